"""Kitchens: worktops at working height, free of the sink and the hob."""

from itertools import pairwise

import numpy as np
import pytest
from furnishing import assert_made_well, draw, drop, sizes

from cmtof.scenes.rooms.kitchen import CATALOGUE, kitchen_run, wall_units

LIMITS = {
    "kitchen_run": ((1.7, 3.8), (0.55, 0.7), (0.9, 1.35)),
    "wall_units": ((1.1, 2.8), (0.28, 0.48), (0.5, 0.9)),
    "fridge": ((0.5, 1.0), (0.55, 0.85), (0.8, 2.05)),
    "kitchen_island": ((1.15, 2.1), (0.7, 1.1), (0.85, 0.96)),
    "range_hood": ((0.5, 1.0), (0.25, 0.85), (0.1, 1.2)),
    "high_chair": ((0.4, 0.6), (0.5, 0.75), (0.75, 1.0)),
}
"""Least and greatest width, depth and height, m."""
ON_THE_WALL = ("wall_units", "range_hood")


def test_every_piece_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    standing = "wall" if name in ON_THE_WALL else "floor"
    assert_made_well(
        name, CATALOGUE[name], LIMITS[name], check_thing, budget=12000, standing=standing
    )


@pytest.mark.parametrize("maker", [kitchen_run, wall_units])
@pytest.mark.parametrize("length", [0.6, 1.37, 2.4, 3.9])
def test_units_fill_the_length_asked_for(maker, length):
    measured = sizes(maker, 8, length=length)[:, 0]
    assert np.abs(measured - length).max() < 0.04


def test_worktops_are_worked_at():
    levels = [s.z for seed in range(12) for s in draw(kitchen_run, seed).supports if s.z > 0.8]
    assert min(levels) > 0.85
    assert max(levels) < 0.94


def test_free_stretches_of_a_worktop_do_not_overlap():
    for seed in range(20):
        spans = sorted((s.x0, s.x1) for s in draw(kitchen_run, seed).supports)
        assert all(a < b for a, b in spans)
        assert all(left[1] <= right[0] for left, right in pairwise(spans))


def test_a_long_run_has_something_that_cooks_and_a_tap():
    materials = [p.material for p in draw(kitchen_run, 2, length=3.0).parts]
    assert any(m.specular > 0.8 for m in materials)
    assert len(materials) >= 8


def test_a_sink_is_hollow():
    for seed in range(8):
        run = draw(kitchen_run, seed)
        top = max(support.z for support in run.supports)
        half = run.bounds[1, 0] - 0.05
        heights = drop(run, np.linspace(-half, half, 300), -0.02)
        assert ((heights < top - 0.13) & (heights > top - 0.22)).mean() > 0.08
