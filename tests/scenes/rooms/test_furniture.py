"""The whole catalogue of furniture, and the odd ones in it."""

import pytest
from furnishing import assert_repeatable, assert_within, closed_volumes, draw, sizes

from cmtof.scenes.rooms.furniture import CATALOGUE

LIMITS = {
    "stepladder": ((0.4, 0.85), (0.7, 2.2), (0.6, 1.75)),
    "ironing_board": ((1.1, 1.75), (0.35, 0.5), (0.75, 0.95)),
    "wine_rack": ((0.4, 0.75), (0.2, 0.45), (0.35, 0.9)),
    "fish_tank": ((0.55, 1.15), (0.3, 0.5), (0.95, 1.4)),
    "pinboard": ((0.45, 1.25), (0.01, 0.08), (0.35, 0.85)),
    "pram": ((0.4, 0.7), (0.8, 1.2), (0.9, 1.2)),
}
"""Least and greatest width, depth and height, m."""
ON_THE_WALL = ("pinboard",)


def test_every_piece_has_limits():
    assert set(LIMITS) <= set(CATALOGUE)


@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.parametrize("seed", range(8))
def test_it_stands_and_carries(name, seed, check_thing):
    check_thing(
        draw(CATALOGUE[name], seed),
        standing="wall" if name in ON_THE_WALL else "floor",
        triangles=9000,
    )


@pytest.mark.parametrize("name", LIMITS)
def test_its_sizes_are_those_of_real_ones(name):
    assert_within(sizes(CATALOGUE[name]), LIMITS[name])


@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.parametrize("seed", range(4))
def test_its_faces_look_outwards(name, seed):
    assert all(volume > -1e-9 for volume in closed_volumes(draw(CATALOGUE[name], seed)))


@pytest.mark.parametrize("name", LIMITS)
def test_the_same_seed_makes_the_same_piece(name):
    assert_repeatable(CATALOGUE[name])


def test_every_maker_of_the_catalogue_draws_something_with_a_name():
    assert len(CATALOGUE) >= 60
    for maker in CATALOGUE.values():
        thing = draw(maker, 0)
        assert thing.kind
        assert thing.kind == thing.kind.lower()
