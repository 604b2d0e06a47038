"""Trained networks, safetensors in half precision, never unpickled: cards, state, unwrapping."""

import hashlib
import json
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, PositiveInt

from cmtof.constants import FREQUENCIES
from cmtof.correlation import centred, depth_from_wraps, wrap_length
from cmtof.estimate import within_range, wraps_in_range
from cmtof.files import check_input, small_file, written_whole
from cmtof.measurement import Measurement
from cmtof.network.features import CLASSES, FULL_AMPLITUDE, features
from cmtof.simulation import QUADRATURES
from cmtof.validation import checked, expect

Network = Tensor = Any  # of cmtof.network.models and of torch, which are imported late
FOLDER = Path(str(files("cmtof"))) / "weights"  # those that travel with the package

Share = Annotated[float, Field(ge=0, le=1)]
Count = Annotated[int, Field(ge=0, lt=2**63)]


class Strict(BaseModel):
    """Plain values with checked names and kinds."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Rates(Strict):
    """Shares of pixels whose wrap count is wrong by less than 1, 2, 3, and by 10 or more."""

    delta_lt_1: Share
    delta_lt_2: Share
    delta_lt_3: Share
    delta_ge_10: Share


class Card(Strict):
    """Origin of weights, and what they reached on whole views of rooms that they never saw."""

    model: str
    protocol: Literal["released", "full"]
    classes: int = Field(ge=1, le=4096)
    first_wrap: Count
    parameters: PositiveInt
    configuration: dict[str, Any]
    data: str
    crops: Count
    steps: Count
    minutes: float
    hardware: str
    versions: dict[str, str]
    curve: list[dict[str, float]]  # validation while training
    views: PositiveInt
    validation: Rates
    trivial: dict[str, Rates]  # of answers that look at nothing, over the same pixels
    gain: tuple[float, float, float]  # in δ < 1 over the best of them, and its 95 % interval
    note: str = ""
    fine_tuned: dict[str, float] | None = None
    sha256: str = ""


class Trained(NamedTuple):
    """A network with its weights, in evaluation mode, and its card."""

    network: Network
    card: Card


def weights_path(model: str, protocol: str, folder: Path = FOLDER) -> Path:
    """File of a model's weights; its card lies beside it as ``.json``."""
    return folder / f"{model}.{protocol}.safetensors"


def state(model: str, protocol: str = "released", folder: Path = FOLDER) -> str:
    """Trained (the gain is above zero with 95 % confidence), untrained or no weights."""
    if not (path := weights_path(model, protocol, folder)).is_file():
        return "no weights"
    return "trained" if read_card(path).gain[1] > 0 else "untrained"


def find_weights(model: str, first: int, last: int, folder: Path = FOLDER) -> Path:
    """Weights of a model with the fewest classes that hold the wraps first to last."""
    for protocol, (low, count) in CLASSES.items():
        path = weights_path(model, protocol, folder)
        if path.is_file() and low <= first and last < low + count:
            return path
    what = f"weights of {model} for the wraps {first} to {last}, got none"
    raise ValueError(f"Expected {what}. Narrow the range, or train them with cmtof train.")


def halved(network: Network) -> dict[str, Tensor]:
    """Weights in half precision; running variances may exceed its range and stay in single."""
    held = {name: tensor.cpu().contiguous() for name, tensor in network.state_dict().items()}
    single = ("running_mean", "running_var", "num_batches_tracked")
    return {name: w if name.endswith(single) else w.half() for name, w in held.items()}


def save_weights(path: Path, network: Network, card: Card) -> None:
    """Write weights in half precision and their card, with the hash of the weights' file."""
    from safetensors.torch import save

    content = save(halved(network))
    card = card.model_copy(update={"sha256": hashlib.sha256(content).hexdigest()})
    with written_whole(path) as part, written_whole(path.with_suffix(".json")) as beside:
        part.write_bytes(content)
        beside.write_text(card.model_dump_json(indent=1) + "\n", encoding="utf-8")


def read_card(weights: Path) -> Card:
    """Card of a file of weights; a ValueError if there is none, or it is no card."""
    path = weights.with_suffix(".json")
    try:
        held = json.loads(small_file(path))
    except (OSError, ValueError, RecursionError) as error:
        got = f"got {error}. Keep both together"
        raise ValueError(f"Expected the card of {weights.name} in {path}, {got}.") from error
    return checked(Card, held, path)


