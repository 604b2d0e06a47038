"""What takes its time: render, train, replicate."""

from pathlib import Path
from typing import Annotated

import typer

from cmtof.cli.app import app
from cmtof.cli.options import Quiet
from cmtof.console import hidden, print_render_costs, progress_bar


@app.command()
def render(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write the set into.")],
    scenes: Annotated[int, typer.Option(min=1, help="How many rooms.")] = 20,
    views: Annotated[
        int, typer.Option(min=1, help="Views of each; one in twenty is a close-up.")
    ] = 5,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the set.")] = 0,
    size: Annotated[str, typer.Option(help="Height x width, px.")] = "512x512",
    focal: Annotated[
        float | None,
        typer.Option(help="Focal length, px. Default: each scene has its own, 35 to 60° across."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes. Default: one a core.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Render furnished rooms, in Hypersim's layout.

    The same seed gives the same bytes. A run that was stopped goes on where it was, and a set may
    grow: ask for more scenes or views in the same folder. Needs the extra [bold]rooms[/bold].

    Example: [bold]cmtof render --scenes 20 --views 5 --seed 1 -o rooms[/bold]
    """
    from time import perf_counter

    from cmtof.scenes.rooms.rendering import Settings, render_rooms, shape_from_text

    height, width = shape_from_text(size)
    settings = Settings(seed, scenes, views, height, width, focal)
    start = perf_counter()
    with progress_bar(quiet) as bar:
        task = bar.add_task("rooms", total=scenes)
        done = render_rooms(
            output,
            settings,
            workers=workers,
            progress=lambda one: bar.update(task, advance=1, description=one.scene),
        )
    seconds = perf_counter() - start
    rendered = sum(one.rendered for one in done)
    print(f"{output}: {scenes} rooms, {views} views each; {rendered} views rendered", end="")
    if not rendered:
        print(", the others were there")
        return
    print(f" in {seconds:.1f} s, {rendered / seconds:.2f} views/s")
    print_render_costs(done)


@app.command()
def train(
    config: Annotated[
        str,
        typer.Argument(help="paper, gpu, common, cpu or smoke, or a YAML file."),
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder of the run.")
    ] = None,
    model: Annotated[
        str | None, typer.Option(help="fast-scnn or a variant of it.", show_default="fast-scnn")
    ] = None,
    protocol: Annotated[
        str | None,
        typer.Option(help="released: 21 wraps; full: 358.", show_default="released"),
    ] = None,
    data: Annotated[
        Path | None,
        typer.Option(
            help="Frames in Hypersim's layout. Default: rooms of the configuration, rendered "
            "beside the run."
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on from the run's last checkpoint.")
    ] = False,
    minutes: Annotated[
        float | None,
        typer.Option(help="Stop after the epoch in which they are over; --resume goes on."),
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Of weights, crops, noise.")] = None,
    precision: Annotated[
        str | None, typer.Option(help="Lightning's: 32-true, bf16-mixed, 16-mixed.")
    ] = None,
    accelerator: Annotated[str, typer.Option(help="Lightning's: auto, cpu, gpu.")] = "auto",
    devices: Annotated[str, typer.Option(help="How many, or auto.")] = "auto",
    num_nodes: Annotated[int, typer.Option(min=1, help="Machines.")] = 1,
    strategy: Annotated[str, typer.Option(help="Lightning's: auto, ddp.")] = "auto",
    workers: Annotated[int, typer.Option(min=0, help="Processes that cut crops.")] = 0,
    quiet: Quiet = False,
) -> None:
    """Train an unwrapping network and write its weights and their card.

    Everything random hangs on the seed: a run that was killed and resumed ends with the same
    weights. Needs the extras [bold]learn[/bold] and [bold]rooms[/bold].

    Example: [bold]cmtof train smoke -o runs/smoke[/bold]
    """
    from cmtof.network.configuration import read_config

    chosen = read_config(config, model=model, protocol=protocol, seed=seed, precision=precision)
    name = f"{chosen.name}-{chosen.model}-{chosen.protocol}"
    folder = output or Path("runs") / name
    from cmtof.network.training import train as train_network

    rooms = chosen.rooms
    size = f"{rooms.scenes}x{rooms.views}_{rooms.height}x{rooms.width}"
    written = train_network(
        chosen,
        folder,
        tree=data or folder.parent / f"rooms_{rooms.seed}_{size}",
        resume=resume,
        minutes=minutes,
        workers=workers,
        quiet=quiet or hidden(),
        accelerator=accelerator,
        devices=int(devices) if devices.isdigit() else devices,
        num_nodes=num_nodes,
        strategy=strategy,
    )
    print(written or f"{folder}: stopped before its last epoch; --resume goes on")


@app.command()
def replicate(
    output: Annotated[Path, typer.Option("--output", "-o", help="Where to draw Fig. 10.")] = Path(
        "fig10_comparison.png"
    ),
) -> None:
    """Draw Fig. 10 anew, and hold the chain from frame to depth against stored values.

    Methods side by side on the embedded frames. Ends with 1 if a line says FAIL. No arguments, a
    minute on a CPU.
    """
    from cmtof.replication import replicate as outcomes

    failed = 0
    for outcome in outcomes(output):
        print(outcome, flush=True)
        failed += not outcome.passed
    print(f"{output}: Fig. 10, drawn on this machine")
    if failed:
        raise ValueError(f"Expected every line to pass, got {failed} FAIL. Compare versions.")
