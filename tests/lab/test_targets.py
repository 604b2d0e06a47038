"""Where rays end: planes, frames, meshes."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pytest import mark
from refusals import refused
from walls import flat_wall, lit

from cmtof.pointcloud import points_from_depth
from cmtof.scenes import load_frame
from cmtof_lab.optics import directions_from_angles
from cmtof_lab.targets import FrameTarget, MeshTarget, Plane, scene_from

CAMERA = [60.0, 60.0, 24.0, 20.0]
RAYS = directions_from_angles(np.random.default_rng(0).uniform(-0.25, 0.25, (500, 2)))


@mark.parametrize("tilt", [0.0, 0.4])
def test_a_frame_of_a_plane_is_that_plane(tilt):
    target = Plane(1.0, tilt_x=tilt)
    seen = target.look(points_from_depth(np.ones((40, 48)), CAMERA))
    frame = FrameTarget(lit(seen.range, 0.4, CAMERA)).look(RAYS)
    plane = target.look(RAYS)
    assert_allclose(frame.range, plane.range, rtol=1e-6)
    assert_allclose(frame.cosine, plane.cosine, atol=1e-2)
    assert set(frame.reflectance.round(6)) == {0.4}


def test_a_mesh_interpolates_its_vertices():
    pytest.importorskip("embreex")
    corners = np.array([[-1, -1, 2.0], [1, -1, 2], [1, 1, 2], [-1, 1, 2]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    target = MeshTarget(corners, faces, np.array([0.0, 1.0, 1.0, 0.0]), 0.25)
    found = target.look(RAYS)
    assert_allclose(found.range, Plane(2.0).look(RAYS).range, rtol=1e-6)
    assert_allclose(found.reflectance, (RAYS[:, 0] * found.range + 1) / 2, atol=1e-5)
    assert_allclose(found.mirrored, 0.25)
    points = np.array([[0.0, 0, 3], [0, 0, 1]])
    assert target.is_hidden(points, (0, 0, 0)).tolist() == [True, False]


def test_scenes_by_name_file_and_mapping():
    assert scene_from(None) is None
    assert isinstance(scene_from("still_life"), FrameTarget)
    assert isinstance(scene_from(load_frame("still_life")), FrameTarget)
    assert scene_from({"kind": "mirror", "distance": 1.0}) == Plane(1.0, mirrored=1.0)


def test_a_frame_without_a_camera_is_refused():
    with refused("Expected a frame with a camera"):
        FrameTarget(flat_wall(4, 1.0))
