"""The bursts of a scan, planned before any device is used.

A *burst* is one point in one modulation mode: 16 phases of 20 samples. Bursts are numbered from 1;
the number is the *label* that travels with the burst to the read-out. A *line* is the run of bursts
that stands or falls together, one record of the journal. Each mode is taken in one go, its
calibration around it, so that neither the plates turn nor the phases drift more than they must::

    dark, reference target at each position, lines of the image, reference target again
"""

from math import ceil, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.frame import rays_from_camera
from cmtof.hardware.rig import MODES, Rig
from cmtof.types import Array, Numbers

DARK_BURSTS = 16  # behind the closed shutter, each mode
REFERENCE_BURSTS = 8  # at each position of the reference target
SWEEP = 8  # positions of it, over one wrap of the single mode, two of the doubled one
VOLTS_PER_DEGREE = 0.5  # scan mirrors GVS012, of mechanical angle
VOLTS_PER_RADIAN = VOLTS_PER_DEGREE * 180 / pi / 2
"""Of optical angle: the beam turns by twice what a mirror does."""
SETTLING = {0.4: 4e-4, 40.0: 1 / (2 * 65), 80.0: 1 / (2 * 25)}
"""Time that the mirrors take for a step, s, by degrees of optical angle. GVS012 with its mirrors of
10 mm: 0.4 ms for 0.2 mechanical degrees; square waves of 65 Hz over half the travel, of 25 Hz over
all of it (its specifications). Between, a straight line (not verified)."""
BURST_INTERVAL = 20e-3
"""Time from one burst to the next on the plan's clock, s: 13.3 ms for the paper's burst, and what
the devices need between."""


class Line(NamedTuple):
    """Bursts that are recorded together."""

    index: int
    mode: str
    kind: str  # "dark", "reference" or "scan"
    row: int  # of the image, or the number of the target's position
    labels: range


class Record(NamedTuple):
    """One line as it was measured."""

    line: int
    power: float  # behind the emission module at the line's end, W
    rate: float  # of the samples, as the converter made it, Hz
    times: Array  # at which the bursts were read, s (N,)
    sums: NDArray[np.uint32]  # of the kept samples of each phase (N, K)
    clipped: NDArray[np.uint16]  # samples at either end of the converter's scale (N,)


class Plan(NamedTuple):
    """Lines of a scan, and what they share."""

    rig: Rig
    angles: Array  # of the beam, optical, rad (H, W, 2)
    camera: Array  # fx, fy, cx, cy, px, of the pinhole with the same rays
    sweep: Array  # positions of the reference target from its zero, m
    kept: Numbers  # how many samples of each phase are summed, the last ones (K,)
    lines: list[Line]


def mirror_settling(step: float) -> float:
    """Time, s, that the mirrors take for a step, rad of optical angle.

    >>> f"{mirror_settling(np.deg2rad(40)):.4f}"
    '0.0077'
    """
    return float(np.interp(np.rad2deg(step), list(SETTLING), list(SETTLING.values())))


def planned(rig: Rig, *, size: int | tuple[int, int] = 64) -> Plan:
    """Plan of an image of ``size`` (height and width, px) whose rays are those of a pinhole."""
    height, width = (size, size) if isinstance(size, int) else size
    focal = np.array([width, height]) / 2 / np.tan(np.deg2rad(rig.field_of_view_deg) / 2)
    camera = np.array([*focal, width / 2, height / 2])
    x, y, z = np.moveaxis(rays_from_camera((height, width), camera), -1, 0)
    angles = np.stack([np.arctan2(x, z), np.arctan2(y, z)], axis=-1)
    wrap = SPEED_OF_LIGHT / (2 * rig.frequency_single * rig.group_index)
    sweep = wrap * ((np.arange(SWEEP) + 0.5) / SWEEP - 0.5)
    reference = [("reference", n, REFERENCE_BURSTS) for n in range(SWEEP)]
    image = [("scan", row, width) for row in range(height)]
    lines = []
    label = 1
    for mode in MODES:
        for kind, row, bursts in [("dark", 0, DARK_BURSTS), *reference, *image, *reference]:
            lines.append(Line(len(lines), mode, kind, row, range(label, label + bursts)))
            label += bursts
    settle = np.full(rig.phases, rig.settle_samples)
    step = float(np.abs(np.diff(angles[..., 0], axis=1)).max(initial=0.0))
    mirrors = ceil(mirror_settling(step) * rig.rate - 1e-9)
    settle[0] = max(settle[0], min(mirrors, rig.samples_per_phase - 1))  # mirrors settle, too
    return Plan(rig, angles, camera, sweep, rig.samples_per_phase - settle, lines)
