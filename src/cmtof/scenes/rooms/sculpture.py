"""Sculpture and curiosities: busts, figures, masks, skulls, stones, shells, globes, m."""

import numpy as np

from cmtof.scenes.rooms.joinery import boards
from cmtof.scenes.rooms.materials import Material, Style, darker
from cmtof.scenes.rooms.pliant import slab, spline
from cmtof.scenes.rooms.portraits import Face, draw_face, portrait, socle, statuary
from cmtof.scenes.rooms.shaping import handle, hollow, laid, modelled, on_wall, pick, stood, turned
from cmtof.scenes.rooms.solids import ball, blob, faceted, joined, revolve, tube
from cmtof.scenes.rooms.tableware import BRASS
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between


def lifted(mesh: Mesh, x: float, y: float, z: float) -> Mesh:
    """A mesh moved, m."""
    return Mesh(mesh.vertices + np.array([x, y, z], np.float32), mesh.faces)


def bust(rng: np.random.Generator, style: Style) -> Thing:
    """A portrait on a socle, a herm, a head, a faceted head or an abstract one, m."""
    kind = int(pick(rng, 0, 0, 0, 1, 1, 2, 3, 4))
    scale = between(rng, 0.11, 0.22)
    stuff = statuary(rng)
    thing = Thing("bust")
    if kind == 4:
        return _abstract(rng, thing, stuff, scale)
    face = draw_face(rng, ("rounded", "square", "neck", "rounded")[kind])
    if kind == 3:
        body = faceted(portrait(rng, face._replace(curl=0.2), scale, 26, 20))
    else:
        body = portrait(rng, face, scale)
    foot = 0.0
    if kind != 1:
        foot = scale * between(rng, 0.45, 0.7)
        base = statuary(rng) if rng.uniform() < 0.4 else stuff
        width = scale * (0.62 if kind == 2 else 0.85)
        thing.add(socle(width, foot, kind == 2 or rng.uniform() < 0.3), base)
        foot -= 0.05 * scale
    return stood(thing.add(lifted(body, 0, 0, foot), stuff))


def _abstract(rng: np.random.Generator, thing: Thing, stuff: Material, scale: float) -> Thing:
    """An egg-shaped head with a ridge for its nose, on a long neck."""
    s = scale
    egg = modelled((0.72 * s, 0.8 * s, 1.15 * s), [((0, -1, -0.9), 0.5, 0.12), ((0, 1, 0.5), 0.6, 0.1),
                   ((0.5, -1, 0.1), 0.25, -0.09), ((-0.5, -1, 0.1), 0.25, -0.09),
                   ((0, -1, -0.12), 0.14, 0.14), ((0, -1, 0.12), 0.14, 0.09)],
                   (0, 0, 1.35 * s), subdivisions=4)  # fmt: skip
    neck = handle([(0, 0.12 * s, 0.1 * s), (0, 0.14 * s, 0.5 * s), (0, 0.02 * s, 1.0 * s)],
                  [0.2 * s, 0.13 * s, 0.17 * s], count=9, sides=18)  # fmt: skip
    base = boards([(-0.35 * s, 0.35 * s, -0.28 * s, 0.42 * s, 0, 0.13 * s)], 0.003)
    return stood(thing.add(joined([egg, neck]), stuff).add(base, statuary(rng)))


