"""Screens and what one types on: monitors, televisions, laptops, keyboards, m."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.cabinetry import BLACK, GLOSSY_BLACK
from cmtof.scenes.rooms.joinery import beams, boards, corners, shifted
from cmtof.scenes.rooms.kitchen_devices import casing
from cmtof.scenes.rooms.materials import Material, Style, hue
from cmtof.scenes.rooms.shaping import absorbed, laid, pick, stood, turned
from cmtof.scenes.rooms.solids import cylinder, joined, sheet
from cmtof.scenes.rooms.thing import Mesh, Thing, pose
from cmtof.scenes.rooms.vessels import Maker, between

SILVER = Material((0.5, 0.5, 0.52), specular=0.35, gloss=60.0)


GRILLE = Material((0.03, 0.03, 0.03), (0.006, 0.006, 0.006), "dots", 0.004, specular=0.0)


RUBBER = Material((0.015, 0.015, 0.015), specular=0.02, gloss=10.0)


def picture(rng: np.random.Generator, scale: float) -> Material:
    """What a screen shows: nothing, a film, a page of text, or code on black."""
    kind = int(rng.integers(5))
    if kind < 2:
        return GLOSSY_BLACK
    shine = between(rng, 0.3, 0.9)
    if kind == 2:
        tone = hue(float(rng.uniform()), between(rng, 0.2, 0.7), between(rng, 0.2, 0.8))
        return Material(
            tone, hue(float(rng.uniform()), 0.6, 0.3), "picture", 0.3 * scale, 0.05, 300.0, shine
        )
    ink, ground = (0.02, 0.02, 0.03), (0.8, 0.82, 0.85)
    if kind == 4:
        ink, ground = (0.3, 0.6, 0.35), (0.02, 0.02, 0.025)
    return Material(ground, ink, "marks", 0.018 * scale, 0.05, 300.0, shine)


def _screen(rng: np.random.Generator, w: float, h: float, t: float, rim: float) -> Thing:
    """An upright screen about the origin, its front at y = 0, m."""
    thing = Thing("screen")
    case = casing(rng, dark=0.8)
    thing.add(boards([(-w / 2, w / 2, 0, t, -h / 2, h / 2)], 0.003), case)
    hump = [(-0.28 * w, 0.28 * w, t - 0.002, t + 0.02, -0.35 * h, 0.2 * h)]
    thing.add(boards(hump, 0.008), case)
    face = [(-w / 2 + rim, w / 2 - rim, -0.001, 0.001, -h / 2 + 1.6 * rim, h / 2 - rim)]
    return thing.add(boards(face, 0), picture(rng, w))


def monitor(rng: np.random.Generator, style: Style) -> Thing:
    """A flat screen on a foot: plate, ring or fork; wide or square, or turned upright, m."""
    diagonal = between(rng, 0.48, 0.7)
    ratio = pick(rng, 9 / 16, 9 / 16, 10 / 16, 3 / 4, 9 / 21)
    w = diagonal / np.hypot(1, ratio)
    h = w * ratio
    if rng.uniform() < 0.1:
        w, h = h, w
    z = h / 2 + between(rng, 0.08, 0.15)
    thing = Thing("monitor")
    absorbed(thing, _screen(rng, w, h, 0.02, pick(rng, 0.006, 0.012, 0.018)), pose(0, 0, z))
    stuff = BLACK if rng.uniform() < 0.6 else SILVER
    kind = int(rng.integers(3))
    deep = 0.5 * min(h, 0.36)
    if kind == 0:
        foot = [(-0.12, 0.12, 0.055 - deep / 2, 0.055 + deep / 2, 0, 0.01)]
        neck = beams([(0, 0.075, 0.008)], [(0, 0.045, z)], 0.05, 0.014)
        thing.add(joined([boards(foot, 0.003), neck]), stuff)
    elif kind == 1:
        disc = turned([(0, 0), (0.11, 0), (0.112, 0.006), (0.1, 0.009), (0, 0.01)], 32, 10)
        neck = beams([(0, 0.0, 0.008)], [(0, 0, z)], 0.045, 0.02)
        thing.add(shifted(joined([disc, neck]), 0, 0.052, 0), stuff)
    else:
        ends = [(s * 0.16, 0.06 - deep / 2, 0.007) for s in (-1, 1)]
        fork = beams([(0, 0.07, 0.007)] * 2, ends, 0.014, 0.03)
        thing.add(joined([fork, beams([(0, 0.065, 0.0)], [(0, 0.045, z)], 0.04, 0.014)]), stuff)
    return stood(thing)


def television(rng: np.random.Generator, style: Style, *, width: float | None = None) -> Thing:
    """A flat television on two feet or a plate, now and then an old tube set, m."""
    w = pick(rng, 0.72, 0.9, 0.97, 1.11, 1.23) if width is None else width
    thing = Thing("television")
    if width is None and rng.uniform() < 0.12:
        return _tube_set(rng, thing, style)
    h = w * 9 / 16 + 0.02
    rise = between(rng, 0.045, 0.09)
    absorbed(
        thing, _screen(rng, w, h, 0.028, pick(rng, 0.006, 0.012, 0.025)), pose(0, 0, rise + h / 2)
    )
    stuff = BLACK if rng.uniform() < 0.7 else SILVER
    if rng.uniform() < 0.6:
        x = w * between(rng, 0.25, 0.42)
        starts = [(s * x, y, 0.006) for s in (-1, 1) for y in (-0.11, 0.14)]
        tops = [(s * x, 0.014, rise + 0.01) for s in (-1, 1) for _ in range(2)]
        thing.add(beams(starts, tops, 0.022, 0.012), stuff)
    else:
        disc = boards([(-0.2 * w, 0.2 * w, -0.1, 0.13, 0, 0.012)], 0.004)
        neck = boards([(-0.045, 0.045, 0.014, 0.034, 0.01, rise + 0.05)], 0.003)
        thing.add(joined([disc, neck]), stuff)
    return stood(thing)


def _tube_set(rng: np.random.Generator, thing: Thing, style: Style) -> Thing:
    w = between(rng, 0.42, 0.6)
    h, d = 0.8 * w, 0.4
    case = style.wood if rng.uniform() < 0.5 else casing(rng, dark=0.7)
    thing.add(boards([(-w / 2, w / 2, 0, 0.6 * d, 0.02, h)], 0.008), case, 0)
    thing.add(boards([(-0.36 * w, 0.36 * w, 0.6 * d - 0.01, d, 0.06, 0.8 * h)], 0.02), RUBBER)
    u, v = np.meshgrid(np.linspace(-1, 1, 13), np.linspace(-1, 1, 11), indexing="ij")
    bow = 0.014 * (1 - 0.5 * u**2 - 0.5 * v**2)
    points = np.stack([-0.07 * w + 0.36 * w * u, -0.002 - bow, 0.54 * h + 0.36 * h * v], -1)
    thing.add(sheet(points), picture(rng, w))
    thing.add(boards([(0.35 * w, 0.47 * w, -0.004, 0.002, 0.1 * h, 0.5 * h)], 0.001), GRILLE)
    knobs = [shifted(laid(cylinder(0.018, 0.022, sides=16), 1), 0.41 * w, -0.009,
        z * h) for z in (0.84, 0.67)]  # fmt: skip
    thing.add(joined(knobs), SILVER)
    thing.add(boards([(s * 0.4 * w - 0.02, s * 0.4 * w + 0.02, 0.02, 0.5 * d, 0,
        0.022) for s in (-1, 1)]), RUBBER)  # fmt: skip
    return stood(thing)


def _keys(w: float, d: float, rows: int, columns: int, z: float, rise: float) -> Mesh:
    """Rows of keys between x = ±w/2 and y = ±d/2, higher towards the back, m."""
    pitch_x, pitch_y = w / columns, d / rows
    limits = []
    for row in range(rows):
        y = -d / 2 + (row + 0.5) * pitch_y
        top = z + rise * (row + 0.5) / rows
        cuts = ([k - 0.25 * row % 1 for k in range(columns + 1)] if row else [0, 2, 3.5, 9.5, 11,
            columns])  # fmt: skip
        edges = np.clip(np.unique(np.array(cuts + ([0, columns] if row else []))), 0, columns)
        for a, b in pairwise(edges):
            if b - a > 0.3:
                limits.append((a * pitch_x - w / 2 + 0.0012, b * pitch_x - w / 2 - 0.0012,
                    y - pitch_y / 2 + 0.0012, y + pitch_y / 2 - 0.0012, top - 0.004,
                    top))  # fmt: skip
    return boards(limits, 0)


def keyboard(rng: np.random.Generator, style: Style) -> Thing:
    """A keyboard, mostly with the mouse beside it, m."""
    full = rng.uniform() < 0.6
    w, d = (0.44, 0.13) if full else (0.3, 0.12)
    case = casing(rng, dark=0.5)
    thing = Thing("keyboard")
    body = boards([(-w / 2, w / 2, -d / 2, d / 2, 0, 0.012)], 0.003)
    thing.add(body, case)
    wide = 0.3 if full else w - 0.012
    caps = BLACK if rng.uniform() < 0.5 else Material((0.7, 0.7, 0.68), specular=0.04)
    keys = [shifted(_keys(wide, d - 0.014, 6, 15, 0.016, 0.004), -w / 2 + wide / 2 + 0.006, 0, 0)]
    if full:
        keys.append(shifted(_keys(0.11, d - 0.014, 6, 6, 0.016, 0.004), w / 2 - 0.061, 0, 0))
    thing.add(joined(keys), caps)
    if rng.uniform() < 0.75:
        mouse = turned([(0, 0), (0.028, 0), (0.031, 0.012), (0.02, 0.03), (0, 0.035)], 20, 12)
        points = mouse.vertices.astype(float) * [1, 1.75, 1] + [w / 2 + between(rng, 0.07, 0.13),
            -0.01, 0]  # fmt: skip
        thing.add(Mesh(points.astype(np.float32), mouse.faces), case)
    return stood(thing)


def laptop(rng: np.random.Generator, style: Style) -> Thing:
    """An open laptop with its keys and touch pad, m."""
    w = pick(rng, 0.3, 0.325, 0.358)
    d = 0.69 * w
    case = SILVER if rng.uniform() < 0.5 else casing(rng, dark=0.7)
    thing = Thing("laptop").add(boards([(-w / 2, w / 2, -d / 2, d / 2, 0.002, 0.016)], 0.003), case)
    keys = shifted(_keys(0.9 * w, 0.46 * d, 6, 15, 0.0172, 0.0), 0, 0.16 * d, 0)
    thing.add(keys, BLACK)
    pad = [(-0.18 * w, 0.18 * w, -0.42 * d, -0.14 * d, 0.0155, 0.0165)]
    thing.add(boards(pad, 0), Material((0.3, 0.3, 0.31), specular=0.1))
    feet = boards([(x - 0.01, x + 0.01, y - 0.005, y + 0.005, 0, 0.003) for x, y,
        _ in corners(0.4 * w, 0.4 * d)])  # fmt: skip
    thing.add(feet, RUBBER)
    lean = between(rng, 0.15, 0.6)
    lid = Thing("lid")
    lid.add(boards([(-w / 2, w / 2, 0, 0.006, 0, d)], 0.002), case)
    lid.add(boards([(-w / 2 + 0.006, w / 2 - 0.006, -0.0008, 0.001, 0.014, d - 0.006)], 0),
        picture(rng, w))  # fmt: skip
    motion = np.eye(4)
    c, s = np.cos(lean), np.sin(lean)
    motion[1:3, 1:3] = [[c, s], [-s, c]]
    motion[:3, 3] = [0, d / 2 - 0.001, 0.014]
    return stood(absorbed(thing, lid, motion))


CATALOGUE: dict[str, Maker] = {
    "monitor": monitor,
    "television": television,
    "keyboard": keyboard,
    "laptop": laptop,
}
