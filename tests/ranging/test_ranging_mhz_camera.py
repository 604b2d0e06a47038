"""The 100 MHz camera: closed forms, limits, each cause of error alone, noise against its bound."""

from dataclasses import replace

import numpy as np
import pytest

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU, correlation_from_harmonics, phase_from_depth
from cmtof.instrument import optics as free_space
from cmtof.instrument.settings import Optics
from cmtof.instrument.targets import Hits
from cmtof.ranging.mhz_camera import PSI, MhzCamera
from cmtof.ranging.mhz_light import (
    View,
    ambient,
    delay_error,
    pulled_phase,
    ratio_for_pull,
    signal,
)
from cmtof.ranging.mhz_settings import CameraSettings

SHAPE = (24, 24)


def flat(distance=1.0, reflectance=0.5, cosine=1.0, shape=SHAPE, mirrored=0.0):
    images = [np.full(shape, x) for x in (distance, cosine, reflectance)]
    return View(images[0], images[1], images[2], mirrored)


def bias(camera, view):
    """Range error (H, W), m, of images without noise."""
    light = camera.light(view)
    return camera.error(camera.estimate(camera.differences(light)), view.range)


def ideal(**changes):
    return MhzCamera(CameraSettings.ideal(**changes))


# --- light -------------------------------------------------------------------------------------


def test_signal_is_lamberts_share_of_the_light_sent_towards_a_pixel():
    """The same law as the scanning instrument's, which sends all its light to each point."""
    camera, view = ideal(), flat(0.8, 0.3, 0.6)
    s = camera.settings
    aperture = 2 * np.sqrt(s.pupil_area / np.pi)
    share = free_space.returned_fraction(
        Optics(aperture=aperture), "diffuse", Hits(*(np.array(part, float) for part in view[:3]))
    )
    photons = s.power * s.exposure / 4 * s.wavelength / (6.62607015e-34 * SPEED_OF_LIGHT)
    expected = (
        photons / s.pixels * 2 * share * s.transmission * s.efficiency
    )  # half polarised there
    np.testing.assert_allclose(signal(camera.settings, view), expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "factor"),
    [({"distance": 2.0}, 0.25), ({"reflectance": 1.0}, 2), ({"cosine": 0.5}, 0.5)],
)
def test_signal_scales(change, factor):
    camera = ideal()
    ratio = signal(camera.settings, flat(**change)) / signal(camera.settings, flat())
    np.testing.assert_allclose(ratio, factor)


def test_nothing_returns_from_nowhere():
    view = flat(np.nan)
    camera = MhzCamera()
    assert not signal(camera.settings, view).any()
    assert not ambient(camera.settings, view).any()
    depth = camera.estimate(camera.capture(camera.light(view), rng=np.random.default_rng(0)))
    assert np.isnan(ideal(confidence=5.0).estimate(np.zeros((4, 2, 2))).range).all()
    assert np.isnan(depth.range).mean() > 0.3


def test_a_polished_surface_is_faint_aside_and_blinding_ahead():
    camera = ideal()
    aside, ahead = (signal(camera.settings, flat(cosine=c, mirrored=1.0))[0, 0] for c in (0.9, 1.0))
    assert aside == pytest.approx(0.02 * signal(camera.settings, flat(cosine=0.9))[0, 0])
    assert ahead > 1000 * signal(camera.settings, flat())[0, 0]
    assert camera.saturated(camera.light(flat(reflectance=0.9, mirrored=1.0))).all()


# --- waveforms and decoding --------------------------------------------------------------------


def test_differences_are_the_correlation_of_the_waveforms():
    camera, view = ideal(), flat(0.77)
    phase = phase_from_depth(0.77, camera.settings.frequency)
    expected = correlation_from_harmonics(camera.emitted, camera.gates, phase=phase, psi=PSI)
    charge = signal(camera.settings, view)[0, 0]
    images = camera.differences(camera.light(view))
    np.testing.assert_allclose(images[:, 3, 5], charge * expected, atol=1e-9 * charge)


def test_sinusoids_have_no_cyclic_error_and_squares_do():
    slow = ideal(emitter_bandwidth=1e6)  # one pole far below: nearly a sinusoid
    phase = np.linspace(0, TAU, 100)
    assert np.abs(slow.wiggling(phase)).max() < 0.045
    assert np.abs(ideal(emitter_bandwidth=1e12, gate_bandwidth=1e12).wiggling(phase)).max() > 0.06


