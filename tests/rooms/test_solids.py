"""Solids: closed, oriented outwards, of the volumes of the textbook."""

import numpy as np
from pytest import approx, mark

from cmtof_rooms import solids

SOLIDS = {
    "two boxes": (solids.slab(0, 1, 0, 2, [0, 4], [3, 5]), 8.0),
    "plate with a door and a window": (
        solids.plate(4.0, 2.5, 0.2, [(1, 2, 0, 2), (2.5, 3.5, 1, 2)]),
        0.2 * (10 - 2 - 1),
    ),
    "plate with a hole over its edge": (
        solids.plate(2.0, 2.0, 0.1, [(-1, 1, -1, 1)]),
        0.3,
    ),
    "bowl": (
        solids.revolution([(1, 0), (1, 1), (0.9, 1), (0.9, 0.1)], sections=300),
        0.271 * np.pi,
    ),
    "bar": (
        solids.bar([(0, 0, 0), (1, 0, 0), (1, 0, 2)], 0.1),
        0.03 * 2 * np.sqrt(2),  # of an octagon
    ),
    "ball": (solids.ball(1.0, fineness=5), 4 * np.pi / 3),
}


@mark.parametrize("name", SOLIDS)
def test_a_solid_is_closed_and_has_its_volume(name):
    solid, volume = SOLIDS[name]
    assert solid.is_volume
    assert solid.volume == approx(volume, rel=2e-3)


def test_noise_keeps_a_ball_closed_and_follows_the_seed():
    one, same, other = (
        solids.ball((1, 2, 3), noise=0.3, rng=np.random.default_rng(seed))
        for seed in (1, 1, 2)
    )
    assert one.is_watertight
    assert np.array_equal(one.vertices, same.vertices)
    assert not np.array_equal(one.vertices, other.vertices)
