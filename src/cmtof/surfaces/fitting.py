"""Compiled loops (Numba): fits of surfaces to the phasors of their pixels.

Vectors are added number by number, for expressions of arrays take Numba far longer to compile.
"""

from typing import NamedTuple

import numpy as np

from cmtof.compiled import inlined, njit
from cmtof.correlation import TAU
from cmtof.surfaces.blocks import (
    SIDE,
    Region,
    block_sums,
    blocks_of_boxes,
    depths_of_blocks,
)
from cmtof.surfaces.field import CELL, Field, pixels_of_cells
from cmtof.surfaces.shapes import (
    BENT,
    PLANE,
    is_possible,
    solve,
)
from cmtof.types import Array, Numbers

# As NumPy's integers, for Numba compiles a function again for every literal that it is given.
HOPS = np.int64(60)  # largest hop, wraps
EFFORT = np.int64(6), np.int64(400)  # steps of a last fit, and cells that it looks at
UPRIGHT = (np.int64(0), np.int64(0))  # no tilt, wraps per pixel down and right
ASTRAY = 0.2  # distance, wraps (rms), of a plane from a bent surface from which on it is not tried
FLAT = 5e-5  # a surface counts as bent if a plane misses it by more, m (rms), and it gains in S


class Fit(NamedTuple):
    """A surface, its log-likelihood, and the step and offset, wraps, that would raise it."""

    q: Array
    likelihood: float  # S
    most: float  # E
    step: Array  # of the parameters, by Gauss and Newton
    offset: float  # that it lacks, wraps
    known: float  # inverse variance of this offset, 1 / wraps^2


@njit()
def _moments(field, region, q):  # pragma: no cover - compiled
    """S, E, gradient (7,) and lower Hessian (7, 7) by the parameters and by whole wraps."""
    places = blocks_of_boxes(region.boxes)
    total, known = block_sums(field, region, q, places)
    z, functions = depths_of_blocks(field, q, places)
    sums = np.zeros(2)
    right = np.zeros(BENT + 1)
    matrix = np.zeros((BENT + 1, BENT + 1))
    row = np.empty(BENT + 1)
    for n in range(z.size):
        for f in range(2):
            for i in range(BENT):
                row[i] = -(z[n] ** 2) * field.wavenumber[f] * functions[n, i]
            row[BENT] = field.turns[f]
            _add_products(matrix, row, known[f, n])
            for i in range(BENT + 1):
                right[i] += total[f, n].imag * row[i]
            sums[0] += total[f, n].real
            sums[1] += known[f, n]
    return sums, right, matrix


@inlined
def _add_products(matrix, row, weight):  # pragma: no cover - compiled
    """Add the products of a row's numbers (7,), weighted, to the lower half of a matrix (7, 7)."""
    for i in range(BENT + 1):
        for j in range(i + 1):
            matrix[i, j] += weight * row[i] * row[j]


@inlined
def _product(some, others):  # pragma: no cover - compiled
    """Scalar product of two vectors (6,)."""
    total = 0.0
    for i in range(BENT):
        total += some[i] * others[i]
    return total


