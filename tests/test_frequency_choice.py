"""Distances against brute force, bounds against counting, the search against trying every set."""

from itertools import combinations, product

import numpy as np
import pytest

from cmtof import bounds
from cmtof import frequency_choice as choice
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, phase_from_depth, wrap_length, wrapped

NOISE = 0.1336
TRIPLE = (7.14e9, 14.28e9, 14.32e9)
SETS = [FREQUENCIES, (7.14e9, 7.16e9), TRIPLE, (7.14e9, 7.15e9, 7.16e9, 14.32e9)]


@pytest.mark.parametrize("noise", [(0.134, 0.134), (0.1, 0.5), (0.4, 0.02)])
@pytest.mark.parametrize(
    "pair", [FREQUENCIES, (7.15e9, 7.16e9), (7.16e9, 14.28e9), (14.28e9, 14.32e9)]
)
def test_first_distance_of_a_pair_is_one_over_its_wrap_noise(pair, noise):
    distance, _ = choice.wrap_distances(pair, noise, depth_range=0.3)
    assert 1 / distance[0] == pytest.approx(float(bounds.wrap_noise(*noise, frequencies=pair)))
    # the beat grows evenly with the wraps
    np.testing.assert_allclose(distance, distance[0] * np.arange(1, distance.size + 1))


@pytest.mark.parametrize("pair", [FREQUENCIES, (7.14e9, 7.16e9), (7.15e9, 7.16e9)])
def test_pixels_of_a_pair_are_those_of_the_closed_form(pair):
    least, enough = choice.pixels_needed(pair, NOISE, depth_range=7.0)
    theory = bounds.pixels_needed(NOISE, NOISE, frequencies=pair)
    # the ends of the range have one neighbour only, so a little less is needed
    assert least <= enough
    assert least == pytest.approx(theory, rel=0.01)
    assert enough == pytest.approx(theory, rel=0.01)


@pytest.mark.parametrize("pixels", [300, 3000])
def test_odds_of_a_pair_are_those_of_the_closed_form(rng, pixels):
    spread = NOISE / np.sqrt(pixels)
    theory = float(bounds.wrap_probability(spread, spread, frequencies=FREQUENCIES))
    share, low, high = choice.counted_odds(
        FREQUENCIES, [NOISE, NOISE], depth_range=7.0, rng=rng, pixels=pixels, draws=3000
    )
    assert low <= share <= high
    assert abs(share - theory) < 4 * np.sqrt(theory * (1 - theory) / 3000)
    lower, upper = choice.odds_bounds(FREQUENCIES, NOISE, depth_range=7.0, pixels=pixels)
    assert lower <= theory <= upper


@pytest.mark.parametrize("frequencies", SETS)
@pytest.mark.parametrize("pixels", [150, 600, 2000])
def test_counts_lie_between_the_bounds(rng, frequencies, pixels):
    noise = np.linspace(1, 1.5, len(frequencies)) * NOISE
    draws = 2000
    share, *_ = choice.counted_odds(
        frequencies, noise, depth_range=3.0, rng=rng, pixels=pixels, draws=draws
    )
    lower, upper = choice.odds_bounds(frequencies, noise, depth_range=3.0, pixels=pixels)
    room = 4 * np.sqrt(0.25 / draws)
    assert lower - room <= share <= upper + room


def test_pooling_enough_pixels_gives_the_odds(rng):
    _, enough = choice.pixels_needed(TRIPLE, NOISE, depth_range=3.0, odds=0.8)
    share, *_ = choice.counted_odds(
        TRIPLE, [NOISE] * 3, depth_range=3.0, rng=rng, pixels=float(enough), draws=4000
    )
    # the sum over rivals counts some errors twice, so the odds may only be better
    assert 0.8 - 4 * np.sqrt(0.16 / 4000) < share < 0.84
    lower, _ = choice.odds_bounds(TRIPLE, NOISE, depth_range=3.0, pixels=enough)
    assert lower == pytest.approx(0.8, abs=2e-3)


@pytest.mark.parametrize("frequencies", SETS)
def test_phases_without_noise_give_the_wrap(rng, frequencies):
    reach = 3.0
    depth = rng.uniform(0, reach, (5, 7))
    f = np.array(frequencies)
    phase = wrapped(phase_from_depth(depth, f[:, None, None]))
    found = choice.likeliest_wrap(phase, frequencies=f, noise=NOISE, depth_range=reach)
    assert np.array_equal(found, np.floor(depth / wrap_length(f[0])))


