"""Which shape a room has: sizes by use, and what is cut from or added to its rectangle."""

from dataclasses import dataclass, field

import numpy as np

from cmtof.scenes.rooms.plan import Points, Rect, chamfered, outline

SIZES: dict[str, tuple[float, float, float, float]] = {
    "living": (5.0, 10.0, 4.2, 8.0),
    "dining": (4.5, 8.0, 4.0, 6.5),
    "bedroom": (4.0, 6.5, 3.6, 5.5),
    "kitchen": (4.0, 7.5, 3.5, 5.5),
    "office": (4.0, 9.0, 3.5, 6.5),
    "hallway": (4.5, 9.5, 3.5, 4.5),
    "bathroom": (4.0, 5.5, 3.5, 4.5),
    "attic": (5.0, 9.5, 4.5, 7.5),
    "workshop": (5.5, 10.0, 4.5, 8.0),
    "nursery": (4.0, 5.5, 3.5, 5.0),
}
"""Shortest and longest width and depth of each kind of room, m."""


@dataclass
class Plan:
    """A room's outline and what stands in it."""

    width: float
    depth: float
    height: float
    features: list[str] = field(default_factory=list)
    cuts: list[Rect] = field(default_factory=list)
    chamfers: list[tuple[float, float]] = field(default_factory=list)
    chamfer: float = 0.0
    busy: set[int] = field(default_factory=set)
    """Sides that already have a feature: 0 at y = 0, then counter-clockwise."""
    bay: int = -1
    hearth: tuple[int, float, float] | None = None
    """Side, and ends along it, of a chimney breast."""
    obstacles: list[Rect] = field(default_factory=list)

    def length(self, side: int) -> float:
        """Of a side, m."""
        return self.width if side % 2 == 0 else self.depth

    def strip(self, side: int, a: float, b: float, deep: float) -> Rect:
        """Rectangle at a side, from a to b along x or y, ``deep`` m into the room."""
        if side == 0:
            return (a, b, 0.0, deep)
        if side == 1:
            return (self.width - deep, self.width, a, b)
        if side == 2:
            return (a, b, self.depth - deep, self.depth)
        return (0.0, deep, a, b)

    @property
    def points(self) -> Points:
        """Outline, counter-clockwise."""
        ring = outline(self.width, self.depth, self.cuts)
        return chamfered(ring, self.chamfers, self.chamfer) if self.chamfers else ring

    @property
    def blocked(self) -> list[Rect]:
        """All that is not free floor."""
        ring = outline(self.width, self.depth, self.cuts)
        corners: list[Rect] = []
        for x, y in self.chamfers:
            k = int(np.argmin(np.hypot(*(ring - (x, y)).T)))
            steps = [np.sign(ring[j] - ring[k]) for j in (k - 1, (k + 1) % len(ring))]
            dx, dy = (self.chamfer * (steps[0] + steps[1])).tolist()
            corners.append((min(x, x + dx), max(x, x + dx), min(y, y + dy), max(y, y + dy)))
        return [*self.cuts, *corners, *self.obstacles]


def draw_plan(
    rng: np.random.Generator,
    kind: str,
    width: float | None = None,
    depth: float | None = None,
    height: float | None = None,
) -> Plan:
    """Draw sizes that were left open, then one to three features that fit."""
    w0, w1, d0, d1 = SIZES[kind]
    drawn = rng.uniform(size=3)
    width = round(w0 + (w1 - w0) * drawn[0] ** 1.3, 2) if width is None else width
    depth = round(d0 + (d1 - d0) * drawn[1] ** 1.3, 2) if depth is None else depth
    tall = kind in ("living", "workshop", "hallway") and rng.uniform() < 0.35
    low, high = (2.8, 4.0) if tall else (2.3, 3.1)
    if kind == "attic":
        low, high = 2.6, 3.8
    height = round(low + (high - low) * drawn[2], 2) if height is None else height
    plan = Plan(float(width), float(depth), float(height))
    if kind == "attic":
        plan.features.append("slope")
        return plan
    order = [str(f) for f in rng.permutation(list(_FEATURES))]
    wanted = int(rng.choice([0, 1, 2, 3], p=[0.1, 0.35, 0.35, 0.2]))
    for name in order:
        if len(plan.features) < wanted and _FEATURES[name](rng, plan):
            plan.features.append(name)
    return plan


def _free_side(rng: np.random.Generator, plan: Plan, shortest: float) -> int:
    """A side without a feature, at least that long; -1 when there is none."""
    sides = [s for s in range(4) if s not in plan.busy and plan.length(s) >= shortest]
    return int(rng.choice(sides)) if sides else -1


def _corner(rng: np.random.Generator, plan: Plan) -> tuple[int, int]:
    """A corner between two free sides; (-1, -1) when there is none."""
    pairs = [(s, (s + 1) % 4) for s in range(4) if not {s, (s + 1) % 4} & plan.busy]
    return pairs[int(rng.integers(len(pairs)))] if pairs else (-1, -1)


