r"""Which frequencies tell wraps best: distances between wraps, odds, and a search for better sets.

F phases with noise ``s_i`` at frequencies ``f_i`` see one depth. A guess that is off by d wraps of
the lowest frequency f_1 leaves the residuals

.. math:: \rho_i(d) = \left[2\pi d f_i / f_1\right]_{-\pi}^{\pi}

of which a small shift of the depth absorbs what it can; the rest is the **distance** of the wraps,

.. math:: D^2(d) = \sum_i w_i\rho_i^2 - \frac{(\sum_i w_i f_i\rho_i)^2}{\sum_i w_i f_i^2},
          \qquad w_i = s_i^{-2},

and the odds to prefer the wrong one are ``Q(D / 2)``, Q the tail of the normal law. For a pair
``D(1) = 1 / sigma_n`` of `cmtof.bounds.wrap_noise`. Pooling P pixels whose relative depth is known
makes every distance ``sqrt(P)`` larger.
"""

from collections.abc import Iterator
from itertools import chain, combinations, islice
from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import jv, ndtr, ndtri

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import TAU, consistent_wrap_count, phase_from_depth, wrap_length, wrapped

Array = NDArray[np.floating]

_BLOCK = 2_000_000  # residuals held at a time


class Choice(NamedTuple):
    """A set of frequencies and the pixels that it must pool."""

    frequencies: tuple[float, ...]
    """Hz, lowest first."""
    least: float
    """Fewer pixels cannot give the odds asked for."""
    enough: float
    """So many do."""


def misfit(residual: ArrayLike, frequencies: ArrayLike, noise: ArrayLike) -> Array:
    """Squared residual over its noise that no shift of the depth removes, ``D^2`` above.

    Parameters
    ----------
    residual : array_like, shape (F, ...)
        Phase residuals, rad.
    frequencies, noise : array_like, shape (F, ...)
        Hz, and phase noise, rad; broadcast against the residuals.

    Examples
    --------
    Residuals that grow with the frequency are a mere shift:

    >>> round(float(misfit([0.1, 0.2, 0.3], [1e9, 2e9, 3e9], [1.0, 0.5, 2.0])), 12)
    0.0
    """
    r, f = np.asarray(residual, float), np.asarray(frequencies, float)
    w = 1 / np.square(np.asarray(noise, float))
    shift = np.sum(w * f * r, axis=0) ** 2 / np.sum(w * f * f + 0 * r, axis=0)
    return np.maximum(np.sum(w * r * r, axis=0) - shift, 0)


def likeliest_wrap(
    phase: ArrayLike, *, frequencies: ArrayLike, noise: ArrayLike, depth_range: float
) -> NDArray[np.int64]:
    """Wrap of the lowest frequency that F phases together make likeliest, by search.

    Every wrap n of the range gives a depth from the lowest phase; the other phases' residuals at
    it, wrapped to [-pi, pi), must be small but for a common shift (`misfit`).

    Parameters
    ----------
    phase : array_like, shape (F, ...)
        Wrapped phases, rad.
    frequencies, noise : array_like, shape (F,)
        Hz, and phase noise, rad.
    depth_range : float
        Depths lie in ``0 <= z < depth_range``, m.

    Returns
    -------
    ndarray of int, shape (...)
        The wrap consistent with the measured phase (`cmtof.correlation.consistent_wrap_count`).

    Raises
    ------
    ValueError
        If frequencies, noise, range and phases do not fit one another.
    """
    f, s = _checked(frequencies, noise, depth_range)
    turns = np.asarray(phase, float) / TAU
    if f.ndim != 1 or turns.shape[:1] != f.shape:
        raise ValueError(
            f"Expected one phase image for each of {f.size} frequencies, got shape {turns.shape}. "
            "Put the frequencies first."
        )
    low, column = int(np.argmin(f)), (-1,) + (1,) * (turns.ndim - 1)
    f, s = f.reshape(column), s.reshape(column)
    ratio, length, own = f / f[low], float(wrap_length(f[low].item())), turns[low]
    best, wraps = np.full(own.shape, np.inf), np.zeros(own.shape, np.int64)
    at_zero = turns - ratio * own
    for n in range(_wraps(depth_range, length)):
        off = at_zero - ratio * n
        cost = misfit(TAU * (off - np.rint(off)), f, s)
        better = (cost < best) & ((own + n) * length < depth_range)
        best, wraps = np.where(better, cost, best), np.where(better, n, wraps)
    return wraps


