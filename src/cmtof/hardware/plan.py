"""What a scan does, burst by burst, settled before anything is touched.

A *burst* is one point in one modulation mode: 16 phases of 20 samples. Bursts are numbered from 1;
the number is the *label* that travels with the burst to the read-out. A *line* is the run of bursts
that stands or falls together, one record of the journal. Each mode is taken in one go, its
calibration around it, so that neither the plates turn nor the phases drift more than they must::

    dark, reference target, every line of the image, reference target again
"""

from math import ceil, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.hardware.rig import Rig
from cmtof.instrument.optics import group_index
from cmtof.scenes.frame import rays_from_camera

Array = NDArray[np.float64]

MODES = ("single", "doubled")
"""Modulation modes, that of the lower frequency first."""
DARK_BURSTS = 16
"""Bursts behind the closed shutter, each mode."""
REFERENCE_BURSTS = 8
"""Bursts at each position of the reference target."""
SWEEP = 8
"""Positions of the reference target, over one wrap of the single mode, two of the doubled one."""
LARGEST = 4096
"""Height and width of an image at most, px."""


class Line(NamedTuple):
    """Bursts that are recorded together: "dark", "reference" or a "scan" line of the image."""

    index: int
    mode: str
    kind: str
    row: int
    labels: range


class Record(NamedTuple):
    """One line as it was measured.

    ``power`` behind the emission module at its end, W; ``sums`` (N, K) of the kept samples of each
    phase; ``clipped`` (N,) samples at either end of the converter's scale.
    """

    line: int
    power: float
    sums: NDArray[np.uint32]
    clipped: NDArray[np.uint16]


class Plan(NamedTuple):
    """Lines of a scan, and what they share.

    ``angles`` (H, W, 2) of the beam, optical, rad; ``camera`` fx, fy, cx, cy, px, of the pinhole
    with the same rays; ``sweep``, positions of the reference target from its zero, m; ``kept``
    (K,), how many samples of each phase are summed: the last ones.
    """

    rig: Rig
    angles: Array
    camera: Array
    sweep: Array
    kept: NDArray[np.int64]
    lines: list[Line]

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the image, px."""
        return self.angles.shape[0], self.angles.shape[1]

    @property
    def bursts(self) -> int:
        """Number of bursts, which is the label of the last one."""
        return self.lines[-1].labels[-1]


def planned(rig: Rig, *, size: int | tuple[int, int] = 64) -> Plan:
    """Plan of an image of ``size`` (height and width, px) whose rays are those of a pinhole.

    Raises
    ------
    ValueError
        If it is too large, or a direction is beyond what the mirrors reach.

    Examples
    --------
    >>> plan = planned(Rig.default(), size=4)
    >>> plan.shape, len(plan.lines), plan.bursts
    ((4, 4), 14, 320)
    """
    height, width = (size, size) if isinstance(size, int) else size
    if not (1 <= height <= LARGEST and 1 <= width <= LARGEST):
        raise ValueError(f"Expected 1 to {LARGEST} px, got {height} x {width}. Change --size.")
    view = np.deg2rad(rig.galvo.field_of_view_deg)
    focal = np.array([width, height]) / 2 / np.tan(view / 2)
    camera = np.array([*focal, width / 2, height / 2])
    x, y, z = np.moveaxis(rays_from_camera((height, width), camera), -1, 0)
    angles = np.stack([np.arctan2(x, z), np.arctan2(y, z)], axis=-1)
    rig.galvo.volts(angles)  # raises beyond the mirrors' reach
    wrap = SPEED_OF_LIGHT / (2 * rig.drive.frequency_single * group_index())
    sweep = wrap * ((np.arange(SWEEP) + 0.5) / SWEEP - 0.5)
    lines, label = [], 1
    for mode in MODES:
        reference = ("reference", 0, REFERENCE_BURSTS * SWEEP)
        image = [("scan", row, width) for row in range(height)]
        for kind, row, bursts in [("dark", 0, DARK_BURSTS), reference, *image, reference]:
            lines.append(Line(len(lines), mode, kind, row, range(label, label + bursts)))
            label += bursts
    return Plan(rig, angles, camera, sweep, _kept(rig, angles), lines)


def _kept(rig: Rig, angles: Array) -> NDArray[np.int64]:
    """Samples (K,) kept of each phase: in the first one the mirrors settle, too."""
    detection, step = rig.detection, np.abs(np.diff(angles[..., 0], axis=1)).max(initial=0.0)
    settle = np.full(detection.phases, detection.settle_samples)
    mirrors = ceil(settling_time(float(step), rig.galvo.settling) * detection.rate - 1e-9)
    settle[0] = max(settle[0], min(mirrors, detection.samples_per_phase - 1))
    return detection.samples_per_phase - settle


def settling_time(step: float, small: float) -> float:
    """Time, s, that the mirrors take for a step of optical angle, rad.

    ``small``, s, holds to 0.2 mechanical degrees; beyond, 100 Hz full-scale square waves (GVS012
    specifications) set the pace: 5 ms for 40 degrees. Between, a straight line (not verified).
    """
    near, far = 2 * 0.2 * pi / 180, 2 * 40 * pi / 180
    share = min(max((step - near) / (far - near), 0.0), 1.0)
    return small + share * max(5e-3 - small, 0.0)
