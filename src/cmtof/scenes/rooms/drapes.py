"""What hangs in front of windows: curtains with folds, roller, venetian and roman blinds.

Each hangs centred in x, its rod or head rail at z = 0, its back at y = 0, and reaches down.
"""

from collections.abc import Callable

import numpy as np

from cmtof.scenes.rooms.bars import bar, bars
from cmtof.scenes.rooms.materials import Material, Style, darker, fabric, hue
from cmtof.scenes.rooms.solids import ball, box, faceted, joined, sheet, tube
from cmtof.scenes.rooms.thing import Mesh, Thing, moved, pose

Maker = Callable[..., Thing]


def curtains(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
    drop: float | None = None,
    drawn: float | None = None,
) -> Thing:
    """Two curtains on a rod, pushed aside or drawn.

    Parameters
    ----------
    width : float
        Between the rod's ends, m.
    drop : float
        From the rod to the hem, m.
    drawn : float
        Share of the width that each covers, 0.1 to 0.5.
    """
    width = float(rng.uniform(1.6, 2.8)) if width is None else width
    drop = float(rng.uniform(1.4, 2.3)) if drop is None else drop
    drawn = float(rng.uniform(0.12, 0.32)) if drawn is None else drawn
    cloth = _cloth(rng, style)
    thing = Thing("curtain")
    tied = rng.uniform() < 0.3 and drop > 1.5
    reach = max(drawn * width, 0.18)
    folds = int(np.clip(round(reach / 0.08), 4, 8))
    for side in (-1, 1):
        if tied:
            hem = _tieback(reach, drop)
            band = _band(side * (width / 2 - 0.11 * reach - 0.04), 0.62 * drop, 0.13 * reach + 0.05)
            thing.add(band, style.accent if rng.uniform() < 0.3 else cloth)
        else:
            hem = _straight(rng)
        panel = _folded(rng, reach, drop - 0.02, folds, hem)
        x = side * (width / 2 - 0.03)
        thing.add(_mirrored(panel, side, x), cloth, grain=2)
    _rod(thing, style, width, reach, folds)
    return thing


def _cloth(rng: np.random.Generator, style: Style) -> Material:
    if rng.uniform() < 0.4:
        value = float(rng.choice([0.85, 0.75, 0.6]))
        base = hue(float(rng.uniform(0.05, 0.2)), float(rng.uniform(0, 0.15)), value)
        return Material(base, darker(base, 0.9), "weave", 0.004, 0.0)
    return (style.fabric, style.second_fabric, fabric(rng))[int(rng.integers(3))]


def _straight(rng: np.random.Generator) -> Callable[[np.ndarray], np.ndarray]:
    flare = float(rng.uniform(-0.1, 0.25))
    return lambda t: 1 + flare * t


def _tieback(reach: float, drop: float) -> Callable[[np.ndarray], np.ndarray]:
    """Width over height of a curtain that is tied back at 62 % of its drop."""
    return lambda t: np.where(
        t < 0.62, 1.15 - 0.9 * (t / 0.62) ** 3, 0.25 + 0.5 * np.sqrt(np.maximum(t - 0.62, 0) / 0.38)
    )


def _folded(
    rng: np.random.Generator,
    reach: float,
    drop: float,
    folds: int,
    hem: Callable[[np.ndarray], np.ndarray],
) -> Mesh:
    """One curtain from x = 0 to ``reach``: pinched at the rod, waves that grow and wander down."""
    t = np.linspace(0, 1, 10)[:, None]
    s = np.linspace(0, 1, 6 * folds + 1)[None]
    wander = np.cumsum(rng.normal(0, 0.12, (10, 1)), 0) * t
    wobble = np.interp(s[0], np.linspace(0, 1, 7), rng.normal(0, 0.9, 7))[None] * t
    phase = 2 * np.pi * folds * s + 0.6 * wander + wobble
    size = np.interp(s[0], np.linspace(0, 1, folds + 1), rng.uniform(0.6, 1.2, folds + 1))[None]
    depth = np.clip(0.35 * reach / folds, 0.012, 0.05)
    amplitude = depth * (0.45 + 0.55 * t**0.7) * size
    squeeze = hem(t)
    amplitude = amplitude * np.minimum(1, 0.35 + 0.65 * squeeze)
    points = np.empty((10, s.shape[1], 3))
    points[..., 0] = s * reach * squeeze + 0.2 * amplitude * squeeze * np.sin(2 * phase)
    points[..., 1] = -0.075 + amplitude * np.sin(phase)
    points[..., 2] = -0.012 - t * (drop + 0.006 * np.sin(phase + 1))
    return sheet(points, thickness=0.0015)


