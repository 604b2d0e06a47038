"""Cloth that lies or covers: rugs, blankets, tablecloths, towels, heaps of clothes."""

import numpy as np

from cmtof.scenes.rooms.materials import Colour, Material, Style, darker, fabric, hue
from cmtof.scenes.rooms.pliant import Points, bars, grid, loft, ripples, slab, spline
from cmtof.scenes.rooms.shades import Maker
from cmtof.scenes.rooms.solids import joined, quads, sheet
from cmtof.scenes.rooms.thing import Mesh, Thing


def yarn_of(rng: np.random.Generator, pattern: str | None = None) -> Material:
    """Wool or cotton of a rug or blanket: muted or strong, plain or patterned."""
    value = float(rng.choice([0.06, 0.2, 0.4, 0.65]))
    base = hue(float(rng.uniform()), float(rng.choice([0.05, 0.3, 0.6])), value)
    kinds = ["rug", "rug", "stripes", "checks", "noise", "weave"]
    name = pattern or str(rng.choice(kinds))
    other = darker(base, float(rng.choice([0.45, 1.7, 2.4])))
    scale = {"rug": 0.35, "stripes": 0.12, "checks": 0.15, "noise": 0.2}.get(name, 0.012)
    scale *= float(rng.uniform(0.7, 1.4))
    return Material(base, other, name, scale, specular=0.0, bump=0.5)


def _edge(yarn: Material) -> Material:
    """Bound edge that goes with a yarn."""
    dark = darker(yarn.colour, 0.6)
    return Material(dark, yarn.colour, "weave", scale=0.01, specular=0.0, bump=0.4)


# --- on the floor -----------------------------------------------------------------------------


def _pile(
    rng: np.random.Generator, length: float, width: float, thick: float, shape: str = "square"
) -> Points:
    """Upper side of a rug that lies a little uneven, its edges not quite straight."""
    x, y = grid(-1, 1, -1, 1, 21, 15)
    if shape == "round":
        x, y = x * np.sqrt(1 - y**2 / 2), y * np.sqrt(1 - x**2 / 2)
    elif shape == "half round":
        y = (1 + y) * np.sqrt(1 - 0.97 * x**2) - 1
    x, y = x * length / 2, y * width / 2
    z = thick + 0.0008 * ripples(rng, x, y, 6, 0.8)
    sway = 0.006 * ripples(rng, x, y, 6, 1.2)
    drift = 0.006 * ripples(rng, x, y, 6, 1.2)
    return np.stack([x + sway, y + drift, z], -1)


def rug(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
    length: float | None = None,
) -> Thing:
    """A rug: bordered, plain, round, a runner, or shaggy; some with fringes.

    Parameters
    ----------
    width, length : float, optional
        Along y and along x, m.
    """
    thing = Thing("rug")
    sizes = ((1.2, 1.7), (1.4, 2.0), (1.6, 2.3), (2.0, 3.0), (0.7, 2.2))
    deep, long = sizes[int(rng.integers(len(sizes)))]
    width, length = width or deep, length or long
    round_ = bool(rng.uniform() < 0.2 and length < 1.8 * width)
    thick = float(rng.uniform(0.006, 0.012))
    yarn = yarn_of(rng)
    if round_:
        length = width
    top = _pile(rng, length, width, thick, "round" if round_ else "square")
    bordered = not round_ and rng.uniform() < 0.55
    thing.add(_on_floor(top), _edge(yarn) if bordered else yarn)
    if bordered:
        rings = (
            [(0.06, yarn_of(rng, "stripes")), (0.15, yarn)]
            if rng.uniform() < 0.5
            else [(0.08, yarn)]
        )
        for k, (inset, material) in enumerate(rings):
            shrink = 1 - 2 * inset * width / np.array([length, width])
            field = top * [*shrink, 1.0] + [0, 0, 0.002 * (k + 1)]
            thing.add(slab(field, 0.004), material)
    if not round_ and rng.uniform() < 0.45:
        thing.add(_fringe(rng, length, width), Material((0.62, 0.56, 0.44), specular=0.0))
    return thing


