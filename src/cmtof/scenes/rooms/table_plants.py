"""Plants and flowers on tables, sills and shelves; ivy from the ceiling."""

from dataclasses import replace

import numpy as np

from cmtof.scenes.rooms.foliage import (
    BARK,
    BLADE,
    HEART,
    LANCE,
    OVATE,
    PETAL,
    STALK,
    STRAP,
    Leaves,
    arches,
    green,
    leaves,
    pot,
    rested,
    round_about,
    stems,
    trunk,
    vase,
)
from cmtof.scenes.rooms.materials import Material, Style, ceramic, darker, hue
from cmtof.scenes.rooms.pliant import Points, across, bars, moved_by, spline, unit
from cmtof.scenes.rooms.shades import Maker
from cmtof.scenes.rooms.solids import ball, box, joined, revolve, sheet
from cmtof.scenes.rooms.thing import Mesh, Thing


def _top(z: float) -> Points:
    return np.array([0.0, 0.0, z])


def spider_plant(rng: np.random.Generator, style: Style) -> Thing:
    """A fountain of narrow leaves with a pale stripe."""
    thing = Thing("spider_plant")
    size = float(rng.uniform(0.22, 0.38))
    z = pot(rng, style, thing, 0.3 * size, 0.36 * size)
    count = int(rng.integers(36, 52))
    out = round_about(rng, count, rng.uniform(0.3, 1.45, count))
    length = size * rng.uniform(0.7, 1.25, count)
    droop = rng.uniform(1.0, 2.3, count)
    outline = ((0, 0.7), (0.25, 1.0), (0.5, 0.9), (0.75, 0.6), (1.0, 0.05))
    how = Leaves(np.tile(_top(z), (count, 1)), out, length, 0.014, droop, 0.5)
    thing.add(leaves(how, outline), Material((0.09, 0.27, 0.05), specular=0.05))
    pale = Leaves(how.base + np.array([0, 0, 0.0008]), out, length, 0.005, droop, 0.4)
    thing.add(leaves(pale, outline, 2e-4), Material((0.6, 0.65, 0.4), specular=0.05))
    return rested(thing)


def cactus(rng: np.random.Generator, style: Style) -> Thing:
    """A ribbed column with arms, a ribbed ball, or the pads of an opuntia."""
    thing = Thing("cactus")
    size = float(rng.uniform(0.12, 0.34))
    radius = float(np.clip(0.3 * size, 0.045, 0.1))
    z = pot(rng, style, thing, radius, 1.1 * radius)
    skin = Material((0.07, 0.17, 0.06), (0.12, 0.24, 0.09), "noise", 0.02, specular=0.03)
    kind = int(rng.integers(3))
    if kind == 0:
        bodies = [_ribbed(_top(z - 0.01) + np.array([[0, 0, 0], [0, 0, size]]), 0.5 * radius)]
        for side in (-1, 1):
            if rng.uniform() < 0.7:
                y, start = 0.0, z + size * float(rng.uniform(0.3, 0.5))
                reach = 0.95 * radius
                bend = [(0.3 * radius * side, y, start), (reach * side, y, start + 0.02),
                        (1.1 * reach * side, y, start + 0.3 * size)]  # fmt: skip
                bodies.append(_ribbed(np.array(bend), 0.3 * radius))
    elif kind == 1:
        bodies = [_ribbed(np.array([[0, 0, z - 0.02], [0, 0, z + 1.3 * radius]]), 0.85 * radius)]
    else:
        bodies = _pads(rng, z, 0.4 * size)
    body = joined(bodies)
    thing.add(body, skin)
    pick = rng.choice(len(body.vertices), 130)
    at = body.vertices[pick].astype(float)
    away = unit(at - [0, 0, z + 0.3 * size] + 1e-4) + 0.5 * rng.normal(size=at.shape)
    thing.add(bars(at, at + 0.009 * away, 3e-4, 3, 0.2), Material((0.6, 0.55, 0.4), specular=0.0))
    if rng.uniform() < 0.25:
        top = body.vertices[np.argmax(body.vertices[:, 2])].astype(float)
        _bloom(rng, thing, top[None], np.array([[0.0, 0.0, 1.0]]), 0.025, 9)
    return thing


