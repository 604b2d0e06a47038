"""Planes and bent surfaces: their depth, and the nearest one to depths.

A surface is ``1 / z = cosine (q_0 u + q_1 v + q_2 + q_3 u^2 + q_4 u v + q_5 v^2)``; a plane has
none of the last three.
"""

import numpy as np

from cmtof.compiled import njit

# As NumPy's integers, for Numba compiles a function again for every literal that it is given.
PLANE = np.int64(3)  # parameters of a plane
BENT = np.int64(6)  # and of a bent surface
FARTHEST = 1e-4  # smallest 1 / z, 1 / m, of a surface


@njit(inline="always")
def depth_at(field, q, y, x):  # pragma: no cover - compiled
    """Depth, m, of a surface at a pixel."""
    u = field.u[x]
    v = field.v[y]
    inverse = q[2] + q[0] * u + q[1] * v
    inverse += q[3] * u * u + q[4] * u * v + q[5] * v * v
    return 1.0 / max(field.cosine[y, x] * inverse, FARTHEST)


@njit(inline="always")
def possible(field, q, boxes):  # pragma: no cover - compiled
    """Whether a surface lies before the camera and not far beyond the limits."""
    z = depth_at(field, q, boxes[0, 0], boxes[0, 2])
    return 0.02 * field.limits[1] < z < 2 * field.limits[1]


@njit()
def moved(field, q, boxes, size, distance, down=0, right=0):  # pragma: no cover
    """Nearest surface to this one moved, by m and by wraps per pixel; their distance, m (rms)."""
    points = _every_third(boxes[:: max(1, len(boxes) // 100)])
    middle = (np.mean(boxes[:, :2]), np.mean(boxes[:, 2:]))
    z = np.empty(len(points))
    for n in range(len(points)):
        y = points[n, 0]
        x = points[n, 1]
        shift = field.period * (down * (y - middle[0]) + right * (x - middle[1]))
        inverse = np.sum(q * _functions(field, y, x))
        z[n] = max(
            1 / max(field.cosine[y, x] * inverse, FARTHEST) + (distance + shift), 0.05
        )
    return _surface_through(field, points, z, size)


@njit()
def _every_third(boxes):  # pragma: no cover - compiled
    """Every third pixel (P, 2), down and across, of rectangles."""
    count = 0
    for box in boxes:
        count += len(range(box[0], box[1], 3)) * len(range(box[2], box[3], 3))
    points = np.empty((count, 2), np.int64)
    n = 0
    for box in boxes:
        for y in range(box[0], box[1], 3):
            for x in range(box[2], box[3], 3):
                points[n, 0] = y
                points[n, 1] = x
                n += 1
    return points


@njit()
def _functions(field, y, x):  # pragma: no cover - compiled
    """The six functions of a surface at a pixel."""
    u = field.u[x]
    v = field.v[y]
    return np.array([u, v, 1.0, u * u, u * v, v * v])


@njit()
def _surface_through(field, points, z, size):  # pragma: no cover - compiled
    """Surface nearest to depths (P,), m, at pixels (P, 2), and its distance, m (rms)."""
    matrix = np.zeros((BENT, BENT))
    wanted = np.zeros(BENT)
    for n in range(len(points)):
        y = points[n, 0]
        x = points[n, 1]
        basis = _functions(field, y, x)
        cosine = field.cosine[y, x]
        weight = z[n] ** 4 * cosine**2
        for i in range(size):
            wanted[i] += weight * basis[i] / (z[n] * cosine)
            for j in range(i + 1):
                matrix[i, j] += weight * basis[i] * basis[j]
    q = solve(matrix, wanted, size)
    return q, np.sqrt(max(np.sum(z * z) - np.sum(q * wanted), 0.0) / z.size)


@njit()
def solve(matrix, right, size):  # pragma: no cover - compiled
    """M^-1 right for the first functions, by elimination, M scaled to a unit diagonal."""
    left = np.empty((BENT, BENT))
    scale = np.empty(BENT)
    out = np.zeros(BENT)
    for i in range(size):
        scale[i] = 1 / np.sqrt(matrix[i, i] + 1e-12)
        out[i] = scale[i] * right[i]
        for j in range(i + 1):
            left[i, j] = left[j, i] = scale[i] * scale[j] * matrix[i, j]
    for k in range(size):
        for i in range(size):
            share = left[i, k] / (left[k, k] + 1e-10) if i != k else 0.0
            out[i] -= share * out[k]
            for j in range(k, size):
                left[i, j] -= share * left[k, j]
    out[:size] *= scale[:size] / (np.diag(left)[:size] + 1e-10)
    return out
