"""Where surfaces meet, and offsets by belief propagation against all of their combinations."""

from itertools import combinations

import numpy as np
from exact_scenes import (
    COLUMNS,
    SIDES,
    WRAP,
    exact_field,
    known,
    meeting_planes,
    plane_depth,
    whole_boxes,
)
from numpy.testing import assert_allclose, assert_array_equal
from pytest import approx, mark
from scipy.special import softmax

from cmtof.surfaces import contacts
from cmtof.surfaces.fitting import move_surface
from cmtof.surfaces.shapes import BENT

REPEAT = 357.5  # wraps
SURE = 0.99


def between(*entries):
    *numbers, odds = np.reshape(entries, (-1, 4)).T
    return contacts.Borders(*np.array(numbers, int), odds)


def place(found, borders, limits=None):
    if limits is None:
        limits = np.outer([-np.inf, np.inf], np.ones_like(found.mean))
    return contacts.offsets_with_contacts(found, borders, limits, REPEAT)


def test_borders_find_whole_wraps_between_planes_that_meet():
    """Left one plane, right another that meets it, moved by three wraps."""
    field, surfaces = meeting_planes()
    found = contacts.borders(field, SIDES, surfaces)
    assert found.first.tolist() == [0]
    assert found.second.tolist() == [1]
    assert abs(found.step[0]) == 3
    assert found.odds[0] > 0.5


def test_a_border_counts_the_departure_of_its_pixels():
    """A quarter of a wrap that neither plane explains does not move the step."""
    depth, q = plane_depth((0.1, 0, 1))
    field = exact_field(depth + 0.3 * WRAP * np.sin(COLUMNS / 8))
    aside, _ = move_surface(field, q, whole_boxes(), BENT, -0.4 * WRAP)
    for other in (q, aside):
        assert contacts.borders(field, SIDES, np.stack([q, other])).step == [0]


@mark.parametrize("borders", [[(0, 1, 2, 0.7), (1, 2, -1, 0.4)], [(0, 2, 1, 0.9)]])
def test_beliefs_along_a_chain_are_those_of_all_combinations(monkeypatch, borders):
    """Without loops belief propagation is exact: against the sum over every set of offsets."""
    monkeypatch.setattr(contacts, "_LOOP", 1.0)
    monkeypatch.setattr(contacts, "_OFFSETS", np.arange(-4, 5))
    alone = known([0.3, 1.6, 0.9], [0.5, 1.0, 0.7])
    joint = joint_odds(alone, borders)
    found = place(alone, between(*borders))
    for n in range(3):
        share = joint.sum(axis=tuple({0, 1, 2} - {n})) / joint.sum()
        assert found.wraps[n] == np.rint(alone.mean[n]) + share.argmax() - 4
        assert found.odds[n] == approx(share.max(), rel=1e-3)


def joint_odds(alone, borders):
    """Odds (9, 9, 9) of all combinations of three offsets within four wraps of their own."""
    wraps = np.rint(alone.mean)[:, None] + np.arange(-4, 5)
    spread = np.hypot(alone.spread, contacts._UNSEEN)
    off = (wraps - alone.mean[:, None]) / spread[:, None]
    density = softmax(-(off**2) / 2, axis=1) + contacts._STRAY / 9
    before = np.einsum("i,j,k->ijk", *density / (1 + contacts._STRAY))
    together = np.meshgrid(*wraps, indexing="ij")
    joint = before.copy()
    for a, b, step, odds in borders:
        meets = together[b] - together[a] == step
        possible = min(9 * before[meets].sum(), 1)
        joint *= odds * possible * meets + (1 - odds * possible) / 9
    return joint


def test_a_false_contact_gives_way_to_those_that_agree():
    """Five surfaces, all in contact; one border of ten is a wrap off."""
    borders = between(
        *((*pair, pair == (0, 1), 0.8) for pair in combinations(range(5), 2))
    )
    found = place(known([0.1, 0.3, 0, 0.4, -0.2], [0.6] * 5), borders)
    assert not found.wraps.any()
    assert np.unique(found.group).size == 1


def test_a_wall_behind_leaves_keeps_its_offset():
    """Sixteen leaves seem to touch it fourteen wraps off, where its own beat forbids it."""
    borders = between(*((0, leaf, 14, 0.9) for leaf in range(1, 17)))
    assert not place(known([0.1, *[0.2] * 16], [0.1, *[1.0] * 16]), borders).wraps.any()


@mark.parametrize(
    "mean, spread, odds, second",
    [
        ([0, 9], [0.3, 0.3], SURE, 9),  # they disagree
        ([0.1, 0.8], [0.1, 0.5], 0.01, 1),
        ([0.1, 0.8], [0.1, 0.5], SURE, 0),
    ],
)
def test_none_are_tied_that_disagree_or_against_the_odds(mean, spread, odds, second):
    assert place(known(mean, spread), between((0, 1, 0, odds))).wraps.tolist() == [
        0,
        second,
    ]


def test_no_surface_has_no_offset():
    assert place(known([], []), between()).wraps.size == 0


def test_offsets_stay_within_the_limits_and_find_their_beat():
    limits = np.array([[-2.0, 340.0, -np.inf], [2.0, 370.0, np.inf]])
    found = place(known([4.0, 0.2, 0.0], [3.0, 0.3, 0.3]), between(), limits)
    assert -3 < found.wraps[0] < 3
    assert found.wraps[1:].tolist() == [np.rint(0.2 + REPEAT), 0]


@mark.parametrize("count", [2, 5, 9])
def test_neither_the_order_of_borders_nor_their_sides_matter(rng, count):
    true = rng.integers(-20, 20, count)
    spread = rng.uniform(0.05, 2, count)
    told = [
        (a, b, true[b] - true[a] + rng.integers(-1, 2), rng.random())
        for a, b in combinations(range(count), 2)
        if rng.random() < 0.7
    ]
    turned = [(b, a, -step, odds) for a, b, step, odds in told]
    rng.shuffle(turned)
    found = known(true + spread * rng.normal(size=count), spread)
    once = place(found, between(*told))
    again = place(found, between(*turned))
    assert_array_equal(again.wraps, once.wraps)
    assert_allclose(again.share, once.share, atol=1e-9)
