"""Calibration of two cameras from views of a board, and how well it is known (Zhang 2000).

Z. Zhang, "A flexible new technique for camera calibration", IEEE TPAMI 22(11), 2000: a closed form
to start with, then all corners of all views in both images at once, by least squares with analytic
derivatives. The covariance is that of the linearised fit, ``s^2 (J' J)^-1``, with the variance s^2
of a corner taken from what is left over.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.stereo.board import Board
from cmtof.stereo.camera import PinholeCamera, pixels_from_points
from cmtof.stereo.homography import (
    homography_from_points,
    intrinsics_from_homographies,
    pose_from_homography,
)
from cmtof.stereo.pose import Pose, turned
from cmtof.stereo.rig import StereoRig

Array = NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class Calibration:
    """What a calibration found.

    Attributes
    ----------
    rig : StereoRig
        The scanner is not located yet (`cmtof.stereo.scanner`): its six parameters are 0, without
        variance.
    boards : list of Pose
        Of the board in the left camera.
    corner_noise : float
        Standard deviation of a corner's coordinate, px, from what is left over.
    residuals : ndarray, shape (2, V, N, 2)
        Found less predicted corners of left and right, px.
    """

    rig: StereoRig
    boards: list[Pose]
    corner_noise: float
    residuals: Array


def calibrate(
    board: Board, left: ArrayLike, right: ArrayLike, shapes: tuple[tuple[int, int], tuple[int, int]]
) -> Calibration:
    """Calibrate two cameras from what both see of a board.

    Parameters
    ----------
    board : Board
    left, right : array_like, shape (V, N, 2)
        Corners in each view and image, px, in the board's order; NaN where one is not seen.
    shapes : ((int, int), (int, int))
        Heights and widths of both images, px.

    Raises
    ------
    ValueError
        If shapes disagree, there are fewer than three views, or they do not determine the cameras.
    """
    from scipy.optimize import least_squares

    both = [_checked(board, seen) for seen in (left, right)]
    if both[0].shape != both[1].shape:
        raise ValueError(
            f"Expected as many views of left and right, got {len(both[0])} and {len(both[1])}. "
            "Keep those that both cameras have."
        )
    corners = np.stack(both)
    start = _closed_form(board, corners)
    known = np.isfinite(corners)

    def residual(p: Array) -> Array:
        return (_predicted(p, board)[0] - corners)[known]

    def jacobian(p: Array) -> Array:
        return _predicted(p, board)[1][known]

    fit = least_squares(residual, start, jac=jacobian, method="lm", x_scale="jac")  # type: ignore[arg-type]
    spare = known.sum() - start.size
    noise = np.sqrt(2 * fit.cost / spare)
    covariance = noise**2 * _inverse(fit.jac)[:24, :24]
    rig = StereoRig(
        PinholeCamera(fit.x[:9], shapes[0]),
        PinholeCamera(fit.x[9:18], shapes[1]),
        Pose.from_vector(fit.x[18:24]),
        Pose.none(),
        np.pad(covariance, (0, 6)),
    )
    left_over = corners - _predicted(fit.x, board)[0]
    poses = [Pose.from_vector(v) for v in fit.x[24:].reshape(-1, 6)]
    return Calibration(rig, poses, float(noise), left_over)


def _checked(board: Board, seen: ArrayLike) -> Array:
    seen = np.asarray(seen, float)
    count = board.rows * board.columns
    if seen.ndim != 3 or seen.shape[1:] != (count, 2):
        raise ValueError(
            f"Expected corners (views, {count}, 2) of a board of {board.rows} x {board.columns}, "
            f"got {seen.shape}. Order them by views, then as the board's."
        )
    return seen


def _inverse(jacobian: Array) -> Array:
    """``(J' J)^-1`` by singular values of the scaled Jacobian: parameters differ by 10^4."""
    scale = np.linalg.norm(jacobian, axis=0)
    _, strength, directions = np.linalg.svd(np.linalg.qr(jacobian / scale, mode="r"))
    if strength[-1] < 1e-9 * strength[0]:
        raise ValueError(
            "Expected views that determine both cameras, got views that leave some parameter "
            "open. Show the board in more places, tilted."
        )
    root = directions.T / strength / scale[:, None]
    return root @ root.T


# --- start: closed form --------------------------------------------------------------------------


def _closed_form(board: Board, corners: Array) -> Array:
    """Parameters to start from: both cameras without distortion, and median poses."""
    plane = board.corners[:, :2]
    cameras, poses = [], []
    for views in corners:
        maps = []
        for view in views:
            seen = np.isfinite(view).all(axis=1)
            maps.append(homography_from_points(plane[seen], view[seen]))
        camera = intrinsics_from_homographies(maps)
        cameras.append(np.concatenate([camera, np.zeros(5)]))
        poses.append([pose_from_homography(one, camera) for one in maps])
    lefts, rights = poses
    between = [r.after(one.inverse).vector for one, r in zip(lefts, rights, strict=True)]
    return np.concatenate([*cameras, np.median(between, axis=0), *(one.vector for one in lefts)])


# --- the model and its derivatives ---------------------------------------------------------------


def _predicted(parameters: Array, board: Board) -> tuple[Array, Array]:
    """Corners (2, V, N, 2), px, of 24 + 6 V parameters, and their derivatives (2, V, N, 2, P)."""
    points, views = board.corners, (parameters.size - 24) // 6
    pixels = np.empty((2, views, len(points), 2))
    slopes = np.zeros((*pixels.shape, parameters.size))
    between = parameters[18:24]
    for v in range(views):
        own = slice(24 + 6 * v, 30 + 6 * v)
        in_left, by_turn = turned(parameters[own][:3], points)
        in_left = in_left + parameters[own][3:]
        by_board = np.concatenate([by_turn, np.broadcast_to(np.eye(3), by_turn.shape)], -1)
        seen, by_point, by_camera = pixels_from_points(parameters[:9], in_left)
        pixels[0, v], slopes[0, v, :, :, :9] = seen, by_camera
        slopes[0, v, :, :, own] = by_point @ by_board
        in_right, by_between = turned(between[:3], in_left)
        seen, by_point, by_camera = pixels_from_points(parameters[9:18], in_right + between[3:])
        pixels[1, v], slopes[1, v, :, :, 9:18] = seen, by_camera
        slopes[1, v, :, :, 18:21] = by_point @ by_between
        slopes[1, v, :, :, 21:24] = by_point
        rotation = turned(between[:3], np.eye(3))[0].T
        slopes[1, v, :, :, own] = by_point @ rotation @ by_board
    return pixels, slopes


# --- simulation ----------------------------------------------------------------------------------


def simulated_views(
    rig: StereoRig,
    board: Board,
    count: int,
    *,
    rng: np.random.Generator,
    noise: float = 0.05,
    distance: float = 1.0,
    margin: float = 10.0,
) -> tuple[Array, Array]:
    """Corners of a board held before a rig (simulated), seen whole by both cameras.

    Parameters
    ----------
    rig : StereoRig
    board : Board
    count : int
        Views.
    rng : Generator
    noise : float
        Standard deviation of a corner's coordinate, px.
    distance, margin : float
        See `Board.poses`, m; least distance of a corner from the image's border, px.

    Returns
    -------
    left, right : ndarray, shape (V, N, 2)
        px.

    Raises
    ------
    ValueError
        If the board hardly ever fits into both images.
    """
    found: list[Array] = []
    for _ in range(50):
        for pose in board.poses(count, rng=rng, distance=distance):
            both = np.stack(rig.project(pose.apply(board.corners)))
            inside = rig.left.sees(both[0], margin).all() and rig.right.sees(both[1], margin).all()
            if inside and len(found) < count:
                found.append(both)
        if len(found) == count:
            views = np.stack(found, axis=1)
            left, right = views + noise * rng.standard_normal(views.shape)
            return left, right
    raise ValueError(
        f"Expected a board that both cameras see whole at {distance} m, got {len(found)} of "
        f"{count} views. Hold it farther away, or take a smaller one."
    )
