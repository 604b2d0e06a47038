"""A bicycle and its cousin that stays indoors, m."""

import numpy as np
from numpy.typing import NDArray

from cmtof.scenes.rooms.cabinetry import (
    BLACK,
    CHROME,
    STEEL,
)
from cmtof.scenes.rooms.joinery import (
    boards,
    centred,
    placed,
    plank,
    rods,
    rounded,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.solids import cushion, joined, revolve, tube
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.upholstery import cloth


def vector(x: float, y: float, z: float) -> NDArray[np.float64]:
    """A shift, m."""
    return np.array([x, y, z], float)


RUBBER = Material((0.02, 0.02, 0.02), specular=0.02, gloss=10.0)


def wheel(radius: float, spokes: int = 28) -> tuple[Mesh, Mesh]:
    """Tyre, and rim with hub and crossed spokes, turning about x through the origin."""
    turn = np.linspace(-np.pi / 2, 1.5 * np.pi, 8)
    ring = np.stack([np.cos(turn), np.sin(turn)], -1)
    sides = 36 if radius > 0.25 else 24
    tyre, rim = (
        placed(revolve(r * ring + [radius - away, 0], sides), tilt=np.pi / 2)
        for r, away in ((0.017, 0.017), (0.008, 0.038))
    )
    k = np.arange(spokes)
    side = np.where(k % 2, 0.03, -0.03)
    a = 2 * np.pi * k / spokes
    b = a + np.where(k % 4 < 2, 1.1, -1.1)
    inner = np.stack([side, 0.022 * np.cos(b), 0.022 * np.sin(b)], -1)
    outer = np.stack([0 * a, (radius - 0.04) * np.cos(a), (radius - 0.04) * np.sin(a)], -1)
    hub = rods([(-0.05, 0, 0)], [(0.05, 0, 0)], 0.02, sides=10)
    return tyre, joined([rim, hub, rods(inner, outer, 0.0013, sides=4)])


def bicycle(rng: np.random.Generator, style: Style) -> Thing:
    """A bicycle that stands along x: tubes, spoked wheels, saddle, bars, cranks, mudguards."""
    r, base = float(rng.choice([0.34, 0.34, 0.3])), 1.05
    wave, step = rng.uniform() < 0.5, float(rng.uniform(0.48, 0.58))
    rear, front = np.array([-0.43, 0, r]), np.array([base - 0.43, 0, r])
    crank, seat = np.array([0.0, 0, 0.28]), np.array([-0.17, 0, 0.28 + step])
    head = np.array([front[0] - 0.19, 0, 0.28 + step + 0.03])
    low_head = head + vector(0.045, 0, -0.13)
    colour = style.accent if rng.uniform() < 0.7 else style.metal
    saddle = seat + np.array([-0.035, 0, 0.13])
    top = (
        [seat + vector(0.01, 0, -0.04), head]
        if not wave
        else [crank + vector(-0.07, 0, 0.2), low_head + vector(0, 0, 0.03)]
    )
    lines = [
        (crank, seat),
        (crank, low_head),
        tuple(top),
        (low_head, head),
        (seat, saddle - vector(0, 0, 0.05)),
    ]
    starts, ends = np.array([a for a, _ in lines]), np.array([b for _, b in lines])
    main = rods(starts, ends, 0.016, sides=10)
    off = np.array([0, 0.055, 0])
    stays = [(rear + s * off, crank + 0.5 * s * off) for s in (-1, 1)]
    stays += [(rear + s * off, seat + 0.3 * s * off - [0, 0, 0.03]) for s in (-1, 1)]
    crown = low_head + vector(0.012, 0, -0.04)
    stays += [(crown + s * off, front + s * off) for s in (-1, 1)]
    pairs = np.array(stays)
    yoke = rods([crown - off], [crown + off], 0.014)
    thing = Thing("bicycle")
    thing.add(joined([main, rods(pairs[:, 0], pairs[:, 1], 0.009), yoke]), colour)
    tyre, spokes = wheel(r)
    for centre in (rear, front):
        thing.add(placed(tyre, centre, turn=np.pi / 2), RUBBER)
        thing.add(placed(spokes, centre, turn=np.pi / 2), STEEL)
    stem = head + vector(-0.03, 0, 0.09)
    half = np.array([(stem[0] + 0.03, 0, stem[2]), (stem[0] + 0.03, 0.1, stem[2] + 0.02),
                     (stem[0] - 0.02, 0.22, stem[2] + 0.07), (stem[0] - 0.15, 0.27,
                         stem[2] + 0.06)])  # fmt: skip
    bar = np.concatenate([half[:0:-1] * [1, -1, 1], half])
    grips = [
        tube(half[-2:] * [1, s, 1] + np.array([[-0.04, 0, 0], [-0.002, 0, 0]]), 0.016, 8)
        for s in (-1, 1)
    ]
    thing.add(
        joined([tube(rounded(bar), 0.011, 8), rods([head], [stem + vector(0.03, 0, 0)], 0.012)]),
        CHROME,
    )
    sit = _saddle(saddle)
    thing.add(joined([*grips, sit]), style.leather if rng.uniform() < 0.5 else BLACK)
    _drive(thing, rng, crank, rear)
    if rng.uniform() < 0.6:
        _mudguards(thing, r, rear, front, colour)
    return centred(thing)


def _saddle(at: np.ndarray) -> Mesh:
    """A saddle, broad behind and narrow before (+x)."""
    u = np.linspace(-1, 1, 9)[:, None]
    v = np.linspace(0, 1, 9)
    half = np.interp(v, [0, 0.25, 0.6, 1], [0.05, 0.085, 0.03, 0.018])
    points = np.empty((9, 9, 3))
    points[..., 0] = at[0] - 0.13 + 0.28 * v
    points[..., 1] = half * u
    points[..., 2] = (
        at[2] + 0.02 - 0.05 * u**2 * np.interp(v, [0, 1], [0.6, 1]) + 0.015 * (1 - v) ** 3
    )
    return cloth(points.transpose(1, 0, 2), 0.012)


def _drive(thing: Thing, rng: np.random.Generator, crank: np.ndarray, rear: np.ndarray) -> None:
    """Chain wheel, cranks with pedals, and the chain."""
    disc = revolve([(0, 0), (0.095, 0), (0.095, 0.004), (0, 0.004)], 28)
    cog = revolve([(0, 0), (0.035, 0), (0.035, 0.004), (0, 0.004)], 16)
    y = -0.05
    a = float(rng.uniform(0, 2 * np.pi))
    arm = 0.17 * np.array([np.cos(a), 0, np.sin(a)])
    out = np.array([0, 0.07, 0])
    parts = [placed(disc, crank + vector(0, y, 0), lean=np.pi / 2), placed(cog, rear + vector(0,
        y, 0), lean=np.pi / 2),
             rods([crank - out, crank + out], [crank - out + arm, crank + out - arm], 0.009),
             rods([crank - out], [crank + out], 0.014)]  # fmt: skip
    chain = [rods([rear + vector(0, y - 0.002, s * 0.035)], [crank + vector(0, y - 0.002,
        s * 0.095)], 0.0035, sides=5)
             for s in (-1, 1)]  # fmt: skip
    thing.add(joined([*parts, *chain]), STEEL)
    centre = [crank - 1.6 * out + arm, crank + 1.6 * out - arm]
    pedals = [(p[0] - 0.045, p[0] + 0.045, p[1] - 0.045, p[1] + 0.045, p[2] - 0.012, p[2] + 0.012)
              for p in centre]  # fmt: skip
    thing.add(boards(pedals, 0.003), BLACK)


def _mudguards(
    thing: Thing, r: float, rear: np.ndarray, front: np.ndarray, colour: Material
) -> None:
    """Bent strips over the wheels."""
    for centre, a, b in ((rear, 0.25, 1.05), (front, 0.35, 0.95)):
        turn = np.linspace(a * np.pi, b * np.pi, 15)
        path = np.stack([np.cos(turn), 0 * turn, np.sin(turn)], -1) * (r + 0.018) + centre
        thing.add(plank(path, (0, 0.05, 0), 0.002), colour)


def exercise_bike(rng: np.random.Generator, style: Style) -> Thing:
    """A home trainer: feet, flywheel in a shell, saddle, bars, a small screen."""
    colour = style.accent if rng.uniform() < 0.4 else BLACK
    thing = Thing("exercise bike")
    feet = rods(
        [(x, -0.25, 0.03) for x in (-0.45, 0.45)], [(x, 0.25, 0.03) for x in (-0.45, 0.45)], 0.03
    )
    caps = rods([(x, s * 0.2, 0.034) for x in (-0.45, 0.45) for s in (-1, 1)],
                [(x, s * 0.27, 0.034) for x in (-0.45, 0.45) for s in (-1, 1)], 0.034)  # fmt: skip
    beam = rods([(-0.45, 0, 0.04), (-0.16, 0, 0.1), (0.2, 0, 0.2)],
                [(0.45, 0, 0.06), (-0.24, 0, 0.72), (0.36, 0, 1.0)], 0.03, sides=10)  # fmt: skip
    post = rods([(-0.24, 0, 0.7)], [(-0.26, 0, 0.82)], 0.018)
    thing.add(joined([feet, beam]), colour if colour is not BLACK else STEEL)
    disc = revolve(
        [(0, -0.03), (0.2, -0.03), (0.215, -0.02), (0.215, 0.02), (0.2, 0.03), (0, 0.03)], 36
    )
    shell_ = cushion((0.62, 0.13, 0.3), (-0.02, 0, 0.28), square=0.5)
    thing.add(
        placed(disc, (0.28, 0, 0.29), lean=np.pi / 2), STEEL if rng.uniform() < 0.5 else colour
    )
    thing.add(joined([shell_, caps, post, _saddle(np.array([-0.27, 0, 0.84]))]), BLACK)
    half = np.array([(0.37, 0, 1.0), (0.36, 0.1, 1.02), (0.42, 0.2, 1.06), (0.5, 0.2, 1.12)])
    bar = np.concatenate([half[:0:-1] * [1, -1, 1], half])
    thing.add(tube(rounded(bar), 0.015, 8), BLACK)
    screen = boards([(-0.02, 0.02, -0.1, 0.1, 0, 0.15)], 0.008)
    glass = boards([(-0.022, -0.015, -0.085, 0.085, 0.02, 0.13)])
    thing.add(placed(screen, (0.4, 0, 1.03), tilt=0.45), BLACK)
    thing.add(
        placed(glass, (0.4, 0, 1.03), tilt=0.45),
        Material((0.1, 0.14, 0.12), specular=0.1, gloss=300.0),
    )
    a = float(rng.uniform(0, 2 * np.pi))
    arm, crank, out = (
        0.17 * np.array([np.cos(a), 0, np.sin(a)]),
        np.array([0.02, 0, 0.29]),
        np.array([0, 0.09, 0]),
    )
    cranks = rods(
        [crank - out, crank + out, crank - out],
        [crank - out + arm, crank + out - arm, crank + out],
        0.01,
    )
    centre = [crank - 1.5 * out + arm, crank + 1.5 * out - arm]
    pedals = [
        (p[0] - 0.05, p[0] + 0.05, p[1] - 0.045, p[1] + 0.045, p[2] - 0.015, p[2] + 0.015)
        for p in centre
    ]
    return centred(thing.add(joined([cranks, boards(pedals, 0.004)]), STEEL))
