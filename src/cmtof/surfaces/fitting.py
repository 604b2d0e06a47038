"""Compiled loops (Numba): likelihood of a surface over cells and over rectangles, and its fit.

A surface is ``1 / z = cosine (q_0 u + q_1 v + q_2 + q_3 u^2 + q_4 u v + q_5 v^2)``; a plane has
none of the last three. Pixels of a ``label`` count, all if it is < 0.
"""

import numpy as np

from cmtof.compiled import njit
from cmtof.correlation import TAU
from cmtof.surfaces.field import CELL, Field
from cmtof.types import Array, Numbers

# As NumPy's integers, for Numba compiles a function again for every literal that it is given.
PLANE = np.int64(3)  # parameters of a plane
BENT = np.int64(6)  # and of a bent surface
EVERY = np.int64(-1)  # label of a fit to whole rectangles
HOPS = np.int64(60)  # largest hop, wraps
ASTRAY = 0.2  # distance, wraps (rms), of a plane from a bent surface from which on it is not tried
FLAT = 5e-5  # a surface counts as bent if a plane misses it by more, m (rms), and it gains in S

_U = np.array([1, 0, 0, 2, 1, 0])  # powers of u of the six functions
_V = np.array([0, 1, 0, 0, 1, 2])
FARTHEST = 1e-4  # smallest 1 / z, 1 / m, of a surface


@njit(inline="always")
def _turn(turns):  # pragma: no cover - compiled
    """Cosine and sine of an angle in turns, to 2e-8: Taylor series on a quarter turn each side."""
    whole = np.floor(2 * turns + 0.5)
    x = (turns - 0.5 * whole) * TAU
    odd = 1.0 - 2.0 * (whole - 2.0 * np.floor(0.5 * whole))
    y = x * x
    # quotients of literals are factors already when this is compiled
    c = y * (1 / 40320 - y * (1 / 3628800 - y * (1 / 479001600)))
    c = 1 - y * (1 / 2 - y * (1 / 24 - y * (1 / 720 - c)))
    s = y * (1 / 5040 - y * (1 / 362880 - y * (1 / 39916800)))
    s = x * (1 - y * (1 / 6 - y * (1 / 120 - s)))
    return odd * c, odd * s


@njit(inline="always")
def depth_at(field, q, y, x):  # pragma: no cover - compiled
    """Depth, m, of a surface at a pixel."""
    u = field.u[x]
    v = field.v[y]
    inverse = q[2] + q[0] * u + q[1] * v
    inverse += q[3] * u * u + q[4] * u * v + q[5] * v * v
    return 1.0 / max(field.cosine[y, x] * inverse, FARTHEST)


@njit(inline="always")
def pixel_likelihood(field, q, y, x):  # pragma: no cover - compiled
    """S of a surface at one pixel."""
    z = depth_at(field, q, y, x)
    total = 0.0
    for f in range(2):
        c, s = _turn(field.wavenumber[f] / TAU * z)
        total = total + field.real[f, y, x] * c + field.imaginary[f, y, x] * s
    return total


@njit()
def cell_likelihood(field, q, row, column):  # pragma: no cover - compiled
    """S of a surface over one cell."""
    total = 0.0
    for y in range(row * CELL, row * CELL + CELL):
        for x in range(column * CELL, column * CELL + CELL):
            total += pixel_likelihood(field, q, y, x)
    return total


@njit()
def frequency_sums(field, q, boxes):  # pragma: no cover - compiled
    """S of both frequencies (2,) over rectangles, then E of both (2,)."""
    out = np.zeros((2, 2))
    for box in boxes:
        for y in range(box[0], box[1]):
            for x in range(box[2], box[3]):
                turns = depth_at(field, q, y, x) / TAU
                for f in range(2):
                    c, s = _turn(field.wavenumber[f] * turns)
                    out[0, f] += field.real[f, y, x] * c + field.imaginary[f, y, x] * s
                    out[1, f] += field.information[f, y, x]
    return out


