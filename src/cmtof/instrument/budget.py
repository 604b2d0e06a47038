"""Where the light goes: powers, photons and noise along the path, each with its source."""

from typing import NamedTuple

import numpy as np

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.instrument import optics as free_space
from cmtof.instrument.electronics import PLANCK, SLOPE, Conversion, chain
from cmtof.instrument.optics import emission_mean, sent_power
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.targets import Hits
from cmtof.instrument.world import PHASES, SAMPLE_RATE, SAMPLES
from cmtof.modulator import doubled_mode_harmonics, single_mode_harmonics

_LAWS = {"single": single_mode_harmonics, "doubled": doubled_mode_harmonics}


class BudgetLine(NamedTuple):
    """One step along the light's path."""

    name: str
    value: float
    unit: str
    source: str


def photon_budget(
    settings: TwinSettings,
    *,
    mode: str = "single",
    distance: float = 1.0,
    reflectance: float = 0.5,
) -> list[BudgetLine]:
    """Light from the laser to the counts, for a diffuse target that faces the instrument.

    Ideal modulators at the stated eta; the last lines are what noise follows from it.

    Parameters
    ----------
    settings : TwinSettings
    mode : {"single", "doubled"}
    distance : float
        Range of the target, m.
    reflectance : float
        0 to 1.

    Raises
    ------
    ValueError
        For another mode, or a range that is not positive.

    Examples
    --------
    >>> lines = photon_budget(TwinSettings())
    >>> [round(line.value * 1e3, 2) for line in lines if line.name == "Sent to the scene"]
    [3.2]
    """
    if mode not in ("single", "doubled"):
        raise ValueError(f"Expected mode single or doubled, got {mode!r}. Choose one.")
    if not distance > 0:
        raise ValueError(f"Expected a range above 0 m, got {distance}. Give it in metres.")
    harmonics = _LAWS[mode](settings.drive.eta, 2)
    mean = float(harmonics[0].real)
    order = 1 if mode == "single" else 2
    contrast = float(2 * abs(harmonics[order]) ** 2 / mean**2)
    return _optical(settings, mode, mean, distance, reflectance, contrast)


def _optical(
    settings: TwinSettings,
    mode: str,
    mean: float,
    distance: float,
    reflectance: float,
    contrast: float,
) -> list[BudgetLine]:
    optics, laser = settings.optics, settings.laser
    fibre = (laser.fibre_low + laser.fibre_high) / 2
    module = emission_mean(settings, mode)
    sent = sent_power(settings, mode)
    hits = Hits(np.array(distance), np.array(1.0), np.array(reflectance))
    share = float(free_space.returned_fraction(optics, "diffuse", hits))
    caught = sent * share
    demodulated = free_space.inward(optics) * mean * settings.detection.mirror_reflectance
    room = free_space.ambient(optics) * mean * settings.detection.mirror_reflectance
    light = caught * demodulated
    lines = [
        BudgetLine("Laser", laser.power, "W", "assumed: yields the 3 mW of Sec. 7.1"),
        BudgetLine("Fibre", fibre, "1", "Sec. 7.1: 20-30 %"),
        BudgetLine("Emission module", module, "1", "mean of Eq. 16 or 19, silver mirror"),
        BudgetLine(
            "Optics to the scene", free_space.outward(optics), "1", "Sec. 7.1: two splitters"
        ),
        BudgetLine("Sent to the scene", sent, "W", "product; Sec. 7.1: 3 mW"),
        BudgetLine("Share collected", share, "1", "rho A / (2 pi z^2), one polarisation"),
        BudgetLine("Collected", caught, "W", "product"),
        BudgetLine("Detection path", demodulated, "1", "Sec. 7.2: a splitter, module, lenses"),
        BudgetLine("On the detector", light, "W", "product"),
        BudgetLine("Room light on the detector", room, "W", "radiance x etendue (assumed)"),
        BudgetLine("Correlation contrast", contrast, "1", "2 J1^2 or 2 J2^2 / (1 - J0)^2"),
    ]
    return lines + _electrical(settings, light, room, contrast)


def _electrical(
    settings: TwinSettings, light: float, room: float, contrast: float
) -> list[BudgetLine]:
    detector, wavelength = settings.detector, settings.laser.wavelength
    conversion = Conversion(detector, wavelength)
    bandwidth = chain(detector, 1 / SAMPLE_RATE).noise_bandwidth
    volts = float(conversion.volts(light + room))
    phase_time = SAMPLES / SAMPLE_RATE
    rate = light * wavelength / (PLANCK * SPEED_OF_LIGHT)
    amplifier = detector.noise_density * np.sqrt(bandwidth)
    total = np.sqrt(float(conversion.density(volts)) * bandwidth)
    shot = np.sqrt(max(total**2 - amplifier**2, 0.0))
    converter = detector.converter_noise * SLOPE
    # a mean over a phase averages white noise of the density over 1 / (2 T)
    mean = np.sqrt(float(conversion.density(volts)) / (2 * phase_time) + converter**2 / SAMPLES)
    amplitude = contrast * float(conversion.volts(light))
    spread = np.sqrt(2 / PHASES) * mean / amplitude if amplitude > 0 else np.inf
    return [
        BudgetLine("Photons", rate, "1/s", "P lambda / h c"),
        BudgetLine("Photons in a phase", rate * phase_time, "1", "20 samples at 24 kS/s"),
        BudgetLine("Photons in a point", rate * phase_time * PHASES, "1", "16 phases, 13.3 ms"),
        BudgetLine(
            "Photo-electrons in a point",
            rate * phase_time * PHASES * detector.efficiency,
            "1",
            "quantum efficiency at 532 nm (known)",
        ),
        BudgetLine("Detector output", volts, "V", "M R_0 R_T; APD440A, 5e7 V/A"),
        BudgetLine("Noise bandwidth", bandwidth, "Hz", "detector, EF120 and RC"),
        BudgetLine("Shot noise, a sample", shot, "V", "2 e I F, F = M^x"),
        BudgetLine("Amplifier noise, a sample", amplifier, "V", "APD440A: NEP 3.5 fW/sqrt(Hz)"),
        BudgetLine("Converter noise, a sample", converter, "V", "T7: about 1 count of 16 bit"),
        BudgetLine("Amplitude of the correlation", amplitude, "V", "contrast x output"),
        BudgetLine("Phase noise of a point", float(spread), "rad", "sqrt(2/16) sigma / a"),
    ]
