"""What people wear and carry: shoes, bags, hats, a suitcase, a guitar, m."""

import numpy as np

from cmtof.scenes.rooms import pocket_things
from cmtof.scenes.rooms.cabinetry import BLACK, CHROME, STEEL
from cmtof.scenes.rooms.joinery import boards, copies, mirrored, placed, rods, shifted
from cmtof.scenes.rooms.materials import Material, Style, darker, fabric, hue, leather
from cmtof.scenes.rooms.pliant import Points, loft, ripples, slab, spline
from cmtof.scenes.rooms.shaping import (
    handle,
    laid,
    modelled,
    pick,
    stood,
    turned,
)
from cmtof.scenes.rooms.solids import cushion, cylinder, joined, quads, revolve, sheet, tube
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between

_LAST = np.array(
    [
        (0.0, 0.02, 0.06, 0.0),
        (0.04, 0.034, 0.075, 0.0),
        (0.2, 0.037, 0.08, 0.0),
        (0.38, 0.033, 0.082, -0.002),
        (0.55, 0.04, 0.062, -0.003),
        (0.72, 0.047, 0.046, -0.004),
        (0.88, 0.041, 0.036, -0.001),
        (0.97, 0.026, 0.028, 0.002),
        (1.0, 0.008, 0.02, 0.003),
    ]
)
"""From heel to toe: share of the length, half breadth, height of the upper, middle across, m."""


def _shoe(long: float, shaft: float, toe: float) -> tuple[Mesh, Mesh, Mesh]:
    """Upper, sole and the dark opening of a right shoe that points to -y, m."""
    n = 22
    s = np.linspace(0, 1, n)
    half, high, middle = (np.interp(s, _LAST[:, 0], column) for column in _LAST[:, 1:].T)
    high = high * np.where(s > 0.5, toe, 1.0) + shaft * np.clip((0.42 - s) / 0.05, 0, 1)
    a = np.linspace(0, np.pi, 13)
    square = np.abs(np.sin(a)) ** 0.6
    x = middle[:, None] + half[:, None] * np.cos(a) * (1 - 0.32 * np.sin(a) ** 3)
    z = 0.018 + high[:, None] * square
    y = np.broadcast_to((0.5 - s)[:, None] * long, x.shape)
    upper = sheet(np.stack([x, y, z], -1)[:, ::-1])
    edge = np.linspace(0, 2 * np.pi, 33)[:-1]
    at = 0.5 - 0.5 * np.cos(edge)
    wide = np.interp(at, _LAST[:, 0], _LAST[:, 1]) + 0.004
    ring = np.stack([np.interp(at, _LAST[:, 0], _LAST[:, 3]) + wide * np.sign(np.sin(edge)) *
        np.abs(np.sin(edge)) ** 0.25, (0.5 - at) * (long + 0.008)], -1)  # fmt: skip
    levels = [(0.93, 0.0), (1.0, 0.004), (1.0, 0.018), (0.95, 0.022)]
    rings = np.array([np.column_stack([ring * f, np.full(32, z)]) for f, z in levels])
    sole = loft(rings[:, ::-1])
    mouth = modelled(
        (0.044, 0.09, 0.008), centre=(0, 0.29 * long, 0.018 + 0.079 + shaft), subdivisions=2
    )
    return upper, sole, mouth


def shoes(rng: np.random.Generator, style: Style) -> Thing:
    """A pair of shoes, trainers or boots, as somebody left them, m."""
    kind = int(rng.integers(3))
    long = between(rng, 0.24, 0.31)
    shaft = (0.0, 0.012, between(rng, 0.06, 0.2))[kind]
    upper, sole, mouth = _shoe(long, shaft, (1.0, 1.15, 1.1)[kind])
    if kind == 1:
        tone = hue(float(rng.uniform()), pick(rng, 0, 0.7), pick(rng, 0.03, 0.3, 0.78))
        skin = Material(tone, darker(tone, 0.75), "weave", 0.004, specular=0.02)
        rubber = Material((0.78, 0.78, 0.76), specular=0.04)
    else:
        skin, rubber = leather(rng), Material((0.03, 0.02, 0.015), specular=0.04)
    thing = Thing("shoes")
    laces = []
    if kind < 2 or shaft > 0.1:
        for s in np.linspace(0.44, 0.6, 4):
            z = 0.02 + np.interp(s, _LAST[:, 0], _LAST[:, 2]) * (
                1.15 if s > 0.5 and kind == 1 else 1.0
            )
            laces.append(handle([(-0.02, (0.5 - s) * long, z - 0.006),
                (0, (0.5 - s) * long - 0.003, z + 0.002), (0.02, (0.5 - s) * long, z - 0.006)],
                0.0022, count=6, sides=5))  # fmt: skip
    gap = between(rng, 0.052, 0.08)
    for side in (-1, 1):
        spot = {"at": (side * gap, between(rng, -0.04, 0.04), 0.0),
            "turn": between(rng, -0.35, 0.35)}  # fmt: skip
        for mesh, material in ((upper, skin), (sole, rubber), (mouth, BLACK)):
            thing.add(placed(mesh if side > 0 else mirrored(mesh), **spot), material)
        if laces:
            thing.add(placed(joined(laces), **spot), rubber)
    return stood(thing)


