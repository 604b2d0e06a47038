"""Registry of the unwrapping methods: function, source, and state of the weights, by name."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from math import isqrt
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import numpy as np

from cmtof.classical import trivial
from cmtof.classical.beat import estimate_with_beat
from cmtof.estimate import Estimate, beat_repeats, without_holes, wraps_in_range
from cmtof.files import AnyPath, read_document
from cmtof.measurement import Measurement, tiles
from cmtof.types import Fields, Named

MOST_MEMORY = (
    3 * 2**29
)  # bytes beside the measurement, about, before a method goes in tiles


@dataclass(frozen=True)
class Method:
    """An unwrapping method; ``run(measurement, **options)`` returns an `Estimate`."""

    name: str
    kind: str  # classical, learned, trivial or reference
    source: str  # whom to cite
    run: Callable[..., Estimate]
    frequencies: int = 2  # least number
    tones: tuple[float, ...] = ()  # Hz, where those of the prototype do not serve
    knows_truth: bool = False  # whether it reads the true depth
    about: str = ""
    # bytes a pixel of methods that work in tiles when memory is short, and those of each wrap
    memory: int = 0
    wrap_memory: int = 0
    network: str = ""  # whose weights it needs
    # whether its confidence assumes that the beat does not repeat within the range
    one_beat: bool = False
    sets: bool = False  # whether `cmtof.estimate.SETS` hold for its confidence

    @property
    def summary(self) -> str:
        """One line on the method: ``about``, or the first line of its function's docstring."""
        return self.about or (self.run.__doc__ or "").partition("\n")[0].rstrip(".")

    def __call__(self, measurement: Measurement, **options: Any) -> Estimate:
        """Run the method; raise a ValueError if the measurement or an option does not fit it."""
        self._check(measurement, options)
        if measurement.frequencies.size > 2:  # methods know of two
            measurement = Measurement(measurement.dataset.isel(frequency=slice(2)))
        if not measurement.mask.any():
            return trivial.middle(measurement)
        first, last = wraps_in_range(measurement)
        pixel = self.memory + self.wrap_memory * (last - first + 1)
        if pixel * measurement.mask.size <= MOST_MEMORY:
            found = self.run(measurement, **options)
        else:
            images = np.empty((2, *measurement.shape))
            side = 64 * max(
                isqrt(MOST_MEMORY // pixel) // 64 - 8, 2
            )  # and 256 around: only `rapid` sees more
            for seen, inner, place in tiles(measurement.dataset, side, 256):
                images[:, *place] = np.stack(self.run(seen, **options)[:2])[
                    :, *inner.values()
                ]
            found = Estimate(*images)  # pyright: ignore[reportArgumentType]
        repeats = beat_repeats(measurement) if self.one_beat else 1
        return found._replace(confidence=found.confidence / repeats)

    def _check(self, measurement: Measurement, options: Named) -> None:
        """Raise a ValueError if the measurement or an option does not fit the method."""
        if not options.keys() <= inspect.signature(self.run).parameters.keys():
            raise ValueError(
                f"Expected options of method {self.name}, got {', '.join(options)}. Leave them out."
            )
        count = measurement.frequencies.size
        if count < self.frequencies:
            raise ValueError(
                f"Expected {self.frequencies} frequencies for method {self.name}, got {count}. "
                "Measure another frequency or choose the method spatial."
            )
        if self.knows_truth and measurement.depth is None:
            raise ValueError(
                f"Expected a measurement with its true depth for method {self.name}, got none. "
                "Simulate one, or choose another method."
            )

    def state(self, protocol: str = "released") -> str:
        """State "trained", "untrained" or "no weights"; the kind for a method without a network."""
        if not self.network:
            return self.kind
        from cmtof.network.weights import state

        return state(self.network, protocol)

    def validation(self, protocol: str = "released") -> float | None:
        """Share of right wraps by the card of its weights; None for a method without weights."""
        from cmtof.network.weights import read_card, weights_path

        path = weights_path(self.network, protocol)
        return read_card(path).validation.delta_lt_1 if path.is_file() else None


def _network_function(model: str, *, mirrored: bool = False) -> Callable[..., Estimate]:
    """Function of the method by a network, given the network's name."""

    def run(measurement: Measurement, *, weights: AnyPath | None = None) -> Estimate:
        from cmtof.network.inference import unwrap_with_network

        filled = without_holes(measurement)  # a network was never shown any
        found = unwrap_with_network(
            filled, model=model, weights=weights, mirrored=mirrored
        )
        return estimate_with_beat(*found, measurement)

    return run


def _method(name: str, row: Fields) -> Method:
    """Method of a row of methods.yml."""
    if "run" in row:
        row["run"] = resolve_name(f"cmtof.{row['run']}")
    else:
        mirrored = row.pop("mirrored", False)
        row["run"] = _network_function(row["network"], mirrored=mirrored)
    row["tones"] = tuple(row.get("tones", ()))
    return Method(name, **row)


METHODS = {
    name: _method(name, row)
    for name, row in read_document(Path(__file__).with_name("methods.yml")).items()
}

DEFAULT = "surfaces"

# Older names, still understood.
ALIASES = {"cmtof": DEFAULT} | {
    name.replace("reference", "oracle"): name
    for name in METHODS
    if name.startswith("reference")
}


def find_method(name: str) -> Method:
    """Method of that name or alias; a ValueError for an unknown one lists all.

    >>> find_method("oracle-depth").name
    'reference-depth'
    """
    found = METHODS.get(ALIASES.get(name, name))
    if found is None:
        raise ValueError(
            f"Expected a method out of {', '.join(METHODS)}, got {name}. Choose one."
        )
    return found


def names_of(chosen: str, protocol: str = "released") -> list[str]:
    """Methods named in a comma-separated list; ``all``: all but references and untrained networks.

    >>> names_of("cmtof, beat")
    ['surfaces', 'beat']
    """
    if chosen != "all":
        return list(
            dict.fromkeys(find_method(name.strip()).name for name in chosen.split(","))
        )
    return [
        name
        for name, method in METHODS.items()
        if method.state(protocol) not in ("reference", "untrained", "no weights")
    ]
