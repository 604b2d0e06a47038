"""A frame as a target: depth and brightness, looked up by direction."""

import numpy as np
from numpy.typing import NDArray

from cmtof.instrument.targets import Hits
from cmtof.scenes.frame import Frame, ray_lengths, rays_from_camera

Array = NDArray[np.float64]

LARGEST_STEP = 0.02
"""Neighbouring pixels whose depths differ by less than this share belong to one surface."""


class FrameTarget:
    """A frame's depth and intensity, looked up by direction through its camera.

    Between pixels of one surface the inverse depth along the axis is interpolated, which is exact
    on planes; across a step the nearest pixel counts. The intensity, clipped to 1, is taken as
    reflectance. Outside the frame nothing returns.

    Parameters
    ----------
    frame : Frame
        With a camera.
    material : str
        One of `cmtof.instrument.settings.MATERIALS`.
    """

    def __init__(self, frame: Frame, material: str = "diffuse") -> None:
        if frame.camera is None:
            raise ValueError(
                f"Expected a frame with a camera, got none in {frame.name or 'the frame'}. "
                "Store fx, fy, cx, cy."
            )
        self.material = material
        self._camera = np.asarray(frame.camera, float)
        self._reflectance = np.clip(np.asarray(frame.intensity, float), 0, 1)
        planar = np.asarray(frame.depth, float) / ray_lengths(frame.depth.shape, self._camera)
        self._inverse = 1 / planar
        self._cosine = _cosines(planar, rays_from_camera(planar.shape, self._camera))

    def look(self, directions: Array) -> Hits:
        """Trace unit rays (..., 3) from the origin."""
        fx, fy, cx, cy, *skew = self._camera
        height, width = self._inverse.shape
        forward = directions[..., 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = directions[..., 0] / forward, directions[..., 1] / forward
            u, v = fx * x + sum(skew) * y + cx, fy * y + cy
            seen = (forward > 0) & (u >= 0) & (u < width) & (v >= 0) & (v < height)
            u, v = np.where(seen, u, 0.0), np.where(seen, v, 0.0)
            row, column = v.astype(int), u.astype(int)
            reach = 1 / (self._between(u, v, row, column) * forward)
        here = row * width + column
        reach = np.where(seen, reach, np.nan)
        return Hits(reach, self._cosine.ravel()[here], self._reflectance.ravel()[here])

    def _between(self, u: Array, v: Array, row: NDArray, column: NDArray) -> Array:
        """Inverse depth at pixel positions: bilinear within a surface, else the nearest."""
        height, width = self._inverse.shape
        flat = self._inverse.ravel()
        nearest = flat[row * width + column]
        if height < 2 or width < 2:
            return nearest
        i = np.minimum(np.maximum(v - 0.5, 0).astype(int), height - 2)
        j = np.minimum(np.maximum(u - 0.5, 0).astype(int), width - 2)
        s, t = v - 0.5 - i, u - 0.5 - j
        corner = i * width + j
        a, b, c, d = (flat[corner + step] for step in (0, 1, width, width + 1))
        low = np.minimum(np.minimum(a, b), np.minimum(c, d))
        high = np.maximum(np.maximum(a, b), np.maximum(c, d))
        above, below = a + t * (b - a), c + t * (d - c)
        return np.where(high - low < LARGEST_STEP * low, above + s * (below - above), nearest)


def _cosines(planar: Array, rays: Array) -> Array:
    """Cosine of incidence (H, W) from the smaller of the steps to either neighbour."""
    points = rays * planar[..., None]
    along = [_smaller_step(points, axis) for axis in (0, 1)]
    normal = np.cross(along[1], along[0])
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = np.abs((normal * rays).sum(-1)) / (
            np.linalg.norm(normal, axis=-1) * np.linalg.norm(rays, axis=-1)
        )
    return np.clip(np.nan_to_num(cosine, nan=1.0), 0, 1)


def _smaller_step(points: Array, axis: int) -> Array:
    if points.shape[axis] < 2:
        return np.zeros_like(points)
    step = np.diff(points, axis=axis)
    blank = np.full_like(np.take(points, [0], axis=axis), np.nan)
    before, after = np.concatenate([blank, step], axis), np.concatenate([step, blank], axis)
    size = [np.nan_to_num(np.abs(s[..., 2]), nan=np.inf) for s in (before, after)]
    return np.where((size[0] < size[1])[..., None], before, after)
