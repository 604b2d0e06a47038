r"""Closed forms of what bends the phase: errors that repeat with the phase of the correlation.

With :math:`x_k = \phi + \psi_k` and a correlation :math:`C_k = d + a\cos x_k`, a small change
:math:`a\,\epsilon_k` of the K readings turns the decoded phase by

.. math:: \delta\phi = -\frac2K\sum_k\epsilon_k\sin x_k .

All but the back-reflection, which is exact, follow from it. Phases are those of the correlation,
rad, everything that shifts it included; the sign of an error is that of decoded minus true.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import jv, jvp

from cmtof.correlation import TAU

Array = NDArray[np.float64]

ORDER: dict[str, int] = {"single": 1, "doubled": 2}
"""Harmonic of the drive that the correlation is made of."""


def _checked(mode: str) -> str:
    if mode not in ORDER:
        raise ValueError(f"Expected mode single or doubled, got {mode!r}. Choose one.")
    return mode


def uniform_steps(steps: int) -> Array:
    """Reference phases ``2 pi k / K`` (K,), rad; at least 3."""
    if steps < 3:
        raise ValueError(f"Expected at least 3 steps of the phase, got {steps}. Use 4 or 16.")
    return TAU * np.arange(steps) / steps


def phase_error(change: ArrayLike, phase: ArrayLike, psi: ArrayLike) -> Array:
    """Phase error ``-(2/K) sum change_k sin(phase + psi_k)``, rad, to first order.

    Parameters
    ----------
    change : array_like, shape (..., K)
        Change of the readings over the amplitude of the correlation.
    phase : array_like, shape (...)
        rad.
    psi : array_like, shape (K,)
        Uniform reference phases, rad.

    Examples
    --------
    A correlation that is late by 1 mrad, ``-a sin(x) 1e-3``:

    >>> psi = uniform_steps(16)
    >>> round(float(phase_error(-1e-3 * np.sin(0.7 + psi), 0.7, psi)), 6)
    0.001
    """
    angle = np.asarray(phase, float)[..., None] + np.asarray(psi, float)
    return -2 * np.mean(np.asarray(change) * np.sin(angle), axis=-1)


def back_reflection(phase: ArrayLike, stray: ArrayLike, ratio: ArrayLike) -> Array:
    r"""Error of a second, constant phasor: ``arg(1 + r exp(i (stray - phase)))``, exact.

    Its peak is ``arcsin r``; for small r it is ``r sin(stray - phase)``.

    Parameters
    ----------
    phase, stray : array_like
        Phase of the target and of the back-reflection, rad.
    ratio : array_like
        Power of the back-reflection over the target's, 0 to 1.
    """
    return np.angle(1 + np.asarray(ratio) * np.exp(1j * (np.asarray(stray) - np.asarray(phase))))


def imbalance(phase: ArrayLike, amplitude: float, *, mode: str = "single") -> Array:
    """Error of a driver that makes ``p + e sin 2p`` of each phase p it is told.

    The detection's driver steps ``p = -psi`` (single) or ``-psi/2`` (doubled). Half of the
    former's error follows the phase, ``(e/2) sin 2 phi``; of the latter's, with K >= 5, nothing.

    Parameters
    ----------
    phase : array_like
        rad.
    amplitude : float
        e, rad.
    mode : {"single", "doubled"}
    """
    share = 0.5 if ORDER[_checked(mode)] == 1 else 0.0
    return share * amplitude * np.sin(2 * np.asarray(phase))


def aliasing(phase: ArrayLike, eta: float, *, steps: int, mode: str = "single") -> Array:
    """Error of the harmonic K - 1 of the correlation, which K steps cannot tell from the first.

    ``-(J_3 / J_1)^2 sin 4 phi`` with four steps in the single mode, ``-(J_6 / J_2)^2 sin 4 phi``
    in the doubled one; the harmonic K + 1 is left out.

    Parameters
    ----------
    phase : array_like
        rad.
    eta : float
        Amplitude of the drive, rad.
    steps : int
        K.
    mode : {"single", "doubled"}
    """
    order = ORDER[_checked(mode)] * (uniform_steps(steps).size - 1)
    # a single mode has odd harmonics only
    there = mode == "doubled" or order % 2 == 1
    ratio = (jv(order, 2 * eta) / jv(ORDER[_checked(mode)], 2 * eta)) ** 2 if there else 0.0
    return -ratio * np.sin(steps * np.asarray(phase))


def leakage(
    phase: ArrayLike, lag: ArrayLike, leak: float, eta: float, *, steps: int, mode: str = "single"
) -> Array:
    r"""Error of drives that leak into each other, to first order in the leak l.

    With :math:`u = \varphi_d - \varphi_e` both drives grow by :math:`l\cos u`, and the phase
    between them by :math:`-2l\sin u`. In the single mode u turns with psi and the error averages
    out; in the doubled one it turns half as fast, and does not.

    Parameters
    ----------
    phase : array_like, shape (...)
        rad.
    lag : array_like, shape (...)
        u at psi = 0, rad: cables and the phase of the leak.
    leak, eta : float
        Amplitude of the leaking drive over the other's, and the drive's amplitude, rad.
    steps : int
    mode : {"single", "doubled"}
    """
    psi, order = uniform_steps(steps), ORDER[_checked(mode)]
    x = np.asarray(phase, float)[..., None] + psi
    u = np.asarray(lag, float)[..., None] - psi / order
    drive = 2 * eta
    growth = drive * jvp(order, drive) / jv(order, drive)
    if mode == "doubled":
        mean, mean_growth = 1 - jv(0, drive), drive * jv(1, drive) / (1 - jv(0, drive))
    else:
        mean, mean_growth = 1.0, 0.0
    contrast = 2 * jv(order, drive) ** 2 / mean**2
    change = 2 * leak * np.cos(u) * (mean_growth / contrast + growth * np.cos(x))
    change -= 2 * order * leak * np.sin(u) * np.sin(x)
    return phase_error(change, phase, psi)


def power_ramp(phase: ArrayLike, ramp: ArrayLike, contrast: float, *, steps: int) -> Array:
    """Error of light that changes evenly while the K steps are taken.

    Parameters
    ----------
    phase : array_like, shape (...)
        rad.
    ramp : array_like, shape (...)
        Relative change of the power from first to last moment.
    contrast : float
        Amplitude over mean of the correlation.
    steps : int
    """
    psi = uniform_steps(steps)
    x = np.asarray(phase, float)[..., None] + psi
    place = (np.arange(steps) + 0.5) / steps - 0.5
    change = np.asarray(ramp, float)[..., None] * place * (1 / contrast + np.cos(x))
    return phase_error(change, phase, psi)


def code_noise(code: float, *, steps: int, mode: str = "single") -> tuple[float, float]:
    """Spread of the errors of K random phase codes: (constant, cyclic) part, rad.

    ``m s / sqrt(K)`` stays the same at every phase and goes into the zero; ``m s / sqrt(2 K)``
    goes round twice a turn.

    Parameters
    ----------
    code : float
        s, error of one code, rms, rad.
    steps : int
    mode : {"single", "doubled"}
    """
    spread = ORDER[_checked(mode)] * code / np.sqrt(steps)
    return float(spread), float(spread / np.sqrt(2))


def residual_fundamental(phase: ArrayLike, ratio: float, *, steps: int) -> Array:
    r"""Error of the drive's own frequency left over in the doubled mode: plates out of place.

    Its correlation is ``r a cos((phi + psi) / 2)``, half a turn of which does not average out.
    With the half-wave plates off by :math:`\delta`, ``r = (J_1/J_2)^2 tan^2 8 delta`` at 2 eta.

    Parameters
    ----------
    phase : array_like, shape (...)
        rad; not wrapped, for the error repeats after two wraps.
    ratio : float
        r, ``|W_1|^2 / |W_2|^2`` of the modules' harmonics.
    steps : int
    """
    psi = uniform_steps(steps)
    half = (np.asarray(phase, float)[..., None] + psi) / 2
    return phase_error(ratio * np.cos(half), phase, psi)
