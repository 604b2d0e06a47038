"""Where a method is right: counts of pixels by brightness, wrap, distance to an edge, surface size.

Pixels are sorted into bins frame by frame, so that `cmtof.resampling` can draw frames again.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.correlation import wrap_count_from_depth
from cmtof.measurement import Measurement
from cmtof.scenes.frame import Frame
from cmtof.scenes.statistics import bends, surface_sizes

MOST_WRAPS = 21
"""Bins that wrap counts are sorted into, at most."""


class Stratum(NamedTuple):
    """A quantity that pixels are sorted by."""

    label: str
    """Quantity and unit, for an axis."""
    edges: tuple[float, ...]
    """Ends of the bins; the first and the last also take what lies beyond."""
    scale: str = "linear"
    """Of an axis."""

    @property
    def middles(self) -> NDArray[np.float64]:
        """A value within each bin (B,): the geometric mean of its ends where the axis asks so."""
        ends = np.asarray(self.edges)
        if self.scale == "log":
            return np.sqrt(ends[1:] * ends[:-1])
        return (ends[1:] + ends[:-1]) / 2


def strata_of(first: int, last: int) -> dict[str, Stratum]:
    """Strata of a protocol that tells the wraps first to last, by name.

    Examples
    --------
    >>> strata_of(36, 56)["wrap"].edges[:3], strata_of(0, 357)["wrap"].edges[:3]
    ((35.5, 36.5, 37.5), (-0.5, 17.5, 35.5))
    """
    width = -(-(last + 1 - first) // MOST_WRAPS)
    wraps = np.arange(first, last + width + 1, width) - 0.5
    return {
        "intensity": Stratum(
            "brightness I", (0.005, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.0), "log"
        ),
        "patch": Stratum(
            "size of a pixel's surface (px)", (1, 10, 100, 1000, 5000, 20000, 100000), "log"
        ),
        "wrap": Stratum("true wrap count", tuple(wraps.tolist())),
        "edge": Stratum("distance to an edge (px)", (0.7, 1.5, 3, 6, 12, 24, 48, 96), "log"),
    }


def strata_values(frame: Frame, measurement: Measurement) -> dict[str, NDArray[np.float64]]:
    """The quantities of `strata_of` for each scored pixel of a frame.

    Edges and surfaces are those of the depth that was measured, after the protocol's staging: cut
    where it bends by 4 mm, a fifth of a wrap, which is what a method could follow.

    Parameters
    ----------
    frame : Frame
        What the measurement was simulated from; of it the brightness.
    measurement : Measurement
        With its true depth.

    Returns
    -------
    dict of ndarray, shape (P,)
        In the order of `cmtof.metrics.scored_pixels`. Pixels on an edge have distance 0 and a
        surface of one pixel.

    Raises
    ------
    ValueError
        If the measurement holds no true depth.
    """
    from scipy.ndimage import distance_transform_edt

    truth = measurement.depth
    if truth is None:
        raise ValueError("Expected a measurement with its true depth, got none. Simulate one.")
    scored = measurement.mask & np.isfinite(truth)
    ends = bends(truth)
    far = np.asarray(distance_transform_edt(~ends)) if ends.any() else np.full(ends.shape, np.inf)
    return {
        "intensity": np.clip(frame.intensity, 0, 1)[scored].astype(float),
        "patch": surface_sizes(ends)[scored].astype(float),
        "wrap": wrap_count_from_depth(
            truth[scored].astype(float), measurement.frequencies[0]
        ).astype(float),
        "edge": far[scored].astype(float),
    }


def bin_of(values: ArrayLike, edges: ArrayLike) -> NDArray[np.int64]:
    """Bin that each value falls into; the outer bins take what lies beyond.

    Examples
    --------
    >>> bin_of([0.0, 1.0, 1.5, 9.0], [1, 1.2, 2]).tolist()
    [0, 0, 1, 1]
    """
    edges = np.asarray(edges, float)
    place = np.searchsorted(edges, np.asarray(values, float), side="right") - 1
    return np.clip(place, 0, edges.size - 2)


def counted(place: ArrayLike, bins: int, chosen: ArrayLike | None = None) -> NDArray[np.int64]:
    """Pixels in each bin (B,), all or only the chosen ones.

    Parameters
    ----------
    place : array_like of int, shape (P,)
        From `bin_of`.
    bins : int
    chosen : array_like of bool, shape (P,), optional
    """
    place = np.asarray(place)
    kept = place if chosen is None else place[np.asarray(chosen, bool)]
    return np.bincount(kept, minlength=bins)
