"""Parts of a surface that become surfaces of their own.

Growing joins what has the same phases. Parts that do not touch may be better described alone, and
what lies at whole wraps of distance has the same phases, but another beat.
"""

from functools import partial

import numpy as np
from scipy.ndimage import maximum

from cmtof.classical.region import components
from cmtof.surfaces.beats import cell_phasors, lags_of_phasors
from cmtof.surfaces.field import Field, pixels_of_cells, sum_nearby
from cmtof.surfaces.fitting import EFFORT, fit_surfaces
from cmtof.surfaces.roughness import Cells, cells_of_surfaces, sum_surfaces
from cmtof.types import Array, Flags, Numbers

_LEAST = 6  # size, cells, of a part
_ALONE = 20.0  # gain in S from which on a piece is a surface of its own
_CUT = 20.0  # least gain, as a log-likelihood, of a part whose beat steps,
_EDGE = 0.12  # also per cell of its border, since halves of noise gain by their cells,
_APART = 0.7  # and its least distance, wraps
_CUTS = 3  # rounds of cutting


def cut_surfaces(
    field: Field,
    inner: Numbers,
    surfaces: Array,
    gain: float,
) -> tuple[Numbers, Array]:
    """Surface at the middle of each cell (h, w), and all surfaces (N, 7), new parts last.

    Two planes at whole wraps of distance have the same phases and grow as one. They are parted if
    that gains more log-likelihood than `_CUT`, and than `_EDGE` for each cell along the border.
    """
    cells = cells_of_surfaces(field, inner, surfaces)
    lags = lags_of_phasors(field, cell_phasors(field, cells), cells.information)
    main, surfaces = _part_pieces(field, cells, surfaces, gain)
    for _ in range(_CUTS):
        count = len(surfaces)
        ahead, apart, won, sizes = _halves(main, *lags, count)
        good = won > np.maximum(_CUT, _EDGE * _borders_of_halves(main, ahead, count))
        good &= sizes.min(axis=0) >= _LEAST
        good &= abs(apart) > _APART
        good[count] = False  # of cells without a surface
        new = count + good.cumsum() - 1
        main = np.where(ahead & good[main], new[main], main)
        surfaces = np.concatenate([surfaces, surfaces[good[:count]]])
    return main, surfaces


def _part_pieces(
    field: Field,
    cells: Cells,
    surfaces: Array,
    gain: float,
) -> tuple[Numbers, Array]:
    """Surface of each cell (h, w), and surfaces (N, 7), with pieces added that fit better alone."""
    number, parent = _pieces(cells.main)
    label = np.where(cells.label >= 0, pixels_of_cells(number), -1)
    found, _ = fit_surfaces(field, label, surfaces[parent], EFFORT, gain)
    alone = cells_of_surfaces(field, label, found)
    won = (alone.sums - cells.sums).real.sum(axis=0)
    good = sum_surfaces(number, won, len(found))[:-1] > _ALONE
    new = np.where(good, len(surfaces) + good.cumsum() - 1, parent)
    main = np.where(number >= 0, np.append(new, -1)[number], cells.main)
    return main, np.concatenate([surfaces, found[good]])


def _pieces(main: Numbers) -> tuple[Numbers, Numbers]:
    """Number of each cell's piece (h, w), -1 for none, and the surface (P,) of each piece.

    A piece touches no other one of its surface. The largest of each is left out.
    """
    pieces = components(main[1:] == main[:-1], main[:, 1:] == main[:, :-1])
    size = np.bincount(pieces.ravel())
    parent = np.zeros_like(size)
    parent[pieces] = main
    tried = size < maximum(size, parent, parent)
    tried &= (size >= _LEAST) & (parent >= 0)
    number = np.where(tried, tried.cumsum() - 1, -1)
    return number[pieces], parent[tried]


def _halves(
    main: Numbers, lag: Array, weight: Array, count: int
) -> tuple[Flags, Array, Array, Array]:
    """Halves of surfaces by their beats: cells (h, w) ahead, wraps apart, log-likelihood gained.

    The last two (N + 1,) are also those of cells without a surface, and so are the sizes of both
    halves (2, N + 1), cells.
    """
    summed = partial(sum_surfaces, main, count=count)
    middle = (summed(weight * lag) / np.maximum(summed(weight), 1e-9))[main]
    turn = 1.0
    for radius in (1, 2, 2, 2, 2):
        ahead = sum_nearby(weight * (lag - middle) * turn, main, radius) > 0
        sides = np.array([~ahead, ahead])
        known = np.maximum(summed(weight * sides), 1e-9)
        rest, part = summed(weight * lag * sides) / known
        middle = ((part + rest) / 2)[main]
        turn = (part - rest)[main]
    apart = part - rest
    gain = apart**2 / (1 / known).sum(axis=0) / 2
    return ahead, apart, gain, summed(sides)


def _borders_of_halves(main: Numbers, ahead: Flags, count: int) -> Array:
    """Length (N + 1,), cells, of the border between both halves of each surface."""
    border = np.zeros(count + 1)
    for axis in (0, 1):
        here = np.delete(main, 0, axis)
        inside = np.diff(main, axis=axis) == 0
        border += sum_surfaces(here, inside & np.diff(ahead, axis=axis), count)
    return border
