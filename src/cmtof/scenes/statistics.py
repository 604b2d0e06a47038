"""What makes a scene hard to unwrap: brightness, range, slope, jumps, and size of its surfaces.

Surfaces are cut where depth bends by more than 4 mm from one pixel to the next, a fifth of a wrap
at 7.15 GHz: a method may follow depth up to there, and must find a new offset beyond.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from skimage.measure import label

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import wrap_length
from cmtof.scenes.frame import Frame

Array = NDArray[np.float64]

BEND = 0.004
"""Second difference of depth at which one surface ends, m."""

HYPERSIM_DEPTH = {5: 1.27, 25: 3.0, 50: 4.8, 75: 7.8, 95: 23.0}
"""Percentiles of range in Hypersim's pixels, m."""

HYPERSIM_BRIGHTNESS = {5: 0.010, 25: 0.08, 50: 0.27, 75: 0.70, 90: 1.6}
"""Percentiles of linear brightness in Hypersim's pixels, tone map's units."""


class Hardness(NamedTuple):
    """Samples of what makes unwrapping hard, of one or many frames."""

    depth: Array
    """Range of each valid pixel, m."""
    brightness: Array
    """Linear intensity of each pixel."""
    slope: Array
    """Change of depth from a pixel to its neighbour within a surface, wraps of 7.15 GHz."""
    jump: Array
    """Change of depth between neighbours where a surface ends, wraps of 7.15 GHz."""
    patch: Array
    """Size of the surface that each pixel lies in, px."""
    invalid: float
    """Share of pixels without depth."""


def bends(depth: ArrayLike, threshold: float = BEND) -> NDArray[np.bool_]:
    """Pixels (H, W) where a surface ends: depth bends by more than ``threshold``, m, or is NaN.

    Examples
    --------
    >>> depth = np.outer(np.ones(5), [1.0, 1.1, 1.2, 1.5, 1.6])
    >>> bends(depth)[2].tolist()
    [False, False, True, True, False]
    """
    depth = np.asarray(depth, float)
    ends = ~np.isfinite(depth)
    for axis in (0, 1):
        second = np.abs(np.diff(depth, n=2, axis=axis))
        inner: NDArray[np.bool_] = np.moveaxis(ends, axis, 0)[1:-1]
        inner |= ~(np.moveaxis(second, axis, 0) <= threshold)  # NaN counts as an end
    return ends


def surface_sizes(ends: ArrayLike) -> NDArray[np.int64]:
    """Size, px, of the surface that each pixel (H, W) lies in; one where a surface ends.

    Parameters
    ----------
    ends : array_like of bool, shape (H, W)
        From `bends`.

    Examples
    --------
    >>> surface_sizes([[False, False, True, False]]).tolist()
    [[2, 2, 1, 1]]
    """
    surfaces = np.asarray(label(~np.asarray(ends, bool), connectivity=1))
    sizes = np.bincount(surfaces.ravel())
    sizes[0] = 1  # a pixel on an edge stands alone
    return sizes[surfaces]


def hardness(frame: Frame) -> Hardness:
    """Measure one frame."""
    depth = frame.depth.astype(float)
    valid = np.isfinite(depth)
    ends = bends(depth)
    wrap = float(wrap_length(FREQUENCY_SINGLE))
    slope, jump = [], []
    for axis in (0, 1):
        change = np.moveaxis(np.abs(np.diff(depth, axis=axis)) / wrap, axis, 0)
        across = np.moveaxis(ends, axis, 0)
        between = across[1:] & across[:-1]
        known = np.isfinite(change)
        slope.append(change[known & ~between])
        # of the two pixels that a bend marks, the step lies between them
        jump.append(change[known & between & (change * wrap > BEND)])
    return Hardness(
        depth[valid],
        frame.intensity.ravel().astype(float),
        np.concatenate(slope),
        np.concatenate(jump),
        surface_sizes(ends)[valid].astype(float),
        float(1 - valid.mean()),
    )


def pooled(measured: Iterable[Hardness]) -> Hardness:
    """Samples of many frames together, every pixel counting the same.

    Raises
    ------
    ValueError
        If there is none.
    """
    several = list(measured)
    if not several:
        raise ValueError("Expected at least one frame to measure, got none. Name some.")
    samples = (np.concatenate(one) for one in list(zip(*several, strict=True))[:-1])
    return Hardness(*samples, invalid=float(np.mean([one.invalid for one in several])))


def cumulative(samples: ArrayLike, at: ArrayLike) -> Array:
    """Share of the samples at or below each value.

    Examples
    --------
    >>> cumulative([1, 2, 3, 4], [0, 2, 9]).tolist()
    [0.0, 0.5, 1.0]
    """
    ordered = np.sort(np.asarray(samples, float))
    return np.searchsorted(ordered, np.asarray(at, float), side="right") / max(len(ordered), 1)
