"""Borders at which surfaces may meet, and the whole wraps that these give all surfaces jointly.

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
from scipy.special import expit, softmax

from cmtof.classical.region import groups
from cmtof.correlation import TAU
from cmtof.estimate import Components
from cmtof.surfaces.field import Field, sums_near
from cmtof.surfaces.placing import Offsets
from cmtof.surfaces.roughness import turn_back
from cmtof.surfaces.shapes import depth_of_labels, depth_of_pixels
from cmtof.types import Array, Numbers

_LEAST = 8  # border, px, below which nothing follows from it
_NEAR = 2  # radius, px, over which a pixel's departure from its surface is averaged
# distances, wraps, from the same whole wraps, at which border pixels count
_WIDE = 0.25
_CLOSE = 0.1
# Log-odds that surfaces meet: without evidence; by the shares of their border that are close; by
# the mean of the latter over all borders; by the log of the length; by slope, wraps per pixel.
_MEETING = (-3.85, 1.66, 1.27, 2.75, 0.41, -0.61)
_FAR = 10  # offset, wraps, up to which the odds of components are given
_OFFSETS = np.arange(-32, 33)  # wraps, from that of the surface alone
_UNSEEN = 0.2  # deviation, wraps, of an offset beyond its stated spread
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


class Placement(NamedTuple):
    """Whole wraps to add to surfaces, by their own evidence and contacts, one entry (N,) each."""

    wraps: Numbers  # to add
    group: Numbers  # of those whose contacts hold
    share: Array  # probability (N, M) of each to lie (1 - M) / 2 to (M - 1) / 2 wraps beyond

    @property
    def odds(self) -> Array:
        """Probability (N,) of each surface that its ``wraps`` are right."""
        return self.share[:, self.share.shape[1] // 2]

    def calibrate(self, calibration: tuple) -> "Placement":
        """The placement with ``share`` scaled: ``odds`` follow a table of (odds, rate right)."""
        factor = np.interp(self.odds, *calibration) / self.odds
        return self._replace(share=self.share * factor[:, None])


def borders(field: Field, label: Numbers, surfaces: Array) -> Borders:
    """Borders of 8 px and more between labels (H, W): wraps between depths, odds of a contact.

    Depths are those of the surfaces, and of their pixels' phases about them.
    """
    pairs, at = _crossings(label)
    jumps = _jumps(field, label, surfaces, pairs, at)
    found, of, length = np.unique(
        pairs, axis=1, return_inverse=True, return_counts=True
    )
    rows = [
        (*found[:, n], *_evidence(*jumps[:, of == n]))
        for n in np.flatnonzero(length >= _LEAST)
    ]
    table = np.array(rows, float).reshape(-1, 7)
    whole = table[:, :3].astype(int)
    odds = _odds_of_meeting(table[:, 3:].T)
    return Borders(*whole.T, odds)  # pyright: ignore[reportCallIssue]


def _crossings(label: Numbers) -> tuple[Numbers, Numbers]:
    """Neighbouring pixels of different surfaces: surfaces (2, C), lower first; pixel numbers."""
    pixels = np.arange(label.size).reshape(label.shape)
    here = np.append(pixels[:-1], pixels[:, :-1])  # above, then to the left of a border
    beyond = np.append(pixels[1:], pixels[:, 1:])
    flat = label.ravel()
    at = np.where(flat[here] < flat[beyond], [here, beyond], [beyond, here])
    pairs = flat[at]
    crossed = (pairs[0] >= 0) & (pairs[0] != pairs[1])
    return pairs[:, crossed], at[:, crossed]


def _jumps(
    field: Field, label: Numbers, surfaces: Array, pairs: Numbers, at: Numbers
) -> Array:
    """Wraps by which the first surface is farther at border pixels, and change per px (2, C)."""
    # on this side of the border and on the other
    one, other = (
        np.subtract(
            *(depth_of_pixels(field, surfaces, np.array([n, *place])) for n in pairs)
        )
        for place in zip(*np.divmod(at, label.shape[1]), strict=True)
    )
    depth = depth_of_labels(field, label, surfaces)
    # how far phases about these pixels depart from those of their surface
    total = sums_near(at.ravel(), turn_back(field, depth)[:1], label, _NEAR)
    here, beyond = np.angle(total).reshape(at.shape) / TAU
    jump = (one + other) / 2 / field.period + here - beyond
    return np.array([jump, np.minimum(abs(one - other) / field.period, 1)])


def _evidence(step: Array, tilt: Array) -> tuple:
    """Commonest whole wraps along a border, shares of it near them, log length, median slope."""
    whole = np.unique(np.rint(step))
    off = abs(step[:, None] - whole)
    wide = (off < _WIDE).mean(axis=0)
    best = wide.argmax()
    close = (off[:, best] < _CLOSE).mean()
    return whole[best], wide[best], close, np.log(step.size), np.median(tilt)


def _odds_of_meeting(evidence: Array) -> Array:
    """Probability (B,) that surfaces meet, by the evidence (4, B) of their borders."""
    alike = evidence[1].mean() if evidence.size else 0.0
    known = np.insert(evidence, 2, alike, axis=0)
    base, *weights = _MEETING
    return expit(base + np.array(weights) @ known)


def offsets_with_contacts(
    found: Offsets,
    borders: Borders,
    limits: Array,
    repeat: float,
    prior: Callable[[Numbers], Array] | None = None,
) -> Placement:
    """Offsets of surfaces by their own beat and shape and by their contacts.

    What is known from elsewhere counts, too: ``prior`` returns log-odds of offsets (N, M), wraps.
    They lie within ``limits`` (2, N), wraps; beats repeat after ``repeat`` wraps. The message from
    surface a to b is ``log r_b(m + step) = L log(P q_a(m) + (1 - P) / M)``, where q_a are the
    probabilities at a without the message from b, P those that both meet, times how far their own
    offsets agree with the step, M the number of offsets, and L < 1, since the same evidence comes
    back around loops.
    """
    base, alone = _own_odds(found, limits, repeat)
    if prior:
        alone += prior(base + _OFFSETS)
    source = np.append(borders.first, borders.second)
    target = np.append(borders.second, borders.first)
    step = np.append(borders.step, -borders.step)[:, None]
    step += base[source] - base[target]
    place = np.arange(_OFFSETS.size) - step
    share = _propagate(alone, source, target, place, np.tile(borders.odds, 2))
    share = softmax(share, axis=1)
    best = share.argmax(axis=1)
    wraps = base[:, 0] + _OFFSETS[best]
    share = _values_at(
        share, best[:, None] + np.arange(1 - _OFFSETS.size, _OFFSETS.size)
    )
    # borders join surfaces whose wraps differ by their step
    holds = wraps[borders.first] + borders.step == wraps[borders.second]
    return Placement(
        wraps, groups(borders.first[holds], borders.second[holds], wraps.size), share
    )


def _own_odds(found: Offsets, limits: Array, repeat: float) -> tuple[Numbers, Array]:
    """Whole wraps (N, 1) nearest to each offset, and log-probabilities (N, M) about them."""
    low, high = limits[..., None]
    mean = found.mean[:, None]
    turns = np.ceil(np.nan_to_num(low - mean, neginf=0.0) / repeat) * repeat
    own = mean + np.where(mean + turns < high, turns, 0)
    base = np.rint(np.clip(own, low, high)).astype(int)
    spread = np.hypot(found.spread, _UNSEEN)
    off = (_OFFSETS - (own - base)) / spread[:, None]
    density = softmax(-(off**2) / 2, axis=1)
    density += _STRAY / _OFFSETS.size
    every = base + _OFFSETS
    inside = (every > low - 1) & (every < high + 1)
    return base, np.log(np.where(inside, density, _OUTSIDE))


def _values_at(share: Array, place: Numbers) -> Array:
    """Probabilities (N, K) at places of rows (N, M), zero before the first and after the last."""
    padded = np.pad(share, ((0, 0), (1, 1)))
    place = np.clip(place, -1, share.shape[1]) + 1
    return np.take_along_axis(padded, place, axis=1)


def _propagate(
    alone: Array, source: Numbers, target: Numbers, place: Numbers, odds: Array
) -> Array:
    """Log-probabilities (N, M) after messages from sources to targets (2 B,): B there, B back.

    An offset of the target is at a ``place`` (2 B, M) of the source's, from 0 on. The odds of a
    border count less where the own offsets of its surfaces contradict the step: times the
    probability of the step by these, over that of a random one; one at most.
    """
    count = alone.shape[1]
    share = softmax(alone, axis=1)
    agree = (_values_at(share[source], place) * share[target]).sum(axis=1)
    meets = (odds * np.minimum(count * agree, 1))[:, None]
    message = np.zeros(place.shape)
    belief = alone
    for _ in range(_ROUNDS):
        back = np.roll(message, len(source) // 2, axis=0)  # the message the other way
        share = softmax(belief[source] - back, axis=1)
        new = _LOOP * np.log(meets * _values_at(share, place) + (1 - meets) / count)
        new -= new.max(axis=1, keepdims=True)
        message = _DAMPING * message + (1 - _DAMPING) * new
        belief = alone.copy()
        np.add.at(belief, target, message)
    return belief


def components(placement: Placement, label: Numbers) -> Components:
    """`Components` of an image: groups of joined surfaces, by labels (H, W), -1 for none."""
    group = placement.group
    count = group.size
    pixels = np.bincount(label[label >= 0], minlength=count)
    middle = placement.share.shape[1] // 2
    share = pixels[:, None] * placement.share[:, middle - _FAR : middle + _FAR + 1]
    odds = np.zeros_like(share)
    np.add.at(odds, group, share)
    size = np.bincount(group, pixels, count)
    order = np.argsort(-size, kind="stable")
    rank = np.argsort(order)[group] + 1
    number = np.append(rank, 0)  # of each surface, and of none
    seen = order[: np.count_nonzero(size)]
    return Components(number[label], odds[seen] / size[seen, None])
