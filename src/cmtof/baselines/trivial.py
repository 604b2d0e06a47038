"""Answers that cost nothing, and the truth itself: marks to measure methods by.

With 21 wraps in range the middle one is right in a twentieth of all cases; who reports a rate
without this one beside it has reported little.
"""

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines import Estimate, within_range, wraps_in_range
from cmtof.correlation import (
    consistent_wrap_count,
    depth_from_wraps,
    wrap_count_from_depth,
    wrap_length,
)
from cmtof.measurement import Measurement


def middle(measurement: Measurement) -> Estimate:
    """Answer the middle of the range for every pixel, whatever was measured."""
    first, last = wraps_in_range(measurement)
    depth = np.full(measurement.shape, sum(measurement.range) / 2)
    return Estimate(depth, np.full(measurement.shape, 1 / (last - first + 1)))


def uniform(measurement: Measurement, *, seed: int = 0) -> Estimate:
    """Guess a depth in range, every one alike; drawn from (seed, frame number)."""
    first, last = wraps_in_range(measurement)
    frame = int(measurement.dataset.attrs.get("frame_number", 0))
    depth = np.random.default_rng([seed, frame]).uniform(*measurement.range, measurement.shape)
    return Estimate(depth, np.full(measurement.shape, 1 / (last - first + 1)))


def mode(measurement: Measurement) -> Estimate:
    """Answer the image's most frequent wrap for every pixel; the truth has to be known.

    The depth is the middle of that wrap; the confidence is the share of pixels that have it.
    """
    frequency = measurement.frequencies[0]
    known = _truth(measurement)[measurement.mask & np.isfinite(_truth(measurement))]
    if not known.size:
        return middle(measurement)
    wraps, counts = np.unique(wrap_count_from_depth(known, frequency), return_counts=True)
    most = counts.argmax()
    depth = np.full(measurement.shape, (wraps[most] + 0.5) * wrap_length(frequency))
    return Estimate(
        within_range(depth, measurement),
        np.full(measurement.shape, counts[most] / counts.sum()),
    )


def true_depth(measurement: Measurement) -> Estimate:
    """Answer the measured phase with the wraps that bring it nearest to the true depth.

    All of them are right by the count that turns the phase into depth, and no method that reads
    depths off single phases does better by the paper's: noise carries phases across the boundary
    of a wrap.
    """
    frequency, phase = measurement.frequencies[0], measurement.phase[0].astype(float)
    truth = _truth(measurement)
    known = np.isfinite(truth)
    wraps = consistent_wrap_count(np.where(known, truth, 0), phase, frequency)
    depth = np.where(known, depth_from_wraps(phase, wraps, frequency), sum(measurement.range) / 2)
    return Estimate(within_range(depth, measurement), known.astype(float))


def _truth(measurement: Measurement) -> NDArray[np.floating]:
    assert measurement.depth is not None  # `Method` has made sure
    return measurement.depth.astype(float)