def statuette(rng: np.random.Generator, style: Style) -> Thing:
    """A standing, striding or dancing figure, or a ring-shaped abstract one, on a base, m."""
    h = between(rng, 0.18, 0.4)
    stuff = statuary(rng)
    thing = Thing("statuette")
    foot = 0.08 * h
    thing.add(turned(np.array([(0, 0), (0.2, 0), (0.21, 0.03), (0.18, 0.06), (0.18, 0.083), (0, 0.083)])
                     * h, 24, 12), statuary(rng) if rng.uniform() < 0.4 else stuff)  # fmt: skip
    if rng.uniform() < 0.25:
        return stood(thing.add(_ring(rng, h, foot), stuff))
    stride, sway = between(rng, -0.06, 0.1), between(rng, -0.03, 0.03)
    hip, chest = np.array([sway, 0, 0.52]), np.array([-sway, 0, 0.76])
    limbs = []
    for side in (-1, 1):
        toe = [side * 0.045, -side * stride, 0.085]
        knee = [side * 0.05, -0.5 * side * stride - 0.015, 0.29]
        limbs.append(
            handle([toe, knee, hip + [side * 0.04, 0, 0]], [0.022, 0.03, 0.028, 0.045], sides=9)
        )
        limbs.append(
            modelled((0.04, 0.1, 0.04), centre=(toe[0], toe[1] - 0.02, 0.092), subdivisions=2)
        )
        raise_ = between(rng, -0.2, 0.25) if rng.uniform() < 0.5 else -0.2
        elbow = chest + [side * 0.13, between(rng, -0.06, 0.04), 0.04 + 0.6 * raise_]
        hand = elbow + [side * between(rng, -0.05, 0.09), between(rng, -0.1, 0.0), 0.8 * raise_]
        limbs.append(
            handle([chest + [side * 0.07, 0, 0.05], elbow, hand], [0.026, 0.022, 0.017], sides=8)
        )
    trunk = spline([hip + [0, 0, -0.03], (hip + chest) / 2, chest, chest + [0, 0, 0.075]], 10)
    body = tube(trunk, np.interp(np.linspace(0, 1, 10), [0, 0.15, 0.45, 0.75, 1],
                                 [0.055, 0.068, 0.05, 0.072, 0.03]), 14)  # fmt: skip
    head = modelled((0.085, 0.1, 0.125), [((0, -1, -0.1), 0.18, 0.12), ((0, 1, 0.6), 0.5, 0.12)],
                    chest + [0, -0.005, 0.175], subdivisions=2)  # fmt: skip
    neck = tube([chest + [0, 0, 0.05], chest + [0, 0, 0.14]], 0.022, 8)
    figure = [*limbs, body, head, neck]
    if rng.uniform() < 0.35:  # a gown
        skirt = np.array([(0.14, 0.083), (0.12, 0.2), (0.085, 0.42), (0.062, 0.55), (0.055, 0.62)])
        gown = turned(skirt, 40, 14)
        x, y, z = gown.vertices.T.astype(float)
        fold = 1 + 0.09 * np.cos(9 * np.arctan2(y, x)) * np.clip((0.6 - z) / 0.4, 0, 1)
        figure.append(
            Mesh(np.stack([x * fold + sway, y * fold, z], -1).astype(np.float32), gown.faces)
        )
    whole = joined(figure)
    return stood(thing.add(Mesh(whole.vertices * np.float32(h), whole.faces), stuff))


def _ring(rng: np.random.Generator, h: float, foot: float) -> Mesh:
    """A loop whose thickness swells around it, twisted out of its plane."""
    t = np.linspace(0, 2 * np.pi, 41)
    r = 0.36 * h
    twist = between(rng, 0.0, 0.14) * h
    path = np.stack(
        [r * np.sin(t), twist * np.sin(2 * t), foot + 1.2 * r - 1.25 * r * np.cos(t)], -1
    )
    return tube(path, 0.05 * h * (1.25 + 0.6 * np.cos(t - 2.2)), 14)


def owl_figure(rng: np.random.Generator, style: Style) -> Thing:
    """A sitting owl of ceramic, wood or bronze, m."""
    h = between(rng, 0.1, 0.26)
    stuff = style.wood if rng.uniform() < 0.2 else statuary(rng)
    wide = between(rng, 0.5, 0.62) * h
    body = modelled((wide, 0.85 * wide, 0.78 * h), [((0, -1, 0.1), 0.5, 0.08), ((0, 0, -1), 0.6, 0.06)],
                    (0, 0, 0.38 * h))  # fmt: skip
    bumps = [((0.45, -1, 0.1), 0.2, -0.13), ((-0.45, -1, 0.1), 0.2, -0.13), ((0.75, -0.3, 1), 0.16, 0.34),
             ((-0.75, -0.3, 1), 0.16, 0.34), ((0, -1, 0.25), 0.16, 0.06)]  # fmt: skip
    head = modelled((0.95 * wide, 0.78 * wide, 0.4 * h), bumps, (0, -0.02 * h, 0.74 * h))
    wings = [modelled((0.14 * wide, 0.6 * wide, 0.58 * h), [((0, 0.4, -1), 0.5, 0.2)],
                      (side * 0.47 * wide, 0.06 * wide, 0.4 * h), subdivisions=2)
             for side in (-1, 1)]  # fmt: skip
    feet = [modelled((0.2 * wide, 0.22 * wide, 0.07 * h), centre=(side * 0.17 * wide, -0.3 * wide, 0.034 * h),
                     subdivisions=2) for side in (-1, 1)]  # fmt: skip
    tail = modelled(
        (0.4 * wide, 0.2 * wide, 0.3 * h), centre=(0, 0.42 * wide, 0.15 * h), subdivisions=2
    )
    beak = modelled((0.1 * wide, 0.18 * wide, 0.11 * h), [((0, -0.6, -1), 0.4, 0.3)],
                    (0, -0.42 * wide, 0.72 * h), subdivisions=2)  # fmt: skip
    eyes = [
        ball(0.115 * wide, (side * 0.19 * wide, -0.345 * wide, 0.765 * h), 2) for side in (-1, 1)
    ]
    thing = Thing("owl").add(joined([body, head, *wings, *feet, tail]), stuff)
    pale = Material((0.6, 0.42, 0.08), specular=0.2, gloss=300.0)
    thing.add(joined([beak]), pale if rng.uniform() < 0.5 else stuff)
    pupils = [
        ball(0.06 * wide, (side * 0.19 * wide, -0.43 * wide, 0.765 * h), 2) for side in (-1, 1)
    ]
    thing.add(joined(eyes), pale)
    return stood(thing.add(joined(pupils), Material((0.01, 0.01, 0.01), specular=0.2, gloss=500.0)))


