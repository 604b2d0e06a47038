"""Free places in a room: on the floor, before or on a wall, under the ceiling."""

from dataclasses import dataclass, field

import numpy as np

from cmtof.types import Array, Fields
from cmtof_rooms.boxes import Rectangle, Rectangles
from cmtof_rooms.kit import Kit, weighted_choice
from cmtof_rooms.shell import Shell, Wall
from cmtof_rooms.solids import turn_about_z
from cmtof_rooms.things import Light, Place

Kind = Fields  # one of the ``kinds`` of `presets.yml`

Extents = Array  # width, depth, height, m

TRIES = 14  # places that are tried for one thing before it is left out


def turned_size(size: Extents, turn: float) -> Array:
    """Size along x and y, m, of a box that is turned by ``turn``, rad, about z."""
    return np.abs(turn_about_z(turn)[:2]) @ size


@dataclass
class Vacancy:
    """What of a room is still free.

    Attributes
    ----------
    shell : Shell
    kit : Kit
    lights : list of Light
        Lamps in the room.
    taken : list of Rectangle
        Floor on which something stands.
    tall : list of Rectangle
        Where that reaches up to the lamps.
    clear : list of Rectangle
        Floor that stays free.
    """

    shell: Shell
    kit: Kit
    lights: list[Light] = field(default_factory=list)
    taken: Rectangles = field(default_factory=list)
    tall: Rectangles = field(default_factory=list)
    clear: Rectangles = field(default_factory=list)

    def find(self, kind: Kind, size: Extents) -> Place | None:
        """Draw a free place for a thing and take what floor and wall it needs, or give None."""
        foot = self.kit.between(*kind["over"]) if kind["at"] == "hung" else 0.0
        for _ in range(TRIES):
            match kind["at"]:
                case "free" | "flat":
                    place = self._on_floor(kind, size)
                case "ceiling":
                    place = self._under_ceiling(size)
                case _:
                    place = self._at_wall(kind, size, foot)
            if place is not None:
                return place
        return None

    def take(
        self,
        area: Rectangle,
        height: float,
        around: Rectangle,
        clear: Rectangles,
    ) -> bool:
        """Take an area of the floor if it and its height are free; tell whether they are.

        Parameters
        ----------
        area : Rectangle
        height : float
            m.
        around : Rectangle
            The area and what before it or about it must be free of other things.
        clear : list of Rectangle
            Floor that must not be stood upon.
        """
        free = (
            any(floor.contains(area) for floor in self.shell.floor)
            and height <= self.shell.headroom(area)
            and not area.meets(clear)
            and not around.meets(self.taken)
        )
        if free:
            self.taken.append(area)
            if height > 1.8:
                self.tall.append(area)
        return free

    def _at_wall(self, kind: Kind, size: Extents, foot: float) -> Place | None:
        """Try a place before a wall, in a corner, or on a wall with its foot at a height."""
        width, _, height = size
        walls = self.shell.walls
        wall = weighted_choice(self.kit.rng, walls, [one.length for one in walls])
        last = wall.length - width - 0.04
        if wall.length < width + 0.1 or foot + height > self.shell.height - 0.02:
            return None
        x = self.kit.between(0.04, last)
        if kind["at"] == "corner":
            x = 0.04 if self.kit.chance(0.5) else last
        spot = Rectangle(x, x + width, foot, foot + height)
        if not wall.free(spot):
            return None
        return self._before_wall(kind, size, wall, spot)

    def _before_wall(
        self, kind: Kind, size: Extents, wall: Wall, spot: Rectangle
    ) -> Place | None:
        """Try to take a spot of a wall and the floor before it."""
        width, depth, _ = size
        gap = 0.002 if kind["at"] == "hung" else 0.03
        front = -depth - gap
        reach = kind.get("clear", 0.0)
        area = wall.footprint(spot, front, -gap)
        if spot.y0 < 0.5:  # what hangs higher leaves the floor free
            before = wall.footprint(spot, front - reach, -gap)
            if not self.take(area, spot.y1, before, self.clear):
                return None
            if reach:
                self.clear.append(wall.footprint(spot, front - reach, front))
        elif spot.y1 > self.shell.headroom(area):
            return None
        wall.taken.append(spot.grow(0.03, 0.03, 0.03, 0.05))
        return wall.place.at(spot.x0 + width / 2, -depth / 2 - gap, spot.y0)

    def _on_floor(self, kind: Kind, size: Extents) -> Place | None:
        """Try a place on the floor, mostly about the middle of a room."""
        flat = kind["at"] == "flat"
        margin = kind.get("clear", 0.15)
        floor = self.kit.pick(self.shell.floor)
        turn = self.kit.rng.integers(4) * np.pi / 2
        if not flat and self.kit.chance(0.3):
            turn += self.kit.between(-0.3, 0.3)
        covered = turned_size(size, turn)
        spare = floor.size - covered - 2 * margin
        if (spare < 0).any():
            return None
        middle = floor.start + margin + covered / 2 + self.kit.rng.beta(2, 2, 2) * spare
        area = Rectangle.about(middle, covered)
        around = area.grow(margin, margin, margin, margin)
        if flat:
            free = not area.meets(self.shell.keep)
        else:
            free = self.take(area, size[2], around, self.clear)
        return Place(*middle, turn=turn) if free else None

    def _under_ceiling(self, size: Extents) -> Place | None:
        """Try a place under the ceiling, away from other lamps and tall things."""
        width, depth, height = size
        floor = self.kit.pick(self.shell.floor)
        x, y = (
            floor.start + width + self.kit.rng.beta(2, 2, 2) * (floor.size - 2 * width)
        )
        z = self.shell.height - self.shell.lowest - height
        area = Rectangle.about((x, y), (width, depth))
        for light in self.lights:
            along, across, above = light.centre - np.array([x, y, z])
            if abs(above) < 1.0 and np.hypot(along, across) <= 1.2:
                return None
        if area.meets(self.tall) or z + height > self.shell.headroom(area):
            return None
        return Place(x, y, z=z)
