"""Beds: frames with their headboards, mattresses, covers that hang in folds, pillows, m."""

import numpy as np

from cmtof.scenes.rooms.cabinetry import Maker, timber
from cmtof.scenes.rooms.joinery import (
    beams,
    boards,
    centred,
    copies,
    corners,
    mirrored,
    placed,
    plank,
    raised,
    rods,
    rounded,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style, hue
from cmtof.scenes.rooms.solids import joined, tube
from cmtof.scenes.rooms.thing import Support, Thing
from cmtof.scenes.rooms.upholstery import covering, pad, pillow

SHEET = Material((0.78, 0.77, 0.75), (0.72, 0.71, 0.69), "weave", 0.004, specular=0.0, bump=0.2)


def linen(rng: np.random.Generator, style: Style) -> Material:
    """What beds are made up with: white, the household's cloth, or a print."""
    kind = int(rng.integers(4))
    if kind == 0:
        return SHEET
    if kind == 1:
        return style.fabric if rng.uniform() < 0.5 else style.second_fabric
    tone = hue(
        float(rng.uniform()), float(rng.uniform(0.05, 0.5)), float(rng.choice([0.3, 0.6, 0.75]))
    )
    other = hue(float(rng.uniform()), 0.5, float(rng.uniform(0.1, 0.6)))
    pattern = str(rng.choice(["stripes", "checks", "dots", "plain", "noise"]))
    return Material(tone, other, pattern, float(rng.uniform(0.03, 0.15)), 0.0, bump=0.3)


def headboard(rng: np.random.Generator, style: Style, width: float, high: float) -> Thing:
    """Board, bars, laths, padded panels or a wrought-iron arch; its back at y = 0."""
    kind = str(rng.choice(["board", "bars", "laths", "padded", "iron", "frame"]))
    x, material = width / 2, timber(rng, style)
    thing = Thing("headboard")
    if kind == "board":
        thing.add(boards([(-x, x, -0.035, 0, 0.1, high)], 0.006), material)
    elif kind == "padded":
        count = int(rng.integers(2, 7)) if rng.uniform() < 0.7 else 1
        step = width / count
        piece = pad((step - 0.004, high - 0.2, 0.08), radius=0.035, edge=0.03, crown=0.015)
        at = [(-x + (k + 0.5) * step, 0.0, 0.2 + (high - 0.2) / 2) for k in range(count)]
        upright = placed(piece, lean=np.pi / 2)
        cover = style.leather if rng.uniform() < 0.3 else style.fabric
        thing.add(copies(upright, at), cover)
        thing.add(boards([(-x + 0.1, x - 0.1, -0.05, -0.01, 0.0, 0.25)]), material)
    elif kind == "iron":
        arch = rounded([(-x, -0.02, 0), (-x, -0.02, high), (-0.4 * x, -0.02, high + 0.12),
                        (0.4 * x, -0.02, high + 0.12), (x, -0.02, high), (x, -0.02, 0)],
                            3)  # fmt: skip
        at = np.linspace(-0.85, 0.85, 9) * x
        top = high + 0.075 - 0.09 * (np.abs(at) / x) ** 3
        low = np.stack([at, 0 * at - 0.02, 0 * at + 0.35], -1)
        bars = rods(low, np.stack([at, 0 * at - 0.02, top], -1), 0.007, sides=7)
        rail = rods([(-x, -0.02, 0.35)], [(x, -0.02, 0.35)], 0.011)
        thing.add(joined([tube(arch, 0.016, 8), bars, rail]), style.metal)
    else:
        post = 0.055
        stand = [(s * (x - post / 2), -post / 2, 0.0) for s in (-1, 1)]
        thing.add(beams(stand, raised(stand, high), post, post, chamfer=0.006), material, 2)
        rail = [(-x + 0.03, x - 0.03, -0.045, -0.012, z - 0.09, z) for z in (0.42, high - 0.03)]
        thing.add(boards(rail, 0.004), material)
        at = np.linspace(
            -x + 0.14, x - 0.14, max(int(width / (0.11 if kind == "bars" else 0.16)), 4)
        )
        if kind == "frame":
            fill = (-x + 0.05, x - 0.05, -0.034, -0.020, 0.4, high - 0.1)
            thing.add(boards([fill], 0), material, 2)
        else:
            low = np.stack([at, 0 * at - 0.028, 0 * at + 0.41], -1)
            up = raised(low, high - 0.5)
            bars = rods(low, up, 0.011, sides=8) if kind == "bars" else beams(low, up, 0.07, 0.014)
            thing.add(bars, material, 2)
    return thing


def _bedstead(
    rng: np.random.Generator, style: Style, w: float, length: float, rail: float, board: bool
) -> Thing:
    """Side rails, foot, slats and legs of a bed of w by length; ``board`` is a high foot, m."""
    thing, material = Thing("bed"), timber(rng, style)
    x, y, t = w / 2 + 0.025, length / 2, 0.025
    low = rail - float(rng.uniform(0.13, 0.2))
    sides = [(s * x - t / 2, s * x + t / 2, -y, y, low, rail) for s in (-1, 1)]
    foot = [(-x - t / 2, x + t / 2, -y - 0.03, -y - 0.001, low, rail)]
    if board:
        foot = [(-x - 0.03, x + 0.03, -y - 0.04, -y - 0.001, 0.08, rail + 0.22)]
    thing.add(boards([*sides, *foot], 0.004), material)
    at = np.linspace(-y + 0.06, y - 0.06, 12)
    slats = [(-x + t / 2, x - t / 2, a - 0.035, a + 0.035, rail - 0.07, rail - 0.052) for a in at]
    thing.add(boards(slats, 0), style.second_wood)
    place = corners(x - 0.03, y - 0.05)
    legs = beams(place, raised(place, low + 0.01), 0.06, 0.06, taper=float(rng.choice([1, 0.7])))
    return thing.add(legs, material, 2)


def make_bed(
    thing: Thing,
    rng: np.random.Generator,
    style: Style,
    x: tuple[float, float],
    y: tuple[float, float],
    top: float,
    *,
    hang: float = 0.28,
    foot: float = 0.25,
) -> None:
    """Put duvet, pillows and perhaps a throw on a mattress whose top is at ``top``, m.

    The duvet hangs down by up to ``hang`` at the sides and by ``foot`` at the lower end.
    """
    w, length = x[1] - x[0], y[1] - y[0]
    cover = linen(rng, style)
    back = float(rng.uniform(0.42, 0.75))
    drop = (hang * float(rng.uniform(0.5, 1.0)), hang * float(rng.uniform(0.5, 1.0)))
    puff = float(rng.uniform(0.008, 0.022))
    state = float(rng.uniform())
    limits = (y[0] + 0.01, y[1] - back)
    if state < 0.2:
        limits = (y[0] + 0.01, y[0] + 0.45 * length)
    duvet = covering(rng, (x[0] + 0.02, x[1] - 0.02), limits, top - 0.004,
                     (*drop, foot, 0.0), thickness=0.035, folds=0.018, puff=puff)  # fmt: skip
    thing.add(duvet, cover, 1)
    if state < 0.65 and hang > 0.1:
        roll = covering(rng, (x[0] + 0.0, x[1] - 0.0), (limits[1] - 0.24, limits[1] + 0.02),
                        top + 0.03, (0.9 * drop[0], 0.9 * drop[1], 0.0, 0.0), thickness=0.04,
                        folds=0.02, puff=puff)  # fmt: skip
        thing.add(roll, SHEET if rng.uniform() < 0.5 else cover, 1)
    _pillows(thing, rng, style, cover, (x[0] + x[1]) / 2, w, y[1], top)
    rest = (y[0] + 0.12, max(limits[1] - 0.3, y[0] + 0.4), top + 0.031 + 0.7 * puff)
    if rng.uniform() < 0.4 and hang > 0.1:
        at = y[0] + float(rng.uniform(0.15, 0.4))
        end, level = at + float(rng.uniform(0.3, 0.6)), top + 0.032 + 1.5 * puff
        throw = covering(rng, (x[0] - 0.02, x[1] + 0.02), (at, end), level,
                         (0.9 * drop[0], 0.9 * drop[1], 0, 0), thickness=0.012, folds=0.035,
                         puff=0.012)  # fmt: skip
        thing.add(throw, (style.accent, style.second_fabric, style.fabric)[int(rng.integers(3))])
        rest = (at + 0.03, end - 0.03, level + 0.02)
    thing.supports.append(Support(x[0] + 0.15, x[1] - 0.15, *rest, 1.0))


def _pillows(
    thing: Thing,
    rng: np.random.Generator,
    style: Style,
    cover: Material,
    x: float,
    w: float,
    head: float,
    top: float,
) -> None:
    """Pillows at the head, flat or propped up, and a small one before them."""
    count = 2 if w > 1.2 else 1
    wide = min(0.78, 0.9 * w / count)
    for k in range(count):
        mesh = pillow(rng, wide, 0.44, 0.15, count=10)
        middle = x + (k - (count - 1) / 2) * (w / count)
        turn = float(rng.normal(0, 0.05))
        if rng.uniform() < 0.35:
            mesh = placed(mesh, lean=0.95, turn=turn)
            at = (middle, head - 0.24, top - 0.02 - float(mesh.vertices[:, 2].min()))
        else:
            mesh = placed(mesh, turn=turn)
            at = (middle, head - 0.27, top - 0.02)
        thing.add(placed(mesh, at), cover if rng.uniform() < 0.6 else SHEET)
    if rng.uniform() < 0.4:
        mesh = placed(
            pillow(rng, 0.42, 0.36, 0.13, count=10), lean=0.8, turn=float(rng.normal(0, 0.2))
        )
        lift = top - 0.01 - float(mesh.vertices[:, 2].min())
        thing.add(placed(mesh, (x + float(rng.normal(0, 0.1 * w)), head - 0.5, lift)), style.accent)


def bed(rng: np.random.Generator, style: Style, *, width: float | None = None) -> Thing:
    """A bed with headboard, mattress and bedding; its head at +y."""
    width = float(rng.choice([0.9, 1.2, 1.4, 1.6, 1.8])) if width is None else width
    length, rail = float(rng.choice([2.0, 2.0, 1.9])), float(rng.uniform(0.28, 0.38))
    thick = float(rng.uniform(0.16, 0.26))
    divan, board = rng.uniform() < 0.2, rng.uniform() < 0.25
    if divan:
        thing = Thing("bed")
        base = pad(
            (width + 0.02, length, rail - 0.07), (0, 0, 0.06), radius=0.04, edge=0.015, crown=0
        )
        place = corners(width / 2 - 0.1, length / 2 - 0.1)
        thing.add(base, style.fabric).add(
            rods(place, raised(place, 0.07), 0.025, sides=10), style.wood
        )
        floor = rail - 0.012
    else:
        thing = _bedstead(rng, style, width, length, rail, board)
        floor = rail - 0.0525
    mattress = pad(
        (width, length - 0.01, thick), (0, 0, floor), radius=0.06, edge=0.04, crown=0.012
    )
    thing.add(mattress, SHEET)
    high = float(rng.uniform(0.85, 1.25))
    head = headboard(rng, style, width + (0.06 if rng.uniform() < 0.7 else 0.16), high)
    for part in head.parts:
        mesh = placed(part.mesh, (0, length / 2 + 0.09, 0))
        thing.add(mesh, part.material, part.grain)
    half = (width / 2, length / 2)
    make_bed(thing, rng, style, (-half[0], half[0]), (-half[1], half[1] - 0.02), floor + thick,
             hang=min(0.34, floor + thick - 0.12),
                 foot=0.0 if board and not divan else 0.2)  # fmt: skip
    return thing


def bunk_bed(rng: np.random.Generator, style: Style) -> Thing:
    """Two berths one above the other, guard rails and a ladder."""
    w, length, high = 0.9, 2.0, float(rng.uniform(1.5, 1.75))
    x, y, p = w / 2 + 0.03, length / 2 + 0.03, 0.06
    steel = rng.uniform() < 0.3
    material = style.metal if steel else timber(rng, style)
    t = 0.03 if steel else p
    place = corners(x, y)
    thing = Thing("bunk bed").add(
        beams(place, raised(place, high), t, t, chamfer=0.005), material, 2
    )
    bars = []
    upper = high - 0.42
    for z in (0.36, upper):
        bars += [(-x + t / 2, x - t / 2, s * y - 0.012, s * y + 0.012, z - 0.1, z) for s in (-1, 1)]
        bars += [(s * x - 0.012, s * x + 0.012, -y + t / 2, y - t / 2, z - 0.1, z) for s in (-1, 1)]
    ends = (0.68, high - 0.05, high - 0.2)
    bars += [(-x + t / 2, x - t / 2, s * y - 0.011, s * y + 0.011, z - 0.06, z)
             for s in (-1, 1) for z in ends]  # fmt: skip
    gap = -0.35
    guard = [
        (x - 0.011, x + 0.011, -y + t / 2, y - t / 2),
        (-x - 0.011, -x + 0.011, gap, y - t / 2),
    ]
    bars += [(*g, z - 0.06, z) for g in guard for z in ends[1:]]
    bars += [(-x - 0.011, -x + 0.011, gap - 0.03, gap, upper - 0.01, high - 0.05)]
    thing.add(boards(bars, 0.004), material)
    rails = np.array([(-x - 0.03, gap - 0.07, 0.0), (-x - 0.03, -y + 0.1, 0.0)])
    ladder = beams(rails, raised(rails, high - 0.05), 0.03, 0.05)
    z = np.arange(0.28, upper, 0.27)
    rung = np.stack([0 * z - x - 0.03, 0 * z + rails[0, 1], z], -1)
    rungs = rods(rung, rung * [1, 0, 1] + [0, rails[1, 1], 0], 0.016)
    thing.add(joined([ladder, rungs]), material, 2)
    for z in (0.30, upper - 0.06):
        thing.add(boards([(-w / 2, w / 2, -1.0, 1.0, z - 0.02, z)], 0), style.second_wood)
        thing.add(pad((w - 0.01, 1.99, 0.13), (0, 0, z + 0.0005), radius=0.05, edge=0.03), SHEET)
        make_bed(thing, rng, style, (-w / 2 + 0.04, w / 2 - 0.04), (-0.98, 0.97), z + 0.135,
            hang=0.05,
                 foot=0.0)  # fmt: skip
        if z < 0.5:
            thing.supports[-1] = thing.supports[-1]._replace(clearance=upper - 0.8)
    return centred(thing, along="x")


def crib(rng: np.random.Generator, style: Style) -> Thing:
    """A cot with bars all round, a mattress, a blanket and perhaps a rail for toys."""
    w, length, high = 0.66, 1.26, float(rng.uniform(0.85, 1.0))
    x, y, material = w / 2, length / 2, timber(rng, style)
    floor = float(rng.uniform(0.3, 0.5))
    place = corners(x - 0.02, y - 0.02)
    thing = Thing("crib").add(beams(place, raised(place, high + 0.02), 0.04, 0.04, chamfer=0.006),
                              material, 2)  # fmt: skip
    rails = []
    for z0, z1 in ((floor - 0.07, floor - 0.02), (high - 0.05, high)):
        rails += [(s * (x - 0.02) - 0.012, s * (x - 0.02) + 0.012, -y + 0.04, y - 0.04, z0, z1)
                  for s in (-1, 1)]  # fmt: skip
        rails += [(-x + 0.04, x - 0.04, s * (y - 0.02) - 0.012, s * (y - 0.02) + 0.012, z0, z1)
                  for s in (-1, 1)]  # fmt: skip
    thing.add(boards(rails, 0.005), material)
    side, end = np.linspace(-y + 0.1, y - 0.1, 15), np.linspace(-x + 0.1, x - 0.1, 6)
    low = [(s * (x - 0.02), a, floor - 0.04) for s in (-1, 1) for a in side]
    panel_ends = rng.uniform() < 0.4
    if not panel_ends:
        low += [(a, s * (y - 0.02), floor - 0.04) for s in (-1, 1) for a in end]
    else:
        fill = [(-x + 0.03, x - 0.03, s * (y - 0.02) - 0.007, s * (y - 0.02) + 0.007, floor - 0.03,
                 high - 0.03) for s in (-1, 1)]  # fmt: skip
        thing.add(boards(fill, 0), style.paint)
    thing.add(rods(low, raised(low, high - floor), 0.008, sides=8), material, 2)
    base = (-x + 0.035, x - 0.035, -y + 0.035, y - 0.035, floor - 0.06, floor - 0.045)
    thing.add(boards([base], 0), material)
    thing.add(pad((w - 0.085, length - 0.085, 0.1), (0, 0, floor - 0.0445), radius=0.05), SHEET)
    top = floor + 0.064
    blanket = covering(rng, (-x + 0.08, x - 0.08), (-y + 0.08, 0.1), top - 0.004, (0, 0, 0, 0),
                       thickness=0.018, puff=0.02)  # fmt: skip
    thing.add(blanket, linen(rng, style))
    mesh = pillow(rng, 0.4, 0.28, 0.07, count=10)
    thing.add(placed(mesh, (0, y - 0.25, top - 0.012)), SHEET)
    thing.supports.append(Support(-x + 0.14, x - 0.14, -y + 0.15, 0.0, top + 0.024, 0.4))
    return thing


def daybed(rng: np.random.Generator, style: Style) -> Thing:
    """A bed to sit on by day: three low sides or two curved ends, cushions along the back."""
    length, depth = float(rng.uniform(1.85, 2.05)), float(rng.uniform(0.8, 0.95))
    seat, x, y = float(rng.uniform(0.40, 0.46)), length / 2, depth / 2
    thing = Thing("daybed")
    material = timber(rng, style)
    if rng.uniform() < 0.5:
        place = corners(x - 0.025, y - 0.025)
        high = float(rng.uniform(0.7, 0.85))
        thing.add(beams(place, raised(place, high), 0.045, 0.045, chamfer=0.005), material, 2)
        z = (0.22, 0.3), (high - 0.06, high)
        rows = [(s * (x - 0.025) - 0.011, s * (x - 0.025) + 0.011, -y + 0.045, y - 0.045, *q)
                for s in (-1, 1) for q in z]  # fmt: skip
        rows += [(-x + 0.045, x - 0.045, y - 0.036, y - 0.014, *q) for q in z]
        rows += [(-x + 0.045, x - 0.045, -y + 0.014, -y + 0.036, *z[0])]
        thing.add(boards(rows, 0.004), material)
        at = np.linspace(-x + 0.12, x - 0.12, 17)
        low = [(a, y - 0.025, 0.28) for a in at]
        low += [(s * (x - 0.025), a, 0.28) for s in (-1, 1) for a in np.linspace(-0.7, 0.7, 6) * y]
        thing.add(rods(low, raised(low, high - 0.31), 0.009), material, 2)
    else:
        base = [(-x + 0.1, x - 0.1, -y + 0.02, y - 0.02, 0.2, 0.26)]
        curve = rounded(
            [(-x + 0.1, 0, 0.23), (-x + 0.03, 0, 0.45), (-x, 0, 0.68), (-x - 0.05, 0, 0.72)]
        )
        end = plank(curve, (0, depth - 0.06, 0), 0.03)
        place = corners(x - 0.14, y - 0.06)
        thing.add(joined([boards(base, 0.004), end, mirrored(end)]), material)
        thing.add(beams(place, raised(place, 0.21), 0.055, 0.055, taper=0.7), material, 2)
    width, deep = length - 0.26, depth - 0.12
    thing.add(boards([(-x + 0.1, x - 0.1, -y + 0.06, y - 0.06, 0.255, 0.275)], 0), material)
    thick = seat - 0.275
    cover = style.fabric if rng.uniform() < 0.7 else style.leather
    thing.add(pad((width + 0.02, deep, thick), (0, 0, 0.2745), radius=0.05, edge=0.03), cover)
    for k in range(int(rng.integers(2, 5))):
        size = float(rng.uniform(0.42, 0.55))
        mesh = placed(pillow(rng, size, 0.8 * size, 0.15, count=10), lean=1.15)
        at = (
            -0.36 * width + 0.24 * width * k,
            y - 0.24,
            seat - float(mesh.vertices[:, 2].min()) - 0.01,
        )
        thing.add(placed(mesh, at), (style.second_fabric, style.accent, cover)[k % 3])
    thing.supports.append(Support(-0.4 * width, 0.4 * width, -y + 0.1, -0.05, seat + 0.006))
    return thing


CATALOGUE: dict[str, Maker] = {
    "bed": bed,
    "bunk_bed": bunk_bed,
    "crib": crib,
    "daybed": daybed,
}