def _bag(w: float, d: float, h: float, taper: float) -> Mesh:
    """A soft body: rounded rectangle below, narrower and thinner above, m."""
    body = cushion((w, d, h), (0, 0, h / 2), square=0.42)
    p = body.vertices.astype(float)
    t = np.clip(p[:, 2] / h, 0, 1)
    p[:, 1] *= 1 - taper * t**1.5
    p[:, 0] *= 1 - 0.12 * t
    return Mesh(p.astype(np.float32), body.faces)


def handbag(rng: np.random.Generator, style: Style) -> Thing:
    """A handbag with flap or zip, two handles or a long strap, m."""
    w, h, d = between(rng, 0.24, 0.38), between(rng, 0.17, 0.27), between(rng, 0.1, 0.15)
    hide = style.leather if rng.uniform() < 0.3 else leather(rng)
    if rng.uniform() < 0.35:
        tone = hue(float(rng.uniform()), 0.7, between(rng, 0.05, 0.5))
        hide = Material(tone, darker(tone, 0.75), "noise", 0.01, specular=0.1, gloss=40.0)
    thing = Thing("handbag").add(_bag(w, d, h, 0.72), hide)
    if rng.uniform() < 0.5:
        s = np.linspace(0, 1, 9)
        across = np.linspace(-0.38 * w, 0.38 * w, 2)
        low = -d / 2 * (1 - 0.72 * (0.5) ** 1.5) - 0.004
        line = np.array([(0.16 * d, h + 0.001), (0.0, h + 0.004), (-0.16 * d, h + 0.001),
            (-0.28 * d, 0.85 * h), (low, 0.5 * h)])  # fmt: skip
        flap = np.empty((9, 2, 3))
        flap[..., 0] = across
        flap[..., 1] = np.interp(s, np.linspace(0, 1, 5), line[:, 0])[:, None]
        flap[..., 2] = np.interp(s, np.linspace(0, 1, 5), line[:, 1])[:, None]
        thing.add(slab(flap[:, ::-1], 0.003), hide)
        thing.add(
            boards([(-0.014, 0.014, low - 0.006, low + 0.004, 0.48 * h, 0.6 * h)], 0.002), CHROME
        )
    rise = between(rng, 0.09, 0.16)
    for y in (-0.13 * d, 0.13 * d):
        path = [(-0.24 * w, y, h - 0.025), (-0.23 * w, y * 1.4, h + 0.5 * rise),
            (0, y * 0.7, h + rise), (0.23 * w, y * 1.4, h + 0.5 * rise),
            (0.24 * w, y, h - 0.025)]  # fmt: skip
        thing.add(handle(path, 0.005, count=14, sides=6), hide)
    return stood(thing)


