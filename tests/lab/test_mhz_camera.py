"""The 100 MHz camera: photon budget, noise against its closed form, what pulls at a phase."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose
from pytest import approx, mark
from scipy.constants import c, h

from cmtof.correlation import depth_from_phase, phase_from_depth
from cmtof_lab.mhz_camera import MhzCamera
from cmtof_lab.targets import RayEnds

CLEAN = MhzCamera(veil=0.0, blur=0.0, ambient_radiance=0.0)


def flat(distance=1.0, reflectance=0.5, shape=(24, 24), mirrored=0.0):
    return RayEnds(
        np.full(shape, distance),
        np.ones(shape),
        np.full(shape, reflectance),
        mirrored,
    )


def seen(camera, view, rng):
    """Depth (H, W), m, from images with noise."""
    return camera.depth(camera.capture(camera.light(view, view), rng=rng))[0]


def bias(camera, view, field):
    """Range error (H, W), m, of images without noise."""
    images = camera.differences(camera.light(view, field))
    return camera.error(camera.depth(images)[0], view.range)


def test_the_field_returns_what_a_lambertian_wall_sends_into_the_pupil():
    """8 mW for 2 ms on all pixels; 0.5 A / (pi z^2) of it comes back, times 0.8 and 0.5."""
    photons = CLEAN.power * CLEAN.exposure / 4 * CLEAN.wavelength / (h * c)
    share = 0.5 * CLEAN.pupil_area / np.pi / 0.8**2
    found = CLEAN.signal(flat(0.8)).mean() * 480 * 640
    assert found == approx(photons * share * 0.8 * 0.5)


@mark.parametrize("z", [0.2, 1.4, 1.4 + c / 2e8])
def test_ranges_are_exact_without_noise_and_repeat_after_one_wrap(z):
    camera = replace(CLEAN, power=1.0, full_scale=1e6)
    assert camera.wrap == approx(c / 2e8)  # 1.5 m, not the 3 m of Sec. 1
    images = camera.differences(camera.light(flat(z), flat(z)))
    assert_allclose(camera.depth(images)[0], z % camera.wrap, atol=1e-9)


@mark.parametrize("power, distance", [(8e-3, 0.4), (2.0, 1.23)])
def test_noise_reaches_its_closed_form(power, distance, rng):
    """12 800 pixels: the standard error of a standard deviation is 0.6 %, the margin 3 %."""
    camera = MhzCamera(power=power)
    view = flat(distance, shape=(80, 160))
    error = camera.error(seen(camera, view, rng), view.range)
    bound = camera.bound(view)[0, 0]
    assert error.std() == approx(bound, rel=0.03)
    assert abs(error.mean()) < 4 * bound / np.sqrt(error.size)


def test_dark_and_saturated_pixels_have_no_range(rng):
    dark, full = (
        np.isnan(seen(MhzCamera(), view, rng)).mean()
        for view in (flat(np.nan), flat(reflectance=0.9, mirrored=1.0))
    )
    assert 0.3 < dark < 0.9
    assert full == 1


def test_a_veil_pulls_a_dark_spot_by_the_closed_form(dark=0.005):
    """A spot at 1 m before a bright field 0.3 m behind it: arg(1 + s exp(i D))."""
    camera = replace(CLEAN, veil=0.2)
    spot = flat(1.0, dark)
    field = flat(1.3, 0.8)
    ratio = 0.25 * camera.signal(field) / camera.signal(spot)
    turned = np.angle(1 + ratio * np.exp(1j * phase_from_depth(0.3, camera.frequency)))
    pull = depth_from_phase(turned, camera.frequency)
    assert_allclose(bias(camera, spot, field), pull, rtol=1e-9)
    assert abs(bias(camera, spot, flat(1.0, 0.8))).max() < 1e-12
