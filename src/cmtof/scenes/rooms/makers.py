"""Makers of furniture: each fills a box of a size (width, depth, height), m, from its options.

A thing stands on z = 0 about the origin, its front towards -y. Every maker takes a `Kit`, the size,
and options that `presets.yml` names.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh

from cmtof.scenes.rooms.engine import Part
from cmtof.scenes.rooms.materials import Material
from cmtof.scenes.rooms.solids import (
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


@dataclass(frozen=True)
class Kit:
    """Random numbers and the materials of a household.

    Attributes
    ----------
    rng : Generator
    palette : dict
        Materials to choose from, by role: wood, fabric, metal, ...
    """

    rng: np.random.Generator
    palette: dict[str, list[Material]]

    def material(self, role: str) -> Material:
        """One of the household's materials of a role."""
        several = self.palette[role]
        return several[int(self.rng.integers(len(several)))]

    def between(self, low: float, high: float) -> float:
        """Number drawn evenly."""
        return float(self.rng.uniform(low, high))

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

    def add(self, meshes: Trimesh | Sequence[Trimesh], material: Material) -> "Made":
        """Add solids of one material."""
        whole = meshes if isinstance(meshes, Trimesh) else joined(meshes)
        self.parts.append(Part(whole, material))
        return self


def table(
    kit: Kit, size: Size, *, legs: str = "four", round_top: float = 0.0, material: str = "wood"
) -> Made:
    """A top on four legs, two panels, or a pedestal; ``round_top`` is the share of round ones."""
    w, d, h = size
    thick = min(kit.between(0.02, 0.05), h / 4)
    wood = kit.material(material)
    made = Made()
    if kit.chance(round_top):
        turn = np.linspace(0, 2 * np.pi, 33)[:-1]
        outline = np.stack([w / 2 * np.cos(turn), d / 2 * np.sin(turn)], 1)
        made.add(moved(extrusion(outline, thick), (0, 0, h - thick)), wood)
        legs, a, b = "pedestal", 0.35 * w, 0.35 * d
    else:
        made.add(slab(-w / 2, w / 2, -d / 2, d / 2, h - thick, h), wood)
        a, b = w / 2, d / 2
    below = h - thick
    if legs == "pedestal":
        foot = 0.3 * min(w, d)
        profile = [(foot, 0), (foot, 0.03), (0.05, 0.06), (0.04, below)]
        made.add(revolution(profile), kit.material("metal"))
    elif legs == "panel":
        made.add(
            [
                slab(s - 0.02, s + 0.02, -b * 0.95, b * 0.95, 0, below)
                for s in (-a + 0.06, a - 0.06)
            ],
            wood,
        )
    else:
        thin = min(kit.between(0.03, 0.07), w / 6, d / 6)
        x, y = a - thin, b - thin
        made.add(
            [box((thin, thin, below), (i * x, j * y, below / 2)) for i in (-1, 1) for j in (-1, 1)],
            wood,
        )
        if h > 0.5:
            rail = below - 0.05
            made.add(
                [slab(-x, x, j * y - 0.01, j * y + 0.01, rail - 0.06, below) for j in (-1, 1)], wood
            )
    made.tops.append(Top(-a * 0.9, a * 0.9, -b * 0.9, b * 0.9, h, 1.2))
    return made


