"""The beat of the two frequencies, averaged coherently over a window.

``phi_2 - k phi_1`` with ``k = round(f_2 / f_1)`` is the phase of a synthetic frequency
``Delta = f_2 - k f_1`` (20 MHz for the prototype), which repeats only after ``c / 2 Delta``. Its
noise is ``f_1 / Delta`` times too large for one pixel to tell the wrap; averages tell more.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines import Estimate, within_range
from cmtof.bounds import wrap_probability
from cmtof.correlation import TAU, centred, phase_from_depth, wrap_length
from cmtof.measurement import Measurement

WINDOW = 41
"""Side of the averaging window, px.

Of 21 to 161 px on 40 views of validation rooms, delta < 1 in %: released 18.0 (best 61: 18.8), full
10.5 (best 31: 10.6); one window serves both protocols, and 41 has the best mean.
"""


class Synthetic(NamedTuple):
    """The synthetic frequency of a pair."""

    multiple: int
    """k: how many times the lower phase is subtracted."""
    frequency: float
    """|f_2 - k f_1|, Hz."""
    sign: int
    """Sign of f_2 - k f_1."""


def synthetic_frequency(low: float, high: float) -> Synthetic:
    """Beat of the higher frequency with the nearest multiple of the lower one.

    Examples
    --------
    >>> synthetic_frequency(7.15e9, 14.32e9)
    Synthetic(multiple=2, frequency=20000000.0, sign=1)
    """
    multiple = round(high / low)
    beat = high - multiple * low
    if beat == 0:
        raise ValueError(
            f"Expected frequencies that are no multiples, got {low:g} and {high:g} Hz. "
            "Detune one of them."
        )
    return Synthetic(multiple, abs(beat), 1 if beat > 0 else -1)


def beat_phasor(measurement: Measurement) -> NDArray[np.complexfloating]:
    """Phasor ``|p_1| |p_2| exp(i (phi_2 - k phi_1))`` of each pixel (H, W), counts^2.

    Zero where a phase or an amplitude is not finite (a masked pixel may be so): such a pixel tells
    nothing, and its NaN would run through every average.
    """
    synthetic = synthetic_frequency(*measurement.frequencies[:2])
    low, high = measurement.phase[:2]
    size = measurement.amplitude[0] * measurement.amplitude[1]
    with np.errstate(invalid="ignore"):
        phasor = size * np.exp(1j * synthetic.sign * (high - synthetic.multiple * low))
    return np.where(np.isfinite(phasor), phasor, 0)


def beat(measurement: Measurement, *, window: int = WINDOW) -> Estimate:
    """Depth of the beat averaged over a ``window`` x ``window`` square, borders reflected.

    The confidence takes the beat's noise from its coherence within the window.

    Parameters
    ----------
    measurement : Measurement
        At two frequencies.
    window : int
        Odd side of the window, px; 1 leaves every pixel alone.

    Raises
    ------
    ValueError
        If the window is not an odd number of at least 1.
    """
    if window < 1 or window % 2 == 0:
        raise ValueError(f"Expected an odd window of 1 px or more, got {window}. Try {WINDOW}.")
    phasor = beat_phasor(measurement)
    mean = box(phasor, window)
    depth = beat_depth(np.angle(mean), measurement)
    power = box(np.abs(phasor) ** 2, window)
    return Estimate(depth, confidence_from_coherence(mean, power, window, measurement))


def box(image: NDArray[Any], window: int, *, beyond: str = "reflect") -> NDArray[Any]:
    """Mean of a real or complex image over a square window; beyond the borders as SciPy has it."""
    from scipy.ndimage import uniform_filter

    if np.iscomplexobj(image):
        real, imaginary = (
            uniform_filter(p, window, mode=beyond) for p in (np.real(image), np.imag(image))
        )
        return real + 1j * imaginary
    return uniform_filter(image, window, mode=beyond)


def beat_depth(phase: NDArray[np.floating], measurement: Measurement) -> NDArray[np.floating]:
    """Depth in the measurement's range, m, of a beat phase, rad (nearest end if outside)."""
    synthetic = synthetic_frequency(*measurement.frequencies[:2])
    middle = sum(measurement.range) / 2
    turns = centred(phase - phase_from_depth(middle, synthetic.frequency)) / TAU
    return within_range(middle + turns * wrap_length(synthetic.frequency), measurement)


def confidence_from_coherence(
    mean: NDArray[np.complexfloating],
    power: NDArray[np.floating],
    window: int,
    measurement: Measurement,
) -> NDArray[np.floating]:
    """Odds that the averaged beat lies within half a wrap.

    Noise across the mean phasor is half of the scatter, over the number of pixels; a single pixel
    has no scatter and is given that of pure noise.
    """
    low, high = (float(f) for f in measurement.frequencies[:2])
    coherent = np.abs(mean) ** 2
    scatter = np.maximum(power - coherent, 0) if window > 1 else power
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = np.sqrt(scatter / (2 * window**2) / coherent)
    return np.nan_to_num(wrap_probability(0, spread, frequencies=(low, high)), nan=0.0)
