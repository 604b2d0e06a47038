"""The test set that travels with the package."""

import numpy as np
from numpy.testing import assert_allclose

from cmtof import simulate
from cmtof.frame import HELD_OUT_STEP, held_out_frames


def test_the_test_set_is_whole_exact_in_its_steps_and_of_the_test_partition():
    frames = held_out_frames()
    assert len({frame.name for frame in frames}) == 32
    assert all(frame.name.split("/")[0].endswith("9") for frame in frames)
    for frame in frames:
        steps = frame.depth[np.isfinite(frame.depth)].astype(float) / HELD_OUT_STEP
        assert_allclose(steps, np.round(steps), rtol=0, atol=0.05)  # float32 at 40 m
        levels = 255 * np.sqrt(frame.intensity.astype(float))
        assert_allclose(levels, np.round(levels), rtol=0, atol=1e-3)
        assert steps.size > 0.8 * frame.depth.size


def test_every_test_view_has_a_fifth_to_nine_tenths_of_its_pixels_scored():
    coverage = [simulate(one, noise_free=True).mask.mean() for one in held_out_frames()]
    assert min(coverage) >= 0.2
    assert max(coverage) <= 0.9
    assert 0.4 < np.median(coverage) < 0.65