def test_likeliest_wrap_is_the_least_squares_over_all_wraps_of_all_frequencies(rng):
    """Every choice of whole turns at every frequency, the depth fitted to each."""
    f, s, reach = np.array([0.9e9, 1.0e9, 1.9e9]), np.array([0.3, 0.2, 0.4]), 0.6
    turns = [range(-1, int(np.ceil(reach / wrap_length(x))) + 1) for x in f]
    agree, draws = 0, 60
    for depth in rng.uniform(0.05, reach - 0.05, draws):
        phase = wrapped(phase_from_depth(depth, f) + s * rng.normal(size=3))
        costs = {}
        for whole in product(*turns):
            path = (phase + TAU * np.array(whole)) / s
            slope = phase_from_depth(1.0, f) / s
            fit = (slope @ path) / (slope @ slope)
            own = (phase[0] / TAU + whole[0]) * wrap_length(f[0])
            if 0 <= own < reach:
                cost = np.sum((path - slope * fit) ** 2)
                costs[whole[0]] = min(cost, costs.get(whole[0], np.inf))
        found = choice.likeliest_wrap(phase, frequencies=f, noise=s, depth_range=reach)
        agree += int(found == min(costs, key=lambda n: costs[n]))
    # residuals are wrapped at the depth of the lowest phase, before the fit: seldom another turn
    assert agree >= 0.9 * draws


def test_order_of_the_frequencies_does_not_matter(rng):
    f, s = np.array(SETS[3]), NOISE * np.array([1.0, 2.0, 0.5, 3.0])
    phase = rng.uniform(0, TAU, (4, 50))
    order = [2, 0, 3, 1]
    first = choice.likeliest_wrap(phase, frequencies=f, noise=s, depth_range=2.0)
    again = choice.likeliest_wrap(
        phase[order], frequencies=f[order], noise=s[order], depth_range=2.0
    )
    assert np.array_equal(first, again)
    distance, _ = choice.wrap_distances(f, s, depth_range=2.0)
    np.testing.assert_allclose(
        choice.wrap_distances(f[order], s[order], depth_range=2.0)[0], distance
    )


@pytest.mark.parametrize("added", [7.15e9, 7.153e9, 14.28e9, 14.3e9])
@pytest.mark.parametrize("strength", [1.0, 0.1])
def test_a_further_frequency_never_hurts(added, strength):
    """At the same noise of the others, as long as the wraps counted stay the same."""
    few, _ = choice.wrap_distances(FREQUENCIES, NOISE, depth_range=7.4)
    more, _ = choice.wrap_distances(
        (*FREQUENCIES, added), (NOISE, NOISE, NOISE / strength), depth_range=7.4
    )
    assert (more >= few * (1 - 1e-9)).all()


def test_noise_and_scale_act_as_they_must():
    first = choice.wrap_distances(TRIPLE, NOISE, depth_range=2.0)[0]
    # twice the noise, half the distance; all frequencies thrice as high in a third of the range
    np.testing.assert_allclose(
        choice.wrap_distances(TRIPLE, 2 * NOISE, depth_range=2.0)[0], first / 2
    )
    scaled = choice.wrap_distances(3 * np.array(TRIPLE), NOISE, depth_range=2.0 / 3)[0]
    np.testing.assert_allclose(scaled, first, rtol=1e-6)
    quiet, noisy = (choice.pixels_needed(TRIPLE, k * NOISE, depth_range=2.0)[1] for k in (1, 2))
    assert noisy == pytest.approx(4 * quiet, abs=4)


def test_half_whole_ratios_keep_the_second_turn_and_whole_ones_lose_it():
    """f_1 over the beat is 178.5 for 7.14/14.32 and 179 for 7.16/14.28 GHz."""
    turn, far = float(wrap_length(40e6)), float(wrap_length(20e6))
    within, beyond = (
        choice.pixels_needed((7.14e9, 14.32e9), NOISE, depth_range=z)[1] for z in (0.9 * turn, far)
    )
    assert beyond == pytest.approx(4 * within, rel=0.02)
    assert np.isinf(choice.pixels_needed((7.16e9, 14.28e9), NOISE, depth_range=far)).all()


