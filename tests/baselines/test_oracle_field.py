"""True surfaces through a window."""

import numpy as np
import pytest

import cmtof
from cmtof.baselines.oracle_field import oracle_field, pieces, pool_within
from cmtof.baselines.oracle_offset import oracle_offset, surfaces
from cmtof.scenes.frame import Frame
from cmtof.simulation import simulate


@pytest.fixture
def two(rng):
    """Two flat surfaces with a step between them, at the paper's noise."""
    depth = np.where(np.arange(90) < 50, 2.0, 2.7) * np.ones((40, 1))
    return simulate(Frame(depth, np.full(depth.shape, 0.8)), protocol="full", seed=4)


def by_hand(phasors, surface, side, y, x):
    """Sum over the pixels of (y, x)'s surface within the square."""
    reach, total = side // 2, 0j
    for v in range(max(y - reach, 0), min(y + reach + 1, phasors.shape[0])):
        for u in range(max(x - reach, 0), min(x + reach + 1, phasors.shape[1])):
            total += phasors[v, u] * (surface[v, u] == surface[y, x])
    return total


@pytest.mark.parametrize("side", [1, 3, 7, 41])
def test_sums_are_those_of_a_loop(rng, side):
    surface = np.repeat(np.repeat(rng.integers(0, 3, (3, 4)), 5, 0), 4, 1)
    surface[2, 3] = 3  # a single pixel
    phasors = rng.normal(size=(15, 16)) + 1j * rng.normal(size=(15, 16)) + 2
    found = pool_within(phasors, surface, side)
    for y, x in [(0, 0), (2, 3), (7, 8), (14, 15), (0, 15), (2, 4)]:
        assert found.phase[y, x] == pytest.approx(
            np.angle(by_hand(phasors, surface, side, y, x)), abs=1e-9
        )
    assert np.isinf(found.spread[2, 3])


def test_spread_is_that_of_many_draws(rng):
    """Across a mean of n phasors of unit noise an angle spreads by 1 / (a sqrt n)."""
    noise = rng.normal(size=(2, 300, 300))
    found = pool_within(10 + noise[0] + 1j * noise[1], np.zeros((300, 300), int), 9)
    inner = (slice(4, -4),) * 2
    assert np.std(found.phase[inner]) == pytest.approx(1 / (10 * 9), rel=0.05)
    assert np.mean(found.spread[inner]) == pytest.approx(1 / (10 * 9), rel=0.02)


def test_a_window_of_the_whole_image_is_the_whole_surface(two):
    wide, whole = oracle_field(two, side=201), oracle_offset(two)
    _, boundary = surfaces(two.depth.astype(float))
    np.testing.assert_allclose(wide.depth[~boundary], whole.depth[~boundary], atol=1e-6)


def test_wider_windows_are_right_more_often(two):
    right = [
        np.mean(np.abs(oracle_field(two, side=side).depth - two.depth) < 0.01)
        for side in (5, 21, 61)
    ]
    assert right[0] < right[1] < right[2]


def test_pieces_are_the_surfaces_without_single_pixels(two):
    surface, boundary = surfaces(two.depth.astype(float))
    covered = np.zeros(surface.shape, int)
    for place, inside in pieces(surface):
        covered[place] += inside
    np.testing.assert_array_equal(covered, ~boundary)


@pytest.mark.parametrize("side", [0, 2, -3])
def test_a_side_without_a_middle_is_refused(two, side):
    with pytest.raises(ValueError, match="Expected an odd side"):
        cmtof.unwrap(two, method="oracle-field", side=side)
