"""Solid things on walls: clocks, hooks with coats, plates, boards for keys and darts, letters."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.foliage import HEART, STALK, Leaves, green, leaves, round_about, stems
from cmtof.scenes.rooms.materials import Material, Style, ceramic, fabric, hue
from cmtof.scenes.rooms.pliant import Points, against_wall, bars, moved_by, spline
from cmtof.scenes.rooms.shades import BLACK, BRASS, Maker
from cmtof.scenes.rooms.solids import (
    ball,
    box,
    cylinder,
    joined,
    prism,
    quads,
    revolve,
    sheet,
    tube,
)
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.wall_art import PAPER, rectangle

STEEL = Material((0.5, 0.5, 0.51), specular=0.6, gloss=80.0)


def _hand(angle: float, length: float, width: float, y: float) -> Mesh:
    """A clock's hand from a little behind the centre, in the plane y."""
    mesh = box((width, 0.0015, 1.2 * length), (0, y, 0.4 * length))
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    return Mesh((mesh.vertices @ turn).astype(np.float32), mesh.faces)


def _marks(radius: float, y: float) -> Mesh:
    """Twelve strokes around a dial, every third longer."""
    strokes = []
    for k in range(12):
        long = 0.16 if k % 3 == 0 else 0.09
        mesh = box((0.02 * radius if k % 3 else 0.035 * radius, 0.001, long * radius),
                   (0, y, (0.93 - long / 2) * radius))  # fmt: skip
        c, s = np.cos(np.pi * k / 6), np.sin(np.pi * k / 6)
        turn = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
        strokes.append(Mesh((mesh.vertices @ turn).astype(np.float32), mesh.faces))
    return joined(strokes)


def wall_clock(rng: np.random.Generator, style: Style) -> Thing:
    """Round in a rim, square, with rays, or a case with a pendulum."""
    thing = Thing("wall_clock")
    r = float(rng.uniform(0.11, 0.2))
    kind = int(rng.integers(4))
    dark = rng.uniform() < 0.25
    face, ink = (BLACK, PAPER) if dark else (PAPER, BLACK)
    skin = (style.wood, style.metal, style.accent, BLACK)[int(rng.integers(4))]
    y = -0.03
    if kind == 1:
        thing.add(box((2.1 * r, 0.03, 2.1 * r), (0, -0.0155, 0), bevel=0.004), skin)
        thing.add(against_wall(cylinder(0.96 * r, 0.003, (0, 0, 0.0315), sides=40)), face)
    else:
        rim = revolve([(0, 0.001), (1.06 * r, 0.001), (1.1 * r, 0.02), (1.06 * r, 0.042),
                       (r, 0.042), (0.99 * r, 0.03), (0.99 * r, 0.03), (0, 0.03)], 44)  # fmt: skip
        thing.add(against_wall(rim), skin)
        thing.add(against_wall(cylinder(0.985 * r, 0.003, (0, 0, 0.031), sides=40)), face)
    if kind == 2:  # rays
        angle = np.arange(24) * (np.pi / 12)
        out = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], -1)
        reach = np.where(np.arange(24) % 2, 1.6, 1.9)[:, None] * r
        thing.add(
            bars(1.0 * r * out + [0, -0.015, 0], reach * out + [0, -0.015, 0], 0.006, 4, 0.4), skin
        )
    if kind == 3:
        _pendulum(thing, r, style.wood)
    thing.add(_marks(r, y - 0.0035), ink)
    time = float(rng.uniform(0, 12))
    thing.add(_hand(time * np.pi / 6, 0.5 * r, 0.055 * r, y - 0.005), ink)
    thing.add(_hand(time * 2 * np.pi, 0.78 * r, 0.035 * r, y - 0.007), ink)
    thing.add(against_wall(cylinder(0.05 * r, 0.01, (0, 0, 0.035), sides=12)), ink)
    return thing


