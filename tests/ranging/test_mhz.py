"""The 100 MHz camera: photon budget, noise against its closed form, what pulls at a phase."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.constants import c, h

from cmtof.correlation import TAU, phase_from_depth
from cmtof.instrument.targets import Hits
from cmtof.ranging.mhz import MhzCamera, pulled_phase

CLEAN = MhzCamera(veil=0.0, blur=0.0, ambient_radiance=0.0)


def flat(distance=1.0, reflectance=0.5, cosine=1.0, shape=(24, 24), mirrored=0.0):
    return Hits(*(np.full(shape, x) for x in (distance, cosine, reflectance)), mirrored)


def bias(camera, view, field=None):
    """Range error (H, W), m, of images without noise."""
    images = camera.differences(camera.light(view, view if field is None else field))
    return camera.error(camera.depth(images)[0], view.range)


def test_the_field_returns_what_a_lambertian_wall_sends_into_the_pupil():
    """8 mW for 2 ms on all pixels; 0.5 A / (pi z^2) of it comes back, times 0.8 and 0.5."""
    photons = CLEAN.power * CLEAN.exposure / 4 * CLEAN.wavelength / (h * c)
    share = 0.5 * CLEAN.pupil_area / np.pi / 0.8**2
    found = CLEAN.signal(flat(0.8)).mean() * 480 * 640
    assert found == pytest.approx(photons * share * 0.8 * 0.5)


@pytest.mark.parametrize(
    ("change", "factor"),
    [({"distance": 2.0}, 0.25), ({"reflectance": 1.0}, 2), ({"cosine": 0.5}, 0.5),
     ({"distance": np.nan}, 0)],
)  # fmt: skip
def test_signal_scales_as_a_diffuse_surface(change, factor):
    ratio = CLEAN.signal(flat(**change)) / CLEAN.signal(flat())
    np.testing.assert_allclose(ratio, factor)


def test_polished_metal_is_faint_aside_and_blinding_ahead():
    aside, ahead = (CLEAN.signal(flat(cosine=x, mirrored=1.0))[0, 0] for x in (0.9, 1.0))
    assert aside == pytest.approx(0.02 * CLEAN.signal(flat(cosine=0.9))[0, 0])
    assert ahead > 1000 * CLEAN.signal(flat())[0, 0]


@pytest.mark.parametrize("distance", [0.2, 1.1, 1.4])
def test_ranges_are_exact_without_noise_and_repeat_after_one_wrap(distance):
    camera = replace(CLEAN, power=1.0, full_scale=1e6)
    assert camera.wrap == pytest.approx(c / 2e8)  # 1.5 m, not the 3 m of Sec. 1
    for z in (distance, distance + camera.wrap):
        images = camera.differences(camera.light(flat(z), flat(z)))
        np.testing.assert_allclose(camera.depth(images)[0], distance, atol=1e-9)


@pytest.mark.parametrize(("power", "distance"), [(8e-3, 0.4), (0.1, 1.0), (2.0, 1.23)])
def test_noise_reaches_its_closed_form(power, distance, rng):
    """12 800 pixels: the standard error of a standard deviation is 0.6 %, the margin 3 %."""
    camera, view = MhzCamera(power=power), flat(distance, shape=(16, 16))
    images = camera.capture(camera.light(view, view), rng=rng, repeats=50)
    error = camera.error(camera.depth(images)[0], view.range)
    bound = camera.bound(view)[0, 0]
    assert error.std() == pytest.approx(bound, rel=0.03)
    assert abs(error.mean()) < 4 * bound / np.sqrt(error.size)


def test_dark_and_saturated_pixels_have_no_range(rng):
    camera = MhzCamera()
    dark = flat(np.nan)
    found, _ = camera.depth(camera.capture(camera.light(dark, dark), rng=rng))
    assert 0.3 < np.isnan(found).mean() < 0.9
    bright = flat(reflectance=0.9, mirrored=1.0)
    found, _ = camera.depth(camera.capture(camera.light(bright, bright), rng=rng))
    assert np.isnan(found).all()


@pytest.mark.parametrize("dark", [0.5, 0.05, 0.005])
def test_a_veil_pulls_a_dark_spot_by_the_closed_form(dark):
    """A spot at 1 m before a bright field 0.3 m behind it."""
    camera = replace(CLEAN, veil=0.2)
    spot, field = flat(1.0, dark), flat(1.3, 0.8)
    ratio = 0.2 / 0.8 * camera.signal(field)[0, 0] / camera.signal(spot)[0, 0]
    pull = pulled_phase(ratio, phase_from_depth(0.3, camera.frequency)) * camera.wrap / TAU
    np.testing.assert_allclose(bias(camera, spot, field), pull, rtol=1e-9)
    assert np.abs(bias(camera, spot, flat(1.0, 0.8))).max() < 1e-12  # nothing at equal ranges


def test_the_pull_is_at_most_the_arc_sine_of_the_ratio():
    ratio = np.linspace(0.1, 0.9, 9)
    widest = np.max([pulled_phase(ratio, d) for d in np.linspace(0, np.pi, 20001)], axis=0)
    np.testing.assert_allclose(widest, np.arcsin(ratio), rtol=1e-6)
    assert pulled_phase(1e9, 1.2) == pytest.approx(1.2)


def test_blur_mixes_ranges_at_an_edge_only():
    view = flat(1.0)
    view.range[:, 12:] = 1.1
    error = bias(replace(CLEAN, blur=0.6), view)
    assert np.abs(error[:, [0, 5, 18, 23]]).max() < 1e-5
    assert error[0, 11] > 0.01 > -0.01 > error[0, 12]
