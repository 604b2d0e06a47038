"""Fine-tuning of a trained network on labelled measurements of an instrument (Sec. 6.4)."""

from collections.abc import Sequence
from copy import deepcopy

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
    views = [view for view in views if (view[1] != IGNORED).any()]
    if not views:
        raise ValueError(
            f"Expected labels among the wraps {card.first_wrap} to "
            f"{card.first_wrap + card.classes - 1}, got none in {len(examples)} measurements. "
            "Choose other weights."
        )
    for layer in norms(network):
        layer.eval()
    crop = min(crop, *(min(label.shape) for _, label, _ in views))
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
):
    """Images, classes, `IGNORED` where unknown, and turns above the first class of an example."""
    (network, card), turns = trained, np.asarray(depth, float) / WRAP
    label = np.asarray(wraps, np.int64) - card.first_wrap
    known = (
        (label >= 0) & (label < card.classes) & np.isfinite(turns) & measurement.mask
    )
    images = network_images(measurement, network.model.features)
    return (
        images,
        np.where(known, label, IGNORED),
        np.where(known, turns - card.first_wrap, 0),
    )


def _piece(
    view: tuple, classes: int, side: int, kind: str, rng: np.random.Generator
) -> Sample:
    """Augmented crop with a labelled pixel; NumPy arrays."""
    images, label, turns = view
    place = zip(rng.choice(np.argwhere(label != IGNORED)), label.shape, strict=True)
    y, x = (np.clip(at - rng.integers(side), 0, size - side) for at, size in place)
    window = (..., slice(y, y + side), slice(x, x + side))
    turn = rng.integers(4) * rng.integers(2)  # scenes stand upright more often
    mirror = 1 - 2 * rng.integers(2)
    cut = (
        np.rot90(x[window], turn, (-2, -1))[..., ::mirror]
        for x in (label, turns, *images)
    )
    (label, turns, phase, amplitude, *more), move = map(np.ascontiguousarray, cut), 0.0
    known = label != IGNORED
    if not more:  # raw correlations stay where they are
        move = rng.uniform(-turns[known].min(), classes - turns[known].max())
    ratio = np.array(FREQUENCIES)[:, None, None] / FREQUENCIES[0]
    label = label + np.floor(phase[0] / TAU + move).astype(int)
    label[~known | (label < 0) | (label >= classes)] = IGNORED
    phase = np.mod(phase + TAU * move * ratio, TAU).astype(np.float32)
    return Sample(
        features(phase, amplitude, kind, *more), label, phase[0], turns + move
    )
