"""Solids of rooms: a few closed shapes on trimesh, in metres, z up."""

from collections.abc import Iterable, Sequence

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from trimesh import Trimesh

Array = NDArray[np.float64]


def raw(vertices: NDArray, faces: NDArray) -> Trimesh:
    """Mesh of these vertices and faces as they are."""
    return Trimesh(vertices, faces, process=False)


def box(size: ArrayLike, centre: ArrayLike = (0.0, 0.0, 0.0)) -> Trimesh:
    """Box of full ``size`` (x, y, z) about ``centre``, m.

    >>> float(box((1, 2, 3)).volume)
    6.0
    """
    corners = np.array([[i, j, k] for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (-0.5, 0.5)])
    return raw(corners * np.asarray(size, float) + np.asarray(centre, float), _BOX)


def slab(x0: float, x1: float, y0: float, y1: float, z0: float, z1: float) -> Trimesh:
    """Box between two corners, m."""
    low, high = np.array([x0, y0, z0]), np.array([x1, y1, z1])
    return box(high - low, (low + high) / 2)


def extrusion(outline: ArrayLike, height: float) -> Trimesh:
    """Prism over an outline (N, 2), m, counter-clockwise and star-shaped about its mean.

    >>> round(float(extrusion([(0, 0), (2, 0), (0, 1)], 3.0).volume), 6)
    3.0
    """
    flat = np.asarray(outline, float)
    n = len(flat)
    ring = np.arange(n)
    faces = np.stack([np.full(n, n), ring, (ring + 1) % n], axis=1)
    return trimesh.creation.extrude_triangulation(np.vstack([flat, flat.mean(0)]), faces, height)


def plate(
    width: float,
    height: float,
    thickness: float,
    holes: Sequence[tuple[float, float, float, float]] = (),
) -> Trimesh:
    """Upright plate over x in [0, width], z in [0, height], y in [0, thickness], with holes.

    Parameters
    ----------
    width, height, thickness : float
        m.
    holes : sequence of (x0, x1, z0, z1)
        Rectangles cut out of it, m; they may touch the plate's edge.

    >>> wall = plate(4.0, 2.5, 0.2, [(1.0, 2.0, 0.0, 2.0)])
    >>> wall.is_watertight, round(float(wall.volume), 6)
    (True, 1.6)
    """
    inside = np.array(holes, float).reshape(-1, 4)
    xs = np.unique(np.clip(np.concatenate([[0.0, width], *inside[:, :2]]), 0, width))
    zs = np.unique(np.clip(np.concatenate([[0.0, height], *inside[:, 2:]]), 0, height))
    x, z = np.meshgrid((xs[1:] + xs[:-1]) / 2, (zs[1:] + zs[:-1]) / 2, indexing="ij")
    kept = np.ones(x.shape, bool)
    for x0, x1, z0, z1 in inside:
        kept &= ~((x > x0) & (x < x1) & (z > z0) & (z < z1))
    i, j = np.nonzero(kept)
    corner = i * len(zs) + j
    a, b, c, d = corner, corner + len(zs), corner + len(zs) + 1, corner + 1
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    flat = np.stack(np.meshgrid(xs, zs, indexing="ij"), -1).reshape(-1, 2)
    solid = trimesh.creation.extrude_triangulation(flat, faces, thickness)
    solid.vertices = solid.vertices[:, [0, 2, 1]]  # (x, z, y) to (x, y, z), a reflection
    solid.faces = solid.faces[:, ::-1]
    return solid


def revolution(profile: ArrayLike, sections: int = 28) -> Trimesh:
    """Solid of revolution about z of a profile (N, 2) of radius and height, m, bottom to top.

    The profile starts and ends on the axis; the ends are joined to it where they do not.

    >>> cone = revolution([(1.0, 0.0), (0.0, 3.0)], sections=720)
    >>> bool(abs(cone.volume - np.pi) < 1e-3)
    True
    """
    rings = np.asarray(profile, float)
    for end, place in ((0, 0), (-1, len(rings))):
        if rings[end, 0] > 0:
            rings = np.insert(rings, place if end == 0 else len(rings), [0, rings[end, 1]], axis=0)
    return trimesh.creation.revolve(rings, sections=sections)


