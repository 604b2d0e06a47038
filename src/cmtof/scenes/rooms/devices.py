"""Sound, office and photography: radios, clocks, telephones, cameras, m."""

import numpy as np

from cmtof.scenes.rooms import kitchen_devices, screens
from cmtof.scenes.rooms.cabinetry import BLACK, CHROME, GLOSSY_BLACK
from cmtof.scenes.rooms.joinery import boards, placed, rods, shifted
from cmtof.scenes.rooms.kitchen_devices import casing
from cmtof.scenes.rooms.materials import Material, Style, hue
from cmtof.scenes.rooms.pliant import spline
from cmtof.scenes.rooms.screens import GRILLE, RUBBER, SILVER
from cmtof.scenes.rooms.shaping import handle, laid, pick, stood, turned
from cmtof.scenes.rooms.solids import cylinder, joined, revolve, sheet, tube
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between

LETTERED = Material((0.7, 0.7, 0.68), (0.05, 0.05, 0.05), "marks", 0.012, specular=0.03)


def _cone(radius: float, x: float, z: float) -> tuple[Mesh, Mesh]:
    """A driver in a front at y = 0: ring and surround, cone and dust cap."""
    r = radius
    ring = revolve([(1.0 * r, -0.001), (1.0 * r, 0.003), (0.86 * r, 0.004), (0.84 * r, 0.001)], 24)
    rubber = [(0.86 * r, 0.001), (0.8 * r, 0.004), (0.72 * r, 0.0012), (0.36 * r, 0.0007),
        (0.3 * r, 0.001), (0.2 * r, 0.006), (0, 0.009)]  # fmt: skip
    return shifted(laid(ring, 1), x, 0, z), shifted(laid(revolve(rubber, 24), 1), x, 0, z)


def loudspeaker(rng: np.random.Generator, style: Style) -> Thing:
    """A shelf speaker or a slim tower, drivers bare or behind cloth, m."""
    tower = rng.uniform() < 0.2
    w = between(rng, 0.15, 0.23)
    h = between(rng, 0.85, 1.1) if tower else w * between(rng, 1.5, 1.8)
    d = w * between(rng, 1.1, 1.4)
    case = style.wood if rng.uniform() < 0.5 else (BLACK if rng.uniform() < 0.6 else style.paint)
    thing = Thing("loudspeaker").add(boards([(-w / 2, w / 2, 0, d, 0.004, h)], 0.004), case, 2)
    thing.add(boards([(x - 0.012, x + 0.012, y, y + 0.024, 0, 0.006) for x in (-0.35 * w,
        0.35 * w) for y in (0.02, d - 0.05)], 0.001), RUBBER)  # fmt: skip
    if rng.uniform() < 0.35:
        cloth = boards([(-w / 2 + 0.008, w / 2 - 0.008, -0.012, 0.001, 0.015, h - 0.01)], 0.004)
        return stood(
            thing.add(cloth, Material((0.03, 0.03, 0.03), (0.06, 0.06, 0.06), "weave", 0.003, 0.0))
        )
    r = 0.4 * w
    drivers = [(r, h - 0.16 * w - 1.65 * r), (0.16 * w, h - 0.27 * w)]
    if tower:
        drivers.append((r, h - 0.2 * w - 3.8 * r))
    rings, cones = zip(*(_cone(radius, 0.0, z) for radius, z in drivers), strict=True)
    thing.add(joined(list(rings)), SILVER if rng.uniform() < 0.5 else BLACK)
    thing.add(joined(list(cones)), RUBBER if rng.uniform() < 0.7 else Material((0.6, 0.5, 0.1),
        specular=0.05))  # fmt: skip
    return stood(thing)


