"""A scan of a scene by the simulated instrument without wires: the same plan, physics, reduction.

Every burst of the plan is asked of the `World` at once, with the knobs as the drivers leave them;
the counts go through the journal's own reduction. What differs from `cmtof.hardware.scan.scan` is
the last digit of the power meter and of the stage, and that it takes seconds.
"""

from collections.abc import Iterator
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cmtof import __version__
from cmtof.hardware.codecs.labjack import NOMINAL, gain_index
from cmtof.hardware.export import measurement_from_journal
from cmtof.hardware.journal import Record
from cmtof.hardware.plan import REFERENCE_BURSTS, Line, Plan
from cmtof.hardware.reduction import Sampling, drive_phases
from cmtof.hardware.rig import Rig
from cmtof.hardware.rig_settings import RigSettings
from cmtof.hardware.scan import DARK, planned, sampling_of
from cmtof.hardware.scan_header import settings_as_dict
from cmtof.instrument.devices import TDAC_STEP
from cmtof.instrument.light import Panel, RfKnobs
from cmtof.instrument.optics import group_index
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.world import LABEL_TIME, World
from cmtof.measurement import Measurement

Array = NDArray[np.float64]


def scan_scene(
    settings: TwinSettings,
    target: Any,
    *,
    size: int | tuple[int, int],
    field_of_view: float | tuple[float, float],
    seed: int,
    phases: int = 16,
    range_min: float = 0.0,
    range_max: float | None = None,
) -> Measurement:
    """Scan a target in both modes, dark level and reference target included.

    Ranges are optical, ``n_g z`` with the attribute ``group_index``, as in every scan: divide what
    comes out of the measurement, its true ``depth`` included, to have metres along the ray.

    Parameters
    ----------
    settings : TwinSettings
        The instrument; its ``reference`` is what calibrates psi in both modes.
    target : Target, Frame, str or mapping
        As `cmtof.instrument.targets.scene_from` takes it.
    size : int or (int, int)
        Height and width, px; one number for both. Points lie uniformly in the tangent.
    field_of_view : float or (float, float)
        Full optical angles across and down, rad; one number for both.
    seed : int
        Of the simulated instrument.
    phases : int
        Steps of psi over a turn.
    range_min, range_max : float
        Depths to choose from, m; the default ends where both frequencies repeat themselves.

    Returns
    -------
    Measurement
        As a scan's file, with ``depth`` (H, W), m, NaN and masked where the beam meets nothing.

    Raises
    ------
    ValueError
        If a direction is beyond the mirrors, or the reference target shows no modulation.

    Examples
    --------
    >>> wall = {"kind": "plane", "distance": 1.0}
    >>> scan_scene(TwinSettings(), wall, size=2, field_of_view=0.1, seed=0)
    <Measurement 2x2 px at 7.15, 14.32 GHz, 0.000-7.495 m>
    """
    view = field_of_view if isinstance(field_of_view, tuple) else (field_of_view, field_of_view)
    rig = _rig(settings, view, phases)
    plan = planned(rig, size=size)
    sampling = sampling_of(rig, plan)
    world = World(settings, target, seed=seed)
    header = _header(rig, settings, plan, sampling, seed)
    records = list(_records(world, rig, plan, sampling))
    data = measurement_from_journal(header, records).dataset
    ranges = header["group_index"] * world.ranges(plan.angles).reshape(plan.shape)
    data["depth"] = (("y", "x"), ranges, {"units": "m"})
    data["mask"] = data["mask"] * np.isfinite(ranges).astype(np.int8)
    data.attrs["range_min"] = float(range_min)
    if range_max is not None:
        data.attrs["range_max"] = float(range_max)
    return Measurement(data)


