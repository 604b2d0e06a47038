"""Commands that turn measurements into depth, and compare methods."""

import json
import os
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from cmtof.cli.options import (
    File,
    Options,
    Quiet,
    conditions,
    group_options,
    output_option,
    reading,
)
from cmtof.files import atomic_output, check_output
from cmtof.terminal import error_line, escape_controls, print_table, progress

if TYPE_CHECKING:
    from cmtof.evaluation import Evaluation
    from cmtof.frame import Frames
    from cmtof.types import Fields, Texts, Values


def choice(
    method: Annotated[str, Option(help="Name out of `cmtof methods`.")] = "surfaces",
    range: Annotated[
        tuple[float, float] | None,
        Option(metavar="MIN MAX", help="Depths, m: MIN <= z < MAX."),
    ] = None,
    min_confidence: Annotated[float, Option(help="Mask pixels below, 0 to 1.")] = 0.0,
    window: Annotated[int | None, Option(help="Side of window, px (beat).")] = None,
    weights: Annotated[File, Option(help="Own .safetensors (learned methods).")] = None,
    covered: Annotated[
        File, Option(help="Scan with a covered beam: its light is taken away.")
    ] = None,
    tile: Annotated[int, Option(min=0, help="Side of tiles, px, of a large .nc.")] = 0,
) -> None:
    """Options of the unwrapping method, which a command takes through `group_options`."""


@group_options(choice)
def unwrap(
    measurement: Annotated[
        list[Path], Argument(help="Measurements .nc, .npz or *_phase.csv.")
    ],
    output: Annotated[
        Path, Option("--output", "-o", help="File, *.nc; a folder for several.")
    ],
    ply: Annotated[
        File, output_option(".ply", "--ply", text="Point cloud (camera).")
    ] = None,
    quiet: Quiet = False,
    *,
    choice: Options,
) -> None:
    """Turn correlation images into wrap count, depth and confidence.

    Prints how many wraps are right when the file holds the truth.

    Example: [bold]cmtof unwrap m.nc -o out.nc --ply cloud.ply[/bold]
    """
    from cmtof.measurement import open_measurement

    several = len(measurement) > 1
    files = {
        path: output / f"{path.stem}.nc" if several else output for path in measurement
    }
    _check_distinct(
        [*measurement, *files.values(), *filter(None, (ply, choice["covered"]))]
    )
    whole_file = not (choice["tile"] or several)
    if ply is not None and not whole_file:
        raise ValueError(
            "Expected one file without tiles for --ply, got several or --tile. Leave --ply out."
        )
    options = {name: value for name, value in choice.items() if value is not None}
    if choice["covered"]:
        options["covered"] = open_measurement(choice["covered"])
    if several:
        output.mkdir(exist_ok=True)
    for target in files.values():
        check_output(target, ".nc")
    with progress(len(files), quiet or whole_file) as advance:
        rows = _unwrap_each(files, ply, options, advance)
    if rows:
        print_table(f"method {options['method']}, into {output}", rows)
    if len(rows) < len(files):
        sys.exit(1)


def _check_distinct(paths: list[Path]) -> None:
    """Raise a ValueError if two of the inputs and outputs are the same file."""
    # also for a circle of links
    [(file, count)] = Counter(map(os.path.realpath, paths)).most_common(1)
    if count > 1:
        raise ValueError(
            f"Expected different files as inputs and outputs, got {Path(file).name} twice. "
            "Name another."
        )


def _unwrap_each(
    files: dict[Path, Path], ply: File, how: Options, advance: Callable[..., None]
) -> list["Texts"]:
    """Rows of the table, one per unwrapped file; if one of several fails, the others go on."""
    rows = []
    for path, target in files.items():
        try:
            rows.append(_unwrap_one(path, target, ply, how, advance))
        except (OSError, ValueError) as error:
            if len(files) == 1:
                raise
            line = f"cmtof: left out {path.name}. {error_line(error)}"
            print(escape_controls(line), file=sys.stderr)
    return rows


def _unwrap_one(
    path: Path,
    target: Path,
    ply: Path | None,
    how: Options,
    advance: Callable[..., None],
) -> "Texts":
    """Unwrap a file; return its row of the table: cells by title."""
    import numpy as np

    from cmtof.evaluation import Tally, scored_pixels
    from cmtof.pointcloud import write_ply
    from cmtof.unwrapping import unwrap_file

    tally = Tally()
    valid = 0
    size = 0
    for share, opened, result in unwrap_file(path, target, **how):
        kept = result.depth.notnull().to_numpy()
        valid += int(kept.sum())
        size += kept.size
        if opened.depth is not None and np.isfinite(opened.depth[kept]).any():
            tally.add(scored_pixels(result, opened))
        if ply is not None:
            points = write_ply(
                ply,
                result.depth,
                opened.camera,
                brightness=opened.amplitude[0],
                confidence=result.confidence,
            )
            print(f"{ply}: {points} points")
        advance(path.name, share)
    row = {"file": path.name, "valid": f"{valid / size:.1%}"}
    return row | _rates(tally.score()) if tally.frames else row


