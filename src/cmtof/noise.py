"""Noise of a phase map: its size, its spectrum, and less of it."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray
from scipy import optimize, stats

from cmtof.bounds import linear_phase_noise, phase_spread
from cmtof.constants import FREQUENCY_SINGLE, GAIN, INTEGRATION_TIME
from cmtof.correlation import consistent_wrap_count, depth_from_wraps, wrapped
from cmtof.scenes import Frame, load_frame

Array = NDArray[np.floating]


class Denoised(NamedTuple):
    """A phase map after local coherent averaging; arrays of shape (H, W)."""

    phase: Array
    """Wrapped phase in [0, 2 pi), rad."""
    coherence: Array
    """Length of the mean phasor over the mean length, 0 to 1: near 1 on one smooth surface,
    ``exp(-sigma^2 / 2)`` for phase noise sigma, low across edges."""


def phase_slope(
    phase: ArrayLike, amplitude: ArrayLike | None = None, *, window: int = 5
) -> tuple[Array, Array]:
    """Slope (down, right) of a wrapped phase map around each pixel, rad/px, each (H, W).

    The angle of ``sum a a' exp(i (phi' - phi))`` over all pairs of neighbours in the window: exact
    for a plane, and free of wraps as long as the slope stays below half a turn per pixel.

    Parameters
    ----------
    phase : array_like, shape (H, W)
        Wrapped phase, rad.
    amplitude : array_like, shape (H, W), optional
        Weight of each pixel; equal weights by default.
    window : int
        Odd side of the window, px.

    Examples
    --------
    >>> down, right = phase_slope(np.add.outer(0.3 * np.arange(9), -1.2 * np.arange(9)))
    >>> round(float(down[4, 4]), 6), round(float(right[4, 4]), 6)
    (0.3, -1.2)
    """
    _check_window(window)
    phasor = _phasor(phase, amplitude)
    slopes = []
    for axis in (0, 1):
        ahead = np.roll(phasor, -1, axis) * np.conj(phasor)
        ahead[(slice(None),) * axis + (-1,)] = 0  # the last pixel has no neighbour ahead
        windows = _windows(ahead, window)
        # pairs whose second half lies beyond the window do not count
        inside = windows[..., :-1, :] if axis == 0 else windows[..., :-1]
        slopes.append(np.angle(inside.sum(axis=(-2, -1))))
    return slopes[0], slopes[1]


def local_phase_noise(phase: ArrayLike, *, window: int = 5) -> Array:
    """Standard deviation of the phase about a quadratic surface fitted to each window, rad.

    Least squares with six coefficients leave ``window^2 - 6`` degrees of freedom, and the sum of
    squares is divided by these: the mean square is unbiased for white noise. Smooth surfaces cancel
    up to their third derivative; edges, and noise near a wrap (sigma beyond about 0.6 rad), do not.

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
    >>> float(np.nanmax(local_phase_noise((0.02 * x**2 + 0.5 * y) % (2 * np.pi)))) < 1e-12
    True
    """
    phase = np.asarray(phase, float)
    flat = np.angle(flattened(phase, window=window))
    outside = left_over(window)
    residual = flat.reshape(*phase.shape, -1) @ outside
    noise = np.sqrt((residual**2).sum(axis=-1) / (window**2 - 6))
    reach = window // 2
    noise[:reach], noise[-reach:], noise[:, :reach], noise[:, -reach:] = (np.nan,) * 4
    return noise


def left_over(window: int) -> Array:
    """Projector (window^2, window^2) onto what a quadratic surface fitted to a window leaves.

    ``1 - A A^+`` with the six columns 1, x, y, x², xy, y² of A.

    Examples
    --------
    >>> round(float(np.trace(left_over(5))), 9)  # degrees of freedom
    19.0
    """
    _check_window(window)
    y, x = _offsets(window)
    design = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y]).reshape(6, -1).T
    return np.eye(window**2) - design @ np.linalg.pinv(design)


def denoise(phase: ArrayLike, amplitude: ArrayLike | None = None, *, window: int = 5) -> Denoised:
    """Average each pixel's phasor with its window's, turned back by the local slope.

    Sums of phasors are linear in the noise, so white noise falls by ``window`` and no wrap is ever
    passed. A plane is kept as it is; curvature kappa (rad/px^2, each way) moves the phase by about
    ``kappa (window^2 - 1) / 12``.

    Parameters
    ----------
    phase, amplitude, window
        As in `phase_slope`. Pixels beyond the border have no weight.

    Returns
    -------
    Denoised
        Phase, rad, and coherence.

    Raises
    ------
    ValueError
        If the window is not an odd number of at least 3, or the map is smaller.

    Examples
    --------
    >>> phase = (np.outer(np.ones(9), 0.7 * np.arange(9))) % (2 * np.pi)
    >>> np.allclose(denoise(phase).phase, phase)
    True
    """
    _check_window(window)
    phase = np.asarray(phase, float)
    phasor = _phasor(phase, amplitude)
    total = flattened(phase, amplitude, window=window).sum(axis=(-2, -1))
    length = _windows(np.abs(phasor), window).sum(axis=(-2, -1))
    coherence = np.abs(total) / np.where(length > 0, length, 1)
    return Denoised(wrapped(phase + np.angle(total)), np.minimum(coherence, 1.0))


def denoised_phase(
    phase: ArrayLike, amplitude: ArrayLike | None = None, *, window: int = 5
) -> Array:
    """Phase (H, W) of `denoise`, rad."""
    return denoise(phase, amplitude, window=window).phase


def _check_window(window: int) -> None:
    if window < 3 or window % 2 == 0:
        raise ValueError(f"Expected an odd window of 3 px or more, got {window}. Try 5.")


def _phasor(phase: ArrayLike, amplitude: ArrayLike | None) -> NDArray[np.complex128]:
    phase = np.asarray(phase, float)
    if phase.ndim != 2:
        raise ValueError(f"Expected a phase map (H, W), got shape {phase.shape}. Pick one plane.")
    phasor = np.exp(1j * phase)
    return phasor if amplitude is None else phasor * np.asarray(amplitude, float)


def _windows(image: NDArray, window: int) -> NDArray:
    """Windows (H, W, window, window) around every pixel; zero beyond the border."""
    return sliding_window_view(np.pad(image, window // 2), (window, window))


def _offsets(window: int) -> tuple[Array, Array]:
    steps = np.arange(window) - window // 2.0
    return np.repeat(steps[:, None], window, axis=1), np.repeat(steps[None, :], window, axis=0)


def flattened(
    phase: ArrayLike, amplitude: ArrayLike | None = None, *, window: int
) -> NDArray[np.complex128]:
    """Windows (H, W, window, window) turned back by the centre's phase and the local slope.

    On a smooth surface their angles are small and hold no wrap. Zero beyond the border.
    """
    _check_window(window)
    down, right = phase_slope(phase, amplitude, window=window)
    y, x = _offsets(window)
    centre = np.asarray(phase, float)[..., None, None]
    ramp = down[..., None, None] * y + right[..., None, None] * x + centre
    return _windows(_phasor(phase, amplitude), window) * np.exp(-1j * ramp)


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


Array = NDArray[np.float64]

_LARGEST_LINEAR_NOISE = 50.0
"""Linear phase noise, rad, beyond which the phase tells nothing: it is uniform over the circle."""


def phase_noise_from_sigma(
    sigma: float,
    *,
    intensity: float = 1.0,
    gain: float = GAIN,
    integration_time: float = INTEGRATION_TIME,
    steps: int = 4,
) -> float:
    r"""Spread of the simulator's phase by its exact law, rad (Eq. 8 and 9).

    .. math:: \sigma_\varphi \approx \sqrt{\tfrac{2}{K}\left(\tfrac{GTI}{2}+\sigma^2\right)}
              \Big/ \tfrac{GTI}{\pi}

    with `cmtof.bounds.phase_spread` for what noise beyond the small adds.

    Parameters
    ----------
    sigma : float
        Gaussian noise, counts; photon noise comes with it.
    intensity : float
        Brightness I of the surface, above 0.
    gain, integration_time : float
        G and T of Eq. 8.
    steps : int
        Number K of uniform reference phases.

    Examples
    --------
    >>> round(phase_noise_from_sigma(1200.0), 3)
    0.135
    """
    signal = gain * integration_time * intensity
    if not (signal > 0 and sigma >= 0):
        raise ValueError(
            f"Expected a signal above 0 and sigma >= 0 counts, got {signal:g} and {sigma:g}. "
            "Check brightness and noise."
        )
    return phase_spread(float(linear_phase_noise(signal / np.pi, signal / 2 + sigma**2, steps)))


def sigma_from_phase_noise(
    phase_noise: float,
    *,
    intensity: ArrayLike = 1.0,
    gain: float = GAIN,
    integration_time: float = INTEGRATION_TIME,
    steps: int = 4,
) -> Array:
    """Gaussian noise of the simulator that gives a phase noise, counts.

    The inverse of `phase_noise_from_sigma`.

    Parameters
    ----------
    phase_noise : float
        rad.
    intensity : array_like
        Brightness I of the surface.
    gain, integration_time, steps
        As in `phase_noise_from_sigma`.

    Raises
    ------
    ValueError
        If no noise spreads a phase so far, or photon noise alone spreads it further.

    Examples
    --------
    >>> round(float(sigma_from_phase_noise(phase_noise_from_sigma(1200.0))), 6)
    1200.0
    """
    signal = gain * integration_time * np.asarray(intensity, float)
    variance = steps / 2 * (linear_from_spread(phase_noise) * signal / np.pi) ** 2
    rest = variance - signal / 2
    if not np.all(rest >= -1e-9 * variance):  # false for NaN as well
        least = intensity_from_phase_noise(
            phase_noise, 0.0, gain=gain, integration_time=integration_time, steps=steps
        )
        raise ValueError(
            f"Expected a brightness of {least:.4g} or more, got {np.min(intensity):.4g}: photon "
            f"noise alone is beyond {phase_noise:.4g} rad there. Assume a brighter surface."
        )
    return np.sqrt(np.maximum(rest, 0))


def intensity_from_phase_noise(
    phase_noise: float,
    sigma: ArrayLike,
    *,
    gain: float = GAIN,
    integration_time: float = INTEGRATION_TIME,
    steps: int = 4,
) -> Array:
    """Brightness at which the simulator's Gaussian noise gives a phase noise.

    The positive root of ``K/2 (l G T I / pi)^2 - G T I / 2 - sigma^2 = 0``, l the linear phase
    noise. It may exceed 1: then the surface measured is less noisy than white paper simulated.

    Parameters
    ----------
    phase_noise : float
        rad.
    sigma : array_like
        Gaussian noise, counts.
    gain, integration_time, steps
        As in `phase_noise_from_sigma`.

    Examples
    --------
    >>> noise = phase_noise_from_sigma(900.0, intensity=0.7)
    >>> round(float(intensity_from_phase_noise(noise, 900.0)), 9)
    0.7
    """
    square = steps / 2 * (linear_from_spread(phase_noise) / np.pi) ** 2
    sigma = np.asarray(sigma, float)
    signal = (0.5 + np.sqrt(0.25 + 4 * square * sigma**2)) / (2 * square)
    return signal / (gain * integration_time)


def linear_from_spread(spread: float) -> float:
    """Linear phase noise whose exact law spreads this far: inverse of `bounds.phase_spread`, rad.

    Raises
    ------
    ValueError
        If the spread is not between 0 and that of a uniform phase, pi/sqrt(3).

    Examples
    --------
    >>> round(linear_from_spread(phase_spread(0.445)), 9)
    0.445
    """
    if not 1e-6 < spread < phase_spread(_LARGEST_LINEAR_NOISE):
        raise ValueError(
            f"Expected a phase noise between 0 and {np.pi / np.sqrt(3):.2f} rad, got {spread:.4g}. "
            "A phase that spreads further is no more than a guess."
        )
    # the law spreads up to a third further than the linear noise, then ever less far
    low, high = 0.6 * spread, _LARGEST_LINEAR_NOISE
    root: Any = optimize.brentq(lambda linear: phase_spread(linear) - spread, low, high, xtol=1e-13)
    return float(root)


def typical_phase_noise(phase: ArrayLike, where: ArrayLike, *, window: int = 5) -> float:
    """Phase noise of a typical window of a phase map, rad.

    The median of `cmtof.noise.local_phase_noise`, over the median that white noise of one
    radian would have there: edges and outliers do not count.

    Parameters
    ----------
    phase : array_like, shape (H, W)
        Wrapped phase, rad.
    where : array_like of bool, shape (H, W)
        Windows to count, by their centres.
    window : int
        Side of the fits, px.

    Raises
    ------
    ValueError
        If no window lies whole within the map there, or the shapes differ.
    """
    noise, where = local_phase_noise(phase, window=window), np.asarray(where, bool)
    _check_same(noise, where, "a region")
    held = noise[where & np.isfinite(noise)]
    if held.size == 0:
        raise ValueError(
            f"Expected whole windows of {window} px to fit, got none. Widen the region."
        )
    freedom = window**2 - 6
    return float(np.median(held) / np.sqrt(stats.chi2.median(freedom) / freedom))


def frame_from_phase(
    phase: ArrayLike,
    reference: ArrayLike,
    *,
    frequency: float = FREQUENCY_SINGLE,
    intensity: float = 1.0,
) -> Frame:
    """Scene whose true phase is a given (denoised) one, each pixel in the wrap nearest a reference.

    At this frequency the wraps do not show, so the reference may err by whole ones.

    Parameters
    ----------
    phase : array_like, shape (H, W)
        Wrapped phase, rad.
    reference : array_like, shape (H, W)
        Coarse depth, m.
    frequency : float
        Hz.
    intensity : float
        Brightness assumed everywhere.

    Raises
    ------
    ValueError
        If the shapes differ.
    """
    phase, reference = np.asarray(phase, float), np.asarray(reference, float)
    _check_same(phase, reference, "a reference")
    wraps = consistent_wrap_count(reference, phase, frequency)
    depth = depth_from_wraps(phase, wraps, frequency)
    return Frame(depth, np.full(depth.shape, intensity), name="measured surface")


def _check_same(phase: NDArray, other: NDArray, what: str) -> None:
    if phase.shape != other.shape:
        raise ValueError(
            f"Expected {what} of the phase's shape {phase.shape}, got {other.shape}. Crop one."
        )


def rehearsal_capture(folder: Path, *, seed: int = 0) -> Path:
    """Write a simulated scan in the layout of the published captures; return its phase file.

    A piece of an embedded frame, shrunk to the captures' distances, with photon and electronic
    noise. Its «reference» is the true range blurred and tilted by millimetres, as a coarse stereo
    pair would see it.

    Parameters
    ----------
    folder : Path
        Where ``phase/`` and ``depth/`` are made.
    seed : int
        Of the noise.
    """
    from scipy import ndimage

    from cmtof.scenes.captures import write_capture
    from cmtof.simulation import simulate

    frame = load_frame("still_life")
    view = slice(5, 105), slice(85, 185)
    piece = Frame(frame.depth[view] / 2, frame.intensity[view], name="rehearsal")
    scan = simulate(piece, protocol="full", noise=600.0, seed=seed)
    filled = np.where(np.isfinite(piece.depth), piece.depth, np.nanmax(piece.depth))
    tilt = 0.004 * np.linspace(-1, 1, 100)[:, None]
    return write_capture(scan.phase[0], ndimage.gaussian_filter(filled, 2) + tilt, folder)
