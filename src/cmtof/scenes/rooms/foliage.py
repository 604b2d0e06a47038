"""What plants are put together from: leaves by the dozen, stems, branches, pots with soil."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.rooms.materials import Colour, Material, Style, ceramic, darker
from cmtof.scenes.rooms.pliant import Points, across, bars, four_sided, sheets, spline, unit
from cmtof.scenes.rooms.solids import box, joined, revolve, tube
from cmtof.scenes.rooms.thing import Mesh, Thing

SOIL = Material((0.05, 0.032, 0.02), (0.02, 0.013, 0.009), "noise", 0.006, specular=0.0, bump=0.8)
BARK = Material((0.13, 0.085, 0.05), (0.06, 0.04, 0.025), "noise", 0.012, specular=0.01, bump=0.7)
STALK = Material((0.1, 0.2, 0.05), (0.14, 0.24, 0.07), "noise", 0.03, specular=0.03)


def green(
    rng: np.random.Generator, base: Colour = (0.07, 0.19, 0.035), scale: float = 0.02
) -> Material:
    """A leaf's upper side: some green with paler veins."""
    tint = rng.uniform(0.7, 1.35, 3) * rng.uniform(0.7, 1.3)
    colour: Colour = tuple(float(c * t) for c, t in zip(base, tint, strict=True))  # type: ignore[assignment]
    return Material(colour, darker(colour, 1.5), "leaf", scale, specular=0.05, gloss=30.0)


class Leaves(NamedTuple):
    """How K leaves sit: each value one for all, or one a leaf."""

    base: Points
    """(K, 3) where the blade begins, m."""
    along: Points
    """(K, 3) direction in which it begins."""
    length: ArrayLike
    """m."""
    width: ArrayLike
    """m."""
    droop: ArrayLike = 0.6
    """Angle by which the tip has turned downwards against the base, rad."""
    fold: ArrayLike = 0.25
    """Rise of the edges over the midrib, in half widths."""
    up: ArrayLike = (0.0, 0.0, 1.0)
    """Direction to which the upper side looks, about."""


OVATE = ((0.0, 0.08), (0.3, 0.95), (0.65, 0.8), (1.0, 0.02))
BLADE = ((0.0, 0.3), (0.45, 1.0), (1.0, 0.03))
LANCE = ((0.0, 0.25), (0.3, 1.0), (0.7, 0.75), (1.0, 0.03))
STRAP = ((0.0, 0.6), (0.2, 0.9), (0.5, 1.0), (0.8, 0.75), (1.0, 0.05))
HEART = ((-0.12, 0.6), (0.15, 1.0), (0.6, 0.65), (1.0, 0.02))
PETAL = ((0.0, 0.12), (0.7, 1.0), (1.0, 0.45))
"""Outlines: place along the midrib, and half width there in halves of the full width."""


def leaves(how: Leaves, outline: ArrayLike, thickness: float = 4e-4) -> Mesh:
    """Leaves with a crease at the midrib, bent along their length."""
    s, w = np.asarray(outline, float).T
    count = len(how.base)

    def each(value: ArrayLike) -> NDArray:
        return np.broadcast_to(np.asarray(value, float), (count,))[:, None]

    along = unit(how.along)
    up = unit(np.broadcast_to(np.asarray(how.up, float), along.shape))
    side = np.cross(up, along)
    weak = np.linalg.norm(side, axis=1, keepdims=True) < 0.1
    side = unit(np.where(weak, across(along)[0], side))
    normal = np.cross(along, side)
    turn = each(how.droop) * s + 1e-6
    length, half = each(how.length), each(how.width) / 2
    forth = length * s * np.sinc(turn / np.pi)  # arc of constant bend
    down = length * s * (1 - np.cos(turn)) / turn
    rib = how.base[:, None] + forth[..., None] * along[:, None] - down[..., None] * normal[:, None]
    # the normal turns with the rib, so that the fold stays square to the blade
    out = np.cos(turn)[..., None] * normal[:, None] + np.sin(turn)[..., None] * along[:, None]
    spread = (half * w)[..., None]
    rise = spread * each(how.fold)[..., None] * out
    points = np.stack(
        [rib - spread * side[:, None] + rise, rib, rib + spread * side[:, None] + rise]
    )
    return sheets(np.moveaxis(points, 0, 2), thickness)


def round_about(
    rng: np.random.Generator, count: int, rise: ArrayLike, spread: float = 0.25
) -> Points:
    """Directions (count, 3) all around in golden-angle order, ``rise`` rad above the horizon."""
    angle = 2.39996 * np.arange(count) + rng.normal(0, spread, count) + rng.uniform(0, 6.28)
    rise = np.broadcast_to(np.asarray(rise, float), (count,))
    return np.stack([np.cos(angle) * np.cos(rise), np.sin(angle) * np.cos(rise), np.sin(rise)], -1)


