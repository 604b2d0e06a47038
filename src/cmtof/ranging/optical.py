r"""The all-optical instrument as a range finder: the twin's physics, many days and places at once.

Nothing is modelled here a second time: each repeat is one `cmtof.instrument.world.World`, with
its own noise, drift, errors of the phase codes and speckle, before the target on the stage. A
reading is one burst of 16 phases x 20 samples at 24 kS/s (13.3 ms); its decoded phase is

.. math:: \phi = 4\pi f (n_g z + z_{in})/c + \phi_0,

and a calibration takes the constants away. Ranges are unwrapped to the wrap of the known range.
"""

from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import (
    FREQUENCY_DOUBLED,
    FREQUENCY_SINGLE,
    HALF_WAVE_PLATE_DOUBLED,
    HALF_WAVE_PLATE_SINGLE,
)
from cmtof.correlation import centred, decode, decoding_weights, depth_from_phase, phase_from_depth
from cmtof.hardware.reduction import drive_phases, nominal_psi
from cmtof.instrument.electronics import chain, slope
from cmtof.instrument.light import Panel, RfKnobs
from cmtof.instrument.optics import group_index
from cmtof.instrument.parsing import check_fields, choice, number
from cmtof.instrument.settings import Air, TwinSettings
from cmtof.instrument.world import LABEL_TIME, World
from cmtof.ranging.burst_noise import mean_weights, phase_covariance
from cmtof.ranging.target import StageTarget

Array = NDArray[np.float64]

FREQUENCY = {"single": FREQUENCY_SINGLE, "doubled": FREQUENCY_DOUBLED}
"""Modulation frequency of each mode, Hz."""

_PLATE = {"single": HALF_WAVE_PLATE_SINGLE, "doubled": HALF_WAVE_PLATE_DOUBLED}
_ORDER = {"single": 1, "doubled": 2}


