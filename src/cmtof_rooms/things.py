"""What a room consists of: solids of one material, things made of them, lights, and places."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from trimesh import Trimesh

from cmtof.types import Array
from cmtof_rooms.boxes import Box, Vector
from cmtof_rooms.materials import Colour, Material
from cmtof_rooms.solids import join, move, slab, turn_about_z

Solid = Trimesh | Box


def meshes_of(solids: Iterable[Solid]) -> Iterator[Trimesh]:
    """Meshes of solids, one after the other; a box with arrays as limits becomes several."""
    for solid in solids:
        if isinstance(solid, Box):
            for single in solid.singles():
                yield slab(*single)
        else:
            yield solid


class Part(NamedTuple):
    """A solid of one material."""

    material: Material
    mesh: Trimesh


class Thing(NamedTuple):
    """Something with a name, made of parts, in the room's coordinates, m."""

    kind: str
    parts: list[Part]

    @property
    def bounds(self) -> Array:
        """Lowest and highest corner (2, 3), m."""
        return join(part.mesh for part in self.parts).bounds


class Place(NamedTuple):
    """A frame in a room, of a thing or a wall: its origin, m, and its turn about z, rad."""

    x: float
    y: float
    z: float = 0.0
    turn: float = 0.0

    def carry(self, points: ArrayLike) -> Array:
        """Points (..., 3), m, given in this frame, in the room's coordinates."""
        turned = np.asarray(points, float) @ turn_about_z(self.turn)
        return np.add(turned, self[:3])

    def at(self, x: float, y: float, z: float = 0.0, turn: float = 0.0) -> "Place":
        """Frame at a point of this one, m, turned by ``turn``, rad, relative to it."""
        return Place(*self.carry((x, y, z)), turn=self.turn + turn)

    def parts(self, material: Material, *solids: Solid) -> list[Part]:
        """Solids given in this frame, as parts of one material in the room's coordinates."""
        return [
            Part(material, move(mesh, self[:3], self.turn))
            for mesh in meshes_of(solids)
        ]


ROOM = Place(0.0, 0.0)  # the room's own frame


class Light(NamedTuple):
    """A rectangular light, m; a ``normal`` of zeros shines to all sides."""

    centre: Vector
    half_u: Vector
    half_v: Vector
    normal: Vector
    power: float  # W/sr, in the units of `cmtof_rooms.interior`
    colour: Colour = (1.0, 1.0, 1.0)


def level_light(
    centre: Vector,
    half: float,
    power: float,
    direction: float = -1.0,
) -> Light:
    """White square light of a half width, m, that shines up (1), down (-1), all round (0)."""
    return Light(
        centre,
        (half, 0, 0),
        (0, half, 0),
        (0, 0, direction),
        power,
    )
