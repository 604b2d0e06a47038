"""Two close frequencies: exact without noise, equal to the look-up, as good as theory."""

import numpy as np
import pytest

import cmtof
from cmtof import bounds, metrics
from cmtof.baselines.phasor import match, phasor
from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth, wrap_length
from cmtof.measurement import Measurement
from cmtof.scenes.frame import Frame
from cmtof.simulation import simulate

CLOSE = (7.15e9, 7.16e9)


def measured(depth, intensity, limits=None, **options):
    m = simulate(Frame(depth, intensity), protocol="full", frequencies=CLOSE, **options)
    return m.between(*limits) if limits else m


def from_phases(depth, pair=CLOSE, **more):
    phase = np.stack([phase_from_depth(depth, f) for f in pair])
    return Measurement.from_phase(phase, pair, depth=depth, **more)


def table(m, step):
    """One-stage look-up: nearest entry of the table of weighted vectors, (H, W), m."""
    entries = np.arange(*m.range, step)
    phase, weight = m.phase.reshape(2, -1).astype(float), m.amplitude.reshape(2, -1).astype(float)
    pixels = np.concatenate([weight * np.cos(phase), weight * np.sin(phase)])
    angles = np.stack([phase_from_depth(entries, f) for f in m.frequencies])
    best, index = np.full(pixels.shape[1], -np.inf), np.zeros(pixels.shape[1], int)
    for begin in range(0, entries.size, 10_000):
        block = angles[:, begin : begin + 10_000]
        found = pixels.T @ np.concatenate([np.cos(block), np.sin(block)])
        top = found.argmax(axis=1)
        high = found[np.arange(top.size), top]
        index = np.where(high > best, begin + top, index)
        best = np.maximum(best, high)
    return entries[index].reshape(m.shape), best.reshape(m.shape)


def test_exact_over_all_fifteen_metres(rng):
    depth = rng.uniform(0.0001, 14.9895, (90, 100))
    m = from_phases(depth)
    assert m.range == pytest.approx((0, 14.98962), abs=1e-5)
    np.testing.assert_allclose(phasor(m).depth, depth, atol=1e-9)
    result = cmtof.unwrap(m, method="phasor")
    assert metrics.score(metrics.scored_pixels(result, m))["consistent_lt_1"] == 1.0


def test_simulated_without_noise(rng):
    depth = rng.uniform(0.01, 14.98, (50, 50))
    m = measured(depth, np.ones_like(depth), noise_free=True)
    np.testing.assert_allclose(phasor(m).depth, depth, atol=1e-5)


@pytest.mark.parametrize(
    ("limits", "step"), [((0.0, 14.98), 4e-4), ((0.75, 1.19), 1e-4), ((0.9, 0.935), 1e-5)]
)
def test_no_entry_of_the_table_is_nearer(rng, limits, step):
    depth = rng.uniform(*limits, (16, 16))
    m = measured(depth, rng.uniform(0.05, 1, depth.shape), limits, seed=2)
    _, height = table(m, step)
    phase, amplitude = m.phase.astype(float), m.amplitude.astype(float)
    ours = match(m, phase, amplitude, phasor(m).depth)
    scale = amplitude.sum(axis=0)
    assert (ours >= height - 1e-7 * scale).all()
    # and an entry next to ours misses the peak by no more than half a step
    loss = phase_from_depth(step, CLOSE[1]) ** 2 / 2
    assert (ours <= height + loss * scale).all()


def test_equals_the_look_up_in_a_table_as_fine_as_the_peaks_differ(rng):
    depth = rng.uniform(0.85, 1.05, (12, 12))
    m = measured(depth, rng.uniform(0.2, 1, depth.shape), (0.85, 1.05), seed=4)
    nearest, _ = table(m, 1e-6)
    assert np.mean(np.abs(phasor(m).depth - nearest) < 2e-6) > 0.98


def test_rate_is_that_of_theory():
    m = measured(np.full((500, 500), 7.0), np.ones((500, 500)), seed=3)
    result = cmtof.unwrap(m, method="phasor")
    rate = metrics.score(metrics.scored_pixels(result, m))["consistent_lt_1"]
    noise = float(bounds.linear_phase_noise(20_000 / np.pi, 10_000 + 1200**2, 4))
    assert float(bounds.wrap_noise(noise, noise, frequencies=CLOSE)) / noise == pytest.approx(
        161, abs=0.1
    )
    theory = bounds.wrap_probability_law(noise, noise, frequencies=CLOSE)
    assert rate == pytest.approx(theory, abs=4 * np.sqrt(theory / m.mask.size))
    assert float(result.confidence.mean()) == pytest.approx(theory, rel=0.03)


def test_amplitude_weighs_the_phases():
    """Where one frequency returns nothing the depth is that of the other's phase."""
    depth = np.full((3, 4), 5.0)
    for bright in (0, 1):
        amplitude = np.full((2, 3, 4), 1e-6)
        amplitude[bright] = 1
        phase = np.stack([phase_from_depth(depth, f) for f in CLOSE])
        phase[1 - bright] += 0.003
        m = Measurement.from_phase(phase, CLOSE, amplitude=amplitude, depth=depth)
        np.testing.assert_allclose(phasor(m).depth, 5.0, atol=1e-9)


@pytest.mark.parametrize("limits", [(0.755, 1.195), (0.90, 0.91), (0.0, 0.001), (14.0, 14.9)])
def test_depths_stay_in_range(rng, limits):
    depth = rng.uniform(0.1, 14, (20, 20))
    estimate = phasor(measured(depth, np.ones_like(depth), limits, seed=1))
    assert (estimate.depth >= limits[0]).all()
    assert (estimate.depth < limits[1]).all()
    assert ((estimate.confidence >= 0) & (estimate.confidence <= 1)).all()


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1)])
def test_any_shape(shape):
    depth = np.full(shape, 3.3)
    np.testing.assert_allclose(phasor(from_phases(depth)).depth, depth, atol=1e-9)


def test_darkness_and_nothing_known_stay_in_the_middle():
    depth = np.full((4, 5), 3.3)
    dark = phasor(from_phases(depth, amplitude=np.zeros((2, 4, 5)), range_min=1.0, range_max=2.0))
    np.testing.assert_allclose(dark.depth, 1.5)
    np.testing.assert_allclose(dark.confidence, 1 / 49)
    holed = np.where(np.eye(4, 5) > 0, np.nan, depth)
    m = from_phases(holed, mask=np.isfinite(holed), range_max=5.0)
    estimate = phasor(m)
    np.testing.assert_allclose(estimate.depth[m.mask], 3.3, atol=1e-9)
    np.testing.assert_allclose(estimate.depth[~m.mask], 2.5)
    assert np.isfinite(estimate.confidence).all()


@pytest.mark.parametrize(
    ("pair", "limits"),
    [(FREQUENCIES, (0.0, 7.0)), (FREQUENCIES, (0.0, 0.02)), ((7.15e9, 7.25e9), (0.0, 7.0))],
)
def test_pairs_whose_beat_repeats_are_refused(pair, limits):
    m = from_phases(np.ones((3, 3)), pair).between(*limits)
    message = (
        r"Expected two close frequencies .* got 7.15e\+09 and .* "
        r"simulate with --frequencies 7.15e9,7.16e9."
    )
    with pytest.raises(ValueError, match=message) as error:
        phasor(m)
    assert "\n" not in str(error.value)
    assert f"cover {float(wrap_length(pair[1] - pair[0])):.3f} m" in str(error.value)
