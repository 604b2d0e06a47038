"""Stairs: treads on strings, with or without risers, straight or around a corner, with a banister.

A flight starts at the front, y = -depth/2, and climbs towards +y; the lowest step stands on z = 0.
"""

from collections.abc import Callable

import numpy as np

from cmtof.scenes.rooms.bars import bar
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.solids import box, cylinder, joined, prism, revolve
from cmtof.scenes.rooms.thing import Mesh, Thing, moved, pose

Maker = Callable[..., Thing]
GOING = 0.26
"""Depth of a tread, m."""


def straight_stairs(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
    rise: float | None = None,
    open_side: int | None = None,
) -> Thing:
    """One flight.

    Parameters
    ----------
    width : float
        m.
    rise : float
        Height that it climbs, m.
    open_side : int
        Where the banister stands: -1 left, 1 right, 0 on both; drawn when None.
    """
    width = float(rng.uniform(0.8, 1.0)) if width is None else width
    rise = float(rng.uniform(2.4, 2.9)) if rise is None else rise
    side = int(rng.choice([-1, 0, 1])) if open_side is None else open_side
    count = max(3, round(rise / 0.185))
    thing = Thing("stairs")
    y0 = -GOING * count / 2
    _flight(rng, thing, style, width, rise, count, y0)
    for s in (-1, 1) if side == 0 else (side,):
        _banister(thing, style, s * (width / 2 - 0.05), rise, count, y0, dense=side != 0)
    return thing


def _flight(
    rng: np.random.Generator,
    thing: Thing,
    style: Style,
    width: float,
    rise: float,
    count: int,
    y0: float,
    z0: float = 0.0,
    design: int | None = None,
) -> None:
    """Treads, risers and strings of one flight from (y0, z0)."""
    step = rise / count
    design = int(rng.integers(3)) if design is None else design
    nose, thick = 0.025, 0.035
    wood, paint = style.wood, style.trim
    treads, risers = [], []
    for k in range(count):
        y, z = y0 + GOING * k, z0 + step * (k + 1)
        deep = GOING + nose
        treads.append(
            box((width - 0.06, deep, thick), (0, y - nose + deep / 2, z - thick / 2), bevel=0.006)
        )
        if design == 0:
            tall = step - thick
            risers.append(
                box((width - 0.062, 0.016, tall), (0, y + 0.008, z - thick - tall / 2 + 0.001))
            )
        elif design == 2:
            tall = min(step * (k + 1), 2.5 * step)
            risers.append(
                box(
                    (width - 0.08, GOING, tall - thick),
                    (0, y + GOING / 2, z - thick - (tall - thick) / 2 + 0.001),
                )
            )
    thing.add(joined(treads), wood)
    if risers:
        concrete = Material((0.4, 0.4, 0.39), (0.33, 0.33, 0.32), "noise", 0.3)
        thing.add(joined(risers), concrete if design == 2 else paint)
    run = GOING * count
    string = _string(run, rise, step, z0)
    strings = [moved(string, pose(s * (width / 2 - 0.017), y0, 0)) for s in (-1, 1)]
    thing.add(joined(strings), wood if design == 1 else paint)


