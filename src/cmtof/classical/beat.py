"""The beat of the two frequencies, averaged coherently over a window.

``phi_2 - k phi_1`` with ``k = round(f_2 / f_1)`` is the phase of a synthetic frequency
``Delta = f_2 - k f_1`` (20 MHz), which repeats after ``c / 2 Delta``. Its noise is too large for
the wrap of one pixel; averages do better.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from cmtof.bounds import rounding_odds, wrap_noise
from cmtof.correlation import TAU, centred, phase_from_depth, wrap_length
from cmtof.estimate import Estimate, phase_noise, within_range
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
    """The synthetic frequency of a pair: ``multiple`` k, |f_2 - k f_1| in Hz, and its sign."""

    multiple: int
    frequency: float
    sign: int


def synthetic_frequency(low: float, high: float) -> Synthetic:
    """Beat of the higher frequency with the nearest multiple of the lower one.

    >>> synthetic_frequency(7.15e9, 14.32e9)
    Synthetic(multiple=2, frequency=20000000.0, sign=1)
    """
    multiple = round(high / low)
    difference = high - multiple * low
    if not difference:
        raise ValueError(
            f"Expected frequencies that are no multiples, got {low:g} and {high:g} Hz. "
            "Choose the method crt, or detune one of them."
        )
    return Synthetic(multiple, abs(difference), 1 if difference > 0 else -1)


def beat_polar(measurement: Measurement) -> Arrays:
    """Size ``|p_1| |p_2|``, counts^2, zero where unknown, and angle of the beat, rad, (H, W)."""
    synthetic = synthetic_frequency(*measurement.frequencies[:2])
    low, high = measurement.phase[:2]
    size = np.nan_to_num(measurement.amplitude[0] * measurement.amplitude[1])
    return size, synthetic.sign * (high - synthetic.multiple * low)


def beat_phasor(measurement: Measurement) -> Complex:
    """Phasor ``|p_1| |p_2| exp(i (phi_2 - k phi_1))`` (H, W), counts^2; zero where unknown."""
    size, angle = beat_polar(measurement)
    return size * np.exp(1j * angle)


def beat(measurement: Measurement, *, window: int = WINDOW) -> Estimate:
    """Depth of the beat averaged over a square of side ``window``, px, borders reflected."""
    if window not in range(1, 10_000, 2):
        raise ValueError(
            f"Expected an odd window of 1 to 9999 px, got {window}. Try {WINDOW}."
        )
    phasor = beat_phasor(measurement)
    return _averaged(
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
    unit = quotient(phasor, size)
    filtered = guided_filter(unit, guides(measurement), weight, WINDOW, SMOOTHING)
    return _averaged(filtered * uniform_filter(size, WINDOW), size, WINDOW, measurement)


def guides(measurement: Measurement) -> Array:
    """Guides (6, H, W): log amplitude, coherence, and the cosine and sine of both slopes.

    The wrapped phase cannot guide, its slope can: along an axis, the angle of ``sum p(x+1) conj
    p(x)`` over 11 x 11 px, p the phasor of the lowest frequency. The sum's length over that of
    lengths, the coherence, sinks at edges.
    """
    amplitude = np.nan_to_num(measurement.amplitude[:2])
    phasor = amplitude[0] * np.exp(1j * measurement.phase[0])
    coherence = np.ones(phasor.shape)
    slopes = []
    for axis in (0, 1):
        pairs = steps(phasor, axis)
        total = uniform_filter(pairs, 11)
        length = uniform_filter(np.abs(pairs), 11)
        coherence *= quotient(np.abs(total), length)
        slope = quotient(total, np.abs(total))
        slopes += [slope.real, slope.imag]
    bright = uniform_filter(amplitude.sum(axis=0), 5)
    # a tenth of the mean keeps the logarithm of noise in the dark from guiding anything
    bright = np.log(0.1 + np.maximum(bright, 0) / (bright.mean() or 1.0))
    return np.stack([bright, coherence, *slopes])


def quotient(above: NDArray[Any], below: Array) -> NDArray[Any]:
    """Quotient of images; zero where the lower one is."""
    return np.divide(above, below, out=np.zeros_like(above), where=below > 0)


def steps(phasor: Complex, axis: int) -> Complex:
    """Each pixel's neighbour ahead times its own conjugate (H, W); zero at the end of an axis."""
    ahead = np.roll(phasor, -1, axis) * np.conj(phasor)
    np.moveaxis(ahead, axis, 0)[-1] = 0
    return ahead


