"""Scenes of solids given by formulas, traced ray by ray: the embedded frames, and known truths.

A solid is a signed distance function: how far a point is from its surface, negative inside. Rays
march by that distance (sphere tracing, Hart 1996) until they touch, so range is exact to a
micrometre. Lengths in metres, y up.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.frame import Frame, rays_from_camera

Points = NDArray[np.float64]
Distance = Callable[[Points], NDArray[np.float64]]
Albedo = Callable[[Points], NDArray[np.float64]]

TOUCH = 2e-7
FAR = 12.0


@dataclass(frozen=True)
class Solid:
    """A body: signed distance (N, 3) -> (N,), m, and albedo (N, 3) -> (N,) in [0, 1]."""

    distance: Distance
    albedo: Albedo


# --- shapes ------------------------------------------------------------------------------------


def plane(normal: ArrayLike, offset: float) -> Distance:
    """Half-space ``n . p < offset``."""
    n = np.asarray(normal, float) / np.linalg.norm(normal)
    return lambda p: p @ n - offset


def sphere(centre: ArrayLike, radius: float) -> Distance:
    """Ball."""
    c = np.asarray(centre, float)
    return lambda p: np.linalg.norm(p - c, axis=-1) - radius


def box(
    centre: ArrayLike, size: ArrayLike, *, turn: float = 0.0, rounding: float = 0.0
) -> Distance:
    """Box of full ``size``, turned about the vertical by ``turn`` rad, edges rounded."""
    c, half = np.asarray(centre, float), np.asarray(size, float) / 2 - rounding
    cos, sin = np.cos(turn), np.sin(turn)

    def distance(p: Points) -> NDArray[np.float64]:
        x, y, z = (p - c).T
        q = np.abs(np.stack([cos * x - sin * z, y, sin * x + cos * z], axis=-1)) - half
        outside = np.linalg.norm(np.maximum(q, 0), axis=-1)
        return outside + np.minimum(q.max(axis=-1), 0) - rounding

    return distance


def revolved(base: ArrayLike, profile: Sequence[tuple[float, float]]) -> Distance:
    """Body of revolution about the vertical: round cones between (radius, height) pairs."""
    b = np.asarray(base, float)
    rings = np.asarray(profile, float)

    def distance(p: Points) -> NDArray[np.float64]:
        q = p - b
        radial, height = np.hypot(q[:, 0], q[:, 2]), q[:, 1]
        best = np.full(len(p), np.inf)
        for (r0, h0), (r1, h1) in pairwise(rings):
            best = np.minimum(best, _frustum(radial, height, r0, h0, r1, h1))
        return best

    return distance


def _frustum(
    radial: NDArray, height: NDArray, r0: float, h0: float, r1: float, h1: float
) -> NDArray[np.float64]:
    """Signed distance to a cone's frustum between two rings."""
    along = np.clip(
        ((radial - r0) * (r1 - r0) + (height - h0) * (h1 - h0)) / ((r1 - r0) ** 2 + (h1 - h0) ** 2),
        0,
        1,
    )
    slant = np.hypot(radial - r0 - along * (r1 - r0), height - h0 - along * (h1 - h0))
    caps = [np.hypot(np.maximum(radial - r, 0), height - h) for r, h in ((r0, h0), (r1, h1))]
    side = (radial - r0) * (h1 - h0) - (height - h0) * (r1 - r0)
    inside = (side < 0) & (height > h0) & (height < h1)
    size = np.minimum(slant, np.minimum(*caps))
    return np.where(inside, -size, size)


def capsule(start: ArrayLike, end: ArrayLike, radius: float) -> Distance:
    """Rod with round ends."""
    a, b = np.asarray(start, float), np.asarray(end, float)
    ab = b - a

    def distance(p: Points) -> NDArray[np.float64]:
        t = np.clip((p - a) @ ab / (ab @ ab), 0, 1)
        return np.linalg.norm(p - a - t[:, None] * ab, axis=-1) - radius

    return distance


# --- textures ----------------------------------------------------------------------------------


def plain(value: float) -> Albedo:
    """One albedo everywhere."""
    return lambda p: np.full(len(p), value)


def striped(dark: float, light: float, direction: ArrayLike, period: float) -> Albedo:
    """Stripes across a direction, soft at their edges."""
    d = 2 * np.pi * np.asarray(direction, float) / (np.linalg.norm(direction) * period)
    return lambda p: dark + (light - dark) / (1 + np.exp(-6 * np.sin(p @ d)))