def _pendulum(thing: Thing, r: float, skin: Material) -> None:
    """A case below the dial with a weight on a rod."""
    w, h = 1.3 * r, 2.6 * r
    z = -r - h / 2 + 0.1 * r
    thing.add(box((w, 0.02, h), (0, -0.011, z), bevel=0.003), skin)
    sides = [box((0.014, 0.06, h), (s * (w / 2 - 0.007), -0.031, z), bevel=0.002) for s in (-1, 1)]
    thing.add(
        joined([*sides, box((w, 0.06, 0.014), (0, -0.031, z - h / 2 + 0.007), bevel=0.002)]), skin
    )
    thing.add(tube([(0, -0.04, -r), (0.01, -0.04, z - 0.3 * h)], 0.003, 6), BRASS)
    thing.add(against_wall(cylinder(0.3 * r, 0.006, (0.01, z - 0.3 * h, 0.042), sides=28)), BRASS)


def coat_hooks(rng: np.random.Generator, style: Style) -> Thing:
    """A board with hooks; coats, scarves, bags and hats hang from some."""
    thing = Thing("coat_hooks")
    count = int(rng.integers(4, 8))
    pitch = float(rng.uniform(0.12, 0.17))
    length = count * pitch
    board = style.wood if rng.uniform() < 0.7 else style.paint
    thing.add(box((length, 0.02, 0.09), (0, -0.011, 0), bevel=0.004), board)
    if rng.uniform() < 0.4:
        thing.add(box((length, 0.2, 0.02), (0, -0.1, 0.12), bevel=0.003), board)
        sides = [
            box((0.02, 0.16, 0.11), (s * (length / 2 - 0.03), -0.08, 0.06), bevel=0.003)
            for s in (-1, 1)
        ]
        thing.add(joined(sides), board)
    hook = spline([(0, -0.02, 0.02), (0, -0.045, 0.0), (0, -0.07, 0.005), (0, -0.08, 0.03)], 9)
    hooks = []
    places = (np.arange(count) - (count - 1) / 2) * pitch
    for x in places:
        hooks += [tube(hook + np.array([x, 0, 0]), 0.005, 6), ball(0.008, hook[-1] + [x, 0, 0], 1)]
    thing.add(joined(hooks), style.metal)
    coats = 0
    for x in rng.permutation(places)[:4]:
        drawn = float(rng.uniform())
        if drawn < 0.35 and coats < 2:
            coats += 1
            _coat(rng, thing, x)
        elif drawn < 0.4:
            _bag(rng, style, thing, x)
        elif drawn < 0.52:
            _scarf(rng, thing, x)
        elif drawn < 0.58:
            _hat(rng, thing, x)
    return thing


def _coat(rng: np.random.Generator, thing: Thing, x: float) -> None:
    """A coat or jacket by its loop: shoulders, folds to the hem, two sleeves."""
    tall, wide = float(rng.uniform(0.65, 1.05)), float(rng.uniform(0.36, 0.46))
    cover = fabric(rng)
    s, t = np.meshgrid(
        np.linspace(0, 1, 15), np.linspace(0, 2 * np.pi, 32, endpoint=False), indexing="ij"
    )
    breadth = wide / 2 * np.interp(s, [0, 0.03, 0.12, 0.3, 1.0], [0.1, 0.25, 0.72, 0.8, 0.95])
    deep = np.interp(s, [0, 0.1, 1.0], [0.02, 0.06, 0.075])
    fold = 1 + 0.14 * s * np.sin(6 * t + rng.uniform(0, 6)) + 0.07 * s * np.sin(9 * t + 3 * s)
    points = np.stack(
        [x + breadth * np.cos(t) * fold, -0.085 - deep * np.sin(t) * fold, 0.03 - tall * s], -1
    )
    points[..., 1] = np.minimum(points[..., 1], -0.005)
    points[0] = points[0].mean(axis=0)
    hem, middle = points[-1:], points[-1].mean(axis=0)
    inner = middle + 0.94 * (hem - middle) + [0, 0, 0.003]  # closed some way up inside
    deep = np.broadcast_to(middle + np.array([0, 0, 0.1 * tall]), hem.shape)
    whole = np.concatenate([points, hem, inner, inner, deep])[:, ::-1]
    thing.add(sheet(whole, closed=True), cover)
    for side in (-1, 1):
        a, b, c = x + side * wide * np.array([0.3, 0.46, 0.5])
        shoulder = [(a, -0.09, -0.1 * tall), (b, -0.1, -0.32 * tall), (c, -0.105, -0.68 * tall)]
        thing.add(tube(spline(shoulder, 9), np.linspace(0.06, 0.042, 9), 10), cover)


