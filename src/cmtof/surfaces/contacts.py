"""Where surfaces meet, and the wraps that follow from it for all of them together.

Along a border two surfaces either meet, with the same depth but for whole wraps, or one hides the
other, and their difference takes any value. What meets has offsets that differ by a known number.
Belief propagation passes the probabilities of offsets from surface to surface, so that a contact
counts the more, the more others agree with it.

Constants are fits to views of training rooms, even and with waves, with a camera and without:
`_MEETING` to 11,126 borders of 16 views, and `_LOOP` and `_STRAY` to rates of right wraps there and
on scans of things that the book does not show.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.special import expit, softmax

from cmtof.correlation import TAU
from cmtof.estimate import Components
from cmtof.surfaces.field import Field
from cmtof.surfaces.placing import Offsets, depth_of_labels, depth_of_pixels
from cmtof.surfaces.roughness import sum_nearby, turned_back
from cmtof.types import Array, Numbers

_LEAST = 8  # border, px, below which nothing follows from it
_NEAR = 2  # radius, px, over which a pixel's departure from its surface is averaged
_CLOSE = (
    0.25,
    0.1,
)  # distances, wraps, from the same whole wraps, at which border pixels count
# Log-odds that surfaces meet: without evidence; by the shares of their border that are close; by
# the mean of the latter over all borders; by the log of the length; by slope, wraps per pixel.
_MEETING = (-3.85, 1.66, 1.27, 2.75, 0.41, -0.61)
_FAR = 10  # offset, wraps, up to which the odds of components are told
_FARTHEST = 32  # offset, wraps, from that of the surface alone
_UNSEEN = 0.2  # deviation, wraps, of an offset beside what its spread says
_STRAY = 1e-5  # share of surfaces whose own offset is arbitrary
_OUTSIDE = 1e-6  # density of offsets beyond the limits
_LOOP = 0.3  # power of messages, since the same evidence comes back around loops
_ROUNDS = 30  # of messages,
_DAMPING = 0.5  # of which each keeps that much


class Borders(NamedTuple):
    """Pairs of surfaces with a common border, one entry (B,) each."""

    first: Numbers
    second: Numbers
    step: Numbers  # whole wraps by which the first lies behind along most of it
    odds: Array  # probability that both meet there


class Tied(NamedTuple):
    """Offsets of surfaces by themselves and by their contacts, one entry (N,) each."""

    wraps: Array  # whole, to add
    group: Numbers  # of those whose contacts hold
    share: Array  # probability (N, M) of each to lie (1 - M) / 2 to (M - 1) / 2 wraps beyond

    @property
    def moves(self) -> Numbers:
        """Wraps (M,) of the probabilities."""
        count = self.share.shape[1]
        return np.arange(count) - count // 2

    @property
    def odds(self) -> Array:
        """Probability of these wraps."""
        return self.share[:, self.share.shape[1] // 2]

    def calibrate(self, calibration: tuple) -> "Tied":
        """Probabilities as often right as those of these wraps were, (odds, share right)."""
        factor = np.interp(self.odds, *calibration) / self.odds
        return self._replace(share=self.share * factor[:, None])

    def moved(self, share: Array) -> "Tied":
        """Surfaces at their likeliest moves from these wraps, by probabilities (N, M) of them."""
        most = share.shape[1] // 2
        best = share.argmax(axis=1)
        padded = np.pad(share, ((0, 0), (2 * most, 2 * most)))
        place = best[:, None] + np.arange(4 * most + 1)
        share = np.take_along_axis(padded, place, axis=1)
        return Tied(self.wraps + best - most, self.group, share)


def borders(field: Field, label: Numbers, surfaces: Array) -> Borders:
    """Odds that surfaces meet, from depths across every border between labels (H, W).

    Depths are those of the surfaces, and of their pixels' phases about them.
    """
    pairs, at = _crossings(label)
    jumps = _jumps(field, label, surfaces, pairs, at)
    key = pairs[0].astype(np.int64) * len(surfaces) + pairs[1]
    order = np.argsort(key, kind="stable")
    found = []
    for part in np.split(order, np.flatnonzero(np.diff(key[order])) + 1):
        if part.size >= _LEAST:
            found.append((*pairs[:, part[0]], *_evidence(*jumps[:, part])))
    first, second, step, *evidence = np.array(found, float).reshape(-1, 7).T
    odds = _odds_of_meeting(np.array(evidence).reshape(4, -1))
    return Borders(first.astype(int), second.astype(int), step.astype(int), odds)


def _crossings(label: Numbers) -> tuple[Numbers, Numbers]:
    """Surfaces (2, C), the lower number first, of neighbouring pixels, and the pixels' numbers."""
    pixels = np.arange(label.size).reshape(label.shape)
    here = np.append(pixels[:-1], pixels[:, :-1])  # above, then to the left of a border
    beyond = np.append(pixels[1:], pixels[:, 1:])
    sides = label.ravel()[[here, beyond]]
    crossed = (sides[0] != sides[1]) & (sides.min(axis=0) >= 0)
    at = np.where(sides[0] < sides[1], (here, beyond), (beyond, here))
    return np.sort(sides[:, crossed], axis=0), at[:, crossed]