def _ribbed(path: Points, radius: float) -> Mesh:
    """A round-headed column along a path with ten ribs."""
    fine = spline(path, 9)
    s = np.linspace(0, 1, 9)
    girth = radius * np.sqrt(1 - np.clip((s - 0.62) / 0.38, 0, 1) ** 2)
    ribs = 1 + 0.13 * np.cos(np.pi * np.arange(20))
    along = unit(np.gradient(fine, axis=0))
    one = unit(np.cross(along, [0.0, 1.0, 0.0]))
    two = np.cross(along, one)
    angle = np.arange(20) * (np.pi / 10)
    ring = np.cos(angle)[:, None] * one[:, None] + np.sin(angle)[:, None] * two[:, None]
    rings = fine[:, None] + (girth[:, None] * ribs)[..., None] * ring
    return sheet(rings[:, ::-1], closed=True)


def _pads(rng: np.random.Generator, z: float, size: float) -> list[Mesh]:
    """Flat oval pads that grow out of one another's upper edges."""
    unit_pad = ball(1.0, subdivisions=2)
    pads, open_ends = [], [(np.array([0.0, 0.0, z - 0.015]), 0.0, size)]
    for _ in range(6):
        foot, lean, tall = open_ends.pop(0)
        turn = float(rng.uniform(0, np.pi))
        wide = 0.62 * tall
        local = unit_pad.vertices * [wide / 2, 0.012, tall / 2] + [0, 0, 0.47 * tall]
        c, s = np.cos(lean), np.sin(lean)
        local = local @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
        c, s = np.cos(turn), np.sin(turn)
        spin = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        pads.append(Mesh((local @ spin + foot).astype(np.float32), unit_pad.faces))
        for side in (-1, 1):
            tip = np.array([side * 0.25 * tall + tall * 0.85 * np.sin(lean), 0, 0.85 * tall]) @ spin
            open_ends.append((foot + tip, side * float(rng.uniform(0.2, 0.6)), 0.72 * tall))
    return pads


def ivy(rng: np.random.Generator, style: Style) -> Thing:
    """A pot on three cords from the ceiling, vines falling over its rim."""
    thing = Thing("ivy")
    drop = float(rng.uniform(0.5, 0.9))
    r, h = float(rng.uniform(0.08, 0.12)), float(rng.uniform(0.1, 0.14))
    inner = Thing("pot")
    rim = r
    soil = _hung_pot(rng, inner, r, h)
    for part in inner.parts:
        thing.add(moved_by(part.mesh, 0, 0, -drop - h), part.material)
    angle = np.arange(3) * (2 * np.pi / 3)
    ring = rim * np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    cord = Material((0.6, 0.52, 0.38), specular=0.0)
    knot = np.tile([0.0, 0.0, -0.3 * drop], (3, 1))
    low = ring * [0.6, 0.6, 0] + [0, 0, -drop - h + 0.002]
    waist = 1.06 * ring + [0, 0, -drop]
    thing.add(joined([bars(waist, knot, 0.0022), bars(low * [1.2, 1.2, 1], waist, 0.0022)]), cord)
    thing.add(bars(knot[:1], [(0, 0, 0)], 0.003), cord)
    count = int(rng.integers(7, 11))
    out = round_about(rng, count, 0.5)
    paths = _vines(rng, out, rim, -drop + soil - h + 0.02, rng.uniform(0.15, 0.75, count))
    _leafy(rng, thing, paths)
    return thing


def _hung_pot(rng: np.random.Generator, thing: Thing, r: float, h: float) -> float:
    at = np.linspace(0, 1, 8)
    girth = r * (0.55 + 0.45 * np.sin(0.5 * np.pi * at))
    profile = np.column_stack([girth, h * at])
    whole = np.concatenate(
        [[(0, 0), profile[0]], profile, [(0.93 * r, h), (0.93 * r, 0.85 * h), (0, 0.85 * h)]]
    )
    thing.add(revolve(whole, 28), ceramic(rng))
    return 0.85 * h


def _vines(
    rng: np.random.Generator, out: Points, rim: float, z: float, length: Points, count: int = 12
) -> Points:
    """Paths (K, count, 3) from the soil over the rim and down."""
    s = np.linspace(0, 1, count)
    level = unit(out * [1, 1, 0])
    far = rim * (1.25 * np.sin(np.minimum(s / 0.25, 1) * 0.5 * np.pi))
    hang = np.clip((s - 0.18) / 0.82, 0, 1)
    high = z + 0.05 * np.sin(np.pi * np.minimum(s / 0.3, 1)) - length[:, None] * hang
    sway = 0.02 * np.sin(9 * s + rng.uniform(0, 6.28, (len(out), 1)))
    side = np.cross(level, [0.0, 0.0, 1.0])
    points = (far[:, None] * level[:, None]) + sway[..., None] * side[:, None]
    points[..., 2] = high
    return points


