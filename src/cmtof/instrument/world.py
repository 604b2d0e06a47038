r"""The simulated instrument before a scene: its knobs, the light on its detector, its counts.

With the Fourier coefficients :math:`W_k` of the emission's and :math:`R_k` of the detection's
waveform, drives :math:`\eta\sin(\omega t-\varphi)` and paths of the shares p and round trips tau,

.. math:: C = \sum_m p_m\,\Big[W_0R_0 + 2\,\mathrm{Re}\sum_{k\ge1}W_kR_k^*\,
          e^{ik(\varphi_d-\varphi_e-\omega\tau_m)}\Big].

Its fundamental is :math:`\cos(\phi+\psi)`, :math:`\phi = 4\pi f n_g z/c` at the frequency f of the
*modulation*, with psi = -phi_d + const in the single and -2 phi_d + const in the doubled mode.

Time is virtual. Burst number n starts at ``n * 20 ms``, and its noise depends on (seed, n, sample)
only. The mirrors rest and the filters have settled when a burst begins. Optical angles: the beam
leaves along (tan x, tan y, 1), y downwards. The laser's fast noise is not modelled, its drift is.
"""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.random import Generator, Philox
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.instrument import optics as free_space
from cmtof.instrument.electronics import POLES, Conversion, chain, counts_from_volts
from cmtof.instrument.settings import Drive, Module, TwinSettings
from cmtof.instrument.targets import Plane, scene_from
from cmtof.modulator import TwoPassModulator

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.integer]

LABEL_TIME = 0.02
"""Virtual time from one burst to the next, s: 13.3 ms and its dialogue."""
SAMPLE_RATE = 24000.0
"""Samples a second, Hz (Sec. 7.2)."""
VOLTS_PER_DEGREE = 0.5
"""Scan mirrors GVS012, V per mechanical degree (its manual)."""
HARMONICS = 16
"""Highest harmonic of the drive that is kept: J_16(2 eta) < 1e-12 up to eta = 1.5."""
CODES = 65536
"""Phase codes of an RF driver in a turn."""
DRIFT_OCTAVES = 1e-3 * 2.0 ** np.arange(10)
"""Frequencies of a drift, Hz, from 1 mHz to 0.5 Hz."""
DRIFT_RMS = float(1 / np.sqrt(2 * DRIFT_OCTAVES.size))

_ROWS = 512  # directions computed at a time, to stay within the processor's caches


def keyed_generator(seed: int, purpose: int, key: int = 0) -> Generator:
    """Philox generator whose numbers depend on the arguments alone (Salmon et al., SC 2011)."""
    words = np.array([seed & (2**64 - 1), purpose], np.uint64)
    return Generator(Philox(key=words, counter=np.array([0, key & (2**64 - 1), 0, 0], np.uint64)))


LABEL, DRIFT, CODE = 1, 5, 6  # purposes


def drift(seed: int, channel: int, time: ArrayLike) -> Array:
    """Drift in [-1, 1] at times (...), s, 1/f in spectrum: ten equal sinusoids, one an octave."""
    rng = keyed_generator(seed, DRIFT, channel)
    # off the exact octaves, or the sum would be periodic
    rate = 2 * np.pi * DRIFT_OCTAVES * rng.uniform(0.9, 1.1, DRIFT_OCTAVES.size)
    angle = np.multiply.outer(np.asarray(time, float), rate)
    return np.sin(angle + rng.uniform(0, 2 * np.pi, rate.size)).sum(-1) / rate.size


@dataclass
class RfKnobs:
    """One RF driver: Hz, dBm, rad, and the phases (K,), rad, that a trigger steps through."""

    on: bool = False
    frequency: float = 7.15e9
    power: float = 0.0
    phase: float = 0.0
    table: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

    def phases(self, edges: Integers) -> Array:
        """Drive phases (S,), rad, behind trigger edges (S,) numbered from 0; -1 is before them."""
        table = self.table if len(self.table) else np.array([self.phase])
        return np.asarray(table, float)[edges % len(table)]


@dataclass
class Panel:
    """Every knob of the instrument: rad, V, m; the flip mirror leads to the reference target."""

    emission: RfKnobs = field(default_factory=RfKnobs)
    detection: RfKnobs = field(default_factory=RfKnobs)
    plate_emission: float = 0.0
    plate_detection: float = 0.0
    stage: float = 0.0
    galvo_volts: list[float] = field(default_factory=lambda: [0.0, 0.0])
    laser_on: bool = False
    shutter_open: bool = False
    flip_mirror_in: bool = False
    beam_block_in: bool = True
    interlock_closed: bool = True
    clock_on: bool = False
    time: float = 0.0  # virtual, s