def animal_figure(rng: np.random.Generator, style: Style) -> Thing:
    """A sitting cat, a standing horse, an elephant or a bird, m."""
    maker = (_cat, _horse, _elephant, _bird)[int(rng.integers(4))]
    stuff = style.wood if rng.uniform() < 0.15 else statuary(rng)
    kind, meshes = maker(rng)
    whole = joined(meshes)
    size = between(rng, 0.1, 0.24)
    thing = Thing(kind).add(Mesh(whole.vertices * np.float32(size), whole.faces), stuff)
    if kind == "horse" and rng.uniform() < 0.6:
        low, high = thing.bounds
        plinth = boards([(low[0] + 0.1 * size, high[0] - 0.1 * size, low[1] - 0.05 * size,
                          high[1] + 0.05 * size, -0.09 * size, 0.01 * size)], 0.003)  # fmt: skip
        thing.add(plinth, statuary(rng))
    return stood(thing)


def _cat(rng: np.random.Generator) -> tuple[str, list[Mesh]]:
    body = modelled((0.42, 0.56, 0.62), [((0, 0.6, -0.6), 0.7, 0.12)], (0, 0.08, 0.3))
    chest = modelled((0.32, 0.32, 0.58), centre=(0, -0.08, 0.42))
    head = modelled((0.34, 0.32, 0.29), [((0.62, -0.1, 0.8), 0.17, 0.55), ((-0.62, -0.1, 0.8), 0.17, 0.55),
                    ((0, -1, -0.35), 0.3, 0.16), ((0.4, -1, 0.15), 0.14, -0.08),
                    ((-0.4, -1, 0.15), 0.14, -0.08)], (between(rng, -0.05, 0.05), -0.14, 0.8))  # fmt: skip
    legs = [handle([(s * 0.09, -0.13, 0.5), (s * 0.1, -0.2, 0.22), (s * 0.1, -0.22, 0.04)],
                   [0.09, 0.065, 0.055], count=7) for s in (-1, 1)]  # fmt: skip
    paws = [
        modelled((0.13, 0.2, 0.09), centre=(s * 0.1, -0.25, 0.045), subdivisions=2) for s in (-1, 1)
    ]
    haunch = [
        modelled((0.2, 0.4, 0.36), centre=(s * 0.17, 0.12, 0.18), subdivisions=2) for s in (-1, 1)
    ]
    tail = handle([(0, 0.34, 0.06), (0.2, 0.38, 0.05), (0.34, 0.2, 0.05), (0.33, -0.02, 0.05)],
                  [0.06, 0.055, 0.045, 0.04])  # fmt: skip
    return "cat", [body, chest, head, *legs, *paws, *haunch, tail]


def _legs(x: float, y: float, top: float, thick: tuple[float, ...], stride: float) -> list[Mesh]:
    made = []
    for k, (a, b) in enumerate(((-1, -1), (1, -1), (-1, 1), (1, 1))):
        step = stride * (-1) ** k
        path = [(a * x, b * y, top), (a * x + 0.03 * a + 0.4 * step, b * y, 0.55 * top),
                (a * x + step, b * y, 0.02)]  # fmt: skip
        made.append(handle(path, thick, count=8))
    return made


