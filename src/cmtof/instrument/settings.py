"""Settings of the simulated instrument: every number behind the light, with its source.

SI units and radians. *Known*: from general knowledge of the part, not verified. *Assumed*: the
paper does not say; a number that such a part could have. Nothing was tuned to the paper's results.
"""

from dataclasses import replace
from typing import Any, Literal

import numpy as np
from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

from cmtof.constants import FREQUENCY_SINGLE, LASER_WAVELENGTH, SPEED_OF_LIGHT

STRICT = ConfigDict(extra="forbid")
"""Unknown names are errors."""


def number(default: float, low: float, high: float = np.inf) -> Any:
    """Field for a number from ``low`` to ``high``, both allowed."""
    return Field(default=default, ge=low, le=high)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Laser:
    """Laser and fibre (Sec. 7.1: Laser Quantum gem 532, OZ Optics QPMJ)."""

    power: float = number(0.15, 0, 10)  # W; assumed: gives the 3 mW of Sec. 7.1 as emitted
    wavelength: float = number(LASER_WAVELENGTH, 3e-7, 2e-6)  # m (Sec. 7.1)
    fibre_low: float = number(0.20, 0, 1)  # transmission of the fibre (Sec. 7.1: 20-30 %), which
    fibre_high: float = number(0.30, 0, 1)  # drifts between the two


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Module:
    """One two-pass modulator, as in `cmtof.modulator.TwoPassModulator`."""

    # m, EOM to mirror: half a modulation wavelength of 7.15 GHz (Sec. 6.2.1)
    mirror_distance: float = number(SPEED_OF_LIGHT / (2 * FREQUENCY_SINGLE), 0, 1)
    mirror_reflectance: float = number(0.97, 0, 1)  # protected silver, PF10-03-P01 (known)
    transmitted_extinction: float = number(1000.0, 1.0001)  # cube PBS101, T_p : T_s (known)
    reflected_extinction: float = number(100.0, 1.0001)  # its other port (known, 20 to 100)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Drive:
    """RF drivers, resonance and what is wrong with them (Sec. 7.3).

    A drive of P dBm at the detuning d has ``eta * 10^((P - power) / 20)``, times the resonance's
    Lorentzian relative to ``detuning``: as stated at both frequencies of the default rig.
    """

    # rad, retardance amplitude of one pass at ``power`` and ``detuning`` (assumed)
    eta: float = number(float(np.pi / 4), 0, 3)
    power: float = number(30.0, -20, 50)  # dBm (assumed)
    detuning: float = number(5e6, 0, 1e9)  # Hz
    resonance: float = number(7.155e9, 1e6)  # Hz, of both crystals (assumed: between the drives)
    width: float = number(20e6, 1e3)  # Hz, full at half power (Sec. 6.1: bandwidth)
    lock_range: float = number(15e6, 0)  # Hz of detuning within which a driver locks (assumed)
    phase_offset: float = number(0.4, -7, 7)  # rad, lag of the detection's cable (assumed)
    phase_drift: float = number(1e-3, 0, 3)  # rad rms between the drivers, slow (assumed)
    phase_step_error: float = number(5e-4, 0, 1)  # rad rms, of each of 65536 codes (assumed)
    iq_imbalance: float = number(1e-3, 0, 0.5)  # rad, amplitude of sin(2 phi) (assumed)
    # share of either drive's amplitude that leaks into the other crystal: -80 dB (assumed)
    leakage: float = number(1e-4, 0, 1)
    leakage_phase: float = number(0.0, -7, 7)  # rad that the leak gains


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Optics:
    """From the modulator to the scene and back (Sec. 7.1, 7.2)."""

    splitter: float = number(0.45, 0, 0.5)  # share of either port of a CCM1-BS013 (known)
    mirror: float = number(0.97, 0, 1)  # silvered, the galvo's included (known)
    lens: float = number(0.99, 0, 1)  # coated (known)
    # m, diameter of the aperture at the galvo: 2 mm of crystal (assumed) through the 1.6x expander
    aperture: float = number(3.2e-3, 1e-5, 0.1)
    exit_radius: float = number(0.25e-3, 0, 0.05)  # m, 1/e^2, at the galvo (Sec. 7.1: 0.5 mm wide)
    # rad, 1/e^2 half angle of the defocused beam (assumed; diffraction alone 0.68 mrad)
    divergence: float = number(1e-3, 0, 0.2)
    speckle: bool = True  # whether rough surfaces speckle
    internal_path: float = number(0.5, -10, 10)  # m, half the path between the modulators (assumed)
    back_range: float = number(-0.10, -5, 50)  # m, of the coaxial back-reflection: a splitter
    back_fraction: float = number(1e-9, 0, 1)  # share of the emitted light in it (both assumed)
    # rad, full angle that the detector sees: 1 mm behind LA1951-A (f = 25.4 mm, known), 1.6x
    field_of_view: float = number(1e-3 / 25.4e-3 / 1.6, 0, 1)
    ambient_radiance: float = number(0.1, 0, 1e4)  # W/(m^2 sr) (assumed: white wall, 150 lux)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Air:
    """Air between instrument and scene."""

    temperature: float = number(293.15, 200, 350)  # K
    pressure: float = number(101325.0, 0, 2e5)  # Pa; 0 is vacuum


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Detector:
    """Avalanche detector Thorlabs APD440A, filters and converter (Sec. 7.2).

    Thorlabs' table of free-space Si APDs (transcribed by a third party, not checked): 53 A/W at
    800 nm and M = 100, 2.65e9 V/W, NEP 3.5 fW/sqrt(Hz), saturation 1.54 nW, DC to 100 kHz, 1 mm.
    """

    gain: float = number(50.0, 1, 1000)  # avalanche gain M, adjustable from 10 to 100
    efficiency: float = number(0.65, 0, 1)  # at 532 nm (known; 53 A/W are 0.82 at 800 nm)
    # x of the excess noise F = M^x (Hamamatsu S12023 at 800 nm; the diode inside is not stated)
    excess_index: float = number(0.3, 0, 1)
    transimpedance: float = number(5e7, 1)  # V/A: 2.65e9 V/W over 53 A/W
    noise_density: float = number(3.5e-15 * 2.65e9, 0)  # V/sqrt(Hz) at the output, at every M
    saturation: float = number(4.1, 0.001)  # V, largest output: 1.54 nW times 2.65e9 V/W
    bandwidth: float = number(1e5, 1)  # Hz, -3 dB
    low_pass: float = number(1e4, 1)  # Hz, filter EF120 (Sec. 7.2); one pole (not verified)
    rc_time: float = number(20e-6, 1e-9, 100)  # s; the paper's 0.1 damps a sweep 47 times
    bits: int = number(16, 4, 16)  # of the T7's stream; the paper speaks of 14
    # counts rms of the T7's stream (T-Series Datasheet, A-3-2-2: about 16 bit; table not seen)
    converter_noise: float = number(1.0, 0, 1e4)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Reference:
    """Target on the stage behind the flip mirror (Sec. 8.2: 60 cm)."""

    distance: float = number(0.60, 0.01, 100)  # m along the ray with the stage at ``stage_zero``
    stage_zero: float = number(0.025, -1, 1)  # m
    material: Literal["diffuse", "specular"] = "diffuse"
    reflectance: float = number(0.5, 0, 1)  # with its grey filter: a bare mirror saturates

    @classmethod
    def mirror(cls, **changes: Any) -> "Reference":
        """Silvered mirror, PF10-03-P01 (known: 97 % at 532 nm)."""
        return cls(material="specular", reflectance=0.97, **changes)


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
    noise: bool = True  # of photons, amplifier and converter; rounding and clipping stay
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
            drive=Drive(**dict.fromkeys(faults, 0.0)),
            optics=Optics(speckle=False, **dict.fromkeys(light, 0.0)),
            air=Air(pressure=0.0),
            noise=False,
        )
        return replace(quiet, **changes)