def load_weights(path: Path) -> Trained:
    """Network for inference; a ValueError if its file or card is missing, damaged, or no match."""
    from safetensors import SafetensorError
    from safetensors.torch import load

    from cmtof.network.models import MODELS, build_network

    content, card = check_input(path, "weights, *.safetensors").read_bytes(), read_card(path)
    found = hashlib.sha256(content).hexdigest()
    try:
        if card.model not in MODELS or (card.first_wrap, card.classes) != CLASSES[card.protocol]:
            raise RuntimeError(f"no such model with {card.classes} classes")
        if found != card.sha256:
            raise RuntimeError(f"the hash {found[:12]}… instead of {card.sha256[:12]}…")
        network = build_network(card.model, card.protocol)
        network.load_state_dict(load(content))
        if not all(bool(tensor.isfinite().all()) for tensor in network.state_dict().values()):
            raise RuntimeError("NaN or infinity")
    except (RuntimeError, SafetensorError) as error:
        what = f"finite weights of {card.model} in {path} that fit their card"
        got = f"got others ({str(error).splitlines()[0]}). Fetch or train them again."
        raise ValueError(f"Expected {what}, {got}") from error
    return Trained(network.eval(), card)


def unwrap_with_network(
    measurement: Measurement, *, model: str | None = None, weights: str | Path | None = None
) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Depth by a network that classifies each pixel's wrap (Sec. 5) or regresses its depth.

    Weights are the shipped ones that hold every wrap in range, or a ``.safetensors`` of one's own.
    Returned are depth, m, and the probability of the chosen class, of a regression the share of
    right wraps in validation; both (H, W).
    """
    tones = np.asarray(measurement.frequencies, float)
    right = tones.size > 1 and np.allclose(tones[:2], FREQUENCIES, rtol=1e-6)
    got = f"{', '.join(f'{f / 1e9:g}' for f in tones)} GHz"
    what = "7.15 and 14.32 GHz, which the weights were trained at"
    expect(right, what, got, "Choose the method crt.")
    first, last = wraps_in_range(measurement)
    trained = load_weights(Path(weights or find_weights(model or "fast-scnn", first, last)))
    given = trained.card.model
    expect(model in (None, given), f"weights of {model}", f"those of {given}", "Name that method.")
    if trained.network.target == "depth":
        turns = trained.card.first_wrap + _output(trained, measurement)[0].numpy()
        depth = turns * wrap_length(FREQUENCIES[0])
        sure = np.full(depth.shape, trained.card.validation.delta_lt_1)
    else:
        wraps, sure = classify(trained, measurement, first, last)
        phase = np.nan_to_num(measurement.phase[0]).astype(float)
        depth = depth_from_wraps(phase, wraps, FREQUENCIES[0])
    return within_range(depth, measurement), sure


def classify(
    trained: Trained, measurement: Measurement, first: int, last: int
) -> tuple[NDArray[np.int64], NDArray[np.floating]]:
    """Likeliest wrap ``first <= n <= last`` of each pixel and its probability, both (H, W)."""
    low, stop = trained.card.first_wrap, trained.card.first_wrap + trained.card.classes
    what = f"wraps within {low} to {stop - 1}, which {trained.card.model} distinguishes"
    expect(low <= first and last < stop, what, f"{first} to {last}", "Narrow the range.")
    found = _output(trained, measurement)[first - low : last - low + 1].float().numpy()
    np.exp(np.subtract(found, found.max(0), out=found), out=found)  # a softmax, in place
    return first + found.argmax(0), 1 / found.sum(0)


def network_images(measurement: Measurement, kind: str) -> list[NDArray[np.float32]]:
    """Phases, amplitudes (2, H, W) and, if read, correlations (2, 4, H, W): the features' source.

    Amplitudes in other units than the simulation's counts are scaled, for each frequency, so that
    the brightest tenth of the image begins at a white surface's.
    """
    # a masked pixel may be NaN; the network gets a dark one, or its neighbours would be NaN too
    images = [measurement.phase[:2], measurement.amplitude[:2]]
    if kind == "correlation" and "correlation" in measurement.dataset:
        psi = measurement.dataset["psi"].to_numpy()[:2]
        off = np.abs(centred(psi[:, :, None] - np.asarray(QUADRATURES)))
        what = "correlations at psi = 0, 1/2, 1 and 3/2 pi, which the network was trained on"
        got = f"psi = {np.round(psi[0], 3).tolist()} rad"
        expect((off.min(1) <= 1e-6).all(), what, got, "Choose another method.")
        held = measurement.dataset["correlation"]
        images.append(np.stack([held[f, k].to_numpy() for f, k in enumerate(off.argmin(1))]))
    phase, amplitude, *more = (np.nan_to_num(np.asarray(x, np.float32)) for x in images)
    bright = np.quantile(amplitude, 0.9, axis=(1, 2), keepdims=True)
    if not 0.1 < bright[0].item() / FULL_AMPLITUDE < 2:  # noise alone has more in the simulation
        amplitude *= FULL_AMPLITUDE / np.maximum(bright, np.float32(1e-30))
    return [phase, amplitude, *more]


def _output(trained: Trained, measurement: Measurement) -> Tensor:
    """Output (C, H, W) of a network for a measurement."""
    import torch

    kind = trained.network.model.features
    phase, amplitude, *more = network_images(measurement, kind)
    inputs = features(phase, amplitude, kind, *more)
    image = torch.from_numpy(inputs)[None].contiguous(memory_format=torch.channels_last)
    with torch.inference_mode():
        return trained.network(image)[0].float()
