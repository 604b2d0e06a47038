r"""Phase offsets of the two frequencies: what they cost, and how a camera finds its own.

Offsets d_1 and d_2, rad, added to the two phases, do two things. Along (f_1, f_2) they are an
error of range that all pixels share. Across it they move the beat against the phase, and with it
every wrap, by

.. math:: m = \frac{\gamma f_1}{2\pi\,\Delta},\quad \gamma = d_2 - \frac{f_2}{f_1} d_1,\quad
          \Delta = f_2 - k f_1,\ k = \mathrm{round}(f_2/f_1)

wraps. The closure gamma shows wherever a surface tells its beat well: wraps are whole, so what is
left of one is gamma, modulo ``2 pi Delta / f_1`` (17.6 mrad for the prototype). The whole wraps
in it look like range. Planes seen under known angles tell them, for a range error bends a plane;
so does a target at a known range.
"""

from collections.abc import Iterable
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from cmtof.correlation import (
    TAU,
    centred,
    phase_from_depth,
    residual_noise,
    wrap_length,
)
from cmtof.measurement import Measurement

Array = NDArray[np.floating]

SIDE = 64
"""Side of the windows that are pooled, px."""

BLUR = 0.15
"""Variance that a window's fit may leave beyond the noise's, as a share of it."""


# --- what an offset costs ------------------------------------------------------------------------


def closure_of(offset: ArrayLike, frequencies: ArrayLike) -> Array:
    """Closure ``d_2 - (f_2 / f_1) d_1``, rad, of offsets (2, ...), rad.

    Examples
    --------
    >>> round(float(closure_of([0.01, 0.0], (7.15e9, 14.32e9))), 5)
    -0.02003
    """
    low, high = np.asarray(frequencies, float)[:2]
    first, second = np.asarray(offset, float)
    return second - high / low * first


def closure_period(frequencies: ArrayLike) -> float:
    """Closure that moves every wrap by exactly one, ``2 pi |Delta| / f_1``, rad.

    Examples
    --------
    >>> round(1e3 * closure_period((7.15e9, 14.32e9)), 2)  # mrad
    17.58
    """
    return float(abs(TAU * _detuning(frequencies)[1]))


def wraps_moved(offset: ArrayLike, frequencies: ArrayLike) -> Array:
    """Wraps by which offsets (2, ...), rad, move the depth that the beat tells.

    ``(d_2 - k d_1) f_1 / 2 pi Delta``: the closure's wraps plus ``d_1 / 2 pi``, by which the
    phase itself moves.

    Examples
    --------
    >>> np.abs(wraps_moved([[0.0, 0.01], [0.01, 0.0]], (7.15e9, 14.32e9))).round(2).tolist()
    [0.57, 1.14]
    """
    multiple, detuning = _detuning(frequencies)
    first, second = np.asarray(offset, float)
    return (second - multiple * first) / (TAU * detuning)


def count_odds(moved: ArrayLike, spread: ArrayLike, *, limit: int = 1) -> Array:
    r"""Odds that ``|floor(u + e) - floor(u)| < limit`` where a depth errs by e ~ N(m, s).

    u, the place within a wrap, is uniform, so the odds of a known error are a trapezium of e, a
    second difference of ramps; each ramp has the mean ``s phi(x/s) + x Phi(x/s)`` under noise.

    Parameters
    ----------
    moved, spread : array_like
        Mean and standard deviation of the error of the depth, wraps; spread > 0.
    limit : int
        1 for the rate delta < 1, and so on.

    Examples
    --------
    Half a wrap of offset costs half of what a faultless beat would tell:

    >>> round(float(count_odds(0.5, 1e-6)), 3)
    0.5
    """
    ramps = ((1, limit), (-1, limit - 1), (-1, 1 - limit), (1, -limit))
    moved, spread = np.asarray(moved, float), np.asarray(spread, float)
    total = np.zeros(np.broadcast_shapes(moved.shape, spread.shape))
    for sign, edge in ramps:
        x = (moved + edge) / spread
        total += sign * spread * (np.exp(-(x**2) / 2) / np.sqrt(TAU) + x * special.ndtr(x))
    return total


def consistent_odds(moved: ArrayLike, spread: ArrayLike) -> Array:
    """Odds ``P(|e| < 1/2)`` of the wrap that fits the measured phase; arguments in wraps."""
    moved, spread = np.asarray(moved, float), np.asarray(spread, float)
    return special.ndtr((0.5 - moved) / spread) - special.ndtr((-0.5 - moved) / spread)


