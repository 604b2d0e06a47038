"""Chairs at a table: seven designs on one set of proportions, m."""

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cmtof.scenes.rooms.cabinetry import BLACK, CHROME, timber
from cmtof.scenes.rooms.joinery import (
    Points,
    beams,
    bent,
    boards,
    corners,
    mirrored,
    plank,
    raised,
    rods,
    shifted,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style, hue
from cmtof.scenes.rooms.solids import joined, tube
from cmtof.scenes.rooms.thing import Mesh, Support, Thing
from cmtof.scenes.rooms.upholstery import cloth, loft, pad


class Build(NamedTuple):
    """Proportions of one chair, m."""

    width: float
    depth: float
    seat: float
    """Height of the seat."""
    back: float
    """Height of the back's top."""
    rake: float
    """How far the back's top leans behind its foot."""


def build(rng: np.random.Generator) -> Build:
    """Draw the proportions of a chair."""
    return Build(
        width=float(rng.uniform(0.42, 0.50)),
        depth=float(rng.uniform(0.40, 0.46)),
        seat=float(rng.uniform(0.44, 0.475)),
        back=float(rng.uniform(0.80, 1.05)),
        rake=float(rng.uniform(0.05, 0.12)),
    )


def seat_board(b: Build, thickness: float = 0.022, dish: float = 0.008) -> Mesh:
    """A wooden seat, wider in front, with a rounded edge and hollowed where one sits."""
    t = thickness
    rows = [(b.depth / 2, -t), (0.008, -t), (0.0, -t + 0.008), (0.0, -0.006), (0.004, -0.001),
            (0.012, 0.0), (0.09, -0.5 * dish), (0.15, -dish), (b.depth / 2, -dish)]  # fmt: skip
    return flared(loft(b.width, b.depth, 0.05, rows, (0, 0, b.seat), side=2), b)


def flared(mesh: Mesh, b: Build) -> Mesh:
    """The same seat, a tenth narrower at the back."""
    v = mesh.vertices.copy()
    v[:, 0] *= 1 - 0.10 * (v[:, 1] / b.depth + 0.5)
    return Mesh(v, mesh.faces)


def back_line(b: Build, z: Points) -> Points:
    """Depth coordinate of the back posts at heights z: upright below the seat, raked above."""
    up = np.clip((z - b.seat) / (b.back - b.seat), 0, 1)
    return b.depth / 2 - 0.02 + b.rake * up**1.3


def back_posts(b: Build, size: float) -> Mesh:
    """Two posts from the floor to the top of the back, splayed backwards at both ends."""
    z = np.concatenate([[0.0], np.linspace(0.5 * b.seat, b.back, 8)])
    y = back_line(b, z)
    y[0] += 0.04
    x = np.full_like(z, 0.45 * b.width - size / 2)
    post = plank(np.stack([x, y, z], -1), (size, 0, 0), 1.15 * size)
    post.vertices[:, 2] = np.maximum(post.vertices[:, 2], 0.0)
    return joined([post, mirrored(post)])


def front_legs(b: Build, size: float, round_leg: bool) -> Mesh:
    """Two front legs up to the seat."""
    top = corners(b.width / 2 - size, b.depth / 2 - size)[:2]
    if round_leg:
        return rods(top, raised(top, b.seat - 0.01), size / 2, taper=0.7, sides=10)
    return beams(top, raised(top, b.seat - 0.01), size, size, taper=0.75, chamfer=0.003)


def rails(b: Build, size: float) -> Mesh:
    """Apron under the seat, and stretchers between the legs."""
    x, y, z = b.width / 2 - size, b.depth / 2 - size, b.seat - 0.05
    across = [(-x, -y, z), (-0.9 * x, y, z), (-0.96 * x, 0, 0.17)]
    to = [(x, -y, z), (0.9 * x, y, z), (0.96 * x, 0, 0.17)]
    side = [(s * x, -y, h) for s in (-1, 1) for h in (z + 0.001, 0.172)]
    back = [(0.92 * s * x, y, h) for s in (-1, 1) for h in (z + 0.001, 0.172)]
    return joined(
        [
            beams(across[:2], to[:2], 0.02, 0.06),
            beams(across[2:], to[2:], 0.018, 0.022),
            beams(side, back, 0.02, 0.024),
        ]
    )


def curved_slat(b: Build, z: float, height: float, half: float, bow: float = 0.03) -> Mesh:
    """A level slat between the back posts, bowed backwards."""
    x = np.linspace(-half, half, 9)
    y = back_line(b, np.full(9, z)) + bow * (1 - (x / half) ** 2)
    lean = b.rake / (b.back - b.seat)
    return plank(np.stack([x, y, np.full(9, z)], -1), (0, lean * height, height), 0.014)


def wooden(rng: np.random.Generator, style: Style, b: Build, design: str) -> Thing:
    """Slats upright (slat), level (ladder) or one broad padded rest (padded)."""
    size, material = float(rng.uniform(0.03, 0.04)), timber(rng, style)
    thing = Thing("chair")
    thing.add(joined([back_posts(b, size), front_legs(b, size, rng.uniform() < 0.4)]), material, 2)
    thing.add(rails(b, size), material)
    half = 0.45 * b.width - size
    span = b.back - b.seat
    if design == "ladder":
        count = int(rng.integers(2, 6))
        level = b.seat + span * np.linspace(0.28, 0.93, count)
        high = min(0.075, 0.5 * span / count)
        thing.add(joined([curved_slat(b, float(z), high, half) for z in level]), material)
    elif design == "slat":
        count, width = int(rng.integers(3, 8)), float(rng.uniform(0.018, 0.045))
        low, top = b.seat + 0.1 * span, b.seat + 0.94 * span
        ends = [curved_slat(b, low, 0.04, half, 0.0), curved_slat(b, top, 0.07, half, 0.0)]
        x = np.linspace(-0.72, 0.72, count) * half
        y0, y1 = back_line(b, np.array([low, top]))
        starts, stops = np.full((count, 3), (0, y0, low)), np.full((count, 3), (0, y1, top))
        starts[:, 0] = stops[:, 0] = x
        thing.add(joined(ends), material)
        thing.add(beams(starts, stops, min(width, 1.2 * half / count), 0.011), material, 2)
    else:
        low = b.seat + 0.45 * span
        rest = pad((2 * half + 0.01, 0.5 * span, 0.04), radius=0.03, edge=0.015, crown=0.012)
        thing.add(_leaning(rest, b, low + 0.25 * span), style.leather)
    if design == "padded" or rng.uniform() < 0.3:
        cover = style.fabric if design != "padded" else style.leather
        cushion = pad((b.width, b.depth, 0.05), (0, 0, b.seat - 0.028), radius=0.05)
        thing.add(flared(cushion, b), cover)
        level = b.seat + 0.029
    else:
        thing.add(seat_board(b), material, 1)
        level = b.seat - 0.004
    return sat_on(thing, b, level)


def sat_on(thing: Thing, b: Build, level: float) -> Thing:
    """Let the middle of a seat at that height, m, carry things."""
    x, y = 0.3 * b.width, 0.28 * b.depth
    thing.supports.append(Support(-x, x, -y, y, level, clearance=0.8))
    return thing


def _leaning(rest: Mesh, b: Build, z: float) -> Mesh:
    """A pad made lying, stood up before the back posts with its top face forwards."""
    v, slope = rest.vertices.astype(float), b.rake / (b.back - b.seat)
    up = v[:, 1] + z
    y = back_line(b, up) - v[:, 2] + 0.012
    return Mesh(np.stack([v[:, 0], y - 0 * slope, up], -1).astype(np.float32), rest.faces)


def spindle(rng: np.random.Generator, style: Style, b: Build) -> Thing:
    """A Windsor chair: dished seat, splayed legs, a bent hoop with sticks in it."""
    material = timber(rng, style)
    seat = seat_board(b, 0.035, 0.012)
    x, y = b.width / 2, b.depth / 2
    feet, heads = corners(x - 0.01, y + 0.01), corners(x - 0.08, y - 0.07, b.seat - 0.02)
    legs = rods(feet, heads, 0.018, taper=0.65, sides=10)
    middle = 0.45 * feet + 0.55 * heads
    side = rods(middle[[0, 1]], middle[[3, 2]], 0.009)
    bar = rods([(middle[0] + middle[3]) / 2], [(middle[1] + middle[2]) / 2], 0.009)
    count = int(rng.integers(6, 10))
    turn = np.linspace(0.0, np.pi, 19)
    half, span = 0.44 * b.width, b.back - b.seat

    def hoop(angle: Points) -> Points:
        height = np.sin(angle) ** 0.55
        return np.stack([half * np.cos(angle), y - 0.05 + b.rake * height,
                         b.seat - 0.02 + span * height], -1)  # fmt: skip

    heads = hoop(np.linspace(0.17, 0.83, count) * np.pi)
    foot = heads * [0.72, 0, 0] + [0, y - 0.06, b.seat - 0.02]
    sticks = rods(foot, heads, 0.006, taper=1.25, sides=7)
    thing = Thing("chair").add(seat, material, 1)
    thing.add(joined([legs, sticks, tube(hoop(turn), 0.011, 8)]), material, 2)
    return thing.add(joined([side, bar]), material)


def shell_grid(b: Build, arms: bool) -> Points:
    """Surface of a moulded shell, (across, along, 3), from the front edge up the back."""
    v = np.array([0, 0.06, 0.18, 0.32, 0.44, 0.52, 0.58, 0.66, 0.78, 0.9, 1.0])
    front, back, top = -b.depth / 2, b.depth / 2 - 0.03, min(b.back, b.seat + 0.42)
    y = np.interp(v, [0, 0.06, 0.5, 0.58, 0.66, 1], [front, front + 0.04, back - 0.06, back, back
                  + 0.03, back + 0.05 + b.rake])  # fmt: skip
    z = np.interp(v, [0, 0.06, 0.5, 0.58, 0.66, 1], [b.seat - 0.035, b.seat, b.seat - 0.012,
                  b.seat + 0.012, b.seat + 0.08, top])  # fmt: skip
    u = np.linspace(-1, 1, 13)[:, None]
    half = b.width / 2 * np.interp(v, [0, 0.1, 0.55, 0.8, 1], [0.86, 0.98, 1.0, 0.95, 0.72])
    rise = (0.16 if arms else 0.03) * np.interp(v, [0, 0.2, 0.5, 0.65, 1], [0, 0.5, 1, 0.5, 0.1])
    wrap = np.interp(v, [0, 0.5, 0.7, 1], [0, 0.0, 0.08, 0.05])
    lift = np.abs(u) ** 3
    return np.stack([u * half * (1 - 0.05 * lift), y - wrap * lift, z + rise * lift], -1)


def moulded(rng: np.random.Generator, style: Style, b: Build) -> Thing:
    """A one-piece shell of plastic or plywood on wooden, wire or tube legs."""
    grid = shell_grid(b, arms=bool(rng.uniform() < 0.4))
    colours = (style.accent, Material((0.8, 0.8, 0.78), specular=0.05, gloss=40.0), BLACK,
               style.wood, Material(hue(float(rng.uniform()), 0.4, 0.35),
                   specular=0.05))  # fmt: skip
    thing = Thing("chair").add(cloth(grid, 0.008), colours[int(rng.integers(len(colours)))], 1)
    x, y = b.width / 2 - 0.03, b.depth / 2 - 0.03
    heads = corners(0.55 * x, 0.55 * y, b.seat - 0.03)
    ring = rods(heads, np.roll(heads, -1, 0), 0.007, sides=6)
    if rng.uniform() < 0.5:
        thing.add(rods(corners(x, y), heads, 0.017, taper=0.6, sides=10), style.second_wood, 2)
        return thing.add(ring, BLACK)
    feet = corners(x, y)
    braces = rods(0.6 * feet + 0.4 * heads, np.roll(heads, -1, 0), 0.004, sides=6)
    return thing.add(joined([rods(feet, heads, 0.008, sides=8), ring, braces]), style.metal)


def cantilever(rng: np.random.Generator, style: Style, b: Build) -> Thing:
    """A steel tube bent into a sled and a back, with leather or cane stretched on it."""
    r, x = 0.0115, b.width / 2 - 0.012
    front, back, top = -b.depth / 2, b.depth / 2 - 0.02, min(b.back, 0.85)
    line = [(0, back + b.rake, top), (0, back, b.seat), (0, front, b.seat), (0, front + 0.03, r),
            (0, back + 0.06, r)]  # fmt: skip
    side = bent(line, 0.07)
    left, right = side - np.array([x, 0, 0]), side[::-1] + np.array([x, 0, 0])
    loop = np.concatenate([left[:-1], bent([left[-1], left[-1] + [0, 0.03, 0],
           right[0] + [0, 0.03, 0], right[0]], 0.05), right[1:]])  # fmt: skip
    cover = style.leather if rng.uniform() < 0.6 else style.second_wood
    w = 2 * x + 0.004
    seat = plank([(0, front + 0.03, b.seat), (0, 0, b.seat - 0.006), (0, back - 0.05, b.seat)],
                 (w, 0, 0), 0.028)  # fmt: skip
    rise = np.linspace(0.42, 0.98, 6)
    lean = np.stack([0 * rise, back + b.rake * rise, b.seat + (top - b.seat) * rise], -1)
    rest = plank(lean, (w, 0, 0), 0.028)
    return Thing("chair").add(tube(loop, r, 8), CHROME).add(joined([seat, rest]), cover, 1)


def folding(rng: np.random.Generator, style: Style, b: Build) -> Thing:
    """Crossed frames of wood or flat steel with slats to sit on and lean against."""
    x, y, top = 0.44 * b.width, b.depth / 2, min(b.back, 0.84)
    wooden_one = rng.uniform() < 0.6
    material = timber(rng, style) if wooden_one else style.metal
    w, t = (0.02, 0.035) if wooden_one else (0.012, 0.028)
    long = beams([(s * x, -y, 0) for s in (-1, 1)], [(s * x, y, top) for s in (-1, 1)], w, t)
    inner = x - w - 0.003
    head = (-y + 0.06, b.seat - 0.03)
    short = beams([(s * inner, y, 0) for s in (-1, 1)], [(s * inner, *head) for s in (-1, 1)], w, t)
    bars = rods([(-x, -0.8 * y, 0.08), (-inner, 0.85 * y, 0.07)], [(x, -0.8 * y, 0.08),
                (inner, 0.85 * y, 0.07)], 0.009)  # fmt: skip
    thing = Thing("chair").add(joined([long, short, bars]), material, 2)
    count = int(rng.integers(5, 8))
    at = np.linspace(-y, y - 0.04, count + 1)
    reach = b.width / 2
    slats = [(-reach, reach, p + 0.005, q - 0.005, b.seat - 0.018, b.seat)
             for p, q in pairwise(at)]  # fmt: skip
    under = [(s * (x - 0.008), s * (x - 0.008) + 0.016, -y + 0.01, y - 0.05, b.seat - 0.045,
              b.seat - 0.017) for s in (-1, 1)]  # fmt: skip
    flat = Build(b.width, b.depth, 0.0, top, 2 * y)
    rest = [curved_slat(flat._replace(seat=b.seat), z, 0.05, x, 0.02)
            for z in (top - 0.04, top - 0.13)]  # fmt: skip
    shift = [shifted(m, 0, _on_line(m, y, top), 0) for m in rest]
    return thing.add(joined([boards(slats, 0.003), boards(under), *shift]), material)


def _on_line(mesh: Mesh, y: float, top: float) -> float:
    """Shift that brings a slat onto the long legs of a folding chair."""
    middle = mesh.vertices.mean(0)
    return float(-y + 2 * y * middle[2] / top - middle[1] - 0.012)


Design = Callable[[np.random.Generator, Style, Build], Thing]
DESIGNS: dict[str, Design] = {
    "slat": lambda rng, style, b: wooden(rng, style, b, "slat"),
    "ladder": lambda rng, style, b: wooden(rng, style, b, "ladder"),
    "padded": lambda rng, style, b: wooden(rng, style, b, "padded"),
    "spindle": spindle,
    "moulded": moulded,
    "cantilever": cantilever,
    "folding": folding,
}


def dining_chair(rng: np.random.Generator, style: Style, *, design: str | None = None) -> Thing:
    """A chair at a table; ``design`` is one of `DESIGNS`, None draws it."""
    b = build(rng)
    design = str(rng.choice(list(DESIGNS))) if design is None else design
    thing = DESIGNS[design](rng, style, b)
    if not thing.supports and design != "folding":  # small things fall between its slats
        sat_on(thing, b, b.seat)
    return thing
