"""How noisy the phase means of one burst are: the filters' memory from sample to sample."""

import numpy as np
from numpy.typing import NDArray

from cmtof.instrument.electronics import Chain

Array = NDArray[np.float64]


def mean_weights(phases: int, samples: int, settle: int) -> Array:
    """Weights (K, T) that turn the samples of a burst into the mean of each phase.

    Examples
    --------
    >>> mean_weights(2, 3, 1).tolist()
    [[0.0, 0.5, 0.5, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.5, 0.5]]
    """
    kept = np.arange(samples) >= settle
    return np.kron(np.eye(phases), kept / kept.sum())


def phase_covariance(filters: Chain, density: Array, weights: Array) -> Array:
    r"""Covariance (N, K, K) of weighted sums of a chain's output, V^2.

    With the state's covariance :math:`P_{t+1} = T P_t T^\top + d_t Q` and the output the last
    state, :math:`\mathrm{cov}(x_{t+l}, x_t) = e^\top T^l P_t e`.

    Parameters
    ----------
    filters : Chain
    density : ndarray, shape (N, T)
        One-sided noise density at each sample, V^2/Hz.
    weights : ndarray, shape (K, T)
        Of the samples in each sum.
    """
    step, last = filters.transition, np.eye(len(filters.transition))[-1]
    added = filters.root @ filters.root.T
    state = density[:, 0, None, None] * (filters.settled @ filters.settled.T)
    columns = np.empty((*density.shape, last.size))
    for t in range(density.shape[1]):
        columns[:, t] = state[:, :, -1]
        state = step @ state @ step.T + density[:, t, None, None] * added
    # sum over l of weights(t + l) e T^l, from the end backwards; the sample itself counts half,
    # for the transpose brings the other half
    later = np.zeros((len(weights), last.size))
    half = np.empty((weights.shape[1], *later.shape))
    for t in reversed(range(weights.shape[1])):
        later = later @ step
        half[t] = later + weights[:, t, None] * last / 2
        later = later + weights[:, t, None] * last
    one_sided = np.einsum("kt,tjc,ntc->nkj", weights, half, columns, optimize=True)
    return one_sided + one_sided.transpose(0, 2, 1)
