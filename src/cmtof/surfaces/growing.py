"""Surfaces grow from cell to cell, and every cell then takes the likeliest one beside it."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cmtof.surfaces.field import CELL, Field
from cmtof.surfaces.kernels import BENT, cell_likelihood, depth_at, select
from cmtof.surfaces.seeds import FREE, WINDOWS, plane_in_window, windows

START = 0.75
"""Share S / E of what a window could say at best that a plane must reach to begin there."""

JOIN = 0.6
"""Share that a surface must reach in a cell to grow into it."""

STAY = 0.5
"""Share below which a cell belongs to none of the surfaces about it."""

GAIN, FLAT = 15.0, 5e-5
"""A surface counts as bent if that gains so much in S and a plane misses it by so much, m (rms)."""

_HOPS = 60
_CELLS = 100
"""Cells that a growing surface is fitted to, spread over all of it."""

_ROUNDS = 6
_NEIGHBOURLY = 3.0
"""What each of four neighbours in the same surface adds to S when a cell chooses."""


def grown_surfaces(
    field: Field, *, bent: bool = True
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Owner of each cell, -1 for none, and the parameters (N, 6) of the surfaces.

    From the best window on, a plane is fitted to a window, takes the cells beside it that it
    explains, and is fitted again whenever it has doubled.
    """
    shape = tuple(n // CELL for n in field.cosine.shape)
    both = field.information.sum(axis=0, dtype=float)
    information = both.reshape(shape[0], CELL, shape[1], CELL).sum(axis=(1, 3))
    label = np.zeros((1, 1), np.int32)  # fits look at whole cells
    gain = GAIN if bent else np.inf
    limits = (float(field.limits[0]), float(field.limits[1]))
    owner, surfaces = np.full(shape, -1, np.int64), np.zeros((0, BENT))
    for kind in WINDOWS:
        start = windows(field, owner < 0, *kind)
        added = _grow(field.arrays(), label, tuple(start), information, limits, gain, owner,
                      len(surfaces))  # fmt: skip
        surfaces = np.concatenate([surfaces, added])
    for turn in range(_ROUNDS):
        owner = _reassigned(field.arrays(), owner, surfaces, information)
        if turn % 2:
            surfaces = _refitted(field.arrays(), label, owner, surfaces, limits[1], gain)
    return owner, surfaces


@njit(cache=True, nogil=True)
def boxes_of_cells(cells, columns, most):  # pragma: no cover - compiled
    """Rectangles of at most so many cells, spread over the list."""
    stride = max(1, cells.size // most)
    chosen = cells[::stride]
    out = np.empty((chosen.size, 4), np.int64)
    for i in range(chosen.size):
        y, x = chosen[i] // columns * CELL, chosen[i] % columns * CELL
        out[i] = (y, y + CELL, x, x + CELL)
    return out


@njit(cache=True, nogil=True)
def possible(field, q, box, farthest):  # pragma: no cover - compiled
    """Whether a surface lies before the camera and not far beyond the limits."""
    z = depth_at(field, q, box[0], box[2])
    return 0.02 * farthest < z < 2 * farthest


@njit(cache=True, nogil=True)
def _grow(field, label, start, information, limits, gain, owner, count):  # pragma: no cover
    """Grow surfaces from windows, numbered from ``count`` on; return their parameters."""
    rows, columns = information.shape
    stamp = np.zeros((rows, columns), np.int64)
    surfaces = np.zeros((start[0].size, BENT))
    first = count
    for n in range(start[0].size):
        window = (start[0][n], start[1][n], start[2][n], start[3][n], start[4][n])
        side = max(window[2] // CELL, 1)
        y0, x0 = window[0] // CELL, window[1] // CELL
        free, told = 0, 0.0
        for y in range(y0, y0 + side):
            for x in range(x0, x0 + side):
                told += information[y, x]
                if owner[y, x] < 0:
                    free += 1
        if free < FREE * side * side:
            continue
        q, likelihood = plane_in_window(field, label, window, limits, told)
        if likelihood < START * told:
            continue
        region = np.empty(rows * columns, np.int64)
        size = 0
        for y in range(y0, y0 + side):
            for x in range(x0, x0 + side):
                told_here = JOIN * information[y, x]
                if owner[y, x] < 0 and cell_likelihood(field, q, y, x) > told_here:
                    region[size] = y * columns + x
                    stamp[y, x] = n + 1
                    size += 1
        if size < 0.6 * free:
            continue
        while True:
            before = size
            boxes = boxes_of_cells(region[:size], columns, _CELLS)
            weight = size / boxes.shape[0]
            fit = select(field, label, -1, q, boxes, 2, _HOPS, gain, FLAT, weight)
            if possible(field, fit[0], boxes[0], limits[1]):
                q = fit[0]
            size = _spread(field, q, owner, stamp, n + 1, region, size, information)
            if size == before:
                break
        if size >= 0.6 * side * side:
            for i in range(size):
                owner[region[i] // columns, region[i] % columns] = count
            surfaces[count - first] = q
            count += 1
    return surfaces[: count - first]


@njit(cache=True, nogil=True)
def _spread(field, q, owner, stamp, mark, region, size, information):  # pragma: no cover
    """Add free cells beside the region that the surface explains, until it has doubled."""
    rows, columns = information.shape
    goal = max(2 * size, size + 8)
    i = 0
    while i < size and size < goal:
        for dy, dx in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            y, x = region[i] // columns + dy, region[i] % columns + dx
            if y < 0 or x < 0 or y >= rows or x >= columns:
                continue
            if owner[y, x] >= 0 or stamp[y, x] == mark:
                continue
            if cell_likelihood(field, q, y, x) > JOIN * information[y, x]:
                stamp[y, x] = mark
                region[size] = y * columns + x
                size += 1
        i += 1
    return size


@njit(cache=True, nogil=True)
def around(owner, y, x, found):  # pragma: no cover - compiled
    """Write the different owners of a cell and its eight neighbours; return how many."""
    rows, columns = owner.shape
    count = 0
    for a in range(max(y - 1, 0), min(y + 2, rows)):
        for b in range(max(x - 1, 0), min(x + 2, columns)):
            new = owner[a, b] >= 0
            for i in range(count):
                if found[i] == owner[a, b]:
                    new = False
            if new:
                found[count] = owner[a, b]
                count += 1
    return count


@njit(cache=True, nogil=True)
def _reassigned(field, owner, surfaces, information):  # pragma: no cover - compiled
    """Give each cell the likeliest of the surfaces about it, or none."""
    rows, columns = owner.shape
    out = owner.copy()
    found = np.empty(9, np.int64)
    for y in range(rows):
        for x in range(columns):
            count = around(owner, y, x, found)
            if count == 0 or (count == 1 and owner[y, x] == found[0]):
                continue
            best, at = -np.inf, -1
            for i in range(count):
                value = cell_likelihood(field, surfaces[found[i]], y, x)
                for dy, dx in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                    a, b = y + dy, x + dx
                    if 0 <= a < rows and 0 <= b < columns and owner[a, b] == found[i]:
                        value += _NEIGHBOURLY
                if value > best:
                    best, at = value, found[i]
            told = information[y, x]
            out[y, x] = at if best >= STAY * told - np.sqrt(told) else -1
    return out


@njit(cache=True, nogil=True)
def _refitted(field, label, owner, surfaces, farthest, gain):  # pragma: no cover - compiled
    columns = owner.shape[1]
    out = surfaces.copy()
    order = np.argsort(owner.ravel(), kind="mergesort")
    sorted_owner = owner.ravel()[order]
    for n in range(surfaces.shape[0]):
        a, b = np.searchsorted(sorted_owner, n), np.searchsorted(sorted_owner, n + 1)
        if b == a:
            continue
        boxes = boxes_of_cells(order[a:b], columns, _CELLS)
        weight = (b - a) / boxes.shape[0]
        fit = select(field, label, -1, out[n], boxes, 2, _HOPS, gain, FLAT, weight)
        if possible(field, fit[0], boxes[0], farthest):
            out[n] = fit[0]
    return out
