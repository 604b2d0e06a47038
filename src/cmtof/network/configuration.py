"""What a training is made of: everything that decides its outcome stands in one of these."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

import yaml

from cmtof.constants import FREQUENCIES, NOISE_SIGMA
from cmtof.correlation import wrap_length
from cmtof.measurement import unambiguous_range
from cmtof.network.features import FEATURE_SETS
from cmtof.simulation import RELEASED_WRAPS, Protocol


@dataclass(frozen=True)
class Model:
    """A network by name: what it reads, how it is built, what it is trained for.

    Attributes
    ----------
    summary : str
    network : str
        Who builds it, out of `cmtof.network.building.NETWORKS`.
    features : str
        Out of `cmtof.network.features.FEATURE_SETS`.
    architecture : dict
        What differs from the defaults of the network's own ``Architecture``.
    target : {"wraps", "depth"}
        Classes of wraps, or a regression of depth.
    depth_weight : float
        w of Eq. 7, for wraps.
    smoothness : float
        Weight of the depth's gradient, for depth.
    mended : bool
        Whether wraps are mended afterwards (`cmtof.network.rapid.mended`).
    """

    summary: str
    network: str = "fast-scnn"
    features: str = "proposed"
    architecture: Mapping[str, Any] = field(default_factory=dict)
    target: Literal["wraps", "depth"] = "wraps"
    depth_weight: float = 0.1
    smoothness: float = 0.0
    mended: bool = False


MODELS = {
    "fast-scnn": Model("the paper's network: Fourier features, edges, both losses"),
    "fast-scnn-ce": Model("the paper's network without the loss on depth", depth_weight=0.0),
    "fast-scnn-fourier": Model("the paper's network without phase edges", features="fourier"),
    "fast-scnn-phase": Model("the paper's network on bare phases and amplitudes", features="phase"),
    "fast-scnn-released": Model(
        "the authors' released code: phases only, instance norm, global pools, no skip",
        features="released",
        architecture={"stem": 0, "pools": (), "norm": "instance"},
    ),
    "fast-scnn-light": Model(
        "a lighter network that is given the beat of the two phases",
        features="beat",
        architecture={
            "stem": 16,
            "down": (24, 32),
            "bottlenecks": (48, 64, 96),
            "repeats": 2,
            "expansion": 3,
            "context": 64,
            "head": 32,
        },
    ),
    "u-net": Model(
        "U-Net on bare phases and amplitudes: segmentation into wraps",
        network="u-net",
        features="phase",
        depth_weight=0.0,
    ),
    "one-step": Model(
        "residual U-Net on bare phases and amplitudes: regression of the absolute phase",
        network="one-step",
        features="phase",
        target="depth",
    ),
    "deep-tof": Model(
        "encoder and decoder on raw correlations: regression of depth",
        network="deep-tof",
        features="correlation",
        target="depth",
        smoothness=1e-4,
    ),
    "rapid": Model(
        "DeepLabV3+ on bare phases and amplitudes: segmentation into wraps, mended",
        network="rapid",
        features="phase",
        depth_weight=0.0,
        mended=True,
    ),
}
"""The rows of Table 1, the released variant, one that costs less, and the paper's baselines."""


@dataclass(frozen=True)
class Rooms:
    """Rendered frames to train on, as ``cmtof render`` makes them."""

    seed: int = 1
    scenes: int = 100
    views: int = 8
    height: int = 512
    width: int = 512