def wrap_distances(
    frequencies: ArrayLike, noise: ArrayLike, *, depth_range: float
) -> tuple[Array, Array]:
    """Distance D(d) of wraps d = 1, 2, … apart, and the share of depths that have such a rival.

    Parameters
    ----------
    frequencies, noise : array_like, shape (F, ...)
        Sets of frequencies, Hz, along the other axes, and phase noise, rad.
    depth_range : float
        Range of depths, all as likely, m: the share is ``1 - d c / 2 f_1 depth_range``.

    Returns
    -------
    distance, share : ndarray, shape (D, ...)

    Raises
    ------
    ValueError
        If frequencies, noise and range cannot be.

    Examples
    --------
    A pair's first distance is one over the noise of its wrap count, 17.1:

    >>> distance, _ = wrap_distances([7.15e9, 14.32e9], 0.134, depth_range=3.0)
    >>> round(1 / float(distance[0]), 1)
    17.1
    """
    f, s = _checked(frequencies, noise, depth_range)
    lowest = f.min(axis=0)
    length = wrap_length(lowest)
    apart = np.arange(1, _wraps(depth_range, float(np.min(length))), dtype=float)
    apart = apart.reshape((-1,) + (1,) * lowest.ndim)
    off = apart * (f / lowest)[:, None]
    distance = np.sqrt(misfit(TAU * (off - np.rint(off)), f[:, None], s[:, None]))
    return distance, np.clip(1 - apart * length / depth_range, 0, 1)


def odds_bounds(
    frequencies: ArrayLike, noise: ArrayLike, *, depth_range: float, pixels: ArrayLike = 1.0
) -> tuple[Array, Array]:
    """Lower and upper bound on the odds of the right wrap, by Gaussian phase noise.

    An error happens where any rival is nearer: at most the sum over rivals, ``2 sum_d share(d)
    Q(D(d) / 2)`` (both sides), at least the largest of its terms. For a pair whose beat turns at
    most once the odds are ``erf(1 / (2 sqrt2 sigma_n))``, just below the upper bound.

    Parameters as in `wrap_distances`, for one set of frequencies; ``pixels`` (...) are pooled, and
    both bounds have their shape.
    """
    distance, share = wrap_distances(frequencies, noise, depth_range=depth_range)
    pixels = np.asarray(pixels, float)
    errors = 2 * share * ndtr(-np.sqrt(pixels)[..., None] * distance / 2)
    return np.maximum(1 - errors.sum(-1), 0), 1 - errors.max(-1, initial=0)


def pixels_needed(
    frequencies: ArrayLike, noise: ArrayLike, *, depth_range: float, odds: float = 0.95
) -> tuple[Array, Array]:
    """Pixels to pool for the given odds: fewer than `least` cannot do, `enough` surely do.

    From the two bounds of `odds_bounds`: whole numbers (...), or infinity where two wraps cannot
    be told apart at all. Parameters as in `wrap_distances`; ``odds`` from 0.5 to below 1.

    Examples
    --------
    >>> [float(p) for p in pixels_needed([7.15e9, 14.32e9], 0.1336, depth_range=3.0)]
    [4436.0, 4440.0]
    """
    if not 0.5 <= odds < 1:
        raise ValueError(f"Expected odds from 0.5 to below 1, got {odds}. Give a fraction.")
    distance, share = wrap_distances(frequencies, noise, depth_range=depth_range)
    least = _least(distance, share, 1 - odds)
    return np.ceil(least), np.ceil(_enough(distance, share, 1 - odds, least))


def _least(distance: Array, share: Array, error: float) -> Array:
    """Pixels (...) below which one rival alone, on both sides, is preferred too often."""
    rare = np.maximum(2 * share, np.finfo(float).tiny)
    reach = -2 * ndtri(np.minimum(error / rare, 0.5))  # the distance that this rival must have
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.where(reach > 0, (reach / distance) ** 2, 0)
    return needed.max(axis=0, initial=1.0)


