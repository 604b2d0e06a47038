"""What the command line shows: progress, tables of scores, what a file holds."""

import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr
    from rich.progress import Progress

    from cmtof.measurement import Measurement
    from cmtof.scenes.rooms.rendering import Done


def progress_bar(quiet: bool) -> "Progress":
    """A progress bar on stderr; hidden when asked for, in CI, and where nobody watches."""
    from rich.console import Console
    from rich.progress import MofNCompleteColumn, Progress, SpinnerColumn, TimeRemainingColumn

    columns = (SpinnerColumn(), *Progress.get_default_columns()[:2], MofNCompleteColumn())
    return Progress(
        *columns, TimeRemainingColumn(), console=Console(stderr=True), disable=quiet or hidden()
    )


def hidden() -> bool:
    """Whether progress is not to be shown: in CI, and where nobody watches."""
    return bool(os.environ.get("CI")) or not sys.stderr.isatty()


def print_report(report: dict[str, Any]) -> None:
    """Print the scores of an evaluation as a table."""
    from rich.console import Console
    from rich.table import Table

    columns = {
        "δ<1": "delta_lt_1",
        "δ<2": "delta_lt_2",
        "δ<3": "delta_lt_3",
        "δ≥10": "delta_ge_10",
        "consistent": "consistent_lt_1",
    }
    table = Table(
        title=f"{len(report['frames'])} frame(s), protocol {report['protocol']}, "
        f"σ = {report['noise']:g}, seed {report['seed']}, {report['coverage']:.1%} scored"
    )
    table.add_column("method", no_wrap=True)
    for heading in (*columns, "median error", "s/frame"):
        table.add_column(heading, justify="right")
    for name, scores in report["methods"].items():
        rates = [f"{scores[key]:.1%}" for key in columns.values()]
        error = f"{1e3 * scores['depth_median_error_m']:.1f} mm"
        table.add_row(name, *rates, error, f"{scores['seconds_per_frame']:.2f}")
    Console().print(table)


def print_scores(result: "xr.Dataset", measurement: "Measurement") -> None:
    """Print the rates of one result against the truth in its measurement."""
    from cmtof.evaluation import score, scored_pixels

    scores = score(scored_pixels(result, measurement))
    print(
        f"δ<1 {scores['delta_lt_1']:.1%}  δ<2 {scores['delta_lt_2']:.1%}  "
        f"δ<3 {scores['delta_lt_3']:.1%}  δ≥10 {scores['delta_ge_10']:.1%}  "
        f"consistent {scores['consistent_lt_1']:.1%}  "
        f"median error {1e3 * scores['depth_median_error_m']:.1f} mm"
    )


def print_render_costs(done: "list[Done]") -> None:
    """Print what rendering cost, in seconds of one core."""
    build, views, write = (
        sum(getattr(one, f"{part}_s") for one in done) for part in ("build", "views", "write")
    )
    parts = f"rooms and their light {build:.1f}, views {views:.1f}, writing {write:.1f}"
    print(f"seconds of one core: {parts}")


def write_json(path: Path, content: Any) -> None:
    """Write JSON, whole or not at all."""
    from cmtof.files import written_whole

    with written_whole(path) as part:
        part.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def describe(file: Path) -> None:
    """Print what a measurement, a result or a frame holds."""
    from cmtof.measurement import Measurement, open_measurement, read_dataset
    from cmtof.scenes.frame import embedded_frames, read_npz

    file = embedded_frames().get(str(file), file)
    if file.suffix == ".npz" and file.is_file():
        for name, array in read_npz(file).items():
            print(f"  {name} {array.shape} {array.dtype}")
        return
    if file.suffix == ".nc" and file.is_file():
        dataset = read_dataset(file)
        if "wrap_count" not in dataset:
            print(repr(Measurement(dataset)))
    else:
        dataset = open_measurement(file).dataset
    for name, variable in dataset.variables.items():
        sizes = ", ".join(f"{dim} {size}" for dim, size in variable.sizes.items())
        print(f"  {name} ({sizes}) {variable.dtype} {variable.attrs.get('units', '')}".rstrip())
    for key, value in dataset.attrs.items():
        print(f"  {key}: {value}")
