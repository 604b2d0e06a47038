"""Plants that stand on the floor, from monstera to dried branches."""

import numpy as np

from cmtof.scenes.rooms.foliage import (
    BARK,
    BLADE,
    STALK,
    Leaves,
    arches,
    branches,
    green,
    leaves,
    pot,
    rested,
    round_about,
    stems,
    trunk,
    vase,
)
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.pliant import Points, bars, sheets, unit
from cmtof.scenes.rooms.shades import Maker
from cmtof.scenes.rooms.solids import joined
from cmtof.scenes.rooms.thing import Mesh, Thing


def monstera(rng: np.random.Generator, style: Style) -> Thing:
    """Large heart-shaped leaves, cut to the midrib, on long stalks."""
    thing = Thing("monstera")
    size = float(rng.uniform(0.75, 1.2))
    z = pot(rng, style, thing, 0.15 * size + 0.03, 0.26 * size + 0.05)
    count = int(rng.integers(10, 15))
    rise = rng.uniform(0.95, 1.5, count)
    out = round_about(rng, count, rise)
    length = size * rng.uniform(0.4, 0.85, count)
    base = (0.0, 0.0, z) + 0.03 * out * [1, 1, 0]
    paths = arches(base, out, length, rng.uniform(0.2, 0.6, count))
    thing.add(stems(paths, 0.006 * size + 0.002, sides=5), STALK)
    along = unit(unit(out * [1, 1, 0]) + [0, 0, -0.25] + 0.2 * rng.normal(size=(count, 3)))
    up = unit(out * [0.5, 0.5, 0] + [0, 0, 1.0] + 0.15 * rng.normal(size=(count, 3)))
    blade = size * rng.uniform(0.2, 0.33, count)
    thing.add(_cut_leaves(paths[:, -1], along, up, blade), green(rng, (0.04, 0.14, 0.025), 0.05))
    return thing


def _cut_leaves(base: Points, along: Points, up: Points, length: Points) -> Mesh:
    """Heart-shaped blades whose edges are cut into five lobes a side."""
    s = np.linspace(-0.18, 1.0, 17)
    heart = np.interp(s, [-0.18, -0.05, 0.2, 0.5, 0.8, 1.0], [0.3, 0.8, 1.0, 0.85, 0.5, 0.02])
    lobe = np.where(np.arange(17) % 4 == 3, 0.42, 1.0)
    lobe[[0, 1, 16, 15]] = 1.0
    side = unit(np.cross(up, along))
    normal = np.cross(along, side)
    t = np.array([-1.0, -0.35, 0.0, 0.35, 1.0])
    reach = np.where(np.abs(t) > 0.5, (heart * lobe)[:, None], heart[:, None])
    x = np.where((s < 0)[:, None] & (t == 0), 0.0, s[:, None]) + 0.16 * np.abs(t) * reach
    y = 0.48 * t * reach
    z = 0.12 * np.abs(t) * reach - 0.45 * np.maximum(x, 0) ** 2 - 0.12 * t**2 * reach
    size = length[:, None, None, None]
    frame = (along[:, None, None], side[:, None, None], normal[:, None, None])
    points = base[:, None, None] + size * sum(
        a[..., None] * axis for a, axis in zip((x, y, z), frame, strict=True)
    )
    return sheets(points)


