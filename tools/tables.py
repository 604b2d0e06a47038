"""Count a table over all test frames and store the counts where its chapter finds them.

    python tools/tables.py 1|2 [--protocol released|full] [--noise SIGMA] [--again METHOD...]

Table 1 holds the rows of the ablation, whose rates are also written into the cards of the weights;
Table 2 every method. Only what the stored counts lack is counted: methods that are new, that have
other weights, or that are named after ``--again``. A run that was stopped goes on where it was.
"""

import argparse
import json
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).resolve().parents[1] / "book" / "results"


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("table", choices=("1", "2"))
    parser.add_argument("--protocol", default="released", choices=("released", "full"))
    parser.add_argument("--noise", type=float, default=1200.0, help="Gaussian sigma, counts")
    parser.add_argument("--again", nargs="*", default=[], metavar="METHOD", help="count anew")
    parser.add_argument("--workers", type=int, default=1)
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Count and store; return the exit code."""
    given = parsed(arguments)
    # one thread a process: each has its own frames; said before NumPy and torch are loaded
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    from cmtof import tally
    from cmtof.conditions import Conditions
    from cmtof.network.ablation import found_rows

    rows = found_rows(given.protocol) if given.table == "1" else []
    entries = tally.networks(row.path for row in rows) | tally.CLASSICAL | tally.MIDDLE
    if given.table == "2":
        entries = tally.every_entry(given.protocol)
    conditions = Conditions(protocol=given.protocol, noise=given.noise)
    contest = tally.Contest(entries, conditions=conditions)
    stem = f"table{given.table}_{given.protocol}_{given.noise:g}"
    try:
        records = brought_up_to_date(RESULTS / f"{stem}.json", contest, given.again, given.workers)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 1
    for label in contest.entries:
        print(label, {name: round(rate, 4) for name, rate in tally.rates(records, label).items()})
    for row in rows:
        write_test(row, contest, records)
    return 0


def brought_up_to_date(
    path: Path, contest: Any, again: Sequence[str], workers: int = 1
) -> list[dict[str, Any]]:
    """Stored counts with all that they lacked, of every frame; they are written back.

    Raises
    ------
    ValueError
        If ``again`` names what does not take part, or the stored counts are of other frames.
    """
    from cmtof.stored_counts import joined, outdated, read_counts, write_counts

    if strange := set(again) - set(contest.entries):
        names = ", ".join(contest.entries)
        raise ValueError(f"Expected methods out of {names}, got {', '.join(strange)}. Choose some.")
    held = read_counts(path) if path.is_file() else None
    if held and (held["settings"] != contest.settings() or len(held["frames"]) != contest.size):
        held = None
    wanted = [*outdated(held, contest), *again] if held else list(contest.entries)
    rest = replace(contest, entries={k: v for k, v in contest.entries.items() if k in wanted})
    part = path.with_name(f"{path.name}.part")
    records = counted(rest, part, workers) if rest.entries else held["frames"] if held else []
    if held:
        records = joined(held, records, contest)
    write_counts(path, contest, records, command=f"python tools/tables.py {told(contest, path)}")
    part.unlink(missing_ok=True)
    return records


def told(contest: Any, path: Path) -> str:
    """Arguments that make a file of counts anew."""
    chosen = contest.conditions
    table = path.stem.removeprefix("table").partition("_")[0]
    return f"{table} --protocol {chosen.protocol} --noise {chosen.noise:g}"


def counted(contest: Any, part: Path, workers: int) -> list[dict[str, Any]]:
    """Counts of all frames; each is kept in ``part`` as soon as it is there."""
    from cmtof.console import progress_bar
    from cmtof.tally import count_all

    part.parent.mkdir(exist_ok=True)
    key = json.dumps([contest.settings(), contest.weights(), list(contest.entries)])
    lines = part.read_text("utf-8").splitlines() if part.is_file() else []
    records = [json.loads(line) for line in lines[1:]] if lines[:1] == [key] else []
    print(f"{contest.size} frames, {len(records)} done: {', '.join(contest.entries)}", flush=True)
    found = count_all(contest, workers=workers, after=len(records))
    left = contest.size - len(records)
    with part.open("w", encoding="utf-8") as file, progress_bar(quiet=False) as bar:
        file.write("\n".join([key, *map(json.dumps, records)]) + "\n")
        for record in bar.track(found, total=left, description="frames"):
            records.append(record)
            file.write(json.dumps(record) + "\n")
            file.flush()
    return records


def write_test(row: Any, contest: Any, records: Sequence[dict[str, Any]]) -> None:
    """Write the rates of one row into its card."""
    from cmtof.network.weights import write_card
    from cmtof.tally import rates

    tested = {"frames": len(records), **contest.settings(), **rates(records, row.label)}
    write_card(row.path, row.card | {"test": tested})


if __name__ == "__main__":
    sys.exit(main())
