"""Light in a room: what is seen along rays, direct light with shadows, one bounce.

Irradiance is in units in which a white surface at irradiance 1 has radiance 1. A light of power P,
W/sr in those units, gives P cos(surface) cos(light) / distance² (Lambert's law twice).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cmtof.types import Array, Flags, Numbers
from cmtof_rooms.bounce import measure_bounce
from cmtof_rooms.engine import Tracer
from cmtof_rooms.materials import Palette
from cmtof_rooms.solids import join
from cmtof_rooms.things import Light, Thing

# Rows of an image, and those two before, one before and one after them.
_NEIGHBOURS = [
    (slice(2, None), slice(-2)),
    (slice(1, None), slice(-1)),
    (slice(-1), slice(1, None)),
]

# Places on a light that each of 4 x 4 pixels asks for: all 16, those of neighbours far apart.
_SAMPLES = np.array(
    [[0, 10, 2, 8], [5, 15, 7, 13], [1, 11, 3, 9], [4, 14, 6, 12]],
)


class Picture(NamedTuple):
    """Images (H, W) of one view."""

    color: Array  # (H, W, 3) linear radiance
    depth: Array  # range along the ray, m; NaN where the ray leaves the scene
    # (H, W, 3) unit normal of the surface in the world, towards the camera; 0 without depth.
    normal: Array
    instance: Numbers  # number of the thing, from 1 on; -1 where there is none


class Surface(NamedTuple):
    """What the rays of an image meet, as arrays (H, W)."""

    # Number of the part; -1 where nothing is met: there the other arrays mean nothing.
    part: Numbers
    distance: Array  # m
    cosine: Array  # of incidence, without its sign
    position: Array  # (H, W, 3), m
    normal: Array  # (H, W, 3), towards where the rays come from


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

    Attributes
    ----------
    vertices : ndarray of float32, shape (V, 3)
        m.
    faces : ndarray of int, shape (F, 3)
    normals : ndarray, shape (F, 3)
        Unit vectors, outwards.
    part : ndarray of int, shape (F + 1,)
        Number of the part that each triangle belongs to; the last is -1, for triangle -1, none.
    instance : ndarray of int, shape (P + 1,)
        Number of the thing that each part belongs to, from 1 on; the last is -1, for part -1.
    """

    def __init__(
        self,
        things: Sequence[Thing],
        lights: Sequence[Light],
        space: ArrayLike,
        *,
        sky: float = 0.0,
    ) -> None:
        self.things = things
        self.lights = lights
        self.sky = sky
        parts = [part for thing in things for part in thing.parts]
        whole = join(part.mesh for part in parts)
        self.vertices = np.asarray(whole.vertices, np.float32)
        self.faces = whole.faces
        self.part = _numbers(0, [len(part.mesh.faces) for part in parts])
        self.instance = _numbers(1, [len(thing.parts) for thing in things])
        self.palette = Palette([part.material for part in parts])
        self.tracer = Tracer(self.vertices, self.faces)
        a, b, c = self.vertices.astype(np.float64)[self.faces].swapaxes(0, 1)
        across = np.cross(b - a, c - a)
        area = np.linalg.norm(across, axis=1, keepdims=True)
        self.normals = across / np.maximum(area, 1e-30)
        self._offsets = (self.normals * a).sum(axis=1)
        self.bounce = measure_bounce(
            np.asarray(space, np.float32), self.reflected_radiance
        )

    def render(self, origin: ArrayLike, directions: Array) -> Picture:
        """Picture of what is seen along rays.

        Parameters
        ----------
        origin : array_like, shape (3,)
            Where the camera stands, m.
        directions : ndarray of float32, shape (H, W, 3)
            Unit vectors through the pixels' centres, in the world.
        """
        seen = self._surface(np.asarray(origin, float), directions)
        first = directions[0, :2]
        pixel = np.linalg.norm(first[-1] - first[0]) or 1e-3
        footprint = pixel * seen.distance / np.maximum(seen.cosine, 0.15)
        albedo = self.palette.albedo(
            seen.part,
            seen.position,
            seen.normal,
            footprint.astype(np.float32),
        )
        # neighbours ask for different places on the lights
        sample = _SAMPLES[tuple(np.indices(seen.part.shape) % 4)]
        direct = self.direct(seen.position, seen.normal, sample)
        light = _smooth(direct, seen.part, seen.normal) + self._bounced_light(seen)
        emission = self.palette.looks["emission"][seen.part]
        color = albedo * (light + emission[..., None])
        missed = seen.part < 0
        color[missed] = self.sky
        seen.normal[missed] = 0.0
        seen.distance[missed] = np.nan
        return Picture(
            color,
            seen.distance.astype(np.float32),
            seen.normal,
            self.instance[seen.part].astype(np.int32),
        )

    def _surface(self, eye: Array, rays: Array) -> Surface:
        """Surfaces that rays (H, W, 3) from a point (3,), m, meet.

        Range is solved in double precision from the triangle's plane: Embree's own is good to some
        micrometres only.
        """
        flat = rays.reshape(-1, 3)
        hits = self.tracer.nearest(np.full_like(flat, eye), flat)
        triangle = hits.triangle.reshape(rays.shape[:2])
        plane = self.normals[triangle]
        along = np.einsum("...i,...i", plane, rays)
        distance = (self._offsets[triangle] - plane @ eye) / np.where(
            along == 0, 1e-12, along
        )
        return Surface(
            self.part[triangle],
            distance,
            np.abs(along),
            (eye + distance[..., None] * rays).astype(np.float32),
            (plane * -np.sign(along)[..., None]).astype(np.float32),
        )

    def direct(
        self,
        position: Array,
        normal: Array,
        sample: Numbers | None = None,
    ) -> Array:
        """Irradiance (..., 3) from the lights, with shadows.

        Parameters
        ----------
        position, normal : ndarray of float32, shape (..., 3)
            m, and unit vectors.
        sample : ndarray of int, shape (...), optional
            Which of 16 places on a light is asked for, 0 to 15; its centre by default.
        """
        found = np.zeros(position.shape, np.float32)
        start = position + 2e-4 * normal
        for light in self.lights:
            to = np.asarray(light.centre, np.float32) - start
            if sample is not None:
                places = np.stack([sample % 4, sample // 4], -1).astype(np.float32)
                sides = np.array([light.half_u, light.half_v], np.float32)
                to += (places / 2 - 0.75) @ sides
            reach = np.sqrt(np.einsum("...i,...i", to, to))
            to /= np.maximum(reach, 1e-6)[..., None]
            given = light.power * np.einsum("...i,...i", to, normal)
            given /= np.maximum(reach, 0.2) ** 2
            facing = np.asarray(light.normal, np.float32)
            if facing.any():
                given *= np.maximum(-(to @ facing), 0)
            lit = given > 0
            lit[lit] = ~self.tracer.is_blocked(start[lit], to[lit], reach[lit] * 0.999)
            found[lit] += given[lit, None] * np.asarray(light.colour, np.float32)
        return found

    def reflected_radiance(
        self, origins: Array, directions: Array
    ) -> tuple[Array, Flags]:
        """Radiance, along rays, of the surfaces that lights fall on, without that of lamps and sky.

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
        met = hits.triangle >= 0
        normal = self.normals[hits.triangle].astype(np.float32)
        front = np.einsum("ij,ij->i", normal, directions) <= 0
        lit = met & front
        point = origins[lit] + directions[lit] * hits.distance[lit, None]
        reflectance = self.palette.mean[self.part[hits.triangle[lit]]]
        radiance = np.zeros(origins.shape, np.float32)
        radiance[lit] = reflectance * self.direct(point, normal[lit])
        return radiance, met & ~front

    def _bounced_light(self, seen: Surface) -> Array:
        """Irradiance by one bounce; it varies slowly: 2 x 2 pixels of a surface share it."""
        pixel = np.indices(seen.part.shape)
        lead = tuple(pixel // 2 * 2)
        alike = seen.part == seen.part[lead]
        alike &= np.einsum("...i,...i", seen.normal, seen.normal[lead]) > 0.98
        asked = ~alike | (pixel % 2 == 0).all(axis=0)
        found = np.zeros_like(seen.normal)
        found[asked] = self.bounce.irradiance(seen.position[asked], seen.normal[asked])
        return np.where(alike[..., None], found[lead], found)


def _numbers(first: int, counts: list[int]) -> Numbers:
    """Number of the group, from ``first`` on, of each item of groups with sizes ``counts``; -1."""
    return np.append(np.repeat(np.arange(len(counts)) + first, counts), -1)


def _smooth(image: Array, part: Numbers, normal: Array) -> Array:
    """Mean (H, W, 3) over 4 x 4 pixels that lie on the same part and face the same way."""
    for _ in ("rows", "columns"):
        total = image.copy()
        count = np.ones(part.shape, np.float32)
        for here, there in _NEIGHBOURS:
            alike = np.einsum("ijk,ijk->ij", normal[here], normal[there]) > 0.9
            alike &= part[here] == part[there]
            total[here] += image[there] * alike[..., None]
            count[here] += alike
        image = (total / count[..., None]).swapaxes(0, 1)
        normal = normal.swapaxes(0, 1)
        part = part.T
    return image
