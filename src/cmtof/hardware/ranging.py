r"""Three ways to range the target on its stage, as in Fig. 13: readings and their phases.

The all-optical one ("reference") steps the reference phase within a burst. RF demodulation ("rf")
takes I and Q of the fast photodiode as two inputs: what they show without light is taken away, and
a turn of the emission's phase shows by how much Q is too large, g, and off a right angle, e,

.. math:: V = I + i\,\frac{Q / g - I \sin e}{\cos e}.

The interferometer ("interferometer") moves its mirror over half a wavelength, a burst a step.
"""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import count

import numpy as np
from numpy.typing import ArrayLike
from xarray import Dataset

from cmtof.constants import LASER_WAVELENGTH, SPEED_OF_LIGHT
from cmtof.correlation import centred, decode, depth_from_phase, phase_from_depth
from cmtof.hardware.bench import Bench
from cmtof.hardware.plan import DARK_BURSTS
from cmtof.hardware.reduction import Gain, check_brightness, nominal_psi
from cmtof.hardware.rig import MODES
from cmtof.types import Array, Complex

STEPS = 8  # of the interferometer's mirror over half a wavelength
TURN = 16  # phases of the emission that tell the mixer's imbalance
# ways of the light, and the axes (burst, phase, sample) over which a reading is averaged
MEANS = {"reference": (0, 2), "rf": (0, 1, 2), "interferometer": (1, 2)}


def correct_quadratures(reading: Complex, gain: float, error: float) -> Complex:
    """Phasor of a reading I + iQ, corrected for Q's ``gain`` and phase ``error``, rad."""
    i = reading.real
    return i + 1j * ((reading.imag / gain - i * np.sin(error)) / np.cos(error))


def take_reading(bench: Bench, way: str, gain: Gain, labels: Iterator[int]) -> Array:
    """Mean voltages of a reading: by phase or by step of the mirror (K,), or I and Q (2,)."""
    rig = bench.rig
    outputs = [{}]
    if way == "interferometer":
        travels = LASER_WAVELENGTH / 2 * np.arange(STEPS) / STEPS
        volts = (travels / rig.reference_mirror_travel).tolist()
        outputs = [{rig.reference_mirror: one} for one in volts]
    counts = bench.bursts([next(labels) for _ in outputs], outputs)
    samples = counts.reshape(len(outputs), rig.phases, rig.samples_per_phase, -1)
    kept = gain.volts_from_counts(samples[:, :, rig.settle_samples :])
    if way != "rf":
        check_brightness(kept, rig.limit_volts)
    return kept.mean(axis=MEANS[way]).ravel()


def stepped_phases(volts: Array) -> Array:
    """Phases (N,), rad, of readings (N, K) at K reference phases, evenly over a turn."""
    return decode(volts.T, nominal_psi(volts.shape[1])).phase


def calibrated_mixer(
    bench: Bench, read: Callable[[], Array]
) -> Callable[[Array], Array]:
    """Function from I and Q (N, 2), V, to phases (N,), rad, after a calibration of the mixer."""
    bench.listen(*bench.rig.iq_inputs)
    bench.rf_detection.load_table(np.zeros(bench.rig.phases))  # it drives the mixer
    dark = np.mean([read() for _ in range(DARK_BURSTS)], axis=0)
    bench.look_at("rf")
    psi = nominal_psi(TURN)
    turned = []
    for phase in psi.tolist():
        bench.rf_emission.set_phase(phase)
        turned.append(read())
    bench.rf_emission.set_phase(0.0)
    found = decode(np.array(turned), psi)
    gain = found.amplitude[1] / found.amplitude[0]
    error = found.phase[1] - found.phase[0] + np.pi / 2
    return lambda volts: np.angle(
        correct_quadratures((volts - dark) @ [1, 1j], gain, error)
    )


def sweep(
    bench: Bench, way: str, offsets: ArrayLike, *, mode: str = "single", label: int = 1
) -> Dataset:
    """Phases and voltages of the target at offsets (N,), m, by one of three ways of ranging.

    ``way`` is a key of `MEANS`; bursts are numbered from ``label`` on. The dataset holds ``phase``
    (rad), ``volts`` and ``laser_power`` (W) by ``position`` (m), and as attributes
    the frequency, Hz, that belongs to the phase, and the settings. The bench is set up. Raises as a
    scan does, and a ValueError where light saturates the detector.
    """
    if way == "rf" and mode != "single":
        raise ValueError(
            f"Expected RF in the single mode, whose drive is its light's, got {mode}. Choose it."
        )
    read = partial(take_reading, bench, way, bench.daq.gain(), count(label))
    bench.choose_mode(mode)
    frequency = MODES[mode] * bench.rig.drive_frequency(mode)
    phases_of = stepped_phases
    if way == "rf":
        phases_of = calibrated_mixer(bench, read)
    elif way == "interferometer":
        frequency = SPEED_OF_LIGHT / LASER_WAVELENGTH
        bench.turn_rf_off()
    bench.look_at(way)
    volts = []
    powers = []
    for offset in np.asarray(offsets, float).tolist():
        bench.move_target(offset)
        volts.append(read())
        powers.append(bench.metered_power())
    if way != "interferometer":
        bench.check()
    bench.look_at("dark")
    bench.listen(bench.rig.detector_input)
    return Dataset(
        {
            "phase": (
                "position",
                phases_of(np.array(volts)),
                {"units": "rad"},
            ),
            "volts": (("position", "step"), volts, {"units": "V"}),
            "laser_power": ("position", powers, {"units": "W"}),
        },
        {"position": ("position", offsets, {"units": "m"})},
        {
            "way": way,
            "frequency": frequency,
            "settings": bench.rig.as_dict(),
            **bench.about,
        },
    )


def sweep_errors(seen: Dataset, distance: float, *, visits: int) -> Array:
    """Range errors (N,), m, of a `sweep` whose zero is at a distance, m; see `range_errors`."""
    index = seen.attrs["group_index"]
    ranges = index * (distance + seen["position"])
    return (
        range_errors(seen["phase"], ranges, seen.attrs["frequency"], visits=visits)
        / index
    )


def range_errors(
    phases: ArrayLike, ranges: ArrayLike, frequency: float, *, visits: int
) -> Array:
    """Range errors (N,), m, of phases (N,), rad, at true optical ranges (N,), m.

    The mean phase error of the first ``visits`` is taken as the zero.
    """
    off = np.asarray(phases) - phase_from_depth(ranges, frequency)
    zero = np.angle(np.exp(1j * off[:visits]).sum())
    return depth_from_phase(centred(off - zero), frequency)
