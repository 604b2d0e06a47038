"""Makers of furniture: each fills a box of a size (width, depth, height), m, from its options.

A thing stands on z = 0 about the origin, its front towards -y. Every maker takes a `Kit`, the size,
and options that `presets.yml` names.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh

from cmtof_rooms.engine import Part
from cmtof_rooms.materials import Material
from cmtof_rooms.solids import (
    ball,
    box,
    extrusion,
    joined,
    moved,
    revolution,
    sheet,
    slab,
    sweep,
)

Size = Sequence[float]
Extent = tuple[float, float, float, float, float, float]
"""A box: x0, x1, y0, y1, z0, z1, m."""


@dataclass(frozen=True)
class Kit:
    """Random numbers and the materials of a household.

    Attributes
    ----------
    rng : Generator
    palette : dict
        Materials to choose from, by role: wood, fabric, metal, ...
    profiles : dict
        Outlines of vessels, by name: share of the radius and of the height, from the foot on.
    """

    rng: np.random.Generator
    palette: dict[str, list[Material]]
    profiles: dict[str, list[tuple[float, float]]]

    def material(self, *roles: str) -> Material:
        """One of the household's materials of a role, or of one of several."""
        role = roles[0] if len(roles) == 1 else str(self.rng.choice(roles))
        several = self.palette[role]
        return several[int(self.rng.integers(len(several)))]

    def between(self, low: float, high: float) -> float:
        """Number drawn evenly."""
        return float(self.rng.uniform(low, high))

    def count(self, pair: Sequence[int]) -> int:
        """Whole number drawn evenly from the lowest to the highest."""
        return int(self.rng.integers(pair[0], pair[1] + 1))

    def chance(self, share: float) -> bool:
        """Whether something happens that does so in a share of cases."""
        return bool(self.rng.uniform() < share)


class Top(NamedTuple):
    """A level rectangle on which things can stand, m."""

    x0: float
    x1: float
    y0: float
    y1: float
    z: float
    room: float = 1.0
    """Free height above it, m."""


@dataclass
class Made:
    """What a maker returns: parts, places for other things, and where light comes from."""

    parts: list[Part] = field(default_factory=list)
    tops: list[Top] = field(default_factory=list)
    glow: tuple[float, float, float, float] | None = None
    """Of a lamp: height of its light, half width, direction (1 up, -1 down, 0 all), power."""

    def add(self, material: Material, *solids: Trimesh | Extent) -> "Made":
        """Add solids of one material; six numbers are a box."""
        self.parts.append(
            Part(joined(s if isinstance(s, Trimesh) else slab(*s) for s in solids), material)
        )
        return self


def posts(x: float, y: float, thick: float, z0: float, z1: float) -> list[Extent]:
    """Four upright bars about (±x, ±y)."""
    half = thick / 2
    centres = [(i * x, j * y) for i in (-1, 1) for j in (-1, 1)]
    return [(a - half, a + half, b - half, b + half, z0, z1) for a, b in centres]


def disc(w: float, d: float, sections: int = 32) -> NDArray[np.float64]:
    """Outline (N, 2) of an ellipse."""
    turn = 2 * np.pi * np.arange(sections) / sections
    return np.stack([w / 2 * np.cos(turn), d / 2 * np.sin(turn)], 1)


def table(
    kit: Kit, size: Size, *, legs: str = "four", round_top: float = 0.0, material: str = "wood"
) -> Made:
    """A top on four legs, two panels, or a pedestal; ``round_top`` is the share of round ones."""
    w, d, h = size
    made, thick = Made(), min(kit.between(0.02, 0.05), h / 4)
    wood, below, a, b = kit.material(material), h - thick, w / 2, d / 2
    if kit.chance(round_top):
        made.add(wood, moved(extrusion(disc(w, d), thick), (0, 0, below)))
        legs, a, b = "pedestal", 0.35 * w, 0.35 * d
    else:
        made.add(wood, (-a, a, -b, b, below, h))
    if legs == "pedestal":
        foot = 0.3 * min(w, d)
        profile = [(foot, 0), (foot, 0.03), (0.05, 0.06), (0.04, below)]
        made.add(kit.material("metal"), revolution(profile))
    elif legs == "panel":
        y, ends = 0.95 * b, (0.06 - a, a - 0.06)
        made.add(wood, *[(x - 0.02, x + 0.02, -y, y, 0, below) for x in ends])
    else:
        thin = min(kit.between(0.03, 0.07), w / 6, d / 6)
        x, y = a - thin, b - thin
        made.add(wood, *posts(x, y, thin, 0, below))
        if h > 0.5:
            made.add(wood, *[(-x, x, s - 0.01, s + 0.01, below - 0.11, below) for s in (-y, y)])
    made.tops.append(Top(-a * 0.9, a * 0.9, -b * 0.9, b * 0.9, h, 1.2))
    return made


