"""Rays against triangles, by Embree."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Rays = NDArray[np.float32]


class Hits(NamedTuple):
    """What N rays met first."""

    distance: NDArray[np.float32]
    """(N,), m; meaningless where nothing was met."""
    triangle: NDArray[np.int32]
    """(N,); -1 where nothing was met."""
    u: NDArray[np.float32]
    """(N,) weight of the triangle's second vertex."""
    v: NDArray[np.float32]
    """(N,) weight of its third."""


@dataclass
class Tracer:
    """Triangles that rays can be sent against; counts rays and the seconds that Embree took."""

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    rays: int = 0
    seconds: float = 0.0
    _scene: Any = field(init=False, repr=False)

    def __post_init__(self) -> None:
        try:
            from embreex.mesh_construction import TriangleMesh
            from embreex.rtcore_scene import EmbreeScene
        except ImportError as error:
            raise ValueError(
                f"Expected Embree for rendering rooms, got {error}. "
                "Install the extra: pip install cmtof[rooms]."
            ) from error
        self._scene = EmbreeScene(robust=True)
        TriangleMesh(self._scene, self.vertices, self.faces)

    def nearest(self, origins: Rays, directions: Rays) -> Hits:
        """First triangle along each ray, (N, 3) and (N, 3), unit directions."""
        found = self._run(origins, directions, output=1)
        return Hits(found["tfar"], found["primID"], found["u"], found["v"])

    def blocked(
        self, origins: Rays, directions: Rays, reach: NDArray[np.float32]
    ) -> NDArray[np.bool_]:
        """Whether anything lies within ``reach``, (N,), m, along each ray."""
        return self._run(origins, directions, dists=reach, query="OCCLUDED") == 0

    def _run(self, origins: Rays, directions: Rays, **options: Any) -> Any:
        from time import thread_time

        self.rays += len(origins)
        start = thread_time()
        result = self._scene.run(origins, directions, **options)
        self.seconds += thread_time() - start
        return result
