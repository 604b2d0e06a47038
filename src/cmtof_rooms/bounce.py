"""Light that was scattered once, stored on a grid of places."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_edt, map_coordinates

from cmtof.types import Array, Flags
from cmtof_rooms.engine import sphere_of_directions

PLACES = 10
"""Places along each axis of a room."""

RAYS = 64
"""Directions in which light is asked for from each place."""

Look = Callable[[Array, Array], tuple[Array, Flags]]
"""Radiance (N, 3) along rays (N, 3) and (N, 3), and which of them meet the back of a surface."""


class Bounce(NamedTuple):
    """Irradiance at places of a grid, on faces towards +x, -x, +y, -y, +z, -z."""

    space: Array
    """Lowest and highest corner of the grid (2, 3), m."""
    light: Array
    """(X, Y, Z, 6, 3)."""

    def irradiance(self, position: Array, normal: Array) -> Array:
        """Irradiance (N, 3) of surfaces, between the places of the grid.

        Parameters
        ----------
        position, normal : ndarray of float32, shape (N, 3)
            m, and unit vectors.
        """
        low, high = self.space
        share = np.clip((position - low) / (high - low), 0, 1)
        found = np.zeros(position.shape, np.float32)
        for axis in range(3):
            part = normal[:, axis] ** 2
            some = np.flatnonzero(part > 1e-3)
            side = 2 * axis + (normal[some, axis] < 0)
            place = [*((PLACES - 1) * share[some]).T, side]
            for colour in range(3):
                light = map_coordinates(self.light[..., colour], place, order=1)
                found[some, colour] += part[some] * light
        return found


def measure_bounce(space: Array, look: Look) -> Bounce:
    """Bounce in a space, by what is seen from places within it.

    Parameters
    ----------
    space : ndarray of float32, shape (2, 3)
        Its lowest and highest corner, m.
    look : callable
        See `Look`; without lamps and sky, whose light is direct.
    """
    low, high = space
    grid = np.indices([PLACES] * 3).reshape(3, -1).T / (PLACES - 1)
    places = (low + grid * (high - low)).astype(np.float32)
    rays = sphere_of_directions(RAYS)
    origins = np.repeat(places, RAYS, axis=0)
    radiance, behind = look(origins, np.tile(rays, (len(places), 1)))
    faces = np.maximum(np.stack([rays, -rays], axis=2), 0).reshape(RAYS, 6)
    light = np.einsum(
        "pdc,df->pfc",
        radiance.reshape(-1, RAYS, 3),
        faces * (4 / RAYS),
    )
    shape = [PLACES] * 3
    inside = behind.reshape(*shape, RAYS).mean(axis=-1) > 0.25
    # a place inside a solid takes the light of its nearest neighbour outside
    nearest = distance_transform_edt(
        inside, return_distances=False, return_indices=True
    )
    light = light.reshape(*shape, 6, 3)[tuple(np.asarray(nearest))]
    return Bounce(space, light.astype(np.float32))
