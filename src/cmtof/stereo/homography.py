"""Maps from one plane to another: found from points, and turned into a camera (Zhang 2000)."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.stereo.pose import Pose

Array = NDArray[np.floating]


def mapped(homography: ArrayLike, points: ArrayLike) -> Array:
    """Points (N, 2) where a homography (3, 3) takes points (N, 2)."""
    points = np.asarray(points, float)
    sent = np.column_stack([points, np.ones(len(points))]) @ np.asarray(homography, float).T
    return sent[:, :2] / sent[:, 2:]


def homography_from_points(source: ArrayLike, target: ArrayLike) -> Array:
    """Homography (3, 3) that takes points (N, 2) to others, by the normalised linear fit.

    Hartley and Zisserman 2004, "Multiple view geometry", algorithm 4.2.

    Raises
    ------
    ValueError
        From fewer than four points, or points that lie on one line.
    """
    source, target = np.asarray(source, float), np.asarray(target, float)
    if len(source) < 4 or source.shape != target.shape:
        raise ValueError(
            f"Expected at least 4 pairs of points, got {source.shape} and {target.shape}. Show "
            "more of the board."
        )
    before, after = _normaliser(source), _normaliser(target)
    a, b = mapped(before, source), mapped(after, target)
    one = np.column_stack([a, np.ones(len(a))])
    none = np.zeros_like(one)
    rows = np.concatenate(
        [np.hstack([one, none, -b[:, :1] * one]), np.hstack([none, one, -b[:, 1:] * one])]
    )
    _, strength, directions = np.linalg.svd(np.linalg.qr(rows, mode="r"))
    if strength[7] < 1e-9 * strength[0]:
        raise ValueError("Expected points of a plane, got points of a line. Show more of it.")
    return np.linalg.inv(after) @ directions[-1].reshape(3, 3) @ before


def _normaliser(points: Array) -> Array:
    """Shift and scale (3, 3) that bring points about 0 to a distance of about sqrt 2."""
    middle = points.mean(axis=0)
    scale = np.sqrt(2) / np.maximum(np.linalg.norm(points - middle, axis=1).mean(), 1e-300)
    return np.array([[scale, 0, -scale * middle[0]], [0, scale, -scale * middle[1]], [0, 0, 1]])


def intrinsics_from_homographies(homographies: ArrayLike) -> Array:
    """fx, fy, cx, cy, px, of a camera without skew, in closed form (Zhang 2000, Sec. 3.1).

    Each view of a plane gives two equations in the image of the absolute conic, which is what a
    camera's four numbers make of the unit matrix.

    Parameters
    ----------
    homographies : array_like, shape (V, 3, 3)
        From the board's plane to pixels; at least three views that are turned against each other
        (two would do without skew, but badly).

    Raises
    ------
    ValueError
        If there are fewer than three, or they do not determine a camera.
    """
    homographies = np.asarray(homographies, float)
    if len(homographies) < 3:
        raise ValueError(
            f"Expected at least 3 views of the board, got {len(homographies)}. Show it more often."
        )
    rows = []
    for h in homographies / np.linalg.norm(homographies, axis=(1, 2), keepdims=True):
        rows += [
            _conic_row(h[:, 0], h[:, 1]),
            _conic_row(h[:, 0], h[:, 0]) - _conic_row(*h.T[[1, 1]]),
        ]
    rows = np.array(rows)
    scale = 1 / np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
    _, strength, directions = np.linalg.svd(np.linalg.qr(rows * scale, mode="r"))
    b11, b22, b13, b23, b33 = directions[-1] * scale
    with np.errstate(all="ignore"):
        cx, cy = -b13 / b11, -b23 / b22
        size = b33 - b13**2 / b11 - b23**2 / b22
        squares = np.array([size / b11, size / b22])
    if strength[3] < 1e-9 * strength[0] or not (np.isfinite(squares) & (squares > 0)).all():
        raise ValueError(
            "Expected views of a board that is turned between them, got views that do not "
            "determine a camera. Tilt it by 15 degrees or more, differently each time."
        )
    return np.array([*np.sqrt(squares), cx, cy])


def _conic_row(a: Array, b: Array) -> Array:
    """Coefficients of B11, B22, B13, B23, B33 in a' B b, for B12 = 0."""
    return np.array(
        [
            a[0] * b[0],
            a[1] * b[1],
            a[0] * b[2] + a[2] * b[0],
            a[1] * b[2] + a[2] * b[1],
            a[2] * b[2],
        ]
    )


def pose_from_homography(homography: ArrayLike, camera: ArrayLike) -> Pose:
    """Pose of a board in a camera fx, fy, cx, cy, px, from its homography (Zhang 2000)."""
    fx, fy, cx, cy = np.asarray(camera, float)
    pinhole = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    columns = np.linalg.inv(pinhole) @ np.asarray(homography, float)
    columns /= np.sign(columns[2, 2]) * np.sqrt(np.prod(np.linalg.norm(columns[:, :2], axis=0)))
    first, second, place = columns.T
    # the nearest rotation to what noise has left of one
    u, _, v = np.linalg.svd(np.column_stack([first, second, np.cross(first, second)]))
    return Pose(u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v, place)
