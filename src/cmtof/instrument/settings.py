"""Settings of the simulated instrument: every number behind the light, with its source.

SI units and radians. *Known*: from general knowledge of the part, not verified. *Assumed*: the
paper does not say; a number that such a part could have. Nothing here was tuned to the paper's
results.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cmtof.constants import FREQUENCY_SINGLE, LASER_WAVELENGTH, SPEED_OF_LIGHT
from cmtof.instrument.parsing import check_fields, choice, number, section_from_mapping

MATERIALS = ("diffuse", "specular", "retro")
"""How a surface sends light back."""


class _Checked:
    def __post_init__(self) -> None:
        check_fields(type(self), vars(self), f"twin's {type(self).__name__}")


@dataclass(frozen=True, kw_only=True)
class Laser(_Checked):
    """Laser and fibre (Sec. 7.1: Laser Quantum gem 532, OZ Optics QPMJ)."""

    power: float = number(0.15, 0, 10)
    """W; assumed: gives the 3 mW that Sec. 7.1 states as emitted."""
    wavelength: float = number(LASER_WAVELENGTH, 3e-7, 2e-6)
    """m (Sec. 7.1)."""
    fibre_low: float = number(0.20, 0, 1)
    """Lowest transmission of the fibre (Sec. 7.1: 20-30 %)."""
    fibre_high: float = number(0.30, 0, 1)
    """Highest transmission of the fibre; it drifts between the two."""


@dataclass(frozen=True, kw_only=True)
class Module(_Checked):
    """One two-pass modulator; names and signs as in `cmtof.modulator.TwoPassModulator`."""

    plate_zero: float = number(0.0, -7, 7)
    """Mount angle of the half-wave plate at which theta_h is 0, rad."""
    half_wave_angle_error: float = number(0.0, -1, 1)
    half_wave_retardance_error: float = number(0.0, -1, 1)
    quarter_wave_angle_error: float = number(0.0, -1, 1)
    quarter_wave_retardance_error: float = number(0.0, -1, 1)
    eom_angle_error: float = number(0.0, -1, 1)
    static_retardance: float = number(0.0, -4, 4)
    mirror_distance: float = number(SPEED_OF_LIGHT / (2 * FREQUENCY_SINGLE), 0, 1)
    """EOM to mirror, m: half a modulation wavelength of 7.15 GHz (Sec. 6.2.1)."""
    mirror_reflectance: float = number(0.97, 0, 1)
    """Protected silver, PF10-03-P01 (known)."""
    transmitted_extinction: float = number(1000.0, 1.0001)
    """Splitter cube PBS101, T_p : T_s (known)."""
    reflected_extinction: float = number(100.0, 1.0001)
    """The same cube's reflected port, known to be worse (known, 20 to 100)."""


@dataclass(frozen=True, kw_only=True)
class Drive(_Checked):
    """RF drivers, resonance and what is wrong with them (Sec. 7.3).

    The drive amplitude is ``eta * 10^((P - power) / 20)`` for P in dBm, times the resonance's
    Lorentzian relative to ``detuning``: as stated at both frequencies of the default rig.
    """

    eta: float = number(float(np.pi / 4), 0, 3)
    """Retardance amplitude of one pass, rad, at ``power`` and ``detuning`` (assumed)."""
    power: float = number(30.0, -20, 50)
    """dBm at which ``eta`` is stated (assumed)."""
    detuning: float = number(5e6, 0, 1e9)
    """Hz off resonance at which ``eta`` is stated."""
    resonance: float = number(7.155e9, 1e6)
    """Resonance of both crystals, Hz (assumed: between the drives at 7.15 and 7.16 GHz)."""
    width: float = number(20e6, 1e3)
    """Full width at half power of the resonance, Hz (Sec. 6.1: 20 MHz of bandwidth)."""
    lock_range: float = number(15e6, 0)
    """Detuning within which a driver locks, Hz (assumed)."""
    phase_offset: float = number(0.4, -7, 7)
    """Phase by which the detection's cable lags, rad (assumed; calibration removes it)."""
    phase_drift: float = number(1e-3, 0, 3)
    """Slow drift of the phase between the drivers, rms, rad (assumed)."""
    phase_step_error: float = number(5e-4, 0, 1)
    """Error of each of the 65536 phase codes, rms, rad (assumed)."""
    iq_imbalance: float = number(1e-3, 0, 0.5)
    """Amplitude of the drivers' phase error sin(2 phi), rad (assumed)."""
    leakage: float = number(1e-4, 0, 1)
    """Amplitude of either drive that leaks into the other crystal: -80 dB (assumed). The table of
    the doubled mode spans half a turn of the drive, over which a leak does not average out: -60 dB
    would already cost a cyclic error of 15 mrad."""
    leakage_phase: float = number(0.0, -7, 7)
    """Phase that the leak gains, rad."""
    free_running: float = number(2e-7, 0, 1e-3)
    """Relative error of a driver without the external clock, of opposite signs (assumed)."""


