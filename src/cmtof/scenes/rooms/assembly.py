"""Things and poses -> one array of triangles, with what each is made of."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cmtof.scenes.rooms.materials import PATTERNS, Material
from cmtof.scenes.rooms.meshing import vertex_normals
from cmtof.scenes.rooms.thing import Light, Part, Pose, Thing, pose, transformed

LONGEST_EDGE = 0.6
"""Triangles with longer edges are divided, m: light is stored a triangle."""

MATERIAL = np.dtype(
    [
        ("colour", np.float32, 3),
        ("second", np.float32, 3),
        ("pattern", np.int32),
        ("scale", np.float32),
        ("specular", np.float32),
        ("gloss", np.float32),
        ("emission", np.float32),
        ("bump", np.float32),
        ("from_world", np.float32, (3, 4)),
    ]
)
"""A part's material, and the affine map from the world, m, into repeats of its pattern."""

LIGHT = np.dtype(
    [
        ("centre", np.float32, 3),
        ("half_u", np.float32, 3),
        ("half_v", np.float32, 3),
        ("normal", np.float32, 3),
        ("colour", np.float32, 3),
        ("power", np.float32),
    ]
)


@dataclass(frozen=True)
class Geometry:
    """All triangles of a scene; P parts, T triangles, V vertices, L lights, world z up, m."""

    vertices: NDArray[np.float32]
    """(V, 3)."""
    faces: NDArray[np.int32]
    """(T, 3)."""
    normals: NDArray[np.float32]
    """(V, 3) unit, for shading only."""
    part: NDArray[np.int32]
    """(T,) part of each triangle."""
    materials: NDArray[np.void]
    """(P,) of `MATERIAL`."""
    instance: NDArray[np.int32]
    """(P,) thing of each part, from 1 on."""
    kinds: tuple[str, ...]
    """Name of every thing; ``kinds[i - 1]`` belongs to instance i."""
    lights: NDArray[np.void]
    """(L,) of `LIGHT`."""
    outdoors: "Outdoors"


