"""Noise of a phase map, and less of it: local fits that follow the surface.

A wrapped phase may be neither averaged nor differenced as it stands: its wraps are no steps. Both
functions here first turn every window's phasors back by the local slope of the phase, which the
phasors' own products tell without unwrapping. What is left is flat, far from a wrap, and may be
fitted or summed.
"""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike, NDArray

from cmtof.correlation import wrapped

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
