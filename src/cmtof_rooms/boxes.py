"""Rectangles of a floor or a wall, and boxes along the axes, by their limits, m."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from cmtof.types import Array

Vector = Sequence[float] | Array  # such as a point or a size, m
Triple = tuple[float, float, float]
Limit = Any  # A number, m, or an array of them where a `Box` stands for several


class Rectangle(NamedTuple):
    """A piece of a floor (x and y) or of a wall (along it and in height), m."""

    x0: float
    x1: float
    y0: float
    y1: float

    @classmethod
    def about(cls, middle: Vector, size: Vector) -> "Rectangle":
        """Rectangle of a size (x, y) about a point (x, y), m."""
        x, y = middle
        width, depth = size
        return cls(x - width / 2, x + width / 2, y - depth / 2, y + depth / 2)

    @property
    def start(self) -> Array:
        """Lowest corner (x, y), m."""
        return np.array(self[::2])

    @property
    def end(self) -> Array:
        """Highest corner (x, y), m."""
        return np.array(self[1::2])

    @property
    def size(self) -> Array:
        """Size along x and y, m."""
        return self.end - self.start

    def grow(
        self, left: float, right: float, below: float, above: float
    ) -> "Rectangle":
        """Rectangle that reaches further by margins, m, below x0, above x1, below y0, above y1."""
        return Rectangle(*np.add(self, (-left, right, -below, above)).tolist())

    def contains(self, other: "Rectangle") -> bool:
        """Whether another rectangle lies within this one."""
        return bool((self.start <= other.start).all() and (other.end <= self.end).all())

    def meets(self, others: Iterable["Rectangle"], gap: float = 1e-6) -> bool:
        """Whether this rectangle overlaps one of several others by more than ``gap``, m.

        >>> Rectangle(0, 1, 0, 1).meets([Rectangle(1, 2, 0, 1)])
        False
        >>> Rectangle(0, 1, 0, 1).meets([Rectangle(0.5, 2, 0.5, 2)])
        True
        """
        x0, x1, y0, y1 = self
        return any(
            x0 < b - gap and a < x1 - gap and y0 < d - gap and c < y1 - gap
            for a, b, c, d in others
        )


Rectangles = list[Rectangle]


class Box(NamedTuple):
    """A box along the axes by its limits, m; limits that are arrays make several boxes."""

    x0: Limit
    x1: Limit
    y0: Limit
    y1: Limit
    z0: Limit
    z1: Limit

    @classmethod
    def standing(cls, size: Vector) -> "Box":
        """Box of a size (width, depth, height), m, that stands on z = 0 about the z axis.

        >>> Box.standing((2.0, 1.0, 3.0))
        Box(x0=-1.0, x1=1.0, y0=-0.5, y1=0.5, z0=0.0, z1=3.0)
        """
        width, depth, height = size
        return cls(*Rectangle.about((0.0, 0.0), (width, depth)), 0.0, height)

    @property
    def size(self) -> Array:
        """Width, depth and height, m."""
        return np.subtract(self[1::2], self[::2])

    @property
    def middle(self) -> Array:
        """Middle along x, y and z, m."""
        return np.add(self[1::2], self[::2]) / 2

    @property
    def floor(self) -> Rectangle:
        """Rectangle that the box covers, seen from above."""
        return Rectangle(*self[:4])

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
            axis, *ends = name
            for end in ends or "01":
                inwards = margin if end == "0" else -margin
                limits[axis + end] = getattr(self, axis + end) + inwards
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
        low = getattr(self, axis + "0")
        high = getattr(self, axis + "1")
        edges = np.linspace(low, high, count + 1)
        return self._along(axis, edges[:-1], edges[1:])

    def _along(self, axis: str, low: Array, high: Array) -> "Box":
        """Boxes between limits (N,) along an axis, N for each that this one stands for."""
        each = [limit[..., None] if np.ndim(limit) else limit for limit in self]
        return Box(*each)._replace(**{axis + "0": low, axis + "1": high})
