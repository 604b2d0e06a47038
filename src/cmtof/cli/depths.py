"""Commands that turn measurements into depth, and compare methods."""

import json
import os
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from cmtof.cli.options import File, Options
from cmtof.files import atomic_output, check_output
from cmtof.terminal import complain, error_line, print_table, progress, say

if TYPE_CHECKING:
    from cmtof.types import Fields, Texts, Values


def unwrap(
    measurement: list[Path],
    output: Path,
    ply: File = None,
    quiet: bool = False,
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
    if several and not output.exists():
        output.mkdir()
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
            complain(f"left out {path.name}. {error_line(error)}")
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
    valid = 0.0
    for share, opened, result in unwrap_file(path, target, **how):
        kept = result.depth.notnull().to_numpy()
        valid += share * kept.mean()
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
            say(f"{ply}: {points} points")
        advance(path.name, share)
    row = {"file": path.name, "valid": f"{valid:.1%}"}
    return row | _rates(tally.score()) if tally.frames else row


def evaluate(
    frames: list[str],
    method: str = "all",
    json_file: File = None,
    quiet: bool = False,
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
    found = Frames([one for name in frames for one in frames_in(name, **reading)])
    evaluation = Evaluation(names, **conditions)
    with progress(len(found.sources) * len(names), quiet) as advance:
        for frame in found:
            try:
                for done in evaluation.add(frame):
                    advance(f"{frame.name}: {done}")
            except ValueError as error:  # the others go on
                found.skipped[frame.name] = str(error)
    evaluation.notes |= {f"skipped {name}": why for name, why in found.skipped.items()}
    if evaluation.frames:
        _report_scores(evaluation.report(), json_file)
    _print_missing(evaluation.missing)
    if found.skipped:
        raise ValueError(" ".join(found.skipped.values()))
    if evaluation.missing and method != "all":
        sys.exit(1)


def _print_missing(missing: Mapping[str, Exception]) -> None:
    """Print one line on stderr per failure: the methods left out because of it."""
    methods_by_line = {}
    for name, error in missing.items():
        methods_by_line.setdefault(error_line(error), []).append(name)
    for line, names in methods_by_line.items():
        complain(f"left out {', '.join(names)}. {line}")


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
        say(f"{name}: {remark}")


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
    as_json: bool = False,
) -> None:
    """List every unwrapping method with its source and state.

    The state is its kind, or how far its network is trained, and then with the share of right wraps
    in its validation.
    """
    from cmtof.methods import DEFAULT, METHODS

    keys = ("kind", "source", "summary", "frequencies", "tones", "knows_truth")
    rows = [
        {
            "name": name,
            "state": entry.state(),
            "validation": entry.validation,
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
    head = ("name", "state", "right", "summary", "source")
    print_table("", [{key: row[key] for key in head} for row in rows])
    print(f"Default: {DEFAULT}. State: kind, or of weights for the released protocol.")
    print(
        "Right: share of right wraps on validation views by the network alone, from its card."
    )


PICTURES = (".png", ".pdf", ".svg", ".jpg")


def replicate(
    output: Path = Path("build/replicate/fig10_comparison.png"),
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
        say(outcome)
        failed += not outcome.passed
    say(f"{output}: Fig. 10, {'drawn' if output.is_file() else 'needs cmtof[plot]'}")
    if failed:
        raise ValueError(
            f"Expected every line to pass, got {failed} FAIL. Compare versions (cmtof info)."
        )
