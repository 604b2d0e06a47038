"""Floor plans: rectangles with pieces cut away, as outlines, triangles and free floor, m.

An outline runs counter-clockwise, so that the inside lies on the left of each of its edges.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Points = NDArray[np.float64]
Rect = tuple[float, float, float, float]
"""x0, x1, y0, y1."""


def cells(width: float, depth: float, cuts: list[Rect]) -> tuple[Points, Points, NDArray[np.bool_]]:
    """Grid lines in x and y through every edge of the cuts, and which cells are left."""
    xs = np.unique(np.round([0.0, width, *(v for c in cuts for v in c[:2])], 9))
    ys = np.unique(np.round([0.0, depth, *(v for c in cuts for v in c[2:])], 9))
    xs = xs[(xs >= 0) & (xs < width + 1e-6)]
    ys = ys[(ys >= 0) & (ys < depth + 1e-6)]
    x, y = (xs[1:] + xs[:-1]) / 2, (ys[1:] + ys[:-1]) / 2
    free = np.ones((len(x), len(y)), bool)
    for x0, x1, y0, y1 in cuts:
        free &= ~(((x > x0) & (x < x1))[:, None] & ((y > y0) & (y < y1)))
    return xs, ys, free


def outline(width: float, depth: float, cuts: list[Rect]) -> Points:
    """Corners (N, 2) of the rectangle without its cuts, counter-clockwise from the lowest left.

    Examples
    --------
    >>> outline(4, 3, [(3, 4, 2, 3)]).tolist()
    [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [3.0, 2.0], [3.0, 3.0], [0.0, 3.0]]
    """
    xs, ys, free = cells(width, depth, cuts)
    full = np.pad(free, 1)
    following: dict[tuple[int, int], tuple[int, int]] = {}
    for i, j in np.argwhere(free).tolist():
        if not full[i + 1, j]:
            following[i, j] = (i + 1, j)
        if not full[i + 2, j + 1]:
            following[i + 1, j] = (i + 1, j + 1)
        if not full[i + 1, j + 2]:
            following[i + 1, j + 1] = (i, j + 1)
        if not full[i, j + 1]:
            following[i, j + 1] = (i, j)
    node = min(following)
    ring = [node]
    while (node := following[node]) != ring[0]:
        ring.append(node)
    points = np.array([(xs[i], ys[j]) for i, j in ring])
    before, after = points - np.roll(points, 1, 0), np.roll(points, -1, 0) - points
    turns = np.abs(cross(before, after)) > 1e-9
    return points[turns]


def cross(a: Points, b: Points) -> Points:
    """Third component of the cross product of vectors (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def chamfered(points: Points, corners: list[tuple[float, float]], by: float) -> Points:
    """The outline with the named corners cut off ``by`` metres along both of their edges."""
    ring: list[Points] = []
    for k, point in enumerate(points):
        if not any(np.hypot(*(point - np.asarray(c))) < 1e-6 for c in corners):
            ring.append(point)
            continue
        for other in (points[k - 1], points[(k + 1) % len(points)]):
            ring.append(point + by * (other - point) / np.linalg.norm(other - point))
    return np.array(ring)


def offset(points: Points, by: ArrayLike) -> Points:
    """The outline with each edge (from corner k to k+1) pushed outwards by its distance, m."""
    along = np.roll(points, -1, 0) - points
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    out = np.stack([along[:, 1], -along[:, 0]], -1)
    moved = points + np.broadcast_to(np.asarray(by, float), len(points))[:, None] * out
    back, base = np.roll(along, 1, 0), np.roll(moved, 1, 0)
    reach = cross(moved - base, along) / cross(back, along)
    return base + reach[:, None] * back


def triangulated(points: Points) -> NDArray[np.int32]:
    """Triangles (T, 3) of a simple outline, by clipping ears."""
    left = list(range(len(points)))
    faces = []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            corner = points[[a, b, c]]
            if cross(corner[1] - corner[0], corner[2] - corner[1]) <= 1e-12:
                continue
            rest = points[[i for i in left if i not in (a, b, c)]]
            edges = np.roll(corner, -1, 0) - corner
            side = cross(edges[:, None], rest[None] - corner[:, None])
            if not (side >= -1e-9).all(0).any():
                faces.append((a, b, c))
                left.pop(k)
                break
        else:
            raise ValueError("Expected a simple outline, got one that crosses itself. Mend it.")
    return np.array([*faces, tuple(left)], np.int32)


def free_rectangles(width: float, depth: float, cuts: list[Rect]) -> list[Rect]:
    """Every largest rectangle of free floor; they overlap, and their union is all of it."""
    xs, ys, free = cells(width, depth, cuts)
    table = np.pad(np.cumsum(np.cumsum(~free, 0), 1), ((1, 0), (1, 0)))

    def empty(i0: int, i1: int, j0: int, j1: int) -> bool:
        inside = 0 <= i0 < i1 < len(xs) and 0 <= j0 < j1 < len(ys)
        return inside and table[i1, j1] - table[i0, j1] - table[i1, j0] + table[i0, j0] == 0

    found: list[Rect] = []
    for i0 in range(len(xs) - 1):
        for j0 in range(len(ys) - 1):
            last = len(ys)
            for i1 in range(i0 + 1, len(xs)):
                j1 = j0
                while j1 + 1 < last and empty(i0, i1, j0, j1 + 1):
                    j1 += 1
                last = j1 + 1
                if j1 == j0:
                    break
                grown = (
                    empty(i0 - 1, i1, j0, j1),
                    empty(i0, i1 + 1, j0, j1),
                    empty(i0, i1, j0 - 1, j1),
                )
                if not any(grown):
                    found.append((float(xs[i0]), float(xs[i1]), float(ys[j0]), float(ys[j1])))
    return found
