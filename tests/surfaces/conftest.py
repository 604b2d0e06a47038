"""The furnished corner, measured."""

import pytest
from exact_scenes import Scene, corner_scene

from cmtof.measurement import Measurement
from cmtof.simulation import simulate


@pytest.fixture(scope="session")
def corner() -> Scene:
    return corner_scene()


@pytest.fixture(scope="session")
def clean_corner(corner: Scene) -> Measurement:
    return simulate(corner.frame, protocol="full", noise_free=True)
