"""Flat things on walls: paintings, mirrors, posters, maps, calendars, boards."""

import numpy as np
from numpy.typing import ArrayLike

from cmtof.scenes.rooms.materials import Colour, Material, Style, darker, hue, wood
from cmtof.scenes.rooms.pliant import (
    Points,
    against_wall,
    bars,
    grid,
    hung,
    moved_by,
    ripples,
    slab,
)
from cmtof.scenes.rooms.shades import BLACK, Maker
from cmtof.scenes.rooms.solids import box, cylinder, joined, quads, tube
from cmtof.scenes.rooms.thing import Mesh, Thing

PAPER = Material((0.8, 0.79, 0.75), specular=0.0)
GILT = Material((0.5, 0.34, 0.1), (0.36, 0.22, 0.05), "noise", 0.03, 0.35, 40.0, bump=0.3)
SILVERED = Material((0.85, 0.86, 0.86), specular=0.95, gloss=3000.0)


def frame(width: float, height: float, profile: ArrayLike) -> Mesh:
    """Four mitred mouldings around an opening of that size, in the plane y = 0.

    Parameters
    ----------
    width, height : float
        Of the opening, m.
    profile : array_like, shape (N, 2)
        Points (outwards from the opening, forward from the wall), m, from the back edge outside
        over the front to the rebate inside.
    """
    out, forward = np.asarray(profile, float).T
    a, b = width / 2, height / 2
    sides = []
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    for start, end in zip(corners, np.roll(corners, -1, 0), strict=True):
        points = np.empty((2, len(out), 3))
        for row, corner in zip(points, (start, end), strict=True):
            row[:, 0], row[:, 2] = corner[0] * (a + out), corner[1] * (b + out)
            row[:, 1] = -forward
        sides.append(_creased(points))
    return joined(sides)


def _creased(points: Points) -> Mesh:
    """A strip (2, N, 3) with an edge along every one of its lines."""
    low, high = points
    return quads(np.stack([low[:-1], high[:-1], high[1:], low[1:]], axis=1))


def moulding(rng: np.random.Generator, wide: float, deep: float) -> Points:
    """Profile of a picture frame: flat, bevelled, stepped or rounded."""
    w, d = wide, deep
    forms = (
        [(w, 0), (w, d), (0, d), (0, 0.3 * d)],
        [(w, 0), (w, d), (0.75 * w, d), (0.1 * w, 0.55 * d), (0, 0.55 * d), (0, 0.3 * d)],
        [(w, 0), (w, 0.6 * d), (0.8 * w, d), (0.55 * w, d), (0.5 * w, 0.75 * d),
         (0.25 * w, 0.6 * d), (0.12 * w, 0.7 * d), (0, 0.6 * d), (0, 0.3 * d)],
        [(w, 0), (0.97 * w, 0.4 * d), (0.8 * w, 0.8 * d), (0.5 * w, d), (0.2 * w, 0.8 * d),
         (0.03 * w, 0.45 * d), (0, 0.3 * d)],
    )  # fmt: skip
    return np.array(forms[int(rng.integers(len(forms)))])


def rectangle(width: float, height: float, y: float) -> Mesh:
    """A flat face towards -y about the origin, m."""
    a, b = width / 2, height / 2
    return quads([[(-a, y, -b), (a, y, -b), (a, y, b), (-a, y, b)]])


def motif(rng: np.random.Generator, size: float) -> Material:
    """What is painted or printed: patches, marks, bands, dots; oil, ink or grey print."""
    base = hue(
        float(rng.uniform()), float(rng.choice([0.0, 0.25, 0.6])), float(rng.uniform(0.15, 0.6))
    )
    other: Colour = (
        (0.75, 0.72, 0.65) if rng.uniform() < 0.4 else darker(base, float(rng.choice([0.2, 2.0])))
    )
    kind = str(rng.choice(["picture", "picture", "picture", "marble", "noise", "dots", "stripes"]))
    shine = float(rng.choice([0.0, 0.03, 0.08]))
    return Material(base, other, kind, size * float(rng.uniform(0.25, 0.6)), shine, 60.0, bump=0.1)


def _wood_or(rng: np.random.Generator, style: Style) -> Material:
    white = Material((0.78, 0.77, 0.75), specular=0.05, gloss=40.0)
    return (style.wood, BLACK, white, GILT, wood(rng), style.metal)[int(rng.integers(6))]


