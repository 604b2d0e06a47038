"""The whole catalogue of furniture, and the odd ones in it."""

import pytest
from furnishing import assert_made_well, draw

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
def test_it_is_made_well(name, check_thing):
    standing = "wall" if name in ON_THE_WALL else "floor"
    assert_made_well(
        name, CATALOGUE[name], LIMITS[name], check_thing, budget=9000, standing=standing
    )


def test_every_maker_of_the_catalogue_draws_something_with_a_name():
    assert len(CATALOGUE) >= 60
    for maker in CATALOGUE.values():
        thing = draw(maker, 0)
        assert thing.kind
        assert thing.kind == thing.kind.lower()
