"""Straight round bars, many at once: rails, rods, cords, balusters."""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.rooms.thing import Mesh


def bars(starts: ArrayLike, ends: ArrayLike, radius: float, sides: int = 8) -> Mesh:
    """Bars of one radius from points (N, 3) to points (N, 3), m; smooth around, creased at caps.

    Examples
    --------
    >>> mesh = bars([[0, 0, 0], [1, 0, 0]], [[0, 0, 1], [1, 0, 1]], 0.1, sides=6)
    >>> mesh.vertices.shape, mesh.faces.shape
    ((48, 3), (40, 3))
    """
    a, b = np.atleast_2d(np.asarray(starts, float)), np.atleast_2d(np.asarray(ends, float))
    frames = np.array([_across(*d) for d in (b - a).tolist()])
    ring = radius * (_circle(sides) @ frames)
    low, high = a[:, None] + ring, b[:, None] + ring
    points = np.concatenate([low, high, low, high], 1).astype(np.float32)
    faces = _faces(sides)[None] + (4 * sides * np.arange(len(a), dtype=np.int32))[:, None, None]
    return Mesh(points.reshape(-1, 3), faces.reshape(-1, 3))


def _across(x: float, y: float, z: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Two unit vectors square to a direction and to each other, right-handed with it.

    In plain floats: most calls are for a single bar.
    """
    n = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / n, y / n, z / n
    # the first is level unless the bar stands nearly upright
    u = (z, 0.0, -x) if abs(z) > 0.9 else (-y, x, 0.0)
    m = math.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    p, q, r = u[0] / m, u[1] / m, u[2] / m
    return (p, q, r), (y * r - z * q, z * p - x * r, x * q - y * p)


@lru_cache
def _circle(sides: int) -> NDArray[np.float64]:
    angle = np.arange(sides) * (2 * np.pi / sides)
    return np.stack([np.cos(angle), np.sin(angle)], 1)


@lru_cache
def _faces(sides: int) -> NDArray[np.int32]:
    """Sides and both caps of one bar; its rings come twice, for the crease."""
    k = np.arange(sides)
    n = np.roll(k, -1)
    fan = np.arange(1, sides - 1)
    one = [
        np.stack([k, n, sides + n], 1),
        np.stack([k, sides + n, sides + k], 1),
        np.stack([0 * fan, fan + 1, fan], 1) + 2 * sides,
        np.stack([0 * fan, fan, fan + 1], 1) + 3 * sides,
    ]
    return np.concatenate(one).astype(np.int32)


def bar(start: ArrayLike, end: ArrayLike, radius: float, sides: int = 8) -> Mesh:
    """One bar."""
    return bars([start], [end], radius, sides)  # type: ignore[list-item]
