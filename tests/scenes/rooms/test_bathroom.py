"""Bathrooms: what holds water is hollow, towels hang, mirrors shine."""

import numpy as np
import pytest
from furnishing import assert_made_well, draw, drop

from cmtof.scenes.rooms.bathroom import CATALOGUE

LIMITS = {
    "bathtub": ((1.45, 1.85), (0.65, 0.9), (0.5, 0.95)),
    "shower_cabin": ((0.75, 1.25), (0.75, 1.1), (1.85, 2.1)),
    "washbasin": ((0.45, 0.95), (0.4, 0.6), (0.8, 1.3)),
    "toilet": ((0.3, 0.95), (0.5, 0.8), (0.7, 1.2)),
    "towel_rail": ((0.4, 0.85), (0.05, 0.25), (0.3, 1.5)),
    "bathroom_cabinet": ((0.4, 0.95), (0.12, 0.25), (0.45, 0.8)),
}
"""Least and greatest width, depth and height, m."""
ON_THE_WALL = ("towel_rail", "bathroom_cabinet")


def test_every_piece_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    standing = "wall" if name in ON_THE_WALL else "floor"
    assert_made_well(name, CATALOGUE[name], LIMITS[name], check_thing, standing=standing)


def test_a_bathtub_is_hollow_down_to_its_floor():
    for seed in range(8):
        tub = draw(CATALOGUE["bathtub"], seed)
        assert 0.08 < drop(tub, 0.3, 0.0)[0] < 0.2
        assert 0.08 < drop(tub, -0.3, 0.0)[0] < 0.2


def test_a_basin_is_lower_inside_than_at_its_rim():
    for seed in range(8):
        basin = draw(CATALOGUE["washbasin"], seed)
        high = max(part.mesh.vertices[:, 2].max() for part in basin.parts[:-1])
        assert drop(basin, 0.0, -0.07)[0] < high - 0.06


def test_a_cabinet_in_the_bathroom_has_a_mirror():
    for seed in range(5):
        materials = [p.material for p in draw(CATALOGUE["bathroom_cabinet"], seed).parts]
        assert max(m.specular for m in materials) > 0.9


def test_towels_hang_below_their_rail():
    for seed in range(8):
        rail = draw(CATALOGUE["towel_rail"], seed)
        towels = [p.mesh.vertices for p in rail.parts[1:]]
        assert towels
        assert all(np.ptp(v[:, 2]) > 0.3 for v in towels)
