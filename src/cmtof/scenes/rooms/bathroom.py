"""Bathrooms: tub, shower, basin and toilet, m."""

import numpy as np

from cmtof.scenes.rooms.bathroom_walls import bathroom_cabinet, towel_rail
from cmtof.scenes.rooms.cabinetry import (
    BLACK,
    CHROME,
    STEEL,
    WHITE,
    Maker,
    Span,
    add_fronts,
    carcass,
    footing,
    look,
    tap,
)  # fmt: skip
from cmtof.scenes.rooms.joinery import (
    bent,
    boards,
    centred,
    copies,
    corners,
    placed,
    rods,
    rounded,
    shifted,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.solids import cylinder, joined, quads, revolve, tube
from cmtof.scenes.rooms.thing import Mesh, Support, Thing
from cmtof.scenes.rooms.upholstery import loft, shell


def _egg(rx: float, front: float, back: float, count: int = 32, square: float = 0.75) -> np.ndarray:
    """Outline (count, 2) of a bowl: a half ellipse to -y, a squarer one to +y."""
    t = np.arange(count) * (2 * np.pi / count)
    c, s = np.cos(t), np.sin(t)
    power = np.where(s > 0, square, 1.0)
    x = rx * np.sign(c) * np.abs(c) ** power
    y = np.where(s > 0, back * np.abs(s) ** power, -front * np.abs(s))
    return np.stack([x, y], -1)


def _rings(outline: np.ndarray, rows: list[tuple[float, float, float, float]]) -> Mesh:
    """A smooth body through an outline scaled in x and y, shifted in y, at a height."""
    grid = np.empty((len(rows), len(outline), 3))
    for k, (sx, sy, dy, z) in enumerate(rows):
        grid[k, :, 0], grid[k, :, 1], grid[k, :, 2] = sx * outline[:, 0], sy * outline[:, 1] + dy, z
    return shell(grid)


def bathtub(rng: np.random.Generator, style: Style) -> Thing:
    """Built in behind a panel, or free-standing on a plinth or on feet."""
    w, d = float(rng.uniform(1.5, 1.8)), float(rng.uniform(0.7, 0.82))
    h, built = float(rng.uniform(0.54, 0.62)), rng.uniform() < 0.5
    thing = Thing("bathtub")
    radius = 0.05 if built else 0.34
    bottom = 0.14 if not built else 0.12
    inside = [(0.055, h + 0.002), (0.075, h - 0.012), (0.095, h - 0.1), (0.13, 0.24), (0.19,
        bottom + 0.02),
              (0.25, bottom), (d / 2, bottom - 0.003)]  # fmt: skip
    if built:
        rows = [
            (0.012, h - 0.045),
            (0.0, h - 0.04),
            (0.0, h - 0.008),
            (0.008, h),
            (0.03, h + 0.001),
        ]
        tub = _tub(w, d, radius, rows, inside)
        thing.add(tub, WHITE)
        skirt = [(-w / 2 + 0.015, w / 2 - 0.015, -d / 2 + 0.018, d / 2 - 0.005, 0.06, h - 0.035),
                 (-w / 2 + 0.03, w / 2 - 0.03, -d / 2 + 0.05, d / 2 - 0.01, 0.0,
                     0.062)]  # fmt: skip
        cover = WHITE if rng.uniform() < 0.5 else Material((0.6, 0.6, 0.58), (0.4, 0.4, 0.4),
            "tiles",
                                                         0.15, 0.1, 120.0)  # fmt: skip
        thing.add(joined(_skirt(skirt)), cover)
    else:
        foot = 0.11 if rng.uniform() < 0.5 else 0.0
        rows = [(0.2, foot), (0.14, foot), (0.09, foot + 0.06), (0.05, 0.3), (0.03, h - 0.06),
                (0.004, h - 0.022), (0.0, h - 0.008), (0.012, h + 0.002), (0.035,
                    h + 0.004)]  # fmt: skip
        paint = WHITE if rng.uniform() < 0.6 else style.paint
        outer = loft(w, d, radius, [(d / 2, foot), *rows[1:]], corner=9)
        thing.add(outer, paint).add(loft(w, d, radius, rows[-1:] + inside, corner=9), WHITE)
        if foot:
            claw = revolve([(0, 0), (0.035, 0), (0.045, 0.02), (0.03, 0.05), (0.02, 0.08), (0.045,
                0.15),
                            (0, 0.16)], 12)  # fmt: skip
            thing.add(copies(claw, corners(0.32 * w, 0.24 * d)), CHROME)
    _tub_tap(thing, rng, w, d, h)
    return thing


def _tub(w: float, d: float, radius: float, rim: list, inside: list) -> Mesh:
    """A rim with square corners that turns into a rounded hollow."""
    outer = loft(w, d, radius, rim, corner=9)
    inner = loft(w, d, 0.2, inside, corner=9)
    edge = outer.vertices.reshape(len(rim), -1, 3)[-1][::-1]
    start = inner.vertices.reshape(len(inside), -1, 3)[0][::-1]
    flat = shell(np.stack([edge, start]))
    return joined([outer, flat, inner])


def _skirt(limits: list[tuple[float, ...]]) -> list[Mesh]:
    """Walls of boxes without top and bottom, which would show inside a tub."""
    found = []
    for x0, x1, y0, y1, z0, z1 in limits:
        p = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
        low, high = np.column_stack([p, np.full(4, z0)]), np.column_stack([p, np.full(4, z1)])
        nxt = np.roll(np.arange(4), -1)
        found.append(quads(np.stack([low, low[nxt], high[nxt], high], 1)))
    return found


def _tub_tap(thing: Thing, rng: np.random.Generator, w: float, d: float, h: float) -> None:
    """Mixer on the rim, overflow, and a hand shower on its hose."""
    x = float(rng.choice([-1, 1])) * (w / 2 - 0.028) if rng.uniform() < 0.5 else 0.0
    spout = placed(tap(rng, 0.14, 0.16), turn=0.0 if x == 0 else -np.sign(x) * np.pi / 2)
    at = (x, d / 2 - 0.028 if x == 0 else 0.0, h + 0.001)
    hose = rounded([(0.05, 0, 0.03), (0.12, -0.02, 0.1), (0.1, -0.02, 0.02), (0.08, 0, 0.14)], 3)
    head = rods([(0.08, 0, 0.1)], [(0.06, -0.06, 0.2)], 0.013, taper=0.7)
    turn = 0.0 if x == 0 else -np.sign(x) * np.pi / 2
    extra = placed(joined([tube(hose, 0.005, 6), head]), at, turn=turn)
    thing.add(joined([placed(spout, at), extra]), CHROME)


def shower_cabin(rng: np.random.Generator, style: Style) -> Thing:
    """Tray, frame whose panes are left out, mixer bar, riser, shower head and hose."""
    w = float(rng.uniform(0.8, 1.2))
    d, h = float(rng.uniform(0.8, 0.95)), float(rng.uniform(1.9, 2.05))
    thing, rim = Thing("shower cabin"), float(rng.choice([0.05, 0.09, 0.15]))
    rows = [(d / 2, 0.0), (0, 0), (0, 0), (0, rim - 0.006), (0.006, rim), (0.045, rim), (0.05,
        rim - 0.004),
            (0.065, rim - 0.03), (0.1, rim - 0.034), (min(w, d) / 2, rim - 0.036)]  # fmt: skip
    rows[0] = (min(w, d) / 2, 0.0)
    thing.add(loft(w, d, 0.03, rows, corner=3), WHITE)
    drain = cylinder(0.045, 0.004, (0, 0, rim - 0.034), sides=24)
    x, y = w / 2 - 0.025, d / 2 - 0.025
    profile, bars = 0.03, []
    t = profile / 2
    for px, py in ((-x, -y), (x, -y), (x, y), (-x, y)):
        bars.append((px - t, px + t, py - t, py + t, rim - 0.001, h))
    for z in (rim + t, h - t):
        bars += [
            (-x + t, x - t, s * y - t + 0.001, s * y + t - 0.001, z - t, z + t - 0.001)
            for s in (-1, 1)
        ]
        bars += [
            (s * x - t + 0.001, s * x + t - 0.001, -y + t, y - t, z - t, z + t - 0.001)
            for s in (-1, 1)
        ]
    slide = float(rng.uniform(-0.3, 0.3)) * w
    bars.append((slide - 0.012, slide + 0.012, -y - 0.008, -y + 0.008, rim + t, h - t))
    metal = (CHROME, WHITE, BLACK)[int(rng.integers(3))]
    pull = rods([(slide + 0.06, -y - 0.03, 0.9)], [(slide + 0.06, -y - 0.03, 1.25)], 0.009)
    thing.add(joined([boards(bars), pull]), metal)
    if rng.uniform() < 0.5:
        wall = [(-x + t, x - t, y - 0.004, y + 0.004, rim + 2 * t, h - 2 * t)]
        thing.add(boards(wall, 0), WHITE)
    _shower(thing, rng, y - 0.03, h)
    return thing.add(drain, STEEL)


def _shower(thing: Thing, rng: np.random.Generator, y: float, h: float) -> None:
    """Riser with a head on an arm, a mixer and a hose; against the plane y."""
    top = h - 0.03
    line = [(0, y, 1.05), (0, y, top), (0, y - 0.3, top), (0, y - 0.3, top - 0.06)]
    head = revolve([(0, 0), (0.09, 0), (0.1, 0.008), (0.06, 0.016), (0.015, 0.03), (0, 0.03)], 28)
    mixer = rods([(-0.14, y - 0.02, 1.05)], [(0.14, y - 0.02, 1.05)], 0.02, sides=12)
    hose = rounded([(0.05, y - 0.02, 1.04), (0.06, y - 0.05, 0.45), (0.14, y - 0.06, 0.5), (0.1,
        y - 0.04, 1.3),
                    (0.02, y - 0.05, 1.42)], 3)  # fmt: skip
    hand = rods([(0.02, y - 0.05, 1.38)], [(0.0, y - 0.11, 1.55)], 0.014, taper=0.7)
    parts = [tube(bent(line, 0.05), 0.01, 8), placed(head, (0, y - 0.3, top - 0.085)), mixer,
             tube(hose, 0.006, 6), hand]  # fmt: skip
    thing.add(joined(parts), CHROME if rng.uniform() < 0.7 else BLACK)


def washbasin(rng: np.random.Generator, style: Style) -> Thing:
    """A basin on a pedestal, let into a cabinet, or a bowl standing on a slab."""
    kind, w = int(rng.integers(3)), float(rng.uniform(0.5, 0.9))
    d, h = float(rng.uniform(0.42, 0.5)), float(rng.uniform(0.82, 0.9))
    thing = Thing("washbasin")
    if kind == 0:
        w = min(w, 0.65)
        _basin(thing, w, d, h, 0.16)
        column = [
            (0, 0),
            (0.105, 0),
            (0.11, 0.02),
            (0.075, 0.12),
            (0.07, 0.45),
            (0.10, h - 0.14),
            (0, h - 0.13),
        ]
        foot = revolve(np.concatenate([column[:2], rounded(column[1:-1]), column[-1:]]), 24)
        thing.add(shifted(foot, 0, 0.08, 0), WHITE)
    else:
        _vanity(thing, rng, style, (w, d, h), bowl=kind == 2)
    level = h + (0.0 if kind < 2 else -0.02)
    spout = tap(rng, 0.13, 0.13 if kind < 2 else 0.3)
    thing.add(placed(spout, (0, d / 2 - 0.05, level - 0.001)), CHROME)
    return thing


def _basin(thing: Thing, w: float, d: float, h: float, deep: float) -> None:
    """A basin with a deck for the tap; its hollow is set forwards."""
    short = min(w, d) / 2
    outer = [(short, h - deep - 0.01), (0.14, h - deep), (0.07, h - 0.08), (0.012, h - 0.045),
             (0.0, h - 0.035), (0.0, h - 0.006), (0.006, h), (0.02, h + 0.0005)]  # fmt: skip
    inner = [(0.0, h + 0.001), (0.01, h - 0.008), (0.03, h - 0.05), (0.08, h - 0.11), (0.13,
        h - deep + 0.02),
             ((d - 0.14) / 2, h - deep + 0.016)]  # fmt: skip
    body = loft(w, d, 0.08, outer, corner=8)
    hollow = loft(w - 0.06, d - 0.14, 0.15, inner, (0, -0.045, 0), corner=8)
    edge = body.vertices.reshape(len(outer), -1, 3)[-1][::-1]
    start = hollow.vertices.reshape(len(inner), -1, 3)[0][::-1]
    thing.add(joined([body, hollow, shell(np.stack([edge, start]))]), WHITE)
    drain = revolve([(0, 0), (0.022, 0), (0.024, 0.002), (0, 0.0035)], 16)
    thing.add(placed(drain, (0, -0.045, h - deep + 0.0165)), CHROME)


def _vanity(
    thing: Thing,
    rng: np.random.Generator,
    style: Style,
    size: tuple[float, float, float],
    *,
    bowl: bool,
) -> None:
    """A cabinet under a basin: doors or drawers; or a slab with a bowl on it."""
    w, d, h = size
    made = look(rng, style, style.paint if rng.uniform() < 0.5 else style.wood)
    top = h - 0.02 if bowl else h - 0.047
    x, y = (-w / 2 + 0.01, w / 2 - 0.01), (-d / 2 + 0.03, d / 2)
    foot = float(rng.uniform(0.08, 0.25))
    thing.add(carcass(x, y, (foot, top), 0.016, lid=bowl), made.material, 2)
    thing.add(
        footing(rng, x, y, foot, style.modern < 0.5), made.material if foot > 0.14 else BLACK, 2
    )
    z = (foot + 0.002, top - (0.018 if bowl else 0.002))
    if rng.uniform() < 0.5:
        middle = (z[0] + z[1]) / 2
        fronts: list[tuple[str, Span, Span]] = [
            ("drawer", x, (z[0], middle)),
            ("drawer", x, (middle, z[1])),
        ]
    else:
        cut = (x[0] + x[1]) / 2
        fronts = [("left", (x[0], cut), z), ("right", (cut, x[1]), z)]
    add_fronts(thing, fronts, y[0], made)
    if not bowl:
        _basin(thing, w, d, h, 0.12)
        return
    thing.add(
        boards([(-w / 2, w / 2, -d / 2, d / 2, top + 0.0006, top + 0.03)], 0.003), style.second_wood
    )
    base, r = top + 0.0295, min(0.5 * d - 0.05, 0.19)
    rows = np.array([(0, 0), (0.6, 0), (0.85, 0.25), (0.97, 0.7), (1.0, 1.0), (0.985, 1.03),
        (0.96, 1.0),
                     (0.92, 0.7), (0.78, 0.28), (0.4, 0.1), (0, 0.09)])  # fmt: skip
    bowl_mesh = revolve(rows * [r, 0.13], 36)
    thing.add(placed(bowl_mesh, (0, -0.06, base)), WHITE if rng.uniform() < 0.7 else style.accent)
    if w > 0.7:
        thing.supports.append(
            Support(r + 0.03, w / 2 - 0.02, -d / 2 + 0.05, d / 2 - 0.05, top + 0.03, 0.4)
        )


def toilet(rng: np.random.Generator, style: Style) -> Thing:
    """A bowl on a foot with a cistern, or before a boxed-in wall; its lid up or down."""
    boxed, open_lid = rng.uniform() < 0.4, rng.uniform() < 0.35
    h, rx = float(rng.uniform(0.39, 0.43)), float(rng.uniform(0.17, 0.19))
    outline = _egg(rx, float(rng.uniform(0.26, 0.3)), 0.17)
    foot = [(0.0, 0.0, 0.05, 0.0), (0.6, 0.62, 0.06, 0.0), (0.6, 0.62, 0.06, 0.0), (0.52, 0.62,
        0.05, 0.06),
            (0.5, 0.62, 0.04, 0.14), (0.72, 0.8, 0.02, 0.24), (0.97, 0.98, 0, 0.34), (1, 1, 0,
                h - 0.03),
            (0.99, 0.995, 0, h - 0.004), (0.95, 0.965, 0, h), (0.74, 0.76, 0, h), (0.7, 0.72, 0,
                h - 0.015),
            (0.62, 0.66, 0, h - 0.1), (0.42, 0.45, 0.0, h - 0.19), (0.2, 0.2, 0.02, h - 0.23),
            (0.0, 0.0, 0.02, h - 0.235)]  # fmt: skip
    body = _rings(outline, foot)
    seat = _rings(outline, [(0.98, 0.985, 0, h + 0.004), (1.03, 1.02, 0, h + 0.008), (1.03, 1.02,
        0, h + 0.02),
                            (0.99, 0.99, 0, h + 0.026), (0.75, 0.77, 0, h + 0.024), (0.66, 0.7, 0,
                                h + 0.014),
                            (0.66, 0.7, 0, h + 0.006), (0.98, 0.985, 0, h + 0.004)])  # fmt: skip
    lid = _rings(outline, [(0, 0, 0, 0), (0.99, 0.99, 0, 0.0), (1.02, 1.015, 0, 0.004), (1.02,
        1.015, 0, 0.012),
                           (0.96, 0.96, 0, 0.02), (0.5, 0.5, 0, 0.023), (0, 0, 0,
                               0.024)])  # fmt: skip
    if open_lid:
        lid = placed(lid, (0, -0.17, 0))
        lid = placed(lid, (0, 0.16, h + 0.045), lean=-1.72)
    else:
        lid = placed(lid, (0, 0, h + 0.0275))
    hinge = rods([(-0.09, 0.165, h + 0.025)], [(0.09, 0.165, h + 0.025)], 0.011)
    pedestal = loft(
        0.2, 0.26, 0.05, [(0.1, 0), (0.0, 0.0), (0.0, h - 0.06), (0.1, h - 0.05)], (0, 0.16, 0)
    )
    wood = style.wood if rng.uniform() < 0.15 else WHITE
    thing = Thing("toilet").add(joined([body, pedestal]), WHITE).add(joined([seat, lid]), wood)
    back = 0.215
    if boxed:
        high = 1.12
        thing.add(boards([(-0.45, 0.45, back, back + 0.2, 0, high)], 0.002),
                  Material((0.75, 0.75, 0.73), (0.5, 0.5, 0.5), "tiles", 0.15, 0.1,
                      120.0))  # fmt: skip
        plate = (-0.12, 0.12, back - 0.012, back + 0.001, 0.93, 1.09)
        knobs = [(-0.1, -0.01, back - 0.015, back - 0.01, 0.96, 1.06), (0.01, 0.1, back - 0.015,
            back - 0.01,
                                                                     0.96, 1.06)]  # fmt: skip
        thing.add(boards([plate, *knobs], 0.002), WHITE if rng.uniform() < 0.5 else CHROME)
        thing.supports.append(Support(-0.42, 0.42, back + 0.04, back + 0.17, high, 0.4))
    else:
        rows = [
            (0.08, h - 0.05),
            (0.015, h - 0.05),
            (0.005, h + 0.1),
            (0.0, h + 0.32),
            (0.08, h + 0.33),
        ]
        tank = loft(0.38, 0.17, 0.04, rows, (0, back, 0))
        cover = loft(0.395, 0.185, 0.045, [(0.09, h + 0.322), (0, h + 0.322), (0, h + 0.345),
            (0.006, h + 0.355),
                     (0.0925, h + 0.358)], (0, back, 0))  # fmt: skip
        push = cylinder(0.022, 0.008, (0, back, h + 0.360), sides=20)
        thing.add(joined([tank, cover]), WHITE).add(push, CHROME)
        thing.supports.append(Support(-0.15, 0.15, back - 0.05, back + 0.05, h + 0.357, 0.4))
    thing.add(hinge, CHROME)
    return centred(thing, along="y")


CATALOGUE: dict[str, Maker] = {
    "bathtub": bathtub,
    "shower_cabin": shower_cabin,
    "washbasin": washbasin,
    "toilet": toilet,
    "towel_rail": towel_rail,
    "bathroom_cabinet": bathroom_cabinet,
}
