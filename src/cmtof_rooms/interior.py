"""Light in a room: what is seen along rays, direct light with shadows, one bounce.

Irradiance is in units in which a white surface at irradiance 1 has radiance 1. A light of power P,
W/sr in those units, gives P cos(surface) cos(light) / distance² (Lambert's law twice).
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof_rooms.bounce import measure_bounce
from cmtof_rooms.engine import Array, Tracer
from cmtof_rooms.materials import Palette
from cmtof_rooms.solids import join
from cmtof_rooms.things import Light, Thing


class Picture(NamedTuple):
    """One view, (H, W) each."""

    color: Array
    """(H, W, 3) linear radiance."""
    depth: Array
    """Range along the ray, m; NaN where the ray leaves the scene."""
    normal: Array
    """(H, W, 3) unit normal of the surface in the world, towards the camera; 0 without depth."""
    instance: NDArray[np.int32]
    """Number of the thing, from 1 on; -1 where there is none."""


class Surface(NamedTuple):
    """What N rays meet."""

    met: NDArray[np.bool_]
    """Whether anything is met, (N,); the other arrays mean nothing where not."""
    part: NDArray
    """Number of the part, (N,)."""
    distance: Array
    """m, (N,)."""
    cosine: Array
    """Of incidence, without its sign, (N,)."""
    position: Array
    """(N, 3), m."""
    normal: Array
    """(N, 3), towards where the rays come from."""


class Interior:
    """A furnished room with its light.

    Parameters
    ----------
    things : sequence of Thing
    lights : sequence of Light
    space : array_like, shape (2, 3)
        Lowest and highest corner of the space for which one bounce is stored, m.
    sky : float
        Radiance where rays leave.
    bounce : bool
        Whether light is scattered once more by what it falls on.

    Attributes
    ----------
    vertices : ndarray of float32, shape (V, 3)
        m.
    faces : ndarray of int32, shape (F, 3)
    normals : ndarray, shape (F, 3)
        Unit vectors, outwards.
    part : ndarray of int, shape (F,)
        Number of the part that each triangle belongs to.
    instance : ndarray of int, shape (P,)
        Number of the thing that each part belongs to, from 1 on.
    """

    def __init__(
        self,
        things: Sequence[Thing],
        lights: Sequence[Light],
        space: ArrayLike,
        *,
        sky: float = 0.0,
        bounce: bool = True,
    ) -> None:
        self.things = list(things)
        self.lights = list(lights)
        self.sky = sky
        parts = [part for thing in things for part in thing.parts]
        whole = join(part.mesh for part in parts)
        self.vertices = np.asarray(whole.vertices, np.float32)
        self.faces = np.asarray(whole.faces, np.int32)
        self.part = np.repeat(np.arange(len(parts)), [len(part.mesh.faces) for part in parts])
        self.instance = np.repeat(np.arange(len(things)), [len(t.parts) for t in things]) + 1
        self.palette = Palette([part.material for part in parts])
        self.tracer = Tracer(self.vertices, self.faces)
        a, b, c = self.vertices.astype(np.float64)[self.faces].swapaxes(0, 1)
        across = np.cross(b - a, c - a)
        self.normals = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-30)
        self._offsets = (self.normals * a).sum(axis=1)
        low, high = np.asarray(space, np.float32)
        self.bounce = measure_bounce(low, high, self.lit) if bounce else None

    def render(self, origin: ArrayLike, directions: Array) -> Picture:
        """Picture of what is seen along rays.

        Parameters
        ----------
        origin : array_like, shape (3,)
            Where the camera stands, m.
        directions : ndarray of float32, shape (H, W, 3)
            Unit vectors through the pixels' centres, in the world.
        """
        shape = directions.shape[:2]
        rays = np.ascontiguousarray(directions.reshape(-1, 3), np.float32)
        seen = self._surface(np.asarray(origin, float), rays)
        pixel = np.linalg.norm(rays[1] - rays[0]) if shape[1] > 1 else 1e-3
        footprint = pixel * seen.distance / np.maximum(seen.cosine, 0.15)
        albedo = self.palette.albedo(
            seen.part, seen.position, seen.normal, footprint.astype(np.float32)
        )
        key = np.where(seen.met, seen.part, -1)
        light = _smooth(
            self.direct(seen.position, seen.normal, _tiles(*shape)).reshape(*shape, 3),
            key.reshape(shape),
            seen.normal.reshape(*shape, 3),
        ).reshape(-1, 3)
        light += self._scattered(seen, key, shape)
        color = albedo * (light + self.palette.emission[seen.part][:, None])
        missed = ~seen.met
        color[missed] = self.sky
        seen.normal[missed] = 0.0
        seen.distance[missed] = np.nan
        instance = np.where(seen.met, self.instance[seen.part], -1).astype(np.int32)
        return Picture(
            color.reshape(*shape, 3),
            seen.distance.astype(np.float32).reshape(shape),
            seen.normal.reshape(*shape, 3),
            instance.reshape(shape),
        )

    def _surface(self, eye: Array, rays: Array) -> Surface:
        """Surfaces that rays (N, 3) from a point (3,), m, meet.

        Range is solved in double precision from the triangle's plane: Embree's own is good to some
        micrometres only.
        """
        starts = np.ascontiguousarray(np.broadcast_to(eye.astype(np.float32), rays.shape))
        triangle = self.tracer.nearest(starts, rays).triangle
        plane = self.normals[triangle]
        along = np.einsum("ij,ij->i", plane, rays)
        distance = (self._offsets[triangle] - plane @ eye) / np.where(along == 0, 1e-12, along)
        return Surface(
            triangle >= 0,
            self.part[triangle],
            distance,
            np.abs(along),
            (eye + distance[:, None] * rays).astype(np.float32),
            (plane * -np.sign(along)[:, None]).astype(np.float32),
        )

    def direct(self, position: Array, normal: Array, sample: NDArray | None = None) -> Array:
        """Irradiance (N, 3) from the lights, with shadows.

        Parameters
        ----------
        position, normal : ndarray of float32, shape (N, 3)
            m, and unit vectors.
        sample : ndarray of int, shape (N,), optional
            Which of 16 places on a light is asked for, 0 to 15; its centre by default.
        """
        found = np.zeros(position.shape, np.float32)
        start = position + np.float32(2e-4) * normal
        for light in self.lights:
            to = _ways(light, start, sample)
            reach = np.sqrt(np.einsum("ij,ij->i", to, to))
            to /= np.maximum(reach, 1e-6)[:, None]
            given = light.power * np.einsum("ij,ij->i", to, normal)
            given /= np.maximum(reach, 0.2) ** 2
            facing = np.asarray(light.normal, np.float32)
            if facing.any():
                given *= np.maximum(-(to @ facing), 0)
            some = np.flatnonzero(given > 0)
            limit = reach[some] * np.float32(0.999)
            lit = some[~self.tracer.blocked(start[some], to[some], limit)]
            found[lit] += given[lit, None] * np.asarray(light.colour, np.float32)
        return found

    def lit(self, origins: Array, directions: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Radiance along rays of what the lights fall on, without lamps and sky themselves.

        Parameters
        ----------
        origins, directions : ndarray of float32, shape (N, 3)
            m, and unit vectors.

        Returns
        -------
        radiance : ndarray of float32, shape (N, 3)
        behind : ndarray of bool, shape (N,)
            Whether the back of a surface is met, which is dark.
        """
        hits = self.tracer.nearest(origins, directions)
        met = np.flatnonzero(hits.triangle >= 0)
        triangle = hits.triangle[met]
        normal = self.normals[triangle].astype(np.float32)
        back = np.einsum("ij,ij->i", normal, directions[met]) > 0
        point = origins[met] + directions[met] * hits.distance[met, None]
        light = self.palette.mean[self.part[triangle]] * self.direct(point, normal)
        radiance = np.zeros(origins.shape, np.float32)
        radiance[met] = np.where(back[:, None], 0, light)
        behind = np.zeros(len(origins), bool)
        behind[met] = back
        return radiance, behind

    def _scattered(self, seen: Surface, key: NDArray, shape: tuple[int, int]) -> Array:
        """Irradiance (N, 3) by one bounce; it varies slowly: 2 x 2 pixels of a surface share it."""
        found = np.zeros(seen.position.shape, np.float32)
        if self.bounce is None:
            return found
        y, x = np.indices(shape).reshape(2, -1) // 2 * 2
        lead = y * shape[1] + x
        alike = key == key[lead]
        alike &= np.einsum("ij,ij->i", seen.normal, seen.normal[lead]) > 0.98
        asked = np.flatnonzero(~alike | (lead == np.arange(len(lead))))
        found[asked] = self.bounce.irradiance(seen.position[asked], seen.normal[asked])
        return np.where(alike[:, None], found[lead], found)


