"""From beat to fringe: which measured phase tells the whole number of the next finer one (Sec. 9).

Each rung of the ladder is a phase that turns once in a wrap. The range of the rung above, good to
less than half a wrap, picks the wrap; then the finer phase takes over.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import erf, erfinv

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU, wrapped

Array = NDArray[np.float64]

# --- one step of the ladder ----------------------------------------------------------------------


def order_odds(spread: ArrayLike, wrap: ArrayLike) -> Array:
    r"""Odds that a range with Gaussian error picks the right wrap.

    Right where the error stays within half a wrap, :math:`P(|\epsilon| < \ell/2) =
    \mathrm{erf}(\ell / 2\sqrt2\,\sigma)`; for a fringe, :math:`\ell = \lambda/2`, that is
    :math:`\mathrm{erf}(\lambda / 4\sqrt2\,\sigma)`.

    Parameters
    ----------
    spread : array_like, shape (...)
        Standard deviation of the coarse less the fine range, m, above 0.
    wrap : array_like, shape (...)
        Wrap of the fine phase, m.

    Examples
    --------
    >>> print(f"{order_odds(68e-9, 266e-9):.3f}")
    0.950
    """
    return erf(np.asarray(wrap, float) / (2 * np.sqrt(2) * np.asarray(spread, float)))


def required_spread(odds: ArrayLike, wrap: ArrayLike) -> Array:
    """Largest standard deviation, m, with which `order_odds` are at least ``odds`` (0 to 1).

    Examples
    --------
    >>> print(f"{required_spread(0.95, 266e-9) * 1e9:.1f} nm")
    67.9 nm
    """
    return np.asarray(wrap, float) / (2 * np.sqrt(2) * erfinv(np.asarray(odds, float)))


def averages_needed(noise: float, floor: float, *, odds: float, wrap: float) -> float:
    """Averages after which noise over root N and a floor that stays give the odds; inf if never.

    Parameters
    ----------
    noise, floor : float
        Standard deviation of one range by noise, and of what no average removes, m.
    odds, wrap : float
        As in `required_spread`.

    Examples
    --------
    >>> averages_needed(6.8e-6, 0.0, odds=0.95, wrap=266e-9)
    10042.0
    >>> averages_needed(6.8e-6, 1e-6, odds=0.95, wrap=266e-9)
    inf
    """
    room = float(required_spread(odds, wrap)) ** 2 - floor**2
    return float(np.ceil(noise**2 / room)) if room > 0 else np.inf


# --- two colours ---------------------------------------------------------------------------------


def synthetic_wavelength(first: ArrayLike, second: ArrayLike) -> Array:
    """Wavelength of the beat of two colours ``l1 l2 / |l1 - l2|``, m; about ``l^2 / dl``.

    Examples
    --------
    >>> print(f"{synthetic_wavelength(532e-9, 531e-9) * 1e6:.0f} um")
    282 um
    """
    a, b = np.asarray(first, float), np.asarray(second, float)
    return a * b / np.abs(a - b)


def second_colour(first: ArrayLike, synthetic: ArrayLike) -> Array:
    """Colour, m, shorter than the first, whose beat with it has a wavelength, m."""
    return 1 / (1 / np.asarray(first, float) + 1 / np.asarray(synthetic, float))


def plan_colours(
    wavelength: float, coarse: float, *, phase_noise: float, odds: float
) -> list[float]:
    r"""Fewest synthetic wavelengths, m, longest first, that lead from a coarse range to the fringe.

    Each is the shortest whose order the rung above tells with the odds. Its own range has the error
    :math:`\sqrt2\,\sigma_\phi\Lambda/4\pi`, so with :math:`q = \mathrm{erf}^{-1}(P)`

    .. math:: \Lambda = \frac{4\sqrt2\,q\,\sigma}{\sqrt{1 - (2q\,\sigma_\phi/\pi)^2}}

    Parameters
    ----------
    wavelength : float
        Of the first colour, m.
    coarse : float
        Standard deviation of the range to start from, m.
    phase_noise : float
        Of each colour's fringe phase, rad.
    odds : float
        Of each step, 0 to 1.

    Raises
    ------
    ValueError
        If the phases are too noisy for any ladder.

    Examples
    --------
    >>> [f"{s * 1e6:.1f} um" for s in plan_colours(532e-9, 33e-6, phase_noise=0.03, odds=0.999)]
    ['434.8 um', '19.3 um', '0.9 um']
    """
    q = float(erfinv(odds))
    rest = 1 - (2 * q * phase_noise / np.pi) ** 2
    own = np.sqrt(2) * phase_noise / (2 * TAU)  # error of a synthetic rung over its wavelength
    shrink = 4 * np.sqrt(2) * q * own / np.sqrt(rest) if rest > 0 else np.inf
    if not shrink < 1:
        raise ValueError(
            f"Expected phases good enough that a rung narrows the range, got {phase_noise:g} rad "
            f"for odds of {odds:g}. Average the phases or ask for lower odds."
        )
    found: list[float] = []
    fine = phase_noise * wavelength / (2 * TAU)
    while order_odds(np.hypot(coarse, fine), wavelength / 2) < odds:
        found.append(4 * np.sqrt(2) * q * coarse / np.sqrt(rest))
        coarse = own * found[-1]
    return found


# --- the whole ladder ----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Ladder:
    """Rungs made of measured phases, coarsest first; the first one must not wrap in the range used.

    Attributes
    ----------
    names : tuple of str
        Of the R rungs.
    wavenumbers : ndarray, shape (M,)
        Change of each measured phase with the range, rad/m.
    weights : ndarray, shape (R, M)
        Whole numbers: a rung's phase is the sum of measured ones with these weights.
    """

    names: tuple[str, ...]
    wavenumbers: Array
    weights: Array

    @classmethod
    def of(
        cls,
        frequencies: tuple[float, float],
        wavelengths: Sequence[float] = (),
        *,
        group: float = 1.0,
        index: float = 1.0,
    ) -> "Ladder":
        """Beat, both modulation frequencies, synthetic wavelengths, and the first colour's fringe.

        Parameters
        ----------
        frequencies : (float, float)
            Lower and higher modulation frequency, Hz.
        wavelengths : sequence of float
            Colours in vacuum, m; each but the first beats with the first, in the order given.
        group, index : float
            Index of air for the modulation, and for the colours (their dispersion left out).

        Examples
        --------
        >>> ladder = Ladder.of((7.15e9, 14.32e9), [532e-9, 531.2e-9])
        >>> [f"{name}: {wrap:.3g} m" for name, wrap in zip(ladder.names, ladder.wraps)][:3]
        ['beat: 7.49 m', '7.15 GHz: 0.021 m', '14.32 GHz: 0.0105 m']
        """
        low, high = frequencies
        count = 2 + len(wavelengths)
        rows, names = np.zeros((1 + count, count)), ["beat"]
        rows[0, :2] = -round(high / low), 1
        names += [f"{frequency / 1e9:g} GHz" for frequency in frequencies]
        rows[1, 0] = rows[2, 1] = 1
        for k, colour in enumerate(wavelengths[1:], start=1):
            rows[2 + k, [2, 2 + k]] = (-1, 1) if colour < wavelengths[0] else (1, -1)
            names.append(f"{synthetic_wavelength(wavelengths[0], colour) * 1e6:.3g} µm")
        if len(wavelengths) > 0:
            rows[count, 2] = 1
            names.append(f"{wavelengths[0] * 1e9:g} nm")
        turns = [2 * f * group / SPEED_OF_LIGHT for f in frequencies]
        turns += [2 * index / colour for colour in wavelengths]
        rows = rows[: len(names)]
        return cls(tuple(names), TAU * np.array(turns), rows)

    @property
    def wraps(self) -> Array:
        """Range (R,) in which each rung turns once, m."""
        return TAU / (self.weights @ self.wavenumbers)

    def gains(self) -> Array:
        """Change (R, M) of each rung's range with an error of a measured phase, m/rad."""
        return self.weights * (self.wraps / TAU)[:, None]

    def spreads(self, noise: ArrayLike) -> Array:
        """Standard deviation (R,), m, of each rung's range for phase noise (M,), rad."""
        return np.sqrt(self.gains() ** 2 @ np.asarray(noise, float) ** 2)

    def odds(self, noise: ArrayLike) -> Array:
        """Odds (R - 1,) that each rung tells the wrap of the next, phase noise (M,), rad.

        Two rungs may share a measured phase: what counts is the error of their difference.
        """
        apart = np.diff(self.gains(), axis=0)
        return order_odds(np.sqrt(apart**2 @ np.asarray(noise, float) ** 2), self.wraps[1:])

    def phases(self, ranges: ArrayLike) -> Array:
        """Measured phases (..., M) of ranges (...), m, without noise, wrapped, rad."""
        turned = np.asarray(ranges, float)[..., None] * self.wavenumbers
        return np.asarray(wrapped(turned), float)

    def resolve(self, phases: ArrayLike) -> Array:
        """Ranges (..., R) that the rungs give one after the other, m, for phases (..., M), rad."""
        rung = wrapped(np.asarray(phases, float) @ self.weights.T)
        found = [rung[..., 0] * self.wraps[0] / TAU]
        for k in range(1, len(self.names)):
            turns = rung[..., k] / TAU
            found.append(self.wraps[k] * (turns + np.rint(found[-1] / self.wraps[k] - turns)))
        return np.stack(found, axis=-1)
