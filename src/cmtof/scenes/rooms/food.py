"""Fruit, bread and cake, and a bowl in which fruits rest on each other, m."""

import numpy as np

from cmtof.scenes.rooms import vessels
from cmtof.scenes.rooms.materials import Material, Style, darker, hue
from cmtof.scenes.rooms.pliant import loft, spline
from cmtof.scenes.rooms.shaping import Points, hollow, modelled, outline_radius, pick, stood, turned
from cmtof.scenes.rooms.solids import cylinder, joined, quads, sheet, tube
from cmtof.scenes.rooms.tableware import candle_mesh
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between, ware

STALK = Material((0.09, 0.06, 0.03), specular=0.0)


def _skin(rng: np.random.Generator, low: float, high: float, value: float) -> Material:
    base = hue(between(rng, low, high), between(rng, 0.75, 0.92), value * between(rng, 0.8, 1.2))
    other = hue(between(rng, low, high) + 0.05, 0.8, 0.9 * value)
    return Material(base, other, "noise", 0.03, specular=0.05, gloss=40.0)


def apple(rng: np.random.Generator, style: Style, *, sides: int = 24) -> Thing:
    """A red, green or yellow apple with its stalk, m."""
    r = between(rng, 0.034, 0.042)
    profile = np.array([(0, 0.22), (0.25, 0.05), (0.45, 0), (0.8, 0.25), (1.0, 0.95), (0.85, 1.55),
        (0.5, 1.75), (0.2, 1.68), (0, 1.4)]) * r  # fmt: skip
    body = _dented(turned(profile, sides, 14 if sides < 20 else 18), 5, 0.025, r)
    hue_low, hue_high, value = ((0.98, 1.02, 0.3), (0.22, 0.28, 0.45), (0.11, 0.16, 0.65))[
        int(rng.integers(3))
    ]
    thing = Thing("apple").add(body, _skin(rng, hue_low, hue_high, value))
    lean = between(rng, -0.01, 0.01)
    stalk = tube(
        spline([(0, 0, 1.38 * r), (0.3 * lean, 0, 1.65 * r), (lean, 0, 2.0 * r)], 5), 0.0012, 5
    )
    return stood(thing.add(stalk, STALK))


def _dented(mesh: Mesh, lobes: int, depth: float, height: float) -> Mesh:
    """Lobes around a fruit, strongest at its bottom."""
    x, y, z = mesh.vertices.T.astype(float)
    wave = 1 + depth * np.cos(lobes * np.arctan2(y, x)) * np.clip(1.4 - z / height, 0, 1)
    return Mesh(np.stack([x * wave, y * wave, z], -1).astype(np.float32), mesh.faces)


def pear(rng: np.random.Generator, style: Style, *, sides: int = 22) -> Thing:
    """A green, yellow or russet pear, m."""
    r = between(rng, 0.031, 0.037)
    profile = np.array([(0, 0.15), (0.3, 0), (0.7, 0.2), (1.0, 0.85), (0.85, 1.5), (0.5, 2.1),
        (0.36, 2.55), (0.2, 2.75), (0, 2.72)]) * r  # fmt: skip
    bend = between(rng, -0.3, 0.3)
    body = turned(profile, sides, 14 if sides < 20 else 18)
    points = body.vertices.astype(float)
    points[:, 0] += bend * r * (points[:, 2] / (2.7 * r)) ** 2
    thing = Thing("pear")
    thing.add(
        Mesh(points.astype(np.float32), body.faces), _skin(rng, 0.1, 0.24, between(rng, 0.25, 0.6))
    )
    at = bend * r
    stalk = tube(
        spline([(at, 0, 2.65 * r), (at, 0.001, 2.9 * r), (1.2 * at, 0.004, 3.3 * r)], 5), 0.0012, 5
    )
    return stood(thing.add(stalk, STALK))