def _bag(rng: np.random.Generator, style: Style, thing: Thing, x: float) -> None:
    """A tote or a leather bag on its strap."""
    w, h = float(rng.uniform(0.26, 0.36)), float(rng.uniform(0.26, 0.36))
    drop = float(rng.uniform(0.15, 0.3))
    cover = fabric(rng) if rng.uniform() < 0.6 else style.leather
    s, t = np.meshgrid(
        np.linspace(-1, 1, 9), np.linspace(0, 2 * np.pi, 28, endpoint=False), indexing="ij"
    )
    slim = np.interp(s, [-1, -0.85, 0, 0.9, 1.0], [0.0, 0.85, 1.0, 0.85, 0.0])
    high = h / 2 * np.clip(s * 1.1, -1, 1)
    a = w / 2 * np.sign(np.cos(t)) * np.abs(np.cos(t)) ** 0.5 * slim**0.3
    b = 0.05 * np.sin(t) * slim * np.interp(s, [-1, 1], [1.2, 0.5])
    points = np.stack([x + a, -0.085 - b, high - drop - h / 2], -1)
    points[..., 1] = np.minimum(points[..., 1], -0.005)
    thing.add(sheet(points, closed=True), cover)
    for y in (-0.075, -0.105):
        strap = [(x - 0.3 * w, y, -drop - 0.02), (x - 0.02, -0.062, 0.012), (x + 0.02, -0.062, 0.012), (x + 0.3 * w, y, -drop - 0.02)]  # fmt: skip  # noqa: E501
        thing.add(tube(np.array(strap), 0.007, 5), cover)


def _scarf(rng: np.random.Generator, thing: Thing, x: float) -> None:
    """A long strip over the hook, its two ends unlike in length."""
    cover = fabric(rng)
    for side, length in ((-1, float(rng.uniform(0.5, 0.7))), (1, float(rng.uniform(0.6, 0.9)))):
        s = np.linspace(0, 1, 10)
        path = np.stack([x + side * (0.012 + 0.035 * s), -0.075 - 0.02 * np.sin(2.5 * s), 0.025 - length * s], -1)  # fmt: skip  # noqa: E501
        t = np.linspace(0, 2 * np.pi, 16, endpoint=False)
        wide = 0.02 + 0.05 * np.sqrt(s)[:, None]
        fold = 1 + 0.3 * np.sin(4 * t + rng.uniform(0, 6))
        around = np.stack(
            [wide * np.cos(t) * fold, -0.45 * wide * np.sin(t) * fold, 0 * wide * t], -1
        )
        points = path[:, None] + around
        points[[0, -1]] = path[[0, -1], None]
        points[-1, :, 2] = path[-2, 2]
        thing.add(sheet(points, closed=True), cover)


def _hat(rng: np.random.Generator, thing: Thing, x: float) -> None:
    """A brimmed hat, its crown to the room."""
    hat = revolve(
        [(0.15, 0.0), (0.155, 0.004), (0.09, 0.012), (0.082, 0.09), (0.06, 0.11), (0, 0.1)], 28
    )
    inside = revolve([(0, 0.09), (0.075, 0.085), (0.085, 0.006), (0.15, 0.0)], 28)
    felt = Material(
        hue(float(rng.uniform(0, 0.12)), 0.5, float(rng.choice([0.03, 0.15, 0.4]))), specular=0.0
    )
    thing.add(moved_by(against_wall(joined([hat, inside])), x, -0.085, -0.05), felt)