def panel_of(rig: RigSettings, mode: str, phases: int, **knobs: Any) -> Panel:
    """Knobs as a scan leaves them in a mode; ``knobs`` are fields of `Panel`."""
    drive = {"on": True, "frequency": rig.drive.frequency(mode), "power": rig.drive.power_dbm}
    stepping = {"table": drive_phases(phases, mode)}
    return Panel(
        emission=RfKnobs(**drive),
        detection=RfKnobs(**drive, **stepping),
        plate_angle=list(rig.plates.mount_angles(mode)),
        laser_on=True,
        clock_on=True,
        **knobs,
    )


def _rig(settings: TwinSettings, view: tuple[float, float], phases: int) -> RigSettings:
    """Build the default rig before this instrument: it knows where the reference target stands."""
    rig, known = Rig.default().settings, settings.reference
    degrees = float(np.rad2deg(view[0])), float(np.rad2deg(view[1]))
    return replace(
        rig,
        scan=replace(rig.scan, field_of_view_deg=degrees),
        detection=replace(rig.detection, phases=phases),
        reference=replace(rig.reference, distance=known.distance, stage_zero=known.stage_zero),
    )


def _header(
    rig: RigSettings, settings: TwinSettings, plan: Plan, sampling: Sampling, seed: int
) -> dict[str, Any]:
    """What the reduction needs to know, as a scan over the wires writes it."""
    drive = rig.drive
    return {
        "version": __version__,
        "source": "simulated instrument",
        "seed": seed,
        "scene": None,
        "plan": plan.as_dict(),
        "sampling": asdict(sampling),
        "gain": asdict(NOMINAL.high_speed[gain_index(rig.detection.range)]),
        "group_index": group_index(settings.air, settings.laser.wavelength),
        "frequencies": {
            mode: drive.frequency(mode) * (2 if mode == "doubled" else 1) for mode in plan.modes
        },
        "settings": settings_as_dict(rig),
        "instruments": {},
    }


def _records(world: World, rig: RigSettings, plan: Plan, sampling: Sampling) -> Iterator[Record]:
    """Every line of the plan, in order."""
    for line in plan.lines:
        panel = panel_of(rig, line.mode, sampling.phases, shutter_open=line.kind != "dark")
        counts = _counts(world, rig, plan, sampling, line, panel)
        reduced = [sampling.sums(burst) for burst in counts]
        # the power meter is read at the end of the last burst, at the last phase of the table
        panel.time = LABEL_TIME * line.labels[-1] + sampling.scans / rig.detection.rate
        yield Record(
            line.index,
            DARK if line.kind == "dark" else world.laser_power(panel),
            np.array([sums for sums, _ in reduced], np.uint32),
            np.array([clipped for _, clipped in reduced], np.uint16),
        )


def _counts(
    world: World, rig: RigSettings, plan: Plan, sampling: Sampling, line: Line, panel: Panel
) -> NDArray[np.uint16]:
    """Raw counts (bursts, scans) of a line: of the scene, the dark, or the target on the stage."""
    angles, labels = np.zeros((line.bursts, 2)), np.array(line.labels)
    edges = np.arange(sampling.scans) // sampling.samples_per_phase

    def asked(part: slice) -> NDArray[np.uint16]:
        return world.bursts(
            panel,
            angles[part],
            labels=labels[part],
            scans=sampling.scans,
            rate=rig.detection.rate,
            pulses=edges,
            volts_range=rig.detection.range,
        )

    if line.kind == "reference":
        panel.flip_mirror_in = True
        parts = []
        for number, offset in enumerate(plan.sweep):
            panel.stage_position = rig.reference.stage_zero + offset
            parts.append(asked(slice(number * REFERENCE_BURSTS, (number + 1) * REFERENCE_BURSTS)))
        return np.concatenate(parts)
    if line.kind == "scan":  # the mirrors' converter has steps
        volts = np.rint(plan.points(line) * rig.galvo.volts_per_radian / TDAC_STEP) * TDAC_STEP
        angles = volts / rig.galvo.volts_per_radian
    return asked(slice(None))