def _jumps(
    field: Field, label: Numbers, surfaces: Array, pairs: Numbers, at: Numbers
) -> Array:
    """By how much the first of two surfaces lies behind at a border (C,), wraps, and its slope."""
    # on this side of the border and on the other
    one, other = (
        depth_of_pixels(field, surfaces, pairs[0], *place)
        - depth_of_pixels(field, surfaces, pairs[1], *place)
        for place in (np.divmod(side, label.shape[1]) for side in at)
    )
    depth = np.nan_to_num(depth_of_labels(field, label, surfaces))
    turned = np.where(label < 0, 0, turned_back(field, depth)[0])
    departure = np.angle(sum_nearby(turned, label, _NEAR)).ravel() / TAU
    jump = (one + other) / 2 / field.period + departure[at[0]] - departure[at[1]]
    return np.array([jump, np.minimum(np.abs(one - other) / field.period, 1)])


def _evidence(step: Array, tilt: Array) -> tuple:
    """Whole wraps of most steps along a border, shares that are close, log length, and slope."""
    whole = np.unique(np.rint(step))
    off = np.abs(step[:, None] - whole)
    wide, close = (np.mean(off < most, axis=0) for most in _CLOSE)
    best = int(np.argmax(wide))
    return whole[best], wide[best], close[best], np.log(step.size), np.median(tilt)


def _odds_of_meeting(evidence: Array) -> Array:
    """Probability (B,) that surfaces meet, by the evidence (4, B) of their borders."""
    alike = evidence[1].mean() if evidence.size else 0.0
    told = np.insert(evidence, 2, alike, axis=0)
    return expit(_MEETING[0] + np.array(_MEETING[1:]) @ told)


def tied(
    found: Offsets,
    borders: Borders,
    limits: Array,
    repeat: float,
    told: Callable[[Numbers], Array] | None = None,
) -> Tied:
    """Offsets of surfaces by their own beat and shape and by their contacts.

    What is known from elsewhere counts, too: ``told`` returns log-odds of offsets (N, M), wraps.
    They lie within ``limits`` (2, N), wraps; beats repeat after ``repeat`` wraps. The message from
    surface a to b is ``log r_b(m + step) = L log(P q_a(m) + (1 - P) / M)``, where q_a are the
    probabilities at a without the message from b, P those that both meet, times `_agreement`, M the
    number of offsets, and L < 1, since the same evidence comes back around loops.
    """
    base, alone = _own_odds(found, limits, repeat)
    offsets = np.arange(-_FARTHEST, _FARTHEST + 1)
    if told:
        alone += told(base + offsets)
    source = np.append(borders.first, borders.second)
    target = np.append(borders.second, borders.first)
    step = np.append(borders.step, -borders.step)[:, None] + base[source] - base[target]
    place = np.clip(offsets + _FARTHEST - step, -1, offsets.size) + 1
    belief = _propagate(alone, source, target, place, np.tile(borders.odds, 2))
    share = softmax(belief, axis=1)
    alike = Tied(base[:, 0].astype(float), np.zeros(0, int), share).moved(share)
    return alike._replace(group=groups(alike.wraps, borders))


