"""The plan numbers every burst once, and its rays are a pinhole's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.hardware.plan import (
    DARK_BURSTS,
    LINE_LENGTH,
    REFERENCE_BURSTS,
    angles_from_rays,
    plan_from_dict,
    point_list,
    points_from_csv,
    raster,
)
from cmtof.scenes.frame import rays_from_camera

VIEW = (np.deg2rad(20.0), np.deg2rad(20.0))


@given(st.integers(1, 7), st.integers(1, 7), st.sampled_from([(0.0,), (-1e-3, 0.0, 1e-3)]))
def test_every_burst_has_one_number_and_every_pixel_one_burst_a_mode(height, width, sweep):
    plan = raster((height, width), field_of_view=VIEW, sweep=sweep)
    labels = [label for line in plan.lines for label in line.labels]
    assert labels == list(range(1, plan.bursts + 1))
    assert [line.index for line in plan.lines] == list(range(len(plan.lines)))
    for mode in plan.modes:
        seen = np.zeros(plan.shape, int)
        for line in plan.lines:
            if (line.kind, line.mode) == ("scan", mode):
                seen[line.row, line.columns] += 1
        assert (seen == 1).all()


def test_each_mode_is_taken_in_one_go_between_two_looks_at_the_reference():
    plan = raster(3, field_of_view=VIEW, sweep=(0.0, 1e-3))
    order = [(line.mode, line.kind, line.bursts) for line in plan.lines]
    reference = ("reference", 2 * REFERENCE_BURSTS)
    one = [("dark", DARK_BURSTS), reference, *[("scan", 3)] * 3, reference]
    assert order == [(mode, *part) for mode in ("single", "doubled") for part in one]


def test_a_list_of_points_is_cut_into_lines():
    plan = point_list(np.zeros((LINE_LENGTH + 3, 2)))
    spans = [line.bursts for line in plan.lines if line.kind == "scan"]
    assert spans == [LINE_LENGTH, 3] * 2
    assert plan.shape == (1, LINE_LENGTH + 3)
    assert plan.camera is None


def test_the_raster_is_uniform_in_the_tangent_and_spans_the_field():
    plan = raster((3, 5), field_of_view=VIEW)
    tangent = np.tan(plan.angles[1, :, 0])
    np.testing.assert_allclose(np.diff(tangent, 2), 0, atol=1e-15)
    step = tangent[1] - tangent[0]
    np.testing.assert_allclose(np.arctan(tangent[-1] + step / 2), VIEW[0] / 2)
    np.testing.assert_allclose(plan.angles[:, 2, 0], 0, atol=1e-15)  # the middle column
    assert plan.angles[0, 0, 1] < 0 < plan.angles[-1, 0, 1]  # rows run along y, downwards


def test_angles_are_those_of_the_cameras_rays():
    plan = raster((4, 6), field_of_view=VIEW)
    assert plan.camera is not None
    rays = rays_from_camera(plan.shape, plan.camera)
    np.testing.assert_array_equal(plan.angles, angles_from_rays(rays))


@pytest.mark.parametrize(
    "plan",
    [raster((2, 3), field_of_view=VIEW, sweep=(0.1,)), point_list([[0.01, 0.02], [0.0, 1 / 3]])],
)
def test_a_plan_comes_back_from_its_header(plan):
    again = plan_from_dict(plan.as_dict())
    np.testing.assert_array_equal(again.angles, plan.angles)
    assert again.lines == plan.lines
    assert again.as_dict() == plan.as_dict()


def test_a_plan_is_frozen():
    plan = raster(2, field_of_view=VIEW)
    with pytest.raises(ValueError, match="read-only"):
        plan.angles[0, 0] = 1
    with pytest.raises(AttributeError):
        plan.modes = ()  # type: ignore[misc]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x,y\n0.1,-0.2\n0,0.3\n", [[0.1, -0.2], [0.0, 0.3]]),
        ("x_deg, y_deg\n180, 90\n\n", [[np.pi, np.pi / 2]]),
    ],
)
def test_points_are_read(tmp_path, text, expected):
    path = tmp_path / "points.csv"
    path.write_text(text)
    np.testing.assert_allclose(points_from_csv(path), expected)


@pytest.mark.parametrize(
    "content",
    [b"", b"x,y\n", b"a,b\n1,2\n", b"x,y\n1\n", b"x,y\n1,2,3\n", b"x,y\n1,nan\n", b"\xff\xfe\x00"],
)
def test_bad_tables_are_refused_in_one_sentence(tmp_path, content):
    path = tmp_path / "points.csv"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"^Expected .*, got .*\. \w.*\.$"):
        points_from_csv(path)


@pytest.mark.parametrize(
    ("build", "named"),
    [
        (lambda: raster(0, field_of_view=VIEW), "1 px or more"),
        (lambda: raster(4, field_of_view=(0.1, 4.0)), "angles of view"),
        (lambda: raster(4, field_of_view=VIEW, modes=()), "modes out of"),
        (lambda: raster(4, field_of_view=VIEW, modes=("single", "single")), "each mode once"),
        (lambda: raster(4, field_of_view=VIEW, modes=("tripled",)), "modes out of"),
        (lambda: point_list([]), "points"),
        (lambda: point_list([[0, np.inf]]), "points"),
    ],
)
def test_what_cannot_be_scanned_is_refused(build, named):
    with pytest.raises(ValueError, match=f"^Expected .*{named}"):
        build()
