"""Doors, passages and windows of rooms, and what is seen through them."""

import numpy as np
from trimesh import Trimesh

from cmtof_rooms.arrays import Triple
from cmtof_rooms.boxes import Box, Rectangle
from cmtof_rooms.kit import Kit
from cmtof_rooms.materials import Colour, Material
from cmtof_rooms.shell import Shell
from cmtof_rooms.solids import ball, move, plate
from cmtof_rooms.things import Light, level_light
from cmtof_rooms.walls import THICKNESS, Wall

SKY: Colour = (0.95, 1.0, 1.06)
"""Colour of daylight."""


def add_door(kit: Kit, shell: Shell, wall: Wall) -> None:
    """Add a door in its frame, shut, where the wall has room for it."""
    width = kit.between(0.8, 1.0)
    height = kit.between(1.98, 2.15)
    x = wall.gap(kit, width)
    if x is None:
        return
    hole = Rectangle(x, x + width, 0.0, height)
    wall.cut(hole, side=0.08, above=0.1)
    shell.keep.append(wall.footprint(hole, -0.9, 0.0))
    front = kit.material("front")
    leaf = Box(x, hole.x1, 0.06, 0.1, 0.0, height)
    handle = Box(x + 0.06, x + 0.18, 0.02, 0.04, 1.02, 1.04)
    frame = leaf.cut(y0=-0.02, y1=0.0, z1=height + 0.07)
    jambs = np.array([x - 0.07, hole.x1])
    shell.build(
        "door",
        wall,
        (front, leaf),
        (kit.material("metal"), handle),
        (front, frame.cut(x0=jambs, x1=jambs + 0.07), frame.cut(z0=height)),
    )


def add_passage(kit: Kit, shell: Shell, wall: Wall) -> None:
    """Add an open passage to a room beyond, where the wall has room for it."""
    width = min(kit.between(0.9, 2.6), 0.6 * wall.length)
    height = min(kit.between(2.05, 2.6), shell.height - 0.15)
    x = wall.gap(kit, width)
    if x is None:
        return
    hole = Rectangle(x, x + width, 0.0, height)
    wall.cut(hole)
    shell.keep.append(wall.footprint(hole, -0.9, 0.0))
    left = x - kit.between(0.1, 1.5)
    right = hole.x1 + kit.between(0.1, 1.5)
    depth = kit.between(2.0, 7.0)
    ceiling = max(height + 0.1, min(shell.height, 3.0))
    _add_room_beyond(kit, shell, wall, Box(left, right, 0.0, depth, 0.0, ceiling))


def _add_room_beyond(kit: Kit, shell: Shell, wall: Wall, space: Box) -> None:
    """Add walls, floor, ceiling and a lamp of a room beyond a wall, from its outer face on."""
    t = THICKNESS
    left, right, _, depth, _, height = space
    far = t + depth
    paint = kit.material("wall")
    outer = Box(left - t, right + t, t, far + t, 0.0, height)
    sides = np.array([left - t, right])
    shell.build(
        "room beyond",
        wall,
        (paint, outer.cut(x0=sides, x1=sides + t), outer.cut(y0=far)),
        (kit.material("floor"), outer.cut(y0=0.0, z0=-0.2, z1=0.0)),
        (paint, outer.cut(z0=height, z1=height + t)),
    )
    width = right - left
    corner = wall.place((left, far, 0.0))[:2]
    shell.beyond.append(Wall(tuple(corner), wall.turn, width))
    lamp = ((left + right) / 2, (t + far) / 2, height - 0.03)
    power = min(0.25 * width * depth, 2.0)
    shell.lights.append(level_light(wall.place(lamp), 0.4, 0.4, power))


def add_windows(kit: Kit, shell: Shell, wall: Wall, *, view: bool) -> None:
    """Add a row of windows: bright panes or, with a ``view``, open to what is outside."""
    count = int(max(1, min(5, wall.length / kit.between(1.6, 3.5))))
    each = wall.length / count
    width = min(kit.between(0.8, 2.4), 0.75 * each)
    sill = kit.between(0.02, 1.0)
    head = shell.height * kit.between(0.75, 0.92)
    starts = [each * (k + 0.5) - width / 2 for k in range(count)]
    holes = [Rectangle(x, x + width, sill, head) for x in starts]
    holes = [hole for hole in holes if wall.free(hole.grown(0.1, 0.1, 0, 0))]
    if holes:
        _glaze(kit, shell, wall, holes, view=view)
        area = len(holes) * width * (head - sill)
        shell.lights.append(_daylight(wall, holes, area * shell.sky / np.pi))
        if view:
            _add_outdoors(kit, shell, wall)