def seat(kit: Kit, size: Size, *, style: str = "chair") -> Made:
    """A chair or stool on legs, or an upholstered bench, armchair, sofa."""
    if style in ("chair", "stool"):
        return _chair(kit, size, back=style == "chair")
    w, d, h = size
    a, b, cover, made = w / 2, d / 2, kit.material("fabric"), Made()
    arm = kit.between(0.12, 0.2) if style in ("sofa", "armchair") else 0.0
    level, back = min(0.42, 0.9 * h), kit.between(0.16, 0.24) if h > 0.5 else 0.0
    made.add(cover, (-a, a, -b, b, 0.08, level - 0.12))
    made.add(kit.material("wood"), *posts(a - 0.06, b - 0.06, 0.06, 0, 0.08))
    if arm:
        top = min(kit.between(0.55, 0.65), h)
        made.add(cover, *[(x, x + arm, -b, b, 0.08, top) for x in (-a, a - arm)])
    wide = w - 2 * arm
    count = max(1, round(wide / 0.75))
    each, deep = wide / count, d - back
    middles = -wide / 2 + each * (np.arange(count) + 0.5)
    cushion = ball((each / 2, deep / 2, 0.09), squareness=0.75)
    made.add(cover, *[moved(cushion, (x, -back / 2, level - 0.05)) for x in middles])
    if back:
        made.add(cover, (-wide / 2, wide / 2, b - 0.08, b, level - 0.12, h))
        tall, y = (h - level) / 2, b - back / 2 - 0.03
        cushion = ball((each / 2, back / 2, tall), squareness=0.7)
        made.add(cover, *[moved(cushion, (x, y, level + 0.9 * tall)) for x in middles])
    return made


def _chair(kit: Kit, size: Size, *, back: bool) -> Made:
    """Seat, four legs and, of a chair, two posts with a board."""
    w, d, h = size
    level = min(0.46, 0.55 * h) if back else h
    wood, made, thin = kit.material("wood", "metal"), Made(), 0.035
    x, y = (w - thin) / 2, (d - thin) / 2
    made.add(kit.material("fabric"), (-w / 2, w / 2, -d / 2, d / 2, level - 0.04, level))
    made.add(wood, *posts(x, y, thin, 0, level - 0.04))
    if back:
        low = level + 0.5 * (h - level) if kit.chance(0.5) else level + 0.08
        made.add(wood, *posts(x, y, thin, level, h)[1::2], (-x, x, y - 0.012, y + 0.012, low, h))
    return made


def cabinet(
    kit: Kit,
    size: Size,
    *,
    columns: Sequence[int] = (1, 3),
    rows: Sequence[int] = (1, 3),
    material: str = "wood",
    top: str = "",
) -> Made:
    """A carcass with fronts (doors or drawers) and handles, perhaps a worktop of its own."""
    w, d, h = size
    made, wood, a, front = Made(), kit.material(material), w / 2, 0.02 - d / 2
    plinth = min(0.06, h / 8)
    foot = (0.03 - a, a - 0.03, 0.06 - d / 2, d / 2, 0.0, plinth)
    made.add(wood, (-a, a, front, d / 2, plinth, h), foot)
    n, m = kit.count(columns), kit.count(rows)
    gap, dx, dz = 0.006, w / n, (h - plinth - 0.02) / m
    cells = [(i * dx - a, plinth + j * dz) for i in range(n) for j in range(m)]
    x0, x1, z1 = gap, dx - gap, dz - gap
    made.add(wood, *[(x + x0, x + x1, -d / 2, front, z + gap, z + z1) for x, z in cells])
    if kit.chance(0.6):
        y, knobs = -d / 2, [(x + dx / 2, z + 0.8 * dz) for x, z in cells]
        bars = [(x - 0.05, x + 0.05, y - 0.025, y, z, z + 0.012) for x, z in knobs]
        made.add(kit.material("metal"), *bars)
    if top:
        made.add(kit.material(top), (-a, a, -d / 2 - 0.015, d / 2, h, h + 0.03))
        h += 0.03
    made.tops.append(Top(0.03 - a, a - 0.03, 0.04 - d / 2, d / 2 - 0.03, h))
    return made


