"""Surfaces that meet share their depth, but for whole wraps.

Along a border two surfaces either meet, with the same depth but for whole wraps, or one hides the
other, and their difference takes any value.
"""

from typing import NamedTuple

import numpy as np

from cmtof.correlation import TAU
from cmtof.surfaces.field import Array, Field, Labels
from cmtof.surfaces.labels import depth_on
from cmtof.surfaces.offsets import Offsets

_LEAST, _LONG = 8, 24  # border, px, below which nothing follows from it; with full odds
# Tolerance, wraps, of a pixel's difference, and per wrap of slope; the same of the median.
_TOLERANCE = (0.25, 1.5, 0.1, 0.3)
# Odds that surfaces meet, by the share of their border that differs by the same whole wraps.
_SUPPORT = ((0.95, 2.0), (0.85, 0.7), (0.6, 0.2), (0.0, 0.02))
_JUMP = 40.0  # wraps over which the depths of surfaces that do not meet are spread
_MEET, _LOOSE = 0.3, 0.05  # odds from which on two surfaces are tied; variance, wraps^2, of a tie


class Borders(NamedTuple):
    """Pairs of surfaces with a common border, one entry (B,) each."""

    first: Labels
    second: Labels
    step: Array  # whole wraps by which the first lies behind along most of it
    odds: Array  # that both meet there, before their offsets are known


class Ties(NamedTuple):
    """Surfaces after the ties, one entry (N,) each."""

    wraps: Array  # whole, to add
    group: Labels
    mean: Array  # offset of the group before rounding, wraps
    spread: Array  # standard deviation of that


class _Steps(NamedTuple):
    """Pairs of pixels across a border, one entry (P,) each."""

    low: Labels  # surface of the smaller number
    high: Labels
    step: Array  # wraps by which the first lies behind
    slope: Array  # change of that across the border


def borders(field: Field, label: Labels, parameters: Array) -> Borders:
    """Odds that surfaces meet, from their depths across every border between labels (H, W)."""
    both = [_across(field, label, parameters, *way) for way in ((1, 0), (0, 1))]
    steps = _Steps(*(np.concatenate(parts) for parts in zip(*both, strict=True)))
    key = steps.low.astype(np.int64) * len(parameters) + steps.high
    order = np.argsort(key, kind="stable")
    found = []
    for part in np.split(order, np.flatnonzero(np.diff(key[order])) + 1):
        if part.size >= _LEAST:
            pair = steps.low[part[0]], steps.high[part[0]]
            found.append((*pair, *_meeting(steps.step[part], steps.slope[part])))
    columns = np.array(found, float).reshape(-1, 4).T
    return Borders(*columns[:2].astype(int), *columns[2:])


def _across(field: Field, label: Labels, parameters: Array, down: int, right: int) -> _Steps:
    """Pixels of different surfaces side by side, one way, and their depths on both sides."""
    here = label[: len(label) - down, : label.shape[1] - right]
    ahead = label[down:, right:]
    y, x = np.nonzero((here != ahead) & (here >= 0) & (ahead >= 0))
    low, high = np.sort([here[y, x], ahead[y, x]], axis=0)
    first, second = (  # differences of depth on this side of the border and on the other
        depth_on(field, parameters, low, *at) - depth_on(field, parameters, high, *at)
        for at in ((y, x), (y + down, x + right))
    )
    period = field.period
    return _Steps(low, high, (first + second) / 2 / period, np.abs(first - second) / period)


def _meeting(step: Array, slope: Array) -> tuple[float, float]:
    """Whole wraps by which most of a border differs, and the odds that its surfaces meet."""
    slope = np.minimum(slope, 1)
    near = _TOLERANCE[0] + _TOLERANCE[1] * slope
    whole = np.unique(np.rint(step))
    support = (np.abs(step[:, None] - whole) < near[:, None]).mean(axis=0)
    best = int(np.argmax(support))
    agreeing = step[np.abs(step - whole[best]) < near.max()]
    rest = np.median(agreeing) - whole[best] if agreeing.size else 0.5
    width = _TOLERANCE[2] + _TOLERANCE[3] * np.median(slope)
    odds = next(value for least, value in _SUPPORT if support[best] >= least)
    odds *= np.exp(-((rest / width) ** 2) / 2) * min(1, step.size / _LONG)
    return whole[best], odds


def tied(found: Offsets, borders: Borders) -> Ties:
    """Tie surfaces, the surest pair first, as long as the odds are good.

    They are those of the border times how much likelier both offsets agree than are anywhere.
    """
    count = found.mean.size
    ties = Ties(np.zeros(count), np.arange(count), found.mean.copy(), found.spread.copy())
    live = borders.odds > 0
    while live.any():
        live &= ties.group[borders.first] != ties.group[borders.second]
        apart, value = _odds(ties, borders)
        value = np.where(live, value, 0)
        n = int(np.argmax(value))
        if value[n] <= _MEET:
            break
        _join(ties, borders.first[n], borders.second[n], apart[n])
    shift, group = ties.wraps, ties.group
    mean = ties.mean[group]
    return Ties(np.rint(mean) + shift, group, mean + shift, ties.spread[group])


def _odds(ties: Ties, borders: Borders) -> tuple[Array, Array]:
    """Wraps by which the groups of each pair lie apart if these meet, and the odds of that."""
    a = ties.group[borders.first]
    b = ties.group[borders.second]
    # meeting: wraps_first - wraps_second = -step
    apart = -borders.step - ties.wraps[borders.first] + ties.wraps[borders.second]
    width = ties.spread[a] ** 2 + ties.spread[b] ** 2 + _LOOSE
    off = ties.mean[a] - ties.mean[b] - apart
    return apart, borders.odds * _JUMP * np.exp(-(off**2) / (2 * width)) / np.sqrt(TAU * width)


def _join(ties: Ties, first: int, second: int, apart: float) -> None:
    """Join the groups of two surfaces; ``wraps`` holds each surface's distance from its group."""
    keep = ties.group[first]
    join = ties.group[second]
    weights = 1 / ties.spread[[keep, join]] ** 2
    both = ties.mean[keep] * weights[0] + (ties.mean[join] + apart) * weights[1]
    ties.mean[keep] = both / weights.sum()
    ties.spread[keep] = 1 / np.sqrt(weights.sum())
    members = ties.group == join
    ties.group[members] = keep
    ties.wraps[members] -= apart
