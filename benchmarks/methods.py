"""Seconds and memory of every unwrapping method for one large frame, each in a fresh process.

    python benchmarks/methods.py [METHOD...]

One thread, 768x1024 pixels, both protocols; the fastest of two runs, so that what is compiled or
loaded at first use is not counted. Memory is what the process holds at most during a run, above
what it held before (Linux alone tells). Results of methods that are not named are kept.
"""

import json
import multiprocessing
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

STORE = Path(__file__).resolve().parents[1] / "book" / "results" / "methods_cost.json"
SIZE = (768, 1024)
RUNS = 2


def measured(method: str, protocol: str, file: str) -> dict[str, float]:
    """Unwrap a frame; return seconds and megabytes."""
    import torch

    import cmtof
    from cmtof.conditions import Conditions, Measured

    torch.set_num_threads(1)
    conditions = Conditions(protocol=protocol)  # type: ignore[arg-type]
    measurement = Measured(conditions, cmtof.load_frame(file)).by(method)
    seconds, peaks = [], []
    for _ in range(RUNS):
        Path("/proc/self/clear_refs").write_text("5", "utf-8")  # forget the peak so far
        before, start = _memory("VmRSS"), time.perf_counter()
        cmtof.unwrap(measurement, method=method)
        seconds.append(time.perf_counter() - start)
        peaks.append(_memory("VmHWM") - before)
    return {"seconds": round(min(seconds), 3), "megabytes": round(max(peaks), 1)}


def _memory(name: str) -> float:
    """A line of the process's status, MB."""
    lines = Path("/proc/self/status").read_text("utf-8").splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith(f"{name}:")) / 1024


def render(file: str) -> None:
    """Write a large view of a test room."""
    from cmtof.scenes.rooms.held_out import TEST_ROOMS, held_out, held_out_frame
    from cmtof.scenes.rooms.rendering import Settings

    rooms = Settings(TEST_ROOMS.seed, TEST_ROOMS.scenes, height=SIZE[0], width=SIZE[1])
    held_out_frame(rooms, held_out(rooms)[1]).save(file)


def main(names: list[str]) -> int:
    """Measure, print and store; return the exit code."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[name] = "1"
    from cmtof import __version__
    from cmtof.book.provenance import processor
    from cmtof.evaluation import ready_methods
    from cmtof.files import written_whole

    held: dict[str, Any] = json.loads(STORE.read_text("utf-8")) if STORE.is_file() else {}
    found = held.get("methods", {})
    spawn = multiprocessing.get_context("spawn")
    file = f"{tempfile.mkdtemp()}/room.npz"
    render(file)
    for name in names or ready_methods("released"):
        for protocol in ("released", "full"):
            if name not in ready_methods(protocol):
                continue
            with spawn.Pool(1) as pool:
                one = pool.apply(measured, (name, protocol, file))
            found.setdefault(name, {})[protocol] = one
            print(name, protocol, one, flush=True)
    machine = f"one thread of {processor()}"
    held = {"command": "python benchmarks/methods.py", "version": __version__, "machine": machine}
    STORE.parent.mkdir(exist_ok=True)
    with written_whole(STORE) as part:
        part.write_text(json.dumps(held | {"methods": found}, indent=1) + "\n", "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
