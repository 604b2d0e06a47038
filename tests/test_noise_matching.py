"""The simulator's noise found from a phase map's, against noise that is known."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

import cmtof
from cmtof.bounds import phase_bound, phase_spread
from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import TAU, centred, wrapped
from cmtof.noise import (
    frame_from_phase,
    intensity_from_phase_noise,
    linear_from_spread,
    phase_noise_from_sigma,
    rehearsal_capture,
    sigma_from_phase_noise,
    typical_phase_noise,
)
from cmtof.simulation import QUADRATURES


def surface(size: int = 240) -> np.ndarray:
    """A curved wrapped phase of many fringes, rad."""
    y, x = np.mgrid[:size, :size] / size
    return wrapped(90 * x**2 + 60 * x * y + 30 * y)


# --- sigma, brightness and phase noise


@pytest.mark.parametrize("intensity", [0.3, 0.7, 1.0])
@pytest.mark.parametrize("sigma", [300.0, 1200.0, 2000.0])
def test_sigma_comes_back_from_its_phase_noise(sigma: float, intensity: float):
    noise = phase_noise_from_sigma(sigma, intensity=intensity)
    assert sigma_from_phase_noise(noise, intensity=intensity) == pytest.approx(sigma, rel=1e-8)
    assert intensity_from_phase_noise(noise, sigma) == pytest.approx(intensity, rel=1e-8)


@pytest.mark.parametrize("sigma", [600.0, 1200.0])
def test_gaussian_noise_keeps_to_the_bound(sigma: float):
    """Within the percent that the exact law spreads further, and the variance tells more."""
    noise = phase_noise_from_sigma(sigma)
    bound = phase_bound(20_000 / np.pi, 10_000.0, QUADRATURES, sigma=sigma, phase=np.pi / 4)
    assert noise == pytest.approx(float(bound), rel=0.012)


def test_without_gaussian_noise_only_photons_are_left():
    """sigma_phi = sqrt(GTI/2) / (sqrt2 GTI/pi) = pi / (2 sqrt(GTI))."""
    assert phase_noise_from_sigma(0.0, intensity=0.5) == pytest.approx(
        np.pi / 2 / np.sqrt(10_000), rel=1e-3
    )


def test_without_photon_noise_only_the_ratio_of_sigma_to_brightness_matters():
    """With ever more light sigma / I runs to the constant sqrt2 l G T / pi."""
    noise = 0.1
    ratio = np.sqrt(2) * linear_from_spread(noise) * 20_000 / np.pi
    intensity = np.array([1.0, 1e2, 1e4])
    off = sigma_from_phase_noise(noise, intensity=intensity) / intensity / ratio - 1
    assert np.all(np.diff(np.abs(off)) < 0) and abs(off[-1]) < 1e-5


def test_all_pairs_of_one_curve_have_the_same_phase_noise():
    intensity = np.linspace(0.05, 1, 7)
    sigma = sigma_from_phase_noise(0.11, intensity=intensity)
    noise = [phase_noise_from_sigma(s, intensity=i) for s, i in zip(sigma, intensity, strict=True)]
    assert np.allclose(noise, 0.11, rtol=1e-9)
    assert np.all(np.diff(sigma) > 0)


def test_sixteen_steps_halve_the_noise_of_four():
    four, sixteen = (phase_noise_from_sigma(600.0, steps=k) for k in (4, 16))
    assert linear_from_spread(sixteen) == pytest.approx(linear_from_spread(four) / 2)


@pytest.mark.parametrize("linear", [1e-4, 0.1, 0.5, 1.0, 3.0, 20.0])
def test_the_exact_law_is_inverted(linear: float):
    assert linear_from_spread(phase_spread(linear)) == pytest.approx(linear, rel=1e-6)


# --- from a map


@pytest.mark.parametrize(("sigma", "intensity"), [(600.0, 1.0), (1200.0, 1.0), (500.0, 0.6)])
def test_sigma_is_found_in_a_simulated_map(sigma: float, intensity: float):
    """The mean square of disjoint windows is chi-squared; the median of all is at least as good
    as 40 % of it. Bounds of 99.9 %."""
    phase = surface()
    frame = frame_from_phase(phase, np.full(phase.shape, 0.6), intensity=intensity)
    seen = cmtof.simulate(frame, protocol="full", noise=sigma, seed=1).phase[0]
    noise = typical_phase_noise(seen, np.ones(phase.shape, bool))
    freedom = 0.4 * 19 * (240 / 5) ** 2
    low, high = np.sqrt(chi2.ppf([5e-4, 1 - 5e-4], freedom) / freedom)
    found = float(sigma_from_phase_noise(noise, intensity=intensity))
    assert low < found / sigma < high


def test_outliers_hardly_move_the_typical_noise():
    phase = wrapped(surface() + 0.1 * np.random.default_rng(2).standard_normal((240, 240)))
    clean = typical_phase_noise(phase, np.ones(phase.shape, bool))
    phase[::40, ::40] += 2.0
    assert typical_phase_noise(phase, np.ones(phase.shape, bool)) == pytest.approx(clean, rel=0.03)


def test_only_the_windows_asked_for_count():
    noise = np.where(np.arange(240) < 120, 0.05, 0.2)
    phase = wrapped(surface() + noise * np.random.default_rng(3).standard_normal((240, 240)))
    left = np.zeros(phase.shape, bool)
    left[:, :115] = True
    assert typical_phase_noise(phase, left) == pytest.approx(0.05, rel=0.02)


# --- the measured surface as a scene


def test_the_scene_of_a_phase_has_that_phase():
    phase = surface(60)
    frame = frame_from_phase(phase, np.full(phase.shape, 0.7), intensity=0.5)
    seen = cmtof.simulate(frame, protocol="full", noise_free=True).phase[0]
    assert np.abs(centred(seen - phase)).max() < 1e-4  # depth is kept in single precision
    assert np.all(frame.intensity == 0.5)


def test_the_scene_lies_within_half_a_wrap_of_its_reference():
    phase = surface(60)
    frame = frame_from_phase(phase, np.full(phase.shape, 0.7))
    assert np.abs(frame.depth - 0.7).max() <= 0.5 * 0.02097
    assert np.ptp(frame.depth) > 0.02  # and makes use of it


# --- the rehearsal


def test_a_rehearsal_reads_like_a_capture(tmp_path: Path):
    capture = cmtof.open(rehearsal_capture(tmp_path, seed=0))
    assert capture.shape == (100, 100)
    assert capture.frequencies.tolist() == [FREQUENCY_SINGLE]
    assert 0.3 < capture.dataset["reference_depth"].min() < 1.5
    assert capture.phase.min() >= 0 and capture.phase.max() < TAU


def test_a_rehearsal_is_the_same_for_the_same_seed(tmp_path: Path):
    texts = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        texts.append(rehearsal_capture(tmp_path / name, seed=seed).read_bytes())
    assert texts[0] == texts[1] != texts[2]


# --- what is refused


@pytest.mark.parametrize(("sigma", "intensity"), [(-1.0, 1.0), (100.0, 0.0), (np.nan, 1.0)])
def test_noise_without_light_or_below_zero_is_refused(sigma: float, intensity: float):
    with pytest.raises(ValueError, match="Expected a signal above 0 and sigma >= 0 counts"):
        phase_noise_from_sigma(sigma, intensity=intensity)


@pytest.mark.parametrize("noise", [0.0, -0.1, 1.9, np.nan])
def test_a_phase_noise_that_none_can_have_is_refused(noise: float):
    with pytest.raises(ValueError, match=r"Expected a phase noise between 0 and 1\.81 rad"):
        sigma_from_phase_noise(noise)


def test_a_surface_too_dark_is_refused_with_the_brightness_needed():
    least = float(intensity_from_phase_noise(0.1, 0.0))
    assert sigma_from_phase_noise(0.1, intensity=least) == pytest.approx(0, abs=0.5)
    with pytest.raises(ValueError, match=f"Expected a brightness of {least:.4g} or more, got 0.01"):
        sigma_from_phase_noise(0.1, intensity=[0.01, 1.0])


def test_maps_of_two_shapes_are_refused():
    phase = surface(30)
    with pytest.raises(ValueError, match=r"Expected a region of the phase's shape \(30, 30\)"):
        typical_phase_noise(phase, np.ones((30, 29), bool))
    with pytest.raises(ValueError, match=r"Expected a reference of the phase's shape \(30, 30\)"):
        frame_from_phase(phase, np.ones((29, 30)))


def test_a_region_without_a_window_is_refused():
    with pytest.raises(ValueError, match="Expected whole windows of 5 px"):
        typical_phase_noise(surface(30), np.zeros((30, 30), bool))
