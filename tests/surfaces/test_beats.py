"""Beats of surfaces, pooled over cells, and the steps where these are cut."""

import numpy as np
import pytest
from exact_scenes import SHAPE, WRAP, exact_field, fitted_surfaces, plane_depth

from cmtof.surfaces.beats import cells_of_surfaces, cut_where_beats_step, pooled_beats

INNER = np.zeros(SHAPE, np.int32)


def beats_of(depth, q, *, roughness=0.0, information=10.0, rng=None):
    """Beat of one surface over a whole image: offset, noise, coherence."""
    field = exact_field(depth, information=information, noise_of=rng)
    cells = cells_of_surfaces(field, INNER, fitted_surfaces(q[None], roughness=roughness))
    return [part[0] for part in pooled_beats(field, cells, 1)]


def test_pooled_beats_scatter_as_the_sum_of_their_phasors():
    """Sixty draws: unbiased, a deviation to 9 %, and sqrt(1 + 4) over root of the information."""
    rng = np.random.default_rng(9)
    depth, q = plane_depth((0.3, -0.2, 1), 2.5)
    beat, noise, coherence = np.array([beats_of(depth, q, rng=rng) for _ in range(60)]).T
    assert abs(beat.mean()) < 3 * noise.mean() / np.sqrt(60)
    assert noise.mean() == pytest.approx(np.std(beat), rel=0.28)
    expected = np.sqrt(5 / (10.0 * SHAPE[0] * SHAPE[1])) / (2 * np.pi * 20 / 7150)
    # turning cells back by their own phasors takes some of the noise along
    assert noise.mean() == pytest.approx(expected, rel=0.05)
    assert (coherence > 0.95).all()


def test_the_roughness_of_a_surface_hardly_costs_its_beat_precision():
    """0.12 wraps a pixel: 0.75 rad, and twice that, which a pixel's two phases share."""
    rng = np.random.default_rng(3)
    depth, q = plane_depth((0.3, -0.2, 1), 2.5)
    rough, off = 0.12 * 2 * np.pi, []
    for _ in range(20):
        uneven = depth + 0.12 * WRAP * rng.normal(size=SHAPE)
        given = beats_of(uneven, q, roughness=rough**2, information=20.0, rng=rng)
        blind = beats_of(uneven, q, information=20.0, rng=rng)
        off.append([given[0], blind[0]])
    given, blind = np.std(off, axis=0)
    smooth = np.sqrt(5 / (20.0 * SHAPE[0] * SHAPE[1])) / (2 * np.pi * 20 / 7150)
    assert given < 2 * smooth and given < 0.5 * blind


def test_two_planes_with_one_phase_are_cut_where_the_beat_steps(rng):
    depth, q = plane_depth((0.3, -0.2, 1), 2.5)
    depth = depth + 5 * WRAP * (np.arange(SHAPE[1]) >= 80)
    field = exact_field(depth, information=50.0, noise_of=rng)
    cells = cells_of_surfaces(field, INNER, fitted_surfaces(q[None]))
    main, surfaces = cut_where_beats_step(field, cells, q[None])
    right = np.mean((main > 0) == (np.arange(SHAPE[1] // 8) >= 10))
    assert len(surfaces) == 2 and max(right, 1 - right) > 0.97
