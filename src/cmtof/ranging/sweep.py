r"""The sweep of Fig. 13 and Table 4: errors over positions, repeats, and what they are made of.

The error of one repeat at stage position x is split by least squares,

.. math:: e(x) = \underbrace{o}_{offset} + s\,(x - \bar x) + r(x), \qquad
          \mathrm{RMSE}^2 = o^2 + s^2\,\mathrm{var}(x) + \frac{P-2}{P}\,\sigma_r^2

The scatter :math:`\sigma_r` of P positions counts the two that the line takes.

Gaussian errors about zero have MAE/RMSE = sqrt(2/pi) = 0.80, a constant offset has 1.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import root_scalar
from scipy.special import erf

from cmtof.correlation import wrap_length
from cmtof.ranging.target import StageTarget

Array = NDArray[np.float64]

POSITIONS = 5e-5 * np.arange(21)
"""Stage positions, m: 1 mm in steps of 50 um (Sec. 8.2)."""

GAUSSIAN_RATIO = float(np.sqrt(2 / np.pi))
"""MAE/RMSE of many Gaussian errors about zero."""


class Ranger(Protocol):
    """An instrument that measures ranges."""

    def sweep(self, target: StageTarget, positions: ArrayLike, *, repeats: int, seed: int) -> Array:
        """Estimate ranges (repeats, P), m, at stage positions (P,), m from target.distance."""
        ...

    def bound(self, target: StageTarget, positions: ArrayLike) -> Array:
        """Least standard deviation (P,), m, of one estimate by noise alone."""
        ...


# --- errors -> numbers -------------------------------------------------------------------------


def rmse(errors: ArrayLike) -> Array:
    """Root mean square (...) of errors (..., P), in their unit.

    Examples
    --------
    >>> float(rmse([3.0, -4.0, 5.0, 0.0])), float(mae([3.0, -4.0, 5.0, 0.0]))
    (3.5355339059327378, 3.0)
    """
    return np.sqrt(np.mean(np.square(errors), axis=-1))


def mae(errors: ArrayLike) -> Array:
    """Mean size (...) of errors (..., P), in their unit."""
    return np.mean(np.abs(errors), axis=-1)


class Parts(NamedTuple):
    """What the errors of each repeat (...) are made of."""

    offset: Array
    """Mean error, m."""
    slope: Array
    """Change of error with position, 1."""
    scatter: Array
    """Standard deviation about the straight line, m."""
    rmse: Array
    """m."""
    mae: Array
    """m."""

    @property
    def ratio(self) -> Array:
        """MAE over RMSE."""
        return self.mae / self.rmse


def parts(errors: ArrayLike, positions: ArrayLike) -> Parts:
    """Split errors (..., P), m, at positions (P,), m, into offset, slope and scatter.

    Raises
    ------
    ValueError
        With fewer than three positions, or all the same.

    Examples
    --------
    >>> z = np.linspace(-1e-3, 1e-3, 5)
    >>> found = parts(3e-5 + 0.01 * z, z)
    >>> f"{found.offset:.1e} {found.slope:.3f}", bool(found.scatter < 1e-15)
    ('3.0e-05 0.010', True)
    """
    error, place = np.asarray(errors, float), np.asarray(positions, float)
    about = place - place.mean()
    if place.size < 3 or not about.any():
        raise ValueError(
            f"Expected at least 3 positions, not all the same, got {place.tolist()}. Sweep more."
        )
    offset = error.mean(axis=-1)
    slope = error @ about / (about @ about)
    left = error - offset[..., None] - slope[..., None] * about
    scatter = np.sqrt((left**2).sum(axis=-1) / (place.size - 2))
    return Parts(offset, slope, scatter, rmse(error), mae(error))


class Interval(NamedTuple):
    """A number over repeats."""

    mean: float
    median: float
    low: float
    """Quantile of single repeats."""
    high: float
    mean_low: float
    """End of the mean's own interval."""
    mean_high: float


def interval(
    values: ArrayLike, *, level: float = 0.95, resamples: int = 2000, seed: int = 0
) -> Interval:
    """Where single repeats (R,) lie, and how well their mean is known.

    The mean's interval is a percentile bootstrap: a few far days make the mean anything but
    Gaussian.

    Raises
    ------
    ValueError
        With fewer than two repeats.

    Examples
    --------
    >>> found = interval(np.arange(101.0))
    >>> found.median, round(found.low, 6), round(found.high, 6)
    (50.0, 2.5, 97.5)
    """
    values = np.asarray(values, float)
    if values.ndim != 1 or values.size < 2:
        raise ValueError(
            f"Expected values of at least 2 repeats, got shape {values.shape}. Repeat more."
        )
    ends = (1 - level) / 2, (1 + level) / 2
    chosen = np.random.default_rng(seed).integers(values.size, size=(resamples, values.size))
    low, high = np.quantile(values, ends)
    mean_low, mean_high = np.quantile(values[chosen].mean(axis=1), ends)
    return Interval(
        float(values.mean()),
        float(np.median(values)),
        float(low),
        float(high),
        float(mean_low),
        float(mean_high),
    )


# --- what RMSE and MAE say together ------------------------------------------------------------


