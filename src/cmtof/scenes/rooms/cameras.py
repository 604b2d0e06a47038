"""Where cameras stand: as people do in a room, and close to things at 0.5 to 1.2 m."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.scenes.rooms.assembly import Geometry
from cmtof.scenes.rooms.tracing import Tracer

Vector = NDArray[np.float64]

TRIES = 32
"""Places drawn for each view."""
_PROBE = 20  # a candidate is judged by that many rays squared
_CLOSE = (0.5, 1.2)  # m
_FAR = np.float32(50.0)  # m, what a ray that leaves counts for
_AIR = 0.22  # m, free all round the camera


class Lens(NamedTuple):
    """A pinhole with its centre in the middle of the picture."""

    shape: tuple[int, int]
    """(H, W), px."""
    focal: float
    """px."""

    def rays(self, orientation: Vector) -> NDArray[np.float32]:
        """Unit vectors (H, W, 3) in the world through the pixels' centres (at +0.5)."""
        height, width = self.shape
        u = ((np.arange(width) + 0.5 - width / 2) / self.focal).astype(np.float32)
        v = ((height / 2 - 0.5 - np.arange(height)) / self.focal).astype(np.float32)
        right, up, back = orientation.T.astype(np.float32)
        world = u[None, :, None] * right + v[:, None, None] * up - back
        return world / np.sqrt(1 + u[None, :, None] ** 2 + v[:, None, None] ** 2)


class Camera(NamedTuple):
    """One pose: position (3,), m, and orientation (3, 3), world from camera.

    Columns are the camera's axes: right, up, backwards (it looks along -z).
    """

    position: Vector
    orientation: Vector


def looking(position: Vector, target: Vector, roll: float = 0.0) -> Camera:
    """A camera at ``position`` that looks at ``target``, m, rolled by ``roll``, rad.

    Examples
    --------
    >>> looking(np.zeros(3), np.array([0.0, 1.0, 0.0])).orientation.round(6).tolist()
    [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    """
    back = position - target
    back = back / np.linalg.norm(back)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    c, s = np.cos(roll), np.sin(roll)
    return Camera(position, np.stack([c * right + s * up, c * up - s * right, back], -1))


def room_cameras(
    count: int,
    *,
    floor: list[tuple[float, float, float, float]],
    height: float,
    tracer: Tracer,
    geometry: Geometry,
    lens: Lens,
    rng: np.random.Generator,
) -> list[Camera]:
    """Views across the room from where a person could stand or sit.

    Of the places drawn for each view, those without air around them or with a wall before them
    are left out; the one whose median range is nearest to a drawn one is taken. Those ranges are
    spread as interiors are: log-normal about 6 m.

    Parameters
    ----------
    count : int
        Views.
    floor : list of (x0, x1, y0, y1)
        Rectangles where a camera may stand, m.
    height : float
        Of the ceiling, m.
    """
    area = np.array([(x1 - x0) * (y1 - y0) for x0, x1, y0, y1 in floor])
    views: list[Camera] = []
    for _ in range(count):
        wanted = 6.0 * np.exp(0.35 * rng.normal())
        candidates = []
        for _ in range(TRIES):
            x0, x1, y0, y1 = floor[int(rng.choice(len(floor), p=area / area.sum()))]
            eye_height = min(float(rng.choice([1.1, 1.5, 1.65, 1.9])), height - 0.4)
            a, b = rng.beta(0.5, 0.5, 2)  # with one's back to the wall, mostly
            eye = np.array([x0 + a * (x1 - x0), y0 + b * (y1 - y0), eye_height])
            heading = rng.uniform(0, 2 * np.pi)
            pitch = np.radians(rng.normal(-9, 8))
            ahead = np.array([np.cos(heading), np.sin(heading), np.tan(pitch)])
            candidates.append(looking(eye, eye + ahead, np.radians(rng.normal(0, 1.5))))
        alike = _alike(candidates, views)
        views.append(_best(candidates, wanted, tracer, geometry, lens, alike))
    return views


def close_cameras(
    count: int,
    *,
    things: NDArray[np.int32],
    floor: list[tuple[float, float, float, float]],
    height: float,
    tracer: Tracer,
    geometry: Geometry,
    lens: Lens,
    rng: np.random.Generator,
) -> list[Camera]:
    """Views of single things from 0.5 to 1.2 m away: what stands on tables, plants, chairs.

    Parameters
    ----------
    count : int
        Views.
    things : ndarray of int
        Instances worth a look.
    floor : list of (x0, x1, y0, y1)
        Rectangles above which things are looked at, m.
    height : float
        Of the ceiling, m.
    """
    centres, sizes = _things(geometry)
    fits = (sizes > 0.1) & (sizes < 1.3) & _above(floor, centres) & (centres[:, 2] < height - 0.2)
    fit = things[fits[things]]
    if not len(fit):
        fit = things
    views: list[Camera] = []
    for _ in range(count):
        wanted = rng.uniform(0.7, _CLOSE[1])
        candidates = []
        for _ in range(TRIES):
            target = centres[int(rng.choice(fit))] + rng.normal(0, 0.05, 3)
            heading, rise = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(0, 45))
            away = np.array([np.cos(heading), np.sin(heading), np.tan(rise)])
            eye = target + away / np.linalg.norm(away) * rng.uniform(*_CLOSE)
            candidates.append(looking(eye, target, np.radians(rng.normal(0, 3))))
        eyes = np.stack([c.position for c in candidates])
        inside = _above(floor, eyes) & (eyes[:, 2] > 0.2) & (eyes[:, 2] < height - 0.1)
        kept = [c for c, good in zip(candidates, inside, strict=True) if good] or candidates
        alike = _alike(kept, views)
        views.append(_best(kept, wanted, tracer, geometry, lens, alike, close=True))
    return views


