"""The scan: instruments and a plan go in, a journal line by line, and a measurement at the end.

Every line begins from a known state and is checked at its end (edges counted, both modulators on
and locked, interlock closed); only then is it recorded. Whatever goes wrong, the emergency stop
closes the shutter, parks the beam and turns RF off, and ``resume`` goes on at the first line that
is not in the journal.
"""

import json
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from glob import escape
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from cmtof import __version__
from cmtof.constants import SPEED_OF_LIGHT
from cmtof.hardware.beam import settling_time
from cmtof.hardware.bench import Bench
from cmtof.hardware.journal import Journal, journal_path, read_journal
from cmtof.hardware.plan import Line, Plan, Record, raster
from cmtof.hardware.reduction import Gain, Sampling, measurement_from_records
from cmtof.hardware.rig import Instruments, Rig, simulated
from cmtof.instrument.optics import group_index
from cmtof.instrument.settings import TwinSettings
from cmtof.measurement import Measurement, open_measurement

Report = Callable[[Line], None]
"""Called with each line that is on the disk; of those of an earlier run with the last one only."""

SWEEP = 8
"""Positions of the reference target, spread over one wrap of the single mode."""


def planned(rig: Rig, *, size: int | tuple[int, int] = 64) -> Plan:
    """Plan of a rig's scan: an image of ``size`` (height and width).

    With a stage the reference target is taken at positions over one wrap of the single mode, which
    is two of the doubled one.

    Raises
    ------
    ValueError
        If a direction is beyond what the mirrors reach.
    """
    sweep: tuple[float, ...] = (0.0,)
    if "stage" in rig.devices:
        wrap = SPEED_OF_LIGHT / (2 * rig.drive.frequency_single * group_index())
        sweep = tuple(float(s) for s in wrap * ((np.arange(SWEEP) + 0.5) / SWEEP - 0.5))
    modes = rig.scan.modes
    plan = raster(size, field_of_view=rig.scan.field_of_view, modes=modes, sweep=sweep)
    galvo = rig.galvo
    offset = np.array([galvo.offset_x_volts, galvo.offset_y_volts])
    volts = np.abs(plan.angles * galvo.volts_per_radian + offset).max()
    if volts > galvo.limit_volts:
        raise ValueError(
            f"Expected directions within {galvo.limit_volts:g} V of the mirrors, got {volts:.3g}. "
            "Reduce the field of view."
        )
    return plan


def sampling_of(rig: Rig, plan: Plan) -> Sampling:
    """Layout of a burst: in its first phase the mirrors settle from one column to the next, too."""
    detection, step = rig.detection, 0.0
    if plan.shape[1] > 1:
        step = float(np.abs(np.diff(plan.angles[..., 0], axis=1)).max())
    settling = ceil(settling_time(step, rig.galvo.settling) * detection.rate - 1e-9)
    first = max(detection.settle_samples, min(settling, detection.samples_per_phase - 1))
    layout = detection.phases, detection.samples_per_phase, detection.settle_samples
    return Sampling(*layout, first)


def header_of(bench: Bench, plan: Plan, *, seed: int | None, scene: str | None) -> dict[str, Any]:
    """Everything that the result depends on, as JSON has it; no address, no clock."""
    rig, identities = bench.rig, bench.identities()
    twin = "TWIN" in json.dumps(identities)
    gain = Gain(*bench.instruments.daq.gain(rig.detection.range))
    order = {"single": 1, "doubled": 2}
    header = {
        "version": __version__,
        "source": "simulated instrument" if twin else "instrument",
        "seed": seed,
        "scene": scene,
        "plan": plan.as_dict(),
        "sampling": vars(bench.sampling),
        "gain": gain._asdict(),
        "group_index": group_index(rig.twin.air) if twin else group_index(),
        "frequencies": {mode: order[mode] * rig.drive.frequency(mode) for mode in plan.modes},
        "settings": rig.as_dict(),
        "instruments": identities,
    }
    return json.loads(json.dumps(header))


