"""Shells of rooms: floor, walls with doors and windows, ceiling, slope, beams, what lies beyond.

The room is a rectangle, 0 to width by 0 to depth, m, from which a block may be cut off in one
corner (an L). A wall's own frame has x along it and y outwards.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from trimesh import Trimesh

from cmtof_rooms.engine import Light, Part, Thing
from cmtof_rooms.makers import Extent, Kit
from cmtof_rooms.materials import Material
from cmtof_rooms.solids import ball, moved, plate, sheet, slab

Rectangle = tuple[float, float, float, float]
"""x0, x1, y0, y1, m."""

THICK = 0.15
"""Of walls, m."""

SKY: tuple[float, float, float] = (0.95, 1.0, 1.06)
"""Colour of daylight."""


@dataclass
class Wall:
    """One side of a room."""

    origin: tuple[float, float]
    """Its left end, seen from inside, m."""
    turn: float
    """Of its own frame about z, rad."""
    length: float
    taken: list[Rectangle] = field(default_factory=list)
    """What is in it or stands before it: along the wall and in height, m."""
    holes: list[Rectangle] = field(default_factory=list)
    """What is cut out of it, m."""

    def place(self, points: ArrayLike) -> NDArray[np.float64]:
        """Points (..., 3) of the wall's frame in the world."""
        c, s = np.cos(self.turn), np.sin(self.turn)
        axes = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
        return np.asarray(points, float) @ axes + np.array([*self.origin, 0.0])

    def parts(self, material: Material, *solids: Trimesh | Extent) -> list[Part]:
        """Solids of the wall's frame, or boxes of six numbers, as parts in the world."""
        meshes = [solid if isinstance(solid, Trimesh) else slab(*solid) for solid in solids]
        return [Part(moved(one, (*self.origin, 0.0), self.turn), material) for one in meshes]

    def footprint(self, x0: float, x1: float, y0: float, y1: float) -> Rectangle:
        """Rectangle of the wall's frame in the world; quarter turns keep it one."""
        a, b = self.place([(x0, y0, 0.0), (x1, y1, 0.0)])
        low, high = np.minimum(a, b).tolist(), np.maximum(a, b).tolist()
        return low[0], high[0], low[1], high[1]

    def free(self, x0: float, x1: float, z0: float, z1: float) -> bool:
        """Whether nothing is in or before this piece of it."""
        return not any(x0 < b and x1 > a and z0 < d and z1 > c for a, b, c, d in self.taken)

    def gap(self, kit: Kit, wide: float) -> float | None:
        """Start of a free piece, m, for a door or a passage."""
        for _ in range(12 if self.length >= wide + 0.3 else 0):
            x = kit.between(0.15, self.length - wide - 0.15)
            if self.free(x - 0.1, x + wide + 0.1, 0, 9):
                return x
        return None

    def solid(self, height: float) -> Trimesh:
        """The wall itself, to a height, m, a little longer than the room at both ends."""
        holes = [(x0 + THICK, x1 + THICK, z0, z1) for x0, x1, z0, z1 in self.holes]
        whole = plate(self.length + 2 * THICK, height, THICK, holes)
        return moved(whole, (-THICK, 0, 0))


@dataclass
class Shell:
    """An empty room."""

    width: float
    depth: float
    height: float
    walls: list[Wall]
    floor: list[Rectangle]
    things: list[Thing] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    keep: list[Rectangle] = field(default_factory=list)
    """Floor before doors, which stays free."""
    beyond: list[Wall] = field(default_factory=list)
    """Far wall of a room beyond a passage."""
    eaves: list[tuple[float, float, float]] = field(default_factory=list)
    """Slopes: direction along y (1 or -1), where the slope starts, height lost a metre."""
    open: bool = False
    """Without a ceiling."""
    day: bool = True
    lowest: float = 0.0
    """How far beams reach down, m."""

    def add(self, kind: str, *parts: Part) -> None:
        """Add a thing of the house itself."""
        self.things.append(Thing(kind, list(parts)))

    def headroom(self, area: Rectangle) -> float:
        """Free height above a rectangle of the floor, m."""
        lost = [0.0]
        for way, start, fall in self.eaves:
            lost.append(fall * way * ((area[3] if way > 0 else area[2]) - start))
        return self.height - self.lowest - max(lost)

    @property
    def sky(self) -> float:
        """Radiance of the sky."""
        return 1.0 if self.day else 0.01


