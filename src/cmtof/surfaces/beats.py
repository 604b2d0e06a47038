"""Offset of each surface, in wraps, by the beat of both phases pooled over its pixels.

The beat ``phi_2 - 2 phi_1`` of a surface that is m wraps off is ``2 pi m (k_2 / k_1 - 2)``.
Where a spot crosses an outline, a pixel has the beat of neither surface, and lies wraps away from
both. It hardly counts, as far as it is clear enough to be told from the others.
"""

import numpy as np

from cmtof.correlation import TAU, centred
from cmtof.surfaces.field import ENOUGH, Field, sum_nearby
from cmtof.surfaces.roughness import (
    Cells,
    departure,
    pooled_phasors,
    sum_cells,
    turn_both_back,
)
from cmtof.types import Array, Arrays

_AGAIN = 2  # times that beats of rough surfaces are pooled again
_PASSES = 3  # over the cells of a surface, each with new weights
_CREDIBLE = 3.0  # deviations from these beyond which a cell counts less

# Offset (N,), wraps, of each surface by its summed beat; standard deviation; coherence.
Beats = tuple[Array, Array, Array]


def pooled_beats(field: Field, cells: Cells) -> Beats:
    """Offset (N,), wraps, of each surface by its summed beat; standard deviation; coherence.

    Pixels of rough surfaces are turned back by their own departure, which takes a part of the
    offset along: it is pooled again without the offset that was found.
    """
    turn = -1j * TAU * field.excess
    beat, noise, coherence = _beats(field, cells)
    for _ in range(_AGAIN if cells.rough.any() else 0):
        turned = cells.turned.copy()
        turned[1] *= np.exp(turn * np.append(beat, 0)[cells.label])
        sums = sum_cells(turned, cells.side)
        left, noise, coherence = _beats(field, cells._replace(turned=turned, sums=sums))
        beat += left
    return beat, noise, coherence


def _beats(field: Field, cells: Cells) -> Beats:
    """Beats of surfaces by one pooling, in which cells far from their surface's mean count less."""
    turned = cell_phasors(field, cells)
    lag, known = lags_of_phasors(field, turned, cells.information)
    weight = np.ones(1)
    for _ in range(_PASSES):
        mean = _weighted_beats(field, cells, turned, weight)[0]
        off = lag - np.append(mean, 0)[cells.main]
        weight = _CREDIBLE**2 / np.maximum(known * off**2, _CREDIBLE**2)
    return _weighted_beats(field, cells, turned, weight)


def _weighted_beats(field: Field, cells: Cells, turned: Array, weight: Array) -> Beats:
    """`Beats` of surfaces by the phasors (2, h, w) of their cells, times weights (h, w)."""
    total, most = pooled_phasors(
        cells.main, weight * turned, weight * cells.information, cells.rough.size
    )
    low, high = np.angle(total)
    beat = centred(high - field.multiple * low) / (TAU * field.excess)
    coherence = np.maximum(np.abs(total), 1e-9) / most
    known = information_of_beats(field, most * coherence**2)
    return beat, 1 / np.sqrt(known), coherence.min(axis=0)


def lags_of_phasors(field: Field, turned: Array, information: Array) -> Arrays:
    """Offset (h, w), wraps, by the beat of each cell's phasors (2, h, w); its inverse variance."""
    low, high = turned.imag / np.maximum(information, 1e-6)
    lag = (high - field.multiple * low) / (TAU * field.excess)
    return lag, information_of_beats(field, information)


def information_of_beats(field: Field, information: Array) -> Array:
    """Inverse variance (h, w), 1 / wraps^2, of beats by the information of both phases."""
    lower, higher = information.astype(float)
    both = np.maximum(lower + field.multiple**2 * higher, 1e-9)
    return (TAU * field.excess) ** 2 * lower * higher / both


def cell_phasors(field: Field, cells: Cells) -> Array:
    """Phasors (2, h, w) of cells, turned back by the departure in depth that both phases share."""
    sums = cells.sums
    multiple = field.multiple
    rough = np.append(cells.rough, 0)[cells.label]
    if rough.any():  # pixels are turned back by their own departure first
        off = departure(field, cells.turned, rough)
        turned = cells.turned.copy()
        there = off != 0
        turned[:, there] = turn_both_back(field, turned[:, there], off[there])
        sums = sum_cells(turned, cells.side)
    near = _with_neighbours(cells, sums) if cells.side > 1 else sums
    low = np.angle(near[0])
    high = np.angle(turn_both_back(field, near, low)[1])
    lower, higher = np.abs(near)
    pull = higher * multiple * high / (lower + multiple**2 * higher + 1e-9)
    return turn_both_back(field, sums, low + pull)


def _with_neighbours(cells: Cells, sums: Array) -> Array:
    """Phasors (2, h, w) of cells, summed with neighbours' where their information is small."""
    both = np.concatenate([sums, cells.information])
    found = both
    for radius in (1, 2, 4):  # six functions miss what these turn back
        information = found[2:].real.sum(axis=0)  # pyright: ignore[reportAttributeAccessIssue]
        wider = sum_nearby(both, cells.main, radius)
        found = np.where(information < ENOUGH, wider, found)
    return found[:2]
