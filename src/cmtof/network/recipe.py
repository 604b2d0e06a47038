"""Configuration of a training: stages, rooms and schedule, by name or from a file."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    NonNegativeFloat,
    PositiveFloat,
    PositiveInt,
    model_validator,
)

from cmtof.files import AnyPath, check_input, read_document
from cmtof.network.models import MODELS
from cmtof.network.weights import Count, Share, Strict
from cmtof.simulation import Protocol
from cmtof.validation import checked_values

Size = Annotated[int, Field(ge=1, le=4096)]  # px
# Configurations that travel with the package, by name.
PRESETS = read_document(Path(__file__).with_name("train.yml"))


class Rooms(Strict):
    """Set of rendered rooms to train on: numbers, and size of views, px."""

    seed: Count = 1
    scenes: PositiveInt = 100
    views: PositiveInt = 6
    height: Size = 512
    width: Size = 512


class Stage(Strict):
    """A part of a training: number of crops, their side, px, crops per step, noise and rate."""

    name: str
    crops: PositiveInt
    crop: Size
    batch: PositiveInt
    noise: tuple[
        PositiveFloat, PositiveFloat
    ]  # Gaussian sigma, counts; rises geometrically
    # share in which the noise rises
    ramp: float = Field(default=1.0, gt=0, le=1)
    rooms: Share = 0.0  # share of crops from rooms, the others are dead leaves
    rate: tuple[PositiveFloat, PositiveFloat]
    warm: PositiveInt = 100  # steps in which the rate rises
    # from there on norms keep their statistics: a few crops' give labels away
    freeze: Share = 1.0

    @property
    def steps(self) -> int:
        """Number of optimisation steps."""
        return max(self.crops // self.batch, 1)


class Config(Strict):
    """Configuration of one training: everything that decides its result."""

    name: str = "own"
    model: Literal[tuple(MODELS)] = "fast-scnn"  # pyright: ignore[reportInvalidTypeForm]
    protocol: Protocol = "released"
    stages: tuple[Stage, ...] = Field(min_length=1)
    rooms: Rooms | None = Rooms()  # without them it validates on leaves
    depth_weight: NonNegativeFloat | None = None  # w of Eq. 7; None: the model's
    # share of the old in averaged weights
    average: float = Field(default=0.998, ge=0, lt=1)
    # standard deviation of each phase's error of calibration, drawn for each crop, rad
    offset: NonNegativeFloat = 0.0
    optimizer: Literal["adamw", "muon"] = "adamw"
    precision: str = "bf16-mixed"  # Lightning's, or single where that is faster
    save_every: PositiveInt = 250  # steps
    validate_every: PositiveInt = 4  # checkpoints
    validation_views: PositiveInt = 32
    seed: Count = 0

    @model_validator(mode="after")
    def _check_crops(self) -> "Config":
        side = min(self.rooms.height, self.rooms.width) if self.rooms else 0
        if any(stage.rooms and stage.crop > side for stage in self.stages):
            raise ValueError(
                f"Expected crops within rooms of {side} px, got larger ones. Make crop smaller."
            )
        return self

    @property
    def steps(self) -> int:
        """Number of optimisation steps."""
        return sum(stage.steps for stage in self.stages)

    def stage_at(self, step: int) -> tuple[Stage, float]:
        """Stage of a step, counted from 0, and the share of that stage that is done, 0 to 1."""
        for stage in self.stages:
            if step < stage.steps:
                return stage, step / stage.steps
            step -= stage.steps
        return self.stages[-1], 1.0

    def rate_at(self, step: int) -> float:
        """Learning rate at a step: linear within its stage, and rising in its first steps."""
        stage, share = self.stage_at(step)
        first, last = stage.rate
        rate = first + (last - first) * share
        return rate * min(1.0, (share * stage.steps + 1) / stage.warm)


def read_config(source: AnyPath, **changes: Any) -> Config:
    """Configuration of a preset or a YAML file, with the ``changes`` that are not None."""
    path = Path(source)
    wanted = f"a configuration out of {', '.join(PRESETS)}, or a YAML file"
    values = PRESETS.get(str(source)) or read_document(check_input(path, wanted))
    replaced = {key: value for key, value in changes.items() if value is not None}
    values = {"name": path.stem} | values | replaced
    return checked_values(Config, values, f"the configuration {source}")
