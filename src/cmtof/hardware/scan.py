"""The scan of a plan by instruments: a journal line by line, and a measurement at the end.

Every line begins from a known state and is checked at its end (edges counted, both modulators on
and locked, interlock closed); only then is it recorded. Whatever goes wrong, the emergency stop
closes the shutter, parks the beam and turns RF off, and ``resume`` goes on at the first line that
is not in the journal.
"""

import os
import tempfile
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cmtof import __version__
from cmtof.files import alone, check_output
from cmtof.hardware.bench import VOLTS_RANGE, Bench, simulated
from cmtof.hardware.journal import append, begun, journal_path, whole_lines
from cmtof.hardware.plan import SWEEP, Line, Plan, planned
from cmtof.hardware.reduction import calibrated, measurement_from_records
from cmtof.hardware.rig import Rig
from cmtof.measurement import Measurement, open_measurement
from cmtof.validation import expect
from cmtof_lab.settings import TwinSettings


def scan(
    plan: Plan,
    bench: Callable[[], AbstractContextManager[Bench]],
    output: str | Path,
    *,
    resume: bool = False,
    report: Callable[[Line], None] = lambda line: None,
) -> Measurement:
    """Scan, and write the measurement ``*.nc``; a journal lies beside it until that is done.

    ``bench`` opens the instruments, `opened` or `simulated`; ``report`` is called with each line
    that is on the disk. Raises ValueError for a journal of other settings or a reference target
    that saturates or shows no modulation (after its first visit), and InstrumentError for whatever
    an instrument did not do; what was measured stays in the journal.
    """
    output = Path(output)
    path = check_output(journal_path(check_output(output, ".nc")))
    if path.exists() and not resume:
        got = f"{max(len(whole_lines(path)) - 1, 0)} lines in {path}"
        expect(False, "no scan begun", got, "Go on with --resume, or remove it to begin again.")
    if resume and output.exists() and not path.exists():
        return open_measurement(output)  # the journal goes when the file is whole
    mode = None
    with bench() as on:
        header = {
            "version": __version__,
            **on.about,
            "size": list(plan.angles.shape[:2]),
            "calibration": list(on.daq.gain(VOLTS_RANGE)),
            "settings": plan.rig.as_dict(),
            "instruments": {role: device.identify() for role, device in on.devices.items()},
        }
        path.touch()
        with alone(path):
            records = begun(path, header, plan)
            for line in plan.lines[len(records) :]:
                if mode is None:
                    on.set_up()
                if line.mode != mode:
                    on.choose_mode(mode := line.mode)
                records.append(on.measure(plan, line))
                if (line.kind, line.row) == ("reference", SWEEP - 1):
                    calibrated(plan, header, line.mode, records)
                append(path, records[-1]._asdict())
                report(line)
    measurement = measurement_from_records(plan, header, records)
    measurement.save(output)
    with output.open("rb") as written:  # it is on the disk before the journal goes
        os.fsync(written.fileno())
    path.unlink()
    return measurement


def scan_scene(
    settings: TwinSettings,
    target: Any,
    *,
    size: int | tuple[int, int],
    field_of_view: float | tuple[float, float],
    seed: int,
) -> Measurement:
    """Scan of a target by the simulated instrument, with its true depth; no file is left.

    Ranges are optical, ``n_g z`` with the attribute ``group_index``, as in every scan: divide what
    comes out of the measurement, its true ``depth`` included, to have metres along the ray. The
    target is one of `cmtof_lab.targets.scene_from`; ``size`` is height and width, px,
    ``field_of_view`` the full optical angles across and down, rad.

    >>> wall = {"kind": "plane", "distance": 1.0}
    >>> scan_scene(TwinSettings(), wall, size=2, field_of_view=0.1, seed=0)
    <Measurement 2x2 px at 7.15, 14.32 GHz, 0.000-7.495 m>
    """
    view = tuple(np.rad2deg(np.broadcast_to(field_of_view, 2)).tolist())
    rig = replace(Rig.default(), twin=settings, field_of_view_deg=view)
    plan, bench = planned(rig, size=size), simulated(rig, target, seed=seed)
    with tempfile.TemporaryDirectory() as folder:
        data = scan(plan, lambda: bench, Path(folder, "m.nc")).dataset
    ranges = bench.daq.world.ranges(plan.angles).reshape(plan.angles.shape[:2])
    data["depth"] = (("y", "x"), data.attrs["group_index"] * ranges, {"units": "m"})
    data["mask"] = data["mask"] * np.isfinite(ranges).astype(np.int8)
    return Measurement(data)
