"""RF demodulation: slopes of its SNR, the mixer, bounds, and what a day does."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose
from pytest import approx, mark

from cmtof.bounds import phase_spread
from cmtof.correlation import TAU, centred
from cmtof_lab.rf_ranging import (
    RfRanger,
    correct_quadratures,
    rf_image,
    skew_quadratures,
)
from cmtof_lab.settings import TwinSettings
from cmtof_lab.sweep import POSITIONS
from cmtof_lab.targets import MIRROR, PLATE, Plane


def test_snr_goes_with_the_square_of_light_and_with_light_beyond_the_shot_noise():
    def slope(power):
        low, high = RfRanger().snr([power, 2 * power])
        return np.log2(high / low)

    assert slope(1e-9) == approx(2, abs=1e-4)
    assert slope(1e4) == approx(1, abs=2e-3)


def test_noise_is_the_closed_form_of_thermal_and_shot_noise():
    """Behind an amplifier of high gain and no noise figure only these are left."""
    receiver = RfRanger(noise_figure=0.0, amplifier_gain=120.0, dark_current=0.0)
    assert receiver.noise_factor == approx(1, abs=1e-6)
    thermal = 1.380649e-23 * 290 * 50 / receiver.time
    assert receiver.noise(0.0) ** 2 == approx(thermal, rel=1e-6)
    shot = receiver.noise(1e-3) ** 2 - receiver.noise(0.0) ** 2
    assert shot == approx(2 * 1.602176634e-19 * 0.2e-3 * 50**2 / receiver.time)
    friis = RfRanger(amplifier_gain=10.0, filter_loss=0.0, mixer_noise_figure=10.0)
    assert friis.noise_factor == approx(10**0.3 + 9 / 10)


def test_an_imbalance_errs_twice_a_turn_and_is_taken_away(gain=0.9, error=-0.2):
    angle = np.linspace(0, TAU, 400, endpoint=False)
    true = 2 * np.exp(1j * angle)
    read = skew_quadratures(true, gain, error)
    assert_allclose(read.imag, 2 * gain * np.sin(angle + error))
    assert_allclose(correct_quadratures(read, gain, error), true)
    wrong = centred(np.angle(read) - angle)
    assert abs(np.fft.rfft(wrong - wrong.mean())).argmax() == 2


@mark.parametrize("reflectance", [1e-3, 1e-6])
def test_sweep_follows_the_law_of_a_noisy_phase_where_nothing_drifts(reflectance):
    """8000 readings, each day with a zero and an offset of better readings."""
    settings = TwinSettings.ideal(noise=True)
    target = replace(MIRROR, reflectance=reflectance)
    ranger = RfRanger(settings=settings, drift=0.0, stage_error=0.0)
    error = ranger.sweep(target, np.zeros(400), repeats=20, seed=1) - target.distance
    linear = ranger.bound(target, [0.0])[0] * ranger.phase(1.0)
    linear *= np.sqrt(1 + 1 / 800 + 1 / 100)
    expected = phase_spread(linear) if linear > 0.05 else linear
    assert error.std() * ranger.phase(1.0) == approx(expected, rel=0.04)


def test_calibration_helps_a_mirror_and_the_offset_hides_a_plate():
    def rms(ranger):
        error = ranger.sweep(MIRROR, POSITIONS, repeats=20, seed=2) - POSITIONS
        return np.sqrt(((error - MIRROR.distance) ** 2).mean())

    assert rms(RfRanger()) < 0.3 * rms(RfRanger(calibrated=False))
    # without calibration the offset is all there is: the reading stands still
    stuck = RfRanger(calibrated=False, visits=1).sweep(
        PLATE, POSITIONS, repeats=5, seed=2
    )
    assert_allclose(stuck, PLATE.distance, atol=20e-6)


def test_image_has_the_noise_of_the_ranging_instrument():
    ranger = RfRanger(settings=TwinSettings(speckle=False, laser_power=10.0))
    phase = rf_image(ranger, Plane(0.3), np.zeros((100, 100, 2)), seed=1)
    bound = ranger.bound(PLATE, [0.3 - PLATE.distance])[0] * ranger.phase(1.0)
    assert bound < 0.1  # small enough for the bound to hold
    assert centred(phase - ranger.phase(0.3)).std() == approx(bound, rel=0.03)
