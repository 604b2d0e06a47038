"""Commands that simulate or scan a measurement, and list the content of files."""

import os
import sys
from collections.abc import Callable
from functools import partial
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from typer import BadParameter

from cmtof.cli.options import (
    File,
    Options,
)
from cmtof.terminal import complain, print_table, progress, say

if TYPE_CHECKING:
    from cmtof.hardware.rig import Rig


def simulate(
    frame: str,
    output: Path,
    frequencies: str = "7.15e9,14.32e9",
    *,
    conditions: Options,
    reading: Options,
) -> None:
    """Turn an RGB-D frame into correlation images. `cmtof info` lists the embedded frames.

    Example: [bold]cmtof simulate still_life -o m.nc --protocol full --seed 3[/bold]
    """
    from cmtof.scenes import load_frame
    from cmtof.simulation import simulate as simulate_frame
    from cmtof.validation import checked_values

    tones = checked_values(list[float], frequencies.split(","), "--frequencies HZ,HZ")
    loaded = load_frame(frame, **reading)
    measurement = simulate_frame(loaded, frequencies=tones, **conditions)
    measurement.save(output)
    say(f"{output}: {measurement}, {measurement.mask.mean():.1%} of pixels scored")
    if loaded.note:
        say(f"{loaded.name}: {loaded.note}")


def scan(
    output: File = None,
    rig: File = None,
    size: int = 64,
    resume: bool = False,
    check: bool = False,
    quiet: bool = False,
    *,
    rehearsal: Options,
) -> None:
    """Scan with the instrument, or with its simulation, into a measurement.

    Every line goes to the disk, into a journal beside the output, until the file is whole. After a
    stop of any kind, [bold]--resume[/bold] goes on at the first line that is missing.

    Example: [bold]cmtof scan --twin --scene still_life --size 64 --seed 0 -o m.nc[/bold]
    """
    from cmtof.hardware.journal import journal_path
    from cmtof.hardware.plan import plan_scan
    from cmtof.hardware.rig import Rig
    from cmtof.hardware.scan import scan as run_scan

    if not rehearsal["twin"] and rig is None:
        raise BadParameter("Expected a RIG file or --twin, got neither. Name one.")
    plan = plan_scan(Rig.default() if rig is None else Rig.load(rig), size=size)
    bench = _opener(plan.rig, **rehearsal)
    if check:
        _print_states_and_exit(bench)
    if output is None:
        raise BadParameter("Expected an output, got none. Add -o m.nc.")
    try:
        with progress(len(plan.lines), quiet) as advance:
            measurement = run_scan(
                plan,
                bench,
                output,
                resume=resume,
                report=lambda line: advance(f"{line.mode}: {line.kind}"),
            )
    except (KeyboardInterrupt, SystemExit):
        complain(f"stopped; {journal_path(output)} goes on with --resume")
        raise
    say(f"{output}: {measurement}, {measurement.mask.mean():.1%} of pixels valid")


def _opener(
    rig: "Rig",
    *,
    twin: bool,
    scene: str | None,
    seed: int | None,
    log: File,
) -> Callable[[], Any]:
    """Function that opens a bench of real devices or, for a twin, of simulated ones."""
    if twin:
        if log:
            raise BadParameter(
                "Expected --log with a RIG file, got --twin. Leave one out."
            )
        from cmtof_lab.rehearsal import simulated_bench

        chosen = scene or rig.twin.get("scene", "still_life")
        return partial(simulated_bench, rig, chosen, seed=seed or 0)
    if (seed, scene) != (None, None):
        raise BadParameter(
            "Expected --scene and --seed with --twin, got a RIG file. Leave them out."
        )
    from cmtof.hardware.connect import connected_bench

    return partial(connected_bench, rig, log)


def _print_states_and_exit(bench: Callable[[], Any]) -> None:
    """Print what every device reports; exit with 1 if one is not as expected, else with 0."""
    from cmtof.hardware.checkup import states_of

    with bench() as on:
        states = [{"device": name, "reports": text} for name, text in states_of(on)]
    print_table("", states)
    raise SystemExit(any("Expected" in state["reports"] for state in states))


def info(
    file: File = None,
) -> None:
    """Print versions and embedded frames, or what a file holds."""
    from importlib.metadata import packages_distributions, version

    from cmtof import __version__
    from cmtof.captures import data_root
    from cmtof.frame import embedded_frames, list_npz
    from cmtof.measurement import open_measurement
    from cmtof.storage import open_netcdf

    if file is not None:
        path = embedded_frames().get(str(file), file)
        if path.suffix == ".npz":
            for line in list_npz(path):
                say(line)
            return
        text = StringIO()
        if path.suffix == ".nc":
            with open_netcdf(path) as dataset:
                dataset.info(text)
                if "component_odds" in dataset:
                    odds = (
                        dataset["component_odds"]
                        .sel(offset=slice(-2, 2))[:10]
                        .to_pandas()
                    )
                    print(
                        "Odds of the largest components to lie so many wraps farther:"
                    )
                    print(odds.round(3))
        else:
            open_measurement(path).dataset.info(text)
        say(text.getvalue())
        return
    print(
        f"cmtof {__version__}, Python {sys.version.split()[0]}, {os.cpu_count()} processors"
    )
    # a module may come from another package, as from onnxruntime-gpu
    packages = packages_distributions()
    for name in ("onnxruntime", "torch"):
        versions = " ".join(map(version, packages.get(name, [])))
        print(name, versions or "is not installed (only training needs torch)")
    print(f"embedded frames: {', '.join(embedded_frames())}")
    print(f"published captures: {data_root() or 'not on this machine'}")
