"""Where the house's fittings go: heat under windows, switches by doors, cloth before panes."""

from collections.abc import Callable

import numpy as np

from cmtof.scenes.rooms import drapes, fittings
from cmtof.scenes.rooms.daylight import Glazing
from cmtof.scenes.rooms.layouts import Plan
from cmtof.scenes.rooms.materials import Style
from cmtof.scenes.rooms.thing import Pose, Thing
from cmtof.scenes.rooms.walls import Room, Wall

Placed = list[tuple[Thing, Pose]]
FACE = -0.011
"""Fittings stand in front of what may line the wall, m."""


def heating(rng: np.random.Generator, style: Style, windows: list[Glazing]) -> Placed:
    """Radiators of one design under the windows of a room, or low convectors, or none."""
    mode = int(rng.choice(3, p=[0.65, 0.12, 0.23]))
    design = str(rng.choice(["ribs", "panel", "panel"]))
    placed: Placed = []
    for glazing in windows[:6]:
        wall, hole = glazing.wall, glazing.hole
        if wall is None or hole.z0 < 0.3 or mode == 2 or rng.uniform() < 0.25:
            continue
        width = min(hole.x1 - hole.x0, 1.6) * float(rng.uniform(0.7, 1.0))
        x = hole.centre[0]
        if mode == 1 or hole.z0 < 0.6:
            made, middle = fittings.skirting_heater(rng, style, length=width), 0.1
        else:
            height = min(0.6, hole.z0 - 0.28)
            made = fittings.radiator(rng, style, width=width, height=height, design=design)
            middle = 0.13 + height / 2
        wall.block(x - width / 2 - 0.1, x + width / 2 + 0.1, 0.0)
        placed.append((made, wall.at(x, FACE, middle)))
    return placed


def hearth(rng: np.random.Generator, style: Style, main: Room, plan: Plan) -> Placed:
    """A fireplace on the front of the chimney breast; it takes the floor before it."""
    if plan.hearth is None:
        return []
    side, a, b = plan.hearth
    axis = side % 2
    for wall in main.walls:
        ends = sorted((float(wall.start[axis]), float(wall.end[axis])))
        if np.allclose(ends, (a, b), atol=1e-6) and abs(wall.along[axis]) > 0.9:
            made = fittings.fireplace(rng, style, width=min(1.4, b - a - 0.15))
            deep = float(-made.bounds[0, 1])
            wall.block(0.0, wall.length, 0.0)
            middle = wall.at(wall.length / 2, 0.003, 0.0)
            centre = middle[:2, 3] + wall.inward * deep / 2
            half = np.abs(wall.along) * (wall.length / 2) + np.abs(wall.inward) * deep / 2
            low, high = centre - half, centre + half
            plan.obstacles.append((float(low[0]), float(high[0]), float(low[1]), float(high[1])))
            return [(made, middle)]
    return []


def small_fittings(rng: np.random.Generator, style: Style, built: Room) -> Placed:
    """Switches beside doors, sockets along walls, vents, a thermostat, a smoke detector."""
    placed: Placed = []
    for wall in built.walls:
        for j in sorted(wall.framed):
            hole = wall.openings[j]
            x = hole.x1 + 0.22 if rng.uniform() < 0.5 else hole.x0 - 0.22
            if _clear(wall, x, 0.06, 1.1):
                placed.append((fittings.light_switch(rng, style), wall.at(x, FACE, 1.1)))
        if wall.length > 1.0 and rng.uniform() < 0.7:
            x = float(rng.uniform(0.25, wall.length - 0.25))
            if _clear(wall, x, 0.2, 0.3) and not _blocked(wall, x):
                placed.append((fittings.socket(rng, style), wall.at(x, FACE, 0.3)))
        if wall.length > 1.5 and rng.uniform() < 0.15:
            x, z = float(rng.uniform(0.4, wall.length - 0.4)), wall.height - 0.4
            if z > 1.9 and _clear(wall, x, 0.25, z):
                placed.append((fittings.vent(rng, style), wall.at(x, -0.001, z)))
        if wall.length > 1.5 and rng.uniform() < 0.08:
            x = float(rng.uniform(0.3, wall.length - 0.3))
            if _clear(wall, x, 0.1, 1.45) and not _blocked(wall, x):
                placed.append((fittings.thermostat(rng, style), wall.at(x, FACE, 1.45)))
    return placed


