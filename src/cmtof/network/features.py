"""What a network is given of a measurement (Fig. 5): features that no wrap can be seen in.

A wrapped phase jumps by a whole turn where nothing in the scene does. Sines and cosines of it do
not, nor do differences that are wrapped again; the logarithm brings amplitudes of bright and dark
surfaces to one scale. Arrays of NumPy and tensors of torch alike, so that training can make its
inputs on the device that it runs on.
"""

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from cmtof.correlation import TAU

Array = Any
"""A NumPy array, or a torch tensor; what goes in comes out."""

ORDER = 5
"""E_C of Eq. 5, which the paper does not state; the authors' released code ends at 5."""

FEATURE_SETS: dict[str, tuple[str, ...]] = {
    "phase": ("phase", "amplitude"),
    "fourier": ("phase", "fourier", "amplitude"),
    "proposed": ("phase", "fourier", "edges", "amplitude"),
    "released": ("phase", "fourier"),
    "beat": ("phase", "fourier", "edges", "amplitude", "beat"),
    "correlation": ("correlation",),
}
"""Inputs by name: the rows of Table 1, the authors' released code, those of Table 1 with the beat
besides, which no row of the paper has, and raw correlations at four quadratures."""

CHANNELS = {
    "phase": 1,
    "fourier": 2 * (ORDER + 1),
    "edges": 4,
    "amplitude": 1,
    "beat": 1,
    "correlation": 4,
}
"""Channels of each kind at each of the two frequencies."""

TYPICAL_LOG_AMPLITUDE = 7.5, 0.8
"""Centre and spread of log amplitudes at the paper's gain, taken off before a network sees them."""

FULL_AMPLITUDE = 20 * 1000 / np.pi
"""Amplitude of a white surface at the paper's gain and time, G T / pi, counts."""

DARK_AMPLITUDE = FULL_AMPLITUDE / 20
"""Amplitude below which correlations are no longer scaled up, counts."""


def channels(name: str, frequencies: int = 2) -> int:
    """Count the channels of a set of features; raise a ValueError for an unknown name.

    Examples
    --------
    >>> [channels(name) for name in FEATURE_SETS]
    [4, 28, 36, 26, 38, 8]
    """
    return frequencies * sum(CHANNELS[kind] for kind in _kinds(name))


def needs_correlation(name: str) -> bool:
    """Whether a set of features is made of raw correlations."""
    return "correlation" in _kinds(name)


def features(
    phase: Array, amplitude: Array, name: str = "proposed", correlation: Array = None
) -> Array:
    """All inputs of a network, by the name of their set (Table 1, Fig. 5).

    Parameters
    ----------
    phase : array or tensor, shape (..., F, H, W)
        Wrapped phases, rad.
    amplitude : array or tensor, shape (..., F, H, W)
        Measured coefficients of the cosine, counts.
    name : str
        Out of `FEATURE_SETS`.
    correlation : array or tensor, shape (..., F, 4, H, W), optional
        Images at the quadratures 0, 1/2, 1 and 3/2 pi, counts, for the set that is made of them.

    Returns
    -------
    array or tensor, shape (..., C, H, W)
        Kind by kind, within a kind frequency by frequency; `channels` counts them.

    Raises
    ------
    ValueError
        For an unknown name, or without the correlations that the set is made of.

    Examples
    --------
    >>> phase = np.zeros((2, 8, 8), np.float32)
    >>> features(phase, phase, "released").shape
    (26, 8, 8)
    """
    if correlation is None and needs_correlation(name):
        raise ValueError(
            f"Expected raw correlations for the features {name}, got none. Pass them, or choose "
            "another model."
        )
    centre, spread = TYPICAL_LOG_AMPLITUDE
    made = {
        "phase": lambda: phase / TAU,
        "fourier": lambda: _merged(fourier_features(phase)),
        "edges": lambda: _merged(phase_edges(phase)),
        "amplitude": lambda: (log_amplitude(amplitude) - centre) / spread,
        "beat": lambda: beat_features(phase, amplitude),
        "correlation": lambda: _merged(scaled_correlation(correlation, amplitude)),
    }
    return _namespace(phase).concatenate([made[kind]() for kind in _kinds(name)], -3)


