"""From cells to pixels: which surface each pixel lies on, and how deep it is there."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cmtof.surfaces.field import CELL, Field
from cmtof.surfaces.growing import around
from cmtof.surfaces.kernels import depth_at, pixel_likelihood

RADIUS = 2
"""Half side, px, of the square over which a pixel compares surfaces."""

EXPLAINED = 0.4
"""Share S / E within that square below which a pixel lies on none of them."""

INSIDE, CERTAIN = 4, 0.6
"""What fits pool: pixels with no other surface within this many px, and this share S / E."""


def pixel_labels(
    field: Field, owner: NDArray[np.int64], surfaces: NDArray[np.float64]
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Likeliest surface of each pixel among those about its cell, and its share S / E.

    Returns the labels (H, W), -1 where none explains the pixel, and the shares (H, W).
    """
    shape = field.cosine.shape
    label, share = np.full(shape, -1, np.int32), np.zeros(shape, np.float32)
    _label(field.arrays(), owner, surfaces, label, share)
    return np.where(share > EXPLAINED, label, -1).astype(np.int32), share


def interiors(label: NDArray[np.int32], share: NDArray[np.float32]) -> NDArray[np.int32]:
    """The labels without the borders of surfaces, unless little else would be left of one."""
    from scipy.ndimage import maximum_filter, minimum_filter

    side = 2 * INSIDE + 1
    inner = (minimum_filter(label, side) == maximum_filter(label, side)) & (share > CERTAIN)
    known = label >= 0
    count = int(label.max()) + 1
    whole, left = (np.bincount(label[known & of], minlength=count) for of in (True, inner))
    thin = np.append(left < whole / 4, False)
    return np.where(inner | thin[label], label, -1).astype(np.int32)


def depth_of_labels(
    field: Field, label: NDArray[np.integer], surfaces: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Depth (H, W), m, of each pixel on its surface; NaN without one."""
    out = np.full(label.shape, np.nan)
    if len(surfaces):
        _depth(field.arrays(), label, surfaces, out)
    return out


@njit(cache=True, nogil=True)
def _depth(field, label, surfaces, out):  # pragma: no cover - compiled
    for y in range(label.shape[0]):
        for x in range(label.shape[1]):
            if label[y, x] >= 0:
                out[y, x] = depth_at(field, surfaces[label[y, x]], y, x)


@njit(cache=True, nogil=True, fastmath=True)
def _label(field, owner, surfaces, label, share):  # pragma: no cover - compiled
    information = field[2]
    height, width = label.shape
    side = CELL + 2 * RADIUS
    found = np.empty(9, np.int64)
    patch = np.zeros((side, side))
    best, told = np.empty((CELL, CELL)), np.empty((CELL, CELL))
    summed = np.empty((CELL, CELL))
    for row in range(owner.shape[0]):
        for column in range(owner.shape[1]):
            count = around(owner, row, column, found)
            top, left = row * CELL - RADIUS, column * CELL - RADIUS
            best[:] = -np.inf
            for i in range(-1, count):
                patch[:] = 0.0
                for y in range(max(top, 0), min(top + side, height)):
                    for x in range(max(left, 0), min(left + side, width)):
                        if i < 0:
                            patch[y - top, x - left] = information[0, y, x] + information[1, y, x]
                        else:
                            value = pixel_likelihood(field, surfaces[found[i]], y, x)
                            patch[y - top, x - left] = value
                _box(patch, summed)
                if i < 0:
                    told[:] = summed
                    continue
                for y in range(CELL):
                    for x in range(CELL):
                        if summed[y, x] > best[y, x]:
                            best[y, x] = summed[y, x]
                            at = (row * CELL + y, column * CELL + x)
                            label[at] = found[i]
                            share[at] = summed[y, x] / max(told[y, x], 1e-9)


@njit(cache=True, nogil=True, fastmath=True)
def _box(patch, out):  # pragma: no cover - compiled
    """Sum over squares of 2 RADIUS + 1 px about each pixel of a cell."""
    side = 2 * RADIUS + 1
    for y in range(CELL):
        for x in range(CELL):
            total = 0.0
            for a in range(side):
                for b in range(side):
                    total += patch[y + a, x + b]
            out[y, x] = total
