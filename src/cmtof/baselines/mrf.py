"""A random field over wraps: the beat for each pixel, the steps of the phase between neighbours.

Wraps n minimise ``E(n) = sum_p U_p(n_p) + sum_pq min(jump |n_q - n_p - d_pq|, most)``.

The unary cost ``U_p(n) = kappa_p (1 - cos r_p(n))`` is the von Mises law of the beat, r the
remainder that n leaves of it and ``1 / kappa = (s_2 / a_2)^2 + (k s_1 / a_1)^2`` from noise s and
amplitudes a. ``d_pq = round((phi_p - phi_q) / 2 pi)`` lets the wraps follow the phase across its
jumps, so that a smooth surface costs nothing up to half a wrap per pixel.

`mrf` lowers the energy along eight directions (Hirschmüller 2008). `mrf_graphcut` goes on with a
convex prior by moves of all pixels at once, each a minimum cut; moves by one wrap are those of PUMA
(Bioucas-Dias and Valadão 2007).
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, uniform_filter

from cmtof.baselines import Estimate, phase_noise, within_range, wraps_in_range
from cmtof.baselines.beat import synthetic_frequency
from cmtof.correlation import TAU, depth_from_wraps, wrapped
from cmtof.measurement import Measurement

JUMP, MOST = 0.03, 0.1
"""Cost of a step by one wrap that the phase does not show, and of the largest step: the best of 13
settings on six views of validation rooms, as are the following."""
RADIUS, POOLING = 2, 6.0
"""Half side, px, of the square over which phasors are summed, turned back by the slope, and
standard deviation, px, of the Gaussian over which the beat is averaged."""
MOVES = (4, -4, 2, -2, 1, -1)
"""Moves of a round of graph cuts, wraps."""
_TEMPERATURE = 0.08  # of the softmax: on the same views its mean is 0.36, where 33 % are right
_SHARPEST = 1e4  # largest kappa: a beat known to 0.01 rad needs no more weight
_STRIP_BYTES = 2**28


class Field(NamedTuple):
    """The random field of a measurement.

    Smoothed ``phase`` (H, W), rad, which the labels belong to; ``beat`` (H, W, 2), kappa (cos, sin)
    of what label 0 leaves of it; its ``angles`` (N,) at each label; wrap of the ``first`` label.
    """

    phase: NDArray[np.float32]
    beat: NDArray[np.float32]
    angles: NDArray[np.float64]
    first: int

    def unary(self, labels: NDArray[np.integer]) -> NDArray[np.floating]:
        """Cost (H, W) of labels (H, W), but for a constant."""
        cosine, sine = (f(self.angles).astype(np.float32)[labels] for f in (np.cos, np.sin))
        return -(self.beat[..., 0] * cosine + self.beat[..., 1] * sine)

    def depth(self, labels: NDArray[np.integer], measurement: Measurement) -> NDArray[np.floating]:
        """Depth (H, W), m, of labels (H, W)."""
        phase, frequency = self.phase.astype(float), measurement.frequencies[0]
        return within_range(depth_from_wraps(phase, labels + self.first, frequency), measurement)


def mrf(measurement: Measurement) -> Estimate:
    """Wraps of least cost summed over eight paths.

    Each path is a chain whose best costs up to a pixel follow from the pixel before,
    ``L(q, n) = U_q(n) + min_m [L(p, m) + min(jump |n - m - d_pq|, most)] - min_m L(p, m)``.
    """
    field = wrap_field(measurement)
    labels, odds = semi_global_labels(field)
    return Estimate(field.depth(labels, measurement), odds)


def mrf_graphcut(measurement: Measurement, *, jump: float = JUMP, rounds: int = 2) -> Estimate:
    """Graph cuts with the convex prior ``jump |n_q - n_p - d_pq|``, from where `mrf` ends.

    Ends after ``rounds`` of `MOVES` or when none helps. The confidence is that of the matching,
    inverted where the cuts disagree with it.
    """
    if not 0 < jump < np.inf:
        raise ValueError(f"Expected a cost jump > 0, got {jump:g}. Try {JUMP:g}.")
    field = wrap_field(measurement)
    start, odds = semi_global_labels(field)
    labels = lowered(field, start, jump=jump, rounds=rounds)
    changed = np.where(labels == start, odds, np.minimum(odds, 1 - odds))
    return Estimate(field.depth(labels, measurement), changed)


def wrap_field(measurement: Measurement) -> Field:
    """Smoothed phases and beat of a measurement, weighted by their noise."""
    low, high = measurement.frequencies[:2]
    synthetic = synthetic_frequency(low, high)
    phase, amplitude = measurement.phase[:2].astype(float), measurement.amplitude[:2].astype(float)
    known = (np.isfinite(phase) & np.isfinite(amplitude)).all(axis=0)
    phasors = np.where(known, amplitude, 0) * np.exp(1j * np.where(known, phase, 0))
    slope, smooth = _slope(phasors[0], 2 * RADIUS + 1), np.empty_like(phasors)
    _coherent_mean(*phasors, *slope, high / low, RADIUS, smooth)
    spread = np.where(known & (amplitude > 0), phase_noise(measurement) * amplitude, np.nan)
    noise = np.nanmedian(spread, axis=(1, 2)) if np.isfinite(spread).any() else (0.0, 0.0)
    mean_phase = wrapped(np.angle(smooth[0]))
    beat = synthetic.sign * (np.angle(smooth[1]) - synthetic.multiple * mean_phase)
    # neighbours share what smoothing gained, so each gets the variance of a single pixel
    size = np.abs(smooth)
    with np.errstate(divide="ignore", invalid="ignore"):
        variance = (synthetic.multiple * noise[0] / size[0]) ** 2 + (noise[1] / size[1]) ** 2
    kappa = np.where((size > 0).all(axis=0), 1 / np.maximum(variance, 1 / _SHARPEST), 0)
    first, last = wraps_in_range(measurement)
    share = synthetic.frequency / low
    turned = _pooled(kappa, beat, share * slope)
    turned = turned * np.exp(-1j * share * (mean_phase + TAU * first))
    return Field(
        mean_phase.astype(np.float32),
        np.stack([turned.real, turned.imag], axis=-1).astype(np.float32),
        TAU * share * np.arange(last - first + 1),
        first,
    )


def _slope(phasor: NDArray[np.complex128], window: int) -> NDArray[np.float64]:
    """Slope (2, H, W) down and right, rad/px: angle of the summed products of neighbours."""
    slopes = []
    for axis in (0, 1):
        ahead = np.roll(phasor, -1, axis) * np.conj(phasor)
        ahead[(slice(None),) * axis + (-1,)] = 0  # the last pixel has no neighbour ahead
        products = ahead + np.roll(ahead, 1, axis)  # of both neighbours
        real, imaginary = (uniform_filter(part, window) for part in (products.real, products.imag))
        slopes.append(np.arctan2(imaginary, real))
    return np.stack(slopes)


def _pooled(
    kappa: NDArray[np.float64], beat: NDArray[np.float64], slope: NDArray[np.float64]
) -> NDArray[np.complex128]:
    """Gaussian mean of ``kappa exp(i beat)``, moved by the slope from the centre of its weights."""

    def mean(image: NDArray[np.float64]) -> NDArray[np.float64]:
        return gaussian_filter(image, POOLING, mode="constant")

    total = np.maximum(mean(kappa), np.finfo(float).tiny)
    place = np.indices(kappa.shape, sparse=True)
    off = sum(s * (mean(kappa * at) / total - at) for s, at in zip(slope, place, strict=True))
    phasor = mean(kappa * np.cos(beat)) + 1j * mean(kappa * np.sin(beat))
    return phasor * np.exp(-1j * off)


@njit(cache=True, nogil=True, error_model="numpy")
def _coherent_mean(low, high, down, right, ratio, radius, out):  # pragma: no cover - compiled
    """Mean phasors (2, H, W) over a square, turned back by the slope of the surface."""
    height, width = low.shape
    for y in range(height):
        for x in range(width):
            sum_low, sum_high = 0j, 0j
            for v in range(max(0, y - radius), min(height, y + radius + 1)):
                for u in range(max(0, x - radius), min(width, x + radius + 1)):
                    ramp = down[y, x] * (v - y) + right[y, x] * (u - x)
                    sum_low += low[v, u] * np.exp(-1j * ramp)
                    sum_high += high[v, u] * np.exp(-1j * ratio * ramp)
            out[0, y, x] = sum_low / (2 * radius + 1) ** 2
            out[1, y, x] = sum_high / (2 * radius + 1) ** 2


# --- semi-global matching ----------------------------------------------------------------------


def semi_global_labels(
    field: Field, *, jump: float = JUMP, most: float = MOST, rows: int | None = None
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Labels (H, W) of least aggregated cost over eight paths, and their softmax; see `mrf`.

    To keep memory small the downward sweep leaves its state at the head of every strip of ``rows``
    and runs through each strip again, where the upward sweep meets it; that changes no result.
    """
    height, width = field.phase.shape
    count = field.angles.size
    fitting = max(_STRIP_BYTES // (4 * width * count), round(height**0.5))
    rows = min(rows or fitting, height)
    cosine, sine = (f(field.angles).astype(np.float32) for f in (np.cos, np.sin))
    fixed = (field.beat, field.phase, cosine, sine, np.float32(jump), np.float32(most))
    labels, odds = np.empty((height, width), np.int32), np.empty((height, width), np.float32)
    total = np.empty((rows, width, count), np.float32)
    heads, starts = [np.zeros((3, width, count), np.float32)], range(0, height, rows)
    for start in starts[:-1]:
        heads.append(heads[-1].copy())
        _sweep(*fixed, start, start + rows, 1, heads[-1], total)
    below = np.zeros_like(heads[0])
    for start in reversed(starts):
        stop = min(start + rows, height)
        strip = total[: stop - start]
        strip[:] = 0
        _sweep(*fixed, start, stop, 1, heads.pop(), strip)
        _sweep(*fixed, stop - 1, start - 1, -1, below, strip)
        part = slice(start, stop)
        found = (labels[part], odds[part])
        _choose(field.beat[part], cosine, sine, np.float32(_TEMPERATURE), strip, *found)
    return labels, odds


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _sweep(
    beat, phase, cosine, sine, jump, most, start, stop, step, above, total
):  # pragma: no cover - compiled
    """Four of the paths through rows start, start + step, ..., added to total (rows, W, N).

    ``above`` (3, W, N) holds the costs of the row before and is replaced by those of the last row.
    """
    height, width = phase.shape
    labels = cosine.size
    unary, none = np.empty(labels, np.float32), np.zeros(labels, np.float32)
    wide, spare = np.empty(labels + 2, np.float32), np.empty(labels + 2, np.float32)
    previous, current = above.copy(), np.empty_like(above)
    beside = np.empty((2, labels), np.float32)
    base = min(start, stop - step)
    for y in range(start, stop, step):
        for i in range(width):
            x = i if step > 0 else width - 1 - i
            in_phase, quadrature = beat[y, x, 0], beat[y, x, 1]
            for n in range(labels):
                unary[n] = -(in_phase * cosine[n] + quadrature * sine[n])
            target = total[y - base, x]
            for path in range(4):
                # the pixel before on this path: beside (3), or in the row before (0 to 2)
                v = y if path == 3 else y - step
                u = x - step if path == 3 else x + path - 1
                into = beside[i % 2] if path == 3 else current[path, x]
                before, shift = none, 1  # a path begins
                if 0 <= v < height and 0 <= u < width:
                    before = beside[(i + 1) % 2] if path == 3 else previous[path, u]
                    # labels rise where the phase falls by a wrap
                    shift = 1 - int(np.rint((phase[v, u] - phase[y, x]) / np.float32(2 * np.pi)))
                come = _cheapest(before, wide, spare, jump, most)[shift : shift + labels]
                for n in range(labels):
                    into[n] = unary[n] + come[n]
                for n in range(labels):
                    target[n] += into[n]
        previous, current = current, previous
    above[:] = previous


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _cheapest(before, wide, spare, jump, most):  # pragma: no cover - compiled
    """Min over m of ``before(m) - least + min(jump |n - m|, most)``, a label more at each end.

    Cones of 1, 2, 4, ... steps one after the other make up one as wide as ``most`` lets it count.
    """
    labels = before.size
    least = before[0]
    for n in range(labels):
        least = before[n] if before[n] < least else least
    wide[0] = wide[labels + 1] = most
    inner = wide[1 : labels + 1]
    for n in range(labels):
        inner[n] = min(before[n] - least, most)
    reach = 1
    while reach < labels + 2 and np.float32(reach) * jump < most:
        rise = np.float32(reach) * jump
        rest = labels + 2 - reach
        low, high = wide[:rest], wide[reach:]
        new_low, new_high = spare[:rest], spare[reach:]
        spare[:] = wide
        for n in range(rest):
            new_high[n] = min(new_high[n], low[n] + rise)
        for n in range(rest):
            new_low[n] = min(new_low[n], high[n] + rise)
        wide, spare = spare, wide
        reach *= 2
    return wide


@njit(cache=True, nogil=True, error_model="numpy")
def _choose(beat, cosine, sine, temperature, total, labels, odds):  # pragma: no cover - compiled
    """Label of least cost and its share of exp(-cost); each pixel's own cost counts once."""
    height, width, size = total.shape
    cost = np.empty(size, np.float32)
    for y in range(height):
        for x in range(width):
            for n in range(size):
                own = beat[y, x, 0] * cosine[n] + beat[y, x, 1] * sine[n]
                cost[n] = total[y, x, n] + np.float32(7) * own
            best = np.argmin(cost)
            mass = 0.0
            for n in range(size):
                gap = (cost[n] - cost[best]) / temperature
                if gap < 20:
                    mass += np.exp(-gap)
            labels[y, x], odds[y, x] = best, 1 / mass


# --- graph cuts --------------------------------------------------------------------------------


def lowered(
    field: Field, labels: NDArray[np.integer], *, jump: float, rounds: int
) -> NDArray[np.integer]:
    """Labels (H, W) after moves that lower the energy, until none does or for so many rounds."""
    least = energy(field, labels, jump=jump)
    for _ in range(rounds):
        before = least
        for step in MOVES:
            moved = labels + step * best_move(field, labels, step, jump=jump)
            # costs are rounded to whole units: what gains less than the rounding is not taken
            if (found := energy(field, moved, jump=jump)) < least:
                labels, least = moved, found
        if least == before:
            break
    return labels


def energy(field: Field, labels: NDArray[np.integer], *, jump: float) -> float:
    """E of labels (H, W) with the convex prior."""
    pairs = sum(np.abs(_steps(field, labels, axis)).sum() for axis in (0, 1))
    return float(field.unary(labels).sum(dtype=float) + jump * pairs)


def best_move(
    field: Field, labels: NDArray[np.integer], step: int, *, jump: float
) -> NDArray[np.bool_]:
    """Pixels (H, W) whose move by ``step`` wraps, all at once, lowers the energy most.

    The costs ``A, B, C, A`` of a pair for the choices 00, 01, 10, 11 are ``A + (C - A) (x_p - x_q)
    + (B + C - 2 A) (1 - x_p) x_q``, and a convex prior keeps the last factor >= 0.
    """
    target = labels + step
    inside = (target >= 0) & (target < field.angles.size)
    gain = field.unary(np.where(inside, target, labels)) - field.unary(labels)
    excess, capacities = np.where(inside, gain, np.inf).astype(float), []
    for axis in (1, 0):
        now = _steps(field, labels, axis)
        # x_p = 0, x_q = 1 raises the difference, x_p = 1, x_q = 0 lowers it
        same, ahead, back = (jump * np.abs(now + move) for move in (0, step, -step))
        first, second = ((slice(None),) * axis + (part,) for part in (np.s_[:-1], np.s_[1:]))
        excess[first] += back - same
        excess[second] += same - back
        capacity = np.zeros(labels.shape)
        capacity[first] = ahead + back - 2 * same
        capacities.append(capacity)
    return minimum_cut(excess, *capacities)


def _steps(field: Field, labels: NDArray[np.integer], axis: int) -> NDArray[np.int64]:
    """Steps between neighbouring labels beyond those of the phase, ``n_q - n_p - d_pq``."""
    told = -np.rint(np.diff(field.phase, axis=axis) / TAU).astype(np.int64)
    return np.diff(labels.astype(np.int64), axis=axis) - told


def minimum_cut(
    excess: NDArray[np.floating], right: NDArray[np.floating], down: NDArray[np.floating]
) -> NDArray[np.bool_]:
    """Binary x (H, W) of least ``sum e_p x_p + sum c_pq (1 - x_p) x_q`` on a grid, c >= 0.

    c (H, W) leads to the pixel ``right`` of or ``down`` from p; an infinite excess e forbids x = 1.
    Costs are rounded to 2^-26 of the largest. Of equal minima that with fewest ones is found.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    index = np.arange(excess.size).reshape(excess.shape)
    source, sink = np.full_like(index, excess.size), np.full_like(index, excess.size + 1)
    # x = 0 on the side of the sink: edges that lead there are cut for x = 1 before them
    edges = (
        (source, index, np.maximum(-excess, 0)),
        (index, sink, np.maximum(excess, 0)),
        (index[:, 1:], index[:, :-1], right[:, :-1]),
        (index[1:], index[:-1], down[:-1]),
    )
    start, end, cost = (np.concatenate([e[i].ravel() for e in edges]) for i in range(3))
    scale = 2.0**26 / max(float(cost[np.isfinite(cost)].max(initial=0)), 1e-30)
    capacity = np.rint(np.minimum(cost * scale, 2.0**28)).astype(np.int32)
    graph = csr_array((capacity, (start, end)), shape=(excess.size + 2,) * 2)
    left = csr_array(graph - maximum_flow(graph, excess.size, excess.size + 1).flow)
    left.data[left.data < 0] = 0
    left.eliminate_zeros()
    reached = np.zeros(excess.size + 2, bool)
    reached[breadth_first_order(left, excess.size, return_predecessors=False)] = True
    return reached[: excess.size].reshape(excess.shape)
