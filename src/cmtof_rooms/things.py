"""What a room consists of: solids of one material, things made of them, and lights."""

from typing import NamedTuple

from trimesh import Trimesh

from cmtof.types import Array
from cmtof_rooms.arrays import Vector
from cmtof_rooms.materials import Colour, Material
from cmtof_rooms.solids import join


class Part(NamedTuple):
    """A solid of one material."""

    mesh: Trimesh
    material: Material


class Thing(NamedTuple):
    """Something with a name, made of parts, in the room's coordinates, m."""

    kind: str
    parts: list[Part]

    @property
    def bounds(self) -> Array:
        """Lowest and highest corner (2, 3), m."""
        return join(part.mesh for part in self.parts).bounds


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
    half_x: float,
    half_y: float,
    power: float,
    direction: float = -1.0,
) -> Light:
    """White light of half widths along x and y, m, that shines up (1), down (-1), all round (0)."""
    return Light(
        centre,
        (half_x, 0, 0),
        (0, half_y, 0),
        (0, 0, direction),
        power,
    )
