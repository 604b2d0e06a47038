"""Surfaces that meet share their offset; surfaces that do not are left alone."""

import numpy as np
import pytest
from facet_scenes import SHAPE, WRAP, exact_field, plane_depth, whole_boxes
from hypothesis import given
from hypothesis import strategies as st

from cmtof.surfaces.kernels import BENT, moved
from cmtof.surfaces.offsets import Offsets
from cmtof.surfaces.ties import Borders, borders, tied
from cmtof.surfaces.unwrapping import stages

GOOD = 2.0


def known(mean, spread):
    mean = np.array(mean, float)
    return Offsets(mean, np.array(spread, float))


def between(*entries):
    """Borders out of (first, second, step, odds)."""
    columns = list(zip(*entries, strict=True)) if entries else [(), (), (), ()]
    kinds = (np.int64, np.int64, float, float)
    return Borders(*(np.array(c, kind) for c, kind in zip(columns, kinds, strict=True)))


# --- ties --------------------------------------------------------------------------------------


@pytest.mark.parametrize("step", [-3, 0, 12])
@pytest.mark.parametrize("spreads", [(0.2, 0.4), (0.3, 0.3), (2.0, 0.1)])
def test_two_take_their_precision_weighted_mean(step, spreads):
    """Meeting means wraps_first - wraps_second = -step."""
    apart = -step
    found = tied(known([1.2, 0.9 - apart], spreads), between((0, 1, step, GOOD)))
    weights = 1 / np.square(spreads)
    mean = (1.2 * weights[0] + 0.9 * weights[1]) / weights.sum()
    np.testing.assert_allclose(found.mean, [mean, mean - apart])
    np.testing.assert_allclose(found.wraps, np.rint(mean) - np.array([0, apart]))
    np.testing.assert_allclose(found.spread, 1 / np.sqrt(weights.sum()))
    assert found.group[0] == found.group[1]


@pytest.mark.parametrize("steps", [(0, 0), (5, -2), (-30, 31)])
def test_a_chain_of_three_shares_one_offset(steps):
    """True offsets 4, 4 + s1, 4 + s1 + s2, each measured a little off."""
    true = 4 + np.array([0, steps[0], steps[0] + steps[1]])
    error, spread = np.array([0.1, -0.2, 0.3]), np.array([0.1, 0.2, 0.3])
    chain = between((0, 1, steps[0], GOOD), (1, 2, steps[1], GOOD))
    found = tied(known(true + error, spread), chain)
    mean = np.sum(error / spread**2) / np.sum(1 / spread**2)
    np.testing.assert_allclose(found.mean, true + mean)
    np.testing.assert_array_equal(found.wraps, true)
    assert len(set(found.group.tolist())) == 1


def test_the_sure_one_carries_the_unsure():
    """A vague surface is put right by a sharp one, and not the other way round."""
    found = tied(known([0.02, 3.4], [0.05, 3.0]), between((0, 1, 0, GOOD)))
    np.testing.assert_array_equal(found.wraps, [0, 0])


@pytest.mark.parametrize("spread", [0.3, 1.0])
def test_none_are_tied_that_disagree(spread):
    off = 20 * np.hypot(spread, spread)
    found = tied(known([0, off], [spread, spread]), between((0, 1, 0, GOOD)))
    np.testing.assert_allclose(found.mean, [0, off])
    np.testing.assert_allclose(found.spread, spread)
    assert found.group[0] != found.group[1]


@pytest.mark.parametrize("odds", [0.0, 1e-6])
def test_none_are_tied_against_the_odds(odds):
    found = tied(known([0.2, 0.6], [0.2, 0.2]), between((0, 1, 0, odds)))
    np.testing.assert_allclose(found.mean, [0.2, 0.6])
    assert found.group[0] != found.group[1]


def test_the_surest_pair_goes_first():
    """Between two neighbours that contradict each other the better border wins."""
    pairs = between((0, 1, 0, 0.5), (1, 2, 0, GOOD))
    found = tied(known([0, 1.0, 2.0], [0.1, 1.0, 0.1]), pairs)
    assert found.group[1] == found.group[2] != found.group[0]
    np.testing.assert_array_equal(found.wraps, [0, 2, 2])


def test_without_borders_each_is_rounded():
    found = tied(known([0.4, -1.7, 9.5001], [1, 1, 1]), between())
    np.testing.assert_array_equal(found.wraps, [0, -2, 10])
    np.testing.assert_array_equal(found.group, [0, 1, 2])


def test_no_surfaces_no_ties():
    found = tied(known([], []), between())
    assert found.wraps.size == found.group.size == 0


@st.composite
def graphs(draw):
    """Surfaces with true offsets, borders that tell them, and an order to take these in."""
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    count = draw(st.integers(2, 9))
    true, spread = rng.integers(-20, 20, count), rng.uniform(0.05, 2, count)
    entries = []
    for a in range(count):
        for b in range(a + 1, count):
            if rng.random() < 0.5:
                lie = rng.integers(-3, 4) if rng.random() < 0.2 else 0
                entries.append((a, b, true[b] - true[a] + lie, rng.uniform(0.01, 2)))
    return known(true + spread * rng.normal(size=count), spread), entries, rng