def seat(kit: Kit, size: Size, *, style: str = "chair") -> Made:
    """A chair or stool on legs, or an upholstered bench, armchair, sofa."""
    if style in ("chair", "stool"):
        return _chair(kit, size, back=style == "chair")
    w, d, h = size
    cover, made = kit.material("fabric"), Made()
    arm = kit.between(0.12, 0.2) if style in ("sofa", "armchair") else 0.0
    level, back = min(0.42, 0.9 * h), kit.between(0.16, 0.24) if h > 0.5 else 0.0
    made.add(slab(-w / 2, w / 2, -d / 2, d / 2, 0.08, level - 0.12), cover)
    feet = [
        box((0.06, 0.06, 0.08), (i * (w / 2 - 0.06), j * (d / 2 - 0.06), 0.04))
        for i in (-1, 1)
        for j in (-1, 1)
    ]
    made.add(feet, kit.material("wood"))
    if arm:
        top = kit.between(0.55, 0.65)
        made.add(
            [
                slab(
                    i * (w / 2) - (arm if i > 0 else 0),
                    i * (w / 2) + (arm if i < 0 else 0),
                    -d / 2,
                    d / 2,
                    0.08,
                    min(top, h),
                )
                for i in (-1, 1)
            ],
            cover,
        )
    wide = w - 2 * arm
    count = max(1, round(wide / 0.75))
    each, deep = wide / count, d - back
    middles = -wide / 2 + each * (np.arange(count) + 0.5)
    made.add(
        [
            moved(ball((each / 2, deep / 2, 0.09), squareness=0.75), (x, -back / 2, level - 0.05))
            for x in middles
        ],
        cover,
    )
    if back:
        made.add(slab(-wide / 2, wide / 2, d / 2 - 0.08, d / 2, level - 0.12, h), cover)
        tall = (h - level) / 2
        made.add(
            [
                moved(
                    ball((each / 2, back / 2, tall), squareness=0.7),
                    (x, d / 2 - back / 2 - 0.03, level + 0.9 * tall),
                )
                for x in middles
            ],
            cover,
        )
    return made


def _chair(kit: Kit, size: Size, *, back: bool) -> Made:
    w, d, h = size
    level = min(0.46, 0.55 * h) if back else h
    wood, made, thin = kit.material(str(kit.rng.choice(["wood", "metal"]))), Made(), 0.035
    x, y = w / 2 - thin / 2, d / 2 - thin / 2
    made.add(box((w, d, 0.04), (0, 0, level - 0.02)), kit.material("fabric"))
    made.add(
        [
            box((thin, thin, level - 0.04), (i * x, j * y, (level - 0.04) / 2))
            for i in (-1, 1)
            for j in (-1, 1)
        ],
        wood,
    )
    if back:
        posts = [
            slab(i * x - thin / 2, i * x + thin / 2, y - thin / 2, y + thin / 2, level, h)
            for i in (-1, 1)
        ]
        low = level + 0.5 * (h - level) if kit.chance(0.5) else level + 0.08
        made.add([*posts, slab(-x, x, y - 0.012, y + 0.012, low, h)], wood)
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
    """A carcass with fronts (doors or drawers) and knobs, perhaps a worktop of its own."""
    w, d, h = size
    made, wood = Made(), kit.material(material)
    plinth, front = min(0.06, h / 8), 0.02
    made.add(
        [
            slab(-w / 2, w / 2, -d / 2 + front, d / 2, plinth, h),
            slab(-w / 2 + 0.03, w / 2 - 0.03, -d / 2 + 0.06, d / 2, 0, plinth),
        ],
        wood,
    )
    n, m = (int(kit.rng.integers(a, b + 1)) for a, b in (columns, rows))
    gap, dx, dz = 0.006, w / n, (h - plinth - 0.02) / m
    cells = [(-w / 2 + i * dx, plinth + j * dz) for i in range(n) for j in range(m)]
    made.add(
        [
            slab(x + gap, x + dx - gap, -d / 2, -d / 2 + front, z + gap, z + dz - gap)
            for x, z in cells
        ],
        wood,
    )
    if kit.chance(0.6):
        made.add(
            [
                slab(
                    x + dx / 2 - 0.05,
                    x + dx / 2 + 0.05,
                    -d / 2 - 0.025,
                    -d / 2,
                    z + 0.8 * dz,
                    z + 0.8 * dz + 0.012,
                )
                for x, z in cells
            ],
            kit.material("metal"),
        )
    if top:
        made.add(slab(-w / 2, w / 2, -d / 2 - 0.015, d / 2, h, h + 0.03), kit.material(top))
        h += 0.03
    made.tops.append(Top(-w / 2 + 0.03, w / 2 - 0.03, -d / 2 + 0.04, d / 2 - 0.03, h))
    return made


