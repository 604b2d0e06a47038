"""Boxes along the axes by their limits, m: solids, and places in a room that they take."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cmtof.types import Array

Vector = Sequence[float] | Array  # such as a point or a size, m
Triple = tuple[float, float, float]
Limit = Any  # A number, m, or an array of them where a `Box` stands for several


class Box(NamedTuple):
    """A box along the axes by its limits, m; limits that are arrays make several boxes."""

    x0: Limit
    x1: Limit
    y0: Limit
    y1: Limit
    z0: Limit
    z1: Limit

    @classmethod
    def standing(cls, size: Vector, foot: Vector = (0.0, 0.0, 0.0)) -> "Box":
        """Box of a size (width, depth, height), m, the middle of whose foot lies at a point, m.

        >>> Box.standing((2.0, 1.0, 3.0))
        Box(x0=-1.0, x1=1.0, y0=-0.5, y1=0.5, z0=0.0, z1=3.0)
        """
        width, depth, height = size
        x, y, z = foot
        return cls(
            x - width / 2,
            x + width / 2,
            y - depth / 2,
            y + depth / 2,
            z,
            z + height,
        )

    @property
    def low(self) -> Array:
        """Lowest corner (x, y, z), m."""
        return np.array(self[::2])

    @property
    def high(self) -> Array:
        """Highest corner (x, y, z), m."""
        return np.array(self[1::2])

    @property
    def size(self) -> Array:
        """Width, depth and height, m."""
        return self.high - self.low

    @property
    def middle(self) -> Array:
        """Middle along x, y and z, m."""
        return (self.high + self.low) / 2

    def contains(self, other: "Box") -> bool:
        """Whether another box lies within this one."""
        return bool((self.low <= other.low).all() and (other.high <= self.high).all())

    def meets(self, others: Sequence["Box"]) -> bool:
        """Whether this box overlaps one of several others by more than 1 µm.

        >>> cube = Box(0, 1, 0, 1, 0, 1)
        >>> cube.meets([cube.cut(x0=1, x1=2)]), cube.meets([cube.cut(x0=0.5, x1=2)])
        (False, True)
        """
        low, high = np.reshape(others, (-1, 3, 2)).T
        shared = np.minimum(high.T, self.high) - np.maximum(low.T, self.low)
        return bool((shared > 1e-6).all(axis=1).any())

    def singles(self) -> list["Box"]:
        """Single boxes, six numbers each, that a box with arrays as limits stands for.

        >>> len(Box(np.array([0.0, 2.0]), np.array([1.0, 3.0]), 0.0, 1.0, 0.0, 1.0).singles())
        2
        """
        limits = np.stack(np.broadcast_arrays(*self), -1).reshape(-1, 6)
        return [Box(*single) for single in limits.tolist()]

    def cut(self, **limits: Limit) -> "Box":
        """Box with other limits, by their names, m.

        >>> Box.standing((2.0, 1.0, 3.0)).cut(z1=0.5).size.tolist()
        [2.0, 1.0, 0.5]
        """
        return self._replace(**limits)

    def inset(self, **margins: float) -> "Box":
        """Box whose named limits, or both along a named axis, lie further inside by margins, m.

        >>> Box.standing((2.0, 1.0, 3.0)).inset(x=0.5, z1=1.0).size.tolist()
        [1.0, 1.0, 2.0]
        """
        limits = {}
        for name, margin in margins.items():
            for end in name[1:] or "01":
                side = name[0] + end
                inwards = margin if end == "0" else -margin
                limits[side] = getattr(self, side) + inwards
        return self._replace(**limits)

    def ends(self, axis: str, thickness: float) -> "Box":
        """Two boxes of a thickness, m, at both ends along an axis ``x``, ``y`` or ``z``."""
        half = thickness / 2
        low = getattr(self, axis + "0")
        high = getattr(self, axis + "1")
        return self.bars(axis, np.array([low + half, high - half]), half)

    def bars(self, axis: str, middles: Array, half: float) -> "Box":
        """Boxes about ``middles`` along an axis, m, that reach ``half``, m, to either side."""
        return self._along(axis, middles - half, middles + half)

    def split(self, axis: str, count: int) -> "Box":
        """Boxes of equal size, a number of them, that fill this one along an axis.

        >>> Box.standing((2.0, 1.0, 3.0)).split("x", 2).x0.tolist()
        [-1.0, 0.0]
        """
        edges = np.linspace(
            getattr(self, axis + "0"),
            getattr(self, axis + "1"),
            count + 1,
        )
        return self._along(axis, edges[:-1], edges[1:])

    def _along(self, axis: str, low: Array, high: Array) -> "Box":
        """Boxes between limits (N,) along an axis, N for each that this one stands for."""
        each = [limit[..., None] if np.ndim(limit) else limit for limit in self]
        return Box(*each)._replace(**{axis + "0": low, axis + "1": high})


Boxes = list[Box]
