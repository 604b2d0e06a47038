"""Unwrapping with a trained network: a measurement goes in, the likeliest wrap comes out."""

from functools import cache
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from cmtof.baselines import Estimate, wraps_in_range
from cmtof.constants import FREQUENCIES
from cmtof.correlation import depth_from_wraps
from cmtof.measurement import Measurement
from cmtof.network.configuration import MODELS
from cmtof.network.features import features
from cmtof.network.weights import Trained, find_weights, load_weights


def unwrap_with_network(
    measurement: Measurement, *, model: str = "fast-scnn", weights: str | Path | None = None
) -> Estimate:
    """Classify each pixel's wrap with a network (Sec. 5).

    Classes outside the measurement's range are not considered. The confidence is the probability
    that the network gives its choice.

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
        If no weights know the range, or the frequencies are others.
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
    inputs = features(
        phase,
        amplitude,
        MODELS[trained.card["model"]].features,
    )
    likeliest, odds = classify(trained, inputs, start, last - trained.first + 1)
    depth = depth_from_wraps(phase[0].astype(float), first + likeliest, measurement.frequencies[0])
    return Estimate(depth, odds)


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
