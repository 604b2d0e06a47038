"""Solids of rooms: a few closed shapes on trimesh, in metres, z up."""

from collections.abc import Iterable
from itertools import product

import numpy as np
import trimesh
from numpy.lib.stride_tricks import sliding_window_view
from numpy.random import Generator
from numpy.typing import ArrayLike
from trimesh import Trimesh

from cmtof.types import Array, Numbers
from cmtof_rooms.boxes import Box

# Corners of a unit cube about the origin.
_CORNERS = np.indices((2, 2, 2)).reshape(3, 8).T - 0.5

# Corners of each side of the cube, counter-clockwise from outside.
_SIDES = [
    [0, 1, 3, 2],
    [4, 6, 7, 5],
    [0, 4, 5, 1],
    [2, 3, 7, 6],
    [0, 2, 6, 4],
    [1, 5, 7, 3],
]

# Corners of a quadrilateral that make its two triangles.
_HALVES = [[0, 1, 2], [0, 2, 3]]

_BOX_FACES = np.array(_SIDES)[:, _HALVES].reshape(12, 3)


def mesh_from(vertices: Array, faces: ArrayLike) -> Trimesh:
    """Mesh of vertices (V, 3), m, and triangles (F, 3), which stay as they are."""
    return Trimesh(vertices, faces, process=False)


def slab(*limits: float) -> Trimesh:
    """Box between limits x0, x1, y0, y1, z0, z1, m.

    >>> slab(0, 1, 0, 2, 1, 4).bounds.tolist()
    [[0.0, 0.0, 1.0], [1.0, 2.0, 4.0]]
    """
    box = Box(*limits)
    return mesh_from(box.middle + _CORNERS * box.size, _BOX_FACES)


def extrusion(outline: ArrayLike, height: float) -> Trimesh:
    """Prism over an outline (N, 2), m, counter-clockwise and star-shaped about its mean.

    >>> round(float(extrusion([(0, 0), (2, 0), (0, 1)], 3.0).volume), 6)
    3.0
    """
    flat = np.asarray(outline, float)
    ring = np.arange(len(flat))
    faces = _join_corners(len(flat), ring, np.roll(ring, -1))
    points = np.vstack([flat, flat.mean(0)])
    return trimesh.creation.extrude_triangulation(points, faces, height)


def ellipse(size: ArrayLike, sections: int = 32) -> Array:
    """Outline (N, 2) of an ellipse of a size (x, y) about the origin, m."""
    turn = 2 * np.pi * np.arange(sections) / sections
    return np.stack([np.cos(turn), np.sin(turn)], 1) * np.divide(size, 2)


def plate(
    width: float,
    height: float,
    thickness: float,
    holes: ArrayLike = (),
) -> Trimesh:
    """Upright plate over x in [0, width], z in [0, height], y in [0, thickness], with holes.

    Parameters
    ----------
    width, height, thickness : float
        m.
    holes : array_like, shape (N, 4)
        Limits x0, x1, z0, z1 of rectangles cut out of it, m; they may touch the plate's edge.

    Returns
    -------
    Trimesh

    Examples
    --------
    >>> wall = plate(4.0, 2.5, 0.2, [(1.0, 2.0, 0.0, 2.0)])
    >>> wall.is_watertight, round(float(wall.volume), 6)
    (True, 1.6)
    """
    cut = np.reshape(holes, (-1, 2, 2)).clip(0, [[width], [height]])
    x = np.unique([0.0, width, *cut[:, 0].flat])
    z = np.unique([0.0, height, *cut[:, 1].flat])
    points = np.array([*product(x, z)])
    cells = cells_of(np.arange(len(points)).reshape(len(x), -1)).reshape(-1, 4)
    corner = points[cells[:, 0], None]  # the lowest one of each cell
    cut_out = ((cut[..., 0] <= corner) & (corner < cut[..., 1])).all(-1).any(-1)
    flat = trimesh.creation.extrude_triangulation(
        points,
        triangles_of(cells[~cut_out]),
        thickness,
    )
    # (x, z, y) to (x, y, z) is a reflection
    return mesh_from(flat.vertices[:, [0, 2, 1]], flat.faces[:, ::-1])


def cells_of(number: Numbers) -> Numbers:
    """Corners (N - 1, M - 1, 4), in turn, of the cells of a grid of numbered points (N, M)."""
    squares = sliding_window_view(number, (2, 2))
    return squares.reshape(*squares.shape[:2], 4)[..., [0, 2, 3, 1]]


def triangles_of(cells: Numbers) -> Numbers:
    """Triangles (2 N, 3) of cells (N, 4): first one half of each, then the other."""
    return np.concatenate([cells[:, half] for half in _HALVES])


def _join_corners(first: Numbers | int, second: Numbers, third: Numbers) -> Numbers:
    """Triangles (N, 3) of N first, second and third corners, or of one first corner for all."""
    return np.stack(np.broadcast_arrays(first, second, third), 1)