def _horse(rng: np.random.Generator) -> tuple[str, list[Mesh]]:
    body = modelled(
        (0.9, 0.34, 0.4), [((1, 0, 0.2), 0.5, 0.06), ((-1, 0, 0.3), 0.5, 0.08)], (0, 0, 0.66)
    )
    neck = handle([(-0.3, 0, 0.7), (-0.45, 0, 0.9), (-0.56, 0, 1.1)], [0.17, 0.13, 0.09], sides=12)
    head = modelled(
        (0.36, 0.15, 0.18), [((-1, 0, -0.1), 0.4, 0.12)], (-0.66, 0, 1.08), subdivisions=2
    )
    ears = [handle([(-0.55, s * 0.04, 1.13), (-0.54, s * 0.05, 1.24)], [0.03, 0.006], count=4, sides=5)
            for s in (-1, 1)]  # fmt: skip
    mane = handle([(-0.6, 0, 1.16), (-0.44, 0, 1.08), (-0.3, 0, 0.88)], [0.03, 0.05, 0.03])
    mane = Mesh(mane.vertices * np.array([1, 0.5, 1], np.float32), mane.faces)
    tail = handle([(0.42, 0, 0.74), (0.54, 0, 0.68), (0.56, 0, 0.35)], [0.03, 0.055, 0.015])
    legs = _legs(0.31, 0.09, 0.6, (0.12, 0.055, 0.04, 0.05), between(rng, 0, 0.1))
    return "horse", [body, neck, head, *ears, mane, tail, *legs]


def _elephant(rng: np.random.Generator) -> tuple[str, list[Mesh]]:
    body = modelled((0.95, 0.6, 0.62), [((0, 0, 1), 0.6, 0.06)], (0.08, 0, 0.62))
    head = modelled((0.42, 0.4, 0.46), [((-0.3, 0.4, 1), 0.4, 0.1), ((-0.3, -0.4, 1), 0.4, 0.1)],
                    (-0.48, 0, 0.8))  # fmt: skip
    end = between(rng, 0.1, 0.6)
    trunk = handle([(-0.6, 0, 0.78), (-0.78, 0, 0.6), (-0.8, 0, 0.35), (-0.92, 0, 0.2 + 0.4 * end)],
                   [0.13, 0.09, 0.06, 0.045], sides=10)  # fmt: skip
    ears = [modelled((0.36, 0.07, 0.46), [((1, 0, -0.6), 0.5, 0.15)], (-0.36, s * 0.24, 0.78), subdivisions=2)
            for s in (-1, 1)]  # fmt: skip
    tusks = [handle([(-0.6, s * 0.1, 0.66), (-0.72, s * 0.11, 0.56), (-0.84, s * 0.1, 0.58)],
                    [0.03, 0.025, 0.006], count=6, sides=6) for s in (-1, 1)]  # fmt: skip
    legs = _legs(0.3, 0.17, 0.5, (0.13, 0.11, 0.11), between(rng, 0, 0.06))
    tail = handle(
        [(0.54, 0, 0.7), (0.6, 0, 0.5), (0.58, 0, 0.35)], [0.02, 0.015, 0.025], count=6, sides=5
    )
    return "elephant", [body, head, trunk, *ears, *tusks, *legs, tail]


def _bird(rng: np.random.Generator) -> tuple[str, list[Mesh]]:
    body = modelled(
        (0.85, 0.42, 0.46), [((1, 0, 0.5), 0.3, 0.5), ((-1, 0, 0.1), 0.5, 0.06)], (0, 0, 0.42)
    )
    head = modelled(
        (0.32, 0.28, 0.28), [((-1, 0, -0.1), 0.16, 0.6)], (-0.36, 0, 0.72), subdivisions=3
    )
    neck = handle([(-0.22, 0, 0.5), (-0.34, 0, 0.7)], [0.17, 0.12], count=5)
    wings = [modelled((0.62, 0.08, 0.26), [((1, 0, 0.3), 0.4, 0.25)], (0.08, s * 0.2, 0.46), subdivisions=2)
             for s in (-1, 1)]  # fmt: skip
    foot = turned([(0, 0), (0.22, 0), (0.2, 0.05), (0.06, 0.08), (0.05, 0.3), (0, 0.3)], 18, 12)
    return "bird", [body, head, neck, *wings, foot]


