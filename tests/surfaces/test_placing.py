"""Whole wraps of a surface by its beat and by its shape."""

import numpy as np
from exact_scenes import (
    SHAPE,
    WRAP,
    exact_field,
    known,
    meeting_planes,
    plane_depth,
    whole_boxes,
)
from numpy.testing import assert_allclose
from pytest import approx, mark

from cmtof.surfaces import placing
from cmtof.surfaces.field import CELL
from cmtof.surfaces.fitting import leaning, region_of_boxes
from cmtof.surfaces.roughness import cells_of_surfaces
from cmtof.surfaces.shapes import PLANE, moved

INNER = np.zeros(SHAPE, np.int32)
BOXES = whole_boxes(SHAPE)


def a_fit(offset, known, missed=0.0):
    return np.array([[offset, known, missed, 1e-3]])


def beats_of(field, q):
    depth = placing.depth_of_labels(field, INNER, q[None])
    return placing.pooled_beats(field, cells_of_surfaces(field, INNER, depth, 1))


def test_pooled_beats_scatter_as_the_sum_of_their_phasors():
    """Sixty draws: unbiased, a deviation to 9 %, and sqrt(1 + 4) over root of the information."""
    rng, found = np.random.default_rng(9), []
    depth, q = plane_depth((0.3, -0.2, 1), 2.5)
    for _ in range(60):
        field = exact_field(depth, information=10.0, noise_of=rng)
        found.append([part[0] for part in beats_of(field, q)])
    beat, noise, coherence = np.array(found).T
    assert abs(beat.mean()) < 3 * noise.mean() / np.sqrt(60)
    assert noise.mean() == approx(np.std(beat), rel=0.28)
    expected = np.sqrt(5 / (10.0 * SHAPE[0] * SHAPE[1])) / (2 * np.pi * 20 / 7150)
    # turning cells back by their own phasors takes some of the noise along
    assert noise.mean() == approx(expected, rel=0.05)
    assert (coherence > 0.95).all()


@mark.parametrize(("information", "side", "share"), [(10, CELL, 0), (100, 1, 1)])
def test_every_pixel_of_a_narrow_surface_counts_where_pixels_are_clear(
    information, side, share
):
    """Strips of three pixels that meet no middle of a cell."""
    depth = plane_depth((0.3, -0.2, 1), 2.5)[0]
    field = exact_field(depth, information=information)
    strips = np.where(np.arange(SHAPE[1]) % CELL < 3, INNER, -1)
    cells = cells_of_surfaces(field, strips, depth, 1, field.side)
    assert cells.side == side
    counted = field.information[:, strips >= 0].sum() * share
    assert cells.told.sum() == approx(counted)


def test_shape_and_beat_are_weighed_by_what_is_known_of_them():
    depth, q = plane_depth((0.2, 0.1, 1), 2.5)
    beats = beats_of(exact_field(depth), q)
    alone = placing.offsets(beats, q[None], a_fit(12.0, 1e6), shape=False)
    assert alone.mean[0] == approx(beats[0][0], abs=1e-9)
    sharp, bent = (
        placing.offsets(beats, q[None], a_fit(12.0, 1e6, m)) for m in (0, 1e-4)
    )
    assert abs(sharp.mean[0] - 12) < abs(beats[0][0] - 12)
    assert sharp.spread[0] < bent.spread[0] < alone.spread[0]


def test_the_roughness_of_a_surface_hardly_costs_its_beat_precision():
    """0.12 wraps a pixel: 0.75 rad, and twice that, which a pixel's two phases share."""
    rng, off = np.random.default_rng(3), []
    depth, q = plane_depth((0.3, -0.2, 1), 2.5)
    lifted, _ = moved(exact_field(depth), q, BOXES, PLANE, -11 * WRAP)
    for _ in range(12):
        uneven = depth + 0.12 * WRAP * rng.normal(size=SHAPE)
        field = exact_field(uneven, information=20.0, noise_of=rng)
        off.append([beats_of(field, one)[0][0] for one in (q, lifted)])
    smooth = np.sqrt(5 / (20.0 * SHAPE[0] * SHAPE[1])) / (2 * np.pi * 20 / 7150)
    assert (np.std(off, axis=0) < 2 * smooth).all()
    assert_allclose(np.mean(off, axis=0), [0, 11], atol=3 * smooth)


def test_two_planes_with_one_phase_are_cut_where_the_beat_steps(rng):
    depth, q = plane_depth((0.3, -0.2, 1), 2.5)
    depth = depth + 5 * WRAP * (np.arange(SHAPE[1]) >= 80)
    field = exact_field(depth, information=50.0, noise_of=rng)
    main, surfaces = placing.parted(field, INNER, q[None])
    right = np.mean((main > 0) == (np.arange(SHAPE[1] // 8) >= 10))
    assert len(surfaces) == 2 and max(right, 1 - right) > 0.97


def test_planes_at_right_angles_place_each_other():
    camera, found, fit = (400.0, 400.0, 81.0, 62.5), [], []
    for normal, off in (((2, 2, 1), 0), ((-2, 1, 2), 0), ((1, -2, 2), 2)):
        depth, q = plane_depth(normal, 1.5, camera=camera)
        field = exact_field(depth, camera=camera)
        found.append(moved(field, q, BOXES, PLANE, -off * WRAP)[0])
        fit.append(
            [
                0,
                1,
                0,
                1e-3,
                *leaning(field, region_of_boxes(BOXES), found[-1], 1.0).ravel(),
            ]
        )
    alone, label = known([0, 0, 0.6], [0.05, 0.05, 1.5]), np.repeat([0, 1, 2], 1000)
    sharp = placing.aligned(alone, np.array(found), np.array(fit), label)
    assert_allclose([*sharp.mean, sharp.spread[2]], [0, 0, 2, 0.05], atol=0.1)


def test_pixels_take_the_likeliest_surface():
    """Left one plane, right another that meets it, moved by three wraps."""
    field, surfaces = meeting_planes()
    owner = np.zeros((SHAPE[0] // 8, SHAPE[1] // 8), np.int64)
    owner[:, 10:] = 1
    label, share = placing.pixel_labels(field, owner, surfaces)
    assert np.mean(label == np.where(np.arange(SHAPE[1]) < 81, 0, 1)) > 0.97
    assert share.max() == approx(1, abs=0.05)
    assert (placing.interiors(label, share)[:, 78:84] == -1).all()
