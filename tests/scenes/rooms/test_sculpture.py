"""Heads, figures and curiosities; fruit that rests on fruit."""

import numpy as np
import pytest
from furnishing import assert_made_well, closed_volumes, distinct, draw

from cmtof.scenes.rooms import food, sculpture, vessels
from cmtof.scenes.rooms.portraits import STATUARY, draw_face, portrait
from cmtof.scenes.rooms.thing import Thing

CATALOGUE = {**sculpture.CATALOGUE, **food.CATALOGUE}
LIMITS = {
    "bust": ((0.07, 0.5), (0.08, 0.3), (0.15, 0.55)),
    "statuette": ((0.06, 0.4), (0.06, 0.2), (0.17, 0.45)),
    "owl_figure": ((0.05, 0.18), (0.05, 0.18), (0.09, 0.29)),
    "animal_figure": ((0.05, 0.4), (0.03, 0.22), (0.07, 0.36)),
    "trophy": ((0.1, 0.32), (0.06, 0.2), (0.17, 0.52)),
    "skull": ((0.1, 0.18), (0.14, 0.24), (0.14, 0.25)),
    "stone": ((0.03, 0.19), (0.02, 0.16), (0.01, 0.24)),
    "shell": ((0.05, 0.17), (0.03, 0.12), (0.01, 0.1)),
    "globe": ((0.13, 0.38), (0.12, 0.37), (0.18, 0.5)),
    "mask": ((0.08, 0.25), (0.04, 0.16), (0.12, 0.5)),
    "apple": ((0.06, 0.09), (0.06, 0.09), (0.06, 0.1)),
    "pear": ((0.05, 0.09), (0.05, 0.08), (0.08, 0.14)),
    "orange": ((0.05, 0.12), (0.05, 0.12), (0.05, 0.11)),
    "banana_bunch": ((0.15, 0.23), (0.05, 0.22), (0.03, 0.09)),
    "bread": ((0.15, 0.58), (0.05, 0.25), (0.03, 0.17)),
    "pumpkin": ((0.12, 0.35), (0.12, 0.35), (0.08, 0.36)),
    "fruit_bowl": ((0.25, 0.34), (0.25, 0.34), (0.06, 0.25)),
    "cake": ((0.22, 0.4), (0.22, 0.4), (0.06, 0.28)),
}
"""Least and greatest width, depth and height, m."""
BUDGETS = {"skull": 7000}


def test_everything_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    standing = "wall" if name == "mask" else "floor"
    budget = BUDGETS.get(name, 6000)
    assert_made_well(
        name, CATALOGUE[name], LIMITS[name], check_thing, budget=budget, standing=standing
    )


@pytest.mark.parametrize("name", ["bust", "statuette", "animal_figure"])
def test_no_two_come_from_one_mould(name):
    assert distinct(CATALOGUE[name]) >= 3


def test_statues_are_of_marble_plaster_and_bronze_at_least():
    assert len(STATUARY) >= 3
    assert {m.pattern for m in STATUARY} >= {"marble", "plain", "noise"}


@pytest.mark.parametrize("cut", ["rounded", "square", "neck"])
@pytest.mark.parametrize("seed", range(3))
def test_a_portrait_is_a_head_of_its_height_with_the_nose_in_front(cut, seed):
    rng = np.random.default_rng(seed)
    face = draw_face(rng, cut)._replace(turn=0.0, nod=0.0, hair=0.0, beard=0.0)
    mesh = portrait(rng, face, 0.23)
    v = mesh.vertices
    chin = v[:, 2].max() - 0.23
    head = v[v[:, 2] > chin]
    nose = head[np.argmin(head[:, 1])]
    assert abs(nose[0]) < 0.01
    assert 0.25 < (nose[2] - chin) / 0.23 < 0.4
    assert np.ptp(head[:, 0]) == pytest.approx(0.16, abs=0.03)
    assert closed_volumes(Thing("head").add(mesh, STATUARY[0]))[0] > 0


def test_a_portrait_without_turn_and_hair_is_its_own_mirror_image():
    rng = np.random.default_rng(1)
    face = draw_face(rng, "neck")._replace(turn=0.0, nod=0.0, hair=0.0)
    v = portrait(rng, face, 0.2).vertices
    assert v[:, 0].max() == pytest.approx(-v[:, 0].min(), abs=1e-4)
    assert v[:, 0].mean() == pytest.approx(0, abs=1e-4)


@pytest.mark.parametrize("far", [0.0, 0.03, 0.06])
def test_a_ball_at_its_resting_height_touches_the_bowl_and_does_not_sink(far):
    corners = vessels.outline(((0.4, 0), (0.45, 0.03), (0.75, 0.22), (1.0, 1.0)), 0.15, 0.08)
    z = food.resting_height(corners, 0.005, 0.04, far)
    from cmtof.scenes.rooms.shaping import outline_radius

    r, h = outline_radius(corners, 0.005)
    gap = np.hypot(np.concatenate([r, -r]) - far, np.concatenate([h, h]) - z) - 0.04
    assert gap.min() == pytest.approx(0, abs=5e-4)


def test_fruit_lies_in_the_bowl_and_not_under_it():
    for seed in range(8):
        thing = draw(food.fruit_bowl, seed)
        bowl = thing.parts[0].mesh.vertices
        rim = np.hypot(bowl[:, 0], bowl[:, 1]).max()
        for part in thing.parts[1:]:
            v = part.mesh.vertices
            assert v[:, 2].min() > 0.003
            assert np.hypot(v[:, 0], v[:, 1]).max() < rim + 0.06


def test_a_bowl_has_four_to_nine_fruits():
    counts = []
    for seed in range(12):
        parts = draw(food.fruit_bowl, seed).parts[1:]
        counts.append(sum(np.ptp(p.mesh.vertices, axis=0).min() > 0.04 for p in parts))
    assert min(counts) >= 4
    assert max(counts) <= 9
    assert len(set(counts)) > 1
