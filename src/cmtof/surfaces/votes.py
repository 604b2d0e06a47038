r"""Where no surface explains a pixel and little noise lies on it: a vote among its neighbours.

A pixel could be as deep as any of its wraps, :math:`z_n = n + \phi_1/2\pi` wraps. At a depth z a
neighbour has the cost of its wrap that comes nearest,

.. math:: \frac{(z_m - z)^2}{2h^2} + \frac{r_m^2}{2s^2}, \quad r_m = \phi_2 - 2\pi k z_m, \quad
          s^2 = s_2^2 + k^2 s_1^2, \quad k = f_2/f_1,

one on a surface the first term with that surface's depth. No cost exceeds a cap, for who lies on
another body tells nothing; the depth of least cost wins. The sum of capped squares is the robust
form of a product of likelihoods, where `cmtof.baselines.kde` sums the likelihoods themselves. On
one noisy pixel all wraps of a range are alike: then nobody is asked.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cmtof.correlation import TAU
from cmtof.surfaces.field import Field

DOUBT = 4.0
"""Standard deviation, wraps, of a single pixel's beat up to which it may vote and be voted on."""

RADIUS = 5
"""Of the neighbourhood, px; its Gaussian has half of that."""

KERNEL = 0.25
"""How far, wraps, two depths may lie apart and mean the same."""

CAP = 4.0
"""What a neighbour that disagrees costs at most, as a log-likelihood."""

ASTRAY = 0.3
"""Distance, rad, of a phase from its surface's beyond which the pixel does not lie on it."""

SQUARE, MOST = 5, 0.7
"""Side, px, of the square about a pixel, and the share of it that has to lie on surfaces."""

ENOUGH = 3.0
"""Votes that decide; a pixel alone has one."""

_FARTHEST = 8
"""Wraps from what a pixel's own beat says up to which neighbours may outvote it."""


class Votes(NamedTuple):
    """What the neighbours voted for."""

    depth: NDArray[np.float64]
    """(H, W), m; NaN where nothing was decided."""
    share: NDArray[np.float64]
    """Share of the votes that the winner has (H, W), 0 where nothing was decided."""


def wrap_doubt(field: Field) -> NDArray[np.float64]:
    """Standard deviation (H, W), wraps, of the wrap count that one pixel's beat tells."""
    ratio = float(field.wavenumber[1] / field.wavenumber[0])
    with np.errstate(divide="ignore"):
        variance = 1 / np.maximum(field.information, 0).astype(float)
    return np.sqrt(variance[1] + ratio**2 * variance[0]) / (TAU * abs(field.excess))


def voted(field: Field, depth: NDArray[np.float64], explained: NDArray[np.bool_]) -> Votes:
    """Let pixels that no surface explains, and that noise leaves clear, vote.

    Parameters
    ----------
    field : Field
    depth : ndarray, shape (H, W)
        m, of the explained pixels.
    explained : ndarray of bool, shape (H, W)
        Pixels that lie on a surface: they vote and are not voted on, unless their own phases or
        their neighbours speak against it.
    """
    out, share = np.full(depth.shape, np.nan), np.zeros(depth.shape)
    doubt = wrap_doubt(field)
    clear = doubt < DOUBT
    explained = explained & ~(clear & _astray(field, depth, explained))
    asked = ~explained & clear
    if asked.any():
        turns = np.mod(np.arctan2(field.imaginary, field.real) / TAU, 1).astype(float)
        ratio = float(field.wavenumber[1] / field.wavenumber[0])
        step = TAU * abs(field.excess)  # of the misfit from wrap to wrap, rad
        # a quarter of it at least: without noise all other wraps would be ruled out
        spread = np.maximum(np.where(np.isfinite(doubt), doubt, 1.0), 0.25) * step
        place = np.where(explained, depth / field.period, np.nan)
        limits = np.array(field.limits) / field.period
        farthest = _FARTHEST * step / TAU
        precision = TAU**2 / (2 * spread**2)
        images = turns[0], turns[1], precision, place
        _vote(asked, *images, ratio, farthest, limits, _window(), KERNEL, CAP, out, share)
    return Votes(out * field.period, share)


def _astray(
    field: Field, depth: NDArray[np.float64], explained: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Pixels (H, W) whose phases are not those of their surface, or that lie among such ones."""
    from scipy.ndimage import uniform_filter

    phasor = field.real + 1j * field.imaginary
    turned = phasor * np.exp(-1j * field.wavenumber[:, None, None] * depth)
    fits = explained & (np.abs(np.angle(turned)).max(axis=0) < ASTRAY)
    return ~fits | (uniform_filter(fits.astype(float), SQUARE) < MOST)


def _window() -> NDArray[np.float64]:
    steps = np.arange(-RADIUS, RADIUS + 1) / (RADIUS / 2)
    one = np.exp(-(steps**2) / 2)
    return np.outer(one, one)


@njit(cache=True, nogil=True)
def _misfit(low, high, ratio, precision, n):  # pragma: no cover - compiled
    left = high - ratio * (low + n)
    left -= np.rint(left)
    return precision * left * left


@njit(cache=True, nogil=True)
def _vote(
    asked, low, high, precision, place, ratio, farthest, limits, window, kernel, cap, out, share
):  # pragma: no cover - compiled
    height, width = asked.shape
    radius = window.shape[0] // 2
    scale = 1 / (2 * kernel**2)
    votes = np.empty(4 * _FARTHEST)
    depths = np.empty(4 * _FARTHEST)
    for y in range(height):
        for x in range(width):
            if not asked[y, x]:
                continue
            first = int(np.ceil(limits[0] - low[y, x]))
            last = int(np.ceil(limits[1] - low[y, x]))
            count = 0
            for n in range(first, last):
                left = high[y, x] - ratio * (low[y, x] + n)
                if abs(left - np.rint(left)) > farthest or count == votes.size:
                    continue
                z, told = low[y, x] + n, 0.0
                for v in range(max(0, y - radius), min(height, y + radius + 1)):
                    for u in range(max(0, x - radius), min(width, x + radius + 1)):
                        if np.isfinite(place[v, u]):
                            away = place[v, u] - z
                            cost = scale * away * away
                        elif asked[v, u]:
                            m = np.rint(z - low[v, u])
                            away = low[v, u] + m - z
                            cost = scale * away * away
                            cost += _misfit(low[v, u], high[v, u], ratio, precision[v, u], m)
                        else:
                            continue
                        told += window[v - y + radius, u - x + radius] * max(cap - cost, 0.0)
                votes[count], depths[count] = told, z
                count += 1
            if count == 0:
                continue
            best = int(np.argmax(votes[:count]))
            if votes[best] > ENOUGH * cap:
                out[y, x] = depths[best]
                share[y, x] = 1 / np.sum(np.exp(votes[:count] - votes[best]))
