r"""The simulated instrument: from its knobs to the light on its detector and its counts.

With the Fourier coefficients :math:`W_k` of the emission's and :math:`R_k` of the detection's
waveform, drives :math:`\eta\sin(\omega t-\varphi)` and paths of the shares p and round trips tau,

.. math:: C = \sum_m p_m\,\Big[W_0R_0 + 2\,\mathrm{Re}\sum_{k\ge1}W_kR_k^*\,
          e^{ik(\varphi_d-\varphi_e-\omega\tau_m)}\Big].

Its fundamental is :math:`\cos(\phi+\psi)` with psi = -phi_d + const, in the doubled mode -2 phi_d.
Time is virtual: burst n starts at ``n * 20 ms``, settled, and its noise depends on (seed, n) only;
the laser has drift but no fast noise. Optical angles: along (tan x, tan y, 1), y downwards.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.random import Generator, Philox
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU
from cmtof.hardware.plan import BURST_INTERVAL
from cmtof.hardware.rf import CODES
from cmtof.hardware.rig import SAMPLE_RATE
from cmtof.modulator import TwoPassModulator
from cmtof.types import Array, Complex, Counts, Numbers
from cmtof_lab.electronics import (
    POLES,
    Chain,
    counts_from_volts,
    density,
    volts_per_watt,
)
from cmtof_lab.optics import (
    WORD,
    ambient,
    directions_from_angles,
    inward,
    outward,
    trace,
)
from cmtof_lab.settings import NOISE, TwinSettings
from cmtof_lab.targets import Plane, scene_from

HARMONICS = 16  # Highest harmonic of the drive that is kept: J_16(2 eta) < 1e-12 up to eta = 1.5
# Frequencies of a drift, Hz, from 1 mHz to 0.5 Hz
DRIFT_OCTAVES = 1e-3 * 2.0 ** np.arange(10)
DRIFT_RMS = 1 / np.sqrt(2 * DRIFT_OCTAVES.size)

# Phase noise of a step over that of 16: mean of (2 sin^2)^2 is 3/2
STEP_NOISE = np.sqrt(32 / 3)

# Deviation of a phasor's parts, share of the emitted light, as at the photon limit of a scan
DARK = np.reshape([1.9e-9, 4.7e-9], (2, 1, 1))

LABEL = 1  # purposes of random numbers
DRIFT = 5
CODE = 6
JITTER = 8
_harmonics = lru_cache(maxsize=4096)(TwoPassModulator.harmonics)


def keyed_generator(seed: int, purpose: int, key: int) -> Generator:
    """Philox generator whose numbers depend on the arguments alone (Salmon et al., SC 2011)."""
    # words of 64 bits: both may be negative or larger
    stream = (purpose << 64) + (seed & WORD)
    return Generator(Philox(key=stream, counter=(key & WORD) << 64))


def normals_by_key(seed: int, purpose: int, keys: Numbers, count: int) -> Array:
    """Standard normals (N, count), a row for each key, as `keyed_generator` draws them."""
    rng = keyed_generator(seed, purpose, 0)
    # to set a state takes an eighth of the time of a new generator
    state = rng.bit_generator.state
    rows = []
    for key in keys.tolist():
        state["state"]["counter"][1] = key & WORD
        rng.bit_generator.state = state
        rows.append(rng.standard_normal(count))
    return np.array(rows)


def correlated(own: Array, before: Array, grain: float) -> Array:
    """Normals whose neighbours are correlated by ``grain``, from white ones and those before."""
    mix = np.arcsin(2 * grain) / 2  # cos sin of it is the correlation
    return np.cos(mix) * own + np.sin(mix) * before


def with_noise(phasor: Complex, rng: Generator) -> Complex:
    """Phasors (2, H, W) with detector noise and the captures' phase noise, correlated in rows."""
    captures = NOISE["captures"]
    dark = DARK * rng.standard_normal((2, *phasor.shape))
    own = rng.standard_normal(phasor.shape)
    turn = correlated(own, np.roll(own, 1, axis=-1), captures["grain"])
    turn *= np.reshape(captures["phase_noise"], (2, 1, 1))
    return (phasor + dark[0] + 1j * dark[1]) * np.exp(1j * turn)