def orange(rng: np.random.Generator, style: Style, *, subdivisions: int = 3) -> Thing:
    """An orange, a lemon or a grapefruit, m."""
    kind = int(pick(rng, 0, 0, 1, 2))
    r = (0.037, 0.027, 0.048)[kind] * between(rng, 0.94, 1.06)
    tip = 0.3 if kind == 1 else -0.04
    body = modelled((2 * r, 2 * r, (1.9, 2.2, 1.85)[kind] * r),
        [((0, 0, 1), 0.22, tip), ((0, 0, -1), 0.2, tip)], subdivisions=subdivisions)  # fmt: skip
    if kind == 1:
        body = Mesh(body.vertices[:, [2, 0, 1]], body.faces)
    skin = Material(((0.75, 0.25, 0.02), (0.8, 0.6, 0.04), (0.78, 0.36, 0.1))[kind], specular=0.06,
        gloss=25.0, bump=0.3)  # fmt: skip
    thing = Thing(("orange", "lemon", "grapefruit")[kind]).add(body, skin)
    if kind != 1:
        thing.add(cylinder(0.003, 0.002, (0, 0, 0.92 * r), sides=6), STALK)
    return stood(thing)


def banana_bunch(rng: np.random.Generator, style: Style) -> Thing:
    """Three to six bananas that hang together at their stalks, lying on their sides, m."""
    count = int(rng.integers(3, 7))
    ripe = between(rng, 0.6, 0.85)
    yellow = Material((ripe, 0.72 * ripe, 0.05), (0.25, 0.14, 0.03), "noise", 0.05, specular=0.04)
    bodies, tips = [], []
    for k in range(count):
        long = between(rng, 0.17, 0.2)
        bow = between(rng, 0.9, 1.2)
        t = np.linspace(0, 1, 14)
        big = long / bow
        spread = (k - (count - 1) / 2) * 0.2
        angle = bow * (t - 0.5)
        u = big * (np.sin(angle) - np.sin(angle[0]))
        v = big * (np.cos(angle) - np.cos(0.5 * bow))
        path = np.stack(
            [u * np.cos(spread), 0.004 + u * np.sin(spread), v + 0.002 * abs(k - count / 2)], -1
        )
        girth = 0.018 * np.interp(
            t, [0, 0.1, 0.18, 0.35, 0.7, 0.9, 0.97, 1], [0.36, 0.36, 0.6, 1, 1, 0.7, 0.4, 0.25]
        )
        girth = girth * between(rng, 0.92, 1.05)
        rings = tube(path, girth, 7, capped=False).vertices.reshape(14, 7, 3)
        bodies.append(loft(rings[:, ::-1]))
        end = path[-1] + np.array([0.3, 0.3 * np.sin(spread), -0.1]) * 0.006
        tips.append(tube([path[-1] - (end - path[-1]), end], 0.0045, 6))
    crown = modelled((0.03, 0.034, 0.022), centre=(0.0, 0.004, 0.004), subdivisions=2)
    thing = Thing("bananas").add(joined(bodies), yellow).add(joined([*tips, crown]), STALK)
    return stood(thing)