@dataclass(frozen=True)
class OpticalRanger:
    """All-optical correlation against a target on the stage (Sec. 7, 8.2).

    Parameters
    ----------
    settings : TwinSettings
        Laser, modulators, drives, optics, air, detector; single terms are switched off here.
    mode : {"single", "doubled"}
        7.15 or 14.32 GHz.

    Examples
    --------
    >>> ranger = OpticalRanger(TwinSettings.ideal())
    >>> error = ranger.sweep(StageTarget(), [0.0, 1e-3], repeats=1, seed=0) - [[0.6, 0.601]]
    >>> bool((abs(error) < 2e-6).all())
    True
    """

    settings: TwinSettings = field(default_factory=TwinSettings)
    mode: str = choice("single", ("single", "doubled"))
    _: KW_ONLY
    phases: int = number(16, 3, 4096)  # type: ignore[assignment]
    """Steps of the reference phase (Sec. 7.2)."""
    samples: int = number(20, 1, 4096)  # type: ignore[assignment]
    """Samples of each phase (Sec. 7.2)."""
    settle: int = number(4, 0, 4095)  # type: ignore[assignment]
    """Samples of each phase that are dropped while the filters settle, as in the default rig."""
    rate: float = number(24000.0, 1)
    """Samples a second, Hz (Sec. 7.2)."""
    calibration: str = choice("reading", ("reading", "perfect"))
    """"reading": the constant phase is that of an earlier reading of the same target at a known
    range, itself noisy. "perfect": that of the instrument without any error, so that every
    systematic error stays whole."""
    calibration_readings: int = number(1, 1, 10**4)  # type: ignore[assignment]
    """Bursts that the calibration averages."""
    reference_offset: float = number(0.0, -1, 1)
    """Stage position of that reading, m; 0 is the first of Fig. 13's sweep."""
    calibration_age: float = number(60.0, 0.02)
    """Time from that reading to the first of the sweep, s (assumed)."""
    step_time: float = number(1.0, 0.02)
    """Time from one stage position to the next, s (assumed: 2.4 mm/s and a turn of 1 mm)."""
    air: str = choice("corrected", ("corrected", "ignored"))
    """Whether the lab divides by a group index, from its thermometer and barometer, or by 1."""
    temperature_error: float = number(0.5, 0)
    """Standard deviation of the thermometer's error, K (assumed)."""
    pressure_error: float = number(100.0, 0)
    """Standard deviation of the barometer's error, Pa (assumed)."""
    stage_error: float = number(5e-8, 0)
    """Standard deviation of a position of the stage, m (Sec. 8.2: 0.05 um)."""
    level: float = number(0.5, 0.01, 1)
    """Share of the detector's largest output that the brightest sample may reach: a grey filter
    before the detector, chosen for that, lets no more pass (assumed)."""

    def __post_init__(self) -> None:
        check_fields(type(self), vars(self), "all-optical ranger")
        if self.settle >= self.samples:
            raise ValueError(
                f"Expected fewer than {self.samples} samples of a phase to be dropped, got "
                f"{self.settle}. Lower `settle`."
            )

    # --- forward: what the converter reads -------------------------------------------------------

    def panel(self) -> Panel:
        """Knobs of the instrument while it ranges: mode set, table armed, target in the beam."""
        drive = {"on": True, "frequency": self.frequency / _ORDER[self.mode]}
        table = drive_phases(self.phases, self.mode)
        turned = np.deg2rad(_PLATE[self.mode])
        modules = self.settings.emission, self.settings.detection
        return Panel(
            emission=RfKnobs(**drive, power=self.settings.drive.power),
            detection=RfKnobs(**drive, power=self.settings.drive.power, table=table),
            plate_angle=[float(turned + module.plate_zero) for module in modules],
            laser_on=True,
            shutter_open=True,
            flip_mirror_in=True,
            clock_on=True,
        )

    def world(self, target: StageTarget, seed: int) -> World:
        """One instrument before the target, behind the grey filter that the target needs."""
        return World(self.before(target), seed=seed)

    def counts(
        self, world: World, panel: Panel, positions: ArrayLike, labels: ArrayLike
    ) -> NDArray[np.uint16]:
        """Raw counts (P, phases x samples) at stage positions, m from the target's distance.

        Parameters
        ----------
        world : World
        panel : Panel
        positions : array_like, shape (P,)
        labels : array_like, shape (P,)
            Numbers of the bursts: they begin at ``label * LABEL_TIME``.
        """
        offsets = np.asarray(positions, float)
        return world.bursts(
            panel,
            np.zeros((offsets.size, 2)),
            labels=labels,
            scans=self.phases * self.samples,
            rate=self.rate,
            pulses=self._pulses,
            stage=offsets + world.settings.reference.stage_zero,
        )

    def phase(self, counts: ArrayLike) -> Array:
        """Wrapped phases (P,), rad, of raw counts (P, phases x samples)."""
        means = self._weights @ np.asarray(counts, float).T
        return np.asarray(decode(means, nominal_psi(self.phases)).phase, float)

    # --- inverse: ranges -------------------------------------------------------------------------

    def sweep(self, target: StageTarget, positions: ArrayLike, *, repeats: int, seed: int) -> Array:
        """Estimated ranges (repeats, P), m, at stage positions (P,), m from the target's distance.

        Each repeat is another instrument on another day.

        Raises
        ------
        ValueError
            For no position or no repeat.
        """
        offsets = _checked(positions, repeats)
        first = self.calibration_readings
        later = np.arange(offsets.size) * self.step_time + self.calibration_age
        labels = np.append(np.arange(first), first - 1 + np.rint(later / LABEL_TIME)).astype(int)
        stated = np.append(np.full(first, self.reference_offset), offsets)
        panel, constant, settings = self.panel(), self._constant(target), self.before(target)
        ranges = np.empty((repeats, offsets.size))
        for repeat in range(repeats):
            rng = np.random.default_rng((seed, repeat))
            world = World(settings, seed=int(rng.integers(2**63)))
            index = self.stated_index(*rng.standard_normal(2))
            at = stated + self.stage_error * rng.standard_normal(stated.size)
            phase = self.phase(self.counts(world, panel, at, labels + 1))
            expected = phase_from_depth(index * (target.distance + stated), self.frequency)
            error = phase - expected  # of every reading, the constant of the instrument in it
            read = np.angle(np.exp(1j * error[:first]).mean())
            known = read if self.calibration == "reading" else constant
            off = depth_from_phase(centred(error[first:] - known), self.frequency)
            ranges[repeat] = target.distance + offsets + off / index
        return ranges

    def bound(self, target: StageTarget, positions: ArrayLike) -> Array:
        """Cramer-Rao bound on one estimate (P,), m: least standard deviation by noise alone.

        Of all that reads the fundamental of the phase means of a burst without knowing amplitude,
        offset and harmonics of the correlation. As many unknowns as phases leave one unbiased
        estimate, the Fourier coefficient (Eq. 9), and its variance *is* the bound. Noise is that
        of light, amplifier, converter and rounding, correlated by the filters; the mean power
        stands for every speckle, and the calibration's own reading counts.
        """
        offsets = _checked(positions, 1)
        stated = np.append(self.reference_offset, offsets)
        variance = self._phase_variance(target, stated)
        own = variance[0] / self.calibration_readings if self.calibration == "reading" else 0.0
        return np.asarray(depth_from_phase(np.sqrt(variance[1:] + own), self.frequency), float)

    def stated_index(self, thermometer: float, barometer: float) -> float:
        """Group index that the lab divides by; its instruments err by so many standard deviations.

        Without air, or without correction, it is 1.
        """
        air = self.settings.air
        if self.air == "ignored" or air.pressure == 0:
            return 1.0
        read = Air(
            temperature=air.temperature + thermometer * self.temperature_error,
            pressure=air.pressure + barometer * self.pressure_error,
        )
        return group_index(read, self.settings.laser.wavelength)

    # --- parts -----------------------------------------------------------------------------------

    @property
    def frequency(self) -> float:
        """Modulation frequency, Hz."""
        return FREQUENCY[self.mode]

    def grey_filter(self, target: StageTarget) -> float:
        """Transmission of the grey filter that keeps the detector within its range; 1 for none."""
        world = World(_on_stage(without_errors(self.settings), target))
        volts = self._light(world, np.array([self.reference_offset])).max()
        volts = volts * world.conversion.volts_per_watt
        return float(min(1.0, self.level * self.settings.detector.saturation / volts))

    def before(self, target: StageTarget, *, errors: bool = True) -> TwinSettings:
        """Settings with the target on the stage and the grey filter before the detector.

        The filter thins out photons as a lower quantum efficiency does. ``errors`` False is
        `without_errors`.
        """
        settings = self.settings if errors else without_errors(self.settings)
        efficiency = settings.detector.efficiency * self.grey_filter(target)
        dimmed = replace(settings, detector=replace(settings.detector, efficiency=efficiency))
        return _on_stage(dimmed, target)

    def _light(self, world: World, positions: Array) -> Array:
        """Light (P, T), W, on the detector in a burst's samples."""
        panel = self.panel()
        setting = world.light.configuration(panel, self._pulses, self.rate)
        angles, starts = np.zeros((positions.size, 2)), np.zeros(positions.size)
        stage = positions + world.settings.reference.stage_zero
        light = world.light.on_detector(panel, angles, starts, setting, stage)
        return light[:, setting.of_sample]

    def _phase_variance(self, target: StageTarget, positions: Array) -> Array:
        """Variance (P,), rad^2, of the phase decoded from one burst."""
        plain = self.before(target, errors=False)
        world = World(plain)
        detector, per_count = plain.detector, slope(10.0)
        volts = world.conversion.volts(self._light(world, positions))
        density, filters = world.conversion.density(volts), chain(detector, 1 / self.rate)
        means = filters.run(volts, density, None) @ self._weights.T
        covariance = phase_covariance(filters, density, self._weights)
        rounding = 4.0 ** (16 - detector.bits) / 12
        converter = (detector.converter_noise**2 + rounding) * per_count**2
        kept = self.samples - self.settle
        covariance = covariance + converter / kept * np.eye(self.phases)
        psi = nominal_psi(self.phases)
        found, weights = decode(means.T, psi), decoding_weights(psi)
        # phi = atan2(y, x), so d phi = (cos(phi) dy - sin(phi) dx) / a
        slope_x, slope_y = -np.sin(found.phase), np.cos(found.phase)
        along = np.outer(slope_x, weights[1]) + np.outer(slope_y, weights[2])
        return np.einsum("pk,pkj,pj->p", along, covariance, along) / found.amplitude**2

    def _constant(self, target: StageTarget) -> float:
        """Phase, rad, of an instrument without errors beyond that of the range."""
        if self.calibration == "reading":
            return 0.0
        world = World(self.before(target, errors=False))
        volts = world.conversion.volts(self._light(world, np.zeros(1)))
        found = decode(self._weights @ volts.T, nominal_psi(self.phases))
        optical = world.light.group_index * target.distance
        return float(found.phase[0] - phase_from_depth(optical, self.frequency))

    @cached_property
    def _pulses(self) -> NDArray[np.intp]:
        return np.arange(self.phases * self.samples) // self.samples

    @cached_property
    def _weights(self) -> Array:
        return mean_weights(self.phases, self.samples, self.settle)


