"""Solids: closed, oriented outwards, of the volumes of the textbook."""

import numpy as np
import pytest
from pytest import approx

from cmtof.correlation import TAU
from cmtof_rooms import solids

GRID = np.stack(
    [
        *np.meshgrid([0, 1, 2], [0, 1], indexing="ij"),
        np.zeros((3, 2)),
    ],
    -1,
)
BOWL = [(1, 0), (1, 1), (0.9, 1), (0.9, 0.1)]


@pytest.mark.parametrize(
    ("solid", "volume"),
    [
        pytest.param(solids.box((1, 2, 3), (5, 5, 5)), 6.0, id="box"),
        pytest.param(
            solids.slab(0, 1, 0, 2, [0, 4], [3, 5]),
            8.0,
            id="two boxes",
        ),
        pytest.param(
            solids.extrusion(solids.ellipse(2.0, 2.0, 200), 2.0),
            TAU,
            id="cylinder",
        ),
        pytest.param(
            solids.plate(4.0, 2.5, 0.2, [(1, 2, 0, 2), (2.5, 3.5, 1, 2)]),
            0.2 * (10 - 2 - 1),
            id="plate with a door and a window",
        ),
        pytest.param(
            solids.plate(2.0, 2.0, 0.1, [(-1, 1, -1, 1)]),
            0.3,
            id="plate with a hole over its edge",
        ),
        pytest.param(
            solids.revolution([(1, 0), (0, 3)], sections=300),
            np.pi,
            id="cone",
        ),
        pytest.param(
            solids.revolution(BOWL, sections=300),
            0.271 * np.pi,
            id="bowl",
        ),
        pytest.param(
            solids.sweep([(0, 0, 0), (1, 0, 0), (3, 0, 0)], 0.1, sections=300),
            0.03 * np.pi,
            id="bar",
        ),
        pytest.param(
            solids.sweep([(0, 0, 0), (0, 0, 1)], [1.0, 0.5], sections=300),
            np.pi * 1.75 / 3,
            id="taper",
        ),
        pytest.param(solids.ball(1.0, fineness=5), 4 * np.pi / 3, id="ball"),
        pytest.param(solids.sheet(GRID, 0.01), 0.02, id="sheet"),
        pytest.param(
            solids.sheet(GRID[::-1], 0.01),
            0.02,
            id="sheet from its other side",
        ),
    ],
)
def test_a_solid_is_closed_and_has_its_volume(solid, volume):
    assert solid.is_watertight
    assert solid.is_winding_consistent
    assert solid.volume == approx(volume, rel=2e-3)


def test_joined_solids_keep_their_volumes():
    both = solids.join(
        [
            solids.box((1, 1, 1)),
            solids.move(solids.box((1, 1, 2)), (5, 0, 0), 0.3),
        ]
    )
    assert both.is_watertight
    assert both.volume == approx(3.0)


def test_noise_keeps_a_ball_closed_and_follows_the_seed():
    def bumpy(seed):
        return solids.ball((1, 2, 3), noise=0.3, rng=np.random.default_rng(seed))

    one = bumpy(1)
    assert one.is_watertight
    assert np.array_equal(one.vertices, bumpy(1).vertices)
    assert not np.array_equal(one.vertices, bumpy(2).vertices)
