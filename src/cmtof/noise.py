"""Noise of a phase map: its size, spectrum and reduction, and the simulator's equivalent.

A wrapped phase may be neither averaged nor differenced as it stands: its wraps are no steps. Every
window of a map is therefore first turned back by the local slope of the phase, which products of
neighbouring phasors give without unwrapping. What is left is flat and may be fitted or summed. A
local fit is a linear filter: the spectrum of its residual gives that of the noise it lets pass.
"""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.random import Generator
from numpy.typing import ArrayLike
from scipy import optimize, stats

from cmtof.bounds import phase_spread
from cmtof.constants import FULL_SIGNAL
from cmtof.correlation import TAU, wrapped
from cmtof.types import Array, Complex, Shape

# linear phase noise, rad, beyond which the phase is uniform over the circle
_LARGEST = 50.0


class Denoised(NamedTuple):
    """A wrapped phase map (H, W), rad, after local coherent averaging, and its coherence.

    That is the length of the mean phasor, 0 to 1: ``exp(-sigma^2 / 2)`` for phase noise sigma on a
    smooth surface, low across edges.
    """

    phase: Array
    coherence: Array


def denoise(phase: ArrayLike, *, window: int = 5) -> Denoised:
    """Phase and coherence of the mean phasor in a window about each pixel, its slope removed.

    The side of the window, px, is odd. White noise falls by ``window``. A plane is kept as it is;
    curvature kappa (rad/px^2, each way) moves the phase by about ``kappa (window^2 - 1) / 12``.

    >>> phase = np.outer(np.ones(9), 0.7 * np.arange(9)) % (2 * np.pi)
    >>> np.allclose(denoise(phase).phase, phase)
    True
    >>> bowl = 0.005 * np.add.outer(np.arange(-9, 10) ** 2, np.arange(-9, 10) ** 2)
    >>> round(float(denoise(bowl, window=7).phase[9, 9]), 3)  # 0.01 * 48 / 12
    0.04
    >>> edge = np.multiply.outer(np.ones(9), np.pi * (np.arange(12) > 5))
    >>> denoise(edge).coherence[4, [2, 5]].round(1).tolist()
    [1.0, 0.2]
    """
    flat = _windows_without_slope(phase, window)
    total = flat.sum(axis=(-2, -1))
    coherence = np.minimum(abs(total) / abs(flat).sum(axis=(-2, -1)), 1.0)
    return Denoised(wrapped(np.add(phase, np.angle(total))), coherence)


def local_phase_noise(phase: ArrayLike, *, window: int = 5) -> Array:
    """Standard deviation (H, W) of the phase about a quadratic fitted to each window, rad.

    The sum of squares is divided by the ``window^2 - 6`` degrees of freedom. Smooth surfaces cancel
    up to second order; edges, and noise beyond about 0.6 rad, do not. NaN where the
    window reaches beyond the map.
    """
    flat = np.angle(_windows_without_slope(phase, window, beyond=np.nan))
    residual = flat.reshape(*flat.shape[:2], -1) @ _residual_matrix(window)
    return np.sqrt(np.vecdot(residual, residual) / (window**2 - 6))


def local_residual(phase: ArrayLike, *, window: int = 9) -> Array:
    """Phase (H, W) of each pixel minus the quadratic fitted to the window around it, rad.

    NaN where the window reaches beyond the map.
    """
    flat = np.angle(_windows_without_slope(phase, window, beyond=np.nan))
    return np.einsum("yxij,ij->yx", flat, _fit_kernel(window))


def typical_phase_noise(
    phase: ArrayLike, where: ArrayLike, *, window: int = 5
) -> float:
    """Phase noise of a typical window of a map, rad.

    The median of `local_phase_noise` over the centres in ``where`` (H, W), over that of white noise
    of one radian: edges and outliers do not count.
    """
    noises = local_phase_noise(phase, window=window)[np.asarray(where, bool)]
    if not np.isfinite(noises).any():
        raise ValueError(
            f"Expected whole windows of {window} px to fit, got none. Widen the region."
        )
    freedom = window**2 - 6
    return float(np.nanmedian(noises) / np.sqrt(stats.chi2.median(freedom) / freedom))


