"""Comparison of methods on the same frames and the same noise, in bounded memory."""

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cmtof.correlation import consistent_wrap_count, wrap_count_from_depth
from cmtof.estimate import wraps_in_range
from cmtof.files import AnyPath
from cmtof.measurement import Measurement
from cmtof.methods import find_method
from cmtof.scenes import Frame
from cmtof.simulation import simulate
from cmtof.statistics import Interval, ratio_interval
from cmtof.types import Fields, Named, Numbers, Texts, Values
from cmtof.unwrapping import unwrap

Pixels = Mapping[str, NDArray]  # arrays (P,) by name

LIMITS = (1, 2, 3, 10)  # wraps off below which pixels are counted, Tables 1 to 3

COVERAGE = ("covered_90", "covered_95", "wraps_in_90", "wraps_in_95")

_EDGES = np.geomspace(1e-7, 1e2, 18_001)  # of depth errors, m, 0.12 % apart: medians


def scored_pixels(result: xr.Dataset, measurement: Measurement) -> Pixels:
    """Result and truth of the P valid, unwrapped pixels with a known depth: arrays (P,) by name.

    ``wrap_count``, ``true_count`` (the paper's floor), ``consistent``, ``true_consistent`` (the
    wraps that turn the measured phase into depth), ``depth_error`` (m), ``confidence``; of sets of
    wraps ``covered_90`` (whether they hold the true one) and ``wraps_in_90`` (how many they hold),
    and as of 95. Raises a ValueError if the measurement holds no true depth or no valid pixel.
    """
    truth = measurement.depth
    if truth is None:
        raise ValueError(
            "Expected a measurement with its true depth, got none. Simulate one."
        )
    scored = measurement.mask & np.isfinite(truth)
    scored &= result["wrap_count"].to_numpy() >= 0
    if not scored.any():
        raise ValueError(
            "Expected at least one scored pixel, got none. Check mask and range."
        )

    def of_result(name: str) -> NDArray:
        return result[name].to_numpy()[scored]

    frequency = measurement.frequencies[0]
    depth = truth[scored].astype(float)
    phase = measurement.phase[0][scored]
    estimate = of_result("depth").astype(float)
    count = of_result("wrap_count").astype(np.int64)
    true = wrap_count_from_depth(depth, frequency)
    sets = {}
    for level in ("90", "95") if "within_90" in result else ():
        half_width = of_result(f"within_{level}")
        ends = np.clip(
            [count - half_width, count + half_width], *wraps_in_range(measurement)
        )
        sets[f"covered_{level}"] = abs(count - true) <= half_width
        sets[f"wraps_in_{level}"] = np.ptp(ends, axis=0) + 1
    return sets | {
        "wrap_count": count,
        "true_count": true,
        "consistent": consistent_wrap_count(estimate, phase, frequency),
        "true_consistent": consistent_wrap_count(depth, phase, frequency),
        "depth_error": estimate - depth,
        "confidence": of_result("confidence"),
    }


class Tally:
    """Counts of one method's right and wrong wraps: a few numbers per frame, in bounded memory."""

    def __init__(self) -> None:
        self.frames: list[Fields] = []
        self.seconds = 0.0
        self._squares = 0.0
        self._confidences = 0.0
        self._errors = np.zeros(_EDGES.size + 1, np.int64)

    def add(self, pixels: Pixels) -> Fields:
        """Add the `scored_pixels` of a frame; return its counts, ``below`` each of `LIMITS`."""
        delta = abs(pixels["wrap_count"] - pixels["true_count"])
        right = pixels["consistent"] == pixels["true_consistent"]
        error = abs(pixels["depth_error"])
        self._squares += (error**2).sum()
        self._confidences += pixels["confidence"].sum(dtype=float)
        self._errors += np.bincount(
            np.searchsorted(_EDGES, error), minlength=_EDGES.size + 1
        )
        below = [int((delta < limit).sum()) for limit in LIMITS]
        counts = {"pixels": delta.size, "below": below, "consistent": int(right.sum())}
        counts |= {name: int(pixels[name].sum()) for name in COVERAGE if name in pixels}
        self.frames.append(counts)
        return counts

    def score(self) -> Values:
        """Rates and depth errors, m, over all frames, as ``cmtof evaluate`` names them."""
        whole = sum(frame["pixels"] for frame in self.frames)
        counts = [[*frame["below"], frame["consistent"]] for frame in self.frames]
        lt_1, lt_2, lt_3, lt_10, consistent = (np.sum(counts, axis=0) / whole).tolist()
        median = np.searchsorted(self._errors.cumsum(), whole / 2)
        sets = {
            name: float(
                np.mean([frame[name] / frame["pixels"] for frame in self.frames])
            )
            for name in COVERAGE
            if name in self.frames[0]
        }
        return sets | {
            "delta_lt_1": lt_1,
            "delta_lt_2": lt_2,
            "delta_lt_3": lt_3,
            "delta_ge_3": 1 - lt_3,
            "delta_ge_10": 1 - lt_10,
            "consistent_lt_1": consistent,
            "depth_rmse_m": (self._squares / whole) ** 0.5,
            "depth_median_error_m": float(_EDGES.take(median, mode="clip")),
            "mean_confidence": self._confidences / whole,
        }


def score(*frames: Pixels) -> Values:
    """Rates and depth errors, m, over the `scored_pixels` of one or more frames."""
    tally = Tally()
    for pixels in frames:
        tally.add(pixels)
    return tally.score()


