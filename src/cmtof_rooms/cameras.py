"""Where cameras stand: as people do in a room, and close to things at 0.5 to 1.2 m."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof_rooms.engine import World, sphere_of_directions
from cmtof_rooms.shell import Rectangle

Vector = NDArray[np.float64]

TRIES = 28
"""Places drawn for each view."""

MIDDLE, SPREAD, SQUARE = 6.5, 0.8, 0.8
"""Median of a view's median range, m; its spread, log; share of views that face a wall."""

_PROBE = 16  # a candidate is judged by that many rays squared
_AIR = 0.22  # m, free about a camera
_CLOSE = (0.5, 1.2)  # m
_FAR = 60.0  # m, what a ray that leaves counts for


class Lens(NamedTuple):
    """Size of the image, (H, W) px, and focal length, px; pixel centres at +0.5."""

    shape: tuple[int, int]
    focal: float

    def rays(self, orientation: Vector) -> NDArray[np.float32]:
        """Unit directions (H, W, 3) in the world for an ``orientation`` (3, 3)."""
        height, width = self.shape
        x = (np.arange(width) + 0.5 - width / 2) / self.focal
        y = (height / 2 - np.arange(height) - 0.5) / self.focal
        rays = np.stack([*np.meshgrid(x, y), np.full(self.shape, -1.0)], -1)
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        return np.ascontiguousarray(rays @ orientation.T, np.float32)


class Camera(NamedTuple):
    """A pose: position (3,), m, and orientation (3, 3), world from camera.

    The orientation's columns are the camera's axes: right, up, backwards (it looks along -z).
    """

    position: Vector
    orientation: Vector


def looking(position: Vector, target: Vector, roll: float = 0.0) -> Camera:
    """A camera at ``position`` that looks at ``target``, m, rolled by ``roll``, rad.

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
    world: World,
    lens: Lens,
    *,
    floor: list[Rectangle],
    height: float,
    rng: np.random.Generator,
) -> list[Camera]:
    """Views across a room from where a person could stand or sit.

    Of the places drawn for each view, those without air around them or with something right before
    them are left out; the one whose median range is nearest to a drawn one is taken. Those ranges
    are spread as Hypersim's are, log-normal. Four of five cameras face a wall squarely,
    as interiors are often photographed. ``floor`` holds rectangles (x0, x1, y0, y1) where a camera
    may stand, ``height`` is the ceiling's, m.
    """
    area = np.array([(x1 - x0) * (y1 - y0) for x0, x1, y0, y1 in floor])
    views: list[Camera] = []
    for _ in range(count):
        wanted = MIDDLE * np.exp(SPREAD * rng.normal())
        candidates = []
        for _ in range(TRIES):
            x0, x1, y0, y1 = floor[int(rng.choice(len(floor), p=area / area.sum()))]
            eye_height = min(float(rng.choice([1.1, 1.4, 1.6, 1.9])), height - 0.4)
            a, b = rng.beta(0.6, 0.6, 2)  # with one's back to the wall, mostly
            eye = np.array([x0 + a * (x1 - x0), y0 + b * (y1 - y0), eye_height])
            heading = rng.uniform(0, 2 * np.pi)
            if rng.uniform() < SQUARE:
                heading = np.pi / 2 * rng.integers(4) + rng.normal(0, 0.05)
            pitch = np.radians(rng.normal(-4, 5))
            ahead = np.array([np.cos(heading), np.sin(heading), np.tan(pitch)])
            candidates.append(looking(eye, eye + ahead, np.radians(rng.normal(0, 1.0))))
        views.append(_best(candidates, wanted, world, lens, views))
    return views


def close_cameras(
    count: int, world: World, lens: Lens, *, things: NDArray, rng: np.random.Generator
) -> list[Camera]:
    """Views from 0.5 to 1.2 m away of single ``things``, given by their numbers."""
    boxes = [np.stack([part.mesh.bounds for part in world.things[k - 1].parts]) for k in things]
    low = np.array([box[:, 0].min(axis=0) for box in boxes])
    high = np.array([box[:, 1].max(axis=0) for box in boxes])
    size = (high - low).max(axis=1)
    fit = np.flatnonzero((size > 0.1) & (size < 1.6))
    middles = ((low + high) / 2)[fit if len(fit) else slice(None)]
    views: list[Camera] = []
    for _ in range(count):
        wanted = rng.uniform(0.6, _CLOSE[1])
        candidates = []
        for _ in range(TRIES):
            target = middles[int(rng.integers(len(middles)))] + rng.normal(0, 0.05, 3)
            heading, rise = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(0, 45))
            away = np.array([np.cos(heading), np.sin(heading), np.tan(rise)])
            eye = target + away / np.linalg.norm(away) * rng.uniform(*_CLOSE)
            candidates.append(looking(eye, target, np.radians(rng.normal(0, 3))))
        views.append(_best(candidates, wanted, world, lens, views))
    return views


def _best(
    candidates: list[Camera], wanted: float, world: World, lens: Lens, chosen: list[Camera]
) -> Camera:
    """The candidate with air around it, enough to see, and a median range nearest ``wanted``."""
    coarse = Lens((_PROBE, _PROBE), lens.focal * _PROBE / max(lens.shape))
    probes = np.stack([coarse.rays(c.orientation).reshape(-1, 3) for c in candidates])
    ball = np.broadcast_to(sphere_of_directions(48), (len(candidates), 48, 3))
    rays = np.concatenate([probes, ball], axis=1)
    eyes = np.stack([c.position for c in candidates]).astype(np.float32)
    starts = np.repeat(eyes, rays.shape[1], axis=0)
    hits = world.tracer.nearest(starts, np.ascontiguousarray(rays.reshape(-1, 3)))
    met = hits.triangle >= 0
    distance = np.where(met, hits.distance, _FAR).reshape(len(candidates), -1)
    facing = np.einsum("ij,ij->i", world.normals[hits.triangle], rays.reshape(-1, 3))
    behind = (met & (facing > 0)).reshape(distance.shape)  # the back of a surface: inside a solid
    inside = behind.mean(axis=1) > 0.02
    air = distance[:, -48:].min(axis=1)
    seen = distance[:, :-48]
    thing = np.where(met, world.instance[world.part[hits.triangle]], 0).reshape(distance.shape)
    kinds = np.array([len(np.unique(row)) for row in thing[:, :-48]])
    off = np.abs(np.log(np.maximum(np.median(seen, axis=1), 0.05) / wanted))
    off += 0.15 * np.maximum(0, 9 - kinds)  # bare walls are rarely photographed
    off += 20.0 * (np.quantile(seen, 0.02, axis=1) < 0.45)
    off += 2.0 * np.maximum(0.0, (seen == _FAR).mean(axis=1) - 0.1)
    off += 50.0 * (air < _AIR) + 200.0 * inside + 0.8 * _alike(candidates, chosen)
    return candidates[int(np.argmin(off.round(4)))]


def _alike(candidates: list[Camera], chosen: list[Camera]) -> Vector:
    """How much each candidate (N,) repeats a view chosen before: 1 from the same place and way."""
    if not chosen:
        return np.zeros(len(candidates))
    place, way = (np.stack([getattr(c, k) for c in candidates]) for k in Camera._fields)
    place0, way0 = (np.stack([getattr(c, k) for c in chosen]) for k in Camera._fields)
    apart = np.linalg.norm(place[:, None] - place0, axis=-1) / 2.0
    turned = np.arccos(np.clip(way[..., 2] @ way0[..., 2].T, -1, 1))
    return np.exp(-(apart**2) - (turned / 0.7) ** 2).max(axis=1)