def _on_floor(top: Points) -> Mesh:
    """A pad from a surface down to z = 0."""
    mesh = slab(top, 1e-3)
    count = top.shape[0] * top.shape[1]
    vertices = mesh.vertices.copy()
    lower = vertices[:, 2] < np.concatenate(
        [top.reshape(-1, 3)[:, 2] - 5e-4, np.full(len(vertices) - count, 1.0)]
    )
    lower[2 * count :] = np.tile([True, True, False, False], (len(vertices) - 2 * count) // 4)
    lower[:count] = False
    vertices[lower, 2] = 0.0
    return Mesh(vertices, mesh.faces)


def _fringe(rng: np.random.Generator, length: float, width: float) -> Mesh:
    """Tassels at both short ends."""
    count = min(int(width / 0.025), 70)
    y = np.linspace(-0.49, 0.49, count) * width
    tufts = []
    for side in (-1, 1):
        start = np.stack([np.full(count, side * (length / 2 - 0.01)), y, np.full(count, 0.006)], -1)
        reach = side * rng.uniform(0.045, 0.065, count)
        end = start + np.stack([reach, rng.normal(0, 0.008, count), np.full(count, -0.003)], -1)
        tufts.append(bars(start, end, 0.0028, 4, 0.8))
    return joined(tufts)


def doormat(rng: np.random.Generator, style: Style) -> Thing:
    """A coir or ribbed mat."""
    thing = Thing("doormat")
    length, width = float(rng.uniform(0.55, 0.85)), float(rng.uniform(0.38, 0.52))
    coir = Material((0.3, 0.2, 0.1), (0.16, 0.1, 0.05), "noise", 0.008, specular=0.0, bump=0.8)
    kind = str(rng.choice(["marks", "stripes", "dots"]))
    marked = Material(coir.colour, (0.03, 0.02, 0.015), kind, 0.07, specular=0.0, bump=0.6)
    base = Material((0.03, 0.03, 0.03), specular=0.02)
    top = _pile(rng, length, width, 0.012, str(rng.choice(["square", "square", "half round"])))
    top = top[::2, ::2]
    thing.add(_on_floor(top), base)
    inner = top * [0.93, 0.9, 1.0] + [0, 0, 0.003]
    thing.add(slab(inner, 0.006), coir if rng.uniform() < 0.4 else marked)
    return thing


# --- draped -----------------------------------------------------------------------------------


def throw_blanket(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
    length: float | None = None,
    hang: float = 0.0,
) -> Thing:
    """A blanket on a level place (z = 0) whose front side hangs over the edge, z < 0.

    Parameters
    ----------
    width : float, optional
        Along x, m.
    length : float, optional
        What lies, along y, m; the edge is at y = -length/2.
    hang : float
        What hangs down in front, m; by default the blanket only lies.
    """
    drawn = rng.uniform([0.5, 0.45], [1.1, 0.9])
    width = float(drawn[0] if width is None else width)
    length = float(drawn[1] if length is None else length)
    u, v = grid(-width / 2, width / 2, -length / 2 - hang, length / 2, 31, 37)
    folds = 0.5 + 0.5 * ripples(rng, 2.5 * u, 0.5 * v, 10, 0.5)
    folds = np.clip(folds, 0, 1) ** 1.3 * 0.022 + 0.004 * (1 + ripples(rng, u, v, 8, 0.15))
    r = 0.02
    over = np.clip(-length / 2 - v, 0, None)  # length of cloth beyond the edge
    angle = np.minimum(over / r, np.pi / 2)
    down = np.maximum(over - r * np.pi / 2, 0)
    sway = 0.012 * ripples(rng, 2.2 * u, 0.3 * v, 8, 0.4) * np.clip(down / 0.15, 0, 1)
    y = np.maximum(v, -length / 2) - (r + folds) * np.sin(angle) - sway
    z = (r + folds) * np.cos(angle) - r - down
    x = u * (1 - 0.04 * np.clip(down / 0.3, 0, 1)) + 0.012 * ripples(rng, u, v, 5, 1.0)
    y = y + 0.015 * ripples(rng, u, v, 5, 1.0) * (over == 0)
    thing = Thing("throw_blanket")
    yarn = yarn_of(rng)
    thing.add(slab(np.stack([x, y, z + 0.006], -1), 0.005), yarn)
    if hang > 0 and rng.uniform() < 0.5:
        end = np.stack([x[:, 0], y[:, 0], z[:, 0]], -1)
        path = spline(end, 60)
        thing.add(
            bars(path, path + [0, 0, -0.05] + 0.004 * rng.normal(size=path.shape), 0.002, 4), yarn
        )
    return thing


def tablecloth(
    rng: np.random.Generator,
    style: Style,
    *,
    length: float | None = None,
    width: float | None = None,
    drop: float | None = None,
) -> Thing:
    """A cloth on a rectangular table top (z = 0), hanging in folds that gather at the corners.

    Parameters
    ----------
    length, width : float, optional
        Table top along x and y, m.
    drop : float, optional
        How far it hangs down the sides, m.
    """
    drawn = rng.uniform([1.2, 0.75, 0.15], [1.9, 0.95, 0.32])
    length = float(drawn[0] if length is None else length)
    width = float(drawn[1] if width is None else width)
    drop = float(drawn[2] if drop is None else drop)
    half = np.array([length, width]) / 2
    around, out, corner = _rim(half, 26, 18)
    count = len(around)
    at = np.arange(count) * (2 * np.pi / count)
    folds = np.sin(at * rng.integers(9, 14) + rng.uniform(0, 6)) + 0.6 * np.sin(
        at * 23 + rng.uniform(0, 6)
    )
    rows = []
    for share in (0.0, 0.06, 0.15, 0.4, 0.7, 1.0):
        # a square cloth's corners hang lower than its sides, in one deep fold each
        low = drop * share * (1 + 0.28 * corner)
        flare = 0.022 + share * (0.006 * folds * (1 - corner) + 0.045 * corner**2 + 0.012)
        lie = min(share / 0.06, 1.0)
        reach = lie * flare
        rows.append(
            np.column_stack([around + reach[:, None] * out, 0.0025 - np.maximum(low - 0.004, 0)])
        )
    skirt = np.stack(rows)[:, ::-1]
    cloth = _linen(rng)
    thing = Thing("tablecloth")
    thing.add(sheet(skirt[::-1], closed=True, thickness=0.0018), cloth)
    a, b = half
    thing.add(quads([[(-a, -b, 0.0025), (a, -b, 0.0025), (a, b, 0.0025), (-a, b, 0.0025)]]), cloth)
    return thing


def _rim(half: Points, long: int, short: int) -> tuple[Points, Points, Points]:
    """Points around a rectangle, the way out at each, and 1 at corners falling to 0."""
    a, b = half
    turn = np.linspace(0, np.pi / 2, 7)
    spots, ways, corners = [], [], []
    for k, (x, y) in enumerate(((a, -b), (a, b), (-a, b), (-a, -b))):
        angle = turn + (k - 1) * np.pi / 2
        side = np.stack([np.cos(angle), np.sin(angle)], -1)
        spots.append(np.tile([x, y], (7, 1)))
        ways.append(side)
        corners.append(np.cos(2 * (turn - np.pi / 4)) ** 0.5)
        ends = np.array(
            [((a, -b), (a, b)), ((a, b), (-a, b)), ((-a, b), (-a, -b)), ((-a, -b), (a, -b))][k]
        )
        count = short if k % 2 == 0 else long
        t = np.linspace(0, 1, count + 2)[1:-1, None]
        spots.append(ends[0] * (1 - t) + ends[1] * t)
        ways.append(np.tile(side[-1], (count, 1)))
        corners.append(np.zeros(count))
    return np.concatenate(spots), np.concatenate(ways), np.clip(np.concatenate(corners), 0, 1)


def _linen(rng: np.random.Generator) -> Material:
    """Table linen: white, checked, striped or printed."""
    kind = str(rng.choice(["plain", "checks", "stripes", "dots", "weave"]))
    white: Colour = (0.75, 0.74, 0.7)
    other = hue(float(rng.uniform()), float(rng.uniform(0.3, 0.9)), float(rng.uniform(0.1, 0.5)))
    first = white if rng.uniform() < 0.7 else darker(other, 1.3)
    return Material(first, other, kind, float(rng.uniform(0.02, 0.07)), specular=0.0, bump=0.15)


# --- heaps and folds --------------------------------------------------------------------------


def _heap(rng: np.random.Generator, size: float, tall: float, n: int) -> Mesh:
    """A thrown-down square of cloth: gathered, creased, folded over itself."""
    u, v = grid(-1, 1, -1, 1, n, n)
    far = np.sqrt(u**2 + v**2)
    gather = 0.62 + 0.1 * ripples(rng, u, v, 6, 2.0)
    slip = [0.22 * ripples(rng, u, v, 9, 1.3) for _ in range(2)]
    crease = sum(
        a * np.sqrt(ripples(rng, u, v, 3, w) ** 2 + 0.02)
        for a, w in ((0.5, 1.9), (0.35, 1.1), (0.12, 0.6 if n > 20 else 1.2))
    )
    z = (0.25 + crease) * np.exp(-1.1 * far**2) + 0.16 * crease
    points = np.stack(
        [size / 2 * (u * gather + slip[0]), size / 2 * (v * gather + slip[1]), tall * z], -1
    )
    points[..., 2] -= points[..., 2].min() - 0.003
    points[..., :2] -= (points[..., :2].min((0, 1)) + points[..., :2].max((0, 1))) / 2
    mesh = slab(points, 0.002)
    vertices = np.maximum(mesh.vertices, [-9.0, -9.0, 0.0]).astype(np.float32)
    low = vertices[:, 2].min()
    return Mesh((vertices - [0, 0, low]).astype(np.float32), mesh.faces)


def crumpled_cloth(rng: np.random.Generator, style: Style) -> Thing:
    """A cloth, towel or shirt dropped in a heap."""
    size = float(rng.uniform(0.25, 0.6))
    mesh = _heap(rng, size, size * float(rng.uniform(0.22, 0.4)), 30)
    return Thing("crumpled_cloth").add(mesh, fabric(rng))


def laundry_pile(rng: np.random.Generator, style: Style) -> Thing:
    """Several pieces of clothing on one heap."""
    thing = Thing("laundry_pile")
    for k in range(int(rng.integers(3, 6))):
        size = float(rng.uniform(0.35, 0.6))
        mesh = _heap(rng, size, 0.16, 17)
        aside = rng.normal(0, 0.09, 2) if k else np.zeros(2)
        # each lies on those below: lower at the sides, where it has slipped down
        lift = 0.035 * k * np.exp(-((mesh.vertices[:, :2] / 0.3) ** 2).sum(1))
        shift = np.column_stack([np.full(len(lift), aside[0]), np.full(len(lift), aside[1]), lift])
        thing.add(Mesh((mesh.vertices + shift).astype(np.float32), mesh.faces), fabric(rng))
    return thing


def folded_towels(rng: np.random.Generator, style: Style) -> Thing:
    """A stack of folded towels, their round folds to the front."""
    thing = Thing("folded_towels")
    z, colour = 0.0, fabric(rng)
    length, deep = float(rng.uniform(0.26, 0.4)), float(rng.uniform(0.18, 0.28))
    for _ in range(int(rng.integers(2, 6))):
        if rng.uniform() < 0.5:
            colour = fabric(rng)
        layers, thick = int(rng.integers(2, 4)), float(rng.uniform(0.011, 0.017))
        a, b = length * float(rng.uniform(0.92, 1)), deep * float(rng.uniform(0.92, 1))
        shift = rng.normal(0, 0.006, 2)
        for _ in range(layers):
            mesh = _fold(rng, a, b, thick)
            thing.add(
                Mesh((mesh.vertices + np.array([*shift, z])).astype(np.float32), mesh.faces), colour
            )
            z += thick + 0.0006
    return thing


def _fold(rng: np.random.Generator, length: float, deep: float, thick: float) -> Mesh:
    """One folded layer on z = 0: a flat pad with a round front and sagging ends."""
    angle = np.linspace(-np.pi / 2, -3 * np.pi / 2, 7)
    front = np.stack([-deep / 2 + thick / 2 + thick / 2 * np.cos(angle), thick / 2 + thick / 2 * np.sin(angle)], -1)  # fmt: skip  # noqa: E501
    back = np.array([(0.0, thick), (deep / 2, 0.92 * thick), (deep / 2, 0.1 * thick), (0.0, 0.0)])
    outline = np.concatenate([front, back])
    x = np.linspace(-0.5, 0.5, 6) * length
    wave = 1 + 0.012 * rng.normal(size=(6, 1))
    rings = np.empty((6, len(outline), 3))
    rings[..., 0] = x[:, None]
    rings[..., 1] = outline[:, 0] * wave
    rings[..., 2] = outline[:, 1]
    return loft(rings[:, ::-1])


CATALOGUE: dict[str, Maker] = {
    "rug": rug,
    "doormat": doormat,
    "throw_blanket": throw_blanket,
    "tablecloth": tablecloth,
    "crumpled_cloth": crumpled_cloth,
    "laundry_pile": laundry_pile,
    "folded_towels": folded_towels,
}
