"""Commands that render rooms and train networks."""

from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option

from cmtof.cli.options import AnySeed, File, Options, Quiet, Seed, group_options
from cmtof.terminal import delay_interrupts, progress, progress_is_hidden


def rooms(
    scenes: Annotated[int, Option(min=1, max=100_000, help="How many rooms.")] = 20,
    views: Annotated[int, Option(min=1, max=1000, help="Views of each.")] = 5,
    seed: Seed = 0,
    size: Annotated[str, Option(help="Height x width, px.")] = "512x512",
    focal: Annotated[
        float | None, Option(help="Focal length, px. Default: 35 to 60°.")
    ] = None,
) -> None:
    """Options of a set of rooms, which a command takes through `group_options`."""


@group_options(rooms)
def render(
    output: Annotated[
        Path, Option("--output", "-o", help="Folder to write the set into.")
    ],
    workers: Annotated[
        int | None, Option(min=1, help="Processes. Default: one a core.")
    ] = None,
    quiet: Quiet = False,
    *,
    rooms: Options,
) -> None:
    """Render furnished rooms, in Hypersim's layout.

    The same seed gives the same bytes. A stopped run continues, and a set may
    grow: ask for more scenes or views in the same folder. Needs the extra [bold]rooms[/bold].

    Example: [bold]cmtof render --scenes 20 --views 5 --seed 1 -o rooms[/bold]
    """
    with delay_interrupts():
        from cmtof_rooms.rendering import shape_from_text

    height, width = shape_from_text(rooms.pop("size"))
    done = _render_set(output, quiet, workers, height=height, width=width, **rooms)
    rendered = sum(one.rendered for one in done)
    print(
        f"{output}: {rooms['scenes']} rooms, {rooms['views']} views each; "
        f"{rendered} views rendered"
    )


def _render_set(
    output: Path, quiet: bool, workers: int | None, **settings: Any
) -> list:
    """Render what a set of rooms still lacks, with a progress bar; return a report of each room."""
    from cmtof_rooms.rendering import Settings, render_rooms

    chosen = Settings(**settings)
    with progress(chosen.scenes, quiet) as advance:
        return render_rooms(
            output, chosen, workers=workers, progress=lambda one: advance(one.scene)
        )


def recipe(
    model: Annotated[
        str | None, Option(help="Learned method, such as fast-scnn.")
    ] = None,
    protocol: Annotated[str | None, Option(help="released or full.")] = None,
    seed: AnySeed = None,
) -> None:
    """Options that replace values of a training recipe."""


def leg(
    init: Annotated[File, Option(help="Weights to begin with.")] = None,
    resume: Annotated[
        bool, Option("--resume", help="Go on from its checkpoint.")
    ] = False,
    minutes: Annotated[
        float | None, Option(help="Stop after; --resume goes on.")
    ] = None,
    accelerator: Annotated[str, Option(help="Lightning's: auto, cpu, gpu.")] = "auto",
    devices: Annotated[str, Option(help="How many, or auto.")] = "auto",
    num_nodes: Annotated[int, Option(min=1, help="Machines.")] = 1,
    strategy: Annotated[str, Option(help="Lightning's: auto, ddp.")] = "auto",
) -> None:
    """Options of one run that are not in its recipe: weights to begin with, time, hardware."""


@group_options(recipe, leg)
def train(
    config: Annotated[str, Argument(help="A recipe by name, or a YAML file.")],
    output: Annotated[File, Option("--output", "-o", help="Folder of the run.")] = None,
    data: Annotated[File, Option(help="Hypersim's layout. Default: rooms.")] = None,
    quiet: Quiet = False,
    *,
    recipe: Options,
    leg: Options,
) -> None:
    """Train an unwrapping network and write its weights and their card.

    A run that was killed and resumed ends with the same weights. Needs the extras
    [bold]train[/bold] and [bold]rooms[/bold].

    Example: [bold]cmtof train miniature -o runs/miniature[/bold]
    """
    from cmtof.hypersim import Hypersim
    from cmtof.network.recipe import Rooms, read_config
    from cmtof.network.training import train as train_network

    chosen = read_config(config, **recipe)
    folder = output or Path("runs") / f"{chosen.name}-{chosen.model}-{chosen.protocol}"
    if data:
        Hypersim(data)  # refused before anything is written

    def find_tree(rooms: Rooms) -> Path:
        rendered = folder.parent / (
            f"rooms_{rooms.seed}_{rooms.scenes}x{rooms.views}_"
            f"{rooms.height}x{rooms.width}"
        )
        if not data:
            _render_set(rendered, quiet, None, **rooms.model_dump())
        return data or rendered

    written = train_network(
        chosen,
        folder,
        quiet=quiet or progress_is_hidden(),
        find_tree=find_tree,
        **leg,
    )
    print(written or f"{folder}: stopped before its last step; --resume goes on")