def _string(run: float, rise: float, step: float, z0: float) -> Mesh:
    """The board that carries the treads on one side, 34 mm thick about x = 0, from y = 0."""
    deep = 0.30
    up = 0.05
    outline = [
        (-0.03, z0),
        (0.12 if z0 == 0 else -0.03, z0),
        (run, z0 + rise - deep + 0.02),
        (run, z0 + rise + up),
        (-0.03, z0 + step * 0.75 + up),
    ]
    outline = [p for k, p in enumerate(outline) if p != outline[k - 1]]
    flat = prism(outline, 0.034)
    turn = np.array([[0, 0, 1, -0.017], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
    return moved(flat, turn)


def _banister(
    thing: Thing,
    style: Style,
    x: float,
    rise: float,
    count: int,
    y0: float,
    z0: float = 0.0,
    *,
    dense: bool = True,
) -> None:
    """Newel posts, a handrail, and one or two balusters a tread: turned, square or steel."""
    step, high = rise / count, 0.9
    turned = style.modern < 0.35
    steel = style.modern > 0.7
    material = style.metal if steel else style.trim
    if turned:
        one = _turned(high)
    elif steel:
        one = bar((0, 0, 0), (0, 0, high), 0.007, 8)
    else:
        one = box((0.028, 0.028, high), (0, 0, high / 2))
    posts = []
    for k in range(count):
        for part in (0.25, 0.75) if dense else (0.5,):
            y, z = y0 + GOING * (k + part), z0 + step * (k + 1)
            gain = step * (part - 0.25)
            stretched = one.vertices * np.array([1, 1, (high + gain) / high], np.float32)
            posts.append(moved(one._replace(vertices=stretched), pose(x, y, z - 0.003)))
    thing.add(joined(posts), material)
    run = GOING * count
    a = np.array([x, y0 - 0.06, z0 + step * 0.75 + high])
    b = np.array([x, y0 + run, z0 + rise + 0.75 * step + high])
    newels = [
        _newel(x, y0 - 0.06, z0, high + step + 0.12),
        _newel(x, y0 + run - 0.05, z0 + rise - 0.2, high + 0.35),
    ]
    thing.add(joined([bar(a, b, 0.028, 12)]), style.wood)
    thing.add(joined(newels), style.wood if not steel else style.metal)


def _newel(x: float, y: float, z: float, high: float) -> Mesh:
    """A square post with a cap."""
    post = box((0.08, 0.08, high), (x, y, z + high / 2), bevel=0.006)
    cap = box((0.105, 0.105, 0.03), (x, y, z + high + 0.012), bevel=0.008)
    return joined([post, cap])


def _turned(high: float) -> Mesh:
    """A baluster from the lathe, standing on z = 0."""
    t = np.array([0.0, 0.14, 0.16, 0.2, 0.24, 0.45, 0.65, 0.72, 0.76, 0.8, 1.0])
    r = np.array([0.018, 0.018, 0.01, 0.02, 0.011, 0.019, 0.011, 0.02, 0.011, 0.016, 0.016])
    return revolve(np.stack([r, t * high], -1), 6)


def quarter_turn_stairs(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
    rise: float | None = None,
    turn: int | None = None,
) -> Thing:
    """Two flights at right angles with a landing between them.

    Parameters
    ----------
    turn : int
        1 to the left on the landing, -1 to the right; drawn when None.
    """
    width = float(rng.uniform(0.8, 1.0)) if width is None else width
    rise = float(rng.uniform(2.4, 2.9)) if rise is None else rise
    turn = int(rng.choice([-1, 1])) if turn is None else turn
    count = max(6, round(rise / 0.185))
    first = int(rng.integers(3, count - 3))
    step, design = rise / count, int(rng.integers(2))
    low = step * first
    flat = Thing("stairs")
    _flight(rng, flat, style, width, low, first, 0.0, design=design)
    _banister(flat, style, turn * (width / 2 - 0.05), low, first, 0.0)
    corner = GOING * first
    landing = box((width, width, 0.05), (0, corner + width / 2, low + 0.024), bevel=0.006)
    flat.add(landing, style.wood)
    apron = box((width - 0.04, width - 0.04, 0.16), (0, corner + width / 2, low - 0.08))
    posts = [
        box((0.08, 0.08, low), (s * (width / 2 - 0.06), corner + width - 0.06, low / 2))
        for s in (-1, 1)
    ]
    flat.add(joined([apron, *posts]), style.trim)
    upper = Thing("stairs")
    rest = count - first
    _flight(rng, upper, style, width, rise - low - 0.049, rest, 0.0, 0.0, design=design)
    _banister(upper, style, turn * (width / 2 - 0.05), rise - low - 0.049, rest, 0.0)
    at = pose(-turn * width / 2, corner + width / 2, low + 0.049, turn * np.pi / 2)
    for part in upper.parts:
        flat.add(moved(part.mesh, at), part.material, part.grain)
    return _centred(flat)


def _centred(thing: Thing) -> Thing:
    low, high = thing.bounds
    shift = pose(-float(low[0] + high[0]) / 2, -float(low[1] + high[1]) / 2, 0.0)
    thing.parts = [part._replace(mesh=moved(part.mesh, shift)) for part in thing.parts]
    return thing


def column(rng: np.random.Generator, height: float) -> Mesh:
    """A pillar from floor to ceiling: round with base and capital, or square."""
    r = float(rng.uniform(0.11, 0.2))
    if rng.uniform() < 0.5:
        shaft = cylinder(r, height + 0.02, (0, 0, height / 2), top=0.92 * r, sides=32)
        rings = [
            cylinder(1.25 * r, 0.06, (0, 0, 0.13), sides=32),
            cylinder(1.2 * r, 0.05, (0, 0, height - 0.12), sides=32),
        ]
        plates = [
            box((2.7 * r, 2.7 * r, 0.1), (0, 0, z), bevel=0.006) for z in (0.05, height - 0.045)
        ]
        return joined([shaft, *rings, *plates])
    return box((2 * r, 2 * r, height + 0.02), (0, 0, height / 2), bevel=0.012)


CATALOGUE: dict[str, Maker] = {
    "straight_stairs": straight_stairs,
    "quarter_turn_stairs": quarter_turn_stairs,
}
