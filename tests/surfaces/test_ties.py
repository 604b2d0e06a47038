"""Surfaces that meet share their depth but for whole wraps."""

from itertools import combinations

import numpy as np
from exact_scenes import SHAPE, exact_field, plane_depth

from cmtof.surfaces.method import _inside
from cmtof.surfaces.offsets import Offsets
from cmtof.surfaces.ties import Borders, Ties, tied

GOOD = 2.0


def known(mean, spread):
    return Offsets(np.array(mean, float), np.array(spread, float))


def between(*entries):
    columns = np.array(entries, float).reshape(-1, 4).T
    return Borders(*columns[:2].astype(int), *columns[2:])


def test_two_that_meet_share_their_precision():
    """The mean of two Gaussians, one of them shifted by the step of the border."""
    found = tied(known([0.3, 2.5], [0.2, 0.4]), between((0, 1, 2, GOOD)))
    mean = (0.3 / 0.2**2 + 0.5 / 0.4**2) / (1 / 0.2**2 + 1 / 0.4**2)
    np.testing.assert_allclose(found.mean, [mean, mean + 2])
    np.testing.assert_allclose(found.spread, (1 / 0.2**2 + 1 / 0.4**2) ** -0.5)
    np.testing.assert_array_equal(found.wraps, [0, 2])


def test_none_are_tied_that_disagree_or_against_the_odds():
    found = tied(known([0, 9], [0.3, 0.3]), between((0, 1, 0, GOOD)))
    np.testing.assert_allclose(found.mean, [0, 9])
    found = tied(known([0.2, 0.6], [0.2, 0.2]), between((0, 1, 0, 1e-6)))
    assert found.group[0] != found.group[1]
    assert tied(known([], []), between()).wraps.size == 0


def test_neither_the_order_of_borders_nor_their_sides_matter(rng):
    for count in (2, 5, 9):
        true, spread = rng.integers(-20, 20, count), rng.uniform(0.05, 2, count)
        pairs = [pair for pair in combinations(range(count), 2) if rng.random() < 0.7]
        steps = [(true[b] - true[a] + rng.integers(-1, 2), rng.uniform(0.01, 2)) for a, b in pairs]
        found = known(true + spread * rng.normal(size=count), spread)
        once = tied(found, between(*((*p, *s) for p, s in zip(pairs, steps, strict=True))))
        turned = [(b, a, -s, o) for (a, b), (s, o) in zip(pairs, steps, strict=True)]
        got = tied(found, between(*(turned[i] for i in rng.permutation(len(turned)))))
        np.testing.assert_array_equal(got.wraps, once.wraps)
        np.testing.assert_allclose(got.mean, once.mean)


def test_the_middle_of_a_group_decides_which_beat_it_lies_in_and_not_its_far_pixels():
    field, depth = exact_field(plane_depth((0, 0, 1), 2.5)[0]), np.full(SHAPE, 2.5)
    depth[0] = 5000.0
    held = Ties(np.zeros(1), np.zeros(1, int), np.zeros(1), np.ones(1))
    label = np.zeros(SHAPE, np.int32)
    assert _inside(held, depth, label, field).wraps == 0
    assert _inside(held, depth + 7.5, label, field).wraps < -350