def shelf(kit: Kit, size: Size, *, fill: float = 0.5, bay: float = 0.9) -> Made:
    """Boards between sides, some of them with rows of books, others free for things."""
    w, d, h = size
    made, wood, thick = Made(), kit.material("wood"), 0.025
    bays, levels = max(1, round(w / bay)), max(1, round(h / kit.between(0.32, 0.42)))
    xs, zs = np.linspace(-w / 2, w / 2, bays + 1), np.linspace(0.05, h - thick, levels + 1)
    sides = [
        slab(min(x, w / 2 - thick), min(x, w / 2 - thick) + thick, -d / 2, d / 2, 0, h) for x in xs
    ]
    boards = [slab(-w / 2, w / 2, -d / 2 + 0.005, d / 2, z, z + thick) for z in zs]
    made.add([*sides, *boards], wood)
    made.add(slab(-w / 2, w / 2, d / 2 - 0.01, d / 2, 0.05, h), wood)
    for x0, x1 in zip(xs[:-1] + thick, xs[1:], strict=True):
        for z0, z1 in zip(zs[:-1] + thick, zs[1:], strict=True):
            if kit.chance(fill):
                _books(kit, made, (x0, x1), (-d / 2 + 0.02, d / 2 - 0.02), (z0, z1))
            else:
                made.tops.append(Top(x0, x1, -d / 2 + 0.02, d / 2 - 0.03, z0, z1 - z0))
    made.tops.append(Top(-w / 2, w / 2, -d / 2, d / 2, h, 0.5))
    return made


def _books(kit: Kit, made: Made, x: Size, y: Size, z: Size) -> None:
    """A row of books of one edition or of several, from the left to where it ends."""
    end, at = x[0] + kit.between(0.4, 1.0) * (x[1] - x[0]), x[0]
    deep, room = y[1] - y[0], z[1] - z[0]
    while at < end - 0.03:
        run = min(kit.between(0.06, 0.4), end - at)  # one edition: equal heights
        tall, thick = room * kit.between(0.6, 0.95), kit.between(0.018, 0.045)
        count = max(1, int(run / thick))
        front = y[0] + kit.between(0, 0.25) * deep
        books = [
            slab(at + k * thick, at + (k + 1) * thick - 0.001, front, y[1], z[0], z[0] + tall)
            for k in range(count)
        ]
        made.add(books, kit.material("paper"))
        at += count * thick + 0.002


def bed(kit: Kit, size: Size) -> Made:
    """A frame with headboard, mattress, blanket and pillows; its head at +y."""
    w, d, h = size
    made, level = Made(), min(0.5, 0.6 * h)
    made.add(
        [
            slab(-w / 2, w / 2, -d / 2, d / 2, 0.1, 0.3),
            slab(-w / 2, w / 2, d / 2 - 0.05, d / 2, 0, h),
            slab(-w / 2 + 0.1, w / 2 - 0.1, -d / 2 + 0.1, d / 2, 0, 0.1),
        ],
        kit.material("wood"),
    )
    soft = ball((w / 2 - 0.02, d / 2 - 0.06, (level - 0.28) / 2), squareness=0.85, fineness=3)
    made.add(moved(soft, (0, -0.01, (level + 0.28) / 2)), kit.material("linen"))
    cover = ball(
        (w / 2, d * 0.33, (level - 0.2) / 2 + 0.02),
        squareness=0.85,
        fineness=4,
        noise=kit.between(0.005, 0.03),
        rng=kit.rng,
    )
    made.add(moved(cover, (0, -d * 0.17, (level + 0.2) / 2)), kit.material("fabric"))
    count = 2 if w > 1.2 else 1
    for k in range(count):
        pillow = ball((min(0.32, w / count / 2.1), 0.2, 0.08), squareness=0.5)
        x = (k - (count - 1) / 2) * w / count
        made.add(moved(pillow, (x, d / 2 - 0.32, level + 0.05)), kit.material("linen"))
    return made