def bread(rng: np.random.Generator, style: Style) -> Thing:
    """A round loaf, a tin loaf, a baguette or rolls, with cuts across the crust, m."""
    kind = int(rng.integers(4))
    crust = Material((0.36, 0.19, 0.07), (0.55, 0.36, 0.17), "noise", 0.03, specular=0.01, bump=0.4)
    size = ((0.22, 0.2, 0.1), (0.26, 0.11, 0.12), (0.5, 0.065, 0.055), (0.09, 0.075, 0.05))[kind]
    thing = Thing("bread")
    for k in range(3 if kind == 3 else 1):
        w, d, h = np.array(size) * between(rng, 0.9, 1.1)
        bumps = [((0, 0, 1), 0.5, 0.06), ((0.5, 0.2, 1), 0.3, 0.04), ((-0.6, -0.1, 1), 0.3, 0.05)]
        mesh = modelled((w, d, 1.25 * h), bumps, subdivisions=4 if kind < 3 else 3)
        p = mesh.vertices.astype(float)
        if kind == 1:  # the tin squares it off
            p = p * (1 + 0.16 * np.clip(np.abs(p[:, :1] * p[:, 1:2]) / (0.25 * w * d), 0, 1))
        if kind == 2:  # blunt ends
            p[:, 1:] *= (1 - (p[:, :1] / (0.52 * w)) ** 6) / (
                1 - (p[:, :1] / (0.52 * w)) ** 2 + 0.02
            ) ** 0.45
        cuts = max(2, int(w / 0.06)) if kind < 3 else 1
        wave = np.cos(2 * np.pi * (p[:, 0] + 0.35 * p[:, 1]) / w * cuts)
        p[:, 2] -= 0.09 * h * np.clip(4 * wave - 3, 0, 1) * (p[:, 2] > 0.2 * h)
        p[:, 2] = np.maximum(p[:, 2], -0.4 * h) + 0.4 * h
        at = [(0, 0), (0.1, 0.02), (0.04, 0.085)][k]
        thing.add(Mesh((p + np.array([*at, 0])).astype(np.float32), mesh.faces), crust)
    return stood(thing)


def pumpkin(rng: np.random.Generator, style: Style) -> Thing:
    """A ribbed orange, green or grey squash with a bent stalk, m."""
    r = between(rng, 0.07, 0.16)
    tall = between(rng, 0.6, 1.0)
    ribs = int(rng.integers(8, 13))
    profile = np.array([(0, 0.12), (0.3, 0.02), (0.5, 0), (0.9, 0.35), (1.0, 0.9), (0.88, 1.45),
        (0.5, 1.75), (0.2, 1.66), (0, 1.55)]) * [r, r * tall]  # fmt: skip
    body = turned(profile, 4 * ribs, 15)
    x, y, z = body.vertices.T.astype(float)
    valley = 1 - 0.13 * np.abs(np.cos(0.5 * ribs * np.arctan2(y, x))) ** 6
    points = np.stack([x * valley, y * valley, z * (0.3 + 0.7 * valley)], -1)
    tones = ((0.7, 0.22, 0.02), (0.1, 0.2, 0.05), (0.45, 0.48, 0.42), (0.8, 0.5, 0.2))
    tone = tones[int(rng.integers(4))]
    thing = Thing("pumpkin")
    skin = Material(tone, darker(tone, 0.75), "noise", 0.04, specular=0.05, gloss=30.0)
    thing.add(Mesh(points.astype(np.float32), body.faces), skin)
    top = 1.5 * r * tall
    stalk = spline([(0, 0, top), (0.02 * r, 0, top + 0.25 * r), (0.25 * r, 0, top + 0.5 * r)], 7)
    thing.add(tube(stalk, np.linspace(0.17 * r, 0.08 * r, 7), 7),
        Material((0.14, 0.13, 0.05), specular=0.0))  # fmt: skip
    return stood(thing)


def fruit_bowl(rng: np.random.Generator, style: Style) -> Thing:
    """A bowl with four to nine fruits: a ring that touches the bowl, and some upon the ring, m.

    A fruit of radius R at distance d from the axis rests where its ball touches the inside:
    ``z = max over the profile of z(r) + sqrt(R² - (r - d)²)``.
    """
    big = between(rng, 0.13, 0.16)
    h = between(rng, 0.07, 0.095)
    shape = ((0.4, 0), (0.45, 0.03), (0.75, 0.22), (0.95, 0.68), (1.0, 1.0))
    thing = Thing("fruit bowl")
    corners = vessels.outline(shape, big, h)
    thing.add(hollow(corners, 0.005), style.wood if rng.uniform() < 0.3 else ware(rng, style))
    ring = int(rng.integers(4, 6))
    upper = int(rng.integers(0, 5))
    fruits = [_small(rng, style) for _ in range(ring + upper)]
    turn = between(rng, 0, 6)
    inside = outline_radius(corners, 0.005)
    below: list[Ball] = []
    for fruit, place in zip(fruits[:ring], _circle(fruits[:ring], turn), strict=True):
        below += _lay(thing, fruit, place, inside, [], 1.1, rng)
    high = _circle(fruits[ring:], turn + np.pi / ring)
    for fruit, place in zip(fruits[ring:], high, strict=True):
        _lay(thing, fruit, place, inside, below, 0.5, rng)
    return thing


