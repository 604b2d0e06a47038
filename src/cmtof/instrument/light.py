r"""Light on the detector: drives, both modulators, ways through the scene, losses, room light.

A drive is :math:`V = \eta\sin(\omega t - \varphi)`, held as the phasor :math:`\eta e^{-i\varphi}`.
The emission's waveform has the Fourier coefficients :math:`W_k e^{-ik\varphi_e}`, a path of round
trip :math:`\tau` delays it by :math:`e^{-ik\omega\tau}`, the detection has
:math:`R_k e^{-ik\varphi_d}`, so the detector sees

.. math:: C = \sum_m p_m\,\Big[W_0R_0 + 2\,\mathrm{Re}\sum_{k\ge1}W_kR_k^*\,
          e^{ik(\varphi_d-\varphi_e-\omega\tau_m)}\Big]

With :math:`\phi = 4\pi f n_g z/c` at the frequency of the *modulation* (f = f_drive in the single,
2 f_drive in the doubled mode) its fundamental is :math:`\cos(\phi + \psi)` with

.. math:: \psi = -\varphi_d + const \ (single), \qquad \psi = -2\varphi_d + const \ (doubled).

So to step psi upwards the drive of the detection steps *downwards*. Without the clock the drives
run at different frequencies and only the mean is left.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.instrument import optics as free_space
from cmtof.instrument.drift import Drift, keyed_generator
from cmtof.instrument.settings import Drive, Module, TwinSettings
from cmtof.instrument.targets import Plane, Target
from cmtof.modulator import TwoPassModulator

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

HARMONICS = 16
"""Highest harmonic of the drive that is kept: J_16(2 eta) < 1e-12 up to eta = 1.5."""
CODES = 65536
"""Phase codes of an RF driver in a turn."""


@dataclass
class RfKnobs:
    """One RF driver: Hz, dBm, rad, and the phases (K,), rad, that a trigger steps through."""

    on: bool = False
    frequency: float = 7.15e9
    power: float = 0.0
    phase: float = 0.0
    table: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

    def phases(self, edges: NDArray[np.integer]) -> Array:
        """Drive phases (S,), rad, behind trigger edges (S,) numbered from 0; -1 is before them."""
        table = self.table if len(self.table) else np.array([self.phase])
        return np.asarray(table, float)[edges % len(table)]


@dataclass
class Panel:
    """Every knob of the instrument: rad, V, m; the flip mirror leads to the reference target."""

    emission: RfKnobs = field(default_factory=RfKnobs)
    detection: RfKnobs = field(default_factory=RfKnobs)
    plate_angle: list[float] = field(default_factory=lambda: [0.0, 0.0])
    galvo_volts: list[float] = field(default_factory=lambda: [0.0, 0.0])
    stage_position: float = 0.0
    laser_on: bool = False
    shutter_open: bool = False
    flip_mirror_in: bool = False
    beam_block_in: bool = True
    interlock_closed: bool = True
    clock_on: bool = False
    time: float = 0.0  # virtual, s


class Configuration(NamedTuple):
    """Both modules during a burst of T samples: S stretches of constant drive."""

    of_sample: NDArray[np.intp]
    """(T,) number of the stretch that a sample lies in."""
    middle: Array
    """(S,) time of its middle after the burst's start, s."""
    frequency: float
    """Frequency of the drive, Hz."""
    detection: Array
    """(S,) mean transmission of the detection."""
    products: Complex
    """(K + 1, S) W_0 R_0, then ``2 W_k conj(R_k)``."""


