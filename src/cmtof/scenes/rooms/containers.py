"""What holds other things: boxes, baskets, buckets, bins, m."""

import numpy as np

from cmtof.scenes.rooms import toys
from cmtof.scenes.rooms.cabinetry import BLACK, CHROME, STEEL
from cmtof.scenes.rooms.joinery import boards, placed, rods, shifted
from cmtof.scenes.rooms.materials import Material, Style, darker, fabric, hue
from cmtof.scenes.rooms.pliant import ripples, slab, spline
from cmtof.scenes.rooms.shaping import handle, hollow, pick, stood, turned
from cmtof.scenes.rooms.solids import (
    blob,
    cylinder,
    faceted,
    joined,
    quads,
    revolve,
    sheet,
    tube,
)
from cmtof.scenes.rooms.thing import Mesh, Support, Thing
from cmtof.scenes.rooms.vessels import Maker, between

CARD = Material((0.42, 0.3, 0.18), (0.36, 0.25, 0.14), "noise", 0.05, specular=0.01)


def plastic(rng: np.random.Generator) -> Material:
    """A dull plastic of some colour."""
    tone = hue(float(rng.uniform()), pick(rng, 0, 0.5, 0.8), between(rng, 0.05, 0.7))
    return Material(tone, specular=0.05, gloss=30.0)


def crate(w: float, d: float, h: float, t: float, z: float = 0.0) -> Mesh:
    """An open box of five boards, m."""
    return boards([(-w / 2, w / 2, -d / 2, -d / 2 + t, z, h),
        (-w / 2, w / 2, d / 2 - t, d / 2, z, h), (-w / 2, -w / 2 + t, -d / 2 + t, d / 2 - t,
        z + 3e-4, h - 3e-4), (w / 2 - t, w / 2, -d / 2 + t, d / 2 - t, z + 3e-4, h - 3e-4),
        (-w / 2 + t, w / 2 - t, -d / 2 + t, d / 2 - t, z + 3e-4, z + t)],
        min(0.001, 0.3 * t))  # fmt: skip


def cardboard_box(rng: np.random.Generator, style: Style) -> Thing:
    """A moving box: closed and taped, or open with four flaps at their own angles, m."""
    w, d, h = between(rng, 0.2, 0.55), between(rng, 0.18, 0.4), between(rng, 0.15, 0.4)
    t = 0.004
    thing = Thing("cardboard box")
    marked = Material(
        CARD.colour, (0.06, 0.045, 0.03), "marks", between(rng, 0.02, 0.05), specular=0.01
    )
    skin = marked if rng.uniform() < 0.5 else CARD
    thing.add(crate(w, d, h, t), skin)
    if rng.uniform() < 0.4:
        flaps = [(-w / 2, w / 2, -d / 2, -0.0015, h + 0.0005, h + t),
            (-w / 2, w / 2, 0.0015, d / 2, h + 0.0005, h + t)]  # fmt: skip
        tape = [(-w / 2 - 0.0006, w / 2 + 0.0006, -0.025, 0.025, h + t, h + t + 0.0006),
            (-w / 2 - 0.0008, -w / 2 + 0.001, -0.025, 0.025, 0.75 * h, h + t + 0.0006),
            (w / 2 - 0.001, w / 2 + 0.0008, -0.025, 0.025, 0.75 * h, h + t + 0.0006)]  # fmt: skip
        thing.add(boards(flaps, 0), CARD)
        thing.add(boards(tape, 0), Material((0.32, 0.2, 0.1), specular=0.12, gloss=60.0))
        thing.supports.append(
            Support(-0.42 * w, 0.42 * w, -0.42 * d, 0.42 * d, h + t + 0.0006, 0.3)
        )
        return stood(thing)
    flaps = []
    for side, (wide, reach, gap) in enumerate(
        [(w, d / 2, d / 2), (d - 0.01, min(d, w) / 2, w / 2)] * 2
    ):
        angle = between(rng, -1.1, 0.9)
        flap = boards([(-wide / 2 + 0.002, wide / 2 - 0.002, -reach, 0, -t / 2, t / 2)], 0)
        flap = placed(flap, (0, -gap + t / 2, h + 0.001), lean=angle)
        flaps.append(placed(flap, turn=side * np.pi / 2))
    thing.add(joined(flaps), CARD)
    if rng.uniform() < 0.6:
        crumpled = blob(rng, (0.75 * w, 0.75 * d, 0.5 * h), roughness=0.25, subdivisions=3)
        thing.add(shifted(crumpled, 0, 0, 0.35 * h), Material((0.6, 0.58, 0.54), specular=0.0))
    return stood(thing)


