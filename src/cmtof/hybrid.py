"""A network and surfaces together: the surfaces say which pixels share an offset, both say which.

Pixels of a group of surfaces are off by the same number m of wraps. Beat and shape give m a
Gaussian, the network the mean of its log-odds over these pixels:

``log P(m) = log(N(m; mean, spread) + r) + w mean_p log p_p(n_p + m)``.

The mean over the pixels counts as ``w`` of them, since a network errs alike on a whole surface.
"""

from pathlib import Path

import numpy as np
from scipy.special import softmax
from scipy.stats import norm

from cmtof.correlation import wrap_length
from cmtof.estimate import Estimate, without_holes, wraps_in_range
from cmtof.measurement import Measurement
from cmtof.surfaces import surfaces
from cmtof.surfaces.contacts import Tied
from cmtof.types import Array, Numbers, Single

# the best of 18 settings on 12 views of validation rooms, 768 x 1024:
PIXELS = 3.0  # weight w
STRAY = 5e-4  # density r of groups that lie anywhere, per wrap
LEAST = -8.0  # log-odds below which a network is not believed
MOVES = np.arange(-20, 21)  # of a group, wraps
_SHARPEST = 1e-4  # least variance of an offset, wraps^2


def hybrid(measurement: Measurement, *, weights: Path | None = None) -> Estimate:
    """Surfaces whose wraps a network helps to choose by its odds, averaged over each."""
    from cmtof.network.inference import (
        network_for,
        scores,
    )  # not every method needs ONNX Runtime

    network = network_for(measurement, "fast-scnn", weights)
    first, last = wraps_in_range(measurement)
    odds = scores(network, without_holes(measurement), first, last)
    odds -= np.log(np.exp(odds).sum(axis=0))  # in place: there may be hundreds of wraps
    period = wrap_length(measurement.frequencies[0])

    def elect(tied, depth, label):
        pixels = np.flatnonzero(label >= 0)
        surface = label.take(pixels)
        turns = depth.take(pixels) / period + tied.wraps[surface]
        wraps = np.floor(turns).astype(int) - first
        told = means_of_groups(
            odds, pixels, wraps, tied.group[surface], tied.wraps.size
        )
        return elected(tied, told[tied.group])

    return surfaces(measurement, elect=elect)


def means_of_groups(
    odds: Single, pixels: Numbers, wraps: Numbers, group: Numbers, count: int
) -> Array:
    """Mean log-odds (G, M) of so many groups at each move.

    ``odds`` are images (N, H, W); ``pixels`` number those that count (P,), beside them their wraps
    before the move and their groups.
    """
    at = wraps[:, None] + MOVES
    told = odds.take(at * odds[0].size + pixels[:, None], mode="clip")
    total = np.zeros((count, MOVES.size))
    outside = (at < 0) | (at >= len(odds))
    told = np.where(outside, LEAST, told).clip(LEAST)
    np.add.at(total, group, told)
    return total / np.maximum(np.bincount(group, minlength=count), 1)[:, None]


def elected(tied: Tied, told: Array) -> Tied:
    """Surfaces at their likeliest moves, by their own offset and what was told (N, M) of each."""
    mean = tied.share @ tied.moves
    spread = np.sqrt(np.maximum(tied.share @ tied.moves**2 - mean**2, _SHARPEST))
    prior = norm.pdf(MOVES, mean[:, None], spread[:, None])
    return tied.moved(softmax(np.log(prior + STRAY) + PIXELS * told, axis=1))