def trophy(rng: np.random.Generator, style: Style) -> Thing:
    """A cup with two ears on a block, with or without a lid, m."""
    h = between(rng, 0.18, 0.4)
    metal = BRASS if rng.uniform() < 0.6 else Material((0.6, 0.6, 0.62), specular=0.75, gloss=200.0)
    base = 0.2 * h
    block = boards([(-0.2 * h, 0.2 * h, -0.2 * h, 0.2 * h, 0, base)], 0.004)
    stone = Material(
        (0.03, 0.03, 0.03), (0.2, 0.2, 0.2), "marble", 0.08, specular=0.15, gloss=200.0
    )
    cup = np.array([(0, 0.2), (0.15, 0.2), (0.15, 0.23), (0.04, 0.28), (0.03, 0.38), (0.06, 0.42),
                    (0.17, 0.52), (0.21, 0.75), (0.23, 0.95)]) * h  # fmt: skip
    body = hollow(cup, 0.004, floor=0.47 * h)
    ears = []
    for side in (-1, 1):
        path = np.array(
            [(0.19, 0, 0.6), (0.3, 0, 0.62), (0.34, 0, 0.82), (0.27, 0, 0.92), (0.22, 0, 0.86)]
        )
        ears.append(handle(path * [side * h, h, h], 0.013 * h + 0.001, sides=7))
    thing = Thing("trophy").add(block, stone if rng.uniform() < 0.6 else style.wood)
    thing.add(joined([body, *ears]), metal)
    plate = boards(
        [(-0.11 * h, 0.11 * h, -0.2 * h - 0.0015, -0.19 * h, 0.3 * base, 0.75 * base)], 0.0004
    )
    thing.add(plate, Material((0.62, 0.5, 0.25), (0.1, 0.08, 0.04), "marks", 0.006, specular=0.3))
    if rng.uniform() < 0.4:
        lid = np.array([(0, 0.955), (0.235, 0.955), (0.2, 1.0), (0.05, 1.05), (0.03, 1.08), (0.05, 1.13),
                        (0, 1.17)]) * h  # fmt: skip
        thing.add(turned(lid, 24, 14), metal)
    return stood(thing)


def skull(rng: np.random.Generator, style: Style) -> Thing:
    """A skull with eye sockets, nose hole, cheek bones, teeth and jaw, m."""
    s = between(rng, 0.85, 1.1)
    bumps = [((0.33, -1, -0.28), 0.15, -0.35), ((-0.33, -1, -0.28), 0.15, -0.35),
             ((0, -1, -0.55), 0.1, -0.12), ((0.4, -1, -0.02), 0.2, 0.1), ((-0.4, -1, -0.02), 0.2, 0.1),
             ((0.7, -0.8, -0.62), 0.16, 0.14), ((-0.7, -0.8, -0.62), 0.16, 0.14),
             ((1, -0.3, -0.1), 0.3, -0.08), ((-1, -0.3, -0.1), 0.3, -0.08),
             ((0, -1, -0.95), 0.28, 0.1), ((0, 0.6, -1), 0.5, -0.2)]  # fmt: skip
    cranium = modelled((0.14, 0.185, 0.15), bumps, (0, 0.015, 0.125), subdivisions=4)
    t = np.linspace(-1.35, 1.35, 15)
    arch = np.stack([0.031 * np.sin(t), -0.04 - 0.035 * np.cos(t), np.full(15, 0.03)], -1)
    line = [(-0.058, 0.012, 0.085), (-0.054, 0.0, 0.03), (-0.035, -0.05, 0.012), (0, -0.078, 0.011),
            (0.035, -0.05, 0.012), (0.054, 0.0, 0.03), (0.058, 0.012, 0.085)]  # fmt: skip
    mandible = handle(line, [0.008, 0.011, 0.0125, 0.0135, 0.0125, 0.011, 0.008], count=25, sides=9)
    chin = modelled((0.034, 0.02, 0.024), centre=(0, -0.082, 0.013), subdivisions=1)
    teeth = [boards([(x - 0.0029, x + 0.0029, y - 0.003, y + 0.004, z, z + 0.0105)], 0)
             for x, y, _ in arch for z in (0.022, 0.0335)]  # fmt: skip
    upper = modelled((0.064, 0.068, 0.1), [((0, -1, 0.5), 0.2, -0.55), ((0, -1, -0.5), 0.4, 0.1)],
                     (0, -0.037, 0.078), subdivisions=3)  # fmt: skip
    cheeks = [handle([(s * 0.025, -0.055, 0.085), (s * 0.056, -0.056, 0.084), (s * 0.067, -0.01, 0.096)],
                     [0.012, 0.0095, 0.005], count=8, sides=7) for s in (-1, 1)]  # fmt: skip
    bone = Material((0.62, 0.55, 0.4), (0.5, 0.42, 0.28), "noise", 0.03, specular=0.03)
    if rng.uniform() < 0.4:
        bone = statuary(rng)
    whole = joined([cranium, upper, mandible, chin, *cheeks, *teeth])
    return stood(Thing("skull").add(Mesh(whole.vertices * np.float32(s), whole.faces), bone))


