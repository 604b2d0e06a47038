"""Points of a depth map, and their file."""

import numpy as np
import trimesh
from numpy.testing import assert_allclose

from cmtof.pointcloud import mesh_triangles, points_from_depth, write_ply

CAMERA = [50.0, 60.0, 8.0, 6.0]


def test_ply_holds_every_finite_pixel(tmp_path, rng):
    depth = rng.uniform(1, 2, (12, 16))
    depth[3, 4] = np.nan
    path = tmp_path / "c.ply"
    light = np.ones((12, 16))
    light[0, 0] = np.nan  # black
    count = write_ply(path, depth, CAMERA, brightness=light, confidence=depth / 4)
    cloud = trimesh.load(path)
    assert count == 191
    held = depth[np.isfinite(depth)]
    assert_allclose(np.linalg.norm(cloud.vertices, axis=1), held, rtol=1e-6)
    stored = cloud.metadata["_ply_raw"]["vertex"]["data"]
    assert {*stored["red"], *stored["green"], *stored["blue"]} == {0, 255}
    assert_allclose(stored["confidence"], held / 4, rtol=1e-6)


def test_the_mesh_is_whole_on_a_surface_and_open_at_edges_and_holes():
    depth = np.full((12, 16), 1.2)
    assert (
        len(mesh_triangles(points_from_depth(depth, CAMERA), longest=0.05))
        == 2 * 11 * 15
    )
    depth[:, 8:] += 0.1
    depth[5, 3] = np.nan
    cut = mesh_triangles(points_from_depth(depth, CAMERA), longest=0.05)
    assert len(cut) == 2 * 11 * 14 - 6
    assert 5 * 16 + 3 not in cut
