"""Likelihood of a surface, its derivatives and its fit, against plain sums and exact planes."""

import numpy as np
from exact_scenes import (
    WRAP,
    exact_field,
    plane_depth,
    unit_rays,
    whole_boxes,
)
from numpy.testing import assert_allclose
from pytest import approx, fixture, mark

from cmtof.surfaces import fitting
from cmtof.surfaces.blocks import SIDE, Region, cell_likelihood, region_of_boxes
from cmtof.surfaces.field import pixels_of_cells
from cmtof.surfaces.fitting import (
    climb,
    evaluate_fit,
    fit_plane_or_bent,
    move_surface,
    refine,
)
from cmtof.surfaces.shapes import BENT, PLANE, depth_at

SHAPE = (64, 80)
CENTRED = (140.0, 138.0, 41.0, 31.5)
BOXES = whole_boxes(SHAPE)
WHOLE = region_of_boxes(BOXES)
NORMALS = [(0, 0, 1), (-0.3, 0.5, 1), (0.8, -0.6, 1)]


def plane(normal):
    return plane_depth(normal, shape=SHAPE, camera=CENTRED)


def field_of(depth, **more):
    return exact_field(depth, camera=CENTRED, **more)


@fixture
def steep(rng):
    """A plane in noise, its parameters and its field; pixels of a block have the same ray."""
    depth, q = plane(NORMALS[2])
    field = field_of(depth, information=2.0, noise_of=rng)
    u, v = (one[::SIDE].repeat(SIDE) for one in (field.u, field.v))
    cosine = pixels_of_cells(field.cosine[::SIDE, ::SIDE], SIDE)
    return q, field._replace(u=u, v=v, cosine=cosine)


def functions(field):
    """The six functions (6, H, W) of directions that a surface is a sum of."""
    u, v = np.broadcast_arrays(field.u, field.v[:, None])
    return np.stack([u, v, np.ones_like(u), u**2, u * v, v**2])


def depth_of(field, q):
    return 1 / (field.cosine * np.tensordot(q, functions(field), 1))


def likelihood(field, q, chosen=True):
    turn = field.wavenumber[:, None, None] * depth_of(field, q)
    return np.sum((field.phasor * np.exp(-1j * turn)).real, where=chosen)


def test_sums_are_those_of_the_likelihood(rng):
    depth, q = plane(NORMALS[1])
    field = field_of(depth, information=3.0, noise_of=rng)
    q[3:] = rng.normal(0, 1e-3, 3)
    got = evaluate_fit(field, WHOLE, q, BENT)
    assert got.likelihood == approx(likelihood(field, q), rel=1e-6)
    assert got.most == approx(field.information.sum(dtype=float), rel=1e-6)
    cells = [cell_likelihood(field, q, *cell) for cell in np.ndindex(8, 10)]
    assert sum(cells) == approx(got.likelihood, rel=1e-6)
    assert depth_at(field, q, 7, 11) == approx(depth_of(field, q)[7, 11])
    label = rng.integers(0, 3, SHAPE, np.int32)
    part = evaluate_fit(field, Region(BOXES, label, 1), q, PLANE)
    assert part.likelihood == approx(likelihood(field, q, label == 1), rel=1e-6)


def test_information_is_that_of_the_derivatives(steep):
    q, field = steep
    *_, found = fitting._moments(field, WHOLE, q)
    slopes = depth_of(field, q) ** 2 * field.cosine * functions(field)
    matrix = np.einsum(
        "iyx,fyx,f,jyx", slopes, field.information, field.wavenumber**2, slopes
    )
    assert_allclose(found[:6, :6], np.tril(matrix), rtol=1e-5, atol=1e-3)


def test_the_gradient_is_that_of_the_likelihood(steep, rng):
    q, field = steep
    q += rng.normal(0, 1e-4, BENT)
    _, gradient, found = fitting._moments(field, WHOLE, q)
    rises = [
        likelihood(field, q + step) - likelihood(field, q - step)
        for step in 1e-6 * np.eye(BENT)
    ]
    slope = np.array(rises) / 2e-6
    noise = np.sqrt(np.diag(found))
    assert (abs(gradient[:6] - slope) < 1e-4 * abs(slope) + 1e-3 * noise[:6]).all()


def misses(field, q, depth):
    """How far, m, a surface is from the truth at most, and how much it varies."""
    off = depth_of(field, q) - depth
    return abs(off).max(), off.std()


@mark.parametrize("normal", NORMALS[1:])
def test_fits_climb_back_to_a_tilted_plane(normal, rng):
    """Tilted by up to a seventh of a wrap, so that no phase is beyond a quarter turn."""
    depth, start = plane(normal)
    field = field_of(depth)
    tilt = rng.uniform(-1, 1, 3) / 21 * [3.6, 4.5, 1]
    start[:3] += tilt * WRAP / depth.max() ** 2
    assert misses(field, climb(field, WHOLE, start, PLANE, 8).q, depth)[0] < 1e-6


@mark.parametrize("wraps", [1, 5])
def test_fits_hop_over_whole_wraps(wraps):
    """As long as the moved plane is bent by less than half a wrap, which this one is."""
    depth, q = plane(NORMALS[1])
    field = field_of(depth)
    start, _ = move_surface(field, q, BOXES, PLANE, wraps * WRAP)
    assert (depth_of(field, start) - depth).mean() == approx(wraps * WRAP, rel=0.02)
    assert misses(field, refine(field, WHOLE, start, PLANE, 8).q, depth)[0] < 1e-6


@mark.parametrize("turns", [0, 1])  # a pixel that the start is off
@mark.parametrize("normal", NORMALS)
def test_planes_are_called_planes(normal, turns, rng):
    depth, q = plane(normal)
    field = field_of(depth, information=20.0, noise_of=rng)
    few = BOXES[abs(BOXES[:, [0, 2]] - (28, 36)).max(1) < 16]
    start = move_surface(field, q, few, BENT, 0.0, (0, turns))[0] if turns else q
    fit, *_ = fit_plane_or_bent(field, region_of_boxes(few), start, 6, 15.0, 1.0)
    assert not fit.q[3:].any()
    assert misses(field, fit.q, depth)[1] < 5e-4


@mark.parametrize("radius", [20.0, -40.0])
def test_balls_are_called_bent(radius, rng):
    """They sag by 13 and 6 mm over half the width, to and from the camera."""
    centre = 2.5 + radius
    along = unit_rays(SHAPE, CENTRED)[..., 2] * centre
    half = np.sqrt(along**2 - centre**2 + radius**2)
    depth = along - np.sign(radius) * half
    field = field_of(depth, information=20.0, noise_of=rng)
    facing = np.eye(BENT)[2] / 2.5
    fit, *_ = fit_plane_or_bent(field, WHOLE, facing, 8, 15.0, 1.0)
    assert fit.q[3:].any()
    assert misses(field, fit.q, depth)[1] < 1e-4


def test_the_offset_scatters_as_predicted(rng):
    """Sixty draws give a deviation to 9 % and a mean to 0.13 of it: three sigma each."""
    depth, q = plane_depth()
    whole = region_of_boxes(whole_boxes())
    found = []
    for _ in range(60):
        field = exact_field(depth, information=1.0, noise_of=rng)
        fit = climb(field, whole, q, PLANE, 8)
        found.append((fit.offset, fit.known))
    offset, known = np.transpose(found)
    deviation = 1 / np.sqrt(known.mean())
    assert offset.std() == approx(deviation, rel=0.28)
    assert abs(offset.mean()) < 3 * deviation / np.sqrt(60)
