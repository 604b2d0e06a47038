"""Fine-tuning of a trained network on labelled measurements of an instrument (Sec. 6.4)."""

from collections.abc import Callable, Iterable
from copy import deepcopy

import numpy as np
import torch
from numpy.random import Generator, default_rng
from numpy.typing import NDArray
from torch import nn
from torch.utils.data import default_collate

from cmtof.constants import FREQUENCIES, FREQUENCY_SINGLE
from cmtof.correlation import TAU
from cmtof.estimate import without_holes
from cmtof.measurement import Measurement
from cmtof.network import weights
from cmtof.network.data import Sample
from cmtof.network.features import WRAP, features
from cmtof.network.inference import network_images
from cmtof.network.losses import IGNORED
from cmtof.network.models import Network
from cmtof.network.training import (
    average_into,
    keep_pages,
    loss_of,
    norms,
    optimizer_of,
)
from cmtof.types import Array, Numbers

# A measurement, its wraps, and its depth.
Example = tuple[Measurement, Numbers, Array]


def fine_tune(
    trained: weights.Trained,
    examples: Iterable[Example],
    *,
    steps: int = 200,
    learning_rate: float = 1e-4,
    crop: int = 64,
    batch: int = 4,
    seed: int = 0,
) -> tuple[weights.Trained, list[float]]:
    """Continue the training of a network on labelled measurements of an instrument (Sec. 6.4).

    Examples are a measurement, its wraps of the lowest frequency (H, W), -1 where unknown, and
    depth (H, W), m. The rate falls to zero; crops are mirrored, some turned, and moved to random
    depths, for a few scans hold few wraps; norms keep their means. Returned are a tuned copy, the
    average over the last hundred steps, and losses.
    """
    keep_pages()
    views = _views(trained, examples)
    crop = min(crop, *(min(view[1].shape) for view in views))
    rng = default_rng(seed)

    def draw_crops() -> list[Sample]:
        return [
            _augmented_crop(views[k], trained.network, crop, rng)
            for k in rng.integers(len(views), size=batch)
        ]

    average, losses = _tune(trained.network, draw_crops, steps, learning_rate)
    note = {
        "steps": steps,
        "learning_rate": learning_rate,
        "examples": len(views),
        "seed": seed,
    }
    card = trained.card.model_copy(update={"fine_tuned": note})
    return weights.Trained(average, card), losses


def _tune(
    trained: Network, draw_crops: Callable[[], list[Sample]], steps: int, rate: float
) -> tuple[Network, list[float]]:
    """Averaged copy of a network that learns from crops, and losses, one before each step."""
    average = deepcopy(trained).requires_grad_(False)
    network = deepcopy(trained).to(memory_format=torch.channels_last).train()  # pyright: ignore[reportCallIssue]
    for layer in norms(network):
        layer.eval()
    optimizer = optimizer_of(network, "muon", rate)
    fall = torch.optim.lr_scheduler.LinearLR(optimizer, 1.0, 0.0, steps)
    losses = []
    for step in range(steps):
        loss = loss_of(network, default_collate(draw_crops()))
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), 2.0)
        optimizer.step()
        average_into(average, network, step, 0.99)
        fall.step()
        losses.append(loss.item())
    return average.eval(), losses


def _views(trained: weights.Trained, examples: Iterable[Example]) -> list[tuple]:
    """Examples with at least one label, as `_view` makes them; a ValueError if there is none."""
    views = [_view(trained, *example) for example in examples]
    known = [view for view in views if (view[1] != IGNORED).any()]
    if not known:
        first = trained.card.first_wrap
        raise ValueError(
            f"Expected labels among the wraps {first} to "
            f"{first + trained.card.classes - 1}, got none in {len(views)} measurements. "
            "Choose other weights."
        )
    return known


def _view(
    trained: weights.Trained, measurement: Measurement, wraps: NDArray, depth: NDArray
):
    """Images, classes (H, W), `IGNORED` where unknown, and depth (H, W), wraps above the first."""
    network, card = trained
    turns = np.asarray(depth, float) / WRAP
    label = np.asarray(wraps, np.int64) - card.first_wrap
    known = (
        (label >= 0) & (label < card.classes) & np.isfinite(turns) & measurement.mask
    )
    return (
        network_images(without_holes(measurement), network.model.features),
        np.where(known, label, IGNORED),
        np.where(known, turns - card.first_wrap, 0),
    )


def _augmented_crop(view: tuple, network: Network, side: int, rng: Generator) -> Sample:
    """Random crop with a labelled pixel, moved in depth; a sample of NumPy arrays."""
    label, turns, phase, amplitude, *more = _random_window(view, side, rng)
    known = label != IGNORED
    move = 0.0
    if not more:  # raw correlations stay where they are
        move = rng.uniform(-turns[known].min(), network.classes - turns[known].max())
    ratio = np.array(FREQUENCIES)[:, None, None] / FREQUENCY_SINGLE
    label = label + np.floor(phase[0] / TAU + move).astype(int)
    label[~known | (label < 0) | (label >= network.classes)] = IGNORED
    phase = np.mod(phase + TAU * move * ratio, TAU).astype(np.float32)
    inputs = features(phase, amplitude, network.model.features, *more)
    return Sample(inputs, label, phase[0], turns + move)  # pyright: ignore[reportArgumentType]


def _random_window(view: tuple, side: int, rng: Generator) -> list[Array]:
    """Classes, depth and images of a random window with a labelled pixel, turned and mirrored."""
    images, label, turns = view
    place = zip(rng.choice(np.argwhere(label != IGNORED)), label.shape, strict=True)
    y, x = (np.clip(at - rng.integers(side), 0, size - side) for at, size in place)
    window = (..., slice(y, y + side), slice(x, x + side))
    turn = rng.integers(4) * rng.integers(2)  # scenes stand upright more often
    mirror = 1 - 2 * rng.integers(2)
    return [
        np.ascontiguousarray(np.rot90(image[window], turn, (-2, -1))[..., ::mirror])  # pyright: ignore[reportArgumentType, reportCallIssue]
        for image in (label, turns, *images)
    ]
