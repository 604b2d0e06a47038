"""Detector, filters and converter: from light to counts, with noise from the data sheets."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import expm, solve_continuous_lyapunov
from scipy.signal import lfilter

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.instrument.settings import Detector

Array = NDArray[np.float64]

ELEMENTARY_CHARGE = 1.602176634e-19
"""C (exact, SI)."""
PLANCK = 6.62607015e-34
"""J s (exact, SI)."""

SLOPE, CENTRE = 3.15805780e-4, 33523.0
"""V per count at +-10 V and the count of 0 V: the T7's nominal calibration (T-Series Datasheet,
20.0.1)."""
RANGES = (10.0, 1.0, 0.1, 0.01)
"""Input ranges of the T7, V (T-Series Datasheet, AIN#_RANGE)."""

POLES = 3


@dataclass(frozen=True)
class Conversion:
    """What the detector makes of light of a wavelength, m."""

    detector: Detector
    wavelength: float

    @property
    def volts_per_watt(self) -> float:
        """Output of the detector, V/W: responsivity, avalanche gain and transimpedance."""
        photon = PLANCK * SPEED_OF_LIGHT / self.wavelength
        responsivity = self.detector.efficiency * ELEMENTARY_CHARGE / photon
        return responsivity * self.detector.gain * self.detector.transimpedance

    def volts(self, power: ArrayLike) -> Array:
        """Output, V, for light, W, up to saturation."""
        return np.minimum(np.asarray(power) * self.volts_per_watt, self.detector.saturation)

    def density(self, volts: ArrayLike) -> Array:
        """One-sided noise density, V^2/Hz, at an output, V: shot noise and amplifier.

        ``2 e I F (M R_T)^2`` for the primary current I (McIntyre 1966), F = M^x, and the data
        sheet's own.
        """
        gain, excess = self.detector.gain, self.detector.gain**self.detector.excess_index
        shot = 2 * ELEMENTARY_CHARGE * excess * (gain * self.detector.transimpedance)
        return shot * np.asarray(volts, float) + self.detector.noise_density**2


@dataclass(frozen=True, eq=False)
class Chain:
    """Three poles in a row, sampled: detector, EF120 and RC, driven by held light and white noise.

    The state holds the poles' outputs, ``x' = A x + b (light + noise)``. Between samples it is
    carried on exactly: ``x -> transition x + entry light + sqrt(density) root normal``.
    """

    transition: Array
    """(3, 3), lower triangular."""
    entry: Array
    """(3,)."""
    root: Array
    """(3, 3), root of the covariance that unit one-sided density adds in an interval."""
    settled: Array
    """(3, 3), root of the covariance under unit density for ever."""

    @property
    def noise_bandwidth(self) -> float:
        """Variance of the output, V^2, per one-sided density, V^2/Hz."""
        return float(self.settled[-1] @ self.settled[-1])

    def run(self, light: Array, density: Array, normals: Array | None) -> Array:
        """Output (N, T), V, at the start of each interval.

        ``light``, V, and ``density``, V^2/Hz, (N, T), are held for an interval each. ``normals``
        (N, T + 1, 3) are standard normals, those of the initial state first; None is silence. The
        first interval finds the filters settled to its own light.
        """
        state = np.repeat(light[:, :1], POLES, axis=1)
        push = light[..., None] * self.entry
        if normals is not None:
            spread = np.sqrt(density)
            state = state + spread[:, :1] * _times(normals[:, 0], self.settled)
            push = push + spread[..., None] * _times(normals[:, 1:], self.root)
        outputs: list[Array] = []
        for i in range(POLES):
            into = push[..., i]
            for j, earlier in enumerate(outputs):
                into = into + self.transition[i, j] * earlier
            keep = [1.0, -self.transition[i, i]]
            outputs.append(lfilter([0.0, 1.0], keep, into, axis=-1, zi=state[:, i : i + 1])[0])
        return outputs[-1]


def _times(normals: Array, root: Array) -> Array:
    """``root @ normal`` by sums in a fixed order: one row or many give the same bits."""
    total = normals[..., :1] * root[:, 0]
    for j in range(1, POLES):
        total = total + normals[..., j : j + 1] * root[:, j]
    return total


@lru_cache(maxsize=64)
def chain(detector: Detector, interval: float) -> Chain:
    """Filters of a detector sampled every ``interval``, s."""
    rates = np.array(
        [2 * np.pi * detector.bandwidth, 2 * np.pi * detector.low_pass, 1 / detector.rc_time]
    )
    matrix = np.diag(-rates) + np.diag(rates[1:], -1)
    push = np.array([rates[0], 0.0, 0.0])
    transition = np.tril(np.asarray(expm(matrix * interval), float))
    entry = np.asarray(np.linalg.solve(matrix, (transition - np.eye(POLES)) @ push), float)
    # one-sided density 1 is two-sided 1/2
    settled = solve_continuous_lyapunov(matrix, -0.5 * np.outer(push, push))
    added = settled - transition @ settled @ transition.T
    return Chain(transition, entry, _root(added), _root(settled))


def _root(covariance: Array) -> Array:
    """Root of a covariance that rounding may have left not quite positive."""
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2)
    return vectors * np.sqrt(np.maximum(values, 0))


def counts_from_volts(
    volts: ArrayLike, detector: Detector, *, volts_range: float = 10.0, normals: ArrayLike = 0.0
) -> NDArray[np.uint16]:
    """Raw stream counts of the T7, rounded and clipped to what it has.

    ``normals`` are standard normals of the converter's noise.

    Examples
    --------
    >>> counts_from_volts([0.0, 10.0, 99.0], Detector()).tolist()
    [33523, 65188, 65535]
    """
    raw = np.asarray(volts) / slope(volts_range) + CENTRE
    raw = raw + detector.converter_noise * np.asarray(normals)
    level = 2 ** (16 - detector.bits)
    rounded = np.rint(raw / level) * level
    return np.maximum(np.minimum(rounded, 65536 - level), 0).astype(np.uint16)


def slope(volts_range: float) -> float:
    """Volts per count of an input range, V."""
    if volts_range not in RANGES:
        raise ValueError(f"Expected a range out of {RANGES} V, got {volts_range}. Choose one.")
    return SLOPE * volts_range / 10


def volts_from_counts(counts: ArrayLike, *, volts_range: float = 10.0) -> Array:
    """Volts of raw stream counts by the nominal calibration."""
    return (np.asarray(counts, float) - CENTRE) * slope(volts_range)
