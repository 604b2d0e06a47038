"""The objects of Figs. 14 to 16: what they are made of, where they stand, how fine they are."""

import numpy as np
import pytest

pytest.importorskip("embreex")
pytest.importorskip("trimesh")

from cmtof.instrument.optics import directions_from_angles, returned_fraction
from cmtof.instrument.settings import Optics
from cmtof.instrument.targets import scene_from
from cmtof.scenes.objects import (
    OBJECTS,
    field_of_view,
    gage_blocks,
    object_scene,
    slanted_plane,
)
from cmtof.scenes.objects.flat import HEIGHT, WIDTH
from cmtof.scenes.objects.staging import DISTANCE, lathe, refined, smoothed
from cmtof.scenes.rooms.solids import ball


def looked_at(name, n=96):
    half = field_of_view(name) / 2
    angle = np.linspace(-half, half, n)
    rays = directions_from_angles(np.stack(np.meshgrid(angle, angle), -1))
    return rays, object_scene(name).look(rays)


@pytest.mark.parametrize("name", OBJECTS)
def test_an_object_stands_a_metre_away_before_a_wall(name):
    rays, hits = looked_at(name)
    assert np.isfinite(hits.range).all()
    assert 0.75 < hits.range.min() < DISTANCE < hits.range.max() < 1.4
    # in the middle the object, about a metre away; in the upper corners the wall behind it
    middle = hits.range[40:56, 40:56]
    assert 0.85 < np.median(middle) < 1.1
    corner = (rays * hits.range[..., None])[0, [0, -1]]
    assert (corner[:, 2] > 1.2).all()
    assert ((hits.reflectance >= 0) & (hits.reflectance <= 1)).all()
    assert ((hits.cosine >= 0) & (hits.cosine <= 1 + 1e-12)).all()


@pytest.mark.parametrize("name", OBJECTS)
def test_an_object_is_the_same_every_time(name):
    first = object_scene(name)
    again = object_scene.__wrapped__(name)  # without the cache
    np.testing.assert_array_equal(first.vertices, again.vertices)
    np.testing.assert_array_equal(first.reflectance, again.reflectance)


def test_materials_are_those_of_the_paper():
    seen = {name: looked_at(name)[1] for name in OBJECTS}
    front = {name: hits.range < 1.1 for name, hits in seen.items()}
    bust = seen["bust"].reflectance[front["bust"] & (seen["bust"].mirrored == 0)]
    assert np.median(bust) == pytest.approx(0.8)
    owl = seen["owl"].reflectance[front["owl"]]
    assert owl.min() < 0.05
    assert owl.max() > 0.75
    assert len(np.unique(seen["table"].reflectance.round(2))) > 8
    helmet = seen["helmet"]
    metal = np.asarray(helmet.mirrored) > 0.9
    assert metal.mean() > 0.2
    faint = returned_fraction(Optics(), "mixed", helmet)[metal]
    wall = returned_fraction(Optics(), "mixed", helmet)[helmet.range > 1.25]
    assert np.median(faint) < 0.15 * np.median(wall)


def test_holes_of_the_helmet_show_the_wall():
    _, hits = looked_at("helmet", 300)
    metal = np.asarray(hits.mirrored) > 0.9
    # a hole: wall with metal to the left and to the right in its row, within the slits' height
    row = slice(100, 135)
    through = ~metal[row] & (hits.range[row] > 1.2)
    enclosed = (
        np.maximum.accumulate(metal[row], 1) & np.maximum.accumulate(metal[row, ::-1], 1)[:, ::-1]
    )
    assert (through & enclosed).sum() > 200


def test_facets_lie_below_the_noise():
    """A turned body's middle of a face is off the curve by less than 5 um."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 13)
    body = lathe(0.05 * np.column_stack([np.cos(angle), np.sin(angle)]))
    corners = body.vertices[body.faces].astype(float)
    level = np.abs(corners[..., 2]).max(1) < 0.03
    gap = np.hypot(corners[..., 0], corners[..., 1])[level]
    middle = corners.mean(1)[level]
    inner = np.hypot(middle[:, 0], middle[:, 1])
    sagged = np.interp(middle[:, 2], np.sort(corners[level][..., 2].ravel()),
                       gap.ravel()[np.argsort(corners[level][..., 2].ravel())]) - inner  # fmt: skip
    assert np.abs(sagged).max() < 8e-6


def test_a_refined_grid_keeps_its_points_and_its_curve():
    turn = np.arange(24) * (2 * np.pi / 24)
    height = np.linspace(0, 0.1, 9)
    grid = np.empty((9, 24, 3))
    grid[..., 0], grid[..., 1] = 0.05 * np.cos(turn), 0.05 * np.sin(turn)
    grid[..., 2] = height[:, None]
    fine = refined(grid, 4)
    assert fine.shape == (33, 96, 3)
    np.testing.assert_allclose(fine[::4, ::4], grid, atol=1e-12)
    np.testing.assert_allclose(np.hypot(fine[..., 0], fine[..., 1]), 0.05, atol=5e-6)


def test_smoothing_cuts_faces_and_keeps_the_shape():
    coarse = ball(0.05, subdivisions=2)
    fine = smoothed(coarse, 2)
    assert len(fine.faces) == 16 * len(coarse.faces)
    radius = np.linalg.norm(fine.vertices, axis=1)
    assert radius.std() < 2e-4


def test_the_step_of_the_gauge_blocks_is_along_their_normal():
    tilt, step = 0.1, 0.5e-3
    target = gage_blocks(step, 1.0, tilt=tilt, errors=(1e-7, -3e-7))
    x = np.array([-0.5 * WIDTH, 0.5 * WIDTH])
    rays = directions_from_angles(np.stack([np.arctan(x), [0.002, -0.003]], -1))
    hits = target.look(rays)
    points = rays * hits.range[:, None]
    normal = np.array([-np.sin(tilt), 0, np.cos(tilt)])
    left, right = points @ normal
    assert left - right == pytest.approx(step - 4e-7, abs=1e-12)
    assert left == pytest.approx(np.cos(tilt) - 1e-7, abs=1e-12)
    beside = directions_from_angles([[0.0, 0.6 * HEIGHT], [1.1 * WIDTH, 0.0]])
    assert np.isnan(target.look(beside).range).all()


def test_the_slanted_plane():
    plane = slanted_plane(1.5, 0.4, 0.3)
    rays = directions_from_angles([[0.1, 0.05]])
    hits = plane.look(rays)
    point = (rays * hits.range[:, None])[0]
    assert point[2] == pytest.approx(1.5 + np.tan(0.4) * point[0])
    assert hits.reflectance[0] == 0.3


def test_a_rig_file_names_an_object():
    assert scene_from({"kind": "object", "name": "bust"}) is object_scene("bust")


@pytest.mark.parametrize("ask", [object_scene, field_of_view])
def test_an_unknown_object_is_refused(ask):
    with pytest.raises(ValueError, match="Expected an object out of bust, helmet, owl, table"):
        ask("cat")
