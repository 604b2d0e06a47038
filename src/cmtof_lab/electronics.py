"""Detector, filters and converter: from light to counts, with noise from the data sheets."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.constants import c, e, h
from scipy.linalg import solve_continuous_lyapunov
from scipy.signal import cont2discrete, lfilter

from cmtof.correlation import TAU
from cmtof.hardware.reduction import Gain
from cmtof.types import Array, Counts
from cmtof_lab.settings import TwinSettings

# nominal calibration at +-10 V (T-Series Datasheet, 20.0.1)
SLOPE = 3.15805780e-4  # V per count
CENTRE = 33523.0  # count of 0 V
GAIN = Gain(SLOPE, -SLOPE, CENTRE)
POLES = 3  # of the filters


def volts_per_watt(settings: TwinSettings) -> float:
    """Output of the detector, V/W: responsivity, avalanche gain and transimpedance."""
    photon = h * c / settings.wavelength  # J
    return settings.efficiency * e / photon * settings.gain * settings.transimpedance


def density(settings: TwinSettings, volts: ArrayLike) -> Array:
    """One-sided noise density, V^2/Hz, at an output, V: shot noise and the amplifier's own."""
    # 2 e I F (M R_T)^2 for the primary current I, F = M^x (McIntyre 1966)
    excess = settings.gain**settings.excess_index
    shot = 2 * e * excess * (settings.gain * settings.transimpedance)
    return np.multiply(shot, volts) + settings.noise_density**2


class Chain:
    """Three poles in a row, detector, EF120 and RC, with outputs x, every ``interval``, s.

    ``x' = A x + b (light + noise)`` is carried on exactly, as
    ``x -> transition x + entry light + sqrt(density) root normal``.
    """

    def __init__(self, settings: TwinSettings, interval: float) -> None:
        rates = np.array(
            [TAU * settings.bandwidth, TAU * settings.low_pass, 1 / settings.rc_time]
        )
        matrix = np.diag(-rates) + np.diag(rates[1:], -1)
        push = np.diag(rates)[:, :1]
        system = matrix, push, np.eye(POLES), np.zeros((POLES, 1))
        transition, entry = cont2discrete(system, interval)[:2]  # pyright: ignore[reportIndexIssue]
        # covariance under a one-sided density of 1 for ever, two-sided 1/2
        settled = solve_continuous_lyapunov(matrix, -0.5 * push @ push.T)
        kept = transition @ settled @ transition.T  # pyright: ignore[reportAttributeAccessIssue]
        self.transition = np.tril(transition)
        self.entry = entry[:, 0]  # pyright: ignore[reportArgumentType, reportCallIssue, reportIndexIssue]
        self.root = root_of(settled - kept)
        self.settled = root_of(settled)

    def memory(self, count: int) -> Array:
        """Autocovariance (count,) of the output, V^2, at successive samples for unit density."""
        # cov(x_{t+l}, x_t) = e^T T^l P e
        covariance = self.settled @ self.settled[-1]
        found = []
        for _ in range(count):
            found.append(covariance[-1])
            covariance = self.transition @ covariance
        return np.array(found)

    def run(self, light: Array, spread: Array, normals: Array) -> Array:
        """Output (N, T), V, at the start of each interval; the first finds the filters settled.

        ``light``, V, and ``spread``, V/sqrt(Hz), (N, T), are held for an interval each. ``normals``
        (N, T + 1, 3) are standard normals, those of the initial state first.
        """
        # a product a row: one burst or many give the same bits
        first = normals[:, :1] @ self.settled.T
        later = normals[:, 1:] @ self.root.T
        state = light[:, :1] + spread[:, :1] * first[:, 0]
        push = light[..., None] * self.entry + spread[..., None] * later
        outputs = []
        for i, row in enumerate(self.transition):
            into = push[..., i] + sum(map(np.multiply, outputs, row))
            filtered = lfilter(
                [0.0, 1.0],
                [1.0, -row[i]],
                into,
                zi=state[:, i : i + 1],
            )
            outputs.append(filtered[0])
        return outputs[-1]


def root_of(covariance: Array) -> Array:
    """Root of a covariance that rounding may have left not quite positive."""
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2)
    return vectors * np.sqrt(values.clip(0))


def counts_from_volts(volts: ArrayLike, noise: ArrayLike = 0.0) -> Counts:
    """Raw stream counts of the T7, rounded and clipped; its ``noise`` is in counts."""
    raw = np.divide(volts, SLOPE) + CENTRE
    return np.rint(np.add(raw, noise)).clip(0, 65535).astype(np.uint16)


# Volts of raw stream counts by the nominal calibration
volts_from_counts = GAIN.volts_from_counts
