"""Unwrapping by surfaces and a network: both help to choose the wrap offset of each surface.

Each surface is off by a number m of wraps. Its beat and shape give m a Gaussian, the network the
mean of its log-odds over the pixels of the surface, and contacts join surfaces as without it:

``log P(m) = log N(m; mean, spread) + mean_p log p_p(n_p + m)``.

All pixels of a surface count as one, since a network errs alike on a whole surface.
"""

from pathlib import Path

import numpy as np
from scipy.special import log_softmax

from cmtof.correlation import wrap_length
from cmtof.estimate import Estimate, without_holes, wraps_in_range
from cmtof.measurement import Measurement
from cmtof.surfaces import surfaces
from cmtof.types import Array, Numbers

LEAST = -8.0  # log-probability below which the network's is clipped


def hybrid(measurement: Measurement, *, weights: Path | None = None) -> Estimate:
    """Surfaces whose wraps a network helps to choose, by its log-odds averaged over each."""
    # not every method needs ONNX Runtime
    from cmtof.network.inference import log_odds, network_for

    network = network_for(measurement, "fast-scnn", weights)
    first, last = wraps_in_range(measurement)

    # 358 wraps need much memory, and surfaces that are grown by then little
    def prior(depth, label, offsets):
        odds = np.empty((last - first + 1, *measurement.shape), np.float16)
        for rows, new in log_odds(network, without_holes(measurement), mirrored=True):
            odds[:, rows] = log_softmax(new, axis=0)
        turns = depth / wrap_length(measurement.frequencies[0]) - first
        return means_of_surfaces(odds, turns, label, offsets)

    return surfaces(measurement, prior=prior)


def means_of_surfaces(
    odds: Array, turns: Array, label: Numbers, offsets: Numbers
) -> Array:
    """Mean log-odds (N, M) of N surfaces at their M offsets (N, M), wraps; 0 without pixels.

    ``odds`` are images (C, H, W); ``turns`` (H, W) is the depth before any offset, in wraps above
    the first of them, and ``label`` (H, W) the surface of each pixel, -1 for none.
    """
    pixels = np.flatnonzero(label >= 0)
    surface = label.take(pixels)
    wraps = np.floor(turns.take(pixels)).astype(int)
    count = np.maximum(np.bincount(surface, minlength=len(offsets)), 1)
    means = np.empty(offsets.shape)
    for k, moved in enumerate(offsets.T):
        at = wraps + moved[surface]
        found = odds.take(at * label.size + pixels, mode="clip")
        clipped = np.where((at < 0) | (at >= len(odds)), LEAST, found.clip(LEAST))
        means[:, k] = np.bincount(surface, clipped, len(offsets)) / count
    return means
