"""Where cameras stand: as people do in a room, and close to things."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from cmtof.frame import rays_from_camera
from cmtof.types import Array, Shape
from cmtof_rooms.boxes import Rectangles
from cmtof_rooms.engine import sphere_of_directions
from cmtof_rooms.interior import Interior
from cmtof_rooms.solids import turn_about_z

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
    axes = np.stack([right, np.cross(back, right), back], -1)
    return Camera(position, axes @ turn_about_z(-roll))


def room_cameras(
    close: Sequence[bool],
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
    close : sequence of bool
        Whether each view is taken from 0.5 to 1.2 m before what it shows.
    interior : Interior
    lens : Lens
    floor : list of Rectangle
        Where a camera may stand.
    height : float
        Of the ceiling, m.
    rng : Generator
    """
    views = []
    for near in close:
        wanted = MIDDLE * np.exp(SPREAD * rng.normal())
        drawn = [_across(floor, height, rng) for _ in range(TRIES)]
        if near:
            wanted = 0.85  # m
            drawn = [_approached(camera, interior, rng) for camera in drawn]
        views.append(_best(drawn, wanted, interior, lens, views))
    return views


def _approached(camera: Camera, interior: Interior, rng: Generator) -> Camera:
    """Camera that was moved on to what it looks at."""
    ahead = -camera.orientation[:, 2].astype(np.float32)
    seen = interior.meet(camera.position[None], ahead[None])
    way = (seen.distance[0] - rng.uniform(*_CLOSE)) * ahead
    return camera._replace(position=camera.position + way)


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
    rise = np.tan(np.radians(rng.normal(-4, 5)))
    ahead = [np.cos(heading), np.sin(heading), rise]
    return look_at(eye, eye + ahead, np.radians(rng.normal(0, 1.0)))


def _best(
    candidates: Cameras,
    wanted: float,
    interior: Interior,
    lens: Lens,
    chosen: Cameras,
) -> Camera:
    """The candidate with air around it, enough to see, and a median range nearest ``wanted``."""
    off = [
        _off(camera, wanted, interior, lens)
        + 0.8 * max((_likeness(camera, one) for one in chosen), default=0.0)
        for camera in candidates
    ]
    return candidates[np.argmin(np.round(off, 4))]


def _off(camera: Camera, wanted: float, interior: Interior, lens: Lens) -> float:
    """How far a camera is from what is wanted, by what it sees and by what stands around it."""
    rays = _probes(camera, lens)
    seen = interior.meet(np.broadcast_to(camera.position, rays.shape), rays)
    distance = np.where(seen.part >= 0, seen.distance, _FAR)
    pictured, around = np.split(distance, [_PROBE**2])
    things = np.unique(interior.instance[seen.part[: _PROBE**2]])
    off = abs(np.log(max(np.median(pictured), 0.05) / wanted))
    off += 0.15 * max(0, 9 - things.size)  # bare walls are rarely photographed
    off += 20.0 * (np.quantile(pictured, 0.02) < 0.45)
    off += 2.0 * max(0.0, np.mean(pictured == _FAR) - 0.1)
    off += 50.0 * (around.min() < _AIR)
    return off + 200.0 * (seen.behind.mean() > 0.02)


def _probes(camera: Camera, lens: Lens) -> Array:
    """Rays (N, 3) through a coarse picture, then to all sides."""
    coarse = Lens((_PROBE, _PROBE), lens.focal * _PROBE / max(lens.shape))
    pictured = coarse.rays(camera.orientation).reshape(-1, 3)
    return np.vstack([pictured, sphere_of_directions(_AROUND)])


def _likeness(one: Camera, other: Camera) -> float:
    """How much two views are the same: 1 from the same place and way."""
    apart = np.linalg.norm(one.position - other.position) / 2.0
    facing = one.orientation[:, 2] @ other.orientation[:, 2]
    turned = np.arccos(np.clip(facing, -1, 1)) / 0.7
    return float(np.exp(-(apart**2) - turned**2))
