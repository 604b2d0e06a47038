"""Cables rest on the floor and pass over themselves; coils and reels."""

from types import ModuleType

import numpy as np
import pytest
from furnishing import assert_repeatable, draw

from cmtof.scenes.rooms import decor
from cmtof.scenes.rooms.cables import CATALOGUE
from cmtof.scenes.rooms.pliant import bars, spline
from cmtof.scenes.rooms.thing import Thing


def made(name: str, seed: int, **options) -> Thing:
    return draw(CATALOGUE[name], seed, **options)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", CATALOGUE)
def test_it_rests_where_it_belongs(check_thing, name, seed):
    check_thing(made(name, seed), standing="wall" if name == "cable_bundle" else "floor")


@pytest.mark.parametrize("name", CATALOGUE)
def test_same_seed_same_cable_and_another_seed_another(name):
    assert_repeatable(CATALOGUE[name])


def test_a_cable_begins_and_ends_where_it_is_told():
    thing = made("cable_on_floor", 4, length=2.0, start=(-0.5, 0.2), end=(0.6, -0.3))
    rings = thing.parts[0].mesh.vertices.reshape(-1, 6, 3).mean(axis=1)
    np.testing.assert_allclose(rings[0, :2], [-0.5, 0.2], atol=1e-5)
    np.testing.assert_allclose(rings[-1, :2], [0.6, -0.3], atol=1e-5)


@pytest.mark.parametrize("length", [1.0, 2.0, 4.0])
def test_a_cable_is_about_as_long_as_asked(length):
    for seed in range(10):
        thing = made("cable_on_floor", seed, length=length)
        rings = thing.parts[0].mesh.vertices.reshape(-1, 6, 3).mean(axis=1)
        assert 0.7 * length < np.linalg.norm(np.diff(rings, axis=0), axis=1).sum() < 1.6 * length


def test_cables_stay_low():
    for seed in range(10):
        assert made("cable_on_floor", seed).bounds[1, 2] < 0.035


def test_a_spline_passes_through_its_points():
    points = np.random.default_rng(0).normal(size=(6, 3))
    np.testing.assert_allclose(spline(points, 51)[::10], points, atol=1e-12)


def test_a_spline_of_equal_steps_is_a_straight_line():
    points = np.linspace([0, 0, 0], [1, 2, 3], 5)
    np.testing.assert_allclose(spline(points, 9), np.linspace([0, 0, 0], [1, 2, 3], 9), atol=1e-12)


def test_bars_have_their_radius_and_look_outwards():
    starts, ends = np.array([[0, 0, 0], [1, 1, 1.0]]), np.array([[0, 0, 1], [2, 1, 1.0]])
    mesh = bars(starts, ends, 0.1, 8)
    assert np.linalg.norm(mesh.vertices[:16, :2], axis=1) == pytest.approx(0.1)
    corners = mesh.vertices[mesh.faces[:16]].astype(float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((normal * corners.mean(axis=1))[:, :2].sum(axis=1) > 0).all()


def test_the_catalogue_holds_every_maker_once():
    modules = [
        value
        for value in vars(decor).values()
        if isinstance(value, ModuleType) and hasattr(value, "CATALOGUE")
    ]
    count = sum(len(module.CATALOGUE) for module in modules)
    assert count > 50
    assert count == len(decor.CATALOGUE)