def measure_frame(
    frame: Frame, methods: Iterable[str], *, number: int = 0, **conditions: Any
) -> dict[str, Measurement]:
    """Simulated measurement of a frame for each method by name, with equal noise and scored pixels.

    Methods that need other frequencies get their own measurement. ``conditions`` are options of
    `cmtof.simulation.simulate`; the noise is drawn from (seed, number).
    """
    tones = {name: find_method(name).tones for name in methods}
    simulated = partial(simulate, frame, frame_number=number, **conditions)
    measurements = {(): simulated()}
    for other in set(tones.values()) - {()}:
        found = simulated(frequencies=other)
        scored = (("y", "x"), found.mask & measurements[()].mask)
        measurements[other] = Measurement(found.dataset.assign(mask=scored))  # pyright: ignore[reportArgumentType]
    for measurement in measurements.values():
        _ = measurement.decoded  # shared, so that it counts in no method's time
    return {name: measurements[tones[name]] for name in tones}  # pyright: ignore[reportArgumentType]


class Evaluation:
    """Scores of several methods over several frames.

    Call `add` for each frame, in order; the noise of frame i is drawn from (seed, i), and every
    method sees the same. ``conditions`` are options of `cmtof.simulation.simulate`. A method that
    fails, as for want of a package, is left out and goes to ``missing``, unless all do.
    """

    def __init__(self, methods: Sequence[str], **conditions: Any) -> None:
        self.options: Fields = {}  # of every method, such as weights
        self.conditions = conditions
        self.frames: list[str] = []
        self.missing: dict[str, Exception] = {}
        self.notes: Texts = {}  # by frame
        self._tallies = {find_method(name).name: Tally() for name in methods}
        self._coverage = 0.0
        self._simulated: Named = {}  # attributes of the last measurement

    def add(self, frame: Frame) -> Iterator[str]:
        """Simulate the next frame and run every method on it, yielding each name when done."""
        measurements = measure_frame(
            frame, self._tallies, number=len(self.frames), **self.conditions
        )
        tallies = deepcopy(
            self._tallies
        )  # a frame at which every method fails counts for none
        failed = {}
        for name, measurement in measurements.items():
            start = perf_counter()
            try:
                result = unwrap(measurement, method=name, **self.options)
            except Exception as error:  # go on without it, if another is left
                failed[name] = error
                if len(failed) == len(measurements):
                    raise
            else:
                tallies[name].seconds += perf_counter() - start
                tallies[name].add(scored_pixels(result, measurement))
            yield name
        self.missing |= failed
        for name in failed:
            del tallies[name]
        self._tallies = tallies
        self.frames.append(frame.name)
        if frame.note:
            self.notes[frame.name] = frame.note
        first = next(iter(measurements.values()))
        self._simulated = first.dataset.attrs
        self._coverage += first.mask.mean()

    def add_all(self, frames: Iterable[Frame]) -> "Evaluation":
        """Run every method on every frame; return this evaluation."""
        for frame in frames:
            list(self.add(frame))
        return self

    def counts(self) -> list[Fields]:
        """One dict per frame: its name, and the counts of each method."""
        return [
            {
                "frame": name,
                "methods": {m: t.frames[i] for m, t in self._tallies.items()},
            }
            for i, name in enumerate(self.frames)
        ]

    def report(self) -> Fields:
        """Rates over all scored pixels of all frames, as ``cmtof evaluate --json`` writes them.

        Only `COVERAGE` is a mean over frames, each with the same weight.
        """
        return {
            "protocol": self._simulated["protocol"],
            "noise": self._simulated["noise_sigma"],
            "seed": self._simulated["seed"],
            "frames": self.frames,
            "notes": self.notes,
            "coverage": self._coverage / len(self.frames),
            "methods": {
                name: tally.score()
                | {"seconds_per_frame": tally.seconds / len(self.frames)}
                for name, tally in self._tallies.items()
            },
        }


def digest(counts: Sequence[Named]) -> str:
    """SHA-256 of counts as a hexadecimal string, stored beside them."""
    return hashlib.sha256(
        json.dumps(counts, sort_keys=True, ensure_ascii=False).encode()
    ).hexdigest()


def read_counts(path: AnyPath) -> list[Fields]:
    """Counts of the test frames from a file of `cmtof_book.tables`; empty without the file.

    Raises a ValueError if the counts were changed after they were written.
    """
    path = Path(path)
    if not path.is_file():
        return []
    stored = json.loads(path.read_text("utf-8"))
    if stored["sha256"] != digest(stored["frames"]):
        raise ValueError(
            f"Expected counts as written in {path}, got edited ones. Count again."
        )
    return stored["frames"]


def rates(
    counts: Sequence[Named], method: str, *, against: str = "", draws: int = 2000
) -> Interval:
    """Rates (5,) of a method over the frames of ``counts``, with 95 % intervals by bootstrap.

    δ < 1, δ < 2, δ < 3, δ ≥ 10 and consistent, less those of the method ``against``.
    """
    whole = np.array([frame["methods"][method]["pixels"] for frame in counts])

    def parts(name: str) -> Numbers:
        tallies = [frame["methods"][name] for frame in counts]
        below = np.array([one["below"] for one in tallies]).T
        return np.stack(
            [*below[:3], whole - below[3], [one["consistent"] for one in tallies]]
        )

    return ratio_interval(
        parts(method) - (parts(against) if against else 0), whole, draws=draws
    )
