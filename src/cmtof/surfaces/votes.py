"""Clear pixels that no surface explains follow the vote of their neighbours."""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import uniform_filter

from cmtof.compiled import njit
from cmtof.correlation import TAU
from cmtof.surfaces.field import Array, Field, Mask

DOUBT = 4.0  # deviation, wraps, of a single pixel's beat up to which it may vote and be voted on
_RADIUS = 5  # of the neighbourhood of a vote, px; its Gaussian has half of that
_KERNEL = 0.25  # distance, wraps, within which two depths mean the same
_CAP = 4.0  # largest cost of a neighbour that disagrees, as a log-likelihood
_ASTRAY = 0.3  # distance, rad, of a phase from its surface's beyond which the pixel lies off it
_SQUARE, _MOST = 5, 0.7  # side, px, of a square and the share of it that has to lie on surfaces
_ENOUGH = 3.0  # votes that decide; a pixel alone has one
_FARTHEST = 8  # wraps from a pixel's own beat up to which neighbours may outvote it


class _Poll(NamedTuple):
    """What pixels (H, W) bring to a vote."""

    asked: Mask  # those that are voted on
    low: Array  # phase of the lower frequency, turns
    high: Array
    sharp: Array  # inverse variance of the misfit of both, 1 / turns^2, halved
    place: Array  # depth, wraps, where a surface explains it; else NaN
    near: Array  # weight of neighbours, a square
    ratio: float  # of both frequencies
    farthest: float  # misfit, turns, of the depths that are put to the vote


def voted(field: Field, depth: Array, explained: Mask, closure: float) -> tuple[Array, Array]:
    """Depth (H, W), m, by votes of and for clear pixels that no surface explains, and their share.

    A neighbour costs its distance and its beat's misfit, squared over their variances, up to a cap,
    or where ``explained`` by a surface of that ``depth``, not contradicting it, the first alone.
    """
    out = np.full(depth.shape, np.nan)
    share = np.zeros(depth.shape)
    doubt = doubt_of_beats(field)
    clear = doubt < DOUBT
    # pixels among those whose phases are not those of their surface vote again
    fits = explained & (_astray(field, depth) < _ASTRAY)
    explained = explained & (~clear | (uniform_filter(fits.astype(float), _SQUARE) >= _MOST))
    asked = ~explained & clear
    if asked.any():
        place = np.where(explained, depth / field.period, np.nan)
        limits = np.array(field.limits) / field.period
        _vote(_poll(field, asked, doubt, place, closure), limits, out, share)
    return out * field.period, share


def doubt_of_beats(field: Field) -> Array:
    """Deviation (H, W), wraps, of the beat of each pixel; infinite in the dark."""
    with np.errstate(divide="ignore"):
        variance = 1 / np.maximum(field.information, 0).astype(float)
    ratio = field.wavenumber[1] / field.wavenumber[0]
    return np.sqrt(variance[1] + ratio**2 * variance[0]) / (TAU * abs(field.excess))


def _astray(field: Field, depth: Array) -> Array:
    """Largest distance (H, W), rad, of the phases of a pixel from those of a depth."""
    phasor = field.real + 1j * field.imaginary
    turned = phasor * np.exp(-1j * field.wavenumber[:, None, None] * depth)
    return np.abs(np.angle(turned)).max(axis=0)


def _poll(field: Field, asked: Mask, doubt: Array, place: Array, closure: float) -> _Poll:
    """What pixels bring to a vote, by the deviation ``doubt`` of their beat, wraps."""
    turns = np.arctan2(field.imaginary, field.real).astype(float) / TAU
    turns[1] -= field.excess * closure
    # a quarter of a wrap at least: without noise all other wraps would be ruled out
    spread = np.maximum(np.where(np.isfinite(doubt), doubt, 1.0), 0.25) * abs(field.excess)
    near = np.exp(-((np.arange(-_RADIUS, _RADIUS + 1) / (_RADIUS / 2)) ** 2) / 2)
    ratio = float(field.wavenumber[1] / field.wavenumber[0])
    images = np.mod(turns[0], 1), turns[1], 1 / (2 * spread**2), place
    return _Poll(asked, *images, np.outer(near, near), ratio, _FARTHEST * abs(field.excess))


@njit(cache=True, nogil=True)
def _vote(poll, limits, out, share):  # pragma: no cover - compiled
    """Elect a depth, wraps, for each pixel that is asked, and its share of the votes."""
    votes = np.empty(4 * _FARTHEST)
    depths = np.empty(4 * _FARTHEST)
    for y in range(poll.asked.shape[0]):
        for x in range(poll.asked.shape[1]):
            if not poll.asked[y, x]:
                continue
            low = poll.low[y, x]
            count = 0
            for n in range(int(np.ceil(limits[0] - low)), int(np.ceil(limits[1] - low))):
                left = poll.high[y, x] - poll.ratio * (low + n)
                if abs(left - np.rint(left)) > poll.farthest or count == votes.size:
                    continue
                depths[count] = low + n
                votes[count] = _votes_for(poll, y, x, low + n)
                count += 1
            best = int(np.argmax(votes[:count])) if count > 0 else 0
            if count > 0 and votes[best] > _ENOUGH * _CAP:
                out[y, x] = depths[best]
                share[y, x] = 1 / np.sum(np.exp(votes[:count] - votes[best]))


@njit(cache=True, nogil=True)
def _votes_for(poll, y, x, z):  # pragma: no cover - compiled
    """Weight of the neighbours of a pixel that agree with a depth, wraps."""
    height, width = poll.asked.shape
    scale = 1 / (2 * _KERNEL**2)
    told = 0.0
    for v in range(max(0, y - _RADIUS), min(height, y + _RADIUS + 1)):
        for u in range(max(0, x - _RADIUS), min(width, x + _RADIUS + 1)):
            if np.isfinite(poll.place[v, u]):
                away = poll.place[v, u] - z
                cost = scale * away * away
            elif poll.asked[v, u]:
                near = poll.low[v, u] + np.rint(z - poll.low[v, u])
                away = near - z
                left = poll.high[v, u] - poll.ratio * near
                left -= np.rint(left)
                cost = scale * away * away + poll.sharp[v, u] * left * left
            else:
                continue
            told += poll.near[v - y + _RADIUS, u - x + _RADIUS] * max(_CAP - cost, 0.0)
    return told