def _framed(
    rng: np.random.Generator, style: Style, thing: Thing, width: float, height: float,
    x: float = 0.0, z: float = 0.0, rim: Material | None = None,
) -> None:  # fmt: skip
    """Add a picture of that outer size about (x, z): frame, mat if any, print."""
    wide = float(np.clip(rng.uniform(0.015, 0.07), 0.0, 0.16 * min(width, height)))
    deep = float(rng.uniform(0.018, 0.035))
    a, b = width - 2 * wide, height - 2 * wide
    rim = rim or _wood_or(rng, style)
    thing.add(moved_by(frame(a, b, moulding(rng, wide, deep)), x, 0, z), rim)
    thing.add(moved_by(rectangle(width - wide, height - wide, -0.001), x, 0, z), BLACK)
    mat = float(rng.choice([0.0, 0.12, 0.2])) * min(a, b) if wide < 0.05 else 0.0
    if mat > 0:
        band = [(mat - 1e-3, 0.0), (mat - 1e-3, 0.006), (0.0, 0.006), (-0.0015, 0.0042)]
        thing.add(moved_by(frame(a - 2 * mat, b - 2 * mat, band), x, 0, z), PAPER)
    picture = rectangle(a - 2 * mat, b - 2 * mat, -0.004)
    thing.add(moved_by(picture, x, 0, z), motif(rng, min(a, b)))


def painting(rng: np.random.Generator, style: Style, *, width: float | None = None) -> Thing:
    """A framed picture, or a bare canvas on its stretcher.

    Parameters
    ----------
    width : float, optional
        Outer width, m.
    """
    thing = Thing("painting")
    drawn = float(rng.uniform(0.3, 1.2) if rng.uniform() < 0.8 else rng.uniform(1.2, 1.6))
    width = drawn if width is None else width
    height = width * float(rng.choice([0.62, 0.75, 1.0, 1.3] if width < 0.8 else [0.5, 0.62, 0.75]))
    if rng.uniform() < 0.22:
        canvas = box((width, 0.034, height), (0, -0.018, 0), bevel=0.003)
        thing.add(canvas, motif(rng, min(width, height)))
        return thing
    _framed(rng, style, thing, width, height)
    return thing


def picture_group(rng: np.random.Generator, style: Style) -> Thing:
    """Three to seven frames: in a row, in a grid, or about a middle line."""
    thing = Thing("picture_group")
    rim = _wood_or(rng, style) if rng.uniform() < 0.6 else None
    kind = int(rng.integers(3))
    if kind == 0:
        w, h = float(rng.uniform(0.22, 0.36)), float(rng.uniform(0.28, 0.48))
        count = int(rng.integers(3, 5))
        spots = [((k - (count - 1) / 2) * (w + 0.06), 0.0, w, h) for k in range(count)]
    elif kind == 1:
        w, h = float(rng.uniform(0.2, 0.3)), float(rng.uniform(0.2, 0.36))
        columns = int(rng.integers(2, 4))
        spots = [((c - (columns - 1) / 2) * (w + 0.05), (r - 0.5) * (h + 0.05), w, h)
                 for r in range(2) for c in range(columns)]  # fmt: skip
    else:
        spots = _salon(rng, int(rng.integers(4, 8)))
    for x, z, w, h in spots:
        _framed(rng, style, thing, w, h, x, z, rim)
    return hung(thing)