def shelf(kit: Kit, size: Size, *, fill: float = 0.5, bay: float = 0.9) -> Made:
    """Boards between sides, some of them with rows of books, others free for things."""
    w, d, h = size
    made, wood, thick, b = Made(), kit.material("wood"), 0.025, d / 2
    bays, levels = max(1, round(w / bay)), max(1, round(h / kit.between(0.32, 0.42)))
    xs, zs = np.linspace(-w / 2, w / 2, bays + 1), np.linspace(0.05, h - thick, levels + 1)
    sides = [(x, x + thick, -b, b, 0.0, h) for x in np.minimum(xs, w / 2 - thick)]
    made.add(wood, *sides, *[(-w / 2, w / 2, 0.005 - b, b, z, z + thick) for z in zs])
    made.add(wood, (-w / 2, w / 2, b - 0.01, b, 0.05, h))
    for x0, x1 in zip(xs[:-1] + thick, xs[1:], strict=True):
        for z0, z1 in zip(zs[:-1] + thick, zs[1:], strict=True):
            if kit.chance(fill):
                _books(kit, made, (x0, x1), (0.02 - b, b - 0.02), (z0, z1))
            else:
                made.tops.append(Top(x0, x1, 0.02 - b, b - 0.03, z0, z1 - z0))
    made.tops.append(Top(-w / 2, w / 2, -b, b, h, 0.5))
    return made


def _books(kit: Kit, made: Made, x: Size, y: Size, z: Size) -> None:
    """A row of books of one edition or of several, from the left to where it ends."""
    end, at, low = x[0] + kit.between(0.4, 1.0) * (x[1] - x[0]), x[0], z[0]
    while at < end - 0.03:
        run = min(kit.between(0.06, 0.4), end - at)  # one edition: equal heights
        high, thick = low + (z[1] - low) * kit.between(0.6, 0.95), kit.between(0.018, 0.045)
        front = y[0] + kit.between(0, 0.25) * (y[1] - y[0])
        starts = at + thick * np.arange(max(1, int(run / thick)))
        books = [(s, s + thick - 0.001, front, y[1], low, high) for s in starts]
        made.add(kit.material("paper"), *books)
        at += len(starts) * thick + 0.002


def bed(kit: Kit, size: Size) -> Made:
    """A frame with headboard, mattress, blanket and pillows; its head at +y."""
    w, d, h = size
    a, b, made, level = w / 2, d / 2, Made(), min(0.5, 0.6 * h)
    frame = [(-a, a, -b, b, 0.1, 0.3), (-a, a, b - 0.05, b, 0.0, h)]
    made.add(kit.material("wood"), *frame, (0.1 - a, a - 0.1, 0.1 - b, b, 0.0, 0.1))
    soft = ball((a - 0.02, b - 0.06, (level - 0.28) / 2), squareness=0.85, fineness=3)
    made.add(kit.material("linen"), moved(soft, (0, -0.01, (level + 0.28) / 2)))
    half, wrinkles = (a, d * 0.33, (level - 0.2) / 2 + 0.02), kit.between(0.005, 0.03)
    cover = ball(half, squareness=0.85, fineness=4, noise=wrinkles, rng=kit.rng)
    made.add(kit.material("fabric"), moved(cover, (0, -d * 0.17, (level + 0.2) / 2)))
    count = 2 if w > 1.2 else 1
    pillow = ball((min(0.32, w / count / 2.1), 0.2, 0.08), squareness=0.5)
    for k in range(count):
        x = (k - (count - 1) / 2) * w / count
        made.add(kit.material("linen"), moved(pillow, (x, b - 0.32, level + 0.05)))
    return made


def lamp(kit: Kit, size: Size, *, style: str = "stand", power: float = 1.0) -> Made:
    """A lamp on a stand, a pendant on its cord, or a panel under the ceiling."""
    r, h = min(size[:2]) / 2, size[2]
    made, shade = Made(), kit.material("shade")._replace(emission=power)
    if style == "panel":
        a, b = size[0] / 2, size[1] / 2
        made.glow = (-0.01, r, -1.0, power)
        return made.add(shade, (-a, a, -b, b, 0, h))
    tall = min(kit.between(0.6, 1.2) * 2 * r, 0.45 * h)
    narrow = r * kit.between(0.4, 1.0)
    metal = kit.material("metal")
    if style == "stand":
        foot = min(0.7 * r, 0.16)
        made.add(metal, revolution([(foot, 0), (foot, 0.02), (0.012, 0.03), (0.012, h - tall)]))
        made.glow = (h + 0.05, 0.5 * narrow, 0.0, power)
        return made.add(shade, moved(revolution([(r, 0), (narrow, tall)]), (0, 0, h - tall)))
    profile = [(r, -tall / 2), (narrow, tall / 2)]
    body = ball((r, r, tall / 2)) if kit.chance(0.4) else revolution(profile)
    made.glow = (-0.03, r, -1.0, power)
    made.add(shade, moved(body, (0, 0, tall / 2)))
    return made.add(metal, sweep([(0, 0, tall), (0, 0, h)], 0.008, 6))