@njit()
def _moments(field, label, only, q, boxes):  # pragma: no cover - compiled
    """Sums over rectangles: S, E, b, c (4,), g (6,), h (6,), and the lower half of M (6, 6)."""
    sums = np.zeros(4)
    g = np.zeros(BENT)
    h = np.zeros(BENT)
    matrix = np.zeros((BENT, BENT))
    row = np.empty((3, 5))  # sums of g, h and M along a row, by powers of u
    for box in boxes:
        for y in range(box[0], box[1]):
            v = field.v[y]
            below = (1.0, v, v * v)
            first = q[0] + q[4] * v
            none = q[2] + q[1] * v + q[5] * v * v
            row[:] = 0.0
            likelihood = most = b = c = 0.0
            for x in range(box[2], box[3]):
                counts = 1.0 if only < 0 or label[y, x] == only else 0.0
                u = field.u[x]
                across = (1.0, u, u * u)
                z = 1.0 / max(
                    field.cosine[y, x] * (none + u * (first + q[3] * u)), FARTHEST
                )
                slope = -z * z * field.cosine[y, x]
                told = pull = stiff = by_depth = by_both = by_turns = 0.0
                for f in range(2):
                    k = field.wavenumber[f]
                    turns = field.turns[f]
                    real = field.real[f, y, x]
                    imaginary = field.imaginary[f, y, x]
                    information = counts * field.information[f, y, x]
                    cosine, sine = _turn(k / TAU * z)
                    likelihood += counts * (real * cosine + imaginary * sine)
                    error = counts * (imaginary * cosine - real * sine)
                    told += information
                    pull += error * turns
                    stiff += information * turns * turns
                    by_depth += error * k
                    by_both += information * turns * k
                    by_turns += information * k * k
                most += told
                b += pull
                c += stiff
                for i in range(3):
                    row[0, i] += by_depth * slope * across[i]
                    row[1, i] += by_both * slope * across[i]
                    row[2, i] += by_turns * slope * slope * across[i]
                for i in (1, 2):
                    row[2, 2 + i] += by_turns * slope * slope * across[i] * across[2]
            for i, value in enumerate((likelihood, most, b, c)):
                sums[i] += value
            for i in range(BENT):
                up = below[_V[i]]
                g[i] += up * row[0, _U[i]]
                h[i] += up * row[1, _U[i]]
                for j in range(i + 1):
                    matrix[i, j] += up * below[_V[j]] * row[2, _U[i] + _U[j]]
    return sums, g, h, matrix


@njit()
def _solved(matrix, right, size):  # pragma: no cover - compiled
    """M^-1 right for the first functions, by elimination, M scaled to a unit diagonal."""
    left = np.empty((BENT, BENT))
    scale = np.empty(BENT)
    out = np.zeros(BENT)
    for i in range(size):
        scale[i] = 1 / np.sqrt(matrix[i, i] + 1e-12)
        out[i] = scale[i] * right[i]
        for j in range(i + 1):
            left[i, j] = left[j, i] = scale[i] * scale[j] * matrix[i, j]
    for k in range(size):
        for i in range(size):
            share = left[i, k] / (left[k, k] + 1e-10) if i != k else 0.0
            out[i] -= share * out[k]
            for j in range(k, size):
                left[i, j] -= share * left[k, j]
    out[:size] *= scale[:size] / (np.diag(left)[:size] + 1e-10)
    return out


@njit()
def _look(field, label, only, q, boxes, size):  # pragma: no cover - compiled
    """S, E, Gauss-Newton step, offset in wraps that the surface lacks, and what is known of it.

    After m wraps and a change dq the phases fit as ``sum K (e + m t - k J dq)^2``; with the best
    dq a parabola in m is left, ``known (m - offset)^2``.
    """
    sums, g, h, matrix = _moments(field, label, only, q, boxes)
    likelihood = sums[0]
    most = sums[1]
    share = min(max(likelihood / max(most, 1e-9), 0.3), 1.0)
    g /= share
    step = _solved(matrix, g, size)
    shift = _solved(matrix, h, size)[:size]
    known = max(sums[3] - np.sum(h[:size] * shift), 1e-12)
    offset = -(sums[2] / share - np.sum(g[:size] * shift)) / known
    return likelihood, most, step, offset, known * share


