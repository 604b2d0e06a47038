"""Where cameras stand: as people do in a room, and close to things at 0.5 to 1.2 m."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof_rooms.boxes import Rectangle
from cmtof_rooms.engine import sphere_of_directions
from cmtof_rooms.interior import Interior

Vector = NDArray[np.float64]

TRIES = 28
"""Places drawn for each view."""

MIDDLE = 6.5
"""Median, m, of the median ranges of views across a room."""

SPREAD = 0.8
"""Standard deviation of the logarithm of those ranges."""

SQUARE = 0.8
"""Share of views across a room that face a wall."""

_PROBE = 16  # a candidate is judged by that many rays squared
_AROUND = 48  # and by that many to all sides
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


def look_at(position: Vector, target: Vector, roll: float = 0.0) -> Camera:
    """Camera at ``position`` that looks at ``target``, m, rolled by ``roll``, rad.

    >>> look_at(np.zeros(3), np.array([0.0, 1.0, 0.0])).orientation.round(6).tolist()
    [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    """
    back = position - target
    back = back / np.linalg.norm(back)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    cosine = np.cos(roll)
    sine = np.sin(roll)
    axes = [cosine * right + sine * up, cosine * up - sine * right, back]
    return Camera(position, np.stack(axes, -1))


def room_cameras(
    count: int,
    interior: Interior,
    lens: Lens,
    *,
    floor: list[Rectangle],
    height: float,
    rng: np.random.Generator,
) -> list[Camera]:
    """Views across a room from where a person could stand or sit.

    Of the places drawn for each view, those without air around them or with something right before
    them are left out; the one whose median range is nearest to a drawn one is taken. Those ranges
    are spread as Hypersim's are, log-normal. Four of five cameras face a wall squarely, as
    interiors are often photographed.

    Parameters
    ----------
    count : int
        How many views.
    interior : Interior
    lens : Lens
    floor : list of Rectangle
        Where a camera may stand.
    height : float
        Of the ceiling, m.
    rng : Generator
    """
    area = np.array([np.prod(piece.size) for piece in floor])

    def draw() -> Camera:
        piece = floor[int(rng.choice(len(floor), p=area / area.sum()))]
        eye_height = min(float(rng.choice([1.1, 1.4, 1.6, 1.9])), height - 0.4)
        # with one's back to the wall, mostly
        eye = np.array([*(piece.start + rng.beta(0.6, 0.6, 2) * piece.size), eye_height])
        heading = rng.uniform(0, 2 * np.pi)
        if rng.uniform() < SQUARE:
            heading = np.pi / 2 * rng.integers(4) + rng.normal(0, 0.05)
        pitch = np.radians(rng.normal(-4, 5))
        ahead = np.array([np.cos(heading), np.sin(heading), np.tan(pitch)])
        return look_at(eye, eye + ahead, np.radians(rng.normal(0, 1.0)))

    views: list[Camera] = []
    for _ in range(count):
        wanted = MIDDLE * np.exp(SPREAD * rng.normal())
        views.append(_best([draw() for _ in range(TRIES)], wanted, interior, lens, views))
    return views


def close_cameras(
    count: int,
    interior: Interior,
    lens: Lens,
    *,
    things: NDArray,
    rng: np.random.Generator,
) -> list[Camera]:
    """Views of single things from 0.5 to 1.2 m away.

    Parameters
    ----------
    count : int
        How many views.
    interior : Interior
    lens : Lens
    things : ndarray of int
        Numbers of the things, from 1 on.
    rng : Generator
    """
    middles = _middles(interior, things)

    def draw() -> Camera:
        target = middles[int(rng.integers(len(middles)))] + rng.normal(0, 0.05, 3)
        heading = rng.uniform(0, 2 * np.pi)
        rise = np.radians(rng.uniform(0, 45))
        away = np.array([np.cos(heading), np.sin(heading), np.tan(rise)])
        eye = target + away / np.linalg.norm(away) * rng.uniform(*_CLOSE)
        return look_at(eye, target, np.radians(rng.normal(0, 3)))

    views: list[Camera] = []
    for _ in range(count):
        wanted = rng.uniform(0.6, _CLOSE[1])
        views.append(_best([draw() for _ in range(TRIES)], wanted, interior, lens, views))
    return views


def _middles(interior: Interior, things: NDArray) -> Vector:
    """Middles (N, 3) of things of 0.1 to 1.6 m; of all where there are none."""
    boxes = [
        np.stack([part.mesh.bounds for part in interior.things[number - 1].parts])
        for number in things
    ]
    low = np.array([box[:, 0].min(axis=0) for box in boxes])
    high = np.array([box[:, 1].max(axis=0) for box in boxes])
    size = (high - low).max(axis=1)
    fit = (size > 0.1) & (size < 1.6)
    middles = (low + high) / 2
    return middles[fit] if fit.any() else middles


def _best(
    candidates: list[Camera],
    wanted: float,
    interior: Interior,
    lens: Lens,
    chosen: list[Camera],
) -> Camera:
    """The candidate with air around it, enough to see, and a median range nearest ``wanted``."""
    sight = _sight(candidates, interior, lens)
    seen = sight.distance
    off = np.abs(np.log(np.maximum(np.median(seen, axis=1), 0.05) / wanted))
    off += 0.15 * np.maximum(0, 9 - sight.things)  # bare walls are rarely photographed
    off += 20.0 * (np.quantile(seen, 0.02, axis=1) < 0.45)
    off += 2.0 * np.maximum(0.0, (seen == _FAR).mean(axis=1) - 0.1)
    crowded = 50.0 * (sight.air < _AIR)
    off += crowded + 200.0 * sight.inside + 0.8 * _likeness(candidates, chosen)
    return candidates[int(np.argmin(off.round(4)))]


class _Sight(NamedTuple):
    """What N candidates see."""

    distance: Vector
    """Along rays of the picture, (N, K), m."""
    air: Vector
    """Free distance around, (N,), m."""
    inside: NDArray[np.bool_]
    """Whether they stand in a solid, (N,)."""
    things: NDArray
    """How many things are in the picture, (N,)."""


def _sight(candidates: list[Camera], interior: Interior, lens: Lens) -> _Sight:
    """Look through coarse pictures of candidates, and around them."""
    count = len(candidates)
    coarse = Lens((_PROBE, _PROBE), lens.focal * _PROBE / max(lens.shape))
    probes = np.stack([coarse.rays(c.orientation).reshape(-1, 3) for c in candidates])
    around = np.broadcast_to(sphere_of_directions(_AROUND), (count, _AROUND, 3))
    rays = np.concatenate([probes, around], axis=1).reshape(-1, 3)
    eyes = np.stack([c.position for c in candidates]).astype(np.float32)
    hits = interior.tracer.nearest(np.repeat(eyes, len(rays) // count, axis=0), rays)
    met = hits.triangle >= 0
    distance = np.where(met, hits.distance, _FAR).reshape(count, -1)
    facing = np.einsum("ij,ij->i", interior.normals[hits.triangle], rays)
    behind = met & (facing > 0)  # the back of a surface: inside a solid
    thing = np.where(met, interior.instance[interior.part[hits.triangle]], 0)
    pictured = thing.reshape(count, -1)[:, :-_AROUND]
    return _Sight(
        distance[:, :-_AROUND],
        distance[:, -_AROUND:].min(axis=1),
        behind.reshape(count, -1).mean(axis=1) > 0.02,
        np.array([len(np.unique(row)) for row in pictured]),
    )


def _likeness(candidates: list[Camera], chosen: list[Camera]) -> Vector:
    """How much each candidate (N,) repeats a view chosen before: 1 from the same place and way."""
    if not chosen:
        return np.zeros(len(candidates))
    place, way = _poses(candidates)
    other_place, other_way = _poses(chosen)
    apart = np.linalg.norm(place[:, None] - other_place, axis=-1) / 2.0
    turned = np.arccos(np.clip(way @ other_way.T, -1, 1))
    return np.exp(-(apart**2) - (turned / 0.7) ** 2).max(axis=1)


def _poses(cameras: list[Camera]) -> tuple[Vector, Vector]:
    """Positions (N, 3) and backward axes (N, 3) of cameras."""
    positions = [camera.position for camera in cameras]
    orientations = [camera.orientation for camera in cameras]
    return np.stack(positions), np.stack(orientations)[..., 2]
