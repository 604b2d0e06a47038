"""Depth precision against modulation frequency: the experiment of Fig. 3 (Sec. 3).

One point of a scene is measured again and again at each frequency, with noise that does not
depend on the frequency. The phase error stays; the depth error falls as 1/f.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray

from cmtof.bounds import phase_bound, phase_spread
from cmtof.constants import ADC_BITS, GAIN, INTEGRATION_TIME, NOISE_SIGMA
from cmtof.correlation import (
    centred,
    correlation_from_phase,
    depth_from_phase,
    phase_from_correlation,
    phase_from_depth,
)
from cmtof.detector import poisson_gaussian, quantise

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class PrecisionSweep(NamedTuple):
    """Depth errors at each modulation frequency; arrays of shape (F,)."""

    frequency: NDArray[np.floating]
    """Modulation frequency, Hz."""
    mean: NDArray[np.floating]
    """Mean depth error, m."""
    spread: NDArray[np.floating]
    """Standard deviation of the depth error, m."""
    bound: NDArray[np.floating]
    """Cramer-Rao bound on that standard deviation, m."""
    law: NDArray[np.floating]
    """Standard deviation by the exact law of a noisy phasor's phase, m."""
    samples: int
    """Measurements at each frequency."""


def precision_sweep(
    frequencies: ArrayLike,
    *,
    rng: Generator,
    samples: int = 1000,
    depth: float = 0.6,
    intensity: float = 0.5,
    sigma: float = NOISE_SIGMA,
    bits: int = ADC_BITS,
) -> PrecisionSweep:
    """Measure one point ``samples`` times at each frequency and keep its depth errors.

    Correlations follow Eq. 8 with Poisson-Gaussian noise at four reference phases. They are
    quantised over a scale that holds the brightest signal and five sigma of noise on either
    side: without that pedestal the converter would clip the noise and bias the phase.

    Parameters
    ----------
    frequencies : array_like, shape (F,)
        Modulation frequencies, Hz.
    rng : Generator
        Source of the noise.
    samples : int
        Measurements at each frequency.
    depth : float
        Range of the point, m; its whole wraps are taken as known.
    intensity : float
        Brightness of the point, 0 to 1.
    sigma : float
        Gaussian noise, counts.
    bits : int
        Resolution of the converter.
    """
    frequencies = np.asarray(frequencies, float)
    psi = np.arange(4) * np.pi / 2
    signal = GAIN * INTEGRATION_TIME * intensity
    phase = phase_from_depth(depth, frequencies)
    mean = correlation_from_phase(phase, psi, amplitude=signal / np.pi, offset=signal / 2)
    counts = poisson_gaussian(np.repeat(mean[..., None], samples, axis=-1), rng=rng, sigma=sigma)
    pedestal = 5 * sigma
    full_scale = GAIN * INTEGRATION_TIME * (0.5 + 1 / np.pi) + 2 * pedestal
    counts = quantise(counts + pedestal, bits=bits, full_scale=full_scale) - pedestal
    error = centred(phase_from_correlation(counts, psi) - phase[:, None])
    error = depth_from_phase(error, frequencies[:, None])
    bound = [
        depth_from_phase(phase_bound(signal / np.pi, signal / 2, psi, sigma=sigma, phase=p), f)
        for f, p in zip(frequencies, phase, strict=True)
    ]
    bound = np.array(bound)
    # the bound in phase is the noise of the phasor across its direction: the law's parameter
    law = [
        depth_from_phase(phase_spread(b), f)
        for b, f in zip(phase_from_depth(bound, frequencies), frequencies, strict=True)
    ]
    return PrecisionSweep(
        frequencies,
        error.mean(axis=1),
        error.std(axis=1, ddof=1),
        bound,
        np.array(law),
        samples,
    )


def precision_ratio(sweep: PrecisionSweep) -> float:
    """How many times finer the depth is at the highest frequency than at the lowest."""
    return float(sweep.spread[0] / sweep.spread[-1])


def precision_figure(sweep: PrecisionSweep) -> "Figure":
    """Draw Fig. 3: envelope of the depth error, and its standard deviation on the bound."""
    import matplotlib.pyplot as plt

    from cmtof.book.plotting import PALETTE

    ghz = sweep.frequency / 1e9
    fig, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8))
    left.fill_between(
        ghz,
        1e3 * (sweep.mean - sweep.spread),
        1e3 * (sweep.mean + sweep.spread),
        color=PALETTE["sky"],
        alpha=0.5,
        label="± one standard deviation",
    )
    left.plot(ghz, 1e3 * sweep.mean, color=PALETTE["blue"], label="mean")
    left.set(xscale="log", xlabel="modulation frequency (GHz)", ylabel="depth error (mm)")
    left.legend()
    right.plot(ghz, 1e3 * sweep.bound, color=PALETTE["black"], label="Cramér–Rao bound")
    right.plot(
        ghz,
        1e3 * sweep.spread,
        "o",
        color=PALETTE["vermillion"],
        label=f"{sweep.samples} simulated samples",
    )
    right.set(
        xscale="log",
        yscale="log",
        xlabel="modulation frequency (GHz)",
        ylabel="standard deviation (mm)",
    )
    right.legend()
    return fig
