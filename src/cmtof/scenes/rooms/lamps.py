"""Lamps that stand: on the floor, on a table, on a desk."""

import numpy as np

from cmtof.scenes.rooms.materials import Material, Style, ceramic
from cmtof.scenes.rooms.pliant import bars, centred, four_sided, slab, spline, unit
from cmtof.scenes.rooms.shades import (
    BLACK,
    BRASS,
    GLOW,
    LINING,
    Maker,
    bulb,
    cloth,
    drum,
    glow_around,
    power,
    shade,
    shine,
    spot,
)
from cmtof.scenes.rooms.solids import ball, box, cylinder, joined, revolve, rod, tube
from cmtof.scenes.rooms.thing import Light, Mesh, Thing

# --- on the floor -----------------------------------------------------------------------------


def _foot(rng: np.random.Generator, radius: float) -> Mesh:
    """A turned, weighted foot, 2 to 4 cm high."""
    r, h = radius, float(rng.uniform(0.015, 0.035))
    return revolve(
        [(0, 0), (r, 0), (r, 0), (r, 0.6 * h), (0.95 * r, h), (0.95 * r, h), (0.15 * r, 1.2 * h),
         (0.012, 1.6 * h), (0.012, 2.2 * h), (0, 2.2 * h)], 36
    )  # fmt: skip


