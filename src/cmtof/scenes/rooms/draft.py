"""A shell while it is being built, and what the layout is told of it in the end."""

from dataclasses import dataclass, field, replace

import numpy as np

from cmtof.scenes.rooms.beyond import Passage
from cmtof.scenes.rooms.house import Annex, Point, Shell, WallRun
from cmtof.scenes.rooms.layouts import Plan
from cmtof.scenes.rooms.materials import Style
from cmtof.scenes.rooms.plan import Rect, free_rectangles
from cmtof.scenes.rooms.thing import Light, Pose, Thing
from cmtof.scenes.rooms.walls import STANDING, Room, Slope

Placed = list[tuple[Thing, Pose]]
SLIVER = 0.2
"""Narrower pieces of floor are not told, m."""
Sun = tuple[tuple[float, float, float], float]
"""Direction towards it, and irradiance on a white wall that faces it."""


@dataclass
class Draft:
    """A shell while it is being built."""

    rng: np.random.Generator
    style: Style
    plan: Plan
    main: Room
    rect: Rect
    things: Placed = field(default_factory=list)
    annexes: list[Room] = field(default_factory=list)
    passages: list[Passage] = field(default_factory=list)
    planes: list[Slope] = field(default_factory=list)
    runs: list[WallRun] = field(default_factory=list)
    hole: Rect | None = None
    """In the ceiling, for stairs."""
    low: float = 0.0
    """Lowest ceiling, m."""
    strip: Rect | None = None
    """Where it is lowered; everywhere when None."""
    bays: dict[int, int] = field(default_factory=dict)
    """Number of beams across x (1) and y (0)."""

    def chance(self, share: float) -> bool:
        """True in that share of draws."""
        return bool(self.rng.uniform() < share)


def told(
    draft: Draft,
    lights: list[Light],
    sun: Sun | None,
    doorways: list[tuple[Point, Point]],
) -> Shell:
    """What the layout must know."""
    plan, main = draft.plan, draft.main
    low, eaves, cuts = draft.low, [], []
    if main.slope is not None:
        low = STANDING
        eaves, cuts = _eaves(main, plan)
    floor = free_rectangles(plan.width, plan.depth, [*plan.blocked, *cuts])
    floor = [r for r in floor if min(r[1] - r[0], r[3] - r[2]) > SLIVER]
    runs = [run for wall in main.walls for run in wall.runs() if run.height >= STANDING - 1e-6]
    return Shell(
        things=draft.things,
        width=plan.width,
        depth=plan.depth,
        height=low,
        floor=floor,
        walls=[replace(run, height=min(run.height, draft.low)) for run in [*runs, *draft.runs]],
        lights=lights,
        sun=sun,
        ceiling_spots=_spots(draft, floor),
        doorways=doorways,
        annexes=[_facts(a) for a in draft.annexes] + eaves,
        kind=main.kind,
        features=plan.features,
        slope=main.slope,
    )


def _eaves(main: Room, plan: Plan) -> tuple[list[Annex], list[Rect]]:
    """Strips under the slopes where nobody stands, each with its knee wall."""
    assert main.slope is not None
    axis, profile = main.slope
    s, z = zip(*profile, strict=True)
    line = np.linspace(0, s[-1], 400)
    tall = line[np.interp(line, s, z) >= STANDING]
    found, cuts = [], []
    for a, b in ((0.0, float(tall[0])), (float(tall[-1]), s[-1])):
        if b - a < 0.05:
            continue
        rect = (a, b, 0.0, plan.depth) if axis == 0 else (0.0, plan.width, a, b)
        cuts.append(rect)
        low = [w for w in main.walls if w.height < STANDING and abs(w.along[axis]) < 0.1]
        edge = 0.0 if a == 0.0 else s[-1]
        runs = tuple(r for w in low if abs(w.start[axis] - edge) < 1e-6 for r in w.runs())
        found.append(Annex("eaves", rect, min(z), runs))
    return found, cuts


def _spots(draft: Draft, floor: list[Rect]) -> list[tuple[float, float, float]]:
    """Over the middle of the largest free floors, between beams; more in long rooms."""
    plan, found = draft.plan, []
    for x0, x1, y0, y1 in sorted(floor, key=lambda r: -(r[1] - r[0]) * (r[3] - r[2]))[:3]:
        long = max(x1 - x0, y1 - y0)
        count = 2 if long > 6 else 1
        for k in range(count):
            share = [(k + 0.5) / count, 0.5] if x1 - x0 > y1 - y0 else [0.5, (k + 0.5) / count]
            x, y = x0 + share[0] * (x1 - x0), y0 + share[1] * (y1 - y0)
            if 1 in draft.bays:
                x = round(x / plan.width * draft.bays[1]) * plan.width / draft.bays[1]
            if 0 in draft.bays:
                y = round(y / plan.depth * draft.bays[0]) * plan.depth / draft.bays[0]
            z = draft.main.ceiling(x, y)
            if draft.strip is not None:
                a0, a1, b0, b1 = draft.strip
                if a0 - 0.3 < x < a1 + 0.3 and b0 - 0.3 < y < b1 + 0.3:
                    continue
            inside = 0.2 < x < plan.width - 0.2 and 0.2 < y < plan.depth - 0.2
            if inside and all(np.hypot(x - a, y - b) > 1.2 for a, b, _ in found):
                found.append((float(x), float(y), float(z)))
    return found


def _facts(built: Room) -> Annex:
    low, high = built.points.min(0), built.points.max(0)
    floor = (float(low[0]), float(high[0]), float(low[1]), float(high[1]))
    runs = tuple(run for wall in built.walls for run in wall.runs())
    return Annex(built.kind, floor, built.height, runs)
