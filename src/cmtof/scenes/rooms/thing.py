"""Nouns of a room: a mesh, a part with its material, a thing with what it carries, a light."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.rooms.materials import Material

Pose = NDArray[np.float64]
"""Rigid motion (4, 4) into the frame of whatever carries the thing, m."""


class Mesh(NamedTuple):
    """Triangles; faces that share a vertex are shaded smooth there, a crease has two vertices."""

    vertices: NDArray[np.float32]
    """(V, 3), m."""
    faces: NDArray[np.int32]
    """(T, 3), counter-clockwise seen from outside."""


class Part(NamedTuple):
    """One mesh of one material."""

    mesh: Mesh
    material: Material
    grain: int = 0
    """Local axis along which wood grows and stripes run."""


class Support(NamedTuple):
    """A level rectangle on which other things may stand, m, in the thing's own frame."""

    x0: float
    x1: float
    y0: float
    y1: float
    z: float
    clearance: float = 0.5
    """Free height above."""


class Light(NamedTuple):
    """A parallelogram that shines, m; both sides of it where ``normal`` is zero."""

    centre: tuple[float, float, float]
    half_u: tuple[float, float, float]
    half_v: tuple[float, float, float]
    power: float
    """Radiant intensity over pi, in units of which a white wall 1 m away gets irradiance 1."""
    normal: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Side that shines (cosine law); zero for a bulb that shines everywhere."""
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass
class Thing:
    """Something with a name: it stands on z = 0 about the origin, its front towards -y.

    Attributes
    ----------
    kind : str
        What it is, as in ``"chair"``.
    parts : list of Part
        Its meshes.
    supports : list of Support
        Where clutter may rest.
    lights : list of Light
        What shines in it.
    children : list of (Thing, Pose)
        Things that it carries; they keep their own instance.
    """

    kind: str
    parts: list[Part] = field(default_factory=list)
    supports: list[Support] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    children: list[tuple["Thing", Pose]] = field(default_factory=list)
    _settled: tuple[int, NDArray[np.float64]] | None = field(
        default=None, init=False, repr=False, compare=False
    )

    def add(self, mesh: Mesh, material: Material, grain: int = 0) -> "Thing":
        """Append a part; returns the thing itself."""
        self.parts.append(Part(mesh, material, grain))
        return self

    def carry(self, thing: "Thing", x: float, y: float, z: float, turn: float = 0.0) -> "Thing":
        """Put another thing at (x, y, z), m, turned about the vertical, rad; returns itself."""
        self.children.append((thing, pose(x, y, z, turn)))
        return self

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Lowest and highest corner, (2, 3), m, of parts and children."""
        if self._settled is not None and self._settled[0] == len(self.children):
            return self._settled[1].copy()
        return self._measured()

    def settle(self) -> "Thing":
        """Remember the bounds: the parts are final, though more may be carried; returns itself."""
        self._settled = len(self.children), self._measured()
        return self

    def _measured(self) -> NDArray[np.float64]:
        low = [part.mesh.vertices.min(axis=0) for part in self.parts]
        high = [part.mesh.vertices.max(axis=0) for part in self.parts]
        for thing, motion in self.children:
            bounds = thing.bounds
            middle = motion[:3, :3] @ bounds.mean(axis=0) + motion[:3, 3]
            half = np.abs(motion[:3, :3]) @ (bounds[1] - bounds[0]) / 2
            low.append(middle - half)
            high.append(middle + half)
        if not low:
            return np.zeros((2, 3))
        return np.array([np.min(low, axis=0), np.max(high, axis=0)], float)


def pose(x: float = 0.0, y: float = 0.0, z: float = 0.0, turn: float = 0.0) -> Pose:
    """Pose at (x, y, z), m, turned counter-clockwise about the vertical by ``turn``, rad.

    Examples
    --------
    >>> transformed([1.0, 0.0, 0.0], pose(turn=np.pi / 2)).round(6).tolist()
    [0.0, 1.0, 0.0]
    """
    c, s = np.cos(turn), np.sin(turn)
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, z], [0, 0, 0, 1]], float)


def transformed(points: ArrayLike, motion: Pose) -> NDArray[np.float64]:
    """Points (..., 3) moved by a pose."""
    return np.asarray(points, float) @ motion[:3, :3].T + motion[:3, 3]


def moved(mesh: Mesh, motion: Pose) -> Mesh:
    """A mesh moved by a pose (or any affine map that does not mirror)."""
    return Mesh(transformed(mesh.vertices, motion).astype(np.float32), mesh.faces)
