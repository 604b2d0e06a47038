"""Planes begin in windows and grow over cells of 8 px, which then take the likeliest one nearby."""

from typing import NamedTuple

import numpy as np

from cmtof.compiled import inlined, njit
from cmtof.surfaces.blocks import cell_likelihood, frequency_sums, region_of_boxes
from cmtof.surfaces.field import CELL, Field, pixels_of_cells
from cmtof.surfaces.fitting import boxes_of_cells, fit_plane_or_bent, fit_surfaces
from cmtof.surfaces.roughness import sum_cells
from cmtof.surfaces.shapes import BENT, is_possible
from cmtof.surfaces.windows import FREE, WINDOWS, plane_in_window, windows
from cmtof.types import Array, Numbers

# Share S / E that a plane must reach
_START = 0.75  # to begin in a window,
_JOIN = 0.6  # to grow into a cell,
_STAY = 0.5  # and to keep it.
GAIN = 15.0  # in S from which on a surface counts as bent
ROUGHEST = 0.9  # variance, rad^2, of the depths about a surface, up to which it is one
_ROUGHER = 0.1  # by which it may grow beyond that of the window in which it began
_SURE = 6.0  # deviations of S from noise for a rough surface to begin
_ALIKE = (
    0.08,
    2.0,
)  # tolerance of its coherence at the higher frequency, and in deviations
_STEPS = np.int64(2)  # of a fit
_CELLS = np.int64(100)  # of a surface that it looks at
_BESIDE = ((1, 0), (-1, 0), (0, 1), (0, -1))  # steps down and right
_ROUNDS = 6  # of reassignment
_NEIGHBOURLY = 3.0  # gain in S per neighbour in the same surface


class Grid(NamedTuple):
    """Cells on which surfaces grow, (h, w) each."""

    owner: Numbers  # surface of each, -1 for none
    stamp: Numbers  # the last window whose surface has entered
    information: Array  # E (2, h, w)


class Seed(NamedTuple):
    """A plane as it begins in a window, its roughness, and how rough it may become in growing."""

    q: Array
    rough: float  # variance, rad^2, of the depths about it; negative if it is none
    most: float  # up to which it may grow


def grown_surfaces(
    field: Field, *, gain: float = GAIN, roughest: float = ROUGHEST
) -> tuple[Numbers, Array]:
    """Owner of each cell, -1 for none, and the surfaces (N, 7) grown from windows.

    Their parameters, and their roughness: the variance of pixels about them, rad^2; those that
    begin rougher than ``roughest`` are none.
    """
    information = sum_cells(field.information.astype(float))
    shape = information.shape[1:]
    owner = np.full(shape, -1)
    surfaces = np.zeros((0, BENT + 1))
    for kind in WINDOWS:
        for start in windows(field, owner, *kind):
            grid = Grid(owner, np.zeros(shape, int), information)
            added = _grow(field, grid, start, gain, roughest, len(surfaces))
            surfaces = np.concatenate([surfaces, added])
    for turn in range(_ROUNDS):
        owner = _reassign_cells(field, owner, surfaces, information)
        if turn % 2:
            label = pixels_of_cells(owner)
            surfaces, _ = fit_surfaces(field, label, surfaces, (_STEPS, _CELLS), gain)
    return owner, surfaces


@njit()
def _grow(field, grid, start, gain, roughest, count):  # pragma: no cover - compiled
    """Grow surfaces from windows, numbered from ``count`` on; return their parameters."""
    surfaces = np.zeros((start[0].size, BENT + 1))
    new = 0
    for n, window in enumerate(zip(*start)):  # noqa: B905 - unknown to Numba
        seed = _seed_in_window(field, grid, window, roughest)
        if seed.rough < 0:
            continue
        cells = _first_cells(field, grid, seed, window, n + 1)
        cells = _grow_from_cells(field, grid, seed, cells, n + 1, gain, surfaces[new])
        side = window[2] // CELL
        if cells.size >= 0.6 * side * side:
            grid.owner.ravel()[cells] = count + new
            new += 1
    return surfaces[:new]


