"""Beds: lengths for people, covers that hang but do not drag."""

import numpy as np
import pytest
from furnishing import assert_made_well, draw, sizes

from cmtof.scenes.rooms.beds import CATALOGUE, bed

LIMITS = {
    "bed": ((0.9, 2.6), (1.9, 2.5), (0.6, 1.5)),
    "bunk_bed": ((0.9, 1.2), (1.95, 2.3), (1.4, 1.95)),
    "crib": ((0.6, 0.75), (1.2, 1.35), (0.8, 1.1)),
    "daybed": ((1.8, 2.3), (0.75, 1.05), (0.6, 0.95)),
}
"""Least and greatest width, depth and height, m."""


def test_every_piece_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    assert_made_well(name, CATALOGUE[name], LIMITS[name], check_thing, budget=8000)


@pytest.mark.parametrize("width", [0.9, 1.4, 1.8])
def test_a_bed_is_as_wide_as_asked(width):
    measured = sizes(bed, 12, width=width)[:, 0]
    assert (measured >= width).all()
    assert (measured < width + 0.5).all()


def test_the_duvet_hangs_over_the_sides_but_not_to_the_floor():
    for seed in range(12):
        piece = draw(bed, seed, width=1.4)
        cloths = [p.mesh.vertices for p in piece.parts if np.ptp(p.mesh.vertices[:, 0]) > 1.4]
        low = min(v[:, 2].min() for v in cloths if len(v) > 600)
        assert low > -1e-3


def test_a_bed_is_lain_on_below_a_metre():
    heights = [draw(bed, seed).supports[0].z for seed in range(20)]
    assert min(heights) > 0.35
    assert max(heights) < 0.75


def test_a_bunk_bed_has_two_berths_with_room_between():
    low, high = sorted(s.z for s in draw(CATALOGUE["bunk_bed"], 1).supports)
    assert high - low > 0.6
