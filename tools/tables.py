"""Count a table over all test frames and store the counts where its chapter finds them.

    python tools/tables.py TABLE [--protocol released|full] [--noise SIGMA] [--workers N]

Table 1: the rows of the ablation, from fifteen seconds a frame on one core; their rates are also
written into the cards of the weights. Table 2: every method, about a minute a frame. A run that was
stopped goes on where it was; so does one with more rooms.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

RESULTS = Path(__file__).resolve().parents[1] / "book" / "results"


def parsed() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("table", choices=("1", "2"))
    parser.add_argument("--protocol", default="released", choices=("released", "full"))
    parser.add_argument("--noise", type=float, default=1200.0, help="Gaussian sigma, counts")
    parser.add_argument("--workers", type=int, default=1)
    return parser.parse_args()


def main() -> int:
    """Count and store; return the exit code."""
    given = parsed()
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
    stem = f"table{given.table}" + f"_{given.protocol}_{given.noise:g}" * (given.table == "2")
    records = counted(contest, RESULTS / f"{stem}.json.part", given.workers)
    for label in contest.entries:
        print(label, {name: round(rate, 4) for name, rate in tally.rates(records, label).items()})
    for row in rows:
        write_test(row, contest, records)
    if given.table == "2" or given.protocol == "released":
        command = f"python tools/tables.py {' '.join(sys.argv[1:])}"
        tally.write_tally(RESULTS / f"{stem}.json", contest, records, command=command)
    (RESULTS / f"{stem}.json.part").unlink()
    return 0


def counted(contest, part: Path, workers: int) -> list:  # type: ignore[no-untyped-def]
    """Counts of all frames; each is kept in ``part`` as soon as it is there."""
    from cmtof.tally import count_all

    part.parent.mkdir(exist_ok=True)
    key = json.dumps([contest.settings(), contest.weights(), list(contest.entries)])
    lines = part.read_text("utf-8").splitlines() if part.is_file() else []
    done = [json.loads(line) for line in lines[1:]] if lines[:1] == [key] else []
    print(f"{contest.size} frames, {len(done)} done: {', '.join(contest.entries)}", file=sys.stderr)
    records, started = list(done), time.time()
    with part.open("w", encoding="utf-8") as file:
        file.write("\n".join([key, *map(json.dumps, done)]) + "\n")
        for record in count_all(contest, workers=workers, after=len(done)):
            records.append(record)
            file.write(json.dumps(record) + "\n")
            file.flush()
            spent = time.time() - started
            print(f"{len(records)} {record['frame']} {spent:.0f} s", file=sys.stderr, flush=True)
    return records


def write_test(row, contest, records) -> None:  # type: ignore[no-untyped-def]
    """Write the rates of one row into its card."""
    from cmtof.network.weights import write_card
    from cmtof.tally import rates

    tested = {"frames": len(records), **contest.settings(), **rates(records, row.label)}
    write_card(row.path, row.card | {"test": tested})


if __name__ == "__main__":
    sys.exit(main())