def stone(rng: np.random.Generator, style: Style) -> Thing:
    """A pebble, a broken rock, or a small pile of pebbles, m."""
    thing = Thing("stone")
    grey = between(rng, 0.08, 0.5)
    base = (grey, 0.97 * grey, 0.9 * grey)
    stuff = Material(base, darker(base, 0.65), "noise", 0.02, specular=0.03, bump=0.3)
    size = between(rng, 0.05, 0.14)
    kind = int(rng.integers(3))
    if kind == 1:
        return stood(thing.add(faceted(blob(rng, (size, 0.8 * size, 0.7 * size), roughness=0.3,
                                            subdivisions=2)), stuff))  # fmt: skip
    z = 0.0
    for k in range(1 if kind == 0 else int(rng.integers(3, 6))):
        w = size * 0.82**k
        mesh = blob(
            rng, (w, 0.8 * w, 0.42 * w), roughness=0.1, waves=6, subdivisions=3 if kind == 0 else 2
        )
        thing.add(lifted(mesh, *rng.normal(0, 0.03 * size, 2), z), stuff)
        z += float(mesh.vertices[:, 2].max()) - 0.002
    return stood(thing)


def shell(rng: np.random.Generator, style: Style) -> Thing:
    """A sea snail's coil or a scallop's fan, m."""
    thing = Thing("shell")
    base = ((0.75, 0.62, 0.5), (0.72, 0.45, 0.38), (0.8, 0.77, 0.7))[int(rng.integers(3))]
    stuff = Material(base, darker(base, 0.55), "stripes", 0.012, specular=0.1, gloss=80.0)
    if rng.uniform() < 0.5:
        turns, n = between(rng, 3.5, 4.5), 70
        t = np.linspace(0, 1, n)
        grow = np.exp(3.2 * (t - 1))
        a = 2 * np.pi * turns * t
        size = between(rng, 0.03, 0.05)
        path = np.stack(
            [
                0.62 * size * grow * np.cos(a),
                0.62 * size * grow * np.sin(a),
                1.9 * size * (1 - grow),
            ],
            -1,
        )
        ribs = 1 + 0.06 * np.cos(26 * a / 2 / np.pi * 4)
        coil = tube(path, 0.6 * size * grow * ribs, 12)
        return stood(thing.add(Mesh(coil.vertices[:, [2, 0, 1]], coil.faces), stuff))
    r, n, m = between(rng, 0.04, 0.075), 13, 57
    u, v = np.meshgrid(np.linspace(0.04, 1, n), np.linspace(-1.15, 1.15, m), indexing="ij")
    edge = 1 + 0.03 * np.cos(13 * v * 2.1)
    x, y = r * u * edge * np.sin(v), r * u * edge * np.cos(v)
    z = 0.34 * r * np.sqrt(np.clip(1.05 - u**2, 0, 1)) * np.cos(0.9 * v) + 0.018 * r * u * np.cos(
        13 * v * 2.1
    )
    fan = slab(np.stack([x, y, z], -1)[:, ::-1], 0.0018)
    hinge = boards([(-0.28 * r, 0.28 * r, -0.05 * r, 0.1 * r, 0.2 * r, 0.28 * r)], 0.002)
    return stood(thing.add(joined([fan, hinge]), stuff))