def build_shell(kit: Kit, room: dict[str, Any]) -> Shell:
    """Build an empty room of a kind; ``room`` is one of the ``rooms`` of `presets.yml`."""
    w, d, height = (kit.between(*pair) for pair in room["size"])
    is_open = bool(room.get("open", False))
    day = is_open or kit.chance(0.75)
    notch = (0.0, 0.0)  # size of the block that is cut off
    if not is_open and min(w, d) >= 3.6 and kit.chance(0.25):
        notch = kit.between(0.2, 0.45) * w, kit.between(0.2, 0.45) * d
    a, b = notch
    floor = [(0.0, w, 0.0, d - b), (0.0, w - a, 0.0, d)][0 if a else 1 :]
    shell = Shell(w, d, height, _walls(w, d, notch), floor, open=is_open, day=day)
    outer = shell.walls[:4]
    order = [outer[k] for k in kit.rng.permutation(4)]
    _doorway(kit, shell, order[0])
    if not is_open and kit.chance(0.35):
        _passage(kit, shell, order[1])
    glazed = order[2:] if kit.chance(0.35) else order[2:3]
    view = not is_open and day and kit.chance(0.35)
    for wall in glazed:
        _windows(kit, shell, wall, view=view)
    material = kit.material("wall")
    for wall in outer:
        shell.add("wall", *wall.parts(material, wall.solid(height)))
    _level_surfaces(kit, shell, notch, material)
    if kit.chance(room.get("slope", 0.0)):
        _slopes(kit, shell)
    elif kit.chance(room.get("beams", 0.1)) and not is_open:
        _beams(kit, shell)
    if kit.chance(0.5):
        _skirting(kit, shell)
    return shell


def _walls(width: float, depth: float, notch: tuple[float, float]) -> list[Wall]:
    """Four outer walls and, of an L, the two faces of the block in its corner."""
    (a, b), quarter = notch, np.pi / 2
    walls = [
        Wall((width, 0.0), 2 * quarter, width),
        Wall((width, depth), -quarter, depth),
        Wall((0.0, depth), 0.0, width),
        Wall((0.0, 0.0), quarter, depth),
    ]
    if a:  # the outer walls behind the block stay, but nothing stands there
        walls[1].taken.append((0.0, b, 0.0, 99.0))
        walls[2].taken.append((width - a, width, 0.0, 99.0))
        walls.append(Wall((width - a, depth - b), 0.0, a))
        walls.append(Wall((width - a, depth), -quarter, b))
    return walls


def _doorway(kit: Kit, shell: Shell, wall: Wall) -> None:
    """A door in its frame, shut."""
    wide, tall = kit.between(0.8, 1.0), kit.between(1.98, 2.15)
    x = wall.gap(kit, wide)
    if x is None:
        return
    end, top = x + wide, tall + 0.07
    wall.holes.append((x, end, 0.0, tall))
    wall.taken.append((x - 0.08, end + 0.08, 0.0, tall + 0.1))
    shell.keep.append(wall.footprint(x, end, -0.9, 0.0))
    front, metal = kit.material("front"), kit.material("metal")
    parts = wall.parts(front, (x, end, 0.06, 0.1, 0.0, tall))
    parts += wall.parts(metal, (x + 0.06, x + 0.18, 0.02, 0.04, 1.02, 1.04))
    jambs = [(a, a + 0.07, -0.02, 0.0, 0.0, top) for a in (x - 0.07, end)]
    shell.add("door", *parts, *wall.parts(front, *jambs, (x, end, -0.02, 0.0, tall, top)))


