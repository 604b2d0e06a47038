"""Vessels by revolution: vases, bowls, cups, glasses, bottles, jugs, m."""

from collections.abc import Callable

import numpy as np

from cmtof.scenes.rooms.materials import Material, Style, ceramic, darker, hue
from cmtof.scenes.rooms.shaping import Points, handle, hollow, pick, stood, turned
from cmtof.scenes.rooms.solids import joined, revolve, sheet
from cmtof.scenes.rooms.thing import Mesh, Thing

Maker = Callable[..., Thing]
"""``maker(rng, style, **sizes)`` draws a thing."""

CORK = Material((0.45, 0.3, 0.17), (0.3, 0.18, 0.1), "noise", 0.004, specular=0.01)


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """A length drawn between two, m."""
    return float(rng.uniform(low, high))


def glassy(rng: np.random.Generator) -> Material:
    """Opaque glass: clear-grey, green, brown, blue, milky or black, with a sharp gloss."""
    tints = ((0.45, 0.5, 0.5), (0.03, 0.09, 0.04), (0.14, 0.06, 0.015), (0.03, 0.07, 0.25),
        (0.75, 0.76, 0.75), (0.02, 0.02, 0.02), hue(float(rng.uniform()), 0.6, 0.3))  # fmt: skip
    tint = tints[int(rng.integers(len(tints)))]
    return Material(tint, specular=0.3, gloss=800.0)


def ware(rng: np.random.Generator, style: Style) -> Material:
    """What vases are made of: glazed, unglazed, glass, the accent or metal."""
    kind = int(rng.integers(8))
    if kind == 0:
        return glassy(rng)
    if kind == 1:
        return style.accent
    if kind == 2:
        return style.metal
    if kind == 3:
        clay = hue(between(rng, 0.03, 0.08), between(rng, 0.3, 0.6), between(rng, 0.15, 0.6))
        return Material(clay, darker(clay, 0.8), "noise", 0.02, specular=0.01, bump=0.2)
    return ceramic(rng)


_VASES: tuple[tuple[tuple[float, float], ...], ...] = (
    # baluster, bottle neck, egg, trumpet, gourd, cylinder, moon, amphora, stepped
    ((0.5, 0), (0.55, 0.02), (0.95, 0.35), (1.0, 0.55), (0.75, 0.75), (0.42, 0.87), (0.45, 0.95),
     (0.6, 1.0)),
    ((0.6, 0), (0.9, 0.08), (1.0, 0.28), (0.7, 0.48), (0.25, 0.6), (0.2, 0.75), (0.22, 0.95),
     (0.34, 1.0)),
    ((0.4, 0), (0.75, 0.12), (1.0, 0.42), (0.92, 0.72), (0.6, 0.92), (0.5, 1.0)),
    ((0.55, 0), (0.5, 0.06), (0.34, 0.18), (0.4, 0.45), (0.55, 0.72), (1.0, 1.0)),
    ((0.5, 0), (0.98, 0.14), (1.0, 0.3), (0.5, 0.5), (0.66, 0.65), (0.62, 0.8), (0.32, 0.9),
     (0.4, 1.0)),
    ((0.92, 0), (0.96, 0.03), (0.96, 0.5), (1.0, 0.97), (0.98, 1.0)),
    ((0.35, 0), (0.7, 0.07), (1.0, 0.38), (0.95, 0.62), (0.5, 0.86), (0.28, 0.92), (0.34, 1.0)),
    ((0.3, 0), (0.42, 0.04), (0.3, 0.08), (0.8, 0.35), (1.0, 0.58), (0.85, 0.72), (0.38, 0.82),
     (0.34, 0.93), (0.5, 1.0)),
    ((0.8, 0), (0.8, 0.3), (0.8, 0.3), (1.0, 0.36), (1.0, 0.7), (1.0, 0.7), (0.6, 0.76),
     (0.6, 1.0)),
)  # fmt: skip
"""Outlines as shares of the largest radius and of the height."""


def outline(shape: tuple[tuple[float, float], ...], radius: float, height: float) -> Points:
    """A vessel's outside at its size, m, closed at the bottom."""
    corners = np.array([(0.0, 0.0), *shape]) * [radius, height]
    return np.insert(corners, 1, corners[1] * [0.7, 1], axis=0)