def _woven(
    shape: list[tuple[float, float]], square: float, depth: float, rows: int, columns: int
) -> Mesh:
    """A basket's wall, rods over and under its ribs, with its inside, m."""
    line = np.array(shape)
    s = np.linspace(0, 1, len(line))
    t = np.linspace(0, 1, rows)
    r, z = np.interp(t, s, line[:, 0]), np.interp(t, s, line[:, 1])
    a = np.arange(columns) * 2 * np.pi / columns
    c, n = np.cos(a), np.sin(a)
    girth = (np.abs(c) ** square + np.abs(n) ** square) ** (-1 / square)
    over = depth * np.outer((-1.0) ** np.arange(rows), (-1.0) ** np.arange(columns))
    radius = r[:, None] * girth + over
    outer = np.stack([radius * c, radius * n, np.broadcast_to(z[:, None], radius.shape)], -1)
    inner = outer * [1, 1, 1]
    inner[..., :2] *= 1 - 3.5 * depth / r[:, None, None]
    floor = np.broadcast_to([0, 0, z[0]], (1, columns, 3))
    raised = floor + np.array([0, 0, 3 * depth])
    inner[0, :, 2] += 3 * depth
    return sheet(np.concatenate([floor, outer, inner[::-1], raised])[:, ::-1], closed=True)


def _wicker(rng: np.random.Generator) -> Material:
    base = ((0.42, 0.27, 0.12), (0.6, 0.46, 0.28), (0.16, 0.09, 0.05), (0.72, 0.68, 0.6))[
        int(rng.integers(4))
    ]
    return Material(base, darker(base, 0.6), "noise", 0.01, specular=0.03)


def basket(rng: np.random.Generator, style: Style) -> Thing:
    """A woven basket, round or squarish, with a bow, two ears or none, m."""
    r, h = between(rng, 0.11, 0.2), between(rng, 0.1, 0.26)
    base = between(rng, 0.75, 1.0)
    kind = int(rng.integers(3))
    stuff = _wicker(rng)
    wall = _woven([(base * r, 0.0), (r, h)], pick(rng, 2.0, 2.0, 4.0), 0.0025, 13, 36)
    thing = Thing("basket").add(wall, stuff)
    x = float(wall.vertices[:, 0].max())
    if kind == 0:
        a = np.linspace(0, np.pi, 15)
        path = np.stack([0.96 * x * np.cos(a), 0 * a, h - 0.02 + (0.7 * h + 0.08) * np.sin(a)], -1)
        thing.add(tube(path, 0.007, 7), stuff)
    elif kind == 1:
        ears = [handle([(s * 0.97 * x, -0.05, h - 0.01), (s * 1.02 * x, -0.035, h + 0.05),
            (s * 1.02 * x, 0.035, h + 0.05), (s * 0.97 * x, 0.05, h - 0.01)], 0.005, count=10,
            sides=6) for s in (-1, 1)]  # fmt: skip
        thing.add(joined(ears), stuff)
    if rng.uniform() < 0.4:
        cloth = blob(rng, (1.5 * base * r, 1.5 * base * r, 0.8 * h), roughness=0.2, subdivisions=3)
        thing.add(shifted(cloth, 0, 0, 0.3 * h), fabric(rng))
    return stood(thing)


def laundry_basket(rng: np.random.Generator, style: Style) -> Thing:
    """A tall slatted or woven basket, washing heaped in it and over its edge, m."""
    r, h = between(rng, 0.18, 0.23), between(rng, 0.34, 0.55)
    stuff = _wicker(rng) if rng.uniform() < 0.5 else plastic(rng)
    wall = _woven([(0.85 * r, 0), (r, h)], pick(rng, 2.0, 3.5), 0.004, 15, 36)
    thing = Thing("laundry basket").add(wall, stuff)
    rim = float(wall.vertices[:, 0].max())
    t = np.linspace(0, 2 * np.pi, 33)
    ring = np.stack([rim * np.cos(t), rim * np.sin(t), h + 0 * t], -1)
    if float(wall.vertices[:, 1].max()) < 1.05 * r:
        thing.add(tube(ring, 0.009, 6, capped=False), stuff)
    for k in range(2):
        wide = between(rng, 0.9, 1.3) * r
        lump = blob(rng, (wide, wide, 0.5 * wide), roughness=0.28, waves=40, subdivisions=3)
        x, y = rng.uniform(-0.25, 0.25, 2) * r
        thing.add(shifted(lump, x, y, h - 0.15 + 0.08 * k), fabric(rng))
    if rng.uniform() < 0.7:
        thing.add(_sleeve(rng, 0.95 * rim, h), fabric(rng))
    return stood(thing)


