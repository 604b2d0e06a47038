"""Cupboards, chests, shelves: sizes, shelves with room above them."""

import numpy as np
import pytest
from furnishing import assert_made_well, draw, sizes

from cmtof.scenes.rooms.storage import CATALOGUE, bookshelf

LIMITS = {
    "bookshelf": ((0.55, 1.45), (0.2, 0.45), (1.0, 2.35)),
    "cupboard": ((0.65, 1.3), (0.33, 0.6), (1.15, 1.95)),
    "wardrobe": ((0.8, 2.25), (0.5, 0.75), (1.8, 2.4)),
    "chest_of_drawers": ((0.5, 1.3), (0.36, 0.7), (0.55, 1.35)),
    "sideboard": ((1.15, 2.1), (0.35, 0.58), (0.65, 0.95)),
    "tv_stand": ((1.05, 2.0), (0.33, 0.55), (0.35, 0.6)),
    "display_cabinet": ((0.7, 1.3), (0.33, 0.55), (1.55, 2.15)),
    "shoe_rack": ((0.55, 1.05), (0.25, 0.36), (0.4, 1.0)),
    "filing_cabinet": ((0.38, 0.5), (0.55, 0.75), (0.6, 1.4)),
    "metal_rack": ((0.7, 1.35), (0.32, 0.55), (1.45, 2.05)),
    "toy_chest": ((0.55, 1.05), (0.36, 0.62), (0.38, 0.8)),
}
"""Least and greatest width, depth and height, m."""


def test_every_piece_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    assert_made_well(name, CATALOGUE[name], LIMITS[name], check_thing)


def test_a_bookshelf_is_as_wide_and_high_as_asked():
    measured = sizes(bookshelf, 30, width=1.0, height=1.8)
    assert np.abs(measured[:, 0] - 1.0).max() < 0.25  # cubes come in whole numbers
    assert np.abs(measured[:, 2] - 1.8).max() < 0.25
    assert np.isclose(measured[:, 0], 1.0, atol=0.02).sum() > 10


def test_shelves_leave_room_below_the_next():
    for seed in range(20):
        levels = sorted((s.z, s.clearance, s.x0) for s in draw(bookshelf, seed).supports)
        for z, clearance, x0 in levels:
            above = [s.z for s in draw(bookshelf, seed).supports if s.z > z + 0.05 and s.x0 == x0]
            if above:
                assert 0.08 < clearance < min(above) - z + 1e-6


def test_bookshelves_have_several_shelves():
    assert min(len(draw(bookshelf, seed).supports) for seed in range(20)) >= 3
