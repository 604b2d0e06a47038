"""Scenes: a target out of a setting, a frame, a file; and meshes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cmtof.hardware.twin.frame_target import FrameTarget
from cmtof.hardware.twin.settings import MATERIALS
from cmtof.hardware.twin.targets import Corner, Hits, Plane, Target
from cmtof.scenes.rgbd import Frame, load_frame

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MeshTarget:
    """Triangles, traced by Embree.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
        m, in the camera's coordinates.
    faces : ndarray, shape (F, 3)
        Numbers of vertices.
    reflectance : float
        0 to 1.
    material : str
        One of `MATERIALS`.
    """

    vertices: NDArray
    faces: NDArray
    reflectance: float = 0.5
    material: str = "diffuse"
    _tracer: Any = field(init=False, repr=False)

    def __post_init__(self) -> None:
        from cmtof.scenes.rooms.tracing import Tracer

        corners = np.asarray(self.vertices, np.float32)
        tracer = Tracer(corners, np.asarray(self.faces, np.int32))
        object.__setattr__(self, "_tracer", tracer)

    def look(self, directions: Array) -> Hits:
        """Trace unit rays (..., 3) from the origin."""
        rays = np.ascontiguousarray(directions.reshape(-1, 3), np.float32)
        hits = self._tracer.nearest(np.zeros_like(rays), rays)
        met = hits.triangle >= 0
        a, b, c = np.asarray(self.vertices, float)[
            np.asarray(self.faces)[np.where(met, hits.triangle, 0)]
        ].swapaxes(0, 1)
        normal = np.cross(b - a, c - a)
        exact = directions.reshape(-1, 3)
        # the range again in double precision, on the plane of the triangle that was met
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (exact * normal).sum(-1)
            reach = np.where(met, (a * normal).sum(-1) / along, np.nan)
            cosine = np.abs(along) / np.linalg.norm(normal, axis=-1)
        shape = directions.shape[:-1]
        bright = np.full(shape, self.reflectance)
        return Hits(reach.reshape(shape), np.nan_to_num(cosine).reshape(shape), bright)


_ANALYTIC = {
    "plane": (Plane, {"distance", "tilt_x", "tilt_y", "reflectance", "material"}),
    "mirror": (Plane, {"distance", "tilt_x", "tilt_y", "reflectance"}),
    "corner": (Corner, {"distance", "radius", "reflectance"}),
}
_FILES = {"frame": {"file", "material"}, "mesh": {"file", "scale", "reflectance", "material"}}


def scene_from(source: Any) -> Target | None:
    """Make a target of a setting, a frame, or what is a target already.

    Parameters
    ----------
    source : str, Path, Frame, mapping, Target or None
        A frame's file or embedded name; or ``{"kind": …}`` with kind plane, mirror or corner
        and the arguments of `Plane` and `Corner`, ``{"kind": "frame", "file": …, "material": …}``
        or ``{"kind": "mesh", "file": …, "scale": 1.0, "reflectance": …, "material": …}``.

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
    kinds = [*_ANALYTIC, *_FILES]
    if kind not in kinds:
        raise ValueError(
            f"Expected twin.scene.kind out of {', '.join(kinds)}, got {kind!r}. Choose."
        )
    known = _FILES[kind] if kind in _FILES else _ANALYTIC[kind][1]
    needed = "file" if kind in _FILES else "distance"
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
