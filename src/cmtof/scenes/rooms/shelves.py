"""Open shelves: for books, shoes and tools, m."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.cabinetry import (
    BLACK,
    STEEL,
    Span,
    add_fronts,
    carcass,
    look,
    timber,
)  # fmt: skip
from cmtof.scenes.rooms.joinery import beams, boards, raised, rods
from cmtof.scenes.rooms.materials import Material, Style, darker
from cmtof.scenes.rooms.solids import joined
from cmtof.scenes.rooms.thing import Support, Thing

Fronts = list[tuple[str, Span, Span]]


def _clear(x: Span, y: Span, z: float, free: float) -> Support:
    """A shelf's surface, a little in from its sides."""
    return Support(x[0] + 0.015, x[1] - 0.015, y[0] + 0.01, y[1] - 0.012, z, free)


def shelved(
    thing: Thing,
    x: Span,
    y: Span,
    levels: np.ndarray,
    thickness: float,
    material: Material,
    *,
    supports: bool = True,
) -> None:
    """Shelves between sides; ``levels`` are the undersides, floor first and top last, m."""
    t, e = thickness, 0.0006
    rows = [(x[0] - e, x[1] + e, y[0] + 0.002, y[1] - 0.008, z, z + t) for z in levels[1:-1]]
    if rows:
        thing.add(boards(rows), material)
    if supports:
        thing.supports += [_clear(x, y, float(low) + t, float(high - low) - t)
                           for low, high in pairwise(levels)]  # fmt: skip


def bookshelf(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
    height: float | None = None,
) -> Thing:
    """Tall shelves: plain, over doors, cubes, a ladder against the wall, or boards on steel."""
    width = float(rng.uniform(0.6, 1.3)) if width is None else width
    height = float(rng.uniform(1.1, 2.2)) if height is None else height
    kind = str(rng.choice(["plain", "plain", "doors", "cubes", "ladder", "steel"]))
    material = timber(rng, style)
    if kind == "cubes":
        return _cubes(rng, material, width, height)
    if kind in ("ladder", "steel"):
        return _open_shelf(rng, style, material, width, height, ladder=kind == "ladder")
    depth, t = float(rng.uniform(0.24, 0.36)), float(rng.uniform(0.018, 0.03))
    x, y, foot = (-width / 2, width / 2), (-depth / 2, depth / 2), float(rng.uniform(0.03, 0.1))
    thing = Thing("bookshelf")
    back = rng.uniform() < 0.75
    thing.add(carcass(x, y, (foot, height), t, back=back, overhang=0.0), material, 2)
    thing.add(boards([(x[0] + 0.001, x[1] - 0.001, y[0] + 0.012, y[1] - 0.01, 0, foot + 0.001)], 0),
              material)  # fmt: skip
    bays = 2 if width > 0.95 and rng.uniform() < 0.7 else 1
    edges = np.linspace(x[0], x[1], bays + 1)
    if bays == 2:
        thing.add(boards([(-t / 2, t / 2, y[0] + 0.001, y[1] - 0.007, foot + t, height - t)]),
                  material, 2)  # fmt: skip
    low = foot
    if kind == "doors":
        low = foot + float(rng.uniform(0.45, 0.75)) if height > 1.4 else foot + 0.35
        fronts: Fronts = []
        for a, b in pairwise(edges):
            fronts += pair(a + 0.002, b - 0.002, (foot + 0.002, low + t - 0.002))
        add_fronts(thing, fronts, y[0], look(rng, style, material))
    for a, b in pairwise(edges):
        inner = (a + t * (0.5 if a > x[0] else 1.0), b - t * (0.5 if b < x[1] else 1.0))
        count = max(round((height - t - low) / float(rng.uniform(0.27, 0.40))), 1)
        levels = np.linspace(low, height - t, count + 1)
        levels[1:-1] += rng.uniform(-0.03, 0.03, count - 1)
        if low > foot:
            thing.add(boards([(*inner, y[0] + 0.001, y[1] - 0.008, low, low + t)]), material)
        shelved(thing, inner, y, levels, t, material)
    thing.supports.append(_clear(x, y, height, 0.6))
    return thing


