"""What cabinets share: fronts with their handles, carcasses on plinths or feet, legs, taps, m."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.joinery import (
    beams,
    bent,
    boards,
    copies,
    corners,
    frame,
    placed,
    rods,
    rounded,
    shifted,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.solids import joined, revolve, tube
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.upholstery import cloth

CHROME = Material((0.60, 0.60, 0.62), specular=0.85, gloss=400.0)
STEEL = Material((0.42, 0.42, 0.43), specular=0.5, gloss=40.0)
BLACK = Material((0.02, 0.02, 0.02), specular=0.06, gloss=30.0)
GLOSSY_BLACK = Material((0.015, 0.015, 0.017), specular=0.25, gloss=500.0)
WHITE = Material((0.80, 0.80, 0.79), specular=0.12, gloss=200.0)
MIRROR = Material((0.05, 0.05, 0.05), specular=0.92, gloss=5000.0)

GAP = 0.003
"""Between neighbouring fronts, m."""
FRONT = 0.018
"""Thickness of a front, m."""

Span = tuple[float, float]
Maker = Callable[..., Thing]
"""``maker(rng, style, **sizes)`` draws a thing."""


def timber(rng: np.random.Generator, style: Style) -> Material:
    """Mostly the household's wood, sometimes its second one or its paint."""
    return (style.wood, style.wood, style.wood, style.second_wood, style.paint)[
        int(rng.integers(5))
    ]


@dataclass(frozen=True)
class Look:
    """How the fronts of one piece are made.

    Attributes
    ----------
    panel : str
        slab, shaker, raised, boards or laths.
    handle : str
        knob, bar, bow, cup, lip or none.
    material, metal : Material
        Of the fronts and of the handles.
    grain : int
        Axis of the fronts' grain.
    """

    panel: str
    handle: str
    material: Material
    metal: Material
    grain: int = 0


def look(rng: np.random.Generator, style: Style, material: Material) -> Look:
    """Plain fronts and bars in a modern household, framed ones and knobs in an old one."""
    modern = rng.uniform() < 0.2 + 0.6 * style.modern
    panels = ["slab", "slab", "laths"] if modern else ["shaker", "raised", "boards", "shaker"]
    handles = ["bar", "bar", "lip", "none", "knob"] if modern else ["knob", "knob", "bow", "cup"]
    kind = str(rng.choice(panels))
    metal = style.metal if rng.uniform() < 0.7 else style.second_wood
    return Look(kind, str(rng.choice(handles)), material, metal, int(rng.choice([0, 2])))


def panel(kind: str, x: Span, z: Span, y: float) -> Mesh:
    """One front in the rectangle x, z, its back at y, m."""
    (x0, x1), (z0, z1) = x, z
    width, height = x1 - x0, z1 - z0
    rim = min(0.065, 0.28 * min(width, height))
    if kind in ("shaker", "glass"):
        ring = frame(x, (y - 0.02, y), z, rim)
        infill = (x0 + rim - 0.004, x1 - rim + 0.004, y - 0.011, y - 0.002,
                  z0 + rim - 0.004, z1 - rim + 0.004)  # fmt: skip
        return ring if kind == "glass" else joined([ring, boards([infill], 0)])
    if kind == "slab" or min(width, height) < 0.09:
        return boards([(x0, x1, y - FRONT, y, z0, z1)])
    if kind == "raised":
        field = (x0 + rim, x1 - rim, y - 0.026, y - FRONT + 0.001, z0 + rim, z1 - rim)
        back = boards([(x0, x1, y - FRONT, y, z0, z1)], 0.003)
        return joined([back, boards([field], 0.008)])
    if kind == "laths":
        edges = np.linspace(x0, x1, max(int(width / 0.03), 3) + 1)
        rows = [(a + 0.004, b - 0.004, y - 0.022, y - 0.009, z0, z1)
                for a, b in pairwise(edges)]  # fmt: skip
        return joined([boards([(x0, x1, y - 0.010, y, z0, z1)]), boards(rows, 0)])
    edges = np.linspace(x0, x1, max(round(width / 0.09), 2) + 1)
    rows = [(a + 0.0008, b - 0.0008, y - FRONT, y, z0, z1)
            for a, b in pairwise(edges)]  # fmt: skip
    return boards(rows, 0.004)


