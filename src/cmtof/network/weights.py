"""Weights of trained networks in half precision (safetensors), with cards of their origin.

Nothing is ever unpickled. Inference reads weights as NumPy arrays, training as a network of torch.
"""

import hashlib
import json
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, PositiveInt

from cmtof.files import atomic_output, check_input, read_small_file, reading
from cmtof.network.features import CLASSES
from cmtof.simulation import Protocol
from cmtof.types import Fields, Texts, Values
from cmtof.validation import checked_values

Network = Tensor = Any  # of cmtof.network.models and of torch, which are imported late
FOLDER = Path(__file__).parents[1] / "weights"  # those that travel with the package

Share = Annotated[float, Field(ge=0, le=1)]
Count = Annotated[int, Field(ge=0, lt=2**63)]


class Strict(BaseModel):
    """Pydantic model that cannot be changed and refuses unknown names, NaN and infinity."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Rates(Strict):
    """Shares of pixels whose wrap count is wrong by less than 1, 2, 3, and by 10 or more."""

    delta_lt_1: Share
    delta_lt_2: Share
    delta_lt_3: Share
    delta_ge_10: Share


class Card(Strict):
    """Origin of weights: model, training, and rates on views of rooms that were held out."""

    model: str
    protocol: Protocol
    classes: int = Field(ge=1, le=4096)
    first_wrap: Count
    parameters: PositiveInt
    configuration: Fields
    data: str
    crops: Count
    steps: Count
    minutes: float
    hardware: str
    versions: Texts
    curve: list[Values]  # validation while training
    views: PositiveInt
    validation: Rates
    trivial: dict[str, Rates]  # of constant answers, over the same pixels
    gain: tuple[
        float, float, float
    ]  # in δ < 1 over the best of them, and its 95 % interval
    note: str = ""
    fine_tuned: Values | None = None
    sha256: str = ""

    @property
    def trained(self) -> bool:
        """Whether the gain is above zero with 95 % confidence."""
        return self.gain[1] > 0


class Trained(NamedTuple):
    """Network of torch with trained weights, in evaluation mode, and its card."""

    network: Network
    card: Card


def weights_path(model: str, protocol: str, folder: Path = FOLDER) -> Path:
    """Path of a model's weights in a folder; their card lies beside it as ``.json``."""
    return folder / f"{model}.{protocol}.safetensors"


def state(model: str, protocol: str = "released", folder: Path = FOLDER) -> str:
    """State "trained" (by `Card.trained`), "untrained" or "no weights"."""
    if not (path := weights_path(model, protocol, folder)).is_file():
        return "no weights"
    return "trained" if read_card(path).trained else "untrained"


def find_weights(model: str, first: int, last: int, folder: Path = FOLDER) -> Path:
    """Path of a model's weights with the fewest classes that hold the wraps first to last."""
    for protocol, (low, count) in CLASSES.items():
        path = weights_path(model, protocol, folder)
        if path.is_file() and low <= first and last < low + count:
            return path
    raise ValueError(
        f"Expected weights of {model} for the wraps {first} to {last}, got none. "
        "Narrow the range, or train them with cmtof train."
    )


def half_precision_weights(network: Network) -> dict[str, Tensor]:
    """Weights by name in half precision; statistics of norms in single, for their range."""
    single = ("running_mean", "running_var", "num_batches_tracked")
    return {
        name: (w if name.endswith(single) else w.half()).cpu().contiguous()
        for name, w in network.state_dict().items()
    }


def save_weights(path: Path, network: Network, card: Card) -> None:
    """Write weights in half precision and their card, with the hash of the weights' file."""
    from safetensors.torch import save

    content = save(half_precision_weights(network))
    card = card.model_copy(update={"sha256": hashlib.sha256(content).hexdigest()})
    with (
        atomic_output(path) as part,
        atomic_output(path.with_suffix(".json")) as beside,
    ):
        part.write_bytes(content)
        beside.write_text(card.model_dump_json(indent=1) + "\n", "utf-8")


def read_card(weights: Path) -> Card:
    """Card of a file of weights; a ValueError if it is missing or damaged."""
    path = weights.with_suffix(".json")
    with reading(f"the card of {weights.name}", path, "Keep both together."):
        values = json.loads(read_small_file(path))
    return checked_values(Card, values, path)


def read_weights(path: Path) -> tuple[dict[str, NDArray], Card]:
    """Arrays of a file of weights by their names, and its card.

    Raises a ValueError if the file or its card is missing, damaged, or does not match the other.
    """
    from safetensors.numpy import load

    content = check_input(path, "weights, *.safetensors").read_bytes()
    card = read_card(path)
    found = hashlib.sha256(content).hexdigest()
    with reading_weights(path, card):
        if (card.first_wrap, card.classes) != CLASSES[card.protocol]:
            raise ValueError(f"no such model with {card.classes} classes")
        if found != card.sha256:
            raise ValueError(f"the hash {found[:12]}… instead of {card.sha256[:12]}…")
        arrays = load(content)
        if not all(np.isfinite(array).all() for array in arrays.values()):
            raise ValueError("NaN or infinity")
    return arrays, card


def reading_weights(path: Path, card: Card) -> AbstractContextManager[None]:
    """Context of reading weights: any error in it becomes a ValueError that names them."""
    expected = f"finite weights of {card.model} that fit their card"
    return reading(expected, path, "Fetch or train them again.")


def load_weights(path: Path) -> Trained:
    """Network of torch with the weights of a file; a ValueError if file or card cannot be used."""
    import torch

    from cmtof.network.models import MODELS, build_network

    arrays, card = read_weights(path)
    with reading_weights(path, card):
        if card.model not in MODELS:
            raise ValueError("no such model")
        network = build_network(card.model, card.protocol)
        network.load_state_dict(
            {name: torch.from_numpy(x) for name, x in arrays.items()}
        )
    return Trained(network.eval(), card)