def guided_filter(
    values: Complex, guide: Array, weight: Array, window: int, smoothing: float
) -> Complex:
    """Guided filter of complex values (H, W) by guides (G, H, W), weights > 0 (H, W)."""
    total = uniform_filter(weight, window)

    def mean(image: NDArray[Any]) -> NDArray[Any]:
        return uniform_filter(weight * image, window) / total

    middle = np.stack([mean(one) for one in guide])
    centre = mean(values)
    spread = _covariances(mean, guide, middle, smoothing)
    shared = [
        mean(one * values) - m * centre for one, m in zip(guide, middle, strict=True)
    ]
    slope = _solved(spread, np.stack(shared, axis=-1))
    flat = mean(centre - (slope * middle).sum(axis=0))
    return flat + sum(map(np.multiply, map(mean, slope), guide))


def _covariances(
    mean: Callable[[Array], Array], guide: Array, middle: Array, smoothing: float
) -> Array:
    """Covariances (H, W, G, G) of guides about their means, and a variance beside them."""
    count, *shape = guide.shape
    spread = smoothing * np.broadcast_to(np.eye(count), (*shape, count, count))
    for i, j in zip(*np.tril_indices(count), strict=True):
        spread[..., i, j] += mean(guide[i] * guide[j]) - middle[i] * middle[j]
        spread[..., j, i] = spread[..., i, j]
    return spread


def _solved(matrix: Array, right: Complex) -> Complex:
    """Solutions (G, H, W) of real systems (H, W, G, G) with complex right sides (H, W, G)."""
    both = np.stack([right.real, right.imag], axis=-1)
    fit = np.linalg.solve(matrix, both)
    return np.moveaxis(fit[..., 0] + 1j * fit[..., 1], -1, 0)


def beat_depth(phase: Array, measurement: Measurement) -> Array:
    """Depth in range, m, of a beat phase, rad; the nearest end of the range if it lies outside."""
    synthetic = synthetic_frequency(*measurement.frequencies[:2])
    middle = sum(measurement.range) / 2
    turns = centred(phase - phase_from_depth(middle, synthetic.frequency)) / TAU
    return within_range(middle + turns * wrap_length(synthetic.frequency), measurement)


def _averaged(
    mean: Complex, size: Array, window: int, measurement: Measurement
) -> Estimate:
    """Estimate of an averaged beat, and the odds that noise and window leave its wrap right."""
    low, high = measurement.frequencies[:2]
    spread = noise_of_mean(mean, uniform_filter(size**2, window), window**2)
    depth = beat_depth(np.angle(mean), measurement)
    wraps = depth / wrap_length(low)
    varied = np.maximum(
        uniform_filter(wraps**2, window) - uniform_filter(wraps, window) ** 2, 0
    )
    noise = np.hypot(
        wrap_noise(0, spread, frequencies=(low, high)), BIAS * np.sqrt(varied)
    )
    return Estimate(depth, rounding_odds(noise))


def noise_of_mean(mean: Complex, power: Array, count: Array | int) -> Array:
    """Noise, rad, of the angle of a mean of ``count`` phasors; infinite of one or of none."""
    length = np.abs(mean)
    scatter = np.maximum(power - length**2, 0)
    known = (count > 1.5) & (length > 0)
    noise = np.sqrt(scatter / (2 * np.maximum(count - 1, 1))) / np.where(
        known, length, 1
    )
    return np.where(known, noise, np.inf)


def confirmed(depth: Array, odds: Array, measurement: Measurement) -> Estimate:
    """Estimate with odds (H, W) of its wraps as far as the beat confirms the depth, calibrated.

    The beat of the pixel and that of the window about it have a say: where the angle that the depth
    leaves of one is r > 2 standard deviations, of half a wrap at least, it takes
    ``exp(2 - r^2 / 2)`` of the odds.
    """
    synthetic = synthetic_frequency(*measurement.frequencies[:2])
    size, angle = beat_polar(measurement)
    left = angle - phase_from_depth(depth, synthetic.frequency)
    left -= TAU * np.rint(left / TAU)
    size /= size.max() or 1.0  # its squares are within single precision
    size, left = np.where(measurement.mask, [size, left], 0).astype(np.float32)
    mean = uniform_filter(size * (np.cos(left) + 1j * np.sin(left)), WINDOW)
    around = noise_of_mean(mean, uniform_filter(size**2, WINDOW), WINDOW**2)
    low, high = phase_noise(measurement)
    least = np.pi * synthetic.frequency / measurement.frequencies[0]
    noises = [around, np.hypot(synthetic.multiple * low, high)]
    off = [np.angle(mean), left] / np.maximum(noises, least)
    share = np.exp(np.minimum(2 - off**2 / 2, 0).sum(axis=0))
    return Estimate(depth, np.interp(odds * share, *CALIBRATION))