def radio(rng: np.random.Generator, style: Style) -> Thing:
    """A table radio in wood or plastic: grille, dial, knobs, handle or aerial, m."""
    w, h, d = between(rng, 0.2, 0.32), between(rng, 0.12, 0.19), between(rng, 0.08, 0.14)
    case = style.wood if rng.uniform() < 0.5 else casing(rng, dark=0.2)
    thing = Thing("radio").add(boards([(-w / 2, w / 2, 0, d, 0.004, h)], 0.012), case)
    thing.add(boards([(s * 0.38 * w - 0.01, s * 0.38 * w + 0.01, 0.015, d - 0.015, 0,
        0.006) for s in (-1, 1)]), RUBBER)  # fmt: skip
    edge = between(rng, 0.02, 0.12) * w
    bars = np.linspace(0.2 * h, 0.85 * h, 9)
    thing.add(boards([(-0.44 * w, edge, -0.001, 0.002, 0.16 * h, 0.89 * h)], 0), GRILLE)
    thing.add(
        boards([(-0.44 * w, edge, -0.004, 0.001, z - 0.0015, z + 0.0015) for z in bars], 0), SILVER
    )
    thing.add(
        boards([(edge + 0.05 * w, 0.45 * w, -0.0015, 0.002, 0.55 * h, 0.86 * h)], 0), LETTERED
    )
    knobs = []
    for x in (edge + 0.12 * w, 0.37 * w):
        knob = turned([(0, 0), (0.016, 0), (0.017, 0.004), (0.0145, 0.016), (0, 0.017)], 16, 9)
        knobs.append(shifted(laid(knob, 1), x, 0.001, 0.3 * h))
    thing.add(joined(knobs), SILVER if rng.uniform() < 0.5 else BLACK)
    if rng.uniform() < 0.5:
        path = [(-0.4 * w, 0.5 * d, h - 0.005), (-0.38 * w, 0.5 * d, h + 0.03),
            (0.38 * w, 0.5 * d, h + 0.03), (0.4 * w, 0.5 * d, h - 0.005)]  # fmt: skip
        thing.add(handle(path, 0.005, count=14, sides=6), SILVER)
    else:
        thing.add(rods([(0.42 * w, 0.9 * d, h - 0.004)], [(0.1 * w, 0.9 * d, h + 0.2)], 0.0022,
            sides=6), CHROME)  # fmt: skip
    return stood(thing)


_SEGMENTS = ("abcdef", "bc", "abged", "abgcd", "fgbc", "afgcd", "afgedc", "abc", "abcdefg",
    "abcdfg")  # fmt: skip


def _digit(digit: int, x: float, z: float, w: float, h: float) -> list[tuple[float, ...]]:
    """Bars of a digit of seven segments, its lower left corner at (x, z), m."""
    t = 0.16 * w
    bars = {"a": (0, w, h - t, h), "d": (0, w, 0, t), "g": (0, w, (h - t) / 2, (h + t) / 2),
        "f": (0, t, h / 2, h), "b": (w - t, w, h / 2, h), "e": (0, t, 0, h / 2),
        "c": (w - t, w, 0, h / 2)}  # fmt: skip
    lit = [bars[s] for s in _SEGMENTS[digit]]
    return [(x + a, x + b, -0.0312, -0.03, z + c, z + e) for a, b, c, e in lit]


