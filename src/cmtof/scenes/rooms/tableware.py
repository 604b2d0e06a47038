"""What a kitchen and a table need besides cups: pots, pans, teapots, candles, cutlery, trays, m."""

import numpy as np

from cmtof.scenes.rooms import vessels
from cmtof.scenes.rooms.cabinetry import BLACK, CHROME, STEEL
from cmtof.scenes.rooms.joinery import boards, placed, rods
from cmtof.scenes.rooms.materials import Material, Style, hue
from cmtof.scenes.rooms.pliant import slab, spline
from cmtof.scenes.rooms.shaping import handle, hollow, pick, pipe, stood, turned
from cmtof.scenes.rooms.solids import cylinder, joined, revolve, tube
from cmtof.scenes.rooms.thing import Mesh, Support, Thing
from cmtof.scenes.rooms.vessels import Maker, between, ware

BRASS = Material((0.62, 0.45, 0.18), specular=0.6, gloss=120.0)
COPPER = Material((0.6, 0.28, 0.16), specular=0.55, gloss=100.0)


def teapot(rng: np.random.Generator, style: Style) -> Thing:
    """A round, a tall or a squat teapot with spout, handle and lid, m."""
    r = between(rng, 0.07, 0.095)
    kind = int(rng.integers(3))
    h = r * (1.35, 1.9, 1.05)[kind]
    shape = (((0.5, 0), (0.55, 0.04), (0.9, 0.2), (1.0, 0.5), (0.85, 0.82), (0.45, 0.97)),
        ((0.8, 0), (0.85, 0.03), (0.9, 0.3), (0.75, 0.75), (0.5, 0.95)),
        ((0.6, 0), (0.85, 0.1), (1.0, 0.45), (0.8, 0.85), (0.45, 0.97)))[kind]  # fmt: skip
    z = shape[-1][1] * h
    top = shape[-1][0] * r
    body = turned([*vessels.outline(shape, r, h), (0, z)], 28, 18)
    dome = [(0, z + 0.0005), (1.02 * top, z + 0.0005), (1.0 * top, z + 0.005),
        (0.6 * top, z + 0.016), (0.1 * r, z + 0.02), (0.09 * r, z + 0.026), (0.17 * r, z + 0.036),
        (0, z + 0.042)]  # fmt: skip
    lid = turned(dome, 24, 16)
    path = spline([(-0.8 * r, 0, 0.25 * h), (-1.2 * r, 0, 0.42 * h), (-1.45 * r, 0, 0.75 * h),
        (-1.75 * r, 0, 0.98 * h)], 9)  # fmt: skip
    spout = pipe(path, np.linspace(0.24 * r, 0.11 * r, 9), 0.0025)
    grip = handle([(0.6 * r, 0, 0.88 * h), (1.2 * r, 0, 0.98 * h), (1.6 * r, 0, 0.65 * h),
        (1.3 * r, 0, 0.3 * h), (0.85 * r, 0, 0.3 * h)], 0.0065, count=12, sides=7)  # fmt: skip
    return stood(Thing("teapot").add(joined([body, lid, spout, grip]), ware(rng, style)))


def _metalware(rng: np.random.Generator) -> Material:
    enamel = Material(hue(float(rng.uniform()), 0.75, between(rng, 0.05, 0.5)), specular=0.12,
        gloss=150.0)  # fmt: skip
    return (STEEL, STEEL, BLACK, COPPER, enamel)[int(rng.integers(5))]


def pan(rng: np.random.Generator, style: Style) -> Thing:
    """A frying pan or a saucepan with a long handle, m."""
    deep = rng.uniform() < 0.4
    r = between(rng, 0.08, 0.1) if deep else between(rng, 0.1, 0.15)
    h = between(rng, 0.08, 0.11) if deep else between(rng, 0.04, 0.055)
    shape = ((0.93, 0), (0.97, 0.08), (1.0, 0.9), (1.02, 1.0))
    flat = ((0.75, 0), (0.8, 0.08), (0.97, 0.85), (1.02, 1.0))
    body = hollow(vessels.outline(shape if deep else flat, r, h), 0.003, sides=32, count=11)
    long = between(rng, 0.17, 0.21)
    rise = between(rng, 0.01, 0.045)
    z = 0.8 * h
    neck = handle([(r - 0.006, 0, z), (r + 0.02, 0, z + 0.004), (r + 0.06, 0, z + 0.4 * rise)],
        [0.006, 0.004, 0.006], count=6)  # fmt: skip
    grip = handle([(r + 0.05, 0, z + 0.33 * rise), (r + 0.1, 0, z + 0.6 * rise),
        (r + long, 0, z + rise)], [0.008, 0.009, 0.012, 0.011], count=8)  # fmt: skip
    grip = Mesh(grip.vertices * np.array([1, 1.25, 1], np.float32), grip.faces)
    stuff = _metalware(rng)
    thing = Thing("pan").add(body, stuff)
    thing.add(neck, STEEL).add(grip, style.wood if rng.uniform() < 0.3 else BLACK)
    if deep and rng.uniform() < 0.5:
        thing.add(_lid(r, h), stuff)
    return stood(thing)