def _passage(kit: Kit, shell: Shell, wall: Wall) -> None:
    """An open passage to a room beyond, with a lamp of its own."""
    wide = min(kit.between(0.9, 2.6), 0.6 * wall.length)
    tall = min(kit.between(2.05, 2.6), shell.height - 0.15)
    x = wall.gap(kit, wide)
    if x is None:
        return
    wall.holes.append((x, x + wide, 0.0, tall))
    wall.taken.append((x - 0.05, x + wide + 0.05, 0.0, tall + 0.05))
    shell.keep.append(wall.footprint(x, x + wide, -0.9, 0.0))
    a, b = x - kit.between(0.1, 1.5), x + wide + kit.between(0.1, 1.5)
    deep, high, t = kit.between(2.0, 7.0), max(tall + 0.1, min(shell.height, 3.0)), THICK
    end = t + deep
    sides = [(p, p + t, t, end + t, 0, high) for p in (a - t, b)]
    paint, ground = kit.material("wall"), kit.material("floor")
    parts = wall.parts(paint, *sides, (a - t, b + t, end, end + t, 0, high))
    parts += wall.parts(ground, (a - t, b + t, 0.0, end + t, -0.2, 0.0))
    parts += wall.parts(paint, (a - t, b + t, t, end + t, high, high + t))
    shell.add("room beyond", *parts)
    left = wall.place((a, end, 0.0))
    shell.beyond.append(Wall((float(left[0]), float(left[1])), wall.turn, b - a))
    middle, power = wall.place(((a + b) / 2, (t + end) / 2, high - 0.03)), 0.25 * (b - a) * deep
    shell.lights.append(Light(middle, (0.4, 0, 0), (0, 0.4, 0), (0, 0, -1), min(power, 2.0)))


def _windows(kit: Kit, shell: Shell, wall: Wall, *, view: bool) -> None:
    """A row of windows: bright panes, or open to what is outside."""
    count = int(max(1, min(5, wall.length / kit.between(1.6, 3.5))))
    each = wall.length / count
    wide = min(kit.between(0.8, 2.4), 0.75 * each)
    sill, head = kit.between(0.02, 1.0), shell.height * kit.between(0.75, 0.92)
    starts = [each * (k + 0.5) - wide / 2 for k in range(count)]
    starts = [x for x in starts if wall.free(x - 0.1, x + wide + 0.1, sill, head)]
    if not starts:
        return
    trim, parts, e = kit.material("front"), [], 0.06
    pane = Material(SKY, emission=shell.sky * kit.between(0.7, 1.3))
    bars, rows = int(kit.rng.integers(0, 3)), int(kit.rng.integers(0, 3))
    zs = np.linspace(sill, head, rows + 2)[1:-1]
    for x0 in starts:
        x1 = x0 + wide
        wall.holes.append((x0, x1, sill, head))
        wall.taken.append((x0 - 0.05, x1 + 0.05, sill - 0.03, head + 0.05))
        frame = [(x, x + e, sill, head) for x in (x0, x1 - e)]
        frame += [(x0, x1, z, z + e) for z in (sill, head - e)]
        frame += [(x - 0.02, x + 0.02, sill, head) for x in np.linspace(x0, x1, bars + 2)[1:-1]]
        frame += [(x0, x1, z - 0.02, z + 0.02) for z in zs]
        parts += wall.parts(trim, *[(p, q, 0.06, 0.11, r, s) for p, q, r, s in frame])
        if not view:
            parts += wall.parts(pane, (x0, x1, 0.08, 0.09, sill, head))
    shell.add("window", *parts)
    end, area = starts[-1] + wide, len(starts) * wide * (head - sill)
    axes = wall.place(np.eye(3)) - wall.place(np.zeros(3))
    middle = wall.place(((starts[0] + end) / 2, -0.01, (sill + head) / 2))
    half = (axes[0] * (end - starts[0]) / 2, axes[2] * (head - sill) / 2)
    shell.lights.append(Light(middle, *half, -axes[1], area * shell.sky / np.pi, SKY))
    if view:
        _outdoors(kit, shell, wall)