@lru_cache(maxsize=64)
def _grip(kind: str, length: float, upright: bool) -> Mesh:
    """A knob, cup, bow or bar whose face is at the origin."""
    if kind == "knob":
        profile = [(0.0, 0.0), (0.007, 0.0), (0.007, 0.012), (0.015, 0.018), (0.016, 0.024),
                   (0.010, 0.030), (0.0, 0.031)]  # fmt: skip
        return placed(revolve(profile, 12), lean=np.pi / 2)
    half = length / 2
    if kind == "cup":
        turn = np.linspace(0, np.pi, 9)
        arch = np.stack([-0.045 * np.cos(turn), -0.022 * np.sin(turn) ** 0.6], -1)
        levels = ((1.0, -0.014), (1.0, 0.0), (0.75, 0.012), (0.2, 0.016))
        bowl = np.stack([np.column_stack([arch * s, np.full(9, h)]) for s, h in levels])
        return placed(cloth(bowl[:, ::-1], 0.002), (0, -0.001, 0))
    if kind == "bow":
        arch = [(-half, 0, 0), (-0.8 * half, -0.026, 0), (0.8 * half, -0.026, 0), (half, 0, 0)]
        mesh = tube(bent(arch, 0.02, steps=4), 0.005, 8)
    else:
        posts = np.array([(-0.75 * half, 0.0, 0.0), (0.75 * half, 0.0, 0.0)])
        bar = rods([(-half, -0.03, 0)], [(half, -0.03, 0)], 0.006)
        mesh = joined([bar, rods(posts, posts - np.array([0, 0.028, 0]), 0.0045, sides=6)])
    return placed(mesh, tilt=np.pi / 2 if upright else 0.0)


def handle(kind: str, at: tuple[float, float, float], length: float, *, upright: bool) -> Mesh:
    """A knob, cup, bow or bar on a front whose face is at ``at``, m."""
    return shifted(_grip(kind, length, upright), *at)


def add_fronts(thing: Thing, fronts: list[tuple[str, Span, Span]], y: float, made: Look) -> Thing:
    """Put doors and drawers on a carcass.

    Parameters
    ----------
    fronts : list of (kind, x, z)
        Kind is left or right (where the hinges are), drawer, flap, or glass-left and
        glass-right; x and z are the limits of the opening, m.
    y : float
        Front edge of the carcass, m; the fronts lie before it.
    made : Look
        How they are made.
    """
    panels, handles = [], []
    for kind, (x0, x1), (z0, z1) in fronts:
        x, z = (x0 + GAP / 2, x1 - GAP / 2), (z0 + GAP / 2, z1 - GAP / 2)
        shape = "glass" if "glass" in kind else made.panel
        panels.append(panel(shape, x, z, y - 0.001))
        face = y - {"slab": 0.019, "boards": 0.019, "raised": 0.019, "laths": 0.022}.get(
            shape, 0.021
        )
        handles += _handles(kind, x, z, face, made)
        if made.handle == "lip":
            panels.append(_lip(kind, x, z, face))
    thing.add(joined(panels), made.material, made.grain)
    if handles:
        thing.add(joined(handles), made.metal)
    return thing


def _handles(kind: str, x: Span, z: Span, y: float, made: Look) -> list[Mesh]:
    """Where hands reach: opposite the hinges of doors, in the middle of drawers."""
    if made.handle in ("none", "lip"):
        return []
    width, height = x[1] - x[0], z[1] - z[0]
    if kind in ("drawer", "flap"):
        if made.panel == "raised" and min(width, height) >= 0.09:
            y -= 0.007
        at = [(x[0] + x[1]) / 2]
        if width > 0.75 and made.handle in ("knob", "cup"):
            at = [x[0] + width / 4, x[1] - width / 4]
        level = (z[0] + z[1]) / 2 if kind == "drawer" else z[1] - 0.05
        if made.panel == "shaker" and kind == "drawer":
            y += 0.009 if min(width, height) > 0.05 else 0.0
        length = min(max(0.35 * width, 0.1), 0.4)
        return [handle(made.handle, (a, y, level), length, upright=False) for a in at]
    side = x[1] - 0.032 if kind.endswith("left") else x[0] + 0.032
    low = (z[0] + z[1]) / 2 < 0.75
    level = max(z[1] - 0.16, (z[0] + z[1]) / 2) if low else min(z[0] + 0.16, 1.05)
    if height > 1.2:
        level = min(max(z[0] + 0.1, 1.0), z[1] - 0.1)
    which = "bar" if made.handle == "cup" else made.handle
    return [handle(which, (side, y, level), min(0.16, 0.4 * height), upright=True)]


def _lip(kind: str, x: Span, z: Span, y: float) -> Mesh:
    """A folded edge to pull by, along the top of drawers and the free side of doors."""
    if kind in ("drawer", "flap"):
        return boards([(x[0] + 0.01, x[1] - 0.01, y - 0.014, y + 0.002, z[1] - 0.022, z[1] - 0.01)])
    side = x[1] - 0.022 if kind.endswith("left") else x[0] + 0.010
    return boards([(side, side + 0.012, y - 0.014, y + 0.002, z[0] + 0.01, z[1] - 0.01)])