def alarm_clock(rng: np.random.Generator, style: Style) -> Thing:
    """A twin-bell clock, a cube with digits, or a round travel clock, m."""
    thing = Thing("alarm clock")
    if rng.uniform() < 0.35:
        w, h = between(rng, 0.1, 0.2), between(rng, 0.05, 0.08)
        thing.add(boards([(-w / 2, w / 2, -0.03, 0.035, 0, h)], 0.008), casing(rng, dark=0.5))
        thing.add(
            boards([(-0.42 * w, 0.42 * w, -0.0306, -0.028, 0.15 * h, 0.85 * h)], 0), GLOSSY_BLACK
        )
        digits = [*divmod(int(rng.integers(24)), 10), *divmod(int(rng.integers(60)), 10)]
        bars = [bar for x, digit in zip((-0.34, -0.17, 0.04, 0.21), digits,
            strict=True) for bar in _digit(digit, x * w, 0.25 * h, 0.12 * w, 0.5 * h)]  # fmt: skip
        red = Material(((0.8, 0.06, 0.03), (0.1, 0.7, 0.3), (0.5, 0.7, 0.8))[int(rng.integers(3))],
            emission=0.6)  # fmt: skip
        return stood(thing.add(boards(bars, 0), red))
    r, d = between(rng, 0.04, 0.06), 0.04
    z = r + 0.012
    body = turned([(0, -d / 2), (0.96 * r, -d / 2), (r, -d / 2 + 0.004), (r, d / 2 - 0.002),
        (1.03 * r, d / 2), (1.03 * r, d / 2 + 0.004), (0.93 * r, d / 2 + 0.004),
        (0.92 * r, d / 2 - 0.001), (0, d / 2 - 0.001)], 32, 22)  # fmt: skip
    shell = (CHROME, SILVER, casing(rng, dark=0.2), style.accent)[int(rng.integers(4))]
    thing.add(shifted(laid(body, 1), 0, 0, z), shell)
    dial = shifted(laid(revolve([(0.9 * r, d / 2), (0, d / 2)], 28), 1), 0, 0, z)
    thing.add(dial, Material((0.8, 0.79, 0.74), specular=0.05))
    y = -d / 2 - 0.0012
    a, b = between(rng, 0, 6.28), between(rng, 0, 6.28)
    marks = [((0.76 * r * np.sin(t), y, z + 0.76 * r * np.cos(t)),
        (0.86 * r * np.sin(t), y,
        z + 0.86 * r * np.cos(t))) for t in np.arange(12) * np.pi / 6]  # fmt: skip
    marks += [((0, y - 0.0004, z), (0.5 * r * np.sin(a), y - 0.0004, z + 0.5 * r * np.cos(a))),
        ((0, y - 0.001, z),
        (0.75 * r * np.sin(b), y - 0.001, z + 0.75 * r * np.cos(b)))]  # fmt: skip
    ends = np.array(marks)
    thing.add(rods(ends[:, 0], ends[:, 1], 0.0011, sides=4), BLACK)
    legs = rods([(s * 0.75 * r, 0, 0.0) for s in (-1, 1)], [(s * 0.5 * r, 0,
        0.3 * r + 0.012) for s in (-1, 1)], 0.004)  # fmt: skip
    thing.add(legs, shell)
    if rng.uniform() < 0.6:
        bell = turned([(0, 0.3), (0.42, 0.0), (0.45, 0.02), (0.3, 0.3), (0, 0.42)], 20, 10)
        dome = Mesh(bell.vertices * np.float32(r), bell.faces)
        bells = [placed(dome, (s * 0.55 * r, 0, z + 0.86 * r), tilt=s * 0.55) for s in (-1, 1)]
        thing.add(joined(bells), CHROME)
        grip = handle([(-0.55 * r, 0, z + 1.2 * r), (0, 0, z + 1.62 * r),
            (0.55 * r, 0, z + 1.2 * r)], 0.0022, sides=6)  # fmt: skip
        thing.add(grip, CHROME)
    return stood(thing)