class Light:
    """The light of an instrument before a scene; ``seed`` of drift, errors and speckle."""

    def __init__(self, settings: TwinSettings, scene: Target | None, seed: int) -> None:
        self.settings, self.scene, self.seed = settings, scene, seed
        self.group_index = free_space.group_index(settings.air, settings.laser.wavelength)
        self._fibre, self._phase = Drift(seed, 0), Drift(seed, 1)

    def configuration(self, panel: Panel, edges: NDArray[np.integer], rate: float) -> Configuration:
        """Both modules during a burst at ``rate``, Hz, whose samples saw the edges (T,)."""
        first = np.flatnonzero(np.diff(edges, prepend=edges[0] - 1))
        last = np.append(first[1:], edges.size)
        emission, detection = self._waveforms(panel, edges[first])
        products = (2 * emission * np.conj(detection)).T
        products[0] /= 2
        if not panel.clock_on or panel.emission.frequency != panel.detection.frequency:
            products[1:] = 0.0
        of_sample = np.repeat(np.arange(first.size), last - first)
        middle = (first + last) / 2 / rate
        return Configuration(
            of_sample, middle, panel.emission.frequency, detection[:, 0].real, products
        )

    def on_detector(
        self,
        panel: Panel,
        angles: Array,
        starts: Array,
        configuration: Configuration,
        stage: Array | None = None,
    ) -> Array:
        """Light on the detector (N, S), W, in each stretch of bursts that start at times (N,), s.

        Optical angles (N, 2), rad; ``stage`` (N,), m, stands for the panel's stage position.
        """
        optics = self.settings.optics
        paths = free_space.with_stray(self.paths(panel, angles, stage), optics)
        way = self.group_index * paths.range + optics.internal_path
        phase = 4 * np.pi * configuration.frequency / SPEED_OF_LIGHT * way
        times = starts[:, None] + configuration.middle
        lag = self.settings.drive.phase_drift / Drift.RMS * self._phase(times)
        share = configuration.products[0].real * paths.fraction.sum(1, keepdims=True)
        size = np.abs(configuration.products).max(axis=1)
        for order in range(1, HARMONICS + 1):
            if size[order] > 1e-13 * size[0]:
                phasor = (paths.fraction * np.exp(-1j * order * phase)).sum(1, keepdims=True)
                turned = configuration.products[order] * phasor * np.exp(1j * order * lag)
                share = share + turned.real
        loss = free_space.outward(optics) * free_space.inward(optics)
        room = free_space.ambient(optics) * configuration.detection
        return self.from_fibre(panel, times) * loss * np.maximum(share, 0.0) + room

    def paths(self, panel: Panel, angles: Array, stage: Array | None = None) -> free_space.Paths:
        """Ways to the scene at optical angles (N, 2), rad, or to the target on the stage."""
        if panel.flip_mirror_in:
            places = np.full(len(angles), panel.stage_position) if stage is None else stage
            ways = {place: self._to_stage(place) for place in set(places.tolist())}
            each = [ways[place] for place in places.tolist()]
            return free_space.Paths(*(np.concatenate(parts) for parts in zip(*each, strict=True)))
        if self.scene is None:
            nothing = np.zeros((len(angles), 1))
            return free_space.Paths(nothing, nothing)
        return free_space.trace(self.scene, angles, self.settings, self.seed)

    def _to_stage(self, position: float) -> free_space.Paths:
        """Ways (1, M) to the reference target; the beam stands still behind the flip mirror."""
        held = self.settings.reference
        distance = held.distance + position - held.stage_zero
        target = Plane(distance, reflectance=held.reflectance, material=held.material)
        # another 10 um of stage, another speckle
        seed = self.seed + 1 + round(position / 1e-5)
        return free_space.trace(target, np.zeros((1, 2)), self.settings, seed)

    def from_fibre(self, panel: Panel, times: Array) -> Array:
        """Power behind the fibre at times, W; 0 unless laser, shutter and interlock let it pass."""
        laser = self.settings.laser
        if not (panel.laser_on and panel.shutter_open and panel.interlock_closed):
            return np.zeros(np.shape(times))
        middle = (laser.fibre_low + laser.fibre_high) / 2
        swing = (laser.fibre_high - laser.fibre_low) / 2
        return laser.power * (middle + swing * self._fibre(times))

    def emission(self, panel: Panel) -> Complex:
        """Fourier coefficients (K + 1,) of the emission module's waveform as it stands."""
        return self._waveforms(panel, np.full(1, -1))[0][0]

    def _waveforms(self, panel: Panel, edges: NDArray[np.integer]) -> tuple[Complex, Complex]:
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
        found = []
        modules = (self.settings.emission, self.settings.detection)
        for module, one, angle, phasor in zip(modules, knobs, panel.plate_angle, made, strict=True):
            plain = _modulator(module, angle, one.frequency)
            waves = np.stack([_harmonics(plain, float(eta)) for eta in np.abs(phasor)])
            turn = np.exp(1j * np.angle(phasor))[:, None] ** np.arange(HARMONICS + 1)
            found.append(waves * turn)
        return found[0], found[1]

    def _made_phase(self, module: int, phase: Array) -> Array:
        """Phase, rad, that driver 0 or 1 really makes of one that was set."""
        drive = self.settings.drive
        skew = drive.iq_imbalance * np.sin(2 * phase)
        if not drive.phase_step_error:
            return phase + skew
        code = np.rint(phase * (CODES / (2 * np.pi))).astype(int) % CODES
        return phase + drive.phase_step_error * _code_errors(self.seed, module)[code] + skew


def amplitude(drive: Drive, power: float, frequency: float) -> complex:
    """Complex drive amplitude, rad: eta by power and resonance, and the resonance's lag.

    A single resonance of full width G passes ``1 / (1 + 2i d / G)`` of the field at detuning d.
    """
    stated = abs(1 / (1 + 2j * drive.detuning / drive.width))
    passed = 1 / (1 + 2j * (frequency - drive.resonance) / drive.width)
    return drive.eta * 10 ** ((power - drive.power) / 20) * passed / stated


@lru_cache(maxsize=64)
def _code_errors(seed: int, module: int) -> Array:
    """Standard normal error (65536,) of each phase code of a driver."""
    return keyed_generator(seed, "codes", module).standard_normal(CODES)


@lru_cache(maxsize=4096)
def _harmonics(modulator: TwoPassModulator, eta: float) -> Complex:
    """Harmonics (K + 1,) of a modulator at a drive amplitude, rad."""
    return replace(modulator, eta=eta).harmonics(HARMONICS)


@lru_cache(maxsize=256)
def _modulator(module: Module, plate_angle: float, frequency: float) -> TwoPassModulator:
    """Modulator of a module whose plate's mount stands at an angle, rad; the drive is set later."""
    errors = {name: getattr(module, name) for name in vars(module) if name != "plate_zero"}
    return TwoPassModulator(
        half_wave_angle=plate_angle - module.plate_zero,
        frequency=frequency,
        input_axis="horizontal",  # Sec. 7.1
        **errors,
    )
