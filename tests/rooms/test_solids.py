"""Solids: closed, oriented outwards, of the volumes of the textbook."""

import numpy as np
import pytest

from cmtof_rooms import solids

TURN = np.linspace(0, 2 * np.pi, 200, endpoint=False)
GRID = np.stack([*np.meshgrid([0, 1, 2], [0, 1], indexing="ij"), np.zeros((3, 2))], -1)

CASES = {
    "box": (solids.box((1, 2, 3), (5, 5, 5)), 6.0),
    "extrusion": (solids.extrusion(np.stack([np.cos(TURN), np.sin(TURN)], 1), 2.0), 2 * np.pi),
    "plate": (solids.plate(4.0, 2.5, 0.2, [(1, 2, 0, 2), (2.5, 3.5, 1, 2)]), 0.2 * (10 - 2 - 1)),
    "plate with a hole over its edge": (solids.plate(2.0, 2.0, 0.1, [(-1, 1, -1, 1)]), 0.3),
    "cone": (solids.revolution([(1, 0), (0, 3)], sections=300), np.pi),
    "bowl": (
        solids.revolution([(1, 0), (1, 1), (0.9, 1), (0.9, 0.1)], 300),
        0.271 * np.pi,
    ),
    "bar": (solids.sweep([(0, 0, 0), (1, 0, 0), (3, 0, 0)], 0.1, sections=300), 0.03 * np.pi),
    "taper": (solids.sweep([(0, 0, 0), (0, 0, 1)], [1.0, 0.5], 300), np.pi * 1.75 / 3),
    "ball": (solids.ball(1.0, fineness=5), 4 * np.pi / 3),
    "sheet": (solids.sheet(GRID, 0.01), 0.02),
}


def test_solids_are_closed_and_have_their_volume():
    for name, (solid, volume) in CASES.items():
        assert solid.is_watertight, name
        assert solid.is_winding_consistent, name
        assert solid.volume == pytest.approx(volume, rel=2e-3), name


def test_noise_keeps_a_ball_closed_and_follows_the_seed():
    one, two, other = (
        solids.ball((1, 2, 3), noise=0.3, rng=np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    assert one.is_watertight
    assert np.array_equal(one.vertices, two.vertices)
    assert not np.array_equal(one.vertices, other.vertices)
