"""The result of an unwrapping method, and quantities of a measurement that methods share."""

from math import ceil, floor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.special import gammaincinv

from cmtof.correlation import centred, residual_noise, wrap_length
from cmtof.measurement import Measurement, unambiguous_range
from cmtof.types import Array, Flags, Numbers

# Half-widths of sets of wraps over the odds against a pixel's own: `cmtof_book.coverage` computes
# them.
SETS = {"within_90": 1.85, "within_95": 7.99}

# Beats show hidden noise if a wrap adds up to so many turns to them, for then depth hardly does.
_SLOW = 0.01
_APART = 2  # px between pixels whose beats are compared: the grain of a scan is finer
_CLEAR = 0.2  # variance, rad^2, of the difference of two beats up to which they are
_FEW = 1000  # number of such differences that is too few to tell
_EXCESS = 0.5  # share of the expected variance up to which more of it may be chance
_MEDIAN = 2 * gammaincinv(0.5, 0.5)  # of chi squared; scipy.stats is slow to load
_LEAST = 0.02  # noise, rad, up to which depth may have done it


class Components(NamedTuple):
    """Groups of pixels that share a wrap offset, and probabilities that it is off by m wraps."""

    label: Numbers  # component of each pixel (H, W), from 1 on, the largest first; 0 for none
    odds: Array  # probability (C, M) of each to lie (1 - M) / 2 to (M - 1) / 2 wraps farther away


class Estimate(NamedTuple):
    """Depth and confidence that an unwrapping method returns."""

    # best depth (H, W), m; it need not agree with the measured phase, nor lie in the range
    depth: Array
    confidence: Array  # probability in [0, 1] that the wrap is right (H, W)
    components: Components | None = None  # of methods that know them


def wraps_in_range(measurement: Measurement) -> tuple[int, int]:
    """First and last wrap of the lowest frequency with a depth in ``min <= z < max``."""
    low, high = np.asarray(measurement.range) / wrap_length(measurement.frequencies[0])
    # limits that are whole wraps but for rounding belong to the wrap that they begin
    return floor(low + 1e-9), ceil(high - 1e-9) - 1


def sets_of_wraps(confidence: Array, measurement: Measurement) -> dict[str, Array]:
    """Half-widths (H, W), wraps, of intervals that hold the true wrap in 90 and 95 % of pixels."""
    first, last = wraps_in_range(measurement)
    odds_against = (1 - confidence) / np.maximum(confidence, 1e-6)
    return {
        name: np.minimum(width * odds_against, last - first)
        for name, width in SETS.items()
    }


def guess_probability(measurement: Measurement) -> Array:
    """Probability (H, W) that a wrap guessed at random within the range is right."""
    first, last = wraps_in_range(measurement)
    return np.full(measurement.shape, 1 / (last - first + 1))


def beat_repeats(measurement: Measurement) -> float:
    """Depth range to choose from, as a multiple of the beat's unambiguous range; at least 1."""
    low, high = measurement.range
    return max(1.0, (high - low) / unambiguous_range(measurement.frequencies))


def within_range(depth: Array, measurement: Measurement) -> Array:
    """Depths, m, clipped into ``min <= z < max``, and a nanometre from both ends at the least.

    The quotient by a wrap may carry an end itself across a boundary of wraps.
    """
    low, high = measurement.range
    return np.clip(depth, low + 1e-9, high - 1e-9)


def quotient(above: NDArray, below: Array, otherwise: float = 0.0) -> NDArray:
    """Quotient of arrays, of the shape of ``below``; ``otherwise`` where that is not positive."""
    found = np.full_like(below, otherwise, above.dtype)
    return np.divide(above, below, out=found, where=below > 0)


def nearest_pixel(wanted: Flags) -> tuple[Numbers, Numbers]:
    """Row and column (H, W) of the nearest wanted pixel; a pixel's own if none is wanted."""
    if not wanted.any():
        return tuple(np.indices(wanted.shape))  # pyright: ignore[reportReturnType]
    return tuple(
        distance_transform_edt(~wanted, return_distances=False, return_indices=True)  # pyright: ignore[reportArgumentType]
    )