def backpack(rng: np.random.Generator, style: Style) -> Thing:
    """A rucksack that stands: bag, front pocket, side pockets, straps, top loop, m."""
    w, h, d = between(rng, 0.28, 0.34), between(rng, 0.4, 0.52), between(rng, 0.16, 0.22)
    tone = hue(float(rng.uniform()), between(rng, 0.1, 0.7), pick(rng, 0.02, 0.08, 0.3))
    cloth = Material(tone, darker(tone, 0.7), "weave", 0.005, specular=0.01, bump=0.2)
    trim = Material(darker(tone, 0.4), specular=0.04)
    thing = Thing("backpack").add(_bag(w, d, h, 0.3), cloth)
    pocket = shifted(_bag(0.8 * w, 0.12, 0.45 * h, 0.3), 0, -d / 2 + 0.005, 0.05)
    sides = [shifted(_bag(0.07, 0.7 * d, 0.34 * h, 0.2), s * 0.47 * w, 0, 0.04) for s in (-1, 1)]
    thing.add(joined([pocket, *sides]), Material(darker(tone, 0.8), darker(tone, 0.5), "weave",
        0.005, 0.01))  # fmt: skip
    a = np.linspace(0, np.pi, 21)
    zip_ = np.stack([0.44 * w * np.cos(a), -0.3 * d - 0.18 * d * (1 - np.sin(a)),
        0.62 * h + 0.34 * h * np.sin(a)], -1)  # fmt: skip
    thing.add(tube(zip_, 0.005, 5), trim)
    straps = [handle([(s * 0.07, 0.26 * d, 0.92 * h), (s * 0.1, 0.62 * d, 0.85 * h),
        (s * 0.12, 0.68 * d, 0.5 * h), (s * 0.13, 0.42 * d, 0.1 * h)], 0.016, count=12,
        sides=7) for s in (-1, 1)]  # fmt: skip
    loop = handle([(-0.04, 0.1 * d, h - 0.02), (-0.03, 0.1 * d, h + 0.035),
        (0.03, 0.1 * d, h + 0.035), (0.04, 0.1 * d, h - 0.02)], 0.006, count=10,
        sides=6)  # fmt: skip
    return stood(thing.add(joined([*straps, loop]), trim))


def suitcase(rng: np.random.Generator, style: Style) -> Thing:
    """A ribbed shell on wheels with its handle drawn out, or an old leather case, m."""
    thing = Thing("suitcase")
    w, h, d = between(rng, 0.36, 0.48), between(rng, 0.5, 0.7), between(rng, 0.2, 0.27)
    if rng.uniform() < 0.35:
        w, h, d = between(rng, 0.5, 0.68), between(rng, 0.34, 0.42), between(rng, 0.15, 0.2)
        hide = leather(rng)
        thing.add(boards([(-w / 2, w / 2, -d / 2, -0.001, 0, h),
            (-w / 2, w / 2, 0.001, d / 2, 0, h)], 0.012), hide)  # fmt: skip
        belts = [(x - 0.018, x + 0.018, -d / 2 - 0.003, d / 2 + 0.003, -0.0005,
            h + 0.003) for x in (-0.3 * w, 0.3 * w)]  # fmt: skip
        thing.add(boards(belts, 0.001), Material(darker(hide.colour, 0.5), specular=0.08))
        tips = [(sx * w / 2 - 0.03 + 0.001 * sx, sx * w / 2 + 0.03 + 0.001 * sx, -d / 2 - 0.001,
            d / 2 + 0.001, z - 0.03, z + 0.03) for sx in (-1, 1) for z in (0.029,
            h - 0.029)]  # fmt: skip
        tips = [(max(a, -w / 2 - 0.001), min(b, w / 2 + 0.001), c, e, max(f, -0.0004),
            min(g, h + 0.001)) for a, b, c, e, f, g in tips]  # fmt: skip
        thing.add(boards(tips, 0.01), Material(darker(hide.colour, 0.35), specular=0.1))
        path = [(-0.07, 0, h - 0.002), (-0.06, 0, h + 0.03), (0.06, 0, h + 0.03),
            (0.07, 0, h - 0.002)]  # fmt: skip
        return stood(thing.add(handle(path, 0.009, count=12), BLACK))
    tone = hue(float(rng.uniform()), pick(rng, 0, 0.7), pick(rng, 0.03, 0.2, 0.6))
    shell = Material(tone, specular=0.1, gloss=80.0)
    halves = [(-w / 2, w / 2, -d / 2, -0.004, 0.045, 0.045 + h),
        (-w / 2, w / 2, 0.004, d / 2, 0.045, 0.045 + h)]  # fmt: skip
    thing.add(boards(halves, 0.03), shell)
    ribs = [(x - 0.008, x + 0.008, -d / 2 - 0.004, d / 2 + 0.004, 0.1,
        h - 0.01) for x in np.linspace(-0.38, 0.38, 6) * w]  # fmt: skip
    thing.add(boards(ribs, 0.004), shell)
    thing.add(
        boards([(-w / 2 + 0.004, w / 2 - 0.004, -0.006, 0.006, 0.049, 0.041 + h)], 0.002), BLACK
    )
    wheel = laid(cylinder(0.025, 0.022, sides=16), 0)
    places = [
        (sx * (w / 2 - 0.035), sy * (d / 2 - 0.035), 0.025) for sx in (-1, 1) for sy in (-1, 1)
    ]
    forks = [(x - 0.013, x + 0.013, y - 0.015, y + 0.015, 0.03, 0.06) for x, y, _ in places]
    thing.add(joined([copies(wheel, places), boards(forks, 0.003)]), BLACK)
    out = between(rng, 0.05, 0.42)
    y, z = d / 2 - 0.03, 0.045 + h
    thing.add(rods([(s * 0.09, y, z - 0.1) for s in (-1, 1)],
        [(s * 0.09, y, z + out) for s in (-1, 1)], 0.008), CHROME)  # fmt: skip
    thing.add(boards([(-0.105, 0.105, y - 0.016, y + 0.016, z + out - 0.005, z + out + 0.022)],
        0.008), BLACK)  # fmt: skip
    grip = handle([(-0.06, -0.1 * d, z - 0.01), (-0.05, -0.1 * d, z + 0.03),
        (0.05, -0.1 * d, z + 0.03), (0.06, -0.1 * d, z - 0.01)], 0.009, count=10,
        sides=7)  # fmt: skip
    return stood(thing.add(grip, BLACK))


