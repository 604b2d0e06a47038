"""Targets of a beam: plane, frame, mesh. A target gives the end of a ray, not its light.

Coordinates of the camera: x right, y down, z forward; the galvo's beam leaves along +z at 0 V.
"""

from dataclasses import dataclass
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.linalg import norm
from numpy.typing import ArrayLike, NDArray
from pydantic import ConfigDict
from scipy.interpolate import RegularGridInterpolator

from cmtof.frame import rays_from_camera
from cmtof.scenes import Frame, load_frame
from cmtof.types import Array, Arrays, Flags, Numbers

# Neighbouring pixels whose depths differ by a smaller share: one surface
LARGEST_STEP = 0.02
SURFACE = 3e-3  # How near to a point its own surface may be met, m


class RayEnds(NamedTuple):
    """Where rays (...) ended, arrays or one number for all; NaN range where they met nothing."""

    range: Any  # m
    cosine: Any  # between the ray and the surface's normal, 0 to 1
    reflectance: Any  # 0 to 1
    mirrored: Any = 0.0  # weight of the specular law against the diffuse one, 0 to 1


Target = Any  # What has ``look``, from unit rays (..., 3) of the origin to `RayEnds`


@dataclass(frozen=True)
class Plane:
    """Flat surface that cuts the z axis at ``distance``, m; a mirror if ``mirrored`` is 1."""

    __pydantic_config__ = ConfigDict(extra="forbid")
    distance: float
    tilt_x: float = 0.0  # slope dz/dx as an angle, rad
    reflectance: float = 0.5
    mirrored: float = 0.0

    def look(self, directions: Array) -> RayEnds:
        """Trace unit rays (..., 3) from the origin."""
        normal = np.array([-np.tan(self.tilt_x), 0.0, 1.0])
        along = directions @ normal
        reach = self.distance / np.where(along > 0, along, np.nan)
        cosine = along / norm(normal)
        return RayEnds(reach, cosine, self.reflectance, self.mirrored)


PLATE = Plane(0.60)  # Diffuse target of Sec. 8.2
# Silvered PF10-03-P01 (known, at 532 nm)
MIRROR = Plane(0.60, reflectance=0.97, mirrored=1.0)


class FrameTarget:
    """A frame's depth and intensity, clipped to 1 as reflectance, looked up through its camera."""

    def __init__(self, frame: Frame) -> None:
        if frame.camera is None:
            raise ValueError(
                f"Expected a frame with a camera, got {frame.name!r}. Store one."
            )
        fx, fy, cx, cy, *skew = frame.camera
        # from rays to rows and columns
        self._camera = np.array([[0, fy, cy], [fx, sum(skew), cx]], float)
        self._reflectance = np.clip(frame.intensity, 0, 1, dtype=float)
        rays = rays_from_camera(frame.depth.shape, frame.camera)
        planar = frame.depth / norm(rays, axis=-1)
        self._inverse = 1 / planar
        self._cosine = _cosines(planar, rays)
        self._smooth = RegularGridInterpolator(
            [np.arange(size) + 0.5 for size in planar.shape],
            self._inverse,
            bounds_error=False,
            fill_value=None,  # pyright: ignore[reportArgumentType]
        )
        corners = sliding_window_view(self._inverse, (2, 2))
        step = np.ptp(corners, axis=(2, 3)) / corners.min(axis=(2, 3))
        # the rim beyond the outer middles belongs to the next cell
        self._step = np.pad(step, 1, mode="edge")

    def look(self, directions: Array) -> RayEnds:
        """Trace unit rays (..., 3) from the origin."""
        ahead = np.where(directions[..., 2] > 0, directions[..., 2], np.nan)
        pixels = np.vecdot(self._camera, directions[..., None, :]) / ahead[..., None]
        seen = ((pixels >= 0) & (pixels < self._inverse.shape)).all(-1)
        place = np.moveaxis(np.where(seen[..., None], pixels, 0.0), -1, 0)
        nearest = tuple(place.astype(int))
        cell = tuple((place + 0.5).astype(int))
        # exact on planes; across a step that of the nearest pixel
        inverse = np.where(
            self._step[cell] < LARGEST_STEP,
            self._smooth(tuple(place)),
            self._inverse[nearest],
        )
        reach = 1 / (inverse * np.where(seen, ahead, np.nan))
        return RayEnds(reach, self._cosine[nearest], self._reflectance[nearest])