def arches(
    base: ArrayLike, along: Points, length: ArrayLike, droop: ArrayLike, count: int = 7
) -> Points:
    """Stems (K, count, 3) that start along (K, 3) and bend towards the ground by ``droop`` rad."""
    k = len(along)
    level = unit(along * [1, 1, 0])
    start = np.arcsin(np.clip(unit(along)[:, 2], -1, 1))[:, None]
    s = np.linspace(0, 1, count)
    angle = start - np.broadcast_to(np.asarray(droop, float), (k,))[:, None] * s**1.5
    step = np.broadcast_to(np.asarray(length, float), (k,))[:, None] / (count - 1)
    forth = np.concatenate([np.zeros((k, 1)), np.cumsum(step * np.cos(angle[:, 1:]), 1)], 1)
    high = np.concatenate([np.zeros((k, 1)), np.cumsum(step * np.sin(angle[:, 1:]), 1)], 1)
    points = forth[..., None] * level[:, None] + high[..., None] * np.array([0.0, 0.0, 1.0])
    return points + np.broadcast_to(np.asarray(base, float), (k, 3))[:, None]


def stems(paths: Points, radius: float, taper: float = 0.6, sides: int = 4) -> Mesh:
    """Thin stalks along paths (K, N, 3), thinner towards the tip."""
    n = paths.shape[1] - 1
    thick = radius * (1 - (1 - taper) * np.arange(n) / n)
    radii = np.broadcast_to(thick, (len(paths), n)).ravel()
    starts, ends = paths[:, :-1].reshape(-1, 3), paths[:, 1:].reshape(-1, 3)
    return bars(starts, ends + 0.02 * (ends - starts), radii, sides, taper=taper ** (1 / n))


def branches(
    rng: np.random.Generator,
    start: ArrayLike,
    along: ArrayLike,
    length: float,
    *,
    levels: int = 4,
    forks: int = 3,
    spread: float = 0.6,
    shrink: float = 0.68,
    lift: float = 0.15,
) -> list[tuple[Points, Points]]:
    """Starts and ends of twigs, one pair of (K, 3) arrays a level of forking."""
    begin, way, size = np.atleast_2d(np.asarray(start, float)), unit(np.atleast_2d(along)), length
    made = []
    for _ in range(levels):
        end = begin + size * rng.uniform(0.75, 1.2, (len(begin), 1)) * way
        made.append((begin, end))
        begin = np.repeat(begin + rng.uniform(0.6, 1.0, (len(begin), 1)) * (end - begin), forks, 0)
        begin[::forks] = end
        noise = spread * rng.normal(size=(len(begin), 3)) + [0, 0, lift]
        way = unit(np.repeat(way, forks, 0) + noise)
        size *= shrink
    return made


# --- pots -------------------------------------------------------------------------------------

TERRACOTTA = Material((0.42, 0.17, 0.08), (0.5, 0.25, 0.15), "noise", 0.05, specular=0.0, bump=0.2)
BASKET = Material((0.48, 0.33, 0.17), (0.25, 0.15, 0.07), "weave", 0.018, specular=0.02, bump=0.9)


def _terracotta(rng: np.random.Generator, r: float, h: float) -> tuple[Points, Material]:
    p = [(0.68 * r, 0), (0.92 * r, 0.78 * h), (0.93 * r, 0.78 * h), (r, 0.8 * h), (r, h)]
    return np.array(p), TERRACOTTA


def _cylindrical(rng: np.random.Generator, r: float, h: float) -> tuple[Points, Material]:
    foot = float(rng.uniform(0.75, 1.0))
    return np.array([(foot * r, 0), (foot * r + 0.004, 0.004), (r, h)]), ceramic(rng)


def _rounded(rng: np.random.Generator, r: float, h: float) -> tuple[Points, Material]:
    at = np.linspace(0, 1, 10)
    girth = r * (0.6 + 0.46 * np.sin(np.pi * (0.08 + 0.72 * at)) ** 0.8)
    return np.column_stack([girth, at * h]), ceramic(rng)


def _basket(rng: np.random.Generator, r: float, h: float) -> tuple[Points, Material]:
    at = np.linspace(0, 1, 13)
    girth = r * (0.85 + 0.15 * np.sin(np.pi * at)) + 0.004 * np.cos(np.pi * np.arange(13))
    return np.column_stack([girth, at * h]), BASKET


