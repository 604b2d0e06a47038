"""Empty rooms built from a seed: walls with openings, floor, ceiling, slopes, beams, skirting."""

import numpy as np

from cmtof.types import Fields
from cmtof_rooms.boxes import Box
from cmtof_rooms.kit import Kit
from cmtof_rooms.openings import (
    SKY,
    add_door,
    add_passage,
    add_windows,
)
from cmtof_rooms.shell import Shell, Wall
from cmtof_rooms.solids import sheet
from cmtof_rooms.things import ROOM, Light, Place, Thing


def build_shell(kit: Kit, room: Fields) -> Shell:
    """Build an empty room of a kind.

    Parameters
    ----------
    kit : Kit
    room : dict
        One of the ``rooms`` of `presets.yml`: ``size`` (lowest and highest width, depth and height,
        m), and perhaps ``open``, ``slope``, ``beams``.
    """
    width, depth, height = kit.each(room["size"])
    is_open = room.get("open", False)
    quarter = np.pi / 2
    walls = [
        Wall(Place(width, 0.0, turn=np.pi), width),
        Wall(Place(width, depth, turn=-quarter), depth),
        Wall(Place(0.0, depth), width),
        Wall(Place(0.0, 0.0, turn=quarter), depth),
    ]
    shell = Shell(
        width,
        depth,
        height,
        walls,
        [Box(0.0, width, 0.0, depth, 0.0, height)],
        open=is_open,
        day=is_open or kit.chance(0.75),
    )
    if not is_open and min(width, depth) >= 3.6 and kit.chance(0.25):
        _cut_corner(kit, shell)
    _add_openings(kit, shell)
    paint = kit.material("wall")
    for wall in shell.walls[:4]:
        shell.build("wall", wall.place, (paint, wall.solid(height)))
    _add_levels(kit, shell)
    for face in shell.walls[4:5]:
        block = shell.reach(0.0, height).cut(x0=face.place.x, y0=face.place.y)
        shell.build("wall", ROOM, (paint, block))
    if kit.chance(room.get("slope", 0.0)):
        _add_slopes(kit, shell)
    elif kit.chance(room.get("beams", 0.1)) and not is_open:
        _add_beams(kit, shell)
    if kit.chance(0.5):
        _add_skirting(kit, shell)
    return shell


def _cut_corner(kit: Kit, shell: Shell) -> None:
    """Make the room an L by a block in one corner: two more walls, a floor of two rectangles."""
    (whole,) = shell.floor
    size = whole.high[:2] * kit.draw("notch")  # of the block
    x, y = whole.high[:2] - size
    # the outer walls behind the block stay, but nothing stands there
    shell.walls[1].taken.append(Box(0.0, size[1], -9.0, 9.0, 0.0, 99.0))
    shell.walls[2].taken.append(Box(x, shell.width, -9.0, 9.0, 0.0, 99.0))
    shell.walls += [
        Wall(Place(x, y), size[0]),
        Wall(Place(x, shell.depth, turn=-np.pi / 2), size[1]),
    ]
    shell.floor = [whole.cut(y1=y), whole.cut(x1=x)]


def _add_openings(kit: Kit, shell: Shell) -> None:
    """Add a door, perhaps a passage, and windows in one wall or two."""
    first, second, *others = [shell.walls[k] for k in kit.rng.permutation(4)]
    add_door(kit, shell, first)
    if not shell.open and kit.chance(0.35):
        add_passage(kit, shell, second)
    glazed = others if kit.chance(0.35) else others[:1]
    view = not shell.open and shell.day and kit.chance(0.35)
    for wall in glazed:
        add_windows(kit, shell, wall, view=view)


def _add_levels(kit: Kit, shell: Shell) -> None:
    """Add the floor and the ceiling or, of an open room, the sky."""
    shell.build("floor", ROOM, (kit.material("floor"), shell.reach(-0.2, 0.0)))
    if shell.open:
        x = shell.width / 2
        y = shell.depth / 2
        shell.lights.append(
            Light(
                (x, y, shell.height + 5),
                (x, 0, 0),
                (0, y, 0),
                (0, 0, -1),
                4 * x * y / np.pi,
                SKY,
            )
        )
    else:
        above = shell.reach(shell.height, shell.height + 0.2)
        shell.build("ceiling", ROOM, (kit.material("ceiling"), above))


def _add_slopes(kit: Kit, shell: Shell) -> None:
    """Add a roof slope along x over the side y = depth, or one over each side, y = 0 and depth."""
    depth = shell.depth
    height = shell.height
    plaster = kit.material("ceiling")
    reach = shell.reach(0.0, height)
    for way in (1, -1) if kit.chance(0.5) else (1,):
        share, low = kit.draw("slope")
        start = depth * (0.5 + way * share)
        fall = (height - low) / (depth * (0.5 - share))
        end = reach.y1 if way > 0 else reach.y0
        foot = height - fall * abs(end - start)
        edges = [[(x, start, height), (x, end, foot)] for x in (reach.x0, reach.x1)]
        shell.build("slope", ROOM, (plaster, sheet(edges, 0.02)))
        shell.eaves.append((way, start, fall))


def _add_beams(kit: Kit, shell: Shell) -> None:
    """Add beams under the ceiling, across the room."""
    thickness = kit.between(0.12, 0.3)
    wood = kit.material("wood")
    count = max(1, int(shell.width / kit.between(1.2, 3.0)))
    middles = shell.width / count * (np.arange(count) + 0.5)
    space = Box(0, 0, 0, shell.depth, shell.height - thickness, shell.height)
    shell.build("beams", ROOM, (wood, space.bars("x", middles, thickness / 3)))
    shell.lowest = thickness


def _add_skirting(kit: Kit, shell: Shell) -> None:
    """Add boards at the foot of the walls, between what reaches the floor."""
    height = kit.between(0.05, 0.12)
    paint = kit.material("front")
    parts = []
    for wall in shell.walls:
        cuts = sorted(taken[:2] for taken in wall.taken if taken.z0 < height)
        ends = np.array([0.0, *np.ravel(cuts), wall.length]).reshape(-1, 2)
        x0, x1 = ends[ends[:, 1] > ends[:, 0] + 0.05].T
        parts += wall.place.parts(paint, Box(x0, x1, -0.014, 0.0, 0.0, height))
    shell.things.append(Thing("skirting", parts))
