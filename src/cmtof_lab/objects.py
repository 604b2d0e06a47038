"""Objects in front of the instrument, as Figs. 1 and 14 to 16 show them; all of them our own.

Meshes lie in the instrument's axes (m; x right, y down, z forward); vertices carry ``reflectance``
at 532 nm and ``mirrored``, the weight of a specular law against a diffuse one, both 0 to 1.
Triangles of side L lie up to ``L^2 / (8 R)``, 2 um, off a body of radius R.
"""

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.linalg import norm
from numpy.random import Generator
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation
from trimesh import Trimesh
from trimesh.creation import box, cylinder, icosphere, torus
from trimesh.transformations import rotation_matrix
from trimesh.util import concatenate

from cmtof.types import Array, Fields, Shape
from cmtof_lab import finishes
from cmtof_lab.finishes import CATALOGUE
from cmtof_rooms.solids import cells_of, mesh_from, triangles_of

STEEL = 0.58  # reflectance of polished or lapped steel (known: 0.55 to 0.6)
DISTANCE = 0.9  # from the instrument to the middle of an object, m
WALL = 0.25  # from there to the wall behind, m
WIDTH = 9e-3  # face of a gauge block up to 10 mm long, m (known)
HEIGHT = 30e-3  # m (known)
# Greatest error of such a length, m (DIN 861, grade 2, by makers' tables)
GRADE_2 = 0.45e-6
MIRRORED = 0.7  # specular weight of a block (assumed): lapping leaves a matt sheen

# Objects on whose scans a network is fine-tuned (Sec. 6.4).
TRAINING = CATALOGUE["training"]

# Scanned objects by name, as `objects.yml` describes them.
OBJECTS = CATALOGUE["objects"] | TRAINING

# Full angle, rad, in which an object is scanned.
FIELD_OF_VIEW = {name: one["field_of_view"] for name, one in OBJECTS.items()}


@lru_cache(maxsize=4)
def object_mesh(name: str) -> Trimesh:
    """Mesh of one of `OBJECTS` about 0.9 m before the instrument, on a table before a wall.

    Ranges within the field of view are 0.75 to 1.20 m: the wraps 36 to 56.
    """
    held = OBJECTS[name]
    mesh = _stage(map(_piece, held["pieces"]), 1.2, WALL, 0.4, 0.55)
    return _place_scene(
        mesh, held["pitch"], held["middle"], held.get("distance", DISTANCE)
    )


def still_life(
    stated: Sequence[Iterable[Fields]], rng: Generator
) -> tuple[Trimesh, float]:
    """Mesh of things made of pieces, posed at random on a table, and its field of view, rad."""
    pitch = rng.uniform(0.04, 0.55)
    many = len(stated) > 1
    places = rng.permutation(np.linspace(-0.1, 0.1, len(stated)) * many)
    places += rng.uniform(-0.04, 0.04, len(stated))
    things = [_pose(one, x, many, rng) for x, one in zip(places, stated, strict=True)]
    mesh = _stage(things, 1.6, *rng.uniform([0.16, 0.15, 0.15], [0.27, 0.7, 0.8]))
    turn = rng.normal(0, 0.12)
    share, farther, view = rng.uniform([0.35, -0.03, 0.32], [0.65, 0.02, 0.43])
    middle = share * max(thing.bounds[1, 2] for thing in things)
    return _place_scene(mesh, pitch, middle, DISTANCE + farther, turn), view


def _pose(pieces: Iterable[Fields], x: float, many: bool, rng: Generator) -> Any:
    """Mesh of a thing, stretched, turned and, one in five, laid down; smaller if ``many``."""
    size = rng.uniform(0.75 - 0.25 * many, 1.15 - 0.2 * many)
    mesh: Any = concatenate([_refinish(_piece(one), rng) for one in pieces])
    points = mesh.vertices * size * rng.uniform(0.8, 1.25, 3)
    laid = rng.choice([90, -90]) if rng.uniform() < 0.2 else 0
    turn = Rotation.from_euler("xz", [laid, rng.uniform(-180, 180)], degrees=True)
    mesh.vertices = turn.apply(points)
    foot = mesh.bounds.mean(0)
    foot[2] = mesh.bounds[0, 2]
    room = 0.15 - mesh.extents[1] / 2
    y = 0.01 + rng.uniform(-room, room) if room > 0 else 0
    return mesh.apply_translation([x, y, 0] - foot)


def _refinish(piece: Trimesh, rng: Generator) -> Trimesh:
    """The piece, made darker or brighter at random and, one in five, more or less polished."""
    held = piece.vertex_attributes
    brighter = held["reflectance"] * np.exp(rng.uniform(-0.8, 0.8))
    held["reflectance"] = brighter.clip(0.03, 0.85)
    if rng.uniform() < 0.2:
        held["mirrored"][:] = rng.choice([0, 0.15, 0.6, 0.95])
    return piece


def _stage(things: Iterable[Trimesh], wide: float, wall: float, *looks: float) -> Any:
    """Mesh of things on a table before a wall at y = ``wall``, m; ``looks``: both reflectances."""
    board = _box((wide, 0.75 * wide, 0.01))
    back = _box((wide, 0.01, wide))
    return concatenate(
        [
            *things,
            _finish(board, looks[0], at=(0, -wide / 8, -0.01)),
            _finish(back, looks[1], at=(0, wall + 0.005, -0.1)),
        ]
    )


