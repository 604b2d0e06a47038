"""The Chinese remainder theorem and its robust forms, pixel by pixel.

``z = n_1 L_1 + r_1 = n_2 L_2 + r_2`` with wraps L_i = c / 2 f_i and f_i = k_i g (g the greatest
common divisor) gives ``n_1 k_2 - n_2 k_1 = (r_2 - r_1) / M``, M = L_1 / k_2 = L_2 / k_1. At 7.15
and 14.32 GHz M/4 is 3.7 um: the noise of a remainder is a hundred times larger.
"""

from math import ceil, gcd

import numpy as np
from scipy.special import ndtr

from cmtof.correlation import (
    TAU,
    centred,
    depth_from_phase,
    depth_from_wraps,
    wrap_length,
)
from cmtof.estimate import Estimate, phase_noise, wraps_in_range
from cmtof.measurement import Measurement
from cmtof.types import Array, Numbers

# Least noise of a misfit, rad, that is assumed: the phases are decoded from float32.
_FINEST = 2e-5


def crt(measurement: Measurement) -> Estimate:
    """Range-limited search for the wrap with the smallest remainder, pixel by pixel."""
    wraps, residual = nearest_wrap(measurement)
    return Estimate(
        depth_from_wraps(measurement.phase[0], wraps, measurement.frequencies[0]),
        _posterior(measurement, wraps, residual),
    )


def crt_ml(measurement: Measurement) -> Estimate:
    """Maximum likelihood: wraps of `crt`, the depth fused from both phases."""
    found = nearest_wrap(measurement)
    return Estimate(fused_depth(measurement, *found), _posterior(measurement, *found))


def crt_closed_form(measurement: Measurement) -> Estimate:
    """Chinese remainders in closed form: exact if they err by less than M / 4, else arbitrary.

    ``n_1 = q k_2^{-1} mod k_1``, ``q = round((r_2 - r_1) / M)``: depths run over ``c / 2g``, 15 m.
    Beyond that the confidence is shared among the depths that look alike.
    """
    frequencies = measurement.frequencies
    low, high = map(round, frequencies)
    common = gcd(low, high)
    k1 = low // common
    k2 = high // common
    if k1 * k2 > 10**12:
        raise ValueError(
            "Expected frequencies with a large common divisor, "
            f"got {low} and {high} Hz with {common} Hz. Round them to whole MHz."
        )
    first, second = measurement.phase * wrap_length(frequencies)[:, None, None] / TAU
    unit = wrap_length(low) / k2
    q = np.rint((second - first) / unit).astype(np.int64)
    wraps = q * pow(k2, -1, k1) % k1
    noise = depth_from_phase(phase_noise(measurement), frequencies[:, None, None])
    odds = _rounding_odds(second - first - q * unit, unit, noise)
    alike = np.ptp(wraps_in_range(measurement)) // k1 + 1  # wraps with this remainder
    return Estimate(depth_from_wraps(measurement.phase[0], wraps, low), odds / alike)


def _rounding_odds(misfit: Array, unit: float, noise: Array) -> Array:
    """Probability (H, W) that rounding to a multiple of ``unit``, ``misfit`` away, was right."""
    spread = np.maximum(np.hypot(*noise), 1e-12)
    upper = ndtr((unit / 2 - misfit) / spread)
    lower = ndtr((-unit / 2 - misfit) / spread)
    return upper - lower


def nearest_wrap(measurement: Measurement) -> tuple[Numbers, Array]:
    """Wraps (H, W) in range that best fit the higher frequency's phase, and the misfit, rad.

    From wrap to wrap the remainder moves by the fraction of ``f_2 / f_1``, so that each turn has
    one best wrap: its zero, or the end of the range that lies nearest to it.
    """
    ratio = measurement.frequencies[1] / measurement.frequencies[0]
    first, last = wraps_in_range(measurement)
    phase = measurement.phase / TAU
    step = ratio - round(ratio)
    first_misfit = phase[1] - ratio * phase[0] - step * first  # turns
    first_misfit -= np.rint(first_misfit)
    wraps = np.zeros(first_misfit.shape, np.int64)
    best = np.full(first_misfit.shape, np.inf)
    turns = ceil(abs(step) * (last - first))
    for turn in range(-1, turns + 2):
        zero = (first_misfit + np.sign(step) * turn) / (step or 1.0)
        n = np.clip(np.rint(zero), 0, last - first).astype(np.int64)
        misfit = first_misfit - step * n
        misfit -= np.rint(misfit)
        closer = abs(misfit) < abs(best)
        wraps = np.where(closer, n, wraps)
        best = np.where(closer, misfit, best)
    return wraps + first, TAU * best


def fused_depth(measurement: Measurement, wraps: Numbers, residual: Array) -> Array:
    """Depth (H, W), m: mean of both frequencies' depths, weighted by ``(f_i a_i)^2``.

    ``wraps`` and ``residual``, rad, are those of `nearest_wrap`.
    """
    low, high = measurement.frequencies
    amplitude = np.nan_to_num(measurement.amplitude)
    weights = (amplitude * measurement.frequencies[:, None, None]) ** 2
    share = weights[1] / np.maximum(weights.sum(axis=0), np.finfo(float).tiny)
    depth = depth_from_wraps(measurement.phase[0], wraps, low)
    return depth + share * depth_from_phase(residual, high)


def _misfit_noise(
    measurement: Measurement, residual: Array, ratio: float, gap: float
) -> Array:
    """Standard deviation (H, W), rad, of the misfit, which changes by ``gap`` from wrap to wrap.

    Where only phases were kept it follows from the residuals, if they are clearly smaller than
    those of random phases.
    """
    noise = phase_noise(measurement)
    # infinite where nothing was measured: there every wrap is as likely
    spread = np.hypot(noise[1], ratio * noise[0]).clip(_FINEST, 1e9)
    typical = np.median(abs(residual[measurement.mask]))
    if "correlation" not in measurement.dataset and typical < gap / 8:
        return np.where(spread < 1e9, 1.5 * typical + _FINEST, spread)
    return spread


def _posterior(measurement: Measurement, wraps: Numbers, residual: Array) -> Array:
    """Probability (H, W) of the chosen wrap: its likelihood over the sum of all in range.

    While the beat does not repeat the sum is an integral; else wraps may share their remainder.
    """
    ratio = measurement.frequencies[1] / measurement.frequencies[0]
    first, last = wraps_in_range(measurement)
    step = ratio - round(ratio)
    gap = TAU * max(abs(step), 1e-12)
    spread = _misfit_noise(measurement, residual, ratio, gap)
    if (last - first - 1) * gap > TAU:
        return 1 / sum(  # pyright: ignore[reportReturnType]
            np.exp(
                (residual**2 - centred(residual - TAU * step * (n - wraps)) ** 2)
                / (2 * spread**2)
            )
            for n in range(first, last + 1)
        )
    # below a third of the gap the sum is no integral any more
    spread = spread.clip(gap / 3)
    size = residual * np.sign(step)
    upper = (wraps - first + 0.5) * gap + size
    lower = size - (last - wraps + 0.5) * gap
    mass = sum(
        ndtr((upper + turn) / spread) - ndtr((lower + turn) / spread)
        for turn in (-TAU, 0.0, TAU)  # the misfit is an angle
    )
    # beyond the cap the mass has vanished and the chosen wrap stands alone
    mass *= np.exp(np.minimum((residual / spread) ** 2 / 2, 600))
    return 1 / np.maximum(np.sqrt(TAU) * spread / gap * mass, 1.0)
