"""Lamps that hang from a ceiling or are fixed to it or to a wall."""

from collections.abc import Callable

import numpy as np

from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.pliant import bars, spline
from cmtof.scenes.rooms.shades import (
    BLACK,
    BRASS,
    GLOW,
    LINING,
    WARM,
    Maker,
    bulb,
    cloth,
    glow_around,
    power,
    shade,
    shine,
    spider,
    spot,
)
from cmtof.scenes.rooms.solids import ball, box, cylinder, joined, revolve, rod, tube
from cmtof.scenes.rooms.thing import Light, Thing

OPAL = Material((0.88, 0.86, 0.8), specular=0.06, gloss=120.0, emission=1.5)
"""White glass, lit from within."""

Design = Callable[[np.random.Generator, Style, Thing, float], None]


def _cord(
    thing: Thing, end: float, x: float = 0.0, y: float = 0.0, metal: Material = BLACK
) -> None:
    """A canopy at the ceiling and a cord down to z = ``end``."""
    rose = revolve([(0, -0.03), (0.02, -0.03), (0.055, -0.012), (0.055, 0), (0, 0)], 20)
    thing.add(rose._replace(vertices=rose.vertices + np.array([x, y, 0], np.float32)), metal)
    thing.add(rod((x, y, -0.02), (x, y, end), 0.0035, 6), BLACK)


# --- pendants: each hangs so that its lowest point is at -drop --------------------------------


def _dome(rng: np.random.Generator, style: Style, thing: Thing, drop: float) -> None:
    """Enamel or spun metal: dome, cone, bell or bowl."""
    r = float(rng.uniform(0.14, 0.26))
    rise = np.linspace(0, 1, 10)
    forms = (
        np.column_stack([np.cos(0.46 * np.pi * rise), 0.75 * np.sin(0.47 * np.pi * rise)]),
        np.column_stack([1 - 0.86 * rise, 0.65 * rise]),
        np.column_stack([0.16 + 0.84 * (1 - rise) ** 2.2, 0.9 * rise]),
        np.column_stack([0.3 + 0.7 * (1 - rise**3), 0.55 * rise]),
    )
    profile = r * forms[int(rng.integers(len(forms)))]
    height = profile[-1, 1]
    skin = (style.metal, style.accent, BLACK, LINING)[int(rng.integers(4))]
    shade(thing, profile + np.array([0, -drop]), skin, LINING if rng.uniform() < 0.8 else BRASS)
    neck = -drop + height
    thing.add(cylinder(profile[-1, 0] + 0.012, 0.03, (0, 0, neck), top=0.02), style.metal)
    bulb(thing, 0, 0, -drop + 0.55 * height, 0.032, up=-1)
    shine(thing, (0, 0, -drop + 0.3 * height), power(rng, 0.5, 1.3))
    _cord(thing, neck)


def _globe(rng: np.random.Generator, style: Style, thing: Thing, drop: float) -> None:
    """An opal ball below a brass cap."""
    r = float(rng.uniform(0.1, 0.2))
    thing.add(ball(r, (0, 0, r - drop)), OPAL)
    thing.add(cylinder(0.3 * r, 0.04, (0, 0, 2 * r - drop + 0.008), top=0.16 * r), style.metal)
    _cord(thing, 2 * r - drop)
    glow_around(thing, (0, 0, r - drop), r, power(rng, 0.5, 1.0))


def _drum(rng: np.random.Generator, style: Style, thing: Thing, drop: float) -> None:
    """A wide cloth drum, open above and below, around one to three bulbs."""
    r = float(rng.uniform(0.18, 0.3))
    h = r * float(rng.uniform(0.6, 1.1))
    profile = np.column_stack(
        [np.linspace(r, r * float(rng.uniform(0.85, 1)), 4), np.linspace(0, h, 4)]
    )
    shade(thing, profile + np.array([0, -drop]), cloth(rng), sides=40)
    spider(thing, 0.97 * profile[-1, 0], 0.92 * h - drop, style.metal, 0.0)
    count = int(rng.integers(1, 4))
    for k in range(count):
        a, d = 2 * np.pi * k / count, 0.0 if count == 1 else 0.3 * r
        bulb(thing, d * np.cos(a), d * np.sin(a), 0.5 * h - drop, 0.03, up=-1)
    shine(thing, (0, 0, 0.42 * h - drop), power(rng, 0.6, 1.4), half=0.4 * r)
    _cord(thing, 0.9 * h - drop)


