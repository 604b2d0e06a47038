"""Count Table 1 over all test frames and store the counts where its chapter finds them.

    python tools/table1.py [WORKERS]

About fifteen seconds a frame on one core. The chapter counts a few frames again and says whether
the stored ones belong to the weights that are there.
"""

import os
import sys
import time
from pathlib import Path

STORE = Path(__file__).resolve().parents[1] / "book" / "results" / "table1.json"


def main(workers: int = 1) -> int:
    """Count and store; return the exit code."""
    # one thread a process: each has its own frames; said before NumPy and torch are loaded
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    from cmtof.network.ablation import found_rows
    from cmtof.tally import Contest, count_all, write_tally

    rows = found_rows()
    contest = Contest(weights={r.label: (r.card["model"], str(r.path)) for r in rows})
    print(f"{contest.size} frames: {', '.join(contest.methods)}", file=sys.stderr)
    started, records = time.time(), []
    for record in count_all(contest, workers=workers):
        records.append(record)
        spent = time.time() - started
        print(f"{len(records)} {record['frame']} {spent:.0f} s", file=sys.stderr, flush=True)
    STORE.parent.mkdir(exist_ok=True)
    write_tally(STORE, contest, records, command="python tools/table1.py")
    return 0


if __name__ == "__main__":
    sys.exit(main(*(int(argument) for argument in sys.argv[1:2])))