def plates_on_wall(rng: np.random.Generator, style: Style) -> Thing:
    """Three to seven plates in a loose pattern."""
    thing = Thing("plates_on_wall")
    count = int(rng.integers(3, 8))
    glaze = ceramic(rng)
    ring = [(0, 0), (1, 0.5), (-1, 0.5), (1, -0.6), (-1, -0.6), (0, 1.05), (0, -1.1)]
    spots = 0.27 * np.array(ring[:count])
    spots -= (spots.min(0) + spots.max(0)) / 2
    for x, z in spots:
        r = float(rng.uniform(0.075, 0.13))
        plate = revolve([(0, 0.004), (0.5 * r, 0.004), (0.62 * r, 0.008), (r, 0.026), (r, 0.028),
                         (0.97 * r, 0.029), (0.62 * r, 0.013), (0.55 * r, 0.01), (0.0, 0.009)],
                        32)  # fmt: skip
        own = glaze if rng.uniform() < 0.6 else ceramic(rng)
        thing.add(moved_by(against_wall(plate), float(x), 0, float(z)), own)
    return thing


def dartboard(rng: np.random.Generator, style: Style) -> Thing:
    """A board of twenty sectors with its rings and wires, some darts in it."""
    thing = Thing("dartboard")
    r = 0.225
    thing.add(against_wall(cylinder(r, 0.036, (0, 0, 0.019), sides=40)), BLACK)
    red, teal = (
        Material((0.35, 0.02, 0.02), specular=0.0),
        Material((0.02, 0.2, 0.06), specular=0.0),
    )
    straw = Material((0.6, 0.52, 0.36), specular=0.0)
    rings = ((0.016, 0.1, None), (0.1, 0.11, 1), (0.11, 0.165, None), (0.165, 0.175, 1))
    for colour, even in ((straw, 0), (teal, 0), (red, 1)):
        patches = []
        for inner, outer, strip in rings:
            if (strip is None) != (colour is straw):
                continue
            for k in range(even, 20, 2):
                a = (k + np.array([-0.5, 0.5])) * np.pi / 10
                p = [(inner, a[0]), (outer, a[0]), (outer, a[1]), (inner, a[1])]
                patches.append([(q * np.sin(b), -0.0376, q * np.cos(b)) for q, b in p][::-1])
        thing.add(quads(patches), colour)
    thing.add(against_wall(cylinder(0.008, 0.003, (0, 0, 0.0385), sides=12)), red)
    thing.add(against_wall(cylinder(0.016, 0.002, (0, 0, 0.0375), sides=16)), teal)
    a = (np.arange(20) + 0.5) * np.pi / 10
    out = np.stack([np.sin(a), 0 * a, np.cos(a)], -1)
    thing.add(bars(0.016 * out + [0, -0.039, 0], 0.175 * out + [0, -0.039, 0], 7e-4, 3), STEEL)
    for _ in range(int(rng.integers(0, 4))):
        tip = np.array([*rng.normal(0, 0.07, 1), -0.03, *rng.normal(0, 0.07, 1)])
        way = np.array([rng.normal(0, 0.12), -1.0, 0.1 + rng.normal(0, 0.1)])
        thing.add(tube([tip, tip + 0.06 * way, tip + 0.065 * way, tip + 0.1 * way], [0.001, 0.003, 0.0035, 0.0025], 6), STEEL)  # fmt: skip  # noqa: E501
        tail = tip + 0.13 * way
        vanes = [box((0.03, 0.035, 0.001), tail), box((0.001, 0.035, 0.03), tail)]
        thing.add(joined(vanes), style.accent)
    return thing


