"""How many whole wraps each surface lies off, from its own pixels.

Two things tell. The beat: the pooled higher phase lags behind the pooled lower one by ``2 pi m
(k_2 / k_1 - 2)`` after m wraps. And the shape: a plane moved along the rays is no plane any more,
so a fit that is m wraps off is bent, the more so the wider the surface; see `kernels._look`.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cmtof.correlation import TAU
from cmtof.surfaces.field import CELL, Field
from cmtof.surfaces.growing import FLAT, GAIN, boxes_of_cells, possible
from cmtof.surfaces.kernels import depth_at, select

_CELLS = 400
"""Cells that a surface is fitted to at last, spread over all of it."""

_STEPS, _HOPS = 6, 60

_SMOOTH = 1e-5
"""Departure from a plane, m (rms), that is allowed for where none can be seen."""

_FLOOR = (0.05, 0.15)
"""Least uncertainty, wraps, of an offset from the shape and of one from the beat."""

_BENT = 1.5
"""Wraps of uncertainty a beat gets per share of coherence that its surface lacks."""

_ENOUGH = 60.0
"""Information from which on a cell's own phasors say where it lies off its surface."""


class Offsets(NamedTuple):
    """Offset of each surface (N,), wraps to add, and how well it is known."""

    mean: NDArray[np.float64]
    spread: NDArray[np.float64]


