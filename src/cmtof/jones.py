r"""Jones vectors and matrices of the polarising elements (Sec. 6.1), batched over any parameter.

A Jones vector (..., 2) holds the complex amplitudes [horizontal, vertical]; a Jones matrix
(..., 2, 2) takes one to the next. Angles are in radians, measured from the horizontal as the light
sees it when it travels forward; every parameter broadcasts against the others and its shape leads
that of the result. A retarder delays its slow axis by :math:`e^{-i\Gamma/2}` and advances the other
by :math:`e^{i\Gamma/2}`, the sign of Eq. 10 for fields that vary as :math:`e^{+i\omega t}`. After a
`mirror` the light looks at the elements from behind: use their angles with the opposite sign, as
Eq. 14 does.

Source: R. C. Jones, J. Opt. Soc. Am. 31, 488 (1941); A. Yariv and P. Yeh, Photonics (2007), ch. 1.
"""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.types import Array

JonesMatrix = NDArray[np.complex128]
JonesVector = NDArray[np.complex128]
Port = Literal["transmitted", "reflected"]


def linear_polarisation(angle: ArrayLike = 0.0) -> JonesVector:
    """Unit vector (..., 2) polarised along ``angle``, rad: 0 horizontal, pi/2 vertical (Eq. 11)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1).astype(np.complex128)


def intensity(field: ArrayLike) -> Array:
    """Intensity ``|E_h|^2 + |E_v|^2`` (...) of Jones vectors (..., 2) (Eq. 15)."""
    e = np.asarray(field, np.complex128)
    return (e.real**2 + e.imag**2).sum(axis=-1)


def _matrix(hh: NDArray, hv: NDArray, vh: NDArray, vv: NDArray) -> JonesMatrix:
    """Matrices (..., 2, 2) of entries (...) of one shape."""
    entries = np.stack([hh, hv, vh, vv], axis=-1).astype(np.complex128)
    return entries.reshape(*entries.shape[:-1], 2, 2)


def _diattenuator(along: Array, across: Array) -> JonesMatrix:
    """Jones matrix of amplitude transmissions along the horizontal and the vertical."""
    none = np.zeros_like(along)
    return _matrix(along, none, none, across)


def retarder(retardance: ArrayLike, angle: ArrayLike = 0.0) -> JonesMatrix:
    r"""Linear retarder, :math:`R(\theta)\,\mathrm{diag}(e^{-i\Gamma/2}, e^{i\Gamma/2})R(-\theta)`.

    ``retardance`` is the phase difference Gamma between the axes and ``angle`` the direction theta
    of the slow axis, rad; the matrix has the shape (..., 2, 2). A half-wave plate H(theta) has the
    retardance pi, a quarter-wave plate Q(theta) pi/2.

    A half-wave plate at 22.5 degrees turns horizontal into 45 degrees:

    >>> e = apply(retarder(np.pi, np.pi / 8), linear_polarisation(0.0))
    >>> np.allclose(np.abs(e), np.sqrt(0.5))
    True
    """
    half = np.divide(retardance, 2)
    double = np.multiply(2, angle)
    c = np.cos(half)
    s = np.sin(half)
    along = 1j * s * np.cos(double)
    across = -1j * s * np.sin(double)
    return _matrix(c - along, across, across, c + along)


def eom(
    voltage: ArrayLike,
    *,
    static_retardance: ArrayLike = 0.0,
    angle_error: ArrayLike = 0.0,
) -> JonesMatrix:
    """Electro-optic modulator B(V) = diag(exp(-iV/2), exp(iV/2)) (Eq. 10).

    ``voltage`` is the drive V as the retardance of one pass, ``static_retardance`` that of the
    undriven crystal and ``angle_error`` the angle of its axis off the horizontal, all rad.
    """
    return retarder(np.add(voltage, static_retardance), angle_error)


def mirror(reflectance: ArrayLike = 1.0) -> JonesMatrix:
    """Mirror at normal incidence M = sqrt(R) diag(1, -1), R the reflected intensity (Eq. 13).

    The minus keeps the frame right-handed when the light turns round. Raises ValueError for R
    outside 0 to 1.
    """
    r = np.asarray(reflectance, float)
    if not np.all((r >= 0) & (r <= 1)):
        raise ValueError(
            f"Expected a reflectance from 0 to 1, got {reflectance}. Give a fraction."
        )
    return _diattenuator(np.sqrt(r), -np.sqrt(r))


def _inverse_extinction(extinction_ratio: ArrayLike, name: str) -> Array:
    ratio = np.asarray(extinction_ratio, float)
    if not np.all(ratio > 1):
        raise ValueError(
            f"Expected {name} above 1, got {extinction_ratio}. "
            "Give wanted over unwanted intensity, numpy.inf for an ideal element."
        )
    return 1 / ratio


def polarising_beam_splitter(
    port: Port,
    *,
    transmitted_extinction: ArrayLike = np.inf,
    reflected_extinction: ArrayLike = np.inf,
) -> JonesMatrix:
    """Polarising beam splitter, from the input to one of its two ports.

    The transmitted port carries the horizontal, the reflected one the vertical. The splitter loses
    nothing: with ``a`` and ``b`` the inverse extinction ratios of the transmitted and reflected
    port, T_h = (1 - b)/(1 - ab), T_v = a T_h, and the rest is reflected.

    Cubes reach extinction ratios of 1000 and more in transmission, but only 20 to 100 in
    reflection. Raises ValueError for another port or a ratio of 1 or less.
    """
    a = _inverse_extinction(
        transmitted_extinction, "the transmitted port's extinction ratio"
    )
    b = _inverse_extinction(
        reflected_extinction, "the reflected port's extinction ratio"
    )
    horizontal = (1 - b) / (1 - a * b)
    vertical = a * horizontal
    if port == "reflected":
        horizontal = 1 - horizontal
        vertical = 1 - vertical
    elif port != "transmitted":
        raise ValueError(
            f"Expected port 'transmitted' or 'reflected', got {port!r}. Choose one."
        )
    return _diattenuator(np.sqrt(horizontal), np.sqrt(vertical))


def apply(element: JonesMatrix, field: ArrayLike) -> JonesVector:
    """Jones vectors (..., 2) behind an element (..., 2, 2), of fields (..., 2) before it."""
    return (element @ np.asarray(field, np.complex128)[..., None])[..., 0]
