"""Diffuse walls that meet: a V-groove or the corner of a room, cut into square cells."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.instrument.parsing import check_fields, number

Array = NDArray[np.floating]


@dataclass(frozen=True, kw_only=True)
class Corner:
    """Two or three square diffuse walls that meet, and an instrument on their axis of symmetry.

    Two walls are a V-groove: its edge lies along y, the instrument on +z. Three are the corner of a
    room: wall k is the plane ``x_k = 0``, the instrument on the space diagonal. A field on the
    walls has the shape (walls, cells, along): from the edge outwards, then along it; on wall k of a
    room the axes are k + 1 and k + 2 (modulo 3).

    Examples
    --------
    >>> Corner().points.shape
    (2, 41, 41, 3)
    >>> Corner(walls=3, angle=1.0)
    Traceback (most recent call last):
        ...
    ValueError: Expected three walls at a right angle, got 1 rad. Use walls=2, or leave the angle.
    """

    walls: int = number(2, 2, 3)  # type: ignore[assignment]
    """2 or 3."""
    angle: float = number(float(np.pi / 2), 0.01, 3.14)
    """Opening angle of a groove, rad."""
    side: float = number(0.5, 1e-6, 1e3)
    """Width of a wall, m."""
    distance: float = number(1.0, 1e-6, 1e3)
    """Instrument to the middle of the edge or to the apex, m."""
    cells: int = number(41, 1, 400)  # type: ignore[assignment]
    """Square cells across a wall."""
    along: int = number(0, 0, 4000)  # type: ignore[assignment]
    """Cells along the edge of a groove; 0 is as many as across."""

    def __post_init__(self) -> None:
        check_fields(type(self), vars(self), "corner")
        if self.walls == 3 and abs(self.angle - np.pi / 2) > 1e-9:
            raise ValueError(
                f"Expected three walls at a right angle, got {self.angle:g} rad. "
                "Use walls=2, or leave the angle."
            )
        if self.walls == 3 and self.along not in (0, self.cells):
            raise ValueError(
                f"Expected square walls in a room's corner, got {self.along} cells along. Use 0."
            )

    @property
    def shape(self) -> tuple[int, int, int]:
        """(walls, cells, along) of a field."""
        return self.walls, self.cells, self.along or self.cells

    @property
    def cell(self) -> float:
        """Side of a cell, m."""
        return self.side / self.cells

    @cached_property
    def frames(self) -> tuple[Array, Array]:
        """Unit vectors (walls, 2, 3) along the axes of each wall, and inward normals (walls, 3)."""
        if self.walls == 3:
            unit = np.eye(3)
            return np.stack([unit[[(k + 1) % 3, (k + 2) % 3]] for k in range(3)]), unit
        s, c = np.sin(self.angle / 2), np.cos(self.angle / 2)
        edge = np.array([0.0, 1.0, 0.0])
        axes = np.stack([[[s, 0, c], edge], [[-s, 0, c], edge]])
        return axes, np.array([[-c, 0, s], [c, 0, s]])

    @cached_property
    def points(self) -> Array:
        """Centres (walls, cells, along, 3) of the cells, m."""
        across = (np.arange(self.shape[1]) + 0.5) * self.cell
        count = self.shape[2]
        # the edge of a groove is centred; the walls of a room begin at the apex
        start = 0.5 if self.walls == 3 else 0.5 - count / 2
        along = (np.arange(count) + start) * self.cell
        axes = self.frames[0]
        return (
            across[None, :, None, None] * axes[:, None, None, 0]
            + along[None, None, :, None] * axes[:, None, None, 1]
        )

    @cached_property
    def instrument(self) -> Array:
        """Where the instrument stands, (3,), m."""
        axis = np.ones(3) / np.sqrt(3) if self.walls == 3 else np.array([0.0, 0.0, 1.0])
        return self.distance * axis

    @cached_property
    def seen(self) -> tuple[Array, Array]:
        """Range, m, and cosine of each cell from the instrument, both (walls, cells, along)."""
        way = self.instrument - self.points
        distance = np.linalg.norm(way, axis=-1)
        return distance, np.einsum("wijk,wk->wij", way, self.frames[1]) / distance

    def look(self, directions: ArrayLike) -> tuple[Array, Array, NDArray[np.intp]]:
        """Trace unit rays (..., 3) from the instrument.

        Returns
        -------
        range, cosine : ndarray, shape (...)
            m; NaN where a ray meets nothing.
        cell : ndarray, shape (..., 3)
            Index of the cell that it meets; zeros where none.
        """
        rays = np.asarray(directions, float)
        axes, normals = self.frames
        _, rows, columns = self.shape
        best = np.full(rays.shape[:-1], np.inf)
        cosine, cell = np.full(best.shape, np.nan), np.zeros((*best.shape, 3), int)
        for wall in range(self.walls):
            towards = -(rays @ normals[wall])
            with np.errstate(divide="ignore", invalid="ignore"):
                reach = (self.instrument @ normals[wall]) / towards
                meet = self.instrument + reach[..., None] * rays
                place = meet @ axes[wall].T / self.cell
            place[..., 1] += 0 if self.walls == 3 else columns / 2
            inside = (place >= 0).all(-1) & (place[..., 0] < rows) & (place[..., 1] < columns)
            hit = inside & (towards > 0) & (reach < best)
            best, cosine = np.where(hit, reach, best), np.where(hit, towards, cosine)
            index = np.concatenate([np.full((*hit.shape, 1), wall), np.nan_to_num(place)], -1)
            cell = np.where(hit[..., None], np.floor(index).astype(int), cell)
        return np.where(np.isfinite(best), best, np.nan), cosine, cell
