"""Scenes: a target out of a setting, a frame, a file; meshes, and several of them as one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.instrument.frame_target import FrameTarget
from cmtof.instrument.settings import MATERIALS
from cmtof.instrument.targets import Corner, Hits, Plane, Target
from cmtof.scenes import load_frame
from cmtof.scenes.frame import Frame

Array = NDArray[np.float64]

SURFACE = 3e-3
"""How near to a point its own surface may be met, m."""


@dataclass(frozen=True, eq=False)
class MeshTarget:
    """Triangles, traced by Embree.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
        m, in the camera's coordinates.
    faces : ndarray, shape (F, 3)
        Numbers of vertices.
    reflectance : float or ndarray, shape (V,)
        0 to 1; that of the vertices is interpolated across each triangle.
    material : str
        One of `MATERIALS`, or "mixed".
    mirrored : float or ndarray, shape (V,), or None
        Of "mixed" alone: weight of the law of a specular surface against that of a diffuse one,
        0 to 1, interpolated alike.

    Raises
    ------
    ValueError
        For numbers that are neither one nor one a vertex, and for ``mirrored`` without "mixed".
    """

    vertices: NDArray
    faces: NDArray
    reflectance: float | Array = 0.5
    material: str = "diffuse"
    mirrored: float | Array | None = None

    def __post_init__(self) -> None:
        if (self.material == "mixed") != (self.mirrored is not None):
            raise ValueError(
                f"Expected mirrored for the material mixed alone, got {self.material!r}. "
                "Give both or neither."
            )
        for name in ("reflectance", "mirrored"):
            shape = np.shape(getattr(self, name))
            if shape not in ((), (len(self.vertices),)):
                raise ValueError(
                    f"Expected {name} of all or of each of {len(self.vertices)} vertices, "
                    f"got shape {shape}. Give one number a vertex."
                )

    @cached_property
    def _tracer(self) -> Any:
        """Embree's tree: made when first needed, so not for parts of an assembly."""
        from cmtof.scenes.rooms.tracing import Tracer

        return Tracer(np.asarray(self.vertices, np.float32), np.asarray(self.faces, np.int32))

    def look(self, directions: Array) -> Hits:
        """Trace unit rays (..., 3) from the origin."""
        rays = np.ascontiguousarray(directions.reshape(-1, 3), np.float32)
        hits = self._tracer.nearest(np.zeros_like(rays), rays)
        met = hits.triangle >= 0
        corners = np.asarray(self.faces)[np.where(met, hits.triangle, 0)]
        a, b, c = np.asarray(self.vertices, float)[corners].swapaxes(0, 1)
        normal = np.cross(b - a, c - a)
        exact = directions.reshape(-1, 3)
        # the range again in double precision, on the plane of the triangle that was met
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (exact * normal).sum(-1)
            reach = np.where(met, (a * normal).sum(-1) / along, np.nan)
            cosine = np.abs(along) / np.linalg.norm(normal, axis=-1)
        shape = directions.shape[:-1]

        def there(values: float | Array) -> Array:
            if np.ndim(values) == 0:
                return np.full(shape, values)
            u, v = np.where(met, hits.u, 0.0), np.where(met, hits.v, 0.0)
            share = np.stack([1 - u - v, u, v], -1)
            return (np.asarray(values, float)[corners] * share).sum(-1).reshape(shape)

        bright = there(self.reflectance)
        seen = Hits(reach.reshape(shape), np.nan_to_num(cosine).reshape(shape), bright)
        return seen if self.mirrored is None else seen._replace(mirrored=there(self.mirrored))

    def hidden(self, points: Array, eye: ArrayLike) -> NDArray[np.bool_]:
        """Whether something stands between points (..., 3) of the surface and an eye (3,), m."""
        way = points.reshape(-1, 3) - np.asarray(eye, float)
        far = np.linalg.norm(way, axis=-1)
        rays = np.ascontiguousarray(way / far[:, None], np.float32)
        start = np.broadcast_to(np.asarray(eye, np.float32), rays.shape).copy()
        reach = (far - SURFACE).astype(np.float32)
        return self._tracer.blocked(start, rays, reach).reshape(points.shape[:-1])


_MIRRORED = {"diffuse": 0.0, "specular": 1.0}


