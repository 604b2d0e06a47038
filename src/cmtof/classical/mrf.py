"""A random field over wraps: the beat for each pixel, the steps of the phase between neighbours.

Wraps n minimise ``E(n) = sum_p U_p(n_p) + sum_pq min(jump |n_q - n_p - d_pq|, most)``.

The unary cost ``U_p(n) = kappa_p (1 - cos r_p(n))`` is the von Mises law of the beat, r the
remainder that n leaves of it and ``1 / kappa = (s_2 / a_2)^2 + (k s_1 / a_1)^2`` from noise s and
amplitudes a. ``d_pq = round((phi_p - phi_q) / 2 pi)`` lets the wraps follow the phase across its
jumps, so that a smooth surface costs nothing up to half a wrap per pixel.

`mrf` lowers the energy along eight directions (Hirschmüller 2008), `mrf_graphcut` by moves of all
pixels at once, each a minimum cut (Bioucas-Dias and Valadão 2007, there by one wrap).
"""

from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import gaussian_filter, uniform_filter

from cmtof.classical.beat import (
    estimate_with_beat,
    steps,
    synthetic_frequency,
)
from cmtof.compiled import inlined, njit
from cmtof.correlation import TAU, depth_from_wraps, wrapped
from cmtof.estimate import Estimate, quotient, within_range, wraps_in_range
from cmtof.measurement import Measurement
from cmtof.types import Array, Complex, Flags, Numbers, Single

# the best of 13 settings on six views of validation rooms:
JUMP = 0.03  # cost of a step by one wrap that the phase does not show
MOST = np.float32(0.1)  # of the largest step
# half side, px, of the square over which phasors are summed, turned by the slope
RADIUS = 2
POOLING = 6.0  # standard deviation, px, of the Gaussian over which the beat is averaged
MOVES = (4, -4, 2, -2, 1, -1) * 2  # of the graph cuts, wraps
PATHS = [step for step in product((1, 0, -1), repeat=2) if any(step)]  # down, right
# of the softmax: on the same views its mean is 0.36, where 33 % are right
_TEMPERATURE = 0.08
_SHARPEST = 1e4  # largest kappa: a beat known to 0.01 rad needs no more weight


class RandomField(NamedTuple):
    """Smoothed phase, and costs by the beat, of a random field; label n is wrap ``first`` + n."""

    phase: Single  # smoothed, (H, W), rad; the labels belong to it
    beat: Complex  # (H, W), kappa exp(i r) of what label 0 leaves of the beat
    waves: Single  # (2, N), cosine and sine of the angle of the beat at each label
    first: int  # wrap of label 0

    def unary(self, labels: Numbers) -> Array:
        """Cost (H, W) of labels (H, W) but for a constant."""
        cosine, sine = self.waves[:, labels]
        return -(self.beat.real * cosine + self.beat.imag * sine)

    def depth(self, labels: Numbers, measurement: Measurement) -> Array:
        """Depth (H, W), m, of labels (H, W)."""
        depth = depth_from_wraps(
            self.phase.astype(float), labels + self.first, measurement.frequencies[0]
        )
        return within_range(depth, measurement)


def mrf(measurement: Measurement) -> Estimate:
    """Wraps of least cost summed over eight paths, each a chain from pixel to pixel."""
    field = wrap_field(measurement)
    labels, odds = semi_global_labels(field)
    return estimate_with_beat(field.depth(labels, measurement), odds, measurement)


def mrf_graphcut(measurement: Measurement) -> Estimate:
    """Graph cuts with a convex prior on jumps between neighbours, from where `mrf` ends.

    The prior is ``JUMP |n_q - n_p - d_pq|``. The confidence is that of `mrf`, inverted where the
    cuts disagree with it.
    """
    field = wrap_field(measurement)
    start, odds = semi_global_labels(field)
    labels = start
    for step in MOVES:
        moved = labels + step * best_move(field, labels, step)
        # rounding may propose a move that does not lower it
        labels = min(labels, moved, key=partial(energy, field))
    changed = np.where(labels == start, odds, np.minimum(odds, 1 - odds))
    return estimate_with_beat(field.depth(labels, measurement), changed, measurement)


