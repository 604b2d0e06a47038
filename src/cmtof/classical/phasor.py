"""Depth from the phases of two close frequencies (Gupta et al. 2015), pixel by pixel.

Light that took detours vanishes at high frequencies, so both are high, and their beat is low. The
look-up finds the depth in range whose phasors match the measured ones best, weighted by amplitudes:

    F(z) = a_1 cos(phi_1(z) - phi_1) + a_2 cos(phi_2(z) - phi_2)

F has one peak for each wrap, the higher the less it misses the beat. So two stages replace a table
of tens of thousands of entries: the beat selects a few wraps, both phases give the depth of each.
"""

import numpy as np

from cmtof.bounds import wrap_probability
from cmtof.classical.beat import beat_depth
from cmtof.correlation import TAU, depth_from_phase, phase_from_depth, wrap_length
from cmtof.estimate import (
    Estimate,
    guess_probability,
    phase_noise,
    quotient,
    within_range,
    wraps_in_range,
)
from cmtof.measurement import Measurement
from cmtof.types import Array


def phasor(measurement: Measurement) -> Estimate:
    """Depth in range whose pair of phasors is the nearest to the measured pair.

    The confidence is the odds that noise leaves the beat within half a wrap, no less than those of
    a guess. ValueError if the beat repeats within the range.
    """
    tones = measurement.frequencies
    low, high = tones
    extent = np.ptp(measurement.range)
    covered = wrap_length(high - low)
    if round(high / low) != 1 or covered < extent * (1 - 1e-9):
        raise ValueError(
            f"Expected two close frequencies whose beat covers the range of {extent:.3f} m, got "
            f"{low:g} and {high:g} Hz, which cover {covered:.3f} m. Measure others, for instance "
            "simulate with --frequencies 7.15e9,7.16e9, or choose the method crt."
        )
    noise = phase_noise(measurement)
    known = np.isfinite(noise).all(axis=0)
    phase = np.where(known, measurement.phase, 0)
    amplitude = np.where(known, measurement.amplitude, 0)
    best = np.full(measurement.shape, np.mean(measurement.range))
    # a pixel without signal stays in the middle
    best_value = np.where(known, -np.inf, np.inf)
    for wraps in _candidates(phase, measurement):
        depth = within_range(_peak(phase, amplitude, wraps, tones), measurement)
        value = match(phase, amplitude, depth, tones)
        best = np.where(value > best_value, depth, best)
        best_value = np.maximum(value, best_value)
    noise = np.clip(noise, 1e-9, 1e9)
    return Estimate(
        best,
        np.maximum(
            wrap_probability(*noise, frequencies=tones),
            guess_probability(measurement),
        ),
    )


def _candidates(phase: Array, measurement: Measurement) -> list[Array | int]:
    """Wraps to compare: three about that of the beat, and two at each end of the range.

    A peak that the end cuts may be as high as an inner one of less misfit.
    """
    coarse = beat_depth(phase[1] - phase[0], measurement)
    turns = phase_from_depth(coarse, measurement.frequencies[0]) - phase[0]
    middle = np.rint(turns / TAU)
    first, last = wraps_in_range(measurement)
    return [middle, middle - 1, middle + 1, first - 1, first, last - 1, last]


def match(phase: Array, amplitude: Array, depth: Array, frequencies: Array) -> Array:
    """Match F (H, W), counts, of depths (H, W), m, to phases, rad, and amplitudes (2, H, W)."""
    off = phase_from_depth(depth, np.reshape(frequencies, (2, 1, 1))) - phase
    return (amplitude * np.cos(off)).sum(axis=0)


def _peak(
    phase: Array, amplitude: Array, wraps: Array | int, frequencies: Array
) -> Array:
    """Depth (H, W), m, of the peak of F at a wrap, from the phasors' sum and one Newton step."""
    low, high = frequencies
    tones = frequencies[:, None, None]
    depth = depth_from_phase(phase[0] + TAU * np.asarray(wraps), low)
    apart = phase[1] - phase_from_depth(depth, high)
    total = amplitude[0] + amplitude[1] * np.exp(1j * apart)
    depth += depth_from_phase(np.angle(total), low)
    off = phase_from_depth(depth, tones) - phase
    slope = -(amplitude * tones * np.sin(off)).sum(axis=0)
    curvature = (amplitude * tones**2 * np.cos(off)).sum(axis=0)
    step = np.clip(quotient(slope, curvature) * low, -0.1, 0.1)
    return depth + depth_from_phase(step, low)
