"""The simulator against Eq. 8, its protocols against their definitions."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal, assert_array_less
from pytest import approx, mark
from refusals import WRONG, refused
from walls import flat_wall, lit

from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth, wrap_count_from_depth
from cmtof.simulation import QUADRATURES, simulate


@mark.parametrize("psi", [QUADRATURES, [0.0, 2.0, 4.0], [0.1, 2.0, 3.3, 5.5, 1.0]])
def test_noise_free_correlations_are_equation_8(tilted_wall, psi):
    m = simulate(tilted_wall, noise_free=True, psi=psi)
    true = [phase_from_depth(tilted_wall.depth.astype(float), f) for f in FREQUENCIES]
    cosine = np.cos(np.stack(true)[:, None] + np.reshape(psi, (-1, 1, 1)))
    expected = 20_000 * tilted_wall.intensity * (0.5 + cosine / np.pi)
    assert_allclose(m.dataset.correlation, expected, atol=0.02)


def test_same_seed_same_counts_and_frames_draw_apart(tilted_wall):
    def drawn(**numbers):
        return simulate(tilted_wall, **numbers).dataset.correlation

    assert_array_equal(drawn(seed=1), drawn(seed=1))
    assert (drawn(seed=1) != drawn(seed=2)).mean() > 0.99
    assert (drawn(seed=1) != drawn(seed=1, frame_number=1)).mean() > 0.99


def test_noise_of_a_flat_wall_has_the_mean_and_variance_of_the_model():
    wall = flat_wall(200, 1.0, 0.5)
    mean = simulate(wall, noise_free=True).dataset.correlation[0, :, 0, 0]
    noisy = simulate(wall).dataset.correlation[0]
    variance = mean + 1200**2
    four_errors = 4 * np.sqrt(variance / wall.depth.size)
    pixels = ("y", "x")
    assert_array_less(abs(noisy.mean(pixels) - mean), four_errors)
    assert_allclose(noisy.var(pixels), variance, rtol=4 * np.sqrt(2 / wall.depth.size))


def test_released_protocol_shrinks_to_1195_mm_and_keeps_wraps_36_to_56(rng):
    m = simulate(lit(rng.uniform(1.0, 9.0, (100, 100))), noise_free=True)
    assert np.percentile(m.depth, 99.9) == approx(1.195, abs=1e-4)
    counts = wrap_count_from_depth(m.depth.astype(float), 7.15e9)
    # float32 storage may move a depth across a limit by a tenth of a micrometre
    assert ((counts >= 36) & (counts <= 56))[m.mask].mean() > 0.9999
    assert m.range == approx((0.754722, 1.194977), abs=1e-6)


def test_released_protocol_never_enlarges_and_stops_at_a_hundredth():
    assert simulate(flat_wall(4, 0.9), noise_free=True).depth == approx(0.9)
    with refused("Expected depths between"):
        simulate(flat_wall(4, 300.0), noise_free=True)


def test_full_protocol_scales_nothing_and_masks_beyond_the_beat():
    """Masked pixels keep their signal, unknown ones are dark; intensity is clipped to 1."""
    depth = np.array([[0.3, 7.49, 7.50, 20.0, np.nan]])
    m = simulate(lit(depth, 7.0), protocol="full", noise_free=True)
    assert m.mask.tolist() == [[True, True, False, False, False]]
    assert_allclose(m.depth[:, :4], depth[:, :4].astype(np.float32))
    assert_allclose(m.amplitude[0], [[6366.2] * 4 + [0.0]], rtol=1e-5)


@mark.parametrize("changes, message", WRONG["conditions"])
def test_impossible_conditions_are_refused(tilted_wall, changes, message):
    with refused(message):
        simulate(tilted_wall, **changes)


@mark.parametrize("scale, advice", [(1000, "in millimetres"), (1, "another protocol")])
def test_depths_in_millimetres_are_suspected(tilted_wall, scale, advice):
    frame = lit(scale * tilted_wall.depth)
    with refused(advice):
        simulate(frame, protocol="full", frequencies=[7.15e9])
