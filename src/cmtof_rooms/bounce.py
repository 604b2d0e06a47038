"""Light that was scattered once, stored on a grid of places."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from cmtof_rooms.engine import Array, sphere_of_directions

RAYS = 64
"""Directions in which light is asked for from each place."""

Look = Callable[[Array, Array], tuple[Array, NDArray[np.bool_]]]
"""Radiance (N, 3) along rays (N, 3) and (N, 3), and which of them meet the back of a surface."""


class Bounce(NamedTuple):
    """Irradiance at places of a grid, on faces towards +x, -x, +y, -y, +z, -z."""

    low: Array
    """Lowest corner of the grid (3,), m."""
    high: Array
    """Highest corner (3,), m."""
    light: Array
    """(X, Y, Z, 6, 3)."""

    def irradiance(self, position: Array, normal: Array) -> Array:
        """Irradiance (N, 3) of surfaces, between the places of the grid.

        Parameters
        ----------
        position, normal : ndarray of float32, shape (N, 3)
            m, and unit vectors.
        """
        cells = np.array(self.light.shape[:3]) - 1
        span = np.maximum(self.high - self.low, 1e-3)
        place = np.clip((position - self.low) / span, 0, 1) * cells.astype(np.float32)
        cell = np.minimum(place.astype(np.int32), cells - 1)
        far = (place - cell).T
        weights = np.stack([1 - far, far])
        found = np.zeros(position.shape, np.float32)
        for axis in range(3):
            share = normal[:, axis] ** 2
            some = np.flatnonzero(share > 1e-3)
            side = 2 * axis + (normal[some, axis] < 0)
            for i, j, k in np.ndindex(2, 2, 2):
                weight = share[some] * weights[i, 0, some] * weights[j, 1, some]
                x, y, z = (cell[some] + (i, j, k)).T
                corner = self.light[x, y, z, side]
                found[some] += (weight * weights[k, 2, some])[:, None] * corner
        return found


def measure_bounce(low: Array, high: Array, look: Look) -> Bounce:
    """Bounce in the space between two corners (3,), m, by what is seen from places within it.

    Parameters
    ----------
    low, high : ndarray of float32, shape (3,)
    look : callable
        See `Look`; without lamps and sky, whose light is direct.
    """
    size = high - low
    step = max(0.7, float(size.max()) / 14)
    shape = np.clip(np.round(size / step).astype(int) + 1, 2, 15)
    axes = [np.linspace(*limits) for limits in zip(low, high, shape, strict=True)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3).astype(np.float32)
    rays = sphere_of_directions(RAYS)
    origins = np.repeat(places, RAYS, axis=0)
    radiance, behind = look(origins, np.tile(rays, (len(places), 1)))
    faces = np.stack([np.maximum(rays, 0), np.maximum(-rays, 0)], axis=2).reshape(RAYS, 6)
    faces = faces * (4 / RAYS)
    light = np.einsum("pdc,df->pfc", radiance.reshape(-1, RAYS, 3), faces)
    inside = behind.reshape(-1, RAYS).sum(axis=1) > RAYS / 4
    return Bounce(low, high, _filled(light.reshape(*shape, 6, 3), inside.reshape(shape)))


def _filled(light: Array, inside: NDArray[np.bool_]) -> Array:
    """Light of a grid; a place inside a solid takes that of its nearest neighbour outside."""
    if inside.any() and not inside.all():
        nearest = distance_transform_edt(inside, return_distances=False, return_indices=True)
        light = light[tuple(np.asarray(nearest))]
    return light.astype(np.float32)
