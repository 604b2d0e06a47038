"""Surfaces grow from windows, ring by ring; then every cell takes the likeliest beside it.

Nothing depends on the order of pixels: a mirrored image has mirrored surfaces, but for rounding.
"""

from typing import NamedTuple

import numpy as np

from cmtof.compiled import njit
from cmtof.surfaces import fitting
from cmtof.surfaces.field import CELL, Array, Field, Labels
from cmtof.surfaces.windows import FREE, KINDS, plane_in_window, windows

# Share of the likelihood expected of it that a plane must reach to begin in a window, to grow into
# a cell, and to keep it.
_START, _JOIN, _STAY = 0.75, 0.6, 0.5
GAIN = 15.0  # in S from which on a surface counts as bent
_FILLED = 0.6  # share of the free cells of a window that its surface must explain
_ROUNDS = 6  # of reassignment
_NEIGHBOURLY = 3.0  # gain in S per neighbour in the same surface
_ROUGHEST = 0.9  # variance, rad^2, of the depths about a surface, up to which it is one
_ROUGHER = 0.1  # by which it may grow beyond that of the window in which it began
_SURE = 6.0  # deviations of S from noise for a rough surface to begin
_ALIKE = (0.08, 2.0)  # tolerance of its coherence at the higher frequency, and in deviations
_NEAREST, _BEYOND = 0.02, 2.0  # depths of surfaces, in units of the largest one to choose from
_BESIDE = ((1, 0), (-1, 0), (0, 1), (0, -1))


class Surfaces(NamedTuple):
    """Surfaces, one entry (N,) each, and how they were fitted."""

    parameters: Array  # (N, 6), as `cmtof.surfaces.fitting` has them
    roughness: Array  # variance of single pixels about it, rad^2 at the lower frequency
    offset: Array  # that is lacking by its shape, wraps
    known: Array  # inverse variance of that; 0 where nothing was fitted
    missed: Array  # what a plane misses, m (rms)
    bend: Array  # by how much a wrap bends a plane, m (rms)
    turn: Array  # change (N, 3) of a plane's parameters by a wrap; 0 for what is bent
    covariance: Array  # (N, 3, 3) of these


def coherence(roughness: Array) -> Array:
    """Share of S (2, ...) that is left at both frequencies."""
    return np.exp(-np.multiply.outer([0.5, 2.0], roughness))