def _windows_without_slope(
    phase: ArrayLike, window: int, *, beyond: float = 0.0
) -> Complex:
    """Phasors in each pixel's window (H, W, window, window), without its phase and slope.

    ``beyond`` stands for those outside the map.
    """
    phase = np.asarray(phase, float)
    if phase.ndim != 2:
        raise ValueError(
            f"Expected a phase map (H, W), got shape {phase.shape}. Pick one plane."
        )
    if not (window > 2 and window % 2):
        raise ValueError(
            f"Expected an odd window of 3 px or more, got {window}. Try 5."
        )
    windows = sliding_window_view(
        np.pad(np.exp(1j * phase), window // 2, constant_values=beyond),
        (window, window),
    )
    ramp = np.zeros(windows.shape)
    for axis, steps in enumerate(np.mgrid[:window, :window] - window // 2, start=2):
        near, far = (np.delete(windows, end, axis) for end in (-1, 0))
        ramp += np.multiply.outer(
            np.angle((np.conj(near) * far).sum(axis=(-2, -1))), steps
        )
    return windows * np.exp(-1j * (phase[..., None, None] + ramp))


def _residual_matrix(window: int) -> Array:
    """Matrix ``1 - A A^+`` from a window's values to the residuals of a fit of second degree."""
    y, x = (axis.ravel() - window // 2.0 for axis in np.mgrid[:window, :window])
    design = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    return np.eye(window**2) - design @ np.linalg.pinv(design)


def _fit_kernel(window: int) -> Array:
    """Weights (window, window) of values in the residual of their quadratic fit at the centre."""
    return _residual_matrix(window)[window**2 // 2].reshape(window, window)


# --- spectra -----------------------------------------------------------------------------------


def fit_response(shape: Shape, *, window: int = 9) -> Array:
    """Transfer function (H, W) of `local_residual` over the frequencies of an FFT, 0 to 1.8.

    From 7 px on it is 0.7 to 1.3 beyond ``1.5 / window`` per pixel. Spectra take its square.
    """
    kernel = np.zeros(shape)
    kernel[:window, :window] = _fit_kernel(window)
    kernel = np.roll(kernel, -(window // 2), axis=(0, 1))
    return np.fft.fft2(kernel).real


def power_spectrum(values: ArrayLike, mask: ArrayLike) -> Array:
    r"""Power spectrum (H, W) of the part of a map that a mask lets through.

    .. math:: P(\mathbf k) = \Bigl|\sum_{\mathbf x} m(\mathbf x)\,r(\mathbf x)\,
              e^{-i\mathbf k\mathbf x}\Bigr|^2 \Big/ \sum_{\mathbf x} m(\mathbf x)

    Its mean is the mean square within the mask (Parseval); that of white noise is flat, sigma^2.
    ValueError if the shapes differ or a value within the mask is not finite.
    """
    values = np.asarray(values, float)
    mask = np.asarray(mask, bool)
    if not (
        values.shape == mask.shape and mask.any() and np.isfinite(values[mask]).all()
    ):
        raise ValueError(
            f"Expected finite values within a mask of shape {values.shape}, got a mask of shape "
            f"{mask.shape} with {mask.sum()} pixels. Choose another region."
        )
    return abs(np.fft.fft2(np.where(mask, values, 0))) ** 2 / mask.sum()


def noise_from_spectrum(spectrum: ArrayLike, *, rng: Generator) -> Array:
    """Random periodic Gaussian noise (H, W) whose mean `power_spectrum` is the given one."""
    white = np.fft.fft2(rng.standard_normal(np.shape(spectrum)))
    return np.fft.ifft2(np.sqrt(spectrum) * white).real


class LineNoise(NamedTuple):
    """Parameters of the phase noise of a scan: noise of pixels, and drift between lines.

    ``white^2 (1 + 2 down cos k_y) (1 + 2 across cos k_x)`` plus an offset common to each column of
    standard deviation ``line``, both in rad. ``down`` and ``across`` are the correlations of the
    grain with its neighbours in column and row: 1/2 for a running mean of two samples.
    """

    white: float
    line: float
    down: float
    across: float

    def spectrum(self, shape: Shape) -> Array:
        """Power spectrum (H, W), rad^2, over the frequencies of an FFT."""
        ky, kx = (TAU * np.fft.fftfreq(size) for size in shape)
        along = 1 + 2 * self.down * np.cos(ky)
        across = 1 + 2 * self.across * np.cos(kx)
        power = self.white**2 * np.outer(along, across)
        power[0] += shape[0] * self.line**2
        return power


def fit_line_noise(
    residual: ArrayLike, mask: ArrayLike, *, window: int = 9
) -> LineNoise:
    """Maximum-likelihood parameters of line noise for a `local_residual` (H, W), rad.

    The periodogram of Gaussian noise follows an exponential law at each frequency (Whittle's
    likelihood): ``sum(log E + P / E)`` is least for the expectation E, the model's spectrum times
    that of the fit, convolved with the mask's. Only frequencies that the fit lets pass count.
    """
    mask = np.asarray(mask, bool)
    measured = power_spectrum(residual, mask)
    level = np.sqrt(measured.mean())
    response = fit_response(measured.shape, window=window) ** 2
    passed = response > 0.5
    overlap = np.fft.ifft2(power_spectrum(mask, mask))

    def noise(q: Array) -> LineNoise:
        sizes = level * np.exp(q[:2])
        correlations = 0.5 * np.tanh(q[2:])
        return LineNoise(*sizes.tolist(), *correlations.tolist())

    def cost(q: Array) -> float:
        covariance = np.fft.ifft2(noise(q).spectrum(measured.shape) * response)
        expected = np.fft.fft2(covariance * overlap).real[passed]
        expected = np.maximum(expected, 1e-9 * level**2)
        return float(np.sum(np.log(expected) + measured[passed] / expected))

    start = np.array([0.0, -1.5, 0.0, 0.0])
    bounds = [(-3, 3), (-7, 2), (-4, 4), (-4, 4)]
    return noise(optimize.minimize(cost, start, method="L-BFGS-B", bounds=bounds).x)


# --- the simulator's noise ---------------------------------------------------------------------


def linear_from_spread(spread: float) -> float:
    """Linear phase noise, rad, at which phases deviate by ``spread``: inverse of `phase_spread`."""
    if not 1e-6 < spread < phase_spread(_LARGEST):
        raise ValueError(
            f"Expected a phase noise between 0 and {np.pi / np.sqrt(3):.2f} rad, "
            f"got {spread:.4g}. Average phases first."
        )
    return optimize.brentq(  # pyright: ignore[reportReturnType]
        lambda x: phase_spread(x) - spread, 0.6 * spread, _LARGEST, xtol=1e-13
    )


def sigma_from_phase_noise(phase_noise: float, *, intensity: ArrayLike = 1.0) -> Array:
    r"""Gaussian noise sigma of the simulator, counts, that gives a phase noise, rad (Eq. 8, 9).

    .. math:: \sigma^2 = 2 (\ell\,GTI/\pi)^2 - GTI/2

    with brightness I and the linear phase noise l of `linear_from_spread`: the inverse of
    `cmtof.bounds.simulated_phase_noise`. ValueError if photon noise alone spreads it further.

    >>> round(float(sigma_from_phase_noise(0.1347)), -1)
    1200.0
    """
    signal = np.multiply(FULL_SIGNAL, intensity)
    variance = 2 * (linear_from_spread(phase_noise) * signal / np.pi) ** 2
    rest = variance - signal / 2
    if not np.all(rest >= -1e-9 * variance):
        least = intensity_from_phase_noise(phase_noise, 0.0)
        raise ValueError(
            f"Expected a brightness of {least:.4g} or more, with photon noise below "
            f"{phase_noise:.4g} rad, got {np.min(intensity):.4g}. Assume a brighter surface."
        )
    return np.sqrt(np.maximum(rest, 0))


def intensity_from_phase_noise(phase_noise: float, sigma: ArrayLike) -> Array:
    """Brightness at which Gaussian noise of sigma counts gives a phase noise, rad.

    The positive root I of `sigma_from_phase_noise`; beyond 1 less noisy than simulated white paper.
    """
    square = 2 * (linear_from_spread(phase_noise) / np.pi) ** 2
    root = np.sqrt(0.25 + 4 * square * np.square(sigma))
    return (0.5 + root) / (2 * square) / FULL_SIGNAL