Ball = tuple[float, float, float, float]
"""Centre and radius of what a fruit offers to those above it, m."""


def _circle(fruits: list[Thing], turn: float) -> list[tuple[float, float]]:
    """Places around the axis, as near to it as the widest fruit allows, m."""
    count, far = len(fruits), 0.0
    if count > 1:
        wide = max(float(np.sort(np.ptp(_body(fruit), axis=0))[1]) for fruit in fruits) / 2
        far = wide / float(np.sin(np.pi / count))
    angles = [turn + 2 * np.pi * k / count for k in range(count)]
    return [(far * float(np.cos(a)), far * float(np.sin(a))) for a in angles]


def _body(fruit: Thing) -> Points:
    return fruit.parts[0].mesh.vertices.astype(float)


def resting_height(outline: Points, wall: float, radius: float, far: float) -> float:
    """Height of the centre of a ball that rests in a vessel, ``far`` m from its axis, m."""
    return _on_bowl(outline_radius(outline, wall), radius, far)


def _on_bowl(inside: tuple[Points, Points], radius: float, far: float) -> float:
    r, z = inside
    reach = np.clip(radius**2 - (r - far) ** 2, 0, None)
    return float((z + np.sqrt(reach))[reach > 0].max())


def _on_balls(below: list[Ball], radius: float, x: float, y: float) -> float:
    """Height at which a ball that comes down at (x, y) first touches another, m."""
    if not below:
        return 0.0
    u, v, z, other = np.array(below).T
    reach = (radius + other) ** 2 - (u - x) ** 2 - (v - y) ** 2
    return float((z + np.sqrt(np.clip(reach, 0, None)))[reach > 0].max(initial=0.0))


def _small(rng: np.random.Generator, style: Style) -> Thing:
    kind = int(rng.integers(4))
    if kind == 2:
        return orange(rng, style, subdivisions=2)
    return (pear if kind == 3 else apple)(rng, style, sides=16)


def _lay(
    thing: Thing, fruit: Thing, place: tuple[float, float], inside: tuple[Points, Points],
    below: list[Ball], recline: float, rng: np.random.Generator,
) -> list[Ball]:  # fmt: skip
    """Let a fruit down until it touches the bowl or a fruit below; returns the balls it is.

    A pear reclines by so many rad with its neck towards the axis, where there is room for it; its
    belly and its neck are a ball each. What stands out of the balls is kept inside the bowl.
    """
    x, y = place
    body = _body(fruit)
    low, high = body.min(axis=0), body.max(axis=0)
    radius = float(np.sort(high - low)[:2].mean() / 2)
    middle = (low + high) / 2
    is_pear = fruit.kind == "pear"
    lean = recline if is_pear else float(rng.uniform(-0.6, 0.6))
    turn = float(rng.uniform(-3.1, 3.1))
    if is_pear:
        middle[2] = low[2] + radius
        turn = 0.15 * turn + float(np.arctan2(y, x)) - np.pi / 2
    rotation = _tilted(turn, lean)
    z = max(_on_bowl(inside, radius, float(np.hypot(x, y))), _on_balls(below, radius, x, y))
    spread = (body - middle) @ rotation.T + np.array([x, y, z])
    ground = np.interp(np.hypot(spread[:, 0], spread[:, 1]), *inside)
    at = np.array([x, y, z + max(float((ground - spread[:, 2]).max()), 0.0)])
    for part in fruit.parts:
        points = (part.mesh.vertices - middle) @ rotation.T + at
        thing.add(Mesh(points.astype(np.float32), part.mesh.faces), part.material, part.grain)
    balls = [(*at.tolist(), radius)]
    if is_pear:
        neck = at + 1.2 * radius * rotation[:, 2]
        balls.append((*neck.tolist(), 0.55 * radius))
    return balls


