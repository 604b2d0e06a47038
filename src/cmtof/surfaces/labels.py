"""Which surface each pixel lies on, and how deep."""

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter, uniform_filter

from cmtof.compiled import njit
from cmtof.surfaces.field import CELL, Array, Field, Labels
from cmtof.surfaces.fitting import FARTHEST, pixel_likelihood
from cmtof.surfaces.growing import Surfaces, around, coherence

RADIUS = 2  # half side, px, of the square over which a pixel compares surfaces
EXPLAINED = 0.4  # share of the S expected in that square below which a pixel lies on none of them
_INSIDE, _CERTAIN = 4, 0.6  # fits use pixels without another surface this near, and this share
_THIN = 0.25  # share of a surface's pixels that must be inside for the others to be left out


def pixel_labels(field: Field, owner: Labels, surfaces: Surfaces) -> tuple[Labels, Array]:
    """Likeliest surface (H, W), -1 for none, of a square about each pixel, and its share of S."""
    side = 2 * RADIUS + 1
    shape = field.cosine.shape
    label = np.full(shape, -1, np.int32)
    best = np.full(shape, -np.inf)
    _label_cells(field.arrays(), owner, surfaces.parameters, label, best)
    expected = np.zeros(shape)
    for frequency, left in enumerate(coherence(surfaces.roughness)):
        told = uniform_filter(field.information[frequency].astype(float), side, mode="constant")
        expected += side**2 * told * np.append(left, 1.0)[label]
    share = np.where(label < 0, 0, best / np.maximum(expected, 1e-9)).astype(np.float32)
    return np.where(share > EXPLAINED, label, -1).astype(np.int32), share


def interiors(label: Labels, share: Array) -> Labels:
    """The labels without the borders of surfaces, unless little else would be left of one."""
    side = 2 * _INSIDE + 1
    inner = (minimum_filter(label, side) == maximum_filter(label, side)) & (share > _CERTAIN)
    known = label >= 0
    count = int(label.max()) + 1
    whole = np.bincount(label[known], minlength=count)
    left = np.bincount(label[known & inner], minlength=count)
    thin = np.append(left < _THIN * whole, False)
    return np.where(inner | thin[label], label, -1).astype(np.int32)


def depth_of_labels(field: Field, label: Labels, parameters: Array) -> Array:
    """Depth (H, W), m, of each pixel on its surface; NaN without one."""
    out = np.full(label.shape, np.nan)
    y, x = np.nonzero(label >= 0)
    out[y, x] = depth_on(field, parameters, label[y, x], y, x)
    return out


def depth_on(field: Field, parameters: Array, which: Labels, y: Labels, x: Labels) -> Array:
    """Depth (P,), m, of surfaces by their number (P,) at pixels (P,)."""
    q = parameters[which].T
    u = field.u[x]
    v = field.v[y]
    inverse = q[0] * u + q[1] * v + q[2] + q[3] * u * u + q[4] * u * v + q[5] * v * v
    return 1 / np.maximum(field.cosine[y, x] * inverse, FARTHEST)


@njit(cache=True, nogil=True)
def _label_cells(field, owner, parameters, label, best):  # pragma: no cover - compiled
    """Sum S of every surface about a cell over squares about its pixels; keep the largest."""
    patch = np.zeros((CELL + 2 * RADIUS, CELL + 2 * RADIUS))
    for row in range(owner.shape[0]):
        for column in range(owner.shape[1]):
            for n in around(owner, row, column):
                _fill(field, parameters[n], row * CELL - RADIUS, column * CELL - RADIUS, patch)
                _compare(patch, n, row * CELL, column * CELL, label, best)


@njit(cache=True, nogil=True)
def _fill(field, q, top, left, patch):  # pragma: no cover - compiled
    """S of a surface at the pixels of a patch, zero outside of the image."""
    height, width = field[7].shape
    patch[:] = 0.0
    for y in range(max(top, 0), min(top + patch.shape[0], height)):
        for x in range(max(left, 0), min(left + patch.shape[1], width)):
            patch[y - top, x - left] = pixel_likelihood(field, q, y, x)


@njit(cache=True, nogil=True)
def _compare(patch, number, top, left, label, best):  # pragma: no cover - compiled
    """Give a surface the pixels of a cell where its S over a square is the largest so far."""
    side = 2 * RADIUS + 1
    for y in range(CELL):
        for x in range(CELL):
            total = 0.0
            for a in range(side):
                for b in range(side):
                    total += patch[y + a, x + b]
            if total > best[top + y, left + x]:
                best[top + y, left + x] = total
                label[top + y, left + x] = number
