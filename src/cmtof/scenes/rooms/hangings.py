"""Cloth on walls: towels, woven pieces on a stick, tapestries, flags."""

import numpy as np

from cmtof.scenes.rooms.materials import Material, Style, darker, fabric, hue
from cmtof.scenes.rooms.pliant import bars, grid, hung, ripples, slab, spline
from cmtof.scenes.rooms.shades import Maker
from cmtof.scenes.rooms.solids import ball, cylinder, joined, rod, sheet, tube
from cmtof.scenes.rooms.textiles import yarn_of
from cmtof.scenes.rooms.thing import Mesh, Thing


def hanging_towel(rng: np.random.Generator, style: Style) -> Thing:
    """A towel over a rail, or gathered on a hook."""
    thing = Thing("hanging_towel")
    tall = float(rng.uniform(0.4, 0.7))
    if rng.uniform() < 0.5:
        return _on_hook(rng, style, thing, tall)
    width = float(rng.uniform(0.3, 0.5))
    y0, top = -0.07, tall / 2
    bar = rod((-width / 2 - 0.06, y0, top - 0.012), (width / 2 + 0.06, y0, top - 0.012), 0.008, 12)
    ends = [s * (width / 2 + 0.05) for s in (-1, 1)]
    posts = [rod((x, 0, top - 0.012), (x, y0, top - 0.012), 0.009, 10) for x in ends]
    thing.add(joined([bar, *posts]), style.metal)
    u, v = grid(-width / 2, width / 2, -0.75 * tall, tall, 22, 30)
    angle = np.clip(v / 0.012, -np.pi / 2, np.pi / 2)
    down = np.maximum(np.abs(v) - 0.012 * np.pi / 2, 0)
    wave = 0.012 * ripples(rng, 2 * u, 0 * v, 6, 0.3) * np.clip(down / 0.3, 0, 1)
    y = (
        y0
        - 0.014 * np.sin(angle)
        + wave * np.sign(-v)
        - 0.01 * np.sign(v) * np.clip(down / 0.4, 0, 1)
    )
    z = top - 0.012 + 0.014 * np.cos(angle) - down
    thing.add(slab(np.stack([u, np.minimum(y, -0.008), z], -1), 0.004), fabric(rng))
    return thing


def _on_hook(rng: np.random.Generator, style: Style, thing: Thing, tall: float) -> Thing:
    top = tall / 2
    hook = spline([(0, -0.002, top - 0.02), (0, -0.03, top - 0.03), (0, -0.045, top - 0.01), (0, -0.045, top + 0.01)], 12)  # fmt: skip  # noqa: E501
    thing.add(tube(hook, 0.005), style.metal)
    thing.add(ball(0.009, hook[-1], 1), style.metal)
    thing.add(_gathered(rng, 0.32, tall, top), fabric(rng))
    return thing


def _gathered(rng: np.random.Generator, width: float, tall: float, top: float) -> Mesh:
    """Cloth that hangs from one point at z = ``top``, in folds that open downwards."""
    s, t = np.meshgrid(
        np.linspace(0, 1, 16), np.linspace(0, 2 * np.pi, 44, endpoint=False), indexing="ij"
    )
    folds = 1 + 0.28 * np.sin(5 * t + rng.uniform(0, 6)) * s**0.5 + 0.16 * np.sin(8 * t + 2 * s) * s
    spread = 0.02 + (width / 2 - 0.02) * s**0.8
    x = spread * folds * np.cos(t)
    y = -0.055 - 0.32 * spread * folds * np.sin(t) - 0.01
    z = top - tall * s * (1 + 0.14 * np.cos(t + 0.7) * s)
    y = np.minimum(y, -0.004)
    return sheet(np.stack([x, y, z], -1)[:, ::-1][::-1], closed=True, thickness=0.002)