def test_multiples_tell_nothing():
    least, enough = choice.pixels_needed([7e9, 14e9], NOISE, depth_range=1.0)
    assert np.isinf(least)
    assert np.isinf(enough)
    lower, upper = choice.odds_bounds([7e9, 14e9], NOISE, depth_range=1.0, pixels=1e9)
    assert lower == 0
    assert upper < 0.1


def test_a_range_of_one_wrap_needs_one_pixel():
    assert choice.pixels_needed(FREQUENCIES, NOISE, depth_range=0.02) == (1, 1)
    assert choice.odds_bounds(FREQUENCIES, NOISE, depth_range=0.02) == (1, 1)


def test_many_sets_at_once_are_each_by_itself():
    sets = np.array(list(combinations([7.14e9, 7.15e9, 7.16e9, 14.3e9], 2))).T
    least, enough = choice.pixels_needed(sets, NOISE, depth_range=3.0)
    for i, pair in enumerate(sets.T):
        alone = choice.pixels_needed(pair, NOISE, depth_range=3.0)
        assert (least[i], enough[i]) == alone


@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("eta", [None, np.pi / 4])
def test_search_finds_what_trying_every_set_finds(size, eta):
    grid = choice.feasible_frequencies(5e6)
    noise = NOISE / (1 if eta is None else choice.relative_signal(grid, eta=eta))
    noise = np.broadcast_to(noise, grid.shape)
    every = np.array([s for s in combinations(range(grid.size), size) if grid[s[0]] < 1e10]).T
    _, enough = choice.pixels_needed(grid[every], noise[every], depth_range=3.0)
    found = choice.best_choices(grid, noise, size=size, depth_range=3.0, keep=3)
    np.testing.assert_array_equal([c.enough for c in found], np.sort(enough)[:3])
    for one in found:
        near = np.array([np.argmin(abs(grid - f)) for f in one.frequencies])
        again = choice.pixels_needed(grid[near], noise[near], depth_range=3.0)
        assert (one.least, one.enough) == again


def test_signal_of_the_doubled_mode_follows_the_drive():
    assert choice.relative_signal(14.3e9, eta=0.26) == pytest.approx(0.017, abs=5e-4)
    # small drives: (eta / 2)^2
    assert choice.relative_signal(14.3e9, eta=1e-3) == pytest.approx(2.5e-7, rel=1e-4)
    edge, middle = choice.relative_signal([7.16e9, 7.15e9], eta=1e-3, half_power=10e6)
    # half the power of the drive in both modulators: half the signal
    assert edge == pytest.approx(0.5, rel=1e-5)
    assert middle == pytest.approx(1.0)


def test_a_pair_pays_nothing_for_sharing_and_more_images_do():
    assert choice.budget_factor(2, gaussian=True) == choice.budget_factor(2, gaussian=False) == 1
    # Gaussian noise alone: a third less light in each image, noise of a phase 3/2, pixels 9/4
    assert choice.budget_factor(3, gaussian=True) == pytest.approx(1.5**2)
    noise = [float(bounds.linear_phase_noise(a, 1.0, 4)) for a in (1.0, 2 / 3)]
    assert (noise[1] / noise[0]) ** 2 == pytest.approx(choice.budget_factor(3, gaussian=True))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: choice.wrap_distances([0.0, 1e9], 0.1, depth_range=1), "frequencies above 0 Hz"),
        (lambda: choice.wrap_distances(1e9, 0.1, depth_range=1), "one axis"),
        (lambda: choice.wrap_distances([1e9, 2e9], [0.1, 0], depth_range=1), "noise above 0 rad"),
        (lambda: choice.wrap_distances([1e9, 2e9], [0.1] * 3, depth_range=1), "for each"),
        (lambda: choice.wrap_distances([1e9, 2e9], 0.1, depth_range=0), "range above 0 m"),
        (lambda: choice.pixels_needed([1e9, 2e9], 0.1, depth_range=1, odds=1), "odds"),
        (lambda: choice.relative_signal([1e9], eta=0.3), "or twice that"),
        (lambda: choice.feasible_frequencies(0.0), "step"),
        (
            lambda: choice.likeliest_wrap(
                np.zeros((3, 4)), frequencies=[1e9, 2e9], noise=0.1, depth_range=1
            ),
            "Put the frequencies first",
        ),
        (
            lambda: choice.best_choices([1e9, 2e9], 0.1, size=3, depth_range=1),
            "Refine the grid",
        ),
    ],
)
def test_bad_input_is_told(call, message):
    with pytest.raises(ValueError, match=message):
        call()
