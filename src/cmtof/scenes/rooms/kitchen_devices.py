"""Small machines: fans, kettles, toasters, mixers, a microwave, a sewing machine, m."""

import numpy as np

from cmtof.scenes.rooms.cabinetry import BLACK, CHROME, GLOSSY_BLACK, STEEL
from cmtof.scenes.rooms.joinery import boards, corners, placed, rods, shifted
from cmtof.scenes.rooms.materials import Material, Style, hue
from cmtof.scenes.rooms.pliant import spline
from cmtof.scenes.rooms.shaping import handle, hollow, laid, pick, pipe, stood, stretched, turned
from cmtof.scenes.rooms.solids import cylinder, joined, revolve, sheet, tube
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between, glassy

RUBBER = Material((0.015, 0.015, 0.015), specular=0.02, gloss=10.0)


def casing(rng: np.random.Generator, *, dark: float = 0.5) -> Material:
    """A case of black, white, grey or now and then coloured plastic; ``dark`` share black."""
    u = float(rng.uniform())
    if u < dark:
        grey = between(rng, 0.012, 0.06)
        return Material((grey, grey, grey), specular=0.06, gloss=40.0)
    if u < dark + 0.75 * (1 - dark):
        grey = pick(rng, 0.78, 0.7, 0.4)
        return Material((grey, grey, 0.96 * grey), specular=0.06, gloss=60.0)
    return Material(
        hue(float(rng.uniform()), 0.7, between(rng, 0.1, 0.5)), specular=0.08, gloss=80.0
    )


def _cage(r: float, deep: float, z: float, y: float) -> Mesh:
    """Wires before and behind the blades of a fan, and the rings that hold them."""
    n = 22
    a = np.arange(n) * 2 * np.pi / n
    wires = []
    for way in (-1, 1):
        s = np.linspace(0.14, 1, 5)
        radius, depth = r * s, way * deep * np.sqrt(np.clip(1.02 - s**2.5, 0, 1))
        for k in range(4):
            first = np.stack(
                [radius[k] * np.cos(a), y + depth[k] + 0 * a, z + radius[k] * np.sin(a)], -1
            )
            second = np.stack([radius[k + 1] * np.cos(a), y + depth[k + 1] + 0 * a,
                z + radius[k + 1] * np.sin(a)], -1)  # fmt: skip
            wires.append(rods(first, second, 0.0013, sides=3))
    t = np.linspace(0, 2 * np.pi, 33)
    for way, s in ((-1, 0.5), (1, 0.5), (0, 1.0)):
        depth = way * deep * np.sqrt(1.02 - s**2.5) + y
        ring = np.stack([s * r * np.cos(t), depth + 0 * t, z + s * r * np.sin(t)], -1)
        wires.append(tube(ring, 0.004 if way == 0 else 0.0015, 5, capped=False))
    return joined(wires)


def _blades(r: float, count: int, z: float, y: float, turn: float) -> Mesh:
    u, v = np.meshgrid(np.linspace(0.16, 0.9, 6), np.linspace(-1, 1, 6), indexing="ij")
    angle = 0.42 * v * np.sqrt(u) * 6 / count + 0.35 * u
    pitch = 0.16 * r * v * (1.1 - 0.6 * u)
    one = np.stack([r * u * np.cos(angle), pitch, r * u * np.sin(angle)], -1)
    leaf = sheet(one, thickness=0.0015)
    leaves = [placed(leaf, (0, y, z), tilt=turn + 2 * np.pi * k / count) for k in range(count)]
    return joined(leaves)


