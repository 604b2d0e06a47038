"""Compiled loops (Numba) of the random field over wraps: smoothing and semi-global matching."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

_HUGE = np.float32(1e30)


@njit(cache=True, nogil=True, error_model="numpy")
def _coherent_sum(low, high, down, right, ratio, radius, out):  # pragma: no cover - compiled
    height, width = low.shape
    for y in range(height):
        for x in range(width):
            sum_low, sum_high = 0j, 0j
            for v in range(max(0, y - radius), min(height, y + radius + 1)):
                for u in range(max(0, x - radius), min(width, x + radius + 1)):
                    ramp = down[y, x] * (v - y) + right[y, x] * (u - x)
                    if v == y and u == x:
                        sum_low += low[v, u]
                        sum_high += high[v, u]
                    else:
                        sum_low += low[v, u] * np.exp(-1j * ramp)
                        sum_high += high[v, u] * np.exp(-1j * ratio * ramp)
            out[0, y, x], out[1, y, x] = sum_low, sum_high


def coherent_sum(
    phasors: NDArray[np.complexfloating],
    slope: NDArray[np.floating],
    *,
    ratio: float,
    radius: int,
) -> NDArray[np.complex128]:
    """Mean phasors (2, H, W) over a square, turned back by the slope of the surface.

    Parameters
    ----------
    phasors : ndarray, shape (2, H, W)
        Of the lower and the higher frequency.
    slope : ndarray, shape (2, H, W)
        Slope of the lower phase (down, right), rad/px.
    ratio : float
        Higher over lower frequency: how much steeper its phase is.
    radius : int
        Half side of the square, px.
    """
    out = np.empty(phasors.shape, np.complex128)
    _coherent_sum(phasors[0], phasors[1], slope[0], slope[1], ratio, radius, out)
    return out / (2 * radius + 1) ** 2


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _least(costs):  # pragma: no cover - compiled
    least = costs[0]
    for n in range(costs.size):
        least = costs[n] if costs[n] < least else least
    return least


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _widen(costs, spare, jump, most):  # pragma: no cover - compiled
    """Replace costs h(n) by min over m of h(m) + min(jump |n - m|, most); return the result.

    Cones of 1, 2, 4, ... steps one after the other make up a cone as wide as ``most`` lets it
    count; slices of the same length make each a loop that becomes vector code.
    """
    size = costs.size
    bound = _least(costs) + most
    step = 1
    while step < size and np.float32(step) * jump < most:
        rise = np.float32(step) * jump
        rest = size - step
        old_low, old_high = costs[:rest], costs[step:]
        new_low, new_high = spare[:rest], spare[step:]
        for n in range(size):
            spare[n] = costs[n] if costs[n] < bound else bound
        for n in range(rest):
            other = old_low[n] + rise
            new_high[n] = other if other < new_high[n] else new_high[n]
        for n in range(rest):
            other = old_high[n] + rise
            new_low[n] = other if other < new_low[n] else new_low[n]
        costs, spare = spare, costs
        step *= 2
    for n in range(size):
        costs[n] = costs[n] if costs[n] < bound else bound
    return costs


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _advance(unary, before, into, target, shift, jump, most, one, two):  # pragma: no cover
    """One step of one path: from the costs before to those of this pixel, added to target."""
    labels = unary.size
    inner = one[1 : labels + 1]
    least = _least(before)
    for n in range(labels):
        inner[n] = before[n] - least
    one[0] = one[labels + 1] = _HUGE
    come = _widen(one, two, jump, most)[shift : shift + labels]
    for n in range(labels):
        into[n] = unary[n] + come[n]
    for n in range(labels):
        target[n] += into[n]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _sweep(
    beat, phase, cosine, sine, jump, most, start, stop, step, above, total
):  # pragma: no cover - compiled
    """Four of the eight paths through rows start, start + step, ... before stop.

    ``above`` (3, W, N) holds the costs of the row before and is replaced by those of the last row;
    ``total`` (rows, W, N) gains the sum over the four paths.
    """
    height, width = phase.shape
    labels = cosine.size
    unary, none = np.empty(labels, np.float32), np.zeros(labels, np.float32)
    one, two = np.empty(labels + 2, np.float32), np.empty(labels + 2, np.float32)
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
                if 0 <= v < height and 0 <= u < width:
                    before = beside[(i + 1) % 2] if path == 3 else previous[path, u]
                    turn = (phase[v, u] - phase[y, x]) / np.float32(2 * np.pi)
                    shift = 1 - int(np.rint(turn))  # labels rise where the phase falls by a wrap
                else:
                    before, shift = none, 1  # a path begins
                _advance(unary, before, into, target, shift, jump, most, one, two)
        previous, current = current, previous
    above[:] = previous


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
            best = 0
            for n in range(1, size):
                best = n if cost[n] < cost[best] else best
            mass = 0.0
            for n in range(size):
                gap = (cost[n] - cost[best]) / temperature
                if gap < 20:
                    mass += np.exp(-gap)
            labels[y, x], odds[y, x] = best, 1 / mass


def semi_global_labels(
    beat: NDArray[np.float32],
    phase: NDArray[np.float32],
    angles: NDArray[np.floating],
    *,
    jump: float,
    most: float,
    temperature: float,
    rows: int,
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Labels of least aggregated cost over eight paths, and their softmax.

    The costs of all rows at once would take H W N floats. So the downward sweep first runs through
    and leaves its state at the head of every strip; then, from the last strip up, it runs through
    each strip again, where the upward sweep meets it. The results do not depend on ``rows``.

    Parameters
    ----------
    beat : ndarray of float32, shape (H, W, 2)
        Unary cost of label n: ``-(beat[0] cos(angles[n]) + beat[1] sin(angles[n]))``.
    phase : ndarray of float32, shape (H, W)
        Wrapped phase that the labels belong to, rad.
    angles : ndarray, shape (N,)
        Beat's angle at each label, rad.
    jump, most : float
        Cost of a step of one label beyond the phase's, and of any step at most.
    temperature : float
        Of the softmax.
    rows : int
        Height of a strip.
    """
    height, width = phase.shape
    cosine, sine = np.cos(angles).astype(np.float32), np.sin(angles).astype(np.float32)
    fixed = (beat, phase, cosine, sine, np.float32(jump), np.float32(most))
    labels = np.empty((height, width), np.int32)
    odds = np.empty((height, width), np.float32)
    starts = list(range(0, height, rows))
    total = np.empty((min(rows, height), width, angles.size), np.float32)
    heads = [np.zeros((3, width, angles.size), np.float32)]
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
        _choose(beat[part], cosine, sine, np.float32(temperature), strip, labels[part], odds[part])
    return labels, odds


