"""Count Table 1 over all test frames and store the counts where its chapter finds them.

    python tools/table1.py [WORKERS] [released|full]

About fifteen seconds a frame on one core. The rates are also written into the cards of the weights.
The chapter shows protocol ``released``; counts of ``full`` go into the cards alone.
"""

import os
import sys
import time
from pathlib import Path

STORE = Path(__file__).resolve().parents[1] / "book" / "results" / "table1.json"


def main(workers: int = 1, protocol: str = "released") -> int:
    """Count and store; return the exit code."""
    # one thread a process: each has its own frames; said before NumPy and torch are loaded
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    from cmtof.network.ablation import found_rows
    from cmtof.network.weights import write_card
    from cmtof.tally import Contest, count_all, rates, write_tally

    rows = found_rows(protocol)
    weights = {r.label: (r.card["model"], str(r.path)) for r in rows}
    contest = Contest(protocol=protocol, weights=weights)  # type: ignore[arg-type]
    print(f"{contest.size} frames: {', '.join(contest.methods)}", file=sys.stderr)
    started, records = time.time(), []
    for record in count_all(contest, workers=workers):
        records.append(record)
        spent = time.time() - started
        print(f"{len(records)} {record['frame']} {spent:.0f} s", file=sys.stderr, flush=True)
    for label in contest.methods:
        print(label, {name: round(rate, 4) for name, rate in rates(records, label).items()})
    for row in rows:
        tested = {"frames": len(records), **contest.settings(), **rates(records, row.label)}
        write_card(row.path, row.card | {"test": tested})
    if protocol == "released":
        STORE.parent.mkdir(exist_ok=True)
        write_tally(STORE, contest, records, command="python tools/table1.py")
    return 0


if __name__ == "__main__":
    sys.exit(main(*(int(word) if word.isdigit() else word for word in sys.argv[1:3])))  # type: ignore[arg-type]
