"""Doors, passages and windows of rooms, and what is seen through them."""

import numpy as np
from trimesh import Trimesh

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
    end = x + width
    wall.cut(Rectangle(x, end, 0.0, height), side=0.08, above=0.1)
    shell.keep.append(wall.footprint(x, end, -0.9, 0.0))
    front = kit.material("front")
    metal = kit.material("metal")
    leaf = Box(x, end, 0.06, 0.1, 0.0, height)
    handle = Box(x + 0.06, x + 0.18, 0.02, 0.04, 1.02, 1.04)
    frame = Box(x, end, -0.02, 0.0, 0.0, height + 0.07)
    jambs = np.array([x - 0.07, end])
    frames = (frame.cut(x0=jambs, x1=jambs + 0.07), frame.cut(z0=height))
    shell.build("door", wall, (front, leaf), (metal, handle), (front, *frames))


def add_passage(kit: Kit, shell: Shell, wall: Wall) -> None:
    """Add an open passage to a room beyond, where the wall has room for it."""
    width = min(kit.between(0.9, 2.6), 0.6 * wall.length)
    height = min(kit.between(2.05, 2.6), shell.height - 0.15)
    x = wall.gap(kit, width)
    if x is None:
        return
    end = x + width
    wall.cut(Rectangle(x, end, 0.0, height))
    shell.keep.append(wall.footprint(x, end, -0.9, 0.0))
    left = x - kit.between(0.1, 1.5)
    right = end + kit.between(0.1, 1.5)
    depth = kit.between(2.0, 7.0)
    ceiling = max(height + 0.1, min(shell.height, 3.0))
    _add_room_beyond(kit, shell, wall, Box(left, right, 0.0, depth, 0.0, ceiling))


def _add_room_beyond(kit: Kit, shell: Shell, wall: Wall, space: Box) -> None:
    """Add walls, floor, ceiling and a lamp of a room beyond a wall, from its outer face on."""
    left, right, _, depth, _, height = space
    t = THICKNESS
    far = t + depth
    paint = kit.material("wall")
    ground = kit.material("floor")
    outer = Box(left - t, right + t, t, far + t, 0.0, height)
    sides = np.array([left - t, right])
    shell.build(
        "room beyond",
        wall,
        (paint, outer.cut(x0=sides, x1=sides + t), outer.cut(y0=far)),
        (ground, outer.cut(y0=0.0, z0=-0.2, z1=0.0)),
        (paint, outer.cut(z0=height, z1=height + t)),
    )
    x, y, _ = wall.place((left, far, 0.0)).tolist()
    shell.beyond.append(Wall((x, y), wall.turn, right - left))
    middle = wall.place(((left + right) / 2, (t + far) / 2, height - 0.03))
    power = 0.25 * (right - left) * depth
    shell.lights.append(level_light(middle, 0.4, 0.4, min(power, 2.0)))


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
    if not holes:
        return
    trim = kit.material("front")
    pane = Material(SKY, emission=shell.sky * kit.between(0.7, 1.3))
    bars = kit.rng.integers(0, 3, 2)
    built = []
    for hole in holes:
        wall.cut(hole)
        built.append((trim, *_window_frame(hole, *bars)))
        if not view:
            built.append((pane, Box(hole.x0, hole.x1, 0.08, 0.09, sill, head)))
    shell.build("window", wall, *built)
    shell.lights.append(_daylight(wall, holes, width, shell.sky))
    if view:
        _add_outdoors(kit, shell, wall)


def _window_frame(hole: Rectangle, upright: int, level: int) -> list[Box]:
    """Frame of a window, with numbers of bars across it."""
    x0, x1, z0, z1 = hole
    whole = Box(x0, x1, 0.06, 0.11, z0, z1)
    return [
        whole.ends("x", 0.06),
        whole.ends("z", 0.06),
        whole.bars("x", np.linspace(x0, x1, upright + 2)[1:-1], 0.02),
        whole.bars("z", np.linspace(z0, z1, level + 2)[1:-1], 0.02),
    ]


def _daylight(wall: Wall, holes: list[Rectangle], width: float, sky: float) -> Light:
    """One light for a row of windows of a width, as bright as the sky through all of them."""
    start, _, sill, head = holes[0]
    end = holes[-1].x1
    area = len(holes) * width * (head - sill)
    along, outwards, up = wall.place(np.eye(3)) - wall.place(np.zeros(3))
    return Light(
        wall.place(((start + end) / 2, -0.01, (sill + head) / 2)),
        along * (end - start) / 2,
        up * (head - sill) / 2,
        -outwards,
        area * sky / np.pi,
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
    green = Material((0.08, 0.18, 0.05), emission=glow)
    width = kit.between(15, 45)
    height = kit.between(5, 14)
    left = middle - width / 2
    ground = Box(middle - 60, middle + 60, 0.3, far + 30, level - 0.5, level)
    behind = Box(left, middle + width / 2, far + 0.3, far + 8, level, level + height)
    front = move(_facade(width, height), (left, far, level))
    shell.build("house outside", wall, (lawn, ground), (facade, front), (rooms, behind))
    for _ in range(int(kit.rng.integers(0, 4))):
        size = kit.between(1.0, 2.5)
        crown = ball((size, size, 1.2 * size), noise=0.3, rng=kit.rng, fineness=3)
        x = middle + kit.between(-8, 8)
        y = kit.between(0.3, 0.9) * far
        tree = move(crown, (x, y, level + 1.4 * size))
        shell.build("tree outside", wall, (green, tree))


def _facade(width: float, height: float) -> Trimesh:
    """Front of a house with rows of open windows."""
    columns = np.arange(1.2, width - 1.5, 3.0)
    rows = np.arange(1.0, height - 1.8, 3.0)
    holes = [(x, x + 1.2, z, z + 1.5) for x in columns for z in rows]
    return plate(width, height, 0.3, holes)
