"""Corners of a board, homographies, and cameras calibrated from them: the truth, and how sure."""

import numpy as np
import pytest

from cmtof.stereo.board import Board, board_image, find_corners
from cmtof.stereo.calibration import _predicted, calibrate, simulated_views
from cmtof.stereo.camera import PinholeCamera
from cmtof.stereo.homography import (
    homography_from_points,
    intrinsics_from_homographies,
    mapped,
    pose_from_homography,
)
from cmtof.stereo.pose import Pose
from cmtof.stereo.rig import simulated_rig

BOARD = Board()
SMALL = PinholeCamera.from_lens(8e-3, 4 * 3.45e-6, (384, 512), (-0.09, 0.11, 0.0, 3e-4, -2e-4))
NOISE = 0.05


# --- board -------------------------------------------------------------------------------------


def test_a_board_lies_about_its_middle():
    corners = Board(4, 5, 0.03).corners
    assert corners.shape == (20, 3)
    assert np.allclose(corners.mean(axis=0), 0)
    assert np.allclose(corners[1] - corners[0], [0.03, 0, 0])
    assert np.allclose(corners[5] - corners[0], [0, 0.03, 0])


def test_squares_meet_at_corners():
    for corner in BOARD.corners[:, :2]:
        around = BOARD.brightness(corner + 0.01 * np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]]))
        assert around[0] == around[3] != around[1] == around[2]


@pytest.mark.parametrize("sides", [(6, 8), (5, 7), (2, 5), (6, 9, 0.0)])
def test_a_board_that_cannot_be_told_is_refused(sides):
    with pytest.raises(ValueError, match=r"^Expected a board of at least .* got"):
        Board(*sides)


@pytest.mark.parametrize("turn", [0.0, np.pi / 2, np.pi, -2.0])
def test_corners_are_found_to_a_twentieth_of_a_pixel_and_in_order(turn, rng):
    pose = Pose.from_vector([0, 0, turn, 0, 0, 1.3]).after(
        Pose.from_vector([0.35, -0.25, 0.1, 0, 0, 0])
    )
    image = board_image(BOARD, SMALL, pose, rng=rng)
    error = find_corners(image, BOARD) - SMALL.project(pose.apply(BOARD.corners))
    # the board is 24 squares of 40 mm at 1.3 m: 18 px a square
    assert np.sqrt((error**2).mean()) < 0.05
    assert np.abs(error).max() < 0.2


def test_a_board_that_is_not_whole_is_refused(rng):
    aside = Pose.from_vector([0.3, 0.2, 0, 0.35, 0, 1.0])
    image = board_image(BOARD, SMALL, aside, rng=rng)
    with pytest.raises(ValueError, match="corners of a board of 6 x 9"):
        find_corners(image, BOARD)
    with pytest.raises(ValueError, match="Show the whole board"):
        find_corners(100 + rng.standard_normal((200, 300)), BOARD)


# --- homographies ------------------------------------------------------------------------------


def test_a_homography_is_found_exactly(rng):
    truth = np.array([[1.2, 0.1, 30], [-0.2, 0.9, 12], [1e-3, -2e-3, 1]])
    points = rng.uniform(-50, 50, (9, 2))
    found = homography_from_points(points, mapped(truth, points))
    assert np.allclose(found / found[2, 2], truth, rtol=1e-9, atol=1e-12)


def test_a_homography_needs_four_points_of_a_plane():
    line = np.arange(12.0).reshape(6, 2)
    with pytest.raises(ValueError, match="at least 4 pairs"):
        homography_from_points(line[:3], line[:3])
    with pytest.raises(ValueError, match="points of a line"):
        homography_from_points(line, line)


def test_zhangs_closed_form_is_exact_without_distortion(rng):
    camera = PinholeCamera(np.array([2300, 2310, 1010, 760, 0, 0, 0, 0, 0.0]), (1536, 2048))
    poses = BOARD.poses(4, rng=rng)
    views = [camera.project(pose.apply(BOARD.corners)) for pose in poses]
    maps = [homography_from_points(BOARD.corners[:, :2], view) for view in views]
    found = intrinsics_from_homographies(maps)
    assert np.allclose(found, camera.intrinsics[:4], rtol=1e-8)
    for pose, one in zip(poses, maps, strict=True):
        again = pose_from_homography(one, found)
        assert np.allclose(again.vector, pose.vector, atol=1e-8)


