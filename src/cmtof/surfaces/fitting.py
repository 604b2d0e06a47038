"""Compiled loops (Numba): likelihood of a surface over blocks of pixels, and its fit.

A surface is ``1 / z = cosine (q_0 u + q_1 v + q_2 + q_3 u^2 + q_4 u v + q_5 v^2)``; a plane has
none of the last three. ``field`` is `Field.arrays`; pixels of a ``label`` count, all if it is < 0.

A fit reads the pixels once: turned back by the surface from which it starts, the phasors of a block
add up to one row. What a fit changes within a block of 8 px is far below a turn.
"""

import numpy as np

from cmtof.compiled import njit
from cmtof.surfaces.field import CELL

# As NumPy's integers, for Numba compiles a function again for every literal that it is given.
PLANE = np.int64(3)  # parameters of a plane
BENT = np.int64(6)  # and of a bent surface
EVERY = np.int64(-1)  # label of a fit to all pixels of its blocks
HOPS = np.int64(60)  # largest hop, wraps
ASTRAY = 0.2  # distance, wraps (rms), of a plane from a bent surface from which on it is not tried
FLAT = 5e-5  # a surface counts as bent if a plane misses it by more, m (rms), and it gains in S
FARTHEST = 0.02  # smallest 1 / z, 1 / m, of a surface

_POWER_U = np.array([1, 0, 0, 2, 1, 0])  # of the six functions
_POWER_V = np.array([0, 1, 0, 0, 1, 2])

# Columns of a row: direction, phasors of both frequencies, their information, depth turned back by.
_U, _V, _PHASOR, _INFORMATION, _DEPTH, _COLUMNS = 0, 1, 2, 6, 8, 9
# Sums over rows: S and E of both frequencies; of the offset: slope b and curvature c of S; of the
# parameters: slope g, coupling h with the offset, curvature M.
_S, _E, _B, _C, _G, _H, _M, _SUMS = 0, 2, 4, 5, 6, 12, 18, 54
_CONVERGED = 1e-13  # gain of S, per E, at which a fit ends
CLIMBS = 20  # steps at most
_HOPPED = 5  # hops at most
_ALIKE = 0.2  # largest excess of coherence at the higher frequency over that of uneven surfaces
_FEWEST = 40  # blocks of a fit
_READ, _SETTLED = 4, 0.01  # readings of the pixels at most; gain of S by one that is not repeated
_MEDIAN = 0.455  # of chi^2 with one degree of freedom


@njit(inline="always")
def _turn(turns):  # pragma: no cover - compiled
    """Cosine and sine of an angle in turns, to 2e-8: Taylor series on a quarter turn each side."""
    whole = np.floor(2 * turns + 0.5)
    x = (turns - 0.5 * whole) * 2 * np.pi
    odd = 1.0 - 2.0 * (whole - 2.0 * np.floor(0.5 * whole))
    y = x * x
    c = 1 - y / 2 * (1 - y / 12 * (1 - y / 30 * (1 - y / 56 * (1 - y / 90 * (1 - y / 132)))))
    s = x * (1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72 * (1 - y / 110)))))
    return odd * c, odd * s


@njit(inline="always")
def depth_at(field, q, y, x):  # pragma: no cover - compiled
    """Depth, m, of a surface at a pixel."""
    u = field[5][x]
    v = field[6][y]
    inverse = q[2] + q[0] * u + q[1] * v + q[3] * u * u + q[4] * u * v + q[5] * v * v
    return 1.0 / max(field[7][y, x] * inverse, FARTHEST)


@njit(inline="always")
def pixel_likelihood(field, q, y, x):  # pragma: no cover - compiled
    """S of a surface at one pixel."""
    turns = depth_at(field, q, y, x) / (2 * np.pi)
    total = 0.0
    for f in range(2):
        c, s = _turn(field[3][f] * turns)
        total += field[0][f, y, x] * c + field[1][f, y, x] * s
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def cell_likelihood(field, q, row, column):  # pragma: no cover - compiled
    """S of a surface over one cell."""
    total = 0.0
    for y in range(row * CELL, row * CELL + CELL):
        for x in range(column * CELL, column * CELL + CELL):
            total += pixel_likelihood(field, q, y, x)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def sum_blocks(field, label, only, q, blocks):  # pragma: no cover - compiled
    """A row (N, 9) for each block (N, 4): phasors turned back by a surface, and their place."""
    rows = np.zeros((len(blocks), _COLUMNS))
    for n in range(len(blocks)):
        _sum_block(field, label, only, q, blocks[n], rows[n])
    told = rows[:, _INFORMATION] + rows[:, _INFORMATION + 1] > 0
    return rows[told] if np.any(told) else rows


