"""What is sawn, bent and jointed: boards, beams, rods and frames by the dozen in one mesh, m."""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.rooms.solids import box, joined, quads, sheet
from cmtof.scenes.rooms.thing import Mesh, Thing, moved

Points = NDArray[np.float64]


@lru_cache(maxsize=1)
def _unit() -> tuple[Points, NDArray[np.bool_], NDArray[np.int32]]:
    """Signs of a bevelled box's vertices, where they are cut, and its faces."""
    unit = box((1, 1, 1), bevel=0.1)
    return np.sign(unit.vertices), np.abs(unit.vertices) < 0.45, unit.faces


def boards(limits: ArrayLike, bevel: float = 0.002) -> Mesh:
    """Many boxes at once.

    Parameters
    ----------
    limits : array_like, shape (N, 6)
        x0, x1, y0, y1, z0, z1 of each, m.
    bevel : float
        m, at most a third of a board's shortest side; 0 leaves the edges sharp.

    Examples
    --------
    >>> len(boards([(0, 1, 0, 1, 0, 1), (2, 3, 0, 1, 0, 1)]).faces)
    88
    """
    low, high = np.moveaxis(np.asarray(limits, float).reshape(-1, 3, 2), -1, 0)
    half, centre = (high - low)[:, None] / 2, (high + low)[:, None] / 2
    if bevel <= 0:
        sharp = box((2, 2, 2)).vertices.astype(float)
        return quads(sharp * half + centre)
    sign, cut_here, faces = _unit()
    cut = np.minimum(bevel, 2 * half.min(-1, keepdims=True) / 3)
    return _stacked(sign * (half - cut * cut_here) + centre, faces)


def _stacked(vertices: NDArray[np.floating], faces: NDArray[np.int32]) -> Mesh:
    """Copies (N, V, 3) of one set of faces as one mesh."""
    n, v = vertices.shape[:2]
    shift = (np.arange(n, dtype=np.int32) * v)[:, None, None]
    return Mesh(vertices.reshape(-1, 3).astype(np.float32), (faces + shift).reshape(-1, 3))


def copies(mesh: Mesh, offsets: ArrayLike) -> Mesh:
    """The same mesh at several places (N, 3), m."""
    offsets = np.asarray(offsets, float).reshape(-1, 1, 3)
    return _stacked(mesh.vertices + offsets, mesh.faces)


def shifted(mesh: Mesh, x: float, y: float, z: float) -> Mesh:
    """The same mesh elsewhere, m."""
    return Mesh(mesh.vertices + np.array([x, y, z], np.float32), mesh.faces)


def mirrored(mesh: Mesh, axis: int = 0) -> Mesh:
    """The mirror image in the plane through the origin across an axis."""
    flip = np.where(np.arange(3) == axis, -1, 1).astype(np.float32)
    return Mesh(mesh.vertices * flip, mesh.faces[:, ::-1].copy())


def placed(
    mesh: Mesh,
    at: ArrayLike = (0.0, 0.0, 0.0),
    *,
    lean: float = 0.0,
    tilt: float = 0.0,
    turn: float = 0.0,
) -> Mesh:
    """Turn a mesh about x by ``lean``, y by ``tilt``, z by ``turn``, rad, then shift it, m."""
    (a, b, c), (s, t, u) = np.cos([lean, tilt, turn]), np.sin([lean, tilt, turn])
    about_x = np.array([[1, 0, 0], [0, a, -s], [0, s, a]])
    about_y = np.array([[b, 0, t], [0, 1, 0], [-t, 0, b]])
    about_z = np.array([[c, -u, 0], [u, c, 0], [0, 0, 1]])
    motion = np.eye(4)
    motion[:3, :3] = about_z @ about_y @ about_x
    motion[:3, 3] = np.asarray(at, float)
    return moved(mesh, motion)