def lamp(kit: Kit, size: Size, *, style: str = "stand", power: float = 1.0) -> Made:
    """A lamp on a stand, hanging on a cord from z = height, or a panel under the ceiling."""
    w, h = min(size[:2]), size[2]
    made, r = Made(), w / 2
    shade = kit.material("shade")._replace(emission=power)
    if style == "panel":
        made.add(slab(-size[0] / 2, size[0] / 2, -size[1] / 2, size[1] / 2, 0, h), shade)
        made.glow = (-0.01, r, -1.0, power)
        return made
    tall = min(kit.between(0.6, 1.2) * w, 0.45 * h)
    narrow = r * kit.between(0.4, 1.0)
    metal = kit.material("metal")
    if style == "stand":
        foot = min(0.7 * r, 0.16)
        made.add(revolution([(foot, 0), (foot, 0.02), (0.012, 0.03), (0.012, h - tall)]), metal)
        made.add(moved(revolution([(r, 0), (narrow, tall)]), (0, 0, h - tall)), shade)
        made.glow = (h + 0.05, 0.5 * narrow, 0.0, power)
        return made
    round_one = kit.chance(0.4)
    body = ball((r, r, tall / 2)) if round_one else revolution([(r, -tall / 2), (narrow, tall / 2)])
    made.add(moved(body, (0, 0, tall / 2)), shade)
    made.add(sweep([(0, 0, tall), (0, 0, h)], 0.008, 6), metal)
    made.glow = (-0.03, r, -1.0, power)
    return made


VESSELS = {
    "vase": [
        (0.5, 0),
        (0.8, 0.2),
        (1, 0.5),
        (0.7, 0.8),
        (0.45, 0.92),
        (0.6, 1),
        (0.5, 1),
        (0.35, 0.92),
        (0.6, 0.5),
        (0, 0.1),
    ],
    "bowl": [(0.4, 0), (0.45, 0.06), (0.8, 0.4), (1, 1), (0.95, 1), (0.75, 0.45), (0, 0.15)],
    "bottle": [(0.9, 0), (1, 0.05), (1, 0.6), (0.4, 0.75), (0.35, 0.97), (0.4, 1)],
    "mug": [(0.95, 0), (1, 0.1), (1, 1), (0.9, 1), (0.88, 0.1)],
    "pot": [(0.7, 0), (0.95, 0.9), (1, 0.9), (1, 1), (0.88, 1), (0.85, 0.85)],
    "tub": [(0.85, 0), (0.95, 0.5), (1, 0.98), (1, 1), (0.88, 1), (0.85, 0.6), (0.7, 0.25)],
    "urn": [
        (0.6, 0),
        (0.6, 0.05),
        (0.3, 0.15),
        (0.8, 0.4),
        (1, 0.65),
        (0.7, 0.85),
        (0.85, 0.97),
        (0.85, 1),
    ],
    "column": [
        (1, 0),
        (1, 0.04),
        (0.8, 0.06),
        (0.75, 0.5),
        (0.7, 0.93),
        (0.9, 0.95),
        (1, 0.96),
        (1, 1),
    ],
    "cylinder": [(1, 0), (1, 1)],
    "figure": [
        (0.9, 0),
        (0.9, 0.08),
        (0.4, 0.12),
        (0.55, 0.3),
        (0.7, 0.45),
        (0.95, 0.6),
        (0.4, 0.68),
        (0.3, 0.74),
        (0.45, 0.82),
        (0.45, 0.9),
        (0.25, 0.98),
    ],
}
"""Profiles of vessels: share of the radius and of the height, from the foot on."""


def vessel(kit: Kit, size: Size, *, profile: str = "vase", material: str = "ceramic") -> Made:
    """A turned vessel, of another width than depth where the size says so."""
    w, d, h = size
    turned = revolution(np.array(VESSELS[profile]) * [0.5, 1], sections=32)
    turned.vertices = turned.vertices * [w, d, h]
    return Made().add(turned, kit.material(material))


def blob(
    kit: Kit,
    size: Size,
    *,
    material: str = "fabric",
    noise: float = 0.1,
    squareness: float = 0.0,
    fineness: int = 3,
) -> Made:
    """Something soft or grown: cushion, fruit, stone, toy."""
    w, d, h = size
    body = ball(1.0, noise=noise, rng=kit.rng, squareness=squareness, fineness=fineness)
    low, high = body.bounds
    body.vertices = (body.vertices - (low + high) / 2) * np.array([w, d, h]) / (high - low)
    return Made().add(moved(body, (0, 0, h / 2)), kit.material(material))


