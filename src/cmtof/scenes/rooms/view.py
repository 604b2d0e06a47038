"""One camera's picture of a scene: colour, range, normal and instance of every pixel."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.scenes.rooms import shading
from cmtof.scenes.rooms.illumination import Illumination, Points
from cmtof.scenes.rooms.tracing import Hits

Array = NDArray[np.float32]

MIRRORED_FROM = 0.3
"""Specular share from which a pixel sends a reflected ray."""


class Picture(NamedTuple):
    """One view, (H, W) each."""

    color: Array
    """(H, W, 3) linear radiance."""
    depth: Array
    """Range along the ray, m; NaN where the ray leaves the scene."""
    normal: Array
    """(H, W, 3) unit normal of the surface in the world, towards the camera; 0 without depth."""
    instance: NDArray[np.int32]
    """Number of the thing, from 1 on; -1 where there is none."""


def picture(
    light: Illumination, origin: NDArray[np.float64], directions: Array, *, samples: int = 1
) -> Picture:
    """See a scene along rays.

    Parameters
    ----------
    light : Illumination
        Of the scene.
    origin : ndarray, shape (3,)
        Where the camera stands, m.
    directions : ndarray of float32, shape (H, W, 3)
        Unit vectors through the pixels' centres, in the world.
    samples : int
        Rays a pixel towards lamps.
    """
    height, width = directions.shape[:2]
    flat = np.ascontiguousarray(directions.reshape(-1, 3), np.float32)
    starts = np.broadcast_to(origin.astype(np.float32), flat.shape)
    hits = light.tracer.nearest(np.ascontiguousarray(starts), flat)
    distance, points, albedo = _surfaces(
        light, origin[None], flat, hits, shading.sample_order(height, width)
    )
    part = np.where(hits.triangle < 0, -1, light.geometry.part[np.maximum(hits.triangle, 0)])
    part = part.astype(np.int32)

    soft = _soft_light(light, points, hits, part, (height, width), samples)
    sun, glint = light.sunlight(points)
    specular, emission = points.gloss[:, :1], points.gloss[:, 2:]
    colour = albedo * (1 - specular) * (soft[:, :3] + sun) + albedo * emission
    colour += (soft[:, 3:] + glint[:, None]) * _tint(albedo, specular)
    _add_reflections(light, points, albedo, colour)
    colour[part < 0] = light.geometry.outdoors.sky
    instance = np.where(part < 0, -1, light.geometry.instance[np.maximum(part, 0)])
    return Picture(
        colour.reshape(height, width, 3).astype(np.float32),
        distance.reshape(height, width),
        points.normal.reshape(height, width, 3),
        instance.astype(np.int32).reshape(height, width),
    )


def _soft_light(
    light: Illumination,
    points: Points,
    hits: Hits,
    part: NDArray[np.int32],
    shape: tuple[int, int],
    samples: int,
) -> Array:
    """Irradiance and mirrored radiance (N, 4) without the sun: few samples, smoothed on surfaces.

    Every other pixel asks, as on a chess board; those between are filled by smoothing.
    """
    asking = np.flatnonzero(_chess_board(shape) & (part >= 0))
    some = points.at(asking)
    found = np.zeros((len(part), 8), np.float32)
    found[asking, :3], found[asking, 3] = light.direct(some, samples)
    found[asking, 4:7], found[asking, 7] = light.gathered(some, 1), 1
    for stride in (1, 3):
        surface = (hits.triangle, part, points.normal, points.position, *shape)
        found = shading.smoothed(found, *surface, stride)
    weight = found[:, 7:]
    soft = found[:, :4] / np.maximum(weight, 1e-6)
    soft[:, :3] += found[:, 4:7] / np.maximum(weight, 1e-6)
    lonely = np.flatnonzero((weight[:, 0] == 0) & (part >= 0))
    soft[lonely, :3] = light.irradiance[hits.triangle[lonely]]
    return soft


@lru_cache(maxsize=4)
def _chess_board(shape: tuple[int, int]) -> NDArray[np.bool_]:
    y, x = np.indices(shape).reshape(2, -1)
    return (x + y) % 2 == 0


def _surfaces(
    light: Illumination, origin: NDArray, flat: Array, hits: Hits, order: NDArray[np.int32]
) -> tuple[Array, Points, Array]:
    n, g = len(flat), light.geometry
    distance = np.full(n, np.nan, np.float32)
    position, normal, smooth, albedo, gloss = (np.zeros((n, 3), np.float32) for _ in range(5))
    pixel = float(np.linalg.norm(flat[1] - flat[0])) if n > 1 else 1e-3
    shading.surfaces(
        origin.astype(np.float64), flat, hits.triangle, hits.u, hits.v, g.vertices, g.faces,
        g.normals, g.part, g.materials, pixel, distance, position, normal, smooth, albedo, gloss,
    )  # fmt: skip
    return distance, Points(position, normal, smooth, flat, gloss, order), albedo


def _tint(albedo: Array, specular: Array) -> Array:
    """Metals colour what they mirror, lacquer and glaze do not."""
    metal = np.flatnonzero(specular[:, 0] > 0.3)
    tint = np.ones_like(albedo)
    share = np.minimum(2 * specular[metal] - 0.6, 1)
    hue = albedo[metal] / np.maximum(albedo[metal].max(axis=1, keepdims=True), 1e-3)
    tint[metal] = 1 - share * (1 - hue)
    return tint


def _add_reflections(light: Illumination, points: Points, albedo: Array, colour: NDArray) -> None:
    """What mirrors and polished metal show: one more ray, to the triangles' stored light."""
    shiny = np.flatnonzero(points.gloss[:, 0] >= MIRRORED_FROM)
    if not len(shiny):
        return
    view, normal = points.view[shiny], points.shading[shiny]
    away = view - 2 * (view * normal).sum(axis=1, keepdims=True) * normal
    away = np.ascontiguousarray(away / np.linalg.norm(away, axis=1, keepdims=True), np.float32)
    specular = points.gloss[shiny, :1]
    start = points.position[shiny]
    hits = light.tracer.nearest(start, away)
    _, _, marks = _surfaces(light, start, away, hits, points.order[shiny])
    # the triangle's stored light, with the pattern where the ray met it
    plain = np.maximum(light.albedo[np.maximum(hits.triangle, 0)], 1e-3)
    seen = light.met(hits, start) * np.clip(marks / plain, 0, 3)
    seen[hits.triangle < 0] = light.met(hits, start)[hits.triangle < 0]
    colour[shiny] += seen * specular * _tint(albedo[shiny], specular)