def wrap_field(measurement: Measurement) -> RandomField:
    """Smoothed phases and beat of a measurement, weighted by their noise."""
    low, high = measurement.frequencies
    synthetic = synthetic_frequency(low, high)
    # zero where one of the two is unknown
    known = np.isfinite(measurement.amplitude).all(axis=0)
    phasors = np.where(known, measurement.amplitude, 0) * np.exp(1j * measurement.phase)
    slope = _slope(phasors[0])
    smooth = _coherent_mean(phasors, slope, high / low, RADIUS)
    noise = _noise(phasors, _coherent_mean(phasors, slope, high / low, 1))
    noise[0] *= synthetic.multiple
    mean_phase = wrapped(np.angle(smooth[0]))
    beat = synthetic.sign * (np.angle(smooth[1]) - synthetic.multiple * mean_phase)
    first, last = wraps_in_range(measurement)
    share = synthetic.frequency / low
    beat = _pool_beat(_sharpness(abs(smooth), noise), beat, share * slope)
    beat *= np.exp(-1j * share * (mean_phase + TAU * first))
    angles = TAU * share * np.arange(last - first + 1)
    return RandomField(
        mean_phase.astype(np.float32),
        beat.astype(np.complex64),
        np.array([np.cos(angles), np.sin(angles)], np.float32),
        first,
    )


def _sharpness(size: Array, noise: Array) -> Array:
    """Weight kappa (H, W) of a beat by amplitudes (2, H, W) of its phasors and their noise (2,)."""
    # neighbours share what smoothing gained, so each gets the variance of a single pixel
    variance = (quotient(noise[:, None, None], size, np.inf) ** 2).sum(axis=0)
    return 1 / np.maximum(variance, 1 / _SHARPEST)


def _slope(phasor: Complex) -> Array:
    """Slope (2, H, W) down and right, rad/px: angle of the summed products of neighbours."""
    slopes = []
    for axis in (0, 1):
        ahead = steps(phasor, axis)
        slopes.append(
            np.angle(uniform_filter(ahead + np.roll(ahead, 1, axis), 2 * RADIUS + 1))
        )
    return np.stack(slopes)


def _pool_beat(kappa: Array, beat: Array, slope: Array) -> Complex:
    """Gaussian mean of ``kappa exp(i beat)``, moved by the slope from the centre of its weights."""
    mean = partial(gaussian_filter, sigma=POOLING, mode="constant")
    total = np.maximum(mean(kappa), np.finfo(float).tiny)
    off = np.zeros_like(kappa)
    for steepness, place in zip(slope, np.indices(kappa.shape), strict=True):
        off += steepness * (mean(kappa * place) / total - place)
    return mean(kappa * np.exp(1j * beat)) * np.exp(-1j * off)  # pyright: ignore[reportReturnType]


def _noise(phasors: Complex, means: Complex) -> Array:
    """Noise (2,), counts, of both phasors across the direction of their local means."""
    known = (phasors != 0).all(axis=0)
    if not known.any():
        return np.zeros(2)
    turned = phasors * np.exp(-1j * np.angle(means))
    across = abs(turned.imag[:, known])
    return 1.4826 * np.median(across, axis=1)


def _coherent_mean(
    phasors: Complex, slope: Array, ratio: float, radius: int
) -> Complex:
    """Mean of phasors (2, H, W) over squares, turned back by the slope, the higher by ``ratio``."""
    ratios = np.array([1.0, ratio])[:, None, None]
    down, right = np.exp(-1j * ratios * slope[:, None])
    margin = (radius, radius)
    beyond = np.pad(phasors, [(0, 0), margin, margin])
    moved = sliding_window_view(beyond, slope.shape[1:], axis=(1, 2))
    side = 2 * radius + 1
    total = np.zeros_like(phasors)
    for v, u in np.ndindex(side, side):
        total += moved[:, v, u] * (down ** (v - radius) * right ** (u - radius))
    return total / side**2


def semi_global_labels(field: RandomField) -> tuple[Numbers, Single]:
    """Labels (H, W) of least cost summed over eight paths, and their softmax; see `mrf`."""
    cosine, sine = field.waves
    total = np.zeros((*field.phase.shape, cosine.size), np.float32)
    for down, right in PATHS:
        _add_path(
            field.beat,
            field.phase,
            field.waves,
            down,
            right,
            total,
        )
    labels = np.empty(field.phase.shape, np.intp)
    odds = np.empty_like(field.phase)
    for y, beat in enumerate(field.beat[..., None]):
        # each path counts the pixel's own cost, which counts once
        cost = total[y] + 7 * (beat.real * cosine + beat.imag * sine)
        labels[y] = cost.argmin(axis=1)
        odds[y] = 1 / np.exp(
            (cost.min(axis=1, keepdims=True) - cost) / _TEMPERATURE
        ).sum(axis=1)
    return labels, odds


