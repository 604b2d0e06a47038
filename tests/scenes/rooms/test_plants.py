"""Plants: they stand in pots, their leaves are closed and curved."""

import numpy as np
import pytest
from furnishing import assert_repeatable, closed_volumes, draw

from cmtof.scenes.rooms import plants, table_plants
from cmtof.scenes.rooms.foliage import BLADE, Leaves, arches, leaves, rested
from cmtof.scenes.rooms.materials import Material
from cmtof.scenes.rooms.thing import Mesh, Thing

CATALOGUE = {**plants.CATALOGUE, **table_plants.CATALOGUE}
SIZES = {
    "monstera": (0.5, 1.5),
    "ficus": (0.9, 2.3),
    "palm": (0.8, 2.3),
    "snake_plant": (0.4, 1.3),
    "fern": (0.2, 0.9),
    "cactus": (0.1, 0.6),
    "trailing_ivy": (0.15, 0.4),
    "herb_pot": (0.12, 0.4),
    "orchid": (0.4, 0.9),
    "flowers_in_vase": (0.2, 0.65),
    "bonsai": (0.2, 0.5),
    "dried_branches": (0.6, 1.9),
    "spider_plant": (0.15, 0.6),
}


def made(name: str, seed: int) -> Thing:
    return draw(CATALOGUE[name], seed)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", SIZES)
def test_a_plant_stands_at_its_size(check_thing, name, seed):
    thing = made(name, seed)
    check_thing(thing)
    low, high = SIZES[name]
    assert low < thing.bounds[1, 2] < high


@pytest.mark.parametrize("seed", range(8))
def test_ivy_hangs_from_the_ceiling(check_thing, seed):
    thing = made("ivy", seed)
    check_thing(thing, standing="ceiling")
    assert -1.9 < thing.bounds[0, 2] < -0.6


@pytest.mark.parametrize("name", CATALOGUE)
def test_same_seed_same_plant_and_another_seed_another(name):
    assert_repeatable(CATALOGUE[name])


def one_leaf(**options) -> Mesh:
    how = Leaves(np.zeros((1, 3)), np.array([[1.0, 0, 0]]), 0.2, 0.08, **options)
    return leaves(how, BLADE, 1e-3)


def test_a_leaf_is_a_closed_body_with_its_outside_out():
    (volume,) = closed_volumes(Thing("leaf").add(one_leaf(), Material((0, 1, 0))))
    assert volume > 0


def test_a_flat_leaf_is_as_long_and_as_wide_as_asked():
    mesh = one_leaf(droop=0.0, fold=0.0)
    size = np.ptp(mesh.vertices, axis=0)
    np.testing.assert_allclose(size[:2], [0.2, 0.08], rtol=1e-4)


def test_a_drooping_leaf_keeps_the_length_of_its_midrib():
    how = Leaves(np.zeros((1, 3)), np.array([[1.0, 0, 0]]), 0.2, 0.02, droop=np.pi / 2, fold=0.0)
    s = np.linspace(0, 1, 40)
    mesh = leaves(how, np.column_stack([s, np.full(40, 0.5)]), 0.0)
    rib = mesh.vertices[: 40 * 3].reshape(40, 3, 3)[:, 1]
    assert np.linalg.norm(np.diff(rib, axis=0), axis=1).sum() == pytest.approx(0.2, rel=1e-3)
    assert rib[-1, 2] == pytest.approx(-0.2 * 2 / np.pi, rel=1e-3)  # a quarter of a circle


def test_the_midrib_lies_below_the_edges_of_a_folded_leaf():
    mesh = one_leaf(droop=0.0, fold=0.5)
    assert mesh.vertices[:, 2].max() == pytest.approx(0.02, rel=0.01)


def test_a_stem_without_bend_is_straight():
    path = arches((0, 0, 0.1), np.array([[0.6, 0.0, 0.8]]), 0.5, 0.0)[0]
    np.testing.assert_allclose(path[-1], [0.3, 0, 0.5], atol=1e-9)


def test_leaves_below_the_floor_are_laid_on_it_in_their_order():
    heights = np.array([[0, 0, -0.2], [0, 0, -0.1], [0, 0, 0.0], [0, 0, 0.3]], np.float32)
    faces = np.array([[0, 1, 2], [1, 2, 3]], np.int32)
    thing = Thing("plant").add(Mesh(heights, faces), Material((1, 1, 1)))
    thing.add(Mesh(heights, faces), Material((0, 1, 0)))
    z = rested(thing).parts[1].mesh.vertices[:, 2]
    assert (np.diff(z) > 0).all()
    assert z[0] > 0
    assert z[3] == np.float32(0.3)