def _salon(rng: np.random.Generator, count: int) -> list[tuple[float, float, float, float]]:
    """Frames of all sizes above and below a line, side by side."""
    spots = []
    for row in (-1, 1):
        x = float(rng.uniform(0, 0.12))
        for _ in range((count + (row > 0)) // 2):
            w, h = float(rng.uniform(0.18, 0.42)), float(rng.uniform(0.18, 0.42))
            spots.append((x + w / 2, row * (h / 2 + 0.025), w, h))
            x += w + 0.05
    return spots


def mirror(rng: np.random.Generator, style: Style) -> Thing:
    """A looking-glass: framed, round, arched, or with a bevelled edge only."""
    thing = Thing("mirror")
    kind = int(rng.integers(5))
    width = float(rng.uniform(0.4, 0.8))
    height = width * float(rng.uniform(1.2, 1.8))
    if kind < 2:
        wide = float(rng.uniform(0.03, 0.09))
        thing.add(frame(width, height, moulding(rng, wide, 0.03)), _wood_or(rng, style))
        thing.add(rectangle(width + 0.01, height + 0.01, -0.012), SILVERED)
        thing.add(rectangle(width + wide, height + wide, -0.001), BLACK)
        return thing
    if kind == 2:
        thing.add(box((width, 0.012, height), (0, -0.007, 0), bevel=0.004), SILVERED)
        return thing
    t = np.linspace(0, 2 * np.pi, 49)[:-1]
    r = width / 2
    if kind == 3:
        ring = np.stack([r * np.cos(t), r * np.sin(t)], -1)
    else:  # arched: a round head on an oblong
        x, z = r * np.cos(t), r * np.sin(t)
        ring = np.stack([x, np.where(z > 0, z + (height - width) / 2, np.sign(z) * (height - r) + (height - width) / 2)], -1)  # fmt: skip  # noqa: E501
        ring[:, 1] = np.where(np.sin(t) < -1e-9, -height / 2, ring[:, 1])
        ring[np.sin(t) < -1e-9, 0] = r * np.clip(np.cos(t[np.sin(t) < -1e-9]) * 1.42, -1, 1)
    thing.add(_disc(ring, 0.014), SILVERED)
    closed = np.concatenate([ring, ring[:2]])
    path = np.stack([closed[:, 0], np.full(len(closed), -0.014), closed[:, 1]], -1)
    thing.add(tube(path, float(rng.uniform(0.008, 0.014)), 8, capped=False), style.metal if rng.uniform() < 0.6 else style.wood)  # fmt: skip  # noqa: E501
    return thing


def _disc(ring: Points, forward: float) -> Mesh:
    """A convex outline (N, 2) in x and z filled as a face towards -y, and its edge to the wall."""
    n = len(ring)
    rim = np.column_stack([ring[:, 0], np.full(n, -forward), ring[:, 1]])
    middle = rim.mean(axis=0, keepdims=True)
    k = np.arange(n)
    faces = np.stack([np.full(n, n), k, (k + 1) % n], -1).astype(np.int32)
    face = Mesh(np.concatenate([rim, middle]).astype(np.float32), faces)
    back = rim * [1, 0, 1] - [0, 0.001, 0]
    edge = quads(np.stack([rim, back, np.roll(back, -1, 0), np.roll(rim, -1, 0)], axis=1))
    return joined([face, edge])


def poster(rng: np.random.Generator, style: Style) -> Thing:
    """A sheet on the wall, curling a little at its corners, on pins, tape or between rails."""
    thing = Thing("poster")
    width = float(rng.uniform(0.4, 0.75))
    height = width * float(rng.choice([1.41, 1.41, 1.5, 0.71]))
    thing.add(_hung_sheet(rng, width, height, 0.012), motif(rng, width))
    if rng.uniform() < 0.6:
        caption = (0.6 * width, 0.16 * height)
        ink = Material((0.75, 0.73, 0.68), (0.05, 0.05, 0.05), "marks", 0.035, 0.0)
        thing.add(moved_by(rectangle(*caption, -0.016), 0, 0, -0.36 * height), ink)
    corners = [(sx * 0.47 * width, sz * 0.48 * height) for sx in (-1, 1) for sz in (-1, 1)]
    if rng.uniform() < 0.4:
        rails = [
            box((width + 0.03, 0.012, 0.022), (0, -0.016, s * height / 2), bevel=0.002)
            for s in (-1, 1)
        ]
        thing.add(joined(rails), style.wood)
        ends = np.array([(-0.35 * width, -0.012, height / 2), (0.35 * width, -0.012, height / 2)])
        thing.add(bars(ends, np.tile([0, -0.004, height / 2 + 0.1], (2, 1)), 0.0012), BLACK)
        return thing
    pins = [against_wall(cylinder(0.005, 0.012, (x, z, 0.012), sides=8)) for x, z in corners]
    thing.add(joined(pins), style.accent)
    return thing


def _hung_sheet(rng: np.random.Generator, width: float, height: float, curl: float) -> Mesh:
    """Paper that lies on the wall but for its corners."""
    u, v = grid(-width / 2, width / 2, -height / 2, height / 2, 15, 17)
    far = np.clip(np.abs(2 * u / width) + np.abs(2 * v / height) - 1.45, 0, 1) / 0.55
    lift = 0.003 + curl * far**2 * (v < 0) + 0.0015 * (1 + ripples(rng, u, v, 5, 0.8))
    return slab(np.stack([u, -lift - 5e-4, v], -1), 5e-4)


def map_(rng: np.random.Generator, style: Style) -> Thing:
    """A map: land and water in patches, lettering and a border; framed or on rods."""
    thing = Thing("map")
    width = float(rng.uniform(0.7, 1.3))
    height = width * float(rng.choice([0.6, 0.7, 1.3]))
    land = Material((0.55, 0.5, 0.3), (0.2, 0.36, 0.5), "picture", 0.3 * width, 0.02)
    thing.add(rectangle(width, height, -0.006), PAPER)
    thing.add(rectangle(0.94 * width, height - 0.06 * width, -0.0065), land)
    ink = Material((0.78, 0.76, 0.68), (0.08, 0.06, 0.05), "marks", 0.03, 0.0)
    thing.add(
        moved_by(rectangle(0.2 * width, 0.16 * height, -0.007), 0.33 * width, 0, -0.33 * height),
        ink,
    )
    if rng.uniform() < 0.5:
        thing.add(frame(width, height, moulding(rng, 0.02, 0.02)), _wood_or(rng, style))
    else:
        rods = [against_wall(cylinder(0.001, 0.001))]
        ends = [
            np.array([(s * (width / 2 + 0.03), -0.012, t * height / 2) for s in (-1, 1)])
            for t in (-1, 1)
        ]
        rods = [tube(pair, 0.011, 10) for pair in ends]
        thing.add(joined(rods), style.wood)
    return thing


def calendar(rng: np.random.Generator, style: Style) -> Thing:
    """A picture above a sheet of days, bound with a wire, on a nail."""
    thing = Thing("calendar")
    width = float(rng.uniform(0.24, 0.34))
    half = width * float(rng.uniform(0.6, 0.8))
    days = Material((0.8, 0.79, 0.76), (0.06, 0.06, 0.06), "marks", width / 9, 0.0)
    for z, skin in ((half / 2, motif(rng, half)), (-half / 2, days)):
        leaf = _hung_sheet(rng, width, half - 0.012, 0.018)
        thing.add(moved_by(leaf, 0, 0, z), skin)
    x = np.linspace(-0.46, 0.46, 22) * width
    t = np.linspace(0, 2 * np.pi, 9)[:-1]
    loop = np.stack([0 * t, 0.007 * np.cos(t) - 0.008, 0.009 * np.sin(t)], -1)
    starts = (loop[None] + np.stack([x, 0 * x, 0 * x], -1)[:, None]).reshape(-1, 3)
    ends = (np.roll(loop, -1, 0)[None] + np.stack([x, 0 * x, 0 * x], -1)[:, None]).reshape(-1, 3)
    thing.add(bars(starts, ends, 0.0008, 3), BLACK)
    thing.add(against_wall(cylinder(0.003, 0.02, (0, half - 0.012, 0.012), sides=8)), style.metal)
    return thing


def whiteboard(rng: np.random.Generator, style: Style) -> Thing:
    """A white or black board with a tray, pens, and something written on it."""
    thing = Thing("whiteboard")
    width = float(rng.uniform(0.9, 1.6))
    height = width * 0.66
    black = rng.uniform() < 0.3
    face = BLACK if black else Material((0.82, 0.83, 0.83), specular=0.1, gloss=120.0)
    thing.add(rectangle(width, height, -0.01), face)
    aluminium = Material((0.5, 0.5, 0.51), specular=0.5, gloss=40.0)
    thing.add(frame(width, height, [(0.022, 0), (0.022, 0.02), (0, 0.02), (0, 0.006)]),
              style.wood if black else aluminium)  # fmt: skip
    thing.add(
        box((0.5 * width, 0.06, 0.012), (0, -0.045, -height / 2 - 0.02), bevel=0.003), aluminium
    )
    pens = []
    for k in range(int(rng.integers(2, 5))):
        x, y = (0.12 * k - 0.2) * width, -0.05 + float(rng.uniform(-0.01, 0.01))
        pens.append(
            tube([(x, y, -height / 2 - 0.006), (x + 0.12, y, -height / 2 - 0.006)], 0.008, 8)
        )
    thing.add(joined(pens), style.accent)
    for _ in range(int(rng.integers(1, 5))):
        w, h = float(rng.uniform(0.15, 0.4)) * width, float(rng.uniform(0.15, 0.35)) * height
        x, z = (float(rng.uniform(-0.5, 0.5)) * (s - t) for s, t in ((width, w), (height, h)))
        pen = hue(float(rng.uniform()), 0.8, 0.15) if not black else (0.7, 0.7, 0.7)
        ink = Material(
            face.colour, pen, "marks", float(rng.uniform(0.03, 0.06)), face.specular, face.gloss
        )
        thing.add(moved_by(rectangle(w, h, -0.0104 - 2e-4 * len(thing.parts)), x, 0, z), ink)
    return thing


CATALOGUE: dict[str, Maker] = {
    "painting": painting,
    "picture_group": picture_group,
    "mirror": mirror,
    "poster": poster,
    "map": map_,
    "calendar": calendar,
    "whiteboard": whiteboard,
}