def _glaze(kit: Kit, shell: Shell, wall: Wall, holes: list[Rectangle], *, view: bool) -> None:
    """Cut windows into a wall, with frames and, without a view, bright panes."""
    trim = kit.material("front")
    pane = Material(SKY, emission=shell.sky * kit.between(0.7, 1.3))
    bars = kit.rng.integers(0, 3, 2)
    pieces = []
    for hole in holes:
        wall.cut(hole)
        whole = Box(hole.x0, hole.x1, 0.06, 0.11, hole.y0, hole.y1)
        pieces.append((trim, *_window_frame(whole, *bars)))
        if not view:
            pieces.append((pane, whole.cut(y0=0.08, y1=0.09)))
    shell.build("window", wall, *pieces)


def _window_frame(whole: Box, upright: int, level: int) -> list[Box]:
    """Frame that fills a window, with numbers of bars across it."""
    x = np.linspace(whole.x0, whole.x1, upright + 2)[1:-1]
    z = np.linspace(whole.z0, whole.z1, level + 2)[1:-1]
    return [
        whole.ends("x", 0.06),
        whole.ends("z", 0.06),
        whole.bars("x", x, 0.02),
        whole.bars("z", z, 0.02),
    ]


def _daylight(wall: Wall, holes: list[Rectangle], power: float) -> Light:
    """One light for a row of windows."""
    start, _, sill, head = holes[0]
    end = holes[-1].x1
    along, outwards, up = wall.place(np.eye(3)) - wall.place(np.zeros(3))
    return Light(
        wall.place(((start + end) / 2, -0.01, (sill + head) / 2)),
        along * (end - start) / 2,
        up * (head - sill) / 2,
        -outwards,
        power,
        SKY,
    )


def _add_outdoors(kit: Kit, shell: Shell, wall: Wall) -> None:
    """Add ground, a house across the street and trees, bright by themselves."""
    level = -kit.between(0.2, 4.0)
    far = kit.between(9.0, 40.0)
    middle = wall.length / 2
    glow = shell.sky * kit.between(0.5, 1.0)
    lawn = Material((0.12, 0.2, 0.06), (0.25, 0.24, 0.2), "noise", 0.8, glow)
    facade = Material((0.6, 0.5, 0.4), emission=glow)
    rooms = Material((0.05, 0.06, 0.07), emission=glow)
    width = kit.between(15, 45)
    height = kit.between(5, 14)
    left = middle - width / 2
    ground = Box(middle - 60, middle + 60, 0.3, far + 30, level - 0.5, level)
    behind = Box(left, middle + width / 2, far + 0.3, far + 8, level, level + height)
    front = move(_facade(width, height), (left, far, level))
    shell.build("house outside", wall, (lawn, ground), (facade, front), (rooms, behind))
    _add_trees(kit, shell, wall, (far, level, glow))


def _add_trees(kit: Kit, shell: Shell, wall: Wall, place: Triple) -> None:
    """Add up to three trees before what lies far, on a level, of a radiance per reflectance."""
    far, level, glow = place
    green = Material((0.08, 0.18, 0.05), emission=glow)
    for _ in range(int(kit.rng.integers(0, 4))):
        size = kit.between(1.0, 2.5)
        crown = ball((size, size, 1.2 * size), noise=0.3, rng=kit.rng, fineness=3)
        x = wall.length / 2 + kit.between(-8, 8)
        y = kit.between(0.3, 0.9) * far
        tree = move(crown, (x, y, level + 1.4 * size))
        shell.build("tree outside", wall, (green, tree))


def _facade(width: float, height: float) -> Trimesh:
    """Front of a house with rows of open windows."""
    columns = np.arange(1.2, width - 1.5, 3.0)
    rows = np.arange(1.0, height - 1.8, 3.0)
    holes = [(x, x + 1.2, z, z + 1.5) for x in columns for z in rows]
    return plate(width, height, 0.3, holes)