def _tilted(turn: float, lean: float) -> Points:
    """Rotation (3, 3) by ``lean`` about x, then by ``turn`` about the vertical, rad."""
    c, s, p, q = np.cos(turn), np.sin(turn), np.cos(lean), np.sin(lean)
    return np.array([[c, -s * p, s * q], [s, c * p, -c * q], [0, q, p]])


def cake(rng: np.random.Generator, style: Style) -> Thing:
    """A layer cake on a stand or a plate, a slice cut out, mostly with candles or cherries, m."""
    r, h = between(rng, 0.1, 0.13), between(rng, 0.06, 0.1)
    base = between(rng, 0.06, 0.1) if rng.uniform() < 0.5 else 0.0
    thing = Thing("cake")
    dish = ware(rng, style)
    if base:
        foot = [(0, 0), (0.06, 0), (0.062, 0.006), (0.016, 0.02), (0.014, base - 0.014),
            (0.03, base - 0.004), (r + 0.02, base - 0.002), (r + 0.022, base + 0.004),
            (r, base + 0.003), (0, base + 0.003)]  # fmt: skip
        thing.add(turned(foot, 32, 24), dish)
        base += 0.0035
    else:
        thing.add(vessels.plate_mesh(r + 0.04, 0.018), dish)
        base = 0.012
    cut = pick(rng, 0.0, 0.6, 0.9)
    icing = hue(float(rng.uniform()), pick(rng, 0.0, 0.3, 0.5), pick(rng, 0.03, 0.5, 0.75))
    cream = Material(icing, specular=0.04, gloss=20.0)
    crumb = Material((0.5, 0.3, 0.13), (0.75, 0.65, 0.5), "stripes", h / 2.5, specular=0.0)
    start = between(rng, 0, 6)
    angle = start + np.linspace(0, 2 * np.pi - cut, 37)
    profile = np.array([(r, base), (r, base + 0.9 * h), (0.96 * r, base + h), (0, base + h)])
    ring = np.stack([np.cos(angle), np.sin(angle)], -1)
    points = np.empty((len(profile), 37, 3))
    points[..., :2] = profile[:, None, :1] * ring
    points[..., 2] = profile[:, 1:]
    thing.add(sheet(points[:, ::-1]), cream)
    if cut:
        for a, forth in ((angle[0], 1), (angle[-1], -1)):
            c, s = np.cos(a), np.sin(a)
            face = [(0, 0, base), (r * c, r * s, base), (r * c, r * s, base + h), (0, 0, base + h)]
            thing.add(quads([face[::forth]]), crumb)
    wax = Material(hue(float(rng.uniform()), 0.7, 0.5), specular=0.03)
    count = int(pick(rng, 0, 5, 8))
    for k in range(count):
        a = start + (2 * np.pi - cut) * (k + 0.5) / count
        at = np.array([0.75 * r * np.cos(a), 0.75 * r * np.sin(a), 0], np.float32)
        if rng.uniform() < 0.5:
            body, _ = candle_mesh(rng, 0.003, 0.05, base + h - 0.003)
        else:
            body = modelled((0.02, 0.02, 0.019), centre=(0, 0, base + h + 0.006), subdivisions=2)
        thing.add(Mesh(body.vertices + at, body.faces), wax)
    return stood(thing)


CATALOGUE: dict[str, Maker] = {
    "apple": apple,
    "pear": pear,
    "orange": orange,
    "banana_bunch": banana_bunch,
    "bread": bread,
    "pumpkin": pumpkin,
    "fruit_bowl": fruit_bowl,
    "cake": cake,
}
