"""Settings of the simulated instrument: every number behind the light, with its source.

SI units and radians. *Known*: from general knowledge of the part, not verified. *Assumed*: the
paper does not say; a number that such a part could have. Nothing here was tuned to the paper's
results.
"""

from dataclasses import replace
from typing import Any, Literal

import numpy as np
from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

from cmtof.constants import FREQUENCY_SINGLE, LASER_WAVELENGTH, SPEED_OF_LIGHT

Material = Literal["diffuse", "specular"]
STRICT = ConfigDict(extra="forbid", strict=True)
"""Unknown names and values of another kind are errors."""


def number(default: float, low: float, high: float = np.inf) -> Any:
    """Field for a number from ``low`` to ``high``, both allowed."""
    return Field(default=default, ge=low, le=high)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Laser:
    """Laser and fibre (Sec. 7.1: Laser Quantum gem 532, OZ Optics QPMJ)."""

    power: float = number(0.15, 0, 10)  # W; assumed: gives the 3 mW that Sec. 7.1 states as emitted
    wavelength: float = number(LASER_WAVELENGTH, 3e-7, 2e-6)  # m (Sec. 7.1)
    fibre_low: float = number(0.20, 0, 1)  # Lowest transmission of the fibre (Sec. 7.1: 20-30 %)
    # Highest transmission of the fibre; it drifts between the two
    fibre_high: float = number(0.30, 0, 1)

    def __post_init__(self) -> None:
        if self.fibre_high < self.fibre_low:
            raise ValueError(
                f"Expected laser.fibre_high from {self.fibre_low:g} on, got {self.fibre_high:g}. "
                "Raise it, or lower fibre_low."
            )


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Module:
    """One two-pass modulator; names and signs as in `cmtof.modulator.TwoPassModulator`."""

    # Mount angle of the half-wave plate at which theta_h is 0, rad
    plate_zero: float = number(0.0, -7, 7)
    half_wave_angle_error: float = number(0.0, -1, 1)
    half_wave_retardance_error: float = number(0.0, -1, 1)
    quarter_wave_angle_error: float = number(0.0, -1, 1)
    quarter_wave_retardance_error: float = number(0.0, -1, 1)
    eom_angle_error: float = number(0.0, -1, 1)
    static_retardance: float = number(0.0, -4, 4)
    # EOM to mirror, m: half a modulation wavelength of 7.15 GHz (Sec. 6.2.1)
    mirror_distance: float = number(SPEED_OF_LIGHT / (2 * FREQUENCY_SINGLE), 0, 1)
    mirror_reflectance: float = number(0.97, 0, 1)  # Protected silver, PF10-03-P01 (known)
    # Splitter cube PBS101, T_p : T_s (known)
    transmitted_extinction: float = number(1000.0, 1.0001)
    # The same cube's reflected port, known to be worse (known, 20 to 100)
    reflected_extinction: float = number(100.0, 1.0001)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Drive:
    """RF drivers, resonance and what is wrong with them (Sec. 7.3).

    The drive amplitude is ``eta * 10^((P - power) / 20)`` for P in dBm, times the resonance's
    Lorentzian relative to ``detuning``: as stated at both frequencies of the default rig.
    """

    # Retardance amplitude of one pass, rad, at ``power`` and ``detuning`` (assumed)
    eta: float = number(float(np.pi / 4), 0, 3)
    power: float = number(30.0, -20, 50)  # dBm at which ``eta`` is stated (assumed)
    detuning: float = number(5e6, 0, 1e9)  # Hz off resonance at which ``eta`` is stated
    # Resonance of both crystals, Hz (assumed: between the drives at 7.15 and 7.16 GHz)
    resonance: float = number(7.155e9, 1e6)
    # Full width at half power of the resonance, Hz (Sec. 6.1: 20 MHz of bandwidth)
    width: float = number(20e6, 1e3)
    lock_range: float = number(15e6, 0)  # Detuning within which a driver locks, Hz (assumed)
    # Phase by which the detection's cable lags, rad (assumed; calibration removes it)
    phase_offset: float = number(0.4, -7, 7)
    # Slow drift of the phase between the drivers, rms, rad (assumed)
    phase_drift: float = number(1e-3, 0, 3)
    # Error of each of the 65536 phase codes, rms, rad (assumed)
    phase_step_error: float = number(5e-4, 0, 1)
    # Amplitude of the drivers' phase error sin(2 phi), rad (assumed)
    iq_imbalance: float = number(1e-3, 0, 0.5)
    # Amplitude of either drive that leaks into the other crystal: -80 dB (assumed). The
    # doubled mode's table spans half a turn, over which a leak does not average out
    leakage: float = number(1e-4, 0, 1)
    leakage_phase: float = number(0.0, -7, 7)  # Phase that the leak gains, rad


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Optics:
    """From the modulator to the scene and back (Sec. 7.1, 7.2)."""

    # Share of either port of a CCM1-BS013 (known: 50:50 with some absorption)
    splitter: float = number(0.45, 0, 0.5)
    # Reflectance of a silvered mirror, the galvo's included (known)
    mirror: float = number(0.97, 0, 1)
    lens: float = number(0.99, 0, 1)  # Transmission of a coated lens (known)
    # Diameter of the collecting aperture at the galvo, m: 2 mm of crystal through the 1.6x
    # expander (crystal assumed, expander Sec. 7.2)
    aperture: float = number(3.2e-3, 1e-5, 0.1)
    # 1/e^2 radius of the beam at the galvo, m (Sec. 7.1: 0.5 mm of diameter)
    exit_radius: float = number(0.25e-3, 0, 0.05)
    # 1/e^2 half angle of the defocused beam, rad (assumed; diffraction alone 0.68 mrad)
    divergence: float = number(1e-3, 0, 0.2)
    speckle: bool = True  # Whether rough surfaces speckle
    # Optical path between the modulators inside the instrument, half of it, m (assumed)
    internal_path: float = number(0.5, -10, 10)
    # Range of the coaxial back-reflection, m: the beam splitter before the galvo (assumed)
    back_range: float = number(-0.10, -5, 50)
    # Share of the emitted light that comes back from there and enters the aperture (assumed)
    back_fraction: float = number(1e-9, 0, 1)
    # Full angle that the detector sees, rad: 1 mm behind LA1951-A (f = 25.4 mm, known), 1.6x
    field_of_view: float = number(1e-3 / 25.4e-3 / 1.6, 0, 1)
    # Room light that the detector sees, W/(m^2 sr) (assumed: a white wall in 150 lux)
    ambient_radiance: float = number(0.1, 0, 1e4)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Air:
    """Air between instrument and scene."""

    temperature: float = number(293.15, 200, 350)  # K
    pressure: float = number(101325.0, 0, 2e5)  # Pa; 0 is vacuum


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Detector:
    """Avalanche detector Thorlabs APD440A, filters and converter (Sec. 7.2).

    Thorlabs' table of free-space Si APDs (transcribed by a third party, not checked against
    Thorlabs): 53 A/W at 800 nm and M = 100, 2.65e9 V/W, hence 5e7 V/A; least NEP 3.5 fW/sqrt(Hz),
    saturation 1.54 nW at M = 100, hence 4.1 V; DC to 100 kHz; 1 mm.
    """

    gain: float = number(50.0, 1, 1000)  # Avalanche gain M, adjustable from 10 to 100
    # Quantum efficiency at 532 nm (known; 0.82 at 800 nm follows from 53 A/W)
    efficiency: float = number(0.65, 0, 1)
    # x of the excess noise F = M^x (Hamamatsu Si APD S12023, 0.3 at 800 nm; the diode inside
    # an APD440A is not stated)
    excess_index: float = number(0.3, 0, 1)
    transimpedance: float = number(5e7, 1)  # V/A: 2.65e9 V/W over 53 A/W
    # Noise of detector and amplifier at the output, V/sqrt(Hz): least NEP times gain; taken
    # as the same at every M
    noise_density: float = number(3.5e-15 * 2.65e9, 0)
    saturation: float = number(4.1, 0.001)  # Largest output, V: 1.54 nW times 2.65e9 V/W
    bandwidth: float = number(1e5, 1)  # -3 dB, Hz
    # -3 dB of the filter EF120, Hz (Sec. 7.2); one pole (its order is not verified)
    low_pass: float = number(1e4, 1)
    # RC time constant, s; the paper's 0.1 damps the 75 Hz of a sweep 47 times
    rc_time: float = number(20e-6, 1e-9, 100)
    # Bits of the converter: 16 of the T7's stream; the paper speaks of 14
    bits: int = number(16, 4, 16)
    # Noise of the T7 in stream mode, counts of 16 bit, rms (T-Series Datasheet, A-3-2-2: an
    # effective resolution of about 16 bit at index 1, +-10 V; the table was not seen)
    converter_noise: float = number(1.0, 0, 1e4)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Reference:
    """Target on the stage behind the flip mirror (Sec. 8.2: 60 cm)."""

    distance: float = number(0.60, 0.01, 100)  # Range at ``stage_zero``, m along the ray
    stage_zero: float = number(0.025, -1, 1)  # Position of the stage at that range, m
    material: Material = "diffuse"
    # Reflectance, any grey filter in front included: a bare mirror saturates the detector
    reflectance: float = number(0.5, 0, 1)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TwinSettings:
    """Everything below ``twin:`` in a rig file; ``scene`` as `cmtof.instrument.targets` takes it.

    Examples
    --------
    >>> TwinSettings(detector=Detector(rc_time=0.1)).detector.rc_time
    0.1
    """

    laser: Laser = Laser()
    emission: Module = Module()
    detection: Module = Module()
    drive: Drive = Drive()
    optics: Optics = Optics()
    air: Air = Air()
    detector: Detector = Detector()
    reference: Reference = Reference()
    # Whether photons, amplifier and converter are noisy; rounding and clipping stay
    noise: bool = True
    scene: Any = None

    @classmethod
    def ideal(cls, **changes: Any) -> "TwinSettings":
        """Build settings without noise, drift, errors, speckle, back-reflection or air."""
        module = Module(
            mirror_reflectance=1.0, transmitted_extinction=np.inf, reflected_extinction=np.inf
        )
        faults = ("phase_offset", "phase_drift", "phase_step_error", "iq_imbalance", "leakage")
        light = ("back_fraction", "ambient_radiance", "divergence", "exit_radius")
        quiet = cls(
            laser=Laser(fibre_low=0.25, fibre_high=0.25),
            emission=module,
            detection=module,
            drive=replace(Drive(), **dict.fromkeys(faults, 0.0)),
            optics=replace(Optics(speckle=False), **dict.fromkeys(light, 0.0)),
            air=Air(pressure=0.0),
            noise=False,
        )
        return replace(quiet, **changes)