def vessel(kit: Kit, size: Size, *, profile: str = "vase", material: str = "ceramic") -> Made:
    """A turned vessel, of another width than depth where the size says so."""
    turned = revolution(np.array(kit.profiles[profile]) * [0.5, 1], sections=32)
    turned.vertices = turned.vertices * np.array(size)
    return Made().add(kit.material(material), turned)


def blob(
    kit: Kit, size: Size, *, material: str = "fabric", noise: float = 0.1, squareness: float = 0.0
) -> Made:
    """Something soft or grown: cushion, fruit, stone, toy."""
    body = ball(1.0, noise=noise, rng=kit.rng, squareness=squareness, fineness=3)
    low, high = body.bounds
    body.vertices = (body.vertices - (low + high) / 2) * np.array(size) / (high - low)
    return Made().add(kit.material(material), moved(body, (0, 0, size[2] / 2)))


def cloth(kit: Kit, size: Size, *, style: str = "curtain", material: str = "fabric") -> Made:
    """A curtain in folds, a rug on the floor, or a towel that hangs."""
    w, d, h = size
    if style == "rug":
        corners = np.array([(-w, -d), (w, -d), (w, d), (-w, d)]) / 2
        outline = disc(w, d, 40) if kit.chance(0.2) else corners
        return Made().add(kit.material(material), extrusion(outline, h))
    thick = 0.006
    folds = kit.between(5, 9) * w if style == "curtain" else kit.between(0.5, 2)
    across = max(9, int(10 * folds) + 1)
    x, z = np.meshgrid(np.linspace(-w / 2, w / 2, across), np.linspace(0, h, 7), indexing="ij")
    phase = kit.between(0, 2 * np.pi) + 0.3 * np.sin(3 * z / h + kit.between(0, 6))
    y = (d / 2 - thick) * np.sin(2 * np.pi * folds * (x / w + 0.5) + phase) * (1 - 0.3 * z / h)
    return Made().add(kit.material(material), sheet(np.stack([x, y, z], -1), thick))


def plant(kit: Kit, size: Size, *, style: str = "leaves") -> Made:
    """A plant in a pot: single leaves on stems, or a bush."""
    w, h = min(size[:2]), size[2]
    pot = min(0.35 * h, 0.6 * w)
    made = vessel(kit, (0.9 * pot, 0.9 * pot, pot), profile="pot")
    green, crown = kit.material("leaf"), h - pot
    if style == "bush":
        bush = blob(kit, (w, w, 0.9 * crown), material="leaf", noise=0.35)
        made.add(green, moved(bush.parts[0].mesh, (0, 0, pot + 0.1 * crown)))
        stem = [(0, 0, 0.8 * pot), (0, 0, pot + 0.3 * crown)]
        return made.add(green, sweep(stem, 0.03 * pot + 0.01, 6))
    leaves, stems = [], []
    leaf = ball((0.2 * w, 0.085 * w, 0.008), fineness=1)
    for k in range(kit.count((7, 17))):
        turn, out = 2.4 * k + kit.between(-0.3, 0.3), kit.between(0.2, 0.6)
        way = np.array([np.cos(turn), np.sin(turn)]) * w / 2
        tip = np.array([*(out * way), pot + crown * kit.between(0.35, 0.88)])
        bend = np.array([*(0.3 * out * way), (pot + tip[2]) / 2])
        foot = np.array([0, 0, 0.8 * pot])
        stems.append(sweep(np.stack([foot, bend, tip]), 0.004 + 0.004 * crown, 5))
        leaves.append(moved(leaf, tip, turn))
    return made.add(green, *leaves).add(green, *stems)


def picture(
    kit: Kit, size: Size, *, frame: float = 0.03, material: str = "picture", emission: float = 0.0
) -> Made:
    """A framed panel: picture, mirror, screen, board; upright, its back at +y."""
    w, d, h = size
    a, edge = w / 2, min(frame, w / 6)
    inner, inset = kit.material(material)._replace(emission=emission), edge / 2
    made = Made().add(inner, (inset - a, a - inset, -d / 2 + d / 3, d / 2, inset, h - inset))
    if frame:
        level = [(-a, a, 0.0, edge), (-a, a, h - edge, h)]
        upright = [(-a, edge - a, edge, h - edge), (a - edge, a, edge, h - edge)]
        bars = [(x0, x1, -d / 2, d / 2, z0, z1) for x0, x1, z0, z1 in level + upright]
        made.add(kit.material("wood", "metal"), *bars)
    return made


