"""How fast the hot paths are, as ratios taken in one run, and what each method costs: `make bench`.

Machines are noisy and differ, so no time is judged alone: each hot path stands beside the least
that its data demand (a copy of them, or the drawing of their random numbers). With ``--store`` the
processor's seconds and megabytes of every method for 768x1024 pixels, each in a fresh process on
one thread, go where chapter 10 reads them; memory is the peak above what the process held before
(Linux).
"""

import os
import sys
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from time import process_time
from timeit import repeat
from typing import Any

import numpy as np

from cmtof.types import Fields
from cmtof_book import RESULTS, THREADS


def seconds(work: Callable[[], object], repeats: int = 20) -> float:
    """Median time of a call, s, once caches and the memory allocator have settled."""
    return median(repeat(work, number=1, repeat=repeats)[repeats // 4 :])


def large_frame() -> Any:
    """A view of a test room in the paper's size, 768 x 1024 px."""
    from cmtof_rooms.held_out import SETTINGS, view_across

    return view_across(9, replace(SETTINGS, height=768, width=1024))


def ratios() -> None:
    """Print the time of decoding over a copy's, of simulating over that of drawing its noise."""
    from cmtof.correlation import decode
    from cmtof.simulation import QUADRATURES, simulate

    rng = np.random.default_rng(0)
    simulated = partial(simulate, large_frame(), protocol="full")
    stack = simulated().dataset["correlation"].to_numpy()
    fast = seconds(lambda: decode(stack, QUADRATURES))
    print(
        f"decode (2, 4, 768, 1024) float32 / copy: {fast / seconds(stack.copy):.2f}, goal < 4"
    )
    mean = simulated(noise_free=True).dataset["correlation"].to_numpy()

    def draw() -> None:
        rng.poisson(mean)
        rng.standard_normal(mean.shape, dtype=np.float32)

    whole = seconds(simulated, 4)
    print(
        f"simulate / drawing its random numbers: {whole / seconds(draw, 4):.2f}, goal < 1.5"
    )


def cost(method: str, protocol: str) -> Fields:
    """Seconds and megabytes of unwrapping one large frame; the second of two runs."""
    from cmtof import unwrap
    from cmtof.evaluation import measure_frame

    measurement = measure_frame(large_frame(), [method], protocol=protocol)[method]
    unwrap(measurement, method=method)
    Path("/proc/self/clear_refs").write_text("5", "utf-8")  # forget the peak so far
    before = _memory("VmRSS")
    start = process_time()
    unwrap(measurement, method=method)
    return {
        "seconds": round(process_time() - start, 3),
        "megabytes": round(_memory("VmHWM") - before, 1),
    }


def _memory(name: str) -> float:
    """Memory of this process, MB, by the name of a line in ``/proc/self/status``."""
    status = Path("/proc/self/status").read_text("utf-8")
    return int(status.partition(f"{name}:")[2].split()[0]) / 1024


def store() -> None:
    """Print and store the `cost` of every method that is ready."""
    os.environ |= dict.fromkeys(THREADS, "1")
    from cmtof import __version__
    from cmtof.methods import names_of
    from cmtof_book.provenance import processor, write_json

    found = defaultdict(dict)
    for protocol in ("released", "full"):
        for name in names_of("all", protocol):
            with get_context("spawn").Pool(1) as pool:
                found[name][protocol] = pool.apply(cost, (name, protocol))
            print(protocol, name, found[name], flush=True)
    write_json(
        RESULTS / "methods_cost.json",
        {
            "command": "python -m cmtof_book.benchmarks --store",
            "version": __version__,
            "machine": f"one thread of {processor()}",
            "methods": found,
        },
    )


if __name__ == "__main__":
    ratios()
    if "--store" in sys.argv:
        store()
