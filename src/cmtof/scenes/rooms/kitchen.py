"""Kitchens: base units under a worktop, wall units, an island, a child's chair, m."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.appliances import fridge, hob, machine, oven, range_hood
from cmtof.scenes.rooms.cabinetry import (
    BLACK,
    CHROME,
    STEEL,
    WHITE,
    Look,
    Maker,
    Span,
    add_fronts,
    carcass,
    look,
    tap,
    timber,
)  # fmt: skip
from cmtof.scenes.rooms.joinery import (
    bent,
    boards,
    centred,
    corners,
    mirrored,
    placed,
    rods,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style, darker, hue
from cmtof.scenes.rooms.solids import joined, revolve, tube
from cmtof.scenes.rooms.storage import pair, shelved
from cmtof.scenes.rooms.thing import Mesh, Support, Thing
from cmtof.scenes.rooms.upholstery import loft, pad

PLINTH, DEPTH = 0.10, 0.60


Fronts = list[tuple[str, Span, Span]]


def worktop_material(rng: np.random.Generator, style: Style) -> Material:
    """Wood, stone, terrazzo, laminate or steel."""
    grey = float(rng.choice([0.03, 0.15, 0.45, 0.7]))
    tone = hue(float(rng.uniform(0.02, 0.15)), float(rng.uniform(0, 0.2)), grey)
    kinds = (
        style.wood,
        Material(tone, darker(tone, 0.6), "marble", 0.25, specular=0.12, gloss=150.0),
        Material(tone, darker(tone, 1.6), "terrazzo", 0.012, specular=0.1, gloss=100.0),
        Material(tone, darker(tone, 0.85), "noise", 0.006, specular=0.05, gloss=30.0),
        STEEL,
    )
    return kinds[int(rng.choice(5, p=[0.3, 0.25, 0.15, 0.2, 0.1]))]


def kitchen_look(rng: np.random.Generator, style: Style) -> Look:
    """Lacquered or wooden fronts, all of one kind."""
    made = look(rng, style, style.paint if rng.uniform() < 0.65 else style.wood)
    return Look(
        made.panel, "bar" if made.handle == "none" else made.handle, made.material, made.metal, 2
    )


def _widths(rng: np.random.Generator, length: float) -> list[float]:
    """Widths of units that fill a length: 60 cm mostly, the rest 30 to 90."""
    widths: list[float] = []
    while (left := length - sum(widths)) > 0.02:
        width = float(rng.choice([0.6, 0.6, 0.6, 0.45, 0.8]))
        widths.append(left if left < width + 0.3 else width)
    return widths


def kitchen_run(rng: np.random.Generator, style: Style, *, length: float | None = None) -> Thing:
    """Base units along a wall with worktop, sink, hob over an oven, drawers and doors."""
    length = float(rng.uniform(1.8, 3.6)) if length is None else length
    top, thick = float(rng.uniform(0.86, 0.93)), float(rng.choice([0.02, 0.03, 0.04]))
    made, stone = kitchen_look(rng, style), worktop_material(rng, style)
    widths = _widths(rng, length)
    at = -length / 2 + np.concatenate([[0], np.cumsum(widths)])
    wide = [k for k, w in enumerate(widths) if w >= 0.55]
    order = [int(k) for k in rng.permutation(wide)] if wide else []
    basin = order[0] if order else -1
    stove = order[1] if len(order) > 1 else -1
    washer = order[2] if len(order) > 2 and rng.uniform() < 0.6 else -1
    thing, y = Thing("kitchen units"), (-DEPTH / 2 + 0.04, DEPTH / 2)
    z = (PLINTH + 0.002, top - thick - 0.002)
    bodies, fronts = [], []
    for k, (a, b) in enumerate(pairwise(at)):
        x = (float(a) + 0.0005, float(b) - 0.0005)
        bodies.append(
            carcass(x, y, (PLINTH, top - thick + 0.0006), 0.016, back=False, lid=k != basin)
        )
        if k == stove:
            oven(thing, rng, (x[0] + b) / 2, min(b - a, 0.6), y[0], z, made)
        elif k == washer:
            machine(thing, rng, (a + b) / 2, y[0], z)
        else:
            fronts += _unit_fronts(rng, (float(a), float(b)), z, sink=k == basin)
    plinth = (at[0] + 0.002, at[-1] - 0.002, y[0] + 0.05, y[0] + 0.066, 0, PLINTH + 0.001)
    backing = (at[0] + 0.002, at[-1] - 0.002, y[1] - 0.02, y[1] - 0.002, 0, top - thick)
    thing.add(joined([*bodies, boards([plinth, backing], 0)]), made.material, 2)
    add_fronts(thing, fronts, y[0], made)
    spans = _top(thing, rng, stone, at, (basin, stove), (top, thick))
    if rng.uniform() < 0.5:
        lip = (at[0] + 0.001, at[-1] - 0.001, DEPTH / 2 - 0.018, DEPTH / 2 - 0.001, top - 0.001)
        thing.add(boards([(*lip, top + float(rng.choice([0.04, 0.1])))]), stone)
    thing.supports += [Support(a, b, -DEPTH / 2 + 0.06, DEPTH / 2 - 0.06, top, 0.45)
                       for a, b in spans if b - a > 0.12]  # fmt: skip
    return thing


def _unit_fronts(rng: np.random.Generator, x: Span, z: Span, *, sink: bool) -> Fronts:
    """Doors, drawers, or a drawer over doors."""
    kind = int(rng.integers(3))
    if sink or kind == 0:
        return pair(*x, z)
    if kind == 1:
        cuts = z[0] + (z[1] - z[0]) * np.array([0, 0.4, 0.8, 1.0])
        return [("drawer", x, (float(a), float(b))) for a, b in pairwise(cuts)]
    split = z[1] - 0.15
    return [*pair(*x, (z[0], split)), ("drawer", x, (split, z[1]))]


def _top(
    thing: Thing,
    rng: np.random.Generator,
    stone: Material,
    at: np.ndarray,
    places: tuple[int, int],
    level: tuple[float, float],
) -> list[Span]:
    """Worktop with its sink and hob; returns the free stretches along x."""
    (sink, oven), (top, thick) = places, level
    front, back = -DEPTH / 2, DEPTH / 2 - 0.001
    x0, x1 = float(at[0]) - 0.001, float(at[-1]) + 0.001
    taken = []
    if sink >= 0:
        c = float(at[sink] + at[sink + 1]) / 2
        w, d = float(min(at[sink + 1] - at[sink] - 0.08, 0.56)), 0.40
        hole = (c - w / 2 + 0.012, c + w / 2 - 0.012, -d / 2 - 0.008, d / 2 - 0.032)
        slabs = [(x0, hole[0], front, back), (hole[1], x1, front, back),
                 (hole[0], hole[1], front, hole[2]), (hole[0], hole[1], hole[3], back)]  # fmt: skip
        thing.add(boards([(*s, top - thick, top) for s in slabs], 0), stone)
        _sink(thing, rng, c, w, d, top)
        taken.append((c - w / 2 - 0.04, c + w / 2 + 0.04))
    else:
        thing.add(boards([(x0, x1, front, back, top - thick, top)]), stone)
    if oven >= 0:
        c = float(at[oven] + at[oven + 1]) / 2
        hob(thing, rng, c, top)
        taken.append((c - 0.33, c + 0.33))
    taken.sort()
    ends = [x0 + 0.02, *[v for pair_ in taken for v in pair_], x1 - 0.02]
    return list(zip(ends[::2], ends[1::2], strict=True))


def _sink(thing: Thing, rng: np.random.Generator, x: float, w: float, d: float, top: float) -> None:
    """A basin let into the worktop, its drain and its tap."""
    deep, inset = float(rng.uniform(0.15, 0.2)), min(w, d) / 2
    rows = [(0.0, -0.002), (0.0, 0.003), (0.002, 0.004),
            (0.022, 0.003), (0.026, -0.004), (0.032, -deep + 0.04), (0.06, -deep + 0.005),
            (0.08, -deep + 0.003), (inset, -deep + 0.001)]  # fmt: skip
    steel = STEEL if rng.uniform() < 0.6 else (WHITE if rng.uniform() < 0.5 else BLACK)
    bowl = loft(w, d, 0.07, rows, (x, -0.02, top), corner=6)
    skin = [(inset - 0.02, -deep - 0.004), (0.0, -deep - 0.004), (0.0, -0.003)]
    under = loft(w - 0.04, d - 0.04, 0.05, skin, (x, -0.02, top))
    drain = revolve(
        [(0.0, 0), (0.038, 0), (0.042, 0.003), (0.03, 0.004), (0.026, 0.002), (0, 0.002)], 18
    )
    drain = placed(drain, (x, -0.02, top - deep + 0.002))
    thing.add(joined([bowl, under]), steel).add(drain, STEEL)
    spout = tap(rng, float(rng.uniform(0.16, 0.22)), float(rng.uniform(0.2, 0.34)))
    thing.add(placed(spout, (x + float(rng.normal(0, 0.02)), d / 2 + 0.025, top)), CHROME)


def wall_units(rng: np.random.Generator, style: Style, *, length: float | None = None) -> Thing:
    """Cupboards on the wall over a worktop, some of them open or with framed glass doors."""
    length = float(rng.uniform(1.2, 2.6)) if length is None else length
    high, deep = float(rng.choice([0.55, 0.7, 0.8])), float(rng.uniform(0.31, 0.37))
    made = kitchen_look(rng, style)
    at = -length / 2 + np.concatenate([[0], np.cumsum(_widths(rng, length))])
    thing, y, t = Thing("wall units"), (-deep, 0.0), 0.016
    bodies: list[Mesh] = []
    fronts: Fronts = []
    for a, b in pairwise(at):
        x, z = (float(a) + 0.0005, float(b) - 0.0005), (-high / 2, high / 2)
        bodies.append(carcass(x, y, z, t))
        kind = float(rng.uniform())
        if kind < 0.6:
            fronts += pair(float(a), float(b), z)
            continue
        inner = (x[0] + t, x[1] - t)
        levels = np.linspace(z[0], z[1] - t, 3)
        shelved(thing, inner, (y[0] + 0.01, y[1]), levels, t, made.material)
        if kind > 0.8:
            middle = (x[0] + x[1]) / 2
            fronts += [
                ("glass-left", (float(a), middle), z),
                ("glass-right", (middle, float(b)), z),
            ]
    thing.add(joined(bodies), made.material, 2)
    if fronts:
        add_fronts(thing, fronts, y[0], made)
    if rng.uniform() < 0.4:
        cornice = (
            at[0] - 0.015,
            at[-1] + 0.015,
            y[0] - 0.03,
            0.0,
            high / 2 - 0.001,
            high / 2 + 0.03,
        )
        thing.add(boards([cornice], 0.006), made.material)
    return thing


def kitchen_island(rng: np.random.Generator, style: Style) -> Thing:
    """A free-standing block: fronts on one side, worktop standing out on the other."""
    w, d, h = (
        float(rng.uniform(1.2, 2.0)),
        float(rng.uniform(0.75, 1.0)),
        float(rng.uniform(0.88, 0.94)),
    )
    made, stone, thick = kitchen_look(rng, style), worktop_material(rng, style), 0.035
    thing = Thing("kitchen island")
    x, y = (-w / 2 + 0.03, w / 2 - 0.03), (-d / 2 + 0.05, d / 2 - (0.28 if d > 0.85 else 0.04))
    at = x[0] + (x[1] - x[0]) * np.linspace(0, 1, 2 + int(rng.integers(1, 3)))
    bodies = [carcass((float(a), float(b)), y, (PLINTH, h - thick), 0.016) for a, b in pairwise(at)]
    plinth = (x[0] + 0.03, x[1] - 0.03, y[0] + 0.05, y[1] - 0.03, 0, PLINTH + 0.001)
    skin = (x[0], x[1], y[1] - 0.001, y[1] + 0.015, PLINTH, h - thick)
    thing.add(joined([*bodies, boards([plinth], 0), boards([skin])]), made.material, 2)
    fronts: Fronts = []
    z = (PLINTH + 0.002, h - thick - 0.002)
    for k, (a, b) in enumerate(pairwise(at)):
        if k == 1 and rng.uniform() < 0.5:
            inner = (float(a) + 0.017, float(b) - 0.017)
            levels = np.linspace(PLINTH, h - thick - 0.016, 3)
            shelved(thing, inner, y, levels, 0.016, made.material)
        else:
            fronts += _unit_fronts(rng, (float(a), float(b)), z, sink=False)
    add_fronts(thing, fronts, y[0], made)
    thing.add(boards([(-w / 2, w / 2, -d / 2, d / 2, h - thick + 0.0006, h)], 0.003), stone)
    thing.supports.insert(0, Support(-0.46 * w, 0.46 * w, -0.44 * d, 0.44 * d, h, 1.0))
    return thing


def high_chair(rng: np.random.Generator, style: Style) -> Thing:
    """A child's chair: splayed legs, a small seat with a back, a tray, a foot rest."""
    material, seat = timber(rng, style), float(rng.uniform(0.5, 0.56))
    foot, head = corners(0.25, 0.26), corners(0.15, 0.13, seat - 0.01)
    legs = rods(foot, head, 0.016, taper=0.8, sides=10)
    thing = Thing("high chair").add(legs, material, 2)
    shell_ = style.accent if rng.uniform() < 0.5 else WHITE
    pieces = [pad((0.34, 0.30, 0.035), (0, 0, seat - 0.02), radius=0.06, edge=0.014, crown=0.002)]
    back = pad((0.32, 0.30, 0.03), radius=0.08, edge=0.014, crown=0.004)
    pieces.append(placed(back, (0, 0.16, seat + 0.16), lean=np.pi / 2 - 0.12))
    thing.add(joined(pieces), shell_)
    side = tube(
        bent([(0.17, 0.17, seat + 0.2), (0.17, -0.2, seat + 0.2), (0.17, -0.12, seat)], 0.05), 0.011
    )
    thing.add(joined([side, mirrored(side)]), material)
    rows = [(0.16, 0.0), (0.0, 0.0), (0.0, 0.022), (0.004, 0.025), (0.012, 0.024), (0.02, 0.012),
            (0.16, 0.011)]  # fmt: skip
    thing.add(loft(0.46, 0.3, 0.08, rows, (0, -0.24, seat + 0.205), corner=6), shell_)
    step = 0.45
    at = (1 - step) * foot + step * head
    rest = boards(
        [(-0.17, 0.17, at[0, 1] - 0.08, at[0, 1] + 0.03, at[0, 2] - 0.01, at[0, 2] + 0.008)], 0.004
    )
    bars = rods(at[[1, 3]], at[[2, 0]], 0.009)
    thing.add(joined([rest, bars]), material)
    thing.supports.append(Support(-0.16, 0.16, -0.34, -0.15, seat + 0.216, 0.3))
    return centred(thing, along="y")


CATALOGUE: dict[str, Maker] = {
    "kitchen_run": kitchen_run,
    "wall_units": wall_units,
    "fridge": fridge,
    "kitchen_island": kitchen_island,
    "range_hood": range_hood,
    "high_chair": high_chair,
}
