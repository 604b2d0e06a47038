"""Spatial unwrapping of one frequency: relative depth from neighbours alone."""

import numpy as np

from cmtof.baselines import Estimate, within_range
from cmtof.correlation import TAU, depth_from_phase, phase_from_depth
from cmtof.measurement import Measurement


def spatial(measurement: Measurement) -> Estimate:
    """Reliability-sorted unwrapping (Herraez et al. 2002) of the lowest frequency's phase.

    One frequency does not know the absolute wrap: the whole image is moved by whole wraps until
    its median lies nearest to mid-range, and the confidence is that of a guess among the wraps.
    Depth jumps of more than half a wrap are lost.
    """
    frequency = measurement.frequencies[0]
    relative = unwrapped_phase(measurement)
    middle = phase_from_depth(sum(measurement.range) / 2, frequency)
    offset = TAU * np.rint((middle - np.median(relative[measurement.mask])) / TAU)
    depth = within_range(depth_from_phase(relative + offset, frequency), measurement)
    low, high = measurement.range
    guess = min(1.0, depth_from_phase(TAU, frequency) / (high - low))
    return Estimate(depth, np.full(measurement.shape, guess))


def unwrapped_phase(measurement: Measurement) -> np.ndarray:
    """Phase (H, W) of the lowest frequency without wraps inside the mask, rad, up to 2 pi m."""
    from skimage.restoration import unwrap_phase

    mask = measurement.mask
    if not mask.any():
        raise ValueError("Expected at least one valid pixel, got none. Correct the mask.")
    phase = np.where(mask, measurement.phase[0], 0.0).astype(float)
    image = np.ma.masked_array(phase, mask=~mask)
    return np.asarray(np.ma.filled(unwrap_phase(image, rng=0), 0.0))
