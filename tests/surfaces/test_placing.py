"""Whole wraps of a surface by its beat and by its shape, and ties between surfaces that meet."""

import numpy as np
import pytest
from exact_scenes import SHAPE, WRAP, exact_field, plane_depth, whole_boxes
from hypothesis import given
from hypothesis import strategies as st

from cmtof.surfaces.fitting import BENT, PLANE, moved
from cmtof.surfaces.placing import (
    Borders,
    Offsets,
    borders,
    fitted,
    interiors,
    offsets,
    pixel_labels,
    pooled_beats,
    tied,
)

INNER = np.zeros(SHAPE, np.int32)
BOXES = whole_boxes(SHAPE)
GOOD = 2.0


def a_fit(offset, known, missed=0.0):
    return np.array([[offset, known, PLANE, missed, 1e-3]])


def known(mean, spread):
    return Offsets(np.array(mean, float), np.array(spread, float))


def between(*entries):
    columns = list(zip(*entries, strict=True)) or [(), (), (), ()]
    kinds = (np.int64, np.int64, float, float)
    return Borders(*(np.array(c, kind) for c, kind in zip(columns, kinds, strict=True)))


def test_pooled_beats_scatter_as_the_sum_of_their_phasors():
    """Sixty draws: unbiased, a deviation to 9 %, and sqrt(1 + 4) over root of the information."""
    rng, found = np.random.default_rng(9), []
    depth, q = plane_depth((0.3, -0.2, 1), 2.5)
    for _ in range(60):
        field = exact_field(depth, information=10.0, noise_of=rng)
        found.append([part[0] for part in pooled_beats(field, INNER, q[None])])
    beat, noise, coherence = np.array(found).T
    assert abs(beat.mean()) < 3 * noise.mean() / np.sqrt(60)
    assert noise.mean() == pytest.approx(np.std(beat), rel=0.28)
    expected = np.sqrt(5 / (10.0 * SHAPE[0] * SHAPE[1])) / (2 * np.pi * 20 / 7150)
    # turning cells back by their own phasors takes some of the noise along
    assert noise.mean() == pytest.approx(expected, rel=0.05)
    assert (coherence > 0.95).all()


def test_shape_and_beat_are_weighed_by_what_is_known_of_them():
    depth, q = plane_depth((0.2, 0.1, 1), 2.5)
    field = exact_field(depth)
    beat, _, _ = pooled_beats(field, INNER, q[None])
    for said in (-5.0, 12.0):
        alone = offsets(field, INNER, q[None], a_fit(said, 1e6), shape=False)
        assert alone.mean[0] == pytest.approx(beat[0], abs=1e-9)
        both = offsets(field, INNER, q[None], a_fit(said, 1e6))
        assert abs(both.mean[0] - said) < abs(beat[0] - said)
        assert both.spread[0] < alone.spread[0]
    spreads = [
        offsets(field, INNER, q[None], a_fit(0.0, 1e4, missed)).spread[0] for missed in (0, 1e-4, 1)
    ]
    assert spreads[0] < spreads[1] < spreads[2]
    dark = offsets(exact_field(depth, information=0.0), INNER, q[None], np.zeros((1, 5)))
    assert dark.spread[0] > 100


@pytest.mark.parametrize("wraps", [0, 5])
def test_the_last_fit_finds_the_plane_again(wraps):
    """A wide plane that is off by so few wraps is bent by less than half of one: fits hop back."""
    depth, q = plane_depth((0.2, 0.1, 1), 2.5)
    field = exact_field(depth)
    off = moved(field.arrays(), q, BOXES, PLANE, wraps * WRAP)
    found, fit = fitted(field, INNER, off[None])
    np.testing.assert_allclose(found[0], q, atol=1e-6)
    assert abs(offsets(field, INNER, found, fit).mean[0]) < 0.1


def test_pixels_take_the_likeliest_surface_and_borders_find_whole_wraps():
    """Left one plane, right another that meets it, moved by three wraps."""
    one, q = plane_depth((0.3, 0, 1), 2.5)
    other, p = plane_depth((-0.3, 0, 1), 2.5)
    depth = np.maximum(one, other)  # they meet at the optical axis
    field = exact_field(depth)
    off = moved(field.arrays(), p, BOXES, BENT, 3 * WRAP)
    owner = np.zeros((SHAPE[0] // 8, SHAPE[1] // 8), np.int64)
    owner[:, 10:] = 1
    first, second = (q, off) if one[0, 0] > other[0, 0] else (off, q)
    surfaces = np.stack([first, second])
    label, share = pixel_labels(field, owner, surfaces)
    truth = np.where(np.arange(SHAPE[1]) < 81, 0, 1)
    assert np.mean(label == truth) > 0.97
    assert share.max() == pytest.approx(1, abs=0.05)
    assert (interiors(label, share)[:, 78:84] == -1).all()
    found = borders(field, label, surfaces)
    assert (found.first.tolist(), found.second.tolist()) == ([0], [1])
    assert abs(found.step[0]) == 3
    assert found.odds[0] > 0.5


def test_two_that_meet_share_their_precision():
    """The mean of two Gaussians, one of them shifted by the step of the border."""
    found = tied(known([0.3, 2.5], [0.2, 0.4]), between((0, 1, 2, GOOD)))
    mean = (0.3 / 0.2**2 + 0.5 / 0.4**2) / (1 / 0.2**2 + 1 / 0.4**2)
    np.testing.assert_allclose(found.mean, [mean, mean + 2])
    np.testing.assert_allclose(found.spread, (1 / 0.2**2 + 1 / 0.4**2) ** -0.5)
    np.testing.assert_array_equal(found.wraps, [0, 2])


def test_none_are_tied_that_disagree_or_against_the_odds():
    for spread in (0.3, 1.0):
        off = 20 * np.hypot(spread, spread)
        found = tied(known([0, off], [spread, spread]), between((0, 1, 0, GOOD)))
        np.testing.assert_allclose(found.mean, [0, off])
    found = tied(known([0.2, 0.6], [0.2, 0.2]), between((0, 1, 0, 1e-6)))
    assert found.group[0] != found.group[1]
    assert tied(known([], []), between()).wraps.size == 0


@given(st.integers(0, 2**31))
def test_neither_the_order_of_borders_nor_their_sides_matter(seed):
    rng = np.random.default_rng(seed)
    count = rng.integers(2, 10)
    true, spread = rng.integers(-20, 20, count), rng.uniform(0.05, 2, count)
    entries = [
        (a, b, true[b] - true[a] + rng.integers(-3, 4) * (rng.random() < 0.2), rng.uniform(0.01, 2))
        for a in range(count) for b in range(a + 1, count) if rng.random() < 0.5
    ]  # fmt: skip
    found = known(true + spread * rng.normal(size=count), spread)
    expected = tied(found, between(*entries))
    shuffled = [entries[i] for i in rng.permutation(len(entries))]
    turned = [(b, a, -s, o) if rng.random() < 0.5 else (a, b, s, o) for a, b, s, o in shuffled]
    for other in (shuffled, turned):
        got = tied(found, between(*other))
        np.testing.assert_array_equal(got.wraps, expected.wraps)
        np.testing.assert_allclose(got.mean, expected.mean)
