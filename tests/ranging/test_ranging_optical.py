"""The all-optical range finder: equal to a scan over the wire, and as precise as its bound."""

from dataclasses import replace

import numpy as np
import pytest

from cmtof.correlation import TAU, wrap_length
from cmtof.instrument.electronics import chain, volts_from_counts
from cmtof.instrument.optics import group_index, with_stray
from cmtof.instrument.settings import Detector, TwinSettings
from cmtof.ranging.burst_noise import mean_weights, phase_covariance
from cmtof.ranging.optical import OpticalRanger, without_errors
from cmtof.ranging.target import StageTarget

NOISY = replace(TwinSettings.ideal(), noise=True)
TARGETS = {"diffuse": StageTarget(), "mirror": StageTarget.mirror()}
STEPS = np.linspace(0, 1e-3, 5)


# --- noise against its bound -------------------------------------------------------------------


@pytest.mark.parametrize(("mode", "what"), [("single", "diffuse"), ("doubled", "mirror")])
def test_noise_alone_meets_the_bound(mode, what):
    """5000 estimates tell a standard deviation to 1.0 %: 3 % are three of its own."""
    ranger = OpticalRanger(NOISY, mode, calibration="perfect", stage_error=0.0)
    places = np.linspace(0, 1e-3, 100)
    errors = ranger.sweep(TARGETS[what], places, repeats=50, seed=1) - 0.6 - places
    pulls = errors / ranger.bound(TARGETS[what], places)
    assert np.sqrt(np.mean(pulls**2)) == pytest.approx(1, abs=0.03)


def test_the_noise_of_the_calibration_counts():
    single = OpticalRanger(NOISY)
    alone = replace(single, calibration="perfect").bound(StageTarget(), STEPS)
    for readings in (1, 4):
        both = replace(single, calibration_readings=readings).bound(StageTarget(), STEPS)
        np.testing.assert_allclose(both**2, alone**2 + alone[0] ** 2 / readings)


def test_many_calibration_readings_leave_little_of_its_noise():
    ranger = OpticalRanger(NOISY, calibration_readings=50, stage_error=0.0)
    errors = ranger.sweep(StageTarget(), STEPS, repeats=30, seed=2) - 0.6 - STEPS
    pulls = errors / ranger.bound(StageTarget(), STEPS)
    assert np.sqrt(np.mean(pulls**2)) == pytest.approx(1, abs=5 / np.sqrt(2 * pulls.size))


def test_shot_noise_falls_with_the_root_of_the_light():
    quiet = replace(Detector(), noise_density=0.0, converter_noise=0.0)
    ranger = OpticalRanger(replace(NOISY, detector=quiet), calibration="perfect")
    weak, strong = (ranger.bound(StageTarget(reflectance=share), [0.0])[0] for share in (0.1, 0.4))
    assert weak / strong == pytest.approx(2, rel=2e-3)  # rounding stays


def test_twice_the_samples_or_phases():
    ranger = OpticalRanger(NOISY)
    once = ranger.bound(StageTarget(), [0.0])
    longer = replace(ranger, samples=36).bound(StageTarget(), [0.0])
    more = replace(ranger, phases=32).bound(StageTarget(), [0.0])
    np.testing.assert_allclose(once / longer, np.sqrt(2), rtol=0.01)
    np.testing.assert_allclose(once / more, np.sqrt(2), rtol=0.01)


def test_covariance_of_phase_means_is_that_of_the_linear_chain():
    """Every normal number's way to every sample, added up."""
    filters, weights = chain(Detector(), 1 / 24000), mean_weights(3, 5, 2)
    density = np.linspace(1.0, 4.0, 15)[None]
    normals = np.eye(3 * 16)
    each = filters.run(np.zeros((48, 15)), np.repeat(density, 48, axis=0), normals)
    means = each @ weights.T
    found = phase_covariance(filters, density, weights)
    np.testing.assert_allclose(found[0], means.T @ means, rtol=1e-9, atol=1e-18)


# --- systematic errors -------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ["single", "doubled"])
@pytest.mark.parametrize("what", TARGETS)
@pytest.mark.parametrize("calibration", ["reading", "perfect"])
def test_without_errors_the_range_is_right(mode, what, calibration):
    """What is left is rounding to counts and the sub-rays of the spot."""
    ranger = OpticalRanger(
        without_errors(TwinSettings()), mode, calibration=calibration, stage_error=0.0,
        temperature_error=0.0, pressure_error=0.0,
    )  # fmt: skip
    errors = ranger.sweep(TARGETS[what], STEPS, repeats=1, seed=0) - 0.6 - STEPS
    # 280 counts of amplitude are what the doubled mode leaves of a plate's light
    assert np.abs(errors).max() < (3e-6 if (mode, what) == ("doubled", "diffuse") else 1e-6)


