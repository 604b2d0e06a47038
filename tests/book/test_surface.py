"""The wall behind a scan, its angles, and the mesh between pixels."""

import numpy as np
import pytest

from cmtof.book.views import fit_wall, mesh_triangles, render_surface
from cmtof.pointcloud import points_from_depth

CAMERA = np.array([240.0, 240.0, 50.0, 40.0])


def scan() -> np.ndarray:
    """Range (80, 100), m, of a slanted wall."""
    y, x = np.mgrid[:80, :100] + 0.5
    u, v = (x - 50) / 240, (y - 40) / 240
    return np.sqrt(1 + u**2 + v**2) / (1.4 + 0.3 * u + 0.2 * v)


def test_a_wall_and_the_scan_angles_are_found_behind_objects():
    depth = scan()
    seen = depth + 0.001 * np.random.default_rng(0).standard_normal(depth.shape)
    seen[20:70, 25:65] -= 0.09
    wall = fit_wall(seen)
    assert np.abs(wall.depth - depth).max() < 0.001
    assert wall.camera == pytest.approx(CAMERA, rel=0.03)
    assert not wall.mask[20:70, 25:65].any()
    assert wall.mask.mean() == pytest.approx(1 - 50 * 40 / depth.size, abs=0.002)


@pytest.mark.parametrize("depth", [np.ones(4), np.full((4, 4), np.nan), np.zeros((4, 4))])
def test_holes_and_stacks_are_refused(depth: np.ndarray):
    with pytest.raises(ValueError, match="Expected a range image"):
        fit_wall(depth)


def test_the_mesh_is_whole_on_a_surface_and_open_at_edges_and_holes():
    depth = scan()
    whole = mesh_triangles(points_from_depth(depth, CAMERA), longest=0.02)
    assert len(whole) == 2 * 79 * 99
    depth[:, 50:] += 0.1
    assert len(mesh_triangles(points_from_depth(depth, CAMERA), longest=0.02)) == 2 * 79 * 98
    depth[10, 10] = np.nan
    holed = mesh_triangles(points_from_depth(depth, CAMERA), longest=0.02)
    assert len(holed) == 2 * 79 * 98 - 6 and 10 * 100 + 10 not in holed


def test_a_renderer_that_fails_is_told_not_raised(tmp_path, monkeypatch):
    points = points_from_depth(scan(), CAMERA)
    monkeypatch.setattr("sys.executable", "/nonexistent/python")
    drawn = render_surface(
        points, scan(), tmp_path / "s.png", longest=0.02, eye=(0, 0, 0), cmap="cividis"
    )
    assert drawn is False and not list(tmp_path.iterdir())
