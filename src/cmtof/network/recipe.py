"""The recipe of a training: stages, rooms and schedule, by name or from a file."""

from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import Field, PositiveFloat, PositiveInt, model_validator

from cmtof.files import read_document
from cmtof.network.models import MODELS
from cmtof.network.weights import Strict
from cmtof.validation import checked

Share = Annotated[float, Field(ge=0, le=1)]
PRESETS: dict[str, Any] = yaml.safe_load((files("cmtof.network") / "train.yml").read_text("utf-8"))
"""Configurations that travel with the package, by name."""


class Rooms(Strict):
    """Rendered frames to train on, as ``cmtof render`` makes them."""

    seed: int = 1
    scenes: PositiveInt = 100
    views: PositiveInt = 6
    height: PositiveInt = 512
    width: PositiveInt = 512


class Stage(Strict):
    """A part of a training: crops in all, their side in px, and how many make a step.

    Noise (Gaussian sigma, counts) rises geometrically over the first ``ramp`` of the stage;
    ``rooms`` is the share of crops from rooms, the others are dead leaves. The learning rate rises
    for ``warm`` steps and falls from ``flat`` on. After ``freeze`` norms keep their running
    statistics: those of a few crops take a part of the label away.
    """

    name: str
    crops: PositiveInt
    crop: PositiveInt
    batch: PositiveInt
    noise: tuple[PositiveFloat, PositiveFloat]
    ramp: Annotated[float, Field(gt=0, le=1)] = 1.0
    rooms: Share = 0.0
    rate: tuple[PositiveFloat, PositiveFloat]
    flat: Annotated[float, Field(ge=0, lt=1)] = 0.0
    warm: PositiveInt = 100
    freeze: Share = 1.0

    @property
    def steps(self) -> int:
        """Optimisation steps."""
        return max(self.crops // self.batch, 1)


class Config(Strict):
    """One training: everything that decides its outcome.

    The last stage's noise is also that of validation; without rooms it validates on leaves.
    ``average`` is kept of the averaged weights at each step. ``save_every`` counts steps,
    ``validate_every`` checkpoints. ``precision`` is Lightning's.
    """

    name: str = "own"
    model: str = "fast-scnn"
    protocol: Literal["released", "full"] = "released"
    stages: tuple[Stage, ...] = Field(min_length=1)
    rooms: Rooms | None = Rooms()
    weight_decay: float = 1e-3
    average: Share = 0.998
    precision: str = "32-true"
    save_every: PositiveInt = 250
    validate_every: PositiveInt = 4
    validation_views: PositiveInt = 32
    seed: Annotated[int, Field(ge=0)] = 0

    @model_validator(mode="after")
    def _fits(self) -> "Config":
        if self.model not in MODELS:
            known = ", ".join(MODELS)
            raise ValueError(f"Expected a model out of {known}, got {self.model}. Choose one.")
        side = min(self.rooms.height, self.rooms.width) if self.rooms else 0
        if any(stage.rooms and stage.crop > side for stage in self.stages):
            raise ValueError(f"Expected crops within rooms of {side} px, got larger. Crop less.")
        return self

    @property
    def steps(self) -> int:
        """Optimisation steps of the whole training."""
        return sum(stage.steps for stage in self.stages)

    def stage_at(self, step: int) -> tuple[Stage, float]:
        """Stage of a step, and the share of the stage that lies before it."""
        for stage in self.stages:
            if step < stage.steps:
                return stage, step / stage.steps
            step -= stage.steps
        return self.stages[-1], 1.0

    def rate_at(self, step: int) -> float:
        """Learning rate of a step."""
        stage, share = self.stage_at(step)
        fall = max(share - stage.flat, 0) / (1 - stage.flat)
        rate = stage.rate[0] + (stage.rate[1] - stage.rate[0]) * fall
        return rate * min(1.0, (share * stage.steps + 1) / stage.warm)


def read_config(source: str | Path, **changes: Any) -> Config:
    """Configuration by the name of a preset or from a YAML file; changes that are not None win.

    Raises FileNotFoundError or ValueError if there is none, or a name or value in it is wrong.

    Examples
    --------
    >>> read_config("paper").steps
    41666
    """
    held, path = PRESETS.get(str(source)), Path(source)
    if held is None and not path.is_file():
        raise FileNotFoundError(
            f"Expected a configuration out of {', '.join(PRESETS)}, or a YAML file, got {source}. "
            "Choose one."
        )
    held = {"name": path.stem} | (read_document(path) if held is None else held)
    given = {key: value for key, value in changes.items() if value is not None}
    return checked(Config, held | given, f"the configuration {source}")
