"""The scan: instruments and a plan go in, a journal line by line, and a measurement at the end.

Every line begins from a known state and is checked at its end (edges counted, both modulators on
and locked, interlock closed); only then is it recorded. Whatever goes wrong, the emergency stop
closes the shutter, parks the beam and turns RF off, and ``resume`` goes on at the first line that
is not in the journal.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cmtof import __version__
from cmtof.files import check_output
from cmtof.hardware.bench import VOLTS_RANGE, Bench, simulated
from cmtof.hardware.journal import journal_path, open_journal, whole_lines
from cmtof.hardware.plan import SWEEP, Line, Plan, Record, planned
from cmtof.hardware.reduction import calibrated, measurement_from_records
from cmtof.hardware.rig import Rig
from cmtof.instrument.optics import group_index
from cmtof.instrument.settings import TwinSettings
from cmtof.measurement import Measurement, open_measurement


def scan(
    plan: Plan,
    bench: Callable[[], Bench],
    output: str | Path,
    *,
    resume: bool = False,
    seed: int | None = None,
    scene: str | None = None,
    report: Callable[[Line], None] = lambda line: None,
) -> Measurement:
    """Scan, and write the measurement ``*.nc``; a journal lies beside it until that is done.

    ``bench`` opens the instruments, `opened` or `simulated`, whose ``seed`` and ``scene`` stand in
    the file; ``report`` is called with each line that is on the disk, of an earlier run's with the
    last. Raises ValueError for a journal of other settings or a reference target that saturates or
    shows no modulation, and InstrumentError for whatever an instrument did not do; what was
    measured stays in the journal.
    """
    output, path = Path(output), journal_path(output)
    check_scan_output(output, resume=resume)
    if resume and output.exists() and not path.exists():
        return open_measurement(output)  # the journal goes when the file is whole
    with ExitStack() as held:
        with bench() as instruments:
            header = header_of(instruments, plan, seed=seed, scene=scene)
            journal = held.enter_context(open_journal(path, header, plan))
            if journal.records:
                report(plan.lines[len(journal.records) - 1])
            for record in measured(instruments, plan, header, journal.records):
                journal.append(record)
                report(plan.lines[record.line])
        measurement = measurement_from_records(plan, header, journal.records)
        measurement.save(output)
        with output.open("rb") as written:  # it is on the disk before the journal goes
            os.fsync(written.fileno())
        path.unlink()
    return measurement


def measured(
    bench: Bench, plan: Plan, header: dict[str, Any], records: list[Record]
) -> Iterator[Record]:
    """Next records of a plan; the caller adds each to ``records``. The beam is shut at the end.

    A target that shows nothing or saturates raises its ValueError after its first visit.
    """
    mode = None
    for line in plan.lines[len(records) :]:
        if mode is None:
            bench.set_up()
        if line.mode != mode:
            bench.choose_mode(mode := line.mode)
        record = bench.measure(plan, line)
        if (line.kind, line.row) == ("reference", SWEEP - 1):
            calibrated(plan, header, mode, [*records, record])
        yield record
    if mode is not None:
        bench.shut()


def header_of(bench: Bench, plan: Plan, *, seed: int | None, scene: str | None) -> dict[str, Any]:
    """Everything that the result depends on, as JSON has it; a ``seed`` is a simulation's."""
    identities = {role: device.identify() for role, device in bench.devices.items()}
    twin = seed is not None
    return {
        "version": __version__,
        "source": "simulated instrument" if twin else "instrument",
        "seed": seed,
        "scene": scene,
        "size": list(plan.angles.shape[:2]),
        "calibration": list(bench.daq.gain(VOLTS_RANGE)),
        "group_index": group_index(plan.rig.twin) if twin else group_index(),
        "settings": plan.rig.as_dict(),
        "instruments": identities,
    }


def check_scan_output(output: Path, *, resume: bool) -> None:
    """Raise an error where a scan cannot be written, before anything is started."""
    if output.suffix != ".nc":
        raise ValueError(f"Expected an output named *.nc, got {output.name}. Rename it.")
    path = journal_path(check_output(output))
    if path.exists() and not resume:
        raise ValueError(
            f"Expected no scan begun, got {max(len(whole_lines(path)) - 1, 0)} lines in {path}. "
            "Go on with --resume, or remove it to begin again."
        )


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
    """Scan of a target by the simulated instrument, in memory, with its true depth.

    Ranges are optical, ``n_g z`` with the attribute ``group_index``, as in every scan: divide what
    comes out of the measurement, its true ``depth`` included, to have metres along the ray. The
    target is one of `cmtof.instrument.targets.scene_from`; ``size`` is height and width, px,
    ``field_of_view`` the full optical angles across and down, rad.

    Examples
    --------
    >>> wall = {"kind": "plane", "distance": 1.0}
    >>> scan_scene(TwinSettings(), wall, size=2, field_of_view=0.1, seed=0)
    <Measurement 2x2 px at 7.15, 14.32 GHz, 0.000-7.495 m>
    """
    across, down = np.rad2deg(np.broadcast_to(field_of_view, 2)).tolist()
    rig = replace(
        Rig.default(),
        twin=settings,
        field_of_view_deg=(across, down),
        phases=phases,
        reference_distance=settings.reference.distance,
        stage_zero=settings.stage_zero,
    )
    plan, records = planned(rig, size=size), []
    with simulated(rig, target, seed=seed) as bench:
        header = header_of(bench, plan, seed=seed, scene=None)
        for record in measured(bench, plan, header, records):
            records.append(record)
        ranges = bench.daq.world.ranges(plan.angles).reshape(plan.angles.shape[:2])
    data = measurement_from_records(plan, header, records).dataset
    data["depth"] = (("y", "x"), header["group_index"] * ranges, {"units": "m"})
    data["mask"] = data["mask"] * np.isfinite(ranges).astype(np.int8)
    data.attrs["range_min"] = float(range_min)
    if range_max is not None:
        data.attrs["range_max"] = float(range_max)
    return Measurement(data)