def telephone(rng: np.random.Generator, style: Style) -> Thing:
    """A desk telephone with keys or a dial, receiver on its rest, coiled cord, m."""
    tone = hue(float(rng.uniform()), pick(rng, 0, 0.8), pick(rng, 0.02, 0.2, 0.7))
    case = Material(tone, specular=0.1, gloss=150.0)
    w, d = 0.2, 0.22
    x, y = np.meshgrid(np.linspace(-w / 2, w / 2, 3), np.linspace(-d / 2, d / 2, 9), indexing="ij")
    t = (y + d / 2) / d
    z = 0.02 + 0.06 * t**1.3
    thing = Thing("telephone")
    top = sheet(np.stack([x, y, z], -1))
    rim = []
    for k in (0, -1):
        lower = np.stack([x[k], y[k], 0 * z[k]], -1)
        upper = np.stack([x[k], y[k], z[k]], -1)
        rim.append(sheet(np.stack([upper, lower], 1)[:, :: -1 if k else 1]))
    ends = boards([(-w / 2, w / 2, d / 2 - 0.002, d / 2, 0, 0.08),
        (-w / 2, w / 2, -d / 2, -d / 2 + 0.002, 0, 0.02)], 0)  # fmt: skip
    thing.add(joined([top, *rim, ends]), case)
    old = rng.uniform() < 0.4
    if old:
        dial = shifted(turned([(0, 0), (0.052, 0), (0.05, 0.006), (0.02, 0.008), (0, 0.008)], 28,
            12), 0.02, -0.03, 0)  # fmt: skip
        holes = [shifted(cylinder(0.007, 0.004, sides=10), 0.02 + 0.037 * np.cos(a),
            -0.03 + 0.037 * np.sin(a), 0.006) for a in np.linspace(-0.6, 4.2, 10)]  # fmt: skip
        lean = {"at": (0.02, 0.0, 0.04), "lean": 0.3}
        thing.add(placed(dial, **lean), CHROME).add(placed(joined(holes), **lean), BLACK)
    else:
        keys = [(0.005 + 0.022 * i, 0.021 + 0.022 * i, -0.08 + 0.024 * j, -0.064 + 0.024 * j, 0,
            0.005) for i in range(3) for j in range(4)]  # fmt: skip
        thing.add(placed(boards(keys, 0.001), (0, 0, 0.046), lean=0.28), LETTERED)
        show = boards([(0, 0.075, 0.035, 0.062, 0, 0.002)], 0)
        thing.add(placed(show, (0, 0, 0.049), lean=0.33), GLOSSY_BLACK)
    at = -0.062 if not old else 0.0
    line = [(at, -0.095, 0.06), (at, -0.08, 0.085), (at, 0, 0.103), (at, 0.08, 0.115),
        (at, 0.095, 0.1)]  # fmt: skip
    if old:
        line = [(p[1], 0.06, p[2] + 0.015 + 0.1 * (0.1 - abs(p[1]))) for p in line]
        line = [(p[0], p[1], 0.1 if abs(p[0]) > 0.09 else 0.125) for p in line]
    thing.add(handle(line, [0.02, 0.015, 0.013, 0.015, 0.02], count=14, sides=10), case)
    n = 60
    s = np.linspace(0, 1, n)
    cord = spline(
        [(-0.1, -0.06, 0.012), (-0.15, -0.03, 0.009), (-0.16, 0.05, 0.009), (-0.1, 0.1, 0.012)], n
    )
    coil = cord + 0.006 * np.stack([np.cos(75 * s), 0 * s, np.sin(75 * s)], -1)
    return stood(thing.add(tube(coil, 0.002, 4), case))


def printer(rng: np.random.Generator, style: Style) -> Thing:
    """An ink-jet with its scanner lid, paper standing in its back and lying in front, m."""
    w, d, h = between(rng, 0.42, 0.47), between(rng, 0.3, 0.36), between(rng, 0.14, 0.22)
    case = casing(rng, dark=0.4)
    thing = Thing("printer")
    thing.add(boards([(-w / 2, w / 2, -d / 2, d / 2, 0.004, 0.72 * h)], 0.01), case)
    thing.add(boards([(-w / 2 + 0.004, w / 2 - 0.004, -d / 2 + 0.004, d / 2 - 0.02, 0.735 * h, h)],
        0.008), case)  # fmt: skip
    thing.add(boards([(-0.34 * w, 0.34 * w, -d / 2 - 0.0008, -d / 2 + 0.002, 0.18 * h, 0.5 * h)],
        0), RUBBER)  # fmt: skip
    thing.add(boards([(0.37 * w, 0.48 * w, -d / 2 - 0.002, -d / 2 + 0.01, 0.45 * h, 0.66 * h)],
        0.001), GLOSSY_BLACK)  # fmt: skip
    tray = boards(
        [(-0.27 * w, 0.27 * w, -d / 2 - 0.12, -d / 2 + 0.01, 0.16 * h, 0.16 * h + 0.004)], 0.001
    )
    page = boards(
        [(-0.105, 0.105, -d / 2 - 0.1, -d / 2 + 0.01, 0.17 * h + 0.004, 0.17 * h + 0.006)], 0
    )
    thing.add(tray, case).add(page, LETTERED)
    if rng.uniform() < 0.7:
        leaf = placed(
            boards([(-0.105, 0.105, 0, 0.003, 0, 0.24)], 0), (0, d / 2 - 0.018, 0.7 * h), lean=-0.3
        )
        rest = placed(boards([(-0.115, 0.115, 0.004, 0.007, 0, 0.16)], 0.001),
            (0, d / 2 - 0.018, 0.7 * h), lean=-0.3)  # fmt: skip
        thing.add(leaf, Material((0.8, 0.8, 0.79))).add(rest, case)
    thing.add(boards([(s * 0.4 * w - 0.015, s * 0.4 * w + 0.015, -0.3 * d, 0.3 * d, 0,
        0.006) for s in (-1, 1)]), RUBBER)  # fmt: skip
    return stood(thing)