def _paper_ball(rng: np.random.Generator, style: Style, thing: Thing, drop: float) -> None:
    """A ribbed balloon of rice paper over wire, flat or tall."""
    r, squash = float(rng.uniform(0.17, 0.28)), float(rng.choice([0.7, 0.9, 1.15]))
    angle = np.linspace(-0.42, 0.42, 45) * np.pi
    ribs = 1 + 0.012 * np.cos(np.pi * np.arange(45))
    profile = np.column_stack([r * ribs * np.cos(angle), squash * r * (1 + np.sin(angle)) - drop])
    profile[:, 1] -= profile[0, 1] + drop
    shade(thing, profile, cloth(rng), sides=28, thickness=0.001)
    middle = profile[22, 1]
    bulb(thing, 0, 0, middle, 0.03, up=-1)
    spider(thing, profile[-1, 0], profile[-1, 1], style.metal, 0.0)
    glow_around(thing, (0, 0, middle), r, power(rng, 0.5, 1.2))
    _cord(thing, middle + 0.06)


def _cluster(rng: np.random.Generator, style: Style, thing: Thing, drop: float) -> None:
    """Bare bulbs on cords of their own, or small shades, from one plate."""
    count = int(rng.integers(3, 6))
    plate = float(rng.uniform(0.14, 0.22))
    thing.add(cylinder(plate, 0.025, (0, 0, -0.0125), sides=36), style.metal)
    small = rng.uniform() < 0.5
    for k in range(count):
        a = 2 * np.pi * k / count
        x, y = 0.75 * plate * np.cos(a), 0.75 * plate * np.sin(a)
        end = -drop * (1.0 if k == 0 else float(rng.uniform(0.55, 0.95)))
        thing.add(rod((x, y, -0.02), (x, y, end + 0.1), 0.003, 6), BLACK)
        if small:
            cone = np.array([(0.06, 0), (0.045, 0.05), (0.018, 0.1)])
            shade(thing, cone, style.metal, centre=(x, y, end), sides=20)
            thing.add(ball(0.022, (x, y, end + 0.03), 2), GLOW)
        else:
            bulb(thing, x, y, end + 0.045, 0.045, up=-1)
    shine(thing, (0, 0, -0.75 * drop), power(rng, 0.5, 1.2), half=0.06)


def _basket(rng: np.random.Generator, style: Style, thing: Thing, drop: float) -> None:
    """Rattan: upright canes and hoops, through which the bulb is seen."""
    r, h = float(rng.uniform(0.17, 0.27)), float(rng.uniform(0.2, 0.34))
    at = np.linspace(0, 1, 7)
    girth = r * (0.55 + 0.45 * np.sin(np.pi * (0.15 + 0.7 * at))) * np.linspace(1, 0.55, 7)
    z = at * h - drop + 0.004
    angle = np.arange(26) * (2 * np.pi / 26)
    ring = np.stack([np.cos(angle), np.sin(angle)], -1)
    points = np.concatenate(
        [girth[:, None, None] * ring, np.broadcast_to(z[:, None, None], (7, 26, 1))], -1
    )
    canes = bars(points[:-1].reshape(-1, 3), points[1:].reshape(-1, 3), 0.003)
    hoops = bars(points.reshape(-1, 3), np.roll(points, -1, 1).reshape(-1, 3), 0.004)
    cane = Material((0.5, 0.34, 0.17), (0.36, 0.22, 0.1), "noise", 0.02, 0.04, 30.0)
    thing.add(joined([canes, hoops]), style.wood if rng.uniform() < 0.4 else cane)
    bulb(thing, 0, 0, 0.5 * h - drop, 0.04, up=-1)
    spider(thing, girth[-1], h - drop, BLACK, 0.0)
    shine(thing, (0, 0, 0.45 * h - drop), power(rng, 0.6, 1.2), half=0.06)
    _cord(thing, 0.7 * h - drop)


