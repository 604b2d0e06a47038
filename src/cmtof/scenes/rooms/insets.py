"""What stands on a room's floor and belongs to the house: columns, half walls, steps, stairs."""

import numpy as np

from cmtof.scenes.rooms.house import WallRun
from cmtof.scenes.rooms.layouts import Plan
from cmtof.scenes.rooms.materials import Style
from cmtof.scenes.rooms.plan import Rect
from cmtof.scenes.rooms.solids import box, quads
from cmtof.scenes.rooms.stairs import GOING, column, straight_stairs
from cmtof.scenes.rooms.thing import Pose, Support, Thing, pose
from cmtof.scenes.rooms.walls import SINK, Room

Placed = list[tuple[Thing, Pose]]


def claim(main: Room, plan: Plan, rect: Rect) -> None:
    """Take a rectangle of floor, and the walls beside it, away from furniture."""
    plan.obstacles.append(rect)
    low, high = np.array(rect)[[0, 2]] - 0.05, np.array(rect)[[1, 3]] + 0.05
    for wall in main.walls:
        near = np.linspace(0, wall.length, 1 + int(wall.length / 0.02))
        points = wall.end - near[:, None] * wall.along
        inside = near[((points > low) & (points < high)).all(1)]
        if len(inside):
            wall.block(float(inside[0]), float(inside[-1]), 0.0)


def is_free(plan: Plan, rect: Rect, gap: float) -> bool:
    """Whether a rectangle keeps that far from all that is not floor."""
    x0, x1, y0, y1 = rect
    return all(
        a >= x1 + gap or b <= x0 - gap or c >= y1 + gap or d <= y0 - gap
        for a, b, c, d in plan.blocked
    )


def columns(rng: np.random.Generator, main: Room, plan: Plan) -> Placed:
    """One to three pillars in a row."""
    mesh = column(rng, plan.height)
    half = float(mesh.vertices[:, 0].max())
    count = int(rng.integers(1, 4))
    along = int(plan.width < plan.depth)
    across = float(rng.uniform(0.3, 0.7))
    placed: Placed = []
    for k in range(count):
        share = [(k + 1) / (count + 1), across]
        x, y = share[along] * plan.width, share[1 - along] * plan.depth
        rect = (x - half, x + half, y - half, y + half)
        if is_free(plan, rect, 0.6):
            claim(main, plan, rect)
            placed.append((Thing("column").add(mesh, main.finish.wall), pose(x, y)))
    return placed


def half_wall(
    rng: np.random.Generator, style: Style, main: Room, plan: Plan
) -> tuple[Placed, list[WallRun]]:
    """A wall as high as a counter that stands out from one side, and both of its faces."""
    side = int(rng.integers(4))
    long = float(rng.uniform(0.9, min(2.2, 0.5 * plan.length((side + 1) % 4))))
    high, thick = float(rng.uniform(0.95, 1.3)), float(rng.uniform(0.1, 0.18))
    at = float(rng.uniform(0.3, 0.7)) * plan.length(side)
    rect = plan.strip(side, at, at + thick, long)
    x0, x1, y0, y1 = rect
    if not is_free(plan, rect, 0.02) or not all(
        is_free(plan, r, 0.0) for r in ((x0 - 0.7, x1 + 0.7, y0, y1), (x0, x1, y0 - 0.7, y1 + 0.7))
    ):
        return [], []
    claim(main, plan, rect)
    size, centre = (x1 - x0, y1 - y0), ((x0 + x1) / 2, (y0 + y1) / 2)
    body = box((*size, high + 0.02), (0, 0, high / 2 - 0.01))
    thing = Thing("half wall").add(body, main.finish.wall, main.finish.wall_grain)
    cap = box((size[0] + 0.04, size[1] + 0.04, 0.035), (0, 0, high + 0.012), bevel=0.006)
    thing.add(cap, style.wood)
    a, b = size[0] / 2 - 0.01, size[1] / 2 - 0.01
    thing.supports.append(Support(-a, a, -b, b, high + 0.0295, 0.6))
    if side % 2 == 0:
        faces = [((x0, y0), (x0, y1)), ((x1, y1), (x1, y0))]
    else:
        faces = [((x0, y1), (x1, y1)), ((x1, y0), (x0, y0))]
    return [(thing, pose(*centre))], [WallRun(s, e, high) for s, e in faces]


