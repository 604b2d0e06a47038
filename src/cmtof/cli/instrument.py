"""The instrument, real or simulated: scan."""

import sys
from itertools import chain, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cmtof.cli.app import app
from cmtof.cli.options import Output, Quiet
from cmtof.console import progress_bar

if TYPE_CHECKING:
    from cmtof.hardware.plan import Line

SCENE = "still_life"
"""What the simulated instrument looks at when nobody says."""


@app.command()
def scan(
    output: Output,
    rig: Annotated[Path | None, typer.Argument(help="RIG file, *.yml.")] = None,
    twin: Annotated[
        bool, typer.Option("--twin", help="Scan with the default simulated instrument.")
    ] = False,
    scene: Annotated[
        str | None,
        typer.Option(
            help="Frame before the simulated instrument: .npz, PNG pair, Hypersim, or an embedded "
            f"one. Default: {SCENE}."
        ),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, help="Seed of the simulated instrument. Default: 0.")
    ] = None,
    size: Annotated[
        int, typer.Option(min=1, max=4096, help="Height and width of the image, px.")
    ] = 64,
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
        raise ValueError(f"Expected {what} with --twin only, got a RIG file. Leave it out.")
    from cmtof.hardware.journal import journal_path
    from cmtof.hardware.plan import points_from_csv
    from cmtof.hardware.rig import Rig, open_instruments, simulated
    from cmtof.hardware.scan import check_scan_output, description, planned
    from cmtof.hardware.scan import scan as run_scan

    settings = Rig.default() if rig is None else Rig.load(rig)
    directions = None if points is None else points_from_csv(points)
    plan = planned(settings, size=size, points=directions)
    if dry_run:
        print("\n".join(description(plan, settings)))
        return
    check_scan_output(output, resume=resume)
    seed, scene = (seed or 0, scene or SCENE) if twin else (None, None)
    try:
        with progress_bar(quiet) as bar:
            task = bar.add_task("", total=plan.bursts)

            # the first line may be an earlier run's, which shows nothing of this one's speed
            show = iter(chain([bar.reset], repeat(bar.update)))

            def report(line: "Line") -> None:
                place = f" {line.row + 1}/{plan.shape[0]}" if line.kind == "scan" else ""
                text = f"{line.mode}: {line.kind}{place}"
                next(show)(task, completed=line.labels[-1], description=text)

            measurement = run_scan(
                settings,
                lambda: (
                    simulated(settings, scene, seed=seed or 0)
                    if twin
                    else open_instruments(settings)
                ),
                plan,
                output,
                resume=resume,
                report=report,
                seed=seed,
                scene=Path(scene).name if scene else None,
            )
    except (KeyboardInterrupt, SystemExit):
        print(f"cmtof: stopped; {journal_path(output)} goes on with --resume", file=sys.stderr)
        raise
    print(f"{output}: {measurement}, {measurement.mask.mean():.1%} of pixels valid")
