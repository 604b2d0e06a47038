"""Shells of rooms: floor, walls with doors and windows, ceiling, slope, beams, what lies beyond.

The room is a rectangle, 0 to width by 0 to depth, m, from which a block may be cut off in one
corner (an L). A wall's own frame has x along it and y outwards.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from trimesh import Trimesh

from cmtof.scenes.rooms.engine import Light, Part, Thing
from cmtof.scenes.rooms.makers import Kit
from cmtof.scenes.rooms.materials import Material
from cmtof.scenes.rooms.solids import ball, moved, plate, sheet, slab

Rectangle = tuple[float, float, float, float]
"""x0, x1, y0, y1, m."""

THICK = 0.15
"""Of walls, m."""

SKY: tuple[float, float, float] = (0.95, 1.0, 1.06)
"""Colour of daylight."""


class Wall(NamedTuple):
    """One side of a room."""

    origin: tuple[float, float]
    """Its left end, seen from inside, m."""
    turn: float
    """Of its own frame about z, rad."""
    length: float
    taken: list[Rectangle]
    """What is in it or stands before it: along the wall and in height, m."""

    def place(self, points: ArrayLike) -> NDArray[np.float64]:
        """Points (..., 3) of the wall's frame in the world."""
        c, s = np.cos(self.turn), np.sin(self.turn)
        axes = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
        return np.asarray(points, float) @ axes + np.array([*self.origin, 0.0])

    def put(self, mesh: Trimesh) -> Trimesh:
        """Bring a solid of the wall's frame into the world."""
        return moved(mesh, (*self.origin, 0.0), self.turn)

    def footprint(self, x0: float, x1: float, y0: float, y1: float) -> Rectangle:
        """Rectangle of the wall's frame in the world; quarter turns keep it one."""
        a, b = self.place([(x0, y0, 0.0), (x1, y1, 0.0)])
        low, high = np.minimum(a, b).tolist(), np.maximum(a, b).tolist()
        return low[0], high[0], low[1], high[1]

    def free(self, x0: float, x1: float, z0: float, z1: float) -> bool:
        """Whether nothing is in or before this piece of it."""
        return not any(x0 < b and x1 > a and z0 < d and z1 > c for a, b, c, d in self.taken)


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

    def headroom(self, area: Rectangle) -> float:
        """Free height above a rectangle of the floor, m."""
        lost = [
            max(0.0, way * ((area[3] if way > 0 else area[2]) - start)) * fall
            for way, start, fall in self.eaves
        ]
        return self.height - self.lowest - max(lost, default=0.0)

    @property
    def sky(self) -> float:
        """Radiance of the sky."""
        return 1.0 if self.day else 0.01


def build_shell(kit: Kit, room: dict[str, Any]) -> Shell:
    """Build an empty room of a kind; ``room`` is one of the ``rooms`` of `presets.yml`."""
    width, depth, height = (kit.between(*pair) for pair in room["size"])
    is_open = bool(room.get("open", False))
    day = is_open or kit.chance(0.75)
    notch = _notch(kit, width, depth) if not is_open else (0.0, 0.0)
    shell = Shell(
        width,
        depth,
        height,
        _walls(width, depth, notch),
        _floor(width, depth, notch),
        open=is_open,
        day=day,
    )
    outer = shell.walls[:4]
    holes: list[list[Rectangle]] = [[] for _ in outer]
    order = kit.rng.permutation(4)
    _doorway(kit, shell, int(order[0]), holes)
    passage = not is_open and kit.chance(0.35)
    if passage:
        _passage(kit, shell, int(order[1]), holes)
    glazed = [int(order[2])] + ([int(order[3])] if kit.chance(0.35) else [])
    view = not is_open and day and kit.chance(0.35)
    for number in glazed:
        _windows(kit, shell, number, holes, view=view)
    walls = [
        wall.put(
            moved(
                plate(
                    wall.length + 2 * THICK,
                    height,
                    THICK,
                    [(x0 + THICK, x1 + THICK, z0, z1) for x0, x1, z0, z1 in cut],
                ),
                (-THICK, 0, 0),
            )
        )
        for wall, cut in zip(outer, holes, strict=True)
    ]
    material = kit.material("wall")
    for one in walls:
        shell.things.append(Thing("wall", [Part(one, material)]))
    _level_surfaces(kit, shell, notch, material)
    if kit.chance(room.get("slope", 0.0)):
        _slopes(kit, shell)
    elif kit.chance(room.get("beams", 0.1)) and not is_open:
        _beams(kit, shell)
    if kit.chance(0.5):
        _skirting(kit, shell)
    return shell


