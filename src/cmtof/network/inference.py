"""Unwrapping with a trained network: a measurement goes in, a wrap or a depth comes out."""

from functools import cache
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from cmtof.baselines import Estimate, within_range, wraps_in_range
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, centred, depth_from_wraps, wrap_length
from cmtof.measurement import Measurement
from cmtof.network.configuration import MODELS
from cmtof.network.features import features, needs_correlation
from cmtof.network.rapid import mended
from cmtof.network.weights import Trained, find_weights, load_weights
from cmtof.simulation import QUADRATURES


def unwrap_with_network(
    measurement: Measurement, *, model: str = "fast-scnn", weights: str | Path | None = None
) -> Estimate:
    """Classify each pixel's wrap with a network (Sec. 5), or regress its depth.

    Classes outside the measurement's range are not considered. The confidence is the probability
    that the network gives its choice; where mending chose another wrap, the most that it can have
    given that one: no more than to its own choice, nor than what that left. A regression says
    nothing of single pixels: its confidence is the same everywhere, the share of validation pixels
    whose wrap was right, as its card tells.

    Parameters
    ----------
    measurement : Measurement
        At the two frequencies of the prototype.
    model : str
        Out of `cmtof.network.configuration.MODELS`; of its shipped weights those with the fewest
        classes are taken that know every wrap in range.
    weights : str or Path, optional
        One's own ``.safetensors``, its card beside it.

    Raises
    ------
    ValueError
        If no weights know the range, the frequencies are others, or the network reads raw
        correlations and the measurement has none at the four quadratures.
    """
    found = np.asarray(measurement.frequencies[:2], float)
    if not np.allclose(found, FREQUENCIES, rtol=1e-6):
        raise ValueError(
            f"Expected {' and '.join(f'{f / 1e9:g}' for f in FREQUENCIES)} GHz, which the weights "
            f"were trained at, got {' and '.join(f'{f / 1e9:g}' for f in found)}. Choose the "
            "method beat."
        )
    first, last = wraps_in_range(measurement)
    path = Path(weights) if weights is not None else find_weights(model, first, last)
    trained = _loaded(path, path.stat().st_mtime_ns if path.is_file() else 0)
    start = first - trained.first
    if start < 0 or last - trained.first >= trained.card["classes"]:
        raise ValueError(
            f"Expected wraps within {trained.first} to "
            f"{trained.first + trained.card['classes'] - 1}, which {path.name} tells apart, got "
            f"{first} to {last}. Narrow the range."
        )
    # a masked pixel may be no number: to the network it is dark, or its neighbours would be none
    phase, amplitude = (
        np.nan_to_num(np.asarray(images[:2], np.float32))
        for images in (measurement.phase, measurement.amplitude)
    )
    chosen = MODELS[trained.card["model"]]
    images = quadrature_images(measurement) if needs_correlation(chosen.features) else None
    inputs = features(phase, amplitude, chosen.features, images)
    if chosen.target == "depth":
        depth = (trained.first + regress(trained, inputs)) * wrap_length(FREQUENCIES[0])
        sure = np.full(depth.shape, trained.validated)
        return Estimate(within_range(depth, measurement), sure)
    likeliest, odds = classify(trained, inputs, start, last - trained.first + 1)
    if chosen.mended:
        voted = np.clip(mended(likeliest, phase[0]), 0, last - first)
        likeliest, odds = voted, np.where(voted == likeliest, odds, np.minimum(odds, 1 - odds))
    depth = depth_from_wraps(phase[0].astype(float), first + likeliest, measurement.frequencies[0])
    return Estimate(depth, odds)


def quadrature_images(measurement: Measurement) -> np.ndarray:
    """Correlation images at the four quadratures, (2, 4, H, W), counts, float32.

    Taken by their reference phases, in whatever order they stand; what is not a number is 0.

    Raises
    ------
    ValueError
        If the measurement keeps no correlations, or lacks a quadrature at one of two frequencies.
    """
    if "correlation" not in measurement.dataset:
        raise ValueError(
            "Expected raw correlations, which the network reads, got phases alone. Keep them, or "
            "choose a method that reads phases."
        )
    psi = measurement.dataset["psi"].to_numpy()[:2]
    off = np.abs(centred(psi[:, :, None] - np.asarray(QUADRATURES)))
    if (off.min(1) > 1e-6).any():
        raise ValueError(
            "Expected correlations at psi = 0, 1/2, 1 and 3/2 pi, which the network was trained "
            f"on, got {np.round(psi[0] / TAU, 4).tolist()} turns. Measure those, or choose "
            "another method."
        )
    images = measurement.dataset["correlation"].to_numpy()
    found = np.stack([images[f, order] for f, order in enumerate(off.argmin(1))])
    return np.nan_to_num(found.astype(np.float32))


def regress(trained: Trained, inputs: np.ndarray) -> np.ndarray:
    """Depth (H, W), wraps above the first class, of features (C, H, W), float32."""
    with torch.inference_mode():
        found = trained.network.in_bands(torch.from_numpy(inputs)[None], lambda turns: turns)
    return found[0, 0].numpy().astype(float)


def classify(
    trained: Trained, inputs: np.ndarray, start: int = 0, stop: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Likeliest of the classes ``start <= n < stop``, counted from ``start``, and its odds.

    Parameters
    ----------
    trained : Trained
    inputs : ndarray, shape (C, H, W)
        Features, float32.

    Returns
    -------
    likeliest, odds : ndarray, shape (H, W)
    """

    def best(weights: Tensor) -> Tensor:
        odds, likeliest = torch.softmax(weights[:, start:stop], 1).max(1, keepdim=True)
        return torch.cat([likeliest.to(odds.dtype), odds], 1)

    with torch.inference_mode():
        found = trained.network.in_bands(torch.from_numpy(inputs)[None], best)[0].numpy()
    return found[0].astype(np.int64), found[1]


@cache
def _loaded(path: Path, changed: int) -> Trained:
    return load_weights(path)
