"""Pianos, bicycles, easels: things with one right size."""

import pytest
from furnishing import assert_made_well, draw

from cmtof.scenes.rooms.hobbies import CATALOGUE

LIMITS = {
    "upright_piano": ((1.4, 1.6), (0.5, 0.75), (1.05, 1.6)),
    "grand_piano": ((1.35, 1.7), (1.3, 1.8), (0.95, 1.9)),
    "exercise_bike": ((0.9, 1.2), (0.4, 0.6), (1.0, 1.3)),
    "bicycle": ((1.55, 1.85), (0.4, 0.65), (0.85, 1.15)),
    "rocking_horse": ((0.75, 1.2), (0.22, 0.36), (0.72, 1.1)),
    "music_stand": ((0.4, 0.7), (0.4, 0.65), (1.0, 1.6)),
    "easel": ((0.6, 0.9), (0.6, 0.85), (1.5, 2.1)),
    "sewing_machine_table": ((0.8, 1.1), (0.4, 0.6), (1.0, 1.15)),
}
"""Least and greatest width, depth and height, m."""


def test_every_piece_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    assert_made_well(name, CATALOGUE[name], LIMITS[name], check_thing)


def test_a_piano_has_52_white_and_36_black_keys():
    for seed in range(6):
        parts = draw(CATALOGUE["grand_piano"], seed).parts
        counts = [len(p.mesh.faces) // 12 for p in parts]
        assert 52 in counts
        assert 36 in counts


def test_wheels_of_a_bicycle_touch_the_floor_a_metre_apart():
    thing = draw(CATALOGUE["bicycle"], 2)
    tyres = [p.mesh.vertices for p in thing.parts if p.material.specular == 0.02]
    centres = [float(v[:, 0].max() + v[:, 0].min()) / 2 for v in tyres[:2]]
    assert [float(v[:, 2].min()) for v in tyres[:2]] == pytest.approx([0, 0], abs=2e-3)
    assert abs(centres[1] - centres[0]) == pytest.approx(1.05, abs=0.02)
