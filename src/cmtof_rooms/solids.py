"""Solids of rooms: a few closed shapes on trimesh, in metres, z up."""

from collections.abc import Iterable, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import trimesh
from numpy.random import Generator
from numpy.typing import ArrayLike
from trimesh import Trimesh

from cmtof.types import Array, Numbers

_CUBE = trimesh.creation.box(bounds=[[0, 0, 0], [1, 1, 1]])
_CORNERS = np.array(_CUBE.vertices, int)


def mesh_from(vertices: Array, faces: Numbers) -> Trimesh:
    """Mesh of vertices (V, 3), m, and triangles (F, 3), which stay as they are."""
    return Trimesh(vertices, faces, process=False)


def slab(*limits: ArrayLike) -> Trimesh:
    """Box between limits x0, x1, y0, y1, z0, z1, m; several from arrays.

    >>> slab(0, 1, 0, 2, 1, 4).bounds.tolist()
    [[0.0, 0.0, 1.0], [1.0, 2.0, 4.0]]
    >>> float(slab(0, 1, 0, 2, [0, 2], [1, 3]).volume)
    4.0
    """
    ends = np.stack(np.broadcast_arrays(*limits), -1).reshape(-1, 3, 2)
    corners = ends[:, range(3), _CORNERS]
    first = 8 * np.arange(len(ends))[:, None, None]
    return mesh_from(corners.reshape(-1, 3), (_CUBE.faces + first).reshape(-1, 3))


def plate(
    width: float,
    height: float,
    thickness: float,
    holes: Sequence[Sequence[float]] = (),
) -> Trimesh:
    """Upright plate over x in [0, width], z in [0, height], y in [0, thickness], with holes.

    Parameters
    ----------
    width, height, thickness : float
        m.
    holes : sequence of (x0, x1, z0, z1)
        Rectangles cut out of it, m; they may touch the plate's edge.

    Returns
    -------
    Trimesh
        Boxes side by side.

    Examples
    --------
    >>> wall = plate(4.0, 2.5, 0.2, [(1.0, 2.0, 0.0, 2.0)])
    >>> wall.is_watertight, round(float(wall.volume), 6)
    (True, 1.6)
    """
    cut = np.array(holes, float).reshape(-1, 4)
    x = _lines(width, cut[:, :2])
    z = _lines(height, cut[:, 2:])
    solid = np.ones((len(x) - 1, len(z) - 1), bool)
    for hole in cut:
        columns = slice(*np.searchsorted(x, hole[:2]))
        solid[columns, slice(*np.searchsorted(z, hole[2:]))] = False
    i, k = np.nonzero(solid)
    return slab(x[i], x[i + 1], 0, thickness, z[k], z[k + 1])


def _lines(length: float, edges: Array) -> Array:
    """Positions of grid lines: both ends and every edge of a hole between them."""
    every = np.append(edges, [0.0, length])
    return np.unique(np.clip(every, 0, length))


def revolution(profile: ArrayLike, sections: int = 32) -> Trimesh:
    """Solid of revolution about z of a profile (N, 2) of radius and height, m, bottom to top.

    Ends that do not lie on the axis are joined to it.

    >>> cone = revolution([(1.0, 0.0), (0.0, 3.0)], sections=720)
    >>> bool(abs(cone.volume - np.pi) < 1e-3)
    True
    """
    rings = np.asarray(profile, float)
    ends = rings[[0, -1]] * [0, 1]
    whole = np.vstack([ends[:1], rings, ends[1:]])
    return trimesh.creation.revolve(whole, sections=sections)


def bar(path: ArrayLike, radius: float) -> Trimesh:
    """Round bars of a radius, m, from point to point of a path (N, 3), m.

    >>> bool(bar([(0, 0, 0), (0, 0, 2)], 0.1).is_watertight)
    True
    """
    cylinder = partial(trimesh.creation.cylinder, radius, sections=8)
    return join(cylinder(segment=ends) for ends in pairwise(np.asarray(path)))


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
    unit = trimesh.creation.icosphere(subdivisions=fineness)
    points = np.array(unit.vertices)
    if squareness:
        power = 2 / (1 - squareness)
        total = (np.abs(points) ** power).sum(axis=1, keepdims=True)
        points /= total ** (1 / power)
    if rng is not None and noise:
        waves = rng.normal(0, 3.0, (6, 3))
        phase = rng.uniform(0, 2 * np.pi, 6)
        bumps = np.cos(points @ waves.T + phase).mean(axis=1, keepdims=True)
        points *= 1 + noise * bumps
    return mesh_from(points * np.broadcast_to(radius, 3), unit.faces)


def join(solids: Iterable[Any]) -> Trimesh:
    """Several solids as one mesh; one that is no mesh has the limits of a `slab`."""
    meshes = [one if isinstance(one, Trimesh) else slab(*one) for one in solids]
    vertices = [one.vertices for one in meshes]
    faces = [one.faces for one in meshes]
    return mesh_from(*trimesh.util.append_faces(vertices, faces))


def scaled(mesh: Trimesh, size: ArrayLike) -> Trimesh:
    """Copy that is larger by factors along x, y and z."""
    return mesh_from(np.asarray(mesh.vertices) * size, mesh.faces)


def move(mesh: Trimesh, shift: ArrayLike, turn: float = 0.0) -> Trimesh:
    """Copy turned by ``turn``, rad, about z, then shifted, m."""
    turned = mesh.vertices @ turn_about_z(turn)
    return mesh_from(turned + np.asarray(shift, float), mesh.faces)


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