def vase(rng: np.random.Generator, style: Style) -> Thing:
    """One of nine families, slim or round, smooth, ribbed or twisted."""
    shape = _VASES[int(rng.integers(len(_VASES)))]
    h = between(rng, 0.14, 0.42)
    r = h * between(rng, 0.2, 0.36)
    ribs = int(pick(rng, 0, 0, 0, 8, 12))
    body = hollow(outline(shape, r, h), min(0.006, 0.08 * r), sides=36 if ribs else 28)
    if ribs:
        body = _ribbed(body, ribs, between(rng, 0.03, 0.08), between(rng, -2, 2) / h)
    return Thing("vase").add(body, ware(rng, style))


def _ribbed(mesh: Mesh, ribs: int, depth: float, twist: float) -> Mesh:
    """Flutes around a vessel, upright or twisted, rad per m."""
    x, y, z = mesh.vertices.T.astype(float)
    wave = 1 + depth * np.cos(ribs * (np.arctan2(y, x) + twist * z))
    points = np.stack([x * wave, y * wave, z], -1)
    return Mesh(points.astype(np.float32), mesh.faces)


def bowl(rng: np.random.Generator, style: Style) -> Thing:
    """A salad bowl, a footed bowl, a deep mixing bowl or a wide shallow dish, m."""
    kind = int(rng.integers(4))
    r = between(rng, 0.065, 0.16)
    h = r * (0.75, 0.8, 1.1, 0.4)[kind]
    shapes = (((0.42, 0), (0.5, 0.02), (0.82, 0.35), (0.97, 0.75), (1.0, 1.0)),
        ((0.45, 0), (0.4, 0.1), (0.3, 0.16), (0.7, 0.3), (0.95, 0.62), (1.0, 1.0)),
        ((0.5, 0), (0.62, 0.03), (0.88, 0.4), (0.95, 0.9), (1.03, 1.0)),
        ((0.6, 0), (0.66, 0.04), (0.85, 0.35), (1.0, 1.0)))  # fmt: skip
    material = style.wood if rng.uniform() < 0.25 else ware(rng, style)
    body = hollow(outline(shapes[kind], r, h), pick(rng, 0.003, 0.005, 0.007),
        floor=0.2 * h if kind == 1 else None)  # fmt: skip
    return Thing("bowl").add(body, material)


def plate_mesh(radius: float, height: float, sides: int = 32) -> Mesh:
    """A plate with a foot ring, a well and a flat rim, m."""
    r, h, t = radius, height, 0.0035
    profile = [(0, 0.001), (0.5 * r, 0.001), (0.56 * r, 0), (0.6 * r, 0.003), (0.72 * r, 0.4 * h),
        (0.98 * r, 0.85 * h), (r, 0.95 * h), (0.985 * r, h), (0.74 * r, 0.55 * h + t),
        (0.62 * r, t + 0.003), (0.5 * r, t + 0.001), (0, t + 0.001)]  # fmt: skip
    return revolve(profile, sides)


def plate(rng: np.random.Generator, style: Style) -> Thing:
    """A plate, or now and then two or three stacked, m."""
    material = ceramic(rng)
    thing = Thing("plate")
    r = pick(rng, 0.135, 0.12, 0.095, 0.08)
    h = between(rng, 0.014, 0.024)
    for k in range(int(pick(rng, 1, 1, 1, 2, 4))):
        mesh = plate_mesh(r * between(rng, 0.995, 1.0), h, 28)
        slide = np.array([*rng.normal(0, 0.0015, 2), k * 0.0065], np.float32)
        thing.add(Mesh(mesh.vertices + slide, mesh.faces), material)
    return stood(thing)


def ear(radius: float, low: float, high: float, reach: float, thick: float) -> Mesh:
    """A cup's handle at its right, from one height to another, sunk into the wall, m."""
    x = radius - 0.5 * thick
    middle = (low + high) / 2
    path = [(x, 0, high), (x + 0.7 * reach, 0, high + 0.1 * (high - low)),
        (x + reach, 0, middle + 0.1 * (high - low)), (x + 0.6 * reach, 0, low),
        (x - 0.06 * reach, 0, low - 0.04 * (high - low))]  # fmt: skip
    mesh = handle(path, thick, count=11, sides=6)
    return Mesh(mesh.vertices * np.array([1, 1.35, 1], np.float32), mesh.faces)


