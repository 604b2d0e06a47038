"""A network and surfaces together: the surfaces say which pixels share an offset, both say which.

Pixels of a group of surfaces are off by the same number m of wraps. Beat and shape give m a
Gaussian, the network the mean of its log-odds over these pixels:

``log P(m) = log(N(m; mean, spread) + r) + w mean_p log p_p(n_p + m)``.

The mean over the pixels counts as ``w`` of them, since a network errs alike on a whole surface.
"""

from pathlib import Path

import numpy as np
from scipy.sparse import csr_array
from scipy.special import log_softmax, softmax
from scipy.stats import norm

from cmtof.correlation import wrap_length
from cmtof.estimate import Estimate, without_holes, wraps_in_range
from cmtof.measurement import Measurement
from cmtof.network.inference import network_for, scores
from cmtof.surfaces import surfaces
from cmtof.surfaces.placing import Tied
from cmtof.types import Array, Numbers, Single

# the best of 18 settings on 12 views of validation rooms, 768 x 1024:
PIXELS, STRAY = 3.0, 5e-4  # weight w, and density r of groups that lie anywhere, per wrap
LEAST = -8.0  # log-odds below which a network is not believed
MOVES = np.arange(-20, 21)  # of a group, wraps
_SHARPEST = 0.01  # least variance of an offset, wraps^2


def hybrid(measurement: Measurement, *, weights: str | Path | None = None) -> Estimate:
    """Surfaces whose wraps a network helps to choose by its odds, averaged over each."""
    network = network_for(measurement, "fast-scnn", weights)
    first, last = wraps_in_range(measurement)
    odds = log_softmax(scores(network, without_holes(measurement), first, last), axis=0)
    period = float(wrap_length(measurement.frequencies[0]))

    def elect(tied: Tied, depth: Array, label: Numbers) -> Tied:
        surface = label[label >= 0]
        wraps = np.floor(depth[label >= 0] / period + tied.wraps[surface]).astype(int) - first
        told = means_of_groups(odds[:, label >= 0], wraps, tied.group[surface], tied.wraps.size)
        return elected(tied, told[tied.group])

    return surfaces(measurement, elect=elect)


def means_of_groups(odds: Single, wraps: Numbers, group: Numbers, count: int) -> Array:
    """Mean log-odds (G, M) of each group at each move, from those (N, P) of its pixels (P,)."""
    reach = MOVES[-1]
    padded = np.pad(np.maximum(odds, LEAST), [(reach, reach), (0, 0)], constant_values=LEAST)
    at = np.clip(wraps[:, None] + MOVES + reach, 0, len(padded) - 1)
    pixels = np.arange(wraps.size)
    members = csr_array((np.ones(wraps.size), (group, pixels)), shape=(count, wraps.size))
    size = np.maximum(members.sum(axis=1), 1)
    return members @ padded[at, pixels[:, None]] / size[:, None]


def elected(tied: Tied, told: Array) -> Tied:
    """Surfaces at their likeliest moves, by their own offset and what was told (N, M) of each."""
    off = (tied.mean - tied.wraps)[:, None]
    prior = norm.pdf(MOVES, off, tied.spread[:, None])
    share = softmax(np.log(prior + STRAY) + PIXELS * told, axis=1)
    mean = share @ MOVES
    variance = np.maximum(share @ MOVES**2 - mean**2, _SHARPEST)
    wraps = tied.wraps + MOVES[share.argmax(axis=1)]
    return tied._replace(wraps=wraps, mean=tied.wraps + mean, spread=np.sqrt(variance))