def sweep(path: ArrayLike, radius: ArrayLike, sections: int = 10) -> Trimesh:
    """Round bar along a path (N, 3), m, of one radius or one for each point.

    >>> bar = sweep([(0, 0, 0), (0, 0, 2)], 0.1, sections=400)
    >>> bar.is_watertight, round(float(bar.volume) / (2 * np.pi * 0.01), 3)
    (True, 1.0)
    """
    line = np.asarray(path, float)
    n = len(line)
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # one axis that no part of the path follows serves all rings
    aside = np.eye(3)[np.abs(along).max(axis=0).argmin()]
    u = np.cross(along, aside)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(along, u)
    turn = 2 * np.pi * np.arange(sections) / sections
    circle = np.cos(turn)[:, None] * u[:, None] + np.sin(turn)[:, None] * v[:, None]
    rings = line[:, None] + np.broadcast_to(radius, n)[:, None, None] * circle
    vertices = np.concatenate([rings.reshape(-1, 3), line[[0, -1]]])
    i, k = np.meshgrid(np.arange(n - 1), np.arange(sections), indexing="ij")
    a, b = (i * sections + k).ravel(), (i * sections + (k + 1) % sections).ravel()
    ring, after = np.arange(sections), (np.arange(sections) + 1) % sections
    last = (n - 1) * sections
    faces = np.concatenate(
        [
            np.stack([a, b, b + sections], 1),
            np.stack([a, b + sections, a + sections], 1),
            np.stack([np.full(sections, len(vertices) - 2), after, ring], 1),
            np.stack([np.full(sections, len(vertices) - 1), last + ring, last + after], 1),
        ]
    )
    return raw(vertices, faces)


def ball(
    radius: ArrayLike,
    *,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
    fineness: int = 2,
    squareness: float = 0.0,
) -> Trimesh:
    """Ellipsoid with smooth noise, about the origin.

    Parameters
    ----------
    radius : array_like
        One radius or three half axes, m.
    noise : float
        Relative height of its bumps; needs ``rng``.
    fineness : int
        Subdivisions of an icosahedron: 320 triangles for 2.
    squareness : float
        0 for an ellipsoid; towards 1 for a rounded box (a superellipsoid), as of a cushion.

    >>> ball(1.0, fineness=4).is_watertight
    True
    """
    unit = trimesh.creation.icosphere(subdivisions=fineness)
    points = np.array(unit.vertices)
    if squareness:
        power = 2 / (1 - squareness)
        points /= (np.abs(points) ** power).sum(axis=1, keepdims=True) ** (1 / power)
    if rng is not None and noise:
        waves, phase = rng.normal(0, 3.0, (6, 3)), rng.uniform(0, 2 * np.pi, 6)
        points *= 1 + noise * np.cos(points @ waves.T + phase).mean(axis=1, keepdims=True)
    return raw(points * np.broadcast_to(radius, 3), unit.faces)


def sheet(grid: ArrayLike, thickness: float) -> Trimesh:
    """Closed sheet over a grid of points (N, M, 3), m, thick along the grid's mean normal.

    >>> x, y = np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0], indexing="ij")
    >>> cloth = sheet(np.stack([x, y, 0 * x], -1), 0.01)
    >>> cloth.is_watertight, round(float(cloth.volume), 6)
    (True, 0.02)
    """
    points = np.asarray(grid, float)
    n, m = points.shape[:2]
    across = np.cross(points[-1, 0] - points[0, -1], points[-1, -1] - points[0, 0])
    back = points - thickness * across / np.linalg.norm(across)
    number = np.arange(n * m).reshape(n, m)
    a, b, c, d = (
        s.ravel() for s in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    front = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    rim = np.concatenate([number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]])
    p, q = rim, np.roll(rim, -1)
    side = np.concatenate([np.stack([p, p + n * m, q], 1), np.stack([q, p + n * m, q + n * m], 1)])
    vertices = np.concatenate([points.reshape(-1, 3), back.reshape(-1, 3)])
    faces = np.concatenate([front, front[:, ::-1] + n * m, side])
    solid = raw(vertices, faces)
    return solid if solid.volume > 0 else raw(vertices, faces[:, ::-1])


def joined(meshes: Iterable[Trimesh]) -> Trimesh:
    """Several solids as one mesh."""
    several = list(meshes)
    start = np.cumsum([0] + [len(one.vertices) for one in several[:-1]])
    faces = [one.faces + k for one, k in zip(several, start, strict=True)]
    return raw(np.vstack([one.vertices for one in several]), np.vstack(faces))


def moved(mesh: Trimesh, shift: ArrayLike, turn: float = 0.0) -> Trimesh:
    """Copy turned by ``turn``, rad, about z, then shifted, m."""
    c, s = np.cos(turn), np.sin(turn)
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return raw(mesh.vertices @ axes + np.asarray(shift, float), mesh.faces)


_BOX = np.array(
    [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ]
)
