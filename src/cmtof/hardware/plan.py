"""What a scan does, burst by burst, settled before anything is touched.

A *burst* is one point in one modulation mode: 16 phases of 20 samples. Bursts are numbered from 1;
the number is the *label* that travels with the burst to the read-out. A *line* is the run of bursts
that stands or falls together, one record of the journal. Each mode is taken in one go, its
calibration around it, so that neither the plates turn nor the phases drift more than they must::

    dark, reference target, every line of the image, reference target again
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.frame import rays_from_camera

Array = NDArray[np.float64]

MODES = ("single", "doubled")
"""Modulation modes, that of the lower frequency first."""
DARK_BURSTS = 16
"""Bursts behind the closed shutter, each mode."""
REFERENCE_BURSTS = 8
"""Bursts at each position of the reference target."""
LARGEST = 4096
"""Height and width of an image at most, px."""


class Line(NamedTuple):
    """Bursts that are recorded together: a "reference", "dark" or "scan" line of a mode.

    ``first`` is the label of the first of ``bursts``; ``row`` is that of the image.
    """

    index: int
    kind: str
    mode: str
    first: int
    bursts: int
    row: int = 0

    @property
    def labels(self) -> range:
        """Labels of the bursts."""
        return range(self.first, self.first + self.bursts)


class Record(NamedTuple):
    """One line as it was measured.

    ``power`` behind the emission module at its end, W; ``sums`` (N, K) of the kept samples of each
    phase; ``clipped`` (N,) samples at either end of the converter's scale.
    """

    line: int
    power: float
    sums: NDArray[np.uint32]
    clipped: NDArray[np.uint16]


@dataclass(frozen=True, eq=False)
class Plan:
    """Directions, modes and calibration of a scan.

    Parameters
    ----------
    angles : ndarray, shape (H, W, 2)
        Optical angles x and y of the mirrors, rad.
    camera : ndarray, shape (4,)
        fx, fy, cx, cy, px, of the pinhole with the same rays.
    modes : tuple of str
        Modes in the order in which they are taken.
    sweep : tuple of float
        Positions of the reference target from its zero, m.
    """

    angles: Array
    camera: Array
    modes: tuple[str, ...] = MODES
    sweep: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        modes = set(self.modes)
        if not np.isfinite(self.angles).all() or not modes <= {*MODES} or not modes:
            raise ValueError(
                f"Expected finite angles and modes out of {MODES}, got {self.modes}. Correct them."
            )
        self.angles.setflags(write=False)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the image, px."""
        return self.angles.shape[0], self.angles.shape[1]

    @property
    def bursts(self) -> int:
        """Number of bursts, which is the label of the last one."""
        return self.lines[-1].labels[-1]

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Every line, in order."""
        height, width = self.shape
        image = [("scan", width, row) for row in range(height)]
        reference = ("reference", REFERENCE_BURSTS * len(self.sweep), 0)
        once = [("dark", DARK_BURSTS, 0), reference, *image, reference]
        parts = [(mode, *part) for mode in self.modes for part in once]
        firsts = accumulate((part[2] for part in parts), initial=1)
        return tuple(
            Line(index, kind, mode, first, bursts, row)
            for index, ((mode, kind, bursts, row), first) in enumerate(
                zip(parts, firsts, strict=False)
            )
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain values from which `from_dict` makes the same plan."""
        held = {"modes": list(self.modes), "sweep": list(self.sweep), "shape": list(self.shape)}
        return held | {"camera": self.camera.tolist()}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "Plan":
        """Plan of what `as_dict` gave."""
        calibration = tuple(values["modes"]), tuple(float(s) for s in values["sweep"])
        height, width = (int(size) for size in values["shape"])
        camera = np.asarray(values["camera"], float)
        if not (1 <= height <= LARGEST and 1 <= width <= LARGEST) or camera.shape != (4,):
            raise ValueError(f"Expected 1 to {LARGEST} px, got {height} x {width}. Change --size.")
        angles = angles_from_rays(rays_from_camera((height, width), camera))
        return cls(angles, camera, *calibration)


def raster(
    size: int | tuple[int, int],
    *,
    field_of_view: Sequence[float],
    modes: Sequence[str] = MODES,
    sweep: Sequence[float] = (0.0,),
) -> Plan:
    """Plan of an image whose rays are those of a pinhole: uniform in the tangent of the angle.

    Parameters
    ----------
    size : int or (int, int)
        Height and width, px; one number for both.
    field_of_view : (float, float)
        Full optical angles across and down, rad, from edge to edge of the pixels.
    modes, sweep
        As in `Plan`.

    Examples
    --------
    >>> plan = raster(4, field_of_view=(0.4, 0.4))
    >>> plan.shape, len(plan.lines), plan.bursts
    ((4, 4), 14, 96)
    """
    height, width = (size, size) if isinstance(size, int) else size
    focal = np.array([width, height]) / 2 / np.tan(np.asarray(field_of_view) / 2)
    camera = [*focal.tolist(), width / 2, height / 2]
    held = {"modes": modes, "sweep": sweep, "shape": (height, width), "camera": camera}
    return Plan.from_dict(held)


def angles_from_rays(rays: ArrayLike) -> Array:
    """Optical angles (..., 2), rad, of rays (..., 3), x right, y down, z forward."""
    x, y, z = np.moveaxis(np.asarray(rays, float), -1, 0)
    return np.stack([np.arctan2(x, z), np.arctan2(y, z)], axis=-1)
