"""Limits set by noise: Cramer-Rao bounds, phase distributions, probabilities of the right wrap.

The phase of a correlation is the angle of a phasor with Gaussian noise. Where that noise is small
the angle is Gaussian too, and the bound is met; where it is not, the angle follows the exact law
below and spreads further than the bound says.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from cmtof.constants import FULL_SIGNAL, NOISE_SIGMA
from cmtof.correlation import TAU
from cmtof.types import Array, Pair


def fisher_information(
    amplitude: ArrayLike,
    offset: ArrayLike,
    psi: ArrayLike,
    *,
    sigma: float,
    phase: ArrayLike = 0.0,
) -> Array:
    """Fisher information of (phase, amplitude, offset) in Poisson-Gaussian correlations.

    With mean ``mu_k = offset + a cos(phi + psi_k)`` and variance ``v_k = mu_k + sigma^2``, the
    noise Gaussian (many counts): ``I = sum_k (1/v_k + 1/(2 v_k^2)) grad mu_k grad mu_k^T``, the
    second term because the variance, too, depends on the mean. Amplitude and offset (...) and
    sigma in counts, ``psi`` (K,) and ``phase`` (...) in rad; the result is (..., 3, 3).
    """
    a, d, phi = np.stack(np.broadcast_arrays(amplitude, offset, phase))[..., None]
    angle = phi + np.asarray(psi, float)
    mean = d + a * np.cos(angle)
    variance = mean + sigma**2
    gradient = np.stack([a * -np.sin(angle), np.cos(angle), np.ones_like(angle)], -1)
    weight = 1 / variance + 1 / (2 * variance**2)
    return np.einsum("...k,...ki,...kj->...ij", weight, gradient, gradient)


def phase_bound(
    amplitude: ArrayLike,
    offset: ArrayLike,
    psi: ArrayLike,
    *,
    sigma: float,
    phase: ArrayLike = 0.0,
) -> Array:
    """Cramer-Rao bound: least standard deviation of the phase, rad; amplitude and offset unknown.

    Parameters and shapes as in `fisher_information`.

    The paper's settings at full brightness, G T = 20 000 counts:

    >>> psi = np.arange(4) * np.pi / 2
    >>> round(float(phase_bound(20_000 / np.pi, 10_000.0, psi, sigma=1200.0)), 3)
    0.134
    """
    information = fisher_information(amplitude, offset, psi, sigma=sigma, phase=phase)
    return np.sqrt(np.linalg.inv(information)[..., 0, 0])


def linear_phase_noise(amplitude: ArrayLike, variance: ArrayLike, steps: int) -> Array:
    """Phase noise, rad, as long as it is small: ``sqrt(2 v / K) / a`` of K steps of variance v."""
    return np.sqrt(2 * np.asarray(variance) / steps) / np.asarray(amplitude)


def simulated_phase_noise(
    intensity: ArrayLike,
    *,
    sigma: float = NOISE_SIGMA,
) -> Array:
    """Standard deviation of a simulated pixel's phase, rad, from its brightness I (Eq. 8).

    It is `linear_phase_noise` with the amplitude ``G T I / pi`` and the variance of photon and
    Gaussian noise, ``G T I / 2 + sigma^2``, as `cmtof.simulation.simulate` draws them; sigma is in
    counts.

    >>> round(float(simulated_phase_noise(1.0)), 3)
    0.134
    """
    signal = FULL_SIGNAL * np.asarray(intensity, float)
    return linear_phase_noise(signal / np.pi, signal / 2 + sigma**2, 4)


def phase_density(error: ArrayLike, linear_noise: float) -> Array:
    r"""Probability density of the phase error of a phasor with circular Gaussian noise, 1/rad.

    .. math:: p(\theta) = \frac{e^{-\rho^2/2}}{2\pi} + \frac{\rho\cos\theta}{\sqrt{2\pi}}
              e^{-\rho^2\sin^2\theta/2}\,\Phi(\rho\cos\theta)

    with ``rho = 1 / linear_noise``, amplitude over the noise of one component; error in
    [-pi, pi], rad.
    """
    rho = 1 / linear_noise
    along = rho * np.cos(error)
    across = rho * np.sin(error)
    gaussian = along / np.sqrt(TAU) * np.exp(-(across**2) / 2) * special.ndtr(along)
    return np.exp(-(rho**2) / 2) / TAU + gaussian


def phase_spread(linear_noise: float) -> float:
    """Standard deviation of the wrapped phase error, rad, by the exact `phase_density`.

    A pixel of brightness 0.3 spreads 18 % further than the linear formula says:

    >>> round(phase_spread(0.445) / 0.445, 2)
    1.18
    """
    from scipy.integrate import quad

    # the density is a peak of width linear_noise: the quadrature starts from it
    edges = [min(np.pi, m * linear_noise) for m in (1, 4, 10)]
    moment = quad(
        lambda t: t**2 * phase_density(t, linear_noise),
        0,
        np.pi,
        points=edges,
        epsabs=1e-13,
    )[0]
    return float(np.sqrt(2 * moment))


def wrap_noise(
    noise_low: ArrayLike, noise_high: ArrayLike, *, frequencies: Array | Pair
) -> Array:
    r"""Standard deviation of the wrap count from one pixel's beat, wraps.

    .. math:: \sigma_n = \frac{\sqrt{f_1^2\sigma_2^2 + f_2^2\sigma_1^2}}{2\pi\,\Delta},\quad
              \Delta = |f_2 - k f_1|,\ k = \mathrm{round}(f_2/f_1)

    from the phase noise at the lower and the higher frequency, rad.

    >>> round(float(wrap_noise(0.134, 0.134, frequencies=(7.15e9, 14.32e9))), 1)
    17.1
    """
    low, high = frequencies
    beat = abs(high - round(high / low) * low)
    return np.hypot(low * np.asarray(noise_high), high * np.asarray(noise_low)) / (
        TAU * beat
    )


def wrap_probability(
    noise_low: ArrayLike, noise_high: ArrayLike, *, frequencies: Array | Pair
) -> Array:
    """Probability that one pixel's beat gives the right wrap: `rounding_odds` of `wrap_noise`.

    >>> p = wrap_probability(0.1336, 0.1336, frequencies=(7.15e9, 14.32e9))
    >>> f"{p:.1%}"
    '2.3%'
    """
    return rounding_odds(wrap_noise(noise_low, noise_high, frequencies=frequencies))


def rounding_odds(spread: ArrayLike) -> Array:
    """Probability that a Gaussian error of this standard deviation, wraps, is below half a wrap."""
    with np.errstate(divide="ignore"):  # without noise the odds are 1
        return special.erf(1 / (2 * np.sqrt(2) * np.asarray(spread)))


def wrap_probability_law(
    linear_low: float, linear_high: float, *, frequencies: Pair
) -> float:
    r"""Probability that one pixel's beat gives the right wrap, exact also for large noise.

    .. math:: P = \int p_1(\epsilon_1) \int_{|b f_1/\Delta - \epsilon_1| < \pi}
              p_2(k\epsilon_1 + b)\,db\,d\epsilon_1

    with the densities of `phase_density`, ``Delta = f_2 - k f_1`` and b the error of the beat: the
    wrap is right where the beat's depth and the phase of the lower frequency agree on it.

    `linear_phase_noise` at the lower and the higher frequency in rad, 3 mrad or more; both in Hz.

    The tails of a dark pixel's phase cost a few percent of its odds:

    >>> f = (7.15e9, 14.32e9)
    >>> p, law = wrap_probability(0.445, 0.445, frequencies=f), wrap_probability_law(
    ...     0.445, 0.445, frequencies=f
    ... )
    >>> round(float(law / p), 2)
    0.97
    """
    low, high = frequencies
    multiple = round(high / low)
    ratio = high / low - multiple  # signed Delta / f_1
    error = TAU * (np.arange(8192) + 0.5) / 8192 - np.pi
    # the more, the more standard deviations the beat may err by
    count = 9 + int(4 * np.pi * abs(ratio) / linear_high)
    nodes, weights = np.polynomial.legendre.leggauss(count)
    beat = ratio * (error[:, None] + np.pi * nodes)
    inner = phase_density(multiple * error[:, None] + beat, linear_high) @ weights
    return float(
        TAU * np.mean(phase_density(error, linear_low) * inner) * np.pi * abs(ratio)
    )


def pixels_needed(
    noise_low: float,
    noise_high: float,
    *,
    frequencies: Pair,
    odds: float = 0.95,
) -> int:
    """Number of pixels to average so that the wrap is right with the probability ``odds``.

    Their phasors are summed, after each was turned back by its known depth relative to the others.

    >>> pixels_needed(0.1336, 0.1336, frequencies=(7.15e9, 14.32e9))
    4450
    """
    single = wrap_noise(noise_low, noise_high, frequencies=frequencies)
    return int(np.ceil(8 * (single * special.erfinv(odds)) ** 2))
