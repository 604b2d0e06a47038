r"""Both modulators and their drives: what the detection lets through of what the emission sent.

A drive is :math:`V = \eta\sin(\omega t - \varphi)`, held as the phasor :math:`\eta e^{-i\varphi}`.
The emission's waveform has the Fourier coefficients :math:`W_k e^{-ik\varphi_e}`, a path of round
trip :math:`\tau` delays it by :math:`e^{-ik\omega\tau}`, the detection has
:math:`R_k e^{-ik\varphi_d}`, so the detector sees

.. math:: C = \sum_m p_m\,\Big[W_0R_0 + 2\,\mathrm{Re}\sum_{k\ge1}W_kR_k^*\,
          e^{ik(\varphi_d-\varphi_e-\omega\tau_m)}\Big]

With :math:`\phi = 4\pi f n_g z/c` at the frequency of the *modulation* (f = f_drive in the single,
2 f_drive in the doubled mode) its fundamental is :math:`\cos(\phi + \psi)` with

.. math:: \psi = -\varphi_d + const \ (single), \qquad \psi = -2\varphi_d + const \ (doubled).

So to step psi upwards the drive of the detection steps *downwards*: :math:`\varphi_d = -\psi` or
:math:`-\psi/2`, modulo a turn.
"""

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.instrument.drives import Drives, RfDrivers, true_frequencies
from cmtof.instrument.panel import Panel
from cmtof.instrument.segments import Segments, segments_of
from cmtof.instrument.settings import Module, TwinSettings
from cmtof.modulator import TwoPassModulator

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

HARMONICS = 16
"""Highest harmonic of the drive that is kept: J_16(2 eta) < 1e-12 up to eta = 1.5."""

_KEPT = 8  # configurations: two modes, reference, dark and a few more
_NODE = 1 / 32  # spacing of eta between stored harmonics, rad
_STENCIL = np.arange(-2, 4)


class Configuration(NamedTuple):
    """Both modules as they stand during a burst of S segments."""

    segments: Segments
    frequency: float
    """Frequency of the emission's drive, Hz."""
    beat: float
    """Frequency of the detection's drive above it, Hz."""
    mean: Array
    """(S,) product of the mean transmissions."""
    detection: Array
    """(S,) mean transmission of the detection."""
    orders: tuple[int, ...]
    """Harmonics that matter."""
    products: Complex
    """(len(orders), S) ``2 W_k conj(R_k)``, damped by the beat within a sample."""


def _key(panel: Panel, edges: NDArray[np.integer], rate: float) -> tuple:
    knobs = [
        (
            k.on,
            k.frequency,
            k.power,
            k.phase,
            k.trigger,
            k.armed,
            k.index,
            np.asarray(k.table).tobytes(),
        )
        for k in (panel.emission, panel.detection)
    ]
    clock = panel.clock_on, panel.clock_frequency
    return (*knobs, *panel.plate_angle, *clock, rate, edges.tobytes())