def thermometer(rng: np.random.Generator, style: Style) -> Thing:
    """A tube on a narrow board, or a round dial as on a barometer."""
    thing = Thing("thermometer")
    h = float(rng.uniform(0.18, 0.32))
    thing.add(box((0.055, 0.012, h), (0, -0.0065, 0), bevel=0.003), style.wood)
    scale = Material((0.78, 0.76, 0.7), (0.05, 0.05, 0.05), "stripes", 0.008, 0.05)
    thing.add(moved_by(rectangle(0.036, 0.8 * h, -0.0131), 0, 0, 0.03 * h), scale, 0)
    thing.add(tube([(0, -0.016, -0.33 * h), (0, -0.016, 0.4 * h)], 0.003, 8), PAPER)
    level = float(rng.uniform(-0.05, 0.25))
    thing.add(tube([(0, -0.0185, -0.33 * h), (0, -0.0185, level * h)], 0.0015, 6), style.accent)
    thing.add(ball(0.006, (0, -0.017, -0.35 * h), 2), style.accent)
    if rng.uniform() < 0.4:
        r = 0.075
        thing.add(moved_by(against_wall(cylinder(r, 0.03, (0, 0, 0.0155), sides=36)), 0, 0, -0.5 * h - r + 0.01), style.wood)  # fmt: skip  # noqa: E501
        thing.add(moved_by(against_wall(cylinder(0.8 * r, 0.003, (0, 0, 0.032), sides=32)), 0, 0, -0.5 * h - r + 0.01), PAPER)  # fmt: skip  # noqa: E501
        thing.add(moved_by(_marks(0.8 * r, -0.034), 0, 0, -0.5 * h - r + 0.01), BLACK)
    return thing


def key_board(rng: np.random.Generator, style: Style) -> Thing:
    """A small board with hooks and keys on their rings."""
    thing = Thing("key_board")
    w, h = float(rng.uniform(0.2, 0.36)), float(rng.uniform(0.08, 0.14))
    thing.add(box((w, 0.016, h), (0, -0.0085, 0), bevel=0.003), style.wood)
    count = int(rng.integers(4, 7))
    for x in (np.arange(count) - (count - 1) / 2) * w / (count + 0.4):
        hook = np.array([(x, -0.014, 0.012), (x, -0.03, 0.006), (x, -0.034, 0.016)])
        thing.add(tube(hook, 0.002, 6), BRASS)
        if rng.uniform() < 0.65:
            _keys(rng, style, thing, float(x))
    return thing


def _keys(rng: np.random.Generator, style: Style, thing: Thing, x: float) -> None:
    t = np.linspace(0, 2 * np.pi, 15)
    ring = np.stack([x + 0.012 * np.sin(t), np.full(15, -0.027), -0.004 + 0.012 * np.cos(t)], -1)
    thing.add(tube(ring, 0.001, 4, capped=False), STEEL)
    for lean in rng.normal(0, 0.25, int(rng.integers(1, 4))):
        c, s = np.cos(lean), np.sin(lean)
        pieces = [box((0.009, 0.002, 0.036), (0, 0, -0.035), bevel=0.0005),
                  against_wall(cylinder(0.011, 0.0024, (0, -0.009, 0), sides=14)),
                  box((0.004, 0.0018, 0.018), (0.005, 0, -0.042))]  # fmt: skip
        key = joined(pieces)
        turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        at = np.array([x, -0.028 - 0.003 * abs(lean), -0.016])
        skin = BRASS if rng.uniform() < 0.5 else STEEL
        thing.add(Mesh((key.vertices @ turn.T + at).astype(np.float32), key.faces), skin)
    if rng.uniform() < 0.4:
        thing.add(box((0.022, 0.004, 0.035), (x, -0.036, -0.045), bevel=0.001), style.accent)


