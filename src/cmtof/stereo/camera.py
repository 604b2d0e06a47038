"""A pinhole camera with Brown's distortion: points to pixels, pixels to rays, with derivatives.

Pixel centres lie at +0.5, x to the right, y down, z forward, as everywhere in this package. The
distortion is that of Brown (1971), "Close-range camera calibration", Photogrammetric Engineering
37(8), with the names that OpenCV gave it: for x, y on the plane z = 1 and r^2 = x^2 + y^2

    x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
    y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.floating]

INTRINSICS = ("fx", "fy", "cx", "cy", "k1", "k2", "k3", "p1", "p2")
"""Order of a camera's own nine numbers: px, px, px, px, and five without a unit."""


@dataclass(frozen=True, eq=False)
class PinholeCamera:
    """A camera by its own nine numbers; where it stands is told by a `Pose`.

    Attributes
    ----------
    intrinsics : ndarray, shape (9,)
        `INTRINSICS`.
    shape : (int, int)
        Height and width, px.

    Raises
    ------
    ValueError
        If a number is not finite, a focal length not positive, or the image empty.
    """

    intrinsics: Array
    shape: tuple[int, int]

    def __post_init__(self) -> None:
        numbers = np.array(self.intrinsics, float)
        sound = numbers.shape == (9,) and bool(np.isfinite(numbers).all())
        if not sound or not (numbers[:2] > 0).all():
            raise ValueError(
                f"Expected nine numbers {' '.join(INTRINSICS)} with fx, fy > 0, got "
                f"{numbers.tolist()}. Correct them."
            )
        if min(self.shape) < 1:
            raise ValueError(f"Expected an image of some pixels, got {self.shape}. State its size.")
        object.__setattr__(self, "intrinsics", numbers)

    @classmethod
    def from_lens(
        cls,
        focal_length: float,
        pitch: float,
        shape: tuple[int, int],
        distortion: ArrayLike = (0.0, 0.0, 0.0, 0.0, 0.0),
    ) -> "PinholeCamera":
        """Camera of a lens centred before a sensor.

        Parameters
        ----------
        focal_length, pitch : float
            Of the lens, and from pixel to pixel, m.
        shape : (int, int)
            Height and width, px.
        distortion : array_like, shape (5,)
            k1, k2, k3, p1, p2.

        Examples
        --------
        >>> PinholeCamera.from_lens(8e-3, 3.45e-6, (1536, 2048)).intrinsics[:4].round(1).tolist()
        [2318.8, 2318.8, 1024.0, 768.0]
        """
        focal = focal_length / pitch
        middle = [shape[1] / 2, shape[0] / 2]
        return cls(np.concatenate([[focal, focal], middle, np.asarray(distortion, float)]), shape)

    def project(self, points: ArrayLike) -> Array:
        """Pixels (..., 2) of points (..., 3), m, in the camera's frame; NaN from behind it."""
        return pixels_from_points(self.intrinsics, points)[0]

    def rays(self, pixels: ArrayLike) -> Array:
        """Unit rays (..., 3) through pixels (..., 2); NaN where no ray reaches a pixel."""
        plane = self.undistorted(pixels)
        rays = np.concatenate([plane, np.ones_like(plane[..., :1])], -1)
        return rays / np.linalg.norm(rays, axis=-1, keepdims=True)

    def undistorted(self, pixels: ArrayLike) -> Array:
        """Points (..., 2) on the plane z = 1 that are seen at pixels (..., 2), by Newton's method.

        NaN beyond the fold, where a strong distortion maps no point.
        """
        focal, centre = self.intrinsics[:2], self.intrinsics[2:4]
        wanted = (np.asarray(pixels, float) - centre) / focal
        found = wanted.copy()
        for _ in range(30):
            seen, by_plane, _ = distorted(self.intrinsics[4:], found)
            with np.errstate(all="ignore"):
                step = _solved(by_plane, seen - wanted)
            # what runs away beyond the fold is stopped by the test below
            step = np.clip(np.nan_to_num(step), -0.5, 0.5)
            found = found - step
            if not (np.abs(step) > 1e-12).any():
                break
        seen, by_plane, _ = distorted(self.intrinsics[4:], found)
        with np.errstate(invalid="ignore"):
            reached = np.linalg.norm(seen - wanted, axis=-1) * focal.max() < 1e-6
            reached &= _determinant(by_plane) > 0
        return np.where(reached[..., None], found, np.nan)

    def sees(self, pixels: ArrayLike, margin: float = 0.0) -> NDArray[np.bool_]:
        """Whether pixels (..., 2) lie in the image, at least a margin from its border, px."""
        pixels = np.asarray(pixels, float)
        size = np.array(self.shape[::-1])
        with np.errstate(invalid="ignore"):
            return np.asarray(((pixels >= margin) & (pixels <= size - margin)).all(axis=-1))


