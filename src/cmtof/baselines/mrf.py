"""A random field over wraps: the beat for each pixel, the phase's steps between neighbours.

Wraps n minimise ``E(n) = sum_p U_p(n_p) + sum_pq min(jump |n_q - n_p - d_pq|, most)``.

The unary cost ``U_p(n) = kappa_p (1 - cos r_p(n))`` is the von Mises law of the beat, where r is
the wrapped remainder that n leaves of it: to second order ``r^2 / 2 sigma^2`` with ``kappa = 1 /
sigma^2`` and ``sigma^2 = (s_2 / a_2)^2 + (k s_1 / a_1)^2`` from noise s and amplitudes a, which is
``5 sigma_phi^2`` for the prototype; it flattens where a dark pixel could know nothing.

``d_pq = round((phi_p - phi_q) / 2 pi)`` lets the wraps follow the phase across its jumps, so that a
smooth surface costs nothing, however steep, up to half a wrap per pixel.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines.beat import synthetic_frequency
from cmtof.baselines.method import Estimate, within_range, wraps_in_range
from cmtof.correlation import TAU, centred, depth_from_wraps, wrapped
from cmtof.measurement import Measurement

JUMP, MOST = 0.03, 0.1
RADIUS, POOLING = 2, 6.0
# The best of 13 settings on six views of validation rooms: delta < 1, 2, 3, >= 10 of 33.1, 70.1,
# 82.8, 1.9 % (released). Jump 6, most 20, radius 1 and pooling 2 gave 10.9, 30.9, 44.1, 21.1: lines
# across a surface know far less than all of its pixels do, so the prior must weigh less.
TEMPERATURE = 0.08
"""Of the softmax: on the same views its mean is 0.36, where 33 % are right."""
_SHARPEST = 1e4
"""Largest kappa: a beat known to 0.01 rad, half of the prototype's wrap, needs no more weight."""
_STRIP_BYTES = 2**28


class Field(NamedTuple):
    """What the random field knows of a measurement."""

    phase: NDArray[np.float32]
    """Smoothed phase of the lower frequency (H, W), rad, which the labels belong to."""
    beat: NDArray[np.float32]
    """kappa (cos, sin) of the beat that the label 0 leaves, (H, W, 2)."""
    angles: NDArray[np.float64]
    """Beat's angle of each label (N,), rad."""
    first: int
    """Wrap of the label 0."""

    def depth(self, labels: NDArray[np.integer], measurement: Measurement) -> NDArray[np.floating]:
        """Depth (H, W), m, of labels (H, W)."""
        wraps = labels + self.first
        depth = depth_from_wraps(self.phase.astype(float), wraps, measurement.frequencies[0])
        return within_range(depth, measurement)


def wrap_field(
    measurement: Measurement, *, radius: int = RADIUS, pooling: float = POOLING
) -> Field:
    """Smooth a measurement's phases and beat, and weigh them by their noise.

    Parameters
    ----------
    measurement : Measurement
        At two frequencies.
    radius : int
        Half side, px, of the square over which the phasors are summed, turned back by the slope.
    pooling : float
        Standard deviation, px, of the Gaussian over which the beat is averaged.

    Raises
    ------
    ValueError
        If a width is negative.
    """
    from cmtof.baselines.mrf_kernels import coherent_sum

    if radius < 0 or pooling < 0:
        raise ValueError(
            f"Expected widths of 0 px or more, got {radius} and {pooling:g}. Try {RADIUS} and "
            f"{POOLING:g}."
        )
    low, high = measurement.frequencies[:2]
    synthetic = synthetic_frequency(low, high)
    phasors = _phasors(measurement)
    slope = _slope(phasors[0], 2 * max(radius, 1) + 1)
    smooth = coherent_sum(phasors, slope, ratio=high / low, radius=radius)
    narrow = coherent_sum(phasors, slope, ratio=high / low, radius=1)
    noise = [_noise(*pair) for pair in zip(phasors, narrow, strict=True)]
    phase = wrapped(np.angle(smooth[0]))
    beat = synthetic.sign * (np.angle(smooth[1]) - synthetic.multiple * phase)
    kappa = _concentration(smooth, noise, synthetic.multiple)
    first, last = wraps_in_range(measurement)
    share = synthetic.frequency / low
    pooled = _pooled(kappa, beat, share * slope, pooling)
    turned = pooled * np.exp(-1j * share * (phase + TAU * first))
    return Field(
        phase.astype(np.float32),
        np.stack([turned.real, turned.imag], axis=-1).astype(np.float32),
        TAU * share * np.arange(last - first + 1),
        first,
    )