def _sleeve(rng: np.random.Generator, rim: float, h: float) -> Mesh:
    """A strip of cloth that hangs over the rim, to the front."""
    w, drop = between(rng, 0.1, 0.16), between(rng, 0.12, 0.25)
    u, v = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(0, 1, 14), indexing="ij")
    line = spline([(0, 0.3 * rim, h + 0.0), (0, rim - 0.01, h + 0.03), (0, rim + 0.025, h - 0.01),
        (0, rim + 0.03, h - drop)], 14)  # fmt: skip
    fold = 0.008 * np.cos(6 * u + 2 * v) + 0.006 * ripples(rng, u, v, 5, 1.2)
    x = w / 2 * u * (1 - 0.2 * v)
    far, high = line[:, 1] + fold * v, line[:, 2] + fold * (1 - v)
    return slab(np.stack([x, -far, high], -1)[:, ::-1], 0.004)


def storage_box(rng: np.random.Generator, style: Style) -> Thing:
    """A lidded box of plastic, card, felt or wood, or a wooden crate, m."""
    w, d, h = between(rng, 0.2, 0.45), between(rng, 0.16, 0.34), between(rng, 0.1, 0.28)
    kind = int(rng.integers(3))
    thing = Thing("storage box")
    if kind == 2:
        slats = max(2, int(h / 0.07))
        z = np.linspace(0, h, slats + 1)
        limits = []
        for a, b in zip(z[:-1], z[1:] - 0.012, strict=True):
            limits += [(-w / 2, w / 2, s * d / 2 - 0.005, s * d / 2 + 0.005, a, b) for s in (-1, 1)]
            limits += [(s * (w / 2 - 0.006) - 0.005, s * (w / 2 - 0.006) + 0.005, -d / 2 + 0.0055,
                d / 2 - 0.0055, a, b) for s in (-1, 1)]  # fmt: skip
        limits += [(s * (w / 2 - 0.022) - 0.01, s * (w / 2 - 0.022) + 0.01,
            e * (d / 2 - 0.016) - 0.01, e * (d / 2 - 0.016) + 0.01, 0.0, h - 0.013) for s in (-1,
            1) for e in (-1, 1)]  # fmt: skip
        limits += [(-w / 2 + 0.012, w / 2 - 0.012, -d / 2 + 0.006, d / 2 - 0.006, 0.0005, 0.008)]
        stuff = style.wood if rng.uniform() < 0.4 else toys.WOODEN
        return stood(thing.add(boards(limits, 0.001), stuff))
    stuff = plastic(rng) if kind == 0 else (fabric(rng), style.paint, CARD)[int(rng.integers(3))]
    rings = np.array([(0, 0.92), (h, 1.0)])
    corners_ = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) / 2
    low, high = (np.column_stack([corners_ * [w, d] * f, np.full(4, z)]) for z, f in rings)
    nxt = np.roll(np.arange(4), -1)
    walls = quads([*np.stack([low, low[nxt], high[nxt], high], 1), low[::-1]])
    lid = boards([(-w / 2 - 0.006, w / 2 + 0.006, -d / 2 - 0.006, d / 2 + 0.006, h - 0.025,
        h + 0.006), (-0.4 * w, 0.4 * w, -0.4 * d, 0.4 * d, h + 0.004, h + 0.01)],
        0.004)  # fmt: skip
    thing.add(walls, stuff).add(lid, stuff if rng.uniform() < 0.5 else plastic(rng))
    clasp = [(-w / 2 - 0.01, -w / 2 + 0.006, -0.04, 0.04, h - 0.06, h - 0.01),
        (w / 2 - 0.006, w / 2 + 0.01, -0.04, 0.04, h - 0.06, h - 0.01)]  # fmt: skip
    thing.add(boards(clasp, 0.002), plastic(rng))
    thing.supports.append(Support(-0.38 * w, 0.38 * w, -0.38 * d, 0.38 * d, h + 0.01, 0.25))
    return stood(thing)


