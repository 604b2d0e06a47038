"""Sets of wraps, how often they hold the true one, and what each step of `surfaces` is worth.

    python -m cmtof_book.coverage

A pixel of confidence c has the set of wraps up to q (1 - c) / c from its own. Here q is computed
from rooms of one seed, for `cmtof.estimate.SETS`, and the sets are counted on rooms of another, on
uneven ones, and on scans of `cmtof_book.scanned`, in the same folder. On some of these, steps of
`surfaces` are left out in turn. Everything is simulated.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice, product
from typing import Any

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
from cmtof.surfaces.method import STEPS
from cmtof.types import Array, Fields, Values
from cmtof_book import RESULTS
from cmtof_book.counts import Counts, counts_of
from cmtof_book.scanned import SHOWN, kept_scan
from cmtof_rooms.held_out import views

# Options of the simulation; the first four calibrate.
CONDITIONS: dict[str, Fields] = {
    "released, σ = 300": {"noise": 300.0},
    "released, σ = 1200": {"noise": 1200.0},
    "released, σ = 2000": {"noise": 2000.0},
    "full, σ = 1200": {"protocol": "full"},
    "full, σ = 1200, camera unknown": {"protocol": "full"},
    "full, σ = 1200, 10 mrad off": {"protocol": "full", "phase_offset": (0.0, 0.01)},
}
# Whether walls have waves of 0.02 to 0.3 wraps, 8 to 50 px wide, or 0.12 wraps a pixel.
UNEVEN = {
    "released, σ = 1200, waves": True,
    "released, σ = 1200, waves, camera unknown": True,
    "released, σ = 1200, rough": False,
}
SCANS = {"scans, photon": "photon", "scans, captures": "captures"}  # and their noise
USUAL = ("released, σ = 1200", "full, σ = 1200")
# Conditions under which the sets of a method are counted.
CHECKED = {
    "surfaces": (*CONDITIONS, *UNEVEN, *SCANS),
    "hybrid": USUAL,
    "reference-contact": (*USUAL, *UNEVEN),
}
ABLATED = (
    *USUAL,
    "full, σ = 1200, 10 mrad off",
    "released, σ = 1200, waves",
    "scans, captures",
)


def calibrate_sets() -> Values:
    """Half-width of each set of `SETS` over the odds against a pixel's own wrap, from 80 views."""
    frames = [*islice(views(301, tested=False), 80)]
    seen = zip(*(measurements(one, frames) for one in [*CONDITIONS][:4]), strict=True)
    scores = [np.concatenate([*map(scores_of, room)]) for room in seen]
    return {name: conformal_quantile(scores, int(name[-2:]) / 100) for name in SETS}


def scores_of(measurement: Measurement) -> Array:
    """Wraps off (N,), over the odds against a pixel's own wrap, of every 16th scored pixel."""
    pixels = scored_pixels(unwrap(measurement), measurement)
    off = np.abs(pixels["wrap_count"] - pixels["true_count"])
    sure = pixels["confidence"]
    return (off * sure / (1 - sure))[::16]


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
    """Measurements under a condition: of the frames or, for `SCANS`, of scanned scenes."""
    if condition in SCANS:
        yield from (kept_scan(name, SCANS[condition]) for name in SHOWN)
        return
    for number, frame in enumerate(frames):
        if condition in UNEVEN:
            frame = with_uneven_walls(frame, number, UNEVEN[condition])
        seen = simulate(frame, frame_number=number, **CONDITIONS.get(condition, {}))
        if "unknown" in condition:
            seen = Measurement(seen.dataset.drop_vars("camera"))
        yield seen


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
    counts.store(command="python -m cmtof_book.coverage", version=__version__)
    counts.keep("half-widths", of=calibrate_sets)
    frames = [*islice(views(613, tested=False), 40)]
    for method, conditions in CHECKED.items():
        for one in conditions:
            seen = measurements(one, frames)
            of = partial(shares, seen, method=method)
            counts.keep("checked", method, one, of=of)
    for one, step in product(ABLATED, STEPS):
        seen = measurements(one, frames)
        counts.keep("without", step, one, of=partial(shares, seen, without={step}))


if __name__ == "__main__":
    main()