def _solved(matrix: Array, right: Array) -> Array:
    """Solutions (..., 2) of 2 x 2 systems; without LAPACK's complaint about a singular one."""
    (a, b), (c, d) = np.moveaxis(matrix, (-2, -1), (0, 1))
    x, y = right[..., 0], right[..., 1]
    return np.stack([d * x - b * y, a * y - c * x], -1) / _determinant(matrix)[..., None]


def _determinant(matrix: Array) -> Array:
    return matrix[..., 0, 0] * matrix[..., 1, 1] - matrix[..., 0, 1] * matrix[..., 1, 0]


def distorted(coefficients: ArrayLike, plane: ArrayLike) -> tuple[Array, Array, Array]:
    """Brown's distortion of points on the plane z = 1, with both derivatives.

    Parameters
    ----------
    coefficients : array_like, shape (5,)
        k1, k2, k3, p1, p2.
    plane : array_like, shape (..., 2)

    Returns
    -------
    seen : ndarray, shape (..., 2)
    by_plane : ndarray, shape (..., 2, 2)
        Derivative by the point.
    by_coefficients : ndarray, shape (..., 2, 5)
    """
    k1, k2, k3, p1, p2 = np.asarray(coefficients, float)
    plane = np.asarray(plane, float)
    x, y = plane[..., 0], plane[..., 1]
    r2 = x**2 + y**2
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3))  # d radial / d x = slope * x
    seen = np.stack(
        [
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x**2),
            y * radial + p1 * (r2 + 2 * y**2) + 2 * p2 * x * y,
        ],
        -1,
    )
    mixed = slope * x * y + 2 * p1 * x + 2 * p2 * y
    by_plane = _matrix(
        radial + slope * x**2 + 2 * p1 * y + 6 * p2 * x,
        mixed,
        mixed,
        radial + slope * y**2 + 6 * p1 * y + 2 * p2 * x,
    )
    powers = np.stack([r2, r2**2, r2**3], -1)
    tangential = _matrix(2 * x * y, r2 + 2 * x**2, r2 + 2 * y**2, 2 * x * y)
    by_coefficients = np.concatenate([plane[..., None] * powers[..., None, :], tangential], -1)
    return seen, by_plane, by_coefficients


def _matrix(a: Array, b: Array, c: Array, d: Array) -> Array:
    return np.stack([np.stack([a, b], -1), np.stack([c, d], -1)], -2)


def pixels_from_points(intrinsics: ArrayLike, points: ArrayLike) -> tuple[Array, Array, Array]:
    """Pixels of points in the camera's frame, with both derivatives.

    Parameters
    ----------
    intrinsics : array_like, shape (9,)
        `INTRINSICS`.
    points : array_like, shape (..., 3)
        m.

    Returns
    -------
    pixels : ndarray, shape (..., 2)
        NaN for points that do not lie before the camera.
    by_point : ndarray, shape (..., 2, 3)
        px / m.
    by_intrinsics : ndarray, shape (..., 2, 9)
    """
    intrinsics, points = np.asarray(intrinsics, float), np.asarray(points, float)
    z = np.where(points[..., 2:] > 0, points[..., 2:], np.nan)
    plane = points[..., :2] / z
    seen, by_plane, by_coefficients = distorted(intrinsics[4:], plane)
    focal = intrinsics[:2]
    flat = np.concatenate(
        [np.broadcast_to(np.eye(2), (*plane.shape, 2)), -plane[..., None]], -1
    ) / z[..., None]  # fmt: skip
    by_point = focal[:, None] * (by_plane @ flat)
    diagonal = np.eye(2)
    by_intrinsics = np.concatenate(
        [
            seen[..., None] * diagonal,
            np.broadcast_to(diagonal, (*plane.shape, 2)),
            focal[:, None] * by_coefficients,
        ],
        -1,
    )
    return focal * seen + intrinsics[2:4], by_point, by_intrinsics
