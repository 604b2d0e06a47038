"""Inputs of a network, made from a measurement (Fig. 5, Eq. 5).

Sines and cosines of whole multiples do not change where a wrapped phase jumps, and differences of
neighbours are wrapped again. NumPy arrays and torch tensors alike, so that training computes its
inputs on the device it runs on.
"""

import sys
from typing import Any

import numpy as np

from cmtof.correlation import TAU

Array = Any
"""A NumPy array or a torch tensor; the result is of the same kind."""

ORDER = 5
"""E_C of Eq. 5. The paper does not state it; the authors' released code ends at 5."""

FEATURE_SETS: dict[str, tuple[str, ...]] = {
    "phase": ("phase", "amplitude"),
    "fourier": ("phase", "fourier", "amplitude"),
    "proposed": ("phase", "fourier", "edges", "amplitude"),
    "beat": ("phase", "fourier", "edges", "amplitude", "beat"),
    "correlation": ("correlation",),
}
"""Inputs by name: the rows of Table 1, those with the beat besides, and raw correlations."""

CHANNELS = {"phase": 1, "fourier": 12, "edges": 4, "amplitude": 1, "beat": 1, "correlation": 4}
"""Channels of each kind at each of the two frequencies."""

TYPICAL_LOG_AMPLITUDE = 7.5, 0.8
"""Centre and spread of log amplitudes at the paper's gain."""

FULL_AMPLITUDE = 20 * 1000 / np.pi
"""Amplitude of a white surface at the paper's gain and integration time, G T / pi, counts."""


def channels(name: str) -> int:
    """Number of channels of a set of features.

    Examples
    --------
    >>> [channels(name) for name in FEATURE_SETS]
    [4, 28, 36, 38, 8]
    """
    return 2 * sum(CHANNELS[kind] for kind in FEATURE_SETS[name])


def features(
    phase: Array, amplitude: Array, name: str = "proposed", correlation: Array = None
) -> Array:
    """All inputs of a network, by the name of their set (Table 1, Fig. 5).

    Parameters
    ----------
    phase, amplitude : array or tensor, shape (..., 2, H, W)
        Wrapped phases, rad, and coefficients of the cosine, counts.
    name : str
        Out of `FEATURE_SETS`.
    correlation : array or tensor, shape (..., 2, 4, H, W), optional
        Images at the quadratures 0, 1/2, 1 and 3/2 pi, counts.

    Returns
    -------
    array or tensor, shape (..., C, H, W)
        Kind by kind, within a kind frequency by frequency.

    Raises
    ------
    ValueError
        For an unknown name, or without the correlations that the set needs.

    Examples
    --------
    >>> phase = np.zeros((2, 8, 8), np.float32)
    >>> features(phase, phase).shape
    (36, 8, 8)
    """
    if name not in FEATURE_SETS:
        raise ValueError(
            f"Expected features out of {', '.join(FEATURE_SETS)}, got {name}. Choose one."
        )
    if correlation is None and name == "correlation":
        raise ValueError(
            "Expected raw correlations, which this network reads, got phases alone. Keep them in "
            "the measurement, or choose another method."
        )
    centre, spread = TYPICAL_LOG_AMPLITUDE
    made = {
        "phase": lambda: phase / TAU,
        "fourier": lambda: _merged(fourier_features(phase)),
        "edges": lambda: _merged(phase_edges(phase)),
        "amplitude": lambda: (log_amplitude(amplitude) - centre) / spread,
        "beat": lambda: _beat(phase, amplitude),
        "correlation": lambda: _merged(_scaled(correlation, amplitude)),
    }
    return _namespace(phase).concatenate([made[kind]() for kind in FEATURE_SETS[name]], -3)


def fourier_features(phase: Array, order: int = ORDER) -> Array:
    r"""Fourier features of a wrapped phase (Eq. 5).

    .. math:: \gamma(\hat\varphi) = [\cos 2^0\hat\varphi, \sin 2^0\hat\varphi, \ldots,
              \cos 2^{E_C}\hat\varphi, \sin 2^{E_C}\hat\varphi]

    Each octave is the square of the phasor below it: three products instead of two functions.
    Phases (..., H, W), rad, become (..., 2 (order + 1), H, W).

    Examples
    --------
    >>> fourier_features(np.array([[np.pi / 2]]), order=1).ravel().round(6).tolist()
    [0.0, 1.0, -1.0, 0.0]
    """
    xp = _namespace(phase)
    cosine, sine = xp.cos(phase), xp.sin(phase)
    pairs = [cosine, sine]
    for _ in range(order):
        cosine, sine = (cosine - sine) * (cosine + sine), 2 * cosine * sine
        pairs += [cosine, sine]
    return xp.stack(pairs, -3)


def phase_edges(phase: Array) -> Array:
    """Wrapped differences of a wrapped phase along four directions (Sec. 8.1, Fig. 5).

    Pixel minus its neighbour to the left, above, above left and below left, wrapped to [-pi, pi];
    zero where the neighbour lies outside the image. Phases (..., H, W), rad, become
    (..., 4, H, W), rad.

    Examples
    --------
    A ramp that wraps between its third and fourth pixel:

    >>> phase_edges(np.array([[4.0, 5.0, 6.0, 7.0 - TAU]]))[0].round(6).tolist()
    [[0.0, 1.0, 1.0, 1.0]]
    """
    xp = _namespace(phase)
    edges = xp.stack([xp.zeros_like(phase)] * 4, -3)
    left, above, falling, rising = (edges[..., k, :, :] for k in range(4))
    left[..., 1:] = phase[..., 1:] - phase[..., :-1]
    above[..., 1:, :] = phase[..., 1:, :] - phase[..., :-1, :]
    falling[..., 1:, 1:] = phase[..., 1:, 1:] - phase[..., :-1, :-1]
    rising[..., :-1, 1:] = phase[..., :-1, 1:] - phase[..., 1:, :-1]
    return edges - TAU * xp.round(edges / TAU)


def log_amplitude(amplitude: Array) -> Array:
    """Logarithm ``ln(1 + a)`` of an amplitude in counts: bright and dark surfaces on one scale.

    Examples
    --------
    >>> log_amplitude(np.array([0.0, np.e - 1])).tolist()
    [0.0, 1.0]
    """
    return _namespace(amplitude).log1p(amplitude)


def _beat(phase: Array, amplitude: Array) -> Array:
    """Cosine and sine of ``phi_2 - 2 phi_1``, weighted by the mean amplitude; no row of Table 1."""
    xp = _namespace(phase)
    beat = phase[..., 1, :, :] - 2 * phase[..., 0, :, :]
    weight = xp.sqrt(amplitude[..., 0, :, :] * amplitude[..., 1, :, :]) / FULL_AMPLITUDE
    return xp.stack([weight * xp.cos(beat), weight * xp.sin(beat)], -3)


def _scaled(correlation: Array, amplitude: Array) -> Array:
    """Correlations (..., F, 4, H, W) over the amplitude (Su et al. 2018), dark ones less."""
    scale = _namespace(correlation).sqrt(amplitude * amplitude + (FULL_AMPLITUDE / 20) ** 2)
    return correlation / scale[..., None, :, :]


def _merged(values: Array) -> Array:
    """Frequencies' channels behind each other: (..., F, C, H, W) -> (..., F C, H, W)."""
    return values.reshape(*values.shape[:-4], -1, *values.shape[-2:])


def _namespace(array: Array) -> Any:
    """NumPy, or torch for a tensor: they share the names used here."""
    return sys.modules["torch"] if type(array).__module__.startswith("torch") else np
