"""What an unwrapping method is: a measurement goes in, a depth and how sure it is come out."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from inspect import Parameter, signature
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.correlation import wrap_length
from cmtof.measurement import Measurement


class Estimate(NamedTuple):
    """What a method says of each pixel."""

    depth: NDArray[np.floating]
    """Best depth (H, W), m, anywhere; it need not agree with the measured phase."""
    confidence: NDArray[np.floating]
    """Probability in [0, 1] that the wrap is right (H, W)."""


@dataclass(frozen=True)
class Method:
    """An unwrapping method by name.

    Attributes
    ----------
    name, kind, source, summary : str
        Kind is classical, learned, trivial or oracle; source is whom to cite.
    where : str
        ``module:function``, imported on first use.
    frequencies : int
        Modulation frequencies that it needs.
    model : str
        Of a learned method: whose weights it takes, out of `cmtof.network.configuration.MODELS`.
    options : dict
        Passed on to the function unless given otherwise.
    tones : tuple of float
        Frequencies, Hz, to measure a frame with, where the prototype's do not serve.
    knows_truth : bool
        Reads the true depth, so that it is no method but a mark to measure others by.
    """

    name: str
    kind: str
    source: str
    summary: str
    where: str
    frequencies: int = 2
    model: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)
    tones: tuple[float, ...] = ()
    knows_truth: bool = False

    def __call__(self, measurement: Measurement, **options: Any) -> Estimate:
        """Run the method; raise a ValueError if the measurement lacks what it needs."""
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
        module, function = self.where.split(":")
        learned = {"model": self.model} if self.model else {}
        run = getattr(import_module(module), function)
        known = signature(run).parameters
        if not any(one.kind is Parameter.VAR_KEYWORD for one in known.values()):
            for option in options:
                if option not in known:
                    raise ValueError(
                        f"Expected options that method {self.name} knows, got {option}. Leave it "
                        "out or choose another method."
                    )
        return run(measurement, **learned, **{**self.options, **options})

    def ready(self, first: int, last: int) -> bool:
        """Whether nothing is missing to tell the wraps first to last: a method's weights may."""
        if not self.model:
            return True
        from cmtof.network.weights import find_weights

        try:
            find_weights(self.model, first, last)
        except ValueError:
            return False
        return True


def wraps_in_range(measurement: Measurement) -> tuple[int, int]:
    """First and last wrap of the lowest frequency with a depth in ``min <= z < max``."""
    low, high = np.asarray(measurement.range) / wrap_length(measurement.frequencies[0])
    # limits that are whole wraps but for rounding belong to the wrap that they begin
    return int(np.floor(low + 1e-9)), int(np.ceil(high - 1e-9)) - 1


def within_range(depth: NDArray[np.floating], measurement: Measurement) -> NDArray[np.floating]:
    """Clip depths, m, into ``min <= z < max``."""
    low, high = measurement.range
    return np.clip(depth, low, np.nextafter(high, low))