def _notch(kit: Kit, width: float, depth: float) -> tuple[float, float]:
    """Size of the block cut off, or zeros for a rectangle."""
    if min(width, depth) < 3.6 or not kit.chance(0.25):
        return 0.0, 0.0
    return kit.between(0.2, 0.45) * width, kit.between(0.2, 0.45) * depth


def _walls(width: float, depth: float, notch: tuple[float, float]) -> list[Wall]:
    a, b = notch
    quarter = np.pi / 2
    walls = [
        Wall((width, 0.0), 2 * quarter, width, []),
        Wall((width, depth), -quarter, depth, []),
        Wall((0.0, depth), 0.0, width, []),
        Wall((0.0, 0.0), quarter, depth, []),
    ]
    if a:  # the outer walls behind the block stay, but nothing stands there
        walls[1].taken.append((0.0, b, 0.0, 99.0))
        walls[2].taken.append((width - a, width, 0.0, 99.0))
        walls.append(Wall((width - a, depth - b), 0.0, a, []))
        walls.append(Wall((width - a, depth), -quarter, b, []))
    return walls


def _floor(width: float, depth: float, notch: tuple[float, float]) -> list[Rectangle]:
    a, b = notch
    if not a:
        return [(0.0, width, 0.0, depth)]
    return [(0.0, width, 0.0, depth - b), (0.0, width - a, 0.0, depth)]


def _gap(kit: Kit, wall: Wall, wide: float) -> float | None:
    """Start of a free piece of a wall, m."""
    for _ in range(12):
        if wall.length < wide + 0.3:
            return None
        x = kit.between(0.15, wall.length - wide - 0.15)
        if wall.free(x - 0.1, x + wide + 0.1, 0, 9):
            return x
    return None


def _doorway(kit: Kit, shell: Shell, number: int, holes: list[list[Rectangle]]) -> None:
    """A door in its frame, shut."""
    wall, wide, tall = shell.walls[number], kit.between(0.8, 1.0), kit.between(1.98, 2.15)
    x = _gap(kit, wall, wide)
    if x is None:
        return
    hole = (x, x + wide, 0.0, tall)
    holes[number].append(hole)
    wall.taken.append((x - 0.08, x + wide + 0.08, 0.0, tall + 0.1))
    shell.keep.append(wall.footprint(x, x + wide, -0.9, 0.0))
    leaf = slab(x, x + wide, 0.06, 0.1, 0.0, tall)
    front = kit.material("front")
    handle = slab(x + 0.06, x + 0.18, 0.02, 0.04, 1.02, 1.04)
    parts = [Part(wall.put(leaf), front), Part(wall.put(handle), kit.material("metal"))]
    parts += [Part(wall.put(bar), front) for bar in _frame(hole, 0.07, -0.02)]
    shell.things.append(Thing("door", parts))


def _frame(hole: Rectangle, wide: float, y: float) -> list[Trimesh]:
    """Two jambs and a lintel around a hole."""
    x0, x1, z0, z1 = hole
    return [
        slab(x0 - wide, x0, y, 0.0, z0, z1 + wide),
        slab(x1, x1 + wide, y, 0.0, z0, z1 + wide),
        slab(x0, x1, y, 0.0, z1, z1 + wide),
    ]


