"""The instrument, real or simulated: scan, twin."""

import signal
import sys
from itertools import chain, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cmtof.cli.app import app
from cmtof.cli.options import Output, Quiet
from cmtof.console import progress_bar

if TYPE_CHECKING:
    from cmtof.hardware.plan import Line, Plan
    from cmtof.hardware.rig import Rig

SCENE = "still_life"
"""What the simulated instrument looks at when nobody says."""

Scene = Annotated[
    str | None,
    typer.Option(
        "--scene",
        help="Frame before the simulated instrument: .npz, PNG pair, Hypersim, or an embedded one. "
        f"Default: the rig's, or else {SCENE}.",
    ),
]
TwinSeed = Annotated[
    int | None, typer.Option("--seed", min=0, help="Seed of the simulated instrument. Default: 0.")
]


@app.command()
def scan(
    output: Output,
    rig: Annotated[Path | None, typer.Argument(help="RIG file, *.yml.")] = None,
    twin: Annotated[
        bool, typer.Option("--twin", help="Start the default simulated instrument and scan it.")
    ] = False,
    scene: Scene = None,
    seed: TwinSeed = None,
    size: Annotated[int, typer.Option(min=1, help="Height and width of the image, px.")] = 64,
    points: Annotated[
        Path | None,
        typer.Option(help="CSV of directions instead: x,y in rad or x_deg,y_deg."),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a scan that was stopped.")
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Print the plan and touch nothing.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Scan with the instrument, or with its simulation, into a measurement.

    Every line goes to the disk, into a journal beside the output, until the file is whole. After a
    stop of any kind, [bold]--resume[/bold] goes on at the first line that is missing.

    Example: [bold]cmtof scan --twin --scene still_life --size 64 --seed 0 -o m.nc[/bold]
    """
    if twin == (rig is not None):
        got = "both" if twin else "neither"
        raise ValueError(f"Expected either a RIG file or --twin, got {got}. Name one.")
    if not twin and (seed is not None or scene is not None):
        what = "--scene" if seed is None else "--seed"
        raise ValueError(
            f"Expected {what} with --twin only, got a RIG file. Give it to `cmtof twin`."
        )
    from cmtof.hardware.dry_run import description
    from cmtof.hardware.plan import points_from_csv
    from cmtof.hardware.rig import Rig
    from cmtof.hardware.scan import check_output, planned

    directions = None if points is None else points_from_csv(points)
    opened = Rig.default() if rig is None else Rig.load(rig)
    plan = planned(opened.settings, size=size, points=directions)
    if dry_run:
        print("\n".join(description(plan, opened.settings)))
        return
    check_output(output, resume=resume)
    if not twin:
        _run(opened, plan, output, resume=resume, quiet=quiet)
        return
    from cmtof.hardware.twin.run import Twin

    scene = scene or _scene_of(opened)
    with Twin.default(seed=seed or 0, scene=scene) as running:
        simulated = {"seed": seed or 0, "scene": Path(scene).name if scene else None}
        _run(running.rig, plan, output, resume=resume, quiet=quiet, **simulated)


def _run(
    rig: "Rig", plan: "Plan", output: Path, *, resume: bool, quiet: bool, **simulated: Any
) -> None:
    """Scan behind a progress bar, and say what came of it."""
    from cmtof.hardware.journal import journal_path
    from cmtof.hardware.scan import scan as run_scan

    try:
        with progress_bar(quiet) as bar:
            task = bar.add_task("", total=plan.bursts)

            # the first line may be an earlier run's, which tells nothing of this one's speed
            tell = iter(chain([bar.reset], repeat(bar.update)))

            def report(line: "Line") -> None:
                place = f" {line.row + 1}/{plan.shape[0]}" if line.kind == "scan" else ""
                text = f"{line.mode}: {line.kind}{place}"
                next(tell)(task, completed=line.labels[-1], description=text)

            measurement = run_scan(rig, plan, output, resume=resume, report=report, **simulated)
    except (KeyboardInterrupt, SystemExit):
        print(f"cmtof: stopped; {journal_path(output)} goes on with --resume", file=sys.stderr)
        raise
    print(f"{output}: {measurement}, {measurement.mask.mean():.1%} of pixels valid")


@app.command()
def twin(
    rig: Annotated[Path, typer.Argument(help="RIG file, *.yml.")],
    scene: Scene = None,
    seed: TwinSeed = None,
) -> None:
    """Serve the simulated instrument at the addresses of a RIG file until Ctrl-C.

    The same program that drives the real devices then drives the simulated ones, on loopback and
    pseudo-terminals.

    Example: [bold]cmtof twin rig.yml --scene still_life[/bold], and in another terminal
    [bold]cmtof scan rig.yml -o m.nc[/bold]
    """
    from threading import Event

    from cmtof.hardware.rig import Rig
    from cmtof.hardware.twin.run import Twin

    def stop(number: int, frame: Any) -> None:
        raise SystemExit(128 + number)

    signal.signal(signal.SIGTERM, stop)  # so that the links of the lines are removed
    loaded = Rig.load(rig)
    with Twin(loaded, seed=seed or 0, scene=scene or _scene_of(loaded)) as running:
        _print_addresses(running.rig)
        Event().wait()


def _scene_of(rig: "Rig") -> str | None:
    """Scene to put before a twin: none where the rig has its own."""
    return None if rig.settings.twin.get("scene") else SCENE


def _print_addresses(rig: "Rig") -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"{rig.settings.name}, simulated; Ctrl-C ends it")
    for heading in ("role", "driver", "address"):
        table.add_column(heading, no_wrap=heading != "address")
    for role, device in rig.settings.devices.items():
        table.add_row(role, device.driver, " ".join(filter(None, (device.address, device.stream))))
    console = Console()
    console.print(table)
    console.file.flush()
