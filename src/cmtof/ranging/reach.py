r"""How far the all-optical instrument reaches: its precision against everything, in closed form.

For a target across the beam, with L the light that open modulators would let onto the detector,
:math:`\bar w` and :math:`w_1` mean and fundamental of the product of their waveforms, u the room's
light and S volts per watt,

.. math:: U(\psi) = S\,(L\bar w + u) + S L w_1\cos(\phi+\psi), \qquad
          \sigma_\phi^2 = \frac{v}{(S L w_1)^2}, \qquad
          v = d\,(S(L\bar w + u))\,B + \frac{2}{K}\frac{\sigma_{adc}^2}{N}

where d is the noise density of detector and light at the mean output, B the bandwidth of the
fundamental of K phase means of N samples each behind the filters. Uniform phases see the density's
mean only (K > 3). The powers are the twin's; `cmtof.ranging.optical` simulates what this foretells.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import TAU, centred, depth_from_phase
from cmtof.hardware.reduction import nominal_psi
from cmtof.instrument import optics as free_space
from cmtof.instrument.electronics import Conversion, chain, slope
from cmtof.instrument.optics import emission_mean, sent_power
from cmtof.instrument.parsing import number
from cmtof.instrument.settings import Detector, TwinSettings
from cmtof.instrument.targets import Hits
from cmtof.instrument.world import World
from cmtof.ranging.burst_noise import mean_weights, phase_covariance
from cmtof.ranging.optical import OpticalRanger, without_errors
from cmtof.ranging.target import StageTarget

Array = NDArray[np.float64]


class Levels(NamedTuple):
    """What a detector sees of a target, arrays of one shape, and what follows from it."""

    light: Array
    """Mean of the laser's light on the detector, W."""
    room: float
    """Room light on it, W."""
    amplitude: Array
    """Of the correlation's cosine, W."""
    dimming: Array
    """Transmission of the grey filter that keeps the crest below the detector's end; 1 for none,
    less than 1 where the bare instrument is too bright."""
    phase_noise: Array
    """Linearised standard deviation of the phase of one burst, behind that filter, rad."""
    saturated: NDArray[np.bool_]
    """Whether the crest would exceed the detector's range without the filter."""


@dataclass(frozen=True)
class TunedRanger(OpticalRanger):
    """All-optical instrument with crystals cut for another frequency (`tuned`).

    Parameters
    ----------
    modulation : float
        Frequency of the modulation, Hz, whatever the mode.
    """

    modulation: float = number(FREQUENCY_SINGLE, 1e6, 1e12)

    @property
    def frequency(self) -> float:
        """Modulation frequency, Hz."""
        return self.modulation


def tuned(ranger: OpticalRanger, frequency: float) -> TunedRanger:
    """Return the instrument at another modulation frequency, Hz, all else equal.

    Equal are light, eta and with it the Bessel amplitudes, detuning, errors as phases, and time.
    The mirror stands at the crystal, for half a wavelength would not fit at low frequencies.
    """
    order = 1 if ranger.mode == "single" else 2
    drive = replace(
        ranger.settings.drive, resonance=frequency / order + ranger.settings.drive.detuning
    )
    modules = {
        name: replace(getattr(ranger.settings, name), mirror_distance=0.0)
        for name in ("emission", "detection")
    }
    kept = {name: getattr(ranger, name) for name in OpticalRanger.__dataclass_fields__}
    kept["settings"] = replace(ranger.settings, drive=drive, **modules)
    return TunedRanger(**{k: v for k, v in kept.items() if k != "_"}, modulation=frequency)


def levels(
    ranger: OpticalRanger,
    ranges: ArrayLike,
    reflectance: ArrayLike = 0.5,
    *,
    material: str = "diffuse",
) -> Levels:
    """Light and phase noise for targets across the beam, without errors, speckle's mean.

    Parameters
    ----------
    ranger : OpticalRanger
    ranges, reflectance : array_like, shape (...)
        m and 0 to 1.
    material : str
        As of the twin's targets.

    Raises
    ------
    ValueError
        For ranges that are not positive.

    Examples
    --------
    >>> noise = levels(OpticalRanger(), [0.6, 1.2]).phase_noise
    >>> bool(noise[1] > 2 * noise[0])
    True
    """
    z, rho = np.broadcast_arrays(np.asarray(ranges, float), np.asarray(reflectance, float))
    if not (z > 0).all():
        raise ValueError(
            f"Expected ranges above 0 m, got {float(np.min(z)):g}. Give them in metres."
        )
    optics = ranger.settings.optics
    share = free_space.returned_fraction(optics, material, Hits(z, np.ones(z.shape), rho))
    sent = sent_power(ranger.settings, ranger.mode)
    return levels_of_light(ranger, sent * share * free_space.inward(optics))


