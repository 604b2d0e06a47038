"""Noise laws by their moments; filters and converters by their closed forms."""

from functools import partial
from typing import get_args

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx, mark

from cmtof import detector

DRAWS = 200_000
# four standard errors of a variance estimated from DRAWS nearly Gaussian draws
VARIANCE = 4 * np.sqrt(2 / DRAWS)


@mark.parametrize("order", get_args(detector.NoiseOrder))
def test_poisson_gaussian_has_both_variances_in_the_given_precision(rng, order):
    """Counts of the released order are never negative."""
    noise = partial(detector.poisson_gaussian, rng=rng, sigma=40.0, order=order)
    counts = noise(np.full(DRAWS, 900.0, np.float32))
    assert counts.dtype == np.float32
    assert counts.mean() == approx(900.0, abs=4 * 50 / np.sqrt(DRAWS))
    assert counts.var() == approx(900 + 1600, rel=VARIANCE)
    assert (noise(np.zeros(1000)).min() < 0) == (order == "paper")


def test_skellam_difference_keeps_the_sum_of_the_variances(rng):
    d = detector.skellam_gaussian(
        np.full(DRAWS, 500.0), np.full(DRAWS, 300.0), rng=rng, sigma=10.0
    )
    assert d.mean() == approx(200.0, abs=4 * 30 / np.sqrt(DRAWS))
    assert d.var() == approx(500 + 300 + 100, rel=VARIANCE)


@given(st.floats(-10, 2e4), st.integers(1, 16))
def test_quantisation_errs_by_half_a_level_inside_and_saturates_outside(value, bits):
    level = 16383.0 / (2**bits - 1)
    q = detector.quantise(value, bits=bits, full_scale=16383.0)
    assert abs(q - np.clip(value, 0, 16383)) <= level / 2 * (1 + 1e-9)
    assert detector.quantise(q, bits=bits, full_scale=16383.0) == q
