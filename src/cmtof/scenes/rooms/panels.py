"""Flat walls with holes: faces around the openings, reveals inside them; mouldings along walls.

A panel lies in the plane y = 0 of its own frame, x along it, z up; its front looks towards -y.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.rooms.plan import cross
from cmtof.scenes.rooms.solids import joined, quads
from cmtof.scenes.rooms.thing import Mesh

Points = NDArray[np.float64]
Top = list[tuple[float, float]]
"""Upper edge of a panel: (x, z) from left to right."""


class Opening(NamedTuple):
    """A hole in a panel, m."""

    x0: float
    x1: float
    z0: float
    z1: float
    shape: str = "rectangle"
    """rectangle, arch (round head) or round."""

    @property
    def centre(self) -> tuple[float, float]:
        """x and z of its middle, m."""
        return (self.x0 + self.x1) / 2, (self.z0 + self.z1) / 2

    def ring(self) -> Points:
        """Points (N, 2) around the hole, counter-clockwise seen from the front."""
        x, z = self.centre
        a, b = (self.x1 - self.x0) / 2, (self.z1 - self.z0) / 2
        if self.shape == "rectangle":
            return np.array([(x - a, z - b), (x + a, z - b), (x + a, z + b), (x - a, z + b)])
        if self.shape == "round":
            t = np.arange(40) * (np.pi / 20)
            return np.stack([x + a * np.cos(t), z + b * np.sin(t)], -1)
        rise = min(a, 2 * b)
        t = np.linspace(0, np.pi, 21)
        arc = np.stack([x + a * np.cos(t), self.z1 - rise + rise * np.sin(t)], -1)
        return np.concatenate([[(x - a, z - b), (x + a, z - b)], arc])


def panel(
    openings: list[Opening],
    top: Top,
    *,
    bottom: float = 0.0,
    y: float = 0.0,
    back: bool = False,
) -> Mesh:
    """Face of a panel around its openings.

    Parameters
    ----------
    openings : list of Opening
        Side by side, never above one another.
    top : list of (x, z)
        Upper edge; its ends are the ends of the panel.
    bottom : float
        Lower edge, m.
    y : float
        Where the face lies, m.
    back : bool
        Face towards +y instead of -y.
    """
    ends, heights = np.array(top).T
    breaks = {*ends.tolist()} | {v for o in openings for v in (o.x0, o.x1)}
    xs = np.array(sorted(v for v in breaks if ends[0] <= v <= ends[-1]))
    zs = np.interp(xs, ends, heights)
    pieces = []
    for x0, x1, z0, z1 in zip(xs[:-1], xs[1:], zs[:-1], zs[1:], strict=True):
        middle = (x0 + x1) / 2
        hole = next((o for o in openings if o.x0 < middle < o.x1), None)
        if hole is None:
            pieces.append([(x0, bottom), (x1, bottom), (x1, z1), (x0, z0)])
            continue
        if hole.z0 > bottom:
            pieces.append([(x0, bottom), (x1, bottom), (x1, hole.z0), (x0, hole.z0)])
        if max(z0, z1) > hole.z1 + 1e-6:
            pieces.append([(x0, hole.z1), (x1, hole.z1), (x1, z1), (x0, z0)])
    face = quads(_stood(np.array(pieces), y))
    fills = [_spandrels(o, y) for o in openings if o.shape != "rectangle"]
    face = joined([face, *fills])
    return Mesh(face.vertices, face.faces[:, ::-1].copy()) if back else face


def _stood(flat: Points, y: float) -> Points:
    """Points (..., 2) of x and z put up at y."""
    return np.stack([flat[..., 0], np.full(flat.shape[:-1], y), flat[..., 1]], -1)


def _spandrels(hole: Opening, y: float) -> Mesh:
    """Fill between a round hole and its bounding rectangle."""
    p = hole.ring()
    q = np.roll(p, -1, 0)
    x, z = hole.centre
    m = (p + q) / 2
    corner = np.stack(
        [np.where(m[:, 0] > x, hole.x1, hole.x0), np.where(m[:, 1] > z, hole.z1, hole.z0)], -1
    )
    area = np.abs(cross(p - corner, q - corner))
    triangles = np.stack([corner, q, p], 1)[area > 1e-9]
    count = np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3)
    return Mesh(_stood(triangles, y).reshape(-1, 3).astype(np.float32), count)


def reveals(
    opening: Opening,
    depth: float,
    *,
    y: float = 0.0,
    open_below: bool = False,
    open_above: bool = False,
) -> Mesh:
    """Inside faces of a hole from y to y + depth, m, without its bottom or top if that is open."""
    ring = opening.ring()
    near = np.stack([ring[:, 0], np.full(len(ring), y), ring[:, 1]], -1)
    far = near + np.array([0.0, depth, 0.0])
    following = np.roll(np.arange(len(ring)), -1)
    strip = np.stack([near, near[following], far[following], far], 1)
    for is_open, z in ((open_below, opening.z0), (open_above, opening.z1)):
        if is_open:
            strip = strip[np.abs(strip[:, :2, 2] - z).max(1) > 1e-9]
    return quads(strip)


def swept(path: ArrayLike, profile: ArrayLike, *, closed: bool = False) -> Mesh:
    """A moulding along a path (N, 2) on the floor, mitred at its corners, flat-shaded.

    Parameters
    ----------
    path : array_like, shape (N, 2)
        m; the moulding stands on its left.
    profile : array_like, shape (M, 2)
        Distance from the path to its left and height, m, counter-clockwise seen along the path's
        end: from the foot at the front up and back to the wall.
    closed : bool
        The path runs round.
    """
    path, profile = np.asarray(path, float), np.asarray(profile, float)
    along = np.roll(path, -1, 0) - path
    if not closed:
        along[-1] = along[-2]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    before = np.roll(along, 1, 0)
    if not closed:
        before[0] = along[0]
    left = np.stack([-along[:, 1], along[:, 0]], -1)
    mitre = left + np.stack([-before[:, 1], before[:, 0]], -1)
    mitre /= (mitre * left).sum(1, keepdims=True)
    points = np.empty((len(path), len(profile), 3))
    points[..., :2] = path[:, None] + profile[None, :, :1] * mitre[:, None]
    points[..., 2] = profile[:, 1]
    grid = np.concatenate([points, points[:1]]) if closed else points
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    faces = [quads(np.stack([b, a, d, c], -2).reshape(-1, 4, 3))]
    if not closed:
        faces += [_cap(points[0, ::-1]), _cap(points[-1])]
    return joined(faces)


def _cap(ring: Points) -> Mesh:
    """Convex end of a moulding as a fan."""
    n = len(ring)
    fan = np.stack([np.zeros(n - 2, int), np.arange(1, n - 1), np.arange(2, n)], -1)
    return Mesh(ring.astype(np.float32), fan.astype(np.int32))
