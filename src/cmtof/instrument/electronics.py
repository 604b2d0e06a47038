"""Detector, filters and converter: from light to counts, with noise from the data sheets."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.constants import c, e, h
from scipy.linalg import solve_continuous_lyapunov
from scipy.signal import cont2discrete, lfilter

from cmtof.instrument.settings import Detector

Array = NDArray[np.float64]

SLOPE, CENTRE = 3.15805780e-4, 33523.0
"""V per count at +-10 V, count of 0 V: nominal calibration (T-Series Datasheet, 20.0.1)."""
POLES = 3


@dataclass(frozen=True)
class Conversion:
    """What the detector makes of light of a wavelength, m."""

    detector: Detector
    wavelength: float

    @property
    def volts_per_watt(self) -> float:
        """Output of the detector, V/W: responsivity, avalanche gain and transimpedance."""
        responsivity = self.detector.efficiency * e / (h * c / self.wavelength)
        return responsivity * self.detector.gain * self.detector.transimpedance

    def volts(self, power: ArrayLike) -> Array:
        """Output, V, for light, W, up to saturation."""
        return np.minimum(np.asarray(power) * self.volts_per_watt, self.detector.saturation)

    def density(self, volts: ArrayLike) -> Array:
        """One-sided noise density, V^2/Hz, at an output, V: shot noise and amplifier.

        ``2 e I F (M R_T)^2`` for the primary current I, F = M^x (McIntyre 1966), and its own.
        """
        gain, excess = self.detector.gain, self.detector.gain**self.detector.excess_index
        shot = 2 * e * excess * (gain * self.detector.transimpedance)
        return shot * np.asarray(volts, float) + self.detector.noise_density**2


@dataclass(frozen=True, eq=False)
class Chain:
    """Three poles in a row: detector, EF120 and RC, under held light and white noise.

    Between samples ``x' = A x + b (light + noise)`` is carried on exactly, as
    ``x -> transition x + entry light + sqrt(density) root normal``; x are the poles' outputs.
    """

    transition: Array  # (3, 3), lower triangular
    entry: Array  # (3,)
    root: Array  # (3, 3), root of the covariance that unit one-sided density adds in an interval
    settled: Array  # (3, 3), root of the covariance under unit density for ever

    def memory(self, count: int) -> Array:
        """Autocovariance (count,) of the output, V^2, at successive samples for unit density."""
        row, found = np.eye(POLES)[-1], np.empty(count)
        for lag in range(count):  # cov(x_{t+l}, x_t) = e^T T^l P e
            found[lag] = row @ self.settled @ self.settled[-1]
            row = row @ self.transition
        return found

    def run(self, light: Array, density: Array, normals: Array | None) -> Array:
        """Output (N, T), V, at the start of each interval.

        ``light``, V, and ``density``, V^2/Hz, (N, T), are held for an interval each. ``normals``
        (N, T + 1, 3) are standard normals, those of the initial state first; None is silence. The
        first interval finds the filters settled to its own light.
        """
        state = np.repeat(light[:, :1], POLES, axis=1)
        push = light[..., None] * self.entry
        if normals is not None:  # a product a row: one burst or many give the same bits
            spread = np.sqrt(density)[..., None]
            state = state + spread[:, 0] * (normals[:, :1] @ self.settled.T)[:, 0]
            push = push + spread * (normals[:, 1:] @ self.root.T)
        outputs: list[Array] = []
        for i, row in enumerate(self.transition):
            into = push[..., i] + sum(
                one * factor for one, factor in zip(outputs, row, strict=False)
            )
            keep, start = [1.0, -row[i]], state[:, i : i + 1]
            outputs.append(lfilter([0.0, 1.0], keep, into, axis=-1, zi=start)[0])
        return outputs[-1]


@lru_cache(maxsize=64)
def chain(detector: Detector, interval: float) -> Chain:
    """Filters of a detector sampled every ``interval``, s."""
    rates = np.array(
        [2 * np.pi * detector.bandwidth, 2 * np.pi * detector.low_pass, 1 / detector.rc_time]
    )
    matrix, push = np.diag(-rates) + np.diag(rates[1:], -1), rates[:1] * np.eye(POLES)[:, :1]
    system = matrix, push, np.eye(POLES), np.zeros((POLES, 1))
    transition, entry = cont2discrete(system, interval)[:2]
    # one-sided density 1 is two-sided 1/2
    settled = solve_continuous_lyapunov(matrix, -0.5 * push @ push.T)
    added = settled - transition @ settled @ transition.T
    return Chain(np.tril(transition), entry[:, 0], _root(added), _root(settled))


def _root(covariance: Array) -> Array:
    """Root of a covariance that rounding may have left not quite positive."""
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2)
    return vectors * np.sqrt(np.maximum(values, 0))


def counts_from_volts(
    volts: ArrayLike, detector: Detector, *, normals: ArrayLike = 0.0
) -> NDArray[np.uint16]:
    """Raw stream counts of the T7, rounded and clipped; ``normals`` are those of its noise.

    Examples
    --------
    >>> counts_from_volts([0.0, 10.0, 99.0], Detector()).tolist()
    [33523, 65188, 65535]
    """
    raw = np.asarray(volts) / SLOPE + CENTRE
    raw = raw + detector.converter_noise * np.asarray(normals)
    level = 2 ** (16 - detector.bits)
    return np.clip(np.rint(raw / level) * level, 0, 65536 - level).astype(np.uint16)


def volts_from_counts(counts: ArrayLike) -> Array:
    """Volts of raw stream counts by the nominal calibration."""
    return (np.asarray(counts, float) - CENTRE) * SLOPE