@dataclass(frozen=True)
class Config:
    """One training.

    Attributes
    ----------
    name : str
        Of the configuration; rows of a table share one.
    model : str
        Out of `MODELS`.
    protocol : {"released", "full"}
        Which wraps are told apart: N = 21 or 358.
    rooms : Rooms
        Frames to train and validate on.
    epochs, crops, batch : int
        Epochs, crops drawn in each, and crops a step.
    crop : int
        Side of a crop, px.
    learning_rate, warm_up, weight_decay : float
        Highest rate of the OneCycle schedule, the share of steps on its way up, Adam's decay.
    noise : float
        Gaussian sigma, counts.
    noise_jitter, brightness_jitter : float
        Half of the range that the noise's variance and the intensity are multiplied from, about 1.
    flips : bool
        Mirror half of the crops.
    hardness : float
        gamma of Eq. 6.
    validation_views : int
        Frames to validate on; 0 takes all.
    validate_every : int
        Epochs.
    precision : str
        Lightning's: ``32-true``, ``bf16-mixed``, ``16-mixed``.
    seed : int
        Of weights, crops and noise.
    """

    name: str = "paper"
    model: str = "fast-scnn"
    protocol: Protocol = "released"
    rooms: Rooms = field(default_factory=Rooms)
    epochs: int = 1000
    crops: int = 500
    batch: int = 12
    crop: int = 512
    learning_rate: float = 1e-3
    warm_up: float = 0.05
    weight_decay: float = 5e-5
    noise: float = NOISE_SIGMA
    noise_jitter: float = 0.25
    brightness_jitter: float = 0.25
    flips: bool = True
    hardness: float = 1.0
    validation_views: int = 0
    validate_every: int = 1
    precision: str = "32-true"
    seed: int = 0

    def __post_init__(self) -> None:
        if self.model not in MODELS:
            raise ValueError(
                f"Expected a model out of {', '.join(MODELS)}, got {self.model}. Choose one."
            )
        wraps_of(self.protocol)
        for name in ("epochs", "crops", "batch", "crop", "validate_every"):
            if getattr(self, name) < 1:
                raise ValueError(f"Expected {name} >= 1, got {getattr(self, name)}. Raise it.")
        if self.validate_every > self.epochs:
            raise ValueError(
                f"Expected validate_every <= epochs, got {self.validate_every} and {self.epochs}. "
                "Validate once at least: the best weights are kept."
            )
        if self.crop > min(self.rooms.height, self.rooms.width):
            raise ValueError(
                f"Expected crops within frames of {self.rooms.height}x{self.rooms.width}, got "
                f"{self.crop}. Take smaller crops or larger frames."
            )
        assert MODELS[self.model].features in FEATURE_SETS

    @property
    def steps(self) -> int:
        """Optimisation steps of the whole training."""
        return self.epochs * -(-self.crops // self.batch)

    def as_dict(self) -> dict[str, Any]:
        """Plain values, to be stored."""
        return asdict(self)


def wraps_of(protocol: str) -> tuple[int, int]:
    """First wrap that a protocol tells apart, and how many: its classes.

    Examples
    --------
    >>> wraps_of("released"), wraps_of("full")
    ((36, 21), (0, 358))
    """
    if protocol == "released":
        return RELEASED_WRAPS[0], RELEASED_WRAPS[1] - RELEASED_WRAPS[0]
    if protocol == "full":
        turns = unambiguous_range(FREQUENCIES) / wrap_length(FREQUENCIES[0])
        return 0, int(-(-turns // 1))
    raise ValueError(f"Expected protocol 'released' or 'full', got {protocol!r}. Choose one.")


def configurations() -> dict[str, str]:
    """Names of the configurations that travel with the package, and the first line of each."""
    folder = files("cmtof.network") / "configs"
    found = {}
    for path in sorted(folder.iterdir(), key=lambda p: p.name):
        if path.name.endswith(".yml"):
            first = path.read_text(encoding="utf-8").partition("\n")[0]
            found[path.name.removesuffix(".yml")] = first.removeprefix("# ")
    return found


def read_config(source: str | Path, **changes: Any) -> Config:
    """Read a configuration by name or from a YAML file.

    Parameters
    ----------
    source : str or Path
        A name out of `configurations`, or a file.
    **changes
        What to put in place of the file's; None changes nothing.

    Raises
    ------
    FileNotFoundError, ValueError
        If there is no such configuration, or it holds what a training does not have.
    """
    own = files("cmtof.network") / "configs" / f"{source}.yml"
    path = own if str(source) in configurations() else Path(source)
    if not path.is_file():
        raise FileNotFoundError(
            f"Expected a configuration out of {', '.join(configurations())}, or a YAML file, got "
            f"{source}. Choose one."
        )
    try:
        held = yaml.safe_load(path.read_text(encoding="utf-8")) or {}
    except yaml.YAMLError as error:
        raise ValueError(f"Expected YAML in {path}, got {error}. Correct it.") from error
    if not isinstance(held, dict):
        raise ValueError(f"Expected names and values in {path}, got {held!r}. Correct it.")
    name = Path(str(source)).stem
    return config_from_dict({"name": name} | held, **changes)


def config_from_dict(held: Mapping[str, Any], **changes: Any) -> Config:
    """Build a configuration from plain values; raise a ValueError for names it does not have."""
    known = {one.name for one in fields(Config)}
    unknown = set(held) - known
    if unknown:
        raise ValueError(
            f"Expected settings out of {', '.join(sorted(known))}, got {', '.join(sorted(unknown))}"
            ". Correct the name."
        )
    given = {key: value for key, value in changes.items() if value is not None}
    try:
        rooms = {"rooms": Rooms(**held["rooms"])} if "rooms" in held else {}
        chosen = replace(Config(**{**held, **rooms}), **given)
    except TypeError as error:
        raise ValueError(
            f"Expected numbers in a configuration, got {error}. Correct it."
        ) from error
    for one in (chosen, chosen.rooms):
        _check_kinds(one)
    return chosen


def _check_kinds(values: Config | Rooms) -> None:
    """Raise a ValueError unless every value is of its default's kind; YAML reads 2e-3 as text."""
    for one in fields(values):
        found, default = getattr(values, one.name), one.default
        if isinstance(default, bool | int | float | str):
            kinds = (int, float) if type(default) is float else (type(default),)
            if type(found) not in kinds:
                raise ValueError(
                    f"Expected {one.name} such as {default!r}, got {found!r}. Correct it (YAML "
                    "takes 2.0e-3 for a number, and 2e-3 for text)."
                )
