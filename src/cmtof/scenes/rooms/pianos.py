"""Upright and grand pianos with all their keys, m."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.cabinetry import (
    BLACK,
    GLOSSY_BLACK,
    turned_leg,
)
from cmtof.scenes.rooms.joinery import (
    beams,
    boards,
    centred,
    copies,
    placed,
    plank,
    raised,
    rods,
    rounded,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.solids import joined, prism
from cmtof.scenes.rooms.thing import Mesh, Support, Thing

IVORY = Material((0.80, 0.78, 0.72), specular=0.1, gloss=100.0)


def _keyboard(thing: Thing, x: float, y: tuple[float, float], z: float) -> None:
    """White and black keys over a width of 2x, their front at y[0], m."""
    edges = np.linspace(-x, x, 53)
    white = [(a + 0.0006, b - 0.0006, y[0], y[1], z - 0.016, z)
             for a, b in pairwise(edges)]  # fmt: skip
    thing.add(boards(white, 0.0), IVORY)
    step = edges[1] - edges[0]
    at = [edges[k + 1] for k in range(51) if k % 7 in (0, 2, 3, 5, 6)]
    black = [
        (a - 0.28 * step, a + 0.28 * step, y[0] + 0.05, y[1] - 0.0005, z, z + 0.011) for a in at
    ]
    thing.add(boards(black, 0.0), BLACK)


def music_sheets(rng: np.random.Generator, x: float, y: float, z: float, lean: float) -> Mesh:
    """Two pages of music leaning back."""
    page = boards(
        [(-0.215, -0.003, -0.001, 0.001, 0, 0.29), (0.003, 0.215, -0.001, 0.001, 0, 0.29)], 0
    )
    return placed(page, (x + float(rng.normal(0, 0.05)), y, z), lean=-lean)


MUSIC = Material((0.78, 0.77, 0.72), (0.03, 0.03, 0.03), "marks", 0.012, specular=0.0)


def upright_piano(rng: np.random.Generator, style: Style) -> Thing:
    """A piano against the wall: case, lid open or shut, keys, music desk, pedals."""
    w, d, h = (
        float(rng.uniform(1.46, 1.52)),
        float(rng.uniform(0.56, 0.62)),
        float(rng.uniform(1.1, 1.28)),
    )
    body = GLOSSY_BLACK if rng.uniform() < 0.45 else style.wood
    thing, x, back = Thing("piano"), w / 2, d / 2
    face, front, key = back - 0.30, -d / 2, 0.72
    cheek = [(s * x - 0.05 * (s > 0), s * x + 0.05 * (s < 0)) for s in (-1, 1)]
    rows = [(*c, face + 0.01, back, 0.02, h - 0.02) for c in cheek]
    rows += [(*c, front + 0.01, face + 0.02, key - 0.1, key + 0.08) for c in cheek]
    rows += [(*c, front, back - 0.01, 0.0, 0.075) for c in cheek]
    rows += [(-x + 0.049, x - 0.049, face, face + 0.02, 0.1, key - 0.06),
             (-x + 0.049, x - 0.049, face, face + 0.02, key + 0.02, h - 0.02),
             (-x + 0.049, x - 0.049, front + 0.02, face + 0.03, key - 0.085, key - 0.035),
             (-x + 0.049, x - 0.049, front + 0.02, front + 0.04, key - 0.036, key - 0.004),
             (-x + 0.049, x - 0.049, back - 0.03, back, 0.02, h - 0.02),
             (-x - 0.01, x + 0.01, face - 0.02, back, h - 0.021, h),
             (-x + 0.049, x - 0.049, face + 0.005, back - 0.02, 0.02, 0.1)]  # fmt: skip
    thing.add(boards(rows, 0.004), body)
    leg = turned_leg(rng, key - 0.17, 0.03) if style.modern < 0.5 else None
    place = np.array([(s * (x - 0.025), front + 0.04, 0.07) for s in (-1, 1)])
    legs = (
        copies(leg, place)
        if leg
        else beams(place, raised(place, key - 0.165), 0.045, 0.06, taper=0.7)
    )
    thing.add(legs, body, 2)
    lid_open = rng.uniform() < 0.75
    if lid_open:
        _keyboard(thing, x - 0.11, (front + 0.045, face - 0.02), key)
        blocks = [(s * (x - 0.08) - 0.03, s * (x - 0.08) + 0.03, front + 0.04, face, key - 0.03,
            key + 0.015)
                  for s in (-1, 1)]  # fmt: skip
        lid = [(-x + 0.055, x - 0.055, face - 0.016, face - 0.001, key + 0.03, key + 0.2)]
        thing.add(boards([*blocks, *lid], 0.003), body)
        desk = placed(boards([(-0.32, 0.32, -0.008, 0.008, 0, 0.2)], 0.004), (0, face - 0.035,
            key + 0.22),
                      lean=-0.25)  # fmt: skip
        thing.add(desk, body)
        if rng.uniform() < 0.7:
            thing.add(music_sheets(rng, 0.0, face - 0.048, key + 0.225, 0.25), MUSIC)
    else:
        lid = placed(boards([(-x + 0.055, x - 0.055, -0.27, 0, -0.008, 0.008)], 0.006),
                     (0, face, key + 0.06), lean=0.08)  # fmt: skip
        thing.add(lid, body)
    pedal = rods([(a, face + 0.02, 0.06) for a in (-0.1, 0, 0.1)], [(a, face - 0.09, 0.055) for a in
                 (-0.1, 0, 0.1)], 0.011, taper=0.7)  # fmt: skip
    thing.add(pedal, Material((0.62, 0.45, 0.18), specular=0.65, gloss=120.0))
    thing.supports.append(Support(-x + 0.05, x - 0.05, face + 0.02, back - 0.03, h, 0.6))
    return thing


def grand_piano(rng: np.random.Generator, style: Style) -> Thing:
    """A baby grand: curved case, lid on its prop, keys, three legs."""
    w, length, h = 1.46, float(rng.uniform(1.5, 1.75)), 0.98
    body = GLOSSY_BLACK if rng.uniform() < 0.7 else style.wood
    x = w / 2
    curve = rounded([(-x, -0.5), (x, -0.5), (x, 0.05), (0.92 * x, 0.3), (0.25 * x, 0.55),
        (0.12 * x, 0.95),
                     (-0.1 * x, length - 0.55), (-0.55 * x, length - 0.5), (-x, length - 0.65),
                         (-x, -0.5)],
                    3)  # fmt: skip
    curve = np.concatenate([[(-x, -0.5)], [(x, -0.5)], curve[(curve[:, 1] > -0.4)]])
    thing = Thing("piano")
    wall = np.concatenate([curve, curve[:1]])
    path = np.column_stack([wall, np.full(len(wall), 0.82)])[1:]
    thing.add(plank(path, (0, 0, 0.29), 0.03), body)
    floor = [
        (-x + 0.02, x - 0.02, -0.49, 0.1, 0.68, 0.71),
        (-x + 0.02, 0.05, 0.09, length - 0.58, 0.682, 0.708),
    ]
    thing.add(boards(floor, 0), body)
    gold = Material((0.62, 0.45, 0.18), specular=0.45, gloss=40.0)
    thing.add(boards([(-x + 0.05, 0.62 * x, -0.1, 0.3, 0.85, 0.87), (-x + 0.05, 0.0, 0.29,
        length - 0.62,
                     0.852, 0.868)], 0.004), gold)  # fmt: skip
    deck = [
        (-x + 0.015, x - 0.015, -0.49, -0.28, 0.70, 0.735),
        (-x + 0.015, x - 0.015, -0.29, -0.265, 0.73, 0.9),
    ]
    blocks = [
        (s * (x - 0.07) - 0.05, s * (x - 0.07) + 0.05, -0.47, -0.28, 0.72, 0.79) for s in (-1, 1)
    ]
    thing.add(boards([*deck, *blocks], 0.003), body)
    _keyboard(thing, x - 0.125, (-0.47, -0.29), 0.765)
    lift = float(rng.uniform(0.5, 0.65)) if rng.uniform() < 0.6 else 0.0
    hull = _convex(curve[curve[:, 1] > -0.45])
    lid = prism(hull - [-x, 0], 0.018)
    lid = placed(lid, (-x, 0, h - 0.012), tilt=-lift)
    thing.add(lid, body)
    if lift:
        top = np.array([-x + 1.15 * np.cos(lift), 0.1, h + 1.15 * np.sin(lift)])
        thing.add(rods([(0.6 * x, 0.1, 0.86)], [top], 0.009), body)
    place = np.array([(-x + 0.12, -0.35, 0), (x - 0.12, -0.35, 0), (-0.5 * x, length - 0.75, 0)])
    thing.add(beams(place, raised(place, 0.69), 0.10, 0.10, taper=0.6, chamfer=0.01), body, 2)
    if lift:
        desk = boards([(-0.34, 0.34, -0.008, 0.008, 0, 0.2)], 0.004)
        thing.add(placed(desk, (0, -0.2, 0.87), lean=-0.35), body)
        thing.add(music_sheets(rng, 0.0, -0.215, 0.88, 0.35), MUSIC)
    lyre = rods(
        [(-0.06, -0.2, 0.1), (0.06, -0.2, 0.1)], [(-0.06, -0.2, 0.69), (0.06, -0.2, 0.69)], 0.012
    )
    box_ = boards([(-0.12, 0.12, -0.24, -0.16, 0.06, 0.11)], 0.004)
    thing.add(joined([lyre, box_]), body)
    return centred(thing)


def _convex(points: np.ndarray) -> np.ndarray:
    """Convex hull (N, 2), counter-clockwise: the lid covers the case's bay as well."""
    order = points[np.lexsort((points[:, 1], points[:, 0]))]

    def half(line: np.ndarray) -> list[np.ndarray]:
        hull: list[np.ndarray] = []
        for p in line:
            while len(hull) > 1:
                a, b = hull[-1] - hull[-2], p - hull[-1]
                if a[0] * b[1] - a[1] * b[0] > 0:
                    break
                hull.pop()
            hull.append(p)
        return hull

    low, high = half(order), half(order[::-1])
    return np.array(low[:-1] + high[:-1])
