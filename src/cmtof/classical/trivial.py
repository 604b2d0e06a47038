"""Estimates that ignore what was measured, as baselines for other methods."""

import numpy as np

from cmtof.correlation import wrap_count_from_depth, wrap_length
from cmtof.estimate import Estimate, guess_probability
from cmtof.measurement import Measurement


def middle(measurement: Measurement) -> Estimate:
    """The middle of the range for every pixel, whatever was measured."""
    depth = np.full(measurement.shape, sum(measurement.range) / 2)
    return Estimate(depth, guess_probability(measurement))


def uniform(measurement: Measurement) -> Estimate:
    """A random depth in range, all equally likely; drawn from the frame's number."""
    number = int(measurement.dataset.attrs.get("frame_number", 0))
    depth = np.random.default_rng([0, number]).uniform(
        *measurement.range, measurement.shape
    )
    return Estimate(depth, guess_probability(measurement))


def mode(measurement: Measurement) -> Estimate:
    """The image's most frequent true wrap for every pixel, with its share as the confidence."""
    from scipy import stats  # slow to load

    frequency = measurement.frequencies[0]
    truth = measurement.depth
    assert truth is not None  # `Method` has made sure
    known = truth[measurement.mask & np.isfinite(truth)].astype(float)
    if not known.size:
        return middle(measurement)
    most = stats.mode(wrap_count_from_depth(known, frequency))
    depth = np.full(measurement.shape, (most.mode + 0.5) * wrap_length(frequency))
    return Estimate(depth, np.full(depth.shape, most.count / known.size))