def _frames(starts: Points, ends: Points) -> tuple[Points, Points, Points]:
    """Direction of each bar and two axes of its section; upright bars have x and y."""
    along = ends - starts
    along /= np.linalg.norm(along, axis=1, keepdims=True) + 1e-12
    first = np.where(np.abs(along[:, :1]) > 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    side = first - along * (first * along).sum(1, keepdims=True)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return along, side, np.cross(along, side)


def _levelled(offset: Points, along: Points) -> Points:
    """Offsets of a section slid along steep bars until the cut is level, as legs are cut."""
    rise = along[:, 2]
    steep = np.abs(rise) > 0.6
    slope = np.where(steep, 1 / np.where(steep, rise, 1.0), 0.0)
    return offset - along[:, None] * (offset[..., 2] * slope[:, None])[..., None]


def beams(
    starts: ArrayLike,
    ends: ArrayLike,
    width: float,
    thickness: float,
    *,
    taper: float = 1.0,
    chamfer: float = 0.002,
) -> Mesh:
    """Straight bars of rectangular section with chamfered edges; steep ones are cut level.

    Parameters
    ----------
    starts, ends : array_like, shape (N, 3)
        Middles of the two ends, m.
    width, thickness : float
        Section, m: along x and y for upright bars, y and z along x, x and z along y.
    taper : float
        Factor on the section at the start.
    """
    starts, ends = (np.asarray(p, float).reshape(-1, 3) for p in (starts, ends))
    along, side, other = _frames(starts, ends)
    a, b, c = width / 2, thickness / 2, min(chamfer, 0.3 * min(width, thickness))
    u = np.array([a, a, a - c, c - a, -a, -a, c - a, a - c])
    v = np.array([c - b, b - c, b, b, b - c, c - b, -b, -b])
    offset = u[:, None] * side[:, None] + v[:, None] * other[:, None]
    low = starts[:, None] + _levelled(taper * offset, along)
    high = ends[:, None] + _levelled(offset, along)
    nxt = np.roll(np.arange(8), -1)
    walls = quads(np.stack([low, low[:, nxt], high[:, nxt], high], 2).reshape(-1, 4, 3))
    fan = np.array([(0, k, k + 1) for k in range(1, 7)], np.int32)
    return joined([walls, _stacked(low, fan[:, ::-1]), _stacked(high, fan)])


def rods(
    starts: ArrayLike, ends: ArrayLike, radius: float, *, taper: float = 1.0, sides: int = 8
) -> Mesh:
    """Straight round bars; ``taper`` is the factor on the radius at the start; see `beams`."""
    starts, ends = (np.asarray(p, float).reshape(-1, 3) for p in (starts, ends))
    along, side, other = _frames(starts, ends)
    angle = np.arange(sides) * (2 * np.pi / sides)
    ring = np.cos(angle)[:, None] * side[:, None] + np.sin(angle)[:, None] * other[:, None]
    low = starts[:, None] + _levelled(taper * radius * ring, along)
    high = ends[:, None] + _levelled(radius * ring, along)
    k, nxt = np.arange(sides), np.roll(np.arange(sides), -1)
    walls = [(k, nxt, nxt + sides), (k, nxt + sides, k + sides)]
    wall = np.concatenate([np.stack(t, -1) for t in walls]).astype(np.int32)
    fan = np.array([(0, j, j + 1) for j in range(1, sides - 1)], np.int32)
    body = _stacked(np.concatenate([low, high], 1), wall)
    return joined([body, _stacked(low, fan[:, ::-1]), _stacked(high, fan)])


def plank(path: ArrayLike, across: ArrayLike, thickness: float) -> Mesh:
    """A bent board: rectangular section carried along a path (N, 3), m, creased at its corners.

    Parameters
    ----------
    path : array_like, shape (N, 3)
        Middle of the board, m.
    across : array_like, shape (3,) or (N, 3)
        From one edge to the other, m.
    thickness : float
        At right angles to the path and ``across``, m.
    """
    path = np.asarray(path, float)
    across = np.broadcast_to(np.asarray(across, float), path.shape)
    normal = np.cross(np.gradient(path, axis=0), across)
    normal *= thickness / 2 / (np.linalg.norm(normal, axis=1, keepdims=True) + 1e-12)
    half = across / 2
    corners = [path - half - normal, path + half - normal, path + half + normal,
               path - half + normal]  # fmt: skip
    sides = [
        sheet(np.stack([p, q], 1)[:, ::-1])
        for p, q in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    ends = quads([[c[0] for c in reversed(corners)], [c[-1] for c in corners]])
    return joined([*sides, ends])


def bent(corners: ArrayLike, radius: float, *, steps: int = 5, closed: bool = False) -> Points:
    """Path through corners (N, 3) that are rounded with a radius, m, as steel tube is bent."""
    corners = np.asarray(corners, float)
    n, path = len(corners), []
    t = np.linspace(0, 1, steps)[:, None]
    for k in range(n):
        if not closed and k in (0, n - 1):
            path.append(corners[k : k + 1])
            continue
        p, q, r = corners[k - 1], corners[k], corners[(k + 1) % n]
        to, on = p - q, r - q
        reach = min(radius, 0.49 * float(np.linalg.norm(to)), 0.49 * float(np.linalg.norm(on)))
        a = q + to * reach / (np.linalg.norm(to) + 1e-12)
        b = q + on * reach / (np.linalg.norm(on) + 1e-12)
        path.append((1 - t) ** 2 * a + 2 * t * (1 - t) * q + t**2 * b)
    whole = np.concatenate(path)
    return np.concatenate([whole, whole[:1]]) if closed else whole


def raised(points: ArrayLike, height: float) -> Points:
    """Points moved up, m."""
    return np.asarray(points, float) + np.array([0.0, 0.0, height])


def rounded(points: ArrayLike, times: int = 2) -> Points:
    """An open line (N, D) with its corners cut off, again and again (Chaikin); its ends stay."""
    points = np.asarray(points, float)
    for _ in range(times):
        p, q = points[:-1], points[1:]
        cut = np.stack([0.75 * p + 0.25 * q, 0.25 * p + 0.75 * q], 1).reshape(-1, points.shape[1])
        points = np.concatenate([points[:1], cut[1:-1], points[-1:]])
    return points


def frame(
    x: tuple[float, float],
    y: tuple[float, float],
    z: tuple[float, float],
    width: float,
    bevel: float = 0.002,
) -> Mesh:
    """Four boards around an opening that looks along y: stiles of full height, rails between."""
    (x0, x1), (z0, z1) = x, z
    return boards(
        [
            (x0, x0 + width, *y, z0, z1),
            (x1 - width, x1, *y, z0, z1),
            (x0 + width, x1 - width, y[0] + 0.0006, y[1] - 0.0006, z0, z0 + width),
            (x0 + width, x1 - width, y[0] + 0.0006, y[1] - 0.0006, z1 - width, z1),
        ],
        bevel,
    )


def corners(x: float, y: float, z: float = 0.0) -> Points:
    """The four points (±x, ±y, z): where legs stand."""
    return np.array([(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)])


def faceted_rings(rings: ArrayLike) -> Mesh:
    """A flat-sided solid through rings (N, M, 3), each counter-clockwise seen from above, upwards.

    The first and the last ring are closed by flat caps (M ≥ 3, convex).
    """
    rings = np.asarray(rings, float)
    nxt = np.roll(np.arange(rings.shape[1]), -1)
    low, high = rings[:-1], rings[1:]
    walls = np.stack([low, low[:, nxt], high[:, nxt], high], 2).reshape(-1, 4, 3)
    fan = np.array([(0, k, k + 1) for k in range(1, rings.shape[1] - 1)], np.int32)
    caps = [_stacked(rings[:1], fan[:, ::-1]), _stacked(rings[-1:], fan)]
    return joined([quads(walls), *caps])


def centred(thing: Thing, *, along: str = "xy") -> Thing:
    """Shift a thing that was built off its origin until its footprint is centred."""
    low, high = thing.bounds
    share = np.array([axis in along for axis in "xy"], float)
    shift = (-(low + high)[:2] / 2 * share).astype(np.float32)
    for part in thing.parts:
        part.mesh.vertices[:, :2] += shift
    dx, dy = (float(v) for v in shift)
    thing.supports = [
        s._replace(x0=s.x0 + dx, x1=s.x1 + dx, y0=s.y0 + dy, y1=s.y1 + dy) for s in thing.supports
    ]
    return thing