@pytest.mark.parametrize("bandwidth", [150e6, 400e6])
def test_calibration_takes_the_cyclic_error_and_the_lag_away(bandwidth):
    for distance in (0.2, 0.74, 1.0, 1.49):
        assert np.abs(bias(ideal(emitter_bandwidth=bandwidth), flat(distance))).max() < 5e-6


def test_uncalibrated_camera_has_the_whole_cyclic_error():
    camera = ideal(wiggling_left=1.0)
    for distance in (0.3, 1.1):
        phase = phase_from_depth(distance, camera.settings.frequency)
        expected = camera.wiggling(phase) * camera.wrap / TAU
        np.testing.assert_allclose(bias(camera, flat(distance)), expected, atol=1e-9)


def test_ranges_repeat_after_half_a_modulation_wavelength():
    """c / 2f is 1.5 m, not the 3 m of Sec. 1."""
    camera = ideal(power=10.0)
    assert camera.wrap == pytest.approx(1.49896, abs=1e-5)
    far = camera.estimate(camera.differences(camera.light(flat(1.2 + camera.wrap))))
    np.testing.assert_allclose(far.range, 1.2, atol=1e-5)


# --- noise -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("power", "distance"), [(8e-3, 0.5), (0.1, 1.0), (2.0, 1.23)])
def test_noise_reaches_the_bound_within_3_percent(power, distance):
    """12 800 pixels: the standard error of a standard deviation is 0.6 %."""
    camera, view = ideal(power=power), flat(distance, shape=(16, 16))
    images = camera.capture(camera.light(view), rng=np.random.default_rng(5), repeats=50)
    error = camera.error(camera.estimate(images), view.range)
    bound = camera.bound(view)[0, 0]
    assert error.std() == pytest.approx(bound, rel=0.03)
    assert abs(error.mean()) < 4 * bound / np.sqrt(error.size)


def test_the_bound_is_the_fisher_informations():
    """Of phase and charge in four Gaussian differences, by numeric derivatives."""
    camera, distance, step = ideal(), 0.9, 1e-6
    view = flat(distance, shape=(1, 1))

    def mean(z, part):
        return part * camera.differences(camera.light(flat(z, shape=(1, 1))))[:, 0, 0]

    scale = (distance / (distance + np.array([-step, step]))) ** 2  # keep the charge
    by_range = (
        (mean(distance + step, 1 / scale[1]) - mean(distance - step, 1 / scale[0])) / 2 / step
    )
    gradient = np.stack([by_range, mean(distance, 1.0)])
    lsb = 2 * camera.settings.full_scale / 4095
    variance = signal(camera.settings, view)[0, 0] + camera.settings.read_noise**2 + lsb**2 / 12
    least = np.linalg.inv(gradient @ gradient.T / variance)[0, 0] ** 0.5
    assert camera.bound(view)[0, 0] == pytest.approx(least, rel=1e-6)


def test_fixed_pattern_is_the_cameras_own():
    camera = MhzCamera(CameraSettings.ideal(pattern=0.03, pattern_left=0.5), seed=3)
    first = bias(camera, flat())
    np.testing.assert_array_equal(first, bias(camera, flat()))
    assert np.abs(bias(MhzCamera(camera.settings, seed=4), flat()) - first).max() > 1e-3
    assert first.std() == pytest.approx(0.5 * 0.03 * camera.wrap / TAU, rel=0.15)
    whole = MhzCamera(replace(camera.settings, pattern_left=0.0), seed=3)
    assert np.abs(bias(whole, flat())).max() < 5e-6


# --- causes of the texture-dependent error -----------------------------------------------------


def two_ranges(dark):
    """A dark pixel among bright ones that stand 0.3 m behind it."""
    view = flat(1.3, 0.8)
    view.range[12, 12], view.reflectance[12, 12] = 1.0, dark
    return view


@pytest.mark.parametrize("dark", [0.5, 0.05, 0.005])
def test_veil_pulls_a_dark_pixel_by_the_closed_form(dark):
    camera, view = ideal(veil=0.2), two_ranges(dark)
    own_light, away = signal(camera.settings, view), phase_from_depth(0.3, 100e6)
    pixels = camera.settings.pixels
    bright = (own_light.sum() - own_light[12, 12]) / pixels
    own = 0.8 * own_light[12, 12] + 0.2 * own_light[12, 12] / pixels
    pull = pulled_phase(0.2 * bright / own, away) * camera.wrap / TAU
    # the closed form is that of the fundamental; the harmonics' veil changes the wiggling by little
    assert bias(camera, view)[12, 12] == pytest.approx(pull, rel=0.25, abs=1e-5)