def expected_mae(offset: ArrayLike, scatter: ArrayLike) -> Array:
    r"""Mean size of Gaussian errors of standard deviation sigma about an offset mu.

    .. math:: \sigma\sqrt{2/\pi}\,e^{-\mu^2/2\sigma^2} + \mu\,\mathrm{erf}(\mu/\sqrt2\sigma)

    Examples
    --------
    >>> round(float(expected_mae(0.0, 1.0)), 3), float(expected_mae(2.0, 1e-9))
    (0.798, 2.0)
    """
    mu, sigma = np.asarray(offset, float), np.asarray(scatter, float)
    ratio = mu / sigma
    return sigma * GAUSSIAN_RATIO * np.exp(-(ratio**2) / 2) + mu * erf(ratio / np.sqrt(2))


def offset_and_scatter(rmse: float, mae: float) -> tuple[float, float]:
    """Constant offset and Gaussian scatter, m, that have these RMSE and MAE, m.

    The inverse of `expected_mae` with ``rmse^2 = offset^2 + scatter^2``. A ratio below that of
    Gaussian errors, which few positions may show, gives no offset.

    Raises
    ------
    ValueError
        Unless 0 < mae <= rmse.

    Examples
    --------
    The paper's mirror:

    >>> offset, scatter = offset_and_scatter(33.5e-6, 32.5e-6)
    >>> f"{offset * 1e6:.1f} um, {scatter * 1e6:.1f} um"
    '32.5 um, 8.1 um'
    """
    if not 0 < mae <= rmse:
        raise ValueError(f"Expected 0 < MAE <= RMSE, got {mae:g} and {rmse:g}. Check both.")
    ratio = mae / rmse
    if ratio <= GAUSSIAN_RATIO:
        return 0.0, rmse
    if ratio == 1:
        return rmse, 0.0
    # angle of (offset, scatter): 0 is Gaussian about zero, pi/2 a pure offset

    def missed(angle: float) -> float:
        return float(expected_mae(np.sin(angle), np.cos(angle))) - ratio

    angle = root_scalar(missed, bracket=(0.0, np.pi / 2 - 1e-9)).root
    return float(rmse * np.sin(angle)), float(rmse * np.cos(angle))


def random_phase_errors(frequency: float) -> tuple[float, float]:
    """RMSE and MAE, m, of a phase without signal, uniform, unwrapped to the true wrap of length w.

    ``w / sqrt(12)`` and ``w / 4``: their ratio is 0.87, and no error exceeds w/2.

    Examples
    --------
    >>> [f"{error * 1e3:.2f} mm" for error in random_phase_errors(7.15e9)]
    ['6.05 mm', '5.24 mm']
    """
    length = float(wrap_length(frequency))
    return length / np.sqrt(12), length / 4


# --- the table ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class SweepResult:
    """Repeated sweeps of one instrument before one target.

    Attributes
    ----------
    positions : ndarray, shape (P,)
        Of the stage, m.
    errors : ndarray, shape (repeats, P)
        Estimated minus true range, m.
    bound : ndarray, shape (P,)
        Cramer-Rao bound on one estimate, m.
    """

    positions: Array
    errors: Array
    bound: Array

    @property
    def rmse(self) -> Array:
        """(repeats,), m."""
        return self.parts.rmse

    @property
    def mae(self) -> Array:
        """(repeats,), m."""
        return self.parts.mae

    @property
    def ratio(self) -> Array:
        """MAE over RMSE of each repeat (repeats,)."""
        return self.parts.ratio

    @property
    def parts(self) -> Parts:
        """Offset, slope, scatter, RMSE and MAE of each repeat (repeats,)."""
        return parts(self.errors, self.positions)


def run_sweep(
    ranger: Ranger,
    target: StageTarget,
    *,
    repeats: int,
    seed: int,
    positions: ArrayLike = POSITIONS,
) -> SweepResult:
    """Sweep an instrument over a target, again and again.

    Raises
    ------
    ValueError
        If the instrument's answer has another shape.
    """
    place = np.asarray(positions, float)
    ranges = np.asarray(ranger.sweep(target, place, repeats=repeats, seed=seed), float)
    if ranges.shape != (repeats, place.size):
        raise ValueError(
            f"Expected ranges ({repeats}, {place.size}), got {ranges.shape}. "
            "Return one row a repeat."
        )
    errors = ranges - (target.distance + place)
    return SweepResult(place, errors, np.asarray(ranger.bound(target, place), float))


def table_4(
    rangers: Mapping[str, Ranger],
    targets: Mapping[str, StageTarget],
    *,
    repeats: int,
    seed: int,
    positions: ArrayLike = POSITIONS,
) -> dict[tuple[str, str], SweepResult]:
    """Sweep every instrument over every target, each with noise of its own.

    Returns
    -------
    dict
        `SweepResult` by (instrument, target).
    """
    pairs = [(name, what) for name in rangers for what in targets]
    seeds = np.random.SeedSequence(seed).generate_state(len(pairs))
    return {
        (name, what): run_sweep(
            rangers[name], targets[what], repeats=repeats, seed=int(own), positions=positions
        )
        for (name, what), own in zip(pairs, seeds, strict=True)
    }