_GUITAR = np.array([(0.0, 0.0), (0.0, 0.1), (0.02, 0.155), (0.08, 0.188), (0.14, 0.19), (0.22,
    0.155), (0.285, 0.12), (0.35, 0.13), (0.41, 0.14), (0.455, 0.12), (0.48, 0.07), (0.485,
    0.0)])  # fmt: skip
"""Height and half breadth along the body, m."""


def guitar(rng: np.random.Generator, style: Style) -> Thing:
    """An acoustic or electric guitar on its stand, leaning back, m."""
    acoustic = rng.uniform() < 0.65
    line = np.column_stack([_GUITAR[::-1, 1], _GUITAR[::-1, 0]])
    right = resampled_outline(line, 23)
    outline = np.concatenate([right, (right * [-1, 1])[::-1][1:-1]])
    deep = 0.1 if acoustic else 0.045
    size = 1.0 if acoustic else 0.82
    outline = outline * size
    tone = ((0.62, 0.33, 0.1) if rng.uniform() < 0.6 else hue(float(rng.uniform()), 0.7,
        between(rng, 0.02, 0.4)))  # fmt: skip
    top = Material(
        tone, darker(tone, 0.75), "wood" if acoustic else "plain", 0.02, specular=0.12, gloss=200.0
    )
    rim = Material((0.16, 0.07, 0.03), (0.1, 0.04, 0.02), "wood", 0.03, specular=0.1, gloss=150.0)
    thing = Thing("guitar")
    n = len(outline)
    front = np.column_stack([outline[:, 0], np.full(n, -deep / 2), outline[:, 1]])
    back = front + np.array([0, deep, 0])
    middle = np.array([0, -deep / 2, 0.24 * size])
    nxt = np.roll(np.arange(n), -1)
    fan = np.stack([np.full(n, n), nxt, np.arange(n)], -1).astype(np.int32)
    plate = Mesh(np.vstack([front, middle]).astype(np.float32), fan)
    rear = Mesh(np.vstack([back, middle + np.array([0, deep, 0])]).astype(np.float32),
        fan[:, ::-1].copy())  # fmt: skip
    parts: list[tuple[Mesh, Material]] = [(plate, top), (joined([quads(np.stack([front, front[nxt],
        back[nxt], back], 1)), rear]), rim)]  # fmt: skip
    y, z0 = -deep / 2, 0.47 * size
    neck = boards([(-0.026, 0.026, y - 0.012, y + 0.014, z0 - (0.12 if not acoustic else 0.09),
        0.86), (-0.036, 0.036, y - 0.006, y + 0.01, 0.855, 1.02)], 0.003)  # fmt: skip
    parts.append((neck, Material((0.07, 0.04, 0.025), specular=0.06)))
    frets = [(-0.026, 0.026, y - 0.0135, y - 0.011, z, z + 0.0015) for z in 0.86 - (0.86 - 0.14 *
        size) * (1 - 0.5 ** (np.arange(1, 13) / 12))]  # fmt: skip
    pegs = rods([(s * 0.034, y, z) for s in (-1, 1) for z in (0.885, 0.93, 0.975)],
        [(s * 0.056, y, z) for s in (-1, 1) for z in (0.885, 0.93, 0.975)], 0.006,
        sides=7)  # fmt: skip
    bridge = boards([(-0.05, 0.05, y - 0.009, y + 0.001, 0.13 * size, 0.15 * size)], 0.002)
    x = np.linspace(-0.018, 0.018, 6)
    strings = rods([(1.4 * a, y - 0.011, 0.14 * size) for a in x],
        [(a, y - 0.0155, 0.86) for a in x], 0.0008, sides=3)  # fmt: skip
    parts += [(joined([boards(frets, 0), pegs, strings]), STEEL), (bridge, BLACK)]
    if acoustic:
        hole = shifted(laid(revolve([(0.05, 0), (0, 0)], 24), 1), 0, y - 0.0006, 0.3)
        ring = shifted(laid(revolve([(0.058, -0.0002), (0.058, 0.0004), (0.05, 0.0004)], 24), 1), 0,
            y - 0.0002, 0.3)  # fmt: skip
        parts += [(hole, Material((0.01, 0.008, 0.006), specular=0.0)), (ring, rim)]
    else:
        pickups = [(-0.04, 0.04, y - 0.006, y + 0.001, z, z + 0.018) for z in (0.19, 0.28)]
        parts.append((boards(pickups, 0.002), BLACK))
    lean = 0.2
    for mesh, material in parts:
        thing.add(placed(mesh, (0, 0, 0.13), lean=-lean), material, 2)
    thing.add(_guitar_stand(deep), BLACK)
    return stood(thing)