class Modulators:
    """Both modulators of an instrument.

    Parameters
    ----------
    settings : TwinSettings
    seed : int
        What the errors of the phase codes depend on.
    """

    def __init__(self, settings: TwinSettings, seed: int) -> None:
        self._settings = settings
        self._drivers = RfDrivers(settings.drive, seed)
        self._kept: dict[tuple, Configuration] = {}

    def configuration(self, panel: Panel, edges: NDArray[np.integer], rate: float) -> Configuration:
        """Both modules during a burst whose samples saw the edges (T,); the last few are kept."""
        key = _key(panel, edges, rate)
        if key not in self._kept:
            while len(self._kept) >= _KEPT:
                self._kept.pop(next(iter(self._kept)))
            self._kept[key] = self._configured(panel, edges, rate)
        return self._kept[key]

    def _configured(self, panel: Panel, edges: NDArray[np.integer], rate: float) -> Configuration:
        frequencies = true_frequencies(panel, self._settings.drive)
        segments = segments_of(edges, rate, single=frequencies[0] != frequencies[1])
        drives = self._drivers.at_crystals(panel, segments.edge)
        emission, detection = self.waveforms(panel, drives)
        order = np.arange(HARMONICS + 1)
        cycles = order * drives.beat * segments.interval
        products = (2 * np.sinc(cycles) * emission * np.conj(detection)).T
        size = np.abs(products).max(axis=1)
        matter = tuple(int(k) for k in order[1:] if size[k] > 1e-13 * size[0])
        return Configuration(
            segments,
            drives.frequency,
            drives.beat,
            products[0].real / 2,
            detection[:, 0].real,
            matter,
            products[list(matter)],
        )

    def emission(self, panel: Panel) -> Complex:
        """Fourier coefficients (K + 1,) of the emission between bursts."""
        return self.waveforms(panel, self._drivers.at_crystals(panel, np.full(1, -1)))[0][0]

    def waveforms(self, panel: Panel, drives: Drives) -> tuple[Complex, Complex]:
        """Fourier coefficients (S, K + 1) of emission and detection, phases of drive included."""
        frequencies = drives.frequency, drives.frequency + drives.beat
        found = []
        for number, (module, phasor) in enumerate(
            (
                (self._settings.emission, drives.emission),
                (self._settings.detection, drives.detection),
            )
        ):
            setting = _modulator(module, panel.plate_angle[number], frequencies[number])
            turn = np.exp(1j * np.angle(phasor))[:, None] ** np.arange(HARMONICS + 1)
            found.append(harmonics_at(setting, np.abs(phasor)) * turn)
        return found[0], found[1]


def detected(configuration: Configuration, fraction: Array, phase: Array, lag: Array) -> Array:
    """Share of the light (N, S) that the detection lets through.

    Parameters
    ----------
    configuration : Configuration
    fraction, phase : ndarray, shape (N, M)
        Paths: share of the light, and phase of the round trip at the drive's frequency, rad.
    lag : ndarray, shape (N, S)
        Phase by which the detection's drive lags beyond its table, rad.
    """
    total = configuration.mean * fraction.sum(1, keepdims=True)
    for order, product in zip(configuration.orders, configuration.products, strict=True):
        phasor = (fraction * np.exp(-1j * order * phase)).sum(1, keepdims=True)
        total = total + (product * phasor * np.exp(1j * order * lag)).real
    return np.maximum(total, 0.0)


def harmonics_at(modulator: TwoPassModulator, eta: Array) -> Complex:
    """Harmonics (S, K + 1) at drive amplitudes (S,), rad, from stored ones 1/32 rad apart.

    Six-point Lagrange interpolation; they are entire functions of eta, and the error stays below
    1e-9.
    """
    base = np.floor(eta / _NODE).astype(int)
    result = np.empty((eta.size, HARMONICS + 1), complex)
    for start in np.unique(base):
        here = base == start
        offset = eta[here] / _NODE - start
        weights = np.ones((offset.size, _STENCIL.size))
        for i, node in enumerate(_STENCIL):
            for other in _STENCIL:
                if other != node:
                    weights[:, i] *= (offset - other) / (node - other)
        result[here] = weights @ _nodes(modulator, int(start))
    return result


@lru_cache(maxsize=256)
def _nodes(modulator: TwoPassModulator, start: int) -> Complex:
    return np.stack(
        [replace(modulator, eta=(start + n) * _NODE).harmonics(HARMONICS) for n in _STENCIL]
    )


@lru_cache(maxsize=256)
def _modulator(module: Module, plate_angle: float, frequency: float) -> TwoPassModulator:
    """Modulator of a module whose plate's mount stands at an angle, rad; the drive is set later."""
    return TwoPassModulator(
        half_wave_angle=plate_angle - module.plate_zero,
        frequency=frequency,
        input_axis="horizontal",  # Sec. 7.1
        half_wave_angle_error=module.half_wave_angle_error,
        half_wave_retardance_error=module.half_wave_retardance_error,
        quarter_wave_angle_error=module.quarter_wave_angle_error,
        quarter_wave_retardance_error=module.quarter_wave_retardance_error,
        eom_angle_error=module.eom_angle_error,
        static_retardance=module.static_retardance,
        mirror_distance=module.mirror_distance,
        mirror_reflectance=module.mirror_reflectance,
        transmitted_extinction=module.transmitted_extinction,
        reflected_extinction=module.reflected_extinction,
    )