@inlined
def _seed_in_window(field, grid, window, roughest):  # pragma: no cover - compiled
    """`Seed` in a window; ``rough`` is -1 where too little is free or the plane fits too badly."""
    free = 0
    information = 0.0
    for y, x in _cells_of_window(window):
        free += grid.owner[y, x] < 0
        information += grid.information[0, y, x] + grid.information[1, y, x]
    q = np.zeros(BENT)
    rough = -1.0
    if free >= FREE * (window[2] // CELL) ** 2:
        q, likelihood = plane_in_window(field, window, information)
        if likelihood >= _START * information:
            rough = 0.0
        elif likelihood > 0:
            rough = _roughness(field, q, window, roughest)
    return Seed(q, rough, min(rough + _ROUGHER, roughest))


@inlined
def _cells_of_window(window):  # pragma: no cover - compiled
    """Row and column of each cell of a window."""
    top = window[0] // CELL
    left = window[1] // CELL
    side = window[2] // CELL
    return [(top + i // side, left + i % side) for i in range(side * side)]


@inlined
def _first_cells(field, grid, seed, window, mark):  # pragma: no cover - compiled
    """Numbers of the free cells of a window that its surface explains; none if they are few."""
    free = 0
    found = []
    for y, x in _cells_of_window(window):
        if grid.owner[y, x] < 0:
            free += 1
            if _explains(field, grid, seed.q, seed.rough, y, x):
                grid.stamp[y, x] = mark
                found.append(y * grid.owner.shape[1] + x)
    cells = np.array(found)
    return cells if cells.size >= 0.6 * free else cells[:0]


@inlined
def _grow_from_cells(
    field, grid, seed, cells, mark, gain, surface
):  # pragma: no cover - compiled
    """Fit and grow a surface (7,), in place, until no cell joins; return its cells."""
    q = seed.q
    rough = seed.rough
    before = 0
    while cells.size > before:
        before = cells.size
        boxes, weight = boxes_of_cells(cells, grid.owner.shape[1], _CELLS)
        fit, _ = fit_plane_or_bent(
            field, region_of_boxes(boxes), q, _STEPS, gain, weight
        )
        if is_possible(field, fit.q, boxes):
            q = fit.q
        if rough > 0:
            rough = min(_scatter(frequency_sums(field, q, boxes)), seed.most)
        cells = _add_cells_beside(field, grid, q, rough, cells, mark)
    for i in range(BENT):
        surface[i] = q[i]
    surface[BENT] = rough
    return cells


@inlined
def _explains(field, grid, q, rough, y, x):  # pragma: no cover - compiled
    """Whether a surface may grow into a cell."""
    least = _JOIN * _expected_likelihood(rough, grid.information, y, x)
    return cell_likelihood(field, q, y, x) > least


@inlined
def _expected_likelihood(rough, information, y, x):  # pragma: no cover - compiled
    """Mean log-likelihood S in a cell of a surface of this roughness, a variance in rad^2."""
    return (
        np.exp(-rough / 2) * information[0, y, x]
        + np.exp(-2 * rough) * information[1, y, x]
    )


@inlined
def _scatter(sums):  # pragma: no cover - compiled
    """Variance, rad^2, of depths about a surface by its coherence at the lower frequency."""
    return -2 * np.log(min(max(sums[0, 0] / max(sums[1, 0], 1e-9), 0.05), 1.0))


@inlined
def _roughness(field, q, window, roughest):  # pragma: no cover - compiled
    """Variance, rad^2, of depths about a window's plane; -1 if unsure or not below ``roughest``.

    A Gaussian of variance r costs one frequency exp(-r / 2), twice that frequency exp(-2 r).
    """
    top, left, side, _, _ = window
    sums = frequency_sums(field, q, np.array([[top, top + side, left, left + side]]))
    rough = _scatter(sums)
    most = max(sums[1, 1], 1e-9)
    off = sums[0, 1] / most - np.exp(-2 * rough)
    tolerance = _ALIKE[0] + _ALIKE[1] / np.sqrt(most)
    sure = sums[0].sum() > _SURE * np.sqrt(sums[1].sum()) and abs(off) < tolerance
    return rough if sure and 0 < rough < roughest else -1.0


@inlined
def _add_cells_beside(
    field, grid, q, rough, cells, mark
):  # pragma: no cover - compiled
    """Cells plus free neighbours that the surface explains, until doubled, by 8 at the least."""
    goal = max(2 * cells.size, cells.size + 8)
    found = list(cells)
    i = 0
    while i < len(found) < goal:
        y, x = divmod(found[i], grid.owner.shape[1])
        for a, b in neighbours(grid.owner, y, x):
            taken = grid.owner[a, b] >= 0 or grid.stamp[a, b] == mark
            if not taken and _explains(field, grid, q, rough, a, b):
                grid.stamp[a, b] = mark
                found.append(a * grid.owner.shape[1] + b)
        i += 1
    return np.array(found)


@inlined
def neighbours(cells, y, x):  # pragma: no cover - compiled
    """The cells below, above, right and left of a cell, of those that there are."""
    found = []
    for down, right in _BESIDE:
        a = y + down
        b = x + right
        if 0 <= a < cells.shape[0] and 0 <= b < cells.shape[1]:
            found.append((a, b))
    return found


@njit()
def _reassign_cells(field, owner, surfaces, information):  # pragma: no cover - compiled
    """Owner (h, w) of each cell: the likeliest of the surfaces about it, -1 if that fits badly."""
    out = owner.copy()
    for y, x in np.ndindex(owner.shape):
        found = owners_around(owner, y, x)
        if len(found) == 0 or (len(found) == 1 and owner[y, x] == found[0]):
            continue
        best = -np.inf
        at = -1
        for n in found:
            value = cell_likelihood(field, surfaces[n], y, x)
            for a, b in neighbours(owner, y, x):
                if owner[a, b] == n:
                    value += _NEIGHBOURLY
            # without light all are as likely: the first number wins
            if value > best or (value == best and n < at):
                best = value
                at = n
        expected = _expected_likelihood(surfaces[at, 6], information, y, x)
        out[y, x] = at if best >= _STAY * expected - np.sqrt(expected) else -1
    return out


@njit()
def owners_around(owner, y, x):  # pragma: no cover - compiled
    """The different owners of a cell and its eight neighbours."""
    found = []
    for n in owner[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2].flat:
        if n >= 0 and n not in found:
            found.append(n)
    return found