def _lid(r: float, h: float) -> Mesh:
    profile = [(0, h + 0.001), (1.02 * r, h + 0.001), (1.04 * r, h + 0.003), (0.9 * r, h + 0.012),
        (0.3 * r, h + 0.024), (0.016, h + 0.026), (0.012, h + 0.034), (0.021, h + 0.042),
        (0.018, h + 0.05), (0, h + 0.052)]  # fmt: skip
    return turned(profile, 32, 18)


def pot(rng: np.random.Generator, style: Style) -> Thing:
    """A pot with two handles and its lid, or open, m."""
    r, h = between(rng, 0.09, 0.135), between(rng, 0.09, 0.2)
    stuff = _metalware(rng)
    open_ = rng.uniform() < 0.25
    shape = ((0.94, 0), (0.99, 0.04), (1.0, 0.9), (1.03, 1.0))
    body = hollow(vessels.outline(shape, r, h), 0.003, sides=32, count=11)
    reach = between(rng, 0.03, 0.04)
    loops = []
    for side in (-1, 1):
        path = np.array([(r - 0.004, -0.045, 0), (r + reach, -0.035, 0.006),
            (r + reach, 0.035, 0.006), (r - 0.004, 0.045, 0)]) * [side, 1, 1] + [0, 0,
            0.78 * h]  # fmt: skip
        loops.append(handle(path, 0.0055, count=11, sides=6))
    thing = Thing("pot").add(body, stuff)
    thing.add(joined(loops), STEEL if rng.uniform() < 0.6 else stuff)
    return thing if open_ else thing.add(_lid(r, h), stuff)


def candle_mesh(
    rng: np.random.Generator, radius: float, height: float, z: float = 0.0
) -> tuple[Mesh, Mesh]:
    """A burnt-down candle with its pool, and its wick, m."""
    r = radius
    profile = [(0, z), (r, z), (r, z + 0.9 * height), (0.97 * r, z + height), (0.9 * r, z + height),
        (0.7 * r, z + height - 0.3 * r), (0, z + height - 0.4 * r)]  # fmt: skip
    tilt = float(rng.normal(0, 0.003))
    low = z + height - 0.42 * r
    wick = tube(spline([(0, 0, low), (tilt, 0, low + 0.006), (3 * tilt, 0, low + 0.012 + 0.1 * r)],
        5), 0.0009, 5)  # fmt: skip
    return turned(profile, 18, 11), wick


WICK = Material((0.02, 0.02, 0.02), specular=0.0)


def _wax(rng: np.random.Generator) -> Material:
    plain = (0.8, 0.76, 0.66)
    tone = hue(float(rng.uniform()), 0.7, between(rng, 0.05, 0.5))
    return Material(plain if rng.uniform() < 0.6 else tone, specular=0.04, gloss=15.0)


def candle(rng: np.random.Generator, style: Style) -> Thing:
    """A pillar candle, one to three of them on a dish, or a tealight's glass, m."""
    wax = _wax(rng)
    thing = Thing("candle")
    if rng.uniform() < 0.25:
        cup_ = hollow([(0, 0), (0.028, 0), (0.031, 0.02), (0.033, 0.032)], 0.003, floor=0.008)
        body, wick = candle_mesh(rng, 0.024, 0.02, 0.0075)
        thing.add(cup_, vessels.glassy(rng))
        return thing.add(body, wax).add(wick, WICK)
    count = int(pick(rng, 1, 1, 3))
    turn = np.arange(count) * 2.1 + between(rng, 0, 6)
    far = 0.0 if count == 1 else 0.043
    for k in range(count):
        body, wick = candle_mesh(rng, between(rng, 0.025, 0.035), between(rng, 0.06, 0.18), 0.0055)
        at = np.array([far * np.cos(turn[k]), far * np.sin(turn[k]), 0], np.float32)
        thing.add(Mesh(body.vertices + at, body.faces), wax)
        thing.add(Mesh(wick.vertices + at, wick.faces), WICK)
    dish = vessels.plate_mesh(far + 0.05, 0.012, 28)
    return stood(thing.add(dish, ware(rng, style)))


