"""Fig. 3: precision grows with the frequency, on the bound."""

import numpy as np
import pytest

from cmtof.precision import precision_figure, precision_ratio, precision_sweep


def test_spread_lies_on_the_bound_and_falls_as_one_over_f(rng):
    sweep = precision_sweep(np.geomspace(1e8, 1e10, 5), rng=rng, samples=40_000, intensity=1.0)
    np.testing.assert_allclose(sweep.spread / sweep.bound, 1.0, rtol=0.02)
    np.testing.assert_allclose(sweep.bound[0] / sweep.bound[-1], 100, rtol=1e-2)
    assert precision_ratio(sweep) == pytest.approx(100, rel=0.04)
    # an unbiased mean: four standard errors
    assert (np.abs(sweep.mean) < 4 * sweep.spread / np.sqrt(sweep.samples)).all()


def test_dim_points_follow_the_exact_law_beyond_the_bound(rng):
    sweep = precision_sweep([1e9], rng=rng, samples=200_000, intensity=0.3)
    assert sweep.spread[0] > 1.1 * sweep.bound[0]
    assert sweep.spread[0] == pytest.approx(sweep.law[0], rel=0.03)


def test_coarse_quantisation_costs_precision(rng):
    fine = precision_sweep([1e9], rng=rng, samples=50_000, intensity=1.0, sigma=20.0)
    coarse = precision_sweep([1e9], rng=rng, samples=50_000, intensity=1.0, sigma=20.0, bits=5)
    assert coarse.spread[0] > 1.3 * fine.spread[0]


def test_figure_shows_both_views(rng):
    fig = precision_figure(precision_sweep([1e8, 1e10], rng=rng, samples=10))
    assert len(fig.axes) == 2
