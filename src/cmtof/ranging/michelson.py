"""Michelson interferometer of Sec. 8.2: its settings, the light of its arms, fringe contrast."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.instrument.electronics import SLOPE, Conversion, chain
from cmtof.instrument.optics import group_index, speckle_cells, spot_radius
from cmtof.instrument.parsing import check_fields, number
from cmtof.instrument.settings import Air, Optics, TwinSettings
from cmtof.instrument.world import SAMPLE_RATE
from cmtof.ranging.target import StageTarget, collected_power

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Michelson:
    """What the interferometer adds to the simulated instrument (Sec. 7.1: beam block out).

    The drives of both modulators are off: the emission module then passes the half of the light
    that it passes on average in the single mode. The detector is an APD440A with its filters, as
    in the correlation mode, in front of the second module.

    Examples
    --------
    >>> Michelson(steps=2)
    Traceback (most recent call last):
        ...
    ValueError: Expected interferometer.steps from 4 to 1000, got 2. Keep to SI units.
    """

    linewidth: float = number(30e9, 0, 1e13)
    """Full width at half maximum of the laser's line, Hz: several modes (gem 532: 30 GHz, a
    coherence length of 1 cm; known)."""
    wavelength_error: float = number(2e-4, 0, 0.1)
    """Relative error of the wavelength that the fringes are multiplied with, rms over days
    (assumed: 532.0 nm written on a laser whose line may lie at 532.1 or 532.2 nm)."""
    intensity_noise: float = number(1e-3, 0, 1)
    """Relative noise of the laser's power from step to step, rms (assumed)."""
    arm_power: float = number(1.4e-9, 1e-15, 1)
    """Most light of either arm on the detector, W, grey filters see to it (assumed: two such arms
    in full interference, 5.6 nW, stay below the 5.9 nW at which the detector saturates)."""
    reference_radius: float = number(0.25e-3, 1e-5, 0.05)
    """1/e^2 radius of the reference beam, m (Sec. 7.1: 0.5 mm of diameter)."""
    imbalance: float = number(1e-3, -10, 10)
    """Length of the reference arm less the target's distance, m (assumed: set with a ruler, then
    by looking for the highest contrast)."""
    steps: int = number(8, 4, 1000)  # type: ignore[assignment]
    """K: steps of the reference mirror over half a wavelength, one phase reading (assumed)."""
    samples: int = number(5, 1, 1000)  # type: ignore[assignment]
    """Samples at 24 kS/s in a step (assumed; eight steps take 1.7 ms)."""
    sweep_error: float = number(0.01, 0, 0.5)
    """Relative error of the mirror's travel, rms over days (assumed: a piezo without encoder)."""
    speed: float = number(3e-5, 1e-9, 1)
    """Speed of the stage between positions, m/s (assumed: 50 nm from reading to reading; an
    MTS50/M-Z8 reaches 2.4 mm/s, known)."""
    stage_error: float = number(5e-8, 0, 1e-3)
    """Error of the stage at each position, rms, m (Sec. 8.2: 0.05 um)."""
    speckle_length: float = number(0.016, 1e-9, 1e3)
    """Travel over which the field of a diffuse plate loses e^-1 of its correlation, m (assumed:
    `speckle_length` with a stage that turns the plate by 20 urad per mm)."""
    table_rms: float = number(20e-9, 0, 1e-3)
    """Vibration of target against interferometer along the beam, rms, m: a resonance of the
    breadboard (assumed; a floor of a laboratory, 50 um/s, moves by 265 nm at 30 Hz as a whole)."""
    table_frequency: float = number(30.0, 0.01, 1e4)
    """Hz (assumed)."""
    mount_rms: float = number(5e-9, 0, 1e-3)
    """The same of a resonance of mounts and posts, rms, m (assumed)."""
    mount_frequency: float = number(120.0, 0.01, 1e4)
    """Hz (assumed)."""
    quality: float = number(20.0, 0.5, 1e6)
    """Quality factor of both resonances (assumed)."""
    temperature_drift: float = number(0.05, 0, 50)
    """Slow change of temperature, rms, K (assumed)."""
    drift_time: float = number(600.0, 1e-3, 1e7)
    """Time after which the temperature has forgotten where it was, s (assumed)."""
    expansion: float = number(11e-6, 0, 1e-3)
    """Thermal expansion of the breadboard under the scene arm, 1/K (steel, known; aluminium twice
    that). The reference arm is taken to stand on its own short base."""

    def __post_init__(self) -> None:
        check_fields(type(self), vars(self), "interferometer")

    @classmethod
    def steady(cls, **changes: Any) -> "Michelson":
        """Build one without errors, vibration and drift: light's own noise is left."""
        silent = ("wavelength_error", "sweep_error", "stage_error", "table_rms", "mount_rms")
        return replace(cls(**dict.fromkeys((*silent, "temperature_drift"), 0.0)), **changes)

    @property
    def step_time(self) -> float:
        """Time of a step of the reference mirror, s."""
        return self.samples / SAMPLE_RATE

    @property
    def reading_time(self) -> float:
        """Time of a phase reading, and from one to the next, s."""
        return self.steps * self.step_time

    @property
    def stride(self) -> float:
        """Travel of the stage from one reading to the next, m."""
        return self.speed * self.reading_time

    @property
    def psi(self) -> Array:
        """Nominal phases (K,) of the steps, rad."""
        return 2 * np.pi * np.arange(self.steps) / self.steps


class Fringes(NamedTuple):
    """Interferogram ``offset + amplitude cos(phi + psi)`` behind the detector.

    The noise of a step is taken at the mean of the fringe, the same at all steps.
    """

    amplitude: Array
    """V; for a diffuse plate the root of the mean square over its speckle."""
    offset: Array
    """V."""
    variance: Array
    """Of the noise of one step, V^2."""