def cup(rng: np.random.Generator, style: Style) -> Thing:
    """A tea or espresso cup on its saucer, with or without something in it, m."""
    material = ceramic(rng)
    r = pick(rng, 0.032, 0.044, 0.05)
    h = r * between(rng, 1.25, 1.6)
    shapes = (((0.5, 0), (0.55, 0.06), (0.85, 0.35), (0.95, 0.75), (1.0, 1.0)),
        ((0.6, 0), (0.9, 0.12), (0.95, 0.5), (0.97, 1.0)), ((0.45, 0), (0.48, 0.1), (0.7, 0.35),
        (0.85, 0.7), (1.05, 1.0)))  # fmt: skip
    shape = shapes[int(rng.integers(3))]
    mesh = joined([hollow(outline(shape, r, h), 0.0028, sides=24, count=11),
        ear(0.93 * r, 0.3 * h, 0.82 * h, 0.5 * r, 0.0032)])  # fmt: skip
    lift = 0.006
    thing = Thing("cup").add(Mesh(mesh.vertices + np.array([0, 0, lift], np.float32), mesh.faces),
        material)  # fmt: skip
    thing.add(plate_mesh(r * 1.6, 0.016, 24), material)
    if rng.uniform() < 0.6:
        thing.add(_filling(0.84 * r, 0.75 * h + lift, 20), drink(rng))
    return stood(thing)


def drink(rng: np.random.Generator) -> Material:
    """Coffee, milky coffee, tea."""
    shades = ((0.015, 0.008, 0.004), (0.35, 0.2, 0.1), (0.16, 0.05, 0.01))
    return Material(shades[int(rng.integers(3))], specular=0.1, gloss=900.0)


def _filling(radius: float, height: float, sides: int) -> Mesh:
    """Level surface of what is in a vessel, m."""
    return revolve([(radius, height), (0, height)], sides)


def mug(rng: np.random.Generator, style: Style) -> Thing:
    """Straight, barrel, tapered or enamel mug, m."""
    r, h = between(rng, 0.038, 0.046), between(rng, 0.085, 0.11)
    shapes = (((0.94, 0), (0.98, 0.03), (1.0, 0.5), (1.0, 1.0)),
        ((0.8, 0), (0.88, 0.04), (1.03, 0.5), (0.92, 1.0)), ((0.74, 0), (0.8, 0.04), (0.9, 0.5),
        (1.0, 1.0)), ((0.97, 0), (1.0, 0.02), (1.0, 0.96), (1.05, 1.0)))  # fmt: skip
    body = hollow(outline(shapes[int(rng.integers(4))], r, h), pick(rng, 0.003, 0.004), sides=26,
        count=11)  # fmt: skip
    grip = ear(0.97 * r, 0.22 * h, 0.8 * h, between(rng, 0.024, 0.032), 0.0045)
    thing = Thing("mug").add(joined([body, grip]), ware(rng, style))
    if rng.uniform() < 0.5:
        thing.add(_filling(0.88 * r, 0.78 * h, 20), drink(rng))
    return stood(thing)


def glass(rng: np.random.Generator, style: Style) -> Thing:
    """A tumbler, a wine glass, a goblet, a flute or a beer glass, as opaque glass, m."""
    kind = int(rng.integers(5))
    h = (between(rng, 0.08, 0.13), 0.21, 0.16, 0.22, 0.16)[kind]
    r = (0.037, 0.042, 0.04, 0.026, 0.036)[kind] * between(rng, 0.95, 1.1)
    shapes = (((0.85, 0), (0.87, 0.02), (0.95, 0.5), (1.0, 1.0)),
        ((0.85, 0), (0.8, 0.012), (0.1, 0.05), (0.08, 0.3), (0.12, 0.42), (0.85, 0.56), (1.0, 0.74),
        (0.78, 1.0)), ((0.8, 0), (0.78, 0.02), (0.16, 0.06), (0.14, 0.24), (0.5, 0.36), (0.92, 0.6),
        (1.0, 1.0)), ((1.1, 0), (1.05, 0.012), (0.14, 0.05), (0.13, 0.34), (0.5, 0.46), (1.0, 0.72),
        (0.92, 1.0)), ((0.72, 0), (0.72, 0.03), (0.8, 0.3), (1.05, 0.72), (1.0, 1.0)))  # fmt: skip
    floor = (0.08 * h, 0.43 * h, 0.36 * h, 0.46 * h, 0.1 * h)[kind]
    body = hollow(outline(shapes[kind], r, h), 0.0016, floor=floor, sides=24, count=17)
    return Thing("glass").add(body, glassy(rng))