def ficus(rng: np.random.Generator, style: Style) -> Thing:
    """A small tree: one stem, twisted stems, or an olive's grey crown."""
    thing = Thing("ficus")
    height = float(rng.uniform(1.1, 1.9))
    z = pot(rng, style, thing, float(rng.uniform(0.14, 0.2)), float(rng.uniform(0.24, 0.36)))
    bole = z + 0.42 * (height - z)
    turns = int(rng.choice([0, 0, 3]))
    for k in range(max(turns, 1)):
        s = np.linspace(0, 1, 14)
        angle = 2 * np.pi * k / 3 + 7 * s
        wind = 0.022 * np.stack([np.cos(angle), np.sin(angle)], -1) if turns else 0.0
        path = np.column_stack(
            [0.03 * np.sin(3 * s), 0.02 * np.sin(5 * s), z - 0.03 + (bole - z + 0.05) * s]
        )
        path[:, :2] += wind
        thing.add(trunk(path, np.linspace(0.02, 0.013, 14), 7), BARK)
    twigs = []
    tips = []
    for _ in range(5):
        way = [rng.normal(0, 0.5), rng.normal(0, 0.5), 1.0]
        levels = branches(rng, (0, 0, bole - 0.05), way, 0.42 * (height - bole), levels=4, forks=2)
        twigs += [bars(a, b, 0.007 * 0.6**k, 4, 0.7) for k, (a, b) in enumerate(levels)]
        tips += [(a, b) for a, b in levels[1:]]
    thing.add(joined(twigs), BARK)
    start, end = (np.concatenate([pair[k] for pair in tips]) for k in (0, 1))
    count = 210
    pick = rng.integers(0, len(start), count)
    base = start[pick] + rng.uniform(0.2, 1.0, (count, 1)) * (end - start)[pick]
    along = unit((end - start)[pick]) + 0.9 * rng.normal(size=(count, 3)) + [0, 0, -0.25]
    olive = rng.uniform() < 0.25
    size = rng.uniform(0.05, 0.075, count) if olive else rng.uniform(0.08, 0.125, count)
    width = (0.28 if olive else 0.48) * size
    colour = green(rng, (0.13, 0.18, 0.1) if olive else (0.05, 0.15, 0.03), 0.015)
    how = Leaves(base, along, size, width, rng.uniform(0.2, 1.0, count), 0.3)
    thing.add(leaves(how, BLADE), colour)
    return thing


def palm(rng: np.random.Generator, style: Style) -> Thing:
    """Arching fronds of narrow leaflets from a tuft of canes."""
    thing = Thing("palm")
    height = float(rng.uniform(1.1, 1.9))
    z = pot(rng, style, thing, float(rng.uniform(0.14, 0.19)), float(rng.uniform(0.22, 0.34)))
    count = int(rng.integers(7, 11))
    rise = rng.uniform(1.2, 1.53, count)
    out = round_about(rng, count, rise)
    base = (0.0, 0.0, z) + 0.04 * rng.normal(size=(count, 3)) * [1, 1, 0]
    length = (height - z) * rng.uniform(0.75, 1.1, count)
    paths = arches(base, out, length, rng.uniform(0.4, 1.15, count), 15)
    thing.add(stems(paths, 0.006, 0.3, 3), STALK)
    pairs = 12
    at = np.linspace(4.5, 13.9, pairs)
    low = at.astype(int)
    f = (at - low)[None, :, None]
    rib = paths[:, low] * (1 - f) + paths[:, low + 1] * f
    ahead = unit(paths[:, low + 1] - paths[:, low])
    level = unit(np.cross(ahead, [0.0, 0.0, 1.0]))
    up = np.cross(level, ahead)
    size = (height - z) * 0.26 * np.sin(np.pi * (0.25 + 0.68 * np.linspace(0, 1, pairs)))
    size = np.broadcast_to(size[:, None], (count, pairs, 1)).reshape(-1)
    skin = green(rng, (0.07, 0.2, 0.03))
    for side in (-1, 1):
        way = (0.75 * side * level + 0.7 * ahead + 0.25 * up).reshape(-1, 3)
        way = way + 0.06 * rng.normal(size=way.shape)
        how = Leaves(
            rib.reshape(-1, 3), way, size, 0.085 * size + 0.006, 0.7, 0.3, up.reshape(-1, 3)
        )
        thing.add(leaves(how, BLADE), skin)
    return rested(thing)


def snake_plant(rng: np.random.Generator, style: Style) -> Thing:
    """Stiff upright swords, banded, twisted a little."""
    thing = Thing("snake_plant")
    tall = float(rng.uniform(0.35, 0.85))
    z = pot(rng, style, thing, 0.08 + 0.09 * tall, 0.1 + 0.17 * tall)
    count = int(rng.integers(8, 15))
    angle = rng.uniform(0, 2 * np.pi, count)
    foot = (0.05 + 0.04 * tall) * np.sqrt(rng.uniform(0, 1, count))
    base = np.stack([foot * np.cos(angle), foot * np.sin(angle), np.full(count, z - 0.01)], -1)
    lean = unit(base * [1, 1, 0] * 3 + [0, 0, 1.0] + 0.06 * rng.normal(size=(count, 3)))
    face = round_about(rng, count, 0.0)
    size = tall * rng.uniform(0.6, 1.05, count)
    how = Leaves(base, lean, size, 0.05 + 0.025 * tall, rng.normal(0.0, 0.15, count), 0.45, face)
    outline = ((0, 0.7), (0.2, 0.85), (0.45, 1.0), (0.7, 0.95), (0.88, 0.6), (1, 0.03))
    skin = Material((0.06, 0.14, 0.05), (0.22, 0.3, 0.14), "noise", 0.02, specular=0.05)
    thing.add(leaves(how, outline, 0.002), skin)
    if rng.uniform() < 0.6:  # yellow margins
        rim = Leaves(base - 0.0008 * face, lean, 1.004 * np.asarray(size), 0.062 + 0.025 * tall,
                     how.droop, 0.45, face)  # fmt: skip
        thing.add(leaves(rim, outline, 6e-4), Material((0.5, 0.47, 0.15), specular=0.05))
    return thing


