"""Desks and workbenches."""

import pytest
from furnishing import assert_made_well

from cmtof.scenes.rooms.worktables import CATALOGUE

LIMITS = {
    "desk": ((1.05, 1.75), (0.5, 0.9), (0.7, 0.78)),
    "workbench": ((1.15, 1.95), (0.6, 1.0), (0.8, 0.95)),
}
"""Least and greatest width, depth and height, m."""


def test_every_piece_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    assert_made_well(name, CATALOGUE[name], LIMITS[name], check_thing)
