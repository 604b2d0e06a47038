"""Interferometer: contrast, counting and its limit, vibration, speckle, bound."""

from dataclasses import replace

import numpy as np
from pytest import approx, mark

from cmtof_lab.interferometer import Interferometer
from cmtof_lab.settings import TwinSettings
from cmtof_lab.targets import MIRROR, PLATE

SILENT = TwinSettings(noise=False, speckle=False)
STEADY = dict.fromkeys(
    ["wavelength_error", "stage_error", "shaking", "temperature_drift"], 0.0
)


def test_contrast_halves_at_the_coherence_length():
    ruler = Interferometer(imbalance=0.0)
    # |gamma|^2 of a Gaussian line is 1/2 at tau = sqrt(2) ln 2 / (pi dnu)
    half = np.sqrt(2) * np.log(2) / (np.pi * ruler.linewidth) * 299792458 / 2
    amplitude = ruler.fringes(MIRROR, [0.6, 0.6 + half])[0]
    assert (amplitude[1] / amplitude[0]) ** 2 == approx(0.5, rel=1e-6)


def test_sweep_reaches_the_bound():
    ruler = Interferometer(settings=TwinSettings(speckle=False), **STEADY)
    places = np.linspace(0, 2e-5, 300)
    found = ruler.sweep(PLATE, places, repeats=20, seed=0)
    error = found - 0.6 - places
    assert error[:, 1:].std() == approx(ruler.bound(PLATE, [0.0])[0], rel=0.04)


@mark.parametrize("margin", [0.99, 1.01])
def test_a_move_is_counted_right_below_a_quarter_wavelength_and_backwards_above(margin):
    ruler = Interferometer(settings=SILENT, **STEADY)
    ruler = replace(ruler, speed=margin * ruler.wavelength / 4 / ruler.reading_time)
    found = ruler.sweep(MIRROR, [0.0, 400 * ruler.stride], repeats=1, seed=0)
    counted = ruler.stride - (margin > 1) * ruler.wavelength / 2
    assert found[0, 1] == approx(0.6 + 400 * counted, abs=1e-12)


def test_fringes_lost_to_vibration():
    """Mean loss of 400 whole sweeps against the closed form."""
    ruler = Interferometer(settings=SILENT, **(STEADY | {"shaking": 120e-9}))
    travel = 400 * ruler.stride
    found = ruler.sweep(MIRROR, [0.0, travel], repeats=400, seed=7)[:, 1] - 0.6
    # rounding leaves the mean alone: vibration at the last reading is symmetric
    lost = np.rint((travel - found) / (ruler.wavelength / 2))
    expected = 400 * ruler.lost_fringes()
    assert expected > 0.5
    assert lost.mean() == approx(expected, abs=4 * lost.std() / 20)
    assert Interferometer(speed=0.0).lost_fringes() == 0
