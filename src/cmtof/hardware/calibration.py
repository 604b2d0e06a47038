r"""Calibration of a bench: drive amplitudes, resonances, plates, error within a wrap.

With its half-wave plate in the dark a module passes ``(1 - J_0(2 eta)) / 2`` of what it passes at
most, twice what it passes at quadrature. So eta follows from mean light: that at the power meter
for the emission, and for the detection that of the reference target at the detector over it. Light
that leaks in the dark is taken away. The bench is set up; RF is off afterwards.
"""

from collections.abc import Iterable, Sequence
from functools import partial
from itertools import count

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike
from scipy.special import j0

from cmtof.correlation import centred, decode
from cmtof.hardware.bench import Bench
from cmtof.hardware.ranging import sweep, sweep_errors, take_reading
from cmtof.hardware.rig import PLATES
from cmtof.types import Array, Pair

LARGEST = 1.9  # eta, rad, up to which the mean grows


def measure_light(
    bench: Bench,
    module: str,
    angles: Iterable[float],
    drives: Iterable[Pair] = (),
) -> Array:
    """Light (N,) behind a module, first with its plate at angles, degrees, then at RF drives.

    The other module stays at quadrature; drives of Hz and dBm are those at the last angle.
    """
    read = partial(take_reading, bench, "reference", bench.daq.gain(), count(1))
    rf = bench.devices[f"rf_{module}"]
    bench.choose_mode("single")
    bench.turn_rf_off()
    bench.look_at("reference")
    found = []

    def look() -> None:
        power = bench.power_meter.power
        found.append(read().mean() / power if module == "detection" else power)

    for angle in angles:
        bench.turn_plate(module, angle)
        look()
    for frequency, power in drives:
        rf.set_frequency(frequency)
        bench.ramp_up(rf, power)
        look()
    rf.output(False)
    bench.close_and_park()
    return np.array(found)


def drive_amplitudes(bench: Bench, module: str, drives: Iterable[Pair]) -> Array:
    """Drive amplitudes eta (N,), rad, of a module at N drives, each a pair of Hz and dBm."""
    quadrature, dark, *driven = measure_light(bench, module, PLATES.values(), drives)
    share = (np.array(driven) - dark) / (2 * quadrature - 2 * dark)
    eta = np.linspace(LARGEST, 0.0, 2000)
    return np.interp(1 - 2 * share, j0(2 * eta), eta)


def resonance(bench: Bench, module: str, frequencies: Sequence[float]) -> Pair:
    """Resonance and its full width, Hz, of a module, from eta at three or more frequencies, Hz.

    The width is that of a Lorentzian at half power: 1 / eta^2 grows with the square of the
    distance from the resonance.
    """
    drives = [(hertz, bench.rig.power_dbm) for hertz in frequencies]
    curve = Polynomial.fit(
        frequencies, drive_amplitudes(bench, module, drives) ** -2, 2
    )
    (centre,) = curve.deriv().roots()
    return centre, 2 * np.sqrt(2 * curve(centre) / curve.deriv(2)(centre))


def plate(bench: Bench, module: str, angles: Sequence[float]) -> Pair:
    """Correction of a plate's zero, degrees, and extinction ratio of its module.

    They follow from its light at angles, degrees, spread over 45 degrees: up to twice as much
    leaves an emission module as in a scan.
    """
    fit = decode(measure_light(bench, module, angles), 8 * np.deg2rad(angles))
    ratio = (fit.offset + fit.amplitude) / (fit.offset - fit.amplitude)
    return -float(np.rad2deg(centred(fit.phase))) / 8, float(ratio)


def cyclic_error(bench: Bench, offsets: ArrayLike) -> Array:
    """Amplitudes, m, of range errors of 1, 2, ... periods over offsets (N,), m, of whole wraps."""
    seen = sweep(bench, "reference", offsets)
    bench.turn_rf_off()
    error = sweep_errors(
        seen, bench.rig.reference_distance, visits=seen.sizes["position"]
    )
    return 2 * abs(np.fft.rfft(error))[1:] / error.size
