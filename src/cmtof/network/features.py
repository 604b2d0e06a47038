"""What a network is given of a measurement (Fig. 5): features that no wrap can be seen in.

A wrapped phase jumps by a whole turn where nothing in the scene does. Sines and cosines of it do
not, nor do differences that are wrapped again; the logarithm brings amplitudes of bright and dark
surfaces to one scale. NumPy only: one's own network may take them too.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.correlation import centred

Array = NDArray[np.floating]

ORDER = 5
"""E_C of Eq. 5, which the paper does not state; the authors' released code ends at 5."""


def fourier_features(phase: ArrayLike, order: int = ORDER) -> Array:
    r"""Fourier features of a wrapped phase (Eq. 5, Sec. 5.1).

    .. math:: \gamma(\hat\varphi) = [\cos 2^0\hat\varphi, \sin 2^0\hat\varphi, \ldots,
              \cos 2^{E_C}\hat\varphi, \sin 2^{E_C}\hat\varphi]

    Every multiple is whole, so phases a turn apart have the same features.

    Parameters
    ----------
    phase : array_like, shape (..., H, W)
        Wrapped phase, rad.
    order : int
        Highest octave E_C, at least 0.

    Returns
    -------
    ndarray, shape (..., 2 (order + 1), H, W)
        In the order of Eq. 5, in the phase's own precision.

    Raises
    ------
    ValueError
        If the phase has no image axes or the order is negative.

    Examples
    --------
    >>> fourier_features([[np.pi / 2]], order=1).ravel().round(6).tolist()
    [0.0, 1.0, -1.0, 0.0]
    """
    phase = _images(phase, "phases")
    if order < 0:
        raise ValueError(f"Expected a highest octave of 0 or more, got {order}. Try {ORDER}.")
    octaves = 2.0 ** np.arange(order + 1)
    angle = phase[..., None, :, :] * octaves.astype(phase.dtype)[:, None, None]
    pairs = np.stack([np.cos(angle), np.sin(angle)], axis=-3)  # (..., octave, 2, H, W)
    return pairs.reshape(*phase.shape[:-2], 2 * (order + 1), *phase.shape[-2:])


def phase_edges(phase: ArrayLike) -> Array:
    """Wrapped differences of a wrapped phase along four directions (Sec. 8.1, Fig. 5).

    Pixel minus its neighbour to the left, above, above left and below left, brought to
    [-pi, pi): where depth runs on the difference is small, whether or not a wrap lies between.
    A slope beyond half a turn a pixel, 5.2 mm at 7.15 GHz, is folded back like any other phase.

    Parameters
    ----------
    phase : array_like, shape (..., H, W)
        Wrapped phase, rad.

    Returns
    -------
    ndarray, shape (..., 4, H, W)
        rad; zero where the neighbour lies beyond the image.

    Raises
    ------
    ValueError
        If the phase has no image axes.

    Examples
    --------
    A ramp that wraps between its third and fourth pixel:

    >>> phase_edges([[4.0, 5.0, 6.0, 7.0 - 2 * np.pi]])[0].round(6).tolist()
    [[0.0, 1.0, 1.0, 1.0]]
    """
    phase = _images(phase, "phases")
    edges = np.zeros((*phase.shape[:-2], 4, *phase.shape[-2:]), phase.dtype)
    left, above, falling, rising = (edges[..., k, :, :] for k in range(4))
    left[..., 1:] = centred(phase[..., 1:] - phase[..., :-1])
    above[..., 1:, :] = centred(phase[..., 1:, :] - phase[..., :-1, :])
    falling[..., 1:, 1:] = centred(phase[..., 1:, 1:] - phase[..., :-1, :-1])
    rising[..., :-1, 1:] = centred(phase[..., :-1, 1:] - phase[..., 1:, :-1])
    return edges


def log_amplitude(amplitude: ArrayLike) -> Array:
    """Logarithm ``ln(1 + a)`` of an amplitude in counts, finite in the dark.

    Parameters
    ----------
    amplitude : array_like, shape (..., H, W)
        Coefficient of the cosine, counts, at least 0.

    Raises
    ------
    ValueError
        If the amplitude has no image axes, or is negative or not a number somewhere.

    Examples
    --------
    >>> log_amplitude([[0.0, np.e - 1]]).tolist()
    [[0.0, 1.0]]
    """
    amplitude = _images(amplitude, "amplitudes")
    if amplitude.size and not amplitude.min() >= 0:  # false for NaN as well
        raise ValueError(
            f"Expected amplitudes of 0 counts or more, got {amplitude.min():.4g}. "
            "Take those that decoding gives."
        )
    return np.log1p(amplitude)


def _images(values: ArrayLike, what: str) -> Array:
    array = np.asarray(values)
    array = array if array.dtype == np.float32 else array.astype(float)
    if array.ndim < 2:
        raise ValueError(f"Expected {what} (..., H, W), got shape {array.shape}. Keep the image.")
    return array