def table_fan(rng: np.random.Generator, style: Style, *, size: float | None = None) -> Thing:
    """A fan in its wire cage on a foot, m; ``size`` is the radius of the cage."""
    r = between(rng, 0.13, 0.19) if size is None else size
    case = casing(rng, dark=0.3)
    stem = between(rng, 0.35, 0.9) * r
    z = stem + r + 0.02
    thing = Thing("fan")
    foot = turned([(0, 0), (0.75 * r, 0), (0.76 * r, 0.012), (0.5 * r, 0.028), (0.1 * r, 0.04),
        (0.08 * r, stem), (0, stem)], 28, 18)  # fmt: skip
    neck = rods([(0, 0.06, 0.03)], [(0, 0.06, z)], 0.011, sides=10)
    motor = turned([(0, 0), (0.2 * r, 0), (0.3 * r, 0.015), (0.3 * r, 0.06), (0.2 * r, 0.085),
        (0, 0.09)], 18, 12)  # fmt: skip
    thing.add(joined([shifted(foot, 0, 0.06, 0), neck]), case)
    thing.add(shifted(laid(Mesh(motor.vertices * np.array([1, 1, -1], np.float32),
        motor.faces[:, ::-1].copy()), 1), 0, 0.0, z), case)  # fmt: skip
    thing.add(_cage(r, 0.055, z, -0.025), CHROME if rng.uniform() < 0.5 else case)
    tint = Material(hue(float(rng.uniform()), 0.5, between(rng, 0.1, 0.6)), specular=0.06)
    thing.add(_blades(0.95 * r, int(rng.integers(3, 6)), z, -0.025, between(rng, 0, 2)), tint)
    cap = turned([(0, 0), (0.16 * r, 0), (0.16 * r, 0.01), (0.1 * r, 0.02), (0, 0.022)], 16, 9)
    thing.add(shifted(laid(cap, 1), 0, -0.068, z), tint)
    return stood(thing)


def desk_fan(rng: np.random.Generator, style: Style) -> Thing:
    """A small fan for the desk, m."""
    return table_fan(rng, style, size=between(rng, 0.075, 0.11))


def _front_rings(points: list[tuple[float, float]], sides: int) -> Mesh:
    return laid(turned(points, sides, 10), 1)


def microwave(rng: np.random.Generator, style: Style) -> Thing:
    """A microwave oven: door with window and handle, keys or two knobs, m."""
    w, d, h = between(rng, 0.44, 0.52), between(rng, 0.32, 0.4), between(rng, 0.26, 0.3)
    case = STEEL if rng.uniform() < 0.35 else casing(rng, dark=0.4)
    thing = Thing("microwave").add(boards([(-w / 2, w / 2, 0, d, 0.008, h)], 0.006), case)
    split = 0.24 * w
    thing.add(boards([(-w / 2 + 0.004, split, -0.016, -0.001, 0.014, h - 0.006)], 0.004), case)
    thing.add(
        boards([(-0.42 * w, split - 0.09 * w, -0.017, -0.014, 0.2 * h, 0.82 * h)], 0), GLOSSY_BLACK
    )
    grip = rods([(split - 0.025, -0.042, 0.18 * h)], [(split - 0.025, -0.042, 0.84 * h)], 0.007)
    posts = rods([(split - 0.025, -0.014, z * h) for z in (0.23, 0.79)],
        [(split - 0.025, -0.042, z * h) for z in (0.23, 0.79)], 0.005)  # fmt: skip
    thing.add(joined([grip, posts]), STEEL)
    thing.add(
        boards([(split + 0.003, w / 2 - 0.004, -0.014, -0.001, 0.014, h - 0.006)], 0.003), BLACK
    )
    x = (split + w / 2) / 2
    if rng.uniform() < 0.5:
        knob = _front_rings([(0, 0), (0.022, 0), (0.024, 0.004), (0.02, 0.02), (0, 0.021)], 20)
        thing.add(joined([shifted(knob, x, -0.013, z * h) for z in (0.65, 0.32)]), STEEL)
    else:
        keys = [(x + (i - 1) * 0.026 - 0.01, x + (i - 1) * 0.026 + 0.01, -0.016, -0.013,
            0.18 * h + 0.024 * j,
            0.18 * h + 0.024 * j + 0.016) for i in range(3) for j in range(5)]  # fmt: skip
        thing.add(boards(keys, 0.001), Material((0.4, 0.4, 0.4), specular=0.05))
        show = Material((0.1, 0.6, 0.4), (0.01, 0.02, 0.02), "marks", 0.02, emission=0.5)
        thing.add(boards([(x - 0.036, x + 0.036, -0.0155, -0.013, 0.8 * h, 0.9 * h)], 0), show)
    feet = [
        (a - 0.015, a + 0.015, b - 0.015, b + 0.015, 0, 0.01) for a, b, _ in corners(0.42 * w, 0.13)
    ]
    return stood(thing.add(shifted(boards(feet, 0.002), 0, d / 2, 0), RUBBER))


