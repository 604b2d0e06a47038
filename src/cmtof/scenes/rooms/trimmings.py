"""What runs along walls and ceilings: skirting, cornices, wainscot, beams, coffers."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.layouts import Plan
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.panels import Opening, Points, panel, reveals, swept
from cmtof.scenes.rooms.plan import Rect, cells, offset
from cmtof.scenes.rooms.solids import box, joined
from cmtof.scenes.rooms.thing import Mesh, Pose, Thing, moved, pose
from cmtof.scenes.rooms.walls import SINK, Room, Wall

FRAME = 0.05
"""Mouldings end that far from a framed doorway, under its architrave, m."""
LINING = 0.010
"""Thickness of tiles or boards on the lower part of a wall, m."""


def paths(built: Room, z0: float, z1: float) -> list[tuple[Points, bool]]:
    """Lines along the foot of the walls, broken where openings cut heights from z0 to z1.

    Returns
    -------
    list of (points (N, 2), closed)
        Counter-clockwise, the room on their left.
    """
    found: list[list[Points]] = [[built.walls[0].start]]
    for wall in built.walls:
        holes = [
            (
                wall.length - o.x1 - FRAME * (j in wall.framed),
                wall.length - o.x0 + FRAME * (j in wall.framed),
            )
            for j, o in enumerate(wall.openings)
            if o.z0 < z1 and o.z1 > z0
        ]
        for a, b in sorted(holes):
            found[-1].append(wall.start + max(a, 1e-3) * wall.along)
            found.append([wall.start + min(b, wall.length - 1e-3) * wall.along])
        found[-1].append(wall.end)
    if len(found) == 1:
        return [(np.array(found[0][:-1]), True)]
    found[0] = found.pop() + found[0][1:]  # the last line runs on into the first
    return [(np.array(points), False) for points in found]


def moulding(built: Room, profile: list[tuple[float, float]]) -> Mesh:
    """A profile of (distance from the wall, height) swept along all walls of a room."""
    heights = [z for _, z in profile]
    lines = paths(built, min(heights), max(heights))
    return joined([swept(points, profile, closed=closed) for points, closed in lines])


def skirting(rng: np.random.Generator, built: Room, material: Material) -> Thing:
    """Boards along the foot of the walls."""
    high, thick = float(rng.choice([0.05, 0.07, 0.1, 0.14])), float(rng.uniform(0.012, 0.016))
    profile = [(thick, -SINK), (thick, 0.8 * high), (0.5 * thick, high), (-0.002, high)]
    return Thing("skirting").add(moulding(built, profile), material)


def cornice(rng: np.random.Generator, built: Room, material: Material) -> Thing:
    """A coving between walls and a level ceiling."""
    size, h = float(rng.uniform(0.05, 0.12)), built.height
    t = np.linspace(0, np.pi / 2, 5)
    hollow = [(size * (1 - np.cos(a)) + 0.012, h - size * (1 - np.sin(a)) - 0.012) for a in t]
    profile = [
        (-0.002, h - size - 0.012),
        (0.012, h - size - 0.012),
        *hollow,
        (size + 0.012, h + 0.002),
    ]
    return Thing("cornice").add(moulding(built, profile), material)


def wainscot(rng: np.random.Generator, built: Room, style: Style) -> list[tuple[Thing, Pose]]:
    """Tiles, boards or framed panels on the lower part of each wall, with a rail on top."""
    finish = built.finish
    if finish.lining is None or built.slope is not None:
        return []
    height = min(finish.lining_height, built.height - 0.3)
    curved = [o for w in built.walls for o in w.openings if o.shape != "rectangle"]
    spring = [o.z1 - (o.x1 - o.x0) / 2 if o.shape == "arch" else o.z0 for o in curved]
    if any(s < height + 0.05 for s in spring):
        return []
    ring = offset(built.points, -LINING)
    plain = finish.lining.pattern == "plain"
    things: list[tuple[Thing, Pose]] = []
    for k, wall in enumerate(built.walls):
        d = wall.along
        x0, x1 = (float((p - wall.end) @ -d) for p in (ring[(k + 1) % len(ring)], ring[k]))
        thing = Thing("wainscot").add(
            _lining(wall, x0, x1, height), finish.lining, finish.lining_grain
        )
        if plain:
            fields = _fields(wall, x0, x1, height)
            if fields:
                thing.add(joined(fields), finish.lining)
        things.append((thing, wall.frame))
    rail = [
        (0.002, height - 0.03),
        (0.022, height - 0.02),
        (0.03, height + 0.01),
        (-0.002, height + 0.012),
    ]
    return [
        *things,
        (Thing("rail").add(moulding(built, rail), style.trim if plain else finish.lining), pose()),
    ]


def _lining(wall: Wall, x0: float, x1: float, height: float) -> Mesh:
    """Front and jambs of what covers a wall from its foot to a height."""
    holes = [
        (Opening(o.x0, o.x1, o.z0, min(o.z1, height)), j in wall.doors, o.z1 > height)
        for j, o in enumerate(wall.openings)
        if o.z0 < height - 0.02 and o.x0 > x0 and o.x1 < x1
    ]
    front = panel([h for h, _, _ in holes], [(x0, height), (x1, height)], bottom=-SINK, y=-LINING)
    jambs = [
        reveals(h, LINING + 0.001, y=-LINING, open_below=door, open_above=cut)
        for h, door, cut in holes
    ]
    return joined([front, *jambs])


def _fields(wall: Wall, x0: float, x1: float, height: float) -> list[Mesh]:
    """Raised frames on the free pieces of a panelled wall."""
    taken = sorted((o.x0 - 0.12, o.x1 + 0.12) for o in wall.openings if o.z0 < height)
    pieces, x = [], x0 + 0.08
    low, high = 0.2, height - 0.1
    for a, b in [*taken, (x1 - 0.08, x1)]:
        if a - x > 0.3:
            count = max(1, round((a - x) / 0.6))
            each = (a - x) / count
            for k in range(count):
                at = x + each * (k + 0.5)
                pieces += _field(at, each - 0.1, low, high)
        x = max(x, b)
    return pieces


def _field(x: float, width: float, low: float, high: float) -> list[Mesh]:
    """Four battens around a field."""
    y, t, b = -LINING - 0.004, 0.012, 0.025
    middle, tall = (low + high) / 2, high - low
    sides = [box((b, t, tall), (x + s * (width - b) / 2, y, middle), bevel=0.004) for s in (-1, 1)]
    caps = [box((width - 2 * b, t, b), (x, y, z), bevel=0.004) for z in (low + b / 2, high - b / 2)]
    return sides + caps


def spans(plan: Plan, axis: int, at: float) -> list[tuple[float, float]]:
    """Pieces of the line at x (axis 1) or y (axis 0) = ``at`` that lie in the room."""
    xs, ys, free = cells(plan.width, plan.depth, plan.cuts)
    lines, across = (xs, ys) if axis == 0 else (ys, xs)
    number = int(np.clip(np.searchsorted(across, at) - 1, 0, len(across) - 2))
    inside = free[:, number] if axis == 0 else free[number]
    found: list[tuple[float, float]] = []
    for a, b, yes in zip(lines[:-1], lines[1:], inside, strict=True):
        if yes and found and abs(found[-1][1] - a) < 1e-9:
            found[-1] = (found[-1][0], float(b))
        elif yes:
            found.append((float(a), float(b)))
    return found


def beams(
    rng: np.random.Generator, plan: Plan, material: Material, *, coffered: bool
) -> tuple[Thing, float, dict[int, int]]:
    """Beams under a level ceiling, in both directions for coffers.

    Returns
    -------
    thing : Thing
    deep : float
        How far they reach below the ceiling, m.
    counts : dict
        How many lie side by side along x (1) and along y (0).
    """
    counts: dict[int, int] = {}
    deep = float(rng.uniform(0.08, 0.16) if coffered else rng.uniform(0.1, 0.24))
    broad = float(rng.uniform(0.1, 0.2))
    step = float(rng.uniform(0.9, 1.5) if coffered else rng.uniform(0.6, 1.3))
    first = 1 if plan.width >= plan.depth else 0
    pieces = []
    for axis in (first, 1 - first) if coffered else (first,):
        length = plan.width if axis == 1 else plan.depth
        count = counts[axis] = max(2, round(length / step))
        reach = deep - 0.006 * (axis != first)
        for k in range(count):
            at = length * (k + 0.5) / count
            for a, b in spans(plan, axis, at):
                size, centre = (b - a + 0.04, broad), ((a + b) / 2, at)
                if axis == 1:
                    size, centre = size[::-1], centre[::-1]
                middle = plan.height - reach / 2 + 0.005
                pieces.append(box((*size, reach + 0.01), (*centre, middle), bevel=0.008))
    return Thing("beams").add(joined(pieces), material, grain=first), deep, counts


def lowered(rng: np.random.Generator, plan: Plan, material: Material) -> tuple[Thing, Rect] | None:
    """A strip of lowered ceiling along one side, where nothing is cut away."""
    wide, deep = float(rng.uniform(0.7, 1.4)), float(rng.uniform(0.18, 0.3))
    for side in rng.permutation(4).tolist():
        x0, x1, y0, y1 = plan.strip(side, 0.0, plan.length(side), wide)
        clear = all(a >= x1 or b <= x0 or c >= y1 or d <= y0 for a, b, c, d in plan.blocked)
        if clear:
            size = (x1 - x0 + 0.02, y1 - y0 + 0.02, deep + 0.01)
            centre = ((x0 + x1) / 2, (y0 + y1) / 2, plan.height - deep / 2 + 0.005)
            return Thing("lowered ceiling").add(box(size, centre), material), (x0, x1, y0, y1)
    return None


def rafters(
    rng: np.random.Generator, built: Room, material: Material
) -> tuple[Thing, dict[int, int]]:
    """Timbers under the slopes of an attic, and how many lie along x (1) or y (0)."""
    assert built.slope is not None
    axis, profile = built.slope
    low, high = built.points.min(0), built.points.max(0)
    length = float(high[1 - axis] - low[1 - axis])
    count = max(2, round(length / float(rng.uniform(0.8, 1.4))))
    broad, deep = float(rng.uniform(0.08, 0.14)), float(rng.uniform(0.08, 0.16))
    pieces = []
    for (s0, z0), (s1, z1) in pairwise(profile):
        slant, angle = float(np.hypot(s1 - s0, z1 - z0)), float(np.arctan2(z1 - z0, s1 - s0))
        bar = box((slant + 0.04, broad, deep + 0.02), (0, 0, 0), bevel=0.006)
        c, s = np.cos(angle), np.sin(angle)
        tilt = np.array([[c, 0, -s, 0], [0, 1, 0, 0], [s, 0, c, 0], [0, 0, 0, 1.0]])
        tilt[:3, 3] = tilt[:3, :3] @ [0, 0, -deep / 2] + [(s0 + s1) / 2, 0, (z0 + z1) / 2]
        bar = moved(bar, tilt)
        for k in range(count):
            at = length * (k + 0.5) / count
            turned = pose(at, 0, 0, np.pi / 2) if axis == 1 else pose(0, at)
            pieces.append(moved(bar, turned))
    return Thing("beams").add(joined(pieces), material, grain=axis), {axis: count}
