"""Bounds and laws against Monte Carlo, odds against counting."""

import numpy as np
from numpy.testing import assert_allclose
from pytest import approx, mark
from scipy.differentiate import hessian

from cmtof import bounds
from cmtof.bounds import simulated_phase_noise
from cmtof.constants import FREQUENCIES
from cmtof.correlation import (
    TAU,
    centred,
    correlation_from_phase,
    phase_from_correlation,
)
from cmtof.detector import poisson_gaussian
from cmtof.simulation import QUADRATURES

PSI = np.array(QUADRATURES)
DRAWS = 300_000


def errors(intensity, rng):
    phase = 0.9
    signal = 20_000 * intensity
    mean = correlation_from_phase(
        np.full(DRAWS, phase), PSI, amplitude=signal / np.pi, offset=signal / 2
    )
    counts = poisson_gaussian(mean, rng=rng, sigma=1200.0)
    return centred(phase_from_correlation(counts, PSI) - phase)


def odds(noise):
    """Odds of the right wrap by the formula, from two phases of equal noise."""
    return bounds.wrap_probability(noise, noise, frequencies=FREQUENCIES)


@mark.parametrize("intensity", [1.0, 0.3, 0.1, 0.05])
def test_phase_noise_follows_the_exact_law_everywhere(rng, intensity):
    assert errors(intensity, rng).std() == approx(
        bounds.phase_spread(simulated_phase_noise(intensity)), rel=0.03
    )


def test_phase_spread_tends_to_the_linear_and_to_the_uniform_limit():
    assert bounds.phase_spread(0.01) == approx(0.01, rel=1e-3)
    assert bounds.phase_spread(1e4) == approx(np.pi / np.sqrt(3), rel=1e-3)


def test_fisher_information_is_the_curvature_of_the_likelihood():
    truth = np.array([0.7, 900.0, 2000.0])  # phase, amplitude, offset

    def mean(shares):
        phase, amplitude, offset = map(np.multiply, truth, shares[..., None])
        return offset + amplitude * np.cos(phase + PSI)

    def expected_nll(shares):
        v = mean(shares) + 50**2
        exact = mean(np.ones(3))
        return (
            np.sum(np.log(v) + (exact + 50**2 + (exact + 50**2 - v) ** 2) / v, axis=-1)
            / 2
        )

    found = hessian(expected_nll, np.ones(3), initial_step=0.01).ddf
    fisher = bounds.fisher_information(900.0, 2000.0, PSI, sigma=50.0, phase=0.7)
    fisher *= np.outer(truth, truth)
    assert_allclose(found, fisher, atol=1e-4 * np.diag(fisher).min())


def test_pooling_the_needed_pixels_gives_the_stated_odds():
    noise = simulated_phase_noise(1.0)
    pixels = bounds.pixels_needed(noise, noise, frequencies=FREQUENCIES, odds=0.8)
    assert odds(noise / np.sqrt(pixels)) == approx(0.8, abs=1e-3)


@mark.parametrize("intensity", [1.0, 0.1])
def test_odds_of_one_pixel_equal_counting(rng, intensity):
    """The beat chooses the wrap of drawn phases; in the dark only the exact law still holds."""
    low, high = FREQUENCIES
    draws = 2_000_000
    noise = simulated_phase_noise(intensity)
    real, imaginary = noise * rng.normal(size=(2, 2, draws))
    error = np.angle(1 + real + 1j * imaginary)
    beat = centred(error[1] - 2 * error[0])
    wraps = np.rint((low / (high - 2 * low)) * beat / TAU - error[0] / TAU)
    law = bounds.wrap_probability_law(noise, noise, frequencies=FREQUENCIES)
    assert (wraps == 0).mean() == approx(law, rel=0.04)
    if intensity == 1:
        assert odds(noise) == approx(law, rel=0.05)


def test_the_law_of_the_odds_meets_the_formula_in_small_noise_and_a_guess_in_darkness():
    small = bounds.wrap_probability_law(0.02, 0.02, frequencies=FREQUENCIES)
    assert small == approx(odds(0.02), rel=1e-3)
    wide = bounds.wrap_probability_law(0.02, 0.02, frequencies=(7.15e9, 10e9))
    assert wide == approx(1.0)
    dark = bounds.wrap_probability_law(50.0, 50.0, frequencies=FREQUENCIES)
    assert dark == approx(20 / 7150, rel=0.05)