def kettle(rng: np.random.Generator, style: Style) -> Thing:
    """An electric jug on its base, or a whistling kettle with a bail handle, m."""
    thing = Thing("kettle")
    if rng.uniform() < 0.4:
        r = between(rng, 0.085, 0.105)
        stuff = (STEEL, CHROME, casing(rng, dark=0.3), style.accent)[int(rng.integers(4))]
        body = turned(np.array([(0, 0), (0.95, 0), (1, 0.08), (0.96, 0.5), (0.75, 1.0),
            (0.38, 1.25), (0.36, 1.3), (0.1, 1.34), (0.09, 1.42), (0.16, 1.52), (0, 1.55)]) * r, 30,
            24)  # fmt: skip
        path = spline(
            [(-0.75 * r, 0, 0.6 * r), (-1.15 * r, 0, 0.85 * r), (-1.45 * r, 0, 1.2 * r)], 7
        )
        spout = pipe(path, np.linspace(0.26 * r, 0.14 * r, 7), 0.003)
        thing.add(joined([body, spout]), stuff)
        bail = handle([(-0.62 * r, 0, 1.1 * r), (-0.62 * r, 0, 1.9 * r), (0, 0, 2.25 * r),
            (0.62 * r, 0, 1.9 * r), (0.62 * r, 0, 1.1 * r)], [0.004, 0.007, 0.011, 0.007, 0.004],
            count=16)  # fmt: skip
        return stood(thing.add(bail, BLACK if rng.uniform() < 0.6 else style.wood))
    r, h = between(rng, 0.068, 0.08), between(rng, 0.19, 0.23)
    stuff = STEEL if rng.uniform() < 0.5 else casing(rng, dark=0.3)
    thing.add(
        turned([(0, 0), (1.15 * r, 0), (1.15 * r, 0.014), (r, 0.02), (0, 0.02)], 28, 12), BLACK
    )
    body = turned([(0, 0.0205), (0.97 * r, 0.0205), (r, 0.04), (0.94 * r, 0.6 * h), (0.76 * r, h),
        (0, h)], 28, 16)  # fmt: skip
    x, y, z = body.vertices.T.astype(float)
    lip = (np.clip((z / h - 0.75) / 0.25, 0, 1) ** 2 * np.exp(-((np.arctan2(y,
        -x) / 0.3) ** 2)) * np.hypot(x, y) / r)  # fmt: skip
    thing.add(Mesh(np.stack([x - 0.035 * lip, y, z], -1).astype(np.float32), body.faces), stuff)
    lid = turned([(0, h + 0.0005), (0.72 * r, h + 0.0005), (0.7 * r, h + 0.008),
        (0.2 * r, h + 0.012), (0.15 * r, h + 0.022), (0, h + 0.024)], 24, 14)  # fmt: skip
    grip = handle([(0.7 * r, 0, 0.97 * h), (1.35 * r, 0, 1.02 * h), (1.6 * r, 0, 0.7 * h),
        (1.4 * r, 0, 0.32 * h), (0.95 * r, 0, 0.24 * h)], [0.01, 0.011, 0.012, 0.01, 0.008],
        count=13)  # fmt: skip
    return stood(thing.add(joined([lid, stretched(grip, 1, 1.3, 1)]), BLACK))


def toaster(rng: np.random.Generator, style: Style) -> Thing:
    """A toaster with two slots, lever and knob, mostly empty, m."""
    w, d, h = between(rng, 0.26, 0.31), between(rng, 0.15, 0.18), between(rng, 0.17, 0.2)
    stuff = (CHROME, STEEL, casing(rng, dark=0.3), style.accent)[int(rng.integers(4))]
    round_ = np.linspace(0, np.pi, 15)
    arch = np.stack([-d / 2 * np.sign(np.cos(round_)) * np.abs(np.cos(round_)) ** 0.45,
        0.55 * h + 0.45 * h * np.sin(round_) ** 0.45], -1)  # fmt: skip
    outline = np.concatenate([[(-d / 2, 0.012)], arch, [(d / 2, 0.012)]])
    skin = np.empty((len(outline), 2, 3))
    skin[..., 0], skin[..., 1], skin[..., 2] = (np.array([-w / 2, w / 2]), outline[:, :1],
        outline[:, 1:])  # fmt: skip
    thing = Thing("toaster").add(sheet(skin[:, ::-1]), stuff)
    for side in (-1, 1):
        middle = np.broadcast_to([side * w / 2, 0, 0.4 * h], (len(outline), 3))
        face = np.stack([skin[:, 0 if side < 0 else 1], middle], 1)
        thing.add(sheet(face if side < 0 else face[:, ::-1]), BLACK)
    slots = [
        (-0.4 * w, 0.4 * w, y - 0.014, y + 0.014, h - 0.01, h + 0.0012) for y in (-0.032, 0.032)
    ]
    thing.add(boards(slots, 0), Material((0.008, 0.008, 0.008), specular=0.0))
    if rng.uniform() < 0.4:
        toast = [
            (-0.3 * w, 0.25 * w, y - 0.008, y + 0.008, h - 0.01, h + 0.035) for y in (-0.032, 0.032)
        ]
        thing.add(
            boards(toast, 0.004), Material((0.5, 0.3, 0.12), (0.3, 0.15, 0.05), "noise", 0.02, 0.0)
        )
    parts = [(w / 2 - 0.002, w / 2 + 0.025, -0.02, 0.02, 0.62 * h, 0.7 * h)]
    thing.add(boards(parts, 0.003), BLACK)
    knob = laid(turned([(0, 0), (0.014, 0), (0.013, 0.012), (0, 0.013)], 14, 8), 0)
    thing.add(shifted(knob, w / 2 - 0.001, 0, 0.25 * h), STEEL)
    feet = [(a - 0.012, a + 0.012, b - 0.012, b + 0.012, 0, 0.014) for a, b,
        _ in corners(0.4 * w, 0.35 * d)]  # fmt: skip
    base = boards(
        [(-w / 2 + 0.004, w / 2 - 0.004, -d / 2 + 0.003, d / 2 - 0.003, 0.01, 0.02), *feet], 0.002
    )
    return stood(thing.add(base, BLACK))


