"""Pieces of an object, and where they stand: before a wall, a metre in front of the instrument.

Things of the procedural rooms stand on z = 0 with their front towards -y; the instrument's x points
right, y down and z forward. Surfaces are fine meshes: a triangle of side L on a body of radius R
lies up to ``L^2 / (8 R)`` off it, 2 um for 1 mm on 6 cm.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.instrument.targets import MeshTarget, assembled
from cmtof.scenes.rooms.pliant import spline
from cmtof.scenes.rooms.solids import quads, revolve
from cmtof.scenes.rooms.thing import Mesh, Thing, transformed

Array = NDArray[np.float64]

DISTANCE = 1.0
"""From the instrument to the middle of an object, m."""
_WALL, _REACH = 0.3, 0.6  # m: from the middle to the wall behind it; half breadth of wall and table
_WALL_REFLECTANCE, _TABLE_REFLECTANCE = 0.55, 0.4  # grey paint, a pale board (assumed)


class Piece(NamedTuple):
    """A mesh in the room's axes, and what it is made of at 532 nm."""

    mesh: Mesh
    reflectance: float | Array
    """0 to 1; of all or of each vertex, shape (V,)."""
    mirrored: float = 0.0
    """Weight of the law of a specular surface, 0 to 1."""


def staged(
    pieces: list[Piece], *, middle: float, pitch: float, table: float | None = None
) -> MeshTarget:
    """Look at pieces on a table before a wall.

    Parameters
    ----------
    pieces : list of Piece
        Standing on z = 0.
    middle : float
        Height of the point that the axis meets at `DISTANCE`, m.
    pitch : float
        How far the axis points down, rad.
    table : float, optional
        Reflectance of the table's top.
    """
    bright = _TABLE_REFLECTANCE if table is None else table
    ends = (-_REACH, _REACH)
    board = quads([[(x, y, 0.0) for x, y in _around(ends, (-_REACH, _WALL))]])
    wall = quads([[(x, _WALL, z) for x, z in _around(ends, (-0.1, 2 * _REACH))]])
    every = [*pieces, Piece(board, bright), Piece(wall, _WALL_REFLECTANCE)]
    cos, sin = np.cos(pitch), np.sin(pitch)
    axes = np.array([(1, 0, 0), (0, -sin, -cos), (0, cos, -sin)])  # right, down, forward
    aim = np.array([0.0, 0.0, middle])
    return assembled([
        MeshTarget(
            (piece.mesh.vertices.astype(float) - aim) @ axes.T + [0, 0, DISTANCE],
            piece.mesh.faces,
            piece.reflectance,
            "mixed",
            piece.mirrored,
        )
        for piece in every
    ])  # fmt: skip


def _around(x: tuple[float, float], y: tuple[float, float]) -> list[tuple[float, float]]:
    return [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]


def lathe(profile: ArrayLike, *, sides: int = 240, count: int = 160) -> Mesh:
    """A body turned from a smooth curve through (radius, height), m, from its bottom to its top."""
    path = np.column_stack([np.asarray(profile, float), np.zeros(len(np.asarray(profile)))])
    curve = spline(path, count)[:, :2]
    return revolve(np.column_stack([np.maximum(curve[:, 0], 0.0), curve[:, 1]]), sides)


def refined(grid: ArrayLike, times: int) -> Array:
    """A closed surface's grid (N, M, 3) on a finer one, through cubic splines.

    Index 1 runs around and closes; index 0 ends at both ends.
    """
    from scipy.interpolate import make_interp_spline

    grid = np.asarray(grid, float)
    rows, columns = grid.shape[:2]
    fine = np.linspace(0, rows - 1, times * (rows - 1) + 1)
    along = make_interp_spline(np.arange(rows), grid, k=3, axis=0)(fine)
    ring = np.concatenate([along, along[:, :1]], axis=1)
    around = make_interp_spline(np.arange(columns + 1), ring, k=3, axis=1, bc_type="periodic")
    return around(np.arange(times * columns) / times)


def smoothed(mesh: Mesh, times: int) -> Mesh:
    """A mesh's smooth limit, nearly: each face cut in four so often (Loop, 1987); creases stay."""
    from trimesh.remesh import subdivide_loop

    vertices, faces = subdivide_loop(mesh.vertices.astype(float), mesh.faces, iterations=times)
    return Mesh(vertices.astype(np.float32), faces.astype(np.int32))


def pieces_of(thing: Thing, motion: Array, *, smooth: tuple[int, ...] = ()) -> list[Piece]:
    """Pieces of a room's thing, moved by a pose, the parts of such numbers smoothed.

    Green stands for 532 nm, the mean of its two colours for a pattern.
    """
    made = []
    for number, part in enumerate(thing.parts):
        stuff = part.material
        green = [stuff.colour[1], stuff.colour[1] if stuff.pattern == "plain" else stuff.second[1]]
        mesh = smoothed(part.mesh, 3) if number in smooth else part.mesh
        moved = Mesh(transformed(mesh.vertices, motion).astype(np.float32), mesh.faces)
        made.append(Piece(moved, float(np.mean(green)), float(min(stuff.specular, 1.0))))
    return made
