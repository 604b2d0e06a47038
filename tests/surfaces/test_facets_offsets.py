"""Whole wraps of a surface, by its beat and by its shape."""

import numpy as np
import pytest
from facet_scenes import SHAPE, WRAP, exact_field, plane_depth, whole_boxes

from cmtof.surfaces.kernels import BENT, PLANE, moved
from cmtof.surfaces.offsets import fitted, offsets, pooled_beats

INNER = np.zeros(SHAPE, np.int32)
BOXES = whole_boxes(SHAPE)


def a_fit(offset, known, size=PLANE, missed=0.0, bend=1e-3):
    return np.array([[offset, known, size, missed, bend]])


@pytest.fixture(scope="module")
def drawn():
    """Beats of sixty noisy draws of a wide plane, pooled over its true surface."""
    rng = np.random.default_rng(9)
    depth, q = plane_depth((0.3, -0.2, 1), 2.5)
    found = []
    for _ in range(60):
        field = exact_field(depth, information=10.0, noise_of=rng)
        found.append([part[0] for part in pooled_beats(field, INNER, q[None])])
    return np.array(found).T


def test_pooled_beats_are_unbiased(drawn):
    beat, noise, _ = drawn
    assert abs(beat.mean()) < 3 * noise.mean() / np.sqrt(60)  # three sigma


def test_pooled_beats_scatter_as_they_say(drawn):
    """Sixty draws know a deviation to 9 %: three sigma."""
    beat, noise, _ = drawn
    assert noise.mean() == pytest.approx(np.std(beat), rel=0.28)


def test_noise_of_a_beat_is_that_of_the_sum(drawn):
    """sqrt(1 + 4) over root of the summed information, in turns of 2 pi (k_2 / k_1 - 2)."""
    expected = np.sqrt(5 / (10.0 * SHAPE[0] * SHAPE[1])) / (2 * np.pi * 20 / 7150)
    # turning cells back by their own phasors takes some of the noise along
    assert drawn[1].mean() == pytest.approx(expected, rel=0.05)
    assert (drawn[2] > 0.95).all()


@pytest.mark.parametrize("wraps", [3, -3, 1, 10, -12])
@pytest.mark.parametrize("normal", [(0, 0, 1), (0.3, -0.2, 1)])
def test_a_surface_that_is_off_is_found_to_lack_it(normal, wraps):
    depth, q = plane_depth(normal, 2.5)
    field = exact_field(depth)
    off = moved(field.arrays(), q, BOXES, BENT, wraps * WRAP)
    beat, _, coherence = pooled_beats(field, INNER, off[None])
    assert beat[0] == pytest.approx(-wraps, abs=0.1)
    assert coherence[0] > 0.9


def test_each_surface_has_its_own_beat():
    """Two surfaces side by side, one of them three wraps off."""
    depth, q = plane_depth((0.1, 0, 1), 2.5)
    field = exact_field(depth)
    inner = INNER.copy()
    inner[:, 80:] = 1
    off = moved(field.arrays(), q, BOXES, BENT, 3 * WRAP)
    beat, _, _ = pooled_beats(field, inner, np.stack([q, off]))
    np.testing.assert_allclose(beat, [0, -3], atol=0.1)


def test_a_small_curvature_leaves_the_beat_unbiased():
    """Cells are turned back by their own phasors before they are pooled."""
    depth, q = plane_depth((0, 0, 1), 2.5)
    y, x = np.indices(SHAPE)
    bumpy = depth + 0.2 * WRAP * np.sin(x / 15) * np.cos(y / 20)
    field = exact_field(bumpy, information=10.0)
    beat, _, coherence = pooled_beats(field, INNER, q[None])
    assert abs(beat[0]) < 0.3
    assert coherence[0] > 0.9


def test_dark_surfaces_know_nothing():
    depth, q = plane_depth((0, 0, 1), 2.5)
    field = exact_field(depth, information=0.0)
    found = offsets(field, INNER, q[None], np.zeros((1, 5)))
    assert np.isfinite(found.mean).all()
    assert found.spread[0] > 100


@pytest.mark.parametrize("number", [0, 2])
def test_a_surface_without_pixels_knows_nothing(number):
    depth, q = plane_depth((0, 0, 1), 2.5)
    label = np.full(SHAPE, number, np.int32)
    surfaces = np.stack([q, q, q])
    field = exact_field(depth)
    fitted_to, fit = fitted(field, label, surfaces)
    np.testing.assert_array_equal(fitted_to[1], q)
    found = offsets(field, label, fitted_to, fit)
    assert np.isfinite(found.mean).all()
    assert found.spread[1] > 100 * found.spread[number]


@pytest.mark.parametrize("said", [-5.0, 0.7, 12.0])
def test_without_shape_only_the_beat_counts(said):
    depth, q = plane_depth((0.2, 0.1, 1), 2.5)
    field = exact_field(depth)
    beat, _, _ = pooled_beats(field, INNER, q[None])
    alone = offsets(field, INNER, q[None], a_fit(said, 1e6), shape=False)
    assert alone.mean[0] == pytest.approx(beat[0], abs=1e-9)
    both = offsets(field, INNER, q[None], a_fit(said, 1e6), shape=True)
    assert abs(both.mean[0] - said) < abs(beat[0] - said)
    assert both.spread[0] < alone.spread[0]


def test_a_shape_counts_less_the_more_it_misses():
    depth, q = plane_depth((0.2, 0.1, 1), 2.5)
    field = exact_field(depth)
    spreads = [
        offsets(field, INNER, q[None], a_fit(0.0, 1e4, missed=m)).spread[0] for m in (0, 1e-4, 1e-2)
    ]
    assert spreads[0] < spreads[1] < spreads[2]


@pytest.mark.parametrize("wraps", [0, 5, -4])
def test_fitted_finds_the_plane_again(wraps):
    """A wide plane that is off by so few wraps is bent by less than half of one: fits hop back."""
    depth, q = plane_depth((0.2, 0.1, 1), 2.5)
    field = exact_field(depth)
    off = moved(field.arrays(), q, BOXES, PLANE, wraps * WRAP)
    found, fit = fitted(field, INNER, off[None])
    np.testing.assert_allclose(found[0], q, atol=1e-6)
    assert fit[0, 2] == PLANE
    assert abs(fit[0, 0]) < 1e-2
    known = offsets(field, INNER, found, fit)
    assert abs(known.mean[0]) < 0.1
