"""Rays traced through triangles by Embree, and directions spread over the sphere."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cmtof.types import Array, Flags, Numbers


class RayHits(NamedTuple):
    """What N rays met first."""

    distance: Array  # m, (N,)
    triangle: Numbers  # its number (N,); -1 where nothing was met
    u: Array  # weight of the triangle's second corner at the place that was met, (N,)
    v: Array  # weight of its third corner, (N,)


class Tracer:
    """Triangles that rays can be sent against.

    Parameters
    ----------
    vertices : array_like, shape (V, 3)
        m.
    faces : array_like of int, shape (F, 3)

    Raises
    ------
    ValueError
        If Embree is not installed.
    """

    def __init__(self, vertices: ArrayLike, faces: ArrayLike) -> None:
        try:
            from embreex.mesh_construction import TriangleMesh
            from embreex.rtcore_scene import EmbreeScene
        except ImportError as error:
            raise ValueError(
                f"Expected Embree for rendering rooms, got {error}. "
                "Install it: pip install 'cmtof[rooms]'."
            ) from error
        self._scene: Any = EmbreeScene(robust=True)
        TriangleMesh(
            self._scene,
            np.asarray(vertices, np.float32),
            np.asarray(faces, np.int32),
        )

    def nearest(self, origins: Array, directions: Array) -> RayHits:
        """First triangle along each ray.

        Parameters
        ----------
        origins, directions : ndarray of float32, shape (N, 3)
            m, and unit vectors.
        """
        found = self._scene.run(origins, directions, output=1)
        return RayHits(found["tfar"], found["primID"], found["u"], found["v"])

    def is_blocked(self, origins: Array, directions: Array, reach: Array) -> Flags:
        """Whether anything lies within ``reach``, (N,), m, along each ray."""
        return self._scene.run(origins, directions, dists=reach, query="OCCLUDED") == 0


def sphere_of_directions(count: int) -> Array:
    """Directions (N, 3) spread evenly over the sphere (a Fibonacci lattice)."""
    number = np.arange(count)
    turn = number * (np.pi * (3 - np.sqrt(5)))
    z = 1 - (2 * number + 1) / count
    radius = np.sqrt(1 - z**2)
    return np.stack([np.cos(turn) * radius, np.sin(turn) * radius, z], -1).astype(
        np.float32
    )
