"""Two spots to a point, points to the scanner: exact without noise, and as sure as they say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from cmtof.stereo.board import Board
from cmtof.stereo.calibration import calibrate, simulated_views
from cmtof.stereo.rig import StereoRig, simulated_rig
from cmtof.stereo.scanner import locate_scanner
from cmtof.stereo.supervision import ranges
from cmtof.stereo.triangulation import midpoints, triangulate

RIG = simulated_rig()
SPOT = 0.1 * np.array([[1.0, 0.3], [0.3, 1.2]])
"""Square root of a spot's covariance, px."""


def grid(rows=12, columns=16):
    """Points of a bumpy surface in the scanner's frame, (N, 3), m."""
    y, x = np.meshgrid(np.linspace(-0.26, 0.26, rows), np.linspace(-0.32, 0.32, columns))
    depth = 1.6 + 0.4 * np.sin(3 * x) + 0.5 * y
    return (np.stack([x, y, np.ones_like(x)], -1) * depth[..., None]).reshape(-1, 3)


def noisy(points, rng, root=SPOT):
    """Noisy pixels of both images, and their covariances."""
    pixels = [p + rng.standard_normal(p.shape) @ root.T for p in RIG.project(points)]
    covariance = np.broadcast_to(root @ root.T, (*points.shape[:-1], 2, 2))
    return pixels, (covariance, covariance)


@given(st.floats(-0.3, 0.3), st.floats(-0.25, 0.25), st.floats(0.6, 8))
def test_without_noise_points_come_back(x, y, z):
    point = np.array([x * z, y * z, z])
    found = triangulate(RIG, *RIG.project(point))
    assert np.allclose(RIG.scanner_from_left.apply(found.points), point, atol=1e-8 * z**2)
    assert found.misfit < 1e-12


def test_rays_that_do_not_meet_have_no_point():
    left, right = (camera.intrinsics[2:4] for camera in (RIG.left, RIG.right))
    apart = np.array([600.0, 0.0])
    assert np.isnan(midpoints(RIG, left - apart, right + apart)).all()
    assert np.isnan(triangulate(RIG, left * np.nan, right).points).all()


def test_pairs_must_match():
    with pytest.raises(ValueError, match="Expected pairs of pixels"):
        triangulate(RIG, np.zeros((3, 2)), np.zeros((4, 2)))


def test_the_covariance_is_that_of_many_draws(rng):
    """4000 draws of one point: variances are known to 2.2 %, the margin is 8 %."""
    point = np.broadcast_to(RIG.scanner_from_left.inverse.apply([0.3, -0.2, 2.2]), (4000, 3))
    pixels, covariances = noisy(RIG.scanner_from_left.apply(point), rng)
    found = triangulate(RIG, pixels[0], pixels[1], covariances)
    told = found.covariance.mean(axis=0)
    drawn = np.cov(found.points.T)
    scale = np.sqrt(np.diag(told))
    assert np.allclose(drawn / np.outer(scale, scale), told / np.outer(scale, scale), atol=0.08)
    assert np.abs((found.points - point).mean(axis=0) / scale).max() < 4 / np.sqrt(4000)
    assert found.misfit.mean() == pytest.approx(1, abs=0.1)  # chi^2 of one degree of freedom


def test_uneven_spots_are_weighed(rng):
    """A spot that is five times worse in one camera is believed less: better than unit weights."""
    point = np.broadcast_to([0.1, 0.1, 2.0], (2000, 3))
    exact = RIG.project(point)
    left = exact[0] + 0.5 * rng.standard_normal((2000, 2)) * [0.2, 1]
    right = exact[1] + 0.1 * rng.standard_normal((2000, 2))
    uneven, even = (np.broadcast_to(np.diag(v), (2000, 2, 2)) for v in ([0.01, 0.25], [0.01, 0.01]))
    weights = (uneven, even)
    weighed, plain = (triangulate(RIG, left, right, w).points for w in (weights, None))
    vertical = [np.std(p[:, 1]) for p in (weighed, plain)]
    assert vertical[0] < 0.6 * vertical[1]


