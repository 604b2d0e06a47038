"""Seats: one sits at 36 to 50 cm, higher at a bar."""

import numpy as np
import pytest
from furnishing import assert_made_well, draw, sizes

from cmtof.scenes.rooms.chairs import DESIGNS, dining_chair
from cmtof.scenes.rooms.seats import CATALOGUE, sofa

LIMITS = {
    "dining_chair": ((0.36, 0.62), (0.38, 0.75), (0.75, 1.1)),
    "armchair": ((0.55, 1.2), (0.6, 1.1), (0.65, 1.15)),
    "sofa": ((1.2, 3.2), (0.75, 1.15), (0.68, 1.15)),
    "stool": ((0.28, 0.52), (0.28, 0.52), (0.4, 0.52)),
    "bar_stool": ((0.28, 0.55), (0.28, 0.6), (0.6, 1.15)),
    "office_chair": ((0.55, 0.75), (0.55, 0.85), (0.9, 1.4)),
    "bench": ((0.85, 1.55), (0.28, 0.42), (0.41, 0.52)),
    "ottoman": ((0.38, 0.95), (0.38, 0.65), (0.28, 0.5)),
    "rocking_chair": ((0.45, 0.7), (0.65, 1.1), (0.95, 1.3)),
}
"""Least and greatest width, depth and height, m."""


def test_every_piece_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    assert_made_well(name, CATALOGUE[name], LIMITS[name], check_thing, budget=9000)


def test_one_sits_at_the_height_of_a_knee():
    for name in ("dining_chair", "armchair", "sofa", "office_chair", "rocking_chair"):
        heights = [s.z for seed in range(20) for s in draw(CATALOGUE[name], seed).supports[:1]]
        assert min(heights) > 0.36
        assert max(heights) < 0.56


def test_all_designs_of_chairs_can_be_asked_for(check_thing):
    for design in DESIGNS:
        for seed in range(4):
            check_thing(draw(dining_chair, seed, design=design), triangles=3000)


def test_designs_of_chairs_are_seven_different_things():
    counts = {
        tuple(len(p.mesh.faces) for p in draw(dining_chair, 1, design=d).parts) for d in DESIGNS
    }
    assert len(counts) == len(DESIGNS) == 7


@pytest.mark.parametrize("seats", [2, 3, 4])
def test_a_sofa_has_a_cushion_for_everybody(seats):
    widths = sizes(sofa, 12, seats=seats)[:, 0]
    assert (widths > 0.56 * seats + 0.1).all()
    assert (widths < 0.72 * seats + 0.75).all()


def test_more_seats_make_a_longer_sofa():
    two, four = (sizes(sofa, 12, seats=n)[:, 0].mean() for n in (2, 4))
    assert four > two + 0.8


def test_arms_of_a_sofa_rise_above_its_seat():
    for seed in range(8):
        piece = draw(sofa, seed)
        frame = piece.parts[1].mesh.vertices
        outer = frame[np.abs(frame[:, 0]) > np.abs(frame[:, 0]).max() - 0.05]
        assert outer[:, 2].max() > piece.supports[0].z + 0.05