def _cosines(planar: Array, rays: Array) -> Array:
    """Cosine of incidence (H, W) from the steps to neighbours."""
    points = rays * planar[..., None]
    down = _smaller_step(points.swapaxes(0, 1)).swapaxes(0, 1)
    normal = np.cross(_smaller_step(points), down)
    with np.errstate(all="ignore"):
        along = abs(np.vecdot(normal, rays))
        cosine = along / norm(normal, axis=-1) / norm(rays, axis=-1)
    return np.nan_to_num(cosine, nan=1.0).clip(0, 1)


def _smaller_step(points: Array) -> Array:
    """The smaller of the steps (H, W, 3) to the left and to the right neighbour, by depth."""
    step = np.diff(points, axis=1, prepend=np.nan, append=np.nan)
    size = np.nan_to_num(abs(step[..., 2:]), nan=np.inf)
    return np.where(size[:, :-1] < size[:, 1:], step[:, :-1], step[:, 1:])


@dataclass(frozen=True, eq=False)
class MeshTarget:
    """Triangles (F, 3) of vertices (V, 3), m, traced by Embree."""

    vertices: NDArray
    faces: NDArray
    reflectance: ArrayLike = 0.5  # a number or (V,), which is interpolated
    mirrored: ArrayLike = 0.0  # likewise

    @classmethod
    def from_mesh(cls, mesh: Any) -> "MeshTarget":
        """Target of a trimesh with the vertex attributes ``reflectance`` and ``mirrored``."""
        held = mesh.vertex_attributes
        return cls(mesh.vertices, mesh.faces, held["reflectance"], held["mirrored"])

    @cached_property
    def _tracer(self) -> Any:
        """Embree's tree, made when it is first needed."""
        from cmtof_rooms.engine import Tracer

        return Tracer(self.vertices, self.faces)

    def look(self, directions: Array) -> RayEnds:
        """Trace unit rays (..., 3) from the origin."""
        exact = directions.reshape(-1, 3)
        rays = np.ascontiguousarray(exact, np.float32)
        hits = self._tracer.nearest(np.zeros_like(rays), rays)
        met = hits.triangle >= 0
        corners = np.asarray(self.faces)[np.where(met, hits.triangle, 0)]
        reach, cosine = self._plane_met(exact, corners)
        found = [np.where(met, reach, np.nan), cosine]
        weights = np.stack([1 - hits.u - hits.v, hits.u, hits.v], -1)
        weights[~met] = [1, 0, 0]
        for held in (self.reflectance, self.mirrored):
            there = np.broadcast_to(held, len(self.vertices))[corners]
            found.append(np.vecdot(there, weights))
        return RayEnds(*(one.reshape(directions.shape[:-1]) for one in found))

    def _plane_met(self, rays: Array, corners: Numbers) -> Arrays:
        """Ranges (N,), m, and cosines of rays on the planes of triangles, in double precision."""
        a, b, c = np.asarray(self.vertices, float)[corners].swapaxes(0, 1)
        normal = np.cross(b - a, c - a)
        with np.errstate(all="ignore"):
            along = np.vecdot(rays, normal)
            cosine = abs(along) / norm(normal, axis=-1)
            return np.vecdot(a, normal) / along, np.nan_to_num(cosine)

    def is_hidden(self, points: Array, eye: Array) -> Flags:
        """Whether something stands between points (..., 3) of the surface and an eye (3,), m."""
        way = points.reshape(-1, 3) - eye
        far = norm(way, axis=-1)
        rays = (way / far[:, None]).astype(np.float32)
        reach = (far - SURFACE).astype(np.float32)
        hidden = self._tracer.is_blocked(np.full_like(rays, eye), rays, reach)
        return hidden.reshape(points.shape[:-1])


@cache
def _object(name: str) -> MeshTarget:
    from cmtof_lab.objects import object_mesh

    return MeshTarget.from_mesh(object_mesh(name))


# Targets by the ``kind`` of a rig file's ``twin.scene``; the other keys are their arguments
KINDS = {
    "plane": Plane,
    "mirror": partial(Plane, mirrored=1.0),
    "object": _object,
}


def scene_from(source: Any) -> Target | None:
    """Target of a frame, its file or embedded name, a mapping with `KINDS`, or a target itself."""
    if source is None or hasattr(source, "look"):
        return source
    if isinstance(source, (str, Path)):
        source = load_frame(source)
    if isinstance(source, Frame):
        return FrameTarget(source)
    try:
        options = {**source}
        return KINDS[options.pop("kind")](**options)
    except (KeyError, TypeError):
        raise ValueError(
            f"Expected twin.scene to be a name, or a kind out of {', '.join(KINDS)} with "
            f"its keys, got {source!r}. Correct it."
        ) from None
