"""Trained weights: safetensors, and a card beside each that says where it comes from.

A card is plain JSON: how it was trained, on what, on which machine, how validation went, and the
hash of the weights. Loading checks the hash; nothing is ever unpickled.
"""

import hashlib
import json
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from cmtof.files import written_whole

if TYPE_CHECKING:
    from torch import Tensor
    from torch.nn import Module

FOLDER = Path(str(files("cmtof"))) / "weights"
"""Weights that travel with the package."""


class Trained(NamedTuple):
    """A network with its weights, ready to use."""

    network: Any
    """As `cmtof.network.building.build_network` made it, in eval mode."""
    card: dict[str, Any]

    @property
    def first(self) -> int:
        """Wrap of the first class."""
        return self.card["first_wrap"]

    @property
    def validated(self) -> float:
        """Share of validation pixels whose wrap was right; that of a guess if the card has none."""
        rates = self.card.get("validation_in_half_precision", {})
        return float(rates.get("delta_lt_1", 1 / self.card["classes"]))


def weights_path(model: str, protocol: str, folder: Path = FOLDER) -> Path:
    """File of a model's weights; its card lies beside it as ``.json``."""
    return folder / f"{model}.{protocol}.safetensors"


def shipped(folder: Path = FOLDER) -> dict[tuple[str, str], Path]:
    """Weights that are there, by model and protocol."""
    found = sorted(folder.glob("*.safetensors"))
    return {(p.name.split(".")[0], p.name.split(".")[1]): p for p in found}


def state(model: str, protocol: str) -> str:
    """Whether the weights of a model are trained, untrained (no gain) or not there."""
    path = weights_path(model, protocol)
    if not path.is_file():
        return "no weights"
    rates = read_card(path).get("validation_in_half_precision", {})
    return "trained" if rates.get("delta_lt_1", 0.0) > 0.2 else "untrained"


def find_weights(model: str, first: int, last: int, folder: Path = FOLDER) -> Path:
    """Shipped weights of a model with the fewest classes that know the wraps first to last.

    Raises
    ------
    ValueError
        If there are none.
    """
    cards = {path: read_card(path) for (name, _), path in shipped(folder).items() if name == model}
    known = {p: (c["first_wrap"], c["first_wrap"] + c["classes"] - 1) for p, c in cards.items()}
    fitting = [p for p, (low, high) in known.items() if low <= first and last <= high]
    if not fitting:
        shown = ", ".join(f"{low} to {high}" for low, high in known.values()) or "none"
        raise ValueError(
            f"Expected weights of {model} for the wraps {first} to {last}, got {shown}. Narrow the "
            "range, or train them with cmtof train."
        )
    return min(fitting, key=lambda path: cards[path]["classes"])


def save_weights(path: Path, network: "Module", card: dict[str, Any]) -> dict[str, Any]:
    """Write weights in half precision, and their card.

    Returns
    -------
    dict
        The card as written: with the hash and the size of the file.
    """
    from safetensors.torch import save

    content = save(halved(network.state_dict()))
    card = card | {"sha256": hashlib.sha256(content).hexdigest(), "bytes": len(content)}
    with written_whole(path) as part:
        part.write_bytes(content)
    write_card(path, card)
    return card


def halved(state: Mapping[str, "Tensor"]) -> dict[str, "Tensor"]:
    """Weights in half precision, on the CPU.

    Running means and variances may exceed what half precision holds, and stay in single.
    """

    def stored(name: str, tensor: "Tensor") -> "Tensor":
        half = tensor.is_floating_point() and "running" not in name
        return (tensor.half() if half else tensor).cpu().contiguous()

    return {name: stored(name, tensor) for name, tensor in state.items()}


def write_card(weights: Path, card: dict[str, Any]) -> None:
    """Write the card that belongs to a file of weights."""
    with written_whole(weights.with_suffix(".json")) as part:
        part.write_text(json.dumps(card, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def read_card(weights: Path) -> dict[str, Any]:
    """Card of a file of weights.

    Raises
    ------
    ValueError
        If there is none, or it is no card.
    """
    path = weights.with_suffix(".json")
    try:
        card = json.loads(path.read_text(encoding="utf-8"))
        needed = {"model", "classes", "first_wrap", "protocol", "sha256"}
        if not needed <= card.keys():
            raise KeyError(", ".join(sorted(needed - card.keys())))
    except (OSError, ValueError, KeyError, AttributeError) as error:
        raise ValueError(
            f"Expected the card of {weights.name} in {path}, got {error!r}. Keep both together."
        ) from error
    return card


def load_weights(path: Path) -> Trained:
    """Load a network for inference.

    Parameters
    ----------
    path : Path
        The ``.safetensors``; its card lies beside it.

    Raises
    ------
    ValueError
        If a file is missing, the hash does not agree, or the weights fit another network.
    """
    from safetensors import SafetensorError
    from safetensors.torch import load

    from cmtof.network.building import build_network
    from cmtof.network.configuration import MODELS

    card = read_card(path)
    if not path.is_file():
        raise ValueError(f"Expected weights in {path}, got none. Fetch or train them.")
    content = path.read_bytes()
    found = hashlib.sha256(content).hexdigest()
    if found != card["sha256"]:
        raise ValueError(
            f"Expected weights with the hash {card['sha256'][:12]}… in {path}, got {found[:12]}…. "
            "Fetch them again."
        )
    if card["model"] not in MODELS:
        raise ValueError(
            f"Expected a model out of {', '.join(MODELS)}, got {card['model']} in {path}. Use the "
            "version that trained it."
        )
    network = build_network(card["model"], card["classes"])
    try:
        network.load_state_dict({k: v.float() for k, v in load(content).items()})
    except (RuntimeError, SafetensorError) as error:
        raise ValueError(
            f"Expected weights of {card['model']} with {card['classes']} classes in {path}, got "
            f"others ({str(error).splitlines()[0]}). Train them anew."
        ) from error
    return Trained(network.eval(), card)
