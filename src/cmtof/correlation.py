"""Correlation <-> phase and amplitude <-> depth and wrap count.

The chain of Sections 3 and 5.4, forward and inverse side by side. One convention holds everywhere:
``C_psi = offset + amplitude * cos(phi + psi)`` with ``phi = 4 pi f z / c >= 0``, so the correlation
peaks at ``psi = -phi``. Wrapped phases lie in [0, 2 pi).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.types import Array, Numbers
from cmtof.waveform import Harmonics, waveform_from_harmonics

TAU = 2 * np.pi


# --- light -> correlation ----------------------------------------------------------------------


def correlation_from_harmonics(
    emitted: Harmonics,
    reference: Harmonics,
    *,
    phase: ArrayLike,
    psi: ArrayLike,
) -> Array:
    r"""Correlate two periodic waveforms given by their Fourier coefficients (Eq. 1-4, Sec. 3).

    .. math:: C = \frac{1}{T}\int \tilde p(t-\tau)\, r(t)\,dt
              = P_0 R_0 + 2\,\mathrm{Re}\sum_{k\ge1} P_k R_k^*\, e^{-ik(\phi+\psi)}

    Coefficients (K + 1,) of p and r are complex, ``w = W_0 + 2 Re sum_k W_k exp(i k theta)``; the
    phase of the round trip and psi, rad, broadcast.

    The paper's sinusoids, p = cos + 1 and r = cos + 1/2, give cos(phi + psi) / 2 + 1/2:

    >>> float(correlation_from_harmonics([1, 0.5], [0.5, 0.5], phase=0.3, psi=-0.3))
    1.0
    """
    count = min(np.size(emitted), np.size(reference))
    return waveform_from_harmonics(
        np.conj(emitted[:count]) * reference[:count], np.add(phase, psi)
    )


def correlation_from_phase(
    phase: ArrayLike,
    psi: ArrayLike,
    *,
    amplitude: ArrayLike = 1.0,
    offset: ArrayLike = 0.0,
) -> Array:
    """Sinusoidal correlation ``offset + amplitude cos(phi + psi)`` (Eq. 4, 8 and 20), (K, ...).

    ``phase`` (...) and ``psi`` (K,) in rad, ``amplitude`` and ``offset`` (...) in counts.
    """
    phase = np.asarray(phase) + 0.0  # integers become floats
    psi = np.asarray(psi)
    steps = psi.reshape((-1,) + (1,) * phase.ndim).astype(phase.dtype, copy=False)
    return np.asarray(offset) + np.asarray(amplitude) * np.cos(phase + steps)


def correlation_contrast(emitted: ArrayLike, reference: ArrayLike) -> float:
    """Amplitude of the correlation's fundamental over its mean, ``2 |P_1 R_1| / (P_0 R_0)``.

    Two raised cosines give 1/2; a 0/1 gate against a raised cosine, Eq. 8's multi-bucket pixel,
    gives 2/pi.

    >>> correlation_contrast([0.5, 0.25], [0.5, 0.25])
    0.5
    """
    p = np.asarray(emitted, complex)
    r = np.asarray(reference, complex)
    return float(2 * abs(p[1] * r[1]) / abs(p[0] * r[0]))


# --- correlation -> phase ----------------------------------------------------------------------


class Decoded(NamedTuple):
    """Phase, amplitude and offset of ``C = offset + amplitude cos(phase + psi)``."""

    # Wrapped phase in [0, 2 pi), rad.
    phase: Array
    # Coefficient of the cosine, counts.
    amplitude: Array
    # Mean, counts.
    offset: Array


def decoding_weights(psi: ArrayLike) -> Array:
    """Least-squares weights of (offset, in-phase, quadrature) for any set of reference phases.

    ``C = d + x cos(psi) - y sin(psi)`` with ``x + i y = a exp(i phi)``: weights (3, K) of phases
    ``psi`` (K,), rad, three or more in any order. Raises the ValueError of `check_psi`.
    """
    psi = np.asarray(psi, float)
    check_psi(psi)
    design = np.stack([np.ones_like(psi), np.cos(psi), -np.sin(psi)], axis=1)
    return np.linalg.pinv(design)


def check_psi(psi: Array) -> None:
    """Raise a ValueError unless ``psi`` (K,) can be decoded: 3 or more, finite, distinct."""
    if psi.ndim != 1 or psi.size < 3:
        raise ValueError(
            f"Expected at least 3 reference phases psi in one dimension, got shape {psi.shape}. "
            "Record more steps or check psi."
        )
    if not np.isfinite(psi).all():
        raise ValueError(
            "Expected finite reference phases psi, got NaN or inf. State every psi."
        )
    phasors = np.exp(1j * psi)
    gaps = np.abs(phasors[:, None] - phasors[None, :])[np.triu_indices(psi.size, 1)]
    if gaps.min() < 1e-6:
        raise ValueError(
            "Expected distinct reference phases psi modulo 2 pi, "
            f"got duplicates in {psi.round(6).tolist()}. Average repeated steps or correct psi."
        )


def decode(correlation: ArrayLike, psi: ArrayLike) -> Decoded:
    """Fit phase, amplitude and offset to correlations at known phases psi (Eq. 9, Sec. 5.4).

    For four sorted uniform steps this is Eq. 9 with the first Fourier bin (the paper's F_2 is
    the Nyquist bin, see the errata).

    Correlations (K, ...), not of four axes, or (F, K, H, W), counts; ``psi`` (K,) or (F, K), rad.
    float32 stays float32, with a phase error below 5e-6 rad up to an offset of 40 amplitudes;
    anything else is computed in float64. Where a correlation is NaN, the phase is 0 and the others
    NaN. Raises a ValueError if shapes disagree or psi cannot be decoded.

    >>> psi = np.array([0.0, 1.0, 2.5, 4.0, 5.0])
    >>> c = correlation_from_phase(np.array([0.5, 3.0]), psi, amplitude=2.0, offset=7.0)
    >>> phase, amplitude, offset = decode(c, psi)
    >>> np.round(phase, 6).tolist(), np.round(amplitude, 6).tolist()
    ([0.5, 3.0], [2.0, 2.0])
    """
    correlation = np.asarray(correlation)
    psi = np.asarray(psi, float)
    if psi.ndim == 1 and correlation.ndim == 4:
        psi = np.broadcast_to(psi, (len(correlation), psi.size))
    if psi.ndim not in (1, 2) or correlation.shape[: psi.ndim] != psi.shape:
        raise ValueError(
            f"Expected correlation whose first axes match psi {psi.shape}, "
            f"got {correlation.shape}. Put the steps first: (K, ...) or (F, K, ...)."
        )
    if psi.ndim == 1:
        return Decoded(*(field[0] for field in decode(correlation[None], psi[None])))
    if correlation.dtype != np.float32:
        correlation = correlation.astype(float, copy=False)
    weights = np.array([decoding_weights(steps) for steps in psi], correlation.dtype)
    fitted = weights @ correlation.reshape(*psi.shape, -1)  # (F, 3, pixels)
    fitted = fitted.reshape(len(psi), 3, *correlation.shape[2:])
    offset, x, y = fitted.swapaxes(0, 1)
    phase = np.arctan2(y, x)
    phase = np.where(phase < 0, phase + TAU, phase)  # np.mod takes thrice the time
    # false for NaN, and rounding may have made it TAU
    return Decoded(np.where(phase < TAU, phase, 0), np.hypot(x, y), offset)


def phase_from_correlation(correlation: ArrayLike, psi: ArrayLike) -> Array:
    """Wrapped phase in [0, 2 pi), rad, of correlations at their reference phases (Eq. 9).

    See `decode` for shapes, precision and errors.
    """
    return decode(correlation, psi).phase


def residual_noise(correlation: ArrayLike, psi: ArrayLike) -> float:
    """Standard deviation of one correlation's noise, counts, from residuals of fitted cosines.

    The median absolute residual of all pixels, scaled to a Gaussian: a typical pixel's noise.
    Correlations (K, ...) of many pixels at more than three phases ``psi`` (K,), rad: three are
    fitted exactly. Raises ValueError with fewer.
    """
    psi = np.asarray(psi, float)
    if psi.size <= 3:
        raise ValueError(
            f"Expected more than 3 reference phases to estimate the noise, got {psi.size}. "
            "Record more steps."
        )
    fit = np.stack([np.ones_like(psi), np.cos(psi), np.sin(psi)])
    residual_basis = np.linalg.svd(fit)[2][
        3:
    ]  # orthonormal directions that the fit does not reach
    images = np.asarray(correlation).reshape(psi.size, -1)
    images = images[:, :: max(1, images.shape[1] // 65536)]  # a sample suffices
    images = images + np.float32(0)  # integers become floats
    return float(
        1.4826 * np.median(np.abs(residual_basis.astype(images.dtype) @ images))
    )


# --- phase <-> depth and wraps -----------------------------------------------------------------


def wrapped(phase: ArrayLike) -> Array:
    """Phase modulo 2 pi in [0, 2 pi), rad; never 2 pi itself, whatever the rounding."""
    result = np.mod(phase, TAU)
    return np.where(result >= TAU, 0.0, result).astype(result.dtype, copy=False)


def centred(phase: ArrayLike) -> Array:
    """Phase modulo 2 pi in [-pi, pi), rad, for differences of phases."""
    return wrapped(np.asarray(phase) + np.pi) - np.pi


def wrap_length(frequency: ArrayLike) -> Array:
    """Depth of one phase wrap, ``c / 2f``, m (20.96 mm at 7.15 GHz)."""
    return SPEED_OF_LIGHT / (2 * np.asarray(frequency, float))


def phase_from_depth(depth: ArrayLike, frequency: ArrayLike) -> Array:
    """Unwrapped phase ``4 pi f z / c``, rad, of range z, m (Sec. 5.3)."""
    return TAU / wrap_length(frequency) * np.asarray(depth)


def depth_from_phase(phase: ArrayLike, frequency: ArrayLike) -> Array:
    """Range ``c phi / 4 pi f``, m, of an unwrapped phase, rad (Sec. 3)."""
    return np.asarray(phase) * (wrap_length(frequency) / TAU)


def wrap_count_from_depth(depth: ArrayLike, frequency: ArrayLike) -> Numbers:
    """The paper's wrap count ``floor(2 f z / c)`` of finite depths, m."""
    return np.floor(np.asarray(depth) / wrap_length(frequency)).astype(np.int64)


def consistent_wrap_count(
    depth: ArrayLike, phase: ArrayLike, frequency: ArrayLike
) -> Numbers:
    """Wraps that bring a measured wrapped phase nearest to a depth: ``round(2fz/c - phi/2pi)``.

    Next to a wrap boundary noise moves the phase across it, and this count differs from
    `wrap_count_from_depth` by one though both describe the same surface.
    """
    turns = np.asarray(depth) / wrap_length(frequency) - np.asarray(phase) / TAU
    return np.rint(turns).astype(np.int64)


def depth_from_wraps(phase: ArrayLike, wraps: ArrayLike, frequency: ArrayLike) -> Array:
    """Range of a wrapped phase with its consistent wraps, ``(phi + 2 pi n) c / 4 pi f``, m."""
    return (np.asarray(phase) / TAU + np.asarray(wraps)) * wrap_length(frequency)