def revolution(profile: ArrayLike, sections: int = 28) -> Trimesh:
    """Solid of revolution about z of a profile (N, 2) of radius and height, m, bottom to top.

    Ends that do not lie on the axis are joined to it.

    >>> cone = revolution([(1.0, 0.0), (0.0, 3.0)], sections=720)
    >>> bool(abs(cone.volume - np.pi) < 1e-3)
    True
    """
    rings = np.pad(np.asarray(profile, float), [(1, 1), (0, 0)], "edge")
    rings[[0, -1], 0] = 0.0
    return trimesh.creation.revolve(rings, sections=sections)


def sweep(path: ArrayLike, radius: float, sections: int = 10) -> Trimesh:
    """Round bar along a path (N, 3), m, of a radius, m.

    >>> bar = sweep([(0, 0, 0), (0, 0, 2)], 0.1, sections=400)
    >>> bar.is_watertight, round(float(bar.volume) / (2 * np.pi * 0.01), 3)
    (True, 1.0)
    """
    line = np.asarray(path, float)
    rings = line[:, None] + radius * _circles(line, sections)
    vertices = np.concatenate([rings.reshape(-1, 3), line[[0, -1]]])
    number = np.arange(rings[..., 0].size).reshape(-1, sections)
    closed = np.hstack([number, number[:, :1]])
    cells = cells_of(closed)[..., [0, 3, 2, 1]]
    faces = [
        triangles_of(cells.reshape(-1, 4)),
        _join_corners(len(vertices) - 2, closed[0, 1:], closed[0, :-1]),
        _join_corners(len(vertices) - 1, closed[-1, :-1], closed[-1, 1:]),
    ]
    return mesh_from(vertices, np.concatenate(faces))


def _circles(line: Array, sections: int) -> Array:
    """Unit circles (N, sections, 3) across a path (N, 3)."""
    along = trimesh.unitize(np.gradient(line, axis=0))
    # one axis that no part of the path follows serves all rings
    aside = np.eye(3)[np.abs(along).max(axis=0).argmin()]
    u = np.asarray(trimesh.unitize(np.cross(along, aside)))
    v = np.cross(along, u)
    cosine, sine = ellipse((2, 2), sections).T[:, :, None]
    return cosine * u[:, None] + sine * v[:, None]


def ball(
    radius: ArrayLike,
    *,
    noise: float = 0.0,
    rng: Generator | None = None,
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
    rng : Generator, optional
        Random numbers for the bumps.
    fineness : int
        Subdivisions of an icosahedron: 320 triangles for 2.
    squareness : float
        0 for an ellipsoid; towards 1 for a rounded box (a superellipsoid), as of a cushion.

    Returns
    -------
    Trimesh

    Examples
    --------
    >>> ball(1.0, fineness=4).is_watertight
    True
    """
    unit = trimesh.creation.icosphere(fineness)
    points = np.array(unit.vertices)
    if squareness:
        power = 2 / (1 - squareness)
        points /= np.linalg.norm(points, power, axis=1, keepdims=True)
    if rng is not None and noise:
        waves = rng.normal(0, 3.0, (6, 3))
        phase = rng.uniform(0, 2 * np.pi, 6)
        bumps = np.cos(points @ waves.T + phase).mean(axis=1, keepdims=True)
        points *= 1 + noise * bumps
    return mesh_from(np.multiply(points, radius), unit.faces)


def sheet(grid: ArrayLike, thickness: float) -> Trimesh:
    """Closed sheet over a grid of points (N, M, 3), m, thick along the grid's mean normal.

    >>> x, y = np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0], indexing="ij")
    >>> cloth = sheet(np.stack([x, y, 0 * x], -1), 0.01)
    >>> cloth.is_watertight, round(float(cloth.volume), 6)
    (True, 0.02)
    """
    points = np.asarray(grid, float)
    diagonal = points[-1, -1] - points[0, 0]
    normal = np.cross(points[-1, 0] - points[0, -1], diagonal)
    back = points - thickness * normal / np.linalg.norm(normal)
    number = np.arange(points[..., 0].size).reshape(points.shape[:2])
    behind = number.size
    front = triangles_of(cells_of(number).reshape(-1, 4))
    # the four sides in turn, each without its last point
    rim = np.concatenate([np.rot90(number, -side)[:-1, 0] for side in range(4)])
    following = np.roll(rim, -1)
    faces = [
        front,
        front[:, ::-1] + behind,
        _join_corners(rim, rim + behind, following),
        _join_corners(following, rim + behind, following + behind),
    ]
    return mesh_from(
        np.concatenate([points, back]).reshape(-1, 3),
        np.concatenate(faces),
    )


def join(meshes: Iterable[Trimesh]) -> Trimesh:
    """Several solids as one mesh."""
    return trimesh.util.concatenate(list(meshes))  # pyright: ignore[reportReturnType]


def move(mesh: Trimesh, shift: ArrayLike, turn: float = 0.0) -> Trimesh:
    """Copy turned by ``turn``, rad, about z, then shifted, m."""
    turned = mesh.vertices @ turn_about_z(turn)
    return mesh_from(np.add(turned, shift), mesh.faces)


def turn_about_z(turn: float) -> Array:
    """Matrix (3, 3) that turns row vectors by ``turn``, rad, about z."""
    cosine = np.cos(turn)
    sine = np.sin(turn)
    return np.array(
        [
            [cosine, sine, 0.0],
            [-sine, cosine, 0.0],
            [0.0, 0.0, 1.0],
        ]
    )