def utilities(rng: np.random.Generator, style: Style, built: Room) -> Placed:
    """Rising pipes in a corner, a boiler, a cable duct, as the room's use asks."""
    placed: Placed = []
    odds = {"workshop": 0.6, "bathroom": 0.5, "kitchen": 0.4, "attic": 0.3}.get(built.kind, 0.15)
    if built.slope is None and rng.uniform() < odds:
        wall = built.walls[int(rng.integers(len(built.walls)))]
        x = 0.22 if rng.uniform() < 0.5 else wall.length - 0.22
        if wall.length > 0.8 and _clear(wall, x, 0.2, 1.0) and not _blocked(wall, x):
            made = fittings.pipes(rng, style, height=built.height + 0.01)
            placed.append((made, wall.at(x, FACE, built.height / 2)))
            wall.block(x - 0.2, x + 0.2, 0.0)
    if built.kind in ("kitchen", "bathroom", "workshop") and rng.uniform() < 0.3:
        for wall in built.walls:
            free = [(a, b) for a, b in wall.gaps(0.1) if b - a > 0.8]
            if free and wall.height > 2.3:
                x = free[0][0] + 0.35
                placed.append((fittings.boiler(rng, style), wall.at(x, FACE, 1.6)))
                wall.block(x - 0.3, x + 0.3, 0.75)
                break
    if built.kind in ("office", "workshop") and rng.uniform() < 0.5:
        wall = max(built.walls, key=lambda w: w.length)
        free = max(wall.gaps(0.1), key=lambda g: g[1] - g[0], default=(0.0, 0.0))
        if free[1] - free[0] > 1.0:
            made = fittings.cable_duct(rng, style, length=free[1] - free[0] - 0.1)
            placed.append((made, wall.at((free[0] + free[1]) / 2, FACE, 0.95)))
    return placed


def _clear(wall: Wall, x: float, half: float, z: float) -> bool:
    """Whether no opening, nor the wall's end, comes near."""
    if x < half + 0.02 or x > wall.length - half - 0.02:
        return False
    return not any(
        o.x0 - half < x < o.x1 + half and o.z0 - 0.15 < z < o.z1 + 0.15 for o in wall.openings
    )


def _blocked(wall: Wall, x: float) -> bool:
    return any(a - 0.15 < x < b + 0.15 and s < 0.3 for a, b, s in wall.blocked)


def cover_windows(
    rng: np.random.Generator, style: Style, windows: list[Glazing], sunny: Glazing | None
) -> Placed:
    """The same kind of curtain or blind before each window; the sunny one stays open."""
    mode = str(
        rng.choice(
            ["none", "curtains", "roller", "venetian", "roman"], p=[0.2, 0.42, 0.12, 0.16, 0.1]
        )
    )
    seed = int(rng.integers(2**32))
    placed: Placed = []
    for k, glazing in enumerate(windows):
        wall, hole = glazing.wall, glazing.hole
        if wall is None or mode == "none":
            continue
        own = np.random.default_rng(seed)  # alike but for how far they are drawn
        wide, tall, x = hole.x1 - hole.x0, hole.z1 - hole.z0, hole.centre[0]
        top = min(hole.z1 + 0.1, wall.headroom(hole.x0, hole.x1) - 0.05)
        is_open = glazing is sunny
        if mode == "curtains" and k < 3:
            placed += _curtain(rng, own, style, wall, glazing, top, is_open)
            continue
        if hole.shape != "rectangle" or k > 7:
            continue
        share = float(rng.uniform(0.15, 0.3) if is_open else rng.choice([0.2, 0.5, 0.75, 1.0]))
        drop = max(0.25, share * (tall + 0.08))
        makers: dict[str, Callable[..., Thing]] = {
            "roller": drapes.roller_blind,
            "venetian": drapes.venetian_blind,
            "roman": drapes.roman_shade,
        }
        made = makers.get(mode, drapes.roller_blind)(own, style, width=wide + 0.06, drop=drop)
        placed.append((made, wall.at(x, FACE, top)))
    return placed


def _curtain(
    rng: np.random.Generator,
    own: np.random.Generator,
    style: Style,
    wall: Wall,
    glazing: Glazing,
    top: float,
    is_open: bool,
) -> Placed:
    """One pair of curtains as wide as its neighbours allow, to the floor or to the sill."""
    hole, x = glazing.hole, glazing.hole.centre[0]
    wide = hole.x1 - hole.x0
    others = [o for o in wall.openings if o is not hole]
    room = min([x, wall.length - x, *(min(abs(o.x0 - x), abs(o.x1 - x)) for o in others)])
    width = 2 * min(wide / 2 + 0.3, room - 0.09)
    if width < wide + 0.05:
        return []
    heated = any(a < x < b and s == 0.0 for a, b, s in wall.blocked)
    long = (hole.z0 < 0.5 or not heated) and own.uniform() < 0.8
    drop = top - 0.03 if long else top - hole.z0 + 0.12
    drawn = float(rng.uniform(0.1, 0.16) if is_open else rng.uniform(0.12, 0.42))
    made = drapes.curtains(own, style, width=width, drop=drop, drawn=drawn)
    if long:
        wall.block(x - width / 2, x + width / 2, 0.0)
    return [(made, wall.at(x, FACE, top))]
