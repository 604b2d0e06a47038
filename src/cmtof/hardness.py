"""How hard a scene is to unwrap: slopes, jumps and sizes of its surfaces."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import wrap_length
from cmtof.types import Array, Flags

BEND = 0.004  # second difference of depth that ends a surface, m; a fifth of a wrap at 7.15 GHz


def bends(depth: ArrayLike) -> Flags:
    """Pixels (H, W) where a surface ends: depth bends by more than `BEND`, or is NaN."""
    depth = np.asarray(depth, float)
    ends = ~np.isfinite(depth)
    for image, marks in ((depth, ends), (depth.T, ends.T)):
        second = abs(np.diff(image, n=2, axis=0))
        marks[1:-1] |= ~(second <= BEND)  # NaN counts as an end
    return ends


class Hardness(NamedTuple):
    """Slopes and jumps, wraps at 7.15 GHz, and sizes, px, of the surfaces of a depth map."""

    slope: (
        Array  # change of depth from a pixel to its neighbour within a surface, wraps
    )
    jump: Array  # the same where a surface ends
    size: Array  # of each valid pixel's surface, px; one where a surface ends


def hardness(depth: ArrayLike) -> Hardness:
    """Slopes, jumps and sizes of the surfaces of a depth map (H, W), m, NaN where invalid."""
    depth = np.asarray(depth, float)
    ends = bends(depth)
    wrap = wrap_length(FREQUENCY_SINGLE)
    # of the two pixels that a bend marks, the step lies between them
    steps = [
        (abs(np.diff(image, axis=0)).ravel(), (marks[1:] & marks[:-1]).ravel())
        for image, marks in ((depth, ends), (depth.T, ends.T))
    ]
    change, is_jump = np.concatenate(steps, axis=1)
    slopes = change[np.isfinite(change) & (is_jump == 0)] / wrap
    jumps = change[(change > BEND) & (is_jump == 1)] / wrap
    surfaces, _ = ndimage.label(~ends)  # pyright: ignore[reportGeneralTypeIssues]
    pixels = np.bincount(surfaces.ravel()).astype(float)
    pixels[0] = 1  # a pixel on an edge stands alone
    sizes = pixels[surfaces][np.isfinite(depth)]  # pyright: ignore[reportArgumentType, reportCallIssue]
    return Hardness(slopes, jumps, sizes)
