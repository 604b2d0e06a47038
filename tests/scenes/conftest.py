"""A tree of Hypersim."""

from pathlib import Path

import pytest
from official_tree import write_tree


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Three scenes of three views, as the data set's description has them."""
    return write_tree(tmp_path / "hypersim")
