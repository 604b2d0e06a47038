"""Small belongings: pens in a cup, scissors, keys, spectacles, m."""

import numpy as np

from cmtof.scenes.rooms.cabinetry import BLACK, CHROME, STEEL
from cmtof.scenes.rooms.joinery import boards, placed, rods, shifted
from cmtof.scenes.rooms.materials import Material, Style, hue, leather
from cmtof.scenes.rooms.pliant import Points, slab
from cmtof.scenes.rooms.shaping import (
    handle,
    hollow,
    laid,
    stood,
    stretched,
    turned,
)
from cmtof.scenes.rooms.solids import cushion, cylinder, joined, tube
from cmtof.scenes.rooms.thing import Thing
from cmtof.scenes.rooms.vessels import Maker, between


def pen_cup(rng: np.random.Generator, style: Style) -> Thing:
    """A cup with pencils, pens, a brush and scissors or a ruler in it, m."""
    r, h = between(rng, 0.034, 0.042), between(rng, 0.085, 0.11)
    stuff = (style.wood, style.metal, style.accent)[int(rng.integers(3))]
    thing = Thing("pen cup").add(
        hollow([(0, 0), (0.9 * r, 0), (r, 0.004), (r, h)], 0.0025, sides=26, count=10), stuff
    )
    count = int(rng.integers(4, 11))
    for k in range(count):
        a = 2.4 * k + between(rng, 0, 0.5)
        far = between(rng, 0.55, 0.82) * r
        foot = np.array([-0.5 * far * np.cos(a), -0.5 * far * np.sin(a), 0.004])
        edge = np.array([far * np.cos(a), far * np.sin(a), h])
        way = (edge - foot) / np.linalg.norm(edge - foot)
        long = between(rng, 0.14, 0.19)
        tip, end = foot + (long - 0.018) * way, foot + long * way
        tint = Material(hue(float(rng.uniform()), between(rng, 0.2, 0.9), between(rng, 0.02, 0.6)),
            specular=0.08)  # fmt: skip
        if k % 3 == 0:  # a pencil, sharpened end up
            thing.add(rods([foot], [tip], 0.0036, sides=6), tint)
            thing.add(rods([tip], [end], 0.0008, taper=4.4, sides=6), Material((0.6, 0.45, 0.28)))
        else:
            thing.add(rods([foot], [end], 0.0045, sides=9), tint)
    return thing


def _loop(a: float, b: float, n: int = 21) -> Points:
    t = np.linspace(0, 2 * np.pi, n)
    return np.stack([a * np.cos(t), b * np.sin(t), 0 * t], -1)


def scissors(rng: np.random.Generator, style: Style) -> Thing:
    """A pair of scissors that lies there, a little open, m."""
    long = between(rng, 0.15, 0.22)
    grip = (BLACK, Material(hue(0.05, 0.9, 0.5), specular=0.06), style.accent)[int(rng.integers(3))]
    thing = Thing("scissors")
    open_ = between(rng, 0.06, 0.35)
    for side in (-1, 1):
        u = np.linspace(0, 1, 10)
        wide = np.interp(u, [0, 0.1, 0.45, 1], [0.004, 0.008, 0.0085, 0.0006])
        blade = np.empty((10, 2, 3))
        blade[..., 0] = side * np.stack([0 * u - 0.2 * wide, wide], -1)[:, ::side]
        blade[..., 1], blade[..., 2] = (0.55 * long * u)[:, None], 0.005 + 0.0012 * (side + 1)
        metal = slab(blade[::-1], 0.002)
        ring = tube(_loop(0.085 * long, 0.125 * long) + np.array([-side * 0.1 * long, -0.24 * long,
            0.007]), 0.0045, 7, capped=False)  # fmt: skip
        shank = handle([(0, 0.02 * long, 0.0065), (-side * 0.03 * long, -0.06 * long, 0.007),
            (-side * 0.06 * long, -0.13 * long, 0.007)], 0.0045, count=6, sides=7)  # fmt: skip
        turn = -side * open_ / 2
        thing.add(placed(metal, turn=turn), STEEL)
        thing.add(placed(joined([ring, shank]), turn=turn), grip)
    return stood(thing.add(shifted(cylinder(0.004, 0.006, sides=10), 0, 0.01, 0.0065), CHROME))