def _leafy(rng: np.random.Generator, thing: Thing, paths: Points) -> None:
    """Stems along paths with small heart-shaped leaves."""
    thing.add(stems(paths, 0.0015, 0.7, 3), STALK)
    base = np.concatenate([paths[:, 1:], paths[:, 2::2]], 1).reshape(-1, 3)
    way = rng.normal(size=base.shape) * [1, 1, 0.4] + [0, 0, -0.3]
    size = rng.uniform(0.025, 0.05, len(base))
    how = Leaves(base, way, size, 0.85 * size, rng.uniform(0.2, 0.8, len(base)), 0.15)
    thing.add(leaves(how, HEART), green(rng, (0.06, 0.19, 0.04), 0.01))


def trailing_ivy(rng: np.random.Generator, style: Style) -> Thing:
    """A pot that stands, with short vines over its rim."""
    thing = Thing("trailing_ivy")
    r, h = float(rng.uniform(0.06, 0.09)), float(rng.uniform(0.13, 0.18))
    z = pot(rng, style, thing, r, h)
    count = int(rng.integers(6, 9))
    length = rng.uniform(0.02, 0.85, count) * h
    _leafy(rng, thing, _vines(rng, round_about(rng, count, 0.5), 1.05 * r, z + 0.02, length))
    top = round_about(rng, 50, rng.uniform(0.1, 1.4, 50))
    size = rng.uniform(0.03, 0.05, 50)
    how = Leaves(
        _top(z) + top * rng.uniform(0.2, 0.9, (50, 1)) * r, top, size, 0.9 * size, 0.6, 0.15
    )
    thing.add(leaves(how, HEART), thing.parts[-1].material)
    return rested(thing)


def herb_pot(rng: np.random.Generator, style: Style) -> Thing:
    """Basil, rosemary or chives in a small pot."""
    thing = Thing("herb_pot")
    r = float(rng.uniform(0.045, 0.07))
    z = pot(rng, style, thing, r, 1.7 * r)
    kind = int(rng.integers(3))
    tall = float(rng.uniform(0.1, 0.2))
    if kind == 2:  # chives
        count = 90
        out = round_about(rng, count, rng.uniform(0.95, 1.55, count))
        base = _top(z) + 0.5 * r * rng.normal(size=(count, 3)) * [0.6, 0.6, 0]
        paths = arches(
            base, out, tall * rng.uniform(0.7, 1.2, count), rng.uniform(0, 0.9, count), 4
        )
        thing.add(stems(paths, 0.0014, 0.3, 3), Material((0.08, 0.24, 0.05), specular=0.05))
        return thing
    count = 14
    out = round_about(rng, count, rng.uniform(0.9, 1.5, count))
    base = _top(z) + 0.4 * r * rng.normal(size=(count, 3)) * [0.7, 0.7, 0]
    paths = arches(base, out, tall * rng.uniform(0.7, 1.1, count), 0.2, 8)
    thing.add(stems(paths, 0.0018, 0.6, 3), STALK)
    each = 2 if kind == 0 else 5
    at = np.repeat(paths[:, 2:], each, 1).reshape(-1, 3)
    way = rng.normal(size=at.shape) + np.array([0, 0, 0.3 if kind == 0 else 0.8])
    if kind == 0:
        size = rng.uniform(0.025, 0.045, len(at))
        thing.add(
            leaves(Leaves(at, way, size, 0.6 * size, 0.9, 0.35), OVATE),
            green(rng, (0.1, 0.3, 0.04)),
        )
    else:
        thing.add(bars(at, at + 0.018 * unit(way), 0.0011, 3, 0.4), green(rng, (0.09, 0.16, 0.08)))
    return thing


# --- flowers ----------------------------------------------------------------------------------


def _bloom(
    rng: np.random.Generator, thing: Thing, at: Points, facing: Points, size: float, petals: int,
    *, cup: float = 0.5, width: float = 0.5, colour: Material | None = None, heart: bool = True,
) -> None:  # fmt: skip
    """Flower heads at (K, 3) that look along ``facing``: petals in a ring about a heart."""
    one, two = across(facing)
    angle = np.arange(petals) * (2 * np.pi / petals)
    ring = np.cos(angle)[:, None] * one[:, None] + np.sin(angle)[:, None] * two[:, None]
    way = ring + np.tan(cup) * facing[:, None]
    base = np.repeat(at, petals, 0) + 0.1 * size * ring.reshape(-1, 3)
    face = np.repeat(facing, petals, 0)
    drawn = hue(
        float(rng.choice([0.0, 0.03, 0.12, 0.15, 0.78, 0.9])), float(rng.uniform(0, 0.9)), 0.7
    )
    skin = colour or Material(drawn, specular=0.02)
    scatter = rng.uniform(0.9, 1.1, len(base))
    how = Leaves(base, way.reshape(-1, 3), size * scatter, width * size, -0.3, 0.3, face)
    thing.add(leaves(how, PETAL, 3e-4), skin)
    if not heart:
        return
    hearts = [ball(0.2 * size, p, 1) for p in at + 0.1 * size * facing]
    thing.add(joined(hearts), Material((0.5, 0.32, 0.04), specular=0.0))