def _mirrored(mesh: Mesh, side: int, x: float) -> Mesh:
    """A panel that grows from x towards the middle."""
    if side < 0:
        return moved(mesh, pose(x))
    vertices = mesh.vertices * np.array([-1, 1, 1], np.float32) + np.array([x, 0, 0], np.float32)
    return Mesh(vertices.astype(np.float32), mesh.faces[:, ::-1].copy())


def _band(x: float, low: float, wide: float) -> Mesh:
    """The loop that ties a curtain to the wall."""
    angle = np.linspace(0, 2 * np.pi, 15)[:-1]
    ring = np.stack([x + 0.5 * wide * np.cos(angle), -0.062 + 0.058 * np.sin(angle), 0 * angle], -1)
    rows = np.stack([ring - [0, 0, low + 0.03], ring - [0, 0, low - 0.03]])
    return sheet(rows[:, ::-1], closed=True, thickness=0.003)


def _rod(thing: Thing, style: Style, width: float, reach: float, folds: int) -> None:
    """The rod with knobs at its ends, brackets, and a ring for every fold."""
    a = width / 2 + 0.05
    parts = [bar((-a, -0.075, 0.012), (a, -0.075, 0.012), 0.012, 10)]
    parts += [ball(0.024, (s * a, -0.075, 0.012), 2) for s in (-1, 1)]
    for s in (-1, 1):
        x = s * (width / 2 + 0.01)
        parts.append(bar((x, -0.075, 0.012), (x, -0.002, 0.012), 0.007))
        parts.append(box((0.04, 0.006, 0.07), (x, -0.003, 0.012), bevel=0.002))
        at = s * (width / 2 - 0.03 - np.arange(folds + 1) * reach / folds)
        rings = np.stack([at, 0 * at - 0.075, 0 * at + 0.006], 1)
        half = np.array([0.003, 0.0, 0.0])
        parts.append(bars(rings - half, rings + half, 0.022, 10))
    thing.add(joined(parts), style.metal)


def roller_blind(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
    drop: float | None = None,
) -> Thing:
    """A cloth from a roller, weighted by a bar, with a chain."""
    width = float(rng.uniform(0.8, 1.6)) if width is None else width
    drop = float(rng.uniform(0.3, 1.2)) if drop is None else drop
    cloth = Material(hue(float(rng.uniform()), float(rng.uniform(0, 0.2)), 0.6), specular=0.0)
    thing = Thing("blind")
    roll = bar((-width / 2 + 0.012, -0.04, -0.03), (width / 2 - 0.012, -0.04, -0.03), 0.022, 14)
    hanging = box((width - 0.03, 0.0012, drop), (0, -0.062, -0.03 - drop / 2))
    thing.add(joined([roll, hanging]), cloth)
    weight = box((width - 0.026, 0.012, 0.026), (0, -0.062, -0.03 - drop), bevel=0.003)
    ends = [box((0.006, 0.07, 0.065), (s * width / 2, -0.037, -0.03)) for s in (-1, 1)]
    thing.add(joined([weight, *ends]), style.trim)
    x = width / 2 - 0.002
    loop = [
        (x, -0.055, -0.03),
        (x, -0.056, -0.6),
        (x, -0.04, -0.63),
        (x, -0.025, -0.6),
        (x, -0.025, -0.03),
    ]
    return thing.add(tube(loop, 0.002, 5), style.metal)


