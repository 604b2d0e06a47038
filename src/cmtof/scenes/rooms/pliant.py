"""What bends or comes by the hundred: curves through points, bars, leaves, cloth with a hem."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.rooms.solids import faceted, joined, quads, revolve, sheet
from cmtof.scenes.rooms.thing import Mesh, Thing

Points = NDArray[np.float64]


def spline(points: ArrayLike, count: int = 40) -> Points:
    """Smooth curve (count, 3) through points (N, 3), m (Catmull and Rom, 1974).

    Examples
    --------
    >>> spline([[0, 0, 0], [1, 1, 0], [2, 0, 0]], 5)[[0, 2, 4]].tolist()
    [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 0.0, 0.0]]
    """
    p = np.asarray(points, float)
    p = np.concatenate([2 * p[:1] - p[1:2], p, 2 * p[-1:] - p[-2:-1]])
    at = np.linspace(0, len(p) - 3, count)
    k = np.minimum(at.astype(int), len(p) - 4)
    t = (at - k)[:, None]
    a, b, c, d = p[k], p[k + 1], p[k + 2], p[k + 3]
    bend = (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3
    return b + 0.5 * ((c - a) * t + bend)


def unit(vectors: ArrayLike) -> Points:
    """Vectors (..., 3) brought to length 1."""
    v = np.asarray(vectors, float)
    return v / (np.linalg.norm(v, axis=-1, keepdims=True) + 1e-12)


def across(direction: ArrayLike) -> tuple[Points, Points]:
    """Two unit vectors that make a right-handed frame with each direction (..., 3), the third."""
    d = unit(direction)
    level = np.abs(d[..., 2:]) < 0.95
    first = unit(np.cross(np.where(level, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]), d))
    return first, np.cross(d, first)


def bars(
    starts: ArrayLike, ends: ArrayLike, radius: ArrayLike, sides: int = 4, taper: float = 1.0
) -> Mesh:
    """Many straight bars at once, open at their ends: stalks, wires, spines, fringes.

    Parameters
    ----------
    starts, ends : array_like, shape (K, 3)
        m.
    radius : array_like
        At the start, m, one or one a bar; the end has ``taper`` times as much.
    """
    starts, ends = np.asarray(starts, float), np.asarray(ends, float)
    one, two = across(ends - starts)
    radius = np.broadcast_to(np.asarray(radius, float), len(starts))[:, None, None]
    angle = np.arange(sides) * (2 * np.pi / sides)
    ring = np.cos(angle)[:, None] * one[:, None] + np.sin(angle)[:, None] * two[:, None]
    low = starts[:, None] + radius * ring
    high = ends[:, None] + taper * radius * ring
    vertices = np.stack([low, high], axis=1).reshape(-1, 3)
    k = np.arange(sides, dtype=np.int32)
    j = (k + 1) % sides
    faces = np.concatenate(
        [np.stack([k, j, j + sides], -1), np.stack([k, j + sides, k + sides], -1)]
    )
    first = 2 * sides * np.arange(len(starts), dtype=np.int32)
    return Mesh(vertices.astype(np.float32), _at_each(faces, first))


def _at_each(faces: NDArray, first: NDArray) -> NDArray[np.int32]:
    """The same faces for each of many copies whose vertices begin at ``first``."""
    return (first[:, None, None] + faces).reshape(-1, 3).astype(np.int32)


def sheets(points: ArrayLike, thickness: float = 4e-4) -> Mesh:
    """Many small sheets at once, (K, N, M, 3), m, each with its back: leaves, petals, slats.

    The outside is ``d/d(axis 1) x d/d(axis 2)``; the back lies ``thickness`` inwards and meets the
    front at the edges.
    """
    p = np.asarray(points, float)
    copies, n, m = p.shape[:3]
    normal = unit(np.cross(np.gradient(p, axis=1), np.gradient(p, axis=2)))
    faces = sheet(p[0]).faces
    first = n * m * np.arange(copies, dtype=np.int32)
    front = Mesh(p.reshape(-1, 3).astype(np.float32), _at_each(faces, first))
    inside = np.zeros((n, m, 1))
    inside[1:-1, 1:-1] = thickness
    back = (p - inside * normal).reshape(-1, 3).astype(np.float32)
    return joined([front, Mesh(back, front.faces[:, ::-1].copy())])


def slab(points: ArrayLike, thickness: float) -> Mesh:
    """A sheet (N, M, 3), m, with a back and a hem around it: closed, so it has a volume."""
    p = np.asarray(points, float)
    both = sheet(p, thickness=thickness)
    front, back = both.vertices.reshape(2, *p.shape)
    loop = _border(p.shape[0], p.shape[1])
    one, two = front[loop[:, 0], loop[:, 1]], back[loop[:, 0], loop[:, 1]]
    ahead = np.roll(np.arange(len(loop)), -1)
    return joined([both, quads(np.stack([two, two[ahead], one[ahead], one], axis=1))])


def _border(n: int, m: int) -> NDArray:
    """Indices (2 (n + m) - 4, 2) around an n by m grid, counter-clockwise seen from outside."""
    i, j = np.arange(n), np.arange(m)
    around = [
        np.stack([i[:-1], np.zeros(n - 1, int)], -1),
        np.stack([np.full(m - 1, n - 1), j[:-1]], -1),
        np.stack([i[:0:-1], np.full(n - 1, m - 1)], -1),
        np.stack([np.zeros(m - 1, int), j[:0:-1]], -1),
    ]
    return np.concatenate(around)


def loft(rings: ArrayLike) -> Mesh:
    """A closed body through rings (R, N, 3), m, that run against the clock about the way ahead."""
    r = np.asarray(rings, float)
    low = np.broadcast_to(r[0].mean(axis=0), r[0].shape)
    high = np.broadcast_to(r[-1].mean(axis=0), r[0].shape)
    return sheet(np.stack([low, r[0], *r, r[-1], high])[:, ::-1], closed=True)


def ripples(
    rng: np.random.Generator, x: ArrayLike, y: ArrayLike, waves: int = 8, longest: float = 0.5
) -> Points:
    """Smooth random field at (x, y), m, about -1 to 1; waves from a quarter of ``longest`` on."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    angle = rng.uniform(0, 2 * np.pi, waves)
    length = longest * rng.uniform(0.25, 1.0, waves)
    phase = rng.uniform(0, 2 * np.pi, waves)
    k = 2 * np.pi / length
    wave = (k * np.cos(angle)) * x[..., None] + (k * np.sin(angle)) * y[..., None] + phase
    weight = length / np.sqrt((length**2).sum() / 2)
    return np.sin(wave) @ weight / 2


