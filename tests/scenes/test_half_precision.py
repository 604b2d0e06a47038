"""Steps of float16 depth, and surfaces without them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.constants import FREQUENCIES, SPEED_OF_LIGHT
from cmtof.scenes.frame import ray_lengths
from cmtof.scenes.half_precision import float16_phase, float16_step, smoothed_within_step
from cmtof.scenes.hypersim import view_of_file

CAMERA = [110.0, 110.0, 64.0, 48.0]
SHAPE = (96, 128)


def slanted(distance=3.0, slope=(0.1, 0.05), shape=SHAPE):
    """Range of a plane, m."""
    v, u = np.indices(shape) + 0.5
    x, y = (u - CAMERA[2]) / CAMERA[0], (v - CAMERA[3]) / CAMERA[1]
    return distance * ray_lengths(shape, CAMERA) / (1 + slope[0] * x + slope[1] * y)


def half_steps(stored):
    """Distances to the middles between a float16 and its neighbours, m."""
    below = stored.astype(float) - np.nextafter(stored, np.float16(0)).astype(float)
    above = np.nextafter(stored, np.float16(np.inf)).astype(float) - stored.astype(float)
    return below / 2, above / 2


def rms(error):
    return float(np.sqrt(np.mean(error**2)))


@given(st.floats(0.01, 1000))
def test_step_is_the_way_to_the_next_float16(depth):
    here = np.float16(depth)
    above = np.nextafter(here, np.float16(np.inf))
    assert float16_step(depth) == float(above) - float(here)


def test_steps_of_2_to_4_mm_are_0_6_to_2_4_radians():
    depth = np.array([3.0, 6.0])
    np.testing.assert_allclose(float16_step(depth), [1 / 512, 1 / 256])
    phases = [float16_phase(depth, f) for f in FREQUENCIES]
    np.testing.assert_allclose(
        phases[0], 4 * np.pi * FREQUENCIES[0] / SPEED_OF_LIGHT / np.array([512, 256])
    )
    assert 0.58 < np.min(phases) < 0.6 and 2.3 < np.max(phases) < 2.4


@given(st.floats(0.7, 12), st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))
def test_smoothed_depth_stays_within_half_a_step_of_what_was_stored(distance, a, b):
    stored = slanted(distance, (a, b), (24, 32)).astype(np.float16)
    smooth = smoothed_within_step(stored, rounds=30)
    below, above = half_steps(stored)
    change = smooth - stored.astype(float)
    assert (change >= -below - 1e-12).all() and (change <= above + 1e-12).all()


@pytest.mark.parametrize("slope", [(0.0, 0.0), (0.1, 0.05), (-0.3, 0.2), (0.5, 0.5)])
def test_smoothing_lowers_the_error_of_a_plane_more_than_threefold(slope):
    true = slanted(3.0, slope)
    stored = true.astype(np.float16)
    assert rms(stored - true) > 3 * rms(smoothed_within_step(stored) - true)


def test_smoothing_takes_the_terraces_off_a_sphere():
    v, u = np.indices(SHAPE) + 0.5
    x, y = (u - CAMERA[2]) / CAMERA[0], (v - CAMERA[3]) / CAMERA[1]
    along = 3.0 / np.sqrt(x**2 + y**2 + 1)
    true = along - np.sqrt(along**2 - (3.0**2 - 2.0**2))  # radius 2 m, fills the view
    stored = true.astype(np.float16)
    assert rms(stored - true) > 3 * rms(smoothed_within_step(stored) - true)


def test_smoothing_does_not_cross_an_edge():
    """Both sides of a jump come out as each does alone."""
    near, far = slanted(2.2)[:, :64], slanted(2.3)[:, 64:]
    stored = np.concatenate([near, far], axis=1).astype(np.float16)
    together = smoothed_within_step(stored)
    np.testing.assert_array_equal(together[:, :64], smoothed_within_step(stored[:, :64]))
    np.testing.assert_array_equal(together[:, 64:], smoothed_within_step(stored[:, 64:]))


def test_smoothing_leaves_holes_and_does_not_lean_on_them():
    stored = slanted().astype(np.float16)
    stored[10, 10], stored[20, 20], stored[30, 30] = np.nan, np.inf, 0
    smooth = smoothed_within_step(stored)
    assert np.isnan(smooth[10, 10]) and np.isinf(smooth[20, 20]) and smooth[30, 30] == 0
    rest = np.ones(SHAPE, bool)
    rest[[10, 20, 30], [10, 20, 30]] = False
    assert rms((smooth - slanted())[rest]) < 0.25 * rms((stored - slanted())[rest])


def test_smoothing_is_the_same_mirrored():
    stored = slanted().astype(np.float16)
    np.testing.assert_allclose(
        smoothed_within_step(stored[::-1, ::-1])[::-1, ::-1],
        smoothed_within_step(stored),
        atol=1e-9,
    )


@pytest.mark.parametrize("shape", [(1, 1), (2, 2), (1, 9), (9, 1)])
def test_images_too_small_to_bend_stay(shape):
    stored = np.full(shape, 2.5, np.float16)
    np.testing.assert_array_equal(smoothed_within_step(stored), stored)


def test_the_public_depth_file_loses_its_terraces(official_tables):
    view = view_of_file(next(official_tables.rglob("frame.*.depth_meters.hdf5")))
    stored = view.depth()[::2, ::2]
    smooth = smoothed_within_step(stored)
    flat = np.mean(np.diff(stored.astype(float), axis=1) == 0)
    assert flat > 0.2
    assert np.mean(np.diff(smooth, axis=1) == 0) < 0.01
