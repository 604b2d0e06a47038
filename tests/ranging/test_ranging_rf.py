"""RF demodulation: slopes of its SNR, the mixer's closed form, bounds, and what a day does."""

from dataclasses import replace

import numpy as np
import pytest

from cmtof.bounds import phase_spread
from cmtof.constants import FREQUENCY_DOUBLED, FREQUENCY_SINGLE
from cmtof.correlation import centred, depth_from_phase
from cmtof.instrument.settings import TwinSettings
from cmtof.modulator import TwoPassModulator
from cmtof.ranging.rf import (
    Imbalance,
    RfParts,
    RfRanger,
    RfReceiver,
    diode_power,
    modulation_depth,
    seen_share,
)
from cmtof.ranging.rf_settings import Amplifier, Baseband, Mixer, Photodiode
from cmtof.ranging.target import StageTarget, collected_power

POSITIONS = np.linspace(0, 1e-3, 21)
PLAIN = RfReceiver(RfParts.ideal())


def _slope(receiver, power):
    low, high = receiver.snr([power, 2 * power])
    return np.log2(high / low)


# --- noise and bound -------------------------------------------------------------------------


def test_snr_goes_with_the_square_of_light_and_with_light_beyond_the_shot_noise():
    base = Baseband(noise_density=0.0, rate=1e15)  # rounding averages out
    silent = RfReceiver(RfParts.ideal(baseband=base))
    turn = silent.shot_noise_power()
    assert _slope(silent, 1e-6 * turn) == pytest.approx(2, abs=1e-4)
    assert _slope(silent, turn / np.sqrt(2)) == pytest.approx(1.5, abs=0.01)
    assert _slope(silent, 1e3 * turn) == pytest.approx(1, abs=2e-3)


def test_noise_is_the_closed_form_of_thermal_and_shot_noise():
    parts = RfParts(
        amplifier=Amplifier(noise_figure=0.0, gain=80.0), photodiode=Photodiode(dark_current=0.0)
    )
    receiver = RfReceiver(parts)
    assert receiver.noise_factor == pytest.approx(1, abs=1e-6)
    thermal = 1.380649e-23 * 290 * 50 / parts.baseband.time
    assert receiver.noise(0.0) ** 2 == pytest.approx(thermal, rel=1e-6)
    shot = receiver.noise(1e-3) ** 2 - receiver.noise(0.0) ** 2
    assert shot == pytest.approx(2 * 1.602176634e-19 * 0.2e-3 * 50**2 / parts.baseband.time)


def test_friis_by_hand():
    parts = RfParts(
        amplifier=Amplifier(gain=10.0, noise_figure=3.0, filter_loss=0.0),
        mixer=Mixer(noise_figure=10.0),
    )
    assert RfReceiver(parts).noise_factor == pytest.approx(10**0.3 + 9 / 10)


@pytest.mark.parametrize("power", [3e-8, 1e-4])
def test_monte_carlo_reaches_the_bound(power):
    receiver = RfReceiver()
    offset, skew, rng = 1e-4 + 5e-5j, receiver.imbalance, np.random.default_rng(3)
    read = receiver.phasor(np.full(40_000, power), 1.1, 2.0, offset=offset, imbalance=skew, rng=rng)
    known = receiver.phasor(0.0, offset=offset, imbalance=skew)
    error = centred(receiver.estimate(read, offset=known, imbalance=skew).phase - 2.0)
    # 40 000 draws tell a standard deviation to 0.35 %
    assert error.std() == pytest.approx(
        receiver.phase_bound(power, 1.1, offset=abs(offset)), rel=0.03
    )
    assert abs(error.mean()) < 5 * error.std() / 200


def test_weak_light_has_a_uniform_phase_and_the_law_in_between():
    rng = np.random.default_rng(4)
    dark = PLAIN.estimate(PLAIN.phasor(np.full(20_000, 1e-15), rng=rng)).phase
    assert centred(dark).std() == pytest.approx(np.pi / np.sqrt(3), rel=0.02)
    power = 1.5e-9
    some = PLAIN.estimate(PLAIN.phasor(np.full(40_000, power), rng=rng)).phase
    linear = float(PLAIN.phase_bound(power))
    assert linear > 0.3
    assert centred(some).std() == pytest.approx(phase_spread(linear), rel=0.02)


def test_ten_times_the_time_is_ten_times_the_snr():
    base = PLAIN.parts.baseband.time
    assert PLAIN.snr(1e-9, time=10 * base) == pytest.approx(10 * PLAIN.snr(1e-9))


def test_detector_damps_the_doubled_mode():
    ratio = PLAIN.snr(1e-9, frequency=FREQUENCY_DOUBLED) / PLAIN.snr(1e-9)
    damped = (1 + (FREQUENCY_SINGLE / 12e9) ** 2) / (1 + (FREQUENCY_DOUBLED / 12e9) ** 2)
    assert ratio == pytest.approx(damped, rel=1e-3)


def test_levels_and_volts_are_inverse():
    assert PLAIN.volts(0.0) == pytest.approx(np.sqrt(0.1))
    assert PLAIN.level(PLAIN.volts(-37.0)) == pytest.approx(-37.0)


# --- the mixer -------------------------------------------------------------------------------


@pytest.mark.parametrize("gain, error", [(1.06, 0.09), (0.9, -0.2), (1.0, 0.05)])
def test_imbalance_is_what_two_skewed_mixers_read(gain, error):
    skew, angle = Imbalance.of(gain, error), np.linspace(0, 6, 50)
    read = skew.skew(2 * np.exp(1j * angle))
    np.testing.assert_allclose(read.real, 2 * np.cos(angle))
    np.testing.assert_allclose(read.imag, 2 * gain * np.sin(angle + error))
    np.testing.assert_allclose(skew.straighten(read), 2 * np.exp(1j * angle))
    closed = (1 + 2 * gain * np.cos(error) + gain**2) / (1 - 2 * gain * np.cos(error) + gain**2)
    assert skew.rejection == pytest.approx(closed)


