"""Furniture in a room: drawn from `presets.yml`, placed so that nothing stands in anything."""

from dataclasses import dataclass, field

import numpy as np

from cmtof.types import Array, Fields, Values
from cmtof_rooms.boxes import Box, Boxes
from cmtof_rooms.kit import Kit, weighted_choice
from cmtof_rooms.makers import MAKERS
from cmtof_rooms.presets import presets
from cmtof_rooms.shell import Shell
from cmtof_rooms.solids import turn_about_z
from cmtof_rooms.things import Light, Place, Thing

TRIES = 14  # places that are tried for one thing before it is left out

WARM = (1.0, 0.93, 0.82)  # colour of lamps


@dataclass
class Furnishing:
    """A room being furnished.

    Attributes
    ----------
    shell : Shell
    kit : Kit
    clear : list of Box
        Space that stays free.
    taken : list of Box
        Space of what stands on the floor.
    things : list of Thing
        Furniture, in the room's coordinates.
    lights : list of Light
        Lamps in the room.
    """

    shell: Shell
    kit: Kit
    clear: Boxes = field(default_factory=list)
    taken: Boxes = field(default_factory=list)
    things: list[Thing] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)

    def fill(self, counts: Values) -> None:
        """Place furniture in the order of `presets.yml`, each kind about as often as ``counts``."""
        drawn = {name: self._times(mean) for name, mean in counts.items()}
        for name in presets()["kinds"]:
            for _ in range(drawn.get(name, 0)):
                self._furnish(name)

    def _times(self, mean: float) -> int:
        """Draw how often a kind is placed that is there ``mean`` times on average."""
        return int(min(self.kit.rng.poisson(mean), 2 * mean + 1))

    def _furnish(self, name: str) -> None:
        """Make one thing of a kind with what belongs to it, if a free place is found for it."""
        kind = _kind(name)
        size = self._size(name)
        foot = self.kit.between(*kind["over"]) if "over" in kind else 0.0
        for _ in range(TRIES):
            match kind["at"]:
                case "free" | "flat":
                    place = self._on_floor(kind, size)
                case "ceiling":
                    place = self._under_ceiling(size)
                case _:
                    place = self._at_wall(kind, size, foot)
            if place is not None:
                spaces = self._stand(name, size, place)
                for other, limits in kind.get("around", {}).items():
                    self._seat(other, self.kit.count(limits), place, size)
                self._decorate(spaces, kind.get("upon", {}), place)
                return

    def _size(self, name: str) -> Array:
        """Draw width, depth and height of a kind, m, that fit under the ceiling."""
        size = np.array(self.kit.each(_kind(name)["size"]))
        size[2] = min(size[2], self.shell.height - self.shell.lowest - 0.01)
        return size

    def _stand(self, name: str, size: Array, place: Place) -> Boxes:
        """Make a thing, stand it at a place, and return the free spaces on it, in its frame."""
        kind = _kind(name)
        parts = []
        spaces = []
        maker = MAKERS[kind["maker"]]
        for made in maker(self.kit, Box.standing(size), **kind.get("make", {})):
            if isinstance(made, Box):
                spaces.append(made)
            elif isinstance(made, Light):
                middle = place.carry(made.centre)
                self.lights.append(made._replace(centre=middle, colour=WARM))
            else:
                parts += place.parts(*self.kit.part(*made))
        self.things.append(Thing(name, parts))
        return spaces

    def _seat(self, name: str, count: int, place: Place, size: Array) -> None:
        """Stand seats along the two long sides of a table, or at the front of a desk."""
        columns = -(-count // 2)
        for k in range(count):
            seat = self._size(name)
            column, side = divmod(k, 2)
            if size[0] < columns * (seat[0] + 0.05):
                continue
            x = size[0] * ((column + 0.5) / columns - 0.5)
            y = size[1] / 2 + seat[1] / 2 + self.kit.between(0.02, 0.25)
            turn = self.kit.between(-0.1, 0.1) + (0.0 if side else np.pi)
            spot = place.at(x, y if side else -y, turn=turn)
            area = Box.standing(_turned_size(seat, spot.turn), spot[:3])
            # a seat may stand where its table keeps the floor clear
            if self._take(area, area, self.shell.keep):
                self._stand(name, seat, spot)

    def _decorate(self, spaces: Boxes, counts: Values, place: Place) -> None:
        """Stand things in the free spaces on another, each kind about as often as ``counts``.

        What does not fit beside the others, of a few sizes and places, is left out.
        """
        shelves = [(space, []) for space in spaces]
        for name, mean in counts.items():
            for _ in range(self._times(mean)):
                space, used = self.kit.pick(shelves)
                for _ in range(4):
                    size = self._size(name)
                    if (size > space.size - [0, 0, 0.02]).any():
                        continue
                    low = space.low + size / 2
                    high = space.high - size / 2
                    foot = np.append(self.kit.rng.uniform(low[:2], high[:2]), space.z0)
                    area = Box.standing(size, foot)
                    if not area.meets(used):
                        used.append(area)
                        self._stand(name, size, place.at(*foot))
                        break

    def _take(self, space: Box, around: Box, clear: Boxes) -> bool:
        """Take the space of a thing on the floor if it is free; tell whether it is.

        Parameters
        ----------
        space : Box
        around : Box
            The space and what before it or about it must be free of other things.
        clear : list of Box
            Space that must not be stood in.
        """
        free = (
            any(piece.contains(space) for piece in self.shell.floor)
            and space.z1 <= self.shell.headroom(space)
            and not space.meets(clear)
            and not around.meets(self.taken)
        )
        if free:
            self.taken.append(space)
        return free

    def _at_wall(self, kind: Fields, size: Array, foot: float) -> Place | None:
        """Try a place before a wall, in a corner, or on a wall with its foot at a height."""
        width, depth, height = size
        walls = self.shell.walls
        wall = weighted_choice(self.kit.rng, walls, [wall.length for wall in walls])
        last = wall.length - width - 0.04
        if wall.length < width + 0.1 or foot + height > self.shell.height - 0.02:
            return None
        x = self.kit.between(0.04, last)
        if kind["at"] == "corner":
            x = 0.04 if self.kit.chance(0.5) else last
        gap = 0.002 if "over" in kind else 0.03
        spot = Box(x, x + width, -depth - gap, -gap, foot, foot + height)
        space = wall.in_room(spot)
        if spot.meets(wall.taken) or space.z1 > self.shell.headroom(space):
            return None
        if foot < 0.5:  # what hangs higher leaves the floor free
            before = spot.inset(y0=-kind.get("clear", 0.0))
            if not self._take(space, wall.in_room(before), self.clear):
                return None
            self.clear.append(wall.in_room(before.cut(y1=spot.y0)))
        wall.take(spot, 0.03)
        return wall.place.at(x + width / 2, -depth / 2 - gap, foot)

    def _on_floor(self, kind: Fields, size: Array) -> Place | None:
        """Try a place on the floor, mostly about the middle of a room."""
        flat = kind["at"] == "flat"
        margin = kind.get("clear", 0.15)
        floor = self.kit.pick(self.shell.floor)
        turn = self.kit.rng.integers(4) * np.pi / 2
        if not flat and self.kit.chance(0.3):
            turn += self.kit.between(-0.3, 0.3)
        covered = _turned_size(size, turn)
        spare = (floor.size - covered)[:2] - 2 * margin
        if (spare < 0).any():
            return None
        corner = floor.low + margin + covered / 2
        middle = corner[:2] + self.kit.rng.beta(2, 2, 2) * spare
        space = Box.standing(covered, (*middle, 0.0))
        around = space.inset(x=-margin, y=-margin)
        free = (
            not space.meets(self.shell.keep)
            if flat
            else self._take(space, around, self.clear)
        )
        return Place(*middle, turn=turn) if free else None

    def _under_ceiling(self, size: Array) -> Place | None:
        """Try a place under the ceiling, away from other lamps and tall things."""
        margin = size[0]
        floor = self.kit.pick(self.shell.floor)
        spare = floor.size[:2] - 2 * margin
        x, y = floor.low[:2] + margin + self.kit.rng.beta(2, 2, 2) * spare
        place = Place(x, y, self.shell.height - self.shell.lowest - size[2])
        for light in self.lights:
            along, across, above = np.subtract(light.centre, place[:3])
            if abs(above) < 1.0 and np.hypot(along, across) <= 1.2:
                return None
        space = Box.standing(size, place[:3])
        tall = [thing for thing in self.taken if thing.z1 > 1.8]
        if space.cut(z0=0.0).meets(tall) or space.z1 > self.shell.headroom(space):
            return None
        return place


def _turned_size(size: Array, turn: float) -> Array:
    """Size along x, y and z, m, of a box that is turned by ``turn``, rad, about z."""
    return np.abs(turn_about_z(turn)) @ size


def _kind(name: str) -> Fields:
    """One of the ``kinds`` of `presets.yml`, by its name."""
    return presets()["kinds"][name]