def _label(radius: float, low: float, high: float, share: float, sides: int = 16) -> Mesh:
    """Paper around a share of a bottle, a quarter of a millimetre off it, m."""
    angle = np.linspace(-np.pi * share, np.pi * share, sides) - np.pi / 2
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1) * (radius + 4e-4)
    corners = np.stack([ring + np.array([0, 0, low]), ring + np.array([0, 0, high])], 0)
    return sheet(corners[:, ::-1], thickness=3e-4)


def paper(rng: np.random.Generator) -> Material:
    """A printed label."""
    ground = hue(between(rng, 0.05, 0.2), between(rng, 0, 0.4), between(rng, 0.3, 0.8))
    ink = hue(float(rng.uniform()), 0.6, between(rng, 0.02, 0.15))
    return Material(ground, ink, "marks", between(rng, 0.006, 0.014), specular=0.02)


def wine_bottle(rng: np.random.Generator, style: Style) -> Thing:
    """Bordeaux, Burgundy, hock or sparkling, with label and capsule or cork, m."""
    kind = int(rng.integers(4))
    r, h = (0.0375, 0.041, 0.036, 0.044)[kind], (0.3, 0.295, 0.335, 0.31)[kind]
    shoulder = (0.66, 0.5, 0.45, 0.48)[kind]
    neck = 0.0145 / r
    profile = [(0.9, 0), (1, 0.02), (1, shoulder - 0.04), (0.97, shoulder),
        (neck * 1.25, (0.76, 0.76, 0.78, 0.74)[kind]), (neck, 0.82), (neck, 0.95)]  # fmt: skip
    body = np.array([(0, 0.02), (0.75, 0), *profile, (neck, 0.955), (neck * 1.12, 0.957),
        (neck * 1.12, 0.985), (neck, 1.0), (0, 1.0)]) * [r, h]  # fmt: skip
    tints = ((0.012, 0.03, 0.012), (0.03, 0.08, 0.03), (0.09, 0.035, 0.01), (0.3, 0.34, 0.28))
    tint = tints[int(rng.integers(4))]
    thing = Thing("wine bottle").add(
        turned(body, 26, 24), Material(tint, specular=0.25, gloss=800.0)
    )
    thing.add(_label(r, 0.13 * h, 0.36 * h, between(rng, 0.5, 0.8)), paper(rng))
    capsule = hue(float(rng.uniform()), 0.8, between(rng, 0.02, 0.2))
    if rng.uniform() < 0.75:
        edge = neck * r
        rings = [(edge + 5e-4, 0.84 * h), (edge + 8e-4, 0.95 * h), (1.14 * edge + 8e-4, 0.96 * h),
            (1.14 * edge + 8e-4, 0.988 * h), (edge, 1.003 * h), (0, 1.003 * h)]  # fmt: skip
        thing.add(revolve(rings, 20), Material(capsule, specular=0.3, gloss=60.0))
    else:
        thing.add(turned([(0, 0.97 * h), (0.009, 0.97 * h), (0.0095, h + 0.012), (0, h + 0.014)],
            16, 9), CORK)  # fmt: skip
    return stood(thing)


def bottle(rng: np.random.Generator, style: Style) -> Thing:
    """A water, oil, sauce, shampoo or pharmacy bottle with its cap, m."""
    kind = int(rng.integers(5))
    r = (0.033, 0.034, 0.03, 0.032, 0.028)[kind] * between(rng, 0.85, 1.2)
    h = (0.25, 0.27, 0.17, 0.2, 0.1)[kind] * between(rng, 0.85, 1.15)
    shapes = ([(0.9, 0), (1, 0.04), (0.93, 0.2), (1, 0.3), (0.93, 0.42), (1, 0.55), (1, 0.66),
        (0.4, 0.86)], [(0.95, 0), (1, 0.02), (1, 0.6), (0.9, 0.68), (0.38, 0.78), (0.36, 0.9)],
        [(0.85, 0), (1, 0.05), (1, 0.5), (0.55, 0.72), (0.42, 0.88)],
        [(0.85, 0), (0.95, 0.04), (1, 0.4), (0.85, 0.78), (0.5, 0.86)],
        [(0.95, 0), (1, 0.03), (1, 0.6), (0.9, 0.68), (0.5, 0.74), (0.5, 0.82)])  # fmt: skip
    top = shapes[kind][-1][0] * r
    z = shapes[kind][-1][1] * h
    body = np.array([(0, 0), (0.6, 0), *shapes[kind]]) * [r, h]
    colour = hue(float(rng.uniform()), between(rng, 0, 0.8), between(rng, 0.1, 0.8))
    stuff = Material(colour, specular=0.08, gloss=100.0) if kind in (2, 3) else glassy(rng)
    thing = Thing("bottle").add(turned([*body, (top, z + 0.004), (0, z + 0.004)], 26, 22), stuff)
    lid = [(0, z + 0.001), (1.15 * top, z + 0.001), (1.15 * top, z + 0.002), (1.1 * top, h),
        (0.9 * top, h + 0.001), (0, h + 0.001)]  # fmt: skip
    cap = hue(float(rng.uniform()), 0.7, pick(rng, 0.02, 0.3, 0.8))
    thing.add(turned(lid, 20, 10), Material(cap, specular=0.06, gloss=50.0))
    if rng.uniform() < 0.8 and kind not in (0, 3):
        thing.add(_label(r, 0.15 * h, 0.45 * h, between(rng, 0.4, 0.9)), paper(rng))
    return stood(thing)