def _own_odds(found: Offsets, limits: Array, repeat: float) -> tuple[Numbers, Array]:
    """Whole wraps (N, 1) nearest to each offset, and log-probabilities (N, M) about them."""
    low, high = limits[..., None]
    mean = found.mean[:, None]
    turns = np.ceil(np.nan_to_num(low - mean, neginf=0.0) / repeat) * repeat
    own = mean + np.where(mean + turns < high, turns, 0)
    base = np.rint(np.clip(own, low, high)).astype(int)
    offsets = np.arange(-_FARTHEST, _FARTHEST + 1)
    off = (offsets - (own - base)) / np.hypot(found.spread, _UNSEEN)[:, None]
    density = softmax(-(off**2) / 2, axis=1) + _STRAY / offsets.size
    every = base + offsets
    inside = (every > low - 1) & (every < high + 1)
    return base, np.log(np.where(inside, density, _OUTSIDE))


def _agreement(alone: Array, source: Numbers, target: Numbers, place: Numbers) -> Array:
    """Factor (2 B,) of the odds of a border; near zero for a step that its surfaces contradict.

    It is the probability of the step by their own offsets, over that of a random one; one at most.
    """
    share = softmax(alone, axis=1)
    there = np.take_along_axis(_padded(share)[source], place, axis=1)
    both = np.sum(there * share[target], axis=1)
    return np.minimum(alone.shape[1] * both, 1)


def _padded(share: Array) -> Array:
    """Probabilities (N, M + 2) of offsets, zero beyond the first and the last."""
    return np.pad(share, ((0, 0), (1, 1)))


def _propagate(
    alone: Array, source: Numbers, target: Numbers, place: Numbers, odds: Array
) -> Array:
    """Log-probabilities (N, M) after messages from sources to targets (2 B,), both ways in turn.

    An offset of the target is at a ``place`` (2 B, M) of the source's, from 1 on.
    """
    count = alone.shape[1]
    agreement = _agreement(alone, source, target, place)
    meets = (odds * agreement)[:, None]
    message = np.zeros(place.shape)
    belief = alone
    for _ in range(_ROUNDS):
        back = np.roll(message, len(source) // 2, axis=0)  # the message the other way
        told = _padded(softmax(belief[source] - back, axis=1))
        told = np.take_along_axis(told, place, axis=1)
        new = _LOOP * np.log(meets * told + (1 - meets) / count)
        new -= new.max(axis=1, keepdims=True)
        message = _DAMPING * message + (1 - _DAMPING) * new
        belief = alone.copy()
        np.add.at(belief, target, message)
    return belief


def groups(wraps: Array, borders: Borders) -> Numbers:
    """Group (N,) of surfaces joined by borders that hold."""
    holds = wraps[borders.first] + borders.step == wraps[borders.second]
    links = borders.first[holds], borders.second[holds]
    graph = coo_array((np.ones(holds.sum(), bool), links), (wraps.size, wraps.size))
    return connected_components(graph, directed=False)[1]


def components(tied: Tied, borders: Borders, label: Numbers) -> Components:
    """Components of surfaces that meet, of pixels labelled (H, W) by surface, -1 for none."""
    group = groups(tied.wraps, borders)
    pixels = np.bincount(label[label >= 0], minlength=group.size)
    odds = np.zeros((group.size, 2 * _FAR + 1))
    np.add.at(odds, group, pixels[:, None] * tied.share[:, np.abs(tied.moves) <= _FAR])
    size = np.bincount(group, pixels, group.size)
    order = np.argsort(-size, kind="stable")
    number = np.append(np.argsort(order)[group] + 1, 0)  # of each surface, and of none
    order = order[: np.count_nonzero(size)]
    return Components(number[label], odds[order] / size[order, None])