def wall_hanging(rng: np.random.Generator, style: Style) -> Thing:
    """A woven piece on a stick, straight, pointed or with long tassels."""
    thing = Thing("wall_hanging")
    width, tall = float(rng.uniform(0.35, 0.8)), float(rng.uniform(0.4, 0.9))
    u, v = grid(-width / 2, width / 2, -tall / 2, tall / 2, 25, 21)
    point = float(rng.choice([0.0, 0.25, 0.4])) * (1 - np.abs(2 * u / width))
    z = np.where(v < 0, v * (1 + point), v)
    y = -0.022 - 0.008 * ripples(rng, 2 * u, 0.4 * v, 8, 0.5) * np.clip((tall / 2 - v) / 0.2, 0, 1)
    yarn = yarn_of(rng)
    thing.add(slab(np.stack([u, y, z], -1), 0.004), yarn, 2)
    stick = [
        (-width / 2 - 0.05, -0.022, tall / 2 + 0.008),
        (width / 2 + 0.05, -0.022, tall / 2 + 0.008),
    ]
    thing.add(rod(stick[0], stick[1], 0.01, 10), style.wood)
    knot, rise = width / 2 - 0.01, tall / 2 + 0.018
    cord = [(-knot, -0.022, rise), (0, -0.006, tall / 2 + 0.16), (knot, -0.022, rise)]
    thing.add(bars(cord[:2], cord[1:], 0.002), Material((0.55, 0.48, 0.35), specular=0.0))
    thing.add(cylinder(0.004, 0.02, (0, -0.003, tall / 2 + 0.16), sides=8), style.metal)
    if rng.uniform() < 0.6:
        ends = np.stack([u[:, 0], y[:, 0], z[:, 0]], -1)
        path = spline(ends, 50)
        lengths = np.full((50, 1), 0.25 * tall) * rng.uniform(0.85, 1.1, (50, 1))
        tips = path + lengths * [0, 0, -1.0] + [0, 0.002, 0]
        thing.add(bars(path, tips, 0.004, 4, 0.7), Material((0.62, 0.56, 0.44), specular=0.0))
    return hung(thing)


def flag(rng: np.random.Generator, style: Style) -> Thing:
    """A flag of two or three bars, pinned to the wall by its upper corners or along its top."""
    thing = Thing("flag")
    width = float(rng.uniform(0.9, 1.5))
    tall = width * float(rng.choice([0.6, 0.67]))
    bands = int(rng.integers(2, 4))
    upright = rng.uniform() < 0.4
    pinned = float(rng.uniform(0.0, 0.05))
    h, s = float(rng.uniform()), float(rng.uniform(0.4, 0.9))
    salt = int(rng.integers(2**31))
    for k in range(bands):
        inner = np.random.default_rng(salt)
        a, b = k / bands - 0.5, (k + 1) / bands - 0.5
        span = (a, b, -0.5, 0.5) if upright else (-0.5, 0.5, a, b)
        u, v = grid(*span, 33 if not upright else 15, 11 if not upright else 25)
        sag = pinned * (1 - (2 * u) ** 2) * (0.5 + v)
        y = -0.04 - 0.03 * ripples(inner, 3 * u * width, v * tall, 8, 1.6) * (0.6 - v)
        z = (v - sag) * tall
        tone = 0.7 if k == 1 else (0.12, 0.0, 0.35)[k]
        colour = hue(h + 0.33 * k, 0.0 if k == 1 else s, tone + 0.02)
        points = np.stack([u * width, np.minimum(y, -0.004), z], -1)
        thing.add(
            slab(points, 0.0015),
            Material(colour, darker(colour, 0.9), "weave", 0.004, specular=0.01),
        )
    return hung(thing)


def tapestry(rng: np.random.Generator, style: Style) -> Thing:
    """A large woven picture on a rod."""
    thing = wall_hanging(rng, style)
    thing.kind = "tapestry"
    return thing


CATALOGUE: dict[str, Maker] = {
    "hanging_towel": hanging_towel,
    "wall_hanging": wall_hanging,
    "flag": flag,
    "tapestry": tapestry,
}
