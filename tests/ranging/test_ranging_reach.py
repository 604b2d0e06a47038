"""Closed forms of the reach against the instrument's own bound, limits and simulated bursts."""

from dataclasses import replace

import numpy as np
import pytest

from cmtof.bounds import wrap_probability_law
from cmtof.constants import FREQUENCIES
from cmtof.instrument.budget import photon_budget
from cmtof.instrument.settings import TwinSettings
from cmtof.ranging.optical import OpticalRanger
from cmtof.ranging.reach import (
    beat_right,
    depth_noise,
    levels,
    noisy_only,
    simulated_errors,
    tuned,
)
from cmtof.ranging.target import StageTarget, collected_power

RANGERS = {mode: noisy_only(OpticalRanger(mode=mode)) for mode in ("single", "doubled")}


@pytest.mark.parametrize("mode", RANGERS)
@pytest.mark.parametrize("phases, samples", [(4, 80), (16, 20), (16, 200)])
def test_closed_form_is_the_instruments_bound(mode, phases, samples):
    ranger = replace(RANGERS[mode], phases=phases, samples=samples)
    ranges = np.array([0.6, 1.5, 4.0])
    bound = ranger.bound(StageTarget(), ranges - 0.6)
    # with four phases the third harmonic passes for the fundamental: (J_3 / J_1)^2 of it
    allowed = 0.02 if phases == 4 else 2e-3
    np.testing.assert_allclose(depth_noise(ranger, ranges), bound, rtol=allowed)


@pytest.mark.parametrize("mode", RANGERS)
@pytest.mark.parametrize("distance", [0.6, 3.0])
def test_simulated_bursts_reach_the_closed_form(mode, distance):
    errors = simulated_errors(RANGERS[mode], distance, count=4000, seed=8)
    # 4000 draws tell a standard deviation to 1.1 %
    assert errors.std() == pytest.approx(float(depth_noise(RANGERS[mode], distance)), rel=0.03)
    assert abs(errors.mean()) < 5 * errors.std() / np.sqrt(4000) + 2e-6


def test_levels_are_those_of_the_budget_up_to_the_leaks_of_the_splitters():
    lines = {line.name: line.value for line in photon_budget(TwinSettings(), distance=0.6)}
    found = levels(OpticalRanger(), 0.6)
    assert found.light == pytest.approx(lines["On the detector"], rel=0.02)
    assert found.room == pytest.approx(lines["Room light on the detector"], rel=0.02)
    # the budget takes all 20 samples of a phase and no memory of the filters
    assert found.phase_noise == pytest.approx(lines["Phase noise of a point"], rel=0.2)


def test_levels_are_behind_the_modulators_what_collected_power_is_before():
    settings = TwinSettings.ideal()
    found = levels(OpticalRanger(settings), [0.6, 2.0])
    power = collected_power(settings, StageTarget(), [0.6, 2.0])
    np.testing.assert_allclose(found.light, power / 2, rtol=1e-9)  # mean of the detection is 1/2


def test_limits_of_much_and_little_light():
    ranger = RANGERS["single"]
    open_end = replace(ranger.settings.detector, saturation=1e9, converter_noise=0.0)
    dark = replace(ranger.settings.optics, ambient_radiance=0.0)
    endless = replace(ranger, settings=replace(ranger.settings, detector=open_end, optics=dark))
    far = depth_noise(endless, [400.0, 800.0])
    near = depth_noise(endless, [0.02, 0.04])
    assert far[1] / far[0] == pytest.approx(4, rel=1e-3)  # amplifier: as 1/power
    assert near[1] / near[0] == pytest.approx(2, rel=1e-2)  # photons: as 1/sqrt(power)


def test_bright_targets_saturate_and_a_grey_filter_levels_the_noise():
    found = levels(OpticalRanger(), 0.6, [1e-3, 0.5, 1.0])
    near = levels(OpticalRanger(), [0.15, 0.05], 0.5)
    assert not found.saturated.any() and near.saturated.all()
    assert found.dimming[0] == 1 and (near.dimming < 0.5).all()
    assert near.phase_noise[0] == pytest.approx(near.phase_noise[1], rel=5e-3)  # room light


def test_room_light_costs_precision():
    settings = TwinSettings()
    bright = replace(settings, optics=replace(settings.optics, ambient_radiance=10.0))
    dim = levels(OpticalRanger(settings), 2.0).phase_noise
    assert levels(OpticalRanger(bright), 2.0).phase_noise > 1.5 * dim


@pytest.mark.parametrize("mode", RANGERS)
def test_another_frequency_keeps_the_phase_and_scales_the_range(mode):
    slow = tuned(RANGERS[mode], 1e9)
    ratio = RANGERS[mode].frequency / 1e9
    assert slow.frequency == 1e9
    assert depth_noise(slow, 1.0) == pytest.approx(
        ratio * depth_noise(RANGERS[mode], 1.0), rel=1e-3
    )
    errors = simulated_errors(slow, 1.0, count=2000, seed=1)
    assert errors.std() == pytest.approx(float(depth_noise(slow, 1.0)), rel=0.06)


def test_beat_is_right_as_often_as_the_law_says():
    rng, noise, count = np.random.default_rng(2), 0.02, 200_000
    errors = noise * rng.standard_normal((2, count))
    found = beat_right(*errors, frequencies=FREQUENCIES).mean()
    law = wrap_probability_law(noise, noise, frequencies=FREQUENCIES)
    assert found == pytest.approx(law, abs=4 * np.sqrt(law / count))
    assert beat_right(0.0, 0.0, frequencies=FREQUENCIES)
    assert not beat_right(0.0, 0.02, frequencies=FREQUENCIES)


def test_ranges_must_be_positive():
    with pytest.raises(ValueError, match="Expected ranges above 0 m, got -1"):
        levels(OpticalRanger(), [1.0, -1.0])