class World:
    """One instrument before a scene as `scene_from` takes it, by default that of the settings."""

    def __init__(self, settings: TwinSettings, scene: Any = None, *, seed: int = 0) -> None:
        self.settings, self.seed = settings, int(seed)
        self.scene = scene_from(settings.scene if scene is None else scene)
        self.conversion = Conversion(settings.detector, settings.laser.wavelength)
        self.group_index = free_space.group_index(settings.air, settings.laser.wavelength)

    def bursts(
        self,
        panel: Panel,
        angles: ArrayLike,
        *,
        labels: ArrayLike | None = None,
        scans: int = 320,
        rate: float = SAMPLE_RATE,
        pulses: ArrayLike | None = None,
        stage: ArrayLike | None = None,
    ) -> NDArray[np.uint16]:
        """Raw stream counts (N, scans) of the detector, a burst for each of N directions.

        ``angles`` (N, 2) are optical, rad, and ``stage`` (N,), m, positions of the target on the
        stage: the panel's galvo and time do not count. ``labels`` (N,) number the bursts,
        ``pulses`` (scans,) the trigger's last edge at each sample, at ``rate``, Hz.
        """
        points = np.asarray(angles, float).reshape(-1, 2)
        numbers = np.arange(1, len(points) + 1) if labels is None else np.asarray(labels, int)
        edges = np.full(scans, -1) if pulses is None else np.asarray(pulses, int)
        places = np.broadcast_to(panel.stage if stage is None else np.asarray(stage), len(points))
        # the drives are constant in stretches between edges
        first = np.flatnonzero(np.diff(edges, prepend=edges[0] - 1))
        length = np.diff(first, append=scans)
        middle = (first + length / 2) / rate
        modules = self._waveforms(panel, edges[first])
        counts = np.empty((len(points), scans), np.uint16)
        for start in range(0, len(points), _ROWS):
            rows = slice(start, start + _ROWS)
            paths = self.paths(panel, points[rows], places[rows])
            times = LABEL_TIME * numbers[rows, None] + middle
            volts = self.conversion.volts(self._light(panel, paths, times, *modules))
            held = np.repeat(volts, length, axis=1)
            counts[rows] = self._read_out(held, numbers[rows], rate)
        return counts

    def paths(self, panel: Panel, angles: Array, stage: Array) -> free_space.Paths:
        """Ways to the scene at optical angles (N, 2), rad, or to the target at stages (N,), m."""
        if panel.flip_mirror_in:
            places, which = np.unique(stage, return_inverse=True)
            each = zip(*(self._to_stage(float(place)) for place in places), strict=True)
            return free_space.Paths(*(np.concatenate(parts)[which] for parts in each))
        if self.scene is None:
            return free_space.Paths(*np.zeros((2, len(angles), 1)))
        return free_space.trace(self.scene, angles, self.settings, self.seed)

    def _to_stage(self, position: float) -> free_space.Paths:
        """Ways (1, M) to the reference target; the beam stands still behind the flip mirror."""
        held = self.settings.reference
        distance = held.distance + position - held.stage_zero
        target = Plane(distance, reflectance=held.reflectance, material=held.material)
        # another 10 um of stage, another speckle
        seed = self.seed + 1 + round(position / 1e-5)
        return free_space.trace(target, np.zeros((1, 2)), self.settings, seed)

    def _light(
        self,
        panel: Panel,
        paths: free_space.Paths,
        times: Array,
        emission: Complex,
        detection: Complex,
    ) -> Array:
        """Light on the detector (N, S), W, at times (N, S), s, with both modules (S, K + 1)."""
        optics, products = self.settings.optics, 2 * emission * np.conj(detection)
        if not panel.clock_on or panel.emission.frequency != panel.detection.frequency:
            products[:, 1:] = 0.0
        back = optics.back_range, optics.back_fraction
        reach, fraction = (
            np.pad(one, ((0, 0), (0, 1)), constant_values=stray)
            for one, stray in zip(paths, back, strict=True)
        )
        way = self.group_index * reach + optics.internal_path
        phase = 4 * np.pi * panel.emission.frequency / SPEED_OF_LIGHT * way
        lag = self.settings.drive.phase_drift / DRIFT_RMS * drift(self.seed, 1, times)
        share = products[:, 0].real / 2 * fraction.sum(1, keepdims=True)
        size = np.abs(products).max(axis=0)
        for order in range(1, HARMONICS + 1):
            if size[order] > 1e-13 * size[0]:
                phasor = (fraction * np.exp(-1j * order * phase)).sum(1, keepdims=True)
                share = share + (products[:, order] * phasor * np.exp(1j * order * lag)).real
        loss = free_space.outward(optics) * free_space.inward(optics)
        room = free_space.ambient(optics) * detection[:, 0].real
        return self.from_fibre(panel, times) * loss * np.maximum(share, 0.0) + room

    def _read_out(self, volts: Array, labels: NDArray, rate: float) -> NDArray[np.uint16]:
        """Counts (N, T) of held detector outputs (N, T), V: noise, filters, converter."""
        detector, samples = self.settings.detector, volts.shape[1]
        filters, density = chain(detector, 1 / rate), self.conversion.density(volts)
        if not self.settings.noise:
            return counts_from_volts(filters.run(volts, density, None), detector)
        # a row: the filters' initial state, then for each sample the filters' noise and the ADC's
        size = POLES + (POLES + 1) * samples
        drawn = np.stack(
            [keyed_generator(self.seed, LABEL, int(n)).standard_normal(size) for n in labels]
        )
        by_sample = drawn[:, POLES:].reshape(-1, samples, POLES + 1)
        normals = np.concatenate([drawn[:, None, :POLES], by_sample[..., :POLES]], axis=1)
        output = filters.run(volts, density, normals)
        output = np.clip(output, -detector.saturation, detector.saturation)
        return counts_from_volts(output, detector, normals=by_sample[..., POLES])

    def emission(self, panel: Panel) -> Complex:
        """Fourier coefficients (K + 1,) of the emission module's waveform as it stands."""
        return self._waveforms(panel, np.full(1, -1))[0][0]

    def _waveforms(self, panel: Panel, edges: Integers) -> tuple[Complex, Complex]:
        """Fourier coefficients (S, K + 1) of emission and detection, phases of drive included."""
        drive, knobs = self.settings.drive, (panel.emission, panel.detection)
        made = []
        for number, one in enumerate(knobs):
            phase = self._made_phase(number, one.phases(edges)) + number * drive.phase_offset
            size = amplitude(drive, one.power, one.frequency) if one.on else 0.0
            made.append(size * np.exp(-1j * phase))
        leak = drive.leakage * np.exp(-1j * drive.leakage_phase)
        if panel.clock_on:  # what leaks at another frequency averages out
            made = [made[0] + leak * made[1], made[1] + leak * made[0]]
        modules = (self.settings.emission, self.settings.detection)
        plates, found = (panel.plate_emission, panel.plate_detection), []
        for module, one, angle, phasor in zip(modules, knobs, plates, made, strict=True):
            eta = np.abs(phasor).tolist()
            waves = np.stack([_harmonics(module, angle, one.frequency, size) for size in eta])
            turn = np.exp(1j * np.angle(phasor))[:, None] ** np.arange(HARMONICS + 1)
            found.append(waves * turn)
        return found[0], found[1]

    def _made_phase(self, module: int, phase: Array) -> Array:
        """Phase, rad, that driver 0 or 1 really makes of one that was set."""
        drive = self.settings.drive
        code = np.rint(phase * (CODES / (2 * np.pi))).astype(int) % CODES
        error = drive.phase_step_error * _code_errors(self.seed, module)[code]
        return phase + error + drive.iq_imbalance * np.sin(2 * phase)

    def from_fibre(self, panel: Panel, times: Array) -> Array:
        """Power behind the fibre at times, W; 0 unless laser, shutter and interlock let it pass."""
        laser = self.settings.laser
        if not (panel.laser_on and panel.shutter_open and panel.interlock_closed):
            return np.zeros(np.shape(times))
        middle = (laser.fibre_low + laser.fibre_high) / 2
        swing = (laser.fibre_high - laser.fibre_low) / 2
        return laser.power * (middle + swing * drift(self.seed, 0, times))

    def angles(self, panel: Panel) -> Array:
        """Optical angles (2,), rad, of the panel's galvo; twice the mechanical ones."""
        return np.deg2rad(2 * np.array(panel.galvo_volts) / VOLTS_PER_DEGREE)

    def ranges(self, angles: ArrayLike) -> Array:
        """True ranges (N,), m, of the scene at optical angles (N, 2), rad; NaN for nothing."""
        points = np.asarray(angles, float).reshape(-1, 2)
        if self.scene is None:
            return np.full(len(points), np.nan)
        return self.scene.look(free_space.directions_from_angles(points)).range

    def laser_power(self, panel: Panel) -> float:
        """Power that the integrating sphere behind the first beam splitter sees, W (Sec. 7.1)."""
        power = self.from_fibre(panel, np.array(panel.time)) * self.emission(panel)[0].real
        optics = self.settings.optics
        return float(power * (optics.lens**2 * optics.mirror * optics.splitter))