def grid(x0: float, x1: float, y0: float, y1: float, n: int, m: int) -> tuple[Points, Points]:
    """Coordinates x and y, each (n, m), of a level grid whose outside is up, m."""
    x, y = np.meshgrid(np.linspace(x0, x1, n), np.linspace(y0, y1, m), indexing="ij")
    return x, y


def four_sided(profile: ArrayLike) -> Mesh:
    """A profile (half side, height), m, carried around a square instead of turned."""
    half, height = np.asarray(profile, float).T
    ring = revolve(np.column_stack([np.sqrt(2) * half, height]), 4)
    eighth = np.array([[1, 1, 0], [-1, 1, 0], [0, 0, np.sqrt(2)]]) / np.sqrt(2)
    return faceted(Mesh((ring.vertices @ eighth).astype(np.float32), ring.faces))


def against_wall(mesh: Mesh) -> Mesh:
    """A mesh whose z axis becomes -y, so that discs lie against the wall."""
    turn = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], np.float32)
    return Mesh(mesh.vertices @ turn, mesh.faces)


def moved_by(mesh: Mesh, x: float, y: float, z: float) -> Mesh:
    """A mesh shifted, m."""
    return Mesh(mesh.vertices + np.array([x, y, z], np.float32), mesh.faces)


def shifted(thing: Thing, x: float, y: float, z: float) -> Thing:
    """The thing itself, its parts and its lights moved, m."""
    thing.parts = [p._replace(mesh=moved_by(p.mesh, x, y, z)) for p in thing.parts]
    thing.lights = [
        light._replace(centre=(light.centre[0] + x, light.centre[1] + y, light.centre[2] + z))
        for light in thing.lights
    ]
    return thing


def centred(thing: Thing) -> Thing:
    """Move a thing so that its footprint's middle is the origin and its lowest point z = 0."""
    low, high = thing.bounds
    return shifted(thing, -(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2])


def hung(thing: Thing) -> Thing:
    """Move a thing so that its back touches the wall, y = 0, about x = 0 and z = 0."""
    low, high = thing.bounds
    return shifted(thing, -(low[0] + high[0]) / 2, -high[1], -(low[2] + high[2]) / 2)
