import numpy as np
import pytest

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import wrap_length
from cmtof.scenes.frame import Frame
from cmtof.scenes.statistics import bends, cumulative, hardness, pooled

WRAP = float(wrap_length(FREQUENCY_SINGLE))


def step(height, width, low, high):
    depth = np.full((height, width), low)
    depth[:, width // 2 :] = high
    return depth


def frame(depth, value=0.5):
    return Frame(depth, np.full(np.shape(depth), value))


def test_a_slanted_plane_has_one_slope_no_jump_and_is_one_surface():
    depth = 1 + 0.003 * np.arange(40)[None, :] + np.zeros((30, 1))
    seen = hardness(frame(depth))
    across = seen.slope[seen.slope > 1e-6]
    assert across == pytest.approx(np.full(across.size, 0.003 / WRAP), rel=1e-3)
    assert seen.jump.size == 0
    assert seen.patch == pytest.approx(np.full(1200, 1200.0))
    assert seen.invalid == 0


def test_a_step_is_one_jump_a_row_and_two_surfaces():
    seen = hardness(frame(step(20, 40, 1.0, 1.5)))
    assert seen.jump == pytest.approx(np.full(20, 0.5 / WRAP), rel=1e-5)
    # the two columns beside the step belong to neither surface
    assert sorted(np.unique(seen.patch)) == [1, 20 * 19]
    assert (seen.patch == 1).sum() == 2 * 20


def test_a_crease_of_walls_bends_without_a_jump():
    x = np.abs(np.arange(-20, 20))
    depth = 2 + 0.003 * x[None, :] + np.zeros((10, 1))
    assert bends(depth)[:, 20].all()
    assert bends(depth).sum() == 10
    assert hardness(frame(depth)).jump.size == 0


def test_pixels_without_depth_end_a_surface_and_are_counted():
    depth = np.ones((10, 11))
    depth[:, 5] = np.nan
    seen = hardness(frame(depth))
    assert seen.invalid == pytest.approx(1 / 11)
    assert seen.depth.size == 100
    assert seen.patch.max() == 40  # four columns each: those beside the gap are ends


def test_frames_are_pooled_by_pixel():
    one, two = hardness(frame(np.ones((4, 4)), 0.1)), hardness(frame(np.ones((8, 8)), 0.9))
    both = pooled([one, two])
    assert both.brightness.size == 80
    assert np.median(both.brightness) == pytest.approx(0.9)
    with pytest.raises(ValueError, match="Expected at least one frame to measure, got none"):
        pooled([])


def test_the_cumulative_share_is_that_of_numpy_quantiles():
    samples = np.random.default_rng(0).exponential(size=10_001)
    assert cumulative(samples, np.quantile(samples, [0.1, 0.5, 0.9])) == pytest.approx(
        [0.1, 0.5, 0.9], abs=1e-3
    )
