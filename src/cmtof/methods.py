"""Registry of the unwrapping methods: function, source, and state of the weights, by name."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from math import isqrt
from typing import Any

import numpy as np

from cmtof.classical import crt, kde, mrf, references, region, trivial
from cmtof.classical.beat import beat, estimate_with_beat
from cmtof.classical.phasor import phasor
from cmtof.estimate import Estimate, beat_repeats, without_holes, wraps_in_range
from cmtof.files import AnyPath
from cmtof.hybrid import hybrid
from cmtof.measurement import Measurement, tiles
from cmtof.surfaces import surfaces, surfaces_mirrored
from cmtof.types import Named

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
        unknown = options.keys() - inspect.signature(self.run).parameters.keys()
        if unknown:
            raise ValueError(
                f"Expected options of method {self.name}, got {', '.join(unknown)}. Leave them out."
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

    @property
    def validation(self) -> float | None:
        """Share of right wraps by the card of its released weights; None for a method without."""
        from cmtof.network.weights import read_card, weights_path

        path = weights_path(self.network, "released")
        return read_card(path).validation.delta_lt_1 if path.is_file() else None


def _network_method(
    name: str, source: str, about: str, network: str = "", **usual: bool
) -> Method:
    model = network or name

    def run(measurement: Measurement, *, weights: AnyPath | None = None) -> Estimate:
        from cmtof.network.inference import unwrap_with_network

        filled = without_holes(measurement)  # a network was never shown any
        found = unwrap_with_network(filled, model=model, weights=weights, **usual)
        return estimate_with_beat(*found, measurement)

    return Method(name, "learned", source, run, about=about, memory=1300, network=model)


_BAEK = "Baek et al. 2023"

_ALL = (
    Method("crt", "classical", "Xia and Wang 2007", crt.crt),
    Method("crt-closed-form", "classical", "Wang and Xia 2010", crt.crt_closed_form),
    Method("crt-ml", "classical", "Wang et al. 2015", crt.crt_ml),
    Method("phasor", "classical", "Gupta et al. 2015", phasor, tones=(7.15e9, 7.16e9)),
    Method(
        "kde",
        "classical",
        "Järemo Lawin et al. 2016",
        kde.kde,
        memory=400,
        wrap_memory=4,
    ),
    Method(
        "kde-tuned",
        "classical",
        "Järemo Lawin et al. 2016",
        kde.kde_tuned,
        memory=400,
        wrap_memory=4,
    ),
    Method("beat", "classical", "Jongenelen et al. 2010", beat, one_beat=True),
    Method(
        "spatial", "classical", "Herraez et al. 2002", region.spatial, frequencies=1
    ),
    Method("region", "classical", "Herraez et al. 2002", region.region, one_beat=True),
    Method(
        "mrf",
        "classical",
        "Hirschmüller 2008",
        mrf.mrf,
        memory=320,
        wrap_memory=4,
        one_beat=True,
    ),
    Method(
        "mrf-graphcut",
        "classical",
        "Bioucas-Dias, Valadão 2007",
        mrf.mrf_graphcut,
        memory=540,
        wrap_memory=4,
        one_beat=True,
    ),
    Method("surfaces", "classical", "this project", surfaces, one_beat=True, sets=True),
    Method(
        "surfaces-mirrored",
        "classical",
        "this project",
        surfaces_mirrored,
        one_beat=True,
    ),
    _network_method(
        "u-net", "Ronneberger et al. 2015", "U-Net, narrowed: segmentation into wraps"
    ),
    _network_method(
        "one-step", "Wang et al. 2019", "Residual U-Net, narrowed: regression of depth"
    ),
    _network_method(
        "deep-tof",
        "Su et al. 2018",
        "Encoder and decoder on raw correlations, narrowed",
    ),
    _network_method("rapid", "Zhang et al. 2019", "DeepLabV3+, narrowed"),
    _network_method("fast-scnn", _BAEK, "The paper's network: segmentation into wraps"),
    _network_method(
        "fast-scnn-mirrored",
        _BAEK,
        "The paper's network, averaged over four mirror images",
        network="fast-scnn",
        mirrored=True,
    ),
    _network_method(
        "fast-scnn-ce", _BAEK, "The paper's network, trained by cross-entropy alone"
    ),
    _network_method(
        "fast-scnn-fourier", _BAEK, "The paper's network without phase edges"
    ),
    _network_method("fast-scnn-phase", _BAEK, "The paper's network on bare phases"),
    _network_method("fast-scnn-public", _BAEK, "Layers of the authors' public code"),
    _network_method(
        "fast-scnn-light",
        "this project",
        "A tenth of the paper's network, given the beat",
    ),
    Method(
        "hybrid",
        "learned",
        "this project",
        hybrid,
        memory=1000,
        wrap_memory=2,
        network="fast-scnn",
        sets=True,
    ),
    Method("middle", "trivial", "", trivial.middle, frequencies=1),
    Method("uniform", "trivial", "", trivial.uniform, frequencies=1),
    Method("mode", "trivial", "", trivial.mode, frequencies=1, knows_truth=True),
    Method(
        "reference-depth",
        "reference",
        "",
        references.reference_depth,
        frequencies=1,
        knows_truth=True,
    ),
    Method(
        "reference-offset",
        "reference",
        "",
        references.reference_offset,
        knows_truth=True,
    ),
    Method(
        "reference-contact",
        "reference",
        "",
        references.reference_contact,
        knows_truth=True,
    ),
    Method(
        "reference-field", "reference", "", references.reference_field, knows_truth=True
    ),
)

METHODS = {method.name: method for method in _ALL}

DEFAULT = "surfaces"


def find_method(name: str) -> Method:
    """Method of that name; a ValueError for an unknown one lists all.

    >>> find_method("beat").source
    'Jongenelen et al. 2010'
    """
    if name not in METHODS:
        raise ValueError(
            f"Expected a method out of {', '.join(METHODS)}, got {name}. Choose one."
        )
    return METHODS[name]


def names_of(chosen: str, protocol: str = "released") -> list[str]:
    """Methods named in a comma-separated list; ``all``: all but references and untrained networks.

    >>> names_of("surfaces, beat")
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
