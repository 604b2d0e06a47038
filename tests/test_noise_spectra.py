"""Spectra of what a local fit leaves, against closed forms and noise that is known."""

import numpy as np
import pytest
from scipy.stats import chi2, expon

from cmtof.correlation import TAU, wrapped
from cmtof.noise import (
    LineNoise,
    fit_kernel,
    fit_line_noise,
    fit_response,
    local_phase_noise,
    local_residual,
    masked_spectrum,
    noise_from_spectrum,
    power_spectrum,
)

SHAPE = (96, 80)
EVERYWHERE = np.ones(SHAPE, bool)


def part() -> np.ndarray:
    """A mask with a hole, an edge and a notch."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return (np.hypot(y - 50, x - 45) > 20) & (x > 6) & (y < 90)


def white(sigma: float, seed: int, shape: tuple[int, int] = SHAPE) -> np.ndarray:
    return sigma * np.random.default_rng(seed).standard_normal(shape)


def inner(mask: np.ndarray, window: int = 9) -> np.ndarray:
    """The mask where a residual is known."""
    known = np.zeros_like(mask)
    reach = window // 2
    known[reach:-reach, reach:-reach] = True
    return mask & known


# --- the fit as a filter


@pytest.mark.parametrize(("window", "kept"), [(3, 4 / 9), (5, 148 / 175)])
def test_the_centre_keeps_what_savitzky_and_golay_say(window: int, kept: float):
    """Their quadratic smoothing gives its centre 5/9 in 3 x 3 and 27/175 in 5 x 5."""
    assert fit_kernel(window)[window // 2, window // 2] == pytest.approx(kept)


@pytest.mark.parametrize("window", [5, 9])
def test_surfaces_up_to_third_order_leave_nothing(window: int):
    y, x = np.mgrid[:40, :40] - 20.0
    phase = 1e-4 * x**3 - 2e-4 * x * y * y + 0.01 * x * y + 0.5 * y - 1.1 * x
    assert np.nanmax(np.abs(local_residual(wrapped(phase), window=window))) < 1e-9


@pytest.mark.parametrize("window", [5, 9])
def test_a_ripple_is_left_by_the_response(window: int):
    """cos(k x) on a plane comes back times R(k)."""
    response = fit_response((96, 96), window=window)
    y, x = np.mgrid[:96, :96]
    for ky, kx in ((0, 7), (12, 5), (30, 48)):
        ripple = 1e-4 * np.cos(TAU * (ky * y + kx * x) / 96)
        left = local_residual(wrapped(0.3 * x - 0.2 * y + ripple), window=window)
        known = np.isfinite(left)
        assert np.allclose(left[known], (response[ky, kx] * ripple)[known], atol=1e-9)


def test_response_is_nil_for_slow_and_one_on_average_for_fast():
    response = fit_response(SHAPE, window=9)
    assert abs(response[0, 0]) < 1e-12
    assert np.mean(response) == pytest.approx(fit_kernel(9)[4, 4])  # its value at lag zero
    assert np.mean(response**2) == pytest.approx(fit_kernel(9)[4, 4])  # a projector: K * K = K


def test_the_residuals_variance_is_the_responses_share():
    """White noise leaves sigma^2 (1 - centre weight), to five standard errors."""
    left = local_residual(white(0.1, 0, (300, 300)), window=5)
    known = np.isfinite(left)
    share = 148 / 175
    error = np.sqrt(2 / known.sum())  # of a mean square, were its pixels independent: nearly
    assert np.mean(left[known] ** 2) / 0.01 == pytest.approx(share, rel=5 * error)


def test_residual_and_local_noise_tell_the_same_sigma():
    phase = white(0.1, 1, (300, 300))
    left = local_residual(phase, window=5)
    by_centre = np.sqrt(np.nanmean(left**2) / (148 / 175))
    by_window = np.sqrt(np.nanmean(local_phase_noise(phase) ** 2))
    assert by_centre == pytest.approx(by_window, rel=0.005)


def test_the_border_has_no_residual():
    left = local_residual(white(0.1, 0), window=7)
    assert np.isnan(left[:3]).all() and np.isnan(left[:, -3:]).all()
    assert np.isfinite(left[3:-3, 3:-3]).all()


# --- spectra


@pytest.mark.parametrize("mask", [EVERYWHERE, part()], ids=["whole", "part"])
def test_parseval(mask: np.ndarray):
    values = white(1.0, 2)
    assert power_spectrum(values, mask).mean() == pytest.approx(np.mean(values[mask] ** 2))


def test_white_noise_is_flat_at_its_variance():
    """Each is the mean of 96 exponential laws: chi-squared, 99.9 % for all 39 at once."""
    sigma = 0.13
    along = power_spectrum(white(sigma, 3), EVERYWHERE).mean(axis=0)[1:40]
    freedom = 2 * SHAPE[0]
    tail = 5e-4 / along.size
    low, high = chi2.ppf([tail, 1 - tail], freedom) / freedom
    assert along.min() / sigma**2 > low and along.max() / sigma**2 < high


def test_the_periodogram_of_noise_is_exponential():
    """Kolmogorov's distance of 96 x 39 free frequencies stays below that of 99.9 %."""
    power = np.sort(power_spectrum(white(2.0, 4), EVERYWHERE)[:, 1:40].ravel() / 4)
    distance = np.abs(expon.cdf(power) - (np.arange(power.size) + 0.5) / power.size).max()
    assert distance < 1.95 / np.sqrt(power.size)


