"""Parts of the RF demodulator after photo-conversion (Sec. 7.4), every number with its source.

SI units; decibels where data sheets use them. *Known*: from general knowledge of the part, not
verified. *Assumed*: the paper does not say; a number that such a part could have. The paper names
the photodiode only, the rest of the circuit stands in a supplement that was not seen; here it
consists of catalogue parts. Nothing was tuned to the paper's results.
"""

from dataclasses import dataclass, field

from cmtof.instrument.parsing import check_fields, number
from cmtof.instrument.world import FAST_BANDWIDTH


class _Checked:
    def __post_init__(self) -> None:
        check_fields(type(self), vars(self), f"RF {type(self).__name__}")


@dataclass(frozen=True, kw_only=True)
class Photodiode(_Checked):
    """GaAs PIN detector EOT ET-4000, unamplified (Sec. 7.4)."""

    responsivity: float = number(0.2, 0, 1)
    """A/W at 532 nm (assumed: quantum efficiency 0.47, as GaAs has off its peak near 850 nm)."""
    bandwidth: float = number(FAST_BANDWIDTH, 1)
    """-3 dB, Hz, first order (Sec. 7.4: 12 GHz)."""
    dark_current: float = number(0.5e-9, 0)
    """A (known; no matter, thermal noise is a million times stronger)."""
    diameter: float = number(60e-6, 1e-7, 0.1)
    """Diameter of the active area, m (known). The whole image of the spot does not fit on it."""
    reference_diameter: float = number(1e-3, 1e-6, 0.1)
    """Detector, m, that sees the optics' ``field_of_view``: the APD440A behind the same lens."""
    load: float = number(50.0, 1)
    """Ohm; the whole current goes into it, no termination inside (assumed)."""


@dataclass(frozen=True, kw_only=True)
class Amplifier(_Checked):
    """Amplifier and band-pass filter: the class of a Mini-Circuits ZVA-183+."""

    gain: float = number(26.0, -20, 80)
    """dB (known)."""
    noise_figure: float = number(3.0, 0, 20)
    """dB (known)."""
    filter_loss: float = number(1.5, 0, 20)
    """Band-pass behind it, dB (assumed). It keeps harmonics from the mixer, no noise: the low-pass
    after the mixer is 100 million times narrower."""
    return_loss: float = number(10.0, 0, 60)
    """Of both together as the mixer sees them, dB (assumed)."""
    temperature: float = number(290.0, 0, 400)
    """K, at which noise figures are stated."""


@dataclass(frozen=True, kw_only=True)
class Mixer(_Checked):
    """Passive I/Q mixer, Analog Devices HMC8193 (data sheet Rev. B, 2.5 to 8.5 GHz, typical).

    At 14.32 GHz another part would be needed; the same numbers are taken there.
    """

    conversion_loss: float = number(9.0, 0, 40)
    """dB (data sheet)."""
    noise_figure: float = number(11.5, 0, 40)
    """dB (data sheet, single sideband)."""
    amplitude_imbalance: float = number(0.5, -3, 3)
    """Q over I, dB (data sheet: amplitude balance)."""
    phase_imbalance: float = number(0.08726646, -0.8, 0.8)
    """Q's error of its 90 degrees, rad (data sheet: phase balance 5 degrees)."""
    lo_power: float = number(18.0, -30, 40)
    """Drive of the local oscillator, dBm (known for this class)."""
    lo_isolation: float = number(48.0, 0, 120)
    """LO to RF port, dB (data sheet). What passes comes back from the filter and mixes with the LO
    to direct current: self-mixing."""
    compression: float = number(13.0, -30, 60)
    """Input at 1 dB of compression, dBm (data sheet). Not modelled: a lab pads strong light."""


@dataclass(frozen=True, kw_only=True)
class Pickup(_Checked):
    """What reaches I and Q without having been light, and how long it stays the same."""

    drive_power: float = number(30.0, -30, 60)
    """Drive of the crystal, dBm (assumed, as for the simulated instrument)."""
    isolation: float = number(100.0, 0, 250)
    """From the drive into the photodiode's cable, dB (assumed: shielded well)."""
    drift: float = number(1e-3, 0, 1)
    """Slow relative drift of all offsets, rms (assumed: 0.1 % of the LO's amplitude, of isolation
    or, as a phase, 7 um of cable)."""
    imbalance_drift: float = number(1e-3, 0, 1)
    """Change of the imbalances since they were calibrated, relative and rad, rms (assumed)."""


@dataclass(frozen=True, kw_only=True)
class Baseband(_Checked):
    """Low-pass, amplifier and converter, and the time they average over."""

    gain: float = number(100.0, 1e-3, 1e6)
    """Largest, V/V (assumed); turned down for what would not fit into the converter."""
    noise_density: float = number(5e-9, 0)
    """At its input, V/sqrt(Hz) (assumed: a low-noise operational amplifier)."""
    time: float = number(320 / 24000, 1e-9, 1e4)
    """Integration for a point, s: the 13.3 ms of the all-optical instrument (Sec. 7.2)."""
    rate: float = number(24000.0, 1)
    """Samples a second of each quadrature, Hz (Sec. 7.2)."""
    converter_noise: float = number(1.0, 0, 1e4)
    """LabJack T7, counts of 16 bit, rms, as in the simulated instrument."""
    least_range: float = number(0.01, 1e-6, 10)
    """Its most sensitive range, V (T-Series Datasheet, AIN#_RANGE)."""
    calibration_points: int = number(100, 1, 10**6)  # type: ignore[assignment]
    """Points averaged for each calibration (assumed)."""


@dataclass(frozen=True, kw_only=True)
class RfParts:
    """The whole circuit.

    Examples
    --------
    >>> RfParts(mixer=Mixer(conversion_loss=-1))
    Traceback (most recent call last):
        ...
    ValueError: Expected RF Mixer.conversion_loss from 0 to 40, got -1. Keep to SI units.
    """

    photodiode: Photodiode = field(default_factory=Photodiode)
    amplifier: Amplifier = field(default_factory=Amplifier)
    mixer: Mixer = field(default_factory=Mixer)
    pickup: Pickup = field(default_factory=Pickup)
    baseband: Baseband = field(default_factory=Baseband)

    @classmethod
    def ideal(cls, **changes: object) -> "RfParts":
        """Build a circuit that has its noise and no other fault."""
        parts: dict[str, object] = {
            "mixer": Mixer(amplitude_imbalance=0.0, phase_imbalance=0.0, lo_power=-30.0,
                           lo_isolation=120.0),
            "pickup": Pickup(drive_power=-30.0, isolation=250.0, drift=0.0, imbalance_drift=0.0),
        }  # fmt: skip
        return cls(**(parts | changes))  # type: ignore[arg-type]