def resampled_outline(line: Points, count: int) -> Points:
    """A half outline through its corners, smooth, (count, 2), m."""
    return spline(np.column_stack([line, np.zeros(len(line))]), count)[:, :2]


def _guitar_stand(deep: float) -> Mesh:
    y = deep / 2 + 0.05
    feet = [(-0.16, -0.1, 0.008), (0.16, -0.1, 0.008), (0, 0.26, 0.008)]
    hub = (0, y + 0.03, 0.2)
    legs = [rods([f], [hub], 0.008) for f in feet]
    arms = [handle([(s * 0.02, y + 0.03, 0.19), (s * 0.09, y - 0.02, 0.13),
        (s * 0.1, -deep / 2 - 0.02, 0.115), (s * 0.1, -deep / 2 - 0.035, 0.15)], 0.008, count=10,
        sides=6) for s in (-1, 1)]  # fmt: skip
    post = rods([hub], [(0, y + 0.13, 0.72)], 0.009)
    fork = [handle([(0, y + 0.13, 0.71), (s * 0.035, y + 0.1, 0.72), (s * 0.035, y + 0.04, 0.73)],
        0.006, count=7, sides=6) for s in (-1, 1)]  # fmt: skip
    return joined([*legs, *arms, post, *fork])


def helmet(rng: np.random.Generator, style: Style) -> Thing:
    """A cycle helmet with ribs and holes, or a motorcyclist's with its visor, m."""
    tone = Material(hue(float(rng.uniform()), pick(rng, 0, 0.8), pick(rng, 0.03, 0.3, 0.75)),
        specular=0.15, gloss=200.0)  # fmt: skip
    thing = Thing("helmet")
    if rng.uniform() < 0.5:
        dome = modelled((0.25, 0.3, 0.26), [((0, 0, -1), 0.5, -0.12), ((0, -1, -0.55), 0.3, 0.2)],
            (0, 0, 0.13), subdivisions=3)  # fmt: skip
        visor = modelled((0.225, 0.26, 0.13), centre=(0, -0.032, 0.145), subdivisions=3)
        return stood(thing.add(dome, tone).add(visor, Material((0.01, 0.01, 0.012), specular=0.35,
            gloss=900.0)))  # fmt: skip
    u, v = np.meshgrid(
        np.linspace(0.0, 1, 15), np.linspace(0, 2 * np.pi, 48, endpoint=False), indexing="ij"
    )
    a = (1 - u) * (np.pi / 2)
    rib = (1 + 0.05 * np.cos(2 * np.pi * 0.105 * np.cos(a) * np.cos(v) / 0.052) * np.sin(np.pi * u)
        ** 0.3)  # fmt: skip
    low = 0.02 * np.cos(2 * v)
    x, y = 0.105 * np.cos(a) * np.cos(v) * rib, 0.14 * np.cos(a) * np.sin(v) * rib
    z = 0.125 * np.sin(a) * rib + low * u
    points = np.stack([x, y, z + 0.03], -1)[::-1]
    inner = points * [0.86, 0.89, 0.84]
    inner[..., 2] += 0.002
    shell = sheet(np.concatenate([inner[::-1], points])[:, ::-1], closed=True)
    thing.add(shell, tone)
    straps = [handle([(s * 0.095, -0.04, 0.03), (s * 0.06, -0.02, -0.04), (s * 0.01, 0.0, -0.055)],
        0.004, count=7, sides=5) for s in (-1, 1)]  # fmt: skip
    strap = joined(straps)
    strap.vertices[:, 2] = np.maximum(
        strap.vertices[:, 2], float(shell.vertices[:, 2].min()) + 0.004
    )
    return stood(thing.add(strap, BLACK))


