"""Compiled descent of `cmtof.scenes.half_precision`. Imported late: numba costs half a second."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True)
def descend(
    depth: Array,
    low: Array,
    high: Array,
    along: NDArray[np.bool_],
    down: NDArray[np.bool_],
    rounds: int,
) -> Array:
    """Change (H, W) of depth, between low and high, that bends it least; all in m."""
    height, width = depth.shape
    change = np.zeros((height, width))
    ahead = np.zeros((height, width))
    slope = np.empty((height, width))
    momentum = 1.0
    for _ in range(rounds):
        slope[:] = 0
        _add_slope(depth, ahead, along, down, slope)
        following = (1 + np.sqrt(1 + 4 * momentum**2)) / 2
        push = (momentum - 1) / following
        momentum = following
        for i in range(height):
            for j in range(width):
                # 1/32: a second difference has norm 4, and there are two of them
                moved = ahead[i, j] - slope[i, j] / 32
                moved = min(max(moved, low[i, j]), high[i, j])
                ahead[i, j] = moved + push * (moved - change[i, j])
                change[i, j] = moved
    return change


@njit(cache=True)
def _add_slope(
    depth: Array,
    change: Array,
    along: NDArray[np.bool_],
    down: NDArray[np.bool_],
    slope: Array,
) -> None:
    """Gradient of half the summed squared second differences."""
    height, width = depth.shape
    for i in range(height):
        for j in range(width):
            if along[i, j]:
                bend = _bend(depth[i, j - 1], depth[i, j], depth[i, j + 1])
                bend += _bend(change[i, j - 1], change[i, j], change[i, j + 1])
                slope[i, j - 1] += bend
                slope[i, j] -= 2 * bend
                slope[i, j + 1] += bend
            if down[i, j]:
                bend = _bend(depth[i - 1, j], depth[i, j], depth[i + 1, j])
                bend += _bend(change[i - 1, j], change[i, j], change[i + 1, j])
                slope[i - 1, j] += bend
                slope[i, j] -= 2 * bend
                slope[i + 1, j] += bend


@njit(cache=True, inline="always")
def _bend(before: float, here: float, after: float) -> float:
    return before - 2 * here + after
