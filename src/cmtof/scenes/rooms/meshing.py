"""Sums over a mesh, compiled: areas, normals, and what neighbours share."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float32]


@njit(cache=True, error_model="numpy", nogil=True)
def face_vectors(vertices, faces):  # pragma: no cover - compiled
    """Middle (T, 3), unit normal (T, 3) and area (T,), m^2, of every triangle."""
    middle = np.empty((len(faces), 3), np.float32)
    normal = np.zeros((len(faces), 3), np.float32)
    area = np.empty(len(faces), np.float32)
    for t in range(len(faces)):
        a, b, c = vertices[faces[t, 0]], vertices[faces[t, 1]], vertices[faces[t, 2]]
        x = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1])
        y = (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2])
        z = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        size = math.sqrt(x * x + y * y + z * z)
        area[t] = size / 2
        for q in range(3):
            middle[t, q] = (a[q] + b[q] + c[q]) / 3
        if size > 0:
            normal[t, 0], normal[t, 1], normal[t, 2] = x / size, y / size, z / size
    return middle, normal, area


@njit(cache=True, error_model="numpy", nogil=True)
def vertex_normals(vertices, faces):  # pragma: no cover - compiled
    """Unit normals (V, 3): the mean of the adjoining faces, weighted by their areas."""
    _, normal, area = face_vectors(vertices, faces)
    total = np.zeros((len(vertices), 3), np.float32)
    for t in range(len(faces)):
        for k in range(3):
            for q in range(3):
                total[faces[t, k], q] += area[t] * normal[t, q]
    for v in range(len(vertices)):
        size = math.sqrt(total[v, 0] ** 2 + total[v, 1] ** 2 + total[v, 2] ** 2)
        for q in range(3):
            total[v, q] /= max(size, 1e-20)
    return total


@njit(cache=True, error_model="numpy", nogil=True)
def spread(values, weight, faces, part, vertex_count, part_count):  # pragma: no cover - compiled
    """Weighted mean (T, 3) over the triangles that share a corner, or over the part if none has.

    ``weight`` (T,) is 0 for triangles without a value.
    """
    at_vertex = np.zeros((vertex_count, 4), np.float32)
    of_part = np.zeros((part_count, 4), np.float64)
    for t in range(len(faces)):
        w = weight[t]
        if w > 0:
            of_part[part[t], 3] += w
            for q in range(3):
                of_part[part[t], q] += w * values[t, q]
            for k in range(3):
                v = faces[t, k]
                at_vertex[v, 3] += w
                for q in range(3):
                    at_vertex[v, q] += w * values[t, q]
    out = np.empty_like(values)
    for t in range(len(faces)):
        a, b, c = at_vertex[faces[t, 0]], at_vertex[faces[t, 1]], at_vertex[faces[t, 2]]
        heard = a[3] + b[3] + c[3]
        total = of_part[part[t]]
        for q in range(3):
            if heard > 0:
                out[t, q] = (a[q] + b[q] + c[q]) / heard
            else:
                out[t, q] = total[q] / max(total[3], 1e-12)
    return out