def podium(rng: np.random.Generator, style: Style, main: Room, plan: Plan) -> Placed:
    """A part of the floor one or two steps higher, along one side."""
    wide, high = float(rng.uniform(0.9, 1.6)), float(rng.uniform(0.14, 0.32))
    for side in rng.permutation(4).tolist():
        rect = plan.strip(side, 0.0, plan.length(side), wide)
        doors = any(w.doors and _touches(w.start, w.end, rect) for w in main.walls)
        if doors or not is_free(plan, rect, 0.0) or wide > 0.4 * plan.length((side + 1) % 4):
            continue
        claim(main, plan, rect)
        x0, x1, y0, y1 = rect
        size, centre = (x1 - x0, y1 - y0), ((x0 + x1) / 2, (y0 + y1) / 2)
        body = box((size[0] + 0.02, size[1] + 0.02, high + 0.02), (0, 0, high / 2 - 0.01), 0.004)
        thing = Thing("step").add(body, main.finish.floor, main.finish.floor_grain)
        a, b = size[0] / 2 - 0.05, size[1] / 2 - 0.05
        thing.supports.append(Support(-a, a, -b, b, high, 1.5))
        return [(thing, pose(*centre))]
    return []


def _touches(start: np.ndarray, end: np.ndarray, rect: Rect) -> bool:
    low, high = np.minimum(start, end) - 0.01, np.maximum(start, end) + 0.01
    return bool(low[0] < rect[1] and high[0] > rect[0] and low[1] < rect[3] and high[1] > rect[2])


def stairwell(
    rng: np.random.Generator, style: Style, main: Room, plan: Plan
) -> tuple[Placed, Rect | None]:
    """Stairs along one side up through the ceiling, and the hole that the ceiling needs."""
    rise = plan.height + 0.3
    width, count = float(rng.uniform(0.8, 0.95)), max(3, round(rise / 0.185))
    run = GOING * count + 0.3
    for side in rng.permutation(4).tolist():
        if plan.length(side) < run + 1.0 or plan.length((side + 1) % 4) < 3.4:
            continue
        a = round(float(rng.choice([0.0, plan.length(side) - run])), 3)
        rect = plan.strip(side, a, a + run, width)
        if not is_free(plan, rect, 0.05) or any(
            w.doors and _touches(w.start, w.end, rect) for w in main.walls
        ):
            continue
        claim(main, plan, rect)
        upwards = 1 if a > 0 else -1
        climb = np.array([upwards, 0.0] if side % 2 == 0 else [0.0, upwards])
        inward = np.array([(0, 1), (-1, 0), (0, -1), (1, 0)][side])
        turn = float(np.arctan2(-climb[0], climb[1]))
        right = np.array([climb[1], -climb[0]])
        flight = straight_stairs(
            rng, style, width=width, rise=rise, open_side=int(np.sign(right @ inward))
        )
        centre = ((rect[0] + rect[1]) / 2, (rect[2] + rect[3]) / 2)
        return [(flight, pose(*centre, 0.0, turn)), (_shaft(main, rect, side), pose())], rect
    return [], None


def _shaft(main: Room, rect: Rect, side: int) -> Thing:
    """Walls around the stairs above the ceiling, closed on top."""
    x0, x1, y0, y1 = rect
    ring = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    low, high = main.height, main.height + 2.3
    size = (main.points.min(0), main.points.max(0))
    faces = []
    for k, ((ax, ay), (bx, by)) in enumerate(zip(ring, ring[1:] + ring[:1], strict=True)):
        along_wall = (
            abs((ay, ax, ay, ax)[k] - (size[0][1], size[1][0], size[1][1], size[0][0])[k]) < 1e-6
        )
        foot = low + SINK * along_wall  # the room's own wall reaches that far
        faces.append([(bx, by, foot), (ax, ay, foot), (ax, ay, high), (bx, by, high)])
    faces.append([(x0, y0, high), (x0, y1, high), (x1, y1, high), (x1, y0, high)])
    return Thing("stairwell").add(quads(faces), main.finish.wall, main.finish.wall_grain)
