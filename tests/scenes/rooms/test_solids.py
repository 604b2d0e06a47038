"""Solids: closed, oriented outwards, of the volumes of the textbook."""

import numpy as np
import pytest

from cmtof.scenes.rooms.solids import (
    ball,
    box,
    extrusion,
    joined,
    moved,
    plate,
    revolution,
    sheet,
    sweep,
)

TURN = np.linspace(0, 2 * np.pi, 200, endpoint=False)
GRID = np.stack([*np.meshgrid([0, 1, 2], [0, 1], indexing="ij"), np.zeros((3, 2))], -1)

CASES = {
    "box": (box((1, 2, 3), (5, 5, 5)), 6.0),
    "extrusion": (extrusion(np.stack([np.cos(TURN), np.sin(TURN)], 1), 2.0), 2 * np.pi),
    "plate": (plate(4.0, 2.5, 0.2, [(1, 2, 0, 2), (2.5, 3.5, 1, 2)]), 0.2 * (10 - 2 - 1)),
    "plate with a hole over its edge": (plate(2.0, 2.0, 0.1, [(-1, 1, -1, 1)]), 0.3),
    "cone": (revolution([(1, 0), (0, 3)], sections=300), np.pi),
    "bowl": (revolution([(1, 0), (1, 1), (0.9, 1), (0.9, 0.1)], 300), np.pi * (1 - 0.81 * 0.9)),
    "bar": (sweep([(0, 0, 0), (1, 0, 0), (3, 0, 0)], 0.1, sections=300), 0.03 * np.pi),
    "taper": (sweep([(0, 0, 0), (0, 0, 1)], [1.0, 0.5], 300), np.pi * 1.75 / 3),
    "ball": (ball(1.0, fineness=5), 4 * np.pi / 3),
    "sheet": (sheet(GRID, 0.01), 0.02),
}


def test_solids_are_closed_and_have_their_volume():
    for name, (solid, volume) in CASES.items():
        assert solid.is_watertight, name
        assert solid.is_winding_consistent, name
        assert solid.volume == pytest.approx(volume, rel=2e-3), name


def test_noise_keeps_a_ball_closed_and_follows_the_seed():
    one, two, other = (
        ball((1, 2, 3), noise=0.3, rng=np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    assert one.is_watertight
    assert np.array_equal(one.vertices, two.vertices)
    assert not np.array_equal(one.vertices, other.vertices)


def test_solids_are_turned_then_shifted_and_joined_without_loss():
    turned = moved(box((2, 4, 1)), (10, 0, 0), np.pi / 2)
    np.testing.assert_allclose(turned.bounds, [[8, -1, -0.5], [12, 1, 0.5]], atol=1e-12)
    both = joined([turned, box((1, 1, 1))])
    assert both.volume == pytest.approx(9)
    assert len(both.split()) == 2
