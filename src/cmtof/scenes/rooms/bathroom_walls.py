"""What hangs on a bathroom's wall: towels on their rail, a cabinet with mirrors, m."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.cabinetry import (
    CHROME,
    MIRROR,
    WHITE,
    carcass,
)  # fmt: skip
from cmtof.scenes.rooms.joinery import (
    bent,
    boards,
    placed,
    rods,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style, fabric, hue
from cmtof.scenes.rooms.solids import joined, revolve, tube
from cmtof.scenes.rooms.thing import Support, Thing
from cmtof.scenes.rooms.upholstery import towel


def towel_rail(rng: np.random.Generator, style: Style) -> Thing:
    """One bar, two bars or a heated ladder on the wall, with towels over them."""
    kind, w = int(rng.integers(3)), float(rng.uniform(0.45, 0.7))
    thing, x = Thing("towel rail"), w / 2
    metal = CHROME if rng.uniform() < 0.6 else style.metal
    if kind < 2:
        bars = [(0.0, -0.07)] if kind == 0 else [(0.0, -0.12), (-0.06, -0.06)]
        meshes = []
        for z, y in bars:
            line = bent([(-x, -0.004, z), (-x, y, z), (x, y, z), (x, -0.004, z)], 0.02)
            meshes.append(tube(line, 0.008, 8))
            plate = [
                (s * x - 0.022, s * x + 0.022, -0.008, 0, z - 0.022, z + 0.022) for s in (-1, 1)
            ]
            meshes.append(boards(plate))
        thing.add(joined(meshes), metal)
    else:
        h = float(rng.uniform(0.8, 1.4))
        posts = rods(
            [(s * x, -0.07, -h / 2) for s in (-1, 1)],
            [(s * x, -0.07, h / 2) for s in (-1, 1)],
            0.017,
        )
        levels = np.linspace(-h / 2 + 0.04, h / 2 - 0.04, int(h / 0.075))
        keep = np.arange(len(levels)) % 6 != 4
        at = levels[keep]
        rungs = rods([(-x, -0.07, z) for z in at], [(x, -0.07, z) for z in at], 0.011)
        pins = [(s * x, -0.07, t * 0.4 * h) for s in (-1, 1) for t in (-1, 1)]
        arms = rods(pins, np.array(pins) * [1, 0, 1], 0.012)
        thing.add(joined([posts, rungs, arms]), metal)
        bars = [(float(at[-1 - 2 * k]), -0.07) for k in range(2)]
    thick = 0.008 if kind < 2 else 0.011
    for k, (z, y) in enumerate(bars[: 1 + int(rng.integers(len(bars)))]):
        wide = float(rng.uniform(0.3, 0.45)) if w < 0.6 or k else float(rng.uniform(0.3, w - 0.06))
        room = w - wide - 0.05
        cloth_ = towel(
            rng, wide, float(rng.uniform(0.35, 0.6)), float(rng.uniform(0.25, 0.45)), thick
        )
        at3 = (float(rng.uniform(-0.5, 0.5)) * max(room, 0), y, z)
        cover = _terry(rng) if rng.uniform() < 0.7 else fabric(rng)
        thing.add(placed(cloth_, at3), cover, 2)
    return thing


def _terry(rng: np.random.Generator) -> Material:
    """Towelling: white, pastel or dark, with a border now and then."""
    tone = hue(
        float(rng.uniform()), float(rng.uniform(0, 0.6)), float(rng.choice([0.08, 0.35, 0.7]))
    )
    pattern = str(rng.choice(["noise", "weave", "stripes"]))
    other = hue(float(rng.uniform()), 0.4, 0.5)
    scale = 0.006 if pattern != "stripes" else 0.15
    return Material(tone, other if pattern == "stripes" else tone, pattern, scale, 0.0, bump=0.5)


def bathroom_cabinet(rng: np.random.Generator, style: Style) -> Thing:
    """A shallow cabinet on the wall with mirrored doors, a shelf under it or a lamp over it."""
    w, h, d = (
        float(rng.uniform(0.45, 0.9)),
        float(rng.uniform(0.5, 0.75)),
        float(rng.uniform(0.13, 0.18)),
    )
    body = WHITE if rng.uniform() < 0.6 else style.wood
    x, y, z = (-w / 2, w / 2), (-d, 0.0), (-h / 2, h / 2)
    niche = rng.uniform() < 0.35
    low = z[0] + (0.16 if niche else 0.0)
    thing = Thing("bathroom cabinet").add(carcass(x, y, z, 0.016), body)
    count = 1 if w < 0.5 else (3 if w > 0.8 else 2)
    at = np.linspace(*x, count + 1)
    doors = [(a + 0.0015, b - 0.0015, y[0] - 0.016, y[0] - 0.001, low + 0.001, z[1] - 0.001)
             for a, b in pairwise(at)]  # fmt: skip
    glass = [(a + 0.004, b - 0.004, y[0] - 0.019, y[0] - 0.014, low + 0.004, z[1] - 0.004)
             for a, b in pairwise(at)]  # fmt: skip
    thing.add(boards(doors), body).add(boards(glass), MIRROR)
    knobs = [revolve([(0, 0), (0.008, 0), (0.01, 0.018), (0, 0.02)], 12)] * count
    places = [(float(b) - 0.03 if k % 2 == 0 else float(a) + 0.03, y[0] - 0.0185, low + 0.07)
              for k, (a, b) in enumerate(pairwise(at))]  # fmt: skip
    thing.add(
        joined([placed(m, p, lean=np.pi / 2) for m, p in zip(knobs, places, strict=True)]), CHROME
    )
    if niche:
        shelf = (x[0] + 0.015, x[1] - 0.015, y[0] + 0.002, -0.004, low - 0.008, low + 0.004)
        thing.add(boards([shelf]), body)
        thing.supports.append(
            Support(x[0] + 0.04, x[1] - 0.04, y[0] + 0.02, -0.03, z[0] + 0.016, 0.12)
        )
    thing.supports.append(Support(x[0] + 0.03, x[1] - 0.03, y[0] + 0.02, -0.02, z[1], 0.3))
    return thing
