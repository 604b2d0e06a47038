"""Where the scanner stands: found from its own spots, as if it were a third camera.

A mirror scanner sends each beam in a known direction, as a camera sees each pixel. So the points
that the cameras have triangulated locate the scanner by resection, and no ruler has to reach the
mirror. A range is then the distance of a point from it.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.stereo.pose import Pose, turned
from cmtof.stereo.rig import SCANNER, StereoRig
from cmtof.stereo.triangulation import Triangulated

Array = NDArray[np.floating]


def locate_scanner(rig: StereoRig, spots: Triangulated, directions: ArrayLike) -> StereoRig:
    """Rig with the scanner's pose found, and with the covariance of all 30 parameters.

    What is wrong with the cameras shifts the points, and the points shift the scanner: the
    covariance keeps that these errors belong together.

    Parameters
    ----------
    rig : StereoRig
        Calibrated cameras; where it says the scanner stands is not looked at.
    spots : Triangulated
        Points (N, 3) of spots; NaN are left out.
    directions : array_like, shape (N, 3)
        Of the beams that made them, in the scanner's frame; z > 0, any length.

    Raises
    ------
    ValueError
        If fewer than four spots are left, or they do not fix the pose.
    """
    from scipy.optimize import least_squares

    directions = np.asarray(directions, float)
    if directions.shape != spots.points.shape or directions.ndim != 2:
        raise ValueError(
            f"Expected points and directions (N, 3), got {spots.points.shape} and "
            f"{directions.shape}. Pass one direction for each spot."
        )
    known = np.isfinite(spots.points).all(axis=1) & (directions[:, 2] > 0)
    if known.sum() < 4:
        raise ValueError(
            f"Expected at least 4 triangulated spots, got {known.sum()}. Scan more of the scene."
        )
    points, wanted = spots.points[known], directions[known]
    plane = wanted[:, :2] / wanted[:, 2:]
    vector = _start(rig).vector
    root = np.broadcast_to(np.eye(2), (len(points), 2, 2))
    for _ in range(2):  # the weights hang a little on the pose

        def whitened(p: Array, root: Array = root) -> Array:
            return np.einsum("nij,nj->ni", root, _seen(p, points)[0] - plane).ravel()

        def slopes(p: Array, root: Array = root) -> Array:
            return (root @ _seen(p, points)[1]).reshape(-1, 6)

        vector = least_squares(whitened, vector, jac=slopes, method="lm", x_scale="jac").x  # type: ignore[arg-type]
        by_points = _seen(vector, points)[2]
        spread = by_points @ spots.covariance[known] @ np.swapaxes(by_points, -1, -2)
        root = np.linalg.inv(np.linalg.cholesky(spread))
    pose = Pose.from_vector(vector)
    if not (pose.apply(points)[:, 2] > 0).all():
        raise ValueError(
            "Expected spots before the scanner, got some behind it. Check the directions' order."
        )
    chain, noise = _uncertainty(vector, points, spots.by_rig[known], root)
    covariance = None
    if rig.covariance is not None:
        covariance = chain @ rig.covariance @ chain.T
        covariance[SCANNER, SCANNER] += noise
    return replace(rig, scanner_from_left=pose, covariance=covariance)


def _start(rig: StereoRig) -> Pose:
    """Half way between both cameras, looking where they do on average."""
    from scipy.spatial.transform import Rotation

    right = rig.right_from_left
    half = Rotation.from_rotvec(right.vector[:3] / 2).as_matrix()
    return Pose(half, -half @ right.inverse.translation / 2)


def _seen(vector: Array, points: Array) -> tuple[Array, Array, Array]:
    """Directions (N, 2) on z = 1 to points, and derivatives by pose (6) and points (3)."""
    rotated, by_turn = turned(vector[:3], points)
    x, y, z = (rotated + vector[3:]).T
    flat = np.zeros((len(points), 2, 3))
    flat[:, 0, 0] = flat[:, 1, 1] = 1 / z
    flat[:, 0, 2], flat[:, 1, 2] = -x / z**2, -y / z**2
    rotation = Pose.from_vector(vector).rotation
    by_pose = np.concatenate([flat @ by_turn, flat], -1)
    return np.stack([x / z, y / z], -1), by_pose, flat @ rotation


def _uncertainty(
    vector: Array, points: Array, points_by_rig: Array, root: Array
) -> tuple[Array, Array]:
    """How the cameras' errors reach all parameters (30, 30), and what the spots add (6, 6)."""
    _, by_pose, by_points = _seen(vector, points)
    white = (root @ by_pose).reshape(-1, 6)
    scale = np.linalg.norm(white, axis=0)
    strength = np.linalg.svd(np.linalg.qr(white / scale, mode="r"), compute_uv=False)
    if strength[-1] < 1e-9 * strength[0]:
        raise ValueError(
            "Expected spots that fix the scanner's pose, got spots in one line. Scan an area."
        )
    inverse = np.linalg.inv(white.T @ white)
    chain = np.eye(30)
    chain[SCANNER] = -inverse @ white.T @ (root @ by_points @ points_by_rig).reshape(-1, 30)
    chain[SCANNER, SCANNER] = 0.0
    return chain, inverse
