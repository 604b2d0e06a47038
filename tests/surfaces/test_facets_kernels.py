"""Likelihood of a surface, its derivatives and its fit, against plain sums and exact planes."""

import numpy as np
import pytest
from facet_scenes import CAMERA, NOTHING, WRAP, exact_field, plane_depth, unit_rays, whole_boxes
from hypothesis import given
from hypothesis import strategies as st

from cmtof.surfaces.kernels import (
    BENT,
    PLANE,
    _look,
    _rectangle,
    _turn,
    cell_likelihood,
    depth_at,
    moved,
    refine,
    select,
)

SHAPE = (64, 80)
CENTRED = (140.0, 138.0, 41.0, 31.5)
BOXES = whole_boxes(SHAPE)
NORMALS = [(0, 0, 1), (0.4, 0, 1), (-0.3, 0.5, 1), (0.8, -0.6, 1), (0, 1.2, 1)]


def plane(normal, z=2.5):
    return plane_depth(normal, z, SHAPE, CENTRED)


def field_of(depth, **more):
    return exact_field(depth, camera=CENTRED, **more)


def depth_of(field, q):
    """Depth (H, W) by the formula of the module."""
    u, v = field.u, field.v[:, None]
    bent = q[3] * u**2 + q[4] * u * v + q[5] * v**2
    return 1 / (field.cosine * (q[0] * u + q[1] * v + q[2] + bent))


def likelihood(field, q, only=slice(None)):
    p = field.real.astype(complex) + 1j * field.imaginary
    turned = p * np.exp(-1j * field.wavenumber[:, None, None] * depth_of(field, q))
    return turned.real[(slice(None), only)].sum() if only is not slice(None) else turned.real.sum()


@given(st.floats(-1e6, 1e6))
def test_turn_is_cosine_and_sine(turns):
    angle = 2 * np.pi * (turns - np.floor(turns))
    c, s = _turn(turns)
    assert abs(c - np.cos(angle)) < 1e-7
    assert abs(s - np.sin(angle)) < 1e-7


@pytest.mark.parametrize("quarter", np.arange(-9, 10) / 4)
def test_turn_has_no_seam(quarter):
    """Where the series change over, both sides agree."""
    below, above = _turn(quarter - 1e-12), _turn(quarter + 1e-12)
    np.testing.assert_allclose(below, above, atol=1e-7)


@pytest.mark.parametrize("normal", NORMALS)
def test_look_sums_the_likelihood(normal, rng):
    depth, q = plane(normal)
    field = field_of(depth, information=3.0, noise_of=rng)
    q[3:] = 1e-3 * rng.normal(size=3)
    got = _look(field.arrays(), NOTHING, -1, q, BOXES, BENT)
    assert got[0] == pytest.approx(likelihood(field, q), rel=1e-6)
    assert got[1] == pytest.approx(field.information.sum(dtype=float), rel=1e-6)
    cells = [cell_likelihood(field.arrays(), q, y, x) for y in range(8) for x in range(10)]
    assert sum(cells) == pytest.approx(got[0], rel=1e-6)


def test_look_counts_its_own_label_only(rng):
    depth, q = plane((0.2, 0.1, 1))
    field = field_of(depth, noise_of=rng)
    label = rng.integers(0, 3, SHAPE).astype(np.int32)
    parts = [_look(field.arrays(), label, n, q, BOXES, PLANE)[:2] for n in range(3)]
    whole = _look(field.arrays(), NOTHING, -1, q, BOXES, PLANE)[:2]
    np.testing.assert_allclose(np.sum(parts, axis=0), whole, rtol=1e-9)
    assert parts[1][0] == pytest.approx(likelihood(field, q, label == 1), rel=1e-6)


