"""Ranging by RF demodulation after photo-conversion (Sec. 7.4, Fig. 13, Table 4): a simulated day.

The circuit is `cmtof.ranging.rf_receiver`; here are the light it gets, the offsets that are no
light, the calibration, and what drifts after it.
"""

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.correlation import centred, depth_from_phase, phase_from_depth
from cmtof.instrument import optics as free_space
from cmtof.instrument.drift import Drift
from cmtof.instrument.optics import sent_power
from cmtof.instrument.settings import TwinSettings
from cmtof.modulator import doubled_mode_harmonics, single_mode_harmonics
from cmtof.ranging.optical import FREQUENCY
from cmtof.ranging.rf_receiver import Imbalance, Reading, RfReceiver
from cmtof.ranging.rf_settings import RfParts
from cmtof.ranging.target import StageTarget, collected_power

__all__ = [
    "FREQUENCY",
    "Imbalance",
    "Reading",
    "RfParts",
    "RfRanger",
    "RfReceiver",
    "diode_power",
    "emitting",
    "modulation_depth",
    "seen_share",
]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def modulation_depth(settings: TwinSettings, mode: str = "single") -> float:
    """Amplitude of the emitted light's fundamental over its mean, ``2 |W_k| / W_0``.

    An ideal module at the stated eta: 2 J_1 in the single, 2 J_2 / (1 - J_0) in the doubled mode.

    Examples
    --------
    >>> round(modulation_depth(TwinSettings()), 3)
    1.134
    """
    law = single_mode_harmonics if mode == "single" else doubled_mode_harmonics
    order = 1 if mode == "single" else 2
    harmonics = law(settings.drive.eta, 2)
    return float(2 * abs(harmonics[order]) / harmonics[0].real)


def emitting(settings: TwinSettings, power: float, *, mode: str = "single") -> TwinSettings:
    """Settings with the laser turned to a mean power sent to the scene, W.

    Examples
    --------
    >>> round(sent_power(emitting(TwinSettings(), 0.03)), 6)
    0.03
    """
    laser = settings.laser
    scale = power / sent_power(settings, mode)
    return replace(settings, laser=replace(laser, power=laser.power * scale))


def seen_share(settings: TwinSettings, parts: RfParts, ranges: ArrayLike) -> Array:
    """Share of a diffuse target's collected light that falls on the small photodiode.

    The lens images the Gaussian spot of 1/e^2 radius w at range z as one of angular radius w/z.
    """
    diode, optics = parts.photodiode, settings.optics
    half = optics.field_of_view / 2 * diode.diameter / diode.reference_diameter
    z = np.asarray(ranges, float)
    image = free_space.spot_radius(optics, z) / z
    with np.errstate(divide="ignore"):  # a spot without size is seen whole
        return 1 - np.exp(-2 * (half / image) ** 2)


def diode_power(
    settings: TwinSettings,
    parts: RfParts,
    target: StageTarget,
    ranges: ArrayLike,
    *,
    mode: str = "single",
) -> Array:
    """Mean light on the photodiode, W: `collected_power`, cut by the diode unless specular.

    A mirror's beam is focused to a point (assumed).
    """
    power = collected_power(settings, target, ranges, mode=mode)
    return power if target.material == "specular" else power * seen_share(settings, parts, ranges)


class _Days(NamedTuple):
    """What differs between the days of a sweep: R days, P positions, the calibration first."""

    offset: Complex
    """(R, 1 + P), V at the amplifier's input; column 0 is the calibration."""
    lag: Array
    """(R, 1 + P), drift of the phase between the drivers, rad."""
    laser: Array
    """(R, 1 + P), light over its middle."""
    imbalance: Imbalance
    """(R, 1), during the sweep."""