@dataclass(frozen=True, kw_only=True)
class Optics(_Checked):
    """From the modulator to the scene and back (Sec. 7.1, 7.2)."""

    splitter: float = number(0.45, 0, 0.5)
    """Share of either port of a CCM1-BS013 (known: 50:50 with some absorption)."""
    mirror: float = number(0.97, 0, 1)
    """Reflectance of a silvered mirror, the galvo's included (known)."""
    lens: float = number(0.99, 0, 1)
    """Transmission of a coated lens (known)."""
    aperture: float = number(3.2e-3, 1e-5, 0.1)
    """Diameter of the collecting aperture at the galvo, m: 2 mm of crystal through the 1.6x
    expander (crystal assumed, expander Sec. 7.2)."""
    exit_radius: float = number(0.25e-3, 0, 0.05)
    """1/e^2 radius of the beam at the galvo, m (Sec. 7.1: 0.5 mm of diameter)."""
    divergence: float = number(1e-3, 0, 0.2)
    """1/e^2 half angle of the defocused beam, rad (assumed; diffraction alone 0.68 mrad)."""
    speckle: bool = True
    """Whether rough surfaces speckle."""
    internal_path: float = number(0.5, -10, 10)
    """Optical path between the modulators inside the instrument, half of it, m (assumed)."""
    back_range: float = number(-0.10, -5, 50)
    """Range of the coaxial back-reflection, m: the beam splitter before the galvo (assumed)."""
    back_fraction: float = number(1e-9, 0, 1)
    """Share of the emitted light that comes back from there and enters the aperture (assumed)."""
    arm_fraction: float = number(0.2, 0, 1)
    """The same for the interferometer's arm while its beam block is out (assumed)."""
    field_of_view: float = number(1e-3 / 25.4e-3 / 1.6, 0, 1)
    """Full angle that the detector sees, rad: 1 mm behind LA1951-A (f = 25.4 mm, known), 1.6x."""
    ambient_radiance: float = number(0.1, 0, 1e4)
    """Room light that the detector sees, W/(m^2 sr) (assumed: a white wall in 150 lux)."""


@dataclass(frozen=True, kw_only=True)
class Air(_Checked):
    """Air between instrument and scene."""

    temperature: float = number(293.15, 200, 350)
    """K."""
    pressure: float = number(101325.0, 0, 2e5)
    """Pa; 0 is vacuum."""


@dataclass(frozen=True, kw_only=True)
class Detector(_Checked):
    """Avalanche detector Thorlabs APD440A, filters and converter (Sec. 7.2).

    Thorlabs' table of free-space Si APDs (as transcribed by a third party, not checked against
    Thorlabs): 53 A/W at 800 nm and M = 100, 2.65e9 V/W, hence 5e7 V/A; least NEP 3.5 fW/sqrt(Hz),
    saturation 1.54 nW at M = 100, hence 4.1 V; DC to 100 kHz; 1 mm.
    """

    gain: float = number(50.0, 1, 1000)
    """Avalanche gain M, adjustable from 10 to 100."""
    efficiency: float = number(0.65, 0, 1)
    """Quantum efficiency at 532 nm (known; 0.82 at 800 nm follows from 53 A/W)."""
    excess_index: float = number(0.3, 0, 1)
    """x of the excess noise F = M^x (Hamamatsu Si APD S12023, 0.3 at 800 nm; the diode inside an
    APD440A is not stated)."""
    transimpedance: float = number(5e7, 1)
    """V/A: 2.65e9 V/W over 53 A/W."""
    noise_density: float = number(3.5e-15 * 2.65e9, 0)
    """Noise of detector and amplifier at the output, V/sqrt(Hz): least NEP times gain; taken as
    the same at every M."""
    saturation: float = number(4.1, 0.001)
    """Largest output, V: 1.54 nW times 2.65e9 V/W."""
    bandwidth: float = number(1e5, 1)
    """-3 dB, Hz."""
    low_pass: float = number(1e4, 1)
    """-3 dB of the filter EF120, Hz (Sec. 7.2); one pole (its order is not verified)."""
    rc_time: float = number(20e-6, 1e-9, 100)
    """RC time constant, s; the paper's 0.1 damps the 75 Hz of a sweep 47 times."""
    bits: int = number(16, 4, 16)  # type: ignore[assignment]
    """Bits of the converter: 16 of the T7's stream; the paper speaks of 14."""
    converter_noise: float = number(1.0, 0, 1e4)
    """Noise of the T7 in stream mode, counts of 16 bit, rms (T-Series Datasheet, A-3-2-2: an
    effective resolution of about 16 bit at index 1, +-10 V; the table was not seen)."""


