"""The beat of the two frequencies, averaged coherently over a window.

``phi_2 - k phi_1`` with ``k = round(f_2 / f_1)`` is the phase of a synthetic frequency
``Delta = f_2 - k f_1`` (20 MHz), which repeats after ``c / 2 Delta``. Its noise is too large for
the wrap of one pixel; averages do better.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from cmtof.bounds import rounding_odds, wrap_noise
from cmtof.correlation import TAU, centred, phase_from_depth, wrap_length
from cmtof.estimate import Estimate, phase_noise, quotient, within_range
from cmtof.measurement import Measurement
from cmtof.types import Array, Arrays, Complex

# Side of the averaging window, px: the best mean of both protocols out of 21 to 161 px on 40 views
# of validation rooms (released 18.0 %, full 10.5 % of delta < 1).
WINDOW = 41
# Error of a window's mean over the deviation of the depths about it, with which the confidence on
# views of rooms exceeds the rate of right wraps by 0.15 at most.
BIAS = 0.5
# Odds that the beat confirms, and the share that was right by `region`, `mrf` and networks on
# views of 27 training and validation rooms, without noise and at 300, 1200 and 2000 counts.
CALIBRATION = ((0, 0.2, 0.5, 0.95, 1), (0.03, 0.14, 0.45, 0.8, 0.96))


class Synthetic(NamedTuple):
    """Beat of two frequencies: multiple k, synthetic frequency |f_2 - k f_1|, Hz, and its sign."""

    multiple: int
    frequency: float
    sign: int


def synthetic_frequency(low: float, high: float) -> Synthetic:
    """Synthetic frequency, Hz: that of the beat of ``high`` with the nearest multiple of ``low``.

    >>> synthetic_frequency(7.15e9, 14.32e9)
    Synthetic(multiple=2, frequency=20000000.0, sign=1)
    """
    multiple = round(high / low)
    difference = high - multiple * low
    if not difference:
        raise ValueError(
            f"Expected frequencies, none a multiple of the other, got {low:g} and {high:g} Hz. "
            "Choose the method crt, or detune one of them."
        )
    return Synthetic(multiple, abs(difference), 1 if difference > 0 else -1)


def beat_polar(measurement: Measurement) -> Arrays:
    """Magnitude ``|p_1| |p_2|``, counts^2, 0 where unknown, and phase, rad, of the beat, (H, W)."""
    synthetic = synthetic_frequency(*measurement.frequencies)
    low, high = measurement.phase
    size = np.nan_to_num(measurement.amplitude[0] * measurement.amplitude[1])
    return size, synthetic.sign * (high - synthetic.multiple * low)


def beat_phasor(measurement: Measurement) -> Complex:
    """Phasor (H, W) of the beat, counts^2, of the magnitude and phase that `beat_polar` gives."""
    size, angle = beat_polar(measurement)
    return size * np.exp(1j * angle)  # pyright: ignore[reportReturnType]


def beat(measurement: Measurement, *, window: int = WINDOW) -> Estimate:
    """Depth of the beat averaged over a square of side ``window``, px, borders reflected.

    The confidence allows for noise and for depth that slopes.
    """
    if window not in range(1, 10_000, 2):
        raise ValueError(
            f"Expected an odd window of 1 to 9999 px, got {window}. Try {WINDOW}."
        )
    phasor = beat_phasor(measurement)
    mean = uniform_filter(phasor, window)
    power = uniform_filter(abs(phasor) ** 2, window)
    # what is reflected counts once
    inside = uniform_filter(np.ones(phasor.shape), window, mode="constant")
    # of the noise 1 + k^2 parts lie across the beat, and two along it
    square = synthetic_frequency(*measurement.frequencies).multiple ** 2
    across = np.sqrt(2 - 4 / (3 + square))
    spread = across * noise_of_mean(mean, power, window**2 * inside)
    depth = beat_depth(np.angle(mean), measurement)
    wraps = depth / wrap_length(measurement.frequencies[0])
    sloping = uniform_filter(wraps**2, window) - uniform_filter(wraps, window) ** 2
    noise = np.hypot(
        wrap_noise(0, spread, frequencies=measurement.frequencies),
        BIAS * np.sqrt(np.maximum(sloping, 0)),
    )
    return Estimate(depth, rounding_odds(noise))


def beat_depth(phase: Array, measurement: Measurement) -> Array:
    """Depth in range, m, of a beat phase, rad; the nearest end of the range if it lies outside."""
    synthetic = synthetic_frequency(*measurement.frequencies)
    middle = sum(measurement.range) / 2
    turns = centred(phase - phase_from_depth(middle, synthetic.frequency)) / TAU
    return within_range(middle + turns * wrap_length(synthetic.frequency), measurement)


def steps(phasor: Complex, axis: int) -> Complex:
    """Phasor (H, W) of the next pixel along an axis times the pixel's conjugate; 0 at the end."""
    ahead = np.roll(phasor, -1, axis) * np.conj(phasor)
    np.moveaxis(ahead, axis, 0)[-1] = 0
    return ahead


def noise_of_mean(mean: NDArray, power: Array, count: Array | int) -> Array:
    """Standard deviation, rad, of the phase of a mean phasor; infinite for fewer than two.

    ``mean`` and ``power`` are the means of ``count`` phasors and of their squared magnitudes.
    """
    length = abs(mean)
    scatter = np.maximum(power - length**2, 0)
    noise = np.sqrt(scatter / (2 * np.maximum(count - 1, 1)))
    return quotient(noise, np.where(count > 1.5, length, 0), np.inf)


def estimate_with_beat(depth: Array, odds: Array, measurement: Measurement) -> Estimate:
    """Estimate of a depth (H, W), m, whose ``odds`` are lowered where the beat contradicts it.

    The beats of the pixel and of the window about it are compared with the depth: where one differs
    by r > 2 standard deviations (half a wrap at least), the odds are multiplied by
    ``exp(2 - r^2 / 2)``. Then they are calibrated by `CALIBRATION`.
    """
    synthetic = synthetic_frequency(*measurement.frequencies)
    size, angle = beat_polar(measurement)
    difference = angle - phase_from_depth(depth, synthetic.frequency)
    difference -= TAU * np.rint(difference / TAU)
    size /= size.max() or 1.0  # its squares are within single precision
    size, difference = np.where(measurement.mask, [size, difference], 0).astype(
        np.float32
    )
    mean = uniform_filter(size * (np.cos(difference) + 1j * np.sin(difference)), WINDOW)
    window_noise = noise_of_mean(mean, uniform_filter(size**2, WINDOW), WINDOW**2)
    low, high = phase_noise(measurement)
    least = np.pi * synthetic.frequency / measurement.frequencies[0]
    noises = [window_noise, np.hypot(synthetic.multiple * low, high)]
    deviations = [np.angle(mean), difference] / np.maximum(noises, least)
    share = np.exp(np.minimum(2 - deviations**2 / 2, 0).sum(axis=0))
    return Estimate(depth, np.interp(odds * share, *CALIBRATION))
