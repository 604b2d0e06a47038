"""Fine-tuning of a trained network on labelled measurements of an instrument (Sec. 6.4)."""

from collections.abc import Sequence
from copy import deepcopy
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.utils.data import default_collate

from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU
from cmtof.measurement import Measurement
from cmtof.network import weights
from cmtof.network.data import WRAP, Sample
from cmtof.network.features import features
from cmtof.network.inference import network_images
from cmtof.network.losses import IGNORED
from cmtof.network.training import (
    average_into,
    keep_pages,
    loss_of,
    norms,
    optimizer_of,
)
from cmtof.types import Array, Numbers


class View(NamedTuple):
    """An example: images of a measurement, and what is known of each pixel."""

    images: Sequence[NDArray]
    label: NDArray  # class, `IGNORED` where unknown
    turns: NDArray  # true depth, wraps above the first class


def fine_tune(
    trained: weights.Trained,
    examples: Sequence[tuple[Measurement, Numbers, Array]],
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
    depths, for a few scans hold few wraps; norms keep their means. Returned are losses and a tuned
    copy, the average over the last hundred steps.
    """
    card = trained.card
    keep_pages()
    average = deepcopy(trained.network).requires_grad_(False)
    network = deepcopy(trained.network).to(memory_format=torch.channels_last).train()
    views = [_view(trained, *example) for example in examples]
    views = [view for view in views if (view.label != IGNORED).any()]
    if not views:
        raise ValueError(
            f"Expected labels among the wraps {card.first_wrap} to "
            f"{card.first_wrap + card.classes - 1}, got none in {len(examples)} measurements. "
            "Choose other weights."
        )
    for layer in norms(network):
        layer.eval()
    crop = min(crop, *(min(view.label.shape) for view in views))
    rng = np.random.default_rng(seed)
    losses = []
    optimizer = optimizer_of(network, "muon", learning_rate)
    fall = torch.optim.lr_scheduler.LinearLR(optimizer, 1.0, 0.0, steps)
    for step in range(steps):
        drawn = rng.integers(len(views), size=batch)
        pieces = [
            _piece(views[k], card.classes, crop, network.model.features, rng)
            for k in drawn
        ]
        loss = loss_of(network, default_collate(pieces))
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), 2.0)
        optimizer.step()
        fall.step()
        average_into(average, network, step, 0.99)
        losses.append(loss.item())
    note = {
        "steps": steps,
        "learning_rate": learning_rate,
        "examples": len(views),
        "seed": seed,
    }
    return weights.Trained(
        average.eval(), card.model_copy(update={"fine_tuned": note})
    ), losses


def _view(
    trained: weights.Trained, measurement: Measurement, wraps: NDArray, depth: NDArray
) -> View:
    """An example as the network sees it."""
    network, card = trained
    turns = np.asarray(depth, float) / WRAP
    label = np.asarray(wraps, np.int64) - card.first_wrap
    known = (label >= 0) & (label < card.classes)
    known &= np.isfinite(turns) & measurement.mask
    return View(
        network_images(measurement, network.model.features),
        np.where(known, label, IGNORED),
        np.where(known, turns - card.first_wrap, 0),
    )


def _cut(view: View, side: int, rng: np.random.Generator) -> View:
    """Crop with a labelled pixel, mirrored or turned or neither."""
    chosen = rng.choice(np.argwhere(view.label != IGNORED))
    top, left = (
        np.clip(at - rng.integers(side), 0, size - side)
        for at, size in zip(chosen, view.label.shape, strict=True)
    )
    window = (..., slice(top, top + side), slice(left, left + side))
    turn = rng.integers(4) * rng.integers(2)  # scenes stand upright more often
    mirror = 1 - 2 * rng.integers(2)

    def cut(image: NDArray) -> NDArray:
        turned = np.rot90(image[window], turn, (-2, -1))
        return np.ascontiguousarray(turned[..., ::mirror])

    return View([cut(x) for x in view.images], cut(view.label), cut(view.turns))


def _piece(
    view: View, classes: int, side: int, kind: str, rng: np.random.Generator
) -> Sample:
    """Augmented crop with a labelled pixel; NumPy arrays."""
    (phase, amplitude, *more), label, turns = _cut(view, side, rng)
    known = label != IGNORED
    move = 0.0
    if not more:  # raw correlations stay where they are
        move = rng.uniform(-turns[known].min(), classes - turns[known].max())
    ratio = np.array(FREQUENCIES)[:, None, None] / FREQUENCIES[0]
    label = label + np.floor(phase[0] / TAU + move).astype(int)
    label[~known | (label < 0) | (label >= classes)] = IGNORED
    phase = np.mod(phase + TAU * move * ratio, TAU).astype(np.float32)
    inputs = features(phase, amplitude, kind, *more)
    return Sample(inputs, label, phase[0], turns + move)
