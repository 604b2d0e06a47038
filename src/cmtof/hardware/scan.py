"""Scans: the lines of a plan are measured, journaled one by one, and become a measurement.

Every line begins from a known state and is checked at its end (edges counted, both modulators on
and locked, interlock closed); only then is it recorded. Whatever goes wrong, the emergency stop
closes the shutter, parks the beam and turns RF off, and ``resume`` goes on at the first line that
is not in the journal.
"""

import json
import os
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

from cmtof import __version__
from cmtof.files import AnyPath, check_output, exclusive_lock
from cmtof.hardware.bench import Bench
from cmtof.hardware.journal import (
    append_line,
    check_settings,
    journal_path,
    resume_journal,
    whole_lines,
)
from cmtof.hardware.plan import SWEEP, Line, Plan
from cmtof.hardware.reduction import (
    attributes,
    measurement_from_records,
    psi_correction,
)
from cmtof.measurement import Measurement, open_measurement


def finished_measurement(output: Path, plan: Plan, bench: object) -> Measurement:
    """Measurement of a finished scan; a ValueError if plan or bench have other settings.

    A simulated bench has a seed and a scene; real devices are not opened for it.
    """
    about = getattr(bench, "about", {"source": "instrument"})
    measurement = open_measurement(output)
    old = measurement.dataset.attrs
    check_settings(
        output,
        {
            **json.loads(old.get("settings", "{}")),
            **old,
            "size": list(measurement.shape),
        },
        plan.rig.as_dict()
        | {"size": list(plan.angles.shape[:2]), "scene": None}
        | attributes(about),
    )
    return measurement


def scan(
    plan: Plan,
    bench: Callable[[], AbstractContextManager[Bench]],
    output: AnyPath,
    *,
    resume: bool = False,
    report: Callable[[Line], None] = lambda line: None,
) -> Measurement:
    """Scan, write the measurement ``*.nc`` and return it; a journal is kept beside it until then.

    ``bench`` opens the instruments, as `cmtof.hardware.connect.connected_bench` does; ``report`` is
    called with each line that is on the disk. Raises ValueError for a journal of other settings or
    a reference target that saturates or shows no modulation (after its first visit), and
    InstrumentError for whatever an instrument did not do; what was measured stays in the journal.
    """
    output = Path(output)
    path = check_output(journal_path(check_output(output, ".nc")))
    if path.exists() and not resume:
        raise ValueError(
            "Expected no unfinished scan, "
            f"got {max(len(whole_lines(path)) - 1, 0)} lines in {path}. "
            "Go on with --resume, or remove it to begin again."
        )
    mode = None
    if resume and output.exists() and not path.exists():
        # the journal goes when the file is whole
        return finished_measurement(output, plan, bench())
    with bench() as on:
        header = {
            "version": __version__,
            **on.about,
            "size": list(plan.angles.shape[:2]),
            "calibration": list(on.daq.gain()),
            "settings": plan.rig.as_dict(),
            "instruments": {
                role: device.identify() for role, device in on.devices.items()
            },
        }
        path.touch()
        with exclusive_lock(path):
            records = resume_journal(path, header, plan)
            for line in plan.lines[len(records) :]:
                if mode is None:
                    on.set_up()
                if line.mode != mode:
                    on.choose_mode(mode := line.mode)
                records.append(on.measure(plan, line))
                if (line.kind, line.row) == ("reference", SWEEP - 1):
                    psi_correction(plan, header, line.mode, records)
                append_line(path, records[-1]._asdict())
                report(line)
    measurement = measurement_from_records(plan, header, records)
    measurement.save(output)
    with output.open("rb") as written:  # it is on the disk before the journal goes
        os.fsync(written.fileno())
    path.unlink()
    return measurement