@dataclass(frozen=True)
class RfRanger:
    """RF demodulation as an instrument: same laser, emission and optics as the all-optical one.

    Calibrated as a lab would do it: the offset is read with the beam blocked, the imbalance from
    a sweep of the phase, a minute before; then both are taken away from every reading. The
    constant phase comes from the same target at the known first position of the sweep. All three
    average over ``calibration_points``. Phases are unwrapped to the wrap of the known range.

    Parameters
    ----------
    settings : TwinSettings
    receiver : RfReceiver
    mode : {"single", "doubled"}
    calibrated : bool
        Whether offset and imbalance are taken away; the first position serves in any case.
    calibration_age : float
        Time from the calibration to the first position, s (assumed).
    step_time : float
        Time from one position to the next, s (assumed).
    stage_error : float
        Standard deviation of a position of the stage, m (Sec. 8.2: 0.05 um).

    Raises
    ------
    ValueError
        For another mode.
    """

    settings: TwinSettings = field(default_factory=TwinSettings)
    receiver: RfReceiver = field(default_factory=RfReceiver)
    mode: str = "single"
    calibrated: bool = True
    calibration_age: float = 60.0
    step_time: float = 1.0
    stage_error: float = 5e-8

    def __post_init__(self) -> None:
        if self.mode not in FREQUENCY:
            raise ValueError(f"Expected mode single or doubled, got {self.mode!r}. Choose one.")

    # --- contract of the ranging instruments -----------------------------------------------------

    def sweep(self, target: StageTarget, positions: ArrayLike, *, repeats: int, seed: int) -> Array:
        """Estimated ranges (repeats, P), m, of a target at positions (P,), m; each repeat a day."""
        ranges = target.distance + np.asarray(positions, float)
        known, first = self.readings(target, positions, repeats=repeats, seed=seed)
        phase = self._phase(ranges) - self._phase(ranges[:1])
        off = centred(known.phase - first.phase - phase)
        return np.asarray(ranges + depth_from_phase(off, self._slope), float)

    def bound(self, target: StageTarget, positions: ArrayLike) -> Array:
        """Cramer-Rao bound (P,), m: noise of one reading at the mean light, nothing else."""
        ranges = target.distance + np.asarray(positions, float)
        power = self._power(target, ranges)
        phase = self.receiver.phase_bound(
            power,
            modulation_depth(self.settings, self.mode),
            frequency=FREQUENCY[self.mode],
            offset=sum(self.receiver.offsets()),
        )
        return np.asarray(depth_from_phase(phase, self._slope), float)

    # --- the day -----------------------------------------------------------------------------

    def readings(
        self, target: StageTarget, positions: ArrayLike, *, repeats: int, seed: int
    ) -> tuple[Reading, Reading]:
        """Phases and amplitudes of a sweep (R, P), and of its first position calibrated (R, 1)."""
        if repeats < 1:
            raise ValueError(f"Expected at least 1 repeat, got {repeats}. Ask for more.")
        rng = np.random.default_rng([seed, 1])
        ranges = target.distance + np.asarray(positions, float)
        days = self._days(seed, repeats, ranges.size)
        power = self._power(target, ranges) * self._speckle(target, ranges, repeats, rng)
        true = ranges + self.stage_error * rng.standard_normal((repeats, ranges.size))
        base, points = self.receiver.parts.baseband, self.receiver.parts.baseband.calibration_points
        blocked = self.receiver.phasor(
            0.0,
            offset=days.offset[:, :1],
            imbalance=self.receiver.imbalance,
            time=points * base.time,
            rng=rng,
        )
        here = slice(1, None)
        swept = self._taken(power, true, days, here, rng, base.time)
        first = self._taken(power[:, :1], true[:, :1], days, slice(1, 2), rng, points * base.time)
        if not self.calibrated:
            return self.receiver.estimate(swept), self.receiver.estimate(first)
        known = {"offset": blocked, "imbalance": self.receiver.imbalance}
        return self.receiver.estimate(swept, **known), self.receiver.estimate(first, **known)

    def _taken(
        self,
        power: Array,
        ranges: Array,
        days: _Days,
        columns: slice,
        rng: np.random.Generator,
        time: float,
    ) -> Complex:
        """Voltages (R, P): target, coaxial back-reflection and offsets, with noise."""
        depth, frequency = modulation_depth(self.settings, self.mode), FREQUENCY[self.mode]
        optics, laser, lag = self.settings.optics, days.laser[:, columns], days.lag[:, columns]
        back = sent_power(self.settings, self.mode) * free_space.inward(optics)
        phase = self._phase(np.array(optics.back_range))
        stray = self.receiver.envelope(
            back * optics.back_fraction * laser, depth, phase + lag, frequency=frequency
        )
        return self.receiver.phasor(
            power * laser,
            depth,
            self._phase(ranges) + lag,
            frequency=frequency,
            offset=stray + days.offset[:, columns],
            imbalance=days.imbalance,
            time=time,
            rng=rng,
        )

    def _days(self, seed: int, repeats: int, positions: int) -> _Days:
        times = np.append(0.0, self.calibration_age + self.step_time * np.arange(positions))
        parts, laser = self.receiver.parts, self.settings.laser
        middle = (laser.fibre_low + laser.fibre_high) / 2
        swing = (laser.fibre_high - laser.fibre_low) / 2
        offset, lag, light, skew = [], [], [], []
        for repeat in range(repeats):
            rng = np.random.default_rng([seed, 0, repeat])
            key = int(rng.integers(2**62))
            slow = [Drift(key, channel)(times) / Drift.RMS for channel in range(4)]
            turns = np.exp(2j * np.pi * rng.random(2))
            still = np.dot(self.receiver.offsets(), turns)
            offset.append(still * (1 + parts.pickup.drift * (slow[0] + 1j * slow[1])))
            lag.append(self.settings.drive.phase_drift * slow[2])
            light.append((middle + swing * Drift.RMS * slow[3]) / middle)
            skew.append(parts.pickup.imbalance_drift * rng.standard_normal(2))
        gain, error = np.array(skew).T[..., None]
        mixer = parts.mixer
        drifted = Imbalance.of(
            10 ** (mixer.amplitude_imbalance / 20) * (1 + gain), mixer.phase_imbalance + error
        )
        return _Days(np.array(offset), np.array(lag), np.array(light), drifted)

    def _speckle(
        self, target: StageTarget, ranges: Array, repeats: int, rng: np.random.Generator
    ) -> Array:
        """Factors (R, P) of mean 1: another pattern at each position, as in the simulated rig."""
        shape = (repeats, ranges.size)
        if not self.settings.optics.speckle or target.material == "specular":
            return np.ones(shape)
        cells = free_space.speckle_cells(
            self.settings.optics, self.settings.laser.wavelength, ranges
        )
        return rng.gamma(cells, 1 / cells, shape)

    def _power(self, target: StageTarget, ranges: Array) -> Array:
        return diode_power(self.settings, self.receiver.parts, target, ranges, mode=self.mode)

    @property
    def _slope(self) -> float:
        """Frequency that turns phase into range in air, Hz."""
        index = free_space.group_index(self.settings.air, self.settings.laser.wavelength)
        return FREQUENCY[self.mode] * index

    def _phase(self, ranges: Array) -> Array:
        return np.asarray(phase_from_depth(ranges, self._slope), float)
