"""Regions of the unwrapped phase: one offset each, and what they cannot see."""

import numpy as np
import pytest

import cmtof
from cmtof.baselines.region import linked, nearest, pool, region, whole_wraps
from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth, wrap_length
from cmtof.measurement import Measurement

WRAP = float(wrap_length(FREQUENCIES[0]))


def exact(depth, amplitude=1.0, **attributes):
    """Phases of known depths without noise."""
    depth = np.atleast_2d(np.asarray(depth, float))
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    size = np.broadcast_to(amplitude, phase.shape)
    return Measurement.from_phase(phase, FREQUENCIES, amplitude=size, depth=depth, **attributes)


def two_walls(jump, amplitude=1.0):
    """Two slanted walls side by side, the right one further by a jump, m."""
    x, y = np.meshgrid(np.arange(80), np.arange(60))
    return exact(2 + 0.0005 * x + 0.001 * y + np.where(x < 40, 0, jump), amplitude)


@pytest.mark.parametrize("jump", [0.4 * WRAP, 10.4 * WRAP, -20.3 * WRAP])
def test_walls_with_a_step_of_phase_are_exact(jump):
    m = two_walls(jump)
    estimate = region(m)
    inside = np.ones(m.shape, bool)
    inside[:, 30:50] = False  # where windows see both walls the slope is told less well
    assert np.abs(estimate.depth - m.depth)[inside].max() < 1e-9


def test_jump_of_whole_wraps_leaks_unless_the_amplitude_steps():
    """Both walls share an offset between the true ones: the reason why regions fail."""
    leaking = two_walls(20 * WRAP)
    error = np.abs(region(leaking).depth - leaking.depth)
    assert error[:, [5, -5]].max() > 5 * WRAP
    seen = two_walls(20 * WRAP, np.where(np.arange(80) < 40, 1000.0, 8000.0))
    error = np.abs(region(seen).depth - seen.depth)
    assert error[:, :36].max() < 1e-9
    assert error[:, 44:].max() < 1e-9


def test_a_region_has_one_offset_of_whole_wraps(rng):
    x = np.arange(100)
    clean = exact(np.broadcast_to(1 + 0.001 * x, (80, 100)))
    m = Measurement.from_phase(
        clean.phase + rng.normal(0, 0.05, clean.phase.shape), FREQUENCIES, depth=clean.depth
    )
    estimate = region(m)
    turns = estimate.depth / WRAP - m.phase[0] / (2 * np.pi)
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-6)
    off = estimate.depth - m.depth
    assert np.ptp(np.rint(off / WRAP)) == 0


def test_pooled_noise_is_that_of_the_sum(rng):
    noise, size = 0.2, 400
    phases = [
        pool(np.exp(1j * rng.normal(0, noise, (20, 20))), np.zeros((20, 20), int))
        for _ in range(300)
    ]
    spread = np.std([one.phase[0] for one in phases])
    assert spread == pytest.approx(noise / np.sqrt(size), rel=0.15)
    assert np.mean([one.spread[0] for one in phases]) == pytest.approx(spread, rel=0.15)


def test_links_are_those_of_a_flood_fill(rng):
    """Brute force: spread numbers over gentle neighbours until nothing changes."""
    inside = rng.random((9, 11)) > 0.2
    phase, bright = rng.normal(0, 1, (2, 9, 11))
    found = linked(inside, phase, bright, step=1.0, edge=1.5)
    names = np.arange(inside.size).reshape(inside.shape)
    for _ in range(inside.size):
        for y, x in np.ndindex(inside.shape):
            for v, u in ((y + 1, x), (y, x + 1)):
                if v < 9 and u < 11 and inside[y, x] and inside[v, u]:
                    steps = (phase[y, x] - phase[v, u], bright[y, x] - bright[v, u])
                    if abs(steps[0]) <= 1.0 and abs(steps[1]) <= 1.5:
                        names[y, x] = names[v, u] = min(names[y, x], names[v, u])
    same = found.ravel()[:, None] == found.ravel()
    np.testing.assert_array_equal(same, names.ravel()[:, None] == names.ravel())


def test_whole_wraps_keep_the_known_fraction():
    m = exact(np.full((1, 1), 2.0))
    beat = phase_from_depth(np.array([5.3 * WRAP]), 20e6)
    offset = whole_wraps(beat, np.array([1.0]), m, np.array([0.2 * WRAP]))
    np.testing.assert_allclose(offset, [5.2 * WRAP])


def test_nearest_is_the_pixel_itself_where_wanted():
    wanted = np.zeros((4, 6), bool)
    wanted[1, 2] = wanted[3, 5] = True
    row, column = nearest(wanted)
    assert (row[1, 2], column[1, 2]) == (1, 2)
    assert (row[0, 0], column[0, 0]) == (1, 2)
    row, column = nearest(np.zeros((2, 2), bool))
    assert row.tolist() == [[0, 0], [1, 1]]


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (7, 1), (2, 2)])
@pytest.mark.parametrize("amplitude", [0.0, 1.0])
@pytest.mark.parametrize("valid", [True, False])
def test_any_size_darkness_and_mask(shape, amplitude, valid):
    m = exact(np.full(shape, 1.0), amplitude, mask=np.full(shape, valid))
    estimate = region(m)
    assert estimate.depth.shape == shape
    assert np.isfinite(estimate.depth).all()
    assert ((estimate.confidence >= 0) & (estimate.confidence <= 1)).all()
    if valid and amplitude:
        assert np.abs(estimate.depth - 1.0).max() < 1e-9
    if not valid:
        assert not estimate.confidence.any()


def test_masked_pixels_that_are_not_finite_tell_nothing():
    depth, mask = np.full((30, 30), 2.5), np.ones((30, 30), bool)
    mask[10:14, 5:9] = False
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    phase[:, ~mask] = np.nan
    estimate = region(Measurement.from_phase(phase, FREQUENCIES, mask=mask))
    assert np.abs(estimate.depth - 2.5)[mask].max() < 1e-9
    assert np.isfinite(estimate.depth).all()


def test_multiples_are_refused():
    m = Measurement.from_phase(np.ones((2, 4, 4)), (7e9, 14e9))
    with pytest.raises(ValueError, match="no multiples"):
        cmtof.unwrap(m, method="region")
