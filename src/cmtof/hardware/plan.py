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
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.frame import rays_from_camera

Kind = Literal["reference", "dark", "scan"]

MODES = ("single", "doubled")
"""Modulation modes, that of the lower frequency first."""

LINE_LENGTH = 64
"""Points of a list that are recorded together."""

DARK_BURSTS = 16
"""Bursts behind the closed shutter, each mode."""

REFERENCE_BURSTS = 8
"""Bursts at each position of the reference target."""


@dataclass(frozen=True)
class Line:
    """Bursts that are recorded together.

    Attributes
    ----------
    index : int
        Place in the plan, from 0; also the number of its record.
    kind : {"reference", "dark", "scan"}
        What is looked at.
    mode : {"single", "doubled"}
        Modulation mode.
    first, bursts : int
        Label of the first burst, and how many there are.
    row, start : int
        Row of the image and first column in it; 0 where nothing of the image is taken.
    """

    index: int
    kind: Kind
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


@dataclass(frozen=True, eq=False)
class Plan:
    """Directions, modes and calibration of a scan.

    Attributes
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

    angles: NDArray[np.float64]
    camera: NDArray[np.float64] | None
    modes: tuple[str, ...] = MODES
    sweep: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        if not self.modes or any(mode not in MODES for mode in self.modes):
            raise ValueError(
                f"Expected modes out of {', '.join(MODES)}, got {list(self.modes)}. "
                "Correct `scan: modes`."
            )
        if len(set(self.modes)) < len(self.modes):
            raise ValueError(f"Expected each mode once, got {list(self.modes)}. Drop one.")
        self.angles.setflags(write=False)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the image, px."""
        return self.angles.shape[0], self.angles.shape[1]

    @property
    def bursts(self) -> int:
        """Number of bursts, which is the label of the last one."""
        return self.lines[-1].first + self.lines[-1].bursts - 1

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Every line, in order."""
        height, width = self.shape
        step = width if self.camera is not None else LINE_LENGTH
        spans = [
            (row, start, min(step, width - start))
            for row in range(height)
            for start in range(0, width, step)
        ]
        reference = ("reference", REFERENCE_BURSTS * len(self.sweep), 0, 0)
        image = [("scan", count, row, start) for row, start, count in spans]
        once = [("dark", DARK_BURSTS, 0, 0), reference, *image, reference]
        parts = [(mode, *part) for mode in self.modes for part in once]
        firsts = accumulate((part[2] for part in parts), initial=1)
        return tuple(
            Line(index, kind, mode, first, bursts, row, start)  # type: ignore[arg-type]
            for index, ((mode, kind, bursts, row, start), first) in enumerate(
                zip(parts, firsts, strict=False)
            )
        )

    def points(self, line: Line) -> NDArray[np.float64]:
        """Optical angles (N, 2), rad, of a line of the image."""
        return self.angles[line.row, line.columns]

    def as_dict(self) -> dict[str, Any]:
        """Plain values from which `plan_from_dict` makes the same plan."""
        directions: dict[str, Any]
        if self.camera is None:
            directions = {"points": self.angles[0].tolist()}
        else:
            directions = {"shape": list(self.shape), "camera": self.camera.tolist()}
        return {"modes": list(self.modes), "sweep": list(self.sweep), **directions}


def plan_from_dict(values: Mapping[str, Any]) -> Plan:
    """Plan of what `Plan.as_dict` gave."""
    calibration = tuple(values["modes"]), tuple(values["sweep"])
    if "points" in values:
        return Plan(np.asarray(values["points"], float)[None], None, *calibration)
    camera = np.asarray(values["camera"], float)
    height, width = values["shape"]
    return Plan(angles_from_rays(rays_from_camera((height, width), camera)), camera, *calibration)


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
    if height < 1 or width < 1:
        raise ValueError(f"Expected an image of 1 px or more, got {height} x {width}. Enlarge it.")
    if len(field_of_view) != 2 or not all(0 < angle < np.pi for angle in field_of_view):
        raise ValueError(
            f"Expected two angles of view between 0 and pi rad, got {list(field_of_view)}. "
            "Correct `scan: field_of_view_deg`."
        )
    focal = np.array([width, height]) / 2 / np.tan(np.asarray(field_of_view) / 2)
    camera = np.array([*focal, width / 2, height / 2])
    rays = rays_from_camera((height, width), camera)
    return Plan(angles_from_rays(rays), camera, tuple(modes), tuple(sweep))


def point_list(
    points: ArrayLike, *, modes: Sequence[str] = MODES, sweep: Sequence[float] = (0.0,)
) -> Plan:
    """Plan of any directions (N, 2), optical angles in rad, in the order given."""
    angles = np.array(points, float)
    if angles.ndim != 2 or angles.shape[1] != 2 or not len(angles) or not np.isfinite(angles).all():
        raise ValueError(
            f"Expected points (N, 2) of finite angles, got shape {angles.shape}. Give x and y."
        )
    return Plan(angles[None], None, tuple(modes), tuple(sweep))


def points_from_csv(path: str | Path) -> NDArray[np.float64]:
    """Read optical angles (N, 2), rad, from a table with columns ``x, y`` (rad) or in degrees.

    Degrees are what a heading ``x_deg, y_deg`` says.

    Raises
    ------
    ValueError
        If the heading is another one, or a line is not two finite numbers.
    """
    path = Path(path)
    try:
        rows = [row for row in csv.reader(path.read_text(encoding="utf-8").splitlines()) if row]
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"Expected a text table in {path}, got {error}. Save it as CSV.") from None
    heading = tuple(cell.strip() for cell in rows[0]) if rows else ()
    scales: dict[tuple[str, ...], float] = {("x", "y"): 1.0, ("x_deg", "y_deg"): np.pi / 180}
    if heading not in scales:
        raise ValueError(
            f"Expected the heading x,y (rad) or x_deg,y_deg in {path}, got "
            f"{','.join(heading) or 'nothing'}. Name the two columns."
        )
    try:
        points = np.array([[float(cell) for cell in row] for row in rows[1:]])
        if points.shape != (len(rows) - 1, 2) or not np.isfinite(points).all() or len(rows) < 2:
            raise ValueError
    except ValueError:
        raise ValueError(
            f"Expected one or more lines of two finite numbers in {path}, got something else. "
            "Give every point x and y."
        ) from None
    return points * scales[heading]


def angles_from_rays(rays: ArrayLike) -> NDArray[np.float64]:
    """Optical angles (..., 2), rad, of rays (..., 3), x right, y down, z forward."""
    x, y, z = np.moveaxis(np.asarray(rays, float), -1, 0)
    return np.stack([np.arctan2(x, z), np.arctan2(y, z)], axis=-1)
