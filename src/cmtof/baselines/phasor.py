"""Two close frequencies and a look-up of their phases (Gupta et al. 2015), pixel by pixel.

Light that took detours vanishes at high frequencies, so both are high, and their beat is low. The
look-up goes through all depths z of the range for the vector
``[cos phi_1, sin phi_1, cos phi_2, sin phi_2]`` nearest to the measured one. Weighted by the
amplitudes a, and but for a constant, the squared distance is minus twice the match

    F(z) = a_1 cos(phi_1(z) - phi_1) + a_2 cos(phi_2(z) - phi_2)

which is also the likelihood of z. F has one peak for each wrap, and the less the wrap's misfit of
the beat, the higher it is. Thus two stages find the same depth as tens of thousands of entries of
the table: the beat tells the few wraps to look at, the high-frequency phases the depth of each.
"""

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines.beat import beat_depth
from cmtof.baselines.method import Estimate, within_range, wraps_in_range
from cmtof.baselines.noise import phase_noise
from cmtof.bounds import wrap_probability
from cmtof.correlation import TAU, depth_from_phase, phase_from_depth, wrap_length
from cmtof.measurement import Measurement


def phasor(measurement: Measurement) -> Estimate:
    """Depth in range whose pair of phasors is the nearest to the measured pair.

    The confidence is the odds that noise leaves the beat within half a wrap,
    ``erf(1 / (2 sqrt2 sigma_n))`` with ``sigma_n = 161 sigma_phi`` at 7.15 and 7.16 GHz.

    Parameters
    ----------
    measurement : Measurement
        At two frequencies so close that their beat does not repeat within the range.

    Raises
    ------
    ValueError
        If the beat repeats within the range.
    """
    check_pair(measurement)
    noise = phase_noise(measurement)
    known = np.isfinite(noise).all(axis=0)
    phase = np.where(known, measurement.phase[:2].astype(float), 0)
    amplitude = np.where(known, measurement.amplitude[:2].astype(float), 0)
    best = np.full(measurement.shape, np.mean(measurement.range))
    height = np.where(known, -np.inf, np.inf)  # what tells nothing stays in the middle
    for wraps in _candidates(measurement, phase):
        depth = within_range(peak_depth(measurement, phase, amplitude, wraps), measurement)
        found = match(measurement, phase, amplitude, depth)
        best, height = np.where(found > height, depth, best), np.maximum(found, height)
    return Estimate(best, _confidence(measurement, noise))


def check_pair(measurement: Measurement) -> None:
    """Raise a ValueError unless the beat of the pair covers the measurement's range."""
    low, high = measurement.frequencies[:2]
    covered = float(wrap_length(high - low))
    extent = measurement.range[1] - measurement.range[0]
    if round(high / low) != 1 or covered < extent * (1 - 1e-9):
        raise ValueError(
            f"Expected two close frequencies whose beat covers the range of {extent:.3f} m, got "
            f"{low:g} and {high:g} Hz, which cover {covered:.3f} m. Measure others, for instance "
            "simulate with --frequencies 7.15e9,7.16e9."
        )


def match(
    measurement: Measurement,
    phase: NDArray[np.floating],
    amplitude: NDArray[np.floating],
    depth: NDArray[np.floating],
) -> NDArray[np.floating]:
    """F at depths (H, W), m, for phases, rad, and amplitudes, counts, (2, H, W)."""
    low, high = measurement.frequencies[:2]
    first = amplitude[0] * np.cos(phase_from_depth(depth, low) - phase[0])
    return first + amplitude[1] * np.cos(phase_from_depth(depth, high) - phase[1])


def peak_depth(
    measurement: Measurement,
    phase: NDArray[np.floating],
    amplitude: NDArray[np.floating],
    wraps: NDArray[np.floating],
) -> NDArray[np.floating]:
    """Depth (H, W), m, of the peak of F within half a wrap of the lower frequency's phase.

    Were the frequencies equal, the peak would stand where the two phasors' sum points to; one
    step of Newton's takes the difference into account.
    """
    low, high = measurement.frequencies[:2]
    depth = depth_from_phase(phase[0] + TAU * wraps, low)
    apart = phase[1] - phase_from_depth(depth, high)
    depth = depth + depth_from_phase(
        np.angle(amplitude[0] + amplitude[1] * np.exp(1j * apart)), low
    )
    slope, bend = np.zeros(depth.shape), np.zeros(depth.shape)
    for i, frequency in enumerate((low, high)):
        off = phase_from_depth(depth, frequency) - phase[i]
        slope -= amplitude[i] * frequency * np.sin(off)
        bend += amplitude[i] * frequency**2 * np.cos(off)
    step = np.where(bend > 0, slope / np.where(bend > 0, bend, 1), 0) * low
    return depth + depth_from_phase(np.clip(step, -0.1, 0.1), low)


def _candidates(
    measurement: Measurement, phase: NDArray[np.floating]
) -> list[NDArray[np.floating]]:
    """Wraps to look at (H, W): the beat's and its neighbours, and the ends of the range.

    At the ends a peak may be cut, so that it is as high as an inner one of less misfit.
    """
    low = measurement.frequencies[0]
    depth = beat_depth(phase[1] - phase[0], measurement)
    middle = np.rint((phase_from_depth(depth, low) - phase[0]) / (TAU))
    ends = (wrap + step for wrap in wraps_in_range(measurement) for step in (-1, 0))
    return [middle, middle - 1, middle + 1, *(np.full(middle.shape, float(n)) for n in ends)]


def _confidence(measurement: Measurement, noise: NDArray[np.floating]) -> NDArray[np.floating]:
    """Odds of the right wrap from the phase noise, no less than those of a guess."""
    low, high = measurement.frequencies[:2]
    first, last = wraps_in_range(measurement)
    bounded = np.clip(noise, 1e-9, 1e9)
    odds = wrap_probability(bounded[0], bounded[1], frequencies=(low, high))
    return np.maximum(odds, 1 / (last - first + 1))