def tissue_box(rng: np.random.Generator, style: Style) -> Thing:
    """A box or a cube with a tissue that stands out of its slot, m."""
    w, d, h = (
        (0.115, 0.115, 0.125) if rng.uniform() < 0.4 else (0.23, 0.12, between(rng, 0.06, 0.09))
    )
    tone = hue(float(rng.uniform()), between(rng, 0.2, 0.6), between(rng, 0.2, 0.7))
    pattern = str(rng.choice(["dots", "stripes", "noise", "picture"]))
    thing = Thing("tissue box").add(boards([(-w / 2, w / 2, -d / 2, d / 2, 0, h)], 0.0015),
        Material(tone, (0.8, 0.8, 0.78), pattern, 0.03, specular=0.03))  # fmt: skip
    a = np.linspace(0, 2 * np.pi, 25)[:-1]
    slot = np.column_stack([0.32 * w * np.cos(a), 0.2 * d * np.sin(a), np.full(24, h + 0.0006)])
    fan = np.array([(0, k, k + 1) for k in range(1, 23)], np.int32)
    thing.add(Mesh(slot.astype(np.float32), fan), BLACK)
    u, v = np.meshgrid(np.linspace(-1, 1, 13), np.linspace(0, 1, 9), indexing="ij")
    fold = (0.016 * np.sin(3.5 * u + between(rng, 0, 6)) * (0.4 + v) + 0.006 * ripples(rng, u, v, 6,
        1.6) * v)  # fmt: skip
    x = 0.028 * u * (0.7 + 1.1 * v)
    z = h - 0.006 + v * (0.07 - 0.025 * u**2)
    points = np.stack([x, fold * (0.5 + 0.7 * v), z], -1)
    return thing.add(slab(points, 6e-4), Material((0.84, 0.84, 0.83), specular=0.0))


def bail(r: float, h: float, rise: float, up: bool) -> Mesh:
    """A bucket's wire handle, standing or fallen to the front."""
    a = np.linspace(0, np.pi, 17)
    x, s = r * np.cos(a), rise * np.sin(a)
    path = np.stack([x, 0 * s if up else -0.985 * s, h + (s if up else -0.22 * s)], -1)
    return tube(path, 0.0028, 6)


def bucket(rng: np.random.Generator, style: Style) -> Thing:
    """A pail of zinc or plastic with its bail, now and then with a cloth over its rim, m."""
    r, h = between(rng, 0.12, 0.16), between(rng, 0.22, 0.3)
    stuff = STEEL if rng.uniform() < 0.35 else plastic(rng)
    body = hollow([(0, 0.004), (0.6 * r, 0.004), (0.72 * r, 0), (0.75 * r, 0.02),
        (0.86 * r, 0.55 * h), (r, h)], 0.003, sides=32)  # fmt: skip
    t = np.linspace(0, 2 * np.pi, 33)
    rim = tube(np.stack([r * np.cos(t), r * np.sin(t), h + 0 * t], -1), 0.004, 6, capped=False)
    thing = Thing("bucket").add(joined([body, rim]), stuff)
    hung = rng.uniform() < 0.35
    thing.add(bail(r + 0.004, h - 0.012, r + 0.03, bool(rng.uniform() < 0.4) or hung), STEEL)
    if hung:
        thing.add(_sleeve(rng, 0.98 * r, h), fabric(rng))
    return stood(thing)


def paint_bucket(rng: np.random.Generator, style: Style) -> Thing:
    """A tin of paint, open with drips and a brush across it, or closed, m."""
    r, h = between(rng, 0.05, 0.1), 0.0
    h = r * between(rng, 1.9, 2.3)
    wet = Material(hue(float(rng.uniform()), between(rng, 0.1, 0.8), between(rng, 0.2, 0.8)),
        specular=0.15, gloss=300.0)  # fmt: skip
    profile = [(0, 0.003), (0.94 * r, 0.003), (0.95 * r, 0), (r, 0.002), (r, h - 0.008),
        (1.03 * r, h - 0.006), (1.03 * r, h), (0.9 * r, h), (0.88 * r, h - 0.006)]  # fmt: skip
    thing = Thing("paint bucket")
    thing.add(joined([revolve([*profile, (0.88 * r, 0.7 * h)], 28)]), STEEL)
    label = revolve([(r + 5e-4, 0.12 * h), (r + 5e-4, 0.8 * h)], 28)
    thing.add(label, Material((0.75, 0.75, 0.73), wet.colour, "marks", 0.03, specular=0.04))
    thing.add(bail(r + 0.002, 0.8 * h, r + 0.01, False), STEEL)
    if rng.uniform() < 0.4:
        thing.add(revolve([(0.89 * r, h - 0.003), (0.8 * r, h - 0.002), (0.78 * r, h - 0.006),
            (0, h - 0.006)], 28), STEEL)  # fmt: skip
        return stood(thing)
    thing.add(revolve([(0.879 * r, 0.78 * h), (0, 0.78 * h)], 28), wet)
    drips = [handle([(1.01 * r * np.cos(a), 1.01 * r * np.sin(a), h - 0.004),
        (1.045 * r * np.cos(a), 1.045 * r * np.sin(a), h - 0.01),
        (1.01 * r * np.cos(a), 1.01 * r * np.sin(a), h * f)], [0.004, 0.005, 0.0045], count=6,
        sides=6) for a, f in zip(between(rng, 3.6, 5) + np.array([0, 0.25, 0.6]),
        rng.uniform(0.3, 0.8, 3), strict=True)]  # fmt: skip
    thing.add(joined(drips), wet)
    z = h + 0.006
    brush = boards([(-r - 0.13, -r + 0.02, -0.012, 0.012, z - 0.005, z + 0.006)], 0.004)
    ferrule = boards([(-r + 0.018, -r + 0.055, -0.024, 0.024, z - 0.0065, z + 0.0075)], 0.002)
    hairs = boards([(-r + 0.05, -r + 0.1, -0.022, 0.022, z - 0.005, z + 0.005)], 0.003)
    thing.add(brush, style.wood).add(ferrule, CHROME).add(hairs, wet)
    return stood(thing)