def coffee_machine(rng: np.random.Generator, style: Style) -> Thing:
    """A filter machine with its pot, or an espresso machine with portafilter, m."""
    thing = Thing("coffee machine")
    case = STEEL if rng.uniform() < 0.3 else casing(rng, dark=0.5)
    if rng.uniform() < 0.5:
        w, d, h = 0.18, 0.24, between(rng, 0.3, 0.36)
        body = [(-w / 2, w / 2, 0.06, d / 2, 0.0, h), (-w / 2, w / 2, -d / 2, 0.07, 0.0, 0.035),
            (-w / 2, w / 2, -d / 2, 0.07, 0.66 * h, h)]  # fmt: skip
        thing.add(boards(body, 0.008), case)
        thing.add(shifted(cylinder(0.062, 0.004, sides=24), 0, -0.03, 0.037), BLACK)
        pot = hollow([(0, 0), (0.05, 0), (0.062, 0.03), (0.058, 0.075), (0.043, 0.105),
            (0.046, 0.115)], 0.0025, sides=24)  # fmt: skip
        thing.add(shifted(pot, 0, -0.03, 0.0395), glassy(rng))
        lid = turned([(0, 0.116), (0.046, 0.116), (0.044, 0.122), (0, 0.126)], 20, 9)
        grip = handle([(0.03, -0.03, 0.112), (0.075, -0.05, 0.112), (0.09, -0.06, 0.07),
            (0.07, -0.05, 0.03)], 0.008, count=10)  # fmt: skip
        grip = shifted(grip, -0.0, -0.0, 0.0395)
        thing.add(joined([shifted(lid, 0, -0.03, 0.0395), grip]), BLACK)
        light = Material((0.8, 0.1, 0.05), emission=0.8)
        return stood(thing.add(boards([(0.05, 0.065, -d / 2 - 0.002, -d / 2 + 0.002, 0.013, 0.021)],
            0.0005), light))  # fmt: skip
    w, d, h = between(rng, 0.2, 0.28), 0.28, between(rng, 0.28, 0.33)
    body = [(-w / 2, w / 2, 0.02, d / 2, 0.008, h), (-w / 2, w / 2, -d / 2, 0.03, 0.008, 0.05),
        (-w / 2, w / 2, -0.1, 0.03, 0.72 * h, h)]  # fmt: skip
    thing.add(boards(body, 0.006), case)
    slats = [(-w / 2 + 0.012, w / 2 - 0.012, y, y + 0.006, 0.0505,
        0.053) for y in np.linspace(-d / 2 + 0.012, 0.0, 10)]  # fmt: skip
    thing.add(boards(slats, 0), CHROME)
    group = turned([(0, 0), (0.03, 0), (0.034, 0.012), (0.036, 0.05), (0, 0.05)], 22, 12)
    thing.add(shifted(group, 0, -0.045, 0.72 * h - 0.046), CHROME)
    grip = handle([(0, -0.07, 0.7 * h - 0.03), (0, -0.12, 0.7 * h - 0.034),
        (0, -0.2, 0.7 * h - 0.04)], [0.006, 0.01, 0.013], count=7)  # fmt: skip
    wand = tube(spline([(0.38 * w, -0.08, 0.74 * h), (0.4 * w, -0.09, 0.55 * h),
        (0.43 * w, -0.1, 0.3 * h)], 8), 0.004, 7)  # fmt: skip
    thing.add(grip, style.wood if rng.uniform() < 0.4 else BLACK).add(wand, CHROME)
    knobs = [shifted(_front_rings([(0, 0), (0.015, 0), (0.013, 0.014), (0, 0.015)], 16), x * w,
        -0.1, 0.87 * h) for x in (-0.3, -0.12, 0.3)]  # fmt: skip
    thing.add(joined(knobs), BLACK)
    feet = [(a - 0.012, a + 0.012, b - 0.012, b + 0.012, 0, 0.01) for a, b,
        _ in corners(0.42 * w, 0.42 * d)]  # fmt: skip
    return stood(thing.add(boards(feet, 0.002), RUBBER))


