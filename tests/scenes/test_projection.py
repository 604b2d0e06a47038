"""Rays and cameras of tilted and shifted projections."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from official_tree import PLAIN, SHAPE, TILTED, official_rays

from cmtof.scenes.frame import rays_from_camera
from cmtof.scenes.hypersim import (
    camera_from_projection,
    projection_from_focal,
    rays_from_projection,
    read_projections,
)

SMALL = (6, 8)


def directions(camera, shape):
    rays = rays_from_camera(shape, camera)
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def tilted_projection(focal, centre, skew, angles, shape):
    """M_cam_from_uv of a pinhole with skew that is turned against the camera's axes."""
    fx, fy = focal
    pinhole = np.array([[fx, skew * fx, centre[0]], [0, fy, centre[1]], [0, 0, 1]])
    turn = np.eye(3)
    for axis, angle in enumerate(angles):
        c, s, one = np.cos(angle), np.sin(angle), np.eye(3)
        i, j = [k for k in range(3) if k != axis]
        one[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
        turn = turn @ one
    height, width = shape
    to_pixel = np.array([[width / 2, 0, width / 2], [0, -height / 2, height / 2], [0, 0, 1]])
    flip = np.diag([1.0, -1.0, -1.0])
    return flip @ turn @ np.linalg.inv(pinhole) @ to_pixel


@pytest.mark.parametrize("projection", [PLAIN, TILTED])
def test_rays_are_those_of_the_published_description(projection):
    np.testing.assert_allclose(
        rays_from_projection(projection, SHAPE), official_rays(projection), atol=1e-12
    )


@given(
    st.tuples(st.floats(3, 30), st.floats(3, 30)),
    st.tuples(st.floats(-2, 12), st.floats(-2, 12)),
    st.floats(-0.02, 0.02),
    st.tuples(*[st.floats(-0.3, 0.3)] * 3),
)
def test_a_turned_pinhole_with_skew_is_found_again(focal, centre, skew, angles):
    projection = tilted_projection(focal, centre, skew, angles, SMALL)
    camera, rotation = camera_from_projection(projection, SMALL)
    np.testing.assert_allclose(camera[:4], [*focal, *centre], rtol=1e-7, atol=1e-7)
    found = camera[4] if len(camera) == 5 else 0.0
    assert found == pytest.approx(skew * focal[0], abs=2e-6 * focal[0])
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    rays = directions(camera, SMALL) @ rotation.T
    np.testing.assert_allclose(rays, rays_from_projection(projection, SMALL), atol=3e-6)


def test_plain_pinhole_has_four_numbers_and_no_turn():
    camera, rotation = camera_from_projection(projection_from_focal(20.0, SMALL), SMALL)
    np.testing.assert_allclose(camera, [20, 20, 4, 3])
    np.testing.assert_allclose(rotation, np.diag([1, -1, -1]))


def test_scale_of_a_projection_does_not_matter():
    one, _ = camera_from_projection(TILTED, SHAPE)
    other, _ = camera_from_projection(3.7 * TILTED, SHAPE)
    np.testing.assert_allclose(one, other)


@pytest.mark.parametrize(
    "projection", [np.zeros((3, 3)), np.eye(3), np.eye(2), np.full((3, 3), np.nan)]
)
def test_projections_that_show_nothing_are_refused(projection):
    with pytest.raises(ValueError, match="M_cam_from_uv"):
        camera_from_projection(projection, SMALL)


def test_every_official_camera_is_a_turned_pinhole(official_tables):
    """All 482: equal rays, a true rotation, a skew of at most 0.02; 206 to 207 are plain."""
    shape, skews, plain = (12, 16), [], 0
    projections = read_projections(official_tables / "metadata_camera_parameters.csv")
    assert len(projections) == 482
    for projection in projections.values():
        camera, rotation = camera_from_projection(projection, shape)
        rays = directions(camera, shape) @ rotation.T
        np.testing.assert_allclose(rays, rays_from_projection(projection, shape), atol=3e-6)
        assert np.linalg.det(rotation) == pytest.approx(1)
        skews.append(abs(camera[4]) / camera[0] if len(camera) == 5 else 0.0)
        plain += np.allclose(projection, PLAIN, atol=2e-3)
    assert max(skews) <= 0.02
    assert sum(skew > 0 for skew in skews) == 31
    assert 200 <= plain <= 215
