"""Pixels take the likeliest surface, and borders of these find whole wraps."""

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

from cmtof.surfaces.fitting import BENT, moved, sum_blocks
from cmtof.surfaces.labels import interiors, pixel_labels
from cmtof.surfaces.ties import borders


def test_pixels_take_the_likeliest_surface_and_borders_find_whole_wraps():
    """Left one plane, right another that meets it, moved by three wraps."""
    one, q = plane_depth((0.3, 0, 1), 2.5)
    other, p = plane_depth((-0.3, 0, 1), 2.5)
    depth = np.maximum(one, other)  # they meet at the optical axis
    field = exact_field(depth)
    rows = sum_blocks(field.arrays(), NOTHING, -1, p, whole_boxes(SHAPE))
    off, _ = moved(field.arrays(), p, rows, BENT, 3 * WRAP)
    owner = np.zeros((SHAPE[0] // 8, SHAPE[1] // 8), np.int64)
    owner[:, 10:] = 1
    first, second = (q, off) if one[0, 0] > other[0, 0] else (off, q)
    surfaces = fitted_surfaces([first, second])
    label, share = pixel_labels(field, owner, surfaces)
    truth = np.where(np.arange(SHAPE[1]) < 81, 0, 1)
    assert np.mean(label == truth) > 0.97
    assert share.max() == pytest.approx(1, abs=0.05)
    assert (interiors(label, share)[:, 78:84] == -1).all()
    found = borders(field, label, surfaces.parameters)
    assert (found.first.tolist(), found.second.tolist()) == ([0], [1])
    assert abs(found.step[0]) == 3
    assert found.odds[0] > 0.5
