"""Compiled loops (Numba): likelihood of a surface over cells and over rectangles, and its fit.

A surface is ``1 / z = cosine (q_0 u + q_1 v + q_2 + q_3 u^2 + q_4 u v + q_5 v^2)``; a plane has
none of the last three. ``field`` is `Field.arrays`; pixels of a ``label`` count, all if it is < 0.
"""

import numpy as np

from cmtof.compiled import njit
from cmtof.surfaces.field import CELL

# As NumPy's integers, for Numba compiles a function again for every literal that it is given.
PLANE, BENT = np.int64(3), np.int64(6)  # parameters of a plane and of a bent surface
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
    x = (turns - 0.5 * whole) * 2 * np.pi
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
    u, v, cosine = field[5], field[6], field[7]
    inverse = q[2] + q[0] * u[x] + q[1] * v[y]
    inverse += q[3] * u[x] * u[x] + q[4] * u[x] * v[y] + q[5] * v[y] * v[y]
    return 1.0 / max(cosine[y, x] * inverse, FARTHEST)


@njit(inline="always")
def pixel_likelihood(field, q, y, x):  # pragma: no cover - compiled
    """S of a surface at one pixel."""
    real, imaginary, wavenumber = field[0], field[1], field[3]
    z = depth_at(field, q, y, x)
    total = 0.0
    for f in range(2):
        c, s = _turn(wavenumber[f] / (2 * np.pi) * z)
        total = total + real[f, y, x] * c + imaginary[f, y, x] * s
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
                turns = depth_at(field, q, y, x) / (2 * np.pi)
                for f in range(2):
                    c, s = _turn(field[3][f] * turns)
                    out[0, f] += field[0][f, y, x] * c + field[1][f, y, x] * s
                    out[1, f] += field[2][f, y, x]
    return out


@njit()
def _moments(field, label, only, q, boxes):  # pragma: no cover - compiled
    """Sums over rectangles: S, E, b, c, then g from 4, h from 10, M from 16 on."""
    moments = np.zeros(52)
    real, imaginary, information, wavenumber, turns, u, v, cosine = field
    k1, k2 = wavenumber[0], wavenumber[1]
    t1, t2 = turns[0], turns[1]
    f1, f2 = k1 / (2 * np.pi), k2 / (2 * np.pi)
    for box in boxes:
        for y in range(box[0], box[1]):
            first = q[0] + q[4] * v[y]
            none = q[2] + q[1] * v[y] + q[5] * v[y] * v[y]
            w0, w1, w2, w3, w4 = 0.0, 0.0, 0.0, 0.0, 0.0
            g0, g1, g2, h0, h1, h2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            likelihood, most, b, c = 0.0, 0.0, 0.0, 0.0
            for x in range(box[2], box[3]):
                counts = 1.0 if only < 0 or label[y, x] == only else 0.0
                inverse = cosine[y, x] * (none + u[x] * (first + q[3] * u[x]))
                z = 1.0 / max(inverse, FARTHEST)
                slope = -z * z * cosine[y, x]
                c1, s1 = _turn(f1 * z)
                c2, s2 = _turn(f2 * z)
                e1 = counts * (imaginary[0, y, x] * c1 - real[0, y, x] * s1)
                e2 = counts * (imaginary[1, y, x] * c2 - real[1, y, x] * s2)
                i1 = counts * information[0, y, x]
                i2 = counts * information[1, y, x]
                likelihood += counts * (real[0, y, x] * c1 + imaginary[0, y, x] * s1)
                likelihood += counts * (real[1, y, x] * c2 + imaginary[1, y, x] * s2)
                most += i1 + i2
                b += e1 * t1 + e2 * t2
                c += i1 * t1 * t1 + i2 * t2 * t2
                g = (e1 * k1 + e2 * k2) * slope
                h = (i1 * t1 * k1 + i2 * t2 * k2) * slope
                w = (i1 * k1 * k1 + i2 * k2 * k2) * slope * slope
                square = u[x] * u[x]
                g0 += g
                g1 += g * u[x]
                g2 += g * square
                h0 += h
                h1 += h * u[x]
                h2 += h * square
                w0 += w
                w1 += w * u[x]
                w2 += w * square
                w3 += w * u[x] * square
                w4 += w * square * square
            moments[0] += likelihood
            moments[1] += most
            moments[2] += b
            moments[3] += c
            row_g = (g0, g1, g2)
            row_h = (h0, h1, h2)
            row_w = (w0, w1, w2, w3, w4)
            power = (1.0, v[y], v[y] * v[y])
            for i in range(BENT):
                up = power[_V[i]]
                moments[4 + i] += up * row_g[_U[i]]
                moments[10 + i] += up * row_h[_U[i]]
                for j in range(i + 1):
                    moments[16 + 6 * i + j] += up * power[_V[j]] * row_w[_U[i] + _U[j]]
    return moments


