"""Every unwrapping method by name: its function, where it comes from, and what state it is in."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from inspect import signature
from pathlib import Path
from typing import Any

from cmtof.baselines import Estimate, crt, kde, mrf, references, region, trivial
from cmtof.baselines.beat import beat, beat_guided
from cmtof.baselines.phasor import phasor
from cmtof.measurement import Measurement
from cmtof.surfaces import surfaces


@dataclass(frozen=True)
class Method:
    """An unwrapping method; ``run(measurement, **options)`` returns an `Estimate`.

    Its kind is classical, learned, trivial or reference, its source whom to cite. It needs so many
    ``frequencies``, or the ``tones``, Hz, where those of the prototype do not serve. A reference
    ``knows_truth``: it reads the true depth.
    """

    name: str
    kind: str
    source: str
    summary: str
    run: Callable[..., Estimate]
    frequencies: int = 2
    tones: tuple[float, ...] = ()
    knows_truth: bool = False

    def __call__(self, measurement: Measurement, **options: Any) -> Estimate:
        """Run the method; raise a ValueError if the measurement or an option does not fit it."""
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
        if unknown := set(options) - set(signature(self.run).parameters):
            raise ValueError(
                f"Expected options of method {self.name}, got {', '.join(sorted(unknown))}. Leave "
                "it out or choose another method."
            )
        protocol = str(measurement.dataset.attrs.get("protocol", "released"))
        if "weights" not in options and self.state(protocol) == "untrained":
            message = f"{self.name} is untrained: its card shows no gain over a trivial answer."
            warnings.warn(message, stacklevel=3)
        return self.run(measurement, **options)

    def state(self, protocol: str = "released") -> str:
        """Kind of a method without weights; else trained, untrained or no weights."""
        if self.kind != "learned":
            return self.kind
        from cmtof.network.weights import state

        return state(self.name, protocol)


def _learned(name: str, source: str, summary: str) -> Method:
    """A learned method, named as its model."""

    def run(measurement: Measurement, *, weights: str | Path | None = None) -> Estimate:
        from cmtof.network.weights import unwrap_with_network

        return Estimate(*unwrap_with_network(measurement, model=name, weights=weights))

    return Method(name, "learned", source, summary, run)


def _reference(
    what: str, run: Callable[..., Estimate], summary: str, frequencies: int = 2
) -> Method:
    name = f"reference-{what}"
    return Method(name, "reference", "", summary, run, frequencies, knows_truth=True)


_BAEK = "Baek et al. 2023"

_ALL = (
    Method("crt", "classical", "Xia and Wang 2007",
           "search over the wraps in range for the smallest remainder, pixel by pixel", crt.crt),
    Method("crt-closed-form", "classical", "Wang and Xia 2010",
           "strict Chinese remainder theorem over the full 15 m, pixel by pixel",
           crt.crt_closed_form),
    Method("crt-ml", "classical", "Wang et al. 2015",
           "search in range, both phases fused by inverse variance, pixel by pixel", crt.crt_ml),
    Method("phasor", "classical", "Gupta et al. 2015",
           "look-up of two close frequencies' phases in two stages, pixel by pixel",
           phasor, tones=(7.15e9, 7.16e9)),
    Method("kde", "classical", "Järemo Lawin et al. 2016",
           "kernel density of every wrap in range over 11x11 px, as published", kde.kde),
    Method("kde-tuned", "classical", "Järemo Lawin et al. 2016",
           "the same with kernel and window chosen on validation rooms", kde.kde_tuned),
    Method("beat", "classical", "Jongenelen et al. 2010",
           "coherent average of the 20 MHz beat over a window, nearest wrap in range", beat),
    Method("beat-guided", "classical", "He et al. 2013",
           "average of the beat that stops at edges of amplitude and of phase", beat_guided),
    Method("spatial", "classical", "Herraez et al. 2002",
           "reliability-sorted unwrapping of one frequency, its offset set to mid-range",
           region.spatial, frequencies=1),
    Method("region", "classical", "Herraez et al. 2002",
           "spatial unwrapping cut into regions, one pooled offset each", region.region),
    Method("mrf", "classical", "Hirschmüller 2008",
           "random field over wraps, its energy lowered along eight directions", mrf.mrf),
    Method("mrf-graphcut", "classical", "Bioucas-Dias and Valadão 2007",
           "the same field with a convex prior, its energy lowered by graph cuts",
           mrf.mrf_graphcut),
    Method("surfaces", "classical", "this project",
           "planes and bent surfaces in true geometry, grown, pooled and tied to each other",
           surfaces),
    _learned("u-net", "Ronneberger et al. 2015", "U-Net, narrowed: segmentation into wraps"),
    _learned("one-step", "Wang et al. 2019", "residual U-Net, narrowed: regression of depth"),
    _learned("deep-tof", "Su et al. 2018", "encoder and decoder on raw correlations, narrowed"),
    _learned("rapid", "Zhang et al. 2019", "DeepLabV3+, narrowed, its wraps mended afterwards"),
    _learned("fast-scnn", _BAEK, "the paper's network: segmentation into wraps"),
    _learned("fast-scnn-ce", _BAEK, "the paper's network, trained by cross-entropy alone"),
    _learned("fast-scnn-fourier", _BAEK, "the paper's network without phase edges"),
    _learned("fast-scnn-phase", _BAEK, "the paper's network on bare phases"),
    Method("middle", "trivial", "", "the middle of the range for every pixel",
           trivial.middle, frequencies=1),
    Method("uniform", "trivial", "", "a random wrap, all in range equally likely",
           trivial.uniform, frequencies=1),
    Method("mode", "trivial", "", "the most frequent true wrap of the image",
           trivial.mode, frequencies=1, knows_truth=True),
    _reference("depth", references.reference_depth,
               "the true depth, read against the measured phase", frequencies=1),
    _reference("offset", references.reference_offset, "true surfaces, one unknown offset each"),
    _reference("contact", references.reference_contact,
               "true bodies, across creases, one unknown offset each"),
    _reference("plane", references.reference_plane,
               "true surfaces, one unknown offset and tilt each"),
    _reference("field", references.reference_field,
               "true surfaces, seen through a window of 281 px"),
)  # fmt: skip

METHODS = {method.name: method for method in _ALL}
"""Every method by name."""

ALIASES = {"cmtof": "surfaces"} | {
    name.replace("reference", "oracle"): name for name in METHODS if name.startswith("reference")
}
"""Older names, still understood."""

DEFAULT = "surfaces"


def find_method(name: str) -> Method:
    """Method of that name or alias; a ValueError for an unknown one lists all.

    Examples
    --------
    >>> find_method("oracle-depth").name
    'reference-depth'
    """
    found = METHODS.get(ALIASES.get(name, name))
    if found is None:
        raise ValueError(f"Expected a method out of {', '.join(METHODS)}, got {name}. Choose one.")
    return found


def names_of(chosen: str, protocol: str = "released") -> list[str]:
    """Names of a comma-separated list; ``all`` is every method but references and untrained ones.

    Examples
    --------
    >>> names_of("cmtof, beat")
    ['surfaces', 'beat']
    """
    if chosen != "all":
        return list(dict.fromkeys(find_method(name.strip()).name for name in chosen.split(",")))
    left_out = ("reference", "untrained", "no weights")
    return [name for name, method in METHODS.items() if method.state(protocol) not in left_out]
