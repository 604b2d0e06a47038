"""A trained network goes on learning from a few labelled measurements of an instrument (Sec. 6.4).

What an instrument does differently from the simulation, its noise and its waveforms, is in its
measurements; labels come from elsewhere, such as stereo, and do not cover every pixel. Only what is
labelled counts. The running means of the normalisation stay as they were trained: a few scans are
too few to estimate them anew.
"""

from collections.abc import Sequence
from copy import deepcopy
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from cmtof.correlation import wrap_length
from cmtof.measurement import Measurement
from cmtof.network.configuration import MODELS
from cmtof.network.features import features, needs_correlation
from cmtof.network.inference import quadrature_images
from cmtof.network.losses import IGNORED, regression_loss, unwrapping_loss
from cmtof.network.weights import Trained


class Labelled(NamedTuple):
    """A measurement and what is known of its wraps."""

    measurement: Measurement
    wraps: NDArray[np.int64]
    """Wrap count of the lowest frequency (H, W)."""
    mask: NDArray[np.bool_]
    """Pixels (H, W) whose wrap is known; the others teach nothing."""
    depth: NDArray[np.floating]
    """Best range (H, W), m; need not be finite where the mask is False."""


class FineTuned(NamedTuple):
    """A network that went on learning."""

    trained: Trained
    """A copy; its card tells of the fine-tuning. `save_weights` writes both."""
    losses: list[float]
    """Of each step, before it was taken."""


def fine_tune(
    trained: Trained,
    examples: Sequence[Labelled],
    *,
    steps: int = 20,
    learning_rate: float = 1e-4,
    crop: int = 128,
    batch: int = 2,
    seed: int = 0,
) -> FineTuned:
    """Continue the training of a network on labelled measurements.

    Parameters
    ----------
    trained : Trained
        As `cmtof.network.weights.load_weights` gives it; it is left as it is.
    examples : sequence of Labelled
    steps : int
    learning_rate : float
        Of Adam; a twentieth of the training's, so that what was learnt stays.
    crop, batch : int
        Side of a crop, px (less where a measurement is smaller), and crops a step; a crop's place
        is drawn anew until a twentieth of it is labelled, ten times at most.
    seed : int
        Of crops and dropout.

    Returns
    -------
    FineTuned

    Raises
    ------
    ValueError
        If there is no example, shapes disagree, or no label lies among the network's classes.
    """
    if not examples or steps < 1 or crop < 1 or batch < 1 or not learning_rate > 0:
        raise ValueError(
            f"Expected examples, steps, crop, batch and learning rate above 0, got "
            f"{len(examples)}, {steps}, {crop}, {batch}, {learning_rate}. Correct them."
        )
    card = trained.card
    prepared = [_prepared(one, trained) for one in examples]
    if not any((label != IGNORED).any() for _, label, _, _ in prepared):
        raise ValueError(
            f"Expected labels among the wraps {trained.first} to "
            f"{trained.first + card['classes'] - 1}, got none in {len(prepared)} measurements. "
            "Choose weights of another protocol, or label more."
        )
    network = deepcopy(trained.network)
    _set_training(network)
    rng = np.random.default_rng(seed)
    optimizer = torch.optim.Adam(network.parameters(), learning_rate)
    losses = []
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        for _ in range(steps):
            found = _loss(network, _drawn(prepared, rng, crop, batch), trained)
            optimizer.zero_grad()
            found.backward()
            optimizer.step()
            losses.append(float(found.detach()))
    note = {
        "steps": steps,
        "learning_rate": learning_rate,
        "examples": len(prepared),
        "labelled_pixels": int(sum((label != IGNORED).sum() for _, label, _, _ in prepared)),
        "seed": seed,
    }
    return FineTuned(Trained(network.eval(), card | {"fine_tuned": note}), losses)


Prepared = tuple[Tensor, Tensor, Tensor, Tensor]
"""Features (C, H, W), class, phase and turns (H, W) of a measurement."""


def _prepared(example: Labelled, trained: Trained) -> Prepared:
    """Inputs and labels of one example; what is not labelled, or no class, is `IGNORED`."""
    measurement, wraps, mask, depth = example
    for name, image in (("wraps", wraps), ("mask", mask), ("depth", depth)):
        if np.shape(image) != measurement.shape:
            raise ValueError(
                f"Expected {name} of the measurement's shape {measurement.shape}, got "
                f"{np.shape(image)}. Take them from one scan."
            )
    phase, amplitude = (
        np.nan_to_num(np.asarray(images[:2], np.float32))
        for images in (measurement.phase, measurement.amplitude)
    )
    kind = MODELS[trained.card["model"]].features
    images = quadrature_images(measurement) if needs_correlation(kind) else None
    inputs = features(phase, amplitude, kind, images)
    label = np.asarray(wraps, np.int64) - trained.first
    turns = np.asarray(depth, float) / wrap_length(measurement.frequencies[0]) - trained.first
    known = np.asarray(mask, bool) & np.isfinite(turns) & measurement.mask
    known &= (label >= 0) & (label < trained.card["classes"])
    label = np.where(known, label, IGNORED)
    return (
        torch.from_numpy(np.ascontiguousarray(inputs, np.float32)),
        torch.from_numpy(label),
        torch.from_numpy(phase[0].copy()),
        torch.from_numpy(np.where(known, turns, 0.0).astype(np.float32)),
    )


def _set_training(network: nn.Module) -> None:
    """Training mode, but for layers that keep running statistics."""
    network.train()
    for layer in network.modules():
        if isinstance(layer, nn.modules.batchnorm._BatchNorm):
            layer.eval()


def _drawn(
    prepared: Sequence[Prepared], rng: np.random.Generator, crop: int, batch: int
) -> list[Prepared]:
    return [_cropped(prepared[int(rng.integers(len(prepared)))], rng, crop) for _ in range(batch)]


def _cropped(example: Prepared, rng: np.random.Generator, crop: int) -> Prepared:
    """A square crop, drawn until it holds labels."""
    height, width = example[1].shape
    high, wide = min(crop, height), min(crop, width)
    pieces = example
    for _ in range(10):
        top, left = rng.integers(height - high + 1), rng.integers(width - wide + 1)
        pieces = tuple(one[..., top : top + high, left : left + wide] for one in example)
        if (pieces[1] != IGNORED).float().mean() >= 0.05:
            break
    return pieces  # type: ignore[return-value]


def _loss(network: nn.Module, crops: Sequence[Prepared], trained: Trained) -> Tensor:
    """Loss of the model that the network is (Eq. 7), as a mean over the crops."""
    model, total = MODELS[trained.card["model"]], torch.zeros(())
    for inputs, label, phase, turns in crops:  # measurements may differ in size
        found = network(inputs[None])
        if model.target == "depth":
            loss = regression_loss(
                found,
                label[None],
                turns[None],
                classes=trained.card["classes"],
                smoothness=model.smoothness,
            )
        else:
            loss = unwrapping_loss(
                found, label[None], phase[None], turns[None], depth_weight=model.depth_weight
            )
        total = total + loss.total / len(crops)
    return total
