"""The beat of the two frequencies, averaged coherently over a window.

``phi_2 - k phi_1`` with ``k = round(f_2 / f_1)`` is the phase of a synthetic frequency
``Delta = f_2 - k f_1`` (20 MHz), which repeats after ``c / 2 Delta``. Its noise is too large for
the wrap of one pixel; averages do better.
"""

from collections.abc import Callable
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
SMOOTHING = (
    0.02  # variance of a guide below which a window is averaged rather than fitted
)


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
    """Beat phasor ``|p_1| |p_2| exp(i (phi_2 - k phi_1))`` (H, W), counts^2; 0 where unknown."""
    size, angle = beat_polar(measurement)
    return size * np.exp(1j * angle)  # pyright: ignore[reportReturnType]


def beat(measurement: Measurement, *, window: int = WINDOW) -> Estimate:
    """Depth of the beat averaged over a square of side ``window``, px, borders reflected."""
    if window not in range(1, 10_000, 2):
        raise ValueError(
            f"Expected an odd window of 1 to 9999 px, got {window}. Try {WINDOW}."
        )
    phasor = beat_phasor(measurement)
    return _estimate_from_mean(
        uniform_filter(phasor, window), np.abs(phasor), window, measurement
    )


def beat_guided(measurement: Measurement) -> Estimate:
    r"""Depth of the beat after a guided filter, which stops at edges.

    .. math:: a = (\Sigma_w + \epsilon 1)^{-1}\,\mathrm{cov}_w(g, e^{i\theta}),\quad
              b = \bar e - a \cdot \bar g,\quad q = \overline{a}\cdot g + \overline{b}

    with the `guides` g and all means weighted by ``|p_1| |p_2|``, the inverse variance of the phase
    theta of the beat. The confidence is that of a plain average over as many pixels.
    """
    phasor = beat_phasor(measurement)
    size = np.abs(phasor)
    weight = size / (size.mean() or 1.0) + 1e-6
    filtered = guided_filter(
        quotient(phasor, size), guides(measurement), weight, WINDOW, SMOOTHING
    )
    return _estimate_from_mean(
        filtered * uniform_filter(size, WINDOW), size, WINDOW, measurement
    )


def guides(measurement: Measurement) -> Array:
    """Guide images (6, H, W): log amplitude, coherence, cosine and sine of both slopes.

    The wrapped phase cannot guide, its slope can: along an axis, the angle of ``sum p(x+1) conj
    p(x)`` over 11 x 11 px, p the phasor of the lowest frequency. The sum's length over that of
    lengths, the coherence, sinks at edges.
    """
    amplitude = np.nan_to_num(measurement.amplitude)
    phasor = amplitude[0] * np.exp(1j * measurement.phase[0])
    coherence = np.ones(phasor.shape)
    slopes = []
    for axis in (0, 1):
        pairs = steps(phasor, axis)
        total = uniform_filter(pairs, 11)
        length = uniform_filter(np.abs(pairs), 11)
        coherence *= quotient(np.abs(total), length)
        slope = quotient(total, np.abs(total))
        slopes += [slope.real, slope.imag]  # pyright: ignore[reportAttributeAccessIssue]
    bright = uniform_filter(amplitude.sum(axis=0), 5)
    # a tenth of the mean keeps the logarithm of noise in the dark from guiding anything
    bright = np.log(0.1 + np.maximum(bright, 0) / (bright.mean() or 1.0))
    return np.stack([bright, coherence, *slopes])


def steps(phasor: Complex, axis: int) -> Complex:
    """Phasor (H, W) of the next pixel along an axis times the pixel's conjugate; 0 at the end."""
    ahead = np.roll(phasor, -1, axis) * np.conj(phasor)
    np.moveaxis(ahead, axis, 0)[-1] = 0
    return ahead


def guided_filter(
    values: Complex, guide: Array, weight: Array, window: int, smoothing: float
) -> Complex:
    """Complex values (H, W) after a guided filter with guides (G, H, W) and weights > 0 (H, W)."""
    total = uniform_filter(weight, window)

    def mean(image: NDArray) -> NDArray:
        return uniform_filter(weight * image, window) / total

    mean_guide = np.stack([mean(one) for one in guide])
    mean_value = mean(values)
    with_values = [
        mean(one * values) - m * mean_value
        for one, m in zip(guide, mean_guide, strict=True)
    ]
    # real and imaginary parts are right sides of their own
    parts = np.stack(with_values, axis=-1)[..., None].view(float)
    fit = np.linalg.solve(_covariances(mean, guide, mean_guide, smoothing), parts)
    slope = np.moveaxis(fit.view(complex)[..., 0], -1, 0)
    flat = mean(mean_value - (slope * mean_guide).sum(axis=0))
    return flat + sum(map(np.multiply, map(mean, slope), guide))


def _covariances(
    mean: Callable[[Array], Array], guide: Array, middle: Array, smoothing: float
) -> Array:
    """Covariance matrices (H, W, G, G) of the guides in each window, plus ``smoothing`` times 1."""
    count, *shape = guide.shape
    spread = smoothing * np.broadcast_to(np.eye(count), (*shape, count, count))
    for i, j in zip(*np.tril_indices(count), strict=True):
        spread[..., i, j] += mean(guide[i] * guide[j]) - middle[i] * middle[j]
        spread[..., j, i] = spread[..., i, j]
    return spread


def beat_depth(phase: Array, measurement: Measurement) -> Array:
    """Depth in range, m, of a beat phase, rad; the nearest end of the range if it lies outside."""
    synthetic = synthetic_frequency(*measurement.frequencies)
    middle = sum(measurement.range) / 2
    turns = centred(phase - phase_from_depth(middle, synthetic.frequency)) / TAU
    return within_range(middle + turns * wrap_length(synthetic.frequency), measurement)


def _estimate_from_mean(
    mean: NDArray, size: Array, window: int, measurement: Measurement
) -> Estimate:
    """Estimate from an averaged beat phasor; its confidence allows for noise and sloping depth."""
    tones = measurement.frequencies
    spread = noise_of_mean(mean, uniform_filter(size**2, window), window**2)
    depth = beat_depth(np.angle(mean), measurement)
    wraps = depth / wrap_length(tones[0])
    variance = np.maximum(
        uniform_filter(wraps**2, window) - uniform_filter(wraps, window) ** 2, 0
    )
    noise = np.hypot(wrap_noise(0, spread, frequencies=tones), BIAS * np.sqrt(variance))
    return Estimate(depth, rounding_odds(noise))


def noise_of_mean(mean: NDArray, power: Array, count: Array | int) -> Array:
    """Standard deviation, rad, of the phase of a mean phasor; infinite of fewer than two.

    ``mean`` and ``power`` are the means of ``count`` phasors and of their squared magnitudes.
    """
    length = np.abs(mean)
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