def cloth(kit: Kit, size: Size, *, style: str = "curtain", material: str = "fabric") -> Made:
    """A curtain in folds, a rug on the floor, or a towel that hangs."""
    w, d, h = size
    if style == "rug":
        outline = [(-w / 2, -d / 2), (w / 2, -d / 2), (w / 2, d / 2), (-w / 2, d / 2)]
        if kit.chance(0.2):
            turn = np.linspace(0, 2 * np.pi, 41)[:-1]
            outline = np.stack([w / 2 * np.cos(turn), d / 2 * np.sin(turn)], 1).tolist()
        return Made().add(extrusion(outline, h), kit.material(material))
    thick = 0.006
    folds = kit.between(5, 9) * w if style == "curtain" else kit.between(0.5, 2)
    across = max(9, int(10 * folds) + 1)
    x, z = np.meshgrid(np.linspace(-w / 2, w / 2, across), np.linspace(0, h, 7), indexing="ij")
    phase = kit.between(0, 2 * np.pi) + 0.3 * np.sin(3 * z / h + kit.between(0, 6))
    y = (d / 2 - thick) * np.sin(2 * np.pi * folds * (x / w + 0.5) + phase) * (1 - 0.3 * z / h)
    return Made().add(sheet(np.stack([x, y, z], -1), thick), kit.material(material))


def plant(kit: Kit, size: Size, *, style: str = "leaves") -> Made:
    """A plant in a pot: single leaves on stems, or a bush."""
    w, h = min(size[:2]), size[2]
    pot = min(0.35 * h, 0.6 * w)
    made = vessel(kit, (0.9 * pot, 0.9 * pot, pot), profile="pot")
    green, crown = kit.material("leaf"), h - pot
    if style == "bush":
        bush = blob(kit, (w, w, 0.9 * crown), material="leaf", noise=0.35)
        made.add(moved(bush.parts[0].mesh, (0, 0, pot + 0.1 * crown)), green)
        made.add(sweep([(0, 0, 0.8 * pot), (0, 0, pot + 0.3 * crown)], 0.03 * pot + 0.01, 6), green)
        return made
    leaves, stems = [], []
    for k in range(int(kit.rng.integers(7, 18))):
        turn, out = 2.4 * k + kit.between(-0.3, 0.3), kit.between(0.2, 0.6)
        way = np.array([np.cos(turn), np.sin(turn)]) * w / 2
        tip = np.array([*(out * way), pot + crown * kit.between(0.35, 0.88)])
        stems.append(
            sweep(
                [(0, 0, 0.8 * pot), (*(0.3 * out * way), (pot + tip[2]) / 2), tip],
                0.004 + 0.004 * crown,
                5,
            )
        )
        leaf = ball((0.2 * w, 0.085 * w, 0.008), fineness=1)
        leaves.append(moved(leaf, tip, turn))
    return made.add(leaves, green).add(stems, green)


def picture(
    kit: Kit, size: Size, *, frame: float = 0.03, material: str = "picture", emission: float = 0.0
) -> Made:
    """A framed panel: picture, mirror, screen, board; upright, its back at +y."""
    w, d, h = size
    made, edge = Made(), min(frame, w / 6)
    inner = kit.material(material)._replace(emission=emission)
    made.add(
        slab(-w / 2 + edge / 2, w / 2 - edge / 2, -d / 2 + d / 3, d / 2, edge / 2, h - edge / 2),
        inner,
    )
    if frame:
        bars = [
            (-w / 2, w / 2, 0, edge),
            (-w / 2, w / 2, h - edge, h),
            (-w / 2, -w / 2 + edge, edge, h - edge),
            (w / 2 - edge, w / 2, edge, h - edge),
        ]
        made.add(
            [slab(x0, x1, -d / 2, d / 2, z0, z1) for x0, x1, z0, z1 in bars],
            kit.material(str(kit.rng.choice(["wood", "metal"]))),
        )
    return made


