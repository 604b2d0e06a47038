"""What is padded, sewn and draped: cushions, covers, towels and clothes, m."""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.rooms.joinery import mirrored
from cmtof.scenes.rooms.solids import joined, quads, sheet, tube
from cmtof.scenes.rooms.thing import Mesh

Points = NDArray[np.float64]


def shell(rings: ArrayLike) -> Mesh:
    """A surface through rings (N, M, 3), each counter-clockwise seen from above, upwards."""
    return sheet(np.asarray(rings, float)[:, ::-1], closed=True)


@lru_cache(maxsize=16)
def _outline(corner: int, side: int) -> tuple[Points, Points]:
    """Signs of a rounded rectangle's arc centres and its normals, counter-clockwise."""
    sign, normal = [], []
    signs = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)], float)
    for q in range(4):
        angle = np.pi / 2 * (q + np.linspace(0, 1, corner))
        normal.append(np.stack([np.cos(angle), np.sin(angle)], -1))
        sign.append(np.repeat(signs[q : q + 1], corner, 0))
        t = np.linspace(0, 1, side + 2)[1:-1, None]
        sign.append((1 - t) * signs[q] + t * signs[(q + 1) % 4])
        normal.append(np.repeat(normal[-1][-1:], side, 0))
    return np.concatenate(sign), np.concatenate(normal)


def loft(
    width: float,
    depth: float,
    radius: float,
    profile: ArrayLike,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    *,
    corner: int = 4,
    side: int = 0,
) -> Mesh:
    """A rounded rectangle carried up a profile: pads, slabs, tubs, trays, hoods.

    Parameters
    ----------
    width, depth, radius : float
        Outline, m.
    profile : array_like, shape (N, 2)
        Inset from the outline and height, m, from the bottom up, then over the rim and down
        inside for a vessel; a repeated row makes a crease, an inset of half the shorter side
        closes it.
    corner, side : int
        Points along each corner and between corners.
    """
    profile = np.asarray(profile, float)
    sign, normal = _outline(corner, side)
    half = np.array([width, depth]) / 2
    inset = profile[:, :1, None]
    reach = np.maximum(half - np.maximum(radius, inset), 0)
    rings = np.empty((len(profile), len(sign), 3))
    rings[..., :2] = sign * reach + normal * np.maximum(radius - inset, 0)
    rings[..., 2] = profile[:, 1:]
    return shell(rings + np.asarray(centre, float))


def pad(
    size: ArrayLike,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    *,
    radius: float = 0.04,
    edge: float = 0.025,
    crown: float = 0.01,
    side: int = 3,
) -> Mesh:
    """A mattress or seat cushion: rounded edges, a top that bulges by ``crown``, m.

    ``centre`` is the middle of its underside.
    """
    w, d, h = np.asarray(size, float)
    edge = min(edge, h / 2.05)
    radius = max(radius, edge)
    short = min(w, d) / 2
    turn = np.linspace(0, np.pi / 2, 3)
    low = np.stack([edge * (1 - np.sin(turn)), edge * (1 - np.cos(turn))], -1)
    high = np.stack([low[::-1, 0], h - low[::-1, 1]], -1)
    inner = edge + (short - edge) * np.array([0.15, 0.4, 0.7, 1.0])
    fall = 1 - inner / short
    top = np.stack([inner, h + crown * (1 - fall**2)], -1)
    rows = np.concatenate([[(short, 0.0)], low, high, top])
    return loft(w, d, radius, rows, centre, corner=3 if radius < 0.1 else 6, side=side)


def dented(mesh: Mesh, places: ArrayLike, depth: float, radius: float) -> Mesh:
    """Press the upper half of a pad in around places (N, 2), m, as those who sat there do."""
    vertices = mesh.vertices.astype(float)
    low, high = vertices[:, 2].min(), vertices[:, 2].max()
    away = vertices[:, None, :2] - np.asarray(places, float)
    press = np.exp(-(away**2).sum(-1) / radius**2).sum(1)
    share = np.clip((vertices[:, 2] - low) / (high - low + 1e-9), 0, 1) ** 2
    vertices[:, 2] -= depth * np.minimum(press, 1.3) * share
    return Mesh(vertices.astype(np.float32), mesh.faces)


