"""True surfaces with an unknown tilt."""

import numpy as np
import pytest

from cmtof.baselines.oracle_offset import surfaces
from cmtof.baselines.oracle_plane import oracle_plane, tilt_of
from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth
from cmtof.measurement import Measurement
from cmtof.scenes.frame import Frame
from cmtof.simulation import simulate

RATIO = FREQUENCIES[1] / FREQUENCIES[0]


def plane(down, across, shape=(30, 41)):
    y, x = np.indices(shape, dtype=float)
    return down * (y - (shape[0] - 1) / 2) + across * (x - (shape[1] - 1) / 2)


@pytest.mark.parametrize("slopes", [(0, 0), (0.31, -0.82), (-1.3, 0.004), (2.9, 2.2), (0, -3.0)])
def test_a_plane_is_found_exactly(slopes):
    true = plane(*slopes)
    found = tilt_of([np.exp(1j * (true + 0.7)), 2 * np.exp(1j * (RATIO * true - 1))], RATIO)
    np.testing.assert_allclose(found, true, atol=1e-6)


def test_spread_of_slopes_meets_the_bound(rng):
    """sigma^2 = 6 s^2 / (a^2 n (m^2 - 1)) for one tone (Rife and Boorstyn); two add up."""
    shape, noise, found = (24, 24), 1.5, []
    for _ in range(60):
        drawn = rng.normal(size=(2, 2, *shape)) * noise
        phasors = [1 + drawn[i, 0] + 1j * drawn[i, 1] for i in (0, 1)]
        tilt = tilt_of(phasors, RATIO)
        found.append((tilt[-1, 0] - tilt[0, 0]) / (shape[0] - 1))
    bound = noise * np.sqrt(12 / (24**2 * (24**2 - 1) * (1 + RATIO**2)))
    # sixty draws know a deviation to 9 %
    assert np.std(found) == pytest.approx(bound, rel=0.28)


def test_a_tilt_of_the_truth_is_found_back():
    """Only the kind of the true shape is used: tilting it changes nothing."""
    depth = 2 + 1e-3 * plane(1, 2)
    moved = depth + 0.017 + 2e-4 * plane(-3, 1)
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    estimate = oracle_plane(Measurement.from_phase(phase, FREQUENCIES, depth=moved))
    assert np.abs(estimate.depth - depth).max() < 1e-6


def test_noise_is_pooled_away_on_every_surface():
    x = np.linspace(0, 1, 150)
    depth = np.where(x < 0.5, 2, 3) + 0.3 * x[:, None] + 0 * x
    m = simulate(Frame(depth, np.ones_like(depth)), protocol="full", seed=5)
    _, boundary = surfaces(m.depth.astype(float))
    assert np.abs(oracle_plane(m).depth - depth)[~boundary].max() < 2e-3


def test_darkness_has_no_tilt():
    assert not tilt_of([np.zeros((4, 5), complex)] * 2, RATIO).any()


@pytest.mark.parametrize("shape", [(1, 1), (1, 6), (2, 2)])
def test_few_pixels_are_no_trouble(shape):
    phase = np.ones((2, *shape))
    m = Measurement.from_phase(phase, FREQUENCIES, depth=np.ones(shape))
    assert np.isfinite(oracle_plane(m).depth).all()