def _passage(kit: Kit, shell: Shell, number: int, holes: list[list[Rectangle]]) -> None:
    """An open passage to a room beyond, with a lamp of its own."""
    wall = shell.walls[number]
    wide = min(kit.between(0.9, 2.6), 0.6 * wall.length)
    tall = min(kit.between(2.05, 2.6), shell.height - 0.15)
    x = _gap(kit, wall, wide)
    if x is None:
        return
    holes[number].append((x, x + wide, 0.0, tall))
    wall.taken.append((x - 0.05, x + wide + 0.05, 0.0, tall + 0.05))
    shell.keep.append(wall.footprint(x, x + wide, -0.9, 0.0))
    a, b = x - kit.between(0.1, 1.5), x + wide + kit.between(0.1, 1.5)
    deep, high = kit.between(2.0, 7.0), max(tall + 0.1, min(shell.height, 3.0))
    y0, y1, t = THICK, THICK + deep, THICK
    sides = [
        slab(a - t, a, y0, y1 + t, 0, high),
        slab(b, b + t, y0, y1 + t, 0, high),
        slab(a - t, b + t, y1, y1 + t, 0, high),
    ]
    paint, ground = kit.material("wall"), kit.material("floor")
    parts = [Part(wall.put(one), paint) for one in sides]
    parts.append(Part(wall.put(slab(a - t, b + t, 0.0, y1 + t, -0.2, 0.0)), ground))
    parts.append(Part(wall.put(slab(a - t, b + t, y0, y1 + t, high, high + t)), paint))
    shell.things.append(Thing("room beyond", parts))
    far = wall.place((b, y1, 0.0))
    origin = wall.place((a, y1, 0.0))
    del far
    shell.beyond.append(Wall((float(origin[0]), float(origin[1])), wall.turn, b - a, []))
    middle = wall.place(((a + b) / 2, (y0 + y1) / 2, high - 0.03))
    power = 0.25 * (b - a) * deep
    shell.lights.append(Light(middle, (0.4, 0, 0), (0, 0.4, 0), (0, 0, -1), min(power, 2.0)))


def _windows(
    kit: Kit, shell: Shell, number: int, holes: list[list[Rectangle]], *, view: bool
) -> None:
    """A row of windows: bright panes, or open to what is outside."""
    wall, high = shell.walls[number], shell.height
    count = int(max(1, min(5, wall.length / kit.between(1.6, 3.5))))
    each = wall.length / count
    wide = min(kit.between(0.8, 2.4), 0.75 * each)
    sill, head = kit.between(0.02, 1.0), high * kit.between(0.75, 0.92)
    cuts = []
    for k in range(count):
        x = each * (k + 0.5) - wide / 2
        if wall.free(x - 0.1, x + wide + 0.1, sill, head):
            cuts.append((x, x + wide, sill, head))
    if not cuts:
        return
    holes[number] += cuts
    trim, parts = kit.material("front"), []
    pane = Material(SKY, emission=shell.sky * kit.between(0.7, 1.3))
    bars, rows = int(kit.rng.integers(0, 3)), int(kit.rng.integers(0, 3))
    for x0, x1, z0, z1 in cuts:
        wall.taken.append((x0 - 0.05, x1 + 0.05, z0 - 0.03, z1 + 0.05))
        frame = [
            (x0, x0 + 0.06, z0, z1),
            (x1 - 0.06, x1, z0, z1),
            (x0, x1, z0, z0 + 0.06),
            (x0, x1, z1 - 0.06, z1),
        ]
        xs, zs = np.linspace(x0, x1, bars + 2)[1:-1], np.linspace(z0, z1, rows + 2)[1:-1]
        frame += [(x - 0.02, x + 0.02, z0, z1) for x in xs]
        frame += [(x0, x1, z - 0.02, z + 0.02) for z in zs]
        solids = [slab(p, q, 0.06, 0.11, r, s) for p, q, r, s in frame]
        parts += [Part(wall.put(one), trim) for one in solids]
        if not view:
            parts.append(Part(wall.put(slab(x0, x1, 0.08, 0.09, z0, z1)), pane))
    shell.things.append(Thing("window", parts))
    x0, x1 = cuts[0][0], cuts[-1][1]
    area = sum((q - p) * (s - r) for p, q, r, s in cuts)
    axes = wall.place(np.eye(3)) - wall.place(np.zeros(3))
    middle = wall.place(((x0 + x1) / 2, -0.01, (sill + head) / 2))
    half = (axes[0] * (x1 - x0) / 2, axes[2] * (head - sill) / 2)
    shell.lights.append(Light(middle, *half, -axes[1], area * shell.sky / np.pi, SKY))
    if view:
        _outdoors(kit, shell, wall)