@given(graphs())
def test_the_order_of_borders_does_not_matter(graph):
    found, entries, rng = graph
    expected = tied(found, between(*entries))
    shuffled = [entries[i] for i in rng.permutation(len(entries))]
    got = tied(found, between(*shuffled))
    np.testing.assert_array_equal(got.wraps, expected.wraps)
    np.testing.assert_allclose(got.mean, expected.mean)


@given(graphs())
def test_which_side_is_first_does_not_matter(graph):
    found, entries, rng = graph
    expected = tied(found, between(*entries))
    turned = [(b, a, -s, o) if rng.random() < 0.5 else (a, b, s, o) for a, b, s, o in entries]
    got = tied(found, between(*turned))
    np.testing.assert_allclose(got.mean, expected.mean, atol=1e-9)
    np.testing.assert_allclose(got.spread, expected.spread)


@given(graphs(), st.integers(-50, 50))
def test_what_all_lack_alike_is_added_to_all(graph, common):
    found, entries, _ = graph
    expected = tied(found, between(*entries))
    got = tied(found._replace(mean=found.mean + common), between(*entries))
    np.testing.assert_allclose(got.mean, expected.mean + common, atol=1e-9)
    assert set(got.wraps - expected.wraps - common) <= {-1.0, 0.0, 1.0}  # halves are rounded


# --- borders -----------------------------------------------------------------------------------


def split(column=80):
    label = np.zeros(SHAPE, np.int32)
    label[:, column:] = 1
    return label


@pytest.mark.parametrize("wraps", [0, 1, 5, -12])
def test_one_plane_cut_in_two_differs_by_its_wraps(wraps):
    depth, q = plane_depth((0.2, 0.1, 1), 2.5)
    field = exact_field(depth)
    off = moved(field.arrays(), q, whole_boxes(SHAPE), BENT, wraps * WRAP)
    found = borders(field, split(), np.stack([q, off]))
    np.testing.assert_array_equal([found.first, found.second], [[0], [1]])
    np.testing.assert_array_equal(found.step, [-wraps])
    assert found.odds[0] > 1


@pytest.mark.parametrize("axis", [0, 1])
def test_a_hidden_surface_does_not_meet_the_one_before_it(axis):
    """Along the border their difference runs through many wraps."""
    normal = (0, 0.4, 1) if axis else (0.4, 0, 1)
    depth, behind = plane_depth(normal, 3.0)
    _, before = plane_depth((0, 0, 1), 2.0)
    label = split()
    if not axis:
        label = np.zeros(SHAPE, np.int32)
        label[64:] = 1
    found = borders(exact_field(depth), label, np.stack([before, behind]))
    assert (found.odds < 0.1).all()


def test_half_a_wrap_is_no_meeting():
    depth, q = plane_depth((0.2, 0.1, 1), 2.5)
    field = exact_field(depth)
    off = moved(field.arrays(), q, whole_boxes(SHAPE), BENT, 0.5 * WRAP)
    found = borders(field, split(), np.stack([q, off]))
    assert (found.odds < 0.1).all()


def test_short_borders_conclude_nothing():
    depth, q = plane_depth((0.2, 0.1, 1), 2.5)
    label = np.full(SHAPE, -1, np.int32)
    label[10:13, 10:20], label[10:13, 20:30] = 0, 1
    assert borders(exact_field(depth), label, np.stack([q, q])).first.size == 0


def test_without_surfaces_there_are_no_borders():
    depth, _ = plane_depth((0, 0, 1), 2.5)
    label = np.full(SHAPE, -1, np.int32)
    assert borders(exact_field(depth), label, np.zeros((0, 6))).first.size == 0


@pytest.fixture(scope="module")
def judged(corner, clean_corner):
    """Step and odds of the border of two parts of the corner, as the method sees them."""
    found = stages(clean_corner)
    names = [np.bincount(found.label[(corner.part == n) & (found.label >= 0)]).argmax()
             for n in range(6)]  # fmt: skip
    table = {}
    for a, b, step, odds in zip(*found.borders, strict=True):
        table[a, b], table[b, a] = (step, odds), (-step, odds)
    return lambda one, other: table.get((names[one], names[other]), (0.0, 0.0))


CREASES = [(0, 1), (0, 2), (1, 2), (3, 4), (4, 5), (3, 5)]
"""Wall and wall, both walls and the floor, and the box's own edges."""


@pytest.mark.parametrize("pair", CREASES[:4])
def test_creases_have_no_step(judged, pair):
    """Steeper ones than these may: beside the box's top a pixel more or less is a wrap."""
    assert judged(*pair)[0] == 0


@pytest.mark.parametrize("pair", CREASES[:3])
def test_creases_of_the_room_have_good_odds(judged, pair):
    assert judged(*pair)[1] > 0.5


@pytest.mark.parametrize("room", [0, 1, 2])
def test_edges_that_hide_have_poor_odds(judged, room):
    """The box's top hangs before the walls and the floor."""
    worst = min(judged(*pair)[1] for pair in CREASES[:3])
    assert judged(4, room)[1] < worst / 3