def _plates(rng: np.random.Generator, style: Style, thing: Thing, drop: float) -> None:
    """Tiers of curved plates that hide the bulb, after Poul Henningsen (1926)."""
    r = float(rng.uniform(0.18, 0.26))
    skin = style.accent if rng.uniform() < 0.4 else Material((0.8, 0.8, 0.78), emission=0.35)
    tiers = ((0.3, 0.5, 0.0, 0.16), (0.35, 0.72, 0.16, 0.36), (0.22, 1.0, 0.3, 0.62))
    for inner, outer, low, high in tiers:
        at = np.linspace(0, 1, 6)
        profile = r * np.column_stack(
            [outer + (inner - outer) * at, low + (high - low) * np.sin(0.5 * np.pi * at)]
        )
        shade(thing, profile + np.array([0, -drop]), skin, sides=36)
    thing.add(cylinder(0.25 * r, 0.3 * r, (0, 0, 0.75 * r - drop), top=0.08 * r), style.metal)
    angle = np.arange(3) * (2 * np.pi / 3)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    low, high = 0.42 * r * ring + [0, 0, 0.05 * r - drop], 0.2 * r * ring + [0, 0, 0.66 * r - drop]
    thing.add(bars(low, high, 0.003), style.metal)
    thing.add(ball(0.16 * r, (0, 0, 0.3 * r - drop), 2), GLOW)
    shine(thing, (0, 0, 0.1 * r - drop), power(rng, 0.6, 1.3), half=0.2 * r)
    _cord(thing, 0.85 * r - drop)


def _beam(rng: np.random.Generator, style: Style, thing: Thing, drop: float) -> None:
    """A long bar on two wires, with a strip of light below."""
    length = float(rng.uniform(0.9, 1.4))
    z = 0.02 - drop
    body = style.wood if rng.uniform() < 0.5 else style.metal
    thing.add(box((length, 0.06, 0.036), (0, 0, z), bevel=0.004), body)
    thing.add(box((length - 0.04, 0.044, 0.006), (0, 0, z - 0.017)), GLOW)
    ends = np.array([(-0.4 * length, 0, z + 0.01), (0.4 * length, 0, z + 0.01)])
    thing.add(bars(ends * [0.3, 1, 0] + [0, 0, -0.01], ends, 0.0012), BLACK)
    thing.add(box((0.34 * length, 0.06, 0.025), (0, 0, -0.0125), bevel=0.004), style.metal)
    thing.lights.append(
        Light((0, 0, z - 0.023), (length / 2 - 0.03, 0, 0), (0, 0.02, 0), power(rng, 0.8, 1.5),
              (0.0, 0.0, -1.0), WARM)
    )  # fmt: skip


PENDANTS: tuple[Design, ...] = (
    _dome, _dome, _globe, _drum, _paper_ball, _cluster, _basket, _plates, _beam,
)  # fmt: skip


def pendant(rng: np.random.Generator, style: Style, *, drop: float | None = None) -> Thing:
    """A lamp on a cord: dome, globe, drum, paper, cluster, basket, plates or beam.

    Parameters
    ----------
    drop : float, optional
        From the ceiling to the lowest edge, m; at least 0.45.
    """
    drawn = float(rng.uniform(0.5, 0.85))
    thing = Thing("pendant")
    design = PENDANTS[int(rng.integers(len(PENDANTS)))]
    design(rng, style, thing, max(drawn if drop is None else float(drop), 0.45))
    return thing


# --- chandeliers ------------------------------------------------------------------------------