def moved_rate(shares: ArrayLike, moved: float) -> float:
    """Rate delta < 1 of a method all of whose answers move by the same wraps.

    A depth within a wrap lies anywhere in it, so a fraction f of a wrap carries a share f of the
    pixels into the next: the rate is the share of the errors ``-moved``, linear in between.

    Parameters
    ----------
    shares : array_like, shape (2 E + 1,)
        Of the pixels, by their error -E ... E without the move, wraps; beyond there is nothing.

    Examples
    --------
    >>> moved_rate([0.1, 0.6, 0.1], 0.5)
    0.35
    """
    shares = np.asarray(shares, float)
    most = len(shares) // 2
    errors = np.arange(-most, most + 1)
    return float(np.interp(-moved, errors, shares, left=0.0, right=0.0))


# --- (1) the closure modulo one wrap, from any surfaces ---------------------------------------


class Closures(NamedTuple):
    """Closures that windows show, each modulo one period, rad."""

    value: Array
    """(W,), in half a period to either side of 0."""
    spread: Array
    """Standard deviation (W,) by the phases' noise, rad; infinite where nothing is told."""


class Closure(NamedTuple):
    """A closure known modulo one period, rad."""

    value: float
    spread: float
    """Standard deviation expected of it, rad; that of a guess where nothing is told."""
    windows: int
    """Windows that took part."""


def window_closures(measurement: Measurement, *, side: int = SIDE) -> Closures:
    """Closure of every ``side`` x ``side`` tile that one smooth surface fills.

    A quartic surface is fitted to the phase of the lower frequency (the slope from a Fourier
    transform, then least squares), and both frequencies' phasors are turned back by it and added
    up. A surface that errs moves both sums by one range, so it does not touch the closure. Tiles
    that scatter more than noise does hold an edge, and are left out.

    Parameters
    ----------
    measurement : Measurement
        With correlations at four or more psi, which tell the noise.
    side : int
        px, at least 8.

    Raises
    ------
    ValueError
        If the side is too small, or the noise cannot be told.
    """
    if side < 8:
        raise ValueError(f"Expected windows of 8 px or more, got {side}. Try {SIDE}.")
    if "correlation" not in measurement.dataset:
        raise ValueError("Expected correlations, which tell the noise, got phases. Keep them.")
    images, psi = (measurement.dataset[name].to_numpy() for name in ("correlation", "psi"))
    noise = [
        residual_noise(image, steps) * np.sqrt(2 / steps.size)
        for image, steps in zip(images[:2], psi[:2], strict=True)
    ]
    phasors: NDArray = measurement.amplitude[:2] * np.exp(1j * measurement.phase[:2])
    usable = measurement.mask & np.isfinite(phasors).all(axis=0)
    rows, columns = ([slice(k, k + side) for k in range(0, n - side + 1, side)]
                     for n in measurement.shape)  # fmt: skip
    tiles = [tile for tile in product(rows, columns) if usable[tile].all()]
    found = [_closure(phasors[:, *tile], np.array(noise), measurement) for tile in tiles]
    return Closures(*np.array(found, float).reshape(-1, 2).T)


def pooled_closure(windows: Closures | Iterable[Closures], frequencies: ArrayLike) -> Closure:
    r"""Mean of closures on their circle, each weighted by what it tells.

    With r and s a window's closure and spread in radians of the circle (period = 2 pi), its mean
    resultant is ``rho = exp(-s^2 / 2)`` and ``Var sin(r - mean) = (1 - rho^4) / 2``, so the best
    weights are ``rho / (1 - rho^4)`` and the angle's variance ``1 / sum 2 rho^2 / (1 - rho^4)``:
    ``s^2 / W`` for small s, but ``e^{s^2} / 2 W`` for large. Windows that err by more than two
    radians (5.6 mrad for the prototype) tell next to nothing, however many they are.

    The closures may come from several measurements.
    """
    several = [windows] if isinstance(windows, Closures) else list(windows)
    value = np.concatenate([one.value for one in several])
    spread = np.concatenate([one.spread for one in several])
    turn = TAU / closure_period(frequencies)
    known = np.isfinite(spread)
    rho = np.exp(-((turn * spread[known]) ** 2) / 2)
    lost = -np.expm1(-2 * (turn * spread[known]) ** 2)  # 1 - rho^4
    lost = np.maximum(lost, np.finfo(float).tiny)
    mean = np.sum(rho / lost * np.exp(1j * turn * value[known]))
    information = np.sum(2 * rho**2 / lost)
    guess = closure_period(frequencies) / np.sqrt(12)  # spread of an even guess
    width = guess if information == 0 else min(guess, 1 / (turn * np.sqrt(information)))
    return Closure(float(np.angle(mean) / turn), float(width), int(known.sum()))


