"""Light that was scattered once, stored on a grid of places."""

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_edt

from cmtof.types import Array, Flags
from cmtof_rooms.engine import sphere_of_directions

# Directions in which light is asked for from each place.
RAYS = 64

# Radiance (N, 3) along rays from (N, 3) in directions (N, 3), and which meet a surface's back.
Look = Callable[[Array, Array], tuple[Array, Flags]]


class Bounce(NamedTuple):
    """Irradiance at places of a grid, on faces towards +x, -x, +y, -y, +z, -z."""

    # Lowest corner of the grid (3,), m.
    low: Array
    # Highest corner (3,), m.
    high: Array
    # Irradiance (X, Y, Z, 6, 3): places of the grid, faces, colours.
    light: Array

    def irradiance(self, position: Array, normal: Array) -> Array:
        """Irradiance (N, 3) of surface points, interpolated between the places of the grid.

        Parameters
        ----------
        position, normal : ndarray of float32, shape (N, 3)
            m, and unit vectors.
        """
        cells = np.array(self.light.shape[:3]) - 1
        span = np.maximum(self.high - self.low, 1e-3)
        place = np.clip((position - self.low) / span, 0, 1) * cells.astype(np.float32)
        cell = np.minimum(place.astype(np.int32), cells - 1)
        far = place - cell  # how far in its cell each place lies, 0 to 1
        found = np.zeros(position.shape, np.float32)
        for axis in range(3):
            share = normal[:, axis] ** 2
            some = np.flatnonzero(share > 1e-3)
            side = 2 * axis + (normal[some, axis] < 0)
            for corner in np.ndindex(2, 2, 2):
                weight = np.where(corner, far[some], 1 - far[some]).T
                weight = share[some] * weight[0] * weight[1] * weight[2]
                found[some] += (
                    weight[:, None] * self.light[*(cell[some] + corner).T, side]
                )
        return found


def measure_bounce(space: Array, look: Look) -> Bounce:
    """Light in a space after one bounce, from the radiance seen at each place of a grid.

    Parameters
    ----------
    space : ndarray of float32, shape (2, 3)
        Its lowest and highest corner, m.
    look : callable
        See `Look`; without lamps and sky, whose light is direct.
    """
    low, high = space
    axes = _grid_axes(low, high)
    shape = [len(axis) for axis in axes]
    places = np.array([*product(*axes)], np.float32)
    rays = sphere_of_directions(RAYS)
    radiance, behind = look(
        np.repeat(places, RAYS, axis=0),
        np.tile(rays, (len(places), 1)),
    )
    faces = np.maximum(np.stack([rays, -rays], axis=2), 0).reshape(RAYS, 6)
    light = np.einsum(
        "pdc,df->pfc",
        radiance.reshape(-1, RAYS, 3),
        faces * (4 / RAYS),
    ).astype(np.float32)
    inside = behind.reshape(*shape, RAYS).sum(axis=-1) > RAYS / 4
    # a place inside a solid takes the light of its nearest neighbour outside
    nearest = distance_transform_edt(
        inside, return_distances=False, return_indices=True
    )
    return Bounce(low, high, light.reshape(*shape, 6, 3)[tuple(np.asarray(nearest))])


def _grid_axes(low: Array, high: Array) -> list[Array]:
    """Grid places along x, y and z, m: 2 to 15 each, about 0.7 m apart, more in large spaces."""
    size = high - low
    step = max(0.7, size.max() / 14)
    counts = np.clip(np.round(size / step).astype(int) + 1, 2, 15)
    return [*map(np.linspace, low, high, counts)]