def _branched(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """Curved arms with candles around a turned stem, hung on a chain."""
    count, r = int(rng.integers(5, 9)), float(rng.uniform(0.24, 0.38))
    z, metal = -float(rng.uniform(0.62, 0.8)), BRASS if rng.uniform() < 0.6 else style.metal
    girth = np.array([0, 6, 18, 30, 14, 10, 24, 12, 8, 8, 0]) * 1e-3
    heights = np.array([-0.1, -0.1, -0.07, -0.03, 0.0, 0.06, 0.1, 0.15, 0.2, 0.26, 0.26]) + z
    thing.add(revolve(np.column_stack([girth, heights]), 20), metal)
    arm = spline([(0.01, 0, 0.02), (0.35 * r, 0, -0.06), (0.75 * r, 0, -0.07), (r, 0, 0.02)], 12)
    candle = Material((0.85, 0.82, 0.72), specular=0.05)
    for k in range(count):
        a = 2 * np.pi * k / count
        c, s = np.cos(a), np.sin(a)
        path = np.stack([c * arm[:, 0], s * arm[:, 0], arm[:, 2] + z], -1)
        thing.add(tube(path, 0.006, 6), metal)
        x, y, top = path[-1]
        pan = revolve([(0, 0), (0.012, 0), (0.032, 0.014), (0, 0.01)], 12)
        thing.add(pan._replace(vertices=pan.vertices + path[-1].astype(np.float32)), metal)
        thing.add(cylinder(0.011, 0.08, (x, y, top + 0.05), sides=10), candle)
        flame = revolve([(0.006, 0), (0.014, 0.018), (0.011, 0.035), (0, 0.06)], 8)
        at = np.array([x, y, top + 0.09], np.float32)
        thing.add(flame._replace(vertices=flame.vertices + at), GLOW)
    shine(thing, (0, 0, z + 0.13), power(rng, 1.0, 2.0), half=0.7 * r)
    _cord(thing, z + 0.25, metal=metal)


def _wheel(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """A level ring on three rods, with globes or a strip of light."""
    r, z = float(rng.uniform(0.28, 0.42)), -float(rng.uniform(0.6, 0.85))
    loop = [
        (r - 0.012, z),
        (r + 0.012, z),
        (r + 0.012, z),
        (r + 0.012, z + 0.04),
        (r + 0.012, z + 0.04),
        (r - 0.012, z + 0.04),
        (r - 0.012, z + 0.04),
        (r - 0.012, z),
    ]
    thing.add(revolve(loop, 48), style.metal if rng.uniform() < 0.6 else style.wood)
    angle = np.arange(3) * (2 * np.pi / 3)
    rim = np.stack([r * np.cos(angle), r * np.sin(angle), np.full(3, z + 0.035)], -1)
    thing.add(bars(np.tile([0, 0, 0.5 * z], (3, 1)), rim, 0.003), BLACK)
    _cord(thing, 0.5 * z, metal=style.metal)
    count = int(rng.integers(6, 11))
    for k in range(count):
        a = 2 * np.pi * k / count
        thing.add(ball(0.035, (r * np.cos(a), r * np.sin(a), z - 0.03), 2), GLOW)
    shine(thing, (0, 0, z - 0.03), power(rng, 1.0, 2.0), half=0.75 * r)


def _sputnik(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """Rods in all directions from a ball, a globe at each end."""
    count, r, z = (
        int(rng.integers(10, 17)),
        float(rng.uniform(0.28, 0.4)),
        -float(rng.uniform(0.6, 0.8)),
    )
    k = np.arange(count) + 0.5
    polar, angle = np.arccos(1 - 2 * k / count), np.pi * (1 + 5**0.5) * k
    out = np.stack(
        [np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle), np.cos(polar)], -1
    )
    ends = r * out + [0, 0, z]
    thing.add(bars(np.tile([0, 0, z], (count, 1)), ends, 0.004, 6), BRASS)
    thing.add(ball(0.06, (0, 0, z), 2), BRASS)
    thing.add(joined([ball(0.04, end, 2) for end in ends]), OPAL)
    shine(thing, (0, 0, z), power(rng, 1.0, 1.8), half=0.8 * r)
    _cord(thing, z, metal=BRASS)


def chandelier(rng: np.random.Generator, style: Style) -> Thing:
    """Candle arms, a ring of globes, or rods in all directions."""
    thing = Thing("chandelier")
    (_branched, _branched, _wheel, _sputnik)[int(rng.integers(4))](rng, style, thing)
    return thing


# --- close to the ceiling ---------------------------------------------------------------------


def _opal_dish(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    r = float(rng.uniform(0.14, 0.24))
    h = r * float(rng.uniform(0.35, 0.6))
    angle = np.linspace(0, 0.5 * np.pi, 9)
    dish = np.column_stack([r * np.sin(angle), -0.03 - h * np.cos(angle)])
    thing.add(revolve(np.concatenate([dish, [(0.9 * r, -0.02)]]), 36), OPAL)
    thing.add(cylinder(1.04 * r, 0.03, (0, 0, -0.015), sides=40), style.metal)
    if rng.uniform() < 0.5:
        thing.add(ball(0.014, (0, 0, -0.034 - h), 2), style.metal)
    shine(thing, (0, 0, -0.06 - h), power(rng, 0.8, 1.6), half=0.5 * r)


def _panel(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    w = float(rng.choice([0.3, 0.4, 0.6]))
    d = w if rng.uniform() < 0.6 else 1.2
    frame = Material((0.8, 0.8, 0.8), specular=0.1, gloss=60.0)
    thing.add(box((d, w, 0.04), (0, 0, -0.02), bevel=0.004), frame)
    thing.add(box((d - 0.03, w - 0.03, 0.006), (0, 0, -0.04)),
              Material((0.95, 0.95, 0.95), emission=float(rng.uniform(2.0, 4.0))))  # fmt: skip
    half_u, half_v = (d / 2 - 0.02, 0.0, 0.0), (0.0, w / 2 - 0.02, 0.0)
    thing.lights.append(
        Light((0.0, 0.0, -0.046), half_u, half_v, power(rng, 1.0, 3.0), (0.0, 0.0, -1.0))
    )


def _cloth_drum(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    r, h = float(rng.uniform(0.18, 0.26)), float(rng.uniform(0.12, 0.18))
    shade(thing, [(r, -h), (r, -0.06), (r, -0.03)], cloth(rng), sides=40)
    thing.add(cylinder(r - 0.006, 0.003, (0, 0, 0.012 - h), sides=40), OPAL)
    thing.add(cylinder(0.07, 0.05, (0, 0, -0.025), sides=28), style.metal)
    spider(thing, r - 0.003, -0.04, style.metal, 0.0)
    shine(thing, (0, 0, -0.02 - h), power(rng, 0.8, 1.5), half=0.5 * r)


def _three_spots(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    thing.add(cylinder(0.14, 0.025, (0, 0, -0.0125), sides=36), style.metal)
    for k in range(3):
        a = 2 * np.pi * k / 3 + float(rng.normal(0, 0.3))
        neck = np.array([0.08 * np.cos(a), 0.08 * np.sin(a), -0.07])
        thing.add(rod(neck * [1, 1, 0] + [0, 0, -0.02], neck, 0.007), style.metal)
        aim = (0.6 * np.cos(a), 0.6 * np.sin(a), -1.0)
        spot(thing, neck, aim, 0.045, 0.11, style.metal, power(rng, 0.3, 0.6))


def _batten(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """A fluorescent tube, bare or behind louvres."""
    length = float(rng.choice([0.6, 1.2, 1.5]))
    thing.add(box((length, 0.06, 0.05), (0, 0, -0.025), bevel=0.004), LINING)
    tubes = (-0.06, 0.06) if rng.uniform() < 0.5 else (0.0,)
    for y in tubes:
        thing.add(
            rod((-length / 2 + 0.03, y, -0.08), (length / 2 - 0.03, y, -0.08), 0.013, 12), GLOW
        )
        for x in (-length / 2 + 0.015, length / 2 - 0.015):
            thing.add(box((0.03, 0.03, 0.06), (x, y, -0.068), bevel=0.003), LINING)
    if len(tubes) == 2:
        thing.add(box((length, 0.18, 0.006), (0, 0, -0.05)), LINING)
    thing.lights.append(
        Light((0, 0, -0.1), (length / 2 - 0.03, 0, 0), (0, 0.02, 0), power(rng, 1.0, 2.5))
    )


def ceiling_lamp(rng: np.random.Generator, style: Style) -> Thing:
    """A lamp close to the ceiling: opal dish, panel, cloth drum, three spots, fluorescent tube."""
    designs = (_opal_dish, _opal_dish, _panel, _cloth_drum, _three_spots, _batten)
    thing = Thing("ceiling_lamp")
    designs[int(rng.integers(len(designs)))](rng, style, thing)
    return thing


def track_spots(rng: np.random.Generator, style: Style) -> Thing:
    """Three or four heads on a rail, each turned its own way."""
    thing = Thing("track_spots")
    count, length = int(rng.integers(3, 5)), float(rng.uniform(0.9, 1.5))
    skin = style.metal if rng.uniform() < 0.5 else BLACK
    thing.add(box((length, 0.036, 0.022), (0, 0, -0.011), bevel=0.003), skin)
    for x in np.linspace(-0.42, 0.42, count) * length:
        aim = np.array([float(rng.normal(0, 0.5)), float(rng.normal(0, 0.6)), -1.0])
        thing.add(rod((x, 0, -0.02), (x, 0, -0.09), 0.007), skin)
        spot(thing, (x, 0, -0.085), aim, 0.045, 0.13, skin, power(rng, 0.35, 0.7))
    return thing


CATALOGUE: dict[str, Maker] = {
    "pendant": pendant,
    "chandelier": chandelier,
    "ceiling_lamp": ceiling_lamp,
    "track_spots": track_spots,
}
