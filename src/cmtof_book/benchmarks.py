"""What each method costs: `make bench` measures it, and stores it where chapter 10 reads it.

Seconds of the processor and megabytes for 768x1024 pixels, each method in a fresh process on one
thread; memory is the peak above what the process held before (Linux).
"""

import multiprocessing
import os
from dataclasses import replace
from itertools import product
from pathlib import Path
from time import process_time

from cmtof_book import RESULTS, THREADS, Values


def cost(method: str, protocol: str) -> Values:
    """Seconds and megabytes of unwrapping one large frame; the second of two runs."""
    import cmtof
    from cmtof.evaluation import measured
    from cmtof_book.frames import SETTINGS, views

    frame = next(views(replace(SETTINGS, height=768, width=1024)))
    measurement = measured(frame, [method], protocol=protocol)[method]
    cmtof.unwrap(measurement, method=method)
    Path("/proc/self/clear_refs").write_text("5", "utf-8")  # forget the peak so far
    before = _memory("VmRSS")
    start = process_time()
    cmtof.unwrap(measurement, method=method)
    seconds = process_time() - start
    held = _memory("VmHWM") - before
    return {"seconds": round(seconds, 3), "megabytes": round(held, 1)}


def _memory(name: str) -> float:
    """A line of the process's status, MB."""
    status = Path("/proc/self/status").read_text("utf-8")
    return int(status.partition(f"{name}:")[2].split()[0]) / 1024


def main() -> None:
    """Measure every method that is ready, print and store."""
    os.environ |= dict.fromkeys(THREADS, "1")
    from cmtof import __version__
    from cmtof.methods import METHODS
    from cmtof_book.provenance import processor, write_json

    found: Values = {name: {} for name in METHODS}
    spawn = multiprocessing.get_context("spawn")
    for protocol, (name, method) in product(("released", "full"), METHODS.items()):
        if method.state(protocol) not in ("untrained", "no weights"):
            with spawn.Pool(1) as pool:
                found[name][protocol] = pool.apply(cost, (name, protocol))
            print(protocol, name, found[name], flush=True)
    held = {
        "command": "python -m cmtof_book.benchmarks",
        "version": __version__,
        "machine": f"one thread of {processor()}",
        "methods": found,
    }
    write_json(RESULTS / "methods_cost.json", held)


if __name__ == "__main__":
    main()