def test_cyclic_error_of_an_imbalance_has_two_periods_a_turn():
    skew, angle = Imbalance.of(1.02, 0.0), np.linspace(0, 2 * np.pi, 400, endpoint=False)
    error = centred(np.angle(skew.skew(np.exp(1j * angle))) - angle)
    assert np.abs(error).max() == pytest.approx(1 / np.sqrt(skew.rejection), rel=1e-3)
    assert np.argmax(np.abs(np.fft.rfft(error))) == 2


def test_no_imbalance_rejects_the_image_for_ever():
    assert np.isinf(Imbalance.of(1.0, 0.0).rejection)


# --- light -----------------------------------------------------------------------------------


@pytest.mark.parametrize("mode, angle, order", [("single", 11.25, 1), ("doubled", 22.5, 2)])
def test_modulation_depth_is_the_modulators(mode, angle, order):
    eta = TwinSettings().drive.eta
    module = TwoPassModulator(half_wave_angle=np.deg2rad(angle), eta=eta, frequency=7.15e9)
    w = module.harmonics(4)
    assert modulation_depth(TwinSettings(), mode) == pytest.approx(
        float(2 * abs(w[order]) / w[0].real), rel=1e-3
    )


def test_small_diode_sees_part_of_a_spot_and_all_of_a_mirror():
    settings, parts = TwinSettings(), RfParts()
    share = seen_share(settings, parts, 0.6)
    assert 0.2 < share < 0.6
    wide = RfParts(photodiode=Photodiode(diameter=1e-2))
    assert seen_share(settings, wide, 0.6) == pytest.approx(1)
    diffuse, mirror = StageTarget(), StageTarget.mirror()
    assert diode_power(settings, parts, diffuse, 0.6) == pytest.approx(
        share * collected_power(settings, diffuse, 0.6)
    )
    assert diode_power(settings, parts, mirror, 0.6) == collected_power(settings, mirror, 0.6)


# --- days ------------------------------------------------------------------------------------


def _quiet():
    settings = TwinSettings.ideal()
    return replace(settings, noise=True)


def test_sweep_meets_its_bound_where_nothing_drifts():
    target = StageTarget.mirror(reflectance=1e-3)
    ranger = RfRanger(_quiet(), PLAIN, stage_error=0.0)
    error = ranger.sweep(target, np.zeros(400), repeats=20, seed=1) - target.distance
    bound = ranger.bound(target, [0.0])[0]
    # every day has its own calibration, of a hundredth of the variance
    assert error.std() == pytest.approx(bound * np.sqrt(1.01), rel=0.03)


def test_sweep_follows_the_stage_and_depends_on_the_seed_alone():
    ranger, target = RfRanger(), StageTarget.mirror()
    first = ranger.sweep(target, POSITIONS, repeats=3, seed=5)
    assert first.shape == (3, 21)
    np.testing.assert_array_equal(first, ranger.sweep(target, POSITIONS, repeats=3, seed=5))
    assert np.abs(first - target.distance - POSITIONS).max() < 50e-6
    assert np.abs(first - ranger.sweep(target, POSITIONS, repeats=3, seed=6)).max() > 0


def test_calibration_helps_a_mirror_and_the_offset_hides_a_diffuse_target():
    target, errors = StageTarget.mirror(), {}
    for calibrated in (True, False):
        ranger = RfRanger(calibrated=calibrated)
        error = ranger.sweep(target, POSITIONS, repeats=20, seed=2) - target.distance - POSITIONS
        errors[calibrated] = np.sqrt(np.mean(error**2))
    assert errors[True] < 0.3 * errors[False]
    # without calibration the offset is all there is: the reading stands still
    stuck = RfRanger(calibrated=False).sweep(StageTarget(), POSITIONS, repeats=5, seed=2)
    np.testing.assert_allclose(stuck, StageTarget().distance, atol=20e-6)


def test_diffuse_errors_are_a_fraction_of_a_wrap_even_at_ten_times_the_light():
    settings = TwinSettings()
    bright = replace(settings, laser=replace(settings.laser, power=1.5))
    for one in (settings, bright):
        error = RfRanger(one).sweep(StageTarget(), POSITIONS, repeats=50, seed=0)
        error = error - StageTarget().distance - POSITIONS
        assert 1e-3 < np.sqrt(np.mean(error**2)) < depth_from_phase(np.pi, FREQUENCY_SINGLE)


def test_doubled_mode_runs():
    error = RfRanger(mode="doubled").sweep(StageTarget.mirror(), POSITIONS, repeats=2, seed=0)
    assert np.abs(error - 0.6 - POSITIONS).max() < 50e-6


# --- bad input -------------------------------------------------------------------------------


def test_bad_input_is_named():
    with pytest.raises(ValueError, match="Expected mode single or doubled, got 'both'"):
        RfRanger(mode="both")
    with pytest.raises(ValueError, match="at least 1 repeat, got 0"):
        RfRanger().sweep(StageTarget(), POSITIONS, repeats=0, seed=0)
    with pytest.raises(ValueError, match="integration time above 0 s, got 0"):
        PLAIN.noise(1e-9, time=0.0)
    with pytest.raises(ValueError, match=r"RF Photodiode\.responsivity from 0 to 1, got 2"):
        Photodiode(responsivity=2)