def keys(rng: np.random.Generator, style: Style) -> Thing:
    """A bunch of two to five keys on a ring with a fob, lying, m."""
    thing = Thing("keys")
    hoop = tube(_loop(0.014, 0.014) + np.array([0, 0, 0.0045]), 0.0012, 5, capped=False)
    thing.add(hoop, CHROME)
    start = between(rng, 0, 6)
    for k in range(int(rng.integers(2, 6))):
        a = start + k * between(rng, 0.5, 0.9)
        t = np.linspace(0, 2 * np.pi, 15)
        ring = 0.011 * np.stack([np.cos(t), np.sin(t), 0 * t], -1)
        bow = slab(np.stack([0.45 * ring, ring]), 0.0018)
        blade = boards([(0.009, 0.048, -0.0035, 0.0035, -0.0018, 0.0002),
            (0.034, 0.037, -0.006, -0.003, -0.0017, 0.0), (0.041, 0.046, -0.0055, -0.003, -0.0017,
            0.0)], 0)  # fmt: skip
        metal = (
            Material((0.6, 0.47, 0.22), specular=0.5, gloss=80.0) if rng.uniform() < 0.4 else STEEL
        )
        at = (0.021 * np.cos(a), 0.021 * np.sin(a), 0.0025 + 0.0024 * k)
        thing.add(placed(joined([bow, blade]), at, turn=float(a)), metal)
    b = start + np.pi + 0.6
    fob = turned([(0, 0), (0.014, 0), (0.016, 0.003), (0.014, 0.006), (0, 0.006)], 16, 9)
    return stood(thing.add(shifted(fob, 0.027 * np.cos(b), 0.027 * np.sin(b), 0.0), leather(rng)))


def glasses_case(rng: np.random.Generator, style: Style) -> Thing:
    """A spectacle case, shut, or spectacles folded on it or beside it, m."""
    hide = leather(rng) if rng.uniform() < 0.6 else style.accent
    thing = Thing("glasses case")
    long = between(rng, 0.155, 0.165)
    case = cushion((long, 0.068, 0.048), (0, 0, 0.024), square=0.5)
    thing.add(case, hide)
    t = np.linspace(0, 2 * np.pi, 33)
    c, n = np.cos(t), np.sin(t)
    x, y = (np.sign(v) * np.abs(v) ** 0.5 for v in (c, n))
    seam = np.stack([0.503 * long * x, 0.0345 * y, 0.024 + 0 * t], -1)
    thing.add(tube(seam, 0.0012, 4, capped=False), BLACK)
    if rng.uniform() < 0.5:
        y = -0.085
        frame_ = BLACK if rng.uniform() < 0.5 else CHROME
        rims = [tube(_loop(0.025, 0.02)[:, [0, 2, 1]] + [s * 0.034, y, 0.0225], 0.002, 6,
            capped=False) for s in (-1, 1)]  # fmt: skip
        bridge = handle(
            [(-0.01, y, 0.028), (0, y - 0.003, 0.031), (0.01, y, 0.028)], 0.0018, count=6, sides=5
        )
        arms = [handle([(s * 0.06, y, 0.03), (s * 0.062, y + 0.012, 0.03),
            (-s * 0.02, y + 0.018 + 0.004 * s, 0.02), (-s * 0.07, y + 0.022 + 0.004 * s, 0.006)],
            0.0018, count=10, sides=5) for s in (-1, 1)]  # fmt: skip
        panes = [shifted(stretched(laid(cylinder(0.0245, 0.0012, sides=20), 1), 1, 1, 0.8),
            s * 0.034, y, 0.0225) for s in (-1, 1)]  # fmt: skip
        glass_ = Material((0.05, 0.055, 0.06), specular=0.4, gloss=900.0)
        thing.add(joined([*rims, bridge, *arms]), frame_)
        thing.add(joined(panes), glass_)
    return stood(thing)


CATALOGUE: dict[str, Maker] = {
    "pen_cup": pen_cup,
    "scissors": scissors,
    "keys": keys,
    "glasses_case": glasses_case,
}