@pytest.mark.parametrize("normal", NORMALS)
@pytest.mark.parametrize("size", [PLANE, BENT])
def test_there_is_nothing_to_climb_at_the_truth(normal, size):
    depth, q = plane(normal)
    field = field_of(depth)
    likely, most, step, offset, _ = _look(field.arrays(), NOTHING, -1, q, BOXES, size)
    assert likely == pytest.approx(most, rel=1e-6)
    moved_by = depth_of(field, q + step) - depth_of(field, q)
    assert np.abs(moved_by).max() < 1e-7
    assert abs(offset) < 1e-3


@pytest.mark.parametrize("number", range(BENT))
@pytest.mark.parametrize("normal", NORMALS[1:4])
def test_gradient_is_that_of_finite_differences(normal, number, rng):
    depth, q = plane(normal)
    field = field_of(depth, information=2.0, noise_of=rng)
    q += 1e-4 * rng.normal(size=BENT)
    moments, ends = np.zeros(52), []
    for box in BOXES:
        _rectangle(field.arrays(), NOTHING, -1, q, box, moments)
    for way in (1, -1):
        there = q.copy()
        there[number] += way * 1e-6
        ends.append(likelihood(field, there))
    slope = (ends[0] - ends[1]) / 2e-6
    scale = np.sqrt(moments[16 + 7 * number])  # what its noise is
    assert moments[4 + number] == pytest.approx(slope, rel=1e-4, abs=1e-3 * scale)


def test_information_matrix_is_that_of_the_derivatives(rng):
    depth, q = plane((0.3, -0.2, 1))
    field = field_of(depth, information=2.0)
    moments = np.zeros(52)
    for box in BOXES:
        _rectangle(field.arrays(), NOTHING, -1, q, box, moments)
    u, v = np.broadcast_to(field.u, SHAPE), np.broadcast_to(field.v[:, None], SHAPE)
    basis = np.stack([u, v, np.ones(SHAPE), u * u, u * v, v * v])
    slopes = -(depth**2) * field.cosine * basis
    k = field.wavenumber[:, None, None]
    expected = np.einsum("iyx,jyx,yx->ij", slopes, slopes, (field.information * k**2).sum(axis=0))
    np.testing.assert_allclose(
        np.tril(moments[16:].reshape(6, 6)), np.tril(expected), rtol=1e-6, atol=1e-3
    )


@pytest.mark.parametrize("wraps", [-20, -3, 0, 1, 7])
@pytest.mark.parametrize("normal", NORMALS[:4])
def test_a_plane_is_moved_by_a_distance(normal, wraps):
    """No plane is exactly that far off along all rays; the nearest one is on average."""
    depth, q = plane(normal)
    field = field_of(depth)
    got = moved(field.arrays(), q, BOXES, PLANE, wraps * WRAP)
    assert not got[3:].any()
    change = depth_of(field, got) - depth
    assert change.mean() == pytest.approx(wraps * WRAP, rel=0.01, abs=1e-6)
    # it misses by far less than it moves
    assert np.std(change) < 0.05 * abs(wraps) * WRAP + 1e-6
    bent = depth_of(field, moved(field.arrays(), q, BOXES, BENT, wraps * WRAP)) - depth
    assert np.std(bent) <= np.std(change) + 1e-6


@pytest.mark.parametrize("normal", NORMALS)
@pytest.mark.parametrize("seed", range(4))
def test_refine_climbs_back(normal, seed):
    depth, q = plane(normal)
    field, rng = field_of(depth), np.random.default_rng(seed)
    # tilted by up to a seventh of a wrap, so that no phase is beyond a quarter turn
    off = rng.uniform(-1, 1, 3) / 3 * np.array([1 / 0.28, 1 / 0.22, 1]) / depth.max() ** 2
    start = q.copy()
    start[:3] += off * WRAP / 7
    got = refine(field.arrays(), NOTHING, -1, start, BOXES, PLANE, 8, 0)
    assert np.abs(depth_of(field, start) - depth).max() > 10e-6
    assert np.abs(depth_of(field, got[0]) - depth).max() < 1e-6
    assert got[1] == pytest.approx(got[2], rel=1e-6)


