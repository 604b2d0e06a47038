"""The RF drivers: frequency, power, phase table, resonance, and what is wrong with each.

A drive is ``V = eta sin(omega t - phi)``, held as the phasor ``eta exp(-i phi)``.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.instrument.drift import keyed_generator
from cmtof.instrument.panel import Panel, RfKnobs
from cmtof.instrument.settings import Drive

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

CLOCK = 10e6
"""Frequency of the external clock that the drivers expect, Hz."""

_CODES = 65536


class RfLockState(NamedTuple):
    """What an RF driver knows about its lock."""

    locked: bool
    detuning: float
    """Drive off resonance, Hz."""
    reflected: float
    """Power that the crystal reflects, dBm."""


class Drives(NamedTuple):
    """Phasors ``eta exp(-i phi)`` (S,), rad, at the crystals, and the drives' frequencies, Hz."""

    emission: Complex
    detection: Complex
    frequency: float
    """Frequency of the emission's drive, Hz."""
    beat: float
    """Frequency of the detection's drive above it, Hz."""


def true_frequencies(panel: Panel, drive: Drive) -> tuple[float, float]:
    """Frequencies of both drives, Hz: scaled with the clock, or adrift without it."""
    wanted = panel.emission.frequency, panel.detection.frequency
    if not panel.clock_on:
        return wanted[0] * (1 + drive.free_running), wanted[1] * (1 - drive.free_running)
    scale = panel.clock_frequency / CLOCK
    return wanted[0] * scale, wanted[1] * scale


def amplitude(drive: Drive, power: float, frequency: float) -> complex:
    """Complex drive amplitude, rad: eta by power and resonance, and the resonance's lag.

    A single resonance of full width G passes ``1 / (1 + 2i d / G)`` of the field at detuning d.
    """
    stated = abs(1 / (1 + 2j * drive.detuning / drive.width))
    passed = 1 / (1 + 2j * (frequency - drive.resonance) / drive.width)
    return drive.eta * 10 ** ((power - drive.power) / 20) * passed / stated


def lock_state(drive: Drive, knobs: RfKnobs, frequency: float, *, clocked: bool) -> RfLockState:
    """Lock of a driver: on, clocked and within the range; reflection of a matched resonance."""
    detuning = frequency - drive.resonance
    ratio = (2 * detuning / drive.width) ** 2
    reflected = knobs.power + 10 * np.log10(ratio / (1 + ratio) + 1e-3)  # -30 dB: no match is ideal
    locked = knobs.on and clocked and abs(detuning) <= drive.lock_range
    return RfLockState(bool(locked), float(detuning), float(reflected if knobs.on else -np.inf))


def played_phases(knobs: RfKnobs, edges: NDArray[np.integer]) -> Array:
    """Drive phases (S,), rad, where ``edges`` (S,) numbers the last edge of the burst from 0, -1
    before the first.

    An armed table plays entry `index` from the first edge on, one that runs already its next.
    """
    count = len(knobs.table)
    if not (knobs.trigger and count):
        return np.full(np.shape(edges), float(knobs.phase))
    first = knobs.index if knobs.armed else knobs.index + 1
    index = np.where(edges >= 0, first + edges, knobs.index)
    return np.asarray(knobs.table, float)[index % count]


class RfDrivers:
    """Both drivers of an instrument.

    Parameters
    ----------
    settings : Drive
    seed : int
        What the errors of the phase codes depend on.
    """

    def __init__(self, settings: Drive, seed: int) -> None:
        self._settings = settings
        self._code_errors = np.zeros((2, _CODES))
        if settings.phase_step_error:  # to draw for all codes takes longer than a burst
            for module, errors in enumerate(self._code_errors):
                keyed_generator(seed, "codes", module).standard_normal(out=errors)
            self._code_errors *= settings.phase_step_error

    def phase(self, module: int, phase: Array) -> Array:
        """Phase that driver 0 or 1 really makes of a phase that it was told, rad."""
        code = np.rint(phase * (_CODES / (2 * np.pi))).astype(int) % _CODES
        skew = self._settings.iq_imbalance * np.sin(2 * phase)
        return phase + self._code_errors[module][code] + skew

    def at_crystals(self, panel: Panel, edges: NDArray[np.integer]) -> Drives:
        """Drives at the crystals while the edges (S,) of a burst pass."""
        drive = self._settings
        frequencies = true_frequencies(panel, drive)
        made = []
        for module, knobs in enumerate((panel.emission, panel.detection)):
            size = amplitude(drive, knobs.power, frequencies[module]) if knobs.on else 0.0
            phase = self.phase(module, played_phases(knobs, edges)) + module * drive.phase_offset
            made.append(size * np.exp(-1j * phase))
        leak = drive.leakage * np.exp(-1j * drive.leakage_phase)
        beat = frequencies[1] - frequencies[0]
        if beat == 0:  # what leaks at another frequency averages out
            made = [made[0] + leak * made[1], made[1] + leak * made[0]]
        return Drives(made[0], made[1], frequencies[0], beat)