def venetian_blind(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
    drop: float | None = None,
) -> Thing:
    """Tilted slats on cords, at most 40."""
    width = float(rng.uniform(0.7, 1.6)) if width is None else width
    drop = float(rng.uniform(0.5, 1.4)) if drop is None else drop
    pitch = max(float(rng.choice([0.025, 0.04, 0.05])), (drop - 0.06) / 40)
    slat, tilt = 1.12 * pitch, float(rng.choice([0.15, 0.5, 0.9, -0.6]))
    count = max(2, int((drop - 0.06) / pitch))
    material = (style.trim, style.wood, style.metal, style.paint)[int(rng.integers(4))]
    u = np.array([-0.5, -0.17, 0.17, 0.5, 0.5, 0.17, -0.17, -0.5])
    lift = 0.06 * slat * (1 - 4 * u**2) + 0.0006 * np.array([1, 1, 1, 1, -1, -1, -1, -1])
    c, s = np.cos(tilt), np.sin(tilt)
    section = np.stack([u * slat, lift], -1) @ np.array([[c, s], [-s, c]])
    points = np.empty((2, 8, 3))
    points[..., 0] = np.array([[-0.5], [0.5]]) * (width - 0.02)
    points[..., 1:] = section
    one = faceted(sheet(points, closed=True))
    z = -0.05 - pitch * (np.arange(count) + 0.5)
    # cords stretch, so no two slats hang quite alike
    slack = rng.normal(0, 0.0008, count)
    slats = [moved(one, pose(0, -0.04 + float(d), float(h))) for d, h in zip(slack, z, strict=True)]
    thing = Thing("blind").add(joined(slats), material, grain=0)
    low = float(z[-1]) - pitch
    rails = [box((width, 0.05, 0.04), (0, -0.04, -0.02), bevel=0.003)]
    rails.append(box((width - 0.02, 0.04, 0.018), (0, -0.04, low), bevel=0.003))
    thing.add(joined(rails), material)
    cords = [
        bar((x * width, y, -0.03), (x * width, y, low), 0.0012, 4)
        for x in (-0.38, 0.38)
        for y in (-0.04 - slat / 2, -0.04 + slat / 2)
    ]
    return thing.add(joined(cords), style.trim)


def roman_shade(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
    drop: float | None = None,
) -> Thing:
    """A cloth that gathers in soft horizontal folds at its foot."""
    width = float(rng.uniform(0.7, 1.6)) if width is None else width
    drop = float(rng.uniform(0.4, 1.2)) if drop is None else drop
    folds = int(rng.integers(2, 6))
    t = np.linspace(0, 1, 14 + 8 * folds)
    gathered = np.clip((t - 0.45) / 0.55, 0, 1)
    bulge = gathered * 0.035 * (1 - np.cos(2 * np.pi * folds * gathered)) / 2
    sag = 0.012 * np.cos(np.linspace(-np.pi / 2, np.pi / 2, 9))
    points = np.empty((len(t), 9, 3))
    points[..., 0] = np.linspace(-width / 2, width / 2, 9)
    points[..., 1] = -0.02 - (bulge + 0.3 * gathered * 0.035)[:, None] * (0.9 + 8 * sag)
    points[..., 2] = -drop * t[:, None] - sag * gathered[:, None]
    thing = Thing("blind").add(sheet(points, thickness=0.002), _cloth(rng, style), grain=2)
    return thing.add(box((width + 0.004, 0.03, 0.03), (0, -0.016, 0.0), bevel=0.003), style.trim)


CATALOGUE: dict[str, Maker] = {
    "curtains": curtains,
    "roller_blind": roller_blind,
    "venetian_blind": venetian_blind,
    "roman_shade": roman_shade,
}
