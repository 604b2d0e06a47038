"""Tables: for dining, coffee, writing, work, halls and bedsides, m."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.cabinetry import (
    Maker,
    add_fronts,
    carcass,
    footing,
    look,
    timber,
    turned_leg,
)  # fmt: skip
from cmtof.scenes.rooms.joinery import (
    beams,
    bent,
    boards,
    copies,
    corners,
    placed,
    plank,
    raised,
    rods,
    rounded,
    shifted,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.solids import joined, revolve, tube
from cmtof.scenes.rooms.thing import Mesh, Support, Thing
from cmtof.scenes.rooms.upholstery import covering, loft


def slab(width: float, depth: float, height: float, thickness: float, shape: str) -> Mesh:
    """A table top whose upper face is at ``height``: square, rounded, oval or round, m."""
    t, e = thickness, min(0.004, thickness / 4)
    profile = [(0.9 * depth, height - t), (e, height - t), (e, height - t), (0, height - t + e),
               (0, height - e), (e, height), (e, height), (0.9 * depth, height)]  # fmt: skip
    if shape in ("round", "oval"):
        rows = [(0.0 if i > 0.5 * depth else 0.5 - i / depth, h) for i, h in profile]
        disc = revolve(np.array(rows), 48)
        return Mesh((disc.vertices * [width, depth, 1]).astype(np.float32), disc.faces)
    profile[0], profile[-1] = (depth / 2, height - t), (depth / 2, height)
    radius = 0.006 if shape == "square" else 0.06
    return loft(width, depth, radius, profile, corner=2 if shape == "square" else 6)


def top_support(width: float, depth: float, height: float, shape: str) -> Support:
    """The rectangle inside a table top."""
    share = 0.35 if shape in ("round", "oval") else 0.47
    return Support(
        -share * width, share * width, -share * depth, share * depth, height, clearance=0.9
    )


def four_legs(
    rng: np.random.Generator, kind: str, half: tuple[float, float], height: float
) -> tuple[Mesh, bool]:
    """Four legs up to a height, and whether they are joined by an apron."""
    x, y = half
    if kind == "turned":
        leg = turned_leg(rng, height, float(rng.uniform(0.03, 0.045)))
        return copies(leg, corners(x - 0.06, y - 0.06)), True
    if kind == "splayed":
        top = corners(x - 0.16, y - 0.14, height)
        return rods(corners(x - 0.07, y - 0.07), top, 0.022, taper=0.6, sides=12), False
    size = float(rng.uniform(0.045, 0.085))
    place = corners(x - size / 2 - 0.02, y - size / 2 - 0.02)
    taper = float(rng.choice([1.0, 0.6]))
    return beams(place, raised(place, height), size, size, taper=taper, chamfer=0.003), True


def _apron(half: tuple[float, float], inset: float, z: tuple[float, float]) -> Mesh:
    """Four boards under a top."""
    x, y, t = half[0] - inset, half[1] - inset, 0.011
    return boards(
        [
            (-x, x, -y - t, -y + t, *z),
            (-x, x, y - t, y + t, *z),
            (-x - t, -x + t, -y + t, y - t, *z),
            (x - t, x + t, -y + t, y - t, *z),
        ]
    )


def _trestle(half: tuple[float, float], height: float) -> Mesh:
    """Two X or A frames and a stretcher."""
    x, y = 0.72 * half[0], 0.78 * half[1]
    starts = [(s * x, t * y, 0.02) for s in (-1, 1) for t in (-1, 1)]
    ends = [(s * x, -0.55 * t * y, height) for s in (-1, 1) for t in (-1, 1)]
    feet = [(s * x - 0.035, s * x + 0.035, -y - 0.06, y + 0.06, 0, 0.045) for s in (-1, 1)]
    heads = [(s * x - 0.03, s * x + 0.03, -y, y, height - 0.05, height + 0.001) for s in (-1, 1)]
    bar = (-x, x, -0.02, 0.02, 0.30 * height, 0.30 * height + 0.09)
    ends = np.array(ends) + np.array([[0.012], [-0.012], [0.012], [-0.012]]) * [1, 0, 0]
    return joined([beams(starts, ends, 0.05, 0.07), boards([*feet, *heads, bar], 0.004)])


def _pedestal(rng: np.random.Generator, reach: float, height: float) -> Mesh:
    """One turned column on three or four feet, or on a disc like a tulip, for a top's reach, m."""
    slim = float(np.clip(reach / 0.45, 0.5, 1.1))
    if rng.uniform() < 0.5:
        r, c = 0.62 * reach, 0.042 * slim
        foot = [(0, 0), (r, 0), (r, 0), (r, 0.008)]
        stem = rounded([(r, 0.008), (0.5 * r, 0.025), (1.3 * c, 0.06), (c, 0.3), (c, 0.6),
                        (1.3 * c, 0.9), (0.35 * r, 0.995)])  # fmt: skip
        rows = np.concatenate([foot, stem, [(0, 0.995)]])
        return revolve(rows * [1, height], 28)
    lathe = rounded([(0.05, 0.12), (0.07, 0.2), (0.065, 0.28), (0.035, 0.32), (0.085, 0.42),
                     (0.06, 0.6), (0.035, 0.85), (0.06, 0.93), (0.1, 0.96)])  # fmt: skip
    rows = np.concatenate([[(0, 0.12)], lathe, [(0.1, 1.0), (0, 1.0)]]) * [slim, height]
    count = int(rng.integers(3, 5))
    curve = rounded([(0.03, 0, 0.24 * height), (0.4 * reach, 0, 0.2 * height),
                     (0.6 * reach, 0, 0.03), (0.95 * reach, 0, 0.0165)])  # fmt: skip
    foot = plank(curve, (0, 0.05 * slim, 0), 0.033)
    lift = [0, 0, -float(foot.vertices[:, 2].min())]
    feet = [placed(foot, lift, turn=k * 2 * np.pi / count + 0.78) for k in range(count)]
    return joined([revolve(rows, 18), *feet])


