"""What is in a doorway: a door, a bare threshold, or a door that nobody opens."""

import numpy as np

from cmtof.scenes.rooms.beyond import Passage
from cmtof.scenes.rooms.doors import door
from cmtof.scenes.rooms.house import Point
from cmtof.scenes.rooms.materials import Style
from cmtof.scenes.rooms.panels import Opening
from cmtof.scenes.rooms.plan import Rect
from cmtof.scenes.rooms.solids import box
from cmtof.scenes.rooms.thing import Pose, Thing
from cmtof.scenes.rooms.walls import Room, Wall, place

Placed = list[tuple[Thing, Pose]]


def fill_passage(
    rng: np.random.Generator, style: Style, passage: Passage, main: Room
) -> tuple[Placed, list[tuple[Point, Point]], Rect | None]:
    """The door or the threshold; the doorway if one can look through; floor that a leaf takes."""
    wall, hole = passage.near, passage.hole
    width, middle, depth = hole.x1 - hole.x0, hole.centre[0], wall.thickness
    strip = style.wood if rng.uniform() < 0.3 else main.finish.floor
    x, y, _ = place(wall, middle, depth / 2, 0.0)
    doorway = ((x, y), (float(wall.inward[0]), float(wall.inward[1])))
    if passage.wide:
        bar = box((width - 0.002, depth + 0.05, 0.02), (0, depth / 2, -0.0065))
        return [(Thing("threshold").add(bar, strip), wall.at(middle))], [doorway], None
    angle = (None, 0.45, 1.35, 1.5, 1.7)[int(rng.choice(5, p=[0.3, 0.15, 0.15, 0.25, 0.15]))]
    inwards = bool(rng.uniform() < 0.5)
    sliding = bool(rng.uniform() < 0.2) and _beside_free(wall, hole)
    made = door(
        rng,
        style,
        width=width,
        height=hole.z1,
        depth=depth,
        threshold=strip,
        angle=angle,
        inwards=inwards,
        sliding=sliding,
    )
    if sliding:
        wall.block(hole.x0 - width - 0.15, hole.x1 + width + 0.15, 0.0)
    seen = [doorway] if angle is None or angle > 1.2 or sliding else []
    swing = None
    if angle is not None and inwards and not sliding:
        corners = np.array(
            [place(wall, u, v, 0.0) for u in (hole.x0, hole.x1) for v in (0.0, -width)]
        )
        low, high = corners.min(0), corners.max(0)
        swing = (float(low[0]), float(high[0]), float(low[1]), float(high[1]))
    return [(made, wall.at(middle))], seen, swing


def _beside_free(wall: Wall, hole: Opening) -> bool:
    """Whether a leaf can slide to either side of a hole."""
    width = hole.x1 - hole.x0
    a, b = hole.x0 - width - 0.1, hole.x1 + width + 0.1
    others = [o for o in wall.openings if o is not hole]
    return a > 0 and b < wall.length and all(o.x1 < a or o.x0 > b for o in others)


def blind_door(rng: np.random.Generator, style: Style, built: Room, walls: list[Wall]) -> Placed:
    """A closed door in a free piece of one of the walls; what lies behind is boarded up."""
    width, height = float(rng.uniform(0.78, 0.95)), float(rng.choice([2.0, 2.05, 2.1]))
    order = rng.permutation(len(walls)).tolist()
    share = float(rng.uniform())
    for k in order:
        wall = walls[k]
        free = [(a, b) for a, b in wall.gaps(margin=0.2) if b - a > width + 0.1]
        if not free or wall.thickness < 0.05 or wall.shared:
            continue
        a, b = free[0]
        x = a + (b - a - width) * share
        if wall.headroom(x, x + width) < height + 0.15:
            continue
        wall.cut(Opening(x, x + width, 0.0, height), door=True, framed=True)
        middle, depth = x + width / 2, wall.thickness
        made = door(
            rng, style, width=width, height=height, depth=depth, threshold=built.finish.floor
        )
        plate = box((width + 0.3, 0.03, height + 0.3), (0, depth + 0.017, height / 2 - 0.1))
        made.add(plate, built.facade)
        return [(made, wall.at(middle))]
    return []
