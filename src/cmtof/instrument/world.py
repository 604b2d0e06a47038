"""The physical model behind the simulated instrument: what its read-out says, and when.

Time is virtual. A burst that carries a label starts at ``label * 20 ms``, whatever happened before,
and its noise depends on (seed, label, sample) only; without one, time runs on and noise depends on
the number of the burst. The mirrors rest and the filters have settled when a burst begins. Optical
angles: the beam leaves along (tan x, tan y, 1), +z at zero volts, y downwards as in a frame. The
two mirrors are taken to turn about one point. The laser's fast noise is not modelled, its slow
drift is. Signs of phases: see `cmtof.instrument.modulation`.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.instrument import optics as free_space
from cmtof.instrument.drift import keyed_generator
from cmtof.instrument.drives import RfLockState, lock_state, true_frequencies
from cmtof.instrument.electronics import POLES, Conversion, chain, counts_from_volts
from cmtof.instrument.light import Light
from cmtof.instrument.panel import Panel
from cmtof.instrument.scene import scene_from
from cmtof.instrument.settings import TwinSettings
from cmtof.waveform import low_pass_harmonics, waveform_from_harmonics

Array = NDArray[np.float64]

LABEL_TIME = 0.02
"""Virtual time from one label to the next, s: a burst of 13.3 ms and its dialogue."""

CHANNEL = 0
"""Analog input that the detector is wired to."""

FAST_BANDWIDTH = 12e9
"""-3 dB of the fast detector ET-4000, Hz (Sec. 7.4)."""

_STILL_RATE = 24000.0  # Hz; of a reading that is no stream
_ROWS = 512  # directions computed at a time, to stay within the processor's caches


class World:
    """One instrument before one scene.

    Parameters
    ----------
    settings : TwinSettings
    scene : str, Path, Frame, mapping, Target or None
        As `cmtof.instrument.scene.scene_from` takes it; None is that of the settings, and
        without one nothing returns.
    seed : int
        What noise, drift, errors and speckle depend on.
    """

    def __init__(self, settings: TwinSettings, scene: Any = None, *, seed: int = 0) -> None:
        self.settings = settings
        self.scene = scene_from(settings.scene if scene is None else scene)
        self.seed = int(seed)
        self.conversion = Conversion(settings.detector, settings.laser.wavelength)
        self.light = Light(settings, self.scene, self.seed)

    # --- what the instrument's devices ask -----------------------------------------------------

    def burst(
        self,
        panel: Panel,
        *,
        scans: int,
        rate: float,
        pulses: ArrayLike | None = None,
        volts_range: float = 10.0,
    ) -> NDArray[np.uint16]:
        """Raw stream counts (scans,) of the detector; advances the panel's time and bursts.

        The RF knobs are left alone: who counts the edges moves the tables on.

        Parameters
        ----------
        panel : Panel
        scans, rate : int, float
            Number of samples, and how many a second, Hz.
        pulses : array_like, shape (scans,), or None
            Number of the last rising edge at each sample, from 0, -1 before the first; None is no
            edge at all.
        volts_range : float
            Input range of the T7, V.
        """
        with panel.lock:
            key = ("label", panel.label) if panel.label else ("count", panel.bursts)
            start = LABEL_TIME * float(panel.label) if panel.label else panel.time
            panel.time = start + scans / rate
            panel.bursts += 1
            edges = _edges(pulses, scans)
            return self._counts(
                panel, self.angles(panel)[None], np.array([start]), [key], edges, rate, volts_range
            )[0]

    def analog_input(self, panel: Panel, channel: int) -> float:
        """One reading by command, V; inputs other than the detector's are grounded."""
        with panel.lock:
            if channel != CHANNEL:
                return 0.0
            configuration = self.light.configuration(panel, np.full(1, -1), _STILL_RATE)
            times = np.array([panel.time])
            light = self.light.on_detector(panel, self.angles(panel)[None], times, configuration)
            volts = self.conversion.volts(light)[0, 0]
            key = round(panel.time * 1e9)
        if not self.settings.noise:
            return float(volts)
        bandwidth = chain(self.settings.detector, 1 / _STILL_RATE).noise_bandwidth
        spread = np.sqrt(self.conversion.density(volts) * bandwidth)
        rng = keyed_generator(self.seed, "analog", key)
        limit = self.settings.detector.saturation
        return float(np.clip(volts + spread * rng.standard_normal(), -limit, limit))

    def laser_power(self, panel: Panel) -> float:
        """Power that the integrating sphere behind the first beam splitter sees, W (Sec. 7.1)."""
        with panel.lock:
            mean = self.light.emission(panel)[0].real
            loss = free_space.to_power_meter(self.settings.optics)
            return float(self.light.from_fibre(panel, np.array(panel.time)) * loss * mean)

    def lock(self, panel: Panel, which: str) -> RfLockState:
        """Lock of the driver "emission" or "detection"."""
        if which not in ("emission", "detection"):
            raise ValueError(
                f"Expected a driver out of emission, detection, got {which!r}. Name one."
            )
        with panel.lock:
            drive = self.settings.drive
            frequency = true_frequencies(panel, drive)[which == "detection"]
            knobs = getattr(panel, which)
            return lock_state(drive, knobs, frequency, clocked=panel.clock_on)

    def fast_detector(self, panel: Panel, phase: ArrayLike) -> Array:
        """Intensity behind the emission module, W, at phases omega t (...), rad (Fig. 8).

        A mirror sends the light to a photodiode of 12 GHz, which damps what lies above.
        """
        with panel.lock:
            frequency = true_frequencies(panel, self.settings.drive)[0]
            power = (
                self.light.from_fibre(panel, np.array(panel.time)) * self.settings.optics.lens**2
            )
            seen = low_pass_harmonics(
                self.light.emission(panel), frequency=frequency, cutoff=FAST_BANDWIDTH
            )
        return np.asarray(power * waveform_from_harmonics(seen, phase))

    # --- many directions at once ---------------------------------------------------------------

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
        """What `burst` would return for each of many directions, (N, scans); the panel stays.

        Parameters
        ----------
        panel : Panel
            Its galvo, label and time do not count.
        angles : array_like, shape (N, 2)
            Optical angles x, y, rad.
        labels : array_like, shape (N,), or None
            Numbers of the bursts; by default 1 to N.
        scans, rate, pulses, volts_range
            As of `burst`.
        stage : array_like, shape (N,), or None
            Positions of the stage, m, in place of the panel's; they count while the flip mirror is
            in, where the directions do not.

        Raises
        ------
        ValueError
            If there is not one stage position a direction.
        """
        points = np.asarray(angles, float).reshape(-1, 2)
        numbers = np.arange(1, len(points) + 1) if labels is None else np.asarray(labels, int)
        places = None if stage is None else np.asarray(stage, float)
        if places is not None and places.shape != (len(points),):
            raise ValueError(
                f"Expected {len(points)} stage positions, one a direction, got shape "
                f"{places.shape}. Give one a burst, m."
            )
        edges = _edges(pulses, scans)
        parts = []
        with panel.lock:
            for first in range(0, len(points), _ROWS):
                rows = slice(first, first + _ROWS)
                some = numbers[rows]
                keys = [("label", int(label)) for label in some]
                starts = LABEL_TIME * some.astype(float)
                at = None if places is None else places[rows]
                parts.append(
                    self._counts(panel, points[rows], starts, keys, edges, rate, volts_range, at)
                )
        return np.concatenate(parts) if parts else np.empty((0, scans), np.uint16)

    def image(
        self,
        panel: Panel,
        angles: ArrayLike,
        *,
        phases: int = 16,
        samples: int = 20,
        settle: int = 4,
        labels: ArrayLike | None = None,
        rate: float = 24000.0,
        volts_range: float = 10.0,
    ) -> Array:
        """Mean counts (N, phases) of bursts that step the table at every ``samples`` samples.

        The first ``settle`` samples of each phase are left out, as in a scan.
        """
        pulses = np.arange(phases * samples) // samples
        counts = self.bursts(
            panel,
            angles,
            labels=labels,
            scans=phases * samples,
            rate=rate,
            pulses=pulses,
            volts_range=volts_range,
        )
        return counts.reshape(-1, phases, samples)[..., settle:].mean(-1)

    def angles(self, panel: Panel) -> Array:
        """Optical angles (2,), rad, of the panel's galvo; twice the mechanical ones."""
        galvo = self.settings.galvo
        volts = np.array(panel.galvo_volts, float) - [galvo.offset_x, galvo.offset_y]
        return np.deg2rad(2 * volts / galvo.volts_per_degree)

    def ranges(self, angles: ArrayLike) -> Array:
        """True ranges (N,), m, of the scene at optical angles (N, 2), rad; NaN for nothing."""
        points = np.asarray(angles, float).reshape(-1, 2)
        if self.scene is None:
            return np.full(len(points), np.nan)
        return self.scene.look(free_space.directions_from_angles(points)).range

    # --- the model -----------------------------------------------------------------------------

    def _counts(
        self,
        panel: Panel,
        angles: Array,
        starts: Array,
        keys: list[tuple[str, int]],
        edges: NDArray[np.integer],
        rate: float,
        volts_range: float,
        stage: Array | None = None,
    ) -> NDArray[np.uint16]:
        detector, scans = self.settings.detector, edges.size
        configuration = self.light.configuration(panel, edges, rate)
        light = self.light.on_detector(panel, angles, starts, configuration, stage)
        volts = self.conversion.volts(light)
        of_sample = configuration.segments.of_sample
        light = volts[:, of_sample]
        density = self.conversion.density(volts)[:, of_sample]
        filters = chain(detector, 1 / rate)
        if not self.settings.noise:
            return counts_from_volts(
                filters.run(light, density, None), detector, volts_range=volts_range
            )
        # a row: the filters' initial state, then for each sample the filters' noise and the ADC's
        size = POLES + (POLES + 1) * scans
        drawn = np.stack([keyed_generator(self.seed, *key).standard_normal(size) for key in keys])
        by_sample = drawn[:, POLES:].reshape(len(keys), scans, POLES + 1)
        noise = by_sample[..., :POLES].reshape(len(keys), -1)
        output = filters.run(light, density, np.concatenate([drawn[:, :POLES], noise], axis=1))
        output = np.maximum(np.minimum(output, detector.saturation), -detector.saturation)
        return counts_from_volts(
            output, detector, volts_range=volts_range, normals=by_sample[..., POLES]
        )


def _edges(pulses: ArrayLike | None, scans: int) -> NDArray[np.integer]:
    edges = np.full(scans, -1) if pulses is None else np.asarray(pulses, int)
    if edges.shape != (scans,) or scans < 1:
        raise ValueError(
            f"Expected the last edge of each of {scans} samples, at least 1, got shape "
            f"{edges.shape}. Give one number a sample."
        )
    return edges