def sled(half: tuple[float, float], height: float) -> Mesh:
    """Two closed frames of flat steel, one at each end."""
    x, y = half[0] - 0.12, half[1] - 0.05
    ring = bent([(0, -y, 0.017), (0, y, 0.017), (0, y, height - 0.012), (0, -y, height - 0.012)],
                0.004, steps=2, closed=True)  # fmt: skip
    bar = tube(ring, 0.017, 4, capped=False)
    return copies(bar, [(-x, 0, 0.0), (x, 0, 0.0)])


def dining_table(rng: np.random.Generator, style: Style, *, length: float | None = None) -> Thing:
    """A table for four to ten: legs with an apron, trestles, pedestal, hairpins or sleds."""
    length = float(rng.uniform(1.2, 2.2)) if length is None else length
    depth = float(np.clip(rng.uniform(0.75, 1.0), 0.6, length))
    height, thick = float(rng.uniform(0.72, 0.77)), float(rng.uniform(0.022, 0.045))
    shape = str(rng.choice(["square", "square", "square", "rounded", "oval"]))
    if length < 1.35 and rng.uniform() < 0.5:
        shape, depth = "round", length
    material = timber(rng, style)
    thing = Thing("dining table").add(slab(length, depth, height, thick, shape), material)
    half, under = (length / 2, depth / 2), height - thick + 0.001
    base = style.metal if rng.uniform() < 0.3 else material
    if shape in ("round", "oval"):
        thing.add(*_pedestal_for(rng, length, depth, under, base))
    else:
        kind = str(rng.choice(["square", "square", "turned", "splayed", "trestle", "sled"]))
        _stand(thing, rng, kind, half, under, material, style.metal)
    thing.supports.append(top_support(length, depth, height, shape))
    if rng.uniform() < 0.2 and shape in ("square", "rounded"):
        x, y = (-half[0], half[0]), (-half[1], half[1])
        drop = float(rng.uniform(0.15, 0.3))
        hang = (drop, drop, drop, drop)
        thing.add(covering(rng, x, y, height, hang, thickness=0.002, puff=0.0015), style.fabric)
    return thing


def _pedestal_for(
    rng: np.random.Generator, length: float, depth: float, under: float, material: Material
) -> tuple[Mesh, Material, int]:
    """One column under a round top, two under a long oval."""
    column = _pedestal(rng, depth / 2, under)
    if length > 1.6:
        column = copies(column, [(-0.22 * length, 0, 0), (0.22 * length, 0, 0)])
    return column, material, 2


def _stand(
    thing: Thing,
    rng: np.random.Generator,
    kind: str,
    half: tuple[float, float],
    under: float,
    material: Material,
    metal: Material,
) -> None:
    """Put four-cornered supports of one kind under a top."""
    if kind == "trestle":
        thing.add(_trestle(half, under), material, 2)
    elif kind == "sled":
        thing.add(sled(half, under), metal)
    else:
        legs, apron = four_legs(rng, kind, half, under)
        thing.add(legs, material, 2)
        deep = float(rng.uniform(0.06, 0.1))
        inset = 0.055 if apron else 0.16
        thing.add(_apron(half, inset, (under - deep, under)), material)


