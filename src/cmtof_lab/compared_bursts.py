"""Bursts of the RF demodulator and the interferometer of Table 4, by the simulated one's knobs.

Both look at the reference target, whose light is taken at its mean over the speckle: I and Q as
`RfRanger` has them, without drift, and the interferogram of `Interferometer`, whose breadboard
shakes from burst to burst.
"""

from dataclasses import replace

import numpy as np

from cmtof.correlation import TAU
from cmtof.hardware.plan import BURST_INTERVAL
from cmtof.types import Array, Counts, Numbers
from cmtof_lab.electronics import counts_from_volts, volts_per_watt
from cmtof_lab.instrument import Panel, SimulatedInstrument, amplitude, normals_by_key
from cmtof_lab.interferometer import Interferometer
from cmtof_lab.rf_ranging import RfRanger

QUADRATURES = 9  # purposes of random numbers
SHAKING = 10


def quadratures(
    instrument: SimulatedInstrument,
    panel: Panel,
    labels: Numbers,
    scans: int,
    rate: float,
) -> Counts:
    """Counts (N, 2 scans) of I and Q in turn, at a rate, Hz, behind the photodiode (Sec. 7.4).

    The emission's phase turns both the light and what the drive's own cable picks up.
    """
    drive = panel.emission
    size = abs(amplitude(instrument.settings, drive))
    ranger = RfRanger(settings=replace(instrument.settings, eta=size), time=1 / rate)
    place = instrument.target_distance(panel.stage)
    light = (
        panel.photodiode_lit
        * _brightness(instrument, panel, labels)
        * ranger.power(instrument.settings.reference, place)
    )
    mixed, picked_up = ranger.offsets
    turning = ranger.phasor(light, place) + picked_up * drive.on
    turning *= np.exp(1j * instrument.made_phase(0, np.array(drive.phase)))
    normals = normals_by_key(instrument.seed, QUADRATURES, labels, 2 * scans)
    noise = ranger.noise(light)[:, None] * normals.view(complex)
    return counts_from_volts(
        ranger.output(mixed + turning[:, None] + noise).view(float)
    )


def fringes(
    instrument: SimulatedInstrument,
    panel: Panel,
    labels: Numbers,
    travels: Array,
    scans: int,
    rate: float,
) -> Counts:
    """Counts (N, scans) of the interferogram, at a rate, Hz; the mirror travels by (N,), m."""
    ruler = Interferometer(settings=instrument.settings)
    place = instrument.target_distance(panel.stage)
    seen = ruler.fringes(instrument.settings.reference, place)
    shaken = normals_by_key(instrument.seed, SHAKING, labels, 1)[:, 0]
    way = place + travels + ruler.shaking * shaken
    volts = seen.offset + seen.amplitude * np.cos(2 * TAU / ruler.wavelength * way)
    volts *= _brightness(instrument, panel, labels)
    light = volts / volts_per_watt(instrument.settings)
    return instrument.counts(np.repeat(light[:, None], scans, axis=1), labels, rate)


def _brightness(
    instrument: SimulatedInstrument, panel: Panel, labels: Numbers
) -> Array:
    """Light on the target (N,) over its mean while the fibre drifts; 0 where none passes."""
    settings = instrument.settings
    mean = settings.laser_power * settings.fibre
    light = instrument.from_fibre(panel, BURST_INTERVAL * labels)
    return panel.target_in_beam * light / mean