def _outdoors(kit: Kit, shell: Shell, wall: Wall) -> None:
    """Ground, a house across the street and trees, bright by themselves."""
    level, far = -kit.between(0.2, 4.0), kit.between(9.0, 40.0)
    middle, glow = wall.length / 2, shell.sky * kit.between(0.5, 1.0)

    def lit(colour: tuple[float, float, float], **pattern: Any) -> Material:
        return Material(colour, emission=glow, **pattern)

    ground = slab(middle - 60, middle + 60, 0.3, far + 30, level - 0.5, level)
    lawn = lit((0.12, 0.2, 0.06), second=(0.25, 0.24, 0.2), pattern="noise", scale=0.8)
    parts = [Part(wall.put(ground), lawn)]
    wide, tall = kit.between(15, 45), kit.between(5, 14)
    holes = [
        (x, x + 1.2, z, z + 1.5)
        for x in np.arange(1.2, wide - 1.5, 3.0)
        for z in np.arange(1.0, tall - 1.8, 3.0)
    ]
    front = moved(plate(wide, tall, 0.3, holes), (middle - wide / 2, far, level))
    back = slab(middle - wide / 2, middle + wide / 2, far + 0.3, far + 8, level, level + tall)
    parts += [
        Part(wall.put(front), lit((0.6, 0.5, 0.4))),
        Part(wall.put(back), lit((0.05, 0.06, 0.07))),
    ]
    shell.things.append(Thing("house outside", parts))
    for _ in range(int(kit.rng.integers(0, 4))):
        size = kit.between(1.0, 2.5)
        crown = ball((size, size, 1.2 * size), noise=0.3, rng=kit.rng, fineness=3)
        at = (middle + kit.between(-8, 8), kit.between(0.3, 0.9) * far, level + 1.4 * size)
        tree = Part(wall.put(moved(crown, at)), lit((0.08, 0.18, 0.05)))
        shell.things.append(Thing("tree outside", [tree]))


def _level_surfaces(kit: Kit, shell: Shell, notch: tuple[float, float], wall: Material) -> None:
    """Floor, ceiling, and the block that makes an L."""
    w, d, h, t = shell.width, shell.depth, shell.height, THICK
    floor = slab(-t, w + t, -t, d + t, -0.2, 0.0)
    shell.things.append(Thing("floor", [Part(floor, kit.material("floor"))]))
    if shell.open:
        sky = Light(
            (w / 2, d / 2, h + 5), (w / 2, 0, 0), (0, d / 2, 0), (0, 0, -1), w * d / np.pi, SKY
        )
        shell.lights.append(sky)
    else:
        ceiling = slab(-t, w + t, -t, d + t, h, h + 0.2)
        shell.things.append(Thing("ceiling", [Part(ceiling, kit.material("ceiling"))]))
    if notch[0]:
        block = slab(w - notch[0], w + t, d - notch[1], d + t, 0.0, h)
        shell.things.append(Thing("wall", [Part(block, wall)]))


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
        shell.things.append(Thing("slope", [Part(roof, plaster)]))
        shell.eaves.append((float(way), start, fall))


def _beams(kit: Kit, shell: Shell) -> None:
    """Beams under the ceiling, across the room."""
    thick = kit.between(0.12, 0.3)
    wood, count = kit.material("wood"), max(1, int(shell.width / kit.between(1.2, 3.0)))
    step = shell.width / count
    at = step * (np.arange(count) + 0.5)
    beams = [
        slab(x - thick / 3, x + thick / 3, 0, shell.depth, shell.height - thick, shell.height)
        for x in at
    ]
    shell.things.append(Thing("beams", [Part(beam, wood) for beam in beams]))
    shell.lowest = thick


def _skirting(kit: Kit, shell: Shell) -> None:
    """Boards at the foot of the walls, between what reaches the floor."""
    high, paint, parts = kit.between(0.05, 0.12), kit.material("front"), []
    for wall in shell.walls:
        cuts = sorted((a, b) for a, b, c, _ in wall.taken if c < high)
        ends = [0.0, *(e for cut in cuts for e in cut), wall.length]
        for x0, x1 in zip(ends[::2], ends[1::2], strict=True):
            if x1 > x0 + 0.05:
                parts.append(Part(wall.put(slab(x0, x1, -0.014, 0.0, 0.0, high)), paint))
    if parts:
        shell.things.append(Thing("skirting", parts))