def orchid(rng: np.random.Generator, style: Style) -> Thing:
    """Broad strap leaves, one or two arching stems with a row of blossoms."""
    thing = Thing("orchid")
    r = float(rng.uniform(0.055, 0.075))
    z = pot(rng, style, thing, r, 1.8 * r)
    out = round_about(rng, 5, rng.uniform(0.3, 0.9, 5))
    size = rng.uniform(0.13, 0.22, 5)
    how = Leaves(np.tile(_top(z), (5, 1)), out, size, 0.055, 1.1, 0.35)
    thing.add(leaves(how, STRAP, 0.0015), green(rng, (0.05, 0.16, 0.03), 0.05))
    tint = hue(float(rng.choice([0.82, 0.88, 0.14])), float(rng.choice([0.0, 0.3, 0.75])), 0.75)
    for _ in range(int(rng.integers(1, 3))):
        a, tall = float(rng.uniform(0, 6.28)), float(rng.uniform(0.38, 0.55))
        c, s = np.cos(a), np.sin(a)
        far = np.array([0.0, 0.02, 0.08, 0.2, 0.32])
        high = z + tall * np.array([0.0, 0.55, 0.92, 1.0, 0.88])
        bend = np.column_stack([c * far, s * far, high])
        path = spline(bend, 24)
        thing.add(trunk(path, np.linspace(0.003, 0.0015, 24), 5), STALK)
        thing.add(bars([(0.006, 0, z - 0.01)], [path[11] + [0.004, 0, 0]], 0.002, 5), STALK)
        at = path[11:24:2] + np.array([0, 0, -0.012])
        look = (
            np.array([c, s, -0.1])
            + 0.5 * np.array([-s, c, 0]) * (-1.0) ** np.arange(len(at))[:, None]
        )
        _bloom(rng, thing, at, unit(look), 0.04, 5, cup=0.1, width=0.95, colour=Material(tint, specular=0.02))  # fmt: skip  # noqa: E501
    return thing


def flowers_in_vase(rng: np.random.Generator, style: Style) -> Thing:
    """Tulips, daisies, roses or sunflowers with their leaves."""
    thing = Thing("flowers_in_vase")
    h = float(rng.uniform(0.13, 0.26))
    neck = vase(rng, thing, h, float(rng.uniform(0.32, 0.45)) * h)
    kind = int(rng.integers(4))
    count = int(rng.integers(5, 10)) if kind < 3 else int(rng.integers(3, 6))
    out = round_about(rng, count, rng.uniform(0.95, 1.5, count))
    base = _top(0.35 * h) + 0.3 * neck * out * [1, 1, 0]
    paths = arches(base, out, h * rng.uniform(1.15, 1.6, count), rng.uniform(0.0, 0.5, count), 7)
    # where the vase is narrow all stems pass through its neck
    far = np.linalg.norm(paths[..., :2], axis=-1, keepdims=True)
    tight = np.clip(0.8 * neck / (far + 1e-9), 0, 1)
    inside = np.clip((1.1 * h - paths[..., 2:]) / (0.2 * h), 0, 1)
    paths[..., :2] *= 1 - inside * (1 - tight)
    thing.add(stems(paths, 0.0025, 0.8), STALK)
    ends, face = paths[:, -1], unit(paths[:, -1] - paths[:, -2])
    if kind == 0:  # tulips: two rings of cupped petals
        _bloom(rng, thing, ends, face, 0.055, 6, cup=1.25, width=0.75)
    elif kind == 1:  # daisies
        _bloom(rng, thing, ends, unit(face + 0.3 * rng.normal(size=face.shape)), 0.035, 13, cup=0.15, width=0.3)  # fmt: skip  # noqa: E501
    elif kind == 2:  # roses: rings of petals, each steeper and shorter
        state = int(rng.integers(2**31))
        for size, cup in ((0.04, 0.5), (0.036, 0.9), (0.034, 1.25)):
            _bloom(
                np.random.default_rng(state),
                thing,
                ends,
                face,
                size,
                6,
                cup=cup,
                width=0.95,
                heart=cup < 0.6,
            )
    else:  # sunflowers
        look = unit(face + np.array([0.0, -0.6, 0.2]))
        yellow = Material((0.7, 0.4, 0.02), specular=0.02)
        _bloom(rng, thing, ends, look, 0.07, 18, cup=0.1, width=0.28, colour=yellow)
        discs = [ball(0.026, p, 2) for p in ends + 0.008 * look]
        thing.add(joined(discs), Material((0.05, 0.03, 0.015), specular=0.0))
    at = paths[:, 3:5].reshape(-1, 3)
    way = np.repeat(face, 2, 0) * 0.8 + 0.7 * rng.normal(size=at.shape) * [1, 1, 0.2]
    how = Leaves(at, way, 0.45 * h * rng.uniform(0.6, 1.1, len(at)), 0.03, 0.9, 0.3)
    thing.add(leaves(how, LANCE), green(rng, (0.08, 0.22, 0.04), 0.015))
    return thing


