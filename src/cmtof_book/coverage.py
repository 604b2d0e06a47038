"""Sets of wraps by split conformal prediction over rooms, and how often they hold the true one.

    python -m cmtof_book.coverage

A pixel of confidence c has the set of wraps up to q (1 - c) / c from its own. Here q is computed
from rooms of one seed, for `cmtof.estimate.SETS`, and the sets are counted on rooms of another, on
uneven ones, and on scans of `cmtof_book.scanned`, in the same folder. Everything is simulated.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter

from cmtof import __version__, simulate, unwrap
from cmtof.constants import FREQUENCIES
from cmtof.correlation import wrap_length
from cmtof.estimate import SETS
from cmtof.evaluation import COVERAGE, scored_pixels
from cmtof.frame import Frame
from cmtof.measurement import Measurement
from cmtof.simulation import staged_depth
from cmtof.statistics import conformal_quantile
from cmtof.types import Array, Fields, Values
from cmtof_book import RESULTS
from cmtof_book.counts import Counts, counts_of
from cmtof_book.scanned import SHOWN, kept_scan
from cmtof_rooms.held_out import views

EVERY = 16  # pixels, of which one counts in the calibration

# Options of the simulation.
CONDITIONS: dict[str, Fields] = {
    "released, σ = 300": {"noise": 300.0},
    "released, σ = 1200": {"noise": 1200.0},
    "released, σ = 2000": {"noise": 2000.0},
    "full, σ = 1200": {"protocol": "full"},
}
# Whether walls have waves of 0.02 to 0.3 wraps, 8 to 50 px wide, or 0.12 wraps a pixel.
UNEVEN = {"released, σ = 1200, waves": True, "released, σ = 1200, rough": False}
SCANS = {"scans, photon": "photon", "scans, captures": "captures"}  # and their noise
# Conditions under which the sets of a method are counted.
CHECKED = {
    "surfaces": (*CONDITIONS, *UNEVEN, *SCANS),
    "hybrid": ("released, σ = 1200", "full, σ = 1200"),
}


def calibrate_sets() -> Values:
    """Half-widths of the sets over the odds against a pixel's wraps."""
    frames = [*islice(views(301, tested=False), 80)]
    seen = zip(*(measurements(one, frames) for one in CONDITIONS), strict=True)
    scores = [np.concatenate([*map(scores_of, room)]) for room in seen]
    return {name: conformal_quantile(scores, int(name[-2:]) / 100) for name in SETS}


def scores_of(measurement: Measurement) -> Array:
    """Wraps off over the odds against a pixel's wraps."""
    pixels = scored_pixels(unwrap(measurement), measurement)
    off = np.abs(pixels["wrap_count"] - pixels["true_count"])[::EVERY]
    sure = pixels["confidence"][::EVERY]
    return off * sure / (1 - sure)


def with_uneven_walls(frame: Frame, number: int, waves: bool) -> Frame:
    """The frame as the released protocol scales it, with uneven walls."""
    rng = np.random.default_rng(number)
    tones = np.array(FREQUENCIES)
    depth = staged_depth(frame.depth, protocol="released", frequencies=tones)[0]
    off = rng.standard_normal(depth.shape)
    size = 0.12
    if waves:
        size, width = np.exp(rng.uniform(*np.log([(0.02, 8.0), (0.3, 50.0)])))
        off = gaussian_filter(off, width / 2)
    return replace(frame, depth=depth + wrap_length(tones[0]) * size / off.std() * off)


def measurements(condition: str, frames: Iterable[Frame]) -> Iterator[Measurement]:
    """What is seen under a condition: scans, or rooms."""
    if condition in SCANS:
        yield from (kept_scan(name, SCANS[condition]) for name in SHOWN)
        return
    for number, frame in enumerate(frames):
        if condition in UNEVEN:
            frame = with_uneven_walls(frame, number, UNEVEN[condition])
        yield simulate(frame, frame_number=number, **CONDITIONS.get(condition, {}))


def coverage_means(method: str, seen: Iterable[Measurement]) -> Fields:
    """Means over rooms of the shares right and covered and of the wraps in a set; their errors."""
    counts = pd.DataFrame(counts_of(seen, method=method))
    counts["right"] = counts["below"].str[0]
    shares = counts[["right", *COVERAGE]].div(counts["pixels"], axis=0)
    return {
        "rooms": len(shares),
        "means": shares.mean().to_dict(),
        "errors": shares.sem().to_dict(),  # pyright: ignore[reportAttributeAccessIssue]
    }


def main() -> None:
    """Compute what is missing, and store it."""
    counts = Counts(RESULTS / "coverage.json")
    counts.store(command="python -m cmtof_book.coverage", version=__version__)
    counts.keep("half-widths", of=calibrate_sets)
    frames = [*islice(views(613, tested=False), 40)]
    for method, conditions in CHECKED.items():
        for one in conditions:
            counts.keep(
                "checked",
                method,
                one,
                of=partial(coverage_means, method, measurements(one, frames)),
            )


if __name__ == "__main__":
    main()
