"""Doors, passages and windows of rooms, and what is seen through them."""

import numpy as np
from trimesh import Trimesh

from cmtof_rooms.boxes import Box, Boxes, Vector
from cmtof_rooms.kit import Kit
from cmtof_rooms.materials import Colour, Material
from cmtof_rooms.presets import presets
from cmtof_rooms.shell import THICKNESS, Shell, Wall
from cmtof_rooms.solids import ball, move, plate, turn_about_z
from cmtof_rooms.things import Light, level_light

SKY: Colour = (0.95, 1.0, 1.06)  # colour of daylight


def add_door(kit: Kit, shell: Shell, wall: Wall) -> None:
    """Add a door in its frame, shut, where the wall has room for it."""
    hole = _doorway(kit, shell, wall, kit.draw("door"), side=0.08, above=0.1)
    if hole is None:
        return
    front = kit.material("front")
    leaf = hole.cut(y0=0.06, y1=0.1)
    handle = Box(hole.x0 + 0.06, hole.x0 + 0.18, 0.02, 0.04, 1.02, 1.04)
    frame = hole.inset(z1=-0.07).cut(y0=-0.02, y1=0.0)
    shell.build(
        "door",
        wall.place,
        (front, leaf),
        (kit.material("metal"), handle),
        (
            front,
            frame.inset(x=-0.07).ends("x", 0.07),
            frame.cut(z0=hole.z1),
        ),
    )


def add_passage(kit: Kit, shell: Shell, wall: Wall) -> None:
    """Add an open passage to a room beyond, where the wall has room for it."""
    width, height = kit.draw("passage")
    height = min(height, shell.height - 0.15)
    hole = _doorway(kit, shell, wall, (min(width, 0.6 * wall.length), height))
    if hole is None:
        return
    left, right, depth = kit.draw("room_beyond")
    far = THICKNESS + depth
    ceiling = max(height + 0.1, min(shell.height, 3.0))
    space = Box(hole.x0 - left, hole.x1 + right, THICKNESS, far, 0.0, ceiling)
    outer = space.inset(x=-THICKNESS, y1=-THICKNESS)  # with the walls of that room
    paint = kit.material("wall")
    shell.build(
        "room beyond",
        wall.place,
        (paint, outer.ends("x", THICKNESS), outer.cut(y0=far)),
        (kit.material("floor"), outer.cut(y0=0.0, z0=-0.2, z1=0.0)),
        (paint, outer.cut(z0=ceiling, z1=ceiling + THICKNESS)),
    )
    shell.beyond.append(Wall(wall.place.at(space.x0, far), space.size[0]))
    lamp = wall.place.carry(space.cut(z0=ceiling - 0.06).middle)
    shell.lights.append(
        level_light(lamp, 0.4, min(0.25 * (space.x1 - space.x0) * depth, 2.0))
    )


def _doorway(
    kit: Kit, shell: Shell, wall: Wall, size: Vector, **margins: float
) -> Box | None:
    """Cut a hole of a size, m, into a free piece of a wall, and return it; None after some tries.

    The floor before it stays free.
    """
    width, height = size
    for _ in range(12):
        x = kit.between(0.15, wall.length - width - 0.15)
        hole = Box(x, x + width, 0.0, THICKNESS, 0.0, height)
        if not hole.inset(x=-0.1, z1=-9.0).meets(wall.taken):
            wall.cut(hole, **margins)
            shell.keep.append(wall.in_room(hole.cut(y0=-0.9, y1=0.0)))
            return hole
    return None


def add_windows(kit: Kit, shell: Shell, wall: Wall, *, view: bool) -> None:
    """Add a row of windows: bright panes or, with a ``view``, open to what is outside."""
    spacing, width, sill, head = kit.draw("windows")
    count = int(np.clip(wall.length / spacing, 1, 5))
    each = wall.length / count
    width = min(width, 0.75 * each)
    head *= shell.height
    starts = each * (np.arange(count) + 0.5) - width / 2
    row = Box(starts, starts + width, 0.0, THICKNESS, sill, head)
    holes = [one for one in row.singles() if not one.inset(x=-0.1).meets(wall.taken)]
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
    holes: Boxes,
    *,
    view: bool,
) -> None:
    """Cut windows into a wall, with frames and, without a view, bright panes."""
    trim = kit.material("front")
    pane = Material(SKY, emission=shell.sky * kit.between(0.7, 1.3))
    columns, rows = kit.rng.integers(1, 4, 2)
    pieces = []
    for hole in holes:
        wall.cut(hole)
        whole = hole.cut(y0=0.06, y1=0.11)
        pieces.append(
            (
                trim,
                whole.ends("x", 0.06),
                whole.ends("z", 0.06),
                whole.bars("x", whole.split("x", columns).x0[1:], 0.02),
                whole.bars("z", whole.split("z", rows).z0[1:], 0.02),
            )
        )
        if not view:
            pieces.append((pane, whole.cut(y0=0.08, y1=0.09)))
    shell.build("window", wall.place, *pieces)


def _daylight(wall: Wall, holes: Boxes, power: float) -> Light:
    """One light for a row of windows, 1 cm before the wall."""
    row = holes[0].cut(x1=holes[-1].x1, y0=-0.02, y1=0.0)
    half_x, _, half_z = row.size / 2
    along, outwards, up = turn_about_z(wall.place.turn)
    return Light(
        wall.place.carry(row.middle),
        along * half_x,
        up * half_z,
        -outwards,
        power,
        SKY,
    )


def _add_outdoors(kit: Kit, shell: Shell, wall: Wall) -> None:
    """Add ground, a house across the street and trees, bright by themselves."""
    drop, far, share, width, height = kit.draw("outdoors")
    look = {
        name: Material(**fields, emission=shell.sky * share)
        for name, fields in presets()["outdoors"].items()
    }
    street = wall.place.at(wall.length / 2, 0.0, -drop)
    house = Box(-width / 2, width / 2, far + 0.3, far + 8, 0.0, height)
    facade = move(_facade(width, height), (house.x0, far, 0.0))
    shell.build(
        "house outside",
        street,
        (look["lawn"], Box(-60, 60, 0.3, far + 30, -0.5, 0.0)),
        (look["front"], facade),
        (look["behind"], house),
    )
    for _ in range(kit.count((0, 3))):
        shell.build("tree outside", street, (look["tree"], _tree(kit, far)))


def _tree(kit: Kit, far: float) -> Trimesh:
    """Crown of a tree between the windows and a house that is ``far``, m, away."""
    size = kit.between(1.0, 2.5)
    crown = ball((size, size, 1.2 * size), noise=0.3, rng=kit.rng, fineness=3)
    along, share = kit.draw("tree")
    return move(crown, (along, share * far, 1.4 * size))


def _facade(width: float, height: float) -> Trimesh:
    """Front of a house with rows of open windows."""
    columns = np.arange(1.2, width - 1.5, 3.0)
    rows = np.arange(1.0, height - 1.8, 3.0)
    holes = [(x, x + 1.2, z, z + 1.5) for x in columns for z in rows]
    return plate(width, height, 0.3, holes)