def scan(
    rig: Rig,
    instruments: Callable[[], Instruments],
    plan: Plan,
    output: str | Path,
    *,
    resume: bool = False,
    seed: int | None = None,
    scene: str | None = None,
    report: Report = lambda line: None,
) -> Measurement:
    """Scan, and write the measurement.

    Parameters
    ----------
    rig : Rig
    instruments : callable
        Opens them: ``lambda: open_instruments(rig)`` or ``lambda: simulated(rig, scene)``.
    plan : Plan
        From `planned`.
    output : str or Path
        The file to write, ``*.nc``; the journal lies beside it until that is done.
    resume : bool
        Go on with the journal that is there.
    seed, scene : int and str, optional
        Of the simulated instrument; they stand in the file.
    report : callable
        Called with each line that is on the disk; of an earlier run's with the last.

    Raises
    ------
    ValueError
        If there is a journal and ``resume`` was not asked for, it belongs to other settings, or the
        reference target saturates the detector or shows no modulation.
    InstrumentError
        For whatever an instrument did not do; what was measured stays in the journal.
    """
    output, path = Path(output), journal_path(output)
    check_scan_output(output, resume=resume)
    if resume and output.exists() and not path.exists():
        return open_measurement(output)  # the journal goes when the file is whole
    with ExitStack() as held:
        with instruments() as opened:
            bench = Bench(opened, rig, sampling_of(rig, plan))
            header = header_of(bench, plan, seed=seed, scene=scene)
            journal = held.enter_context(Journal(path, header))
            if done := len(journal.records):
                report(plan.lines[done - 1])
            for record in measured(bench, plan, journal.header, journal.records):
                journal.append(record)
                report(plan.lines[record.line])
        measurement = export(path, output)
        # what a kill during an export has left; the journal's lock keeps others out
        for part in output.parent.glob(f".{escape(output.stem)}.part-*.nc"):
            part.unlink(missing_ok=True)
        path.unlink()
    return measurement


def measured(
    bench: Bench, plan: Plan, header: dict[str, Any], records: list[Record]
) -> Iterator[Record]:
    """Records of every line behind those that there are; the beam is shut at the end."""
    mode = None
    for line in plan.lines[len(records) :]:
        if mode is None:
            bench.set_up()
        if line.mode != mode:
            bench.choose_mode(line.mode)
            mode = line.mode
        record = bench.measure(plan, line)
        if line.kind == "reference":
            # a target that shows nothing or saturates must not wait for the end of the scan
            measurement_from_records(header, [*records[: line.index], record])
        yield record
    if mode is not None:
        bench.shut()


def export(journal: str | Path, output: str | Path) -> Measurement:
    """Write the measurement that a journal holds, finished or not; the same journal, same bytes."""
    measurement = measurement_from_records(*read_journal(journal))
    measurement.save(output)
    with Path(output).open("rb") as written:  # the journal may be removed after this
        os.fsync(written.fileno())
    return measurement


def check_scan_output(output: Path, *, resume: bool) -> None:
    """Raise an error where a scan cannot be written, before anything is started."""
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
    comes out of the measurement, its true ``depth`` included, to have metres along the ray.

    Parameters
    ----------
    settings : TwinSettings
        The instrument; its ``reference`` is what calibrates psi in both modes.
    target : Target, Frame, str or mapping
        As `cmtof.instrument.targets.scene_from` takes it.
    size, field_of_view : number or (number, number)
        Height and width, px; full optical angles across and down, rad.
    seed : int
        Of the simulated instrument.
    phases : int
        Steps of psi over a turn.
    range_min, range_max : float
        Depths to choose from, m; the default ends where both frequencies repeat themselves.

    Examples
    --------
    >>> wall = {"kind": "plane", "distance": 1.0}
    >>> scan_scene(TwinSettings(), wall, size=2, field_of_view=0.1, seed=0)
    <Measurement 2x2 px at 7.15, 14.32 GHz, 0.000-7.495 m>
    """
    view = field_of_view if isinstance(field_of_view, tuple) else (field_of_view, field_of_view)
    rig, known = Rig.default(), settings.reference
    distance = replace(rig.reference, distance=known.distance, stage_zero=known.stage_zero)
    rig = replace(
        rig,
        twin=settings,
        scan=replace(rig.scan, field_of_view_deg=tuple(float(np.rad2deg(a)) for a in view)),
        detection=replace(rig.detection, phases=phases),
        reference=distance,
    )
    plan, records = planned(rig, size=size), []
    with simulated(rig, target, seed=seed) as instruments:
        bench = Bench(instruments, rig, sampling_of(rig, plan))
        header = header_of(bench, plan, seed=seed, scene=None)
        for record in measured(bench, plan, header, records):
            records.append(record)
        index = header["group_index"]
        ranges = index * instruments.daq.world.ranges(plan.angles).reshape(plan.shape)
    data = measurement_from_records(header, records).dataset
    data["depth"] = (("y", "x"), ranges, {"units": "m"})
    data["mask"] = data["mask"] * np.isfinite(ranges).astype(np.int8)
    data.attrs["range_min"] = float(range_min)
    if range_max is not None:
        data.attrs["range_max"] = float(range_max)
    return Measurement(data)