def _above(floor: list[tuple[float, float, float, float]], points: Vector) -> NDArray[np.bool_]:
    """Which of the points (N, 3) lie above one of the rectangles."""
    x, y = points[:, 0], points[:, 1]
    inside = [(x > x0) & (x < x1) & (y > y0) & (y < y1) for x0, x1, y0, y1 in floor]
    return np.any(inside, axis=0)


def _things(geometry: Geometry) -> tuple[Vector, Vector]:
    """Centre (N, 3) and largest extent (N,) of every thing, m."""
    of_vertex = np.empty(len(geometry.vertices), np.int64)
    of_vertex[geometry.faces] = geometry.instance[geometry.part][:, None]
    count = len(geometry.kinds) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, of_vertex, geometry.vertices)
    np.maximum.at(high, of_vertex, geometry.vertices)
    empty = ~np.isfinite(low).all(axis=1)
    low[empty], high[empty] = 0, 0
    return (low + high) / 2, (high - low).max(axis=1)


def _best(
    candidates: list[Camera],
    wanted: float,
    tracer: Tracer,
    geometry: Geometry,
    lens: Lens,
    alike: Vector,
    *,
    close: bool = False,
) -> Camera:
    """The candidate with air around it, enough to see, and a median range nearest ``wanted``."""
    coarse = Lens((_PROBE, _PROBE), lens.focal * _PROBE / max(lens.shape))
    inside = coarse.rays(np.eye(3)).reshape(-1, 3)
    turns = np.stack([c.orientation for c in candidates]).astype(np.float32)
    probes = np.ascontiguousarray((inside @ turns.swapaxes(1, 2)).reshape(-1, 3))
    starts = np.repeat([c.position for c in candidates], _PROBE**2, axis=0).astype(np.float32)
    hits = tracer.nearest(starts, probes)
    met = hits.triangle >= 0
    distance = np.where(met, hits.distance, _FAR).reshape(len(candidates), -1)
    instance = np.where(met, geometry.instance[geometry.part[np.maximum(hits.triangle, 0)]], 0)
    kinds = np.array([len(np.unique(row)) for row in instance.reshape(len(candidates), -1)])
    near = np.quantile(distance, 0.02, axis=1)
    median = np.median(distance, axis=1)
    off = np.abs(np.log(np.maximum(median, 0.05) / wanted))
    off += 0.1 * np.maximum(0, 14 - kinds)  # bare walls are dull, and rarely photographed
    off += 0.8 * alike
    off += 20.0 * (near < (0.5 if close else 0.6))
    off += 2.0 * np.maximum(0.0, (distance == _FAR).mean(axis=1) - 0.1)
    if close:
        off += 2.0 * np.maximum(0.0, (distance > _CLOSE[1] + 0.6).mean(axis=1) - 0.45)
    off += 50.0 * (_air(candidates, tracer) < _AIR)
    return candidates[int(np.argmin(off))]


def _alike(candidates: list[Camera], chosen: list[Camera]) -> Vector:
    """How much each candidate (N,) repeats a view chosen before: 1 from the same place and way."""
    if not chosen:
        return np.zeros(len(candidates))
    place, way = (np.stack([getattr(c, k) for c in candidates]) for k in Camera._fields)
    place0, way0 = (np.stack([getattr(c, k) for c in chosen]) for k in Camera._fields)
    apart = np.linalg.norm(place[:, None] - place0, axis=-1) / 2.0
    turned = np.arccos(np.clip(way[..., 2] @ way0[..., 2].T, -1, 1))
    return np.exp(-(apart**2) - (turned / 0.7) ** 2).max(axis=1)


def _air(candidates: list[Camera], tracer: Tracer) -> Vector:
    """Distance (N,) from each camera to the nearest surface, m, along a few dozen rays."""
    turn = np.arange(32) * (np.pi * (3 - np.sqrt(5)))
    z = 1 - (np.arange(32) + 0.5) / 16
    ball = np.stack([np.cos(turn) * np.sqrt(1 - z**2), np.sin(turn) * np.sqrt(1 - z**2), z], -1)
    starts = np.repeat([c.position for c in candidates], 32, axis=0).astype(np.float32)
    rays = np.tile(ball.astype(np.float32), (len(candidates), 1))
    hits = tracer.nearest(starts, rays)
    distance = np.where(hits.triangle < 0, np.inf, hits.distance)
    return distance.reshape(len(candidates), 32).min(axis=1)
