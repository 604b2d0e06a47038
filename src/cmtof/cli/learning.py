"""Commands that render rooms and train networks."""

from pathlib import Path
from typing import Any

from cmtof.cli.options import File, Options
from cmtof.terminal import delay_interrupts, progress, progress_is_hidden, say


def render(
    output: Path,
    workers: int | None = None,
    quiet: bool = False,
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
    rendered = _render_set(output, quiet, workers, height=height, width=width, **rooms)
    say(
        f"{output}: {rooms['scenes']} rooms, {rooms['views']} views each; "
        f"{rendered} views rendered"
    )


def _render_set(output: Path, quiet: bool, workers: int | None, **settings: Any) -> int:
    """Render what a set of rooms still lacks, with a progress bar; return how many views it was."""
    from cmtof_rooms.rendering import Settings, render_rooms

    chosen = Settings(**settings)
    with progress(chosen.scenes, quiet) as advance:
        return render_rooms(output, chosen, workers=workers, progress=advance)


def train(
    config: str,
    output: File = None,
    data: File = None,
    quiet: bool = False,
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
    if data and not chosen.rooms:
        raise ValueError(
            f"Expected a recipe with rooms for --data, got {config} without. "
            "Leave --data out."
        )
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
    say(written or f"{folder}: stopped before its last step; --resume goes on")