def two_sided(front: Points, back: Points, *, rim: bool = True) -> Mesh:
    """A closed skin between two grids (N, M, 3): the front's outside as in `sheet`.

    Both sides are cut into triangles along the same diagonals, so that they never cross. Where
    the grids meet at their edges no ``rim`` is wanted.
    """
    face = sheet(front)
    n, m = front.shape[:2]
    index = np.arange(n * m).reshape(n, m)
    behind = Mesh(back.reshape(-1, 3).astype(np.float32), face.faces[:, ::-1].copy())
    if not rim:
        return joined([face, behind])
    loop = np.concatenate([index[:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1]])
    p, q = back.reshape(-1, 3)[loop], face.vertices[loop]
    edge = np.stack([p, np.roll(p, -1, 0), np.roll(q, -1, 0), q], 1)
    return joined([face, behind, quads(edge)])


def cloth(points: ArrayLike, thickness: float = 0.004) -> Mesh:
    """A closed cloth or bent plate through a grid (N, M, 3), thickened inwards, m."""
    points = np.asarray(points, float)
    normal = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True) + 1e-12
    return two_sided(points, points - thickness * normal)


def pillow(
    rng: np.random.Generator, width: float, depth: float, height: float, *, count: int = 13
) -> Mesh:
    """A stuffed pillow lying on z = 0: pinched corners, a seam around, a few creases."""
    u = np.sin(np.linspace(-np.pi / 2, np.pi / 2, count))
    u, v = np.meshgrid(u, u, indexing="ij")
    pinch = rng.uniform(0.04, 0.10)
    x = width / 2 * u * (1 - pinch * (1 - v**2) * np.abs(u))
    y = depth / 2 * v * (1 - pinch * (1 - u**2) * np.abs(v))
    swell = ((1 - u**2) * (1 - v**2)) ** 0.42
    wave = rng.normal(0, 1, (6, 2))
    phase = rng.uniform(0, 2 * np.pi, 6)
    crease = np.sin(3 * (u[..., None] * wave[:, 0] + v[..., None] * wave[:, 1]) + phase).sum(-1)
    top = height * (0.52 * swell * (1 + 0.05 * crease))
    low = -height * 0.48 * swell
    base = -float(low.min())
    top, low = np.stack([x, y, base + top], -1), np.stack([x, y, base + low], -1)
    return two_sided(top, low, rim=False)


def covering(
    rng: np.random.Generator,
    x: tuple[float, float],
    y: tuple[float, float],
    z: float,
    hang: tuple[float, float, float, float],
    *,
    thickness: float = 0.03,
    folds: float = 0.02,
    puff: float = 0.01,
    spacing: float = 0.11,
) -> Mesh:
    """A cloth over a flat top that hangs down at its edges in folds.

    Parameters
    ----------
    x, y : (float, float)
        Limits of the flat top, m.
    z : float
        Its height, m.
    hang : (float, float, float, float)
        How far the cloth reaches beyond -x, +x, -y, +y, m.
    folds, puff : float
        Depth of the folds below the edge and of the unevenness on top, m.
    spacing : float
        Between grid lines on top, m.
    """
    s = _stations(x, hang[0], hang[1], spacing)
    t = _stations(y, hang[2], hang[3], spacing)
    s, t = np.meshgrid(s, t, indexing="ij")
    ex = np.minimum(s - x[0], 0) + np.maximum(s - x[1], 0)
    ey = np.minimum(t - y[0], 0) + np.maximum(t - y[1], 0)
    over = np.hypot(ex, ey)
    px, py = np.clip(s, *x), np.clip(t, *y)
    ux, uy = ex / (over + 1e-9), ey / (over + 1e-9)
    along = px + py + 0.4 * np.arctan2(uy, ux) * (over > 0)
    number = rng.uniform(9, 16, 4)
    phase = rng.uniform(0, 2 * np.pi, 4)
    ripple = np.sin(along[..., None] * number + phase).sum(-1) / 2
    deepest = max(hang) + 1e-9
    share = np.clip(over / deepest, 0, 1)
    reach = thickness + 0.06 * over + folds * share * (1 + ripple)
    out = reach * (1 - np.exp(-over / (0.35 * thickness + 0.01)))
    waves, shift = rng.normal(0, 5, (5, 2)), rng.uniform(0, 2 * np.pi, 5)
    bumps = np.sin(s[..., None] * waves[:, 0] + t[..., None] * waves[:, 1] + shift).sum(-1)
    top = z + thickness + puff * np.clip(0.5 + bumps / 4, 0.0, 1.5)
    points = np.stack([px + ux * out, py + uy * out, top - 0.97 * over], -1)
    return cloth(points, thickness)


