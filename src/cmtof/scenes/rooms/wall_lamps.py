"""Lamps on walls: sconces, strings of bulbs, neon and strips under shelves."""

import numpy as np

from cmtof.scenes.rooms.materials import Material, Style, hue
from cmtof.scenes.rooms.pliant import Points, against_wall, four_sided, slab, spline
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
)
from cmtof.scenes.rooms.solids import ball, box, cylinder, joined, revolve, rod, tube
from cmtof.scenes.rooms.thing import Light, Mesh, Thing


def _half_shell(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """Half a bowl or half a drum of plaster or cloth, open above and, as a drum, below."""
    r, h = float(rng.uniform(0.1, 0.16)), float(rng.uniform(0.16, 0.26))
    bowl = rng.uniform() < 0.5
    at = np.linspace(0, 1, 8)
    girth = r * np.sqrt(at * (2 - at)) + 0.004 if bowl else np.full(8, r)
    angle = np.linspace(np.pi, 2 * np.pi, 17)
    points = np.empty((17, 8, 3))
    points[..., 0] = girth * np.cos(angle)[:, None]
    points[..., 1] = 0.75 * girth * np.sin(angle)[:, None]
    points[..., 2] = h * (at - 0.5)
    skin = Material((0.8, 0.79, 0.76), emission=0.25) if bowl else cloth(rng)
    thing.add(slab(points, 0.003), skin)
    thing.add(box((0.06, 0.012, 0.08), (0, -0.006, 0), bevel=0.003), style.metal)
    bulb(thing, 0, -0.35 * r, 0.1 * h, 0.02)
    shine(thing, (0, -0.4 * r, 0.4 * h), power(rng, 0.25, 0.5), half=0.25 * r)


def _arm(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """One or two curved arms with small cloth shades or globes."""
    metal = BRASS if rng.uniform() < 0.5 else style.metal
    thing.add(against_wall(cylinder(0.045, 0.016, (0, 0, 0.008), sides=24)), metal)
    sides = (0.0,) if rng.uniform() < 0.6 else (-1.0, 1.0)
    globes = rng.uniform() < 0.4
    for side in sides:
        x = 0.13 * side
        path = spline(
            [(0, -0.01, 0), (0.5 * x, -0.07, -0.04), (x, -0.13, -0.03), (x, -0.14, 0.03)], 14
        )
        thing.add(tube(path, 0.006), metal)
        if globes:
            thing.add(ball(0.07, (x, -0.14, 0.1)), Material((0.88, 0.86, 0.8), emission=1.6))
            glow_around(thing, (x, -0.14, 0.1), 0.07, power(rng, 0.15, 0.3))
            continue
        bulb(thing, x, -0.14, 0.1, 0.02)
        shade(thing, [(0.085, 0.05), (0.07, 0.11), (0.055, 0.17)], cloth(rng), centre=(x, -0.14, 0))
        shine(thing, (x, -0.14, 0.1), power(rng, 0.2, 0.4), half=0.036)


def _up_and_down(rng: np.random.Generator, style: Style, thing: Thing) -> None:
    """A box or a cylinder, open at both ends, that washes the wall."""
    w, h = float(rng.uniform(0.07, 0.11)), float(rng.uniform(0.14, 0.24))
    skin = (style.metal, BLACK, LINING)[int(rng.integers(3))]
    square = rng.uniform() < 0.5
    radius = w / 2
    profile = [(radius, -h / 2), (radius, h / 2), (radius, h / 2), (radius - 0.004, h / 2),
               (radius - 0.004, h / 2), (radius - 0.004, -h / 2), (radius - 0.004, -h / 2),
               (radius, -h / 2)]  # fmt: skip
    outer = four_sided(profile) if square else revolve(profile, 28)
    centre = np.array([0, -w / 2 - 0.03, 0], np.float32)
    thing.add(Mesh(outer.vertices + centre, outer.faces), skin)
    thing.add(box((0.03, 0.04, 0.06), (0, -0.02, 0)), skin)
    for side in (-1, 1):
        lens = cylinder(
            w / 2 - 0.006, 0.004, centre + np.array([0, 0, side * (h / 2 - 0.02)]), sides=20
        )
        thing.add(lens, GLOW)
        at = (0.0, float(centre[1]), side * (h / 2 - 0.012))
        thing.lights.append(
            Light(at, (w / 3, 0, 0), (0, w / 3, 0), power(rng, 0.2, 0.4), (0.0, 0.0, side), WARM)
        )


def wall_sconce(rng: np.random.Generator, style: Style) -> Thing:
    """A lamp on the wall: half a bowl or drum, arms with shades or globes, a box up and down."""
    thing = Thing("wall_sconce")
    (_half_shell, _arm, _up_and_down)[int(rng.integers(3))](rng, style, thing)
    return thing


def string_lights(rng: np.random.Generator, style: Style) -> Thing:
    """Bulbs on a wire that sags between nails, or falls from them in lines."""
    thing = Thing("string_lights")
    width, bows = float(rng.uniform(1.2, 2.2)), int(rng.integers(2, 5))
    sag = float(rng.uniform(0.08, 0.2))
    x = np.linspace(-width / 2, width / 2, 16 * bows + 1)
    phase = (x / width + 0.5) * bows
    z = sag * (4 * (phase % 1 - 0.5) ** 2 - 0.5)
    path = np.stack([x, -0.014 - 0.006 * np.sin(np.pi * (phase % 1)), z], -1)
    thing.add(tube(path, 0.002, 4), BLACK)
    nails = [cylinder(0.004, 0.02, (0, 0, 0.01), sides=8) for _ in range(bows + 1)]
    for k, nail in enumerate(nails):
        at = np.array([width * (k / bows - 0.5), 0, sag / 2 + 0.003], np.float32)
        thing.add(Mesh(against_wall(nail).vertices + at, nail.faces), style.metal)
    every = int(rng.choice([2, 3, 4]))
    size = float(rng.uniform(0.01, 0.022))
    lamps = [ball(size, p - [0, 0.4 * size, 1.5 * size], 1) for p in path[2::every]]
    caps = [cylinder(0.4 * size, 1.2 * size, p - [0, 0.2 * size, 0.4 * size], sides=6) for p in path[2 :: every]]  # fmt: skip  # noqa: E501
    thing.add(joined(lamps), Material((0.92, 0.8, 0.5), emission=4.0))
    thing.add(joined(caps), BLACK)
    y = -0.06 - 2 * size
    thing.lights.append(
        Light((0, y, 0), (width / 2, 0, 0), (0, 0, sag / 2), power(rng, 0.15, 0.4), colour=WARM)
    )
    return thing


_SIGNS = (
    [(0.0, -1.0), (-0.95, 0.1), (-0.75, 0.85), (-0.2, 0.85), (0.0, 0.45), (0.2, 0.85), (0.75, 0.85),
     (0.95, 0.1), (0.0, -1.0)],
    [(0.15, 1.0), (-0.45, 0.0), (0.05, 0.0), (-0.25, -1.0), (0.5, 0.2), (0.0, 0.2), (0.15, 1.0)],
    [(-1.6, 0.5), (-1.3, -0.4), (-1.0, 0.3), (-0.7, -0.4), (-0.35, 0.1), (-0.45, -0.35),
     (-0.05, -0.3), (0.1, 0.9), (0.2, -0.35), (0.55, 0.1), (0.75, -0.35), (1.1, 0.15),
     (0.9, -0.3), (1.6, -0.2)],
    [(0.7, 0.75), (-0.3, 0.95), (-0.95, 0.2), (-0.7, -0.65), (0.1, -0.95), (0.75, -0.6),
     (0.0, -0.45), (-0.4, 0.1), (0.0, 0.6), (0.7, 0.75)],
)  # fmt: skip
"""Heart, lightning, a written word, moon; unit size."""


def _cornered(points: Points) -> Points:
    """A path that bends within 6 % of its pieces about each inner point."""
    steps = np.diff(points, axis=0)
    ends = np.stack([points[:-1] + 0.06 * steps, points[:-1] + 0.94 * steps], axis=1)
    return np.concatenate([points[:1], ends.reshape(-1, 3), points[-1:]])


def neon(rng: np.random.Generator, style: Style) -> Thing:
    """A bent tube of coloured light on a board or on the bare wall."""
    thing = Thing("neon")
    size = float(rng.uniform(0.15, 0.26))
    shape = int(rng.integers(len(_SIGNS)))
    sign = size * np.array(_SIGNS[shape])
    points = np.stack([sign[:, 0], np.full(len(sign), -0.045), sign[:, 1]], -1)
    path = _cornered(points) if shape == 1 else spline(points, 90)
    colour = hue(float(rng.uniform()), float(rng.uniform(0.3, 0.9)), 0.9)
    thing.add(tube(path, 0.006, 8), Material(colour, emission=4.0))
    posts = [rod((*p[:1], -0.004, p[2]), p, 0.003, 6) for p in path[6::22]]
    thing.add(joined(posts), BLACK)
    span = np.abs(sign).max(axis=0) + 0.05
    board = (2 * span[0], 0.006, 2 * span[1])
    back = Material((0.03, 0.03, 0.035), specular=0.12, gloss=150.0)
    thing.add(box(board, (0, -0.004, 0), bevel=0.001), back if rng.uniform() < 0.6 else LINING)
    thing.lights.append(
        Light((0, -0.06, 0), (size, 0, 0), (0, 0, 0.7 * size), power(rng, 0.12, 0.3), colour=colour)
    )
    return thing


def light_strip(rng: np.random.Generator, style: Style) -> Thing:
    """A board on the wall with a strip of light below it."""
    thing = Thing("light_strip")
    length, deep = float(rng.uniform(0.6, 1.3)), float(rng.uniform(0.05, 0.12))
    thing.add(box((length, deep, 0.022), (0, -deep / 2, 0.012), bevel=0.002), style.wood)
    profile = (length - 0.04, 0.022, 0.012)
    thing.add(box(profile, (0, -deep + 0.02, -0.004)), style.metal)
    thing.add(box((length - 0.05, 0.016, 0.003), (0, -deep + 0.02, -0.0105)), GLOW)
    thing.lights.append(
        Light((0, -deep + 0.02, -0.014), (length / 2 - 0.03, 0, 0), (0, 0.006, 0),
              power(rng, 0.2, 0.5), (0.0, 0.0, -1.0))
    )  # fmt: skip
    return thing


CATALOGUE: dict[str, Maker] = {
    "wall_sconce": wall_sconce,
    "string_lights": string_lights,
    "neon": neon,
    "light_strip": light_strip,
}