def without_holes(measurement: Measurement) -> Measurement:
    """The measurement, unmasked, whose unknown pixels are copies of the nearest known pixel."""
    amplitude = measurement.amplitude.min(axis=0)
    known = np.where(measurement.mask, np.isfinite(amplitude), amplitude > 0)
    if known.all() or not known.any():
        return measurement
    row, column = nearest_pixel(known)
    place = {"y": (("y", "x"), row), "x": (("y", "x"), column)}
    return Measurement(
        measurement.dataset.drop_vars("mask", errors="ignore").isel(place)
    )


def phase_noise(measurement: Measurement) -> Array:
    """Phase noise of both frequencies (2, H, W), rad: root of `seen_noise`^2 + `hidden_noise`^2."""
    seen = seen_noise(measurement)
    return np.hypot(seen, hidden_noise(measurement, seen))


def hidden_noise(measurement: Measurement, seen: Array) -> float:
    """Phase noise, rad, common to all samples of a pixel, as of vibration; 0 if it cannot be told.

    Vibration and drift move all samples alike, so that the residual of the fit does not show them.
    The beats ``phi_2 - m phi_1`` of pixels two apart do, where the frequencies have nearly the
    ratio m, so that depth hardly moves a beat: by their differences beyond the noise that is
    ``seen`` (2, H, W), rad.
    """
    squares, expected = beat_steps(measurement, seen)
    clear = expected < _CLEAR
    if clear.sum() < _FEW:
        return 0.0
    expected = np.median(expected[clear])
    excess = np.median(squares[clear]) / _MEDIAN - expected
    both = 2 * (1 + round(np.divide(*measurement.frequencies[::-1])) ** 2)
    least = max(_EXCESS * expected, both * _LEAST**2)
    return float(np.sqrt(excess / both)) if excess > least else 0.0


def beat_steps(measurement: Measurement, noise: Array) -> tuple[Array, Array]:
    """Squared differences (A, H, W), rad^2, of beats of pixels two apart, and those by noise.

    Along the axes A that are long enough; the latter are the variances that the phase ``noise``
    (2, H, W), rad, lets expect: infinite at masked pixels, and where depth would move a beat.
    """
    low, high = measurement.frequencies
    multiple = round(high / low)
    beat = measurement.phase[1] - multiple * measurement.phase[0]
    valid = measurement.mask & (abs(high / low - multiple) <= _SLOW)
    variance = np.where(valid, noise[1] ** 2 + multiple**2 * noise[0] ** 2, np.inf)
    axes = [axis for axis in (0, 1) if beat.shape[axis] > _APART]
    steps = np.array([beat - np.roll(beat, _APART, axis) for axis in axes])
    expected = np.array([variance + np.roll(variance, _APART, axis) for axis in axes])
    return centred(steps) ** 2, expected


def seen_noise(measurement: Measurement) -> Array:
    """Phase noise (F, H, W), rad, by residuals of cosines fitted to K steps: ``sqrt(2 / K) s / a``.

    The noise s of a sample is that of the fit's residual, a the amplitude. It is infinite without
    signal. Where only phases or three steps were kept, an s is found for which beats two pixels
    apart differ as they do, or else one radian.
    """
    dataset = measurement.dataset
    if "correlation" not in dataset or dataset.sizes["step"] < 4:
        return _noise_of_phases(measurement)
    psi = dataset["psi"].to_numpy()
    sample = np.array([*map(_sample_noise, dataset["correlation"].to_numpy(), psi)])
    linear = np.sqrt(2 / psi.shape[1]) * sample[:, None, None]
    return quotient(linear, measurement.amplitude, np.inf)


def _noise_of_phases(measurement: Measurement) -> Array:
    """Phase noise (F, H, W), rad, that falls with the amplitude, by `beat_steps`; or 1."""
    amplitude = measurement.amplitude
    relative = quotient(np.ones_like(amplitude), amplitude, np.inf)
    if len(amplitude) == 2:
        squares, expected = beat_steps(measurement, relative)
        finite = np.isfinite(expected)
        if finite.sum() > _FEW:
            clear = expected <= np.median(expected[finite])
            power = np.median(squares[clear] / expected[clear]) / _MEDIAN
            return np.maximum(np.sqrt(max(power, 1e-300)) * relative, _LEAST)
    return np.where(amplitude > 0, 1.0, np.inf)


def _sample_noise(images: NDArray, psi: Array) -> float:
    """Noise of one sample, counts, from the pixels whose samples are finite and not all equal."""
    finite = np.ptp(images, axis=0) > 0  # false for NaN; zeros fill what saw nothing
    if not finite.any():
        return 0.0
    return residual_noise(images[:, finite], psi)
