"""Whole wraps of a surface by its beat and by its shape."""

import numpy as np
from exact_scenes import (
    CELLS,
    COLUMNS,
    SHAPE,
    SIDES,
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
from cmtof.surfaces.beats import pooled_beats
from cmtof.surfaces.blocks import region_of_boxes
from cmtof.surfaces.field import CELL
from cmtof.surfaces.fitting import change_by_a_wrap, move_surface
from cmtof.surfaces.roughness import cells_of_surfaces
from cmtof.surfaces.shapes import PLANE

INNER = np.zeros(SHAPE, np.int32)
BOXES = whole_boxes()
EXCESS = 20 / 7150  # turns of the beat a wrap


def a_fit(missed=0.0):
    """Fit of a surface that is twelve wraps off and well known."""
    return np.array([[12.0, 1e6, missed, 1e-3]])


def beats_of(field, q):
    return pooled_beats(field, cells_of_surfaces(field, INNER, q[None]))


def beat_noise(information):
    """Of the sum over an image, wraps: sqrt(1 + 4) over the root of its information."""
    return np.sqrt(5 / information / INNER.size) / (2 * np.pi * EXCESS)


def test_pooled_beats_scatter_as_the_sum_of_their_phasors(rng):
    """Sixty draws: unbiased, and a deviation to 9 %."""
    depth, q = plane_depth()
    found = []
    for _ in range(60):
        field = exact_field(depth, information=10.0, noise_of=rng)
        found.append(np.squeeze(beats_of(field, q)))
    beat, noise, coherence = np.transpose(found)
    predicted = noise.mean()
    assert abs(beat.mean()) < 3 * predicted / np.sqrt(60)
    assert predicted == approx(beat.std(), rel=0.28)
    # turning cells back by their own phasors takes some of the noise along
    assert predicted == approx(beat_noise(10.0), rel=0.05)
    assert coherence.min() > 0.95


def test_pixels_with_the_beat_of_another_surface_hardly_count(rng):
    """One in ten is mixed with a wall 14 wraps behind; together they would move it by 1.4."""
    depth, q = plane_depth()
    field = exact_field(depth, information=5000.0, noise_of=rng)
    field.phasor[1, rng.random(SHAPE) < 0.1] *= np.exp(2j * np.pi * EXCESS * 14)
    beat, noise, _ = pooled_beats(
        field, cells_of_surfaces(field, INNER, q[None], side=1)
    )
    assert abs(beat) < 0.3 and noise < 0.05


@mark.parametrize("information, side, share", [(10, CELL, 0), (100, 1, 1)])
def test_every_pixel_of_a_narrow_surface_counts_where_pixels_are_clear(
    information, side, share
):
    """Strips of three pixels that meet no middle of a cell."""
    depth, q = plane_depth()
    field = exact_field(depth, information=information)
    strips = np.where(COLUMNS % CELL < 3, INNER, -1)
    cells = cells_of_surfaces(field, strips, q[None], field.side)
    assert cells.side == side
    counted = field.information[:, strips >= 0].sum() * share
    assert cells.information.sum() == approx(counted)


def test_shape_and_beat_are_weighed_by_what_is_known_of_them():
    depth, q = plane_depth((0.2, 0.1, 1))
    beats = beats_of(exact_field(depth), q)
    by_beat = beats[0][0]
    sharp = placing.offsets(beats, q[None], a_fit())
    bent = placing.offsets(beats, q[None], a_fit(missed=1e-4))
    alone = placing.offsets(beats, q[None], a_fit(), shape=False)
    assert alone.mean[0] == approx(by_beat, abs=1e-9)
    assert abs(sharp.mean[0] - 12) < abs(by_beat - 12)
    assert sharp.spread[0] < bent.spread[0] < alone.spread[0]


def test_the_roughness_of_a_surface_hardly_costs_its_beat_precision(rng):
    """0.12 wraps a pixel: 0.75 rad, and twice that, which a pixel's two phases share."""
    depth, q = plane_depth()
    lifted, _ = move_surface(exact_field(depth), q, BOXES, PLANE, -11 * WRAP)
    found = []
    for _ in range(12):
        uneven = depth + 0.12 * WRAP * rng.normal(size=SHAPE)
        field = exact_field(uneven, information=20.0, noise_of=rng)
        found.append([beats_of(field, one)[0][0] for one in (q, lifted)])
    smooth = beat_noise(20.0)
    assert np.std(found, axis=0).max() < 2 * smooth
    assert_allclose(np.mean(found, axis=0), [0, 11], atol=3 * smooth)


def test_planes_at_right_angles_place_each_other():
    camera = (400.0, 400.0, 81.0, 62.5)
    found = []
    fits = []
    for normal, off in (((2, 2, 1), 0), ((-2, 1, 2), 0), ((1, -2, 2), 2)):
        depth, q = plane_depth(normal, 1.5, camera=camera)
        field = exact_field(depth, camera=camera)
        aside, _ = move_surface(field, q, BOXES, PLANE, -off * WRAP)
        lean = change_by_a_wrap(field, region_of_boxes(BOXES), aside, 1.0)
        found.append(aside)
        fits.append([0, 1, 0, 1e-3, *lean.ravel()])
    alone = known([0, 0, 0.6], [0.05, 0.05, 1.5])
    label = np.repeat([0, 1, 2], 1000)
    sharp = placing.use_axes(alone, np.array(found), np.array(fits), label)
    assert_allclose(sharp.mean, [0, 0, 2], atol=0.1)
    assert sharp.spread[2] == approx(0.05, abs=0.1)


def test_pixels_take_the_likeliest_surface():
    """Left one plane, right another that meets it, moved by three wraps."""
    field, surfaces = meeting_planes()
    owner = np.zeros(CELLS, np.int64)
    owner[:, 10:] = 1
    label, share, inner = placing.pixel_labels(field, owner, surfaces)
    assert (label == SIDES).mean() > 0.97
    assert share.max() == approx(1, abs=0.05)
    assert (inner[:, 78:84] == -1).all()