def corrected(measurement: Measurement, offset: ArrayLike) -> Measurement:
    """Return the same measurement with offsets (F,), rad, taken out of its phases.

    An error of the phase is one of the reference phase, so psi is corrected, where it is there.
    A closure alone is an offset ``(0, closure)``.
    """
    offset = np.asarray(offset, float)
    dataset = measurement.dataset
    if "correlation" in dataset:
        psi = (dataset["psi"].dims, dataset["psi"].to_numpy() + offset[:, None], {"units": "rad"})
        return Measurement(dataset.assign_coords(psi=psi))
    phase = np.mod(dataset["phase"].to_numpy() - offset[:, None, None], TAU)
    return Measurement(dataset.assign(phase=(dataset["phase"].dims, phase)))


# --- (2) whole wraps, from planes under known angles ------------------------------------------


class RangeError(NamedTuple):
    """The range error that unbends a plane, m."""

    error: float
    spread: float
    """Its standard deviation by the range's noise, m."""
    plane: Array
    """m of ``m . x = 1`` (3,), 1/m."""


def plane_bend(rays: ArrayLike, plane: ArrayLike) -> float:
    r"""Rms distance from any plane, per metre of range error, of a plane that is ranged wrongly.

    A plane ``m . x = 1`` has the range ``r = 1 / (m . u)`` along unit rays u; other planes change
    it by ``-r^2 u . dm``, an error by the same everywhere. What of a constant no ``dm`` takes
    away is the bend. Head-on, and over a square of half angle t,

    .. math:: \textrm{bend} \approx \sqrt{2/45}\,\tan^2 t .

    Parameters
    ----------
    rays : array_like, shape (P, 3)
        Of any length.
    plane : array_like, shape (3,)
        m, 1/m.
    """
    u = _unit(rays)
    tangent = u / (u @ np.asarray(plane, float))[:, None] ** 2
    constant = np.ones(len(u))
    left = constant - tangent @ np.linalg.lstsq(tangent, constant, rcond=None)[0]
    return float(np.sqrt(np.mean(left**2)))


def range_error_of_plane(depth: ArrayLike, rays: ArrayLike, *, noise: float) -> RangeError:
    """Fit a plane and a constant range error to ranges: ``r = 1 / (m . u) + error``.

    Parameters
    ----------
    depth : array_like, shape (P,)
        Range along each ray, m, right but for one constant; four pixels or more.
    rays : array_like, shape (P, 3)
        Of any length.
    noise : float
        Standard deviation of a range, m.
    """
    depth, u = np.asarray(depth, float), _unit(rays)
    if depth.size < 4:
        raise ValueError(
            f"Expected at least 4 pixels for a plane and an error, got {depth.size}. Add pixels."
        )
    error = 0.0
    plane = np.linalg.lstsq(u * depth[:, None], np.ones(depth.size), rcond=None)[0]
    for _ in range(20):  # Gauss-Newton: nearly linear, so it settles within a few steps
        modelled = 1 / (u @ plane)
        slope = np.column_stack([-u * modelled[:, None] ** 2, np.ones(depth.size)])
        step = np.linalg.lstsq(slope, depth - modelled - error, rcond=None)[0]
        plane, error = plane + step[:3], error + step[3]
    spread = noise / (np.sqrt(depth.size) * plane_bend(u, plane))
    return RangeError(float(error), float(spread), plane)


def whole_wraps(errors: Iterable[RangeError], frequency: float) -> tuple[int, float]:
    """Whole wraps that planes agree on, and the odds of them, ``erf(L / (2 sqrt2 spread))``.

    Each plane is weighted by its inverse variance. With odds much below one, a half say, the
    planes do not decide: they are too small, too few or too noisy.
    """
    found = list(errors)
    weight = np.array([one.spread**-2 for one in found])
    mean = np.sum(weight * [one.error for one in found]) / weight.sum()
    length = float(wrap_length(frequency))
    odds = special.erf(length * np.sqrt(weight.sum() / 8))
    return int(np.rint(mean / length)), float(odds)