def test_air_that_nobody_corrects():
    settings = without_errors(TwinSettings())
    index = group_index(settings.air, settings.laser.wavelength)
    perfect = OpticalRanger(settings, air="ignored", calibration="perfect")
    error = (perfect.sweep(StageTarget(), STEPS, repeats=1, seed=0) - 0.6 - STEPS).mean()
    assert error == pytest.approx((index - 1) * 0.6, rel=0.01)
    # a reading of the same target carries it away, but for the travel
    reading = replace(perfect, calibration="reading")
    assert np.abs(reading.sweep(StageTarget(), STEPS, repeats=1, seed=0) - 0.6 - STEPS).max() < 2e-6


def test_thermometer_and_barometer():
    """(n - 1) z times the relative errors, over 100 days."""
    settings = without_errors(replace(TwinSettings.ideal(), air=TwinSettings().air))
    ranger = OpticalRanger(
        settings, calibration="perfect", temperature_error=5.0, pressure_error=0.0, stage_error=0.0
    )
    errors = ranger.sweep(StageTarget(), [0.0], repeats=100, seed=3) - 0.6
    expected = (group_index(settings.air, 532e-9) - 1) * 0.6 * 5.0 / 293.15
    assert errors.std() == pytest.approx(expected, rel=5 / np.sqrt(200))


def test_coaxial_light_makes_a_cyclic_error():
    """To first order its share of the light, as a phase; the worst of a wrap."""
    optics = replace(without_errors(TwinSettings()).optics, back_fraction=1e-8)
    settings = replace(without_errors(TwinSettings()), optics=optics)
    ranger = OpticalRanger(settings, calibration="perfect", stage_error=0.0)
    places = np.linspace(0, wrap_length(ranger.frequency), 24, endpoint=False)
    errors = ranger.sweep(StageTarget(), places, repeats=1, seed=0)[0] - 0.6 - places
    world = ranger.world(StageTarget(), 0)
    ways = with_stray(
        world.light.paths(ranger.panel(), np.zeros((1, 2)), np.array([0.025])), optics,
        arm_open=False,
    )  # fmt: skip
    share = 1e-8 / ways.fraction[0, :-1].sum()
    expected = share * wrap_length(ranger.frequency) / TAU
    assert np.abs(errors).max() == pytest.approx(expected, rel=0.1)


def test_stage_errors_are_errors_of_the_estimate():
    ranger = OpticalRanger(TwinSettings.ideal(), calibration="perfect", stage_error=2e-5, level=1.0)
    errors = ranger.sweep(StageTarget(), np.linspace(0, 1e-3, 50), repeats=8, seed=4)
    errors = errors - 0.6 - np.linspace(0, 1e-3, 50)
    assert errors.std() == pytest.approx(2e-5, rel=5 / np.sqrt(800))


# --- the instrument before its target ----------------------------------------------------------


def test_the_grey_filter_keeps_a_mirror_within_range():
    for mode in ("single", "doubled"):
        ranger = OpticalRanger(without_errors(TwinSettings()), mode, level=0.5)
        world = ranger.world(StageTarget.mirror(), 0)
        counts = ranger.counts(world, ranger.panel(), [0.0], [1])
        peak = volts_from_counts(counts, volts_range=10.0).max()
        assert peak == pytest.approx(0.5 * 4.1, rel=0.01)
        assert ranger.grey_filter(StageTarget.mirror()) < 1e-3
        assert ranger.grey_filter(StageTarget()) == 1


def test_repeats_are_days_of_their_own():
    ranger = OpticalRanger()
    three = ranger.sweep(StageTarget(), STEPS, repeats=3, seed=9)
    np.testing.assert_array_equal(
        ranger.sweep(StageTarget(), STEPS, repeats=1, seed=9)[0], three[0]
    )
    assert len({row.tobytes() for row in three}) == 3
    assert not np.array_equal(ranger.sweep(StageTarget(), STEPS, repeats=1, seed=8)[0], three[0])
    assert np.abs(three - 0.6 - STEPS).max() < 5e-5


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (lambda: OpticalRanger(mode="tripled"), "Expected all-optical ranger.mode out of single"),
        (lambda: OpticalRanger(settle=20), "Expected fewer than 20 samples of a phase"),
        (lambda: OpticalRanger(calibration="none"), "calibration out of reading, perfect"),
        (lambda: OpticalRanger().bound(StageTarget(), []), r"Expected finite stage positions \(P,"),
        (
            lambda: OpticalRanger().sweep(StageTarget(), [0.0], repeats=0, seed=0),
            "Expected at least 1 repeat, got 0",
        ),
        (
            lambda: OpticalRanger().world(StageTarget(), 0).bursts(
                OpticalRanger().panel(), [[0, 0]], stage=[0.0, 1.0]
            ),
            "Expected 1 stage positions, one a direction",
        ),
    ],
)  # fmt: skip
def test_bad_input(act, message):
    with pytest.raises(ValueError, match=message):
        act()