def _place_scene(
    mesh: Any,
    pitch: float,
    middle: float,
    distance: float,
    turn: float = 0,
) -> Trimesh:
    """A scene in the instrument's axes: turned, and looked down at by ``pitch``, rad."""
    way = Rotation.from_euler("zx", [turn, np.pi / 2 + pitch])
    mesh.vertices = way.apply(mesh.vertices - [0, 0, middle])
    return mesh.apply_translation([0, 0, distance])


def gage_blocks(
    step: float,
    distance: float,
    *,
    tilt: float,
    errors: Sequence[float],
) -> Trimesh:
    """Measuring faces of two gauge blocks, wrung on a mount side by side (Fig. 14).

    The left face meets the axis at ``distance``, m; the right one stands nearer by ``step``. Both
    lengths are off by ``errors``, and ``tilt``, rad, keeps the mirror image off the instrument.
    """
    x = np.array([0, -1, -1, 0, 0, 1, 1, 0]) * WIDTH
    y = np.tile([-0.5, -0.5, 0.5, 0.5], 2) * HEIGHT
    lengths = np.repeat(np.add([0, step], errors), 4)
    # the step is the distance of the two parallel faces, along their normal
    z = distance + np.tan(tilt) * x - lengths / np.cos(tilt)
    faces = triangles_of(np.arange(8).reshape(2, 4))
    return _finish(mesh_from(np.transpose([x, y, z]), faces), STEEL, MIRRORED)


def _piece(stated: Fields) -> Trimesh:
    """A piece of an object as ``objects.yml`` states it."""
    (kind,) = SHAPES.keys() & stated
    place = {key: stated[key] for key in ("mirrored", "at", "turn") if key in stated}
    look = getattr(finishes, str(stated["look"]), stated["look"])
    return _finish(SHAPES[kind](stated), look, **place)


def _finish(
    shape: Trimesh,
    look: Any,
    mirrored: float = 0,
    at: ArrayLike = (0, 0, 0),
    turn: float = 0,
) -> Trimesh:
    """Mesh of a shape, turned and moved, with reflectance: a number, or a function of x, y, z."""
    points = shape.vertices
    seen = look(*points.T) if callable(look) else look
    held = {
        "reflectance": np.full(len(points), seen, float),
        "mirrored": np.full(len(points), mirrored, float),
    }
    moved = Rotation.from_euler("z", turn).apply(points) + at
    return Trimesh(moved, shape.faces, process=False, vertex_attributes=held)  # pyright: ignore[reportArgumentType]


def _body(stated: Fields) -> Trimesh:
    """A smooth upright body by its profile, or by the name of one."""
    sections = np.array(finishes.by_name("profiles", stated["body"]), float)
    return _lathe(sections * stated.get("scale", 1.0), stated)


def _ellipsoid(stated: Fields) -> Trimesh:
    """An ellipsoid about the origin with half axes x, y, z, m."""
    x, y, z = stated["ellipsoid"]
    angle = np.linspace(-np.pi / 2, np.pi / 2, 81)
    breadths = np.outer(np.cos(angle), (x, y, y))
    return _lathe(np.column_stack([z * np.sin(angle), breadths]), stated)


def _box(size: Sequence[float]) -> Trimesh:
    """A box of sides x, y, z, m, that stands on z = 0."""
    return box(size).apply_translation([0, 0, size[2] / 2])


def _rod(stated: Fields) -> Trimesh:
    """A round rod from left to right: length and radius, m."""
    length, radius = stated["rod"]
    return cylinder(
        radius, sections=240, segment=[(-length / 2, 0, 0), (length / 2, 0, 0)]
    )


UPRIGHT = rotation_matrix(-np.pi / 2, [1, 0, 0])  # of a ring
# Makers of the shapes of `objects.yml`.
SHAPES = {
    "body": _body,
    "ellipsoid": _ellipsoid,
    "box": lambda stated: _box(stated["box"]),
    "sphere": lambda stated: icosphere(6, stated["sphere"]),
    "torus": lambda stated: torus(*stated["torus"], 160, 96, UPRIGHT),  # pyright: ignore[reportCallIssue]
    "rod": _rod,
}


def _lathe(sections: Array, stated: Fields) -> Trimesh:
    """Body of sections (height, half breadth, front, back), with its relief and its holes."""
    x, y, z = _skin(sections, stated.get("grid", (240, 400)))
    if "relief" in stated:
        out = finishes.relief(stated["relief"], x, y, z)
        grow = 1 + out / np.hypot(x, y).clip(0.01)
        x *= grow
        y *= grow
    points = np.dstack([x, y, z]).reshape(-1, 3)
    number = np.arange(x.size).reshape(x.shape)
    ring = np.hstack([number, number[:, :1]])
    corners = cells_of(ring)[..., [0, 3, 2, 1]].reshape(-1, 4)
    if "holes" in stated:
        holes = finishes.by_name("openings", stated["holes"])
        corners = corners[~finishes.openings(holes, *points[corners].mean(1).T)]
    return mesh_from(points, triangles_of(corners))


def _skin(sections: Array, grid: Shape) -> tuple[Array, Array, Array]:
    """Coordinates (rows, columns) of a body's skin, evenly along its profile and around it."""
    path = np.take(sections, range(4), axis=1, mode="clip")
    lengths = norm(np.diff(path[:, :2], axis=0), axis=1)
    along = np.append(0, lengths.cumsum())
    profile = PchipInterpolator(along, path)(np.linspace(0, along[-1], grid[0]))
    z, side, front, back = np.repeat(profile.T[..., None], grid[1], axis=2)
    turn = np.linspace(-np.pi, np.pi, grid[1], endpoint=False)  # 0 is the front
    reach = np.where(np.cos(turn) > 0, -front, -back)
    return side * np.sin(turn), reach * np.cos(turn), z
