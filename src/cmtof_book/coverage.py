"""Sets of wraps, how often they hold the true one, and what each step of `surfaces` is worth.

    python -m cmtof_book.coverage

A pixel of confidence c has the set of wraps up to q (1 - c) / c from its own. Here q is computed
from rooms of one seed, for `cmtof.estimate.SETS`, and the sets are counted on rooms of another, on
uneven ones, and on scans of `cmtof_book.scanned`; ``coverage.yml`` lists all conditions. Under some
of these, steps of `surfaces` are left out in turn. Everything is simulated.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter

from cmtof import simulate, unwrap
from cmtof.constants import FREQUENCIES
from cmtof.correlation import wrap_length
from cmtof.estimate import SETS
from cmtof.evaluation import COVERAGE, scored_pixels
from cmtof.frame import Frame
from cmtof.measurement import Measurement
from cmtof.simulation import staged_depth
from cmtof.statistics import conformal_quantile
from cmtof.surfaces.method import STEPS
from cmtof.types import Array, Fields, Values
from cmtof_book import RESULTS, package_data
from cmtof_book.counts import Counts, counts_of
from cmtof_book.scanned import SHOWN, kept_scan
from cmtof_rooms.held_out import views

CONDITIONS = package_data("coverage")


def calibrate_sets() -> Values:
    """Half-width of each set of `SETS` over the odds against a pixel's own wrap, from 80 views."""
    frames = [*islice(views(301, tested=False), 80)]
    chosen = [name for name, one in CONDITIONS.items() if one.get("calibrates")]
    seen = zip(*(measurements(name, frames) for name in chosen), strict=True)
    scores = [np.concatenate([*map(scores_of, room)]) for room in seen]
    return {name: conformal_quantile(scores, int(name[-2:]) / 100) for name in SETS}


def scores_of(measurement: Measurement) -> Array:
    """Wraps off (N,), over the odds against a pixel's own wrap, of every 16th scored pixel."""
    pixels = scored_pixels(unwrap(measurement), measurement)
    off = abs(pixels["wrap_count"] - pixels["true_count"])
    sure = pixels["confidence"]
    return (off * sure / (1 - sure))[::16]


def with_uneven_walls(frame: Frame, number: int, kind: str) -> Frame:
    """The frame as the released protocol scales it, with walls that are rough or have waves."""
    rng = np.random.default_rng(number)
    tones = np.array(FREQUENCIES)
    depth = staged_depth(frame.depth, protocol="released", frequencies=tones)[0]
    off = rng.standard_normal(depth.shape)
    size = 0.12
    if kind == "waves":
        size, width = np.exp(rng.uniform(*np.log([(0.02, 8.0), (0.3, 50.0)])))
        off = gaussian_filter(off, width / 2)
    return replace(frame, depth=depth + wrap_length(tones[0]) * size / off.std() * off)


def measurements(name: str, frames: Iterable[Frame]) -> Iterator[Measurement]:
    """Measurements under a condition: of the frames or of scanned scenes."""
    condition = CONDITIONS[name]
    if "scans" in condition:
        yield from (kept_scan(scene, condition["scans"], seed=0) for scene in SHOWN)
        return
    for number, frame in enumerate(frames):
        if "uneven" in condition:
            frame = with_uneven_walls(frame, number, condition["uneven"])
        if not condition.get("camera", True):
            frame = replace(frame, camera=None)
        options = condition.get("simulated", {})
        yield simulate(frame, frame_number=number, **options)


def shares(seen: Iterable[Measurement], **how: Any) -> Fields:
    """Shares of pixels right or covered, and mean wraps in a set, of each measurement, by name."""
    counts = pd.DataFrame(counts_of(seen, **how))
    counts["right"] = counts["below"].str[0]
    return (
        counts.filter(["right", *COVERAGE])
        .div(counts["pixels"], axis=0)
        .to_dict("list")
    )


def main() -> None:
    """Compute what is missing, and store it."""
    counts = Counts(RESULTS / "coverage.json")
    counts.keep(["half-widths"], calibrate_sets)
    frames = [*islice(views(613, tested=False), 40)]
    for name, condition in CONDITIONS.items():
        for method in condition["methods"]:
            seen = measurements(name, frames)
            counts.keep(("checked", method, name), shares, seen, method=method)
        for step in STEPS if condition.get("ablated") else ():
            seen = measurements(name, frames)
            counts.keep(("without", step, name), shares, seen, without={step})


if __name__ == "__main__":
    main()
