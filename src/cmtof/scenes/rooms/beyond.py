"""Rooms beyond the main one: corridors and next rooms behind a door or a wide opening."""

from dataclasses import dataclass

import numpy as np

from cmtof.scenes.rooms.finishes import finish
from cmtof.scenes.rooms.materials import Style
from cmtof.scenes.rooms.panels import Opening, Points
from cmtof.scenes.rooms.plan import Rect, outline
from cmtof.scenes.rooms.walls import Room, Wall, room

NEXT = {
    "living": ("hallway", "dining", "kitchen", "office"),
    "dining": ("kitchen", "living", "hallway"),
    "kitchen": ("dining", "hallway", "living"),
    "bedroom": ("hallway", "bathroom"),
    "office": ("hallway", "office"),
    "hallway": ("living", "kitchen", "bedroom"),
    "bathroom": ("hallway", "bedroom"),
    "workshop": ("office", "hallway"),
    "nursery": ("hallway", "bedroom"),
    "attic": ("hallway", "bedroom"),
}
"""What lies beside each kind of room."""


@dataclass(eq=False)
class Passage:
    """A doorway between two rooms: the hole in each of the two walls."""

    near: Wall
    hole: Opening
    far: Wall
    wide: bool
    """Without a door."""


def side_of(wall: Wall, rect: Rect) -> int:
    """Which side of a rectangle a wall lies on, counter-clockwise from y = 0; -1 for none."""
    low = np.minimum(wall.start, wall.end)
    high = np.maximum(wall.start, wall.end)
    x0, x1, y0, y1 = rect
    flat = (high[1] - y0, x1 - low[0], y1 - low[1], high[0] - x0)
    found = [s for s, gap in enumerate(flat) if abs(gap) < 1e-6]
    return found[0] if found else -1


def annex(
    rng: np.random.Generator,
    style: Style,
    beside: Room,
    wall: Wall,
    rect: Rect,
    limits: tuple[float, float],
    *,
    corridor: bool,
) -> tuple[Room, Passage] | None:
    """A room behind a wall that lies on a side of the rectangle, and the way into it.

    Parameters
    ----------
    rect : Rect
        Bounding rectangle of the room that the wall belongs to.
    limits : (low, high)
        How far the new room may reach along the wall, m; it may be wider than the wall.
    """
    side = side_of(wall, rect)
    axis = side % 2
    tall = [_standing(wall, a, b) for a, b in wall.gaps(margin=0.0) if b - a > 1.1]
    tall = [span for span in tall if span[1] - span[0] > 1.1]
    if not tall:
        return None
    stretch = max(tall, key=lambda t: t[1] - t[0])
    ends = [float(wall.end[axis] - x * wall.along[axis]) for x in stretch]
    low, high = min(ends), max(ends)
    kind = "hallway" if corridor else str(rng.choice(NEXT[beside.kind]))
    deep = float(rng.uniform(3.0, 7.5) if corridor else rng.uniform(2.6, 5.5))
    width = float(rng.uniform(1.15, 1.9) if corridor else rng.uniform(2.6, 5.0))
    width = min(width, limits[1] - limits[0])
    # at least 1.1 m of both rooms lie beside one another
    first, last = max(limits[0], low - width + 1.1), min(limits[1] - width, high - 1.1)
    p = first + float(rng.uniform()) * max(0.0, last - first)
    top = max(z for _, z in wall.top)
    height = min(round(float(rng.uniform(2.3, 2.8)), 2), top if top == wall.height else 2.3)
    built = _box(rng, style, kind, side, (p, p + width), deep, wall, rect, height)
    far = built.walls[(side + 2) % 4]
    far.thickness, far.shared = 0.0, True
    passage = _passage(rng, wall, far, axis, (max(p, low), min(p + width, high)), height)
    if passage is None:
        return None
    wall.shared = True
    return built, passage


def _standing(wall: Wall, x0: float, x1: float) -> tuple[float, float]:
    """The part of a piece of wall that is at least 2.3 m high."""
    xs = np.linspace(x0, x1, 60)
    stops, heights = zip(*wall.top, strict=True)
    tall = xs[np.interp(xs, stops, heights) >= 2.28]
    return (float(tall[0]), float(tall[-1])) if len(tall) else (0.0, 0.0)


def _box(
    rng: np.random.Generator,
    style: Style,
    kind: str,
    side: int,
    span: tuple[float, float],
    deep: float,
    wall: Wall,
    rect: Rect,
    height: float,
) -> Room:
    """A rectangular room beyond a side."""
    x0, x1, y0, y1 = rect
    t = wall.thickness
    low = ((span[0], y0 - t - deep), (x1 + t, span[0]), (span[0], y1 + t), (x0 - t - deep, span[0]))
    width, depth = (span[1] - span[0], deep) if side % 2 == 0 else (deep, span[1] - span[0])
    points: Points = outline(width, depth, []) + np.array(low[side])
    made = finish(rng, style, kind)
    facade = made.wall
    return room(kind, points, height, made, facade, float(rng.uniform(0.15, 0.3)))


def _passage(
    rng: np.random.Generator,
    near: Wall,
    far: Wall,
    axis: int,
    span: tuple[float, float],
    height: float,
) -> Passage | None:
    """A doorway or a wide opening inside what both walls share."""
    shared = span[1] - span[0] - 0.201
    wide = bool(rng.uniform() < 0.35)
    width = min(float(rng.uniform(1.2, 2.8) if wide else rng.uniform(0.82, 1.0)), shared)
    if width < 0.75:
        return None
    top = min(
        float(rng.uniform(2.05, 2.5) if wide else rng.choice([2.0, 2.05, 2.1])), height - 0.06
    )
    shape = "arch" if wide and width < 1.9 and rng.uniform() < 0.35 else "rectangle"
    middle = float(rng.uniform(span[0] + 0.1 + width / 2, span[1] - 0.1 - width / 2))
    holes = []
    for wall in (near, far):
        x = float(abs(wall.end[axis] - middle))
        holes.append(Opening(x - width / 2, x + width / 2, 0.0, top, shape))
        wall.cut(holes[-1], door=True, framed=not wide)
    return Passage(near, holes[0], far, wide)
