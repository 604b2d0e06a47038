"""Settings of the simulated instrument, SI units and radians, with their sources.

*Known*: general knowledge of the part, not verified. *Assumed*: the paper does not say, such a part
could have it. Nothing was tuned to the paper's results.
"""

from typing import Annotated, Any

import numpy as np
from pydantic import ConfigDict, Field, NonNegativeFloat, PositiveFloat, TypeAdapter
from pydantic.dataclasses import dataclass

from cmtof import air
from cmtof.constants import FREQUENCY_SINGLE, LASER_WAVELENGTH, SPEED_OF_LIGHT
from cmtof.types import Fields
from cmtof_lab.targets import PLATE, Plane

Share = Annotated[float, Field(ge=0, le=1)]
Extinction = Annotated[float, Field(gt=1, allow_inf_nan=True)]

# Phase noise, rad, and correlation of neighbours in a line of the published captures, as chapter 7
# finds them by `cmtof.noise.fit_line_noise`: all that is fitted to them
CAPTURES = {"curlyhair1": (0.092, 0.45), "head": (0.132, 0.02), "owl": (0.126, 0.03)}
_LEVEL, _GRAIN = np.mean(list(CAPTURES.values()), axis=0).round(3).tolist()
# Noise of the instrument: that of photons and electronics alone, or besides the captures' mean.
# They have 7.15 GHz alone; as many radians at 14.32 GHz are assumed, where a jitter in time doubles
NOISE = {
    "photon": {},
    "captures": {"phase_noise": (_LEVEL, _LEVEL), "grain": _GRAIN},
}

# Settings that are zero in an ideal instrument
FLAWS = (
    "phase_offset",
    "phase_drift",
    "phase_step_error",
    "iq_imbalance",
    "leakage",
    "back_fraction",
    "ambient_radiance",
    "divergence",
    "exit_radius",
    "pressure",
)


