"""What things are kept in behind fronts: cupboards, chests and cabinets, m."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.cabinetry import (
    STEEL,
    Look,
    Maker,
    Span,
    add_fronts,
    carcass,
    footing,
    handle,
    look,
    timber,
)  # fmt: skip
from cmtof.scenes.rooms.joinery import boards, frame
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.shelves import Fronts, bookshelf, metal_rack, pair, shelved, shoe_rack
from cmtof.scenes.rooms.solids import joined
from cmtof.scenes.rooms.thing import Support, Thing


def case(
    rng: np.random.Generator,
    style: Style,
    kind: str,
    size: tuple[float, float, float],
    foot: float,
    material: Material,
) -> tuple[Thing, Span, Span, Span]:
    """An empty cabinet of width, depth, height on its feet; spans left for fronts, m."""
    w, d, h = size
    x, y = (-w / 2, w / 2), (-d / 2 + 0.025, d / 2)
    thing = Thing(kind).add(carcass(x, y, (foot, h), 0.02, overhang=0.012), material)
    thing.add(footing(rng, x, y, foot, style.modern < 0.5), material, 2)
    thing.supports.append(Support(x[0] + 0.03, x[1] - 0.03, y[0] + 0.03, y[1] - 0.03, h, 0.8))
    return thing, (x[0] + 0.001, x[1] - 0.001), y, (foot + 0.002, h - 0.021)


def two_tone(rng: np.random.Generator, style: Style, material: Material) -> Look:
    """Fronts like the body, or painted, or of the other wood."""
    other = (material, material, style.paint, style.second_wood)[int(rng.integers(4))]
    return look(rng, style, other)


def cupboard(rng: np.random.Generator, style: Style) -> Thing:
    """A cupboard: doors all the way, or drawers below doors."""
    size = (
        float(rng.uniform(0.7, 1.2)),
        float(rng.uniform(0.36, 0.5)),
        float(rng.uniform(1.2, 1.9)),
    )
    material, foot = timber(rng, style), float(rng.uniform(0.05, 0.14))
    thing, x, y, z = case(rng, style, "cupboard", size, foot, material)
    cut = z[0] + (0.0 if rng.uniform() < 0.4 else float(rng.uniform(0.16, 0.45)))
    fronts = pair(*x, (cut, z[1]))
    if cut > z[0]:
        rows = np.linspace(z[0], cut, 2 if cut - z[0] < 0.25 else 3)
        fronts += [("drawer", x, (a, b)) for a, b in pairwise(rows)]
    return add_fronts(thing, fronts, y[0], two_tone(rng, style, material))


def wardrobe(rng: np.random.Generator, style: Style) -> Thing:
    """Two to four tall doors, one perhaps a mirror, over drawers or not, with a cornice."""
    count = int(rng.integers(2, 5))
    w, h = count * float(rng.uniform(0.42, 0.52)), float(rng.uniform(1.85, 2.3))
    material, d = timber(rng, style), float(rng.uniform(0.55, 0.64))
    thing, x, y, z = case(
        rng, style, "wardrobe", (w, d, h), float(rng.uniform(0.05, 0.1)), material
    )
    made = two_tone(rng, style, material)
    cut = z[0] + (float(rng.uniform(0.2, 0.4)) if rng.uniform() < 0.35 else 0.0)
    at = np.linspace(*x, count + 1)
    fronts: Fronts = [("left" if k % 2 == 0 else "right", (a, b), (cut, z[1]))
                      for k, (a, b) in enumerate(pairwise(at))]  # fmt: skip
    if cut > z[0]:
        step = np.linspace(*x, max(count // 2, 1) + 1)
        fronts += [("drawer", (a, b), (z[0], cut)) for a, b in pairwise(step)]
    add_fronts(thing, fronts, y[0], made)
    if rng.uniform() < 0.3:
        from cmtof.scenes.rooms.cabinetry import MIRROR

        k = int(rng.integers(count))
        deep = y[0] - (0.028 if made.panel in ("raised", "laths") else 0.0225)
        glass = (
            at[k] + 0.075,
            at[k + 1] - 0.075,
            deep - 0.004,
            deep + 0.004,
            cut + 0.1,
            z[1] - 0.08,
        )
        thing.add(boards([glass]), MIRROR)
    if style.modern < 0.4:
        x0, x1 = x[0] - 0.04, x[1] + 0.04
        crown = [(x0, x1, y[0] - 0.045, y[1], h - 0.001, h + 0.03),
                 (x0 + 0.015, x1 - 0.015, y[0] - 0.03, y[1], h - 0.05, h)]  # fmt: skip
        thing.add(boards(crown, 0.008), material)
        thing.supports[0] = thing.supports[0]._replace(z=h + 0.03)
    return thing


def chest_of_drawers(rng: np.random.Generator, style: Style) -> Thing:
    """Three to six rows of drawers, the upper ones in halves; now and then one left ajar."""
    rows = int(rng.integers(3, 7))
    size = (float(rng.uniform(0.55, 1.2)), float(rng.uniform(0.4, 0.5)),
            float(np.clip(rows * rng.uniform(0.17, 0.24) + 0.1, 0.6, 1.3)))  # fmt: skip
    material = timber(rng, style)
    thing, x, y, z = case(
        rng, style, "chest of drawers", size, float(rng.uniform(0.04, 0.16)), material
    )
    share = np.linspace(1.3, 0.8, rows)
    at = z[0] + (z[1] - z[0]) * np.concatenate([[0], np.cumsum(share / share.sum())])
    fronts: Fronts = []
    for k, (low, high) in enumerate(pairwise(at)):
        halves = size[0] > 0.75 and (k == rows - 1 or (k == rows - 2 and size[0] > 1.0))
        cuts = np.linspace(*x, 3 if halves else 2)
        fronts += [("drawer", (a, b), (low, high)) for a, b in pairwise(cuts)]
    made = two_tone(rng, style, material)
    ajar = int(rng.integers(len(fronts))) if rng.uniform() < 0.25 else -1
    add_fronts(thing, [f for k, f in enumerate(fronts) if k != ajar], y[0], made)
    if ajar >= 0:
        pulled, (a, b), (low, high) = float(rng.uniform(0.03, 0.12)), *fronts[ajar][1:]
        add_fronts(thing, [fronts[ajar]], y[0] - pulled, made)
        side = [(p, p + 0.012, y[0] - pulled - 0.001, y[0] + 0.03, low + 0.02, high - 0.03)
                for p in (a + 0.015, b - 0.027)]  # fmt: skip
        floor = (a + 0.02, b - 0.02, y[0] - pulled - 0.001, y[0] + 0.03, low + 0.03, low + 0.04)
        thing.add(boards([*side, floor], 0), style.second_wood)
    return thing


def sideboard(rng: np.random.Generator, style: Style) -> Thing:
    """Long and waist-high: doors beside a stack of drawers, or a niche."""
    w, h = float(rng.uniform(1.2, 2.0)), float(rng.uniform(0.7, 0.9))
    material, foot = timber(rng, style), float(rng.uniform(0.06, 0.2))
    thing, x, y, z = case(
        rng, style, "sideboard", (w, float(rng.uniform(0.38, 0.48)), h), foot, material
    )
    return _bays(rng, thing, x, y, z, two_tone(rng, style, material), material)


def tv_stand(rng: np.random.Generator, style: Style) -> Thing:
    """Long and low, with niches for boxes."""
    w, h = float(rng.uniform(1.1, 1.9)), float(rng.uniform(0.38, 0.55))
    material, foot = timber(rng, style), float(rng.uniform(0.04, 0.14))
    thing, x, y, z = case(
        rng, style, "tv stand", (w, float(rng.uniform(0.36, 0.45)), h), foot, material
    )
    return _bays(rng, thing, x, y, z, two_tone(rng, style, material), material, niche=True)


def _bays(
    rng: np.random.Generator,
    thing: Thing,
    x: Span,
    y: Span,
    z: Span,
    made: Look,
    material: Material,
    *,
    niche: bool = False,
) -> Thing:
    """Fill a long cabinet with bays of doors, drawers and niches between partitions."""
    count = int(rng.integers(2, 5)) if x[1] - x[0] > 1.4 else int(rng.integers(2, 4))
    share = rng.uniform(0.8, 1.3, count)
    at = x[0] + (x[1] - x[0]) * np.concatenate([[0], np.cumsum(share / share.sum())])
    walls = [(a - 0.009, a + 0.009, y[0] + 0.001, y[1] - 0.008, z[0] + 0.017, z[1] + 0.002)
             for a in at[1:-1]]  # fmt: skip
    thing.add(boards(walls, 0), material, 2)
    kinds = [str(k) for k in rng.choice(["doors", "drawers", "niche"], count, p=[0.45, 0.3, 0.25])]
    if niche:
        kinds[count // 2] = "niche"
    fronts: Fronts = []
    for kind, (a, b) in zip(kinds, pairwise(at), strict=True):
        if kind == "doors":
            fronts += pair(a, b, z)
        elif kind == "drawers":
            rows = np.linspace(*z, 2 + int((z[1] - z[0]) / 0.25))
            fronts += [("drawer", (a, b), (low, high)) for low, high in pairwise(rows)]
        else:
            levels = np.linspace(z[0] - 0.002, z[1] + 0.001, 2 + int(rng.integers(0, 2)))
            shelved(thing, (a + 0.02, b - 0.02), y, levels, 0.02, material)
    return add_fronts(thing, fronts, y[0], made) if fronts else thing


def display_cabinet(rng: np.random.Generator, style: Style) -> Thing:
    """A cabinet with framed doors whose glass is left out, shelves for china, doors below."""
    w, h = float(rng.uniform(0.75, 1.2)), float(rng.uniform(1.6, 2.1))
    material, foot = timber(rng, style), float(rng.uniform(0.05, 0.12))
    thing, x, y, z = case(
        rng, style, "display cabinet", (w, float(rng.uniform(0.36, 0.45)), h), foot, material
    )
    cut = z[0] + float(rng.uniform(0.4, 0.75))
    made = look(rng, style, material)
    middle = (x[0] + x[1]) / 2
    fronts: Fronts = [*pair(*x, (z[0], cut)), ("glass-left", (x[0], middle), (cut, z[1])),
                      ("glass-right", (middle, x[1]), (cut, z[1]))]  # fmt: skip
    add_fronts(thing, fronts, y[0], made)
    levels = np.linspace(cut - 0.01, z[1] + 0.001, int(rng.integers(3, 5)) + 1)
    inner = (x[0] + 0.019, x[1] - 0.019)
    thing.add(boards([(*inner, y[0] + 0.002, y[1] - 0.008, cut - 0.01, cut + 0.008)]), material)
    shelved(thing, inner, (y[0] + 0.015, y[1]), levels, 0.018, material)
    if rng.uniform() < 0.6:
        z0, z1 = cut + 0.06, z[1] - 0.06
        bars = [(m - 0.008, m + 0.008, y[0] - 0.014, y[0] - 0.006, z0, z1)
                for m in ((x[0] + middle) / 2, (middle + x[1]) / 2)]  # fmt: skip
        bars += [(a + 0.06, b - 0.06, y[0] - 0.013, y[0] - 0.007, q - 0.008, q + 0.008)
                 for a, b in ((x[0], middle), (middle, x[1]))
                 for q in np.linspace(z0, z1, 4)[1:-1]]  # fmt: skip
        thing.add(boards(bars), material)
    return thing


def filing_cabinet(rng: np.random.Generator, style: Style) -> Thing:
    """Sheet steel, two to four deep drawers with label holders."""
    n, w = int(rng.integers(2, 5)), float(rng.uniform(0.4, 0.48))
    grey = float(rng.choice([0.05, 0.3, 0.5, 0.75]))
    paint = Material((grey, grey, 0.97 * grey), specular=0.1, gloss=60.0)
    h = 0.31 * n + 0.05
    thing = Thing("filing cabinet")
    x, y = (-w / 2, w / 2), (-0.29, 0.31)
    thing.add(boards([(*x, y[0], y[1], 0.03, h), (x[0] + 0.01, x[1] - 0.01, -0.26, 0.3, 0,
        0.031)], 0.004),
              paint)  # fmt: skip
    cut = np.linspace(0.045, h - 0.012, n + 1)
    edge = (x[0] + 0.012, x[1] - 0.012)
    rows = [(*edge, y[0] - 0.016, y[0] - 0.001, a + 0.003, b - 0.003) for a, b in pairwise(cut)]
    thing.add(boards(rows, 0.004), paint)
    face = y[0] - 0.016
    pulls = [handle("bow", (0, face, b - 0.11), 0.13, upright=False) for b in cut[1:]]
    label = [m for b in cut[1:] for m in (frame((-0.04, 0.04), (face - 0.003, face + 0.001),
             (b - 0.075, b - 0.035), 0.004),)]  # fmt: skip
    thing.add(joined([*pulls, *label]), STEEL)
    paper = [(-0.036, 0.036, face - 0.0015, face + 0.001, b - 0.071, b - 0.039) for b in cut[1:]]
    thing.add(
        boards(paper, 0), Material((0.75, 0.74, 0.7), (0.05, 0.05, 0.06), "marks", 0.008, 0.0)
    )
    thing.supports.append(Support(x[0] + 0.02, x[1] - 0.02, y[0] + 0.02, y[1] - 0.02, h, 0.8))
    return thing


def toy_chest(rng: np.random.Generator, style: Style) -> Thing:
    """A box with a lid, closed or held open by a hand's width."""
    w, d, h = (
        float(rng.uniform(0.6, 0.95)),
        float(rng.uniform(0.38, 0.48)),
        float(rng.uniform(0.4, 0.52)),
    )
    material = timber(rng, style)
    other = style.accent if rng.uniform() < 0.4 else material
    x, y, t = (-w / 2, w / 2), (-d / 2, d / 2), 0.02
    walls = [(*x, y[0], y[0] + t, 0.03, h - t), (*x, y[1] - t, y[1], 0.03, h - t),
             (x[0], x[0] + t, y[0] + t, y[1] - t, 0.03, h - t),
             (x[1] - t, x[1], y[0] + t, y[1] - t, 0.03, h - t),
             (x[0] + t, x[1] - t, y[0] + t, y[1] - t, 0.03, 0.045)]  # fmt: skip
    thing = Thing("toy chest").add(boards(walls), material)
    feet = [(s * (w / 2 - 0.05) - 0.03, s * (w / 2 - 0.05) + 0.03, *y, 0, 0.031) for s in (-1, 1)]
    battens = [(p - 0.035, p + 0.035, y[0] - 0.012, y[0] + 0.001, 0.05, h - 0.05)
               for p in (x[0] + 0.06, x[1] - 0.06)]  # fmt: skip
    thing.add(boards([*feet, *battens]), other, 2)
    lid = boards([(x[0] - 0.01, x[1] + 0.01, -d - 0.015, 0, 0.0, t)], 0.004)
    from cmtof.scenes.rooms.joinery import placed

    lift = float(rng.uniform(0.15, 0.5)) if rng.uniform() < 0.25 else 0.0
    thing.add(placed(lid, (0, y[1], h - t + 0.0006), lean=-lift), other)
    if lift == 0:
        thing.supports.append(Support(x[0] + 0.04, x[1] - 0.04, y[0] + 0.03, y[1] - 0.03, h, 0.8))
    return thing


CATALOGUE: dict[str, Maker] = {
    "bookshelf": bookshelf,
    "cupboard": cupboard,
    "wardrobe": wardrobe,
    "chest_of_drawers": chest_of_drawers,
    "sideboard": sideboard,
    "tv_stand": tv_stand,
    "display_cabinet": display_cabinet,
    "shoe_rack": shoe_rack,
    "filing_cabinet": filing_cabinet,
    "metal_rack": metal_rack,
    "toy_chest": toy_chest,
}
