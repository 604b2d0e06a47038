"""Windows, densities and regions: exact on walls, their sums those of plain loops."""

import numpy as np
from numpy.testing import assert_allclose
from pytest import approx, mark
from scipy.stats import norm
from scores import scores
from walls import WRAP, flat_wall

import cmtof
from cmtof import bounds
from cmtof.classical import region
from cmtof.classical.kde import _largest_density, hypotheses
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, phase_from_depth
from cmtof.frame import Frame
from cmtof.simulation import simulate


@mark.parametrize(
    "method",
    [
        "crt",
        "crt-ml",
        "crt-closed-form",
        "beat",
        "kde",
        "kde-tuned",
        "region",
        "mrf",
        "mrf-graphcut",
    ],
)
def test_walls_of_one_depth_are_exact(exact, method):
    m = exact(np.full((20, 20), 3.21))
    assert_allclose(cmtof.unwrap(m, method=method).depth, 3.21, atol=1e-6)


def test_averages_divide_the_noise_by_the_side_of_the_window():
    m = simulate(flat_wall(120, 1.0, 0.8), seed=2)
    rates = [
        scores(m, method="beat", window=side)["delta_lt_1"] for side in (1, 11, 41)
    ]
    assert rates == sorted(rates)
    noise = bounds.simulated_phase_noise(0.8) / 41
    odds = bounds.wrap_probability(noise, noise, frequencies=FREQUENCIES)
    assert rates[2] == approx(odds, abs=0.1)


def test_the_beat_is_as_sure_in_a_corner_as_it_is_right():
    """There the window is reflected, so that a quarter of it is counted four times."""
    draws = [simulate(flat_wall(42, 1.0), seed=seed) for seed in range(200)]
    found = [cmtof.unwrap(m, method="beat").isel(x=0, y=0) for m in draws]
    right = np.mean([one.wrap_count == int(1.0 / WRAP) for one in found])
    assert np.mean([one.confidence for one in found]) == approx(right, abs=0.1)


def densities(m, kernel, radius):
    """D (H, W, N) by the sum as it is written, over neighbours and their wraps."""
    weights = np.array([one.ravel() for one in hypotheses(m)], float)
    turns = np.add.outer(np.arange(len(weights)), m.phase[0].ravel() / TAU)
    side = np.arange(-radius, radius + 1)
    window = norm.pdf(side, scale=max(radius / 2, 0.5))
    places = np.indices(m.shape).reshape(2, -1).T
    apart = places[:, None] - places
    near = np.interp(apart, side, window / window.sum(), 0, 0).prod(-1)
    alike = np.exp(-((np.subtract.outer(turns, turns) / kernel) ** 2) / 2)
    found = np.einsum("npmq,mq,pq->pn", alike, weights, near, optimize=True)
    return found.reshape(*m.shape, -1)


@mark.parametrize("kernel, radius", [(0.25, 5), (0.3, 0), (2.0, 3)])
def test_densities_equal_the_sum_as_it_is_written(rng, kernel, radius):
    """Nodes h/2 apart err by 0.4 % of the largest density; the winner is the same beyond ties."""
    y, x = np.indices((11, 14))
    m = simulate(Frame(0.9 + 0.004 * x + 0.002 * y, rng.uniform(0.1, 1, (11, 14))))
    direct = densities(m, kernel, radius)
    found, best, total = _largest_density(m, kernel, radius)
    assert_allclose(best, direct.max(2), atol=0.01 * direct.max())
    assert_allclose(total, direct.sum(2), rtol=0.04)
    ranked = np.sort(direct, axis=2)
    clear = ranked[..., -1] - ranked[..., -2] > 0.02 * direct.max()
    assert (found == direct.argmax(2))[clear].all()


def test_spatial_unwrapping_follows_a_slope_over_many_wraps(exact):
    x = np.linspace(0, 1, 80)
    depth = np.add.outer(0.9 + 0.05 * x[:60], 0.2 * x)
    m = exact(depth, range_min=0.8, range_max=1.2)
    assert np.ptp(region.relative_phase(m) - phase_from_depth(depth, 7.15e9)) < 1e-9
    assert np.ptp(cmtof.unwrap(m, method="spatial").depth.values - depth) < 1e-6


@mark.parametrize("jump", [0.4, -20.3])
def test_walls_with_a_step_of_phase_are_two_regions(exact, jump):
    depth = 2.0 + jump * WRAP * (np.indices((60, 80))[1] >= 40)
    assert_allclose(cmtof.unwrap(exact(depth), method="region").depth, depth, atol=1e-6)


@mark.parametrize(
    "name, options",
    [
        ("still_life", {}),
        ("stairs", {"noise": 300.0}),
        ("still_life", {"protocol": "full", "noise_free": True}),
    ],
)
def test_a_region_that_leaks_pull_by_a_wrap_is_not_sure(name, options):
    """Up to 61 % of a frame are off by one wrap together."""
    found = scores(simulate(cmtof.load_frame(name), **options), method="region")
    assert found["mean_confidence"] < found["delta_lt_1"] + 0.15


def test_pooled_noise_is_that_of_the_sum(rng):
    """Of 300 sums of 100 phasors with noise of one fifth, to three standard errors."""
    noise = 0.2 * rng.normal(size=(300, 1, 200)).view(complex)
    found = [region.pool(1 + one, np.zeros((1, 100), int)) for one in noise]
    phase, spread = np.squeeze(found).T
    assert phase.std() == approx(0.02, rel=0.13)
    assert spread.mean() == approx(0.02, rel=0.02)
