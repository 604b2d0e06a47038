"""Furniture in a room: drawn from `presets.yml`, placed so that nothing stands in anything."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from cmtof_rooms.engine import Light, Part, Thing
from cmtof_rooms.makers import MAKERS, Kit, Made, Top
from cmtof_rooms.materials import Material
from cmtof_rooms.shell import Rectangle, Shell, Wall
from cmtof_rooms.solids import moved

Kind = dict[str, Any]
Extents = tuple[float, float, float]
"""Width, depth, height, m."""
Place = tuple[float, float, float, float]
"""x, y, z of the foot, m, and turn, rad."""

WARM = (1.0, 0.93, 0.82)
"""Colour of lamps."""

TRIES = 14
"""Places that are tried for one thing before it is left out."""


@lru_cache(maxsize=1)
def presets() -> dict[str, Any]:
    """Kinds, rooms and materials of `presets.yml`."""
    text = Path(__file__).with_name("presets.yml").read_text(encoding="utf-8")
    return yaml.safe_load(text)


def household(rng: np.random.Generator) -> Kit:
    """Draw the materials that everything in a room is made of."""
    palette = {}
    for role, drawn in presets()["materials"].items():
        patterns = drawn["patterns"]
        odds = np.array(list(patterns.values()), float)
        several = []
        for _ in range(drawn["count"]):
            colours = np.array(drawn["colours"])[rng.integers(len(drawn["colours"]), size=2)]
            first, second = np.clip(colours * rng.uniform(0.75, 1.2, (2, 1)), 0.01, 0.92)
            mix = rng.uniform(0.15, 0.7)
            second = first + mix * (second - first) * rng.uniform(0.5, 1.0)
            name = str(rng.choice(list(patterns), p=odds / odds.sum()))
            scale = float(rng.uniform(*drawn["scale"]))
            several.append(Material(tuple(first), tuple(second * 0.8), name, scale))
        palette[role] = several
    return Kit(rng, palette, presets()["profiles"])


def overlap(a: Rectangle, b: Rectangle) -> bool:
    """Whether two rectangles share more than an edge.

    >>> overlap((0, 1, 0, 1), (1, 2, 0, 1)), overlap((0, 1, 0, 1), (0.5, 2, 0.5, 2))
    (False, True)
    """
    gap = 1e-6
    return a[0] < b[1] - gap and b[0] < a[1] - gap and a[2] < b[3] - gap and b[2] < a[3] - gap


class Furnishing:
    """A room being furnished.

    Parameters
    ----------
    shell : Shell
    kit : Kit
    """

    def __init__(self, shell: Shell, kit: Kit) -> None:
        self.shell, self.kit = shell, kit
        self.things: list[Thing] = []
        self.lights: list[Light] = []
        self.taken: list[Rectangle] = []
        """Floor on which something stands, m."""
        self.tall: list[Rectangle] = []
        """Where that reaches up to the lamps, m."""
        self.clear: list[Rectangle] = list(shell.keep)
        """Floor that stays free, m."""

    def fill(self, counts: dict[str, float]) -> None:
        """Place kinds, each about as often as asked for, the largest first."""
        kinds = presets()["kinds"]
        order = {"wall": 0, "corner": 0, "free": 1, "hung": 2, "flat": 3, "ceiling": 4}
        drawn = [(name, self._times(mean)) for name, mean in counts.items()]
        drawn.sort(key=lambda one: (order[kinds[one[0]]["at"]], -_area(kinds[one[0]])))
        for name, count in drawn:
            for _ in range(count):
                self.add(name)

    def add(self, name: str) -> bool:
        """Make one thing of a kind and find a place for it, with what belongs to it."""
        kind = presets()["kinds"][name]
        size = self._size(kind)
        find = {"free": self._free, "flat": self._free, "ceiling": self._ceiling}
        place = find.get(kind["at"], self._wall)(kind, size)
        if place is None:
            return False
        made = self._made(kind, size)
        self._stand(name, made, place)
        for other, count in kind.get("around", {}).items():
            self._around(other, self.kit.count(count), place, size)
        self._decorate(made, kind.get("upon", {}), place)
        return True

    def _times(self, mean: float) -> int:
        return int(min(self.kit.rng.poisson(mean), 2 * mean + 1))

    def _size(self, kind: Kind) -> Extents:
        w, d, h = (self.kit.between(*pair) for pair in kind["size"])
        return w, d, min(h, self.shell.height - self.shell.lowest - 0.01)

    def _made(self, kind: Kind, size: Extents) -> Made:
        return MAKERS[kind["maker"]](self.kit, size, **kind.get("make", {}))

    def _stand(self, name: str, made: Made, place: Place) -> None:
        x, y, z, turn = place
        parts = [Part(moved(part.mesh, (x, y, z), turn), part.material) for part in made.parts]
        self.things.append(Thing(name, parts))
        if made.glow is not None:
            up, half, way, power = made.glow
            square = (x, y, z + up), (half, 0, 0), (0, half, 0), (0, 0, way)
            self.lights.append(Light(*square, power, WARM))

    def _take(self, area: Rectangle, height: float) -> None:
        self.taken.append(area)
        if height > 1.8:
            self.tall.append(area)

    def _fits(
        self,
        area: Rectangle,
        height: float,
        *,
        before: Rectangle | None = None,
        clear: list[Rectangle] | None = None,
    ) -> bool:
        """Whether floor and height are free, also where something opens or people pass."""
        x0, x1, y0, y1 = area
        inside = any(x0 >= a and x1 <= b and y0 >= c and y1 <= d for a, b, c, d in self.shell.floor)
        if not inside or height > self.shell.headroom(area):
            return False
        if any(
            overlap(area, other) for other in self.taken + (self.clear if clear is None else clear)
        ):
            return False
        return before is None or not any(overlap(before, other) for other in self.taken)

    def _wall(self, kind: Kind, size: Extents) -> Place | None:
        w, d, h = size
        hung = kind["at"] == "hung"
        foot = self.kit.between(*kind["over"]) if hung else 0.0
        for _ in range(TRIES):
            wall = self._some_wall()
            if wall.length < w + 0.1 or foot + h > self.shell.height - 0.02:
                continue
            x = self.kit.between(0.04, wall.length - w - 0.04)
            if kind["at"] == "corner":
                x = 0.04 if self.kit.chance(0.5) else wall.length - w - 0.04
            if not wall.free(x, x + w, foot, foot + h):
                continue
            gap = 0.002 if hung else 0.03
            area = wall.footprint(x, x + w, -d - gap, -gap)
            reach = kind.get("clear", 0.0)
            before = wall.footprint(x, x + w, -d - gap - reach, -gap)
            if hung and foot + h > self.shell.headroom(area):
                continue
            if foot < 0.5:  # what hangs higher leaves the floor free
                if not self._fits(area, h, before=before):
                    continue
                self._take(area, h)
                self.clear += [wall.footprint(x, x + w, -d - gap - reach, -d - gap)] * (reach > 0)
            wall.taken.append((x - 0.03, x + w + 0.03, foot - 0.03, foot + h + 0.05))
            at = wall.place((x + w / 2, -d / 2 - gap, foot))
            return float(at[0]), float(at[1]), foot, wall.turn
        return None

    def _some_wall(self) -> Wall:
        length = np.array([wall.length for wall in self.shell.walls])
        return self.shell.walls[int(self.kit.rng.choice(len(length), p=length / length.sum()))]

    def _free(self, kind: Kind, size: Extents) -> Place | None:
        w, d, h = size
        flat, margin = kind["at"] == "flat", kind.get("clear", 0.15)
        for _ in range(TRIES):
            x0, x1, y0, y1 = self._some_floor()
            quarters = int(self.kit.rng.integers(4))
            turn = quarters * np.pi / 2
            a, b = (w, d) if quarters % 2 == 0 else (d, w)
            if not flat and self.kit.chance(0.3):
                tilt = self.kit.between(-0.3, 0.3)
                turn, c, s = turn + tilt, np.cos(tilt), abs(np.sin(tilt))
                a, b = a * c + b * s, b * c + a * s
            if x1 - x0 < a + 2 * margin or y1 - y0 < b + 2 * margin:
                continue
            # most things stand about the middle of a room
            u, v = self.kit.rng.beta(2, 2, 2)
            x = x0 + margin + a / 2 + u * (x1 - x0 - a - 2 * margin)
            y = y0 + margin + b / 2 + v * (y1 - y0 - b - 2 * margin)
            area = (x - a / 2, x + a / 2, y - b / 2, y + b / 2)
            wide = (area[0] - margin, area[1] + margin, area[2] - margin, area[3] + margin)
            if flat:
                if any(overlap(area, other) for other in self.shell.keep):
                    continue
            elif not self._fits(area, h, before=wide):
                continue
            else:
                self._take(area, h)
            return float(x), float(y), 0.0, float(turn)
        return None

    def _some_floor(self) -> Rectangle:
        return self.shell.floor[int(self.kit.rng.integers(len(self.shell.floor)))]

    def _ceiling(self, kind: Kind, size: Extents) -> Place | None:
        w, d, h = size
        if self.shell.open:
            return None
        for _ in range(TRIES):
            x0, x1, y0, y1 = self._some_floor()
            u, v = self.kit.rng.beta(2, 2, 2)
            x, y = x0 + w + u * (x1 - x0 - 2 * w), y0 + w + v * (y1 - y0 - 2 * w)
            z = self.shell.height - self.shell.lowest - h
            area = (x - w / 2, x + w / 2, y - d / 2, y + d / 2)
            hanging = [one for one in self.lights if abs(one.centre[2] - z) < 1.0]
            apart = all(np.hypot(one.centre[0] - x, one.centre[1] - y) > 1.2 for one in hanging)
            apart &= not any(overlap(area, other) for other in self.tall)
            if apart and z + h <= self.shell.headroom(area):
                return float(x), float(y), float(z), 0.0
        return None

    def _around(self, name: str, count: int, place: Place, size: Extents) -> None:
        """Seats along the two long sides of a table, or at the front of a desk."""
        *middle, _, turn = place
        kind = presets()["kinds"][name]
        sides = 1 if count == 1 else 2
        each = -(-count // sides)
        for k in range(count):
            w, d, h = seat = self._size(kind)
            row, side = divmod(k, sides)
            if size[0] < each * (w + 0.05):
                continue
            x = size[0] * ((row + 0.5) / each - 0.5)
            y = size[1] / 2 + d / 2 + self.kit.between(0.02, 0.25)
            way = 1 if side else -1
            c, s = np.cos(turn), np.sin(turn)
            at = (middle[0] + c * x - s * way * y, middle[1] + s * x + c * way * y)
            facing = turn + (0.0 if side else np.pi) + self.kit.between(-0.1, 0.1)
            reach = 0.5 * (w * abs(np.cos(facing)) + d * abs(np.sin(facing)))
            depth = 0.5 * (d * abs(np.cos(facing)) + w * abs(np.sin(facing)))
            area = (at[0] - reach, at[0] + reach, at[1] - depth, at[1] + depth)
            # a seat may stand where its table keeps the floor clear
            if self._fits(area, h, clear=self.shell.keep):
                self.taken.append(area)
                self._stand(name, self._made(kind, seat), (*at, 0.0, facing))

    def _decorate(self, made: Made, counts: dict[str, float], place: Place) -> None:
        """Things on the tops of another."""
        kinds, used = presets()["kinds"], [[] for _ in made.tops]
        x0, y0, z0, turn = place
        c, s = np.cos(turn), np.sin(turn)
        for name, mean in counts.items() if made.tops else ():
            kind = kinds[name]
            for _ in range(self._times(mean)):
                number = int(self.kit.rng.integers(len(made.tops)))
                spot = self._spot(made.tops[number], kind, used[number])
                if spot is None:
                    continue
                size, x, y = spot
                where = x0 + c * x - s * y, y0 + s * x + c * y, z0 + made.tops[number].z
                self._stand(name, self._made(kind, size), (*where, turn))

    def _spot(
        self, top: Top, kind: Kind, used: list[Rectangle]
    ) -> tuple[Extents, float, float] | None:
        for _ in range(4):
            w, d, h = self._size(kind)
            if w > top.x1 - top.x0 or d > top.y1 - top.y0 or h > top.room - 0.02:
                continue
            x = self.kit.between(top.x0 + w / 2, top.x1 - w / 2)
            y = self.kit.between(top.y0 + d / 2, top.y1 - d / 2)
            area = (x - w / 2, x + w / 2, y - d / 2, y + d / 2)
            if not any(overlap(area, other) for other in used):
                used.append(area)
                return (w, d, h), x, y
        return None


def _area(kind: Kind) -> float:
    (a, b), (c, d), _ = kind["size"]
    return (a + b) * (c + d)
