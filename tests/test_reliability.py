import numpy as np
import pytest

from cmtof.reliability import honest_errors, reliability, risk_coverage


def test_honest_odds_have_no_calibration_error(rng):
    said = rng.uniform(size=200_000)
    found = reliability(said, rng.uniform(size=said.size) < said)
    # |share - p| of a bin of 10 000 has a mean of sqrt(2/pi) sqrt(p (1-p) / 10 000) < 0.004
    assert found.calibration_error < 0.006
    assert found.answers.sum() == said.size
    np.testing.assert_allclose(found.confidence, np.arange(20) / 20 + 0.025, atol=2e-3)


def test_who_is_always_sure_errs_by_the_share_of_wrong_ones():
    right = np.arange(10) < 3
    found = reliability(np.ones(10), right)
    assert found.calibration_error == pytest.approx(0.7)
    assert found.answers[-1] == 10 and np.isnan(found.right[0])


def test_nothing_answered_has_no_error():
    assert np.isnan(reliability([], []).calibration_error)


@pytest.mark.parametrize("said", [[0.5, np.nan], [0.5, 1.2], [-0.1, 0.5], [0.5]])
def test_what_is_no_probability_is_refused(said):
    with pytest.raises(ValueError, match=r"Expected a probability in \[0, 1\] for each of 2"):
        reliability(said, [True, False])


def test_risk_grows_to_the_share_of_wrong_ones(rng):
    said = rng.uniform(size=50_000)
    right = rng.uniform(size=said.size) < said
    found = risk_coverage(said, right)
    assert found.coverage[-1] == 1 and found.risk[-1] == pytest.approx(1 - right.mean())
    # of the surest share c the mean confidence is 1 - c / 2
    np.testing.assert_allclose(found.risk, found.coverage / 2, atol=0.03)


def test_confidence_that_knows_nothing_has_the_same_risk_everywhere(rng):
    right = rng.uniform(size=100_000) < 0.4
    found = risk_coverage(np.full(right.size, 0.5), right, points=10)
    np.testing.assert_allclose(found.risk, 0.6, atol=0.02)


def test_honest_errors_of_one_fate_follow_the_closed_form(rng):
    """All answers together at odds p: the error is p or 1 - p, on average 2 p (1 - p)."""
    found = honest_errors(np.full(500, 0.3), np.zeros(500, int), draws=4000, rng=rng)
    assert set(np.round(found, 9)) == {0.3, 0.7}
    # 4 sigma of a mean of two values 0.4 apart
    assert found.mean() == pytest.approx(2 * 0.3 * 0.7, abs=4 * 0.4 * np.sqrt(0.21 / 4000))


def test_honest_errors_of_many_fates_are_those_of_a_binomial(rng):
    found = honest_errors(np.full(900, 0.5), np.arange(900), draws=2000, rng=rng)
    expected = np.sqrt(2 / np.pi) * 0.5 / np.sqrt(900)
    assert found.mean() == pytest.approx(expected, rel=0.1)


def test_honest_errors_agree_with_drawing_every_answer(rng):
    said = rng.uniform(size=3000)
    fate = rng.integers(0, 40, 3000)
    drawn = [reliability(said, said > rng.random(40)[fate]).calibration_error for _ in range(400)]
    found = honest_errors(said, fate, draws=400, rng=rng)
    assert found.mean() == pytest.approx(np.mean(drawn), rel=0.08)


def test_a_fate_is_wanted_for_each_answer(rng):
    with pytest.raises(ValueError, match="Expected a fate for each of 2 answers, got 3"):
        honest_errors([0.5, 0.5], [0, 1, 2], rng=rng)
