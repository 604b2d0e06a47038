"""Compiled loops (Numba): fits of surfaces to the phasors of their pixels."""

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
    """S, E, slope and curvature in wraps (4,); gradient (6,), mixed (6,), lower Hessian (6, 6)."""
    places = blocks_of_boxes(region.boxes)
    total, known = block_sums(field, region, q, places)
    z, functions = depths_of_blocks(field, q, places)
    change = -(z**2) * functions  # of the depth
    k = field.wavenumber
    turns = field.turns
    g = _sums_along(change, total[0].imag * k[0] + total[1].imag * k[1])
    h = _sums_along(change, known[0] * turns[0] * k[0] + known[1] * turns[1] * k[1])
    bend = known[0] * k[0] ** 2 + known[1] * k[1] ** 2
    sums = _sums_of_offset(total, known, turns)
    return sums, g, h, _products(bend * change, change)


@inlined
def _sums_of_offset(total, known, turns):  # pragma: no cover - compiled
    """Sums (4,) over blocks: S, E, slope and curvature in wraps, from phasors and E (2, N)."""
    sums = np.zeros(4)
    for n in range(total.shape[1]):
        for f in range(2):
            sums[0] += total[f, n].real
            sums[1] += known[f, n]
            sums[2] += total[f, n].imag * turns[f]
            sums[3] += known[f, n] * turns[f] * turns[f]
    return sums


@njit()
def _products(some, others):  # pragma: no cover - compiled
    """Lower half of the matrix (6, 6) of scalar products of vectors (6, N)."""
    out = np.zeros((BENT, BENT))
    for n in range(some.shape[1]):
        for i in range(BENT):
            for j in range(i + 1):
                out[i, j] += some[i, n] * others[j, n]
    return out


@njit()
def _sums_along(vectors, weight):  # pragma: no cover - compiled
    """Scalar products (6,) of vectors (6, N) with one (N,)."""
    out = np.zeros(BENT)
    for i in range(BENT):
        for n in range(weight.size):
            out[i] += weight[n] * vectors[i, n]
    return out


@njit()
def move_surface(field, q, boxes, size, distance, tilt=UPRIGHT):  # pragma: no cover
    """Surface fitted to ``q`` moved by ``distance``, m, and ``tilt``, wraps/px; misfit, m (rms)."""
    places = blocks_of_boxes(boxes[:: max(1, len(boxes) // 100)])
    z, functions = depths_of_blocks(field, q, places)
    turned = tilt[0] * _from_middle(places[:, 0])
    turned += tilt[1] * _from_middle(places[:, 1])
    z = np.maximum(z + distance + field.period * turned, 0.05)
    change = z * z * functions
    wanted = _sums_along(change, z)
    found = solve(_products(change, change), wanted, size)
    missed = np.sum(z * z) - np.sum(found * wanted)
    return found, np.sqrt(max(missed, 0.0) / z.size)


@inlined
def _from_middle(first):  # pragma: no cover - compiled
    """Distance (N,), px, of the middle of blocks from a pixel in the middle of them all."""
    return first - np.rint(first.mean()) + (SIDE - 1) / 2


@njit()
def evaluate_fit(field, region, q, size):  # pragma: no cover - compiled
    """`Fit` of a surface: its likelihood, the step of its first ``size`` parameters, its offset.

    After m wraps and a change dq the phases fit as ``sum K (e + m t - k J dq)^2``; with the best
    dq a parabola in m is left, ``known (m - offset)^2``.
    """
    sums, g, h, matrix = _moments(field, region, q)
    share = min(max(sums[0] / max(sums[1], 1e-9), 0.3), 1.0)
    g /= share
    step = solve(matrix, g, size)
    shift = solve(matrix, h, size)  # zero beyond these parameters
    known = max(sums[3] - np.sum(h * shift), 1e-12)
    offset = -(sums[2] / share - np.sum(g * shift)) / known
    return Fit(q, sums[0], sums[1], step, offset, known * share)


@njit()
def change_by_a_wrap(field, region, q, weight):  # pragma: no cover - compiled
    """Change (3,), 1 / m, of a plane moved by a wrap, and its fit's covariance (3, 3), 1 / m^2."""
    _, _, h, matrix = _moments(field, region, q)
    out = np.empty((4, 3))
    out[0] = solve(matrix, h, PLANE)[:3]
    for i in range(3):
        out[1 + i] = solve(matrix, np.eye(6)[i] / weight, PLANE)[:3]
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
    planes = np.empty((9, BENT))
    few = region.boxes[:: max(1, len(region.boxes) // 25)].copy()
    for i in range(9):
        planes[i], near[i] = move_surface(
            field, bent, few, PLANE, 0.0, (i // 3 - 1, i % 3 - 1)
        )
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
    y = chosen // columns * CELL
    x = chosen % columns * CELL
    return np.stack((y, y + CELL, x, x + CELL), axis=1), cells.size / chosen.size


@njit()
def _fit_all(field, label, cells, starts, surfaces, effort, gain):  # pragma: no cover
    """Surfaces, fitted in place, and fits (N, 16), by cells sorted by surface and their starts."""
    steps, most = effort
    fit = np.zeros((len(surfaces), 16))
    for n in range(len(surfaces)):
        own = cells[starts[n] : starts[n + 1]]
        if own.size > 0:
            boxes, weight = boxes_of_cells(own, field.u.size // CELL, most)
            q = surfaces[n, :BENT]
            fit[n] = _fit_one(field, Region(boxes, label, n), q, steps, gain, weight)  # pyright: ignore[reportArgumentType]
    return surfaces, fit


@inlined
def _fit_one(field, region, q, steps, gain, weight):  # pragma: no cover - compiled
    """Fit a surface in place; its row (16,) of `fit_surfaces`, zeros if it is not possible."""
    row = np.zeros(16)
    found, missed = fit_plane_or_bent(field, region, q, steps, gain, weight)
    if is_possible(field, found.q, region.boxes):
        stiff = max(stiffness(field, found.most), 1e-9)
        bend = np.sqrt(found.known / stiff)
        row[:4] = (found.offset, found.known * weight, missed, bend)
        if not found.q[PLANE:].any():
            row[4:] = change_by_a_wrap(field, region, found.q, weight).ravel()
        q[:] = found.q
    return row


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