@dataclass(frozen=True, kw_only=True)
class Galvo(_Checked):
    """Scan mirrors GVS012."""

    volts_per_degree: float = number(0.5, 1e-3, 100)
    """V per mechanical degree (GVS012 manual: 0.5)."""
    offset_x: float = number(0.0, -10, 10)
    """V at which the beam leaves along +z."""
    offset_y: float = number(0.0, -10, 10)


@dataclass(frozen=True, kw_only=True)
class Reference(_Checked):
    """Target on the stage behind the flip mirror (Sec. 8.2: 60 cm)."""

    distance: float = number(0.60, 0.01, 100)
    """Range at ``stage_zero``, m along the ray."""
    stage_zero: float = number(0.025, -1, 1)
    """Position of the stage at that range, m."""
    material: str = choice("diffuse", MATERIALS)
    reflectance: float = number(0.5, 0, 1)
    """Reflectance, any grey filter in front included: a bare mirror saturates the detector."""


@dataclass(frozen=True, kw_only=True)
class TwinSettings:
    """Everything below ``twin:`` in a rig file.

    Examples
    --------
    >>> TwinSettings.from_mapping({"detector": {"rc_time": 0.1}}).detector.rc_time
    0.1
    >>> TwinSettings.from_mapping({"laser": {"power": -1}})
    Traceback (most recent call last):
        ...
    ValueError: Expected twin.laser.power from 0 to 10, got -1. Keep to SI units.
    """

    laser: Laser = field(default_factory=Laser)
    emission: Module = field(default_factory=Module)
    detection: Module = field(default_factory=Module)
    drive: Drive = field(default_factory=Drive)
    optics: Optics = field(default_factory=Optics)
    air: Air = field(default_factory=Air)
    detector: Detector = field(default_factory=Detector)
    galvo: Galvo = field(default_factory=Galvo)
    reference: Reference = field(default_factory=Reference)
    noise: bool = True
    """Whether photons, amplifier and converter are noisy; rounding and clipping stay."""
    scene: Any = None
    """Scene as `cmtof.instrument.scene.scene_from` takes it."""
    faults: Any = ()
    """Faults on demand, for the servers."""

    def __post_init__(self) -> None:
        if self.laser.fibre_high < self.laser.fibre_low:
            raise ValueError(
                f"Expected twin.laser.fibre_high from {self.laser.fibre_low:g} on, "
                f"got {self.laser.fibre_high:g}. Raise it, or lower fibre_low."
            )

    @classmethod
    def from_mapping(cls, raw: Mapping[str, Any] | None) -> "TwinSettings":
        """Build settings from a rig file's mapping; what it does not name keeps its default."""
        return section_from_mapping(cls, {} if raw is None else raw, "twin")

    @classmethod
    def ideal(cls, **changes: Any) -> "TwinSettings":
        """Build settings without noise, drift, errors, speckle, back-reflection or air."""
        module = Module(
            mirror_reflectance=1.0, transmitted_extinction=np.inf, reflected_extinction=np.inf
        )
        drive = {"phase_offset", "phase_drift", "phase_step_error", "iq_imbalance", "leakage"}
        quiet = cls(
            laser=Laser(fibre_low=0.25, fibre_high=0.25),
            emission=module,
            detection=module,
            drive=replace(Drive(), **dict.fromkeys(drive, 0.0)),
            optics=Optics(
                speckle=False,
                back_fraction=0.0,
                ambient_radiance=0.0,
                divergence=0.0,
                exit_radius=0.0,
            ),
            air=Air(pressure=0.0),
            noise=False,
        )
        return replace(quiet, **changes)