def _stations(limits: tuple[float, float], before: float, after: float, spacing: float) -> Points:
    """Grid lines along one direction of a covering: denser near the edges."""
    low = limits[0] - before * np.linspace(1, 0.05, 6) if before > 0.01 else np.empty(0)
    high = limits[1] + after * np.linspace(0.05, 1, 6) if after > 0.01 else np.empty(0)
    inner = np.linspace(*limits, max(round((limits[1] - limits[0]) / spacing), 4) + 1)
    return np.concatenate([low, inner, high])


def towel(rng: np.random.Generator, width: float, front: float, back: float, bar: float) -> Mesh:
    """A towel folded over a bar along x of radius ``bar`` at the origin; lengths down, m."""
    turn = np.linspace(np.pi, 0, 7)
    gap = bar + 0.006
    arc = np.stack([gap * np.cos(turn), gap * np.sin(turn)], -1)
    fall = np.linspace(1, 0.05, 9)[:, None]
    path = np.concatenate(
        [[-gap, 0.0] - fall * [0.01, front], arc, [gap, 0.0] - fall[::-1] * [0.004, back]]
    )
    u = np.linspace(-0.5, 0.5, 15)
    points = np.empty((15, len(path), 3))
    drop = np.clip(-path[:, 1], 0, None)
    ripple = np.sin(u[:, None] * rng.uniform(8, 18) + rng.uniform(0, 6, 1) + 2 * drop)
    points[..., 0] = u[:, None] * width * (1 + 0.03 * drop)
    lift = rng.uniform(0.01, 0.03) * np.minimum(drop, 0.4) / 0.4 * (0.8 + ripple)
    points[..., 1] = path[:, 0] + lift * np.where(path[:, 0] < 0, -1, 0.15)
    points[..., 2] = path[:, 1]
    return cloth(points, 0.005)


def garment(
    rng: np.random.Generator, length: float, shoulder: float, thickness: float = 0.09
) -> Mesh:
    """A coat or shirt on a hanger, hung from the origin (the collar), facing -y; with sleeves."""
    angle = np.arange(26) * (2 * np.pi / 26)
    t = np.array([0, 0.03, 0.08, 0.14, 0.22, 0.38, 0.55, 0.75, 0.9, 1.0])[::-1]
    half = shoulder / 2
    wide = half * np.clip(0.22 + 6.2 * t, 0, 1) * np.where(t < 0.14, 1, 0.86)
    wide *= 1 + rng.uniform(0.0, 0.35) * np.clip(t - 0.3, 0, 1)
    deep = thickness / 2 * np.clip(0.55 + 3 * t, 0, 1) * (1 + rng.uniform(0, 0.8) * t)
    folds = rng.uniform(0.08, 0.3) * np.clip(t - 0.15, 0, 1)
    number = int(rng.integers(5, 10))
    wave = 1 + folds[:, None] * np.sin(number * angle + rng.uniform(0, 6))
    square = np.abs(np.sin(angle)) ** 0.7 * np.sign(np.sin(angle))
    rings = np.empty((len(t), 26, 3))
    rings[..., 0] = wide[:, None] * np.cos(angle) * (1 + 0.25 * (wave - 1))
    rings[..., 1] = deep[:, None] * square * wave
    rings[..., 2] = -length * t[:, None]
    closing = np.stack([rings[0] * [0, 0, 1], rings[-1] * [0, 0, 1]])
    body = shell(np.concatenate([closing[:1], rings[:1], rings, rings[-1:], closing[1:]]))
    arm = min(0.62, 0.75 * length) * np.linspace(0, 1, 5)
    bow = rng.uniform(0.02, 0.06)
    x = 0.92 * half + bow * np.sin(np.linspace(0, 2.2, 5))
    y = -rng.uniform(0.0, 0.05) * np.linspace(0, 1, 5)
    sleeve = np.stack([x, y, -0.085 * length - 0.02 - arm], -1)
    radius = np.linspace(0.062, 0.045, 5) * rng.uniform(0.85, 1.1)
    arm = tube(sleeve, radius, 8)
    arms = [arm, mirrored(arm)]
    return joined([body, *arms])
