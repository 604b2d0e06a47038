"""Slopes, jumps and sizes of surfaces whose answer is known."""

import numpy as np
from pytest import approx

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import wrap_length
from cmtof.hardness import bends, hardness

WRAP = wrap_length(FREQUENCY_SINGLE)


def test_a_slanted_plane_has_one_slope_no_jump_and_is_one_surface():
    seen = hardness(1 + 0.003 * np.arange(40)[None, :] + np.zeros((30, 1)))
    across = seen.slope[seen.slope > 1e-6]
    assert across == approx(np.full(across.size, 0.003 / WRAP), rel=1e-3)
    assert seen.jump.size == 0
    assert seen.size == approx(np.full(1200, 1200.0))


def test_a_step_is_one_jump_a_row_and_two_surfaces():
    depth = np.where(np.arange(40) < 20, 1.0, 1.5) + np.zeros((20, 1))
    seen = hardness(depth)
    assert seen.jump == approx(np.full(20, 0.5 / WRAP))
    # the two columns beside the step belong to neither surface
    assert np.unique(seen.size).tolist() == [1, 20 * 19]
    assert (seen.size == 1).sum() == 2 * 20


def test_a_crease_and_a_gap_end_a_surface_without_a_jump():
    crease = 2 + 0.003 * np.abs(np.arange(-20, 20)) + np.zeros((10, 1))
    assert bends(crease).sum() == 10
    assert hardness(crease).jump.size == 0
    gap = np.where(np.arange(11) == 5, np.nan, 1.0) + np.zeros((10, 1))
    assert hardness(gap).jump.size == 0
    assert (
        hardness(gap).size.max() == 40
    )  # four columns each: those beside the gap are ends