def wall_planter(rng: np.random.Generator, style: Style) -> Thing:
    """Half-round pots on a board, leaves falling over their rims."""
    thing = Thing("wall_planter")
    count = int(rng.integers(1, 4))
    pitch = 0.2
    if count > 1:
        thing.add(box((0.16, 0.018, pitch * count), (0, -0.01, 0), bevel=0.003), style.wood)
    glaze, leaf = ceramic(rng), green(rng, (0.07, 0.2, 0.04), 0.012)
    for k in range(count):
        z = (k - (count - 1) / 2) * pitch - 0.03
        r = 0.075
        pot = revolve([(0, -0.11), (0.6 * r, -0.11), (0.65 * r, -0.11), (r, 0), (r, 0), (0.92 * r, 0), (0.92 * r, -0.02), (0, -0.016)], 28)  # fmt: skip  # noqa: E501
        y = -0.02 - r
        thing.add(moved_by(pot, 0, y, z), glaze)
        n = 8
        out = round_about(rng, n, rng.uniform(0.1, 0.9, n))
        out[:, 1] = -np.abs(out[:, 1]) - 0.1
        s = np.linspace(0, 1, 7)
        reach = rng.uniform(0.03, 0.1, n)[:, None] * np.minimum(3 * s, 1.3)
        fall = 0.04 * np.sin(np.pi * np.minimum(2 * s, 1)) - rng.uniform(0.0, 0.22, (n, 1)) * np.clip(s - 0.3, 0, 1)  # fmt: skip  # noqa: E501
        paths = out[:, None] * [1, 1, 0] * reach[..., None] + np.array([0, y, z - 0.015])
        paths[..., 2] += fall
        thing.add(stems(paths, 0.0012, 0.6, 3), STALK)
        base = paths[:, 1:].reshape(-1, 3)
        base[:, 1] = np.minimum(base[:, 1], -0.06)
        way = rng.normal(size=base.shape) * [1, 0.5, 0.5] + [0, -0.7, -0.1]
        size = rng.uniform(0.025, 0.04, len(base))
        thing.add(leaves(Leaves(base, way, size, 0.8 * size, 0.6, 0.2), HEART), leaf)
    return thing


_STROKES = {
    "A": "0,0 .5,1 1,0|.2,.4 .8,.4",
    "E": "1,0 0,0 0,1 1,1|0,.5 .8,.5",
    "H": "0,0 0,1|1,0 1,1|0,.5 1,.5",
    "L": "0,1 0,0 .9,0",
    "M": "0,0 0,1 .5,.3 1,1 1,0",
    "O": "0,.2 0,.8 .25,1 .75,1 1,.8 1,.2 .75,0 .25,0 0,.2",
    "V": "0,1 .5,0 1,1",
    "T": "0,1 1,1|.5,1 .5,0",
}
_WORDS = ("HOME", "LOVE", "TEA", "HELLO", "ATELA", "MOVE", "LEO", "EMMA")


def letters(rng: np.random.Generator, style: Style) -> Thing:
    """A word in free-standing letters of wood or metal."""
    thing = Thing("letters")
    word = _WORDS[int(rng.integers(len(_WORDS)))]
    h = float(rng.uniform(0.12, 0.24))
    w, thick, deep = 0.62 * h, 0.15 * h, 0.03
    skin = (style.wood, style.metal, style.accent, BLACK)[int(rng.integers(4))]
    for k, letter in enumerate(word):
        x0 = (k - len(word) / 2) * (w + 0.32 * h) + 0.16 * h
        bars_ = []
        for stroke in _STROKES[letter].split("|"):
            p = np.array([[float(c) for c in q.split(",")] for q in stroke.split()]) * [w, h]
            for n, (a, b) in enumerate(pairwise(p)):
                bars_.append(
                    _plank(
                        a + np.array([x0, -h / 2]),
                        b + np.array([x0, -h / 2]),
                        thick,
                        deep + 0.0006 * (n % 3),
                    )
                )
        thing.add(joined(bars_), skin)
    return thing


def _plank(a: Points, b: Points, thick: float, deep: float) -> Mesh:
    """A board from a to b in the plane of the wall, with square ends a little beyond them."""
    along = (b - a) / np.linalg.norm(b - a)
    side = np.array([-along[1], along[0]]) * thick / 2
    a, b = a - along * thick / 2, b + along * thick / 2
    return against_wall(prism(np.stack([a - side, b - side, b + side, a + side]), deep))


CATALOGUE: dict[str, Maker] = {
    "wall_clock": wall_clock,
    "coat_hooks": coat_hooks,
    "plates_on_wall": plates_on_wall,
    "dartboard": dartboard,
    "thermometer": thermometer,
    "key_board": key_board,
    "wall_planter": wall_planter,
    "letters": letters,
}