def carcass(
    x: Span,
    y: Span,
    z: Span,
    thickness: float = 0.018,
    *,
    back: bool = True,
    lid: bool = True,
    overhang: float = 0.0,
) -> Mesh:
    """Sides, bottom, top and back of a cabinet, m.

    The top may stand out by ``overhang``; without a ``lid`` a basin can hang in it.
    """
    (x0, x1), (y0, y1), (z0, z1), t, e = x, y, z, thickness, 0.0006
    high = z1 - t + e if lid else z1
    rows = [
        (x0, x0 + t, y0, y1, z0, high),
        (x1 - t, x1, y0, y1, z0, high),
        (x0 + t - e, x1 - t + e, y0 + e, y1 - e, z0 + e, z0 + t),
    ]
    if lid:
        rows.append((x0 - overhang, x1 + overhang, y0 - overhang, y1 + e, z1 - t, z1))
    if back:
        rows.append((x0 + t - e, x1 - t + e, y1 - 0.006, y1 - 0.001, z0 + t - e, high))
    return boards(rows)


def footing(rng: np.random.Generator, x: Span, y: Span, height: float, old: bool) -> Mesh:
    """What a carcass stands on: a set-back plinth, square or turned feet, or splayed legs."""
    (x0, x1), (y0, y1) = x, y
    kind = int(rng.integers(3)) if height < 0.14 else 2
    centre, half = np.array([(x0 + x1) / 2, (y0 + y1) / 2, 0]), np.array([x1 - x0, y1 - y0]) / 2
    up = [0, 0, height + 0.001]
    if kind == 0:
        return boards([(x0 + 0.01, x1 - 0.01, y0 + 0.04, y1 - 0.005, 0, height + 0.001)], 0)
    if kind == 1 and old:
        r = 0.45 * height
        bun = [(0, 0), (0.6 * r, 0), (r, 0.4 * height), (0.8 * r, 0.8 * height),
               (0.5 * r, height), (0, height)]  # fmt: skip
        reach = half - r - 0.01
        return copies(revolve(np.array(bun) * [1, 1.005], 14), centre + corners(*reach))
    feet = centre + corners(*(half - 0.035))
    if kind == 1:
        return beams(feet, feet + up, 0.05, 0.05, taper=0.8)
    spread = centre + corners(*(half - 0.02))
    heads = centre + corners(*(half - 0.06)) + up
    return rods(spread, heads, 0.018, taper=0.6, sides=10)


def turned_leg(rng: np.random.Generator, height: float, radius: float) -> Mesh:
    """A leg from the lathe: foot, taper, rings and a square block at the top; stands on z = 0."""
    belly = float(rng.uniform(0.3, 0.6))
    rows = rounded([(0.55, 0.0), (0.66, 0.04), (0.4, 0.06), (0.45, 0.1),
                    (0.66 + 0.3 * rng.uniform(), belly), (0.85, 0.74), (0.45, 0.77), (1.1, 0.795),
                    (0.5, 0.83), (0.6, 0.86)], 1)  # fmt: skip
    rows = np.concatenate([[(0, 0)], rows, [(0, 0.86)]])
    post = boards([(-radius, radius, -radius, radius, 0.85 * height, height)], 0.003)
    return joined([revolve(rows * [radius, height], 12), post])


def tap(rng: np.random.Generator, reach: float, height: float) -> Mesh:
    """A mixer tap standing on z = 0 that pours towards -y."""
    if rng.uniform() < 0.5:
        line = [(0, 0, 0), (0, 0, height), (0, -reach, height), (0, -reach, 0.62 * height)]
        spout = tube(bent(line, 0.5 * reach, steps=7), 0.011, 10)
    else:
        line = [(0, 0, 0), (0, 0, 0.8 * height), (0, -0.2 * reach, height), (0, -reach, height)]
        mouth = rods([(0, -reach, height + 0.005)], [(0, -reach, height - 0.03)], 0.011, sides=10)
        spout = joined([tube(bent(line, 0.03), 0.014, 10), mouth])
    base = revolve(
        [(0, 0), (0.026, 0), (0.026, 0.006), (0.02, 0.012), (0.02, 0.07), (0, 0.075)], 16
    )
    side = float(rng.choice([-1, 1]))
    lever = rods([(0, 0, 0.05)], [(0.075 * side, -0.015, 0.085)], 0.0055)
    return joined([spout, base, lever])
