"""Methods against each other on the same frames and the same noise."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines import METHODS, find_method
from cmtof.constants import FREQUENCIES, NOISE_SIGMA
from cmtof.measurement import Measurement
from cmtof.metrics import Scored, score, scored_pixels
from cmtof.scenes.rgbd import Frame
from cmtof.simulation import Protocol, simulate
from cmtof.unwrapping import unwrap


def ready_methods(protocol: str = "released") -> list[str]:
    """Every method that can tell a protocol's wraps: learned ones may lack weights for it."""
    from cmtof.network.configuration import wraps_of

    first, count = wraps_of(protocol)
    return [name for name, method in METHODS.items() if method.ready(first, first + count - 1)]


@dataclass
class Evaluation:
    """Scores of several methods over several frames.

    Call `add` for each frame, in order; the noise of frame i is drawn from (seed, i), so that
    every method sees the same. A method that needs other frequencies gets a measurement of its own,
    of the same frame, noise and scored pixels.
    """

    methods: Sequence[str]
    protocol: Protocol = "released"
    noise: float = NOISE_SIGMA
    noise_free: bool = False
    seed: int = 0
    frequencies: Sequence[float] = FREQUENCIES
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in self.methods:
            find_method(name)
        self._scored: dict[str, list[Scored]] = {name: [] for name in self.methods}
        self._seconds = dict.fromkeys(self.methods, 0.0)
        self._coverage: list[float] = []
        self._names: list[str] = []

    def add(self, frame: Frame) -> Iterator[str]:
        """Simulate the next frame and run every method on it, yielding each name when done."""
        measurement = self._measure(frame, self.frequencies)
        measured = {(): measurement}
        for name in self.methods:
            tones = find_method(name).tones
            if tones not in measured:
                measured[tones] = self._measure(frame, tones, mask=measurement.mask)
            start = perf_counter()
            result = unwrap(measured[tones], method=name, **self.options.get(name, {}))
            self._seconds[name] += perf_counter() - start
            self._scored[name].append(scored_pixels(result, measured[tones]))
            yield name
        self._names.append(frame.name)
        self._coverage.append(float(measurement.mask.mean()))

    def _measure(
        self, frame: Frame, frequencies: Sequence[float], mask: NDArray[np.bool_] | None = None
    ) -> Measurement:
        """Simulate the next frame; only pixels of a given mask are scored."""
        measurement = simulate(
            frame,
            protocol=self.protocol,
            frequencies=frequencies,
            noise=self.noise,
            noise_free=self.noise_free,
            seed=self.seed,
            frame_number=len(self._coverage),
        )
        if mask is not None:
            both = (("y", "x"), measurement.mask & mask)
            measurement = Measurement(measurement.dataset.assign(mask=both))
        _ = measurement.decoded  # shared by all methods, so no method is charged for it
        return measurement

    def add_all(self, frames: Iterable[Frame]) -> "Evaluation":
        """Run every method on every frame."""
        for frame in frames:
            for _ in self.add(frame):
                pass
        return self

    def report(self) -> dict[str, Any]:
        """Rates over all scored pixels of all frames, as ``cmtof evaluate --json`` writes them."""
        if not self._names:
            raise ValueError("Expected at least one frame, got none. Add frames first.")
        return {
            "protocol": self.protocol,
            "noise": 0.0 if self.noise_free else float(self.noise),
            "seed": self.seed,
            "frames": self._names,
            "coverage": sum(self._coverage) / len(self._coverage),
            "methods": {
                name: score(self._scored[name])
                | {"seconds_per_frame": self._seconds[name] / len(self._names)}
                for name in self.methods
            },
        }
