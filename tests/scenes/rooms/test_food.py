"""Fruit in a bowl: it rests, and no part of it comes through."""

import numpy as np
import pytest
from furnishing import draw

from cmtof.scenes.rooms import food

SEEDS = range(40)


def outer_radius(bowl: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Radius of a turned bowl's outside at each height below its rim, m."""
    r = np.hypot(bowl[:, 0], bowl[:, 1])
    rings = np.unique(bowl[:, 2])
    widest = np.array([r[bowl[:, 2] == z].max() for z in rings])
    return np.interp(height, rings, np.maximum.accumulate(widest))


def fruits(thing):
    """Bodies of the fruits, without stalks."""
    return [
        p.mesh.vertices for p in thing.parts[1:] if np.ptp(p.mesh.vertices, axis=0).min() > 0.04
    ]


@pytest.mark.parametrize("seed", SEEDS)
def test_no_fruit_comes_through_the_bowl(seed):
    thing = draw(food.fruit_bowl, seed)
    bowl = thing.parts[0].mesh.vertices
    for part in thing.parts[1:]:
        v = part.mesh.vertices
        v = v[v[:, 2] < bowl[:, 2].max() - 0.005]
        assert (np.hypot(v[:, 0], v[:, 1]) < outer_radius(bowl, v[:, 2])).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_every_fruit_rests_on_the_bowl_or_on_a_fruit(seed):
    thing = draw(food.fruit_bowl, seed)
    bowl, bodies = thing.parts[0].mesh.vertices, fruits(thing)
    for k, body in enumerate(bodies):
        others = np.concatenate([bowl, *bodies[:k], *bodies[k + 1 :]])
        gap = np.linalg.norm(body[:, None] - others, axis=-1).min()
        assert gap < 0.02, "a fruit hangs in the air"


def test_a_ball_that_comes_down_beside_another_touches_nothing():
    assert food._on_balls([(0.0, 0.0, 0.05, 0.04)], 0.04, 0.09, 0.0) == 0.0


def test_a_ball_on_top_of_another_is_both_radii_above_it():
    assert food._on_balls([(0.01, 0.02, 0.05, 0.03)], 0.04, 0.01, 0.02) == pytest.approx(0.12)


def test_a_ball_between_two_touches_both():
    below = [(-0.04, 0.0, 0.04, 0.04), (0.04, 0.0, 0.04, 0.04)]
    assert food._on_balls(below, 0.04, 0.0, 0.0) == pytest.approx(0.04 + 0.04 * np.sqrt(3))
