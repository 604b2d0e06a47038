"""Whole wraps of a surface by its beat, by its shape as far as it is even, and by axes."""

import numpy as np
import pytest
from exact_scenes import (
    NOTHING,
    SHAPE,
    WRAP,
    exact_field,
    fitted_surfaces,
    plane_depth,
    whole_boxes,
)

from cmtof.surfaces.beats import cells_of_surfaces, pooled_beats
from cmtof.surfaces.fitting import PLANE, leaning, moved, sum_blocks
from cmtof.surfaces.offsets import Offsets, Unevenness, aligned, offsets, unevenness

INNER = np.zeros(SHAPE, np.int32)
BOXES = whole_boxes(SHAPE)
EVEN = Unevenness(np.ones(1), np.zeros(1))


def test_shape_and_beat_are_weighed_by_what_is_known_of_them():
    depth, q = plane_depth((0.2, 0.1, 1), 2.5)
    field = exact_field(depth)
    cells = cells_of_surfaces(field, INNER, fitted_surfaces(q[None]))
    beat = pooled_beats(field, cells, 1).offset[0]

    def offset_of(missed=0.0, uneven=EVEN, shape=True):
        surface = fitted_surfaces(q[None], 12.0, 1e6, missed)
        return offsets(field, cells, surface, uneven, shape=shape)

    alone, sharp, bent = offset_of(shape=False), offset_of(), offset_of(1e-4)
    wavy = offset_of(uneven=Unevenness(np.ones(1), np.full(1, 1e-3)))
    assert alone.mean[0] == pytest.approx(beat, abs=1e-9)
    assert abs(sharp.mean[0] - 12) < abs(beat - 12)
    assert sharp.spread[0] < bent.spread[0] < wavy.spread[0] < alone.spread[0]


@pytest.mark.parametrize("amplitude", [0.0, 0.02, 0.1])
def test_the_unevenness_of_a_wall_is_measured_on_its_residuals(amplitude, rng):
    """Waves of 30 px: an rms of amplitude over root of two; without them that of their noise."""
    depth, q = plane_depth((0.2, 0.1, 1), 2.5)
    waves = np.sin(2 * np.pi / 30 * np.arange(SHAPE[1]))
    field = exact_field(depth + amplitude * WRAP * waves, information=10.0, noise_of=rng)
    cells = cells_of_surfaces(field, INNER, fitted_surfaces(q[None]))
    found = unevenness(field, cells, 1)
    assert found.scale[0] == pytest.approx(amplitude * WRAP / np.sqrt(2), rel=0.3, abs=2e-5)
    assert found.inflation[0] < 2 if amplitude == 0 else found.inflation[0] > 10


def test_planes_at_right_angles_place_each_other():
    camera, found, turns, noise = (400.0, 400.0, 81.0, 62.5), [], [], []
    for normal, off in (((2, 2, 1), 0), ((-2, 1, 2), 0), ((1, -2, 2), 2)):
        depth, q = plane_depth(normal, 1.5, camera=camera)
        field = exact_field(depth, camera=camera).arrays()
        rows = sum_blocks(field, NOTHING, -1, q, BOXES)
        found.append(moved(field, q, rows, PLANE, -off * WRAP)[0])
        lean = leaning(field, sum_blocks(field, NOTHING, -1, found[-1], BOXES), found[-1])
        turns.append(lean[0])
        noise.append(lean[1:])
    surfaces = fitted_surfaces(found)._replace(turn=np.array(turns), covariance=np.array(noise))
    alone = Offsets(np.array([0, 0, 0.6]), np.array([0.05, 0.05, 1.5]))
    label = np.repeat([0, 1, 2], 1000)
    sharp = aligned(alone, surfaces, Unevenness(np.ones(3), np.zeros(3)), label)
    np.testing.assert_allclose([*sharp.mean, sharp.spread[2]], [0, 0, 2, 0.05], atol=0.1)
    uneven = aligned(alone, surfaces, Unevenness(np.ones(3), np.full(3, 1e-3)), label)
    assert uneven.spread[2] > 1