def pot(
    rng: np.random.Generator, style: Style, thing: Thing, radius: float, height: float,
    *, sides: int = 28,
) -> float:  # fmt: skip
    """Add a pot with soil: terracotta, ceramic, basket or box; returns the soil's height, m."""
    kind = int(rng.integers(6))
    if kind == 5:
        return _box_pot(style, thing, radius, height)
    foot = 0.0
    if kind == 4 and radius > 0.1:
        foot = _legs(style, thing, radius)
    make = (_terracotta, _cylindrical, _rounded, _basket, _cylindrical)[kind]
    profile, material = make(rng, radius, height)
    profile = profile + np.array([0, foot])
    rim = profile[-1]
    wall = max(0.06 * radius, 0.003)
    inner = [(rim[0] - wall, rim[1] + 0.4 * wall), (rim[0] - wall, rim[1] - 0.2 * height)]
    whole = np.concatenate([[(0, foot), profile[0]], profile, [rim], inner[:1], inner])
    thing.add(revolve(whole, sides), material)
    if kind == 0 and rng.uniform() < 0.7:  # saucer
        r = 1.05 * radius
        plate = [(0.55 * radius, 0.001), (0.85 * r, 0.001), (r, 0.12 * radius),
                 (0.96 * r, 0.12 * radius), (0.8 * r, 0.012), (0.55 * radius, 0.012)]  # fmt: skip
        thing.add(revolve(plate, sides), TERRACOTTA)
    soil = float(rim[1] - float(rng.uniform(0.06, 0.14)) * height)
    _add_soil(rng, thing, float(rim[0] - 0.8 * wall), soil)
    return soil


def _add_soil(rng: np.random.Generator, thing: Thing, radius: float, z: float) -> None:
    girth = radius * np.array([1.0, 0.8, 0.5, 0.2, 0.0])
    heap = z + radius * np.array([0, 0.03, 0.05, 0.04, 0.05])
    thing.add(revolve(np.column_stack([girth, heap]), 20), SOIL)


def _legs(style: Style, thing: Thing, radius: float) -> float:
    """A wooden cross with four posts around the pot; returns the height of the cross."""
    z, r = 0.9 * radius, radius + 0.012
    posts = [
        box((0.02, 0.02, 2.1 * radius), (s * r, 0, 1.05 * radius), bevel=0.003) for s in (-1, 1)
    ]
    posts += [
        box((0.02, 0.02, 2.1 * radius), (0, s * r, 1.05 * radius), bevel=0.003) for s in (-1, 1)
    ]
    cross = [
        box((2 * r, 0.018, 0.018), (0, 0, z - 0.01)),
        box((0.018, 2 * r, 0.017), (0, 0, z - 0.01)),
    ]
    thing.add(joined(posts + cross), style.wood, 2)
    return z


def _box_pot(style: Style, thing: Thing, radius: float, height: float) -> float:
    """A square tub, a little wider above."""
    r = 0.95 * radius
    wall = 0.08 * radius
    profile = [(0, 0), (0.85 * r, 0), (0.85 * r, 0), (r, height), (r, height), (r - wall, height),
               (r - wall, height), (r - wall, 0.85 * height)]  # fmt: skip
    thing.add(four_sided(profile), style.paint)
    side = 2 * r - wall
    thing.add(box((side, side, 0.02), (0, 0, 0.88 * height)), SOIL)
    return 0.88 * height + 0.01


def rested(thing: Thing) -> Thing:
    """Lay what hangs lower than the floor upon it; the order of heights stays."""
    for k, part in enumerate(thing.parts):
        vertices = part.mesh.vertices.copy()
        z = vertices[:, 2]
        low = z < 0.01
        z[low] = 0.002 + 0.008 * np.exp((z[low] - 0.01) / 0.03)
        if part.material is not thing.parts[0].material:
            thing.parts[k] = part._replace(mesh=Mesh(vertices, part.mesh.faces))
    return thing


def trunk(path: Points, radius: ArrayLike, sides: int = 8) -> Mesh:
    """A woody stem along a path."""
    return tube(path, radius, sides)


def vase(rng: np.random.Generator, thing: Thing, h: float, r: float) -> float:
    """Add a vase of height h and widest radius r; returns the radius of its neck, m."""
    forms = (
        [(0.55, 0), (0.8, 0.2), (1.0, 0.5), (0.8, 0.75), (0.45, 0.9), (0.55, 1.0)],
        [(0.8, 0), (0.84, 0.3), (0.9, 0.6), (1.0, 1.0)],
        [(0.9, 0), (1.0, 0.15), (0.9, 0.4), (0.45, 0.6), (0.35, 0.8), (0.5, 1.0)],
        [(0.45, 0), (0.5, 0.3), (0.75, 0.7), (0.95, 0.92), (0.8, 1.0)],
    )
    form = np.array(forms[int(rng.integers(len(forms)))]) * [r, h]
    fine = spline(np.column_stack([form, 0 * form[:, 0]]), 16)[:, :2]
    neck = float(fine[-1, 0])
    inner = fine[::-1][:6] * [1, 1] - [0.004, -0.001]
    inner[:, 0] = np.maximum(inner[:, 0], 0.002)
    whole = np.concatenate([[(0, 0), fine[0]], fine, inner, [(0.0, inner[-1, 1])]])
    thing.add(revolve(whole, 28), ceramic(rng))
    return neck