def bonsai(rng: np.random.Generator, style: Style) -> Thing:
    """A winding trunk in a shallow tray, its foliage in level clouds."""
    thing = Thing("bonsai")
    w, size = float(rng.uniform(0.2, 0.3)), float(rng.uniform(0.22, 0.36))
    tray = ceramic(rng)
    thing.add(box((w, 0.65 * w, 0.04), (0, 0, 0.032), bevel=0.008), tray)
    feet = [box((0.03, 0.03, 0.016), (sx * 0.38 * w, sy * 0.22 * w, 0.008)) for sx in (-1, 1) for sy in (-1, 1)]  # fmt: skip  # noqa: E501
    thing.add(joined(feet), tray)
    moss = Material((0.06, 0.11, 0.03), (0.04, 0.05, 0.02), "noise", 0.02, specular=0.0, bump=0.8)
    thing.add(box((w - 0.016, 0.65 * w - 0.016, 0.012), (0, 0, 0.05), bevel=0.005), moss)
    lean = float(rng.choice([-1, 1])) * 0.3
    way = [(0, 0, 0.04), (0.12 * lean, 0.01, 0.25), (-0.35 * lean, -0.02, 0.5),
           (0.3 * lean, 0.01, 0.75), (0.1 * lean, 0, 0.95)]  # fmt: skip
    path = spline(np.array(way) * [size, 0.6 * size, size], 16)
    path[0, 2] = 0.045
    thing.add(trunk(path, np.linspace(0.022, 0.005, 16), 8), BARK)
    clouds = int(rng.integers(4, 7))
    at = path[np.linspace(6, 15, clouds).astype(int)]
    reach = size * np.linspace(0.34, 0.0, clouds)[:, None]
    out = unit(round_about(rng, clouds, 0.15))
    ends = at + reach * out + [0, 0, 0.01]
    thing.add(bars(at, ends, 0.005, 5, 0.5), BARK)
    each = 52
    bubble = unit(rng.normal(size=(clouds * each, 3)) + np.array([0, 0, 0.8])) * rng.uniform(
        0.6, 1, (clouds * each, 1)
    )
    wide = size * np.repeat(np.linspace(0.22, 0.15, clouds), each)[:, None]
    base = np.repeat(ends, each, 0) + bubble * wide * [1.0, 0.9, 0.45]
    leaf = np.full(len(base), 0.022)
    cores = [ball(1.0, subdivisions=1) for _ in range(clouds)]
    cores = [
        Mesh((core.vertices * 0.62 * w * [1, 0.9, 0.45] + end).astype(np.float32), core.faces)
        for core, w, end in zip(cores, wide[::each, 0], ends, strict=True)
    ]
    how = Leaves(base, bubble + 0.6 * rng.normal(size=base.shape), leaf, 0.6 * leaf, 0.4, 0.2)
    leaf_green = green(rng, (0.06, 0.16, 0.03), 0.01)
    thing.add(leaves(how, BLADE), leaf_green)
    thing.add(joined(cores), replace(leaf_green, colour=darker(leaf_green.colour, 0.5)))
    return thing


CATALOGUE: dict[str, Maker] = {
    "cactus": cactus,
    "ivy": ivy,
    "trailing_ivy": trailing_ivy,
    "herb_pot": herb_pot,
    "orchid": orchid,
    "flowers_in_vase": flowers_in_vase,
    "bonsai": bonsai,
    "spider_plant": spider_plant,
}
