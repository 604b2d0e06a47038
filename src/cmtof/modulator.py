r"""The two-pass EOM modulator: how a resonant phase modulator becomes an intensity modulator.

Light enters a polarising beam splitter, passes HWP, QWP and EOM, travels to a mirror and comes back
through EOM, QWP and HWP to the splitter (Sec. 6.2, Fig. 7). For ideal elements with the QWP at 45
degrees the fraction that leaves by the crossed port is

.. math:: I(V) = \tfrac12\,[1 + \cos(8\theta_h + 2V)],

so the half-wave plate chooses the bias: quadrature at 11.25 degrees (Eq. 15, the single mode), dark
at 22.5 degrees (Eq. 18, the doubled mode). Intensities are fractions of the light that enters the
first element, A^2 = 1. Phases theta are those of the drive, V = eta sin(theta).
"""

from dataclasses import dataclass, replace  # noqa: F401 - for the example
from functools import partial
from math import radians
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import jv

from cmtof import constants, jones
from cmtof.types import Array, Numbers
from cmtof.waveform import Harmonics, harmonics_from_waveform

# Drive amplitude, rad, at which the single mode has the paper's 50 % contrast, sin(2 eta).
ETA = 0.26


@dataclass(frozen=True, kw_only=True)
class TwoPassModulator:
    """Splitter, HWP, QWP, EOM and mirror, passed twice (Sec. 6.2, Eq. 11-18).

    `SINGLE` and `DOUBLED` are the paper's settings; ``dataclasses.replace`` makes others. Angles
    and retardances are in radians; every error is zero (every ratio infinite) by default.

    >>> round(SINGLE.contrast(), 4), round(DOUBLED.contrast(), 4)
    (0.4969, 1.0)
    >>> round(replace(DOUBLED, output="returned").contrast(), 4)  # the bright bias
    0.0342
    """

    half_wave_angle: float  # theta_h
    quarter_wave_angle: float = np.pi / 4  # theta_q
    # drive amplitude: retardance of one pass (the paper's modulation power)
    eta: float = ETA
    frequency: float = constants.FREQUENCY_SINGLE  # of the drive, Hz
    # EOM to mirror, m; None is matched: half a modulation wavelength, both passes in step
    mirror_distance: float | None = None
    # incident: vertical in Eq. 11, horizontal in Sec. 7.1; the same if lossless
    input_axis: Literal["vertical", "horizontal"] = "vertical"
    # port of the splitter: crossed to the input, or back along it (the complement)
    output: Literal["crossed", "returned"] = "crossed"
    half_wave_retardance_error: float = 0.0  # beyond pi
    half_wave_angle_error: float = 0.0
    quarter_wave_retardance_error: float = 0.0  # beyond pi/2
    quarter_wave_angle_error: float = 0.0
    transmitted_extinction: float = np.inf  # of the splitter's transmitted port
    reflected_extinction: float = np.inf
    eom_angle_error: float = 0.0  # crystal's axis off the horizontal
    static_retardance: float = 0.0  # of the undriven crystal in one pass
    mirror_reflectance: float = 1.0  # of intensity

    def __post_init__(self) -> None:
        for name, value, options in (
            ("input_axis", self.input_axis, ("vertical", "horizontal")),
            ("output", self.output, ("crossed", "returned")),
        ):
            if value not in options:
                raise ValueError(
                    f"Expected {name} in {options}, got {value!r}. Choose one."
                )
        if not 0 < self.frequency < np.inf:
            raise ValueError(
                f"Expected a frequency above 0 Hz, got {self.frequency}. Give the drive's in Hz."
            )

    @property
    def pass_delay(self) -> float:
        """Drive phase delta between the passes, 4 pi f d / c in [-pi, pi), rad; 0 if matched."""
        if self.mirror_distance is None:
            return 0.0
        turns = 2 * self.frequency * self.mirror_distance / constants.SPEED_OF_LIGHT
        return float(2 * np.pi * (turns - np.floor(turns + 0.5)))

    @property
    def effective_eta(self) -> float:
        """Drive amplitude, rad, of equal modulation with a matched mirror: eta cos(delta / 2).

        V(t) and V(t + dt) add up to ``2 eta cos(delta/2) sin(theta + delta/2)``.
        """
        return self.eta * float(np.cos(self.pass_delay / 2))

    def elements(
        self, first: ArrayLike, second: ArrayLike | None = None
    ) -> tuple[tuple[str, jones.JonesMatrix], ...]:
        """Names and Jones matrices (..., 2, 2) in the order in which the light meets them.

        ``first`` and ``second`` are the EOM voltages of the two passes as retardances, rad; the
        second is the first by default.
        """
        back = first if second is None else second
        inward = "reflected"
        crossed = "transmitted"
        if self.input_axis == "horizontal":
            inward, crossed = crossed, inward
        h = self.half_wave_angle + self.half_wave_angle_error
        q = self.quarter_wave_angle + self.quarter_wave_angle_error
        off = self.eom_angle_error
        static = self.static_retardance
        half = partial(jones.retarder, np.pi + self.half_wave_retardance_error)
        quarter = partial(
            jones.retarder, np.pi / 2 + self.quarter_wave_retardance_error
        )
        splitter = partial(
            jones.polarising_beam_splitter,
            transmitted_extinction=self.transmitted_extinction,
            reflected_extinction=self.reflected_extinction,
        )
        # behind the mirror the light sees every angle with the opposite sign
        return (
            ("PBS in", splitter(inward)),
            ("HWP", half(h)),
            ("QWP", quarter(q)),
            ("EOM", jones.eom(first, static_retardance=static, angle_error=off)),
            ("mirror", jones.mirror(self.mirror_reflectance)),
            ("EOM back", jones.eom(back, static_retardance=static, angle_error=-off)),
            ("QWP back", quarter(-q)),
            ("HWP back", half(-h)),
            ("PBS out", splitter(crossed if self.output == "crossed" else inward)),
        )

    def states(
        self, first: ArrayLike, second: ArrayLike | None = None
    ) -> dict[str, jones.JonesVector]:
        """Jones vector (..., 2) behind each element, by the element's name; "PBS out" is E_3."""
        angle = np.pi / 2 if self.input_axis == "vertical" else 0.0
        field = jones.linear_polarisation(angle)
        found = {}
        for name, element in self.elements(first, second):
            field = jones.apply(element, field)
            found[name] = field
        return found

    def transmission(self, first: ArrayLike, second: ArrayLike | None = None) -> Array:
        """Transmitted fraction I(V) of the light for EOM voltages, rad (Eq. 15 and 18)."""
        return jones.intensity(self.states(first, second)["PBS out"])

    def waveform(self, phase: ArrayLike) -> Array:
        """Transmitted fraction at the drive phases, rad; same shape (Eq. 16 and 19, exact).

        The first pass sees ``eta sin(theta)``, the second ``eta sin(theta + delta)``.
        """
        second = np.add(phase, self.pass_delay)
        return self.transmission(self.eta * np.sin(phase), self.eta * np.sin(second))

    def harmonics(self, count: int) -> Harmonics:
        """Fourier coefficients W_0 ... W_count (count + 1,) of the waveform over the drive phase.

        Exact to rounding: harmonics fall like J_k(2 eta) beyond k = 2 eta, and the sampling lies
        far above. The doubled mode fills the even ones: ``[::2]`` are those of twice the drive.
        """
        samples = 4 * (count + int(np.ceil(4 * abs(self.eta))) + 16)
        return harmonics_from_waveform(self._waveform_period(samples), count)

    def _waveform_period(self, samples: int) -> Array:
        return self.waveform(2 * np.pi * np.arange(samples) / samples)

    def contrast(self) -> float:
        """Peak-to-peak contrast (max - min)/(max + min); sin(2 eta) in the ideal single mode."""
        w = self._waveform_period(4096)  # holds the crests of the ideal modes exactly
        return float(np.ptp(w) / (w.max() + w.min()))

    def modulation_depth(self) -> float:
        """Amplitude of the drive's first harmonic over the mean, 2 |W_1| / W_0."""
        mean, first = self.harmonics(1)
        return float(2 * abs(first) / mean.real)

    def throughput(self) -> float:
        """Mean transmitted fraction W_0."""
        return float(self.harmonics(0)[0].real)


