"""Hypersim's projections: M_cam_from_uv, tilt and shift included, and the pinhole of equal rays.

A pixel at (x, y), centres at +0.5, has u = 2x/W - 1 and v = 1 - 2y/H. Its ray in the camera's axes
(right, up, backwards) is M (u, v, 1). Of the 482 official cameras 207 have the same plain pinhole;
the others shift or tilt the image plane against the camera's axes. The rays of any of them are
those of a pinhole K turned by a rotation R: with D = diag(1, -1, -1) and N the step from pixels to
(u, v), the QR decomposition of D M N is R' K^-1, and R = D R'.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Matrix = NDArray[np.float64]

SKEW = 1e-6
"""Skew, relative to fx, below which a camera is written with four numbers."""

_DOWN_FORWARD = np.diag([1.0, -1.0, -1.0])


def uv_from_pixel(shape: tuple[int, ...]) -> Matrix:
    """The matrix N (3, 3) that takes (x, y, 1), px, to (u, v, 1)."""
    height, width = shape
    return np.array([[2 / width, 0, -1], [0, -2 / height, 1], [0, 0, 1]])


def rays_from_projection(projection: ArrayLike, shape: tuple[int, ...]) -> Matrix:
    """Unit rays (H, W, 3) through the pixels' centres in the camera's axes: right, up, backwards.

    Parameters
    ----------
    projection : array_like, shape (3, 3)
        M_cam_from_uv.
    shape : (int, int)
        H, W.
    """
    y, x = np.indices(shape) + 0.5
    pixels = np.stack([x, y, np.ones(shape)], axis=-1)
    rays = pixels @ (np.asarray(projection, float) @ uv_from_pixel(shape)).T
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def camera_from_projection(projection: ArrayLike, shape: tuple[int, ...]) -> tuple[Matrix, Matrix]:
    """Camera numbers and rotation of a projection.

    Parameters
    ----------
    projection : array_like, shape (3, 3)
        M_cam_from_uv.
    shape : (int, int)
        H, W.

    Returns
    -------
    camera : ndarray, shape (4,) or (5,)
        fx, fy, cx, cy, px, and the skew where it exceeds `SKEW` of fx.
    rotation : ndarray, shape (3, 3)
        Takes that camera's rays (x right, y down, z forward) to Hypersim's camera axes.

    Raises
    ------
    ValueError
        If the matrix shows nothing, or shows it mirrored.

    Examples
    --------
    >>> camera, rotation = camera_from_projection(np.diag([0.5, 0.375, -1.0]), (384, 512))
    >>> camera.tolist(), rotation.diagonal().tolist()
    ([512.0, 512.0, 256.0, 192.0], [1.0, -1.0, -1.0])
    """
    given = np.asarray(projection, float)
    whole = given.shape == (3, 3) and bool(np.isfinite(given).all())
    rays = _DOWN_FORWARD @ (given if whole else np.zeros((3, 3))) @ uv_from_pixel(shape)
    if not np.linalg.det(rays) > 0:
        raise ValueError(
            f"Expected a projection M_cam_from_uv that shows what lies ahead, got "
            f"{given.tolist()}. Check the table of camera parameters."
        )
    turned, inverse = np.linalg.qr(rays)
    signs = np.sign(np.diag(inverse))
    turned, inverse = turned * signs, inverse * signs[:, None]
    pinhole = np.linalg.inv(inverse)
    pinhole /= pinhole[2, 2]
    camera = pinhole[[0, 1, 0, 1, 0], [0, 1, 2, 2, 1]]
    skewed = abs(camera[4]) > SKEW * camera[0]
    return (camera if skewed else camera[:4]), _DOWN_FORWARD @ turned


def projection_from_focal(focal: float, shape: tuple[int, ...]) -> Matrix:
    """M_cam_from_uv (3, 3) of a plain pinhole with its centre in the middle of the image.

    Examples
    --------
    >>> projection_from_focal(886.81, (768, 1024)).diagonal().round(3).tolist()
    [0.577, 0.433, -1.0]
    """
    height, width = shape
    return np.diag([width / (2 * focal), height / (2 * focal), -1.0])
