"""Stairs that one could climb."""

from pickle import dumps

import numpy as np
import pytest

from cmtof.scenes.rooms.stairs import CATALOGUE, GOING, column, straight_stairs


@pytest.mark.parametrize("name", CATALOGUE)
@pytest.mark.parametrize("seed", range(6))
def test_stairs_stand_on_the_floor(name, seed, style, check_thing):
    thing = CATALOGUE[name](np.random.default_rng(seed), style)
    check_thing(thing, triangles=6000)
    low, high = thing.bounds
    assert 3.0 < high[2] - low[2] < 4.2  # with the banister


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_same_seed_builds_the_same_stairs(name, style):
    one, two = (dumps(CATALOGUE[name](np.random.default_rng(3), style)) for _ in range(2))
    assert one == two
    assert one != dumps(CATALOGUE[name](np.random.default_rng(4), style))


def test_treads_rise_evenly_to_the_upper_floor(style):
    made = straight_stairs(np.random.default_rng(2), style, width=0.9, rise=2.6, open_side=1)
    treads = made.parts[0].mesh.vertices
    tops = np.unique(treads[:, 2].round(3))
    steps = [z for z in tops if z > 0.1]
    assert max(steps) == pytest.approx(2.6, abs=1e-3)
    count = round(2.6 / 0.185)
    for k in range(1, count + 1):
        assert np.abs(tops - k * 2.6 / count).min() < 2e-3
    assert 0.16 < 2.6 / count < 0.21
    assert 0.59 < 2 * 2.6 / count + GOING < 0.68  # the carpenter's rule


def test_a_column_reaches_from_floor_to_ceiling():
    for seed in range(4):
        mesh = column(np.random.default_rng(seed), 2.7)
        assert mesh.vertices[:, 2].min() <= 0
        assert mesh.vertices[:, 2].max() >= 2.7