# The mode at the drive's frequency: theta_h = 11.25 degrees, 7.15 GHz (Eq. 14-16).
SINGLE = TwoPassModulator(half_wave_angle=radians(constants.HALF_WAVE_PLATE_SINGLE))

# The mode at twice the drive's frequency: theta_h = 22.5 degrees, dark bias (Eq. 17-19).
DOUBLED = TwoPassModulator(
    half_wave_angle=radians(constants.HALF_WAVE_PLATE_DOUBLED),
    frequency=constants.FREQUENCY_DOUBLED / 2,
)


# --- closed forms ------------------------------------------------------------------------------


def single_mode_harmonics(eta: ArrayLike, count: int) -> Harmonics:
    """Fourier coefficients (..., count + 1) of the ideal single mode, by Jacobi-Anger expansion.

    ``I = 1/2 - sum_{k odd} J_k(2 eta) sin(k theta)``, hence W_0 = 1/2, W_k = i J_k(2 eta)/2 for odd
    k and 0 for even. ``eta`` (...) is the drive amplitude of one pass, rad.
    """
    k, bessel = _bessel(eta, count)
    return np.where(k % 2, 0.5j * bessel, 0) + 0.5 * (k == 0)


def doubled_mode_harmonics(eta: ArrayLike, count: int) -> Harmonics:
    """Fourier coefficients (..., count + 1) of the ideal doubled mode, by harmonics of the drive.

    ``I = (1 - J_0(2 eta))/2 - sum_{k even >= 2} J_k(2 eta) cos(k theta)``, hence W_0 = (1 - J_0)/2,
    W_k = -J_k/2 for even k and 0 for odd; ``[..., ::2]`` are the harmonics of twice the drive.
    """
    k, bessel = _bessel(eta, count)
    return np.where(k % 2, 0j, -0.5 * bessel) + 0.5 * (k == 0)


def _bessel(eta: ArrayLike, count: int) -> tuple[Numbers, Array]:
    """Orders k up to ``count``, and J_k(2 eta) (..., count + 1)."""
    k = np.arange(count + 1)
    return k, jv(k, 2 * np.expand_dims(eta, -1))
