"""Slopes, jumps and sizes of surfaces whose answer is known."""

import numpy as np
from pytest import approx
from walls import WRAP

from cmtof.hardness import bends, hardness


def test_a_step_in_a_slanted_plane_is_one_jump_a_row_and_two_surfaces():
    x = np.arange(40)
    plane = 1 + 0.003 * x + np.zeros((20, 1))
    seen = hardness(plane + 0.5 * (x >= 20))
    assert seen.jump == approx(np.full(20, 0.503 / WRAP))
    across = seen.slope[seen.slope > 1e-6]
    assert across == approx(np.full(20 * 38, 0.003 / WRAP))
    # the two columns beside the step belong to neither surface
    assert sorted(seen.size) == 2 * 20 * [1] + 2 * 20 * 19 * [20 * 19]


def test_a_crease_and_a_gap_end_a_surface_without_a_jump():
    crease = 2 + 0.003 * abs(np.arange(-20, 20)) + np.zeros((10, 1))
    assert bends(crease).sum() == 10
    assert hardness(crease).jump.size == 0
    gap = np.ones((10, 11))
    gap[:, 5] = np.nan
    seen = hardness(gap)
    assert seen.jump.size == 0
    # four columns each: those beside the gap are ends
    assert seen.size.max() == 40
