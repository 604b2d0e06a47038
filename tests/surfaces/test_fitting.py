"""Likelihood of a surface, its derivatives and its fit, against plain sums and exact planes."""

import numpy as np
from exact_scenes import (
    CAMERA,
    WRAP,
    exact_field,
    plane_depth,
    unit_rays,
    whole_boxes,
)
from numpy.testing import assert_allclose
from pytest import approx, mark

from cmtof.surfaces import fitting
from cmtof.surfaces.fitting import (
    Region,
    cell_likelihood,
    look,
    refine,
    region_of_boxes,
    select,
)
from cmtof.surfaces.shapes import BENT, PLANE, depth_at, moved

SHAPE = (64, 80)
CENTRED = (140.0, 138.0, 41.0, 31.5)
BOXES = whole_boxes(SHAPE)
WHOLE = region_of_boxes(BOXES)
NORMALS = [(0, 0, 1), (-0.3, 0.5, 1), (0.8, -0.6, 1)]


def plane(normal, z=2.5):
    return plane_depth(normal, z, SHAPE, CENTRED)


def field_of(depth, **more):
    return exact_field(depth, camera=CENTRED, **more)


def depth_of(field, q):
    u, v = field.u, field.v[:, None]
    bent = q[3] * u**2 + q[4] * u * v + q[5] * v**2
    return 1 / (field.cosine * (q[0] * u + q[1] * v + q[2] + bent))


def likelihood(field, q, chosen=True):
    p = field.real.astype(complex) + 1j * field.imaginary
    turned = p * np.exp(-1j * field.wavenumber[:, None, None] * depth_of(field, q))
    return np.where(chosen, turned.real, 0).sum()


def test_sums_are_those_of_the_likelihood(rng):
    depth, q = plane(NORMALS[1])
    field = field_of(depth, information=3.0, noise_of=rng)
    q[3:] = 1e-3 * rng.normal(size=3)
    got = look(field, WHOLE, q, BENT)
    assert got.likelihood == approx(likelihood(field, q), rel=1e-6)
    assert got.most == approx(field.information.sum(dtype=float), rel=1e-6)
    cells = [cell_likelihood(field, q, y, x) for y in range(8) for x in range(10)]
    assert sum(cells) == approx(got.likelihood, rel=1e-6)
    label = rng.integers(0, 3, SHAPE).astype(np.int32)
    part = look(field, Region(BOXES, label, 1), q, PLANE)
    assert part.likelihood == approx(likelihood(field, q, label == 1), rel=1e-6)
    assert depth_at(field, q, 7, 11) == approx(depth_of(field, q)[7, 11])


def test_information_is_that_of_the_derivatives():
    depth, q = plane(NORMALS[2])
    field = field_of(depth, information=2.0)
    *_, found = fitting._moments(field, WHOLE, q)
    u, v = np.broadcast_to(field.u, SHAPE), np.broadcast_to(field.v[:, None], SHAPE)
    slopes = -(depth**2) * field.cosine * [u, v, np.ones(SHAPE), u * u, u * v, v * v]
    k = field.wavenumber[:, None, None]
    matrix = np.einsum(
        "iyx,jyx,yx->ij", slopes, slopes, (field.information * k**2).sum(axis=0)
    )
    assert_allclose(found, np.tril(matrix), rtol=1e-5, atol=1e-3)


def test_the_gradient_is_that_of_the_likelihood(rng):
    depth, q = plane(NORMALS[2])
    field = field_of(depth, information=2.0, noise_of=rng)
    q += 1e-4 * rng.normal(size=BENT)
    _, gradient, _, found = fitting._moments(field, WHOLE, q)
    for number in range(BENT):
        ahead, behind = q.copy(), q.copy()
        ahead[number], behind[number] = q[number] + 1e-6, q[number] - 1e-6
        slope = (likelihood(field, ahead) - likelihood(field, behind)) / 2e-6
        noise = np.sqrt(found[number, number])
        assert gradient[number] == approx(slope, rel=1e-4, abs=1e-3 * noise)


@mark.parametrize("normal", NORMALS[1:])
def test_fits_climb_back_and_hop_over_whole_wraps(normal, rng):
    """As long as the moved plane is bent by less than half a wrap, which these are."""
    depth, q = plane(normal)
    field = field_of(depth)
    # tilted by up to a seventh of a wrap, so that no phase is beyond a quarter turn
    start = q.copy()
    start[:3] += (
        rng.uniform(-1, 1, 3) / 21 * WRAP * np.array([3.6, 4.5, 1]) / depth.max() ** 2
    )
    got = refine(field, WHOLE, start, PLANE, 8, 0)
    assert np.abs(depth_of(field, got.q) - depth).max() < 1e-6
    for wraps in (1, 5) if normal[0] < 0.5 else ():
        start, _ = moved(field, q, BOXES, PLANE, wraps * WRAP)
        assert np.mean(depth_of(field, start) - depth) == approx(wraps * WRAP, rel=0.02)
        got = refine(field, WHOLE, start, PLANE, 8)
        assert np.abs(depth_of(field, got.q) - depth).max() < 1e-6


def test_planes_are_called_planes_and_balls_bent(rng):
    for normal in NORMALS:
        depth, q = plane(normal)
        field = field_of(depth, information=20.0, noise_of=rng)
        few = BOXES[(abs(BOXES[:, [0, 2]] - (28, 36)) < 16).all(axis=1)]
        for start in (
            q,
            moved(field, q, few, BENT, 0.0, 0, 1)[0],
        ):  # a turn per pixel off
            found = select(field, region_of_boxes(few), start, 6, 15.0, 1.0)[0].q
            assert not found[3:].any() and np.std(depth_of(field, found) - depth) < 5e-4
    for radius in (
        20.0,
        -40.0,
    ):  # sag over half the width: 13 mm and 6 mm, to and from the camera
        along = unit_rays(SHAPE, CENTRED)[..., 2] * (2.5 + radius)
        depth = along - np.sign(radius) * np.sqrt(
            along**2 - (2.5 + radius) ** 2 + radius**2
        )
        field = field_of(depth, information=20.0, noise_of=rng)
        found = select(field, WHOLE, np.eye(6)[2] / 2.5, 8, 15.0, 1.0)[0].q
        assert found[3:].any() and np.std(depth_of(field, found) - depth) < 1e-4


def test_the_offset_scatters_as_predicted():
    """Sixty draws give a deviation to 9 % and a mean to 0.13 of it: three sigma each."""
    depth, q = plane_depth((0.3, -0.2, 1), 2.5)
    boxes = whole_boxes(depth.shape)
    rng, found = np.random.default_rng(8), []
    for _ in range(60):
        field = exact_field(depth, information=1.0, noise_of=rng, camera=CAMERA)
        fit = refine(field, region_of_boxes(boxes), q, PLANE, 8, 0)
        found.append((fit.offset, fit.known))
    offset, known = np.array(found).T
    deviation = 1 / np.sqrt(known.mean())
    assert np.std(offset) == approx(deviation, rel=0.28)
    assert abs(offset.mean()) < 3 * deviation / np.sqrt(60)
