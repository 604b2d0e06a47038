"""RF demodulation pixel by pixel: the light of the ranging instrument, its noise, its phases."""

from dataclasses import replace

import numpy as np
import pytest

from cmtof.correlation import centred, phase_from_depth
from cmtof.instrument import optics as free_space
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.targets import Hits, Plane
from cmtof.ranging.rf import FREQUENCY, RfParts, diode_power
from cmtof.ranging.rf_scene import rf_image
from cmtof.ranging.target import StageTarget


def still(power=0.15):
    """No speckle, a spot without size; a laser of some power, W."""
    settings = TwinSettings()
    optics = replace(settings.optics, speckle=False, exit_radius=1e-9, divergence=0.0)
    return replace(settings, optics=optics, laser=replace(settings.laser, power=power))


@pytest.mark.parametrize("mode", ["single", "doubled"])
def test_power_is_that_of_the_ranging_instrument(mode):
    settings = still()
    seen = rf_image(settings, Plane(0.6), np.zeros((2, 3, 2)), seed=0, mode=mode)
    expected = diode_power(settings, RfParts(), StageTarget(), 0.6, mode=mode)
    assert seen.power == pytest.approx(np.full((2, 3), expected), rel=1e-6)


def test_noise_reaches_its_bound():
    settings = still(power=10.0)
    seen = rf_image(settings, Plane(0.3), np.zeros((20000, 2)), seed=1)
    index = free_space.group_index(settings.air, settings.laser.wavelength)
    error = centred(seen.phase - phase_from_depth(index * 0.3, FREQUENCY["single"]))
    assert seen.bound[0] < 0.1  # small enough for the bound to hold
    assert error.std() == pytest.approx(seen.bound[0], rel=0.03)
    assert abs(error.mean()) < 4 * seen.bound[0] / np.sqrt(error.size)


def test_weak_light_tells_nothing():
    seen = rf_image(TwinSettings(), Plane(1.0), np.zeros((4000, 2)), seed=0)
    assert seen.bound[0] > 1
    # speckle is that of one direction: its factor is the same in all
    assert np.ptp(seen.power) == 0
    assert abs(np.exp(1j * seen.phase).mean()) < 0.6


class Nothing:
    material = "diffuse"

    def look(self, directions):
        gone = np.full(directions.shape[:-1], np.nan)
        return Hits(gone, np.zeros(gone.shape), np.zeros(gone.shape))


def test_where_nothing_returns_there_is_no_light():
    seen = rf_image(TwinSettings(), Nothing(), np.zeros((3, 2)), seed=0)
    assert not seen.power.any() and np.isinf(seen.bound).all()
    assert np.isfinite(seen.phase).all()
