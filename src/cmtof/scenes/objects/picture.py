"""A picture of an object as an eye would see it: a rendering that stands in for a photograph."""

import numpy as np
from numpy.typing import NDArray

from cmtof.instrument.targets import MeshTarget
from cmtof.pointcloud import normals_from_points, points_from_depth
from cmtof.scenes.frame import rays_from_camera

Array = NDArray[np.float64]

LAMP = (-0.7, -0.9, -0.1)
"""Place of the lamp, m: above the instrument, to its left."""
AMBIENT = 0.3
"""Light from all sides, as a share of the lamp's at 1 m."""
GLOSS = 60.0
"""Exponent of the highlight (Blinn 1977)."""


def picture(target: MeshTarget, *, size: int, field_of_view: float) -> Array:
    """Render an object in grey, (size, size), 0 to 1: Lambert's law, gloss, shadow, gamma 2.2.

    Reflectance is that at 532 nm. What a polished surface mirrors is a pale ceiling and a dark
    floor.

    Parameters
    ----------
    target : MeshTarget
    size : int
        px.
    field_of_view : float
        Full angle across and down, rad.
    """
    focal = size / 2 / np.tan(field_of_view / 2)
    camera = np.array([focal, focal, size / 2, size / 2])
    rays = rays_from_camera((size, size), camera)
    rays = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    hits = target.look(rays)
    points = points_from_depth(hits.range, camera)
    normal = normals_from_points(points)
    to_lamp = np.array(LAMP) - points
    far = np.linalg.norm(to_lamp, axis=-1)
    lamp = to_lamp / far[..., None]
    lit = (
        np.clip((normal * lamp).sum(-1), 0, None)
        / far**2
        * ~target.hidden(np.nan_to_num(points), LAMP)
    )
    half = lamp - rays
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    shine = np.clip((normal * half).sum(-1), 0, None) ** GLOSS * (lit > 0)
    mirrored = hits.mirrored * np.ones_like(far)
    up = -(rays - 2 * (rays * normal).sum(-1, keepdims=True) * normal)[..., 1]
    room = AMBIENT * (1 + np.tanh(3 * up))
    matt = (1 - mirrored) * (lit + AMBIENT)
    grey = hits.reflectance * (matt + mirrored * (room + 4 * shine))
    white = np.nanpercentile(grey, 99.5)
    return np.clip(np.nan_to_num(grey) / white, 0, 1) ** (1 / 2.2)