def fourier_features(phase: Array, order: int = ORDER) -> Array:
    r"""Fourier features of a wrapped phase (Eq. 5, Sec. 5.1).

    .. math:: \gamma(\hat\varphi) = [\cos 2^0\hat\varphi, \sin 2^0\hat\varphi, \ldots,
              \cos 2^{E_C}\hat\varphi, \sin 2^{E_C}\hat\varphi]

    Every multiple is whole, so phases a turn apart have the same features. Each octave is the
    square of the one below as a phasor, which costs three products in place of two functions.

    Parameters
    ----------
    phase : array or tensor, shape (..., H, W)
        Wrapped phase, rad.
    order : int
        Highest octave E_C, at least 0.

    Returns
    -------
    array or tensor, shape (..., 2 (order + 1), H, W)
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
    xp = _namespace(phase)
    cosine, sine = xp.cos(phase), xp.sin(phase)
    pairs = [cosine, sine]
    for _ in range(order):
        cosine, sine = (cosine - sine) * (cosine + sine), 2 * cosine * sine
        pairs += [cosine, sine]
    return xp.stack(pairs, -3)


def phase_edges(phase: Array) -> Array:
    """Wrapped differences of a wrapped phase along four directions (Sec. 8.1, Fig. 5).

    Pixel minus its neighbour to the left, above, above left and below left, brought to
    [-pi, pi]: where depth runs on the difference is small, whether or not a wrap lies between.
    A slope beyond half a turn a pixel, 5.2 mm at 7.15 GHz, is folded back like any other phase.

    Parameters
    ----------
    phase : array or tensor, shape (..., H, W)
        Wrapped phase, rad.

    Returns
    -------
    array or tensor, shape (..., 4, H, W)
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
    xp = _namespace(phase)

    def folded(difference: Array) -> Array:
        return difference - TAU * xp.round(difference / TAU)

    edges = xp.stack([xp.zeros_like(phase)] * 4, -3)
    left, above, falling, rising = (edges[..., k, :, :] for k in range(4))
    left[..., 1:] = folded(phase[..., 1:] - phase[..., :-1])
    above[..., 1:, :] = folded(phase[..., 1:, :] - phase[..., :-1, :])
    falling[..., 1:, 1:] = folded(phase[..., 1:, 1:] - phase[..., :-1, :-1])
    rising[..., :-1, 1:] = folded(phase[..., :-1, 1:] - phase[..., 1:, :-1])
    return edges


def log_amplitude(amplitude: Array) -> Array:
    """Logarithm ``ln(1 + a)`` of an amplitude in counts, finite in the dark.

    Parameters
    ----------
    amplitude : array or tensor, shape (..., H, W)
        Coefficient of the cosine, counts, at least 0.

    Raises
    ------
    ValueError
        If the amplitude has no image axes, or, as an array, is negative or not a number somewhere.

    Examples
    --------
    >>> log_amplitude([[0.0, np.e - 1]]).tolist()
    [[0.0, 1.0]]
    """
    amplitude = _images(amplitude, "amplitudes")
    xp = _namespace(amplitude)
    # false for NaN as well; a tensor is not asked, or a GPU would have to be waited for
    if xp is np and amplitude.size and not amplitude.min() >= 0:
        raise ValueError(
            f"Expected amplitudes of 0 counts or more, got {amplitude.min():.4g}. "
            "Take those that decoding gives."
        )
    return xp.log1p(amplitude)


def beat_features(phase: Array, amplitude: Array) -> Array:
    """Cosine and sine of the beat ``phi_2 - 2 phi_1``, times the geometric mean of the amplitudes.

    A network of sums and clips has to build this product from Fourier features; the paper's does.
    Their ratio knows the wrap, and their sums over a surface know it better: what is dark weighs
    little.

    Parameters
    ----------
    phase, amplitude : array or tensor, shape (..., 2, H, W)
        rad and counts.

    Returns
    -------
    array or tensor, shape (..., 2, H, W)
    """
    xp = _namespace(phase)
    beat = phase[..., 1, :, :] - 2 * phase[..., 0, :, :]
    weight = xp.sqrt(amplitude[..., 0, :, :] * amplitude[..., 1, :, :]) / FULL_AMPLITUDE
    return xp.stack([weight * xp.cos(beat), weight * xp.sin(beat)], -3)


def scaled_correlation(correlation: Array, amplitude: Array) -> Array:
    r"""Correlations over the pixel's amplitude (Su et al. 2018): brightness is taken off.

    .. math:: C_k / \sqrt{a^2 + a_0^2}

    with :math:`a_0` a twentieth of a white surface's amplitude, so that the dark stays finite.

    Parameters
    ----------
    correlation : array or tensor, shape (..., F, 4, H, W)
        Counts.
    amplitude : array or tensor, shape (..., F, H, W)
        Counts.
    """
    xp = _namespace(correlation)
    scale = xp.sqrt(amplitude * amplitude + DARK_AMPLITUDE**2)
    return correlation / scale[..., None, :, :]


def _kinds(name: str) -> Sequence[str]:
    if name not in FEATURE_SETS:
        raise ValueError(
            f"Expected features out of {', '.join(FEATURE_SETS)}, got {name}. Choose one."
        )
    return FEATURE_SETS[name]


def _merged(values: Array) -> Array:
    """Put the frequencies' channels behind each other: (..., F, C, H, W) -> (..., F C, H, W)."""
    return values.reshape(*values.shape[:-4], -1, *values.shape[-2:])


def _namespace(array: Array) -> Any:
    """NumPy, or torch for a tensor: they share the names and the order of arguments used here."""
    return sys.modules["torch"] if type(array).__module__.startswith("torch") else np


def _images(values: Array, what: str) -> Array:
    if _namespace(values) is np:
        array = np.asarray(values)
        values = array if array.dtype == np.float32 else array.astype(float)
    if values.ndim < 2:
        raise ValueError(f"Expected {what} (..., H, W), got shape {values.shape}. Keep the image.")
    return values