def coffee_table(rng: np.random.Generator, style: Style) -> Thing:
    """A low table: box frame with a shelf, round on three legs, drum, hairpins, nested blocks."""
    height, kind = float(rng.uniform(0.36, 0.48)), int(rng.integers(5))
    material = timber(rng, style)
    thing = Thing("coffee table")
    if kind in (1, 2):
        width = float(rng.uniform(0.6, 0.95))
        thing.add(slab(width, width, height, 0.025, "round"), material)
        if kind == 1:
            turn = np.arange(3) * 2 * np.pi / 3
            ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
            low, high = 0.42 * width * ring, 0.28 * width * ring + [0, 0, height - 0.024]
            thing.add(rods(low, high, 0.019, taper=0.6, sides=12), material, 2)
        else:
            thing.add(_wire_drum(0.42 * width, height - 0.024), style.metal)
        thing.supports.append(top_support(width, width, height, "round"))
        return thing
    width, depth = float(rng.uniform(0.9, 1.3)), float(rng.uniform(0.5, 0.7))
    half, under = (width / 2, depth / 2), height - 0.029
    thing.add(slab(width, depth, height, 0.03, str(rng.choice(["square", "rounded"]))), material)
    if kind == 4:
        thing.add(_hairpins(half, under), style.metal)
    else:
        legs, _ = four_legs(rng, "turned" if kind == 3 else "square", half, under)
        thing.add(legs, material, 2).add(_apron(half, 0.05, (under - 0.06, under)), material)
        shelf = 0.3 * height
        x, y = half[0] - 0.03, half[1] - 0.03
        thing.add(boards([(-x, x, -y, y, shelf - 0.018, shelf)]), material)
        free = under - 0.06 - shelf
        thing.supports.append(Support(0.15 - x, x - 0.15, 0.1 - y, y - 0.1, shelf, free))
    thing.supports.insert(0, top_support(width, depth, height, "square"))
    return thing


def _wire_drum(radius: float, height: float) -> Mesh:
    """A basket of steel wires under a round top."""
    turn = np.arange(20) * np.pi / 10
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
    wires = rods(0.75 * radius * ring, radius * ring + [0, 0, height], 0.003, sides=6)
    loop = np.concatenate([ring, ring[:1]])
    hoops = [tube(loop * r + [0, 0, z], 0.005, 6) for r, z in ((0.75 * radius, 0.005),
             (radius, height - 0.004))]  # fmt: skip
    return joined([wires, *hoops])


def _hairpins(half: tuple[float, float], height: float) -> Mesh:
    """Bent steel rods, two to a leg."""
    foot = corners(half[0] - 0.05, half[1] - 0.05, 0.006)
    pins = []
    for x, y, z in foot:
        sx, sy = np.sign(x), np.sign(y)
        line = [(x - 0.11 * sx, y, height), (x, y, z), (x, y - 0.11 * sy, height)]
        pins.append(tube(bent(line, 0.02), 0.005, 6))
    whole = joined(pins)
    return shifted(whole, 0, 0, -float(whole.vertices[:, 2].min()))


def side_table(rng: np.random.Generator, style: Style) -> Thing:
    """A small table beside a sofa: round on a column, C of steel, tray on crossed legs, cube."""
    height, size = float(rng.uniform(0.45, 0.65)), float(rng.uniform(0.35, 0.5))
    material, kind = timber(rng, style), int(rng.integers(5))
    thing = Thing("side table")
    if kind < 2:
        thing.add(slab(size, size, height, 0.02, "round"), material)
        column = _pedestal(rng, 0.9 * size / 2, height - 0.019)
        thing.add(column, style.metal if rng.uniform() < 0.4 else material, 2)
        thing.supports.append(top_support(size, size, height, "round"))
        return thing
    half, under = (size / 2, size / 2), height - 0.021
    thing.add(slab(size, size, height, 0.022, "rounded" if kind == 2 else "square"), material)
    if kind == 2:
        x, y = 0.42 * size, 0.4 * size
        line = [(x, -y, under), (x, -y, 0.011), (-x, -y, 0.011), (-x, y, 0.011), (x, y, 0.011),
                (x, y, under)]  # fmt: skip
        thing.add(tube(bent(line, 0.03), 0.01, 8), style.metal)
    elif kind == 3:
        legs, _ = four_legs(rng, "splayed" if size > 0.45 else "square", half, under)
        thing.add(legs, material, 2).add(_apron(half, 0.06, (under - 0.05, under)), material)
    else:
        x = (-half[0] + 0.005, half[0] - 0.005)
        thing.add(carcass(x, x, (0.0, height - 0.02), back=False), material)
        thing.supports.append(Support(x[0] + 0.04, x[1] - 0.04, x[0] + 0.04, x[1] - 0.04, 0.018,
                                      height - 0.06))  # fmt: skip
    thing.supports.insert(0, top_support(size, size, height, "square"))
    return thing


