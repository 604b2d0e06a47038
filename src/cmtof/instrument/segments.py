"""Stretches of a burst during which the light is held constant."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LONGEST = 5e-3
"""Longest stretch, s: short against the drifts, the fastest of which takes 2 s."""


class Segments(NamedTuple):
    """S stretches of T samples."""

    of_sample: NDArray[np.intp]
    """(T,) number of the stretch that a sample lies in."""
    edge: NDArray[np.integer]
    """(S,) last edge of the trigger, -1 before the first."""
    middle: NDArray[np.float64]
    """(S,) time of the middle after the burst's start, s."""
    interval: float
    """Time between samples, s."""


def segments_of(edges: NDArray[np.integer], rate: float, *, single: bool = False) -> Segments:
    """Cut a burst at the edges of the trigger and every 5 ms.

    Parameters
    ----------
    edges : ndarray, shape (T,)
        Last edge at each sample.
    rate : float
        Samples a second, Hz.
    single : bool
        Every sample a stretch of its own: for drives that beat.

    Examples
    --------
    >>> segments_of(np.array([0, 0, 0, 1, 1, 1]), 24000.0).of_sample.tolist()
    [0, 0, 0, 1, 1, 1]
    """
    longest = 1 if single else max(1, int(rate * LONGEST))
    sample = np.arange(edges.size)
    new = np.concatenate([[True], edges[1:] != edges[:-1]])
    since = sample - np.maximum.accumulate(np.where(new, sample, 0))
    first = np.flatnonzero(since % longest == 0)
    last = np.append(first[1:], edges.size)
    return Segments(
        np.repeat(np.arange(first.size), last - first),
        edges[first],
        (first + last) / 2 / rate,
        1 / rate,
    )
