"""The test set that travels with the package."""

import numpy as np

from cmtof import simulate
from cmtof.frame import held_out_frames


def test_the_test_set_is_whole_and_of_the_test_partition():
    frames = held_out_frames()
    assert len({frame.name for frame in frames}) == 32
    assert all(frame.name.split("/")[0].endswith("9") for frame in frames)
    assert all(np.isfinite(frame.depth).mean() > 0.8 for frame in frames)


def test_every_test_view_has_a_fifth_to_nine_tenths_of_its_pixels_scored():
    coverage = [simulate(one, noise_free=True).mask.mean() for one in held_out_frames()]
    assert min(coverage) >= 0.2
    assert max(coverage) <= 0.9
    assert 0.4 < np.median(coverage) < 0.65