def _at_corner(plan: Plan, first: int, along: float, deep: float) -> Rect:
    """Rectangle in the corner where side ``first`` ends, going counter-clockwise."""
    w, d = plan.width, plan.depth
    return (
        (w - along, w, 0.0, deep),
        (w - along, w, d - deep, d),
        (0.0, along, d - deep, d),
        (0.0, along, 0.0, deep),
    )[first]


def _l_shape(rng: np.random.Generator, plan: Plan) -> bool:
    first, second = _corner(rng, plan)
    if first < 0 or min(plan.width, plan.depth) < 4.0:
        return False
    along = float(rng.uniform(0.25, 0.5)) * plan.width
    deep = float(rng.uniform(0.25, 0.45)) * plan.depth
    plan.cuts.append(_at_corner(plan, first, round(along, 2), round(deep, 2)))
    plan.busy |= {first, second}
    return True


def _pillar(rng: np.random.Generator, plan: Plan) -> bool:
    """A shaft in a corner or a pier in the middle of a wall."""
    size = round(float(rng.uniform(0.28, 0.55)), 2)
    if rng.uniform() < 0.5:
        first, second = _corner(rng, plan)
        if first < 0:
            return False
        plan.cuts.append(_at_corner(plan, first, size, round(float(rng.uniform(0.28, 0.7)), 2)))
        plan.busy |= {first, second}
        return True
    side = _free_side(rng, plan, 4.5)
    if side < 0:
        return False
    middle = float(rng.uniform(0.35, 0.65)) * plan.length(side)
    plan.cuts.append(
        plan.strip(side, round(middle - size / 2, 2), round(middle + size / 2, 2), 0.3)
    )
    plan.busy.add(side)
    return True


def _recess(plan: Plan, side: int, a: float, b: float, deep: float) -> None:
    """Move a side inwards but for the piece from a to b."""
    plan.cuts += [plan.strip(side, 0.0, a, deep), plan.strip(side, b, plan.length(side), deep)]
    plan.busy.add(side)


def _niche(rng: np.random.Generator, plan: Plan) -> bool:
    side = _free_side(rng, plan, 3.5)
    if side < 0:
        return False
    wide, deep = float(rng.uniform(1.1, 2.4)), round(float(rng.uniform(0.3, 0.9)), 2)
    a = round(float(rng.uniform(0.4, plan.length(side) - wide - 0.4)), 2)
    _recess(plan, side, a, round(a + wide, 2), deep)
    return True


def _bay(rng: np.random.Generator, plan: Plan) -> bool:
    side = _free_side(rng, plan, 4.0)
    if side < 0 or plan.bay >= 0:
        return False
    wide, deep = float(rng.uniform(2.2, 3.2)), round(float(rng.uniform(0.6, 1.0)), 2)
    length = plan.length(side)
    a = round(float(rng.uniform(0.3, length - wide - 0.3)), 2)
    b = round(a + wide, 2)
    _recess(plan, side, a, b, deep)
    if rng.uniform() < 0.75:
        x0, x1, y0, y1 = plan.strip(side, a, b, deep)
        plan.chamfers = [
            [(x0, 0.0), (x1, 0.0)],
            [(plan.width, y0), (plan.width, y1)],
            [(x0, plan.depth), (x1, plan.depth)],
            [(0.0, y0), (0.0, y1)],
        ][side]
        plan.chamfer = round(deep * float(rng.uniform(0.7, 0.85)), 3)
    plan.bay = side
    return True


def _chimney_breast(rng: np.random.Generator, plan: Plan) -> bool:
    side = _free_side(rng, plan, 3.8)
    if side < 0 or rng.uniform() < 0.35:
        return False
    wide, deep = float(rng.uniform(1.4, 1.9)), round(float(rng.uniform(0.32, 0.5)), 2)
    middle = plan.length(side) * float(rng.uniform(0.42, 0.58))
    a, b = round(middle - wide / 2, 2), round(middle + wide / 2, 2)
    plan.cuts.append(plan.strip(side, a, b, deep))
    plan.hearth = (side, a, b)
    plan.busy.add(side)
    return True


def _oblique_corner(rng: np.random.Generator, plan: Plan) -> bool:
    first, second = _corner(rng, plan)
    if first < 0 or plan.chamfers:
        return False
    w, d = plan.width, plan.depth
    plan.chamfers = [((w, 0.0), (w, d), (0.0, d), (0.0, 0.0))[first]]
    plan.chamfer = round(float(rng.uniform(0.7, 1.4)), 2)
    plan.busy |= {first, second}
    return True


_FEATURES = {
    "L shape": _l_shape,
    "pillar": _pillar,
    "niche": _niche,
    "bay": _bay,
    "chimney breast": _chimney_breast,
    "oblique corner": _oblique_corner,
}