def jar(rng: np.random.Generator, style: Style) -> Thing:
    """A jam jar, a storage jar with a lid and knob, or a ginger jar, m."""
    kind = int(rng.integers(3))
    r, h = between(rng, 0.032, 0.06), between(rng, 0.09, 0.2)
    shapes = ([(0.92, 0), (1, 0.04), (1, 0.75), (0.9, 0.86), (0.84, 0.9), (0.84, 0.92)],
        [(0.95, 0), (1, 0.02), (1, 0.86), (0.98, 0.9)], [(0.6, 0), (0.75, 0.1), (1, 0.5),
        (0.95, 0.72), (0.55, 0.84), (0.5, 0.88)])  # fmt: skip
    body = np.array([(0, 0), (0.6, 0), *shapes[kind], (0, shapes[kind][-1][1])]) * [r, h]
    stuff = glassy(rng) if kind == 0 else ware(rng, style)
    thing = Thing("jar").add(turned(body, 28, 18), stuff)
    top, z = shapes[kind][-1][0] * r, shapes[kind][-1][1] * h
    if kind == 0:
        lid = [(0, z - 0.012), (top + 0.001, z - 0.012), (top + 0.002, z + 0.001), (top, z + 0.003),
            (0, z + 0.003)]  # fmt: skip
        cap = Material(hue(float(rng.uniform()), 0.6, between(rng, 0.1, 0.7)), specular=0.3)
        thing.add(turned(lid, 28, 12), cap)
        thing.add(_label(r, 0.25 * h, 0.6 * h, 0.5), paper(rng))
        return stood(thing)
    lid = [(0, z + 0.0006), (1.04 * top, z + 0.0006), (1.04 * top, z + 0.006),
        (0.6 * top, z + 0.012), (0.16 * r, z + 0.014), (0.13 * r, z + 0.02), (0.25 * r, z + 0.03),
        (0, z + 0.036)]  # fmt: skip
    thing.add(turned(lid, 28, 18), style.wood if rng.uniform() < 0.4 else stuff)
    return stood(thing)


def _poured(mesh: Mesh, height: float, radius: float, reach: float) -> Mesh:
    """Draw the rim of a vessel out to a lip at its left."""
    x, y, z = mesh.vertices.T.astype(float)
    near = np.clip((z / height - 0.72) / 0.28, 0, 1) ** 2
    far = near * np.exp(-((np.arctan2(y, -x) / 0.35) ** 2)) * np.hypot(x, y) / radius
    return Mesh(np.stack([x - reach * far, y * (1 - 0.25 * far), z + 0.3 * reach * far],
        -1).astype(np.float32), mesh.faces)  # fmt: skip