@dataclass(
    frozen=True, kw_only=True, config=ConfigDict(extra="forbid", allow_inf_nan=False)
)
class TwinSettings:
    """Everything below ``twin:`` in a rig file; ``scene`` as `cmtof_lab.targets` takes it.

    A drive of P dBm at the detuning d has ``eta * 10^((P - drive_power) / 20)``, times the
    resonance's Lorentzian relative to ``detuning``: as stated at both frequencies of the rig.
    The detector's numbers are Thorlabs' for free-space Si APDs (transcribed by a third party, not
    checked): 53 A/W at 800 nm and M = 100, 2.65e9 V/W, NEP 3.5 fW/sqrt(Hz), saturation 1.54 nW.
    """

    # laser and fibre: Laser Quantum gem 532, OZ Optics QPMJ (Sec. 7.1)
    laser_power: NonNegativeFloat = (
        0.15  # W; assumed: gives the 3 mW of Sec. 7.1 as emitted
    )
    wavelength: PositiveFloat = LASER_WAVELENGTH  # m (Sec. 7.1)
    fibre_low: Share = 0.20  # transmission of the fibre (Sec. 7.1: 20-30 %), which
    fibre_high: Share = 0.30  # drifts between the two
    # both two-pass modulators
    # m from the EOM (Sec. 6.2.1)
    mirror_distance: NonNegativeFloat = SPEED_OF_LIGHT / (2 * FREQUENCY_SINGLE)
    mirror_reflectance: Share = 0.97  # protected silver, PF10-03-P01 (known)
    transmitted_extinction: Extinction = 1000.0  # cube PBS101, T_p : T_s (known)
    reflected_extinction: Extinction = 100.0  # its other port (known, 20 to 100)
    # RF drivers and resonance (Sec. 7.3)
    # rad, retardance of one pass, as stated (assumed)
    eta: float = Field(default=np.pi / 4, ge=0, le=3)
    drive_power: float = 30.0  # dBm (assumed)
    detuning: float = 5e6  # Hz
    resonance: PositiveFloat = (
        7.155e9  # Hz, of both crystals (assumed: between the drives)
    )
    resonance_width: PositiveFloat = (
        20e6  # Hz, full at half power (Sec. 6.1: bandwidth)
    )
    phase_offset: float = 0.4  # rad, lag of the detection's cable (assumed)
    phase_drift: NonNegativeFloat = 1e-3  # rad rms between the drivers, slow (assumed)
    phase_step_error: NonNegativeFloat = (
        5e-4  # rad rms, of each of 65536 codes (assumed)
    )
    # rad rms of a point of 16 phases, in either mode
    phase_noise: tuple[NonNegativeFloat, NonNegativeFloat] = (0.0, 0.0)
    # Correlation of that with the point before
    grain: float = Field(default=0.0, ge=0, le=0.5)
    iq_imbalance: NonNegativeFloat = 1e-3  # rad, amplitude of sin(2 phi) (assumed)
    # Of either drive's amplitude into the other crystal: -80 dB (assumed)
    leakage: Share = 1e-4
    leakage_phase: float = 0.0  # rad that the leak gains
    # from the modulator to the scene and back (Sec. 7.1, 7.2)
    splitter: Share = 0.45  # share of either port of a CCM1-BS013 (known)
    mirror: Share = 0.97  # silvered, the galvo's included (known)
    lens: Share = 0.99  # coated (known)
    # m at the galvo, before the 1.6x expander: 2 mm (assumed) of a crystal of 2.5 mm (Sec. 9); the
    # beam that leaves the expander in Sec. 7.2 is 0.5 mm wide
    aperture: PositiveFloat = 3.2e-3
    exit_radius: NonNegativeFloat = (
        0.25e-3  # m, 1/e^2, at the galvo (Sec. 7.1: 0.5 mm wide)
    )
    # rad, 1/e^2 half angle (assumed; diffraction alone 0.68 mrad)
    divergence: NonNegativeFloat = 1e-3
    speckle: bool = True  # whether rough surfaces speckle
    internal_path: float = 0.5  # m, half the path between the modulators (assumed)
    back_range: float = -0.10  # m, of the coaxial back-reflection: a splitter
    back_fraction: Share = 1e-9  # share of the emitted light in it (both assumed)
    # rad, full: 1 mm behind LA1951-A (known), 1.6x
    field_of_view: NonNegativeFloat = 1e-3 / 25.4e-3 / 1.6
    ambient_radiance: NonNegativeFloat = (
        0.1  # W/(m^2 sr) (assumed: white wall, 150 lux)
    )
    temperature: PositiveFloat = 293.15  # K, of the air
    pressure: NonNegativeFloat = 101325.0  # Pa; 0 is vacuum
    # avalanche detector Thorlabs APD440A, filters and converter (Sec. 7.2)
    # Avalanche gain M, adjustable from 10 to 100
    gain: float = Field(default=50.0, ge=1, le=1000)
    efficiency: Share = 0.65  # at 532 nm (known; 53 A/W are 0.82 at 800 nm)
    # x of the excess noise M^x (Hamamatsu S12023; diode not stated)
    excess_index: Share = 0.3
    transimpedance: PositiveFloat = 5e7  # V/A: 2.65e9 V/W over 53 A/W
    noise_density: NonNegativeFloat = (
        3.5e-15 * 2.65e9
    )  # V/sqrt(Hz) at the output, at every M
    saturation: PositiveFloat = 4.1  # V, largest output: 1.54 nW times 2.65e9 V/W
    bandwidth: PositiveFloat = 1e5  # Hz, -3 dB
    low_pass: PositiveFloat = (
        1e4  # Hz, filter EF120 (Sec. 7.2); one pole (not verified)
    )
    rc_time: PositiveFloat = 20e-6  # s; the paper's 0.1 damps a sweep 47 times
    # Counts rms (T-Series Datasheet, A-3-2-2: table not seen)
    converter_noise: NonNegativeFloat = 1.0
    # Of photons, amplifier and converter; rounding and clipping stay
    noise: bool = True
    # target behind the flip mirror (Sec. 8.2: 60 cm), at its distance with the stage at stage_zero
    reference: Plane = PLATE  # with its grey filter: a bare mirror saturates
    stage_zero: float = 0.025  # m
    scene: Any = None

    @property
    def fibre(self) -> float:
        """Mean transmission of the fibre."""
        return (self.fibre_low + self.fibre_high) / 2

    @property
    def group_index(self) -> float:
        """Group index of the air for the laser's light."""
        return air.group_index(
            wavelength=self.wavelength,
            temperature=self.temperature,
            pressure=self.pressure,
        )

    def as_dict(self) -> Fields:
        """Settings as plain values for JSON."""
        return TypeAdapter(type(self)).dump_python(self, mode="json", fallback=repr)

    @classmethod
    def ideal(cls, **changes: Any) -> "TwinSettings":
        """Build settings without noise, drift, errors, speckle, back-reflection or air."""
        perfect = dict.fromkeys(FLAWS, 0.0) | {
            "mirror_reflectance": 1.0,
            "fibre_low": 0.25,
            "fibre_high": 0.25,
            "transmitted_extinction": np.inf,
            "reflected_extinction": np.inf,
            "noise": False,
            "speckle": False,
        }
        return cls(**perfect | changes)  # pyright: ignore[reportArgumentType]