def _outdoors(kit: Kit, shell: Shell, wall: Wall) -> None:
    """Ground, a house across the street and trees, bright by themselves."""
    level, far = -kit.between(0.2, 4.0), kit.between(9.0, 40.0)
    middle, glow = wall.length / 2, shell.sky * kit.between(0.5, 1.0)
    lawn = Material((0.12, 0.2, 0.06), (0.25, 0.24, 0.2), "noise", 0.8, glow)
    facade, dark, green = (
        Material(colour, emission=glow)
        for colour in ((0.6, 0.5, 0.4), (0.05, 0.06, 0.07), (0.08, 0.18, 0.05))
    )
    wide, tall = kit.between(15, 45), kit.between(5, 14)
    xs, zs = np.arange(1.2, wide - 1.5, 3.0), np.arange(1.0, tall - 1.8, 3.0)
    front = plate(wide, tall, 0.3, [(x, x + 1.2, z, z + 1.5) for x in xs for z in zs])
    left, right = middle - wide / 2, middle + wide / 2
    ground = (middle - 60, middle + 60, 0.3, far + 30, level - 0.5, level)
    parts = wall.parts(lawn, ground) + wall.parts(facade, moved(front, (left, far, level)))
    parts += wall.parts(dark, (left, right, far + 0.3, far + 8, level, level + tall))
    shell.add("house outside", *parts)
    for _ in range(int(kit.rng.integers(0, 4))):
        size = kit.between(1.0, 2.5)
        crown = ball((size, size, 1.2 * size), noise=0.3, rng=kit.rng, fineness=3)
        at = (middle + kit.between(-8, 8), kit.between(0.3, 0.9) * far, level + 1.4 * size)
        shell.add("tree outside", *wall.parts(green, moved(crown, at)))


def _level_surfaces(kit: Kit, shell: Shell, notch: tuple[float, float], wall: Material) -> None:
    """Floor, ceiling, and the block that makes an L."""
    w, d, h, t = shell.width, shell.depth, shell.height, THICK
    shell.add("floor", Part(slab(-t, w + t, -t, d + t, -0.2, 0.0), kit.material("floor")))
    if shell.open:
        middle, power = (w / 2, d / 2, h + 5), w * d / np.pi
        sky = Light(middle, (w / 2, 0, 0), (0, d / 2, 0), (0, 0, -1), power, SKY)
        shell.lights.append(sky)
    else:
        ceiling = slab(-t, w + t, -t, d + t, h, h + 0.2)
        shell.add("ceiling", Part(ceiling, kit.material("ceiling")))
    if notch[0]:
        shell.add("wall", Part(slab(w - notch[0], w + t, d - notch[1], d + t, 0.0, h), wall))


def _slopes(kit: Kit, shell: Shell) -> None:
    """A roof slope over one long side, or over both."""
    w, d, h, t = shell.width, shell.depth, shell.height, THICK
    plaster = kit.material("ceiling")
    for way in (1, -1) if kit.chance(0.5) else (1,):
        start = d * (0.5 + way * kit.between(0.05, 0.25))
        end = d + t if way > 0 else -t
        low = kit.between(0.9, 1.6)
        fall = (h - low) / abs((d if way > 0 else 0.0) - start)
        x, y = np.meshgrid([-t, w + t], [start, end], indexing="ij")
        roof = sheet(np.stack([x, y, h - fall * np.abs(y - start)], -1), 0.02)
        shell.add("slope", Part(roof, plaster))
        shell.eaves.append((float(way), start, fall))


def _beams(kit: Kit, shell: Shell) -> None:
    """Beams under the ceiling, across the room."""
    thick, d, h = kit.between(0.12, 0.3), shell.depth, shell.height
    wood, count = kit.material("wood"), max(1, int(shell.width / kit.between(1.2, 3.0)))
    at, half = shell.width / count * (np.arange(count) + 0.5), thick / 3
    beams = [slab(x - half, x + half, 0, d, h - thick, h) for x in at]
    shell.add("beams", *[Part(beam, wood) for beam in beams])
    shell.lowest = thick


def _skirting(kit: Kit, shell: Shell) -> None:
    """Boards at the foot of the walls, between what reaches the floor."""
    high, paint, parts = kit.between(0.05, 0.12), kit.material("front"), []
    for wall in shell.walls:
        cuts = sorted((a, b) for a, b, c, _ in wall.taken if c < high)
        ends = [0.0, *(e for cut in cuts for e in cut), wall.length]
        pieces = [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if b > a + 0.05]
        parts += wall.parts(paint, *[(a, b, -0.014, 0.0, 0.0, high) for a, b in pieces])
    if parts:
        shell.add("skirting", *parts)