def fitted(
    field: Field, inner: NDArray[np.int32], surfaces: NDArray[np.float64], *, bent: bool = True
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit every surface (N, 6) to its interior; its fit (N, 5) as well.

    The fit holds: offset that is lacking, wraps; its inverse variance; functions used; what a plane
    misses, m (rms); by how much a plane is bent by a wrap, m (rms).
    """
    rows, columns = (n // CELL for n in inner.shape)
    # one entry for each cell and surface that share pixels
    cell = (np.arange(inner.shape[0]) // CELL)[:, None] * columns
    cell = cell + np.arange(inner.shape[1]) // CELL
    known = inner >= 0
    pairs = np.unique(inner[known].astype(np.int64) * (rows * columns) + cell[known])
    of, cells = np.divmod(pairs, rows * columns)
    starts = np.searchsorted(of, np.arange(len(surfaces) + 1))
    out, fit = surfaces.copy(), np.zeros((len(surfaces), 5))
    farthest, gain = float(field.limits[1]), GAIN if bent else np.inf
    _fit(field.arrays(), inner, cells, starts, columns, farthest, gain, out, fit)
    return out, fit


@njit(cache=True, nogil=True)
def _fit(field, inner, cells, starts, columns, farthest, gain, surfaces, fit):  # pragma: no cover
    k = field[3]
    for n in range(surfaces.shape[0]):
        own = cells[starts[n] : starts[n + 1]]
        if own.size == 0:
            continue
        boxes = boxes_of_cells(own, columns, _CELLS)
        weight = own.size / boxes.shape[0]
        found = select(field, inner, n, surfaces[n], boxes, _STEPS, _HOPS, gain, FLAT, weight)
        q, _, most, offset, known, size, missed = found
        if not possible(field, q, boxes[0], farthest):
            continue
        surfaces[n] = q
        stiff = max(most * (k[0] ** 2 + k[1] ** 2) / 2, 1e-9)
        bend = np.sqrt(known / stiff)
        fit[n] = np.array([offset, known * weight, float(size), missed, bend])


def offsets(
    field: Field,
    inner: NDArray[np.int32],
    surfaces: NDArray[np.float64],
    fit: NDArray[np.float64],
    *,
    shape: bool = True,
) -> Offsets:
    """Offset of each fitted surface from its shape and from its beat.

    The shape counts as far as a plane is known to miss the surface by less than a wrap bends it.
    """
    beat, noise, coherence = pooled_beats(field, inner, surfaces)
    doubt = _FLOOR[1] + _BENT * (1 - np.clip(coherence, 0.05, 1))
    by_beat = 1 / (noise**2 + doubt**2)
    known, missed, bend = (np.maximum(fit[:, i], 1e-12) for i in (1, 3, 4))
    variance = 1 / known + (np.maximum(missed, _SMOOTH) / bend) ** 2 + _FLOOR[0] ** 2
    by_shape = np.where((fit[:, 1] > 0) & shape, 1 / variance, 0)
    mean = (fit[:, 0] * by_shape + beat * by_beat) / (by_shape + by_beat)
    return Offsets(mean, 1 / np.sqrt(by_shape + by_beat))


def pooled_beats(
    field: Field, inner: NDArray[np.int32], surfaces: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Offset by the beat of each surface (N,), wraps, its noise, and the coherence it rests on.

    A surface is no better than its six functions. So each cell is first turned back by what its
    neighbourhood's phasors say at both frequencies together, and then all are summed.
    """
    count = len(surfaces)
    shape = tuple(n // CELL for n in inner.shape)
    sums, told = np.zeros((2, *shape), np.complex128), np.zeros((2, *shape))
    main = np.full(shape, -1, np.int64)
    _sum_cells(field.arrays(), inner, surfaces, sums, told, main)
    near, reached = sums.copy(), told.sum(axis=0)
    for radius in (1, 2, 4):
        weak = reached < _ENOUGH
        wider = _same(np.concatenate([sums, told]), main, radius)
        near = np.where(weak, wider[:2], near)
        reached = np.where(weak, np.real(wider[2:]).sum(axis=0), reached)
    multiple = field.multiple
    low = np.angle(near[0])
    high = np.angle(near[1] * np.exp(-1j * multiple * low))
    size = np.abs(near)
    residual = low + size[1] * multiple * high / (size[0] + multiple**2 * size[1] + 1e-9)
    known = main >= 0
    turns = np.array([1, multiple])[:, None, None]
    turned = sums * np.exp(-1j * turns * residual)

    def summed(image: NDArray) -> NDArray[np.float64]:
        return np.bincount(main[known], image[known], count).astype(float)

    total = np.stack([summed(np.real(one)) + 1j * summed(np.imag(one)) for one in turned])
    most = np.maximum(np.stack([summed(told[f]) for f in (0, 1)]), 1e-9)
    length = np.maximum(np.abs(total), 1e-9)
    wrap = TAU * field.excess
    beat = np.angle(total[1] * np.conj(total[0] / length[0]) ** multiple) / wrap
    variance = most / length**2
    noise = np.sqrt(variance[1] + multiple**2 * variance[0]) / abs(wrap)
    return beat, noise, (length / most).min(axis=0)


@njit(cache=True, nogil=True)
def _sum_cells(field, inner, surfaces, sums, told, main):  # pragma: no cover - compiled
    """Sum the phasors of each cell's main surface, turned back by it."""
    real, imaginary, information, wavenumber = field[:4]
    for row in range(main.shape[0]):
        for column in range(main.shape[1]):
            most = 0
            for y in range(row * CELL, row * CELL + CELL):
                for x in range(column * CELL, column * CELL + CELL):
                    one = inner[y, x]
                    if one < 0 or one == main[row, column]:
                        continue
                    count = np.sum(
                        inner[row * CELL : row * CELL + CELL, column * CELL : column * CELL + CELL]
                        == one
                    )
                    if count > most:
                        most = count
                        main[row, column] = one
            if most == 0:
                continue
            one = main[row, column]
            for y in range(row * CELL, row * CELL + CELL):
                for x in range(column * CELL, column * CELL + CELL):
                    if inner[y, x] != one:
                        continue
                    z = depth_at(field, surfaces[one], y, x)
                    for f in range(2):
                        phasor = complex(real[f, y, x], imaginary[f, y, x])
                        sums[f, row, column] += phasor * np.exp(-1j * wavenumber[f] * z)
                        told[f, row, column] += information[f, y, x]


def _same(images: NDArray, main: NDArray[np.int64], radius: int) -> NDArray:
    """Sum of images (N, h, w) over the cells of the same surface within a radius."""
    height, width = main.shape
    edge = (radius, radius)
    padded = np.pad(images, ((0, 0), edge, edge))
    owner = np.pad(main, radius, constant_values=-2)
    out = np.zeros_like(images)
    for y in range(2 * radius + 1):
        for x in range(2 * radius + 1):
            place = (slice(y, y + height), slice(x, x + width))
            out += np.where(owner[place] == main, padded[(slice(None), *place)], 0)
    return out