def pair(x0: float, x1: float, z: Span) -> Fronts:
    """One door for a narrow opening, a pair for a wide one."""
    if x1 - x0 < 0.55:
        return [("left", (x0, x1), z)]
    middle = (x0 + x1) / 2
    return [("left", (x0, middle), z), ("right", (middle, x1), z)]


def _cubes(rng: np.random.Generator, material: Material, width: float, height: float) -> Thing:
    """A grid of square boxes, some with a drawer or a basket in them."""
    side, t = float(rng.uniform(0.33, 0.38)), 0.035
    nx, nz = max(round(width / side), 2), max(round(height / side), 2)
    w, h, d = nx * side + t, nz * side + t, 0.38
    xs, zs, y = (
        np.linspace(-w / 2, w / 2 - t, nx + 1),
        np.linspace(0, h - t, nz + 1),
        (-d / 2, d / 2),
    )
    outer = [(xs[0], xs[0] + t, *y, 0, h), (xs[-1], xs[-1] + t, *y, 0, h)]
    inner = [(a, a + 0.016, y[0] + 0.002, y[1], t, h - t) for a in xs[1:-1] + t / 2 - 0.008]
    level = [(xs[0] + t, xs[-1], y[0] + 0.001, y[1] - 0.001, z, z + t) for z in zs[[0, -1]]]
    level += [
        (xs[0] + t, xs[-1], y[0] + 0.003, y[1] - 0.001, z + 0.01, z + 0.026) for z in zs[1:-1]
    ]
    thing = Thing("bookshelf").add(boards(outer + inner), material, 2).add(boards(level), material)
    tone = (0.55, 0.47, 0.36) if rng.uniform() < 0.5 else (0.12, 0.12, 0.13)
    basket = Material(tone, darker(tone, 0.6), "weave", 0.012, specular=0.0, bump=0.5)
    boxes = []
    for a, b in pairwise(xs):
        for low, high in pairwise(zs):
            x, base = (a + 0.02, b + 0.008), float(low) + (t if low == 0 else 0.026)
            if rng.uniform() < 0.2:
                boxes.append((x[0] + 0.008, x[1] - 0.006, y[0] + 0.015, y[1] - 0.03, base + 0.001,
                              high - 0.01))  # fmt: skip
            else:
                thing.supports.append(_clear(x, y, base, float(high) + 0.01 - base))
    if boxes:
        thing.add(boards(boxes, 0.012), basket)
    thing.supports.append(_clear((-w / 2, w / 2), y, h, 0.5))
    return thing


def _open_shelf(
    rng: np.random.Generator,
    style: Style,
    material: Material,
    width: float,
    height: float,
    *,
    ladder: bool,
) -> Thing:
    """Boards on two raked or upright frames; the boards of a ladder get deeper downwards."""
    d, x = float(rng.uniform(0.32, 0.42)), width / 2 - 0.014
    count = max(int(height / 0.36), 3)
    levels = np.linspace(0.14 if not ladder else 0.32, height - 0.03, count)
    rake = d - 0.14 if ladder else 0.0
    base = style.metal if not ladder or rng.uniform() < 0.4 else material
    post = 0.024
    front = [(s * x, -d / 2 + post / 2, 0.0) for s in (-1, 1)]
    head = [(s * x, -d / 2 + post / 2 + rake, height) for s in (-1, 1)]
    back = [(s * x, d / 2 - post / 2, 0.0) for s in (-1, 1)]
    uprights = beams([*front, *back], [*head, *raised(back, height)], post, post)
    thing = Thing("bookshelf")
    rows, rungs = [], []
    for z in levels:
        y0 = -d / 2 + rake * z / height
        rows.append((-x + 0.002, x - 0.002, y0 + 0.002, d / 2 - 0.004, z - 0.022, z))
        rungs += [
            [(s * x, y0 + post, z - 0.012), (s * x, d / 2 - post, z - 0.012)] for s in (-1, 1)
        ]
        free = float(levels[1] - levels[0]) - 0.03
        inner = (-x + 0.03, x - 0.03)
        thing.supports.append(_clear(inner, (y0 + 0.03, d / 2 - 0.01), float(z), free))
    ends = np.array(rungs)
    bars = beams(ends[:, 0], ends[:, 1], 0.016, 0.016)
    cross = rods([(-x, d / 2 - 0.006, 0.2), (x, d / 2 - 0.006, 0.2)],
                 [(x, d / 2 - 0.006, height - 0.2), (-x, d / 2 - 0.006, height - 0.2)],
                     0.004)  # fmt: skip
    thing.add(joined([uprights, bars] if ladder else [uprights, bars, cross]), base, 2)
    return thing.add(boards(rows), material)