@pytest.mark.parametrize("normal", NORMALS[:3])
@pytest.mark.parametrize("wraps", [7, -7, 1, -12])
def test_refine_hops_over_whole_wraps(normal, wraps):
    """As long as the moved plane is bent by less than half a wrap, which these are."""
    depth, q = plane(normal)
    field = field_of(depth)
    start = moved(field.arrays(), q, BOXES, PLANE, wraps * WRAP)
    got = refine(field.arrays(), NOTHING, -1, start, BOXES, PLANE, 8, 60)
    assert np.abs(depth_of(field, got[0]) - depth).max() < 1e-6
    assert abs(got[3]) < 1e-3


def test_refine_without_hops_stays_on_its_wrap():
    depth, q = plane((0.2, 0, 1))
    field = field_of(depth)
    start = moved(field.arrays(), q, BOXES, PLANE, 3 * WRAP)
    got = refine(field.arrays(), NOTHING, -1, start, BOXES, PLANE, 8, 0)
    assert np.mean(depth_of(field, got[0]) - depth) == pytest.approx(3 * WRAP, abs=0.1 * WRAP)
    assert got[3] == pytest.approx(-3, abs=0.1)


@pytest.mark.parametrize("normal", NORMALS)
def test_a_plane_is_called_a_plane(normal, rng):
    depth, q = plane(normal)
    field = field_of(depth, information=20.0, noise_of=rng)
    got = select(field.arrays(), NOTHING, -1, q, BOXES, 6, 60, 15.0, 5e-5, 1.0)
    assert got[5] == PLANE
    assert got[6] < 2e-4


@pytest.mark.parametrize("radius", [20.0, 40.0, -20.0, -40.0])
def test_a_ball_is_called_bent(radius, rng):
    """Sag over half the width: 13 mm and 6 mm, to and from the camera."""
    centre = 2.5 + radius
    along = unit_rays(SHAPE, CENTRED)[..., 2] * centre
    depth = along - np.sign(radius) * np.sqrt(along**2 - centre**2 + radius**2)
    field = field_of(depth, information=20.0, noise_of=rng)
    q = np.zeros(BENT)
    q[2] = 1 / 2.5
    got = select(field.arrays(), NOTHING, -1, q, BOXES, 8, 60, 15.0, 5e-5, 1.0)
    assert got[5] == BENT
    assert np.std(depth_of(field, got[0]) - depth) < 1e-4
    assert got[6] > 1e-4


@pytest.mark.parametrize("information", [1.0, 10.0])
def test_the_offset_scatters_as_it_says(information):
    """Sixty draws know a deviation to 9 % and a mean to 0.13 of it: three sigma each."""
    depth, q = plane_depth((0.3, -0.2, 1), 2.5)
    boxes = whole_boxes(depth.shape)
    rng, found = np.random.default_rng(8), []
    for _ in range(60):
        field = exact_field(depth, information=information, noise_of=rng, camera=CAMERA)
        got = refine(field.arrays(), NOTHING, -1, q, boxes, PLANE, 8, 0)
        found.append((got[3], got[4]))
    offset, known = np.array(found).T
    deviation = 1 / np.sqrt(known.mean())
    assert np.std(offset) == pytest.approx(deviation, rel=0.28)
    assert abs(offset.mean()) < 3 * deviation / np.sqrt(60)


def test_depth_at_a_pixel_is_the_formula(rng):
    depth, q = plane((0.3, 0.1, 1))
    field = field_of(depth)
    q[3:] = 0.01 * rng.normal(size=3)
    wanted = depth_of(field, q)
    for y, x in rng.integers(0, 64, (30, 2)):
        assert depth_at(field.arrays(), q, y, x) == pytest.approx(wanted[y, x], rel=1e-9)
