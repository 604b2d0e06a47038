"""Surfaces that touch share their offset: what one of them knows, the other learns.

Along a border two surfaces either meet, so that both have the same depth there but for their
unknown whole wraps, or one hides the other, and their difference runs through any value.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.correlation import TAU
from cmtof.surfaces.field import Field
from cmtof.surfaces.labels import depth_of_labels
from cmtof.surfaces.offsets import Offsets

LEAST = 8
"""Border, px, below which nothing is concluded from it."""

_TOLERANCE = (0.25, 1.5, 0.1, 0.3)
# Of one pixel's difference, wraps, and of it per wrap of slope between the surfaces; of the
# border's median, and of it per wrap of slope: a border is known to a pixel.

_SUPPORT = ((0.95, 2.0), (0.85, 0.7), (0.6, 0.2), (0.0, 0.02))
"""Odds that surfaces meet, by the share of their border that differs by the same whole wraps."""

_LONG = 24
"""Border, px, from which on these odds hold in full."""

_JUMP = 40.0
"""Wraps over which the depths of surfaces that do not meet are spread."""

_MEET = 0.3
"""Odds from which on two surfaces are tied."""

_LOOSE = 0.05
"""Variance, wraps^2, of a tie."""


class Borders(NamedTuple):
    """One entry (B,) for each pair of surfaces with a common border."""

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    step: NDArray[np.float64]
    """Whole wraps by which the first lies behind the second along most of the border."""
    odds: NDArray[np.float64]
    """That the two meet there, before anything is known of their offsets."""

    def none(self) -> "Borders":
        """The same surfaces without a border."""
        return Borders(self.first[:0], self.second[:0], self.step[:0], self.odds[:0])


class Tied(NamedTuple):
    """What came of the ties."""

    wraps: NDArray[np.float64]
    """Whole wraps (N,) to add to each surface."""
    group: NDArray[np.int64]
    """Number (N,) of the group that each surface was tied into."""
    mean: NDArray[np.float64]
    """Offset (N,), wraps, that each group's members were found to lack, before rounding."""
    spread: NDArray[np.float64]
    """Its uncertainty (N,), wraps."""


def borders(field: Field, label: NDArray[np.int32], surfaces: NDArray[np.float64]) -> Borders:
    """Compare surfaces across every border between labels (H, W)."""
    count = len(surfaces)
    keys, steps, slopes = [], [], []
    for axis in (0, 1):
        here, ahead = np.delete(label, -1, axis), np.delete(label, 0, axis)
        between = (here != ahead) & (here >= 0) & (ahead >= 0)
        low, high = np.minimum(here, ahead), np.maximum(here, ahead)
        pad = [(0, 0), (0, 0)]
        depths = []  # of both surfaces at both pixels
        for one in (low, high):
            for side in ((0, 1), (1, 0)):
                pad[axis] = side
                at = np.pad(np.where(between, one, -1), pad, constant_values=-1)
                found = depth_of_labels(field, at, surfaces)
                depths.append(np.delete(found, -1 if side == (0, 1) else 0, axis)[between])
        first, second = depths[0] - depths[2], depths[1] - depths[3]
        keys.append(low[between].astype(np.int64) * count + high[between])
        steps.append((first + second) / 2 / field.period)
        slopes.append(np.abs(first - second) / field.period)
    return _judged(np.concatenate(keys), np.concatenate(steps), np.concatenate(slopes), count)


def _judged(
    keys: NDArray[np.int64], steps: NDArray[np.float64], slopes: NDArray[np.float64], count: int
) -> Borders:
    """Odds that the two surfaces of each border meet."""
    order = np.argsort(keys, kind="stable")
    cuts = np.flatnonzero(np.diff(keys[order])) + 1
    found = []
    for part in np.split(order, cuts):
        if part.size < LEAST:
            continue
        step, slope = steps[part], np.minimum(slopes[part], 1)
        near = _TOLERANCE[0] + _TOLERANCE[1] * slope
        whole = np.unique(np.rint(step))
        support = (np.abs(step[:, None] - whole) < near[:, None]).mean(axis=0)
        best = int(np.argmax(support))
        agreeing = step[np.abs(step - whole[best]) < near.max()]
        rest = np.median(agreeing) - whole[best] if agreeing.size else 0.5
        width = _TOLERANCE[2] + _TOLERANCE[3] * np.median(slope)
        odds = next(value for least, value in _SUPPORT if support[best] >= least)
        odds *= np.exp(-((rest / width) ** 2) / 2) * min(1, part.size / _LONG)
        found.append((*divmod(int(keys[part[0]]), count), whole[best], odds))
    columns = list(zip(*found, strict=True)) if found else [(), (), (), ()]
    kinds = (np.int64, np.int64, float, float)
    return Borders(*(np.array(c, kind) for c, kind in zip(columns, kinds, strict=True)))


def tied(found: Offsets, borders: Borders) -> Tied:
    """Tie surfaces, the surest pair first, as long as the odds are good.

    Each group's offset is a Gaussian. If two meet, their offsets differ by known wraps: the odds
    are those of the border times how much likelier the two Gaussians are to agree than to be
    anywhere within `_JUMP` wraps.
    """
    count = found.mean.size
    group, shift = np.arange(count), np.zeros(count)
    mean, variance = found.mean.copy(), found.spread**2
    first, second, step, odds = borders
    live = odds > 0
    while live.any():
        a, b = group[first], group[second]
        live &= a != b
        # meeting: wraps_first - wraps_second = -step
        apart = -step - shift[first] + shift[second]
        width = variance[a] + variance[b] + _LOOSE
        off = mean[a] - mean[b] - apart
        value = odds * _JUMP * np.exp(-(off**2) / (2 * width)) / np.sqrt(TAU * width)
        value = np.where(live, value, 0)
        n = int(np.argmax(value))
        if value[n] <= _MEET:
            break
        keep, join = a[n], b[n]
        weights = 1 / variance[[keep, join]]
        mean[keep] = (
            mean[keep] * weights[0] + (mean[join] + apart[n]) * weights[1]
        ) / weights.sum()
        variance[keep] = 1 / weights.sum()
        members = group == join
        group[members] = keep
        shift[members] -= apart[n]
    return Tied(np.rint(mean[group]) + shift, group, mean[group] + shift, np.sqrt(variance[group]))
