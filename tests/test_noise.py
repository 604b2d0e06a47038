"""Noise of a phase map read, averaged, drawn and matched, against noise that is known."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_less
from pytest import approx, fixture, mark
from scipy.stats import chi2, sem
from walls import lit

import cmtof
from cmtof.bounds import phase_spread, simulated_phase_noise
from cmtof.correlation import TAU, centred, depth_from_phase, wrapped
from cmtof.noise import (
    LineNoise,
    denoise,
    fit_line_noise,
    fit_response,
    intensity_from_phase_noise,
    local_phase_noise,
    local_residual,
    noise_from_spectrum,
    power_spectrum,
    sigma_from_phase_noise,
    typical_phase_noise,
)

SHAPE = (96, 80)


def surface(size=300):
    """A curved phase of dozens of wraps, rad, whose third derivative is nil."""
    y, x = np.mgrid[:size, :size] / size
    return 90 * x**2 + 70 * x * y + 40 * y


@fixture
def noisy(rng):
    """Maker of wrapped phases with noise."""
    return lambda phase, sigma: wrapped(rng.normal(phase, sigma))


def interval(freedom, missed=1e-3):
    """Mean of so many squares of unit noise, but for a share of cases."""
    return np.array(chi2.interval(1 - missed, freedom)) / freedom


@mark.parametrize("sigma, window", [(0.05, 5), (0.3, 7)])
def test_local_noise_is_the_known_noise(noisy, sigma, window):
    """Disjoint windows are independent: their sum of squares is chi-squared."""
    noise = local_phase_noise(noisy(surface(), sigma), window=window)
    assert np.isnan(noise[: window // 2]).all()
    assert np.isnan(noise[:, -(window // 2) :]).all()
    apart = noise[window // 2 :: window, window // 2 :: window]
    apart = apart[np.isfinite(apart)]
    low, high = interval(apart.size * (window**2 - 6))
    assert low < (apart**2).mean() / sigma**2 < high


@mark.parametrize("sigma, window", [(0.134, 3), (0.4, 5)])
def test_averaging_brings_white_noise_down_by_the_window(noisy, sigma, window):
    """On a plane the error is sigma / window (of the phasor's transverse part)."""
    plane = np.add.outer(-0.27 * np.arange(300), 0.61 * np.arange(300))
    seen = denoise(noisy(plane, sigma), window=window)
    assert np.median(seen.coherence) == approx(np.exp(-(sigma**2) / 2), rel=0.02)
    error = centred(seen.phase - plane)
    # every other window: neighbouring ones share the error of their slope
    every = slice(window, -window, 2 * window)
    apart = error[every, every].ravel()
    # exp(i e) with Gaussian e: transverse variance over squared mean, per sample
    transverse = np.sinh(sigma**2)
    low, high = interval(apart.size)
    assert low < (apart**2).mean() * window**2 / transverse < high


@mark.parametrize("ky, kx", [(0, 7), (12, 5), (30, 48)])
def test_a_ripple_leaves_its_response_and_a_surface_of_third_order_nothing(ky, kx):
    y, x = np.mgrid[:96, :96]
    ripple = 1e-4 * np.cos(TAU * (ky * y + kx * x) / 96)
    across = x - 48
    cubic = 1e-5 * across**3 - 2e-5 * across * y**2 + 0.5 * y - 1.1 * x
    left = local_residual(wrapped(cubic + ripple))
    expected = fit_response((96, 96))[ky, kx] * ripple
    known = np.isfinite(left)
    assert_allclose(left[known], expected[known], atol=1e-9)


def part():
    """A mask with a hole, an edge and a notch."""
    y, x = np.indices(SHAPE)
    inside = np.zeros(SHAPE, bool)
    inside[4:90, 7:76] = True
    return inside & (np.hypot(y - 50, x - 45) > 20)


def test_spectrum_of_white_noise_is_flat_and_its_mean_is_the_mean_square(rng):
    values = 0.13 * rng.standard_normal(SHAPE)
    held = power_spectrum(np.where(part(), values, np.nan), part())
    assert held.mean() == approx((values[part()] ** 2).mean())
    # each is the mean of 96 exponential laws: chi-squared, 99.9 % for all 39 at once
    along = power_spectrum(values, np.ones(SHAPE, bool)).mean(0)[1:40]
    low, high = 0.13**2 * interval(2 * SHAPE[0], 1e-3 / 39)
    assert low < along.min()
    assert along.max() < high


@mark.parametrize(
    "noise, lag, correlation",
    [
        (LineNoise(0.1, 0.0, 0.4, 0.3), (1, 1), 0.12),
        (LineNoise(0.3, 0.4, 0.0, 0.0), (17, 0), 0.64),
    ],
)
def test_line_noise_correlates_as_its_numbers(noise, lag, correlation):
    covariance = np.fft.ifft2(noise.spectrum(SHAPE)).real
    assert covariance[lag] / covariance[0, 0] == approx(correlation, abs=1e-12)
    assert covariance[0, 0] == approx(noise.white**2 + noise.line**2)


@mark.parametrize(
    "known", [LineNoise(0.12, 0.03, 0.1, 0.05), LineNoise(0.08, 0.03, 0.45, 0.0)]
)
def test_line_noise_is_found_again(known, rng):
    """Within a mask, behind the fit: mean of six draws, to four of its standard errors."""
    spectrum = known.spectrum(SHAPE)
    found = []
    for _ in range(6):
        drawn = noise_from_spectrum(spectrum, rng=rng)
        left = local_residual(wrapped(drawn))
        found.append(fit_line_noise(left, part()))
    floors = [0.002, 0.006, 0.02, 0.02]  # what finite windows bias
    assert_array_less(abs(np.mean(found, 0) - known), 4 * sem(found) + floors)


@mark.parametrize("sigma, intensity", [(300.0, 1.0), (2000.0, 0.3)])
def test_sigma_and_brightness_come_back_from_their_phase_noise(sigma, intensity):
    noise = phase_spread(simulated_phase_noise(intensity, sigma=sigma))
    assert sigma_from_phase_noise(noise, intensity=intensity) == approx(sigma, rel=1e-8)
    assert intensity_from_phase_noise(noise, sigma) == approx(intensity, rel=1e-8)


def test_sigma_is_found_in_a_simulated_map_despite_outliers():
    """The median of all windows is at least as good as the mean square of 40 % of disjoint ones."""
    depth = 0.6 + depth_from_phase(surface(240), 7.15e9)
    phase = cmtof.simulate(lit(depth, 0.6), protocol="full", noise=500).phase[0]
    phase[::40, ::40] += 2.0
    noise = typical_phase_noise(phase, np.ones(phase.shape, bool))
    low, high = np.sqrt(interval(0.4 * 19 * (240 / 5) ** 2))
    assert low - 0.01 < sigma_from_phase_noise(noise, intensity=0.6) / 500 < high + 0.03
