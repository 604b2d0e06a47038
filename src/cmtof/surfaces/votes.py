"""Votes of neighbours on pixels that no surface explains, where their own beats are clear.

Near an outline a body falls away, by half a wrap from pixel to pixel and more. So a neighbour does
not vote for its own depth, but for that of its surface, continued along its slope.
"""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import uniform_filter

from cmtof.compiled import njit
from cmtof.correlation import TAU
from cmtof.surfaces.beats import information_of_beats
from cmtof.surfaces.field import Field
from cmtof.surfaces.roughness import turn_back
from cmtof.types import Array, Arrays, Flags, Numbers

# information of a pixel's beat, 1 / wraps^2, from which on it may vote and be voted on: 4 wraps,
CLEAR = 1 / 16
_MOST_CLEAR = (
    16.0  # and the most that counts: without noise all other wraps would be ruled out
)
_RADIUS = 5  # of the neighbourhood of a vote, px; its Gaussian has half of that
_GAUSS = np.exp(-((np.arange(-_RADIUS, _RADIUS + 1) / (_RADIUS / 2)) ** 2) / 2)
_KERNEL = 0.25  # distance, wraps, within which two depths mean the same
_CAP = 4.0  # largest cost of a neighbour that disagrees, as a log-likelihood
_ASTRAY = 0.3  # distance, rad, of a phase from its surface's beyond which the pixel lies off it
_SQUARE = 5  # side, px, of a square,
_MOST = 0.7  # and the share of it that has to lie on surfaces
_ENOUGH = 3.0  # votes that decide; a pixel alone has one
_FARTHEST = 8  # wraps from a pixel's own beat up to which neighbours may outvote it


class Ballot(NamedTuple):
    """Phases, depths and slopes by which pixels vote, (H, W) each, in lower-frequency wraps."""

    asked: Flags  # whether a pixel is voted on, and votes
    low: Array  # phase, turns
    high: Array  # and that of the higher frequency, without the closure
    sharp: Array  # cost of a beat that misses by a turn
    place: Array  # depth of pixels that a surface explains, NaN for others
    slopes: Array  # of the surface of each (2, H, W), down and to the right, wraps per pixel


def slopes_of_surfaces(depth: Array, label: Numbers) -> Array:
    """Steps (2, H, W) of a depth (H, W) to the next pixel of the same surface, down and right."""
    slopes = []
    for axis in (0, 1):
        step = np.diff(depth, axis=axis) * (np.diff(label, axis=axis) == 0)
        ahead = np.insert(step, step.shape[axis], 0, axis=axis)
        behind = np.insert(step, 0, 0, axis=axis)
        slopes.append(np.where(ahead == 0, behind, ahead))
    return np.array(slopes)


def depth_by_votes(
    field: Field, depth: Array, slopes: Array, explained: Flags, closure: float
) -> Arrays:
    """Depth (H, W), m, after votes on clear pixels that no surface explains, and winners' shares.

    A neighbour costs its distance, along the ``slopes`` of its surface, and its beat's misfit,
    squared over their variances, up to a cap, or where ``explained`` by a surface of that
    ``depth``, not contradicting it, the first alone. Without a vote depths stay and shares are 0.
    """
    known = information_of_beats(field, field.information)
    clear = known > CLEAR
    # pixels among those whose phases are not those of their surface vote again
    turned = turn_back(field, depth)
    close = (np.abs(turned.imag) < np.tan(_ASTRAY) * turned.real).all(axis=0)
    close = uniform_filter((explained & close).astype(float), _SQUARE)
    explained = explained & (~clear | (close >= _MOST))
    step = abs(field.excess)  # of the misfit from wrap to wrap, turns
    low, high = np.angle(field.phasor).astype(float) / TAU
    ballot = Ballot(
        ~explained & clear,
        np.mod(low, 1),
        high - field.excess * closure,
        np.minimum(known, _MOST_CLEAR) / (2 * step**2),
        np.where(explained, depth / field.period, np.nan),
        slopes,
    )
    place, share = _winning_depth(
        ballot, field.ratio, _FARTHEST * step, np.array(field.limits) / field.period
    )
    return np.where(share > 0, place * field.period, depth), share


@njit()
def _winning_depth(ballot, ratio, far, limits):  # pragma: no cover - compiled
    """Depth (H, W), wraps, that wins the vote on each pixel, NaN where none does, and its share."""
    out = np.full(ballot.low.shape, np.nan)
    share = np.zeros(ballot.low.shape)
    for y, x in np.argwhere(ballot.asked):
        own = ballot.low[y, x]
        depths = own + np.arange(np.ceil(limits[0] - own), np.ceil(limits[1] - own))
        left = ballot.high[y, x] - ratio * depths
        depths = depths[np.abs(left - np.rint(left)) <= far][: 4 * _FARTHEST]
        votes = np.array([_support(ballot, ratio, y, x, z) for z in depths])
        if votes.size and votes.max() > _ENOUGH * _CAP:
            out[y, x] = depths[votes.argmax()]
            share[y, x] = 1 / np.sum(np.exp(votes - votes.max()))
    return out, share


@njit()
def _support(ballot, ratio, y, x, z):  # pragma: no cover - compiled
    """Sum of the weighted votes of a pixel and its neighbours for a depth, wraps."""
    height, width = ballot.low.shape
    total = 0.0
    for v in range(max(0, y - _RADIUS), min(height, y + _RADIUS + 1)):
        for u in range(max(0, x - _RADIUS), min(width, x + _RADIUS + 1)):
            step = ballot.slopes[0, v, u] * (y - v) + ballot.slopes[1, v, u] * (x - u)
            cost = _cost_of_depth(ballot, ratio, v, u, z - step)
            weight = _GAUSS[v - y + _RADIUS] * _GAUSS[u - x + _RADIUS]
            total += weight * max(_CAP - cost, 0.0)
    return total


@njit()
def _cost_of_depth(ballot, ratio, y, x, z):  # pragma: no cover - compiled
    """Cost of a depth, wraps, for a pixel, as a log-likelihood; infinite if it has no vote."""
    place = ballot.place[y, x]
    left = 0.0
    if not np.isfinite(place):
        if not ballot.asked[y, x]:
            return np.inf
        place = ballot.low[y, x]
        place += np.rint(z - place)
        left = ballot.high[y, x] - ratio * place
        left -= np.rint(left)
    return (place - z) ** 2 / (2 * _KERNEL**2) + ballot.sharp[y, x] * left * left