def drift(seed: int, channel: int, time: ArrayLike) -> Array:
    """Drift in [-1, 1] at times (...), s, 1/f in spectrum: ten equal sinusoids, one an octave."""
    rng = keyed_generator(seed, DRIFT, channel)
    # off the exact octaves, or the sum would be periodic
    rate = TAU * DRIFT_OCTAVES * rng.uniform(0.9, 1.1, DRIFT_OCTAVES.size)
    angle = np.multiply.outer(time, rate) + rng.uniform(0, TAU, rate.size)
    return np.sin(angle).mean(-1)


@dataclass
class RfKnobs:
    """One RF driver: Hz, dBm, rad, and the phases (K,), rad, that a trigger steps through."""

    on: bool = False
    frequency: float = 7.15e9
    power: float = 0.0
    phase: float = 0.0
    table: Array | Sequence[float] = ()


@dataclass
class Panel:
    """Every knob of the instrument: rad, V, m."""

    emission: RfKnobs = field(default_factory=RfKnobs)
    detection: RfKnobs = field(default_factory=RfKnobs)
    plate_emission: float = 0.0
    plate_detection: float = 0.0
    stage: Any = 0.0  # of the target: one position, or one for each burst
    galvo_volts: list[float] = field(default_factory=lambda: [0.0, 0.0])
    laser_on: bool = False
    shutter_open: bool = False
    target_in_beam: bool = False  # the reference target, not the scene
    photodiode_lit: bool = False  # instead of the detection module
    beam_block_out: bool = False
    mirror_travel: float = 0.0  # of the interferometer's mirror
    interlock_closed: bool = True
    clock_on: bool = False
    time: float = 0.0  # virtual, s


