"""Intervals over scenes and the truth of confidences."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from cmtof.statistics import conformal_quantile, ratio_interval, reliability


def test_intervals_hold_the_truth_as_often_as_they_say(rng):
    """Rates of 40 scenes that differ, against that of all; 200 sets of 95 % intervals."""
    held = 0
    for _ in range(200):
        whole = rng.integers(100, 1900, 40)
        part = whole * np.clip(rng.normal(0.5, 0.2, 40), 0, 1)
        found = ratio_interval(part, whole, draws=400, seed=int(rng.integers(1 << 30)))
        held += found.low <= 0.5 <= found.high
    assert 0.88 <= held / 200 <= 0.99


def test_arrays_of_rates_share_their_scenes(rng):
    part = rng.random((3, 20))
    both = ratio_interval(part, np.ones(20), seed=5)
    alone = [ratio_interval(one, np.ones(20), seed=5) for one in part]
    assert_allclose(both.low, [one.low for one in alone])
    assert_allclose(both.high, [one.high for one in alone])


def test_a_rate_of_nothing_is_nan_and_of_one_scene_has_no_interval():
    empty = ratio_interval(np.zeros((2, 9)), np.stack([np.zeros(9), np.ones(9)]))
    assert_array_equal(empty.value, [np.nan, 0])
    assert_array_equal(empty.low, [np.nan, 0])
    assert np.isnan(empty.high[0])
    single = ratio_interval([3.0], [4.0])
    assert single.value == 0.75
    assert np.isnan(single.low)


def test_conformal_quantiles_cover_the_scores_of_new_groups(rng):
    """300 times 19 groups whose scores differ by a factor, and a new one: 90 % or a bit more."""
    covered = []
    for _ in range(300):
        groups = rng.lognormal(size=(20, 1)) * rng.exponential(size=(20, 50))
        most = conformal_quantile(groups[1:], 0.9)
        covered.append((groups[0] <= most).mean())
    error = np.std(covered) / np.sqrt(300)
    assert 0.9 - 3 * error < np.mean(covered) < 0.9 + 2 / 20 + 3 * error
    assert conformal_quantile(groups[1:], 0.96) == np.inf  # more than 19 of 20


def test_true_confidences_have_no_calibration_error(rng):
    confidence = rng.random(200_000)
    right = rng.random(confidence.size) < confidence
    found = reliability(confidence, right)
    assert found.calibration_error < 0.01
    assert found.answers.sum() == confidence.size
    assert reliability(confidence**2, right).calibration_error > 0.1


def test_reliability_of_nothing_is_nan():
    assert np.isnan(reliability([], []).calibration_error)
