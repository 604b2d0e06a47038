"""Meshes of simple solids, m, from which every thing is made.

One parametric grid (`sheet`) makes whatever bends: turned ware, tubes, cloth, cushions.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.rooms.bars import bar
from cmtof.scenes.rooms.thing import Mesh

Points = NDArray[np.float64]


def joined(meshes: list[Mesh]) -> Mesh:
    """Several meshes as one; they stay apart at their vertices."""
    starts = np.cumsum([0] + [len(m.vertices) for m in meshes[:-1]])
    faces = [m.faces + np.int32(s) for m, s in zip(meshes, starts, strict=True)]
    return Mesh(np.concatenate([m.vertices for m in meshes]), np.concatenate(faces))


def faceted(mesh: Mesh) -> Mesh:
    """The same solid with a crease at every edge."""
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    return Mesh(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3))


def quads(corners: ArrayLike) -> Mesh:
    """Flat quadrilaterals (N, 4, 3), counter-clockwise from outside, each with its own vertices."""
    vertices = np.asarray(corners, np.float32).reshape(-1, 3)
    first = np.arange(0, len(vertices), 4, dtype=np.int32)[:, None]
    faces = np.concatenate([first + np.array([0, 1, 2]), first + np.array([0, 2, 3])]).astype(
        np.int32
    )
    return Mesh(vertices, faces)


_SIGNS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
_BOX = np.array(
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
)


def box(size: ArrayLike, centre: ArrayLike = (0.0, 0.0, 0.0), bevel: float = 0.0) -> Mesh:
    """A box; ``bevel`` breaks its edges by that many metres and shades them round.

    Parameters
    ----------
    size, centre : array_like, shape (3,)
        m.
    bevel : float
        m; at most a third of the shortest side is taken.

    Examples
    --------
    >>> [len(a) for a in box((1, 1, 1))], [len(a) for a in box((1, 1, 1), bevel=0.1)]
    ([24, 12], [24, 44])
    """
    half, centre = np.asarray(size, float) / 2, np.asarray(centre, float)
    if bevel <= 0:
        corners = _SIGNS * half + centre
        return quads(corners[_BOX])
    vertices, faces = _bevelled_unit()
    cut = min(bevel, 2 * half.min() / 3)
    reach = np.sign(vertices) * (half - cut * (np.abs(vertices) < 1))
    return Mesh((reach + centre).astype(np.float32), faces)


@lru_cache(maxsize=1)
def _bevelled_unit() -> tuple[Points, NDArray[np.int32]]:
    """Convex hull of a cube with cut corners; 1 marks the coordinate that stays at the face."""
    import trimesh

    vertices = np.array([np.where(np.arange(3) == a, 1, 0.5) * s for s in _SIGNS for a in range(3)])
    hull = trimesh.convex.convex_hull(vertices)
    order = [int(np.argmin(((hull.vertices - v) ** 2).sum(1))) for v in vertices]
    rank = np.empty(24, np.int32)
    rank[order] = np.arange(24, dtype=np.int32)
    return vertices, rank[hull.faces].astype(np.int32)


def sheet(points: ArrayLike, *, closed: bool = False, thickness: float = 0.0) -> Mesh:
    """A surface through a grid of points (N, M, 3), its outside where rows × columns point.

    Parameters
    ----------
    points : array_like, shape (N, M, 3)
        m; index 0 runs along rows, index 1 along columns; the outside is
        ``d/d(index 0) x d/d(index 1)``.
    closed : bool
        The last column joins the first (tubes, turned ware).
    thickness : float
        m; a second side is added that far inwards, so that cloth is seen from both sides.
    """
    points = np.asarray(points, float)
    n, m = points.shape[:2]
    index = np.arange(n * m, dtype=np.int32).reshape(n, m)
    if closed:
        index = np.concatenate([index, index[:, :1]], axis=1)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    front = Mesh(points.reshape(-1, 3).astype(np.float32), faces)
    if thickness <= 0:
        return front
    du, dv = np.gradient(points, axis=0), np.gradient(points, axis=1)
    normal = np.cross(du, dv)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True) + 1e-12
    back = (points - thickness * normal).reshape(-1, 3).astype(np.float32)
    return joined([front, Mesh(back, faces[:, ::-1].copy())])


def revolve(profile: ArrayLike, sides: int = 40) -> Mesh:
    """Turn a profile (N, 2) of radius and height, m, from bottom to top, about the vertical.

    The outside is to the right of the way up; a profile that turns over the rim and comes down
    inside makes a vessel. A repeated point makes a crease.
    """
    profile = np.asarray(profile, float)
    angle = np.arange(sides) * (2 * np.pi / sides)
    ring = np.stack([np.cos(angle), np.sin(angle)], -1)
    points = np.empty((len(profile), sides, 3))
    points[..., :2] = profile[:, None, :1] * ring
    points[..., 2] = profile[:, 1:]
    return sheet(points[:, ::-1], closed=True)


def cylinder(
    radius: float,
    height: float,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    *,
    top: float | None = None,
    sides: int = 20,
) -> Mesh:
    """An upright cylinder or, with another radius at the top, a frustum; creased at its caps."""
    top = radius if top is None else top
    h = height / 2
    mesh = revolve([(0, -h), (radius, -h), (radius, -h), (top, h), (top, h), (0, h)], sides)
    return Mesh(mesh.vertices + np.asarray(centre, np.float32), mesh.faces)


def tube(path: ArrayLike, radius: ArrayLike, sides: int = 8, *, capped: bool = True) -> Mesh:
    """A tube along a path (N, 3), m, of one radius or one a point: cables, legs, branches, rods."""
    path = np.asarray(path, float)
    radii = np.broadcast_to(np.asarray(radius, float), len(path)).copy()
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True) + 1e-12
    side = np.array(_sides(along.tolist()))
    other = np.stack(
        [
            along[:, 1] * side[:, 2] - along[:, 2] * side[:, 1],
            along[:, 2] * side[:, 0] - along[:, 0] * side[:, 2],
            along[:, 0] * side[:, 1] - along[:, 1] * side[:, 0],
        ],
        axis=-1,
    )
    angle = np.arange(sides) * (-2 * np.pi / sides)
    ring = np.cos(angle)[:, None] * side[:, None] + np.sin(angle)[:, None] * other[:, None]
    rings = path[:, None] + radii[:, None, None] * ring
    if capped:  # a crease, and the middle of either end
        ends = np.broadcast_to(path[[0, -1], None], (2, sides, 3))
        rings = np.concatenate([ends[:1], rings[:1], rings, rings[-1:], ends[1:]])
    return sheet(rings, closed=True)


def _sides(along: list[list[float]]) -> list[tuple[float, float, float]]:
    """A unit vector square to each direction; the frame turns with the path, never about it."""
    x, y, z = along[0]
    u, v, w = (y, -x, 0.0) if abs(z) < 0.9 else (0.0, z, -y)
    made = []
    for x, y, z in along:
        dot = u * x + v * y + w * z
        u, v, w = u - x * dot, v - y * dot, w - z * dot
        size = (u * u + v * v + w * w) ** 0.5 + 1e-12
        u, v, w = u / size, v / size, w / size
        made.append((u, v, w))
    return made


def rod(start: ArrayLike, end: ArrayLike, radius: float, sides: int = 8) -> Mesh:
    """A straight round bar from one point to another, m."""
    return bar(start, end, radius, sides)


def cushion(size: ArrayLike, centre: ArrayLike = (0, 0, 0), *, square: float = 0.35) -> Mesh:
    """A superellipsoid: a pillow at ``square`` 0.35, a ball at 1, nearly a box at 0.1."""
    half = np.asarray(size, float) / 2
    u = np.linspace(-np.pi / 2, np.pi / 2, 15)
    v = np.linspace(-np.pi, np.pi, 28, endpoint=False)

    def power(x: Points) -> Points:
        return np.sign(x) * np.abs(x) ** square

    points = np.empty((15, 28, 3))
    points[..., 0] = power(np.cos(u))[:, None] * power(np.cos(v))
    points[..., 1] = power(np.cos(u))[:, None] * power(np.sin(v))
    points[..., 2] = power(np.sin(u))[:, None]
    return sheet((points * half + np.asarray(centre, float))[:, ::-1], closed=True)


@lru_cache(maxsize=8)
def _icosphere(subdivisions: int) -> Mesh:
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=1.0)
    return Mesh(ball.vertices.astype(np.float32), ball.faces.astype(np.int32))


def ball(radius: float, centre: ArrayLike = (0.0, 0.0, 0.0), subdivisions: int = 3) -> Mesh:
    """A sphere of 80·4^(subdivisions-1) triangles."""
    unit = _icosphere(subdivisions)
    return Mesh(unit.vertices * np.float32(radius) + np.asarray(centre, np.float32), unit.faces)


def blob(
    rng: np.random.Generator,
    size: ArrayLike,
    *,
    roughness: float = 0.2,
    waves: int = 24,
    subdivisions: int = 4,
) -> Mesh:
    """A displaced sphere standing on z = 0: fruit and stones when smooth, crumpled when rough.

    The radius is multiplied by ``1 + roughness * s`` with s a sum of ``waves`` random plane waves.
    """
    unit = _icosphere(subdivisions)
    frequency = rng.normal(size=(waves, 3)) * rng.uniform(1, 6, (waves, 1))
    weight = rng.normal(size=waves) / np.linalg.norm(frequency, axis=1)
    swell = np.sin(unit.vertices @ frequency.T + rng.uniform(0, 2 * np.pi, waves)) @ weight
    swell /= np.abs(swell).max() + 1e-12
    points = unit.vertices * (1 + roughness * swell[:, None]) * (np.asarray(size, float) / 2)
    points[:, 2] -= points[:, 2].min()
    return Mesh(points.astype(np.float32), unit.faces)


def prism(outline: ArrayLike, height: float) -> Mesh:
    """A convex outline (N, 2), counter-clockwise, m, raised from z = 0 to ``height``."""
    outline = np.asarray(outline, float)
    n = len(outline)
    low = np.column_stack([outline, np.zeros(n)])
    high = np.column_stack([outline, np.full(n, height)])
    following = np.roll(np.arange(n), -1)
    walls = quads(np.stack([low, low[following], high[following], high], axis=1))
    fan = np.stack([np.zeros(n - 2, int), np.arange(1, n - 1), np.arange(2, n)], -1).astype(
        np.int32
    )
    top = Mesh(high.astype(np.float32), fan)
    bottom = Mesh(low.astype(np.float32), fan[:, ::-1].copy())
    return joined([walls, top, bottom])
