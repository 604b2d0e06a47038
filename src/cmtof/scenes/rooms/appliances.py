"""What cooks, washes and cools: hob, oven, machines, hood, fridge, m."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.cabinetry import (
    BLACK,
    CHROME,
    GLOSSY_BLACK,
    STEEL,
    WHITE,
    Look,
    Span,
    add_fronts,
    handle,
)  # fmt: skip
from cmtof.scenes.rooms.joinery import (
    boards,
    copies,
    corners,
    faceted_rings,
    placed,
    raised,
    rods,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style, hue
from cmtof.scenes.rooms.solids import joined, revolve
from cmtof.scenes.rooms.thing import Mesh, Support, Thing
from cmtof.scenes.rooms.upholstery import loft, pad


def hob(thing: Thing, rng: np.random.Generator, x: float, top: float) -> None:
    """Four places to cook: rings on glass, or gas burners under cast grates."""
    place = corners(0.14, 0.12, top + 0.006) + np.array([x, 0.0, 0.0])
    steel = rng.uniform() < 0.5
    thing.add(loft(0.575, 0.5, 0.012, [(0.25, 0), (0, 0), (0, 0.004), (0.003, 0.006), (0.25,
        0.006)],
                   (x, 0, top + 0.0005)), STEEL if steel else GLOSSY_BLACK)  # fmt: skip
    if not steel:
        radii = np.array([0.09, 0.07, 0.105, 0.07])
        grey = Material((0.12, 0.12, 0.12), specular=0.1, gloss=200.0)
        rings = [placed(revolve([(r, 0), (r, 0.0012), (r - 0.004, 0.0012), (r - 0.004, 0)], 32), p)
                 for r, p in zip(radii, place, strict=True)]  # fmt: skip
        thing.add(joined(rings), grey)
        return
    burner = revolve(
        [(0, 0), (0.045, 0), (0.045, 0.01), (0.03, 0.012), (0.03, 0.018), (0, 0.019)], 18
    )
    bars = [(x + s * 0.14 - 0.125, x + s * 0.14 + 0.125, y - 0.005, y + 0.005, top + 0.03,
        top + 0.042)
            for s in (-1, 1) for y in (-0.22, -0.12, 0.12, 0.22)]  # fmt: skip
    bars += [(x + e - 0.005, x + e + 0.005, -0.22, 0.22, top + 0.0295, top + 0.0415)
             for e in (-0.265, -0.14, -0.016, 0.016, 0.14, 0.265)]  # fmt: skip
    feet = [(x + e - 0.005, x + e + 0.005, y - 0.005, y + 0.005, top + 0.006, top + 0.035)
            for e in (-0.265, -0.016, 0.016, 0.265) for y in (-0.22, 0.22)]  # fmt: skip
    thing.add(joined([copies(burner, place), boards([*bars, *feet])]), BLACK)


def _knobs(x: np.ndarray, y: float, z: float) -> Mesh:
    """Round switches on a front whose face is at y."""
    knob = revolve(
        [(0, 0), (0.021, 0), (0.021, 0.006), (0.017, 0.008), (0.015, 0.026), (0, 0.027)], 16
    )
    knob = placed(knob, lean=np.pi / 2)
    return copies(knob, np.stack([x, np.full_like(x, y), np.full_like(x, z)], -1))


def oven(
    thing: Thing, rng: np.random.Generator, x: float, w: float, y: float, z: Span, made: Look
) -> None:
    """An oven under the hob: panel with switches, glass door with a bar, drawer below."""
    body = STEEL if rng.uniform() < 0.6 else (GLOSSY_BLACK if rng.uniform() < 0.5 else WHITE)
    half, high = w / 2 - 0.002, min(0.595, z[1] - z[0])
    low = z[1] - high
    rows = [(x - half, x + half, y - 0.02, y - 0.001, z[1] - 0.11, z[1]),
            (x - half, x + half, y - 0.022, y - 0.001, low + 0.002, z[1] - 0.113)]  # fmt: skip
    thing.add(boards(rows, 0.003), body)
    glass = [(x - half + 0.07, x + half - 0.07, y - 0.0235, y - 0.01, low + 0.07, z[1] - 0.19),
             (x - 0.05, x + 0.05, y - 0.0215, y - 0.01, z[1] - 0.075, z[1] - 0.035)]  # fmt: skip
    thing.add(boards(glass), GLOSSY_BLACK)
    bar = handle("bar", (x, y - 0.022, z[1] - 0.145), 2 * half - 0.08, upright=False)
    at = x + np.array([-0.22, -0.14, 0.14, 0.22])
    thing.add(joined([bar, _knobs(at, y - 0.02, z[1] - 0.055)]), CHROME if body is STEEL else STEEL)
    if low - z[0] > 0.06:
        add_fronts(thing, [("drawer", (x - w / 2, x + w / 2), (z[0], low))], y, made)


def machine(thing: Thing, rng: np.random.Generator, x: float, y: float, z: Span) -> None:
    """A dishwasher or a washing machine that stands free under the worktop."""
    body = WHITE if rng.uniform() < 0.6 else STEEL
    rows = [(x - 0.296, x + 0.296, y - 0.02, y + 0.05, z[0] - 0.05, z[1] - 0.122),
            (x - 0.296, x + 0.296, y - 0.02, y + 0.05, z[1] - 0.12, z[1] - 0.004)]  # fmt: skip
    thing.add(boards(rows, 0.004), body)
    if rng.uniform() < 0.5:
        thing.add(handle("bar", (x, y - 0.02, z[1] - 0.17), 0.4, upright=False), STEEL)
        return
    ring = revolve(
        [(0.13, 0), (0.185, 0), (0.185, 0.012), (0.165, 0.026), (0.14, 0.02), (0.13, 0.0)], 36
    )
    bowl = revolve([(0.139, 0.016), (0.10, 0.022), (0.05, 0.034), (0, 0.038)], 36)
    at = (x, y - 0.021, (z[0] + z[1]) / 2 - 0.06)
    thing.add(placed(ring, at, lean=np.pi / 2), CHROME)
    thing.add(placed(bowl, at, lean=np.pi / 2), GLOSSY_BLACK)
    thing.add(_knobs(np.array([x + 0.1]), y - 0.02, z[1] - 0.06), STEEL)
    drawer = boards([(x - 0.27, x - 0.09, y - 0.024, y - 0.01, z[1] - 0.105, z[1] - 0.02)], 0.003)
    thing.add(drawer, body)


def fridge(rng: np.random.Generator, style: Style) -> Thing:
    """A refrigerator: freezer below or above, two doors side by side, small, or retro."""
    kind = str(rng.choice(["combi", "top", "double", "small", "retro"]))
    w = float(rng.uniform(0.88, 0.92)) if kind == "double" else float(rng.uniform(0.54, 0.62))
    h = {"small": 0.85, "retro": 1.5, "top": 1.6}.get(kind, 1.85) * float(rng.uniform(0.97, 1.08))
    d = float(rng.uniform(0.58, 0.66))
    body = style.accent if kind == "retro" else (WHITE, STEEL, GLOSSY_BLACK)[int(rng.integers(3))]
    round_one = 0.06 if kind == "retro" else 0.008
    thing, x, front = Thing("fridge"), w / 2, -d / 2 + 0.07
    rows = [(min(w, d - 0.075) / 2, 0.02), (0, 0.02), (0, h - round_one), (0.3 * round_one,
        h - 0.3 * round_one),
            (round_one, h), (min(w, d - 0.075) / 2, h)]  # fmt: skip
    thing.add(loft(w, d - 0.075, 0.02, rows, (0, 0.0375, 0)), body)
    feet = corners(x - 0.06, d / 2 - 0.1) + np.array([0, 0.03, 0])
    thing.add(rods(feet, raised(feet, 0.03), 0.02, sides=10), BLACK)
    split = {"combi": [0.38], "top": [0.72], "retro": [0.0]}.get(kind, [])
    cuts = [0.03, *[0.03 + s * (h - 0.04) for s in split if s > 0], h - 0.01]
    doors, pulls = [], []
    hinge = float(rng.choice([-1, 1]))
    for a, b in pairwise(cuts):
        sides = [(-x, -0.002), (0.002, x)] if kind == "double" else [(-x, x)]
        for x0, x1 in sides:
            door = pad((x1 - x0, b - a - 0.006, 0.066), radius=max(round_one, 0.012),
                       edge=min(round_one, 0.03), crown=0.2 * round_one, side=2)  # fmt: skip
            doors.append(placed(door, ((x0 + x1) / 2, front, (a + b) / 2), lean=np.pi / 2))
            free = -hinge * x if kind != "double" else 0.0
            sx = free + hinge * 0.05 if kind != "double" else (x0 if x0 > 0 else x1) * 1.0
            sx += 0.04 * np.sign(x0 + x1) if kind == "double" else 0.0
            level = (a + 0.72 * (b - a)) if b > 0.9 and a < 0.8 else (a + b) / 2
            length = min(0.5 * (b - a), 0.5)
            crown = 0.2 * round_one
            style_of = "bow" if kind == "retro" else "bar"
            pulls.append(
                handle(style_of, (sx, front - 0.0645 - crown, level), length, upright=True)
            )
    thing.add(joined(doors), body).add(joined(pulls), CHROME if body is not STEEL else STEEL)
    _notes(thing, rng, x, front - 0.0665 - 0.2 * round_one, h)
    thing.supports.append(Support(-0.35 * w, 0.35 * w, -0.1, 0.2, h, 0.4))
    return thing


def _notes(thing: Thing, rng: np.random.Generator, x: float, y: float, h: float) -> None:
    """Slips of paper and magnets on a door."""
    count = int(rng.integers(0, 6))
    for _ in range(count):
        w, t = float(rng.uniform(0.05, 0.12)), float(rng.uniform(0.05, 0.15))
        cx, cz = float(rng.uniform(-0.4, 0.4)) * x, float(rng.uniform(0.68, 0.9)) * h
        tone = hue(float(rng.uniform()), float(rng.choice([0.05, 0.5])), 0.75)
        pattern = "marks" if rng.uniform() < 0.6 else "picture"
        paper = Material(tone, (0.05, 0.05, 0.08), pattern, float(rng.uniform(0.006, 0.02)), 0.0)
        slip = boards([(cx - w / 2, cx + w / 2, y - 0.001, y + 0.001, cz - t, cz)], 0)
        thing.add(slip, paper)
        pin = revolve([(0, 0), (0.009, 0), (0.009, 0.006), (0, 0.007)], 12)
        pin = placed(pin, (cx, y - 0.0008, cz - 0.012), lean=np.pi / 2)
        thing.add(pin, Material(hue(float(rng.uniform()), 0.8, 0.4), specular=0.08))


def range_hood(rng: np.random.Generator, style: Style) -> Thing:
    """Over the hob: a pyramid with a chimney, a T of steel, a slanted plate or a visor."""
    kind, w = int(rng.integers(4)), float(rng.choice([0.6, 0.6, 0.9]))
    body = STEEL if rng.uniform() < 0.6 else (BLACK if rng.uniform() < 0.5 else WHITE)
    thing = Thing("range hood")
    if kind == 3:
        rows = [(-w / 2, w / 2, -0.5, 0, -0.06, 0.06)]
        thing.add(boards(rows, 0.006), body)
        thing.add(boards([(-w / 2 + 0.01, w / 2 - 0.01, -0.512, -0.499, -0.055, -0.02)]), CHROME)
        grid = [(-w / 2 + 0.06, w / 2 - 0.06, q, q + 0.012, -0.063, -0.058)
                for q in np.arange(-0.42, -0.08, 0.03)]  # fmt: skip
        thing.add(boards(grid, 0), STEEL)
        return thing
    shaft = (-0.14, 0.14, -0.27, 0, -0.1, 0.42)
    thing.add(boards([shaft, (-0.137, 0.137, -0.267, -0.001, 0.42, 0.5)], 0.002), body)
    if kind == 0:
        base, top = np.array([w, 0.5]), np.array([0.30, 0.29])
        rings = [(base, -0.42), (base, -0.36), (base, -0.36), (top, -0.09)]
        grid = [np.column_stack([corners(*(s / 2))[:, :2] - [0, s[1] / 2], np.full(4, z)])
                for s, z in rings]  # fmt: skip
        thing.add(faceted_rings(grid), body)
    elif kind == 1:
        thing.add(boards([(-w / 2, w / 2, -0.5, 0, -0.17, -0.1)], 0.003), body)
    else:
        plate = boards([(-w / 2, w / 2, -0.02, 0.02, 0, 0.55)], 0.004)
        thing.add(placed(plate, (0, -0.46, -0.46), lean=-0.75), GLOSSY_BLACK)
        thing.add(boards([(-0.2, 0.2, -0.3, 0, -0.28, -0.098)], 0.003), body)
    return thing
