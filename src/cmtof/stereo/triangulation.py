"""From a spot in two images to a point in space, and how well it is known.

The middle of the shortest line between both rays is where the search begins; the likeliest point is
where the reprojection errors, weighed by the spots' covariances, are least (Hartley and Sturm 1997,
"Triangulation"). Four coordinates against three unknowns leave one degree of freedom: how far the
spots miss each other across the epipolar line, which tells a wrong pair.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.stereo.camera import pixels_from_points
from cmtof.stereo.pose import turned
from cmtof.stereo.rig import BETWEEN, LEFT, RIGHT, StereoRig

Array = NDArray[np.floating]


class Triangulated(NamedTuple):
    """Points in the left camera's frame."""

    points: Array
    """(..., 3), m; NaN where a spot was missing, or the rays do not meet before the cameras."""
    covariance: Array
    """(..., 3, 3), m^2, from the spots' alone."""
    by_rig: Array
    """Derivative (..., 3, 30) of the points by the rig's parameters; 0 for the scanner's."""
    misfit: Array
    """Weighted sum of squares (...) that is left: chi^2 of one degree of freedom."""


def midpoints(rig: StereoRig, left: ArrayLike, right: ArrayLike) -> Array:
    """Middles (..., 3), m, of the shortest lines between the rays of two pixels (..., 2).

    NaN for rays that are parallel, or meet behind a camera.
    """
    back = rig.right_from_left.inverse
    a = rig.left.rays(left)
    b = rig.right.rays(right) @ back.rotation.T
    origin = back.translation
    across = np.sum(a * b, -1)
    along_a, along_b = a @ origin, np.sum(b * origin, -1)
    with np.errstate(all="ignore"):
        s = (along_a - across * along_b) / (1 - across**2)
        t = (across * along_a - along_b) / (1 - across**2)
        middle = (s[..., None] * a + origin + t[..., None] * b) / 2
        return np.where(((s > 0) & (t > 0))[..., None], middle, np.nan)


def triangulate(
    rig: StereoRig,
    left: ArrayLike,
    right: ArrayLike,
    covariances: tuple[ArrayLike, ArrayLike] | None = None,
    *,
    steps: int = 8,
) -> Triangulated:
    """Likeliest points of pairs of spots.

    Parameters
    ----------
    rig : StereoRig
    left, right : array_like, shape (..., 2)
        px; NaN where there is none.
    covariances : (array_like, array_like), optional
        Of both, (..., 2, 2), px^2; by default 1 px^2 each.
    steps : int
        Gauss–Newton steps at most.

    Raises
    ------
    ValueError
        If there are not as many left as right ones.

    Examples
    --------
    >>> from cmtof.stereo.rig import simulated_rig
    >>> rig = simulated_rig()
    >>> left, right = rig.project([0.1, -0.2, 2.0])
    >>> found = triangulate(rig, left, right).points
    >>> rig.scanner_from_left.apply(found).round(9).tolist()
    [0.1, -0.2, 2.0]
    """
    left, right = np.asarray(left, float), np.asarray(right, float)
    if left.shape != right.shape or left.shape[-1:] != (2,):
        raise ValueError(
            f"Expected pairs of pixels (..., 2), got {left.shape} and {right.shape}. Match them."
        )
    seen = np.concatenate([left, right], -1)
    weight = _weights(seen, covariances)
    points = midpoints(rig, left, right)
    for _ in range(steps):
        predicted, by_point, _ = _model(rig, points)
        step = _solution(by_point, weight, seen - predicted)
        points = points + step
        if not np.nanmax(np.abs(step), initial=0.0) > 1e-12:
            break
    predicted, by_point, by_rig = _model(rig, points)
    rest = seen - predicted
    misfit = np.einsum("...i,...ij,...j->...", rest, weight, rest)
    normal = np.swapaxes(by_point, -1, -2) @ weight
    covariance = _inverted(normal @ by_point)
    return Triangulated(points, covariance, -covariance @ normal @ by_rig, misfit)


def _weights(seen: Array, covariances: tuple[ArrayLike, ArrayLike] | None) -> Array:
    """Inverse covariances (..., 4, 4) of both spots; unit ones where a spot is missing."""
    weight = np.zeros((*seen.shape, 4))
    for camera in range(2):
        block = slice(2 * camera, 2 * camera + 2)
        one = np.eye(2) if covariances is None else np.asarray(covariances[camera], float)
        known = np.isfinite(one).all(axis=(-2, -1), keepdims=True)
        weight[..., block, block] = np.linalg.inv(np.where(known, one, np.eye(2)))
    return weight


def _model(rig: StereoRig, points: Array) -> tuple[Array, Array, Array]:
    """Pixels (..., 4) of points in the left frame, and derivatives (..., 4, 3) and (..., 4, 30)."""
    between = rig.right_from_left.vector
    in_left, slope_left, own_left = pixels_from_points(rig.left.intrinsics, points)
    rotated, by_turn = turned(between[:3], points)
    in_right, slope_right, own_right = pixels_from_points(
        rig.right.intrinsics, rotated + between[3:]
    )
    by_point = np.concatenate([slope_left, slope_right @ rig.right_from_left.rotation], -2)
    by_rig = np.zeros((*points.shape[:-1], 4, 30))
    by_rig[..., :2, LEFT] = own_left
    by_rig[..., 2:, RIGHT] = own_right
    by_rig[..., 2:, BETWEEN] = np.concatenate([slope_right @ by_turn, slope_right], -1)
    return np.concatenate([in_left, in_right], -1), by_point, by_rig


def _solution(slopes: Array, weight: Array, rest: Array) -> Array:
    normal = np.swapaxes(slopes, -1, -2) @ weight
    return (_inverted(normal @ slopes) @ (normal @ rest[..., None]))[..., 0]


def _inverted(matrix: Array) -> Array:
    """Inverses (..., 3, 3); NaN where a matrix is not finite."""
    known = np.isfinite(matrix).all(axis=(-2, -1), keepdims=True)
    return np.where(known, np.linalg.inv(np.where(known, matrix, np.eye(3))), np.nan)