def blender(rng: np.random.Generator, style: Style) -> Thing:
    """A tapered glass jug with lid and handle on a motor, m."""
    case = STEEL if rng.uniform() < 0.4 else casing(rng, dark=0.4)
    thing = Thing("blender")
    base = turned([(0, 0), (0.095, 0), (0.1, 0.02), (0.085, 0.09), (0.06, 0.135), (0.058, 0.15),
        (0, 0.15)], 4, 22)  # fmt: skip
    if rng.uniform() < 0.5:
        base = turned(
            [(0, 0), (0.085, 0), (0.09, 0.02), (0.075, 0.09), (0.058, 0.135), (0, 0.135)], 28, 18
        )
    base = placed(base, turn=np.pi / 4)
    thing.add(base, case)
    jug = hollow(
        [(0, 0.13), (0.05, 0.13), (0.055, 0.15), (0.075, 0.34), (0.078, 0.355)], 0.003, sides=24
    )
    thing.add(jug, glassy(rng))
    lid = turned([(0, 0.356), (0.079, 0.356), (0.078, 0.37), (0.03, 0.374), (0.028, 0.39),
        (0, 0.392)], 24, 14)  # fmt: skip
    grip = handle(
        [(0.06, 0, 0.33), (0.12, 0, 0.33), (0.125, 0, 0.22), (0.052, 0, 0.17)], 0.009, count=11
    )
    thing.add(joined([lid, grip]), BLACK)
    knob = shifted(
        _front_rings([(0, 0), (0.018, 0), (0.016, 0.016), (0, 0.017)], 18), 0, -0.062, 0.06
    )
    return stood(thing.add(knob, STEEL))


def sewing_machine(rng: np.random.Generator, style: Style) -> Thing:
    """A machine with bed, arm, head, needle and hand wheel, m."""
    case = casing(rng, dark=0.25)
    thing = Thing("sewing machine")
    body = [(-0.2, 0.2, -0.08, 0.09, 0.0, 0.06), (0.09, 0.19, -0.05, 0.06, 0.05, 0.27),
        (-0.18, 0.19, -0.05, 0.055, 0.2, 0.285),
        (-0.2, -0.12, -0.052, 0.05, 0.15, 0.28)]  # fmt: skip
    thing.add(boards(body, 0.014), case)
    thing.add(boards([(-0.19, -0.02, -0.07, 0.04, 0.0595, 0.0615)], 0.0005), CHROME)
    pins = rods([(-0.16, 0, 0.062), (-0.145, 0, 0.07), (-0.05, 0.01, 0.28), (0.05, 0.01, 0.28)],
        [(-0.16, 0, 0.16), (-0.145, 0, 0.16), (-0.05, 0.01, 0.34), (0.05, 0.01, 0.34)], 0.0025,
        sides=6)  # fmt: skip
    foot = boards([(-0.172, -0.135, -0.022, 0.016, 0.066, 0.069)], 0.0006)
    thing.add(joined([pins, foot]), CHROME)
    wheel = turned(
        [(0, 0), (0.034, 0), (0.042, 0.006), (0.042, 0.02), (0.03, 0.026), (0, 0.026)], 24, 14
    )
    thing.add(shifted(laid(wheel, 0), 0.189, 0, 0.24), BLACK)
    spool = revolve([(0, 0), (0.014, 0), (0.014, 0.003), (0.01, 0.005), (0.01, 0.035),
        (0.014, 0.037), (0.014, 0.04), (0, 0.04)], 14)  # fmt: skip
    for x in (-0.05, 0.05):
        thread = Material(hue(float(rng.uniform()), 0.8, 0.3), (0.1, 0.1, 0.1), "stripes", 0.001)
        thing.add(shifted(spool, x, 0.01, 0.286), thread)
    dials = [shifted(_front_rings([(0, 0), (0.018, 0), (0.016, 0.012), (0, 0.013)], 16), 0.14,
        -0.049, z) for z in (0.24, 0.18, 0.12)]  # fmt: skip
    return stood(thing.add(joined(dials), STEEL))