def test_veil_between_equal_ranges_does_nothing():
    view = flat()
    view.reflectance[10:, :] = 0.02
    assert np.abs(bias(ideal(veil=0.5), view)).max() < 5e-6


@pytest.mark.parametrize("difference", [0.3, 1.5, 3.0])
def test_pull_and_its_inverse(difference):
    for share in (0.05, 0.5, 0.95):
        ratio = ratio_for_pull(share * difference, difference)
        assert pulled_phase(ratio, difference) == pytest.approx(share * difference)
    assert ratio_for_pull(difference, difference) == float("inf")
    assert pulled_phase(1e9, difference) == pytest.approx(difference)
    ratio = np.linspace(0.1, 0.9, 9)
    widest = np.max([pulled_phase(ratio, d) for d in np.linspace(0, np.pi, 20001)], axis=0)
    np.testing.assert_allclose(widest, np.arcsin(ratio), rtol=1e-6)


def test_leak_pulls_dark_pixels_to_the_camera():
    view = flat(0.3)
    view.reflectance[:, 12:] = 0.01
    error = bias(ideal(leak=1e-8), view)
    assert (error[:, 12:] < 0).all()
    assert error[0, 20] < 10 * error[0, 0] < 0


def test_full_taps_answer_late():
    camera = ideal(delay=1e-9, power=2.0, full_scale=1e6)
    view = flat()
    filling = signal(camera.settings, view)[0, 0] / 2 / camera.settings.full_well
    assert 0.1 < filling < 1
    expected = delay_error(1e-9, filling)
    # the delay comes before the cyclic error, so it is calibrated like a range
    np.testing.assert_allclose(bias(camera, view), expected, rtol=1e-3)


def test_a_quadratic_response_cancels_between_two_taps():
    """(A - B)(1 - k (A + B) / F): it scales the amplitude, and A + B is the same in each step."""
    bent, straight = ideal(nonlinearity=0.3, power=2.0), ideal(power=2.0)
    view = flat()
    np.testing.assert_allclose(bias(bent, view), bias(straight, view), atol=1e-9)
    amplitude = [c.estimate(c.differences(c.light(view))).amplitude[0, 0] for c in (bent, straight)]
    lost = 0.3 * signal(straight.settings, view)[0, 0] / straight.settings.full_well
    assert amplitude[0] / amplitude[1] == pytest.approx(1 - lost)


def test_blur_mixes_ranges_at_an_edge_only():
    view = flat(1.0)
    view.range[:, 12:] = 1.1
    error = bias(ideal(blur=0.6), view)
    assert np.abs(error[:, [0, 5, 18, 23]]).max() < 1e-5
    assert error[0, 11] > 0.01 > -0.01 > error[0, 12]


def test_rays_of_a_pixel_add_up():
    camera = ideal()
    fine = flat(0.9, shape=(12, 12))
    np.testing.assert_allclose(
        camera.light(fine, rays=3).phasors, camera.light(flat(0.9, shape=(4, 4))).phasors
    )
    fine.range[:, ::2] = 1.0  # a flying pixel lies between
    mixed = camera.light(fine, rays=2)
    depth = camera.estimate(camera.differences(mixed)).range
    assert ((depth > 0.9) & (depth < 1.0)).all()


def test_saturated_pixels_are_not_shown():
    camera = ideal(power=100.0)
    light = camera.light(flat())
    depth = camera.estimate(camera.differences(light), camera.saturated(light))
    assert np.isnan(depth.range).all()


# --- bad input ---------------------------------------------------------------------------------


def test_bad_input_is_named():
    with pytest.raises(ValueError, match=r"Expected images \(H, W\) of one shape"):
        ideal().light(flat()._replace(cosine=np.ones((3, 3))))
    with pytest.raises(ValueError, match="Expected 5 rays across each pixel to divide 24 x 24"):
        ideal().light(flat(), rays=5)
    with pytest.raises(ValueError, match=r"Expected camera\.veil from 0 to 1, got 2"):
        CameraSettings(veil=2.0)