def assembled(parts: Sequence[MeshTarget]) -> MeshTarget:
    """Meshes of several materials as one "mixed" target; a ray ends at the nearest of them.

    Raises
    ------
    ValueError
        For retro-reflecting parts, whose law "mixed" does not know.
    """
    starts = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    bright, mirrored = [], []
    for part in parts:
        weight = part.mirrored if part.material == "mixed" else _MIRRORED.get(part.material)
        if weight is None:
            raise ValueError(
                f"Expected parts that are diffuse, specular or mixed, got {part.material!r}. "
                "Look at it alone."
            )
        bright.append(np.broadcast_to(part.reflectance, len(part.vertices)))
        mirrored.append(np.broadcast_to(weight, len(part.vertices)))
    return MeshTarget(
        np.concatenate([np.asarray(part.vertices, float) for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)]),
        np.concatenate(bright),
        "mixed",
        np.concatenate(mirrored),
    )


_ANALYTIC = {
    "plane": (Plane, {"distance", "tilt_x", "tilt_y", "reflectance", "material"}),
    "mirror": (Plane, {"distance", "tilt_x", "tilt_y", "reflectance"}),
    "corner": (Corner, {"distance", "radius", "reflectance"}),
}
_FILES = {"frame": {"file", "material"}, "mesh": {"file", "scale", "reflectance", "material"}}
_NAMED = {"object": {"name"}}


def scene_from(source: Any) -> Target | None:
    """Make a target of a setting, a frame, or what is a target already.

    Parameters
    ----------
    source : str, Path, Frame, mapping, Target or None
        A frame's file or embedded name; or ``{"kind": …}`` with kind plane, mirror or corner
        and the arguments of `Plane` and `Corner`, ``{"kind": "frame", "file": …, "material": …}``,
        ``{"kind": "mesh", "file": …, "scale": 1.0, "reflectance": …, "material": …}``
        or ``{"kind": "object", "name": …}`` out of `cmtof.scenes.objects.OBJECTS`.

    Raises
    ------
    ValueError
        For unknown kinds, keys or materials.

    Examples
    --------
    >>> scene_from({"kind": "mirror", "distance": 0.6, "reflectance": 1e-6}).material
    'specular'
    """
    if source is None or hasattr(source, "look"):
        return source
    if isinstance(source, Frame):
        return FrameTarget(source)
    if isinstance(source, (str, Path)):
        return FrameTarget(load_frame(source))
    if not isinstance(source, Mapping):
        raise ValueError(
            f"Expected twin.scene to be a name or a mapping, got {source!r}. Name a frame."
        )
    options = dict(source)
    kind = options.pop("kind", None)
    kinds = [*_ANALYTIC, *_FILES, *_NAMED]
    if kind not in kinds:
        raise ValueError(
            f"Expected twin.scene.kind out of {', '.join(kinds)}, got {kind!r}. Choose."
        )
    known = _ANALYTIC[kind][1] if kind in _ANALYTIC else {**_FILES, **_NAMED}[kind]
    needed = "distance" if kind in _ANALYTIC else "file" if kind in _FILES else "name"
    if needed not in options or not set(options) <= known:
        raise ValueError(
            f"Expected {needed} and other keys of twin.scene out of {', '.join(sorted(known))}, "
            f"got {', '.join(sorted(options)) or 'none'}. Correct them."
        )
    if options.get("material", "diffuse") not in MATERIALS:
        raise ValueError(
            f"Expected twin.scene.material out of {', '.join(MATERIALS)}, "
            f"got {options['material']!r}. Choose one."
        )
    if kind == "frame":
        return FrameTarget(load_frame(options.pop("file")), **options)
    if kind == "mesh":
        return _mesh(options)
    if kind == "object":
        from cmtof.scenes.objects import object_scene

        return object_scene(options["name"])
    if kind == "mirror":
        options["material"] = "specular"
    return _ANALYTIC[kind][0](**options)


def _mesh(options: dict[str, Any]) -> MeshTarget:
    try:
        import trimesh
    except ImportError as error:
        raise ValueError(
            f"Expected trimesh for a mesh, got {error}. "
            "Install the extra: pip install cmtof[rooms]."
        ) from error
    mesh: Any = trimesh.load(options.pop("file"), force="mesh")
    scale = float(options.pop("scale", 1.0))
    return MeshTarget(np.asarray(mesh.vertices) * scale, np.asarray(mesh.faces), **options)