def shoe_rack(rng: np.random.Generator, style: Style) -> Thing:
    """Slatted shelves between two ladders, knee-high."""
    w, d, n = float(rng.uniform(0.6, 1.0)), float(rng.uniform(0.28, 0.33)), int(rng.integers(2, 5))
    material, x, y = timber(rng, style), w / 2, d / 2
    h = 0.2 * n + 0.08
    feet = np.array([(s * (x - 0.012), t * (y - 0.015), 0) for s in (-1, 1) for t in (-1, 1)])
    thing = Thing("shoe rack").add(beams(feet, raised(feet, h), 0.022, 0.03), material, 2)
    rows, metal = [], rng.uniform() < 0.4
    for k in range(n):
        z = 0.09 + 0.2 * k
        at = np.linspace(-y + 0.004, y - 0.004, 6)
        rows += [(-x + 0.02, x - 0.02, a + 0.006, b - 0.006, z - 0.012, z) for a, b in pairwise(at)]
        rows += [(s * x - 0.02 * (s > 0), s * x + 0.02 * (s < 0), -y + 0.02, y - 0.02, z - 0.03,
            z - 0.011)
                 for s in (-1, 1)]  # fmt: skip
        thing.supports.append(Support(-x + 0.04, x - 0.04, -y + 0.03, y - 0.03, z, 0.17))
    return thing.add(boards(rows), STEEL if metal else material)


def metal_rack(rng: np.random.Generator, style: Style) -> Thing:
    """Workshop shelving of slotted angle steel with sheet or wire shelves."""
    w, d = float(rng.uniform(0.75, 1.3)), float(rng.uniform(0.35, 0.5))
    h, n = float(rng.uniform(1.5, 2.0)), int(rng.integers(4, 6))
    tone = (STEEL, BLACK, Material((0.05, 0.12, 0.3), specular=0.1))[int(rng.integers(3))]
    x, y, t, a = w / 2, d / 2, 0.002, 0.035
    posts = []
    for s in (-1, 1):
        for q in (-1, 1):
            px, py = sorted((s * x, s * (x - a))), sorted((q * y, q * (y - t)))
            posts.append((*px, *py, 0, h))
            px, py = sorted((s * x, s * (x - t))), sorted((q * (y - t), q * (y - a)))
            posts.append((*px, *py, 0, h))
    thing = Thing("metal rack").add(boards(posts, 0), tone, 2)
    levels, wire = np.linspace(0.1, h - 0.02, n), rng.uniform() < 0.4
    bars, rails = [], []
    for z in levels:
        lined = not wire or rng.uniform() < 0.5  # a liner lies on some wires, the others stay bare
        if wire:
            at = np.linspace(-x + 0.02, x - 0.02, 25)
            bars += [[(p, -y + 0.008, z - 0.003), (p, y - 0.008, z - 0.003)] for p in at]
            ys = (-y + 0.008, -0.3 * y, 0.3 * y, y - 0.008)
            bars += [[(-x + 0.006, q, z - 0.008), (x - 0.006, q, z - 0.008)] for q in ys]
        ends = ((-y + 0.0025, -y + 0.005), (y - 0.005, y - 0.0025))
        rails += [(-x + 0.003, x - 0.003, *e, z - 0.035, z - 0.002) for e in ends]
        if lined:
            low = 0.001 if wire else -0.003
            rails.append((-x + 0.004, x - 0.004, -y + 0.006, y - 0.006, z + low, z + low + 0.003))
            free = float(levels[1] - levels[0]) - 0.05
            inner = (-x + 0.05, x - 0.05, -y + 0.05, y - 0.05)
            thing.supports.append(Support(*inner, float(z) + low + 0.003, free))
    if bars:
        ends3 = np.array(bars)
        thing.add(rods(ends3[:, 0], ends3[:, 1], 0.003, sides=5), STEEL)
    return thing.add(boards(rails, 0), tone)
