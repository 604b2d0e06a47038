"""The Chinese remainder theorem and its robust forms, pixel by pixel.

``z = n_1 L_1 + r_1 = n_2 L_2 + r_2`` with wraps L_i = c / 2 f_i: two remainders, two integers.
With f_i = k_i g (g the greatest common divisor) and M = L_1 / k_2 = L_2 / k_1, the integers obey
``n_1 k_2 - n_2 k_1 = (r_2 - r_1) / M``. At 7.15 and 14.32 GHz M is 14.6 um: remainders must be
known to M/4 = 3.7 um, 1.1 mrad at 7.15 GHz, which noise exceeds a hundredfold.
"""

from math import gcd

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines import Estimate, within_range, wraps_in_range
from cmtof.baselines.noise import phase_noise
from cmtof.correlation import (
    TAU,
    depth_from_phase,
    depth_from_wraps,
    phase_from_depth,
    wrap_length,
)
from cmtof.kernels import nearest_wrap
from cmtof.measurement import Measurement


def closed_form(measurement: Measurement) -> Estimate:
    """Strict closed form (Wang and Xia 2010): exact below its bound, arbitrary above.

    ``q = round((r_2 - r_1) / M)``, ``n_1 = q k_2^{-1} mod k_1``. It knows no range: depths run
    over the whole ``c / 2g``, 15 m for the prototype.

    Raises
    ------
    ValueError
        If the frequencies have no common divisor that makes the moduli useful.
    """
    low, high = (round(f) for f in measurement.frequencies[:2])
    common = gcd(low, high)
    k1, k2 = low // common, high // common
    if k1 * k2 > 10**12:
        raise ValueError(
            f"Expected frequencies with a large common divisor, got {low} and {high} Hz with "
            f"{common} Hz. Round them to whole MHz."
        )
    first, second = _remainders(measurement)
    unit = wrap_length(low) / k2
    q = np.rint((second - first) / unit).astype(np.int64)
    wraps = (q * pow(k2, -1, k1)) % k1 if k1 > 1 else np.zeros_like(q)
    depth = depth_from_wraps(measurement.phase[0].astype(float), wraps, low)
    return Estimate(depth, _confidence(measurement, (second - first) - q * unit, unit))


def search(measurement: Measurement) -> Estimate:
    """Range-limited search (Xia and Wang 2007): the wrap in range with the smallest remainder."""
    wraps, residual = _search(measurement)
    depth = depth_from_wraps(measurement.phase[0].astype(float), wraps, measurement.frequencies[0])
    return Estimate(depth, _search_confidence(measurement, wraps, residual))


def maximum_likelihood(measurement: Measurement) -> Estimate:
    """Maximum likelihood: the same integers as `search`, the depth fused from both phases.

    For each integer the best depth leaves a misfit that grows with the remainder alone, so the
    likeliest integer is the one of the smallest remainder (Wang et al. 2015); the depth is the
    mean of both, weighted by ``(f_i a_i)^2``, the inverse variances.
    """
    wraps, residual = _search(measurement)
    depth = fused_depth(measurement, wraps, residual)
    return Estimate(depth, _search_confidence(measurement, wraps, residual))


def fused_depth(
    measurement: Measurement, wraps: NDArray[np.integer], residual: NDArray[np.floating]
) -> NDArray[np.floating]:
    """Mean of both phases' depths (H, W), m, each weighted by its inverse variance.

    Parameters
    ----------
    measurement : Measurement
        At two frequencies.
    wraps : ndarray of int, shape (H, W)
        Wraps of the lower one.
    residual : ndarray, shape (H, W)
        What the higher phase exceeds by what these wraps say of it, rad in [-pi, pi].
    """
    low, high = measurement.frequencies[:2]
    phase = np.nan_to_num(measurement.phase[0].astype(float))
    depth = depth_from_wraps(phase, wraps, low)
    amplitude = np.nan_to_num(measurement.amplitude[:2].astype(float), posinf=0)
    weights = (amplitude * np.array([low, high])[:, None, None]) ** 2
    share = weights[1] / np.maximum(weights.sum(axis=0), np.finfo(float).tiny)
    return within_range(depth + share * depth_from_phase(residual, high), measurement)


def _remainders(measurement: Measurement) -> NDArray[np.floating]:
    """Depths within a wrap at both frequencies (2, H, W), m."""
    lengths = wrap_length(measurement.frequencies[:2])[:, None, None]
    return measurement.phase[:2].astype(float) * lengths / TAU


def _search(measurement: Measurement) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    low, high = measurement.frequencies[:2]
    first, last = wraps_in_range(measurement)
    return nearest_wrap(
        measurement.phase[0], measurement.phase[1], ratio=high / low, first=first, last=last
    )


def _search_confidence(
    measurement: Measurement, wraps: NDArray[np.int64], residual: NDArray[np.float64]
) -> NDArray[np.floating]:
    """Posterior of the chosen wrap: its share of the likelihood of all wraps in range.

    The remainders of neighbouring wraps stand ``2 pi frac(f_2 / f_1)`` apart (17.6 mrad for the
    prototype), so close that their sum is an integral of the normal law.
    """
    from scipy.special import ndtr

    low, high = measurement.frequencies[:2]
    first, last = wraps_in_range(measurement)
    noise = phase_noise(measurement)
    # infinite where nothing was measured: there every wrap is as likely
    spread = np.clip(np.hypot(noise[1], high / low * noise[0]), 1e-9, 1e9)
    ratio = high / low
    gap = TAU * max(abs(ratio - round(ratio)), 1e-12)
    density = (last - first + 1) / min((last - first + 1) * gap, TAU)
    size = residual * np.sign(ratio - round(ratio))
    upper = np.minimum(np.pi, (wraps - first + 0.5) * gap + size)
    lower = np.maximum(-np.pi, size - (last - wraps + 0.5) * gap)
    mass = ndtr(upper / spread) - ndtr(lower / spread)
    # beyond the cap the mass has vanished and the chosen wrap stands alone
    lift = np.exp(np.minimum((residual / spread) ** 2 / 2, 600))
    total = density * np.sqrt(TAU) * spread * mass * lift
    return 1 / np.maximum(total, 1.0)


def _confidence(
    measurement: Measurement, remainder: NDArray[np.float64], unit: float
) -> NDArray[np.floating]:
    """Odds that the rounding to whole units was right, given the phases' noise."""
    from scipy.special import ndtr

    noise = phase_noise(measurement)
    depth_noise = [depth_from_phase(noise[i], measurement.frequencies[i]) for i in (0, 1)]
    spread = np.maximum(np.hypot(*depth_noise), 1e-12)
    return ndtr((unit / 2 - remainder) / spread) - ndtr((-unit / 2 - remainder) / spread)


def guarantee(frequencies: tuple[float, float]) -> float:
    """Largest phase error at the lower frequency that the closed form survives, rad.

    A remainder error below M/4 leaves every rounding right (Wang and Xia 2010).

    Examples
    --------
    >>> round(1e3 * guarantee((7.15e9, 14.32e9)), 2)  # mrad
    1.1
    """
    low, high = (round(f) for f in frequencies)
    unit = wrap_length(low) / (high // gcd(low, high))
    return float(phase_from_depth(unit / 4, low))