def test_a_wave_is_one_line_of_the_spectrum():
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    power = power_spectrum(np.cos(TAU * (6 * y / 96 + 10 * x / 80)), EVERYWHERE)
    assert power[6, 10] == pytest.approx(0.25 * power.size)
    assert power.sum() - power[6, 10] - power[-6, -10] == pytest.approx(0, abs=1e-9)


def test_what_lies_outside_the_mask_does_not_count():
    values, mask = white(1.0, 5), part()
    changed = np.where(mask, values, np.nan)
    assert np.array_equal(power_spectrum(values, mask), power_spectrum(changed, mask))


def test_a_mask_leaves_white_noise_white():
    assert np.allclose(masked_spectrum(np.full(SHAPE, 0.3), part()), 0.3)


def test_no_mask_leaves_every_spectrum_as_it_is():
    spectrum = LineNoise(0.1, 0.05, 0.3, -0.2).spectrum(SHAPE)
    assert np.allclose(masked_spectrum(spectrum, EVERYWHERE), spectrum)


def test_a_masked_spectrum_is_the_mean_of_many():
    """Of 200 draws, band by band of eight frequencies, to five standard errors."""
    rng, mask = np.random.default_rng(6), part()
    spectrum = LineNoise(0.1, 0.05, 0.3, 0.1).spectrum(SHAPE)
    drawn = np.array(
        [power_spectrum(noise_from_spectrum(spectrum, rng=rng), mask) for _ in range(200)]
    )
    bands = drawn.mean(axis=1).reshape(200, 10, 8).mean(axis=2)
    law = masked_spectrum(spectrum, mask).mean(axis=0).reshape(10, 8).mean(axis=1)
    error = bands.std(axis=0) / np.sqrt(200)
    assert np.all(np.abs(bands.mean(axis=0) - law) < 5 * error)


# --- noise with a spectrum


def test_drawn_noise_has_the_spectrum():
    """The ratio to the spectrum is exponential: its mean over all frequencies is one."""
    spectrum = LineNoise(0.1, 0.04, 0.3, 0.0).spectrum(SHAPE)
    drawn = noise_from_spectrum(spectrum, rng=np.random.default_rng(7))
    ratio = power_spectrum(drawn, EVERYWHERE) / spectrum
    assert ratio.mean() == pytest.approx(1, abs=5 * np.sqrt(2 / ratio.size))


def test_drawn_noise_is_the_same_for_the_same_seed():
    spectrum = LineNoise(0.1, 0.04, 0.3, 0.0).spectrum(SHAPE)
    first, second = (noise_from_spectrum(spectrum, rng=np.random.default_rng(8)) for _ in range(2))
    assert np.array_equal(first, second)