@njit()
def move_surface(field, q, boxes, size, distance, tilt=UPRIGHT):  # pragma: no cover
    """Surface fitted to ``q`` moved by ``distance``, m, and ``tilt``, wraps/px; misfit, m (rms)."""
    places = blocks_of_boxes(boxes[:: max(1, len(boxes) // 100)])
    z, functions = depths_of_blocks(field, q, places)
    middle = np.rint(places[:, 0].mean()), np.rint(places[:, 1].mean())
    for n in range(z.size):
        turned = 0.0
        for axis in range(2):
            turned += tilt[axis] * (places[n, axis] - middle[axis] + (SIDE - 1) / 2)
        z[n] = max(z[n] + distance + field.period * turned, 0.05)
    return _surface_through(z, functions, size)


@inlined
def _surface_through(z, functions, size):  # pragma: no cover - compiled
    """Surface next to depths (N,), m, of blocks with functions (N, 6), and its misfit, m (rms)."""
    matrix = np.zeros((BENT + 1, BENT + 1))
    row = np.empty(BENT + 1)
    for n in range(z.size):
        for i in range(BENT):
            row[i] = z[n] ** 2 * functions[n, i]
        row[BENT] = z[n]
        _add_products(matrix, row, 1.0)
    found = solve(matrix, matrix[BENT], size)
    missed = matrix[BENT, BENT] - _product(found, matrix[BENT])
    return found, np.sqrt(max(missed, 0.0) / z.size)


@njit()
def evaluate_fit(field, region, q, size):  # pragma: no cover - compiled
    """`Fit` of a surface: its likelihood, the step of its first ``size`` parameters, its offset.

    After m wraps and a change dq the phases fit as ``sum K (e + m t - k J dq)^2``; with the best
    dq a parabola in m is left, ``known (m - offset)^2``.
    """
    sums, right, matrix = _moments(field, region, q)
    share = min(max(sums[0] / max(sums[1], 1e-9), 0.3), 1.0)
    right /= share
    step = solve(matrix, right, size)
    shift = solve(matrix, matrix[BENT], size)  # zero beyond these parameters
    known = max(matrix[BENT, BENT] - _product(matrix[BENT], shift), 1e-12)
    offset = (_product(right, shift) - right[BENT]) / known
    return Fit(q, sums[0], sums[1], step, offset, known * share)


@njit()
def change_by_a_wrap(field, region, q, weight):  # pragma: no cover - compiled
    """Change (3,), 1 / m, of a plane moved by a wrap, and its fit's covariance (3, 3), 1 / m^2."""
    _, right, matrix = _moments(field, region, q)
    out = np.empty((4, 3))
    for row in range(4):
        found = solve(matrix, right if row else matrix[BENT], PLANE)
        right[:] = 0
        right[row] = 1 / weight
        for i in range(3):
            out[row, i] = found[i]
    return out


@njit()
def climb(field, region, q, size, steps):  # pragma: no cover - compiled
    """`Fit` after Gauss-Newton steps, ``steps`` at most, each of which raises S by over 0.01."""
    best = evaluate_fit(field, region, q, size)
    for _ in range(steps):
        there = evaluate_fit(field, region, best.q + best.step, size)
        if there.likelihood <= best.likelihood + 0.01:
            break
        best = there
    return best


@njit()
def refine(field, region, q, size, steps):  # pragma: no cover - compiled
    """`Fit` after `climb`, then after hops by whole wraps, each with a climb, while S rises."""
    best = climb(field, region, q, size, steps)
    for _ in range(5):
        whole = min(max(np.rint(best.offset), -HOPS), HOPS)
        if whole == 0:
            break
        distance = whole * field.period
        start = move_surface(field, best.q, region.boxes, size, distance, UPRIGHT)[0]
        there = climb(field, region, start, size, np.int64(3))
        if there.likelihood <= best.likelihood:
            break
        best = there
    return best


@inlined
def _straighten(field, region, bent, plane, steps):  # pragma: no cover - compiled
    """Likeliest of ``plane`` and two planes next to ``bent`` tilted by whole wraps per pixel."""
    near = np.empty(9)
    planes = []
    few = region.boxes[:: max(1, len(region.boxes) // 25)].copy()
    for i in range(9):
        tilt = i // 3 - 1, i % 3 - 1
        moved, near[i] = move_surface(field, bent, few, PLANE, 0.0, tilt)
        planes.append(moved)
    for _ in range(2):
        i = np.argmin(near)
        if near[i] < ASTRAY * TAU / field.wavenumber[0]:
            there = refine(field, region, planes[i], PLANE, steps)
            plane = there if there.likelihood > plane.likelihood else plane
        near[i] = np.inf
    return plane


@inlined
def stiffness(field, most):  # pragma: no cover - compiled
    """Sum of K k^2, 1 / m^2, over pixels whose K sum to ``most``, half at each frequency."""
    k = field.wavenumber
    return most * (k[0] ** 2 + k[1] ** 2) / 2


@njit()
def fit_plane_or_bent(
    field, region, q, steps, gain, weight
):  # pragma: no cover - compiled
    """Fit of a plane, or of a bent surface if far likelier; how far a plane misses, m (rms).

    Far likelier is by ``gain`` in S and by `FLAT`. Each pixel that is looked at stands for
    ``weight`` pixels.
    """
    was_bent = q[3:].any()
    before = refine(field, region, q, BENT if was_bent else PLANE, steps)
    plane = before
    if was_bent:
        start = move_surface(field, before.q, region.boxes, PLANE, 0.0, UPRIGHT)[0]
        plane = refine(field, region, start, PLANE, steps)
    bent = refine(field, region, plane.q, BENT, steps)
    if bent.likelihood <= before.likelihood:
        bent = before
    if (bent.likelihood - plane.likelihood) * weight > gain:
        plane = _straighten(field, region, bent.q, plane, steps)
    # S falls by half of K k^2 times the square of what a plane misses
    stiff = max(stiffness(field, plane.most * weight) / 2, 1e-9)
    lost = (bent.likelihood - plane.likelihood) * weight
    missed = np.sqrt(max(lost - 4.0, 0.0) / stiff)
    return bent if lost > gain + stiff * FLAT**2 else plane, missed


@njit()
def boxes_of_cells(cells, columns, most):  # pragma: no cover - compiled
    """Rectangles (B, 4) of cells picked evenly, under 2 ``most``; cells that each stands for."""
    chosen = cells[:: max(1, cells.size // most)]
    boxes = np.empty((chosen.size, 4), np.int64)
    for n, cell in enumerate(chosen):
        y, x = divmod(cell, columns)
        for i, edge in enumerate((y, y + 1, x, x + 1)):
            boxes[n, i] = edge * CELL
    return boxes, cells.size / chosen.size


@njit()
def _fit_all(field, label, cells, starts, surfaces, effort, gain):  # pragma: no cover
    """Surfaces, fitted in place, and fits (N, 16), by cells sorted by surface and their starts."""
    steps, most = effort
    fit = np.zeros((len(surfaces), 16))
    for n in range(len(surfaces)):
        own = cells[starts[n] : starts[n + 1]]
        if own.size > 0:
            boxes, weight = boxes_of_cells(own, field.u.size // CELL, most)
            region = Region(boxes, label, n)  # pyright: ignore[reportArgumentType]
            _fit_one(field, region, surfaces[n], steps, gain, weight, fit[n])
    return surfaces, fit


@inlined
def _fit_one(field, region, q, steps, gain, weight, row):  # pragma: no cover - compiled
    """Fit a surface, and its row (16,) of `fit_surfaces`, in place; neither if impossible."""
    found, missed = fit_plane_or_bent(field, region, q[:BENT], steps, gain, weight)
    if is_possible(field, found.q, region.boxes):
        stiff = max(stiffness(field, found.most), 1e-9)
        row[0] = found.offset
        row[1] = found.known * weight
        row[2] = missed
        row[3] = np.sqrt(found.known / stiff)
        if not found.q[PLANE:].any():
            for i, change in enumerate(
                change_by_a_wrap(field, region, found.q, weight).flat
            ):
                row[4 + i] = change
        for i in range(BENT):
            q[i] = found.q[i]


def fit_surfaces(
    field: Field, label: Numbers, surfaces: Array, effort: tuple, gain: float
) -> tuple:
    """Surfaces (N, 7) fitted to their pixels, by ``effort``: steps, and about how many cells each.

    And the fit (N, 16): offset that is lacking, wraps; its inverse variance; what a plane misses,
    m (rms); by how much a wrap bends a plane, m; for planes `change_by_a_wrap`.
    """
    shape = np.array(label.shape) // CELL
    count = shape.prod()
    # one entry for each surface and cell that share pixels
    pairs = label * count + pixels_of_cells(np.arange(count).reshape(shape))
    pairs = pairs[label >= 0]
    pairs = np.unique(pairs[np.diff(pairs, append=-1) != 0])  # runs first, for speed
    of, cells = np.divmod(pairs, count)
    starts = np.searchsorted(of, np.arange(len(surfaces) + 1))
    label = label.astype(np.int32)
    return _fit_all(field, label, cells, starts, surfaces.copy(), effort, gain)
