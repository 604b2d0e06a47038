"""Tables to work at: desks and workbenches, m."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.cabinetry import (
    STEEL,
    Look,
    Maker,
    add_fronts,
    carcass,
    look,
    timber,
)  # fmt: skip
from cmtof.scenes.rooms.joinery import (
    beams,
    boards,
    corners,
    raised,
    rods,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.solids import joined
from cmtof.scenes.rooms.tables import four_legs, slab, sled, top_support
from cmtof.scenes.rooms.thing import Support, Thing


def desk(rng: np.random.Generator, style: Style) -> Thing:
    """A writing desk: with pedestals of drawers, with one flat drawer, or on steel legs."""
    width, depth = float(rng.uniform(1.1, 1.7)), float(rng.uniform(0.55, 0.8))
    height, kind = float(rng.uniform(0.72, 0.76)), int(rng.integers(4))
    material = timber(rng, style)
    thing = Thing("desk").add(slab(width, depth, height, 0.028, "square"), material)
    half, under = (width / 2, depth / 2), height - 0.027
    made = look(rng, style, material if rng.uniform() < 0.6 else style.paint)
    if kind == 0:
        thing.add(sled(half, under), style.metal)
    elif kind == 1:
        legs, _ = four_legs(rng, "splayed", half, under)
        thing.add(legs, material, 2)
        x, y = half[0] - 0.16, (-half[1] + 0.06, half[1] - 0.1)
        thing.add(carcass((-x, x), y, (under - 0.11, under)), material)
        n = 2 if width > 1.3 else 1
        edges = np.linspace(-x + 0.018, x - 0.018, n + 1)
        fronts = [("drawer", (a, b), (under - 0.092, under - 0.018))
                  for a, b in pairwise(edges)]  # fmt: skip
        add_fronts(thing, fronts, y[0], made)
    else:
        sides = (-1, 1) if kind == 2 and width > 1.4 else (float(rng.choice([-1, 1])),)
        for side in sides:
            _pedestal_of_drawers(thing, side * (half[0] - 0.22), half[1], under, made)
        panel = half[1] - 0.05
        back = (-half[0] + 0.03, half[0] - 0.03, panel - 0.009, panel + 0.009, 0.3, under)
        thing.add(boards([back]), material)
        if len(sides) == 1:
            x = -sides[0] * (half[0] - 0.05)
            place = np.array([(x, -half[1] + 0.06, 0), (x, half[1] - 0.085, 0)])
            thing.add(beams(place, raised(place, under), 0.05, 0.05), material, 2)
    thing.supports.append(top_support(width, depth, height, "square"))
    return thing


def _pedestal_of_drawers(thing: Thing, x: float, back: float, under: float, made: Look) -> None:
    """Three drawers under a desk."""
    sides, y = (x - 0.19, x + 0.19), (-back + 0.05, back - 0.065)
    plinth = (sides[0] + 0.01, sides[1] - 0.01, y[0] + 0.03, y[1] - 0.01, 0.0, 0.062)
    body = joined([carcass(sides, y, (0.06, under)), boards([plinth], 0)])
    thing.add(body, made.material)
    split = under * np.array([0.085, 0.5, 0.76, 0.995])
    fronts = [("drawer", sides, (a, b)) for a, b in pairwise(split)]
    add_fronts(thing, fronts, y[0], made)


def workbench(rng: np.random.Generator, style: Style) -> Thing:
    """A joiner's bench: thick top, stout legs, a shelf, a vice, sometimes a pegboard's rail."""
    width, depth = float(rng.uniform(1.2, 1.9)), float(rng.uniform(0.55, 0.75))
    height, material = float(rng.uniform(0.82, 0.92)), style.second_wood
    half, thick = (width / 2, depth / 2), float(rng.uniform(0.04, 0.08))
    under = height - thick + 0.001
    thing = Thing("workbench")
    thing.add(boards([(-half[0], half[0], -half[1], half[1], height - thick, height)], 0.004),
              material)  # fmt: skip
    steel = rng.uniform() < 0.3
    size, base = (0.045, style.metal) if steel else (0.085, material)
    place = corners(half[0] - 0.15, half[1] - 0.07)
    x, y = half[0] - 0.15, half[1] - 0.07
    bars = beams([(-x, s * y, z) for s in (-1, 1) for z in (0.16, under - 0.06)],
                 [(x, s * y, z) for s in (-1, 1) for z in (0.16, under - 0.06)],
                 0.4 * size, 0.09)  # fmt: skip
    ends = beams([(s * x, -y, z) for s in (-1, 1) for z in (0.162, under - 0.062)],
                 [(s * x, y, z) for s in (-1, 1) for z in (0.162, under - 0.062)],
                 0.4 * size, 0.088)  # fmt: skip
    thing.add(beams(place, raised(place, under), size, size, chamfer=0.004), base, 2)
    thing.add(joined([bars, ends]), base)
    edges = np.linspace(-y - 0.02, y + 0.02, 5)
    laths = [(-x + 0.05, x - 0.05, a + 0.006, b - 0.006, 0.206, 0.224)
             for a, b in pairwise(edges)]  # fmt: skip
    under_laths = (-x + 0.052, x - 0.052, -y - 0.015, y + 0.015, 0.207, 0.221)
    thing.add(boards([*laths, under_laths]), material)
    _vice(thing, float(rng.choice([-1, 1])) * 0.6 * half[0], half[1], height, material)
    thing.supports.append(top_support(width, depth, height, "square"))
    free = under - 0.12 - 0.224
    thing.supports.append(Support(0.1 - x, x - 0.1, 0.03 - y, y - 0.03, 0.224, free))
    return thing


def _vice(thing: Thing, x: float, front: float, height: float, material: Material) -> None:
    """A wooden jaw on a steel screw with its handle."""
    jaw = (x - 0.16, x + 0.16, -front - 0.09, -front - 0.045, height - 0.13, height - 0.003)
    thing.add(boards([jaw], 0.005), material)
    z = height - 0.08
    screw = rods([(x, -front - 0.2, z), (x - 0.1, -front - 0.06, z), (x + 0.1, -front - 0.06, z)],
                 [(x, -front + 0.05, z), (x - 0.1, -front + 0.05, z), (x + 0.1, -front + 0.05, z)],
                 0.013)  # fmt: skip
    bar = rods(
        [(x - 0.05, -front - 0.185, z + 0.11)], [(x + 0.05, -front - 0.185, z - 0.11)], 0.007
    )
    thing.add(joined([screw, bar]), STEEL)


CATALOGUE: dict[str, Maker] = {"desk": desk, "workbench": workbench}
