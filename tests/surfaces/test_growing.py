"""Information of pixels, slopes from spectra, planes in windows, growth over a furnished corner."""

from itertools import product

import numpy as np
from exact_scenes import (
    SHAPE,
    WRAP,
    corner_scene,
    exact_field,
    plane_depth,
)
from pytest import mark
from skimage.util import view_as_blocks

from cmtof.correlation import TAU, centred
from cmtof.surfaces.field import CELL
from cmtof.surfaces.growing import grown_surfaces
from cmtof.surfaces.shapes import depth_of_labels
from cmtof.surfaces.windows import WINDOWS, plane_in_window, spectral_slopes


def test_slopes_are_those_of_a_ramp(rng):
    """To a bin, but for whole turns a pixel, in noise as well."""
    y, x = np.indices((64, 64))
    for down, right in [(0, 0), (0.31, -0.82), (-7.0, 1.0)]:
        depth = 2.0 + (down * y + right * x) * WRAP / TAU
        field = exact_field(depth, information=20.0, noise_of=rng)
        for *_, core, finer in WINDOWS:
            found = spectral_slopes(
                field, np.array([0, 20]), np.array([3, 17]), core, finer
            )
            for got, true in zip(found, (down, right), strict=True):
                assert abs(centred(got - true)).max() <= 1.01 * TAU / (finer * core)


@mark.parametrize("turns", [0.0, -0.6])
def test_planes_are_found_though_their_phase_turns_more_than_half_a_turn_a_pixel(
    turns, rng
):
    """Such a slope is an alias at the lower frequency; at full light the beat decides."""
    depth, _ = plane_depth((-turns * WRAP * 140 / 2.5, 0.02, 1))
    right = 0
    for y, x in product((54, 62, 70), (73, 81, 89)):
        field = exact_field(depth, information=56.0, noise_of=rng)
        q, share = plane_about(field, y, x)
        found = depth_of_labels(field, np.zeros(SHAPE, int), q[None])
        slopes = [d[y, x + 1] - d[y, x] for d in (found, depth)]
        right += share > 0.9 and abs(slopes[0] - slopes[1]) < 0.02 * WRAP
    assert right >= 6  # of nine; by chance one of 25 aliases is


def plane_about(field, y, x):
    """The likeliest plane in a window of 16 px about a pixel, and its share S / E."""
    top = y - 8
    left = x - 8
    slopes = spectral_slopes(field, *np.array([[top + 2], [left + 2]]), 12, 4)
    told = field.information[:, top : top + 16, left : left + 16].sum(dtype=float)
    q, likely = plane_in_window(field, (top, left, 16, *slopes[:, 0]), told)
    return q, likely / told


def test_the_corner_has_a_surface_for_each_of_its_parts():
    """Cells within one part belong to one large surface that hardly any other part shares."""
    corner = corner_scene()
    owner, _ = grown_surfaces(exact_field(corner.frame.depth))
    part = view_as_blocks(corner.part, (CELL, CELL))
    pure = np.ptp(part, axis=(2, 3)) == 0
    number = part[..., 0, 0]
    for one in range(6):
        own = owner[pure & (number == one)]
        counts = np.bincount(own[own >= 0])
        assert counts.max() > 0.7 * own.size
        assert (number[pure & (owner == counts.argmax())] != one).mean() < 0.05