def hat(rng: np.random.Generator, style: Style) -> Thing:
    """A felt hat, a straw hat with a wide brim, a bowler or a cap, m."""
    kind = int(rng.integers(4))
    thing = Thing("hat")
    if kind == 3:
        cap = modelled((0.2, 0.23, 0.24), [((0, 0, -1), 0.6, -0.1)], (0, 0, 0.0), subdivisions=3)
        p = cap.vertices.astype(float)
        p[:, 2] = np.maximum(p[:, 2], 0.0)
        u, v = np.meshgrid(np.linspace(0, 1, 6), np.linspace(-1.0, 1.0, 15), indexing="ij")
        r = 0.1 + 0.075 * u * np.cos(0.9 * v)
        peak = np.stack(
            [r * np.sin(v), -r * np.cos(v), 0.022 - 0.02 * u - 0.018 * np.abs(np.sin(v)) * u], -1
        )
        cloth = fabric(rng)
        thing.add(Mesh(p.astype(np.float32), cap.faces), cloth).add(
            slab(peak[:, ::-1], 0.004), cloth
        )
        return stood(
            thing.add(modelled((0.014, 0.014, 0.01), centre=(0, 0, 0.121), subdivisions=1), cloth)
        )
    brim = (0.15, between(rng, 0.19, 0.24), 0.135)[kind]
    tall = (0.12, 0.1, 0.125)[kind]
    crown = ((0.088, 0.008), (0.086, 0.5 * tall), (0.07, 0.95 * tall), (0.045, tall),
        (0, 0.93 * tall))  # fmt: skip
    if kind == 2:
        crown = ((0.09, 0.008), (0.092, 0.4 * tall), (0.08, 0.75 * tall), (0.045, 0.97 * tall),
            (0, tall))  # fmt: skip
    profile = [(0, 0.004), (0.084, 0.004), (brim, 0.001), (brim + 0.002, 0.0025), (brim, 0.005),
        (0.092, 0.007), *crown]  # fmt: skip
    body = turned(profile, 40, 30)
    p = body.vertices.astype(float)
    far = np.clip((np.hypot(p[:, 0], p[:, 1]) - 0.09) / (brim - 0.09), 0, 1)
    p[:, 2] += far**1.5 * (0.022 * (p[:, 0] / brim) ** 2 * (kind != 1) + 0.02 * ripples(rng,
        2 * p[:, 0], 2 * p[:, 1], 4, 1.0) * (kind == 1))  # fmt: skip
    if kind == 0:
        p[:, 2] -= (0.022 * np.exp(-((p[:, 0] / 0.02) ** 2)) * np.clip((p[:,
            2] - 0.6 * tall) / (0.4 * tall), 0, 1))  # fmt: skip
    p[:, 1] *= 1.12
    straw = Material((0.62, 0.48, 0.26), (0.5, 0.37, 0.18), "weave", 0.006, specular=0.02)
    felt = Material(
        hue(between(rng, 0, 0.12), between(rng, 0, 0.5), pick(rng, 0.02, 0.08, 0.25)), specular=0.0
    )
    thing.add(Mesh(p.astype(np.float32), body.faces), straw if kind == 1 else felt)
    band = revolve(np.array([(-0.006, 0.011), (0, 0.012), (0, 0.031),
        (-0.006, 0.032)]) + np.array([0.0945 if kind == 2 else 0.0915, 0]), 40)  # fmt: skip
    thing.add(Mesh(band.vertices * np.array([1, 1.12, 1], np.float32), band.faces), BLACK)
    return stood(thing)


CATALOGUE: dict[str, Maker] = {
    "shoes": shoes,
    "handbag": handbag,
    "backpack": backpack,
    "suitcase": suitcase,
    "guitar": guitar,
    "helmet": helmet,
    "hat": hat,
    **pocket_things.CATALOGUE,
}