def hair_dryer(rng: np.random.Generator, style: Style) -> Thing:
    """A hair dryer that lies on its side, its cord in a loop, m."""
    case = casing(rng, dark=0.5)
    barrel = laid(turned([(0, -0.1), (0.036, -0.1), (0.043, -0.07), (0.04, 0.0), (0.03, 0.06),
        (0.03, 0.09), (0.024, 0.088), (0.024, 0.04), (0, 0.04)], 24, 22), 0)  # fmt: skip
    grip = handle([(-0.045, -0.02, 0), (-0.05, -0.08, 0), (-0.035, -0.15, 0)],
        [0.022, 0.019, 0.016], count=8, sides=10)  # fmt: skip
    thing = Thing("hair dryer").add(
        joined([shifted(barrel, 0, 0, 0.043), shifted(grip, 0, 0, 0.038)]), case
    )
    nozzle = laid(
        turned([(0.031, 0), (0.032, 0.03), (0.034, 0.06), (0.032, 0.06), (0.03, 0.03)], 20, 12), 0
    )
    thing.add(shifted(stretched(nozzle, 1, 1, 0.6), 0.082, 0, 0.043), BLACK)
    cord = spline([(-0.035, -0.15, 0.038), (-0.03, -0.19, 0.01), (0.02, -0.21, 0.004),
        (0.1, -0.17, 0.004), (0.11, -0.08, 0.004), (0.06, -0.06, 0.004), (0.03, -0.12, 0.009),
        (0.12, -0.2, 0.004)], 44)  # fmt: skip
    return stood(thing.add(tube(cord, 0.0035, 6), RUBBER))


def game_controller(rng: np.random.Generator, style: Style) -> Thing:
    """Two grips, two sticks, buttons and a cross, m."""
    case = casing(rng, dark=0.5)
    thing = Thing("game controller")
    middle = boards([(-0.055, 0.055, -0.02, 0.035, 0.014, 0.042)], 0.01)
    grips = [handle([(s * 0.05, 0.015, 0.03), (s * 0.07, -0.02, 0.026), (s * 0.072, -0.065, 0.018)],
        [0.021, 0.021, 0.014], count=8, sides=12) for s in (-1, 1)]  # fmt: skip
    thing.add(joined([middle, *grips]), case)
    stick = turned(
        [(0, 0), (0.005, 0), (0.005, 0.01), (0.01, 0.012), (0.0095, 0.016), (0, 0.015)], 14, 10
    )
    cross = [(-0.064, -0.04, 0.017, 0.024, 0.044, 0.0525), (-0.0555, -0.0485, 0.0085, 0.0325, 0.044,
        0.052)]  # fmt: skip
    thing.add(joined([*(shifted(stick, s * 0.026, -0.008, 0.041) for s in (-1, 1)),
        boards(cross, 0.001)]), BLACK)  # fmt: skip
    for k, (x, y) in enumerate(((0.052, 0.032), (0.064, 0.02), (0.052, 0.008), (0.04, 0.02))):
        tint = Material(hue(0.25 * k + 0.02, 0.8, 0.5), specular=0.1)
        thing.add(shifted(cylinder(0.0048, 0.012, sides=12), x, y, 0.048), tint)
    triggers = [(s * 0.055 - 0.018, s * 0.055 + 0.018, 0.022, 0.042, 0.02, 0.036) for s in (-1, 1)]
    return stood(thing.add(boards(triggers, 0.005), BLACK))


CATALOGUE: dict[str, Maker] = {
    "table_fan": table_fan,
    "desk_fan": desk_fan,
    "microwave": microwave,
    "kettle": kettle,
    "toaster": toaster,
    "coffee_machine": coffee_machine,
    "blender": blender,
    "sewing_machine": sewing_machine,
    "hair_dryer": hair_dryer,
    "game_controller": game_controller,
}