# --- light ---------------------------------------------------------------------------------------


def phase_index(air: Air, wavelength: float) -> float:
    """Phase index n of dry air from its group index, of which it is the mean over wave numbers.

    With the wave number s, ``n_g = d(n s)/ds``, hence ``n(s) = (1/s) int_0^s n_g ds'``.

    Examples
    --------
    >>> f"{phase_index(Air(temperature=288.15), 532e-9) - 1:.4e}"
    '2.7821e-04'
    """
    nodes, weights = np.polynomial.legendre.leggauss(12)
    shares = (nodes + 1) / 2
    return float(0.5 * weights @ [group_index(air, wavelength / share) for share in shares])


def coherence(michelson: Michelson, distance: ArrayLike, reference: float) -> Array:
    """Degree of coherence |gamma| of arms of two lengths, m: a Gaussian line.

    ``exp(-(pi dnu tau)^2 / (4 ln 2))`` with the delay ``tau = 2 (z - z_r) / c``.
    """
    delay = 2 * (np.asarray(distance, float) - reference) / SPEED_OF_LIGHT
    return np.exp(-((np.pi * michelson.linewidth * delay) ** 2) / (4 * np.log(2)))


def matched_share(
    optics: Optics, michelson: Michelson, target: StageTarget, wavelength: float
) -> float:
    """Share of the collected light that is in the mode of the reference beam; only it interferes.

    The reference is a collimated Gaussian mode of radius w_r. Rough plate: the field in the
    aperture A is speckle with the coherence ``exp(-(pi w d / lambda z)^2 / 2)`` over a distance d,
    w the spot's radius, so the mode takes ``2 pi / (A ((pi w / lambda z)^2 + 1 / w_r^2))`` on
    average. Mirror: overlap with the beam that comes back, W wide and curved with R.

    Examples
    --------
    A rough plate at 60 cm sends a hundred and ten modes into the aperture:

    >>> share = matched_share(Optics(), Michelson(), StageTarget(), 532e-9)
    >>> round(1 / share)
    110
    """
    w_r, z = michelson.reference_radius, target.distance
    area = np.pi * optics.aperture**2 / 4
    if target.material == "diffuse":
        # (pi w / lambda z)^2 of the spot, from the cells that it makes in the aperture
        inverse = np.pi * (float(speckle_cells(optics, wavelength, z)) - 1) / area
        return min(1.0, 2 * np.pi / (area * (inverse + 1 / w_r**2)))
    width = float(spot_radius(optics, 2 * z))
    curvature = optics.divergence / width  # 1/R of a beam that spreads from a waist before
    real, turned = 1 / w_r**2 + 1 / width**2, np.pi * curvature / wavelength
    return float(4 / (w_r * width) ** 2 / (real**2 + turned**2))


def fringes(
    settings: TwinSettings, michelson: Michelson, target: StageTarget, ranges: ArrayLike
) -> Fringes:
    """Amplitude, offset and noise of the interferogram at ranges (...), m.

    ``P = P_r + P_s + 2 |gamma| sqrt(P_r m P_s) cos(phi + psi)`` with the matched share m, times
    volts per watt. Without `TwinSettings.noise` the variance is 0.

    Examples
    --------
    >>> plate = fringes(TwinSettings(), Michelson(), StageTarget(), 0.6)
    >>> print(f"{plate.amplitude:.2f} V on {plate.offset:.2f} V")
    0.16 V on 1.95 V
    """
    detector, wavelength = settings.detector, settings.laser.wavelength
    distance = np.asarray(ranges, float)
    scene = np.minimum(collected_power(settings, target, distance), michelson.arm_power)
    reference = michelson.arm_power
    matched = scene * matched_share(settings.optics, michelson, target, wavelength)
    gamma = coherence(michelson, distance, target.distance + michelson.imbalance)
    conversion = Conversion(detector, wavelength)
    offset = conversion.volts_per_watt * (reference + scene)
    amplitude = conversion.volts_per_watt * 2 * gamma * np.sqrt(reference * matched)
    # a mean over a step averages white noise of the density over 1 / (2 T); the filters pass more
    bandwidth = min(1 / (2 * michelson.step_time), chain(detector, 1 / SAMPLE_RATE).noise_bandwidth)
    variance = conversion.density(offset) * bandwidth
    variance = variance + (detector.converter_noise * SLOPE) ** 2 / michelson.samples
    variance = variance + (michelson.intensity_noise * offset) ** 2
    return Fringes(amplitude, offset, variance * float(settings.noise))


def speckle_length(
    optics: Optics, michelson: Michelson, wavelength: float, distance: float, *, turn: float
) -> float:
    """Travel after which speckle has lost e^-1 of its correlation, m, if the plate turns with it.

    A plate that turns by ``turn`` rad per m of travel moves its speckle by ``2 z turn`` past the
    reference mode, which forgets it after ``sqrt(2) sqrt((lambda z / pi w)^2 + w_r^2)``: cell and
    mode of `matched_share`, convolved. The travel itself changes it more slowly, for speckle is
    ``lambda (z / w)^2``, decimetres, long.

    Examples
    --------
    >>> length = speckle_length(Optics(), Michelson(), 532e-9, 0.6, turn=0.02)
    >>> f"{length * 1e3:.0f} mm"
    '16 mm'
    """
    width = float(spot_radius(optics, distance))
    cell = wavelength * distance / (np.pi * width)
    return float(np.sqrt(2 * (cell**2 + michelson.reference_radius**2)) / (2 * distance * turn))
