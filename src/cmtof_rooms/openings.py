"""Doors, passages and windows of rooms, and what is seen through them."""

import numpy as np
from trimesh import Trimesh

from cmtof_rooms.arrays import Triple
from cmtof_rooms.boxes import Box, Rectangle, Rectangles
from cmtof_rooms.kit import Kit
from cmtof_rooms.materials import Colour, Material
from cmtof_rooms.presets import presets
from cmtof_rooms.shell import THICKNESS, Shell, Wall
from cmtof_rooms.solids import ball, move, plate
from cmtof_rooms.things import Light, level_light

SKY: Colour = (0.95, 1.0, 1.06)  # colour of daylight


def add_door(kit: Kit, shell: Shell, wall: Wall) -> None:
    """Add a door in its frame, shut, where the wall has room for it."""
    width, height = kit.draw("door")
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
        (
            front,
            frame.cut(x0=jambs, x1=jambs + 0.07),
            frame.cut(z0=height),
        ),
    )


def add_passage(kit: Kit, shell: Shell, wall: Wall) -> None:
    """Add an open passage to a room beyond, where the wall has room for it."""
    width, height = kit.draw("passage")
    width = min(width, 0.6 * wall.length)
    height = min(height, shell.height - 0.15)
    x = wall.gap(kit, width)
    if x is None:
        return
    hole = Rectangle(x, x + width, 0.0, height)
    wall.cut(hole)
    shell.keep.append(wall.footprint(hole, -0.9, 0.0))
    left, right, depth = kit.draw("room_beyond")
    far = THICKNESS + depth
    ceiling = max(height + 0.1, min(shell.height, 3.0))
    space = Box(x - left, hole.x1 + right, THICKNESS, far, 0.0, ceiling)
    _add_room_beyond(kit, shell, wall, space)
    corner = wall.place((space.x0, far, 0.0))[:2]
    shell.beyond.append(Wall(tuple(corner), wall.turn, space.x1 - space.x0))
    shell.lights.append(_lamp_beyond(wall, space, depth))


def _lamp_beyond(wall: Wall, space: Box, depth: float) -> Light:
    """Lamp under the ceiling of a room beyond a wall, stronger in a larger one."""
    x0, x1, y0, y1, _, height = space
    middle = wall.place(((x0 + x1) / 2, (y0 + y1) / 2, height - 0.03))
    return level_light(middle, 0.4, 0.4, min(0.25 * (x1 - x0) * depth, 2.0))


def _add_room_beyond(kit: Kit, shell: Shell, wall: Wall, space: Box) -> None:
    """Add walls, floor and ceiling of a room beyond a wall, about its free space."""
    t = THICKNESS
    paint = kit.material("wall")
    outer = space.inset(x0=-t, x1=-t, y1=-t)
    sides = np.array([space.x0 - t, space.x1])
    shell.build(
        "room beyond",
        wall,
        (
            paint,
            outer.cut(x0=sides, x1=sides + t),
            outer.cut(y0=space.y1),
        ),
        (kit.material("floor"), outer.cut(y0=0.0, z0=-0.2, z1=0.0)),
        (paint, outer.cut(z0=space.z1, z1=space.z1 + t)),
    )


def add_windows(kit: Kit, shell: Shell, wall: Wall, *, view: bool) -> None:
    """Add a row of windows: bright panes or, with a ``view``, open to what is outside."""
    spacing, width, sill, head = kit.draw("windows")
    count = int(np.clip(wall.length / spacing, 1, 5))
    each = wall.length / count
    width = min(width, 0.75 * each)
    head *= shell.height
    starts = each * (np.arange(count) + 0.5) - width / 2
    holes = [Rectangle(x, x + width, sill, head) for x in starts.tolist()]
    holes = [hole for hole in holes if wall.free(hole.grow(0.1, 0.1, 0, 0))]
    if holes:
        _glaze(kit, shell, wall, holes, view=view)
        power = len(holes) * width * (head - sill) * shell.sky / np.pi
        shell.lights.append(_daylight(wall, holes, power))
        if view:
            _add_outdoors(kit, shell, wall)


def _glaze(
    kit: Kit,
    shell: Shell,
    wall: Wall,
    holes: Rectangles,
    *,
    view: bool,
) -> None:
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


def _daylight(wall: Wall, holes: Rectangles, power: float) -> Light:
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
    drop, far, share, width, height = kit.draw("outdoors")
    look = _outdoor_materials(shell.sky * share)
    middle = wall.length / 2
    house = Box(
        middle - width / 2,
        middle + width / 2,
        far + 0.3,
        far + 8,
        -drop,
        height - drop,
    )
    facade = move(_facade(width, height), (house.x0, far, -drop))
    shell.build(
        "house outside",
        wall,
        (
            look["lawn"],
            Box(
                middle - 60,
                middle + 60,
                0.3,
                far + 30,
                -drop - 0.5,
                -drop,
            ),
        ),
        (look["front"], facade),
        (look["behind"], house),
    )
    for _ in range(kit.count((0, 3))):
        tree = _tree(kit, (middle, far, -drop))
        shell.build("tree outside", wall, (look["tree"], tree))


def _outdoor_materials(glow: float) -> dict[str, Material]:
    """Materials of what is outside, by name, of a radiance per reflectance."""
    looks = presets()["outdoors"]
    return {name: Material(**fields, emission=glow) for name, fields in looks.items()}


def _tree(kit: Kit, place: Triple) -> Trimesh:
    """Crown of a tree at some way from the window to a place, m."""
    middle, far, level = place
    size = kit.between(1.0, 2.5)
    crown = ball((size, size, 1.2 * size), noise=0.3, rng=kit.rng, fineness=3)
    along, share = kit.draw("tree")
    return move(crown, (middle + along, share * far, level + 1.4 * size))


def _facade(width: float, height: float) -> Trimesh:
    """Front of a house with rows of open windows."""
    columns = np.arange(1.2, width - 1.5, 3.0)
    rows = np.arange(1.0, height - 1.8, 3.0)
    holes = [(x, x + 1.2, z, z + 1.5) for x in columns for z in rows]
    return plate(width, height, 0.3, holes)