@group_options(conditions, reading)
def evaluate(
    frames: Annotated[
        list[str],
        Argument(
            help="Files, embedded names, folders (pairs of images, .npz, Hypersim's tests)"
        ),
    ],
    method: Annotated[
        str, Option(help="Out of `cmtof methods`, with commas, or all.")
    ] = "all",
    json_file: Annotated[
        File, output_option(".json", "--json", text="Table as JSON.")
    ] = None,
    quiet: Quiet = False,
    *,
    conditions: Options,
    reading: Options,
) -> None:
    """Compare methods on the same frames and the same noise.

    Example: [bold]cmtof evaluate still_life room --method crt,beat --json scores.json[/bold]
    """
    from cmtof.evaluation import Evaluation
    from cmtof.frame import Frames
    from cmtof.methods import names_of
    from cmtof.scenes import frames_in

    names = names_of(method, conditions["protocol"])
    sets = [Frames(frames_in(name, **reading)) for name in frames]
    evaluation = Evaluation(names, **conditions)
    with progress(sum(len(one.sources) for one in sets) * len(names), quiet) as advance:
        for one in sets:
            _add_frames(evaluation, one, advance)
    if evaluation.frames:
        _report_scores(evaluation.report(), json_file)
    _print_missing(evaluation.missing)
    if whys := [why for one in sets for why in one.skipped.values()]:
        raise ValueError(" ".join(whys))
    if evaluation.missing and method != "all":
        sys.exit(1)


def _add_frames(
    evaluation: "Evaluation", frames: "Frames", advance: Callable[[str], None]
) -> None:
    """Run every method on each frame; a frame that fails is noted, and the others go on."""
    for frame in frames:
        try:
            for done in evaluation.add(frame):
                advance(f"{frame.name}: {done}")
        except ValueError as error:
            frames.skipped[frame.name] = str(error)
    for name, why in frames.skipped.items():
        evaluation.notes[f"skipped {name}"] = why


def _print_missing(missing: Mapping[str, Exception]) -> None:
    """Print one line on stderr per failure: the methods left out because of it."""
    methods_by_line: dict[str, list[str]] = {}
    for name, error in missing.items():
        methods_by_line.setdefault(error_line(error), []).append(name)
    for line, names in methods_by_line.items():
        print(
            escape_controls(f"cmtof: left out {', '.join(names)}. {line}"),
            file=sys.stderr,
        )


def _report_scores(report: "Fields", json_file: File) -> None:
    """Write a report as JSON if a file is named, and print its table and notes."""
    if json_file is not None:
        with atomic_output(json_file) as part:
            part.write_text(json.dumps(report, indent=2) + "\n", "utf-8")
    title = (
        f"{len(report['frames'])} frame(s), protocol {report['protocol']}, "
        f"σ = {report['noise']:g}, seed {report['seed']}, {report['coverage']:.1%} scored"
    )
    rows = [
        {
            "method": name,
            **_rates(scores),
            "s/frame": f"{scores['seconds_per_frame']:.2f}",
        }
        for name, scores in report["methods"].items()
    ]
    print_table(title, rows)
    for name, remark in report["notes"].items():
        print(escape_controls(f"{name}: {remark}"))


def _rates(scores: "Values") -> "Texts":
    """Rates and median error of a method as text, by the titles of the table's columns."""
    titles = {
        "δ<1": "delta_lt_1",
        "δ<2": "delta_lt_2",
        "δ<3": "delta_lt_3",
        "δ≥10": "delta_ge_10",
        "consistent": "consistent_lt_1",
    }
    return {
        **{title: f"{scores[key]:.1%}" for title, key in titles.items()},
        "median error": f"{1e3 * scores['depth_median_error_m']:.1f} mm",
    }


def methods(
    as_json: Annotated[bool, Option("--json", help="Print JSON.")] = False,
) -> None:
    """List every unwrapping method with its kind, source and state.

    Of a trained network, with the share of right wraps in its validation.
    """
    from cmtof.methods import DEFAULT, METHODS

    keys = ("kind", "source", "summary", "frequencies", "tones", "knows_truth")
    rows = [
        {
            "name": name,
            "state": entry.state(),
            "validation": entry.validation(),
            "default": name == DEFAULT,
        }
        | {key: getattr(entry, key) for key in keys}
        for name, entry in METHODS.items()
    ]
    if as_json:
        print(json.dumps(rows, indent=2, ensure_ascii=False))
        return
    for row in rows:
        rate = row["validation"]
        row["right"] = "" if rate is None else f"{rate:.1%}"
    head = ("name", "kind", "state", "right", "summary", "source")
    print_table("", [{key: row[key] for key in head} for row in rows])
    print(f"Default: {DEFAULT}. State: of weights for the released protocol.")
    print(
        "Right: share of right wraps on validation views, by the card of the weights."
    )


PICTURES = (".png", ".pdf", ".svg", ".jpg")


def replicate(
    output: Annotated[
        Path, Option("--output", "-o", help="Where to draw Fig. 10.")
    ] = Path("build/replicate/fig10_comparison.png"),
) -> None:
    """Draw Fig. 10, and check the chain from frame to depth against stored values.

    Methods side by side on the embedded frames, in a few minutes. Ends with 1 if a line says FAIL.
    """
    from cmtof_book.replication import replicate as outcomes

    if output.suffix not in PICTURES:
        raise ValueError(
            f"Expected a picture named {', '.join(PICTURES)}, got {output.name}. Rename it."
        )
    output.parent.mkdir(parents=True, exist_ok=True)
    failed = 0
    for outcome in outcomes(output):
        print(outcome, flush=True)
        failed += not outcome.passed
    print(f"{output}: Fig. 10, {'drawn' if output.is_file() else 'needs cmtof[plot]'}")
    if failed:
        raise ValueError(
            f"Expected every line to pass, got {failed} FAIL. Compare versions (cmtof info)."
        )