def globe(rng: np.random.Generator, style: Style) -> Thing:
    """A tilted globe in its half ring on a turned foot, m."""
    r = between(rng, 0.07, 0.16)
    tilt = np.radians(23.4)
    axis = np.array([np.sin(tilt), 0, np.cos(tilt)])
    middle = np.array([0, 0, 1.55 * r + 0.03])
    sea = Material(((0.05, 0.2, 0.4), (0.5, 0.4, 0.22), (0.03, 0.04, 0.06))[int(rng.integers(3))],
                   (0.35, 0.3, 0.12), "picture", 1.1 * r, specular=0.1, gloss=120.0)  # fmt: skip
    body = lifted(_sphere(r), *middle)
    a = np.linspace(0, np.pi, 21)
    side = np.array([np.cos(tilt), 0, -np.sin(tilt)])
    ring = middle + 1.07 * r * (np.cos(a)[:, None] * axis + np.sin(a)[:, None] * side)
    pins = [
        tube([middle + s * 0.97 * r * axis, middle + s * 1.1 * r * axis], 0.035 * r, 8)
        for s in (-1, 1)
    ]
    metal = style.metal if rng.uniform() < 0.5 else BRASS
    thing = Thing("globe").add(body, sea)
    thing.add(joined([tube(ring, 0.035 * r, 8), *pins]), metal)
    # the stem comes up to meet the lowest point of the ring
    low = ring[int(np.argmin(ring[:, 2]))]
    foot = turned(np.array([(0, 0), (0.62 * r, 0), (0.64 * r, 0.08 * r), (0.3 * r, 0.16 * r),
                            (0.07 * r, 0.24 * r), (0.06 * r, low[2])]), 26, 16)  # fmt: skip
    thing.add(lifted(foot, float(low[0]), 0, 0), style.wood if rng.uniform() < 0.6 else metal)
    return stood(thing)


def _sphere(radius: float) -> Mesh:
    a = np.linspace(-np.pi / 2, np.pi / 2, 25)
    return revolve(radius * np.stack([np.cos(a), np.sin(a)], -1), 44)


def mask(rng: np.random.Generator, style: Style) -> Thing:
    """A carved or painted mask that hangs on a wall, m."""
    h = between(rng, 0.12, 0.2)
    face = Face(between(rng, 0.12, 0.2), between(rng, 0.02, 0.07), between(rng, 0.03, 0.07), 0.0, 0.3,
                0.0, 0.0, 0.0, 1.0, "neck")  # fmt: skip
    head = portrait(rng, face, h, 42, 42)
    p = head.vertices.astype(float)
    top = float(p[:, 2].max())
    chin = top - h
    corners = p[head.faces]
    keep = np.flatnonzero(
        ((corners[..., 1] < 0.1 * h) & (corners[..., 2] > chin - 0.02 * h)).all(1)
    )
    faces = head.faces[keep]
    long = between(rng, 1.0, 1.4)
    used, faces = np.unique(faces, return_inverse=True)
    q = p[used] * [1, 0.9, long]
    back = q * [0.94, 1, 0.96] + [0, 0.012, 0.02 * h * long]
    index = faces.reshape(-1, 3).astype(np.int32)
    front = Mesh(q.astype(np.float32), index)
    rear = Mesh(back.astype(np.float32), index[:, ::-1].copy())
    stuff = (style.wood, style.accent, statuary(rng))[int(rng.integers(3))]
    thing = Thing("mask").add(joined([front, rear]), stuff)
    pupils = []
    for side in (-1, 1):
        pupils.append(ball(0.055 * h, (side * 0.14 * h, -0.31 * h, (chin + 0.475 * h) * long), 2))
    thing.add(joined(pupils), Material((0.01, 0.01, 0.01), specular=0.0))
    for k in range(int(pick(rng, 0, 2))):
        side = 2 * k - 1
        path = [(side * 0.2 * h, -0.05 * h, (chin + 0.9 * h) * long), (side * 0.4 * h, -0.1 * h, (chin + 1.15 * h) * long),
                (side * 0.32 * h, -0.15 * h, (chin + 1.4 * h) * long)]  # fmt: skip
        thing.add(handle(path, [0.08 * h, 0.06 * h, 0.012 * h], sides=9), stuff)
    return on_wall(thing)


CATALOGUE: dict[str, Maker] = {
    "bust": bust,
    "statuette": statuette,
    "owl_figure": owl_figure,
    "animal_figure": animal_figure,
    "trophy": trophy,
    "skull": skull,
    "stone": stone,
    "shell": shell,
    "globe": globe,
    "mask": mask,
}
