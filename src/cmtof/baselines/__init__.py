"""Unwrapping methods, one a file, one signature; found by name.

A method maps a `Measurement` to an `Estimate`: the depth it believes in and how much. From that
depth `cmtof.unwrapping` derives the paper's wrap count and the one consistent with the phase.
"""

from dataclasses import dataclass
from importlib import import_module
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
    """

    name: str
    kind: str
    source: str
    summary: str
    where: str
    frequencies: int = 2
    model: str = ""

    def __call__(self, measurement: Measurement, **options: Any) -> Estimate:
        """Run the method; raise a ValueError if the measurement lacks a frequency."""
        count = measurement.frequencies.size
        if count < self.frequencies:
            raise ValueError(
                f"Expected {self.frequencies} frequencies for method {self.name}, got {count}. "
                "Measure another frequency or choose the method spatial."
            )
        module, function = self.where.split(":")
        learned = {"model": self.model} if self.model else {}
        return getattr(import_module(module), function)(measurement, **learned, **options)

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


def _network(name: str, summary: str) -> Method:
    """A learned method, named as its model."""
    where = "cmtof.network.inference:unwrap_with_network"
    return Method(name, "learned", "Baek et al. 2023", summary, where, model=name)


METHODS = {
    method.name: method
    for method in (
        Method(
            "beat",
            "classical",
            "Jongenelen et al. 2010",
            "coherent average of the 20 MHz beat over a window, nearest wrap in range",
            "cmtof.baselines.beat:beat",
        ),
        Method(
            "crt",
            "classical",
            "Xia and Wang 2007",
            "search over the wraps in range for the smallest remainder, pixel by pixel",
            "cmtof.baselines.crt:search",
        ),
        Method(
            "crt-closed-form",
            "classical",
            "Wang and Xia 2010",
            "strict Chinese remainder theorem over the full 15 m, pixel by pixel",
            "cmtof.baselines.crt:closed_form",
        ),
        Method(
            "crt-ml",
            "classical",
            "Wang et al. 2015",
            "search in range, both phases fused by inverse variance, pixel by pixel",
            "cmtof.baselines.crt:maximum_likelihood",
        ),
        Method(
            "spatial",
            "classical",
            "Herraez et al. 2002",
            "reliability-sorted unwrapping of one frequency, its offset set to mid-range",
            "cmtof.baselines.spatial:spatial",
            frequencies=1,
        ),
        _network("fast-scnn", "the paper's network: segmentation into wraps"),
        _network("fast-scnn-ce", "the paper's network, trained by cross-entropy alone"),
        _network("fast-scnn-fourier", "the paper's network without phase edges"),
        _network("fast-scnn-phase", "the paper's network on bare phases"),
        _network("fast-scnn-light", "a lighter network that is given the beat"),
    )
}

DEFAULT = "beat"


def find_method(name: str) -> Method:
    """Return the method of that name; raise a ValueError that lists them otherwise."""
    if name not in METHODS:
        raise ValueError(f"Expected a method out of {', '.join(METHODS)}, got {name}. Choose one.")
    return METHODS[name]


def wraps_in_range(measurement: Measurement) -> tuple[int, int]:
    """First and last wrap of the lowest frequency with a depth in ``min <= z < max``."""
    low, high = np.asarray(measurement.range) / wrap_length(measurement.frequencies[0])
    # limits that are whole wraps but for rounding belong to the wrap that they begin
    return int(np.floor(low + 1e-9)), int(np.ceil(high - 1e-9)) - 1


def within_range(depth: NDArray[np.floating], measurement: Measurement) -> NDArray[np.floating]:
    """Clip depths, m, into ``min <= z < max``."""
    low, high = measurement.range
    return np.clip(depth, low, np.nextafter(high, low))
