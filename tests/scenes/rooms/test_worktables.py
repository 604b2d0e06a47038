"""Desks and workbenches."""

import pytest
from furnishing import assert_repeatable, assert_within, closed_volumes, draw, sizes

from cmtof.scenes.rooms.worktables import CATALOGUE

LIMITS = {
    "desk": ((1.05, 1.75), (0.5, 0.9), (0.7, 0.78)),
    "workbench": ((1.15, 1.95), (0.6, 1.0), (0.8, 0.95)),
}
"""Least and greatest width, depth and height, m."""


def test_every_piece_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
@pytest.mark.parametrize("seed", range(8))
def test_it_stands_and_carries(name, seed, check_thing):
    check_thing(draw(CATALOGUE[name], seed), triangles=6000)


@pytest.mark.parametrize("name", CATALOGUE)
def test_its_sizes_are_those_of_real_ones(name):
    assert_within(sizes(CATALOGUE[name]), LIMITS[name])


@pytest.mark.parametrize("name", CATALOGUE)
@pytest.mark.parametrize("seed", range(4))
def test_its_faces_look_outwards(name, seed):
    assert all(volume > -1e-9 for volume in closed_volumes(draw(CATALOGUE[name], seed)))


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_same_seed_makes_the_same_piece(name):
    assert_repeatable(CATALOGUE[name])
