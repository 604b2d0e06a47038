"""The bursts of a scan, planned before any device is used.

A *burst* is one point in one modulation mode: 16 phases of 20 samples. Bursts are numbered from 1;
the number is the *label* that travels with the burst to the read-out. A *line* is the run of bursts
that stands or falls together, one record of the journal. Each mode is taken in one go, its
calibration around it, so that neither the plates turn nor the phases drift more than they must::

    dark, reference target at each position, lines of the image, reference target again
"""

from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.frame import rays_from_camera
from cmtof.hardware.rig import MODES, Rig
from cmtof.types import Array, Counts, Numbers, Shape

DARK_BURSTS = 16  # behind the closed shutter, each mode
REFERENCE_BURSTS = 8  # at each position of the reference target
SWEEP = 8  # positions of it, over one wrap of the single mode, two of the doubled one
# Steps of the beam, degrees, whose settling times are in a rig. By default those of a GVS012 with
# its mirrors of 10 mm, as Thorlabs specifies the GVS011 and GVS012: 0.4 ms for 0.2 degrees of a
# mirror, square waves of 65 Hz over half the travel and of 25 Hz over all of it, 0.5 V per degree.
# Between, a straight line (not verified).
STEPS = (0.4, 40.0, 80.0)
# Time from one burst to the next on the plan's clock, s: 13.3 ms for the paper's burst, and what
# the devices need between.
BURST_INTERVAL = 20e-3


class Line(NamedTuple):
    """Bursts that are recorded together: a row of the image, or a step of the calibration."""

    index: int  # pyright: ignore[reportIncompatibleMethodOverride]
    mode: str
    kind: str  # "dark", "reference" or "scan"
    row: int  # of the image, or the number of the target's position
    labels: range


class LineRecord(NamedTuple):
    """Result of one measured line."""

    line: int
    power: float  # behind the emission module at the line's end, W
    rate: float  # of the samples, as the converter made it, Hz
    locks: Array  # detuning, Hz, and reflected power, dBm, of both drives (2, 2)
    times: Array  # at which the bursts were read, s (N,)
    sums: Numbers  # of the kept samples of each phase (N, K)
    clipped: Counts  # samples at either end of the converter's scale (N,)


class Plan(NamedTuple):
    """Lines of a scan, beam angles, target positions, and samples to sum."""

    rig: Rig
    angles: Array  # of the beam, optical, rad (H, W, 2)
    camera: Array  # fx, fy, cx, cy, px, of the pinhole with the same rays
    sweep: Array  # positions of the reference target from its zero, m
    kept: Numbers  # how many samples of each phase are summed, the last ones (K,)
    lines: list[Line]


def mirror_settling(rig: Rig, step: float) -> float:
    """Settling time, s, of the mirrors after a step of optical angle, rad.

    >>> f"{mirror_settling(Rig.default(), np.deg2rad(40)):.4f}"
    '0.0077'
    """
    return float(np.interp(np.rad2deg(step), STEPS, rig.mirror_settling))


def mirror_volts(rig: Rig, angles: ArrayLike) -> Array:
    """Mirror voltages (..., 2), V, for optical angles (..., 2), rad, twice the mirrors' own."""
    volts = np.rad2deg(angles) / 2 * rig.mirror_volts_per_degree
    return np.round(volts + rig.mirror_offset_volts, 6)


def mirror_angles(rig: Rig, volts: ArrayLike) -> Array:
    """Optical angles (..., 2), rad, at voltages (..., 2), V: the inverse of `mirror_volts`."""
    return np.deg2rad(
        2 * np.subtract(volts, rig.mirror_offset_volts) / rig.mirror_volts_per_degree
    )


def plan_scan(rig: Rig, *, size: int | Shape = 64) -> Plan:
    """Plan of an image of ``size`` (height and width, px) whose rays are those of a pinhole."""
    height, width = np.broadcast_to(size, 2).tolist()
    middle = np.array([width, height]) / 2
    camera = np.array(
        [*middle / np.tan(np.deg2rad(rig.field_of_view_deg) / 2), *middle]
    )
    rays = rays_from_camera((height, width), camera)
    angles = np.arctan2(rays[..., :2], rays[..., 2:])
    largest_volts = abs(mirror_volts(rig, angles)).max()
    if largest_volts > 10:
        raise ValueError(
            f"Expected mirrors within 10 V, got {largest_volts:.3g} V. "
            "Make field_of_view_deg smaller."
        )
    wrap = SPEED_OF_LIGHT / (2 * rig.frequency_single * rig.group_index)
    sweep = wrap * ((np.arange(SWEEP) + 0.5) / SWEEP - 0.5)
    return Plan(
        rig, angles, camera, sweep, _samples_to_sum(rig, angles), _lines(height, width)
    )


def _lines(height: int, width: int) -> list[Line]:
    """Lines of a scan of an image, in order: each mode with its calibration before and after."""
    reference = [("reference", n, REFERENCE_BURSTS) for n in range(SWEEP)]
    image = [("scan", row, width) for row in range(height)]
    lines = []
    label = 1
    for mode in MODES:
        for kind, row, bursts in [
            ("dark", 0, DARK_BURSTS),
            *reference,
            *image,
            *reference,
        ]:
            lines.append(
                Line(len(lines), mode, kind, row, range(label, label + bursts))
            )
            label += bursts
    return lines


def _samples_to_sum(rig: Rig, angles: Array) -> Numbers:
    """Number of samples (K,) to sum at the end of each phase, after filters and mirrors settle."""
    settle = np.full(rig.phases, rig.settle_samples)
    step = abs(np.diff(angles[..., 0], axis=1)).max(initial=0.0)
    mirrors = ceil(mirror_settling(rig, step) * rig.rate - 1e-9)
    settle[0] = max(settle[0], min(mirrors, rig.samples_per_phase - 1))
    return rig.samples_per_phase - settle
