"""Rigid motions and their derivatives: rotation vectors, poses, and how poses chain."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.floating]


def skew(vector: ArrayLike) -> Array:
    """Matrices (..., 3, 3) that multiply like the cross product with vectors (..., 3).

    Examples
    --------
    >>> (skew([1.0, 2.0, 3.0]) @ [4.0, 5.0, 6.0]).tolist()
    [-3.0, 6.0, -3.0]
    """
    x, y, z = np.moveaxis(np.asarray(vector, float), -1, 0)
    zero = np.zeros_like(x)
    rows = ((zero, -z, y), (z, zero, -x), (-y, x, zero))
    return np.stack([np.stack(row, -1) for row in rows], -2)


def rotation_from_vector(vector: ArrayLike) -> Array:
    """Rotation matrix (3, 3) about a vector (3,), by its length, rad (Rodrigues).

    Examples
    --------
    >>> rotation_from_vector([0, 0, np.pi / 2]).round(6).astype(int).tolist()
    [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    """
    vector = np.asarray(vector, float)
    angle = np.linalg.norm(vector)
    cross = skew(vector)
    # sin(t)/t and (1 - cos t)/t^2, which numpy's sinc keeps exact at 0
    return np.eye(3) + np.sinc(angle / np.pi) * cross + _half(angle) * cross @ cross


def vector_from_rotation(rotation: ArrayLike) -> Array:
    """Rotation vector (3,), rad, of a rotation matrix (3, 3); its length is at most pi."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(np.asarray(rotation, float)).as_rotvec()


def turned(vector: ArrayLike, points: ArrayLike) -> tuple[Array, Array]:
    """Rotated points R(w) x and their derivative by the rotation vector w.

    With the right Jacobian J of SO(3), ``d(R x)/dw = -R [x]_x J(w)`` (Sola et al. 2018, eq. 143,
    arXiv:1812.01537).

    Parameters
    ----------
    vector : array_like, shape (3,)
        Rotation vector, rad.
    points : array_like, shape (..., 3)

    Returns
    -------
    turned : ndarray, shape (..., 3)
    derivative : ndarray, shape (..., 3, 3)
    """
    vector, points = np.asarray(vector, float), np.asarray(points, float)
    rotation = rotation_from_vector(vector)
    angle, cross = np.linalg.norm(vector), skew(vector)
    third = (1 - np.sinc(angle / np.pi)) / angle**2 if angle > 1e-4 else 1 / 6
    right = np.eye(3) - _half(angle) * cross + third * cross @ cross
    return points @ rotation.T, -rotation @ skew(points) @ right


def _half(angle: np.floating) -> float:
    """``(1 - cos t) / t^2``, 1/2 at 0."""
    return float(0.5 * np.sinc(angle / (2 * np.pi)) ** 2)


class Pose(NamedTuple):
    """Where one frame of coordinates stands in another: ``there = R here + t``."""

    rotation: Array
    """(3, 3)"""
    translation: Array
    """(3,), m"""

    @classmethod
    def none(cls) -> "Pose":
        """Return the pose that leaves everything where it is."""
        return cls(np.eye(3), np.zeros(3))

    @classmethod
    def from_vector(cls, vector: ArrayLike) -> "Pose":
        """Pose of a rotation vector, rad, followed by a translation, m: (6,)."""
        vector = np.asarray(vector, float)
        return cls(rotation_from_vector(vector[:3]), vector[3:].copy())

    @classmethod
    def looking(cls, position: ArrayLike, at: ArrayLike) -> "Pose":
        """Pose of the world in a camera that stands somewhere and looks at something, level.

        Parameters
        ----------
        position, at : array_like, shape (3,)
            m, in the world: x right, y down, z forward.

        Raises
        ------
        ValueError
            If both are the same, or it looks straight up or down.
        """
        position = np.asarray(position, float)
        forward = np.asarray(at, float) - position
        right = np.cross([0.0, 1.0, 0.0], forward)
        if not np.linalg.norm(right) > 1e-9 * max(1.0, float(np.linalg.norm(forward))):
            raise ValueError(
                f"Expected a camera that looks ahead, got one at {position.tolist()} m looking at "
                f"{np.asarray(at).tolist()} m. Move one of them sideways or forward."
            )
        rows = [right, np.cross(forward, right), forward]
        rotation = np.stack([row / np.linalg.norm(row) for row in rows])
        return cls(rotation, -rotation @ position)

    @property
    def vector(self) -> Array:
        """Rotation vector, rad, and translation, m: (6,)."""
        return np.concatenate([vector_from_rotation(self.rotation), self.translation])

    @property
    def inverse(self) -> "Pose":
        """The way back."""
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)

    def apply(self, points: ArrayLike) -> Array:
        """Points (..., 3), m, in the other frame."""
        return np.asarray(points, float) @ self.rotation.T + self.translation

    def after(self, first: "Pose") -> "Pose":
        """Return the pose of going by `first`, then by this one."""
        return Pose(self.rotation @ first.rotation, self.apply(first.translation))