def camera_on_tripod(rng: np.random.Generator, style: Style) -> Thing:
    """A camera with its lens on a three-legged stand that stands on the floor, m."""
    h = between(rng, 0.95, 1.45)
    turn = np.arange(3) * 2 * np.pi / 3 + between(rng, 0, 2)
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
    far = between(rng, 0.3, 0.42)
    middle = 0.45 * h
    feet, knees = ring * far, ring * (far * 0.5) + [0, 0, 0.4 * h]
    hips = ring * 0.035 + [0, 0, 0.8 * h]
    thing = Thing("camera")
    legs = [rods(feet + np.array([0, 0, 0.01]), knees, 0.0085),
        rods(knees - 0.02 * ring, hips, 0.0125)]  # fmt: skip
    column = rods(
        [(0, 0, middle), (0, 0, 0.78 * h)], [(0, 0, h), (0, 0, 0.82 * h)], 0.012, sides=12
    )
    collar = cylinder(0.045, 0.05, (0, 0, 0.8 * h), sides=12)
    braces = rods(0.55 * knees + 0.45 * hips, [(0, 0, 0.55 * h)] * 3, 0.004, sides=5)
    pads = [shifted(cylinder(0.015, 0.02, sides=10), *(f + np.array([0, 0, 0.01]))) for f in feet]
    thing.add(joined([*legs, column, collar, braces]), BLACK if rng.uniform() < 0.6 else SILVER)
    thing.add(joined(pads), RUBBER)
    head = [(-0.025, 0.025, -0.03, 0.03, h - 0.004, h + 0.03)]
    grip = rods([(0, 0.02, h + 0.015)], [(0.03, 0.24, h - 0.07)], 0.008)
    thing.add(joined([boards(head, 0.004), grip]), BLACK)
    z = h + 0.075
    body = [(-0.07, 0.07, -0.025, 0.03, z - 0.045, z + 0.04),
        (-0.03, 0.03, -0.03, 0.035, z + 0.03, z + 0.062), (-0.075, -0.045, -0.045, 0.025, z - 0.043,
        z + 0.035)]  # fmt: skip
    thing.add(boards(body, 0.006), Material((0.025, 0.025, 0.025), (0.04, 0.04, 0.04), "noise",
        0.003, 0.05))  # fmt: skip
    long = between(rng, 0.05, 0.14)
    lens = turned([(0, 0), (0.034, 0), (0.036, 0.3 * long), (0.032, 0.32 * long),
        (0.037, 0.6 * long), (0.038, long), (0.034, long), (0.032, 0.85 * long), (0, 0.85 * long)],
        24, 24)  # fmt: skip
    thing.add(shifted(laid(lens, 1), 0, -0.024, z), BLACK)
    front = shifted(
        laid(revolve([(0.03, 0), (0.02, 0.005), (0, 0.007)], 20), 1), 0, -0.025 - 0.85 * long, z
    )
    thing.add(front, Material((0.02, 0.015, 0.04), specular=0.4, gloss=900.0))
    return stood(thing)


CATALOGUE: dict[str, Maker] = {
    "loudspeaker": loudspeaker,
    "radio": radio,
    "alarm_clock": alarm_clock,
    "telephone": telephone,
    "printer": printer,
    "camera_on_tripod": camera_on_tripod,
    **screens.CATALOGUE,
    **kitchen_devices.CATALOGUE,
}
