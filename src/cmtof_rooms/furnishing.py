"""Furniture in a room: drawn from `presets.yml`, placed so that nothing stands in anything."""

from dataclasses import dataclass, field

import numpy as np

from cmtof.types import Values
from cmtof_rooms.boxes import Box, Rectangle, Rectangles
from cmtof_rooms.kit import Top
from cmtof_rooms.makers import MAKERS
from cmtof_rooms.presets import presets
from cmtof_rooms.things import Light, Place, Thing
from cmtof_rooms.vacancy import (
    Extents,
    Kind,
    Vacancy,
    turned_size,
)

WARM = (1.0, 0.93, 0.82)  # colour of lamps


@dataclass
class Furnishing(Vacancy):
    """A room being furnished.

    Attributes
    ----------
    things : list of Thing
        Furniture, in the room's coordinates.
    """

    things: list[Thing] = field(default_factory=list)

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
        """Make one thing of a kind with what belongs to it, if there is a place for it."""
        kind = _kind(name)
        size = self._size(name)
        place = self.find(kind, size)
        if place is None:
            return
        tops = self._stand(name, size, place)
        for other, limits in kind.get("around", {}).items():
            self._seat(other, self.kit.count(limits), place, size)
        self._decorate(tops, kind.get("upon", {}), place)

    def _size(self, name: str) -> Extents:
        """Draw a size of a kind, m, that fits under the ceiling."""
        size = np.array(self.kit.each(_kind(name)["size"]))
        size[2] = min(size[2], self.shell.height - self.shell.lowest - 0.01)
        return size

    def _stand(self, name: str, size: Extents, place: Place) -> list[Top]:
        """Make a thing, stand it at a place, and return its tops, on which others can stand."""
        kind = _kind(name)
        make = MAKERS[kind["maker"]]
        parts = []
        tops = []
        for made in make(self.kit, Box.standing(size), **kind.get("make", {})):
            if isinstance(made, Top):
                tops.append(made)
            elif isinstance(made, Light):
                middle = place.carry(made.centre)
                self.lights.append(made._replace(centre=middle, colour=WARM))
            else:
                parts += place.parts(*self.kit.part(*made))
        self.things.append(Thing(name, parts))
        return tops

    def _seat(self, name: str, count: int, place: Place, size: Extents) -> None:
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
            area = Rectangle.about(spot[:2], turned_size(seat, spot.turn))
            # a seat may stand where its table keeps the floor clear
            if self.take(area, seat[2], area, self.shell.keep):
                self._stand(name, seat, spot)

    def _decorate(self, tops: list[Top], counts: Values, place: Place) -> None:
        """Stand things on the tops of another, each kind about as often as ``counts`` has it."""
        surfaces = [(top, []) for top in tops]
        for name, mean in counts.items():
            for _ in range(self._times(mean)):
                self._stand_upon(name, place, *self.kit.pick(surfaces))

    def _stand_upon(self, name: str, place: Place, top: Top, used: Rectangles) -> None:
        """Make a thing and stand it on a top beside what stands there, if it fits."""
        for _ in range(4):
            size = self._size(name)
            if (size > [*top.area.size, top.room - 0.02]).any():
                continue
            half = size[:2] / 2
            middle = self.kit.rng.uniform(top.area.start + half, top.area.end - half)
            area = Rectangle.about(middle, size[:2])
            if not area.meets(used):
                used.append(area)
                self._stand(name, size, place.at(*middle, z=top.z))
                return


def _kind(name: str) -> Kind:
    """Kind of furniture by its name."""
    return presets()["kinds"][name]
