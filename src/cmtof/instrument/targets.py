"""What a beam can meet; here a plane and a corner cube, of one material each.

Coordinates of the camera: x right, y down, z forward; the galvo stands at the origin and its beam
leaves along +z at zero volts. A target tells where a ray ends, not how much light comes back.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Hits(NamedTuple):
    """Where rays (...) ended; NaN range where they met nothing."""

    range: Array
    """m."""
    cosine: Array
    """Cosine between the ray and the surface's normal, 0 to 1."""
    reflectance: Array
    """0 to 1."""
    mirrored: Array | float = 1.0
    """Only where the target is "mixed": weight of the law of a specular surface against that of a
    diffuse one, 0 to 1."""


class Target(Protocol):
    """Something that sends light back."""

    @property
    def material(self) -> str:
        """Return "diffuse", "specular", "retro", or "mixed" where each hit tells its own."""
        ...

    def look(self, directions: Array) -> Hits:
        """Trace unit rays (..., 3) from the origin."""
        ...


@dataclass(frozen=True)
class Plane:
    """Flat surface through a point of the z axis; a mirror if it is specular.

    Parameters
    ----------
    distance : float
        Where it cuts the z axis, m.
    tilt_x, tilt_y : float
        Slopes dz/dx and dz/dy as angles, rad.
    reflectance : float
        0 to 1.
    material : str
        One of `cmtof.instrument.settings.MATERIALS`.
    """

    distance: float
    tilt_x: float = 0.0
    tilt_y: float = 0.0
    reflectance: float = 0.5
    material: str = "diffuse"

    def look(self, directions: Array) -> Hits:
        """Trace unit rays (..., 3) from the origin."""
        normal = np.array([-np.tan(self.tilt_x), -np.tan(self.tilt_y), 1.0])
        along = directions @ normal
        with np.errstate(divide="ignore"):
            reach = np.where(along > 0, self.distance / along, np.nan)
        cosine = along / np.linalg.norm(normal)
        return Hits(reach, cosine, np.full(reach.shape, self.reflectance))


@dataclass(frozen=True)
class Corner:
    """Corner cube with its apex on the z axis.

    Whatever ray enters, the way to and fro is that to the plane through the apex across the ray.

    Parameters
    ----------
    distance : float
        Range of the apex, m.
    radius : float
        Radius of its opening, m.
    reflectance : float
        0 to 1.
    """

    distance: float
    radius: float = 0.0127
    reflectance: float = 0.9
    material: str = "retro"

    def look(self, directions: Array) -> Hits:
        """Trace unit rays (..., 3) from the origin."""
        reach = self.distance * directions[..., 2]
        off = np.sqrt(np.maximum(self.distance**2 - reach**2, 0))
        inside = (reach > 0) & (off <= self.radius)
        return Hits(
            np.where(inside, reach, np.nan),
            directions[..., 2],
            np.full(reach.shape, self.reflectance),
        )
