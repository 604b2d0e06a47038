"""Coats on a stand, clothes on a rail, shelves on a wall, screens."""

import pytest
from furnishing import assert_made_well, draw

from cmtof.scenes.rooms.stands import CATALOGUE, coat_stand

LIMITS = {
    "coat_stand": ((0.4, 1.0), (0.4, 1.0), (1.6, 2.0)),
    "clothes_rail": ((0.75, 1.4), (0.35, 0.65), (1.4, 1.8)),
    "wall_shelf": ((0.4, 1.6), (0.15, 0.28), (0.02, 0.95)),
    "room_divider": ((1.0, 2.1), (0.05, 0.4), (1.5, 1.9)),
}
"""Least and greatest width, depth and height, m."""
ON_THE_WALL = ("wall_shelf",)


def test_every_piece_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    standing = "wall" if name in ON_THE_WALL else "floor"
    assert_made_well(
        name, CATALOGUE[name], LIMITS[name], check_thing, budget=10000, standing=standing
    )


def test_a_coat_stand_carries_one_to_three_coats():
    counts = {len(draw(coat_stand, seed).parts) - 1 for seed in range(30)}
    assert counts == {1, 2, 3}


def test_coats_hang_clear_of_the_floor():
    for seed in range(10):
        coats = draw(coat_stand, seed).parts[1:]
        assert min(part.mesh.vertices[:, 2].min() for part in coats) > 0.1
