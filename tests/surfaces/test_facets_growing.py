"""Surfaces take the cells that they explain, no more and no fewer."""

import numpy as np
import pytest
from facet_scenes import SHAPE, WRAP, Scene, exact_field, plane_depth

from cmtof.measurement import Measurement
from cmtof.surfaces.field import CELL, field_from_measurement
from cmtof.surfaces.growing import around, grown_surfaces
from cmtof.surfaces.labels import depth_of_labels, pixel_labels


def cells(shape=SHAPE):
    return shape[0] // CELL * (shape[1] // CELL)


@pytest.mark.parametrize("bent", [True, False])
@pytest.mark.parametrize("information", [3.0, 56.0])
@pytest.mark.parametrize("normal", [(0, 0, 1), (0.3, 0.1, 1), (-0.2, 0.6, 1), (0.7, -0.2, 1)])
def test_one_plane_is_one_surface(normal, information, bent, rng):
    depth, _ = plane_depth(normal, 2.5)
    field = exact_field(depth, information=information, noise_of=rng)
    owner, surfaces = grown_surfaces(field, bent=bent)
    assert len(surfaces) >= 1
    assert np.bincount(owner[owner >= 0]).max() >= 0.98 * cells()
    if not bent:
        assert not surfaces[:, 3:].any()


@pytest.mark.parametrize("column", [80, 71, 66])
@pytest.mark.parametrize("step", [0.5 * WRAP, 20.3 * WRAP, -30.5 * WRAP])
def test_a_step_parts_two_surfaces(column, step, rng):
    depth, _ = plane_depth((0.2, 0.1, 1), 2.5)
    depth = depth + np.where(np.arange(SHAPE[1]) < column, 0, step)
    owner, _ = grown_surfaces(exact_field(depth, information=20.0, noise_of=rng))
    left, right = owner[:, : column // CELL], owner[:, -(-column // CELL) :]
    names = [np.bincount(side[side >= 0]).argmax() for side in (left, right)]
    assert names[0] != names[1]
    for side, name in zip((left, right), names, strict=True):
        # but for a cell along the border
        assert (side == name).mean() > 0.9
    assert (left[:, :-1] == names[0]).mean() > 0.99
    assert (right[:, 1:] == names[1]).mean() > 0.99


def test_the_border_is_known_to_pixels(rng):
    column = 75
    depth, _ = plane_depth((0.2, 0.1, 1), 2.5)
    depth = depth + np.where(np.arange(SHAPE[1]) < column, 0, 20.5 * WRAP)
    field = exact_field(depth, information=20.0, noise_of=rng)
    owner, surfaces = grown_surfaces(field)
    label, share = pixel_labels(field, owner, surfaces)
    left = label == label[60, 20]
    assert np.abs(left.sum(axis=1) - column).max() <= 2
    assert share[label >= 0].mean() > 0.9


def test_darkness_grows_nothing():
    depth, _ = plane_depth((0, 0, 1), 2.5)
    owner, surfaces = grown_surfaces(exact_field(depth, information=0.0))
    assert (owner == -1).all()
    assert surfaces.shape == (0, 6)


@pytest.mark.parametrize("seed", range(5))
def test_noise_alone_grows_little(seed):
    """Phases without any order: what a plane explains of them is chance."""
    rng = np.random.default_rng(seed)
    phase = rng.uniform(0, 2 * np.pi, (2, *SHAPE))
    field = field_from_measurement(Measurement.from_phase(phase, (7.15e9, 14.32e9)))
    owner, _ = grown_surfaces(field)
    assert (owner >= 0).mean() < 0.05


def test_dark_pixels_belong_to_nothing(rng):
    depth, _ = plane_depth((0, 0, 1), 2.5)
    information = np.broadcast_to(np.where(np.arange(SHAPE[1]) < 80, 56.0, 0.0), SHAPE)
    field = exact_field(depth, information=information, noise_of=rng)
    owner, surfaces = grown_surfaces(field)
    label, _ = pixel_labels(field, owner, surfaces)
    assert (label[:, :80] >= 0).mean() > 0.99
    assert (label[:, 90:] == -1).all()


def test_parts_of_the_corner_are_its_surfaces(corner: Scene, clean_corner):
    field = field_from_measurement(clean_corner)
    owner, surfaces = grown_surfaces(field)
    label, _ = pixel_labels(field, owner, surfaces)
    main = [np.bincount(label[(corner.part == n) & (label >= 0)]).argmax() for n in range(6)]
    assert len(set(main)) == 6
    assert np.mean(np.array(main)[corner.part] == label) > 0.97


def test_no_depth_without_a_surface():
    depth, q = plane_depth((0, 0, 1), 2.5)
    label = np.full(SHAPE, -1)
    label[3, 4] = 0
    found = depth_of_labels(exact_field(depth), label, q[None])
    assert np.isnan(found).sum() == found.size - 1
    assert found[3, 4] == pytest.approx(depth[3, 4])
    assert np.isnan(depth_of_labels(exact_field(depth), label, np.zeros((0, 6)))).all()


@pytest.mark.parametrize(
    ("cell", "owners"), [((0, 0), {0, 1}), ((1, 1), {0, 1, 2}), ((2, 2), {2}), ((2, 0), {0})]
)
def test_owners_about_a_cell(cell, owners):
    owner = np.array([[0, 1, 1], [0, -1, -1], [-1, -1, 2]])
    found = np.empty(9, np.int64)
    count = around(owner, *cell, found)
    assert set(found[:count].tolist()) == owners
    assert len(set(found[:count].tolist())) == count