def waste_bin(rng: np.random.Generator, style: Style) -> Thing:
    """A paper basket of wire, a plain bin, or a pedal bin, with something in it, m."""
    kind = int(rng.integers(3))
    thing = Thing("waste bin")
    r, h = between(rng, 0.1, 0.14), between(rng, 0.25, 0.33)
    if kind == 2:
        stuff = STEEL if rng.uniform() < 0.6 else plastic(rng)
        thing.add(turned([(0, 0.01), (0.98 * r, 0.01), (r, 0.02), (r, 0.05), (r, h - 0.01), (r, h),
            (0, h)], 30, 14), stuff)  # fmt: skip
        thing.add(turned([(0, h + 0.001), (1.02 * r, h + 0.001), (1.02 * r, h + 0.018),
            (0.95 * r, h + 0.03), (0.5 * r, h + 0.04), (0, h + 0.042)], 30, 14),
            stuff if rng.uniform() < 0.5 else BLACK)  # fmt: skip
        thing.add(turned([(0, 0), (1.04 * r, 0), (1.04 * r, 0.018), (0, 0.018)], 30, 8), BLACK)
        thing.add(boards([(-0.025, 0.025, -r - 0.035, -r + 0.01, 0.004, 0.012)], 0.003), BLACK)
        return stood(thing)
    if kind == 1:
        body = hollow([(0, 0), (0.7 * r, 0), (0.78 * r, 0.005), (r, h)], 0.003, sides=30)
        thing.add(body, plastic(rng) if rng.uniform() < 0.7 else style.metal)
    else:
        a = np.arange(30) * 2 * np.pi / 30
        low = np.stack([0.78 * r * np.cos(a), 0.78 * r * np.sin(a), 0 * a + 0.003], -1)
        high = np.stack([r * np.cos(a), r * np.sin(a), 0 * a + h], -1)
        t = np.linspace(0, 2 * np.pi, 31)
        rings = [tube(np.stack([q * r * np.cos(t), q * r * np.sin(t), 0 * t + z], -1), 0.0028, 5,
            capped=False) for q,
            z in ((0.78, 0.003), (0.85, h / 3), (0.93, 2 * h / 3), (1.0, h))]  # fmt: skip
        thing.add(joined([rods(low, high, 0.0014, sides=4), *rings,
            shifted(cylinder(0.77 * r, 0.004, sides=24), 0, 0, 0.002)]), style.metal)  # fmt: skip
    for k in range(int(rng.integers(2, 6))):
        size = between(rng, 0.07, 0.1)
        scrap = blob(rng, (size, size, size), roughness=0.3, waves=40, subdivisions=2)
        x, y = rng.uniform(-0.35, 0.35, 2) * r
        z = (0.1, 0.3, 0.45, 0.55, 0.62)[k] * h
        thing.add(shifted(faceted(scrap), x, y, z), Material((0.76, 0.75, 0.7), specular=0.0))
    return stood(thing)


CATALOGUE: dict[str, Maker] = {
    "cardboard_box": cardboard_box,
    "basket": basket,
    "laundry_basket": laundry_basket,
    "storage_box": storage_box,
    "tissue_box": tissue_box,
    "bucket": bucket,
    "paint_bucket": paint_bucket,
    "waste_bin": waste_bin,
}