def checked(dark: float, light: float, period: float) -> Albedo:
    """Chequer on the floor plane."""

    def albedo(p: Points) -> NDArray[np.float64]:
        odd = (np.floor(p[:, 0] / period) + np.floor(p[:, 2] / period)) % 2
        return np.where(odd > 0, light, dark)

    return albedo


def grained(value: float, contrast: float, period: float) -> Albedo:
    """Wood: wavy rings along x."""

    def albedo(p: Points) -> NDArray[np.float64]:
        wave = p[:, 2] / period + 0.6 * np.sin(p[:, 0] / period / 4) + p[:, 1] / period
        rings = np.sin(2 * np.pi * wave) * np.sin(1.7 * wave + 1) ** 2
        return value * (1 + contrast * rings)

    return albedo


# --- tracing -----------------------------------------------------------------------------------


def view(
    solids: Sequence[Solid],
    *,
    eye: ArrayLike,
    target: ArrayLike,
    shape: tuple[int, int],
    focal: float,
    lamp: ArrayLike,
    ambient: float = 0.25,
    exposure: float = 1.0,
    name: str = "",
) -> Frame:
    """Trace one view: range along each ray, and linear brightness under one shadowing lamp.

    Parameters
    ----------
    solids : sequence of Solid
    eye, target, lamp : array_like, shape (3,)
        Camera, point looked at, and lamp, m.
    shape : (int, int)
        Height and width, px.
    focal : float
        Focal length, px.
    ambient, exposure : float
        Share of light without direction; factor on the brightness.

    Returns
    -------
    Frame
        Depth is NaN where a ray meets nothing within 12 m.
    """
    camera = np.array([focal, focal, shape[1] / 2, shape[0] / 2])
    origin, light = np.asarray(eye, float), np.asarray(lamp, float)
    rays = rays_from_camera(shape, camera).reshape(-1, 3) @ _axes(origin, np.asarray(target, float))
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    depth, index = march(solids, np.broadcast_to(origin, rays.shape), rays)
    hit = np.isfinite(depth)
    brightness = np.zeros(len(rays))
    points = origin + depth[hit, None] * rays[hit]
    brightness[hit] = exposure * _shade(solids, points, index[hit], light, ambient)
    return Frame(depth.reshape(shape), brightness.reshape(shape), camera, name)


def march(
    solids: Sequence[Solid], origin: Points, direction: Points, *, far: float = FAR
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Range (N,), m, NaN if nothing is met before ``far``, and which solid was met."""
    travelled = np.zeros(len(direction))
    index = np.zeros(len(direction), np.int64)
    active = np.arange(len(direction))
    done = np.zeros(len(direction), bool)
    for _ in range(400):
        points = origin[active] + travelled[active, None] * direction[active]
        gaps = np.stack([solid.distance(points) for solid in solids])
        nearest = gaps.argmin(axis=0)
        gap = gaps[nearest, np.arange(len(active))]
        travelled[active] += gap
        index[active] = nearest
        done[active] = gap < TOUCH
        active = active[(gap >= TOUCH) & (travelled[active] < far)]
        if active.size == 0:
            break
    return np.where(done & (travelled < far), travelled, np.nan), index


def _axes(eye: NDArray, target: NDArray) -> NDArray[np.float64]:
    """Rows: the camera's x (right), y (down) and z (forward) axes in the world."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


def _shade(
    solids: Sequence[Solid], points: Points, index: NDArray, lamp: NDArray, ambient: float
) -> NDArray[np.float64]:
    """Lambert's law with a hard shadow, plus ambient light."""
    albedo, normal = np.empty(len(points)), np.empty_like(points)
    for i, solid in enumerate(solids):
        mine = index == i
        albedo[mine] = solid.albedo(points[mine])
        for axis in range(3):
            step = np.zeros(3)
            step[axis] = 1e-5
            ahead, behind = points[mine] + step, points[mine] - step
            normal[mine, axis] = solid.distance(ahead) - solid.distance(behind)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    to_lamp = lamp - points
    reach = np.linalg.norm(to_lamp, axis=-1)
    to_lamp /= reach[:, None]
    start = points + 1e-3 * normal
    blocked, _ = march(solids, start, to_lamp)
    lit = ~(blocked < reach - 2e-3)
    lambert = np.clip(np.sum(normal * to_lamp, axis=-1), 0, 1)
    # ambient light comes more from above than from below
    sky = ambient * (0.75 + 0.25 * normal[:, 1])
    return albedo * (sky + (1 - ambient) * lit * lambert * np.minimum(1, (2 / reach) ** 2))
