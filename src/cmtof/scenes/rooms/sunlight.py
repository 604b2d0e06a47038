"""Patches of sun on floors and walls: small, bright, and lamps to the rest of the room.

A gathered ray meets such a patch too rarely; asked for as a lamp it lights without specks.
"""

import numpy as np
from numpy.typing import NDArray

from cmtof.scenes.rooms.assembly import LIGHT, Geometry
from cmtof.scenes.rooms.tracing import Tracer

_GRID = 16  # rays across each window


def sun_patches(
    geometry: Geometry, tracer: Tracer, albedo: NDArray[np.float32]
) -> NDArray[np.void]:
    """Lamps (N,) of `LIGHT`, one for each window's largest patch of sun.

    Parameters
    ----------
    albedo : ndarray, shape (T, 3)
        Of every triangle.
    """
    outdoors = geometry.outdoors
    if outdoors.sun <= 0:
        return np.empty(0, LIGHT)
    towards = np.array(outdoors.towards_sun, np.float32)
    windows = geometry.lights[geometry.lights["normal"] @ towards < -0.05]
    found = [_patch(geometry, tracer, albedo, window, towards) for window in windows]
    return np.array([lamp for lamp in found if lamp is not None], LIGHT)


def _patch(
    geometry: Geometry,
    tracer: Tracer,
    albedo: NDArray[np.float32],
    window: np.void,
    towards: NDArray[np.float32],
) -> tuple | None:
    """The lamp that the sun makes of what it meets through one window; None if it meets nothing."""
    a, b = np.meshgrid(*[(np.arange(_GRID) + 0.5) / _GRID * 2 - 1] * 2)
    across = a.reshape(-1, 1) * window["half_u"] + b.reshape(-1, 1) * window["half_v"]
    points = (window["centre"] + across).astype(np.float32)
    rays = np.broadcast_to(towards, points.shape)
    open_sky = ~tracer.blocked(points, rays, np.full(len(points), 100, np.float32))
    hits = tracer.nearest(points, -rays)
    lit = np.flatnonzero(open_sky & (hits.triangle >= 0))
    if len(lit) < 4:
        return None
    part = geometry.part[hits.triangle[lit]]
    most = np.bincount(part).argmax()
    lit = lit[part == most]
    triangle = hits.triangle[lit]
    corners = geometry.vertices[geometry.faces[triangle]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)
    normal /= np.linalg.norm(normal) + 1e-12
    if normal @ towards < 0.05:
        return None
    where = points[lit] - hits.distance[lit, None] * towards
    centre = where.mean(axis=0)
    # of a uniform patch, half a side is sqrt(3) standard deviations
    _, extent, axes = np.linalg.svd(where - centre, full_matrices=False)
    half = np.sqrt(3 / len(lit)) * extent[:2, None] * axes[:2]
    pane = 4 * np.linalg.norm(np.cross(window["half_u"], window["half_v"])) / _GRID**2
    flux = len(lit) * pane * -float(window["normal"] @ towards) * geometry.outdoors.sun
    colour = albedo[triangle].mean(axis=0)
    strength = float(colour.max()) + 1e-6
    return (
        centre + 0.01 * normal,
        half[0],
        half[1],
        normal,
        colour / strength,
        flux * strength / np.pi,
    )