@njit()
def _solved(moments, right, size):  # pragma: no cover - compiled
    """M^-1 right for the first functions, by elimination, M scaled to a unit diagonal."""
    left, scale, out = np.empty((BENT, BENT)), np.empty(BENT), np.zeros(BENT)
    for i in range(size):
        scale[i] = 1 / np.sqrt(moments[16 + 7 * i] + 1e-12)
        out[i] = scale[i] * right[i]
        for j in range(i + 1):
            left[i, j] = left[j, i] = scale[i] * scale[j] * moments[16 + 6 * i + j]
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
    moments = _moments(field, label, only, q, boxes)
    likelihood, most = moments[0], moments[1]
    share = min(max(likelihood / max(most, 1e-9), 0.3), 1.0)
    g = moments[4:10] / share
    h = moments[10:16]
    step = _solved(moments, g, size)
    shift = _solved(moments, h, size)
    known = max(moments[3] - np.sum(h[:size] * shift[:size]), 1e-12)
    offset = -(moments[2] / share - np.sum(g[:size] * shift[:size])) / known
    return likelihood, most, step, offset, known * share


@njit()
def leaning(field, label, only, q, boxes, weight):  # pragma: no cover - compiled
    """Change (3,) of a plane that is moved by a wrap, and the covariance (3, 3) of its fit."""
    moments, out = _moments(field, label, only, q, boxes), np.empty((4, 3))
    out[0] = _solved(moments, moments[10:16], PLANE)[:3]
    for i in range(3):
        out[1 + i] = _solved(moments, np.eye(6)[i] / weight, PLANE)[:3]
    return out


@njit()
def moved(field, q, boxes, size, distance, down=0, right=0):  # pragma: no cover - compiled
    """Nearest surface to this one moved, by m and by wraps per pixel; their distance, m (rms)."""
    u, v, cosine = field[5], field[6], field[7]
    normal, wanted, basis = np.zeros(52), np.zeros(BENT), np.zeros(BENT)
    wrap, row, column = 2 * np.pi / field[3][0], np.mean(boxes[:, :2]), np.mean(boxes[:, 2:])
    square, count = 0.0, 0
    for n in range(0, boxes.shape[0], max(1, boxes.shape[0] // 100)):
        box = boxes[n]
        for y in range(box[0], box[1], 3):
            below = (1.0, v[y], v[y] * v[y])
            for x in range(box[2], box[3], 3):
                across = (1.0, u[x], u[x] * u[x])
                for j in range(BENT):
                    basis[j] = across[_U[j]] * below[_V[j]]
                value = np.sum(q * basis)
                shift = distance + wrap * (down * (y - row) + right * (x - column))
                z = max(1 / max(cosine[y, x] * value, FARTHEST) + shift, 0.05)
                weight = z**4 * cosine[y, x] ** 2
                square += z * z
                count += 1
                for i in range(size):
                    wanted[i] += weight * basis[i] / (z * cosine[y, x])
                    for j in range(i + 1):
                        normal[16 + 6 * i + j] += weight * basis[i] * basis[j]
    out = _solved(normal, wanted, size)
    return out, np.sqrt(max(square - np.sum(out * wanted), 0.0) / max(count, 1))


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
def refine(field, label, only, q, boxes, size, steps, hops):  # pragma: no cover - compiled
    """Climb, then hop by whole wraps: q, S, E, offset left, its precision."""
    found, wrap = _climb(field, label, only, q, boxes, size, steps), 2 * np.pi / field[3][0]
    for _ in range(5):
        whole = min(max(np.rint(found[3]), -hops), hops)
        if whole == 0:
            break
        new = moved(field, found[0], boxes, size, whole * wrap)[0]
        trial = _climb(field, label, only, new, boxes, size, np.int64(3))
        if trial[1] <= found[1]:
            break
        found = trial
    return found


@njit()
def _straightened(field, label, only, q, plane, boxes, steps):  # pragma: no cover - compiled
    """The likelier of this plane and those that look bent, their slopes off by a turn per pixel."""
    near, planes = np.full(9, np.inf), np.zeros((9, BENT))
    few = boxes[:: max(1, boxes.shape[0] // 25)]
    for i in range(9):
        planes[i], near[i] = moved(field, q, few, PLANE, 0.0, i // 3 - 1, i % 3 - 1)
    for _ in range(2):
        i = np.argmin(near)
        if near[i] < ASTRAY * 2 * np.pi / field[3][0]:
            trial = refine(field, label, only, planes[i], boxes, PLANE, steps, HOPS)
            plane = trial if trial[1] > plane[1] else plane
        near[i] = np.inf
    return plane


@njit()
def select(field, label, only, q, boxes, steps, gain, weight):  # pragma: no cover - compiled
    """Plane, or a bent surface where that fits much better: by ``gain`` and by `FLAT`.

    Returns q, E, offset, its inverse variance, and by how much, m (rms), a plane misses.
    ``weight`` is the number of pixels that stand for each that is looked at.
    """
    k = field[3]
    was_bent = q[3:].any()
    before = refine(field, label, only, q, boxes, BENT if was_bent else PLANE, steps, HOPS)
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