def _enough(distance: Array, share: Array, error: float, least: Array) -> Array:
    """Pixels (...) at which the sum over all rivals is small enough, by bisection."""
    known = np.isfinite(least)

    def fails(pixels: Array) -> NDArray[np.bool_]:
        tails = ndtr(-np.sqrt(np.where(known, pixels, 1)) * distance / 2)
        return (2 * (share * tails).sum(axis=0) > error) & known

    low = high = np.asarray(least, float)
    while (bad := fails(high)).any():
        low, high = np.where(bad, high, low), np.where(bad, 2 * high, high)
    for _ in range(50):
        middle = np.sqrt(np.where(known, low, 1)) * np.sqrt(np.where(known, high, 1))
        bad = fails(middle)
        low, high = np.where(bad, middle, low), np.where(bad | ~known, high, middle)
    return high


def counted_odds(
    frequencies: ArrayLike,
    noise: ArrayLike,
    *,
    depth_range: float,
    rng: np.random.Generator,
    pixels: float = 1.0,
    draws: int = 4000,
) -> tuple[float, float, float]:
    """Odds of the right wrap by drawing: (share, low, high) with its 95 % (Wilson) interval.

    Depths are uniform in the range; each frequency's phase is that of a phasor with circular
    Gaussian noise, the mean of ``pixels`` phasors of one depth; `likeliest_wrap` decides.

    Parameters as in `likeliest_wrap`, the noise that of one pixel; ``draws`` depths are drawn.
    """
    from scipy.stats import binomtest

    f, s = _checked(frequencies, noise, depth_range)
    depth = rng.uniform(0, depth_range, draws)
    spread = (s / np.sqrt(pixels))[:, None]
    across, along = rng.normal(size=(2, f.size, draws)) * spread
    phase = wrapped(phase_from_depth(depth, f[:, None]) + np.arctan2(across, 1 + along))
    found = likeliest_wrap(phase, frequencies=f, noise=s, depth_range=depth_range)
    low = int(np.argmin(f))
    right = int(np.sum(found == consistent_wrap_count(depth, phase[low], f[low])))
    interval = binomtest(right, draws).proportion_ci(method="wilson")
    return right / draws, float(interval.low), float(interval.high)


