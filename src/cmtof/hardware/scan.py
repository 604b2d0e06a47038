"""The run: instruments and a plan go in, a journal line by line, and a measurement at the end.

Every line begins from a known state and is checked at its end (edges counted, both modulators on
and locked, interlock closed); only then is it recorded. Whatever goes wrong, the emergency stop
closes the shutter, parks the beam and turns RF off, and ``resume`` goes on at the first line that
is not in the journal.
"""

import json
from collections.abc import Callable
from contextlib import ExitStack
from glob import escape
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.hardware.bench import Bench
from cmtof.hardware.drivers.galvo import Galvo
from cmtof.hardware.errors import BadReply
from cmtof.hardware.export import export, measurement_from_journal
from cmtof.hardware.journal import Journal, Record, journal_path, read_journal
from cmtof.hardware.plan import REFERENCE_BURSTS, Line, Plan, point_list, raster
from cmtof.hardware.reduction import Sampling
from cmtof.hardware.rig_settings import RigSettings
from cmtof.hardware.scan_header import header_of, settings_as_dict
from cmtof.instrument.optics import group_index
from cmtof.measurement import Measurement, open_measurement

Report = Callable[[Line], None]
"""Called with each line that is on the disk; of those of an earlier run with the last one only."""

SWEEP = 8
"""Positions of the reference target, spread over one wrap of the single mode."""

LINE_ATTEMPTS = 2
"""How often a line is taken before a missed edge is an error."""

DARK = 1.0
"""Stands for the laser power of a line without light, W: nothing is divided by it."""


def planned(
    settings: RigSettings, *, size: int | tuple[int, int] = 64, points: ArrayLike | None = None
) -> Plan:
    """Plan of a rig's scan: an image of ``size`` (height and width), or directions (N, 2), rad.

    With a stage the reference target is taken at positions over one wrap of the single mode, which
    is two of the doubled one.

    Raises
    ------
    ValueError
        If a direction is beyond what the mirrors reach.
    """
    sweep: tuple[float, ...] = (0.0,)
    if "stage" in settings.devices:
        wrap = SPEED_OF_LIGHT / (2 * settings.drive.frequency_single * group_index())
        sweep = tuple(float(s) for s in wrap * ((np.arange(SWEEP) + 0.5) / SWEEP - 0.5))
    modes, view = settings.scan.modes, settings.scan.field_of_view
    if points is not None:
        plan = point_list(points, modes=modes, sweep=sweep)
    else:
        plan = raster(size, field_of_view=view, modes=modes, sweep=sweep)
    galvo = settings.galvo
    offset = np.array([galvo.offset_x_volts, galvo.offset_y_volts])
    volts = np.abs(plan.angles * galvo.volts_per_radian + offset).max()
    if volts > galvo.limit_volts:
        raise ValueError(
            f"Expected directions within {galvo.limit_volts:g} V of the mirrors, got {volts:.3g}. "
            "Reduce the field of view or leave those points out."
        )
    return plan


def sampling_of(settings: RigSettings, plan: Plan) -> Sampling:
    """Layout of a burst: in its first phase the mirrors settle from one column to the next, too."""
    detection = settings.detection
    mirrors = Galvo(NotImplemented, settling=settings.galvo.settling)
    step = 0.0
    if plan.camera is not None and plan.shape[1] > 1:
        step = float(np.abs(np.diff(plan.angles[..., 0], axis=1)).max())
    settling = ceil(mirrors.settling_time(step) * detection.rate - 1e-9)
    return Sampling(
        detection.phases,
        detection.samples_per_phase,
        detection.settle_samples,
        max(detection.settle_samples, min(settling, detection.samples_per_phase - 1)),
    )


