"""Fringes: reading their phase by steps, counting them by sequential unwrapping, losing them.

A target that recedes by half a wavelength moves the pattern by one fringe, ``phi = 4 pi z /
lambda``. Phases are known modulo a fringe; what lies between two readings has to be guessed.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr

Array = NDArray[np.float64]
Phasor = NDArray[np.complex128]

# --- range <-> phase -----------------------------------------------------------------------------


def fringe_phase(distance: ArrayLike, wavelength: float) -> Array:
    """Phase of the fringes ``4 pi z / lambda``, rad, of a range z, m; the wavelength in air."""
    return 4 * np.pi / wavelength * np.asarray(distance, float)


def fringe_range(phase: ArrayLike, wavelength: float) -> Array:
    """Range ``lambda phi / 4 pi``, m, of an unwrapped phase, rad."""
    return wavelength / (4 * np.pi) * np.asarray(phase, float)


# --- one reading ---------------------------------------------------------------------------------


def step_response(psi: ArrayLike, error: ArrayLike) -> tuple[Phasor, Phasor]:
    r"""What steps with a scale error make of a fringe: gains of the phasor and of its mirror image.

    Steps go to ``(1 + e) psi_k``, the reduction takes them at ``psi_k``. For uniform steps

    .. math:: \frac2K\sum_k I_k e^{-i\psi_k} = a\,(g_+ e^{i\phi} + g_- e^{-i\phi}),\quad
              g_+ = \langle e^{ie\psi_k}\rangle,\ g_- = \langle e^{-i(2+e)\psi_k}\rangle

    exactly; the second one is the cyclic error of two periods a fringe.

    Parameters
    ----------
    psi : array_like, shape (K,)
        Nominal steps, uniform over a turn, rad.
    error : array_like, shape (...)
        Relative error of the travel.

    Returns
    -------
    g_plus, g_minus : ndarray, shape (...)

    Examples
    --------
    >>> plus, minus = step_response(2 * np.pi * np.arange(8) / 8, 0.0)
    >>> print(f"{abs(plus):.3f} {abs(minus):.3f}")
    1.000 0.000
    """
    steps, scale = np.asarray(psi, float), np.asarray(error, float)[..., None]
    return np.exp(1j * scale * steps).mean(-1), np.exp(-1j * (2 + scale) * steps).mean(-1)


# --- counting ------------------------------------------------------------------------------------


def apparent_step(step: ArrayLike, wavelength: float) -> Array:
    """Step that sequential unwrapping sees, m: the equivalent one nearest to zero.

    Equal to ``step`` below a quarter of the wavelength; beyond, whole half wavelengths are lost.

    Examples
    --------
    >>> seen = apparent_step([132e-9, 134e-9, 50e-6], 532e-9)
    >>> [f"{s * 1e9:.0f} nm" for s in seen]
    ['132 nm', '-132 nm', '-8 nm']
    """
    half = wavelength / 2
    step = np.asarray(step, float)
    return step - half * np.rint(step / half)


def lost_fringes(step: ArrayLike, spread: ArrayLike, wavelength: float) -> Array:
    r"""Mean number of fringes that one reading loses, in the direction of the move.

    The path changes by the step s and by something Gaussian with the standard deviation
    :math:`\sigma`; a change beyond an odd multiple of :math:`\lambda/4` costs one more fringe:

    .. math:: \langle m\rangle = \sum_{k\ge1} Q\!\left(\frac{(2k-1)\lambda/4 - s}{\sigma}\right)
              - Q\!\left(\frac{(2k-1)\lambda/4 + s}{\sigma}\right)

    Means add, so a move of N readings loses N times that, however the changes correlate.

    Parameters
    ----------
    step, spread : array_like, shape (...)
        m; ``spread`` of the difference between successive readings, above 0.
    wavelength : float
        m.
    """
    s, sigma = np.broadcast_arrays(np.asarray(step, float), np.asarray(spread, float))
    total = np.zeros(s.shape)
    reach = float(np.max(np.abs(s) + 9 * sigma, initial=0.0))
    for odd in range(1, int(4 * reach / wavelength) + 3, 2):
        edge = odd * wavelength / 4
        total += ndtr((s - edge) / sigma) - ndtr((-s - edge) / sigma)
    return total


def slip_rate(step: ArrayLike, spread: ArrayLike, wavelength: float) -> Array:
    """Odds that one reading slips, either way: ``P(|s + sigma x| > lambda / 4)``.

    Parameters and shapes as in `lost_fringes`.
    """
    s, sigma, edge = np.asarray(step, float), np.asarray(spread, float), wavelength / 4
    return ndtr((s - edge) / sigma) + ndtr((-s - edge) / sigma)
