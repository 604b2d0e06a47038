"""What a scan does, burst by burst, settled before anything is touched.

A *burst* is one point in one modulation mode: 16 phases of 20 samples. Bursts are numbered from 1;
the number is the *label* that travels with the burst to the read-out. A *line* is the run of bursts
that stands or falls together, one record of the journal. Each mode is taken in one go, its
calibration around it, so that neither the plates turn nor the phases drift more than they must::

    dark, reference target, every line of the image, reference target again
"""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.frame import rays_from_camera

Array = NDArray[np.float64]

MODES = ("single", "doubled")
"""Modulation modes, that of the lower frequency first."""
LINE_LENGTH = 64
"""Points of a list that are recorded together."""
DARK_BURSTS = 16
"""Bursts behind the closed shutter, each mode."""
REFERENCE_BURSTS = 8
"""Bursts at each position of the reference target."""
LARGEST = 4096
"""Height and width of an image at most, px."""


class Line(NamedTuple):
    """Bursts that are recorded together: a "reference", "dark" or "scan" line of a mode.

    ``first`` is the label of the first of ``bursts``; ``row`` and ``start`` are the row of the
    image and the first column in it, 0 where nothing of the image is taken.
    """

    index: int
    kind: str
    mode: str
    first: int
    bursts: int
    row: int = 0
    start: int = 0

    @property
    def labels(self) -> range:
        """Labels of the bursts."""
        return range(self.first, self.first + self.bursts)

    @property
    def columns(self) -> slice:
        """Columns of the image that a line of it fills."""
        return slice(self.start, self.start + self.bursts)


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
        Optical angles x and y of the mirrors, rad; a list of N points has H = 1, W = N.
    camera : ndarray, shape (4,), or None
        fx, fy, cx, cy, px, of the pinhole with the same rays; none for a list of points.
    modes : tuple of str
        Modes in the order in which they are taken.
    sweep : tuple of float
        Positions of the reference target from its zero, m.
    """

    angles: Array
    camera: Array | None
    modes: tuple[str, ...] = MODES
    sweep: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        angles, modes = self.angles, set(self.modes)
        if angles.ndim != 3 or angles.shape[2] != 2 or not angles.size:
            raise ValueError(f"Expected points (N, 2), got shape {angles.shape}. Give x and y.")
        if not np.isfinite(angles).all() or len(modes) < len(self.modes) or not modes <= {*MODES}:
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
        step = width if self.camera is not None else LINE_LENGTH
        starts = [(row, start) for row in range(height) for start in range(0, width, step)]
        image = [("scan", min(step, width - start), row, start) for row, start in starts]
        reference = ("reference", REFERENCE_BURSTS * len(self.sweep), 0, 0)
        once = [("dark", DARK_BURSTS, 0, 0), reference, *image, reference]
        parts = [(mode, *part) for mode in self.modes for part in once]
        firsts = accumulate((part[2] for part in parts), initial=1)
        return tuple(
            Line(index, kind, mode, first, bursts, row, start)
            for index, ((mode, kind, bursts, row, start), first) in enumerate(
                zip(parts, firsts, strict=False)
            )
        )

    def points(self, line: Line) -> Array:
        """Optical angles (N, 2), rad, of a line of the image."""
        return self.angles[line.row, line.columns]

    def as_dict(self) -> dict[str, Any]:
        """Plain values from which `from_dict` makes the same plan."""
        held: dict[str, Any] = {"modes": list(self.modes), "sweep": list(self.sweep)}
        if self.camera is None:
            return held | {"points": self.angles[0].tolist()}
        return held | {"shape": list(self.shape), "camera": self.camera.tolist()}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "Plan":
        """Plan of what `as_dict` gave."""
        calibration = tuple(values["modes"]), tuple(float(s) for s in values["sweep"])
        if "points" in values:
            return cls(np.asarray(values["points"], float)[None], None, *calibration)
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


def points_from_csv(path: str | Path) -> Array:
    """Read optical angles (N, 2), rad, from a table with the heading ``x,y`` or ``x_deg,y_deg``.

    Raises
    ------
    ValueError
        If the heading is another one, or a line is not two finite numbers.
    """
    scales = {("x", "y"): 1.0, ("x_deg", "y_deg"): np.pi / 180}
    try:
        text = Path(path).read_text(encoding="utf-8")
        rows = [row for row in csv.reader(text.splitlines()) if row]
        scale = scales[tuple(cell.strip() for cell in rows[0])]
        points = np.array([[float(x), float(y)] for x, y in rows[1:]]).reshape(-1, 2)
    except (ValueError, KeyError, IndexError, csv.Error):
        points, scale = np.empty((0, 2)), 1.0
    if not len(points) or not np.isfinite(points).all():
        raise ValueError(
            f"Expected a table x,y (rad) or x_deg,y_deg of finite numbers in {path}, got something "
            "else. Give a heading, and two numbers a line."
        )
    return points * scale


def angles_from_rays(rays: ArrayLike) -> Array:
    """Optical angles (..., 2), rad, of rays (..., 3), x right, y down, z forward."""
    x, y, z = np.moveaxis(np.asarray(rays, float), -1, 0)
    return np.stack([np.arctan2(x, z), np.arctan2(y, z)], axis=-1)