def best_choices(
    frequencies: ArrayLike,
    noise: ArrayLike,
    *,
    size: int,
    depth_range: float,
    odds: float = 0.95,
    keep: int = 1,
) -> list[Choice]:
    """Search all sets of a size for those that need the fewest pixels (`Choice.enough`).

    Every set is tried: its `least` is cheap, and a set whose `least` exceeds the best `enough` so
    far needs no closer look. Sets whose lowest frequency lies above 1.5 times the grid's lowest
    are left out, as their wraps are others.

    Parameters
    ----------
    frequencies, noise : array_like, shape (T,)
        Grid of frequencies, Hz, and phase noise at each, rad.
    size, keep : int
        Frequencies of a set; sets to return, the best first.
    depth_range, odds : float
        As in `pixels_needed`.
    """
    f, s = _checked(frequencies, noise, depth_range)
    order = np.argsort(f)
    f, s = f[order], s[order]
    block = max(1, _BLOCK // (size * _wraps(depth_range, float(wrap_length(f[0])))))
    found: list[Choice] = []
    for sets in _blocks(f.size, size, block):
        sets = sets[:, f[sets[0]] < 1.5 * f[0]]
        if not sets.size:
            break
        distance, share = wrap_distances(f[sets], s[sets], depth_range=depth_range)
        least = _least(distance, share, 1 - odds)
        limit = found[-1].enough if len(found) == keep else np.inf
        near = np.flatnonzero(np.isfinite(least) & (least <= limit))
        near = near[np.argsort(least[near], kind="stable")]
        for start in range(0, near.size, 64):
            part = near[start : start + 64]
            if len(found) == keep and least[part[0]] > found[-1].enough:
                break
            d, w, bound = distance[:, part], share[:, part], least[part]
            enough = np.ceil(_enough(d, w, 1 - odds, bound))
            found += [
                Choice(tuple(f[sets[:, i]].tolist()), float(np.ceil(least[i])), float(e))
                for i, e in zip(part, enough, strict=True)
            ]
            found = sorted(found, key=lambda choice: choice.enough)[:keep]
    return found


def _blocks(tones: int, size: int, block: int) -> Iterator[NDArray[np.int64]]:
    """All combinations of ``size`` out of ``tones`` as columns, some at a time."""
    if not 1 <= size <= tones:
        raise ValueError(f"Expected sets of 1 to {tones} frequencies, got {size}. Refine the grid.")
    every = combinations(range(tones), size)
    for _ in range(-(-comb(tones, size) // block)):
        flat = np.fromiter(chain.from_iterable(islice(every, block)), np.int64)
        yield flat.reshape(-1, size).T


def feasible_frequencies(step: float, *, half_bandwidth: float = 10e6) -> Array:
    """Frequencies that the modulators reach, Hz: drives ``step`` apart, and twice each drive.

    Examples
    --------
    >>> (feasible_frequencies(10e6) / 1e9).round(2).tolist()
    [7.14, 7.15, 7.16, 14.28, 14.3, 14.32]
    """
    if not 0 < step <= half_bandwidth:
        raise ValueError(
            f"Expected a step above 0 Hz and up to {half_bandwidth:g}, got {step}. Choose another."
        )
    count = int(np.floor(half_bandwidth / step + 1e-9))
    drives = FREQUENCY_SINGLE + step * np.arange(-count, count + 1)
    return np.concatenate([drives, 2 * drives])


def relative_signal(frequencies: ArrayLike, *, eta: float, half_power: float = np.inf) -> Array:
    r"""Correlation signal at each frequency over that of the single mode at resonance.

    .. math:: \left(\frac{J_m(2\eta')}{J_1(2\eta)}\right)^2,\quad
              \eta' = \frac{\eta}{\sqrt{1 + (\delta/B)^2}}

    with m = 1 at the drive's frequency and 2 at its double, both modulators driven alike, and δ
    the drive's distance from the resonance of half-power half width B.

    Parameters
    ----------
    frequencies : array_like
        Near 7.15 GHz, or near twice that, Hz.
    eta : float
        Drive amplitude at resonance, rad.
    half_power : float
        B, Hz; infinite for the same drive everywhere.

    Examples
    --------
    >>> relative_signal([7.15e9, 14.32e9], eta=np.pi / 4).round(2).tolist()
    [1.0, 0.19]
    """
    f = np.asarray(frequencies, float)
    order = np.rint(f / FREQUENCY_SINGLE)
    if not np.isin(order, (1, 2)).all():
        raise ValueError(
            f"Expected frequencies near {FREQUENCY_SINGLE:g} Hz or twice that, got {f.tolist()}. "
            "The modulators reach no others."
        )
    drive = eta / np.hypot(1, (f / order - FREQUENCY_SINGLE) / half_power)
    return (jv(order, 2 * drive) / jv(1, 2 * eta)) ** 2


def budget_factor(images: int, *, gaussian: bool) -> float:
    """Pixels that a set needs when it shares the time of a pair, over those at the pair's noise.

    Each frequency has ``2 / F`` of the time. With photon noise the variance of a phase grows as
    ``F / 2``; with Gaussian noise of fixed σ in every image the signal falls and the variance
    grows as ``(F / 2)^2``. Pixels grow as the variance.

    Examples
    --------
    >>> budget_factor(3, gaussian=False), budget_factor(3, gaussian=True)
    (1.5, 2.25)
    """
    return (images / 2) ** (2 if gaussian else 1)


def _wraps(depth_range: float, length: float) -> int:
    """Number of wraps that a range touches, the last perhaps in part."""
    return int(np.ceil(depth_range / length - 1e-9))


def _checked(frequencies: ArrayLike, noise: ArrayLike, depth_range: float) -> tuple[Array, Array]:
    f = np.asarray(frequencies, float)
    if f.ndim < 1 or not (np.isfinite(f).all() and (f > 0).all()):
        raise ValueError(f"Expected frequencies above 0 Hz, got {f.tolist()}. Give Hz, one axis.")
    s = np.asarray(noise, float)
    if s.ndim == 1 and s.shape == f.shape[:1]:
        s = s.reshape((-1,) + (1,) * (f.ndim - 1))
    if s.ndim and s.shape[:1] != f.shape[:1]:
        raise ValueError(
            f"Expected phase noise for each of {f.shape[0]} frequencies, got shape {s.shape}. "
            "Give one number, or one for each."
        )
    if not (np.isfinite(s).all() and (s > 0).all()):
        raise ValueError(f"Expected phase noise above 0 rad, got {s.tolist()}. Leave out the rest.")
    if not 0 < depth_range < np.inf:
        raise ValueError(f"Expected a range above 0 m, got {depth_range}. Give a length.")
    return f, np.broadcast_to(s, f.shape)
