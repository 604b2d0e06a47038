"""The objects of Figs. 14 to 16: what they are made of, where they stand, how fine they are."""

import numpy as np
import pytest
from pytest import approx, mark
from vectors import unit
from walls import WRAP

pytest.importorskip("embreex")

from cmtof.pointcloud import points_from_depth
from cmtof.simulation import RELEASED_WRAPS
from cmtof_lab import objects
from cmtof_lab.objects import DISTANCE, HEIGHT, WIDTH, gage_blocks, object_mesh
from cmtof_lab.targets import MeshTarget

WRAPS = WRAP * np.array(RELEASED_WRAPS)


def unit_rays(view):
    """Rays (96, 96, 3) over a field of view, rad."""
    focal = 48 / np.tan(view / 2)
    return points_from_depth(np.ones((96, 96)), [focal, focal, 48, 48])


def looked_at(name):
    rays = unit_rays(objects.FIELD_OF_VIEW[name])
    return rays, MeshTarget.from_mesh(object_mesh(name)).look(rays)


@mark.parametrize("name", objects.OBJECTS)
def test_an_object_stands_before_a_wall_within_the_wraps_36_to_56(name):
    rays, hits = looked_at(name)
    low, high = WRAPS / 1.0003  # index of the air
    assert low < hits.range.min() < DISTANCE < hits.range.max() < high
    corners = hits.range * rays[..., 2]
    assert (corners[0, [0, -1]] > DISTANCE + 0.05).all()
    assert hits.reflectance.min() >= 0
    assert hits.reflectance.max() <= 1


def test_still_lifes_stand_on_a_table_and_differ():
    stated = [objects.OBJECTS[name]["pieces"] for name in ("vase", "kettle", "books")]
    drawn = [objects.still_life(stated, np.random.default_rng(k)) for k in (0, 0, 1)]
    (first, view), (same, _), (other, _) = drawn
    assert np.array_equal(first.vertices, same.vertices)
    assert abs(first.vertices - other.vertices).max() > 0.01
    hits = MeshTarget.from_mesh(first).look(unit_rays(view))
    low, high = WRAPS
    assert ((low < hits.range) & (hits.range < high)).mean() > 0.7


def test_materials_are_those_of_the_paper():
    shown = ("bust", "helmet", "owl", "table")
    bust, helmet, owl, table = (looked_at(name)[1] for name in shown)
    assert np.median(bust.reflectance[bust.range < 1.0]) == approx(0.8)
    assert (helmet.mirrored > 0.9).mean() > 0.2
    feathers = owl.reflectance[owl.range < 1.0]
    assert feathers.min() < 0.05
    assert feathers.max() > 0.75
    assert len(np.unique(table.reflectance.round(2))) > 8


def test_the_step_of_the_gauge_blocks_is_along_their_normal():
    tilt, step = 0.1, 0.5e-3
    target = MeshTarget.from_mesh(
        gage_blocks(step, 1.0, tilt=tilt, errors=(1e-7, -3e-7))
    )
    # the last two lie beside the faces
    x = WIDTH * np.array([-0.5, 0.5, 1.1, 0])
    y = HEIGHT * np.array([0.1, -0.1, 0, 0.6])
    rays = unit(np.column_stack([x, y, np.ones(4)]))
    reach = target.look(rays).range
    assert np.isnan(reach[2:]).all()
    left, right = (rays @ [-np.sin(tilt), 0, np.cos(tilt)] * reach)[:2]
    assert left - right == approx(step - 4e-7, abs=1e-12)
    assert left == approx(np.cos(tilt) - 1e-7, abs=1e-12)
