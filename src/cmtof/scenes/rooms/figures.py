"""Figures of animals: owls, cats, horses, elephants, birds, m."""

import numpy as np

from cmtof.scenes.rooms.joinery import boards
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.portraits import statuary
from cmtof.scenes.rooms.shaping import handle, modelled, stood, turned
from cmtof.scenes.rooms.solids import ball, joined
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between


def lifted(mesh: Mesh, x: float, y: float, z: float) -> Mesh:
    """A mesh moved, m."""
    return Mesh(mesh.vertices + np.array([x, y, z], np.float32), mesh.faces)


def owl_figure(rng: np.random.Generator, style: Style) -> Thing:
    """A sitting owl of ceramic, wood or bronze, m."""
    h = between(rng, 0.1, 0.26)
    stuff = style.wood if rng.uniform() < 0.2 else statuary(rng)
    wide = between(rng, 0.5, 0.62) * h
    body = modelled((wide, 0.85 * wide, 0.78 * h), [((0, -1, 0.1), 0.5, 0.08),
        ((0, 0, -1), 0.6, 0.06)], (0, 0, 0.38 * h))  # fmt: skip
    bumps = [((0.45, -1, 0.1), 0.2, -0.13), ((-0.45, -1, 0.1), 0.2, -0.13),
        ((0.75, -0.3, 1), 0.16, 0.34), ((-0.75, -0.3, 1), 0.16, 0.34),
        ((0, -1, 0.25), 0.16, 0.06)]  # fmt: skip
    head = modelled((0.95 * wide, 0.78 * wide, 0.4 * h), bumps, (0, -0.02 * h, 0.74 * h))
    wings = [modelled((0.14 * wide, 0.6 * wide, 0.58 * h), [((0, 0.4, -1), 0.5, 0.2)],
        (side * 0.47 * wide, 0.06 * wide, 0.4 * h), subdivisions=2) for side in (-1,
        1)]  # fmt: skip
    feet = [modelled((0.2 * wide, 0.22 * wide, 0.07 * h), centre=(side * 0.17 * wide, -0.3 * wide,
        0.034 * h), subdivisions=2) for side in (-1, 1)]  # fmt: skip
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
    head = modelled((0.34, 0.32, 0.29), [((0.62, -0.1, 0.8), 0.17, 0.55),
        ((-0.62, -0.1, 0.8), 0.17, 0.55), ((0, -1, -0.35), 0.3, 0.16),
        ((0.4, -1, 0.15), 0.14, -0.08), ((-0.4, -1, 0.15), 0.14, -0.08)],
        (between(rng, -0.05, 0.05), -0.14, 0.8))  # fmt: skip
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
    ears = [handle([(-0.55, s * 0.04, 1.13), (-0.54, s * 0.05, 1.24)], [0.03, 0.006], count=4,
        sides=5) for s in (-1, 1)]  # fmt: skip
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
    ears = [modelled((0.36, 0.07, 0.46), [((1, 0, -0.6), 0.5, 0.15)], (-0.36, s * 0.24, 0.78),
        subdivisions=2) for s in (-1, 1)]  # fmt: skip
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
    wings = [modelled((0.62, 0.08, 0.26), [((1, 0, 0.3), 0.4, 0.25)], (0.08, s * 0.2, 0.46),
        subdivisions=2) for s in (-1, 1)]  # fmt: skip
    foot = turned([(0, 0), (0.22, 0), (0.2, 0.05), (0.06, 0.08), (0.05, 0.3), (0, 0.3)], 18, 12)
    return "bird", [body, head, neck, *wings, foot]


CATALOGUE: dict[str, Maker] = {
    "owl_figure": owl_figure,
    "animal_figure": animal_figure,
}
