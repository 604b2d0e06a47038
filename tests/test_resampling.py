import numpy as np
import pytest
from scipy.stats import binom

from cmtof.resampling import difference_interval, draws_of, ratio_interval


def test_of_trials_that_count_the_same_it_is_the_binomial_law(rng):
    # redrawing F trials of which a share p succeeded gives Binomial(F, p) successes
    trials = (np.arange(200) < 60).astype(float)
    found = ratio_interval(trials, 1.0, draws_of(200, draws=20000, rng=rng))
    assert found.value == 0.3
    law = binom.ppf([0.025, 0.975], 200, 0.3) / 200
    assert [found.low, found.high] == pytest.approx(law, abs=1.01 / 200)


def test_it_covers_the_true_rate_as_often_as_it_says(rng):
    sets = (rng.random((1000, 150)) < 0.4).astype(float)
    found = ratio_interval(sets, 1.0, draws_of(150, draws=1000, rng=rng))
    covered = np.mean((found.low <= 0.4) & (found.high >= 0.4))
    # 1000 sets tell the share to 0.7 %; percentiles of 150 trials are narrow by about 1 %
    assert covered == pytest.approx(0.95, abs=0.025)


def test_pixels_of_one_frame_are_no_trials_of_their_own(rng):
    drawn = draws_of(40, rng=rng)
    right = 1000 * (np.arange(40) % 2)
    one = ratio_interval(right / 1000, 1, drawn)
    many = ratio_interval(right, 1000, drawn)
    assert (many.low, many.high) == (one.low, one.high)


def test_frames_weigh_by_their_pixels(rng):
    found = ratio_interval([10, 0], [10, 990], draws_of(2, rng=rng))
    assert found.value == pytest.approx(0.01)
    assert (found.low, found.high) == (0.0, 1.0)


def test_differences_are_drawn_together(rng):
    level = rng.uniform(0.1, 0.9, 60)  # frames differ a lot, the two methods by little
    drawn = draws_of(60, rng=rng)
    difference = difference_interval(level + 0.01, level, np.ones(60), drawn)
    assert difference.value == pytest.approx(0.01)
    assert [difference.low, difference.high] == pytest.approx([0.01, 0.01])
    assert difference.excludes_zero
    assert not difference_interval(level, level, np.ones(60), drawn).excludes_zero


def test_many_ratios_at_once_are_those_of_each_alone(rng):
    part, whole = rng.integers(0, 50, (3, 4, 20)), rng.integers(50, 99, (3, 4, 20))
    drawn = draws_of(20, rng=rng)
    together = ratio_interval(part, whole, drawn)
    alone = ratio_interval(part[1, 2], whole[1, 2], drawn)
    assert [x[1, 2] for x in together] == pytest.approx(list(alone))


def test_what_no_frame_has_has_no_rate(rng):
    drawn = draws_of(3, rng=rng)
    found = ratio_interval([[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [1, 0, 0]], drawn)
    assert np.isnan([x[0] for x in found]).all()
    # draws without the one frame that has it say nothing about it
    assert [x[1] for x in found] == [1.0, 1.0, 1.0]


def test_equal_generators_give_equal_intervals():
    one, two = (draws_of(9, rng=np.random.default_rng(5)) for _ in range(2))
    assert (one == two).all()


@pytest.mark.parametrize("bad", [(0, 10), (10, 0)])
def test_nothing_cannot_be_drawn(bad, rng):
    with pytest.raises(ValueError, match="at least one frame"):
        draws_of(bad[0], draws=bad[1], rng=rng)


def test_draws_of_other_frames_are_refused(rng):
    with pytest.raises(ValueError, match="draws of 4 frames"):
        ratio_interval(np.ones(4), np.ones(4), draws_of(5, rng=rng))
    with pytest.raises(ValueError, match="level"):
        ratio_interval(np.ones(5), np.ones(5), draws_of(5, rng=rng), level=95)