def pipe(kit: Kit, size: Size, *, count: Sequence[int] = (1, 2), level: bool = False) -> Made:
    """Upright pipes from floor to height, or level rails from side to side."""
    w, d, h = size
    made, metal = Made(), kit.material("metal")
    several, radius = kit.count(count), min(0.4 * d, 0.03)
    for k in range(several):
        x, y = w * ((k + 0.5) / several - 0.5), d / 2 - radius
        z = radius + (h - 2 * radius) * k / max(several - 1, 1)
        path = [(-w / 2, y, z), (-w / 2, -y, z), (w / 2, -y, z), (w / 2, y, z)]
        made.add(metal, sweep(_rounded(path if level else [(x, 0, 0), (x, 0, h)]), radius, 10))
    return made


def _rounded(path: Sequence[tuple[float, float, float]]) -> NDArray[np.float64]:
    """The path with three points close to each inner corner."""
    line = np.array(path, float)
    points = [line[0]]
    for before, corner, after in zip(line[:-2], line[1:-1], line[2:], strict=True):
        a, b = (corner + 0.2 * (p - corner) for p in (before, after))
        points += [a, (a + b + 2 * corner) / 4, b]
    return np.array([*points, line[-1]])


def radiator(kit: Kit, size: Size) -> Made:
    """Upright fins between two rails, on feet."""
    w, d, h = size
    x = np.linspace(-w / 2 + 0.02, w / 2 - 0.02, max(3, int(w / 0.07)))
    fins = [box((0.04, d, 0.86 * h), (k, 0, 0.54 * h)) for k in x]
    rails = [box((w - 0.04, 0.5 * d, 0.04), (0, 0, z)) for z in (0.16 * h, 0.92 * h)]
    feet = [box((0.03, 0.6 * d, 0.12 * h), (k, 0, 0.06 * h)) for k in x[[0, -1]]]
    return Made().add(kit.material("paint"), *fins, *rails, *feet)


def stairs(kit: Kit, size: Size, *, rail: bool = True) -> Made:
    """A flight of steps along x that rises to height, with a banister on its free side."""
    w, d, h = size
    count = max(2, round(h / 0.18))
    xs, zs = np.linspace(-w / 2, w / 2, count + 1), np.linspace(0, h, count + 1)[1:]
    steps = [(a, b, -d / 2, d / 2, 0.0, z) for (a, b), z in zip(pairwise(xs), zs, strict=True)]
    made = Made().add(kit.material("wood"), *steps)
    if rail:
        feet = np.stack([(xs[:-1] + xs[1:]) / 2, np.full(count, 0.04 - d / 2), zs], 1)
        tops = feet + np.array([0, 0, 0.9])
        bars = [sweep([a, b], 0.012, 6) for a, b in zip(feet, tops, strict=True)]
        made.add(kit.material("metal"), *bars).add(kit.material("wood"), sweep(tops, 0.025, 8))
    return made


def stack(kit: Kit, size: Size, *, count: Sequence[int] = (1, 4), material: str = "paper") -> Made:
    """Boxes or books piled up, each turned a little; one of them is a plain case."""
    w, d, h = size
    made, n = Made(), kit.count(count)
    shares = np.sort(kit.rng.uniform(0.15, 1, n - 1)) if n > 1 else np.zeros(0)
    for low, high in pairwise(h * np.unique(np.concatenate([[0.0], shares.round(2), [1.0]]))):
        turn = kit.between(-0.15, 0.15) if n > 1 else 0.0
        fit = 0.5 / (np.cos(turn) + max(w / d, d / w) * abs(np.sin(turn)))
        a, b = (k * fit * (1.0 if n == 1 else kit.between(0.75, 1.0)) for k in (w, d))
        one = moved(slab(-a, a, -b, b, low, high - 1e-3), (0, 0, 0), turn)
        made.add(kit.material(material), one)
    made.tops.append(Top(-w / 3, w / 3, -d / 3, d / 3, h, 0.4))
    return made


_ALL = (table, seat, cabinet, shelf, bed, lamp, vessel, blob, cloth, plant, picture, pipe)
MAKERS: dict[str, Callable[..., Made]] = {
    maker.__name__: maker for maker in (*_ALL, radiator, stairs, stack)
}
"""Every maker by the name that `presets.yml` uses."""
