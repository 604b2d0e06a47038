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
    out[place] = depth_of_pixels(field, surfaces, label[place], *place)
    return out


@njit()
def depth_of_pixels(field, surfaces, which, y, x):  # pragma: no cover - compiled
    """Depth (P,), m, of surfaces by their number (P,) at pixels (P,)."""
    out = np.empty(which.size)
    for n in range(which.size):
        out[n] = depth_at(field, surfaces[which[n]], y[n], x[n])
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
    scale = 1 / np.sqrt(np.diag(matrix)[:size] + 1e-12)
    found = scale * right[:size]
    left = np.empty((size, size))
    for i in range(size):
        for j in range(i + 1):
            left[i, j] = left[j, i] = scale[i] * scale[j] * matrix[i, j]
    for k in range(size):
        pivot = left[k, k] + 1e-10
        for i in range(size):
            if i != k:
                share = left[i, k] / pivot
                found[i] -= share * found[k]
                for j in range(k, size):
                    left[i, j] -= share * left[k, j]
    out = np.zeros(BENT)
    out[:size] = found * (scale / (np.diag(left) + 1e-10))
    return out
