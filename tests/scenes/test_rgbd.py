"""Frames: cameras with skew, notes, and light for eyes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cmtof.pointcloud import points_from_depth
from cmtof.scenes import load_frame
from cmtof.scenes.frame import (
    Frame,
    brightness,
    linear_from_srgb,
    ray_lengths,
    rays_from_camera,
    tone_mapped,
)

ONES = np.ones((6, 8))


@given(st.floats(3, 30), st.floats(3, 30), st.floats(0, 8), st.floats(0, 6), st.floats(-1, 1))
def test_rays_of_a_skewed_camera_land_on_their_pixels(fx, fy, cx, cy, skew):
    rays = rays_from_camera((6, 8), [fx, fy, cx, cy, skew])
    pinhole = np.array([[fx, skew, cx], [0, fy, cy], [0, 0, 1]])
    v, u = np.indices((6, 8)) + 0.5
    seen = rays @ pinhole.T
    np.testing.assert_allclose(seen, np.stack([u, v, np.ones_like(u)], axis=-1), atol=1e-9)


def test_no_skew_is_a_skew_of_0():
    plain, zero = [20.0, 21.0, 4.0, 3.0], [20.0, 21.0, 4.0, 3.0, 0.0]
    np.testing.assert_array_equal(rays_from_camera((6, 8), plain), rays_from_camera((6, 8), zero))
    np.testing.assert_array_equal(ray_lengths((6, 8), plain), ray_lengths((6, 8), zero))


def test_points_of_a_skewed_camera_lie_at_their_range():
    points = points_from_depth(2 * ONES, [20.0, 21.0, 4.0, 3.0, 0.3])
    np.testing.assert_allclose(np.linalg.norm(points, axis=-1), 2.0)


@pytest.mark.parametrize(
    "camera", [[1.0, 1, 1], [1.0] * 6, [0.0, 1, 1, 1], [1, -1, 1, 1], [1, 1, np.nan, 1], 5.0]
)
def test_cameras_that_are_none_are_refused(camera):
    with pytest.raises(ValueError, match=r"Expected camera fx fy cx cy.* in wall"):
        Frame(ONES, ONES, camera, "wall")


@pytest.mark.parametrize("camera", [None, [9.0, 9, 4, 3], [9.0, 9, 4, 3, 0.1]])
def test_camera_and_note_survive_the_file(tmp_path, camera):
    Frame(ONES, ONES, camera, note="float16 depth smoothed").save(tmp_path / "a.npz")
    read = load_frame(tmp_path / "a.npz")
    assert read.note == "float16 depth smoothed"
    assert (read.camera is None) if camera is None else (read.camera.tolist() == camera)


def test_frames_without_a_note_store_none(tmp_path):
    Frame(ONES, ONES).save(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as stored:
        assert set(stored.files) == {"depth", "intensity"}
    assert load_frame(tmp_path / "a.npz").note == ""


# --- light ---------------------------------------------------------------------------------

colours = arrays(np.float64, (5, 4, 3), elements=st.floats(0.01, 100))


@given(colours, st.floats(0.1, 100))
def test_tone_map_does_not_depend_on_exposure(color, gain):
    np.testing.assert_allclose(tone_mapped(gain * color), tone_mapped(color), atol=1e-9)


@given(colours)
def test_tone_map_keeps_order_and_shows_0_to_1(color):
    shown = tone_mapped(color)
    assert shown.min() >= 0 and shown.max() <= 1
    order = np.argsort(color, axis=None)
    assert (np.diff(shown.ravel()[order]) >= 0).all()


def test_tone_map_shows_the_90th_percentile_at_0_8():
    grey = np.repeat(np.linspace(0.1, 1, 101)[:, None], 3, axis=1)[None]
    np.testing.assert_allclose(tone_mapped(grey)[0, 90], 0.8)
    valid = np.arange(101)[None] < 51
    np.testing.assert_allclose(tone_mapped(grey, valid)[0, 45], 0.8)


def test_tone_map_of_darkness_is_black():
    assert (tone_mapped(np.zeros((2, 2, 3))) == 0).all()
    assert (tone_mapped(np.full((2, 2, 3), 1e-5)) == 0).all()


def test_brightness_weighs_green_most():
    np.testing.assert_allclose(brightness(np.eye(3)), [0.3, 0.59, 0.11])
    assert brightness(np.ones((2, 3), np.float32)).dtype == np.float32


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_srgb_is_inverted_at_its_knee_and_ends(kind):
    top = np.iinfo(kind).max
    linear = linear_from_srgb(np.arange(top + 1, dtype=kind))
    assert linear[0] == 0 and linear[-1] == pytest.approx(1)
    assert (np.diff(linear) > 0).all()
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(encoded * top, np.arange(top + 1), atol=1e-3 * top / 255)