# --- (3) everything, from a target at a known range -------------------------------------------


def offsets_at_known_range(measurement: Measurement, depth: ArrayLike) -> Array:
    """Offsets (F,), rad, in [-pi, pi), of a target whose range (H, W) or (), m, is known.

    The mean of all valid phasors, turned back by the range. A range that is wrong by d makes
    every later range wrong by d; their wraps stay right as long as d is below half a wrap.
    """
    turned = phase_from_depth(depth, measurement.frequencies[:, None, None])
    phasors = measurement.amplitude * np.exp(1j * (measurement.phase - turned))
    return np.asarray(centred(np.angle(phasors[:, measurement.mask].sum(axis=1))))


def _detuning(frequencies: ArrayLike) -> tuple[int, float]:
    """k and ``Delta / f_1``, with its sign."""
    low, high = np.asarray(frequencies, float)[:2]
    multiple = round(high / low)
    return multiple, float(high / low - multiple)


def _unit(rays: ArrayLike) -> Array:
    rays = np.asarray(rays, float)
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def _closure(
    phasors: NDArray[np.complexfloating], noise: Array, measurement: Measurement
) -> tuple[float, float]:
    """Closure of one tile (2, S, S), and its spread; infinite where no surface fits."""
    low, high = measurement.frequencies[:2]
    multiple, detuning = _detuning((low, high))
    surface = _fitted_phase(phasors[0])
    turned = phasors * np.exp(-1j * surface * np.array([1, high / low])[:, None, None])
    sums = turned.sum(axis=(1, 2))
    across = np.imag(turned * np.exp(-1j * np.angle(sums))[:, None, None])
    # 3 % of the signal are noise enough for a measurement that has none
    allowed = noise**2 + 1e-3 * np.mean(np.abs(turned) ** 2, axis=(1, 2))
    scatter = np.mean(across**2, axis=(1, 2))
    if not (np.abs(sums) > 0).all() or (scatter > (1 + BLUR) * allowed).any():
        return 0.0, np.inf
    first, second = np.angle(sums)
    # the beat repeats, too: take its turn about the middle of the range
    middle = TAU * detuning * sum(measurement.range) / 2 / wrap_length(low)
    beat = middle + centred(second - multiple * first - middle)
    gap = abs(TAU * detuning)
    value = np.remainder(beat - detuning * first + gap / 2, gap) - gap / 2
    spread = np.sqrt(np.sum(across**2, axis=(1, 2))) / np.abs(sums)
    return float(value), float(np.hypot(spread[1], high / low * spread[0]))


def _fitted_phase(phasor: NDArray[np.complexfloating]) -> Array:
    """Quartic surface through the phase of a tile (S, S), rad, 0 in its middle.

    It starts from the slope of the middle and grows; higher orders come in as it does.
    """
    side = phasor.shape[0]
    start = min(side, 24)
    inner = slice((side - start) // 2, (side + start) // 2)
    padded = 8 * start
    peak = np.argmax(np.abs(np.fft.fft2(phasor[inner, inner], (padded, padded))))
    slopes = TAU * np.fft.fftfreq(padded)[list(np.unravel_index(peak, (padded, padded)))] * side
    x = (np.arange(side) - (side - 1) / 2) / side
    v, u = (axis.ravel() for axis in np.meshgrid(x, x, indexing="ij"))
    orders = [(i, j) for i in range(5) for j in range(5 - i)]
    terms = np.stack([v**i * u**j for i, j in orders], axis=1)
    shape = slopes[0] * v + slopes[1] * u
    flat, far = phasor.ravel(), np.maximum(np.abs(u), np.abs(v))
    steps = np.geomspace(start / 2 / side, 0.5, 7)
    for reach, order in zip((*steps, 0.5), (1, 2, 2, 2, 3, 3, 4, 4), strict=True):
        there = far <= reach
        known = terms[:, [i + j <= order for i, j in orders]]
        turned = (flat * np.exp(-1j * shape))[there]
        turned = turned * np.exp(-1j * np.angle(turned.sum()))
        # least squares on the part across, weighted by the amplitude
        size, inside = np.abs(flat[there]), known[there]
        normal = inside.T @ (inside * size[:, None] ** 2)
        step = np.linalg.lstsq(normal, inside.T @ (size * turned.imag), rcond=None)[0]
        shape = shape + known @ step
    return (shape - shape[(side // 2) * (side + 1)]).reshape(phasor.shape)