def fern(rng: np.random.Generator, style: Style) -> Thing:
    """Arching fronds with small leaflets on both sides."""
    thing = Thing("fern")
    size = float(rng.uniform(0.3, 0.6))
    z = pot(rng, style, thing, 0.3 * size, 0.34 * size)
    count, pairs = int(rng.integers(11, 13)), 10
    out = round_about(rng, count, rng.uniform(0.7, 1.4, count))
    paths = arches(
        (0.0, 0.0, z), out, size * rng.uniform(0.75, 1.2, count), rng.uniform(1.2, 2.1, count), 12
    )
    thing.add(stems(paths, 0.002, 0.4, 3), STALK)
    rib = paths[:, 2:]
    ahead = unit(np.diff(paths[:, 1:], axis=1))
    level = unit(np.cross(ahead, [0.0, 0.0, 1.0]))
    up = np.cross(level, ahead).reshape(-1, 3)
    taper = size * 0.17 * np.sin(np.pi * (0.18 + 0.8 * np.linspace(0, 1, pairs)))
    length = np.broadcast_to(taper, (count, pairs)).reshape(-1)
    both = []
    for side in (-1, 1):
        way = (side * level + 0.35 * ahead).reshape(-1, 3) + 0.1 * rng.normal(size=up.shape)
        how = Leaves(rib.reshape(-1, 3), way, length, 0.02 + 0.3 * length, 0.5, 0.2, up)
        both.append(leaves(how, ((0.0, 0.6), (0.4, 1.0), (1.0, 0.05))))
    thing.add(joined(both), green(rng, (0.09, 0.26, 0.04), 0.012))
    return rested(thing)


def dried_branches(rng: np.random.Generator, style: Style) -> Thing:
    """A tall vase on the floor with bare twigs, or with plumes of pampas grass."""
    thing = Thing("dried_branches")
    h = float(rng.uniform(0.3, 0.6))
    vase(rng, thing, h, 0.3 * h)
    if rng.uniform() < 0.55:
        whole = []
        for _ in range(int(rng.integers(4, 6))):
            way = [rng.normal(0, 0.22), rng.normal(0, 0.22), 1.0]
            levels = branches(rng, (0, 0, 0.6 * h), way, 0.75 * h, levels=5, forks=2, spread=0.3,
                              shrink=0.66, lift=0.3)  # fmt: skip
            whole += [bars(a, b, 0.006 * 0.65**k, 4, 0.7) for k, (a, b) in enumerate(levels)]
        thing.add(joined(whole), BARK)
        return thing
    count = int(rng.integers(5, 9))
    out = round_about(rng, count, rng.uniform(1.15, 1.5, count))
    paths = arches(
        (0, 0, 0.5 * h), out, h * rng.uniform(1.4, 2.0, count), rng.uniform(0.2, 0.7, count), 9
    )
    straw = Material((0.55, 0.44, 0.28), (0.4, 0.3, 0.18), "noise", 0.01, specular=0.0)
    thing.add(stems(paths, 0.003), straw)
    tip = np.repeat(paths[:, 5:], 8, 1).reshape(-1, 3)
    way = np.repeat(np.repeat(paths[:, -1] - paths[:, 5], 4, 0), 8, 0)
    way = unit(way) + 0.45 * rng.normal(size=way.shape)
    how = Leaves(tip, way, 0.16 * h + 0.03, 0.01, 0.9, 0.1)
    thing.add(leaves(how, ((0, 0.3), (0.5, 1.0), (1, 0.05))), straw)
    return thing


CATALOGUE: dict[str, Maker] = {
    "monstera": monstera,
    "ficus": ficus,
    "palm": palm,
    "snake_plant": snake_plant,
    "fern": fern,
    "dried_branches": dried_branches,
}