def grown_surfaces(field: Field, *, gain: float = GAIN) -> tuple[Labels, Surfaces]:
    """Owner of each cell, -1 for none, and the surfaces grown from windows."""
    rows, columns = (n // CELL for n in field.cosine.shape)
    cells = field.information.astype(float).reshape(2, rows, CELL, columns, CELL)
    information = cells.sum(axis=(2, 4))
    owner = np.full((rows, columns), -1, np.int64)
    found = np.zeros((0, fitting.BENT + 1))
    bounds = (*field.limits, gain)
    for kind in KINDS:
        start = windows(field, owner < 0, kind)
        added = _grow(field.arrays(), start, information, bounds, owner, len(found))
        found = np.concatenate([found, added])
    return _settled(field, owner, information, found, gain)


def _settled(
    field: Field, owner: Labels, information: Array, found: Array, gain: float
) -> tuple[Labels, Surfaces]:
    """Owner and surfaces after cells were reassigned and surfaces fitted again, in turn.

    ``found`` (N, 7) holds the parameters of surfaces and their roughness.
    """
    nothing = np.full(field.cosine.shape, -1)
    surfaces = fitted(field, nothing, found[:, :6], gain)._replace(roughness=found[:, 6])
    for turn in range(_ROUNDS):
        fit = surfaces.parameters, coherence(surfaces.roughness)
        owner = _reassigned(field.arrays(), owner, *fit, information)
        if turn % 2:
            label = np.kron(owner, np.ones((CELL, CELL), int))
            surfaces = fitted(field, label, surfaces.parameters, gain)
    return owner, surfaces


def fitted(field: Field, label: Labels, parameters: Array, gain: float) -> Surfaces:
    """Fit every surface (N, 6) to its pixels."""
    blocks, starts = _blocks_of_labels(label, len(parameters))
    bounds = (*field.limits, gain)
    out = _fit_all(field.arrays(), label.astype(np.int32), blocks, starts, parameters, bounds)
    covariance = out[:, 14:].reshape(-1, 3, 3)
    return Surfaces(out[:, :6], *out[:, 6:11].T, out[:, 11:14], covariance)


def _blocks_of_labels(label: Labels, count: int) -> tuple[Labels, Labels]:
    """Cells (B, 4) that share pixels with a surface, by surface, and where each begins (N + 1,)."""
    rows, columns = (n // CELL for n in label.shape)
    y, x = np.nonzero(label >= 0)
    pairs = np.unique((label[y, x].astype(np.int64) * rows + y // CELL) * columns + x // CELL)
    of, order = np.divmod(pairs, rows * columns)
    top, left = np.divmod(order, columns)
    blocks = CELL * np.stack([top, top + 1, left, left + 1], axis=1)
    return blocks, np.searchsorted(of, np.arange(count + 1))


@njit(inline="always")
def _expected(roughness, information, y, x):  # pragma: no cover - compiled
    """S that a surface of this roughness has in a cell on average."""
    low = np.exp(-roughness / 2) * information[0, y, x]
    return low + np.exp(-2 * roughness) * information[1, y, x]


@njit(cache=True, nogil=True)
def _grow(field, start, information, bounds, owner, first):  # pragma: no cover - compiled
    """Grow surfaces from windows, numbered from ``first`` on; their parameters and roughness."""
    found = np.zeros((len(start), fitting.BENT + 1))
    new = 0
    for n in range(len(start)):
        free = _free_cells(owner, start[n])
        side = max(int(start[n, 2]) // CELL, 1)
        if free < FREE * side * side:
            continue
        q, sums = plane_in_window(field, start[n], bounds)
        if not _begins(sums):
            continue
        state = _cells_of_window(field, q, sums, owner, start[n], information)
        if np.sum(state == 1) < _FILLED * free:
            continue
        roughest = min(fitting.roughness(sums) + _ROUGHER, _ROUGHEST)
        found[new] = _grown(field, q, state, owner, information, (*bounds, roughest))
        if np.sum(state == 1) < _FILLED * side * side:
            continue
        _take(owner, state, first + new)
        new += 1
    return found[:new]


@njit(cache=True, nogil=True)
def _take(owner, state, number):  # pragma: no cover - compiled
    """Give the cells of a region to a surface."""
    for y in range(owner.shape[0]):
        for x in range(owner.shape[1]):
            if state[y, x] == 1:
                owner[y, x] = number


@njit(cache=True, nogil=True)
def _free_cells(owner, window):  # pragma: no cover - compiled
    """Number of the cells of a window without an owner."""
    y0, y1, x0, x1 = _span(window)
    return np.sum(owner[y0:y1, x0:x1] < 0)


@njit(cache=True, nogil=True)
def _span(window):  # pragma: no cover - compiled
    """First and last row and column of the cells that lie within a window."""
    side = max(int(window[2]) // CELL, 1)
    y = -(-int(window[0]) // CELL)
    x = -(-int(window[1]) // CELL)
    return y, y + side, x, x + side


@njit(cache=True, nogil=True)
def _begins(sums):  # pragma: no cover - compiled
    """Whether a plane explains its window, or a rough one by both frequencies."""
    if fitting.expected(sums) <= 0:
        return False
    if fitting.likelihood(sums) >= _START * fitting.expected(sums):
        return True
    low = sums[0] / sums[2]
    high = sums[1] / sums[3]
    rough = -2 * np.log(max(low, 1e-3))
    tolerance = _ALIKE[0] + _ALIKE[1] / np.sqrt(sums[3])
    sure = fitting.likelihood(sums) > _SURE * np.sqrt(fitting.expected(sums))
    return sure and rough < _ROUGHEST and abs(high - low**4) < tolerance


@njit(cache=True, nogil=True)
def _cells_of_window(field, q, sums, owner, window, information):  # pragma: no cover - compiled
    """State of each cell: 1 for those free ones of a window that the surface explains, else 0."""
    state = np.zeros(owner.shape, np.int8)
    rough = min(fitting.roughness(sums), _ROUGHEST)
    y0, y1, x0, x1 = _span(window)
    for y in range(y0, y1):
        for x in range(x0, x1):
            least = _JOIN * _expected(rough, information, y, x)
            if owner[y, x] < 0 and fitting.cell_likelihood(field, q, y, x) > least:
                state[y, x] = 1
    return state


@njit(cache=True, nogil=True)
def _grown(field, q, state, owner, information, bounds):  # pragma: no cover - compiled
    """Fit a surface and let it spread until it takes no more cells: parameters and roughness."""
    nothing = np.zeros((1, 1), np.int32)
    out = np.zeros(fitting.BENT + 1)
    out[:6] = q
    while True:
        blocks = _blocks_of_cells(state)
        fit = fitting.select(field, nothing, fitting.EVERY, out[:6].copy(), blocks, bounds[2])
        z = np.mean(fit[2][:, 8])
        if _NEAREST * bounds[1] < z < _BEYOND * bounds[1]:
            out[:6] = fit[0]
            out[6] = min(fitting.roughness(fit[1]), bounds[3])
        if not _spread(field, out, state, owner, information):
            return out


@njit(cache=True, nogil=True)
def _spread(field, surface, state, owner, information):  # pragma: no cover - compiled
    """Add rings of free cells that the surface explains, until it has doubled; whether it grew."""
    ring = np.argwhere(state == 1)
    goal = max(len(ring), 8)
    tested = (state > 0) | (owner >= 0)
    grown = 0
    while grown < goal and len(ring):
        ring = _beyond(ring, tested)
        kept = np.zeros(len(ring), np.bool_)
        for n in range(len(ring)):
            y = ring[n, 0]
            x = ring[n, 1]
            least = _JOIN * _expected(surface[6], information, y, x)
            kept[n] = fitting.cell_likelihood(field, surface[:6], y, x) > least
            if kept[n]:
                state[y, x] = 1
        ring = ring[kept]
        grown += len(ring)
    return grown > 0


@njit(cache=True, nogil=True)
def _beyond(ring, tested):  # pragma: no cover - compiled
    """Cells (N, 2) beside those of a ring that were not tested yet; from now on they are."""
    ahead = np.zeros((4 * len(ring), 2), np.int64)
    size = 0
    for n in range(len(ring)):
        for dy, dx in _BESIDE:
            y = ring[n, 0] + dy
            x = ring[n, 1] + dx
            if 0 <= y < tested.shape[0] and 0 <= x < tested.shape[1] and not tested[y, x]:
                tested[y, x] = True
                ahead[size, 0] = y
                ahead[size, 1] = x
                size += 1
    return ahead[:size]


@njit(cache=True, nogil=True)
def _reassigned(field, owner, surfaces, shares, information):  # pragma: no cover - compiled
    """Give each cell the likeliest of the surfaces about it, or none."""
    out = owner.copy()
    for y in range(owner.shape[0]):
        for x in range(owner.shape[1]):
            found = around(owner, y, x)
            if found.size == 0 or (found.size == 1 and owner[y, x] == found[0]):
                continue
            best = -np.inf
            at = -1
            for n in found:
                value = fitting.cell_likelihood(field, surfaces[n], y, x)
                value += _NEIGHBOURLY * _neighbours(owner, n, y, x)
                if value > best:
                    best = value
                    at = n
            told = shares[0, at] * information[0, y, x] + shares[1, at] * information[1, y, x]
            out[y, x] = at if best >= _STAY * told - np.sqrt(told) else -1
    return out


@njit(cache=True, nogil=True)
def _neighbours(owner, number, y, x):  # pragma: no cover - compiled
    """How many of the four cells beside one belong to a surface."""
    count = 0
    for dy, dx in _BESIDE:
        if 0 <= y + dy < owner.shape[0] and 0 <= x + dx < owner.shape[1]:
            count += owner[y + dy, x + dx] == number
    return count


@njit(cache=True, nogil=True)
def around(owner, y, x):  # pragma: no cover - compiled
    """The different owners of a cell and its eight neighbours."""
    near = np.unique(owner[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2])
    return near[near >= 0]


@njit(cache=True, nogil=True)
def _fit_all(field, label, blocks, starts, surfaces, bounds):  # pragma: no cover - compiled
    """Columns of `Surfaces` (N, 23), from blocks sorted by surface and where each begins."""
    out = np.zeros((len(surfaces), 23))
    out[:, :6] = surfaces
    for n in range(len(surfaces)):
        own = blocks[starts[n] : starts[n + 1]]
        if len(own) == 0:
            continue
        q, sums, rows, missed = fitting.select(field, label, n, surfaces[n], own, bounds[2])
        z = np.mean(rows[:, 8])
        # before the camera and not far beyond the limits
        if _NEAREST * bounds[1] < z < _BEYOND * bounds[1]:
            out[n, :6] = q
            _describe(field, q, sums, rows, out[n])
            out[n, 9] = missed
    return out


@njit(cache=True, nogil=True)
def _describe(field, q, sums, rows, out):  # pragma: no cover - compiled
    """Fill in the columns of `Surfaces` that follow from the sums of a fit."""
    flat = q[3] == 0 and q[4] == 0 and q[5] == 0
    offset, known = fitting.offset_of(sums, fitting.PLANE if flat else fitting.BENT)
    stiff = fitting.expected(sums) * (field[3][0] ** 2 + field[3][1] ** 2) / 2
    out[6] = min(fitting.roughness(sums), _ROUGHEST)
    out[7] = offset
    out[8] = known
    out[10] = np.sqrt(known / max(stiff, 1e-9))
    if flat:
        out[11:] = fitting.leaning(field, rows, q).ravel()


@njit(cache=True, nogil=True)
def _blocks_of_cells(state):  # pragma: no cover - compiled
    """Rectangles (N, 4) of the cells of a region."""
    cells = np.argwhere(state == 1)
    blocks = np.empty((len(cells), 4), np.int64)
    for n in range(len(cells)):
        blocks[n, 0] = CELL * cells[n, 0]
        blocks[n, 1] = CELL * cells[n, 0] + CELL
        blocks[n, 2] = CELL * cells[n, 1]
        blocks[n, 3] = CELL * cells[n, 1] + CELL
    return blocks
