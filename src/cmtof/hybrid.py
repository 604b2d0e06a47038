"""Unwrapping by surfaces and a network: surfaces share an offset, which both help to choose.

Each surface is off by a number m of wraps. Its beat and shape give m a Gaussian, the network the
mean of its log-odds over the pixels of the surface, and contacts join surfaces as without it:

``log P(m) = log N(m; mean, spread) + w mean_p log p_p(n_p + m)``.

The mean over the pixels counts as ``w`` of them, since a network errs alike on a whole surface.
"""

from pathlib import Path

import numpy as np

from cmtof.correlation import wrap_length
from cmtof.estimate import Estimate, without_holes, wraps_in_range
from cmtof.measurement import Measurement
from cmtof.surfaces import surfaces
from cmtof.types import Array, Numbers, Single

PIXELS = 1.0  # weight w
LEAST = -8.0  # log-probability below which the network's is clipped


def hybrid(measurement: Measurement, *, weights: Path | None = None) -> Estimate:
    """Surfaces whose wraps a network helps to choose, by its log-odds averaged over each."""
    # not every method needs ONNX Runtime
    from cmtof.network.inference import network_for, scores

    network = network_for(measurement, "fast-scnn", weights)
    first, last = wraps_in_range(measurement)
    odds = scores(network, without_holes(measurement), first, last, mirrored=True)
    odds -= np.log(np.exp(odds).sum(axis=0))  # in place: there may be hundreds of wraps
    period = wrap_length(measurement.frequencies[0])

    def told(depth, label, offsets):
        turns = depth / period - first
        return PIXELS * means_of_surfaces(odds, turns, label, offsets)

    return surfaces(measurement, told=told)


def means_of_surfaces(
    odds: Single, turns: Array, label: Numbers, offsets: Numbers
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