def test_the_derivative_by_the_rig_is_that_of_differences():
    points = np.array([[0.2, -0.1, 1.5], [-0.4, 0.3, 3.0]])
    pixels = [p + 0.3 for p in RIG.project(points)]
    found = triangulate(RIG, pixels[0], pixels[1])
    numbers = RIG.parameters
    for index in range(24):
        step = 1e-5 * max(1.0, abs(numbers[index]))
        ahead, back = (RIG.with_parameters(numbers + s * np.eye(30)[index]) for s in (step, -step))
        moved = (
            triangulate(ahead, pixels[0], pixels[1]).points
            - triangulate(back, pixels[0], pixels[1]).points
        ) / (2 * step)
        # the residuals' curvature is left out: 0.3 px against 2319
        assert np.allclose(
            found.by_rig[..., index], moved, rtol=5e-3, atol=1e-3 * np.abs(moved).max()
        )
    assert not found.by_rig[..., 24:].any()


# --- scanner -----------------------------------------------------------------------------------


def test_without_noise_the_scanner_is_found():
    points = grid()
    spots = triangulate(RIG, *RIG.project(points))
    found = locate_scanner(RIG, spots, points)
    assert np.allclose(found.scanner_from_left.vector, RIG.scanner_from_left.vector, atol=1e-7)
    assert found.covariance is None


def test_missing_spots_do_not_matter_and_too_few_do(rng):
    points = grid()
    pixels, covariances = noisy(points, rng)
    pixels[0][::3] = np.nan
    spots = triangulate(RIG, pixels[0], pixels[1], covariances)
    found = locate_scanner(RIG, spots, points).scanner_from_left
    assert np.allclose(found.translation, RIG.scanner_from_left.translation, atol=5e-3)
    few = triangulate(RIG, pixels[0][:4], pixels[1][:4])
    with pytest.raises(ValueError, match="at least 4 triangulated spots"):
        locate_scanner(RIG, few, points[:4])
    with pytest.raises(ValueError, match="one direction for each"):
        locate_scanner(RIG, spots, points[:-1])
    line = np.array([[x, 0, 2.0] for x in np.linspace(-0.5, 0.5, 9)])
    with pytest.raises(ValueError, match="fix the scanner"):
        locate_scanner(RIG, triangulate(RIG, *RIG.project(line)), line)


def test_ranges_are_as_sure_as_they_say_with_all_errors():
    """Calibration, scanner and spots drawn anew: chi^2 of ranges, over 8 whole experiments.

    A rig's errors are shared by all points of an experiment, so each gives one number for them:
    the mean error over the surface, against its foretold deviation.
    """
    board, points, draws = Board(), grid(8, 10), 8
    truth = np.linalg.norm(points, axis=1)
    views = simulated_views(RIG, board, 6, rng=np.random.default_rng(2), noise=0.0)
    shared, own = 0.0, []
    for draw in range(draws):
        rng = np.random.default_rng([7, draw])
        left, right = (v + 0.05 * rng.standard_normal(v.shape) for v in views)
        rig = calibrate(board, left, right, (RIG.left.shape, RIG.right.shape)).rig
        pixels, covariances = noisy(points, rng)
        spots = triangulate(rig, pixels[0], pixels[1], covariances)
        located = locate_scanner(rig, spots, points)
        assert isinstance(located, StereoRig)
        found, by_spots, by_rig = ranges(located, spots)
        error = found - truth
        spread = np.sqrt(by_rig.mean() + by_spots.mean() / len(points))
        shared += (error.mean() / spread) ** 2
        own.append(((error - error.mean()) ** 2 / (by_spots + by_rig)).mean())
    low, high = chi2.ppf([5e-4, 1 - 5e-4], draws)
    assert shared < high, "the calibration's share is told too small"
    assert shared > low / 4, "the calibration's share is told far too large"
    # around the mean: all of the spots' variance, and what of the calibration's is not shared
    assert 0.5 < np.mean(own) < 1.15