def amplitude(drive: Drive, power: float, frequency: float) -> complex:
    """Complex drive amplitude, rad; a resonance of width G passes ``1 / (1 + 2i d / G)`` at d."""
    stated = abs(1 / (1 + 2j * drive.detuning / drive.width))
    passed = 1 / (1 + 2j * (frequency - drive.resonance) / drive.width)
    return drive.eta * 10 ** ((power - drive.power) / 20) * passed / stated


@lru_cache(maxsize=64)
def _code_errors(seed: int, module: int) -> Array:
    """Standard normal error (65536,) of each phase code of a driver."""
    return keyed_generator(seed, CODE, module).standard_normal(CODES)


@lru_cache(maxsize=4096)
def _harmonics(module: Module, plate_angle: float, frequency: float, eta: float) -> Complex:
    """Harmonics (K + 1,) of a module whose half-wave plate stands at an angle, rad."""
    return TwoPassModulator(
        half_wave_angle=plate_angle,
        eta=eta,
        frequency=frequency,
        mirror_distance=module.mirror_distance,
        input_axis="horizontal",  # Sec. 7.1
        transmitted_extinction=module.transmitted_extinction,
        reflected_extinction=module.reflected_extinction,
        mirror_reflectance=module.mirror_reflectance,
    ).harmonics(HARMONICS)
