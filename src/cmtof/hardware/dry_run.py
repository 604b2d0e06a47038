"""What a scan would do and how long it would take, told without touching anything."""

import numpy as np

from cmtof.hardware.export import SLOT
from cmtof.hardware.plan import Plan
from cmtof.hardware.rig_settings import RigSettings

MODE_OVERHEAD = 30.0
"""Time to turn the plates and to lock, s (estimated)."""

MOVE = 2.0
"""Time of a move of the target, s (estimated)."""


def duration(plan: Plan) -> float:
    """Time that a scan takes on the instrument, s (estimated)."""
    moves = len(plan.sweep) * sum(line.kind == "reference" for line in plan.lines)
    return plan.bursts * SLOT + moves * MOVE + len(plan.modes) * MODE_OVERHEAD


def description(plan: Plan, settings: RigSettings) -> list[str]:
    """What would be done, for a dry run."""
    height, width = plan.shape
    detection = settings.detection
    what = "points" if plan.camera is None else f"{height} x {width} image,"
    total = duration(plan)
    text = [
        f"{settings.name}: {what} {height * width} directions, {len(plan.modes)} modes, "
        f"{len(plan.lines)} lines, {plan.bursts} bursts",
        f"a burst: {detection.phases} phases x {detection.samples_per_phase} samples at "
        f"{detection.rate:g} samples/s, {1e3 * detection.duration:.1f} ms",
    ]
    for mode in plan.modes:
        lines = [line for line in plan.lines if line.mode == mode]
        counts = ", ".join(
            f"{kind} {sum(line.bursts for line in lines if line.kind == kind)}"
            for kind in ("reference", "dark", "scan")
        )
        angles = np.rad2deg(settings.plates.mount_angles(mode))
        text.append(
            f"{mode}: drive {settings.drive.frequency(mode) / 1e9:g} GHz, plates at "
            f"{angles[0]:g} and {angles[1]:g} deg, bursts {lines[0].first} to "
            f"{lines[-1].labels[-1]} ({counts})"
        )
    text.append(
        f"about {total:.0f} s on the instrument ({SLOT * 1e3:g} ms a burst; overheads estimated)"
    )
    return text