# --- graph cuts --------------------------------------------------------------------------------

_FAR = np.int32(2**30)


@njit(cache=True, nogil=True, error_model="numpy")
def _distances(excess, capacity, offsets, height, queue):  # pragma: no cover - compiled
    """Set each node's height to its residual distance from the nearest node in deficit."""
    count = 0
    for p in range(excess.size):
        height[p] = _FAR
        if excess[p] < 0:
            height[p] = 0
            queue[count] = p
            count += 1
    done = 0
    while done < count:
        q = queue[done]
        done += 1
        for k in range(4):
            p = q - offsets[k]
            if 0 <= p < excess.size and height[p] == _FAR and capacity[k, p] > 0:
                height[p] = height[q] + 1
                queue[count] = p
                count += 1


@njit(cache=True, nogil=True, error_model="numpy")
def _push_all(excess, capacity, offsets):  # pragma: no cover - compiled
    """Push excess towards deficits until none that is left can reach one; return the heights."""
    size = excess.size
    height, ring = np.empty(size, np.int32), np.empty(size, np.int64)
    waiting = np.zeros(size, np.bool_)
    while True:
        _distances(excess, capacity, offsets, height, ring)
        first, count, lifts = 0, 0, 0
        for p in range(size):
            waiting[p] = excess[p] > 0 and height[p] < _FAR
            if waiting[p]:
                ring[count] = p
                count += 1
        if count == 0:
            return height
        # heights drift from the distances: measure anew after a while
        while count > 0 and lifts < size // 2 + 16:
            p = ring[first]
            first = first + 1 if first + 1 < size else 0
            count -= 1
            waiting[p] = False
            while excess[p] > 0 and height[p] < _FAR:
                lowest = _FAR
                for k in range(4):
                    if capacity[k, p] <= 0:
                        continue
                    q = p + offsets[k]
                    if height[p] != height[q] + 1:
                        lowest = min(lowest, height[q])
                        continue
                    flow = min(excess[p], capacity[k, p])
                    capacity[k, p] -= flow
                    capacity[k ^ 1, q] += flow
                    excess[p] -= flow
                    excess[q] += flow
                    if excess[q] > 0 and not waiting[q]:
                        last = first + count
                        ring[last if last < size else last - size] = q
                        count += 1
                        waiting[q] = True
                    if capacity[k, p] > 0:
                        lowest = min(lowest, height[q])
                    if excess[p] == 0:
                        break
                if excess[p] > 0:
                    lifts += 1
                    height[p] = lowest + 1 if lowest < size else _FAR


def minimum_cut(
    excess: NDArray[np.int64], right: NDArray[np.int64], down: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Binary x (H, W) of least ``sum e_p x_p + sum c_pq (1 - x_p) x_q`` on a grid, c >= 0.

    Preflow-push (Goldberg and Tarjan 1988) with heights measured anew from time to time: excess is
    what choosing x = 1 costs, deficit what it gains, and x = 1 is chosen where a deficit can still
    be reached when no more flow can. Of equal minima the one with the fewest ones is found.

    Parameters
    ----------
    excess : ndarray of int64, shape (H, W)
    right, down : ndarray of int64, shape (2, H, W)
        c_pq to the pixel right of or below p, and back from it to p; ignored beyond the border.
    """
    rows, width = excess.shape
    stride = width + 1  # a column without edges keeps rows apart
    capacity = np.zeros((4, rows, stride), np.int64)
    capacity[0, :, : width - 1] = right[0, :, :-1]
    capacity[1, :, 1:width] = right[1, :, :-1]
    capacity[2, :-1, :width] = down[0, :-1]
    capacity[3, 1:, :width] = down[1, :-1]
    nodes = np.zeros((rows, stride), np.int64)
    nodes[:, :width] = excess
    offsets = np.array([1, -1, stride, -stride])
    height = _push_all(nodes.ravel(), capacity.reshape(4, -1), offsets)
    return height.reshape(rows, stride)[:, :width] < _FAR
