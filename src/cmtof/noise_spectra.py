"""What a phase map leaves over a smooth surface, its power spectrum, and noise with a spectrum.

A local fit is a linear filter of the noise: it takes out what is slow and lets pass what is fast.
Its response is known, so a spectrum of what it leaves tells the spectrum of the noise itself.
"""

from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray
from scipy import optimize

from cmtof.denoising import flattened, left_over

Array = NDArray[np.float64]


def fit_kernel(window: int) -> Array:
    """Weights (window, window) by which a quadratic fit leaves over the centre of its window.

    The central row of ``1 - A A^+``: one at the centre less the fit's own weights. It gives zero
    for every surface up to third order.

    Examples
    --------
    >>> kernel = fit_kernel(5)
    >>> bool(abs(kernel.sum()) < 1e-12), round(float(kernel[2, 2]), 4)
    (True, 0.8457)
    """
    return left_over(window)[window**2 // 2].reshape(window, window)


def local_residual(phase: ArrayLike, *, window: int = 9) -> Array:
    """Phase of each pixel minus the quadratic surface fitted to the window around it, rad.

    The windows are turned back by their local slope first, so that no wrap lies within.

    Parameters
    ----------
    phase : array_like, shape (H, W)
        Wrapped phase, rad.
    window : int
        Odd side of the window, px, at least 3.

    Returns
    -------
    ndarray, shape (H, W)
        rad; NaN where the window reaches beyond the image.

    Examples
    --------
    >>> y, x = np.mgrid[:15, :15]
    >>> float(np.nanmax(np.abs(local_residual((0.02 * x**2 + 0.5 * y) % (2 * np.pi))))) < 1e-12
    True
    """
    kernel = fit_kernel(window)
    phase = np.asarray(phase, float)
    flat = np.angle(flattened(phase, window=window))
    residual = np.einsum("yxij,ij->yx", flat, kernel)
    reach = window // 2
    residual[:reach], residual[-reach:] = np.nan, np.nan
    residual[:, :reach], residual[:, -reach:] = np.nan, np.nan
    return residual


def fit_response(shape: tuple[int, int], *, window: int = 9) -> Array:
    """Response (H, W) of `local_residual` at the frequencies of a Fourier transform: 0 to 1.3.

    Real, as the fit is symmetric; zero at zero frequency, about one beyond ``1 / window`` per
    pixel. The spectrum of the residual is the noise's times its square.

    Raises
    ------
    ValueError
        If the window is even, or larger than the map.
    """
    if window > min(shape):
        raise ValueError(
            f"Expected a window of at most {min(shape)} px for a map of {shape}, got {window}. "
            "Take a smaller one."
        )
    kernel = np.zeros(shape)
    kernel[:window, :window] = fit_kernel(window)
    centre = -(window // 2)
    return np.fft.fft2(np.roll(kernel, (centre, centre), axis=(0, 1))).real


def power_spectrum(values: ArrayLike, mask: ArrayLike) -> Array:
    r"""Power spectrum of the part of a map that a mask lets through, unit of the map squared.

    .. math:: P(\mathbf k) = \Bigl|\sum_{\mathbf x} m(\mathbf x)\,r(\mathbf x)\,
              e^{-i\mathbf k\mathbf x}\Bigr|^2 \Big/ \sum_{\mathbf x} m(\mathbf x)

    Its mean is the mean square within the mask (Parseval), and white noise of standard deviation
    sigma has the flat expectation sigma^2. The mean over one axis is the one-dimensional spectrum
    along the other.

    Parameters
    ----------
    values : array_like, shape (H, W)
        Whatever lies outside the mask does not count, NaN included.
    mask : array_like of bool, shape (H, W)

    Raises
    ------
    ValueError
        If the shapes differ, the mask is empty, or lets a value pass that is not finite.
    """
    values, mask = np.asarray(values, float), np.asarray(mask, bool)
    if values.ndim != 2 or values.shape != mask.shape or not mask.any():
        raise ValueError(
            f"Expected a map (H, W) and a mask of its shape with a pixel in it, got {values.shape} "
            f"and {mask.shape} with {mask.sum()}. Choose another region."
        )
    if not np.isfinite(values[mask]).all():
        raise ValueError("Expected finite values within the mask, got NaN or inf. Shrink the mask.")
    return np.abs(np.fft.fft2(np.where(mask, values, 0))) ** 2 / mask.sum()


def masked_spectrum(spectrum: ArrayLike, mask: ArrayLike) -> Array:
    """Expectation of `power_spectrum` within a mask, of noise whose own spectrum is given.

    A mask mixes neighbouring frequencies: it multiplies the autocovariance by its own
    autocorrelation.

    Parameters
    ----------
    spectrum : array_like, shape (H, W)
        Power spectrum of the noise without a mask.
    mask : array_like of bool, shape (H, W)
    """
    overlap = np.abs(np.fft.fft2(np.asarray(mask, float))) ** 2
    covariance = np.fft.ifft2(spectrum) * np.fft.ifft2(overlap / np.sum(mask))
    return np.fft.fft2(covariance).real


def noise_from_spectrum(spectrum: ArrayLike, *, rng: Generator) -> Array:
    """Gaussian noise (H, W) whose expected `power_spectrum` is the one given.

    White noise filtered by the root of the spectrum; it goes on periodically past the border.

    Parameters
    ----------
    spectrum : array_like, shape (H, W)
        At least 0, symmetric in frequency; its mean is the variance.
    rng : Generator
        Source of the random numbers.

    Raises
    ------
    ValueError
        If the spectrum is negative or not finite somewhere.
    """
    spectrum = np.asarray(spectrum, float)
    if not (spectrum.min() >= 0 and np.isfinite(spectrum).all()):
        raise ValueError(
            f"Expected a finite power spectrum >= 0, got values from {spectrum.min():.4g}. "
            "Keep correlations between neighbours within -0.5 and 0.5."
        )
    white = np.fft.fft2(rng.standard_normal(spectrum.shape))
    return np.fft.ifft2(np.sqrt(spectrum) * white).real


class LineNoise(NamedTuple):
    """Phase noise of a scan: a grain whose neighbours may correlate, and drift between lines.

    ``white^2 (1 + 2 rho_d cos k_y) (1 + 2 rho_a cos k_x)`` plus an offset common to each column.
    A running mean of two samples, or beam spots that overlap by half, have rho = 1/2.
    """

    white: float
    """Standard deviation of the grain, rad."""
    line: float
    """Standard deviation of the columns' offsets, rad."""
    down: float
    """Correlation of the grain with its neighbour in the column, -1/2 to 1/2."""
    across: float
    """Correlation of the grain with its neighbour in the row, -1/2 to 1/2."""

    def spectrum(self, shape: tuple[int, int]) -> Array:
        """Power spectrum (H, W) at the frequencies of a Fourier transform, rad^2.

        Examples
        --------
        >>> noise = LineNoise(white=0.3, line=0.4, down=0.2, across=0.0)
        >>> round(float(noise.spectrum((64, 48)).mean()), 12)  # 0.3^2 + 0.4^2
        0.25
        """
        ky, kx = (2 * np.pi * np.fft.fftfreq(size) for size in shape)
        grain = np.outer(1 + 2 * self.down * np.cos(ky), 1 + 2 * self.across * np.cos(kx))
        power = self.white**2 * grain
        power[0] += shape[0] * self.line**2
        return power


def fit_line_noise(residual: ArrayLike, mask: ArrayLike, *, window: int = 9) -> LineNoise:
    """Line noise whose spectrum, seen through fit and mask, is likeliest for a residual.

    The periodogram of Gaussian noise follows an exponential law at each frequency (Whittle's
    likelihood); ``sum(log E + P / E)`` is least for the expectation E sought. Only frequencies
    that the fit lets pass count: in the others surface and noise cannot be told apart.

    Parameters
    ----------
    residual : array_like, shape (H, W)
        From `local_residual` with the same window, rad.
    mask : array_like of bool, shape (H, W)
        Where the surface is smooth.
    window : int
        Side of the fits, px.

    Raises
    ------
    ValueError
        As in `power_spectrum`, or if the residual is zero.
    """
    mask = np.asarray(mask, bool)
    measured = power_spectrum(residual, mask)
    level = float(np.sqrt(measured.mean()))
    if level == 0:
        raise ValueError("Expected a residual with noise in it, got zeros. Take a noisy phase.")
    response = fit_response((mask.shape[0], mask.shape[1]), window=window) ** 2
    passed = response > 0.5

    def noise(q: Array) -> LineNoise:
        grain, line = level * np.exp(q[:2])
        return LineNoise(float(grain), float(line), *(0.5 * np.tanh(q[2:])).tolist())

    def cost(q: Array) -> float:
        expected = masked_spectrum(noise(q).spectrum(mask.shape) * response, mask)[passed]
        expected = np.maximum(expected, 1e-9 * level**2)
        return float(np.sum(np.log(expected) + measured[passed] / expected))

    start = np.array([0.0, -1.5, 0.0, 0.0])
    bounds = [(-3, 3), (-7, 2), (-4, 4), (-4, 4)]
    return noise(optimize.minimize(cost, start, method="L-BFGS-B", bounds=bounds).x)