@njit()
def leaning(field, label, only, q, boxes, weight):  # pragma: no cover - compiled
    """Change (3,) of a plane that is moved by a wrap, and the covariance (3, 3) of its fit."""
    _, _, h, matrix = _moments(field, label, only, q, boxes)
    out = np.empty((4, 3))
    out[0] = _solved(matrix, h, PLANE)[:3]
    for i in range(3):
        out[1 + i] = _solved(matrix, np.eye(6)[i] / weight, PLANE)[:3]
    return out


@njit()
def moved(
    field, q, boxes, size, distance, down=0, right=0
):  # pragma: no cover - compiled
    """Nearest surface to this one moved, by m and by wraps per pixel; their distance, m (rms)."""
    matrix = np.zeros((BENT, BENT))
    wanted = np.zeros(BENT)
    basis = np.zeros(BENT)
    row = np.mean(boxes[:, :2])
    column = np.mean(boxes[:, 2:])
    square = 0.0
    count = 0
    for box in boxes[:: max(1, len(boxes) // 100)]:
        for y in range(box[0], box[1], 3):
            v = field.v[y]
            below = (1.0, v, v * v)
            for x in range(box[2], box[3], 3):
                u = field.u[x]
                across = (1.0, u, u * u)
                for j in range(BENT):
                    basis[j] = across[_U[j]] * below[_V[j]]
                cosine = field.cosine[y, x]
                shift = distance + field.period * (
                    down * (y - row) + right * (x - column)
                )
                z = max(1 / max(cosine * np.sum(q * basis), FARTHEST) + shift, 0.05)
                weight = z**4 * cosine**2
                square += z * z
                count += 1
                for i in range(size):
                    wanted[i] += weight * basis[i] / (z * cosine)
                    for j in range(i + 1):
                        matrix[i, j] += weight * basis[i] * basis[j]
    out = _solved(matrix, wanted, size)
    return out, np.sqrt(max(square - np.sum(out * wanted), 0.0) / count)


@njit()
def _climb(field, label, only, q, boxes, size, steps):  # pragma: no cover - compiled
    """Climb by Gauss-Newton steps, as long as S grows by 0.01.

    Returns q, S, E, the offset left and its precision.
    """
    best, most, step, offset, known = _look(field, label, only, q, boxes, size)
    for _ in range(steps):
        trial = _look(field, label, only, q + step, boxes, size)
        if trial[0] <= best + 0.01:
            break
        q = q + step
        best, most, step, offset, known = trial
    return q, best, most, offset, known


@njit()
def refine(
    field, label, only, q, boxes, size, steps, hops
):  # pragma: no cover - compiled
    """Climb, then hop by whole wraps: q, S, E, offset left, its precision."""
    found = _climb(field, label, only, q, boxes, size, steps)
    for _ in range(5):
        whole = min(max(np.rint(found[3]), -hops), hops)
        if whole == 0:
            break
        new = moved(field, found[0], boxes, size, whole * field.period)[0]
        trial = _climb(field, label, only, new, boxes, size, np.int64(3))
        if trial[1] <= found[1]:
            break
        found = trial
    return found


@njit()
def _straightened(
    field, label, only, q, plane, boxes, steps
):  # pragma: no cover - compiled
    """The likelier of this plane and those that look bent, their slopes off by a turn per pixel."""
    near = np.empty(9)
    planes = np.empty((9, BENT))
    few = boxes[:: max(1, len(boxes) // 25)]
    for i in range(9):
        planes[i], near[i] = moved(field, q, few, PLANE, 0.0, i // 3 - 1, i % 3 - 1)
    for _ in range(2):
        i = np.argmin(near)
        if near[i] < ASTRAY * TAU / field.wavenumber[0]:
            trial = refine(field, label, only, planes[i], boxes, PLANE, steps, HOPS)
            plane = trial if trial[1] > plane[1] else plane
        near[i] = np.inf
    return plane


@njit()
def select(
    field, label, only, q, boxes, steps, gain, weight
):  # pragma: no cover - compiled
    """Plane, or a bent surface where that fits much better: by ``gain`` and by `FLAT`.

    Returns q, E, offset, its inverse variance, and by how much, m (rms), a plane misses.
    ``weight`` is the number of pixels that stand for each that is looked at.
    """
    k = field.wavenumber
    was_bent = q[3:].any()
    before = refine(
        field, label, only, q, boxes, BENT if was_bent else PLANE, steps, HOPS
    )
    plane = before
    if was_bent:
        start = moved(field, before[0], boxes, PLANE, 0.0)[0]
        plane = refine(field, label, only, start, boxes, PLANE, steps, HOPS)
    bent = refine(field, label, only, plane[0], boxes, BENT, steps, HOPS)
    if was_bent and bent[1] <= before[1]:
        bent = before
    if (bent[1] - plane[1]) * weight > gain:
        plane = _straightened(field, label, only, bent[0], plane, boxes, steps)
    # S falls by half of K k^2 times the square of what a plane misses
    stiff = max(plane[2] * weight * (k[0] ** 2 + k[1] ** 2) / 4, 1e-9)
    lost = (bent[1] - plane[1]) * weight
    missed = np.sqrt(max(lost - 4.0, 0.0) / stiff)
    best = bent if lost > gain + stiff * FLAT**2 else plane
    return best[0], best[2], best[3], best[4], missed


@njit(inline="always")
def possible(field, q, boxes):  # pragma: no cover - compiled
    """Whether a surface lies before the camera and not far beyond the limits."""
    z = depth_at(field, q, boxes[0, 0], boxes[0, 2])
    return 0.02 * field.limits[1] < z < 2 * field.limits[1]


@njit()
def boxes_of_cells(cells, columns, most):  # pragma: no cover - compiled
    """Rectangles of at most so many cells, spread over the list; cells that each stands for."""
    chosen = cells[:: max(1, cells.size // most)]
    y = chosen // columns * CELL
    x = chosen % columns * CELL
    return np.stack((y, y + CELL, x, x + CELL), axis=1), cells.size / chosen.size


@njit()
def _fit_all(
    field, label, cells, starts, surfaces, effort, gain
):  # pragma: no cover - compiled
    """Do what `fitted` says, in place; cells sorted by surface, and where those of each start."""
    columns = field.u.size // CELL
    fit = np.zeros((len(surfaces), 16))
    for n in range(len(surfaces)):
        own = cells[starts[n] : starts[n + 1]]
        if own.size == 0:
            continue
        boxes, weight = boxes_of_cells(own, columns, effort[1])
        q, most, offset, known, missed = select(
            field, label, n, surfaces[n, :BENT], boxes, effort[0], gain, weight
        )
        if possible(field, q, boxes):
            k = field.wavenumber
            stiff = max(most * (k[0] ** 2 + k[1] ** 2) / 2, 1e-9)
            surfaces[n, :BENT] = q
            fit[n, :4] = np.array(
                [offset, known * weight, missed, np.sqrt(known / stiff)]
            )
            if not q[PLANE:].any():
                fit[n, 4:] = leaning(field, label, n, q, boxes, weight).ravel()
    return surfaces, fit


def fitted(
    field: Field, label: Numbers, surfaces: Array, effort: tuple, gain: float
) -> tuple:
    """Fit every surface (N, 7) to its pixels, with so many steps, on so many cells at most.

    And the fit (N, 16): offset that is lacking, wraps; its inverse variance; what a plane misses,
    m (rms); by how much a wrap bends a plane, m; for planes `leaning`.
    """
    rows, columns = (n // CELL for n in label.shape)
    y, x = np.nonzero(label >= 0)
    # one entry for each surface and cell that share pixels
    pairs = np.unique(
        (label[y, x].astype(np.int64) * rows + y // CELL) * columns + x // CELL
    )
    of, cells = np.divmod(pairs, rows * columns)
    starts = np.searchsorted(of, np.arange(len(surfaces) + 1))
    label = label.astype(np.int32)
    return _fit_all(field, label, cells, starts, surfaces.copy(), effort, gain)