@dataclass(frozen=True)
class Outdoors:
    """What lies beyond the walls: sky and sun."""

    house: tuple[float, float, float, float] = (-np.inf, np.inf, -np.inf, np.inf)
    """x and y within which the sky is seen through windows only, m."""
    sky: float = 0.0
    """Radiance of the sky, and of every ray that meets nothing."""
    towards_sun: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Unit vector."""
    sun: float = 0.0
    """Irradiance of a surface that faces the sun."""


def assemble(
    placed: list[tuple[Thing, Pose]],
    *,
    rng: np.random.Generator,
    lights: list[Light] | None = None,
    outdoors: Outdoors | None = None,
) -> Geometry:
    """Gather every part of every thing into one set of triangles.

    Parameters
    ----------
    placed : list of (Thing, Pose)
        What stands where.
    rng : Generator
        Shifts each part's pattern, so that no two boards show the same grain.
    lights : list of Light
        Lights beyond those that the things bring along, in the world.
    outdoors : Outdoors, optional
        Sky and sun; darkness by default.
    """
    kinds: list[str] = []
    parts: list[tuple[Part, Pose, int]] = []
    shining: list[tuple[Light, Pose]] = [(light, pose()) for light in lights or []]
    for thing, motion in placed:
        for one, at in _flattened(thing, motion):
            kinds.append(one.kind)
            parts += [(part, at, len(kinds)) for part in one.parts]
            shining += [(light, at) for light in one.lights]
    meshes = [part.mesh for part, _, _ in parts]
    moved = [transformed(mesh.vertices, at) for mesh, (_, at, _) in zip(meshes, parts, strict=True)]
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    faces = np.concatenate([m.faces + s for m, s in zip(meshes, starts, strict=True)])
    numbers = np.repeat(np.arange(len(parts), dtype=np.int32), [len(m.faces) for m in meshes])
    vertices, faces, parents = subdivided(np.concatenate(moved), faces, LONGEST_EDGE)
    vertices, faces = vertices.astype(np.float32), faces.astype(np.int32)
    return Geometry(
        vertices,
        faces,
        vertex_normals(vertices, faces),
        numbers[parents],
        np.array([_material(part, at, rng) for part, at, _ in parts], MATERIAL),
        np.array([number for *_, number in parts], np.int32),
        tuple(kinds),
        np.array([_light(light, at) for light, at in shining], LIGHT),
        outdoors or Outdoors(),
    )


def counted(thing: Thing) -> int:
    """How many instances a thing makes: itself and all that it carries."""
    return 1 + sum(counted(child) for child, _ in thing.children)


def _flattened(thing: Thing, motion: Pose) -> Iterator[tuple[Thing, Pose]]:
    yield thing, motion
    for child, at in thing.children:
        yield from _flattened(child, motion @ at)


def subdivided(
    vertices: NDArray[np.float64], faces: NDArray[np.integer], longest: float
) -> tuple[NDArray[np.float64], NDArray[np.integer], NDArray[np.intp]]:
    """Halve every edge longer than ``longest``, m, until none is; neighbours stay joined.

    Returns
    -------
    vertices, faces
        The old vertices come first.
    parents : ndarray, shape (T,)
        Face that each new one is a piece of.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    >>> v, f, parents = subdivided(corners, np.array([[0, 1, 2]]), 0.8)
    >>> len(v), len(f), parents.tolist()
    (6, 4, [0, 0, 0, 0])
    """
    parents = np.arange(len(faces))
    done: list[tuple[NDArray, NDArray]] = []
    while len(faces):
        ends = faces[:, [[0, 1], [1, 2], [2, 0]]]  # (T, 3, 2)
        spans = vertices[ends[..., 1]] - vertices[ends[..., 0]]
        long = np.einsum("tek,tek->te", spans, spans) > longest**2
        touched = long.any(axis=1)
        # a face without a long edge is finished: its edges will not be halved any more
        done.append((faces[~touched], parents[~touched]))
        if not touched.any():
            break
        low, high = ends[long].min(axis=-1).astype(np.int64), ends[long].max(axis=-1)
        keys, which = np.unique(low * len(vertices) + high, return_inverse=True)
        middle = np.zeros(long.shape, np.int64)
        middle[long] = len(vertices) + which
        first, last = np.divmod(keys, len(vertices))
        vertices = np.concatenate([vertices, (vertices[first] + vertices[last]) / 2])
        faces, pieces = _divide(faces[touched], long[touched], middle[touched])
        parents = parents[touched][pieces]
    kept = [np.concatenate(both) for both in zip(*done, strict=True)]
    return vertices, kept[0], kept[1]


def _divide(
    faces: NDArray, long: NDArray[np.bool_], middle: NDArray[np.int64]
) -> tuple[NDArray, NDArray[np.intp]]:
    """Two to four triangles for each, by which of its edges are halved; and whose they are."""
    made, whose = [], []
    for count in (1, 2, 3):
        chosen = np.flatnonzero(long.sum(axis=1) == count)
        if not len(chosen):
            continue
        # turn each triangle until its first edge is long and, of two, the last is not
        first = np.argmax(long[chosen] & ~np.roll(long[chosen], 1, 1), axis=1)
        order = (first[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(faces[chosen], order, 1).T
        m, n, o = np.take_along_axis(middle[chosen], order, 1).T
        pieces = {
            1: [(a, m, c), (m, b, c)],
            2: [(a, m, c), (m, b, n), (m, n, c)],
            3: [(a, m, o), (m, b, n), (o, n, c), (m, n, o)],
        }[count]
        made += [np.stack(piece, -1) for piece in pieces]
        whose += [chosen] * len(pieces)
    return np.concatenate(made), np.concatenate(whose)


def _material(part: Part, at: Pose, rng: np.random.Generator) -> tuple:
    material: Material = part.material
    inverse = np.linalg.inv(at)[:3]
    order = [part.grain, (part.grain + 1) % 3, (part.grain + 2) % 3]
    from_world = inverse[order] / material.scale
    # whole repeats: tiles and checks keep their place, grain and noise show another piece
    from_world[:, 3] += rng.integers(0, 64, 3)
    return (
        material.colour,
        material.second,
        PATTERNS.index(material.pattern),
        material.scale,
        material.specular,
        material.gloss,
        material.emission,
        material.bump,
        from_world,
    )


def _light(light: Light, at: Pose) -> tuple:
    turn = at[:3, :3]
    vectors = (turn @ np.asarray(v) for v in (light.half_u, light.half_v, light.normal))
    return (transformed(light.centre, at), *vectors, light.colour, light.power)
