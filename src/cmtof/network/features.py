"""Inputs of a network as arrays of NumPy or torch (Fig. 5, Eq. 5), and its classes of wraps."""

import sys
from collections.abc import Iterable
from typing import Any

import numpy as np

from cmtof.constants import FREQUENCIES, FREQUENCY_SINGLE, FULL_SIGNAL
from cmtof.correlation import TAU, wrap_length
from cmtof.measurement import unambiguous_range
from cmtof.simulation import RELEASED_WRAPS

Array = Any  # of NumPy or torch; the result is of the same kind

# Depth of a wrap of the lower frequency, m.
WRAP = float(wrap_length(FREQUENCY_SINGLE))

# First wrap that a protocol distinguishes, and how many: 36 and 21, 0 and 358.
CLASSES = {
    "released": (RELEASED_WRAPS[0], RELEASED_WRAPS[1] - RELEASED_WRAPS[0]),
    "full": (0, int(np.ceil(unambiguous_range(FREQUENCIES) / WRAP))),
}

# E_C of Eq. 5. The paper does not state it; the authors' released code ends at 5.
ORDER = 5

# Inputs by name: the rows of Table 1, those with the beat besides, and raw correlations.
FEATURE_SETS = {
    "phase": ("phase", "amplitude"),
    "octaves": ("phase", "fourier"),
    "fourier": ("phase", "fourier", "amplitude"),
    "proposed": ("phase", "fourier", "edges", "amplitude"),
    "beat": ("phase", "fourier", "edges", "amplitude", "beat"),
    "correlation": ("correlation",),
}

# Number of images per frequency of these kinds of input; the others have one.
IMAGES = {"fourier": 2 * (ORDER + 1), "edges": 4, "correlation": 4}

# Where a pixel's neighbours lie: rows above and columns to the left.
NEIGHBOURS = ((0, 1), (1, 0), (1, 1), (-1, 1))

# Amplitude of a white surface, G T / pi, counts.
FULL_AMPLITUDE = FULL_SIGNAL / np.pi


def padding(size: int, stride: int) -> int:
    """Number of pixels to add to a side, so that it is a multiple of a network's stride.

    Two strides at least: in training a batch norm needs more than one value.
    """
    return max(-(-size // stride), 2) * stride - size


def channels(name: str) -> int:
    """Number of input channels of a set of features, a name of `FEATURE_SETS`."""
    return 2 * sum(IMAGES.get(kind, 1) for kind in FEATURE_SETS[name])


def features(
    phase: Array, amplitude: Array, name: str = "proposed", correlation: Array = None
) -> Array:
    """All inputs of a network (..., C, H, W), by the name of their set (Table 1, Fig. 5).

    Wrapped phases, rad, and amplitudes, counts, are (..., 2, H, W), correlations at the quadratures
    0, 1/2, 1 and 3/2 pi (..., 2, 4, H, W).
    """
    if correlation is None and name == "correlation":
        raise ValueError(
            "Expected raw correlations, which this network reads, got phases alone. "
            "Keep the correlations, or choose another method."
        )
    xp = _namespace(phase)

    def beat() -> Iterable[Array]:
        angle = phase[..., 1, :, :] - 2 * phase[..., 0, :, :]
        weight = xp.sqrt(amplitude.prod(-3)) / FULL_AMPLITUDE
        return [xp.stack([weight * xp.cos(angle), weight * xp.sin(angle)], -3)]

    def scaled() -> Iterable[Array]:  # Su et al. 2018; dark ones less
        scale = xp.sqrt(amplitude * amplitude + (FULL_AMPLITUDE / 20) ** 2)
        return xp.moveaxis(correlation, -3, 0) / scale

    builders = {
        "phase": lambda: [phase / TAU],
        "fourier": lambda: _octaves(phase, ORDER),
        "edges": lambda: _edges(phase),
        # as usual at the paper's gain
        "amplitude": lambda: [(xp.log1p(amplitude) - 7.5) / 0.8],
        "beat": beat,
        "correlation": scaled,
    }
    found = xp.empty(
        (*phase.shape[:-3], channels(name), *phase.shape[-2:]),
        dtype=phase.dtype,
        device=phase.device,
    )
    used = 0
    for kind in FEATURE_SETS[name]:
        count = IMAGES.get(kind, 1)
        for k, pair in enumerate(builders[kind]()):
            found[..., used + k : used + 2 * count : count, :, :] = pair
        used += 2 * count
    return found


def fourier_features(phase: Array, order: int = ORDER) -> Array:
    r"""Fourier features (..., 2 (order + 1), H, W) of wrapped phases (..., H, W), rad (Eq. 5).

    They are :math:`\cos 2^k\hat\varphi, \sin 2^k\hat\varphi` for k = 0 to the order. Each octave is
    the square of the phasor below it.
    """
    return _namespace(phase).stack([*_octaves(phase, order)], -3)


def _octaves(phase: Array, order: int) -> Iterable[Array]:
    """Cosine and sine (...), in turn, of phases times 1, 2, 4, ... 2^order."""
    xp = _namespace(phase)
    cosine = xp.cos(phase)
    sine = xp.sin(phase)
    for k in range(order + 1):
        if k:
            cosine, sine = (cosine - sine) * (cosine + sine), 2 * cosine * sine
        yield cosine
        yield sine


def phase_edges(phase: Array) -> Array:
    """Wrapped differences (..., 4, H, W), rad, of wrapped phases (..., H, W) (Sec. 8.1, Fig. 5).

    Pixel minus its neighbour to the left, above, above left and below left, wrapped to [-pi, pi];
    zero where the neighbour lies outside the image.

    >>> phase_edges(np.array([[4.0, 5.0, 6.0, 7.0 - TAU]]))[0].round(6).tolist()
    [[0.0, 1.0, 1.0, 1.0]]
    """
    return _namespace(phase).stack([*_edges(phase)], -3)


def _edges(phase: Array) -> Iterable[Array]:
    """Wrapped differences (..., H, W), rad, to each of `NEIGHBOURS`, one after the other."""
    xp = _namespace(phase)
    for down, right in NEIGHBOURS:
        edge = phase - xp.roll(phase, (down, right), (-2, -1))
        edge -= TAU * xp.round(edge / TAU)
        if down:
            edge[..., min(0, down), :] = 0
        edge[..., :right] = 0
        yield edge


def _namespace(array: Array) -> Any:
    """Module of the array, NumPy or torch, which share the function names used here."""
    return sys.modules["torch"] if type(array).__module__.startswith("torch") else np