def scan(
    rig: Any,
    plan: Plan,
    output: str | Path,
    *,
    resume: bool = False,
    seed: int | None = None,
    scene: str | None = None,
    report: Report | None = None,
) -> Measurement:
    """Scan, and write the measurement.

    Parameters
    ----------
    rig : Rig
        Settings, and the way to the instruments.
    plan : Plan
        From `planned`.
    output : str or Path
        The file to write, ``*.nc``; the journal lies beside it until that is done.
    resume : bool
        Go on with the journal that is there.
    seed, scene : int and str, optional
        Of the simulated instrument; they stand in the file.
    report : callable, optional
        Called with each line that is on the disk; of an earlier run's with the last.

    Raises
    ------
    ValueError
        If there is a journal and ``resume`` was not asked for, or it belongs to other settings.
    InstrumentError
        For whatever an instrument did not do; what was measured stays in the journal.
    """
    output, path = Path(output), journal_path(output)
    check_output(output, resume=resume)
    if resume and output.exists() and not path.exists():
        return _finished(output, rig.settings, plan, seed)
    with ExitStack() as held:
        with rig.open() as instruments:
            bench = Bench(instruments, rig.settings, sampling_of(rig.settings, plan))
            header = header_of(bench, plan, seed=seed, scene=scene)
            journal = held.enter_context(Journal(path, header))
            run(bench, plan, journal, report or (lambda line: None))
        measurement = export(path, output)
        # what a kill during an export has left; the journal's lock keeps others out
        for part in output.parent.glob(f".{escape(output.stem)}.part-*.nc"):
            part.unlink(missing_ok=True)
        path.unlink()
    return measurement


def _finished(output: Path, settings: RigSettings, plan: Plan, seed: int | None) -> Measurement:
    """Open the file of a scan that is over: its journal goes when the file is whole."""
    measurement = open_measurement(output)
    held = measurement.dataset
    same = (
        held.attrs.get("settings") == json.dumps(settings_as_dict(settings), sort_keys=True)
        and held.attrs.get("seed") == seed
        and "angle" in held
        and np.array_equal(held["angle"], plan.angles)
    )
    if not same:
        raise ValueError(
            f"Expected a scan of these settings in {output}, got another one that is finished. "
            "Name another output, or leave --resume out to scan anew."
        )
    return measurement


def check_output(output: Path, *, resume: bool) -> None:
    """Raise a ValueError where a scan cannot be written, before anything is started."""
    if output.suffix != ".nc":
        raise ValueError(f"Expected an output named *.nc, got {output.name}. Rename it.")
    if not output.parent.is_dir():
        raise FileNotFoundError(
            f"Expected an existing folder to write into, got {output.parent}. Create it first."
        )
    path = journal_path(output)
    if path.exists() and not resume:
        raise ValueError(
            f"Expected no scan begun, got {len(read_journal(path)[1])} lines in {path}. "
            "Go on with --resume, or remove it to begin anew."
        )


def run(bench: Bench, plan: Plan, journal: Journal, report: Report) -> None:
    """Measure every line that is not in the journal."""
    done = len(journal.records)
    if done:
        report(plan.lines[done - 1])
    if done == len(plan.lines):
        return
    bench.set_up()
    mode = None
    for line in plan.lines[done:]:
        if line.mode != mode:
            bench.choose_mode(line.mode)
            mode = line.mode
        record = _measured(bench, plan, line)
        if line.kind == "reference":
            # a target that shows nothing must not wait for the end of the scan
            measurement_from_journal(journal.header, [*journal.records, record])
        journal.append(record)
        report(line)
    bench.shut()


def _measured(bench: Bench, plan: Plan, line: Line) -> Record:
    """One line; it is begun anew once when the phase table has missed an edge.

    The laser power is read at the end, on the clock of the last burst: so it is the same whether
    the line came after others or after a resume.
    """
    bench.look_at(line.kind)
    for _ in range(LINE_ATTEMPTS):
        sums, clipped = _bursts(bench, plan, line)
        bench.check()
        if bench.stepped():
            power = DARK if line.kind == "dark" else bench.power()
            return Record(line.index, power, sums, clipped)
    raise BadReply(
        f"Expected one edge a phase at the trigger of the phase table, got another number "
        f"{LINE_ATTEMPTS} times in line {line.index}. Check the trigger line."
    )


def _bursts(bench: Bench, plan: Plan, line: Line) -> tuple[NDArray[np.uint32], NDArray[np.uint16]]:
    points = plan.points(line)
    bench.begin_line()
    sums = np.empty((line.bursts, bench.sampling.phases), np.uint32)
    clipped = np.empty(line.bursts, np.uint16)
    for n, label in enumerate(line.labels):
        direction = points[n] if line.kind == "scan" else None
        if direction is not None:
            bench.approach(direction)
        if line.kind == "reference" and n % REFERENCE_BURSTS == 0:
            bench.move_target(plan.sweep[n // REFERENCE_BURSTS], first=n == 0)
        sums[n], clipped[n] = bench.sampling.sums(bench.burst(label, direction))
    return sums, clipped
