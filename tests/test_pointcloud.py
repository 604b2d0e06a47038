"""Points of a depth map, and their file."""

import numpy as np
from numpy.testing import assert_allclose

from cmtof.pointcloud import mesh_triangles, points_from_depth, write_ply

CAMERA = [50.0, 60.0, 8.0, 6.0]


def test_ply_holds_every_finite_pixel(tmp_path, rng):
    depth = rng.uniform(1, 2, (12, 16))
    depth[3, 4] = np.nan
    path = tmp_path / "c.ply"
    count = write_ply(
        path, depth, CAMERA, brightness=np.ones((12, 16)), confidence=depth / 4
    )
    head, body = path.read_bytes().split(b"end_header\n", 1)
    assert b"element vertex 191\n" in head
    assert count == 191
    record = np.dtype([("xyz", "<f4", 3), ("rgb", "u1", 3), ("confidence", "<f4")])
    vertices = np.frombuffer(body, record)
    held = depth[np.isfinite(depth)]
    assert_allclose(np.linalg.norm(vertices["xyz"], axis=1), held, rtol=1e-6)
    assert_allclose(vertices["confidence"], held / 4, rtol=1e-6)
    assert (vertices["rgb"] == 255).all()


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