def without_errors(settings: TwinSettings) -> TwinSettings:
    """Settings with the same light, air and detector, but no noise, drift, stray light or errors.

    What stays is what a lab knows of its instrument: powers, drive, geometry, the cable's phase.
    """
    middle = (settings.laser.fibre_low + settings.laser.fibre_high) / 2
    errors = ("phase_drift", "phase_step_error", "iq_imbalance", "leakage")
    return replace(
        settings,
        noise=False,
        laser=replace(settings.laser, fibre_low=middle, fibre_high=middle),
        drive=replace(settings.drive, **dict.fromkeys(errors, 0.0)),
        optics=replace(settings.optics, speckle=False, back_fraction=0.0),
    )


def _on_stage(settings: TwinSettings, target: StageTarget) -> TwinSettings:
    reference = replace(
        settings.reference,
        distance=target.distance,
        material=target.material,
        reflectance=target.reflectance,
    )
    return replace(settings, reference=reference)


def _checked(positions: ArrayLike, repeats: int) -> Array:
    offsets = np.asarray(positions, float)
    if offsets.ndim != 1 or not offsets.size or not np.isfinite(offsets).all():
        raise ValueError(
            f"Expected finite stage positions (P,), m, got shape {offsets.shape}. "
            "Give at least one."
        )
    if repeats < 1:
        raise ValueError(f"Expected at least 1 repeat, got {repeats}. Ask for more.")
    return offsets
