"""Where cameras stand: as people do in a room, and close to things at 0.5 to 1.2 m."""

from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from cmtof.frame import rays_from_camera
from cmtof.types import Array, Arrays, Flags, Numbers, Shape
from cmtof_rooms.boxes import Rectangles
from cmtof_rooms.engine import sphere_of_directions
from cmtof_rooms.interior import Interior

TRIES = 28  # places drawn for each view

MIDDLE = 6.5  # median, m, of the median ranges of views across a room

SPREAD = 0.8  # standard deviation of the logarithm of those ranges

SQUARE = 0.8  # share of views across a room that face a wall

_PROBE = 16  # a candidate is judged by that many rays squared
_AROUND = 48  # and by that many to all sides
_AIR = 0.22  # m, free about a camera
_CLOSE = (0.5, 1.2)  # m
_FAR = 60.0  # m, what a ray that leaves counts for


class Lens(NamedTuple):
    """Size of the image, (H, W) px, and focal length, px; pixel centres at +0.5."""

    shape: Shape
    focal: float

    @property
    def camera(self) -> Array:
        """Focal lengths and middle of the image: fx, fy, cx, cy, px."""
        height, width = self.shape
        return np.array([self.focal, self.focal, width / 2, height / 2])

    def rays(self, orientation: Array) -> Array:
        """Unit directions (H, W, 3) in the world for an ``orientation`` (3, 3)."""
        rays = rays_from_camera(self.shape, self.camera) * [1, -1, -1]
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        return np.ascontiguousarray(rays @ orientation.T, np.float32)


class Camera(NamedTuple):
    """A pose: position (3,), m, and orientation (3, 3), world from camera.

    The orientation's columns are the camera's axes: right, up, backwards (it looks along -z).
    """

    position: Array
    orientation: Array


Cameras = list[Camera]


def look_at(position: Array, target: Array, roll: float = 0.0) -> Camera:
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
    axes = [
        cosine * right + sine * up,
        cosine * up - sine * right,
        back,
    ]
    return Camera(position, np.stack(axes, -1))


def room_cameras(
    count: int,
    interior: Interior,
    lens: Lens,
    *,
    floor: Rectangles,
    height: float,
    rng: Generator,
) -> Cameras:
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
    views = []
    for _ in range(count):
        wanted = MIDDLE * np.exp(SPREAD * rng.normal())
        drawn = [_across(floor, height, rng) for _ in range(TRIES)]
        views.append(_best(drawn, wanted, interior, lens, views))
    return views


def _across(floor: Rectangles, height: float, rng: Generator) -> Camera:
    """Draw a camera that a person could hold in a room."""
    area = np.array([np.prod(piece.size) for piece in floor])
    piece = floor[rng.choice(len(floor), p=area / area.sum())]
    eye_height = min(rng.choice([1.1, 1.4, 1.6, 1.9]), height - 0.4)
    # with one's back to the wall, mostly
    eye = np.append(piece.start + rng.beta(0.6, 0.6, 2) * piece.size, eye_height)
    heading = rng.uniform(0, 2 * np.pi)
    if rng.uniform() < SQUARE:
        heading = np.pi / 2 * rng.integers(4) + rng.normal(0, 0.05)
    ahead = _direction(heading, np.radians(rng.normal(-4, 5)))
    return look_at(eye, eye + ahead, np.radians(rng.normal(0, 1.0)))


def _direction(heading: float, rise: float) -> Array:
    """Array (3,), one long seen from above, of a heading and an angle of rise, rad."""
    return np.array([np.cos(heading), np.sin(heading), np.tan(rise)])


def close_cameras(
    count: int,
    interior: Interior,
    lens: Lens,
    *,
    things: Numbers,
    rng: Generator,
) -> Cameras:
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
    views = []
    for _ in range(count):
        wanted = rng.uniform(0.6, _CLOSE[1])
        drawn = [_close(middles, rng) for _ in range(TRIES)]
        views.append(_best(drawn, wanted, interior, lens, views))
    return views


def _close(middles: Array, rng: Generator) -> Camera:
    """Draw a camera close to one of several things, given by their middles (N, 3), m."""
    target = middles[rng.integers(len(middles))] + rng.normal(0, 0.05, 3)
    away = _direction(rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(0, 45)))
    eye = target + away / np.linalg.norm(away) * rng.uniform(*_CLOSE)
    return look_at(eye, target, np.radians(rng.normal(0, 3)))


def _middles(interior: Interior, things: Numbers) -> Array:
    """Middles (N, 3) of things of 0.1 to 1.6 m; of all where there are none."""
    boxes = np.stack([interior.things[number - 1].bounds for number in things])
    low, high = boxes.swapaxes(0, 1)
    size = (high - low).max(axis=1)
    fit = (size > 0.1) & (size < 1.6)
    middles = (low + high) / 2
    return middles[fit] if fit.any() else middles


def _best(
    candidates: Cameras,
    wanted: float,
    interior: Interior,
    lens: Lens,
    chosen: Cameras,
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
    return candidates[np.argmin(off.round(4))]


def _probes(camera: Camera, lens: Lens) -> Array:
    """Rays (N, 3) through a coarse picture, then to all sides."""
    coarse = Lens((_PROBE, _PROBE), lens.focal * _PROBE / max(lens.shape))
    pictured = coarse.rays(camera.orientation).reshape(-1, 3)
    return np.vstack([pictured, sphere_of_directions(_AROUND)])


class _Sight(NamedTuple):
    """What N candidates see."""

    distance: Array  # along rays of the picture, (N, K), m
    air: Array  # free distance around, (N,), m
    inside: Flags  # whether they stand in a solid, (N,)
    things: Numbers  # how many things are in the picture, (N,)


def _sight(candidates: Cameras, interior: Interior, lens: Lens) -> _Sight:
    """Look through coarse pictures of candidates, and around them."""
    count = len(candidates)
    rays = np.concatenate([_probes(camera, lens) for camera in candidates])
    eyes = _poses(candidates)[0].astype(np.float32)
    hits = interior.tracer.nearest(np.repeat(eyes, len(rays) // count, axis=0), rays)
    met = hits.triangle >= 0
    distance = np.where(met, hits.distance, _FAR).reshape(count, -1)
    facing = np.einsum("ij,ij->i", interior.normals[hits.triangle], rays)
    behind = met & (facing > 0)  # the back of a surface: inside a solid
    thing = np.where(met, interior.thing_of(hits.triangle), 0).reshape(count, -1)
    return _Sight(
        distance[:, :-_AROUND],
        distance[:, -_AROUND:].min(axis=1),
        behind.reshape(count, -1).mean(axis=1) > 0.02,
        np.array([len(np.unique(row)) for row in thing[:, :-_AROUND]]),
    )


def _likeness(candidates: Cameras, chosen: Cameras) -> Array:
    """How much each candidate (N,) repeats a view chosen before: 1 from the same place and way."""
    if not chosen:
        return np.zeros(len(candidates))
    place, way = _poses(candidates)
    other_place, other_way = _poses(chosen)
    apart = np.linalg.norm(place[:, None] - other_place, axis=-1) / 2.0
    turned = np.arccos(np.clip(way @ other_way.T, -1, 1))
    return np.exp(-(apart**2) - (turned / 0.7) ** 2).max(axis=1)


def _poses(cameras: Cameras) -> Arrays:
    """Positions (N, 3) and backward axes (N, 3) of cameras."""
    positions = [camera.position for camera in cameras]
    orientations = [camera.orientation for camera in cameras]
    return np.stack(positions), np.stack(orientations)[..., 2]
