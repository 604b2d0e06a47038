"""Solids: closed, oriented outwards, of the volumes of the textbook."""

import numpy as np
from pytest import approx, mark

from cmtof.correlation import TAU
from cmtof_rooms import solids

GRID = np.stack([*np.mgrid[:3, :2], np.zeros((3, 2))], axis=-1)


SOLIDS = {
    "box": (solids.slab(4, 5, 4, 6, 4, 7), 6.0),
    "cylinder": (solids.extrusion(solids.ellipse((2, 2), 200), 2.0), TAU),
    "plate with a door and a window": (
        solids.plate(4.0, 2.5, 0.2, [(1, 2, 0, 2), (2.5, 3.5, 1, 2)]),
        0.2 * (10 - 2 - 1),
    ),
    "plate with a hole over its edge": (
        solids.plate(2.0, 2.0, 0.1, [(-1, 1, -1, 1)]),
        0.3,
    ),
    "cone": (solids.revolution([(1, 0), (0, 3)], sections=300), np.pi),
    "bowl": (
        solids.revolution([(1, 0), (1, 1), (0.9, 1), (0.9, 0.1)], sections=300),
        0.271 * np.pi,
    ),
    "bar": (
        solids.sweep([(0, 0, 0), (1, 0, 0), (3, 0, 0)], 0.1, sections=300),
        0.03 * np.pi,
    ),
    "ball": (solids.ball(1.0, fineness=5), 4 * np.pi / 3),
    "sheet from its other side": (solids.sheet(GRID[::-1], 0.01), 0.02),
}


@mark.parametrize("name", SOLIDS)
def test_a_solid_is_closed_and_has_its_volume(name):
    solid, volume = SOLIDS[name]
    assert solid.is_volume
    assert solid.volume == approx(volume, rel=2e-3)


def test_joined_solids_keep_their_volumes():
    tall = solids.slab(0, 1, 0, 1, 0, 2)
    both = solids.join(
        [solids.slab(0, 1, 0, 1, 0, 1), solids.move(tall, (5, 0, 0), 0.3)]
    )
    assert both.is_volume
    assert both.volume == approx(3.0)


def test_noise_keeps_a_ball_closed_and_follows_the_seed():
    def bumpy(seed):
        return solids.ball((1, 2, 3), noise=0.3, rng=np.random.default_rng(seed))

    one = bumpy(1)
    assert one.is_watertight
    assert np.array_equal(one.vertices, bumpy(1).vertices)
    assert not np.array_equal(one.vertices, bumpy(2).vertices)
