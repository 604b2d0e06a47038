"""Light on the detector: laser, modulators, ways through the scene, losses, room light."""

import numpy as np
from numpy.typing import NDArray

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.instrument import optics as free_space
from cmtof.instrument.drift import Drift
from cmtof.instrument.modulation import Configuration, Modulators, detected
from cmtof.instrument.panel import Panel
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.targets import Plane, Target

Array = NDArray[np.float64]


class Light:
    """The light of an instrument before a scene.

    Parameters
    ----------
    settings : TwinSettings
    scene : Target or None
    seed : int
        What drift, errors and speckle depend on.
    """

    def __init__(self, settings: TwinSettings, scene: Target | None, seed: int) -> None:
        self.settings = settings
        self.scene = scene
        self.seed = seed
        self.group_index = free_space.group_index(settings.air, settings.laser.wavelength)
        self._modulators = Modulators(settings, seed)
        self._fibre, self._phase = Drift(seed, 0), Drift(seed, 1)

    def configuration(self, panel: Panel, edges: NDArray[np.integer], rate: float) -> Configuration:
        """Both modules during a burst at ``rate``, Hz, whose samples saw the edges (T,)."""
        return self._modulators.configuration(panel, edges, rate)

    def on_detector(
        self,
        panel: Panel,
        angles: Array,
        starts: Array,
        configuration: Configuration,
        stage: Array | None = None,
    ) -> Array:
        """Light on the detector (N, S), W, in each segment of bursts that start at times (N,)."""
        optics = self.settings.optics
        paths = free_space.with_stray(
            self.paths(panel, angles, stage), optics, arm_open=not panel.beam_block_in
        )
        way = self.group_index * paths.range + optics.internal_path
        phase = 4 * np.pi * configuration.frequency / SPEED_OF_LIGHT * way
        times = starts[:, None] + configuration.segments.middle
        drift = self.settings.drive.phase_drift / Drift.RMS * self._phase(times)
        lag = drift - 2 * np.pi * configuration.beat * times
        share = detected(configuration, paths.fraction, phase, lag)
        loss = free_space.outward(optics) * free_space.inward(optics)
        room = free_space.ambient(optics) * configuration.detection
        return self.from_fibre(panel, times) * loss * share + room

    def paths(self, panel: Panel, angles: Array, stage: Array | None = None) -> free_space.Paths:
        """Ways to the scene at optical angles (N, 2), rad, or to the target on the stage.

        ``stage`` (N,), m, are positions of the stage in place of the panel's.
        """
        if panel.flip_mirror_in:
            if stage is None:
                return self._to_stage(panel.stage_position, len(angles))
            ways = [self._to_stage(float(position), 1) for position in stage]
            return free_space.Paths(*(np.concatenate(parts) for parts in zip(*ways, strict=True)))
        if self.scene is None:
            nothing = np.zeros((len(angles), 1))
            return free_space.Paths(nothing, nothing)
        return free_space.trace(self.scene, angles, self.settings, self.seed)

    def _to_stage(self, position: float, count: int) -> free_space.Paths:
        reference = self.settings.reference
        distance = reference.distance + position - reference.stage_zero
        target = Plane(distance, reflectance=reference.reflectance, material=reference.material)
        # behind the flip mirror the beam stands still; another 10 um of stage, another speckle
        beam = np.zeros((count, 2))
        return free_space.trace(target, beam, self.settings, self.seed + 1 + round(position / 1e-5))

    def from_fibre(self, panel: Panel, times: Array) -> Array:
        """Power behind the fibre at times, W; 0 unless laser, shutter and interlock let it pass."""
        laser = self.settings.laser
        if not (panel.laser_on and panel.shutter_open and panel.interlock_closed):
            return np.zeros(times.shape)
        middle = (laser.fibre_low + laser.fibre_high) / 2
        swing = (laser.fibre_high - laser.fibre_low) / 2
        return laser.power * (middle + swing * self._fibre(times))

    def emission(self, panel: Panel) -> NDArray[np.complex128]:
        """Fourier coefficients (K + 1,) of the emission module's waveform as it stands."""
        return self._modulators.emission(panel)
