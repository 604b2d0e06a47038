"""Answers that cost nothing score what arithmetic says."""

import numpy as np
import pytest

import cmtof
from cmtof import metrics
from cmtof.baselines import trivial, within_range
from cmtof.constants import FREQUENCIES
from cmtof.correlation import depth_from_wraps, phase_from_depth, wrap_length
from cmtof.measurement import Measurement
from cmtof.scenes import load_frame
from cmtof.scenes.frame import Frame
from cmtof.simulation import simulate

WRAP = float(wrap_length(FREQUENCIES[0]))


def released(wraps):
    """A measurement of depths in the middle of wraps 36 to 56, without noise."""
    depth = (np.atleast_2d(wraps) + 0.5) * WRAP
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    return Measurement.from_phase(
        phase, FREQUENCIES, depth=depth, range_min=36 * WRAP, range_max=57 * WRAP
    )


def rates(measurement, method, **options):
    result = cmtof.unwrap(measurement, method=method, **options)
    return metrics.score(metrics.scored_pixels(result, measurement))


def test_middle_of_21_wraps_is_right_once_each_way():
    """Each wrap as often as the others: 1, 3 and 5 of 21 lie within 0, 1 and 2 of the middle."""
    found = rates(released(np.arange(36, 57)), "middle")
    assert found["delta_lt_1"] == pytest.approx(1 / 21)
    assert found["delta_lt_2"] == pytest.approx(3 / 21)
    assert found["delta_lt_3"] == pytest.approx(5 / 21)


def test_guesses_are_right_once_in_21_whatever_the_scene():
    m = released(np.full((300, 300), 40))
    found = rates(m, "uniform")
    assert found["delta_lt_1"] == pytest.approx(1 / 21, abs=0.003)
    assert found["delta_lt_2"] == pytest.approx(3 / 21, abs=0.005)


def test_guesses_repeat_with_their_seed_and_differ_between_frames():
    m = released(np.full((5, 5), 40))
    first = trivial.uniform(m, seed=1).depth
    np.testing.assert_array_equal(first, trivial.uniform(m, seed=1).depth)
    other = Measurement(m.dataset.assign_attrs(frame_number=3))
    assert (first != trivial.uniform(other, seed=1).depth).all()
    assert (first != trivial.uniform(m, seed=2).depth).all()


def test_mode_is_right_as_often_as_its_wrap_occurs(rng):
    m = released(rng.choice([37, 40, 41, 50], (40, 40), p=[0.2, 0.5, 0.2, 0.1]))
    estimate = trivial.mode(m)
    share = np.mean(np.floor(m.depth / WRAP) == 40)
    assert rates(m, "mode")["delta_lt_1"] == pytest.approx(share)
    np.testing.assert_allclose(estimate.confidence, share)
    assert rates(m, "mode")["delta_lt_1"] >= rates(m, "middle")["delta_lt_1"]


def test_mode_counts_valid_pixels_alone_and_without_any_is_the_middle():
    m = released([[40, 40, 50]])
    masked = Measurement(m.dataset.assign(mask=(("y", "x"), np.array([[0, 0, 1]], np.int8))))
    assert trivial.mode(masked).depth[0, 0] == pytest.approx(50.5 * WRAP)
    empty = Measurement(m.dataset.assign(mask=(("y", "x"), np.zeros((1, 3), np.int8))))
    np.testing.assert_array_equal(trivial.mode(empty).depth, trivial.middle(empty).depth)


def test_true_depth_is_always_consistent_and_loses_wraps_at_their_ends():
    m = simulate(load_frame("still_life"), protocol="full", seed=0)
    found = rates(m, "oracle-depth")
    assert found["consistent_lt_1"] == 1.0
    assert 0.85 < found["delta_lt_1"] < 0.999
    assert found["delta_lt_2"] == 1.0


def test_true_depth_brings_the_phase_within_half_a_wrap(rng):
    depth = rng.uniform(1, 5, (30, 30))
    m = simulate(Frame(depth, np.ones_like(depth)), protocol="full", seed=4)
    found = trivial.true_depth(m).depth
    assert np.abs(found - m.depth).max() <= WRAP / 2 + 1e-6
    fraction = found / WRAP - m.phase[0] / (2 * np.pi)
    np.testing.assert_allclose(fraction, np.rint(fraction), atol=1e-6)


def test_unknown_depth_is_answered_by_the_middle():
    m = released([[40, 41]])
    depth = m.depth.copy()
    depth[0, 0] = np.nan
    blind = Measurement(m.dataset.assign(depth=(("y", "x"), depth)))
    estimate = trivial.true_depth(blind)
    assert estimate.depth[0, 0] == pytest.approx(46.5 * WRAP)
    assert estimate.confidence.tolist() == [[0, 1]]
    assert trivial.mode(blind).depth[0, 0] == pytest.approx(41.5 * WRAP)


@pytest.mark.parametrize("name", ["middle", "uniform", "mode", "true_depth"])
@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (5, 1)])
def test_answers_lie_in_range_with_odds_between_0_and_1(name, shape):
    m = released(np.full(shape, 38))
    estimate = getattr(trivial, name)(m)
    assert estimate.depth.shape == estimate.confidence.shape == shape
    np.testing.assert_array_equal(estimate.depth, within_range(estimate.depth, m))
    assert ((estimate.confidence >= 0) & (estimate.confidence <= 1)).all()


def test_one_wrap_in_range_is_certain():
    m = released([[40]]).between(40 * WRAP, 41 * WRAP)
    for guess in (trivial.middle, trivial.uniform):
        assert guess(m).confidence.tolist() == [[1.0]]
    assert rates(m, "uniform")["delta_lt_1"] == 1.0


@pytest.mark.parametrize("method", ["mode", "oracle-depth"])
def test_marks_that_know_the_truth_ask_for_it(method):
    m = released([[40]])
    blind = Measurement(m.dataset.drop_vars("depth"))
    with pytest.raises(ValueError, match=f"true depth for method {method}"):
        cmtof.unwrap(blind, method=method)


def test_one_frequency_suffices():
    depth = depth_from_wraps(np.full((2, 2), 1.0), 40, FREQUENCIES[0])
    m = Measurement.from_phase(
        np.full((1, 2, 2), 1.0), FREQUENCIES[:1], depth=depth, range_max=57 * WRAP
    )
    assert rates(m, "oracle-depth")["delta_lt_1"] == 1.0
    assert cmtof.unwrap(m, method="middle").depth.shape == (2, 2)