def _ways(light: Light, start: Array, sample: NDArray | None) -> Array:
    """Ways (N, 3), m, from points to a light's centre, or to a place on it of 4 x 4."""
    ways = np.asarray(light.centre, np.float32) - start
    if sample is not None:
        places = np.stack([sample % 4, sample // 4], 1).astype(np.float32) / 2 - 0.75
        ways += places @ np.array([light.half_u, light.half_v], np.float32)
    return ways


@lru_cache(maxsize=4)
def _tiles(height: int, width: int) -> NDArray[np.int32]:
    """Number 0 to 15 of each pixel (H·W,): every 4 x 4 pixels have all, neighbours far ones."""
    order = [0, 10, 2, 8, 5, 15, 7, 13, 1, 11, 3, 9, 4, 14, 6, 12]
    y, x = np.indices((height, width), dtype=np.int32).reshape(2, -1) % 4
    return np.array(order, np.int32)[4 * y + x]


def _smooth(image: Array, part: NDArray, normal: Array) -> Array:
    """Mean (H, W, 3) over 4 x 4 pixels that lie on the same part and face the same way."""
    for axis in (0, 1):
        total = image.copy()
        count = np.ones(part.shape, np.float32)
        for step in (-2, -1, 1):
            first = slice(max(0, -step), part.shape[axis] - max(0, step))
            second = slice(max(0, step), part.shape[axis] - max(0, -step))
            here = (slice(None),) * axis + (first,)
            there = (slice(None),) * axis + (second,)
            alike = np.einsum("ijk,ijk->ij", normal[here], normal[there]) > 0.9
            alike &= part[here] == part[there]
            total[here] += image[there] * alike[..., None]
            count[here] += alike
        image = total / count[..., None]
    return image