def pipe(kit: Kit, size: Size, *, count: Sequence[int] = (1, 2), level: bool = False) -> Made:
    """Upright pipes from floor to height, or level rails from side to side."""
    w, d, h = size
    made, metal = Made(), kit.material("metal")
    several, radius = int(kit.rng.integers(count[0], count[1] + 1)), min(0.4 * d, 0.03)
    for k in range(several):
        share = (k + 0.5) / several
        if level:
            z, inset = radius + (h - 2 * radius) * k / max(several - 1, 1), d / 2 - radius
            path = [(-w / 2, inset, z), (-w / 2, -inset, z), (w / 2, -inset, z), (w / 2, inset, z)]
        else:
            path = [(w * (share - 0.5), 0, 0), (w * (share - 0.5), 0, h)]
        made.add(sweep(_rounded(np.array(path, float)), radius, 10), metal)
    return made


def _rounded(path: NDArray) -> NDArray:
    """The path with three points close to each inner corner."""
    if len(path) < 3:
        return path
    points = [path[0]]
    for before, corner, after in zip(path[:-2], path[1:-1], path[2:], strict=True):
        a, b = (corner + 0.2 * (p - corner) for p in (before, after))
        points += [a, (a + b + 2 * corner) / 4, b]
    return np.array([*points, path[-1]])


def radiator(kit: Kit, size: Size) -> Made:
    """Upright fins between two rails, on feet."""
    w, d, h = size
    count = max(3, int(w / 0.07))
    x = np.linspace(-w / 2 + 0.02, w / 2 - 0.02, count)
    fins = [box((0.04, d, 0.86 * h), (k, 0, 0.54 * h)) for k in x]
    rails = [box((w - 0.04, 0.5 * d, 0.04), (0, 0, z)) for z in (0.16 * h, 0.92 * h)]
    feet = [box((0.03, 0.6 * d, 0.12 * h), (k, 0, 0.06 * h)) for k in (x[0], x[-1])]
    return Made().add([*fins, *rails, *feet], kit.material("paint"))


def stairs(kit: Kit, size: Size, *, rail: bool = True) -> Made:
    """A flight of steps along x that rises to height, with a banister on its free side."""
    w, d, h = size
    count = max(2, round(h / 0.18))
    run, rise = w / count, h / count
    steps = [
        slab(-w / 2 + k * run, -w / 2 + (k + 1) * run, -d / 2, d / 2, 0, (k + 1) * rise)
        for k in range(count)
    ]
    made = Made().add(steps, kit.material("wood"))
    if rail:
        x = -w / 2 + run * (np.arange(count) + 0.5)
        z = rise * (np.arange(count) + 1.0)
        y = -d / 2 + 0.04
        posts = [sweep([(a, y, b), (a, y, b + 0.9)], 0.012, 6) for a, b in zip(x, z, strict=True)]
        path = np.stack([x, np.full(count, y), z + 0.9], 1)
        made.add(posts, kit.material("metal")).add(sweep(path, 0.025, 8), kit.material("wood"))
    return made


def stack(kit: Kit, size: Size, *, count: Sequence[int] = (1, 4), material: str = "paper") -> Made:
    """Boxes or books piled up, each turned a little; one of them is a plain case."""
    w, d, h = size
    made, n = Made(), int(kit.rng.integers(count[0], count[1] + 1))
    shares = np.sort(kit.rng.uniform(0.15, 1, n - 1)) if n > 1 else np.zeros(0)
    zs = h * np.unique(np.concatenate([[0.0], shares.round(2), [1.0]]))
    for low, high in itertools.pairwise(zs):
        turn = kit.between(-0.15, 0.15) if n > 1 else 0.0
        fit = 1 / (np.cos(turn) + max(w / d, d / w) * abs(np.sin(turn)))
        x, y = (k * fit * (1.0 if n == 1 else kit.between(0.75, 1.0)) for k in (w, d))
        one = moved(slab(-x / 2, x / 2, -y / 2, y / 2, low, high - 1e-3), (0, 0, 0), turn)
        made.add(one, kit.material(material))
    made.tops.append(Top(-w / 3, w / 3, -d / 3, d / 3, h, 0.4))
    return made


MAKERS: dict[str, Callable[..., Made]] = {
    maker.__name__: maker
    for maker in (
        table,
        seat,
        cabinet,
        shelf,
        bed,
        lamp,
        vessel,
        blob,
        cloth,
        plant,
        picture,
        pipe,
        radiator,
        stairs,
        stack,
    )
}
"""Every maker by the name that `presets.yml` uses."""