def test_boards_that_never_turn_tell_no_camera():
    places = ((0, 0, 1), (0.1, 0, 1), (0.1, 0.1, 1.2), (-0.1, 0.05, 0.9))
    facing = [np.array([[2300, 0, 2300 * x], [0, 2300, 2300 * y], [0, 0, z]]) for x, y, z in places]
    with pytest.raises(ValueError, match="Tilt it by 15 degrees"):
        intrinsics_from_homographies(facing)
    with pytest.raises(ValueError, match="at least 3 views"):
        intrinsics_from_homographies(facing[:2])


# --- calibration -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rig():
    return simulated_rig()


@pytest.fixture(scope="module")
def views(rig):
    return simulated_views(rig, BOARD, 6, rng=np.random.default_rng(1), noise=0.0)


def test_the_derivatives_are_those_of_differences(rig, rng):
    poses = BOARD.poses(2, rng=rng)
    parameters = np.concatenate([rig.parameters[:24], *(pose.vector for pose in poses)])
    _, slopes = _predicted(parameters, BOARD)
    for index in range(parameters.size):
        step = 1e-6 * max(1.0, abs(parameters[index]))
        ahead, back = parameters.copy(), parameters.copy()
        ahead[index] += step
        back[index] -= step
        numeric = (_predicted(ahead, BOARD)[0] - _predicted(back, BOARD)[0]) / (2 * step)
        assert np.allclose(slopes[..., index], numeric, atol=2e-3, rtol=1e-5), index


def test_without_noise_the_truth_is_found(rig, views):
    found = calibrate(BOARD, views[0], views[1], (rig.left.shape, rig.right.shape))
    assert found.corner_noise < 1e-8
    assert np.allclose(found.rig.parameters[:24], rig.parameters[:24], rtol=1e-7, atol=1e-8)
    assert len(found.boards) == 6 and found.residuals.shape == (2, 6, 54, 2)


def test_missing_corners_are_left_out(rig, views):
    left, right = views[0].copy(), views[1]
    left[2, 5:9] = np.nan
    found = calibrate(BOARD, left, right, (rig.left.shape, rig.right.shape))
    assert np.allclose(found.rig.parameters[:24], rig.parameters[:24], rtol=1e-7, atol=1e-8)


def test_the_truth_lies_within_the_covariance(rig, views):
    """Normalised squares of 24 parameters in 10 draws: chi^2, held between its 0.05 % tails."""
    from scipy.stats import chi2

    rng = np.random.default_rng(5)
    draws, total, noises = 10, 0.0, []
    for _ in range(draws):
        left, right = (v + NOISE * rng.standard_normal(v.shape) for v in views)
        found = calibrate(BOARD, left, right, (rig.left.shape, rig.right.shape))
        error = (found.rig.parameters - rig.parameters)[:24]
        covariance = np.asarray(found.rig.covariance)[:24, :24]
        scale = np.sqrt(np.diag(covariance))
        correlation = covariance / np.outer(scale, scale)
        total += (error / scale) @ np.linalg.solve(correlation, error / scale)
        noises.append(found.corner_noise)
    low, high = chi2.ppf([5e-4, 1 - 5e-4], 24 * draws)
    assert low < total < high
    assert np.mean(noises) == pytest.approx(NOISE, rel=0.03)


def test_calibration_refuses_what_it_cannot_use(rig, views):
    shapes = (rig.left.shape, rig.right.shape)
    with pytest.raises(ValueError, match=r"Expected corners \(views, 54, 2\)"):
        calibrate(BOARD, views[0][:, :50], views[1], shapes)
    with pytest.raises(ValueError, match="as many views"):
        calibrate(BOARD, views[0], views[1][:5], shapes)
    with pytest.raises(ValueError, match="at least 3 views"):
        calibrate(BOARD, views[0][:2], views[1][:2], shapes)
    with pytest.raises(ValueError, match="both cameras see whole"):
        simulated_views(rig, BOARD, 3, rng=np.random.default_rng(0), distance=0.1)
