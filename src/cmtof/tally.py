"""Pixels counted frame by frame, for tables over all test frames."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cmtof.baselines import find_method, wraps_in_range
from cmtof.conditions import Conditions, Measured
from cmtof.evaluation import ready_methods
from cmtof.metrics import LIMITS, scored_pixels
from cmtof.scenes.frame import Frame
from cmtof.scenes.rooms.held_out import TEST_ROOMS, held_out, held_out_frame
from cmtof.scenes.rooms.rendering import Settings
from cmtof.simulation import Protocol
from cmtof.strata import bin_of, counted, strata_of, strata_values
from cmtof.unwrapping import unwrap

Record = dict[str, Any]
"""Counts of one frame, plain values: ``frame``, ``pixels``, ``strata`` (pixels in each bin), and
``methods``: of each ``below`` (pixels with a wrap error below each of `LIMITS`), ``consistent``,
and ``strata`` (pixels right in each bin)."""


class Entry(NamedTuple):
    """A method with its options."""

    method: str
    options: Mapping[str, Any] = {}

    @property
    def weights(self) -> str:
        """File of a network's weights; empty for other methods."""
        return str(self.options.get("weights", ""))


CLASSICAL = {
    "beat 41": Entry("beat", {"window": 41}),
    "beat 81": Entry("beat", {"window": 81}),
    "crt": Entry("crt"),
}
"""What networks are held against: a formula that averages, and one that does not."""

MIDDLE = {"middle": Entry("middle")}
"""The answer that never looks at a measurement."""


@dataclass(frozen=True)
class Contest:
    """What is run on which frames: equal contests give equal counts.

    Attributes
    ----------
    entries : dict of Entry
        What takes part, by label.
    rooms : Settings
        The set whose test frames are taken.
    conditions : Conditions
        Of the simulated measurements; the noise of the k-th frame is drawn from (seed, k).
    """

    entries: Mapping[str, Entry]
    rooms: Settings = TEST_ROOMS
    conditions: Conditions = field(default_factory=Conditions)

    @property
    def size(self) -> int:
        """Number of test frames in the set."""
        return len(held_out(self.rooms))

    def frame(self, place: int) -> Frame:
        """Render the k-th test frame."""
        return held_out_frame(self.rooms, held_out(self.rooms)[place])

    def measure(self, frame: Frame, place: int) -> Measured:
        """Simulate what is measured of the k-th test frame."""
        return Measured(self.conditions, frame, place)

    def answers(self, measured: Measured) -> dict[str, xr.Dataset]:
        """What every entry says: ``wrap_count`` and ``depth`` on (y, x)."""
        return {
            label: unwrap(measured.by(entry.method), method=entry.method, **entry.options)
            for label, entry in self.entries.items()
        }

    def settings(self) -> dict[str, Any]:
        """Plain values of all but the weights and the size of the set, which may grow."""
        rooms = {k: v for k, v in asdict(self.rooms).items() if k not in ("scenes", "views")}
        return {"rooms": rooms} | self.conditions.settings()

    def weights(self) -> dict[str, str]:
        """Hash of the weights of each entry that has some."""
        return {label: hash_of(one.weights) for label, one in self.entries.items() if one.weights}


def networks(paths: Iterable[Path]) -> dict[str, Entry]:
    """Entries of trained networks, labelled by their files: ``fast-scnn.released``."""
    from cmtof.network.weights import read_card

    named = {path.name.removesuffix(".safetensors"): path for path in paths}
    return {k: Entry(read_card(p)["model"], {"weights": str(p)}) for k, p in named.items()}


def every_entry(protocol: Protocol) -> dict[str, Entry]:
    """All methods that can tell a protocol's wraps, by name, with the weights they take."""
    from cmtof.network.configuration import wraps_of
    from cmtof.network.weights import find_weights

    first, count = wraps_of(protocol)
    found = {}
    for name in ready_methods(protocol):
        model = find_method(name).model
        path = find_weights(model, first, first + count - 1) if model else None
        found[name] = Entry(name, {"weights": str(path)} if path else {})
    return found


def count(frame: Frame, measured: Measured, answers: Mapping[str, xr.Dataset]) -> Record:
    """Count the pixels of one frame, by `strata_of` its range.

    Parameters
    ----------
    frame : Frame
    measured : Measured
        Simulated from it.
    answers : dict of Dataset
        What each method says, as `cmtof.unwrap` returns it.

    Raises
    ------
    ValueError
        If there is no true depth or no scored pixel.
    """
    measurement = measured.usual
    strata = strata_of(*wraps_in_range(measurement))
    places = {
        name: bin_of(values, strata[name].edges)
        for name, values in strata_values(frame, measurement).items()
    }
    bins = {name: len(stratum.edges) - 1 for name, stratum in strata.items()}
    methods = {}
    for label, answer in answers.items():
        # its own measurement: at other frequencies the noise is another too
        scored = scored_pixels(answer, measured.by(answer.attrs["method"]))
        delta = np.abs(scored["wrap_count"].astype(int) - scored["true_count"])
        methods[label] = {
            "below": [int((delta < limit).sum()) for limit in LIMITS],
            "consistent": int((scored["consistent"] == scored["true_consistent"]).sum()),
            "strata": {n: counted(p, bins[n], delta < 1).tolist() for n, p in places.items()},
        }
    totals = {name: counted(place, bins[name]).tolist() for name, place in places.items()}
    pixels = sum(totals["wrap"])
    return {"frame": frame.name, "pixels": pixels, "strata": totals, "methods": methods}


def count_place(contest: Contest, place: int) -> Record:
    """Render, measure, unwrap and count the k-th test frame."""
    frame = contest.frame(place)
    measured = contest.measure(frame, place)
    return count(frame, measured, contest.answers(measured))


def count_all(contest: Contest, *, workers: int = 1, after: int = 0) -> Iterator[Record]:
    """Count every test frame ``after`` the first ones, in order, in one process or several."""
    places = range(after, contest.size)
    if workers == 1:
        yield from (count_place(contest, place) for place in places)
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        try:
            yield from pool.map(partial(count_place, contest), places)
        finally:
            pool.shutdown(cancel_futures=True)


# ------------------------------------------------------------------ arrays over frames


def scored(records: Sequence[Record]) -> NDArray[np.int64]:
    """Pixels of each frame (F,)."""
    return np.array([record["pixels"] for record in records])


def below(records: Sequence[Record], method: str) -> NDArray[np.int64]:
    """Pixels with a wrap error below each of `LIMITS` (4, F)."""
    return np.array([record["methods"][method]["below"] for record in records]).T


def stratum(
    records: Sequence[Record], name: str, method: str
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pixels right and pixels scored in each bin, each (B, F)."""
    right = np.array([record["methods"][method]["strata"][name] for record in records]).T
    return right, np.array([record["strata"][name] for record in records]).T


def rates(records: Sequence[Record], method: str) -> dict[str, float]:
    """Shares over all scored pixels: ``delta_lt_1`` and on to `LIMITS`, ``consistent_lt_1``."""
    whole = scored(records).sum()
    consistent = sum(record["methods"][method]["consistent"] for record in records)
    found = below(records, method).sum(axis=1) / whole
    shares = {f"delta_lt_{limit}": float(x) for limit, x in zip(LIMITS, found, strict=True)}
    return shares | {"consistent_lt_1": float(consistent / whole)}


def hash_of(path: str | Path) -> str:
    """SHA-256 of a file of weights."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()