class SimulatedInstrument:
    """One instrument before a scene as `scene_from` takes it, by default before nothing."""

    def __init__(
        self, settings: TwinSettings, scene: Any = None, *, seed: int = 0
    ) -> None:
        self.settings = settings
        self.seed = seed
        self.scene = scene_from(scene) or Plane(np.nan)
        self.modulator = TwoPassModulator(
            half_wave_angle=0,
            input_axis="horizontal",  # the incident polarisation is that of Sec. 7.1
            mirror_distance=settings.mirror_distance,
            mirror_reflectance=settings.mirror_reflectance,
            transmitted_extinction=settings.transmitted_extinction,
            reflected_extinction=settings.reflected_extinction,
        )
        self.code_errors = settings.phase_step_error * normals_by_key(
            self.seed, CODE, np.arange(2), CODES
        )
        # a matrix exponential finds the filters once for all bursts of a rate, Hz
        self._filters = cache(lambda rate: Chain(settings, 1 / rate))

    def bursts(
        self,
        panel: Panel,
        angles: Array,
        *,
        labels: Numbers,
        pulses: Numbers,
        rate: float = SAMPLE_RATE,
    ) -> Counts:
        """Raw stream counts (N, T) of a burst for each of N optical angles (N, 2), rad.

        ``labels`` (N,) number the bursts, and ``pulses`` (T,) are the trigger's last edge at each
        sample, at ``rate``, Hz; the panel's galvo and time do not count.
        """
        # the drives are constant in stretches between edges
        first = np.flatnonzero(np.diff(pulses, prepend=pulses[0] - 1))
        length = np.diff(first, append=len(pulses))
        light = self._light(
            panel,
            self._paths(panel, angles),
            BURST_INTERVAL * labels[:, None] + (first + length / 2) / rate,
            self._waveforms(panel, pulses[first]),
            labels,
        )
        return self.counts(np.repeat(light, length, axis=1), labels, rate)

    def _paths(self, panel: Panel, angles: Array) -> Array:
        """Ranges, m, and light fractions (2, N, M) of paths to scene or target; last stray."""
        settings = self.settings
        ways = []
        if panel.target_in_beam:
            # the beam stands still behind the flip mirror
            for place in np.broadcast_to(panel.stage, len(angles)).tolist():
                target = replace(
                    settings.reference, distance=self.target_distance(place)
                )
                # another 10 um of stage, another speckle
                seed = self.seed + 1 + round(place / 1e-5)
                ways.append(trace(target, np.zeros((1, 2)), settings, seed))
        else:
            ways.append(trace(self.scene, angles, settings, self.seed))
        stray = np.full(
            (2, len(angles), 1), [[[settings.back_range]], [[settings.back_fraction]]]
        )
        return np.append(np.concatenate(ways, axis=1), stray, axis=-1)

    def target_distance(self, stage: float) -> float:
        """Distance of the reference target, m, with its stage at a position, m."""
        return self.settings.reference.distance + stage - self.settings.stage_zero

    def _light(
        self,
        panel: Panel,
        paths: Array,
        times: Array,
        modules: Complex,
        labels: NDArray,
    ) -> Array:
        """Detector light (N, S), W, at times (N, S), s, by Fourier coefficients (2, S, K + 1)."""
        products = modules[0] * np.conj(modules[1])
        equal = panel.emission.frequency == panel.detection.frequency
        products[:, 1:] *= 2 * (panel.clock_on and equal)
        size = abs(products).max(axis=0)
        lag = self._lag(int(size[1] < size[2]), times, labels)
        # harmonics that count, the mean among them
        orders = np.flatnonzero(size > 1e-13 * size[0])
        turned = products[:, orders] * np.exp(1j * np.multiply.outer(lag, orders))
        share = self._shares(panel.emission.frequency, paths, orders)
        share = (turned * share[:, None]).sum(-1).real.clip(0.0)
        share *= not panel.photodiode_lit
        loss = outward(self.settings) * inward(self.settings)
        room = ambient(self.settings) * modules[1, :, 0].real
        return self.from_fibre(panel, times) * loss * share + room

    def _lag(self, mode: int, times: Array, labels: NDArray) -> Array:
        """Phase lag (N, S), rad, between the drives: slow drift, and noise from step to step."""
        slow = self.settings.phase_drift / DRIFT_RMS * drift(self.seed, 1, times)
        spread = STEP_NOISE * self.settings.phase_noise[mode] / (1 + mode)
        if not spread:
            return slow
        # a neighbour's noise is drawn once
        keys, place = np.unique([labels, labels - 1], return_inverse=True)
        own, before = normals_by_key(self.seed, JITTER, keys, times.shape[1])[place]
        return slow + spread * correlated(own, before, self.settings.grain)

    def _shares(self, frequency: float, paths: Array, orders: Numbers) -> Complex:
        """Fraction (N, O) of the sent light that returns, as phasors of harmonics (O,)."""
        reach, fraction = paths
        way = self.settings.group_index * reach + self.settings.internal_path
        phase = 2 * TAU * frequency / SPEED_OF_LIGHT * way
        phasors = np.exp(-1j * np.multiply.outer(phase, orders))
        return np.vecdot(fraction[:, None], phasors.swapaxes(1, 2))

    def counts(self, light: Array, labels: NDArray, rate: float) -> Counts:
        """Counts (N, T) of light (N, T), W, held for a sample each: noise, filters, converter."""
        settings = self.settings
        samples = light.shape[1]
        volts = np.minimum(light * volts_per_watt(settings), settings.saturation)
        spread = np.sqrt(density(settings, volts))
        # a row: the filters' initial state, then for each sample the filters' noise and the ADC's
        size = POLES + (POLES + 1) * samples
        drawn = settings.noise * normals_by_key(self.seed, LABEL, labels, size)
        normals = np.insert(drawn, POLES, 0.0, axis=1)
        normals = normals.reshape(-1, samples + 1, POLES + 1)
        output = self._filters(rate).run(volts, spread, normals[..., :POLES])
        output = output.clip(-settings.saturation, settings.saturation)
        return counts_from_volts(
            output, settings.converter_noise * normals[:, 1:, POLES]
        )

    def emission(self, panel: Panel) -> Complex:
        """Fourier coefficients (K + 1,) of the emission module's waveform as it stands."""
        return self._waveforms(panel, np.array([-1]))[0][0]

    def _drives(self, panel: Panel, edges: Numbers) -> Complex:
        """Complex amplitudes (2, S), rad, of both drives after edges (S,); -1: before the first."""
        settings = self.settings
        made = []
        for number, one in enumerate((panel.emission, panel.detection)):
            table = one.table if len(one.table) else [one.phase]
            phase = self.made_phase(number, np.take(table, edges, mode="wrap"))
            phase += number * settings.phase_offset
            made.append(amplitude(settings, one) * np.exp(-1j * phase))
        leak = settings.leakage * np.exp(-1j * settings.leakage_phase)
        return np.array(made) + leak * np.array(made[::-1])

    def _waveforms(self, panel: Panel, edges: Numbers) -> Complex:
        """Fourier coefficients (2, S, K + 1) of both waveforms after trigger edges (S,)."""
        drives = self._drives(panel, edges)
        turns = np.exp(1j * np.angle(drives))[..., None] ** np.arange(HARMONICS + 1)
        found = []
        for one, angle, size in zip(
            (panel.emission, panel.detection),
            (panel.plate_emission, panel.plate_detection),
            abs(drives),
            strict=True,
        ):
            modules = [
                replace(
                    self.modulator,
                    half_wave_angle=angle,
                    frequency=one.frequency,
                    eta=eta,
                )
                for eta in size.tolist()
            ]
            found.append([_harmonics(module, HARMONICS) for module in modules])
        return turns * found  # pyright: ignore[reportReturnType]

    def made_phase(self, module: int, phase: Array) -> Array:
        """Phase, rad, that driver 0 or 1 really makes of one that was set."""
        code = np.rint(phase * (CODES / TAU)).astype(int)
        error = self.code_errors[module, code % CODES]
        skew = self.settings.iq_imbalance * np.sin(2 * phase)
        return phase + error + skew

    def from_fibre(self, panel: Panel, times: ArrayLike) -> Array:
        """Power behind the fibre at times, W; 0 unless laser, shutter and interlock let it pass."""
        settings = self.settings
        passed = panel.laser_on and panel.shutter_open and panel.interlock_closed
        swing = (settings.fibre_high - settings.fibre_low) / 2
        fibre = settings.fibre + swing * drift(self.seed, 0, times)
        return passed * settings.laser_power * fibre

    def ranges(self, angles: ArrayLike) -> Array:
        """True ranges (...), m, of the scene at optical angles (..., 2), rad; NaN for nothing."""
        return self.scene.look(directions_from_angles(angles)).range

    def laser_power(self, panel: Panel) -> float:
        """Power that the integrating sphere behind the first beam splitter sees, W (Sec. 7.1)."""
        settings = self.settings
        emitted = self.from_fibre(panel, panel.time) * self.emission(panel)[0].real
        passed = settings.lens**2 * settings.mirror * settings.splitter
        return float(emitted * passed)


def amplitude(settings: TwinSettings, drive: RfKnobs) -> complex:
    """Complex drive amplitude, rad; a resonance of width G passes ``1 / (1 + 2i d / G)`` at d."""
    offsets = np.array([settings.detuning, drive.frequency - settings.resonance])
    stated, passed = 1 / (1 + 2j * offsets / settings.resonance_width)
    eta = settings.eta * 10 ** ((drive.power - settings.drive_power) / 20)
    return drive.on * eta * passed / abs(stated)
