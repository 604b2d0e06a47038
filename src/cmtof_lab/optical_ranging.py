r"""The all-optical range finder: the simulated instrument itself before the target of Fig. 13.

A reading is one burst of 16 phases x 20 samples at 24 kS/s (13.3 ms). With L the light through open
modulators, :math:`\bar w` and :math:`w_1` mean and fundamental of the product of their waveforms, u
the room's light, S volts per watt, d the noise density at the mean output and B the bandwidth of
the fundamental of K means of N samples behind the filters,

.. math:: U(\psi) = S\,(L\bar w + u) + S L w_1\cos(\phi+\psi), \qquad
          \sigma_\phi^2 = \frac{d\,B + 2\sigma_{adc}^2/KN}{(S L w_1)^2} .
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike
from scipy.signal import correlate

from cmtof.correlation import TAU, depth_from_phase
from cmtof.hardware.plan import BURST_INTERVAL
from cmtof.hardware.ranging import range_errors, stepped_phases
from cmtof.hardware.reduction import drive_phases, nominal_psi
from cmtof.hardware.rig import MODES, PLATES, SAMPLE_RATE
from cmtof.types import Array, Arrays, Counts, Numbers, Pair
from cmtof_lab.electronics import SLOPE, Chain, density, volts_per_watt
from cmtof_lab.instrument import Panel, RfKnobs, SimulatedInstrument
from cmtof_lab.optics import ambient, emission_mean
from cmtof_lab.settings import TwinSettings
from cmtof_lab.sweep import WRAP, PhaseRanger, collected_power, zero_positions
from cmtof_lab.targets import Plane


@dataclass(frozen=True)
class OpticalRanger(PhaseRanger):
    """All-optical correlation at 7.15 ("single") or 14.32 GHz ("doubled") (Sec. 7, 8.2).

    Its zero is set as in a scan; a single visit stands at stage position 0.
    """

    phases: int = 16  # K (Sec. 7.2)
    samples: int = 20  # of each phase (Sec. 7.2)
    # Of them are dropped while the filters settle, as in the default rig
    settle: int = 4
    air_change: Pair = (0.5, 100.0)  # K, Pa since the zero, rms (assumed)
    # Share of the detector's range that the crest may reach (assumed)
    level: float = 0.5

    def panel(self) -> Panel:
        """Knobs of the instrument while it ranges: mode set, table armed, target in the beam."""
        drive = RfKnobs(
            True, self.frequency / MODES[self.mode], self.settings.drive_power
        )
        plate = np.deg2rad(PLATES[self.mode])
        return Panel(
            drive,
            replace(drive, table=drive_phases(self.phases, self.mode)),
            plate,
            plate,
            laser_on=True,
            shutter_open=True,
            target_in_beam=True,
            clock_on=True,
        )

    def before(self, target: Plane) -> TwinSettings:
        """Settings with the target on the stage; the grey filter is a lower quantum efficiency."""
        light = collected_power(self.settings, target, target.distance, self.mode)
        efficiency = self.settings.efficiency * float(self.dimming_and_noise(light)[0])
        return replace(self.settings, efficiency=efficiency, reference=target)

    def counts(
        self, instrument: SimulatedInstrument, positions: Array, labels: Numbers
    ) -> Counts:
        """Raw counts (P, K x N) of bursts with labels (P,) at stage positions (P,), m."""
        return instrument.bursts(
            replace(self.panel(), stage=positions + self.settings.stage_zero),
            np.zeros((positions.size, 2)),
            labels=labels,
            pulses=np.arange(self.phases * self.samples) // self.samples,
        )

    def phase(self, counts: ArrayLike) -> Array:
        """Wrapped phases (P,), rad, of raw counts (P, K x N)."""
        bursts = np.reshape(counts, (-1, self.phases, self.samples))
        return stepped_phases(bursts[..., self.settle :].mean(-1))

    def day(self, target: Plane, positions: Array, rng: Generator) -> Array:
        """Estimated ranges (P,), m, of one sweep, unwrapped to the known wrap."""
        settings = self.before(target)
        stated = np.append(zero_positions(self.visits), positions)
        index = settings.group_index
        instrument = SimulatedInstrument(
            _another_day(settings, rng), seed=int(rng.integers(2**63))
        )
        thicker = self._air_change(settings, rng)
        place = stated + self.stage_error * rng.standard_normal(stated.size)
        labels = 1 + np.rint(self.times(positions.size) / BURST_INTERVAL).astype(int)
        phases = self.phase(self.counts(instrument, place, labels))
        ranges = index * (target.distance + stated)
        off = range_errors(phases, ranges, self.frequency, visits=self.visits)[
            self.visits :
        ]
        return (target.distance + positions) * (1 + thicker / index) + off / index

    def _air_change(self, settings: TwinSettings, rng: Generator) -> float:
        """Change of the air's index since the zero; the lab still divides ranges by the old one."""
        warmer, denser = rng.standard_normal(2) * self.air_change
        change = denser / max(settings.pressure, 1.0) - warmer / settings.temperature
        return (settings.group_index - 1) * change

    def bound(self, target: Plane, positions: ArrayLike) -> Array:
        """Cramer-Rao bound on one estimate (P,), m: noise alone, that of the zero included."""
        light = collected_power(
            self.settings, target, np.add(target.distance, positions), self.mode
        )
        noise = self.dimming_and_noise(light)[1] * np.sqrt(1 + 1 / self.visits)
        return depth_from_phase(noise, self.frequency)

    def dimming_and_noise(self, collected: ArrayLike) -> Arrays:
        """Grey filter's transmission for collected light (...), W, and noise of a phase, rad.

        The filter keeps the maximum within the detector's range; no speckle.
        """
        settings = self.settings
        # the detection's is alike
        wave = SimulatedInstrument(settings).emission(self.panel())
        opened = np.divide(collected, emission_mean(settings, self.mode))
        passed = wave[0].real
        mean = opened * passed**2 + ambient(settings) * passed
        amplitude = opened * 2 * abs(wave[MODES[self.mode]]) ** 2
        crest = volts_per_watt(settings) * (mean + amplitude)
        dimming = np.minimum(1.0, self.level * settings.saturation / crest)
        per_watt = volts_per_watt(settings) * dimming
        counts = settings.converter_noise**2 + 1 / 12
        kept = self.phases * (self.samples - self.settle)
        analog = density(settings, per_watt * mean) * self._bandwidth()
        variance = analog + 2 / kept * counts * SLOPE**2
        return dimming, np.sqrt(variance) / (per_watt * amplitude)

    def _bandwidth(self) -> float:
        """Variance, V^2, of one quadrature of the fundamental per one-sided density, V^2/Hz."""
        count = self.phases * self.samples
        memory = Chain(self.settings, 1 / SAMPLE_RATE).memory(count)
        kept = np.arange(self.samples) >= self.settle
        tone = np.outer(np.exp(-1j * nominal_psi(self.phases)), kept).ravel()
        overlap = correlate(tone, tone)[count - 1 :].real
        # both ways of a lag, and none at lag 0
        memory[0] /= 2
        scale = 2 / (self.phases * kept.sum())
        return scale**2 * (overlap @ memory)


def _another_day(settings: TwinSettings, rng: Generator) -> TwinSettings:
    """Settings whose phases of paths, cables and leaks, unknown on another day, are drawn again."""
    path, back, cable, leak = rng.random(4)
    return replace(
        settings,
        internal_path=settings.internal_path + WRAP * path,
        back_range=settings.back_range - WRAP * back,
        phase_offset=TAU * cable,
        leakage_phase=TAU * leak,
    )