@njit(cache=True, nogil=True)
def _finer(blocks):  # pragma: no cover - compiled
    """Squares (N, 4), in quarters where they would be too few for a fit."""
    while len(blocks) < _FEWEST and blocks[0, 1] - blocks[0, 0] > 2:
        half = (blocks[0, 1] - blocks[0, 0]) // 2
        quarters = np.empty((4 * len(blocks), 4), np.int64)
        for n in range(len(quarters)):
            y = blocks[n // 4, 0] + n % 4 // 2 * half
            x = blocks[n // 4, 2] + n % 2 * half
            quarters[n] = np.array([y, y + half, x, x + half])
        blocks = quarters
    return blocks


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_block(field, label, only, q, block, row):  # pragma: no cover - compiled
    """Sums of one block; its place is the mean direction of the pixels that count."""
    count = 0
    for y in range(block[0], block[1]):
        for x in range(block[2], block[3]):
            if only >= 0 and label[y, x] != only:
                continue
            count += 1
            row[_U] += field[5][x]
            row[_V] += field[6][y]
            turns = depth_at(field, q, y, x) / (2 * np.pi)
            for f in range(2):
                c, s = _turn(field[3][f] * turns)
                real = field[0][f, y, x]
                imaginary = field[1][f, y, x]
                row[_PHASOR + 2 * f] += real * c + imaginary * s
                row[_PHASOR + 2 * f + 1] += imaginary * c - real * s
                row[_INFORMATION + f] += field[2][f, y, x]
    row[_U] /= max(count, 1)
    row[_V] /= max(count, 1)
    row[_DEPTH] = _row_depth(row, q)


@njit(inline="always")
def _row_depth(row, q):  # pragma: no cover - compiled
    """Depth, m, of a surface at the place of a row."""
    u = row[_U]
    v = row[_V]
    inverse = q[2] + q[0] * u + q[1] * v + q[3] * u * u + q[4] * u * v + q[5] * v * v
    return 1.0 / max(inverse / np.sqrt(1 + u * u + v * v), FARTHEST)


@njit(cache=True, nogil=True)
def _functions(row, basis):  # pragma: no cover - compiled
    """Values of the six functions at the place of a row."""
    for i in range(BENT):
        basis[i] = row[_U] ** _POWER_U[i] * row[_V] ** _POWER_V[i]


@njit(cache=True, nogil=True, error_model="numpy")
def sums_of_rows(field, rows, q):  # pragma: no cover - compiled
    """S, E and the derivatives (54,) of a surface over rows."""
    sums = np.zeros(_SUMS)
    basis = np.empty(BENT)
    for n in range(len(rows)):
        _functions(rows[n], basis)
        _add_row(field[3], field[4], rows[n], q, basis, sums)
    return sums


@njit(cache=True, nogil=True, error_model="numpy")
def _add_row(wavenumber, turns, row, q, basis, sums):  # pragma: no cover - compiled
    """Add one row to the sums."""
    z = _row_depth(row, q)
    slope = -z * z / np.sqrt(1 + row[_U] ** 2 + row[_V] ** 2)
    products = np.zeros(3)  # of the parameters: pull, coupling with the offset, weight
    for f in range(2):
        k = wavenumber[f]
        told = row[_INFORMATION + f]
        fit, misfit = _turned(row, f, k * (z - row[_DEPTH]))
        sums[_S + f] += fit
        sums[_E + f] += told
        sums[_B] += misfit * turns[f]
        sums[_C] += told * turns[f] ** 2
        products[0] += misfit * k * slope
        products[1] += told * turns[f] * k * slope
        products[2] += told * (k * slope) ** 2
    _add_products(products, basis, sums)


@njit(inline="always")
def _turned(row, f, angle):  # pragma: no cover - compiled
    """Parts along and across of the phasor of a row, turned back by an angle."""
    c = np.cos(angle)
    s = np.sin(angle)
    real = row[_PHASOR + 2 * f]
    imaginary = row[_PHASOR + 2 * f + 1]
    return real * c + imaginary * s, imaginary * c - real * s


@njit(cache=True, nogil=True, error_model="numpy")
def _add_products(products, basis, sums):  # pragma: no cover - compiled
    """Add what a row tells of the parameters."""
    for i in range(BENT):
        sums[_G + i] += products[0] * basis[i]
        sums[_H + i] += products[1] * basis[i]
        for j in range(i + 1):
            sums[_M + 6 * i + j] += products[2] * basis[i] * basis[j]


@njit(cache=True, nogil=True)
def _solved(sums, right, size):  # pragma: no cover - compiled
    """M^-1 right for the first functions, by elimination, M scaled to a unit diagonal."""
    left = np.empty((BENT, BENT))
    scale = np.empty(BENT)
    out = np.zeros(BENT)
    for i in range(size):
        scale[i] = 1 / np.sqrt(sums[_M + 7 * i] + 1e-12)
        out[i] = scale[i] * right[i]
        for j in range(i + 1):
            left[i, j] = scale[i] * scale[j] * sums[_M + 6 * i + j]
            left[j, i] = left[i, j]
    for k in range(size):
        for i in range(size):
            share = left[i, k] / (left[k, k] + 1e-10) if i != k else 0.0
            out[i] -= share * out[k]
            for j in range(k, size):
                left[i, j] -= share * left[k, j]
    for i in range(size):
        out[i] *= scale[i] / (left[i, i] + 1e-10)
    return out


@njit(inline="always")
def likelihood(sums):  # pragma: no cover - compiled
    """S of both frequencies."""
    return sums[_S] + sums[_S + 1]


@njit(inline="always")
def expected(sums):  # pragma: no cover - compiled
    """E of both frequencies."""
    return sums[_E] + sums[_E + 1]


@njit(inline="always")
def _share(sums):  # pragma: no cover - compiled
    """S / E, within the bounds in which it scales the curvature of S."""
    return min(max(likelihood(sums) / max(expected(sums), 1e-9), 0.3), 1.0)


@njit(cache=True, nogil=True)
def roughness(sums):  # pragma: no cover - compiled
    """Variance, rad^2, of depths about the surface, by the coherence of each frequency.

    Unevenness s of a Gaussian costs one frequency exp(-s^2 / 2) and twice that frequency the fourth
    power of this. Pixels of other surfaces cost both alike: then there is none.
    """
    low = max(sums[_S] / max(sums[_E], 1e-9), 0.05)
    high = max(sums[_S + 1] / max(sums[_E + 1], 1e-9), 0.05)
    if high - low**4 > _ALIKE:
        return 0.0
    return max(min(-2 * np.log(low), -0.5 * np.log(high)), 0.0)


@njit(cache=True, nogil=True)
def offset_of(sums, size):  # pragma: no cover - compiled
    """Offset in wraps that a surface lacks, and its inverse variance.

    After m wraps and a change dq the phases fit as ``sum K (e + m t - k J dq)^2``; with the best
    dq a parabola in m is left, ``known (m - offset)^2``.
    """
    share = _share(sums)
    shift = _solved(sums, sums[_H : _H + 6], size)
    known = sums[_C]
    pull = sums[_B]
    for i in range(size):
        known -= sums[_H + i] * shift[i]
        pull -= sums[_G + i] * shift[i]
    known = max(known, 1e-12)
    return -pull / share / known, known * share


@njit(cache=True, nogil=True)
def leaning(field, rows, q):  # pragma: no cover - compiled
    """Change (3,) of a plane that is moved by a wrap, and the covariance (3, 3) of its fit."""
    sums = sums_of_rows(field, rows, q)
    out = np.empty((4, 3))
    out[0] = _solved(sums, sums[_H : _H + 6], PLANE)[:3]
    for i in range(3):
        right = np.zeros(BENT)
        right[i] = 1.0
        out[1 + i] = _solved(sums, right, PLANE)[:3]
    return out


@njit(cache=True, nogil=True)
def moved(field, q, rows, size, distance, down=0, right=0):  # pragma: no cover - compiled
    """Nearest surface to this one moved, by m and by wraps per pixel; their distance, m (rms)."""
    depths = _moved_depths(field, q, rows, distance, down, right)
    sums = np.zeros(_SUMS)
    wanted = np.zeros(BENT)
    basis = np.empty(BENT)
    for n in range(len(rows)):
        _functions(rows[n], basis)
        cosine = 1 / np.sqrt(1 + rows[n, _U] ** 2 + rows[n, _V] ** 2)
        _add_depth(depths[n], cosine, basis, wanted, sums)
    out = _solved(sums, wanted, size)
    left = np.sum(depths**2) - np.sum(out * wanted)
    return out, np.sqrt(max(left, 0.0) / max(len(rows), 1))


@njit(cache=True, nogil=True)
def _moved_depths(field, q, rows, distance, down, right):  # pragma: no cover - compiled
    """Depths of a surface at rows, moved by m and by wraps per pixel."""
    wrap = 2 * np.pi / field[3][0]
    slope_u = right * wrap / (field[5][1] - field[5][0])
    slope_v = down * wrap / (field[6][1] - field[6][0])
    # about a pixel, for a slope of a turn per pixel must be whole turns at all of them
    u = _nearest_pixel(field[5], np.mean(rows[:, _U]))
    v = _nearest_pixel(field[6], np.mean(rows[:, _V]))
    out = np.empty(len(rows))
    for n in range(len(rows)):
        shift = distance + slope_v * (rows[n, _V] - v) + slope_u * (rows[n, _U] - u)
        out[n] = max(_row_depth(rows[n], q) + shift, 0.05)
    return out


@njit(inline="always")
def _nearest_pixel(directions, value):  # pragma: no cover - compiled
    """Direction of the row or column of pixels that is nearest to a direction."""
    pitch = directions[1] - directions[0]
    return directions[0] + pitch * np.floor((value - directions[0]) / pitch + 0.5)


@njit(cache=True, nogil=True)
def _add_depth(z, cosine, basis, wanted, sums):  # pragma: no cover - compiled
    """Add a depth to the normal equations of the nearest surface."""
    weight = z**4 * cosine**2
    for i in range(BENT):
        wanted[i] += weight * basis[i] / (z * cosine)
        for j in range(i + 1):
            sums[_M + 6 * i + j] += weight * basis[i] * basis[j]


@njit(cache=True, nogil=True)
def climb(field, rows, q, size, steps):  # pragma: no cover - compiled
    """Climb by Gauss-Newton steps as long as S grows: q and its sums."""
    best = sums_of_rows(field, rows, q)
    for _ in range(steps):
        step = _solved(best, best[_G : _G + 6], size) / _share(best)
        trial = sums_of_rows(field, rows, q + step)
        gain = likelihood(trial) - likelihood(best)
        if gain <= 0:
            break
        q = q + step
        best = trial
        if gain <= _CONVERGED * expected(best):
            break
    return q, best


@njit(cache=True, nogil=True)
def _settled(field, label, only, q, blocks, size):  # pragma: no cover - compiled
    """Climb, and read the pixels again from where that ends, until S grows no more.

    Slopes that differ by a turn per block look alike to its rows: only what is read again counts.
    """
    rows = sum_blocks(field, label, only, q, blocks)
    sums = sums_of_rows(field, rows, q)
    steps = CLIMBS
    for _ in range(_READ):
        trial = climb(field, rows, q, size, steps)[0]
        again = sum_blocks(field, label, only, trial, blocks)
        found = sums_of_rows(field, again, trial)
        gain = likelihood(found) - likelihood(sums)
        if gain > 0:
            q = trial
            rows = again
            sums = found
        if gain < _SETTLED and (gain > 0 or steps == 1):
            break
        steps = CLIMBS if gain > 0 else 1
    return q, sums, rows


@njit(cache=True, nogil=True)
def fit_blocks(field, label, only, q, blocks, size, hops):  # pragma: no cover - compiled
    """Fit a surface to blocks, also hopping by whole wraps as long as S grows: q, sums, rows."""
    found = _settled(field, label, only, q, blocks, size)
    wrap = 2 * np.pi / field[3][0]
    for _ in range(_HOPPED):
        whole = np.rint(offset_of(found[1], size)[0])
        whole = min(max(whole, -hops), hops)
        if whole == 0:
            break
        start = moved(field, found[0], found[2], size, whole * wrap)[0]
        trial = _settled(field, label, only, start, blocks, size)
        if likelihood(trial[1]) <= likelihood(found[1]):
            break
        found = trial
    return found


@njit(cache=True, nogil=True)
def refine(field, label, only, q, blocks, size, hops):  # pragma: no cover - compiled
    """Fit a surface to blocks: q, S, E, the offset left in wraps, and its inverse variance."""
    q, sums, _ = fit_blocks(field, label, only, q, _finer(blocks), size, hops)
    offset, known = offset_of(sums, size)
    return q, likelihood(sums), expected(sums), offset, known


@njit(cache=True, nogil=True)
def _straightened(field, label, only, q, plane, blocks):  # pragma: no cover - compiled
    """The likelier of this plane and those that look bent, their slopes off by a turn per pixel."""
    near = np.full(9, np.inf)
    planes = np.zeros((9, BENT))
    rows = sum_blocks(field, label, only, q, blocks)
    wrap = 2 * np.pi / field[3][0]
    for i in range(9):
        planes[i], near[i] = moved(field, q, rows, PLANE, 0.0, i // 3 - 1, i % 3 - 1)
    for _ in range(2):
        i = np.argmin(near)
        if near[i] < ASTRAY * wrap:
            trial = fit_blocks(field, label, only, planes[i], blocks, PLANE, HOPS)
            if likelihood(trial[1]) > likelihood(plane[1]):
                plane = trial
        near[i] = np.inf
    return plane


@njit(cache=True, nogil=True)
def inflation(field, rows, q):  # pragma: no cover - compiled
    """Median chi^2 of the rows about a surface, over that of noise alone; one at least."""
    squares = np.zeros(len(rows))
    for n in range(len(rows)):
        row = rows[n]
        distance = _row_depth(row, q) - row[_DEPTH]
        pull = 0.0
        weight = 0.0
        for f in range(2):
            k = field[3][f]
            pull += k * _turned(row, f, k * distance)[1]
            weight += k * k * row[_INFORMATION + f]
        squares[n] = pull * pull / max(weight, 1e-9)
    return max(np.median(squares) / _MEDIAN, 1.0)


@njit(cache=True, nogil=True)
def select(field, label, only, q, blocks, gain):  # pragma: no cover - compiled
    """Plane, or a bent surface where that fits much better: by ``gain`` and by `FLAT`.

    Returns q, its sums and rows, and by how much, m (rms), a plane misses the bent surface.
    """
    start = q
    blocks = _finer(blocks)
    if not _is_plane(q):
        rows = sum_blocks(field, label, only, q, blocks)
        start = moved(field, q, rows, PLANE, 0.0)[0]
    plane = fit_blocks(field, label, only, start, blocks, PLANE, HOPS)
    bent = fit_blocks(field, label, only, plane[0], blocks, BENT, HOPS)
    if not _is_plane(q):
        before = fit_blocks(field, label, only, q, blocks, BENT, HOPS)
        if likelihood(before[1]) >= likelihood(bent[1]):
            bent = before
    noise = inflation(field, bent[2], bent[0])
    if likelihood(bent[1]) - likelihood(plane[1]) > gain * noise:
        plane = _straightened(field, label, only, bent[0], plane, blocks)
    lost = likelihood(bent[1]) - likelihood(plane[1])
    stiff = _stiffness(field, plane[1])
    best = bent if lost > gain * noise + stiff * FLAT**2 else plane
    missed = np.sqrt(max(lost - 4.0 * noise, 0.0) / stiff)
    return best[0], best[1], best[2], missed


@njit(inline="always")
def _stiffness(field, sums):  # pragma: no cover - compiled
    """Loss of S, 1 / m^2, by the square of what a surface misses: half of K k^2."""
    return max(expected(sums) * (field[3][0] ** 2 + field[3][1] ** 2) / 4, 1e-9)


@njit(inline="always")
def _is_plane(q):  # pragma: no cover - compiled
    """Whether a surface has no curvature."""
    return q[3] == 0 and q[4] == 0 and q[5] == 0
