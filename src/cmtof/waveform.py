"""Periodic waveforms as complex Fourier coefficients: what modulators emit and correlators read.

A waveform w(theta) with theta = omega t is held by W_0 ... W_K,
``w(theta) = W_0 + 2 Re sum_{k>=1} W_k exp(i k theta)``: W_0 is its mean, ``2 |W_k|`` the amplitude
of harmonic k. From N uniform samples over one period they are ``fft(w)[k] / N``.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.types import Array

Harmonics = NDArray[np.complex128]


def harmonics_from_waveform(samples: ArrayLike, count: int) -> Harmonics:
    """Fourier coefficients W_0 ... W_count (..., count + 1) of one period of samples (..., N).

    The samples are those at ``theta = 2 pi j / N``; a ValueError unless 0 <= count < N/2.

    >>> theta = 2 * np.pi * np.arange(8) / 8
    >>> np.round(harmonics_from_waveform(3 + np.cos(theta), 2), 12).real.tolist()
    [3.0, 0.5, 0.0]
    """
    w = np.asarray(samples, float)
    highest = w.shape[-1] / 2
    if not 0 <= count < highest:
        raise ValueError(
            f"Expected a highest harmonic from 0 to below N/2 = {highest:g}, got {count}. "
            "Sample the period more finely or ask for fewer harmonics."
        )
    return np.fft.rfft(w, axis=-1)[..., : count + 1] / w.shape[-1]


def waveform_from_harmonics(harmonics: ArrayLike, phase: ArrayLike) -> Array:
    """Waveform at the phases theta, rad, shape (..., *phase.shape), of coefficients (..., K + 1).

    The inverse of `harmonics_from_waveform` for waveforms without harmonics beyond K.
    """
    w = np.asarray(harmonics, np.complex128)
    theta = np.asarray(phase, float)
    rotation = np.exp(1j * np.multiply.outer(np.arange(1, w.shape[-1]), theta))
    mean = w[..., 0].real.reshape(w.shape[:-1] + (1,) * theta.ndim)
    return mean + 2 * np.tensordot(w[..., 1:], rotation, axes=1).real


def sinusoid(dc: float, amplitude: float) -> Harmonics:
    """Coefficients (2,) of ``dc + amplitude cos(theta)``; dc = amplitude is a raised cosine."""
    return np.array([dc, amplitude / 2], np.complex128)


def gate(count: int) -> Harmonics:
    """Coefficients (count + 1,) of the 0/1 square wave that is 1 where cos(theta) > 0.

    ``W_k = sin(k pi/2) / (k pi)``: a pixel bucket that is open for half a period. Against a raised
    cosine it gives the 1/2 + cos/pi of Eq. 8.
    """
    return (0.5 * np.sinc(np.arange(count + 1) / 2)).astype(np.complex128)


def low_pass_harmonics(
    harmonics: ArrayLike,
    *,
    frequency: float,
    cutoff: float,
) -> Harmonics:
    """Coefficients (..., K + 1) after a first-order low pass, ``W_k / (1 + i k f / f_c)``.

    A photodiode of -3 dB bandwidth ``cutoff``, Hz, that watches a waveform of fundamental
    ``frequency``, Hz: harmonics lose amplitude and lag behind.
    """
    w = np.asarray(harmonics, np.complex128)
    return w / (1 + 1j * np.arange(w.shape[-1]) * frequency / cutoff)