def candlestick(rng: np.random.Generator, style: Style) -> Thing:
    """A turned stick with one candle, a branched one with three or five, or a low holder, m."""
    stuff = (BRASS, CHROME, BLACK, style.wood, style.metal)[int(rng.integers(5))]
    wax = _wax(rng)
    arms = int(pick(rng, 1, 1, 1, 3, 5))
    h = between(rng, 0.12, 0.3) if arms == 1 else between(rng, 0.22, 0.34)
    t = between(rng, 0.006, 0.009)
    stem = np.array([(0, 0), (0.055, 0), (0.056, 0.008), (0.02, 0.022), (t, 0.04), (t, 0.3 * h),
        (2.1 * t, 0.36 * h), (t, 0.44 * h), (t, 0.8 * h), (2 * t, 0.86 * h), (1.2 * t, 0.91 * h),
        (0.019, h - 0.004), (0.019, h), (0, h)])  # fmt: skip
    thing = Thing("candlestick").add(turned(stem, 24, 26), stuff)
    tops = [(0.0, h)]
    loops = []
    for k in range(arms // 2):
        x = 0.075 * (k + 1)
        for side in (-1, 1):
            tops.append((side * x, h - 0.012))
            path = [(0, 0, 0.5 * h), (0.6 * side * x, 0, 0.46 * h), (side * x, 0, 0.7 * h),
                (side * x, 0, h - 0.014)]  # fmt: skip
            loops.append(handle(path, 0.0045, count=9, sides=6))
            loops.append(revolve([(0, 0), (0.012, 0.0), (0.018, 0.008), (0.0, 0.01)], 14))
            loops[-1] = Mesh(loops[-1].vertices + np.array([side * x, 0, h - 0.021], np.float32),
                loops[-1].faces)  # fmt: skip
    if loops:
        thing.add(joined(loops), stuff)
    for x, z in tops:
        body, wick = candle_mesh(rng, 0.011, between(rng, 0.1, 0.24), z - 0.0015)
        at = np.array([x, 0, 0], np.float32)
        thing.add(Mesh(body.vertices + at, body.faces), wax)
        thing.add(Mesh(wick.vertices + at, wick.faces), WICK)
    return stood(thing)


def _blade(width: tuple[float, ...], lift: tuple[float, ...], x: float, long: float) -> Mesh:
    """A strip of metal along y: half widths and heights at even steps, m."""
    n = 14
    at = np.linspace(0, 1, n)
    wide = np.interp(at, np.linspace(0, 1, len(width)), width)
    high = np.interp(at, np.linspace(0, 1, len(lift)), lift)
    across = np.array([1.0, 0.5, -0.5, -1.0])
    cup_ = 0.25 * np.clip(wide - 0.011, 0, 1)[:, None] * (across**2 - 1)
    points = np.stack([x + wide[:, None] * across, np.broadcast_to(long * (at - 0.5)[:, None],
        (n, 4)), high[:, None] + cup_ + 0.0022], -1)  # fmt: skip
    return slab(points[:, ::-1], 0.0016)


def cutlery(x: float, kind: str) -> Mesh:
    """A knife, a spoon or a fork lying along y, handle towards -y, m."""
    if kind == "knife":
        return _blade((0.008, 0.0085, 0.006, 0.005, 0.009, 0.0095, 0.009, 0.002), (0, 0.001, 0.001),
            x, 0.22)  # fmt: skip
    if kind == "spoon":
        return _blade((0.008, 0.007, 0.004, 0.003, 0.004, 0.019, 0.021, 0.008),
            (0, 0.003, 0.007, 0.012, 0.006, 0.003, 0.003, 0.006), x, 0.2)  # fmt: skip
    stem = _blade((0.008, 0.007, 0.004, 0.003, 0.004, 0.012, 0.012),
        (0, 0.003, 0.007, 0.012, 0.01, 0.005, 0.003), x, 0.15)  # fmt: skip
    stem = Mesh(stem.vertices - np.array([0, 0.025, 0], np.float32), stem.faces)
    tines = x + np.array([-0.0098, -0.0033, 0.0033, 0.0098])
    low = np.stack([tines, np.full(4, 0.048), np.full(4, 0.0042)], -1)
    high = np.stack([tines, np.full(4, 0.1), np.full(4, 0.0075)], -1)
    return joined([stem, rods(low, high, 0.001, taper=1.7, sides=5)])


def cutlery_set(rng: np.random.Generator, style: Style) -> Thing:
    """Knife, fork and spoon beside each other, mostly on a folded napkin, m."""
    stuff = (STEEL, CHROME, BRASS)[int(pick(rng, 0, 0, 1, 2))]
    thing = Thing("cutlery")
    lift = 0.0
    if rng.uniform() < 0.7:
        lift = 0.006
        cloth_ = style.second_fabric if rng.uniform() < 0.5 else style.fabric
        thing.add(boards([(-0.055, 0.055, -0.1, 0.1, 0, 0.003),
            (-0.053, 0.054, -0.098, 0.1, 0.0034, lift)], 0.001), cloth_)  # fmt: skip
    kinds = [("knife", "fork"), ("knife", "fork", "spoon"), ("fork", "spoon")][int(rng.integers(3))]
    for k, kind in enumerate(kinds):
        x = 0.032 * (k - (len(kinds) - 1) / 2)
        mesh = placed(cutlery(x, kind), (0, between(rng, -0.006, 0.006), lift),
            turn=float(rng.normal(0, 0.03)))  # fmt: skip
        thing.add(mesh, stuff)
    return stood(thing)


def tray(rng: np.random.Generator, style: Style) -> Thing:
    """A tray with handles, and a teapot and cups, or glasses and a bottle, on it, m."""
    w, d = between(rng, 0.38, 0.5), between(rng, 0.27, 0.34)
    t, h = 0.008, between(rng, 0.025, 0.05)
    walls = [(-w / 2, w / 2, -d / 2, -d / 2 + t, 0, h), (-w / 2, w / 2, d / 2 - t, d / 2, 0, h),
        (-w / 2, -w / 2 + t, -d / 2 + t, d / 2 - t, 0.0006, h - 0.0006),
        (w / 2 - t, w / 2, -d / 2 + t, d / 2 - t, 0.0006, h - 0.0006),
        (-w / 2 + t / 2, w / 2 - t / 2, -d / 2 + t / 2, d / 2 - t / 2, 0.001, 0.007)]  # fmt: skip
    stuff = (style.wood, style.second_wood, style.paint, style.metal)[int(rng.integers(4))]
    thing = Thing("tray").add(boards(walls, 0.0015), stuff)
    loops = []
    for side in (-1, 1):
        path = np.array([(w / 2 - 0.004, -0.05, 0), (w / 2, -0.045, 0.028), (w / 2, 0.045, 0.028),
            (w / 2 - 0.004, 0.05, 0)]) * [side, 1, 1] + [0, 0, h - 0.004]  # fmt: skip
        loops.append(handle(path, 0.004, count=11, sides=6))
    thing.add(joined(loops), stuff if rng.uniform() < 0.5 else style.metal)
    if rng.uniform() < 0.3:
        thing.supports.append(Support(-0.42 * w, 0.42 * w, -0.38 * d, 0.38 * d, 0.007, 0.3))
        return thing
    tall, low = ((teapot, vessels.cup), (vessels.wine_bottle, vessels.glass),
        (vessels.pitcher, vessels.glass))[int(rng.integers(3))]  # fmt: skip
    thing.carry(tall(rng, style), -0.22 * w, 0.12 * d, 0.0075, between(rng, -0.4, 0.4))
    for x, y in ((0.04, -0.22), (0.28, 0.2), (0.3, -0.22))[: int(rng.integers(1, 4))]:
        thing.carry(low(rng, style), x * w, y * d, 0.0075, between(rng, -1, 1))
    return thing


def egg_carton(rng: np.random.Generator, style: Style) -> Thing:
    """Six or ten eggs in their pulp tray, some taken, the lid folded back, m."""
    columns = int(pick(rng, 3, 5))
    pitch = 0.048
    w, d = columns * pitch, 2 * pitch
    x, y = np.meshgrid(np.linspace(-w / 2, w / 2, 6 * columns + 1), np.linspace(-d / 2, d / 2, 13),
        indexing="ij")  # fmt: skip
    wave = np.sin(np.pi * (x + w / 2) / pitch) ** 2 * np.sin(np.pi * (y + d / 2) / pitch) ** 2
    points = np.stack([x, y, 0.034 - 0.024 * wave], -1)
    grey = Material((0.42, 0.4, 0.38), (0.33, 0.32, 0.3), "noise", 0.006, specular=0.0, bump=0.3)
    thing = Thing("egg carton").add(slab(points, 0.002), grey)
    skirt = boards([(-w / 2, w / 2, -d / 2, -d / 2 + 0.002, 0, 0.033),
        (-w / 2, w / 2, d / 2 - 0.002, d / 2, 0, 0.033), (-w / 2, -w / 2 + 0.002, -d / 2 + 0.003,
        d / 2 - 0.003, 0, 0.033), (w / 2 - 0.002, w / 2, -d / 2 + 0.003, d / 2 - 0.003, 0, 0.033)],
        0)  # fmt: skip
    thing.add(skirt, grey)
    lid = boards([(-w / 2, w / 2, 0, 0.002, 0, d), (-w / 2, w / 2, -0.02, 0, 0, 0.002),
        (-w / 2, w / 2, -0.02, 0, d - 0.002, d)], 0)  # fmt: skip
    thing.add(placed(lid, (0, d / 2 + 0.003, 0.033), lean=-0.25), grey)
    shell = Material((0.62, 0.4, 0.25) if rng.uniform() < 0.6 else (0.82, 0.8, 0.76), specular=0.04)
    egg = turned([(0, 0), (0.014, 0.001), (0.022, 0.016), (0.02, 0.036), (0.011, 0.053),
        (0, 0.056)], 12, 8)  # fmt: skip
    for i in range(columns):
        for j in range(2):
            if rng.uniform() < 0.75:
                at = np.array(
                    [(i + 0.5) * pitch - w / 2, (j + 0.5) * pitch - d / 2, 0.011], np.float32
                )
                thing.add(Mesh(egg.vertices + at, egg.faces), shell)
    return stood(thing)


def tin_cans(rng: np.random.Generator, style: Style) -> Thing:
    """Two to five tins with labels, one on others, m."""
    thing = Thing("tin cans")
    r, h = 0.037, pick(rng, 0.11, 0.075)
    ring = [(0, 0.002), (0.9, 0.002), (0.9, 0), (1.03, 0), (1.03, 0.004), (1.0, 0.005),
        (1.0, h - 0.005), (1.03, h - 0.004), (1.03, h), (0.93, h), (0.93, h - 0.003),
        (0, h - 0.003)]  # fmt: skip
    can = revolve(np.array(ring) * [r, 1], 20)
    spots = [(-0.041, 0, 0), (0.041, 0, 0), (0, 0, h + 0.0005), (0.02, -0.074, 0),
        (-0.075, -0.055, 0)]  # fmt: skip
    for spot in spots[: int(rng.integers(2, 6))]:
        at = np.array(spot, np.float32)
        thing.add(Mesh(can.vertices + at, can.faces), STEEL)
        label = cylinder(r + 0.0006, h - 0.014, sides=20)
        label = Mesh(label.vertices + at + np.array([0, 0, h / 2], np.float32), label.faces)
        ground = hue(float(rng.uniform()), 0.8, between(rng, 0.05, 0.6))
        thing.add(label, Material(ground, (0.8, 0.78, 0.7), "marks", 0.02, specular=0.03))
    return stood(thing)


def spray_bottle(rng: np.random.Generator, style: Style) -> Thing:
    """A cleaner's bottle with a trigger, m."""
    h = between(rng, 0.17, 0.21)
    profile = np.array([(0, 0), (0.03, 0), (0.036, 0.01), (0.037, 0.5 * h), (0.03, 0.72 * h),
        (0.016, 0.9 * h), (0.013, h), (0, h)])  # fmt: skip
    body = turned(profile, 24, 18)
    body = Mesh(body.vertices * np.array([1.15, 0.72, 1], np.float32), body.faces)
    tone = hue(float(rng.uniform()), between(rng, 0.3, 0.9), between(rng, 0.3, 0.75))
    thing = Thing("spray bottle").add(body, Material(tone, (0.8, 0.8, 0.8), "marks", 0.03, 0.08))
    head = [(-0.045, 0.022, -0.011, 0.011, h + 0.024, h + 0.046),
        (-0.058, -0.0445, -0.007, 0.007, h + 0.029, h + 0.043),
        (-0.012, 0.014, -0.009, 0.009, h + 0.016, h + 0.026)]  # fmt: skip
    cap = cylinder(0.0155, 0.024, (0, 0, h + 0.007), sides=16)
    lever = handle([(-0.03, 0, h + 0.026), (-0.036, 0, h + 0.005), (-0.05, 0, h - 0.016)], 0.0045,
        count=7, sides=6)  # fmt: skip
    plastic = Material(hue(float(rng.uniform()), 0.8, pick(rng, 0.03, 0.4, 0.7)), specular=0.05)
    thing.add(joined([boards(head, 0.003), cap]), plastic).add(lever, plastic)
    return stood(thing)


CATALOGUE: dict[str, Maker] = {
    "teapot": teapot,
    "pan": pan,
    "pot": pot,
    "candle": candle,
    "candlestick": candlestick,
    "cutlery_set": cutlery_set,
    "tray": tray,
    "egg_carton": egg_carton,
    "tin_cans": tin_cans,
    "spray_bottle": spray_bottle,
}