@pytest.mark.parametrize(
    ("noise", "lag", "correlation"),
    [
        (LineNoise(0.1, 0.0, 0.5, 0.0), (1, 0), 0.5),
        (LineNoise(0.1, 0.0, 0.5, 0.0), (0, 1), 0.0),
        (LineNoise(0.1, 0.0, 0.0, -0.3), (0, 1), -0.3),
        (LineNoise(0.1, 0.0, 0.4, 0.3), (1, 1), 0.12),
        (LineNoise(0.3, 0.4, 0.0, 0.0), (17, 0), 0.64),
        (LineNoise(0.3, 0.4, 0.0, 0.0), (0, 1), 0.0),
    ],
)
def test_line_noise_correlates_as_it_says(noise: LineNoise, lag, correlation: float):
    covariance = np.fft.ifft2(noise.spectrum(SHAPE)).real
    assert covariance[lag] / covariance[0, 0] == pytest.approx(correlation, abs=1e-12)
    assert covariance[0, 0] == pytest.approx(noise.white**2 + noise.line**2)


KNOWN = [
    LineNoise(0.12, 0.0, 0.0, 0.0),
    LineNoise(0.12, 0.03, 0.1, 0.05),
    LineNoise(0.08, 0.03, 0.45, 0.0),
]


@pytest.mark.parametrize("known", KNOWN, ids=["white", "grain", "overlap"])
def test_line_noise_is_found_again(known: LineNoise):
    """Within a mask, behind the fit: mean of six draws, to four of its standard errors."""
    mask = inner(part())
    rng = np.random.default_rng(9)
    found = []
    for _ in range(6):
        phase = wrapped(noise_from_spectrum(known.spectrum(SHAPE), rng=rng))
        found.append(fit_line_noise(local_residual(phase), mask))
    mean, error = np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / np.sqrt(6)
    for name, value, ours, spread in zip(known._fields, known, mean, error, strict=True):
        if name == "line" and value == 0:
            assert ours < 0.02  # a drift cannot be found below zero: all errors are upwards
        else:
            # the floors are what finite windows bias
            assert abs(ours - value) < 4 * spread + {"white": 0.002, "line": 0.006}.get(name, 0.02)


# --- what is refused


@pytest.mark.parametrize(
    ("values", "mask"),
    [
        (np.zeros(5), np.ones(5, bool)),
        (np.zeros((5, 5)), np.ones((4, 5), bool)),
        (np.zeros((5, 5)), np.zeros((5, 5), bool)),
    ],
)
def test_a_spectrum_needs_a_map_and_its_mask(values, mask):
    with pytest.raises(ValueError, match=r"Expected a map \(H, W\) and a mask of its shape"):
        power_spectrum(values, mask)


def test_a_mask_that_lets_nan_pass_is_refused():
    with pytest.raises(ValueError, match="Expected finite values within the mask"):
        power_spectrum(local_residual(white(0.1, 0)), EVERYWHERE)


@pytest.mark.parametrize("bad", [-0.1, np.nan, np.inf])
def test_a_spectrum_that_is_none_is_refused(bad: float):
    spectrum = np.ones((4, 4))
    spectrum[1, 1] = bad
    with pytest.raises(ValueError, match="Expected a finite power spectrum"):
        noise_from_spectrum(spectrum, rng=np.random.default_rng(0))


def test_a_residual_of_zeros_is_refused():
    with pytest.raises(ValueError, match="Expected a residual with noise in it"):
        fit_line_noise(np.zeros(SHAPE), EVERYWHERE)


def test_a_window_larger_than_the_map_is_refused():
    with pytest.raises(ValueError, match="Expected a window of at most 7 px"):
        fit_response((7, 20), window=9)


@pytest.mark.parametrize("function", [fit_kernel, lambda w: fit_response(SHAPE, window=w)])
def test_an_even_window_is_refused(function):
    with pytest.raises(ValueError, match="Expected an odd window"):
        function(4)
