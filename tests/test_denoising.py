"""Noise read from a phase map, and averaged away, against noise that is known."""

import numpy as np
import pytest
from scipy.stats import chi2

from cmtof.correlation import TAU, centred
from cmtof.noise import denoise, denoised_phase, local_phase_noise, phase_slope

SIZE = 301


def surface() -> np.ndarray:
    """A curved phase of dozens of wraps, rad, whose third derivative is nearly nil."""
    y, x = np.mgrid[:SIZE, :SIZE] / SIZE
    return 90 * x**2 + 70 * x * y + 40 * y


def noisy(sigma: float, seed: int, phase: np.ndarray) -> np.ndarray:
    return (phase + sigma * np.random.default_rng(seed).standard_normal(phase.shape)) % TAU


@pytest.mark.parametrize(("sigma", "window"), [(0.05, 5), (0.134, 5), (0.134, 7), (0.3, 5)])
def test_local_noise_is_the_known_noise(sigma: float, window: int):
    """Disjoint windows are independent: their sum of squares is chi-squared, to 99.9 %."""
    noise = local_phase_noise(noisy(sigma, 1, surface()), window=window)
    apart = noise[window // 2 :: window, window // 2 :: window]
    apart = apart[np.isfinite(apart)]
    freedom = apart.size * (window**2 - 6)
    low, high = chi2.ppf([5e-4, 1 - 5e-4], freedom) / freedom
    assert low < np.mean(apart**2) / sigma**2 < high


def test_local_noise_knows_no_value_at_the_border():
    noise = local_phase_noise(noisy(0.1, 0, surface()), window=7)
    assert np.isnan(noise[:3]).all() and np.isnan(noise[:, -3:]).all()
    assert np.isfinite(noise[3:-3, 3:-3]).all()


@pytest.mark.parametrize(("sigma", "window"), [(0.134, 3), (0.134, 5), (0.4, 5), (0.134, 9)])
def test_averaging_brings_white_noise_down_by_the_window(sigma: float, window: int):
    """On a plane the error is sigma / window (of the phasor's transverse part), to 99.9 %."""
    y, x = np.mgrid[:SIZE, :SIZE]
    plane = 0.61 * x - 0.27 * y
    error = centred(denoised_phase(noisy(sigma, 2, plane), window=window) - plane)
    # every other window: neighbouring ones tell of each other's slope
    apart = error[window : -window : 2 * window, window : -window : 2 * window].ravel()
    # exp(i e) with Gaussian e: transverse variance over squared mean, per sample
    transverse = (1 - np.exp(-2 * sigma**2)) / 2 / np.exp(-(sigma**2))
    low, high = chi2.ppf([5e-4, 1 - 5e-4], apart.size) / apart.size
    assert low < np.mean(apart**2) * window**2 / transverse < high


def test_curvature_shifts_by_the_documented_bias():
    y, x = np.mgrid[:41, :41]
    kappa, window = 0.01, 7
    phase = kappa / 2 * ((x - 20.0) ** 2 + (y - 20.0) ** 2)
    bias = centred(denoised_phase(phase, window=window) - phase)[20, 20]
    assert bias == pytest.approx(kappa * (window**2 - 1) / 12, rel=0.02)


def test_amplitude_keeps_dark_pixels_out():
    plane = np.outer(np.ones(31), 0.4 * np.arange(31)) % TAU
    phase, amplitude = plane.copy(), np.ones_like(plane)
    phase[15, 16], amplitude[15, 16] = phase[15, 16] + 2.0, 0.0
    weighted = centred(denoised_phase(phase, amplitude) - plane)
    plain = centred(denoised_phase(phase) - plane)
    assert abs(weighted[15, 15]) < 1e-12 < abs(plain[15, 15])


def test_coherence_tells_noise_and_edges():
    sigma = 0.3
    plane = np.add.outer(0.2 * np.arange(SIZE), 0.5 * np.arange(SIZE))
    assert np.median(denoise(noisy(sigma, 3, plane), window=9).coherence) == pytest.approx(
        np.exp(-(sigma**2) / 2), rel=0.01
    )
    plane[:, SIZE // 2 :] += np.pi
    coherence = denoise(plane % TAU).coherence
    assert coherence[50, SIZE // 2] < 0.9 < coherence[50, 20]


def test_slope_is_that_of_a_plane_whatever_its_wraps():
    down, right = phase_slope(np.add.outer(2.9 * np.arange(20), -2.7 * np.arange(20)) % TAU)
    assert np.allclose(down, 2.9) and np.allclose(right, -2.7)


@pytest.mark.parametrize("window", [1, 4, -3])
def test_an_even_or_small_window_is_refused(window: int):
    with pytest.raises(ValueError, match="Expected an odd window"):
        denoised_phase(np.zeros((9, 9)), window=window)


def test_a_stack_is_refused():
    with pytest.raises(ValueError, match="Expected a phase map"):
        local_phase_noise(np.zeros((2, 9, 9)))