def mrf(
    measurement: Measurement,
    *,
    jump: float = JUMP,
    most: float = MOST,
    radius: int = RADIUS,
    pooling: float = POOLING,
    rows: int | None = None,
) -> Estimate:
    """Semi-global matching (Hirschmüller 2008) of the field's wraps along eight directions.

    Each path is a chain whose best costs up to a pixel follow from the pixel before,
    ``L(q, n) = U_q(n) + min_m [L(p, m) + min(jump |n - m - d_pq|, most)] - min_m L(p, m)``;
    the wrap of least cost summed over the paths is taken.

    Parameters
    ----------
    measurement : Measurement
        At two frequencies.
    jump, most : float
        Cost of a step by one wrap that the phase does not tell, and of the largest step.
    radius, pooling
        See `wrap_field`.
    rows : int, optional
        Height of the strips that are in memory at once; it changes no result.
    """
    field = wrap_field(measurement, radius=radius, pooling=pooling)
    labels, odds = semi_global_matching(field, jump=jump, most=most, rows=rows)
    return Estimate(field.depth(labels, measurement), odds)


def semi_global_matching(
    field: Field, *, jump: float = JUMP, most: float = MOST, rows: int | None = None
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Labels (H, W) of a field and how sure they are; see `mrf`.

    Raises
    ------
    ValueError
        Unless ``0 < jump <= most``, and of ``rows`` below 1.
    """
    from cmtof.baselines.mrf_kernels import semi_global_labels

    if not 0 < jump <= most < np.inf:
        raise ValueError(
            f"Expected costs 0 < jump <= most, got {jump:g} and {most:g}. "
            f"Try {JUMP:g} and {MOST:g}."
        )
    height, width = field.phase.shape
    fitting = max(_STRIP_BYTES // (4 * width * field.angles.size), round(height**0.5))
    strip = fitting if rows is None else rows
    if strip < 1:
        raise ValueError(f"Expected strips of 1 row or more, got {strip}. Leave rows out.")
    return semi_global_labels(
        field.beat,
        field.phase,
        field.angles,
        jump=jump,
        most=most,
        temperature=TEMPERATURE,
        rows=min(strip, height),
    )


def _phasors(measurement: Measurement) -> NDArray[np.complex128]:
    """Phasors (2, H, W), counts; zero where nothing is known."""
    phase, amplitude = measurement.phase[:2].astype(float), measurement.amplitude[:2].astype(float)
    known = (np.isfinite(phase) & np.isfinite(amplitude)).all(axis=0)
    return np.where(known, amplitude, 0) * np.exp(1j * np.where(known, phase, 0))


def _slope(phasor: NDArray[np.complex128], window: int) -> NDArray[np.float64]:
    """Slope (2, H, W) down and right, rad/px: angle of the summed products of neighbours."""
    from scipy.ndimage import uniform_filter

    slopes = []
    for axis in (0, 1):
        ahead = np.roll(phasor, -1, axis) * np.conj(phasor)
        ahead[(slice(None),) * axis + (-1,)] = 0  # the last pixel has no neighbour ahead
        products = ahead + np.roll(ahead, 1, axis)  # of both neighbours
        real, imaginary = (uniform_filter(part, window) for part in (products.real, products.imag))
        slopes.append(np.arctan2(imaginary, real))
    return np.stack(slopes)


def _pooled(
    kappa: NDArray[np.float64],
    beat: NDArray[np.float64],
    slope: NDArray[np.float64],
    width: float,
) -> NDArray[np.complex128]:
    """Gaussian mean of ``kappa exp(i beat)``, moved from its weights' centre to the pixel.

    Next to borders and dark surfaces the bright pixels lie to one side, where a slanted surface
    has another beat: by the beat's slope (2, H, W), rad/px, times how far their centre lies off.
    """
    from scipy.ndimage import gaussian_filter

    def mean(image: NDArray[np.float64]) -> NDArray[np.float64]:
        return gaussian_filter(image, width, mode="constant")

    total = np.maximum(mean(kappa), np.finfo(float).tiny)
    place = np.indices(kappa.shape, sparse=True)
    off = sum(s * (mean(kappa * at) / total - at) for s, at in zip(slope, place, strict=True))
    phasor = mean(kappa * np.cos(beat)) + 1j * mean(kappa * np.sin(beat))
    return phasor * np.exp(-1j * off)


def _concentration(
    smooth: NDArray[np.complex128], noise: list[float], multiple: int
) -> NDArray[np.float64]:
    """Kappa of each pixel's beat (H, W): one over its variance, from one pixel's noise.

    Neighbours share what smoothing gained, so each is told a single pixel's variance.
    """
    variance = np.zeros(smooth.shape[1:])
    size = np.abs(smooth)
    for factor, spread, length in zip((multiple, 1), noise, size, strict=True):
        with np.errstate(divide="ignore", invalid="ignore"):
            variance += (factor * spread / length) ** 2
    kappa = 1 / np.maximum(variance, 1 / _SHARPEST)
    return np.where((size > 0).all(axis=0), kappa, 0)


def _noise(phasor: NDArray[np.complex128], mean: NDArray[np.complex128]) -> float:
    """Noise of one phasor across its direction, counts: what smoothing took off, typically."""
    size = np.abs(phasor)
    known = size > 0
    if not known.any():
        return 0.0
    turn = centred(np.angle(phasor[known] * np.conj(mean[known])))
    return float(1.4826 * np.median(size[known] * np.abs(np.sin(turn))))
