"""The test set that travels with the package."""

import numpy as np

from cmtof.frame import held_out_frames


def test_the_test_set_is_whole_and_of_the_test_partition():
    frames = held_out_frames()
    assert len({frame.name for frame in frames}) == 32
    assert all(frame.name.split("/")[0].endswith("9") for frame in frames)
    assert all(np.isfinite(frame.depth).mean() > 0.8 for frame in frames)
