"""The furnished corner and a wide wall, measured."""

from collections.abc import Callable

import pytest
from facet_scenes import Scene, corner_scene, plane_frame

from cmtof.measurement import Measurement
from cmtof.simulation import simulate


@pytest.fixture(scope="session")
def corner() -> Scene:
    return corner_scene()


@pytest.fixture(scope="session")
def clean_corner(corner: Scene) -> Measurement:
    return simulate(corner.frame, protocol="full", noise_free=True)


@pytest.fixture(scope="session")
def bright_wall() -> Callable[[int], Measurement]:
    """A wide slanted wall at full light with the paper's noise, by seed."""
    frame = plane_frame((0.2, -0.1, 1), 2.5)
    return lambda seed: simulate(frame, protocol="full", seed=seed)
