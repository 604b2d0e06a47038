"""Where cameras stand: as people do in a room, and close to things at 0.5 to 1.2 m."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from trimesh import unitize

from cmtof.frame import rays_from_camera
from cmtof.types import Array, Shape
from cmtof_rooms.boxes import Boxes
from cmtof_rooms.engine import sphere_of_directions
from cmtof_rooms.interior import Interior
from cmtof_rooms.kit import weighted_choice
from cmtof_rooms.solids import turn_about_z
from cmtof_rooms.things import Thing

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
    back = unitize(position - target)
    right = unitize(np.cross([0.0, 0.0, 1.0], back))
    axes = turn_about_z(roll) @ [right, np.cross(back, right), back]
    return Camera(position, axes.T)


def choose_cameras(
    interior: Interior,
    lens: Lens,
    count: int,
    rng: Generator,
    wanted: Callable[[Generator], float],
    draw: Callable[[Generator], Camera],
) -> Cameras:
    """Views of a room, each the best of those that are drawn for it.

    A camera without air around it, or with something right before it, is taken only if all are so;
    mostly it is the one whose median range is nearest to a drawn one.

    Parameters
    ----------
    interior : Interior
    lens : Lens
    count : int
        How many views.
    rng : Generator
    wanted : callable
        Draws the median range of a view, m.
    draw : callable
        Draws a camera.
    """
    coarse = Lens((_PROBE, _PROBE), lens.focal * _PROBE / max(lens.shape))
    views = []
    for _ in range(count):
        middle = wanted(rng)
        drawn = [draw(rng) for _ in range(TRIES)]
        flaws = [
            _flaws(one, middle, interior, coarse)
            + 0.8 * max([0.0, *(_likeness(one, view) for view in views)])
            for one in drawn
        ]
        views.append(drawn[np.argmin(np.round(flaws, 4))])
    return views


def range_across(rng: Generator) -> float:
    """Draw the median range, m, of a view across a room: spread as Hypersim's, log-normal."""
    return MIDDLE * np.exp(SPREAD * rng.normal())


def camera_across(floor: Boxes, rng: Generator) -> Camera:
    """Draw a camera that a person could hold, standing or sitting, in one of a room's pieces.

    Four of five face a wall squarely, as interiors are often photographed.
    """
    piece = weighted_choice(rng, floor, [piece.size[:2].prod() for piece in floor])
    eye_height = min(rng.choice([1.1, 1.4, 1.6, 1.9]), piece.z1 - 0.4)
    # with one's back to the wall, mostly
    eye = np.append(piece.low[:2] + rng.beta(0.6, 0.6, 2) * piece.size[:2], eye_height)
    heading = rng.uniform(0, 2 * np.pi)
    if rng.uniform() < SQUARE:
        heading = np.pi / 2 * rng.integers(4) + rng.normal(0, 0.05)
    ahead = _direction(heading, np.radians(rng.normal(-4, 5)))
    return look_at(eye, eye + ahead, np.radians(rng.normal(0, 1.0)))


def _direction(heading: float, rise: float) -> Array:
    """Vector (3,) along a heading and a rise, rad; its part in x and y has length 1."""
    return np.array([np.cos(heading), np.sin(heading), np.tan(rise)])


def range_close(rng: Generator) -> float:
    """Draw the median range, m, of a view of a single thing."""
    return rng.uniform(0.6, _CLOSE[1])


def camera_close(middles: Array, rng: Generator) -> Camera:
    """Draw a camera 0.5 to 1.2 m from one of several things, given by their middles (N, 3), m."""
    target = middles[rng.integers(len(middles))] + rng.normal(0, 0.05, 3)
    away = _direction(rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(0, 45)))
    eye = target + away / np.linalg.norm(away) * rng.uniform(*_CLOSE)
    return look_at(eye, target, np.radians(rng.normal(0, 3)))


def middles_of(things: Sequence[Thing]) -> Array:
    """Middles (N, 3), m, of the things of 0.1 to 1.6 m; of all things if none has such a size."""
    bounds = np.array([thing.bounds for thing in things])
    size = np.ptp(bounds, axis=1).max(axis=1)
    fit = (size > 0.1) & (size < 1.6)
    middles = bounds.mean(axis=1)
    return middles[fit] if fit.any() else middles


def _flaws(camera: Camera, wanted: float, interior: Interior, lens: Lens) -> float:
    """Penalty of a view: 0 with air around it, 9 things in sight, median range ``wanted``, m."""
    pictured = lens.rays(camera.orientation).reshape(-1, 3)
    rays = np.vstack([pictured, sphere_of_directions(_AROUND)])
    hits = interior.tracer.nearest(np.full_like(rays, camera.position), rays)
    met = hits.triangle >= 0
    facing = np.einsum("ij,ij->i", interior.normals[hits.triangle], rays)
    behind = met & (facing > 0)  # the back of a surface: inside a solid
    distance = np.where(met, hits.distance, _FAR)
    seen = distance[:-_AROUND]
    thing = interior.instance[interior.part[hits.triangle[:-_AROUND]]]
    return (
        abs(np.log(max(np.median(seen), 0.05) / wanted))
        # bare walls are rarely photographed
        + 0.15 * max(0, 9 - len(np.unique(thing)))
        + 20.0 * (np.quantile(seen, 0.02) < 0.45)
        + 2.0 * max(0.0, (seen == _FAR).mean() - 0.1)
        + 50.0 * (distance[-_AROUND:].min() < _AIR)
        + 200.0 * (behind.mean() > 0.02)
    )


def _likeness(one: Camera, other: Camera) -> float:
    """Likeness, 0 to 1, of two views: 1 for the same place and direction."""
    apart = np.linalg.norm(one.position - other.position) / 2.0
    cosine = one.orientation[:, 2] @ other.orientation[:, 2]
    turned = np.arccos(np.clip(cosine, -1, 1)) / 0.7
    return float(np.exp(-(apart**2) - turned**2))
