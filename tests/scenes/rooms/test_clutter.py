"""Boxes, toys, clothes; who puts what where."""

import numpy as np
import pytest
from furnishing import assert_made_well, draw

from cmtof.scenes.rooms import clutter, containers, inventory, toys
from cmtof.scenes.rooms.objects import groups

CATALOGUE = clutter.CATALOGUE
LIMITS = {
    "cardboard_box": ((0.19, 1.0), (0.16, 0.95), (0.14, 0.65)),
    "basket": ((0.2, 0.46), (0.2, 0.46), (0.09, 0.6)),
    "laundry_basket": ((0.34, 0.56), (0.34, 0.6), (0.33, 0.75)),
    "storage_box": ((0.19, 0.5), (0.15, 0.38), (0.08, 0.3)),
    "tissue_box": ((0.11, 0.24), (0.11, 0.15), (0.1, 0.22)),
    "bucket": ((0.22, 0.4), (0.2, 0.42), (0.2, 0.52)),
    "paint_bucket": ((0.1, 0.4), (0.1, 0.26), (0.08, 0.27)),
    "waste_bin": ((0.18, 0.32), (0.18, 0.36), (0.22, 0.42)),
    "crumpled_paper": ((0.03, 0.13), (0.03, 0.13), (0.03, 0.13)),
    "broom": ((0.26, 0.48), (0.05, 0.12), (1.2, 1.5)),
    "toolbox": ((0.33, 0.55), (0.17, 0.26), (0.15, 0.32)),
    "gift_box": ((0.1, 0.36), (0.1, 0.3), (0.06, 0.29)),
    "watering_can": ((0.3, 0.65), (0.13, 0.24), (0.16, 0.36)),
    "picture_frame": ((0.09, 0.24), (0.04, 0.15), (0.11, 0.28)),
    "umbrella_stand": ((0.19, 0.65), (0.19, 0.65), (0.7, 1.0)),
    "teddy_bear": ((0.1, 0.36), (0.08, 0.3), (0.14, 0.4)),
    "toy_car": ((0.07, 0.29), (0.03, 0.14), (0.025, 0.12)),
    "toy_train": ((0.15, 0.65), (0.035, 0.09), (0.06, 0.14)),
    "building_blocks": ((0.15, 0.6), (0.15, 0.65), (0.08, 0.32)),
    "ball_toy": ((0.06, 0.37), (0.06, 0.37), (0.06, 0.37)),
    "chess_board": ((0.36, 0.5), (0.36, 0.5), (0.07, 0.14)),
    "shoes": ((0.18, 0.32), (0.23, 0.42), (0.08, 0.34)),
    "handbag": ((0.22, 0.4), (0.08, 0.17), (0.24, 0.45)),
    "backpack": ((0.28, 0.45), (0.22, 0.38), (0.4, 0.6)),
    "suitcase": ((0.34, 0.72), (0.14, 0.31), (0.34, 1.25)),
    "guitar": ((0.3, 0.42), (0.3, 0.45), (1.0, 1.25)),
    "helmet": ((0.18, 0.28), (0.24, 0.36), (0.12, 0.28)),
    "hat": ((0.18, 0.52), (0.22, 0.56), (0.09, 0.17)),
    "pen_cup": ((0.06, 0.16), (0.06, 0.16), (0.12, 0.2)),
    "scissors": ((0.05, 0.14), (0.11, 0.23), (0.005, 0.02)),
    "keys": ((0.04, 0.17), (0.04, 0.17), (0.004, 0.02)),
    "glasses_case": ((0.15, 0.18), (0.06, 0.14), (0.04, 0.06)),
}
"""Least and greatest width, depth and height, m."""


def test_everything_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    assert_made_well(name, CATALOGUE[name], LIMITS[name], check_thing)


def test_blocks_do_not_hang_in_the_air():
    for seed in range(6):
        thing = draw(toys.building_blocks, seed)
        low = np.array([p.mesh.vertices[:, 2].min() for p in thing.parts])
        high = np.array([p.mesh.vertices[:, 2].max() for p in thing.parts])
        for z in low[low > 1e-3]:
            assert np.abs(high - z).min() < 1.5e-3


def test_a_game_of_chess_is_about_to_begin_or_near_its_end():
    counts = []
    for seed in range(10):
        men = draw(toys.chess_board, seed).parts[-2:]
        counts.append(sum(len(p.mesh.faces) for p in men))
    assert max(counts) > 1.5 * min(counts)


def test_pentagons_cover_as_much_of_a_football_as_they_should():
    light, dark = (
        np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1).sum()
        for c in (p.mesh.vertices[p.mesh.faces] for p in toys._football(0.11).parts)
    )
    # between a truncated icosahedron's 0.284 and the 0.46 of equal distances to the middles
    assert 0.28 < dark / (light + dark) < 0.46


def test_wheels_of_a_toy_touch_the_ground():
    for maker in (toys.toy_car, toys.toy_train):
        thing = draw(maker, 2)
        low = [float(p.mesh.vertices[:, 2].min()) for p in thing.parts]
        assert min(low) == pytest.approx(0, abs=1e-5)
        assert sorted(low)[1] > 0.001


def test_boxes_are_open_or_shut():
    kinds = {bool(draw(containers.cardboard_box, seed).supports) for seed in range(12)}
    assert kinds == {True, False}


def test_nobody_has_too_few_or_unknown_things_about():
    assert len(groups) == 14
    for place, group in groups.items():
        names = [name for name, _ in group]
        assert len(names) == len(set(names)) >= 10, place
        assert set(names) <= set(inventory.CATALOGUE), place
        assert all(weight > 0 for _, weight in group), place


def test_no_mask_is_laid_on_a_table():
    assert all(name != "mask" for group in groups.values() for name, _ in group)