def levels_of_light(ranger: OpticalRanger, collected: ArrayLike) -> Levels:
    """Light and phase noise of light (...), W, as `cmtof.ranging.target.collected_power` gives it.

    That is the mean behind the receiving optics, before the second modulator.
    """
    settings = without_errors(ranger.settings)
    opened = np.asarray(collected, float) / emission_mean(settings, ranger.mode)
    mean, fundamental, detection = _products(ranger, settings)
    room = free_space.ambient(settings.optics) * detection
    light, amplitude = opened * mean, opened * fundamental
    detector = settings.detector
    bare = Conversion(detector, settings.laser.wavelength).volts_per_watt
    crest = bare * (light + room + amplitude)
    dimming = np.minimum(1.0, ranger.level * detector.saturation / crest)
    noise = _phase_noise(ranger, dimming * (light + room), dimming * amplitude)
    return Levels(light, room, amplitude, dimming, noise, crest > detector.saturation)


def depth_noise(ranger: OpticalRanger, ranges: ArrayLike, reflectance: ArrayLike = 0.5) -> Array:
    """Linearised standard deviation of one reading's range (...), m, of diffuse targets."""
    noise = levels(ranger, ranges, reflectance).phase_noise
    return np.asarray(depth_from_phase(noise, ranger.frequency), float)


def beat_right(
    error_low: ArrayLike, error_high: ArrayLike, *, frequencies: tuple[float, float]
) -> NDArray[np.bool_]:
    """Whether the beat of phases with given errors (...), rad, names the right wrap.

    With ``phi_2 - k phi_1`` off by b the beat's range is off by ``b f_1 / Delta`` of phase at f_1,
    and the wrap that brings the measured phase nearest to it is right within half a turn.
    """
    low, high = frequencies
    multiple = round(high / low)
    beat = centred(np.asarray(error_high) - multiple * np.asarray(error_low))
    turns = (beat * low / (high - multiple * low) - np.asarray(error_low)) / TAU
    return np.abs(turns) < 0.5


def noisy_only(ranger: OpticalRanger, **changes: float) -> OpticalRanger:
    """Return the instrument with its noise and without any other error, perfectly calibrated."""
    quiet = replace(without_errors(ranger.settings), noise=True)
    return replace(
        ranger, settings=quiet, calibration="perfect", stage_error=0.0, temperature_error=0.0,
        pressure_error=0.0, **changes,
    )  # fmt: skip


def simulated_errors(
    ranger: OpticalRanger, distance: float, reflectance: float = 0.5, *, count: int, seed: int
) -> Array:
    """Errors (count,), m, of as many bursts of one noisy instrument at one diffuse place."""
    target = StageTarget(distance=distance, reflectance=reflectance)
    return ranger.sweep(target, np.zeros(count), repeats=1, seed=seed)[0] - distance


def _products(ranger: OpticalRanger, settings: TwinSettings) -> tuple[float, float, float]:
    """Mean and fundamental of the modules' product, and the detection's mean transmission."""
    modules = {name: getattr(settings, name) for name in ("emission", "detection", "drive")}
    bare = replace(TwinSettings.ideal(), **modules)
    return _products_of(replace(ranger, settings=bare, samples=1, settle=0))


@lru_cache(maxsize=64)
def _products_of(ranger: OpticalRanger) -> tuple[float, float, float]:
    world, pulses = World(ranger.settings), np.arange(ranger.phases)
    configuration = world.light.configuration(ranger.panel(), pulses, ranger.rate)
    order = 1 if ranger.mode == "single" else 2
    return (
        float(configuration.products[0].real.mean()),
        float(np.abs(configuration.products[order]).mean()),
        float(configuration.detection.mean()),
    )


def _phase_noise(ranger: OpticalRanger, light: Array, amplitude: Array) -> Array:
    """Noise (...), rad, at a mean light and an amplitude of the cosine (...), W."""
    detector = ranger.settings.detector
    conversion = Conversion(detector, ranger.settings.laser.wavelength)
    kept = ranger.samples - ranger.settle
    rounding = 4.0 ** (16 - detector.bits) / 12
    converter = (detector.converter_noise**2 + rounding) * slope(10.0) ** 2 / kept
    density = conversion.density(conversion.volts(light))
    reading = ranger.rate, ranger.phases, ranger.samples, ranger.settle
    variance = density * _bandwidth(detector, *reading) + 2 / ranger.phases * converter
    return np.sqrt(variance) / (conversion.volts_per_watt * amplitude)


@lru_cache(maxsize=64)
def _bandwidth(detector: Detector, rate: float, phases: int, samples: int, settle: int) -> float:
    """Variance, V^2, of one quadrature of the fundamental per one-sided density, V^2/Hz."""
    weights = mean_weights(phases, samples, settle)
    density = np.ones((1, weights.shape[1]))
    covariance = phase_covariance(chain(detector, 1 / rate), density, weights)[0]
    fundamental = 2 / phases * np.exp(-1j * nominal_psi(phases))
    return float((fundamental.conj() @ covariance @ fundamental).real / 2)
