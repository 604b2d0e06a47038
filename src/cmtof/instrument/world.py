"""The physical model behind the simulated instrument: what its read-out gives, and when.

Time is virtual. Burst number n starts at ``n * 20 ms``, and its noise depends on (seed, n, sample)
only. The mirrors rest and the filters have settled when a burst begins. Optical angles: the beam
leaves along (tan x, tan y, 1), +z at zero volts, y downwards as in a frame. The two mirrors are
taken to turn about one point. The laser's fast noise is not modelled, its slow drift is.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.instrument import optics as free_space
from cmtof.instrument.drift import keyed_generator
from cmtof.instrument.electronics import POLES, Conversion, chain, counts_from_volts
from cmtof.instrument.light import Light, Panel
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.targets import scene_from
from cmtof.waveform import low_pass_harmonics, waveform_from_harmonics

Array = NDArray[np.float64]

LABEL_TIME = 0.02
"""Virtual time from one burst to the next, s: 13.3 ms and its dialogue."""

VOLTS_PER_DEGREE = 0.5
"""Scan mirrors GVS012, V per mechanical degree (its manual)."""

FAST_BANDWIDTH = 12e9
"""-3 dB of the fast detector ET-4000, Hz (Sec. 7.4)."""

SAMPLE_RATE, SAMPLES, PHASES = 24000.0, 20, 16
"""Samples a second, of a phase, and phases of a point (Sec. 7.2)."""

_ROWS = 512  # directions computed at a time, to stay within the processor's caches


class World:
    """One instrument before one scene.

    Parameters
    ----------
    settings : TwinSettings
    scene : str, Path, Frame, mapping, Target or None
        As `cmtof.instrument.targets.scene_from` takes it; None is that of the settings, and
        without one nothing returns.
    seed : int
        Of noise, drift, errors and speckle.
    """

    def __init__(self, settings: TwinSettings, scene: Any = None, *, seed: int = 0) -> None:
        self.settings = settings
        self.scene = scene_from(settings.scene if scene is None else scene)
        self.seed = int(seed)
        self.conversion = Conversion(settings.detector, settings.laser.wavelength)
        self.light = Light(settings, self.scene, self.seed)

    def bursts(
        self,
        panel: Panel,
        angles: ArrayLike,
        *,
        labels: ArrayLike | None = None,
        scans: int = 320,
        rate: float = 24000.0,
        pulses: ArrayLike | None = None,
        volts_range: float = 10.0,
        stage: ArrayLike | None = None,
    ) -> NDArray[np.uint16]:
        """Raw stream counts (N, scans) of the detector, a burst for each of N directions.

        Parameters
        ----------
        panel : Panel
            Its galvo and time do not count.
        angles : array_like, shape (N, 2)
            Optical angles x, y, rad.
        labels : array_like, shape (N,), or None
            Numbers of the bursts; by default 1 to N.
        scans, rate : int, float
            Samples of a burst, and how many a second, Hz.
        pulses : array_like, shape (scans,), or None
            Number of the trigger's last edge at each sample, from 0; None is no edge.
        volts_range : float
            Input range of the T7, V.
        stage : array_like, shape (N,), or None
            Positions of the stage, m, in place of the panel's.
        """
        points = np.asarray(angles, float).reshape(-1, 2)
        numbers = np.arange(1, len(points) + 1) if labels is None else np.asarray(labels, int)
        edges = np.full(scans, -1) if pulses is None else np.asarray(pulses, int)
        places = None if stage is None else np.asarray(stage, float)
        if edges.shape != (scans,) or (places is not None and places.shape != (len(points),)):
            raise ValueError(
                f"Expected {scans} trigger edges and {len(points)} stage positions, got other "
                "numbers. Give one edge a sample and one position a burst."
            )
        held = self.light.configuration(panel, edges, rate)
        counts = np.empty((len(points), scans), np.uint16)
        for first in range(0, len(points), _ROWS):
            rows = slice(first, first + _ROWS)
            at = None if places is None else places[rows]
            starts = LABEL_TIME * numbers[rows].astype(float)
            light = self.light.on_detector(panel, points[rows], starts, held, at)
            volts = self.conversion.volts(light)[:, held.of_sample]
            counts[rows] = self._read_out(volts, numbers[rows], rate, volts_range)
        return counts

    def _read_out(
        self, volts: Array, labels: NDArray, rate: float, volts_range: float
    ) -> NDArray[np.uint16]:
        """Counts (N, T) of held detector outputs (N, T), V: noise, filters, converter."""
        detector = self.settings.detector
        filters, density = chain(detector, 1 / rate), self.conversion.density(volts)
        if not self.settings.noise:
            quiet = filters.run(volts, density, None)
            return counts_from_volts(quiet, detector, volts_range=volts_range)
        # a row: the filters' initial state, then for each sample the filters' noise and the ADC's
        size = POLES + (POLES + 1) * volts.shape[1]
        drawn = np.stack(
            [keyed_generator(self.seed, "label", int(n)).standard_normal(size) for n in labels]
        )
        by_sample = drawn[:, POLES:].reshape(len(labels), -1, POLES + 1)
        normals = np.concatenate([drawn[:, None, :POLES], by_sample[..., :POLES]], axis=1)
        output = filters.run(volts, density, normals)
        output = np.clip(output, -detector.saturation, detector.saturation)
        return counts_from_volts(
            output, detector, volts_range=volts_range, normals=by_sample[..., POLES]
        )

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
        loss = free_space.to_power_meter(self.settings.optics)
        mean = self.light.emission(panel)[0].real
        return float(self.light.from_fibre(panel, np.array(panel.time)) * loss * mean)

    def fast_detector(self, panel: Panel, phase: ArrayLike) -> Array:
        """Intensity behind the emission module, W, at phases omega t (...), rad (Fig. 8).

        A mirror sends the light to a photodiode of 12 GHz, which damps what lies above.
        """
        power = self.light.from_fibre(panel, np.array(panel.time)) * self.settings.optics.lens**2
        seen = low_pass_harmonics(
            self.light.emission(panel), frequency=panel.emission.frequency, cutoff=FAST_BANDWIDTH
        )
        return np.asarray(power * waveform_from_harmonics(seen, phase))
