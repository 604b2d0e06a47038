"""Tables: heights that people sit and stand at, tops that carry."""

import numpy as np
import pytest
from furnishing import assert_made_well, draw

from cmtof.scenes.rooms.tables import CATALOGUE, dining_table, top_support

LIMITS = {
    "dining_table": ((0.9, 2.9), (0.7, 1.7), (0.7, 0.8)),
    "coffee_table": ((0.6, 1.35), (0.45, 1.0), (0.35, 0.5)),
    "side_table": ((0.3, 0.6), (0.3, 0.6), (0.44, 0.67)),
    "console_table": ((0.75, 1.45), (0.27, 0.45), (0.74, 0.92)),
    "nightstand": ((0.34, 0.6), (0.3, 0.5), (0.43, 0.68)),
}
"""Least and greatest width, depth and height, m."""


def test_every_piece_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    assert_made_well(name, CATALOGUE[name], LIMITS[name], check_thing)


@pytest.mark.parametrize("length", [0.9, 1.4, 2.4])
def test_a_dining_table_is_as_long_as_asked(length):
    for seed in range(12):
        table = draw(dining_table, seed, length=length)
        top = table.parts[0].mesh.vertices
        assert np.ptp(top[:, 0]) == pytest.approx(length, abs=1e-5)


def test_the_rectangle_on_a_round_top_stays_on_it():
    support = top_support(1.0, 1.0, 0.75, "round")
    assert np.hypot(support.x1, support.y1) < 0.5


def test_tables_differ_in_design():
    assert len({len(draw(dining_table, seed).parts) for seed in range(30)}) >= 2
    faces = {sum(len(p.mesh.faces) for p in draw(dining_table, seed).parts) for seed in range(40)}
    assert len(faces) >= 8