@njit()
def _add_path(beat, phase, waves, down, right, total):  # pragma: no cover - compiled
    """Costs of the paths from (y - down, x - right) to each pixel, added to total (H, W, N)."""
    # of this row and the one before
    costs = np.empty((2, *total.shape[1:]), np.float32)
    # three labels more at each end
    buffers = np.full((2, waves.shape[1] + 6), MOST)
    for i, j in np.ndindex(phase.shape):
        y = ~i if down < 0 else i  # from the last row up
        x = ~j if right < 0 else j
        here = costs[y % 2, x]
        own = beat[y, x]
        for n in range(here.size):
            here[n] = -(own.real * waves[0, n] + own.imag * waves[1, n])
        if i >= abs(down) and j >= abs(right):
            here += _least_cost(
                costs[(y - down) % 2, x - right],
                phase[y - down, x - right] - phase[y, x],
                buffers,
            )
        total[y, x] += here


@inlined
def _least_cost(before, fall, buffers):  # pragma: no cover - compiled
    """Min over m of ``before(m) - least + min(JUMP |n - m|, MOST)``, moved as the phase falls."""
    wide, spare = buffers
    wide[2] = wide[-3] = MOST
    least = before.min()
    for n in range(before.size):
        wide[3 + n] = min(before[n] - least, MOST)
    # cones of 1 and 2 steps make up one of 3; 4 cost more than MOST
    for reach in (1, 2):
        rise = np.float32(reach * JUMP)
        for n in range(2, wide.size - 2):
            spare[n] = min(
                wide[n],
                min(wide[n - reach], wide[n + reach]) + rise,
            )
        wide, spare = spare, wide
    # labels rise where the phase falls by a wrap
    start = 3 - int(np.rint(fall / np.float32(TAU)))
    return wide[start : start + before.size]


def energy(field: RandomField, labels: Numbers) -> float:
    """Energy of labels (H, W): their own costs, and the convex prior on steps to neighbours."""
    pairs = sum(abs(_steps(field, labels, axis)).sum() for axis in (0, 1))
    return float(field.unary(labels).sum(dtype=float) + JUMP * pairs)


def best_move(field: RandomField, labels: Numbers, step: int) -> Flags:
    """Pixels (H, W) whose move by ``step`` wraps, all at once, lowers the energy most.

    A pair's costs ``A, B, C, A`` for the choices 00, 01, 10, 11 are ``A + (C - A) (x_p - x_q)
    + (B + C - 2 A) (1 - x_p) x_q``, and a convex prior keeps the last factor >= 0.
    """
    target = labels + step
    inside = (target >= 0) & (target < field.waves.shape[1])
    gain = field.unary(np.where(inside, target, labels)) - field.unary(labels)
    excess = np.where(inside, gain, np.inf).astype(float)
    capacities = []
    for axis in (1, 0):
        now = _steps(field, labels, axis)
        # x_p = 0, x_q = 1 raises the difference, x_p = 1, x_q = 0 lowers it
        same = JUMP * abs(now)
        ahead = JUMP * abs(now + step)
        back = JUMP * abs(now - step)
        excess += np.diff(back - same, axis=axis, prepend=0, append=0)
        capacities.append(ahead + back - 2 * same)
    return minimum_cut(excess, *capacities)


def _steps(field: RandomField, labels: Numbers, axis: int) -> Numbers:
    """Steps between neighbouring labels beyond those of the phase, ``n_q - n_p - d_pq``."""
    falls = np.rint(np.diff(field.phase, axis=axis) / TAU)
    return np.diff(labels, axis=axis) + falls.astype(np.int64)


def minimum_cut(excess: Array, right: Array, down: Array) -> Flags:
    """Binary x (H, W) of least ``sum e_p x_p + sum c_pq (1 - x_p) x_q`` on a grid, c >= 0.

    c leads to the pixel ``right`` of p (H, W - 1) or ``down`` from it (H - 1, W); an infinite
    excess e forbids x = 1. Costs are rounded to 2^-26 of the largest.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    source = excess.size
    sink = source + 1
    index = np.arange(source).reshape(excess.shape)
    # x = 0 on the side of the sink: edges that lead there are cut for x = 1 before them
    start = np.concatenate(
        [np.full_like(index, source), index, index[:, 1:], index[1:]], axis=None
    )
    end = np.concatenate(
        [index, np.full_like(index, sink), index[:, :-1], index[:-1]], axis=None
    )
    cost = np.concatenate(
        [np.maximum(-excess, 0), np.maximum(excess, 0), right, down], axis=None
    )
    scale = 2.0**26 / cost[np.isfinite(cost)].max(initial=1e-30)
    capacity = np.rint(np.minimum(cost * scale, 2.0**28)).astype(np.int32)
    graph = csr_array((capacity, (start, end)), shape=(sink + 1, sink + 1))
    left = graph - maximum_flow(graph, source, sink).flow
    reached = breadth_first_order(left, source, return_predecessors=False)
    return np.isin(index, reached)
