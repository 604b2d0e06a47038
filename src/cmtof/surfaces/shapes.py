"""Planes and bent surfaces: their depth, and the nearest one to depths.

A surface is ``1 / z = cosine (q_0 u + q_1 v + q_2 + q_3 u^2 + q_4 u v + q_5 v^2)``; a plane has
none of the last three.
"""

import numpy as np

from cmtof.compiled import njit
from cmtof.surfaces.field import Field
from cmtof.types import Array, Numbers

# As NumPy's integers, for Numba compiles a function again for every literal that it is given.
PLANE = np.int64(3)  # parameters of a plane
BENT = np.int64(6)  # and of a bent surface
FARTHEST = 1e-4  # smallest 1 / z, 1 / m, of a surface


@njit(inline="always")
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


def depth_of_pixels(
    field: Field, surfaces: Array, which: Numbers, y: Numbers, x: Numbers
) -> Array:
    """Depth (P,), m, of surfaces by their number (P,) at pixels (P,)."""
    q = surfaces[which].T
    u = field.u[x]
    v = field.v[y]
    inverse = q[0] * u + q[1] * v + q[2]
    inverse += q[3] * u * u
    inverse += q[4] * u * v
    inverse += q[5] * v * v
    inverse *= field.cosine[y, x]
    return 1 / np.maximum(inverse, FARTHEST)


@njit(inline="always")
def is_possible(field, q, boxes):  # pragma: no cover - compiled
    """Whether a surface lies before the camera and not far beyond the limits."""
    z = depth_at(field, q, boxes[0, 0], boxes[0, 2])
    farthest = field.limits[1]
    return 0.02 * farthest < z < 2 * farthest


@njit()
def move_surface(field, q, boxes, size, distance, down=0, right=0):  # pragma: no cover
    """Nearest surface to this one moved, by m and by wraps per pixel; their distance, m (rms)."""
    points = _every_third(boxes[:: max(1, len(boxes) // 100)])
    middle = (np.mean(boxes[:, :2]), np.mean(boxes[:, 2:]))
    z = np.empty(len(points))
    for n, (y, x) in enumerate(points):
        move = distance + field.period * (
            down * (y - middle[0]) + right * (x - middle[1])
        )
        inverse = np.sum(q * _functions(field, y, x))
        inverse *= field.cosine[y, x]
        z[n] = max(1 / max(inverse, FARTHEST) + move, 0.05)
    return _surface_through(field, points, z, size)


@njit()
def _every_third(boxes):  # pragma: no cover - compiled
    """Row and column of every third pixel, down and across, of rectangles."""
    points = []
    for top, bottom, left, right in boxes:
        for y in range(top, bottom, 3):
            for x in range(left, right, 3):
                points.append((y, x))
    return points


@njit()
def _functions(field, y, x):  # pragma: no cover - compiled
    """The six functions of a surface at a pixel."""
    u = field.u[x]
    v = field.v[y]
    return np.array([u, v, 1.0, u * u, u * v, v * v])


@njit()
def _surface_through(field, points, z, size):  # pragma: no cover - compiled
    """Surface nearest to depths (P,), m, at points, and its distance, m (rms)."""
    matrix, wanted = _normal_equations(field, points, z, size)
    q = solve(matrix, wanted, size)
    missed = np.sum(z * z) - np.sum(q * wanted)
    return q, np.sqrt(max(missed, 0.0) / z.size)


@njit()
def _normal_equations(field, points, z, size):  # pragma: no cover - compiled
    """Lower half of the matrix (6, 6) and right side (6,) of the fit to depths at points."""
    matrix = np.zeros((BENT, BENT))
    wanted = np.zeros(BENT)
    for n, (y, x) in enumerate(points):
        basis = _functions(field, y, x)
        cosine = field.cosine[y, x]
        weight = z[n] ** 4 * cosine**2
        for i in range(size):
            weighted = weight * basis[i]
            wanted[i] += weighted / (z[n] * cosine)
            for j in range(i + 1):
                matrix[i, j] += weighted * basis[j]
    return matrix, wanted


@njit()
def solve(matrix, right, size):  # pragma: no cover - compiled
    """M^-1 right for the first functions, by elimination, M scaled to a unit diagonal."""
    left = np.empty((BENT, BENT))
    scale = np.empty(BENT)
    out = np.zeros(BENT)
    for i in range(size):
        unit = 1 / np.sqrt(matrix[i, i] + 1e-12)
        scale[i] = unit
        out[i] = unit * right[i]
        for j in range(i + 1):
            scaled = unit * scale[j] * matrix[i, j]
            left[i, j] = scaled
            left[j, i] = scaled
    for k in range(size):
        pivot = left[k, k] + 1e-10
        for i in range(size):
            share = 0.0
            if i != k:
                share = left[i, k] / pivot
            out[i] -= share * out[k]
            for j in range(k, size):
                left[i, j] -= share * left[k, j]
    for i in range(size):
        out[i] *= scale[i] / (left[i, i] + 1e-10)
    return out