def _pole_lamp(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    height = float(rng.uniform(1.2, 1.42))
    thing.add(_foot(rng, float(rng.uniform(0.12, 0.16))), style.metal)
    if style.modern < 0.5:  # turned from wood
        at = np.array([0, 0.1, 0.12, 0.14, 0.45, 0.5, 0.55, 0.9, 0.93, 1.0])
        girth = np.array([16, 12, 20, 12, 16, 22, 16, 11, 18, 10]) * 1e-3
        thing.add(revolve(np.column_stack([girth, 0.02 + at * (height - 0.05)]), 16), style.wood, 2)
    thing.add(rod((0, 0, 0.03), (0, 0, height), 0.008, 12), style.metal)
    drum(rng, thing, height, float(rng.uniform(0.18, 0.26)), power(rng, 0.4, 0.9), style.metal)


def _arc_lamp(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    reach, top = float(rng.uniform(0.8, 1.15)), float(rng.uniform(1.75, 2.0))
    x0 = -reach / 2
    marble = Material((0.82, 0.81, 0.79), (0.45, 0.45, 0.46), "marble", 0.2, 0.1, 100.0)
    block = box((0.24, 0.3, 0.14), (x0, 0, 0.07), bevel=0.006)
    thing.add(block if rng.uniform() < 0.6 else cylinder(0.17, 0.06, (x0, 0, 0.03), sides=36),
              marble if rng.uniform() < 0.6 else BLACK)  # fmt: skip
    path = spline(
        [(x0, 0, 0.05), (x0, 0, 0.6 * top), (x0 + 0.2 * reach, 0, 0.9 * top),
         (x0 + 0.55 * reach, 0, top), (x0 + 0.88 * reach, 0, 0.94 * top),
         (x0 + reach, 0, 0.84 * top)], 32
    )  # fmt: skip
    thing.add(tube(path, np.linspace(0.014, 0.008, 32), 10), style.metal)
    r, z = float(rng.uniform(0.14, 0.19)), 0.84 * top
    angle = np.linspace(0, 0.46 * np.pi, 8)
    dome = np.column_stack([r * np.cos(angle), z - r + r * np.sin(angle)])
    shade(thing, dome, style.metal, centre=(x0 + reach, 0, 0))
    bulb(thing, x0 + reach, 0, z - 0.6 * r, 0.035, up=-1)
    shine(thing, (x0 + reach, 0, z - 0.75 * r), power(rng, 0.4, 0.9))


def _tripod_lamp(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    height, spread = float(rng.uniform(1.0, 1.2)), float(rng.uniform(0.24, 0.32))
    turn = float(rng.uniform(0, 2 * np.pi))
    for k in range(3):
        a = turn + 2 * np.pi * k / 3
        c, s = np.cos(a), np.sin(a)
        knee = np.array([[spread * c, spread * s, 0.004], [0.035 * c, 0.035 * s, height]])
        thing.add(tube(knee, [0.010, 0.016], 10), style.wood, 2)
        brace = [
            (0.5 * (spread + 0.035) * c, 0.5 * (spread + 0.035) * s, height / 2),
            (0, 0, height / 2),
        ]
        thing.add(rod(brace[0], brace[1], 0.004, 6), style.metal)
    thing.add(cylinder(0.055, 0.04, (0, 0, height), sides=24), style.metal)
    thing.add(rod((0, 0, height), (0, 0, height + 0.14), 0.008), style.metal)
    drum(rng, thing, height + 0.1, float(rng.uniform(0.2, 0.28)), power(rng, 0.4, 0.9), style.metal)


def _torchiere(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    height, r = float(rng.uniform(1.65, 1.85)), float(rng.uniform(0.13, 0.2))
    thing.add(_foot(rng, 0.14), style.metal)
    thing.add(rod((0, 0, 0.03), (0, 0, height - 0.05), 0.012, 14), style.metal)
    angle = np.linspace(0.1, 0.48 * np.pi, 8)
    bowl = np.column_stack([r * np.sin(angle), height - 0.7 * r * np.cos(angle)])
    opal = Material((0.85, 0.83, 0.78), specular=0.08, gloss=80.0, emission=1.0)
    shade(thing, bowl, style.metal if rng.uniform() < 0.5 else opal, centre=(0, 0, 0))
    bulb(thing, 0, 0, height - 0.3 * r, 0.022)
    shine(thing, (0, 0, height + 0.01), power(rng, 0.5, 0.9))
    if rng.uniform() < 0.5:  # mother and child: a reading arm half-way up
        z = 0.72 * height
        arm = spline([(0, 0, z), (0.08, -0.06, z + 0.02), (0.2, -0.14, z - 0.04)], 10)
        thing.add(tube(arm, 0.006), style.metal)
        spot(thing, arm[-1], (0.35, -0.3, -1.0), 0.05, 0.1, style.metal, power(rng, 0.15, 0.3))


def _lantern(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """A paper column on short legs, or a stack of paper balloons."""
    height, r = float(rng.uniform(1.1, 1.5)), float(rng.uniform(0.13, 0.19))
    paper = cloth(rng)
    n = 48
    at = np.linspace(0, 1, n)
    ribs = 0.004 * np.cos(np.pi * np.arange(n))
    swell = r * (1 + 0.25 * np.sin(2 * np.pi * float(rng.integers(1, 3)) * at)) + ribs
    profile = np.column_stack([swell, 0.06 + height * at])
    shade(thing, profile, paper, LINING, sides=28 if rng.uniform() < 0.7 else 4)
    angle = np.arange(3) * (2 * np.pi / 3)
    feet = 0.8 * swell[0] * np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    thing.add(bars(feet, feet * [0.9, 0.9, 1] + [0, 0, 0.1], 0.005, 6), BLACK)
    glow_around(thing, (0, 0, 0.06 + 0.5 * height), 1.25 * r, power(rng, 0.4, 0.7))


def _reading_lamp(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """A pole with an arm and a small head over the shoulder."""
    height, reach = float(rng.uniform(1.15, 1.35)), float(rng.uniform(0.25, 0.4))
    x0 = -0.4 * reach
    foot = _foot(rng, 0.13)
    thing.add(Mesh(foot.vertices + np.array([x0, 0, 0], np.float32), foot.faces), style.metal)
    thing.add(rod((x0, 0, 0.03), (x0, 0, height + 0.08), 0.008, 12), style.metal)
    thing.add(box((0.03, 0.03, 0.05), (x0, 0, height), bevel=0.004), style.metal)
    thing.add(rod((x0 - 0.08, 0, height), (x0 + reach, 0, height + 0.02), 0.006, 8), style.metal)
    head = style.metal if rng.uniform() < 0.5 else style.accent
    spot(thing, (x0 + reach, 0, height + 0.015), (0.25, -0.2, -1.0), 0.075, 0.13, head,
               power(rng, 0.25, 0.4))  # fmt: skip


def floor_lamp(rng: np.random.Generator, style: Style) -> Thing:
    """A lamp on the floor: shade on a pole, arc, tripod, torchiere, paper column, reading lamp."""
    designs = (_pole_lamp, _pole_lamp, _arc_lamp, _tripod_lamp, _torchiere, _lantern, _reading_lamp)
    thing = Thing("floor_lamp")
    designs[int(rng.integers(len(designs)))](rng, style, thing)
    return centred(thing)


# --- on a table -------------------------------------------------------------------------------


def _gourd(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """A glazed body: gourd, jar, bottle or stacked balls, below a cloth shade."""
    h = float(rng.uniform(0.2, 0.32))
    forms = (
        [(0.3, 0), (0.33, 0.03), (0.48, 0.25), (0.42, 0.45), (0.2, 0.6), (0.27, 0.78), (0.12, 1)],
        [(0.26, 0), (0.28, 0.03), (0.3, 0.2), (0.45, 0.6), (0.42, 0.8), (0.15, 0.92), (0.1, 1)],
        [(0.4, 0), (0.42, 0.04), (0.42, 0.45), (0.36, 0.62), (0.12, 0.78), (0.1, 1)],
        [(0.22, 0), (0.24, 0.04), (0.12, 0.1), (0.34, 0.3), (0.12, 0.5), (0.26, 0.66), (0.1, 0.8),
         (0.17, 0.9), (0.08, 1)],
    )  # fmt: skip
    profile = h * np.array(forms[int(rng.integers(len(forms)))])
    fine = spline(np.column_stack([profile, 0 * profile[:, 0]]), 24)[:, :2]
    closed = np.concatenate([[(0, 0), fine[0]], fine, [(0, fine[-1, 1])]])
    thing.add(revolve(closed, 32), ceramic(rng))
    thing.add(rod((0, 0, h - 0.01), (0, 0, h + 0.06), 0.007), style.metal)
    drum(rng, thing, h + 0.03, float(rng.uniform(0.12, 0.18)), power(rng, 0.2, 0.45), style.metal)


def _candlestick(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """A turned stem on a foot."""
    h = float(rng.uniform(0.24, 0.36))
    at = np.array([0, 0, 0.03, 0.05, 0.1, 0.14, 0.2, 0.5, 0.55, 0.6, 0.85, 0.9, 1.0])
    girth = np.array([0, 70, 70, 50, 18, 26, 15, 20, 30, 16, 12, 22, 12]) * 1e-3
    profile = np.column_stack([girth, at * h])
    thing.add(revolve(np.concatenate([profile, [(0, h)]]), 28),
              style.wood if rng.uniform() < 0.5 else style.metal, 2)  # fmt: skip
    drum(rng, thing, h + 0.02, float(rng.uniform(0.11, 0.16)), power(rng, 0.2, 0.4), style.metal)


def _globe_lamp(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """An opal ball on a foot of wood, brass or stone."""
    r = float(rng.uniform(0.08, 0.13))
    opal = Material((0.88, 0.86, 0.8), specular=0.06, gloss=120.0, emission=1.6)
    foot = float(rng.uniform(0.03, 0.12))
    wide = 0.55 * r
    body = [(0, 0), (wide, 0), (wide, 0), (0.8 * wide, foot), (0.62 * wide, foot + 0.02),
            (0, foot + 0.02)]  # fmt: skip
    material = (style.wood, BRASS, BLACK)[int(rng.integers(3))]
    thing.add(revolve(body, 32), material, 2)
    thing.add(ball(r, (0, 0, foot + 0.9 * r + 0.015)), opal)
    glow_around(thing, (0, 0, foot + 0.9 * r + 0.015), r, power(rng, 0.15, 0.35))


def _mushroom(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """A dome on a trumpet foot, of one lacquered or opal material."""
    h, r = float(rng.uniform(0.2, 0.32)), float(rng.uniform(0.12, 0.18))
    skin = style.accent if rng.uniform() < 0.5 else Material((0.85, 0.84, 0.8), emission=0.5)
    at = np.linspace(0, 1, 10)
    stem = np.column_stack([0.3 * r + 0.35 * r * (1 - at) ** 3, h * at])
    stem = np.concatenate([[(0, 0), stem[0]], stem, [stem[-1], (0, h)]])
    thing.add(revolve(stem, 28), skin)
    angle = np.linspace(0, 0.49 * np.pi, 9)
    cap = np.column_stack([r * np.cos(angle), 0.8 * h + 0.75 * r * np.sin(angle)])
    shade(thing, cap, skin)
    bulb(thing, 0, 0, h + 0.035, 0.025)
    shine(thing, (0, 0, 0.8 * h), power(rng, 0.2, 0.35), half=0.6 * r)


def _banker(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """A brass stand below a long green glass shade."""
    thing.add(_foot(rng, 0.09), BRASS)
    thing.add(rod((0, 0.0, 0.03), (0, 0.02, 0.3), 0.008, 12), BRASS)
    glass = Material((0.02, 0.2, 0.07), specular=0.12, gloss=200.0, emission=0.3)
    angle = np.linspace(0.02, 0.98, 10) * np.pi
    x = np.linspace(-1, 1, 9)
    y, z = -0.075 * np.cos(angle), 0.27 + 0.06 * np.sin(angle)
    arch = np.empty((9, 10, 3))
    arch[..., 0] = 0.13 * x[:, None]
    narrow = 1 - 0.25 * np.abs(x[:, None]) ** 4
    arch[..., 1], arch[..., 2] = y * narrow - 0.02, 0.27 + (z - 0.27) * narrow
    thing.add(slab(arch, 0.003), glass)
    thing.add(rod((-0.05, -0.02, 0.3), (0.05, -0.02, 0.3), 0.014, 10), GLOW)
    shine(thing, (0, -0.02, 0.275), power(rng, 0.15, 0.3), half=0.04)


def _cube(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """Paper within a frame of slats."""
    w, h = float(rng.uniform(0.14, 0.2)), float(rng.uniform(0.22, 0.4))
    corner = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * w / 2
    posts = [box((0.014, 0.014, h), (*c, h / 2), bevel=0.002) for c in corner]
    for z in (0.02, 0.5 * h, h - 0.012):
        posts += [box((w, 0.01, 0.01), (0, s * w / 2, z)) for s in (-1, 1)]
        posts += [box((0.01, w, 0.01), (s * w / 2, 0, z)) for s in (-1, 1)]
    thing.add(joined(posts), style.wood, 2)
    paper = cloth(rng)
    thing.add(four_sided([(w / 2 - 0.004, 0.025), (w / 2 - 0.004, h - 0.016)]), paper)
    thing.add(box((w - 0.012, w - 0.012, 0.004), (0, 0, h - 0.014)), paper)
    thing.add(box((w - 0.002, w - 0.002, 0.012), (0, 0, 0.006)), style.wood)
    glow_around(thing, (0, 0, h / 2), 0.75 * w, power(rng, 0.15, 0.3))


def table_lamp(rng: np.random.Generator, style: Style) -> Thing:
    """A lamp for a table: gourd, candlestick, globe, mushroom, banker's lamp or lantern."""
    designs = (_gourd, _gourd, _candlestick, _globe_lamp, _mushroom, _banker, _cube)
    thing = Thing("table_lamp")
    designs[int(rng.integers(len(designs)))](rng, style, thing)
    return thing


# --- on a desk --------------------------------------------------------------------------------


def desk_lamp(rng: np.random.Generator, style: Style) -> Thing:
    """A work lamp whose arm bends: balanced twin arm, bar, or gooseneck."""
    thing = Thing("desk_lamp")
    skin = (style.metal, style.accent, BLACK)[int(rng.integers(3))]
    design = int(rng.integers(4))
    (_balanced, _balanced, _bar_head, _gooseneck)[design](rng, thing, skin)
    return centred(thing)


def _balanced(rng: np.random.Generator, thing: Thing, skin: Material) -> None:
    """Two jointed arms of twin rods with springs, after George Carwardine's patent of 1932."""
    low, high = float(rng.uniform(0.28, 0.36)), float(rng.uniform(0.26, 0.34))
    a, b = float(rng.uniform(1.7, 2.0)), float(rng.uniform(0.25, 0.7))
    x0 = -0.12
    thing.add(cylinder(0.085, 0.022, (x0, 0, 0.011), sides=32), skin)
    thing.add(cylinder(0.012, 0.05, (x0, 0, 0.045)), skin)
    shoulder = np.array([x0, 0, 0.07])
    elbow = shoulder + low * np.array([np.cos(a), 0, np.sin(a)])
    wrist = elbow + high * np.array([np.cos(b), 0, np.sin(b)])
    steel = Material((0.5, 0.5, 0.5), specular=0.6, gloss=60.0)
    for start, end in ((shoulder, elbow), (elbow, wrist)):
        for side in (-0.012, 0.012):
            thing.add(
                rod(start + np.array([0, side, 0]), end + np.array([0, side, 0]), 0.003, 8), steel
            )
        at = np.linspace(0.12, 0.55, 60)[:, None]
        coil = 0.005 * np.stack(
            [0 * at[:, 0], np.cos(1.7 * np.arange(60)), np.sin(1.7 * np.arange(60))], -1
        )
        thing.add(tube(start + at * (end - start) + coil, 0.0012, 3), steel)
    for joint in (shoulder, elbow, wrist):
        thing.add(rod(joint - [0, 0.02, 0], joint + np.array([0, 0.02, 0]), 0.011, 12), skin)
    aim = np.array([float(rng.uniform(0.0, 0.5)), float(rng.uniform(-0.3, 0.1)), -1.0])
    spot(thing, wrist - 0.02 * unit(aim), aim, 0.08, 0.15, skin, power(rng, 0.15, 0.4))


def _bar_head(rng: np.random.Generator, thing: Thing, skin: Material) -> None:
    """A foot, an upright and a flat bar that shines downwards."""
    z, reach = float(rng.uniform(0.36, 0.48)), float(rng.uniform(0.34, 0.45))
    x0 = -0.4 * reach
    thing.add(box((0.16, 0.16, 0.018), (x0, 0, 0.009), bevel=0.006), skin)
    thing.add(box((0.018, 0.03, z), (x0, 0, z / 2 + 0.01), bevel=0.003), skin)
    thing.add(box((reach, 0.04, 0.014), (x0 + reach / 2 - 0.01, 0, z + 0.014), bevel=0.004), skin)
    thing.add(box((0.8 * reach, 0.03, 0.003), (x0 + 0.54 * reach, 0, z + 0.0065)), GLOW)
    thing.lights.append(
        Light((x0 + 0.54 * reach, 0.0, z + 0.003), (0.38 * reach, 0, 0), (0, 0.012, 0),
              power(rng, 0.2, 0.4), (0.0, 0.0, -1.0))
    )  # fmt: skip


def _gooseneck(rng: np.random.Generator, thing: Thing, skin: Material) -> None:
    """A bendable neck with a dome at its end."""
    thing.add(_foot(rng, 0.08), skin)
    r, top = float(rng.uniform(0.1, 0.15)), float(rng.uniform(0.36, 0.46))
    path = spline([(0, 0, 0.03), (-0.02, 0.01, 0.6 * top), (0.2 * r, 0, 0.95 * top),
                   (r, -0.01, top), (1.6 * r, -0.02, 0.9 * top)], 28)  # fmt: skip
    thing.add(tube(path, 0.006 + 0.0007 * (np.arange(28) % 2), 8), skin)
    spot(thing, path[-1], path[-1] - path[-3] + [0, 0, -0.004], 0.075, 0.11, skin,
               power(rng, 0.15, 0.35))  # fmt: skip


CATALOGUE: dict[str, Maker] = {
    "floor_lamp": floor_lamp,
    "table_lamp": table_lamp,
    "desk_lamp": desk_lamp,
}