def console_table(rng: np.random.Generator, style: Style) -> Thing:
    """A narrow table along a hall's wall, with drawers or with a low shelf."""
    width, depth = float(rng.uniform(0.8, 1.4)), float(rng.uniform(0.28, 0.4))
    height, material = float(rng.uniform(0.75, 0.9)), timber(rng, style)
    half, under = (width / 2, depth / 2), height - 0.024
    thing = Thing("console table").add(slab(width, depth, height, 0.025, "square"), material)
    kind = int(rng.integers(3))
    thing.supports.append(top_support(width, depth, height, "square"))
    if kind == 0:
        thing.add(sled(half, under), style.metal)
        return thing
    legs, _ = four_legs(rng, "turned" if kind == 1 else "square", half, under)
    thing.add(legs, material, 2)
    x, y = half[0] - 0.05, half[1] - 0.045
    thing.add(carcass((-x, x), (-y, y), (under - 0.13, under)), material)
    split = np.linspace(-x + 0.02, x - 0.02, 1 + int(rng.integers(1, 4)))
    fronts = [("drawer", (a, b), (under - 0.11, under - 0.02))
              for a, b in pairwise(split)]  # fmt: skip
    add_fronts(thing, fronts, -y + 0.001, look(rng, style, material))
    if rng.uniform() < 0.6:
        z = 0.18
        thing.add(boards([(-x, x, -y, y, z - 0.02, z)]), material)
        free = under - 0.13 - z
        thing.supports.append(Support(0.08 - x, x - 0.08, 0.03 - y, y - 0.03, z, free))
    return thing


def nightstand(rng: np.random.Generator, style: Style) -> Thing:
    """A cabinet beside a bed: drawers, a drawer over a shelf, a stool-like stand."""
    width, depth = float(rng.uniform(0.36, 0.55)), float(rng.uniform(0.32, 0.42))
    height, material = float(rng.uniform(0.45, 0.65)), timber(rng, style)
    kind, thick = int(rng.integers(4)), 0.02
    thing = Thing("nightstand")
    x, y = (-width / 2, width / 2), (-depth / 2 + 0.02, depth / 2)
    made = look(rng, style, material if rng.uniform() < 0.6 else style.paint)
    if kind == 3:
        half, under = (width / 2, depth / 2), height - 0.02
        thing.add(slab(width, depth, height, 0.022, "rounded"), material)
        legs, _ = four_legs(rng, "square", half, under)
        thing.add(legs, material, 2)
        thing.add(carcass((x[0] + 0.05, x[1] - 0.05), y, (under - 0.14, under)), material)
        front = ("drawer", (x[0] + 0.068, x[1] - 0.068), (under - 0.122, under - 0.018))
        add_fronts(thing, [front], y[0], made)
        thing.supports.append(top_support(width, depth, height, "square"))
        return thing
    foot = float(rng.uniform(0.04, 0.16))
    thing.add(carcass(x, y, (foot, height), thick, overhang=0.008), material)
    thing.add(footing(rng, x, y, foot, style.modern < 0.5), material, 2)
    inner = (x[0] + 0.001, x[1] - 0.001)
    low, high = foot + 0.002, height - thick - 0.001
    cut = low + (high - low) * (0.55 if kind else 0.5)
    if kind == 0:
        fronts = [("drawer", inner, (low, cut)), ("drawer", inner, (cut, high))]
    elif kind == 1:
        fronts = [("left" if rng.uniform() < 0.5 else "right", inner, (low, high))]
    else:
        fronts = [("drawer", inner, (cut, high))]
        shelf = (x[0] + 0.019, x[1] - 0.019, y[0] + 0.002, y[1] - 0.008, cut - 0.018, cut)
        thing.add(boards([shelf]), material)
        free = cut - 0.018 - foot - thick
        thing.supports.append(Support(x[0] + 0.05, x[1] - 0.05, y[0] + 0.03, y[1] - 0.03,
                                      foot + thick, free))  # fmt: skip
    add_fronts(thing, fronts, y[0], made)
    thing.supports.insert(0, top_support(width, depth - 0.03, height, "square"))
    return thing


CATALOGUE: dict[str, Maker] = {
    "dining_table": dining_table,
    "coffee_table": coffee_table,
    "side_table": side_table,
    "console_table": console_table,
    "nightstand": nightstand,
}
