"""The trigger line that the read-out drives and both RF drivers listen to."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.instrument.panel import Panel, RfKnobs


def pulses_from_levels(levels: ArrayLike, before: bool) -> NDArray[np.int64]:
    """Number of the last rising edge at each scan, from 0; -1 before the first.

    Parameters
    ----------
    levels : array_like of bool (scans,)
        Level of the line during each scan.
    before : bool
        Level before the first.

    Examples
    --------
    >>> pulses_from_levels([0, 1, 0, 1, 1], before=False).tolist()
    [-1, 0, 0, 1, 1]
    >>> pulses_from_levels([1, 0, 1], before=True).tolist()  # high already: no edge
    [-1, -1, 0]
    """
    high = np.asarray(levels, bool)
    rising = high & ~np.concatenate(([before], high[:-1]))
    return np.cumsum(rising) - 1


def advance(knobs: RfKnobs, edges: int) -> None:
    """Step the phase table of one RF driver by a number of rising edges.

    The first edge after arming selects entry 0, each further one the next, wrapping.

    Examples
    --------
    >>> knobs = RfKnobs(table=np.zeros(16), armed=True, trigger=True)
    >>> advance(knobs, 16)
    >>> knobs.index, knobs.edges, knobs.armed
    (15, 16, False)
    >>> advance(knobs, 1)
    >>> knobs.index
    0
    """
    if not knobs.trigger or edges <= 0:
        return
    knobs.edges += edges
    if knobs.armed:
        knobs.armed, knobs.index = False, 0
        edges -= 1
    if knobs.table.size:
        knobs.index = (knobs.index + edges) % knobs.table.size


def pull(panel: Panel, edges: int) -> None:
    """Rising edges of the line, seen by both RF drivers."""
    with panel.lock:
        advance(panel.emission, edges)
        advance(panel.detection, edges)
