"""Poses, the pinhole with Brown's distortion, and the rig that they make."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.stereo.camera import PinholeCamera, distorted, pixels_from_points
from cmtof.stereo.pose import Pose, rotation_from_vector, skew, turned, vector_from_rotation
from cmtof.stereo.rig import PARAMETERS, StereoRig, simulated_rig

SHAPE = (1536, 2048)
small = st.floats(-1, 1)
vectors = st.tuples(*[st.floats(-1.7, 1.7)] * 3)


@st.composite
def cameras(draw) -> PinholeCamera:
    """Cameras as bent as real lenses of this field are."""
    k1, k2, k3 = draw(small) * 0.15, draw(small) * 0.1, draw(small) * 0.03
    p1, p2 = draw(small) * 2e-3, draw(small) * 2e-3
    focal = draw(st.floats(1800, 3200))
    return PinholeCamera(
        np.array([focal, focal * 1.01, 1020 + 20 * draw(small), 770, k1, k2, k3, p1, p2]), SHAPE
    )


def numeric(function, at, step=1e-6):
    """Central differences of a function of a vector, the derivative last."""
    at = np.asarray(at, float)
    return np.stack(
        [(function(at + e) - function(at - e)) / (2 * step) for e in step * np.eye(at.size)], -1
    )


# --- poses -------------------------------------------------------------------------------------


@given(vectors)
def test_a_rotation_vector_comes_back(vector):
    rotation = rotation_from_vector(vector)
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1)
    if np.linalg.norm(vector) < 3.1:
        assert np.allclose(vector_from_rotation(rotation), vector, atol=1e-9)


@pytest.mark.parametrize("vector", [(0, 0, 0), (1e-6, -2e-6, 0), (0.3, -0.2, 0.9), (0, 2.5, 1)])
def test_the_derivative_of_a_turn_is_that_of_differences(vector):
    points = np.array([[0.3, -1.2, 2.0], [1.0, 0.4, -0.5]])
    _, slope = turned(vector, points)
    assert np.allclose(slope, numeric(lambda v: turned(v, points)[0], vector), atol=1e-8)


@given(vectors, vectors)
def test_poses_chain_and_turn_back(first, second):
    a, b = Pose.from_vector([*first, *second]), Pose.from_vector([*second, *first])
    point = np.array([0.1, -0.7, 1.9])
    assert np.allclose(a.inverse.apply(a.apply(point)), point)
    assert np.allclose(b.after(a).apply(point), b.apply(a.apply(point)))


def test_a_camera_looks_where_it_is_told():
    pose = Pose.looking([0.2, 0.1, 0], [0.2, 0.1, 3])
    assert np.allclose(pose.apply([0.2, 0.1, 3]), [0, 0, 3])
    aside = Pose.looking([-0.15, 0, 0], [0, 0, 3]).apply([0, 0, 3])
    assert np.allclose(aside[:2], 0) and aside[2] == pytest.approx(np.hypot(3, 0.15))
    with pytest.raises(ValueError, match="Expected a camera that looks ahead"):
        Pose.looking([0, 0, 0], [0, 1, 0])


def test_skew_is_the_cross_product(rng):
    a, b = rng.standard_normal((2, 5, 3))
    assert np.allclose((skew(a) @ b[..., None])[..., 0], np.cross(a, b))


# --- camera ------------------------------------------------------------------------------------


@given(cameras(), st.tuples(st.floats(5, 2043), st.floats(5, 1531)))
def test_pixels_go_to_rays_and_back(camera, pixel):
    ray = camera.rays(pixel)
    assert np.linalg.norm(ray) == pytest.approx(1)
    assert np.allclose(camera.project(3.7 * ray), pixel, atol=1e-6)


@given(cameras(), st.tuples(small, small, st.floats(0.5, 5)))
def test_points_go_to_pixels_and_back(camera, place):
    point = np.array([0.4, 0.3, 1.0]) * place[2] * [place[0], place[1], 1]
    assert np.allclose(camera.rays(camera.project(point)) * np.linalg.norm(point), point, atol=1e-7)


@given(cameras(), st.tuples(small, small, st.floats(0.5, 5)))
def test_projection_has_the_derivatives_of_differences(camera, place):
    point = np.array([0.4 * place[0], 0.3 * place[1], place[2]])
    _, by_point, by_camera = pixels_from_points(camera.intrinsics, point)
    moved = numeric(lambda p: pixels_from_points(camera.intrinsics, p)[0], point)
    changed = numeric(lambda p: pixels_from_points(p, point)[0], camera.intrinsics, 1e-4)
    assert np.allclose(by_point, moved, atol=1e-3, rtol=1e-6)
    assert np.allclose(by_camera, changed, atol=1e-3, rtol=1e-5)


def test_without_distortion_a_camera_is_a_pinhole():
    camera = PinholeCamera.from_lens(8e-3, 3.45e-6, SHAPE)
    assert np.allclose(
        camera.project([0.1, -0.2, 2.0]), [1024 + 0.05 * 8e-3 / 3.45e-6, 768 - 231.884]
    )


def test_distortion_is_browns_polynomial():
    # 1 + 0.1 r2 + 0.01 r4 with r2 = 0.25, and both tangential terms, by hand
    seen, _, _ = distorted([0.1, 0.01, 0, 0.01, 0.02], [0.3, 0.4])
    radial = 1 + 0.1 * 0.25 + 0.01 * 0.0625
    assert seen[0] == pytest.approx(0.3 * radial + 0.02 * 0.12 + 0.02 * (0.25 + 0.18))
    assert seen[1] == pytest.approx(0.4 * radial + 0.01 * (0.25 + 0.32) + 0.04 * 0.12)


def test_behind_the_camera_and_beyond_the_fold_there_is_nothing():
    camera = PinholeCamera.from_lens(8e-3, 3.45e-6, SHAPE, (-0.5, 0, 0, 0, 0))
    assert np.isnan(camera.project([[0, 0, -1.0], [0, 0, 0]])).all()
    # x (1 - x^2 / 2) is at most 0.544: no ray reaches a pixel farther out
    assert np.isnan(camera.rays([1024 + 0.6 * camera.intrinsics[0], 768])).all()
    assert np.isfinite(camera.rays([1024 + 0.5 * camera.intrinsics[0], 768])).all()


def test_a_camera_sees_its_image_only():
    camera = PinholeCamera.from_lens(8e-3, 3.45e-6, SHAPE)
    pixels = [[0, 0], [2048, 1536], [2049, 5], [np.nan, 3], [4, 700]]
    assert camera.sees(pixels).tolist() == [True, True, False, False, True]
    assert camera.sees(pixels, 5.0).tolist() == [False] * 5


@pytest.mark.parametrize(
    ("numbers", "shape"),
    [
        ([0, 1, 0, 0, 0, 0, 0, 0, 0], SHAPE),
        ([1, 1, 0, 0], SHAPE),
        ([1, 1, np.nan, 0, 0, 0, 0, 0, 0], SHAPE),
        ([1, 1, 0, 0, 0, 0, 0, 0, 0], (0, 4)),
    ],
)
def test_a_bad_camera_is_refused(numbers, shape):
    with pytest.raises(ValueError, match=r"^Expected .* got .*\. "):
        PinholeCamera(np.array(numbers, float), shape)


# --- rig ---------------------------------------------------------------------------------------


def test_a_rig_is_its_parameters():
    rig = simulated_rig(baseline=0.25, converge=2.0)
    assert rig.parameters.shape == (30,) and len(set(PARAMETERS)) == 30
    again = rig.with_parameters(rig.parameters)
    assert np.allclose(again.parameters, rig.parameters)
    point = [[0.1, 0.05, 1.8]]
    assert np.allclose(again.project(point), rig.project(point))


def test_the_simulated_rig_stands_as_asked():
    rig = simulated_rig(baseline=0.4, converge=2.0, forward=0.1)
    assert np.allclose(rig.centres(), [[-0.2, 0, 0.1], [0.2, 0, 0.1], [0, 0, 0]], atol=1e-12)
    for pixels, camera in zip(rig.project([0.0, 0.0, 2.0]), (rig.left, rig.right), strict=True):
        assert np.allclose(pixels, camera.intrinsics[2:4])


def test_single_parameters_move_by_name():
    rig = simulated_rig()
    assert rig.moved(left_fx=2.0).left.intrinsics[0] == pytest.approx(rig.left.intrinsics[0] + 2)
    with pytest.raises(ValueError, match="Expected a parameter out of left_fx"):
        rig.moved(left_focal=1.0)


def test_a_bad_rig_is_refused():
    rig = simulated_rig()
    with pytest.raises(ValueError, match="baseline of 0 m"):
        StereoRig(rig.left, rig.right, Pose.none(), Pose.none())
    with pytest.raises(ValueError, match="covariance"):
        StereoRig(rig.left, rig.right, rig.right_from_left, Pose.none(), np.eye(24))
    with pytest.raises(ValueError, match="above 0 m"):
        simulated_rig(baseline=-0.1)
