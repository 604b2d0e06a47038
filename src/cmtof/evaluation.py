"""Methods against each other on the same frames and the same noise."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from time import perf_counter
from typing import Any

from cmtof.baselines import METHODS, find_method
from cmtof.conditions import Conditions, Measured
from cmtof.metrics import Scored, score, scored_pixels
from cmtof.scenes.frame import Frame
from cmtof.unwrapping import unwrap


def ready_methods(protocol: str = "released") -> list[str]:
    """Every method that can tell a protocol's wraps: learned ones may lack weights for it."""
    from cmtof.network.configuration import wraps_of

    first, count = wraps_of(protocol)
    return [name for name, method in METHODS.items() if method.ready(first, first + count - 1)]


class Evaluation:
    """Scores of several methods over several frames.

    Call `add` for each frame, in order; the noise of frame i is drawn from (seed, i), so that
    every method sees the same. A method that needs other frequencies gets a measurement of its own,
    of the same frame, noise and scored pixels.

    Parameters
    ----------
    methods : sequence of str
    options : dict of dict
        Of each method that shall not run with its defaults.
    **conditions
        Fields of `cmtof.conditions.Conditions`.
    """

    def __init__(
        self,
        methods: Sequence[str],
        *,
        options: Mapping[str, Mapping[str, Any]] | None = None,
        **conditions: Any,
    ) -> None:
        for name in methods:
            find_method(name)
        self.methods, self.options = methods, options or {}
        self.conditions = Conditions(**conditions)
        self._scored: dict[str, list[Scored]] = {name: [] for name in methods}
        self._seconds = dict.fromkeys(methods, 0.0)
        self._coverage: list[float] = []
        self._names: list[str] = []

    def add(self, frame: Frame) -> Iterator[str]:
        """Simulate the next frame and run every method on it, yielding each name when done."""
        taken = Measured(self.conditions, frame, len(self._names))
        self._names.append(frame.name)
        self._coverage.append(float(taken.usual.mask.mean()))
        for name in self.methods:
            measurement = taken.by(name)
            start = perf_counter()
            result = unwrap(measurement, method=name, **self.options.get(name, {}))
            self._seconds[name] += perf_counter() - start
            self._scored[name].append(scored_pixels(result, measurement))
            yield name

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
            "protocol": self.conditions.protocol,
            "noise": 0.0 if self.conditions.noise_free else float(self.conditions.noise),
            "seed": self.conditions.seed,
            "frames": self._names,
            "coverage": sum(self._coverage) / len(self._coverage),
            "methods": {
                name: score(self._scored[name])
                | {"seconds_per_frame": self._seconds[name] / len(self._names)}
                for name in self.methods
            },
        }
