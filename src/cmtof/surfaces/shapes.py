"""Planes and bent surfaces: their depth, and equations of their parameters.

A surface is ``1 / z = cosine (q_0 u + q_1 v + q_2 + q_3 u^2 + q_4 u v + q_5 v^2)``; a plane has
none of the last three.
"""

import numpy as np

from cmtof.compiled import inlined, njit
from cmtof.surfaces.field import Field
from cmtof.types import Array, Numbers

# As NumPy's integers, for Numba compiles a function again for every literal that it is given.
PLANE = np.int64(3)  # parameters of a plane
BENT = np.int64(6)  # and of a bent surface
FARTHEST = 1e-4  # smallest 1 / z, 1 / m, of a surface


@inlined
def depth_at(field, q, y, x):  # pragma: no cover - compiled
    """Depth, m, of a surface at a pixel."""
    u = field.u[x]
    v = field.v[y]
    plane = q[2] + q[0] * u + q[1] * v
    bend = q[3] * u * u
    bend += q[4] * u * v
    bend += q[5] * v * v
    inverse = field.cosine[y, x] * (plane + bend)
    return 1.0 / max(inverse, FARTHEST)


def depth_of_labels(field: Field, label: Numbers, surfaces: Array) -> Array:
    """Depth (H, W), m, of each pixel on its surface; NaN without one."""
    out = np.full(label.shape, np.nan)
    place = np.nonzero(label >= 0)
    out[place] = depth_of_pixels(field, surfaces, np.array([label[place], *place]))
    return out


@njit()
def depth_of_pixels(field, surfaces, pixels):  # pragma: no cover - compiled
    """Depth (P,), m, of pixels by the number of their surface, their row and column (3, P)."""
    out = np.empty(pixels.shape[1])
    for n in range(out.size):
        of, y, x = pixels[:, n]
        out[n] = depth_at(field, surfaces[of], y, x)
    return out


@inlined
def is_possible(field, q, boxes):  # pragma: no cover - compiled
    """Whether the depth at a corner of the first box is 0.02 to 2 times the farthest in range."""
    z = depth_at(field, q, boxes[0, 0], boxes[0, 2])
    farthest = field.limits[1]
    return 0.02 * farthest < z < 2 * farthest


@njit()
def solve(matrix, right, size):  # pragma: no cover - compiled
    """Solution (6,) of ``matrix x = right`` for the first ``size`` unknowns; the rest is zero."""
    scale = np.empty(size)
    left = np.empty((size, size))
    found = np.zeros(BENT)
    for i in range(size):
        scale[i] = 1 / np.sqrt(matrix[i, i] + 1e-12)
        found[i] = scale[i] * right[i]
        for j in range(i + 1):
            left[i, j] = left[j, i] = scale[i] * scale[j] * matrix[i, j]
    for k in range(size):
        for i in range(size):
            if i != k:
                share = left[i, k] / (left[k, k] + 1e-10)
                found[i] -= share * found[k]
                for j in range(k, size):
                    left[i, j] -= share * left[k, j]
    for i in range(size):
        found[i] *= scale[i] / (left[i, i] + 1e-10)
    return found