def _jug(rng: np.random.Generator, material: Material, h: float, kind: str) -> Thing:
    r = h * between(rng, 0.3, 0.38)
    shapes = (((0.7, 0), (0.78, 0.02), (1.0, 0.3), (0.9, 0.6), (0.6, 0.82), (0.68, 1.0)),
        ((0.9, 0), (0.95, 0.02), (0.88, 0.4), (0.72, 0.8), (0.8, 1.0)),
        ((0.55, 0), (0.5, 0.05), (0.85, 0.2), (1.0, 0.42), (0.7, 0.68), (0.55, 0.85),
        (0.75, 1.0)))  # fmt: skip
    shape = shapes[int(rng.integers(3))]
    body = _poured(hollow(outline(shape, r, h), 0.004, sides=32), h, r, 0.35 * r)
    high = 0.9 * h
    at = np.interp(np.array([0.3, 0.9]), [p[1] for p in shape], [p[0] for p in shape]) * r
    reach = between(rng, 0.45, 0.65) * r
    x0, x1 = at[0] - 0.004, at[1] - 0.004
    path = [(x1, 0, high), (x1 + 0.7 * reach, 0, high + 0.05 * h), (r + 0.9 * reach, 0, 0.66 * h),
        (r + 0.4 * reach, 0, 0.42 * h), (x0, 0, 0.3 * h)]  # fmt: skip
    grip = handle(path, [0.007, 0.006, 0.0055, 0.006], count=12)
    return stood(Thing(kind).add(joined([body, grip]), material))


def jug(rng: np.random.Generator, style: Style) -> Thing:
    """A small jug for milk or a larger one of stoneware, m."""
    return _jug(rng, ware(rng, style), between(rng, 0.1, 0.18), "jug")


def pitcher(rng: np.random.Generator, style: Style) -> Thing:
    """A tall pitcher for water, m."""
    material = glassy(rng) if rng.uniform() < 0.4 else ware(rng, style)
    return _jug(rng, material, between(rng, 0.2, 0.29), "pitcher")


def decanter(rng: np.random.Generator, style: Style) -> Thing:
    """A wide-bottomed or a square-shouldered decanter with its stopper, m."""
    h = between(rng, 0.2, 0.26)
    r = h * between(rng, 0.28, 0.42)
    shapes = (
        ((0.9, 0), (1, 0.04), (0.9, 0.2), (0.35, 0.5), (0.2, 0.7), (0.2, 0.9), (0.34, 1.0)),
        ((0.8, 0), (0.82, 0.04), (0.85, 0.5), (0.8, 0.58), (0.22, 0.68), (0.2, 0.9), (0.32, 1.0)),
    )
    shape = shapes[int(rng.integers(2))]
    stuff = glassy(rng)
    body = hollow(outline(shape, r, h), 0.003)
    k = 0.24 * r
    plug = [(0, h - 0.012), (0.45 * k, h - 0.012), (0.6 * k, h), (1.3 * k, h + 0.006),
        (1.6 * k, h + 0.03), (1.2 * k, h + 0.05), (0, h + 0.056)]  # fmt: skip
    return Thing("decanter").add(body, stuff).add(turned(plug, 16, 14), stuff)


def urn(rng: np.random.Generator, style: Style) -> Thing:
    """A footed urn with two handles and mostly a lid, m."""
    h = between(rng, 0.28, 0.5)
    r = h * between(rng, 0.27, 0.33)
    shape = ((0.55, 0), (0.55, 0.05), (0.3, 0.09), (0.22, 0.16), (0.6, 0.28), (1.0, 0.58),
        (0.92, 0.68), (0.55, 0.76), (0.6, 0.84), (0.8, 0.9))  # fmt: skip
    stuff = ware(rng, style)
    body = hollow(outline(shape, r, h), 0.006, floor=0.2 * h, count=20)
    loops = []
    for side in (-1, 1):
        path = np.array([(0.93 * r, 0, 0.66 * h), (1.22 * r, 0, 0.7 * h), (1.18 * r, 0, 0.83 * h),
            (0.7 * r, 0, 0.87 * h)]) * [side, 1, 1]  # fmt: skip
        loops.append(handle(path, 0.03 * h, count=9, sides=6))
    thing = Thing("urn").add(joined([body, *loops]), stuff)
    if rng.uniform() < 0.6:
        lid = np.array([(0, 0.905), (0.82, 0.905), (0.8, 0.93), (0.4, 0.98), (0.12, 1.0),
            (0.1, 1.02), (0.2, 1.05), (0.12, 1.08), (0, 1.1)]) * [r, h]  # fmt: skip
        thing.add(turned(lid, 24, 16), stuff)
    return stood(thing)


CATALOGUE: dict[str, Maker] = {
    "vase": vase,
    "bowl": bowl,
    "plate": plate,
    "cup": cup,
    "mug": mug,
    "glass": glass,
    "wine_bottle": wine_bottle,
    "bottle": bottle,
    "jar": jar,
    "jug": jug,
    "pitcher": pitcher,
    "decanter": decanter,
    "urn": urn,
}
