"""Trees and tables of Hypersim."""

from pathlib import Path

import pytest
from official_tree import write_tree


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Three scenes of three views, as the data set's description has them."""
    return write_tree(tmp_path / "hypersim")


@pytest.fixture(scope="session")
def official_tables(shared_data: Path) -> Path:
    """Folder of the two official tables; the test is skipped without it."""
    folder = shared_data / "hypersim"
    if not (folder / "metadata_camera_parameters.csv").is_file():
        pytest.skip("no official Hypersim tables on this machine")
    return folder
