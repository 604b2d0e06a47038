"""Light in a room: Embree's rays, direct light with shadows, one bounce.

Irradiance is in units in which a white surface at irradiance 1 has radiance 1. A light of power P,
W/sr in those units, gives P cos(surface) cos(light) / distance² (Lambert's law twice).
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import distance_transform_edt
from trimesh import Trimesh

from cmtof_rooms.materials import Material, Palette

Array = NDArray[np.floating]
Vector = tuple[float, float, float] | NDArray[np.floating]


class Part(NamedTuple):
    """A solid of one material."""

    mesh: Trimesh
    material: Material


class Thing(NamedTuple):
    """Something with a name, made of parts, in the world's coordinates, m."""

    kind: str
    parts: list[Part]


class Light(NamedTuple):
    """A rectangular light, m; a ``normal`` of zeros shines to all sides."""

    centre: Vector
    half_u: Vector
    half_v: Vector
    normal: Vector
    power: float
    colour: Vector = (1.0, 1.0, 1.0)


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


class Hits(NamedTuple):
    """What N rays met first: distance, m, triangle (-1: nothing), weights of its last corners."""

    distance: Array
    triangle: NDArray[np.int32]
    u: Array
    v: Array


class Tracer:
    """Triangles that rays can be sent against.

    Parameters
    ----------
    vertices : array_like, shape (V, 3)
        m.
    faces : array_like of int, shape (F, 3)

    Raises
    ------
    ValueError
        If Embree is not installed.
    """

    def __init__(self, vertices: ArrayLike, faces: ArrayLike) -> None:
        try:
            from embreex.mesh_construction import TriangleMesh
            from embreex.rtcore_scene import EmbreeScene
        except ImportError as error:
            raise ValueError(
                f"Expected Embree for rendering rooms, got {error}. "
                "Install it: pip install 'cmtof[rooms]'."
            ) from error
        self._scene: Any = EmbreeScene(robust=True)
        TriangleMesh(self._scene, np.asarray(vertices, np.float32), np.asarray(faces, np.int32))

    def nearest(self, origins: Array, directions: Array) -> Hits:
        """First triangle along each ray, (N, 3) and (N, 3), unit directions."""
        found = self._scene.run(origins, directions, output=1)
        return Hits(found["tfar"], found["primID"], found["u"], found["v"])

    def blocked(self, origins: Array, directions: Array, reach: Array) -> NDArray[np.bool_]:
        """Whether anything lies within ``reach``, (N,), m, along each ray."""
        return self._scene.run(origins, directions, dists=reach, query="OCCLUDED") == 0


class World:
    """A scene with its light.

    Parameters
    ----------
    things : sequence of Thing
    lights : sequence of Light
    interior : array_like, shape (2, 3)
        Lowest and highest corner of the space for which one bounce is stored, m.
    sky : float
        Radiance where rays leave.
    bounce : bool
        Whether light is scattered once more by what it falls on.
    """

    def __init__(
        self,
        things: Sequence[Thing],
        lights: Sequence[Light],
        interior: ArrayLike,
        *,
        sky: float = 0.0,
        bounce: bool = True,
    ) -> None:
        self.things, self.lights, self.sky = list(things), list(lights), sky
        parts = [part for thing in things for part in thing.parts]
        counts = [len(part.mesh.vertices) for part in parts]
        starts = np.cumsum([0, *counts[:-1]])
        self.vertices = np.concatenate([part.mesh.vertices for part in parts]).astype(np.float32)
        self.faces = np.concatenate(
            [part.mesh.faces + start for part, start in zip(parts, starts, strict=True)]
        ).astype(np.int32)
        self.part = np.repeat(np.arange(len(parts)), [len(part.mesh.faces) for part in parts])
        """Number of the part that each triangle belongs to."""
        self.instance = np.repeat(np.arange(len(things)), [len(t.parts) for t in things]) + 1
        """Number of the thing that each part belongs to, from 1 on."""
        self.palette = Palette([part.material for part in parts])
        self.tracer = Tracer(self.vertices, self.faces)
        a, b, c = self.vertices.astype(np.float64)[self.faces].swapaxes(0, 1)
        across = np.cross(b - a, c - a)
        self.normals = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-30)
        self._offsets = (self.normals * a).sum(axis=1)
        self._low, self._high = np.asarray(interior, np.float32)
        self._probes = self._probed() if bounce else None

    def picture(self, origin: ArrayLike, directions: Array) -> Picture:
        """See the scene along rays.

        Range is solved in double precision from the triangle's plane: Embree's own is good to some
        micrometres only.

        Parameters
        ----------
        origin : array_like, shape (3,)
            Where the camera stands, m.
        directions : ndarray of float32, shape (H, W, 3)
            Unit vectors through the pixels' centres, in the world.
        """
        height, width = directions.shape[:2]
        rays = np.ascontiguousarray(directions.reshape(-1, 3), np.float32)
        eye = np.asarray(origin, float)
        starts = np.ascontiguousarray(np.broadcast_to(eye.astype(np.float32), rays.shape))
        triangle = self.tracer.nearest(starts, rays).triangle
        met = triangle >= 0
        plane = self.normals[triangle]
        along = np.einsum("ij,ij->i", plane, rays)
        distance = (self._offsets[triangle] - plane @ eye) / np.where(along == 0, 1e-12, along)
        normal = (plane * -np.sign(along)[:, None]).astype(np.float32)
        position = (eye + distance[:, None] * rays).astype(np.float32)
        part = self.part[triangle]
        pixel = np.linalg.norm(rays[1] - rays[0]) if width > 1 else 1e-3
        footprint = pixel * distance / np.maximum(np.abs(along), 0.15)
        albedo = self.palette.albedo(part, position, normal, footprint.astype(np.float32))

        key = np.where(met, part, -1).reshape(height, width)
        light = self.direct(position, normal, _tiles(height, width))
        light = _smoothed(light.reshape(height, width, 3), key, normal).reshape(-1, 3)
        # the bounce varies slowly: 2 x 2 pixels of one surface share it
        y, x = np.indices((height, width)).reshape(2, -1) // 2 * 2
        lead = y * width + x
        alike = key.ravel() == key.ravel()[lead]
        alike &= np.einsum("ij,ij->i", normal, normal[lead]) > 0.98
        asked = np.flatnonzero(~alike | (lead == np.arange(len(lead))))
        scattered = np.zeros_like(light)
        scattered[asked] = self.bounced(position[asked], normal[asked])
        light += np.where(alike[:, None], scattered[lead], scattered)
        colour = albedo * (light + self.palette.emission[part][:, None])
        colour[~met], normal[~met], distance[~met] = self.sky, 0.0, np.nan
        return Picture(
            colour.reshape(height, width, 3),
            distance.astype(np.float32).reshape(height, width),
            normal.reshape(height, width, 3),
            np.where(met, self.instance[part], -1).astype(np.int32).reshape(height, width),
        )

    def direct(self, position: Array, normal: Array, sample: NDArray | None = None) -> Array:
        """Irradiance (N, 3) from the lights, with shadows.

        Parameters
        ----------
        position, normal : ndarray of float32, shape (N, 3)
        sample : ndarray of int, shape (N,), optional
            Which of 16 places on a light is asked for, 0 to 15; its centre by default.
        """
        found = np.zeros(position.shape, np.float32)
        start = position + np.float32(2e-4) * normal
        for light in self.lights:
            centre, u, v, facing, colour = (
                np.asarray(one, np.float32)
                for one in (light.centre, light.half_u, light.half_v, light.normal, light.colour)
            )
            to = centre - start
            if sample is not None:
                places = np.stack([sample % 4, sample // 4], 1).astype(np.float32) / 2 - 0.75
                to += places @ np.stack([u, v])
            reach = np.sqrt(np.einsum("ij,ij->i", to, to))
            to /= np.maximum(reach, 1e-6)[:, None]
            given = light.power * np.einsum("ij,ij->i", to, normal)
            given /= np.maximum(reach, 0.2) ** 2
            if facing.any():
                given *= np.maximum(-(to @ facing), 0)
            some = np.flatnonzero(given > 0)
            free = ~self.tracer.blocked(start[some], to[some], reach[some] * np.float32(0.999))
            lit = some[free]
            found[lit] += given[lit, None] * colour
        return found

    def bounced(self, position: Array, normal: Array) -> Array:
        """Irradiance (N, 3) of light that was scattered once, between the stored places."""
        if self._probes is None:
            return np.zeros(position.shape, np.float32)
        shape = np.array(self._probes.shape[:3])
        span = np.maximum(self._high - self._low, 1e-3)
        place = np.clip((position - self._low) / span, 0, 1) * (shape - 1).astype(np.float32)
        cell = np.minimum(place.astype(np.int32), shape - 2)
        weight = (place - cell).T
        steps = np.array([shape[1] * shape[2], shape[2], 1])
        first = cell @ steps
        flat = self._probes.reshape(-1, 3)  # six rows a place
        found = np.zeros(position.shape, np.float32)
        for axis in range(3):
            share = normal[:, axis] ** 2
            some = np.flatnonzero(share > 1e-3)
            side = 2 * axis + (normal[some, axis] < 0)
            for corner in np.ndindex(2, 2, 2):
                w = share[some]
                for one, far in zip(weight, corner, strict=True):
                    w = w * (one[some] if far else 1 - one[some])
                row = 6 * (first[some] + int(corner @ steps)) + side
                found[some] += w[:, None] * np.take(flat, row, axis=0)
        return found

    def _probed(self) -> Array:
        """Irradiance (X, Y, Z, 6, 3) on a grid, on faces towards +x, -x, +y, ... : one bounce."""
        size = self._high - self._low
        shape = np.clip(np.round(size / max(0.7, float(size.max()) / 14)).astype(int) + 1, 2, 15)
        axes = [np.linspace(a, b, n) for a, b, n in zip(self._low, self._high, shape, strict=True)]
        places = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3).astype(np.float32)
        rays = sphere_of_directions(64)
        origins = np.repeat(places, len(rays), axis=0)
        directions = np.tile(rays, (len(places), 1))
        hits = self.tracer.nearest(origins, directions)
        met = np.flatnonzero(hits.triangle >= 0)
        triangle = hits.triangle[met]
        normal = self.normals[triangle].astype(np.float32)
        outside = np.einsum("ij,ij->i", normal, directions[met]) > 0  # the back of a surface
        radiance = np.zeros(origins.shape, np.float32)  # without lamps and sky: those are direct
        point = origins[met] + directions[met] * hits.distance[met, None]
        light = self.palette.mean[self.part[triangle]] * self.direct(point, normal)
        radiance[met] = np.where(outside[:, None], 0, light)
        faces = np.concatenate([np.maximum(rays, 0), np.maximum(-rays, 0)], axis=1)
        faces = faces[:, [0, 3, 1, 4, 2, 5]] * (4 / len(rays))
        found = np.einsum("pdc,df->pfc", radiance.reshape(len(places), len(rays), 3), faces)
        within = np.bincount(met[outside] // len(rays), minlength=len(places)) > len(rays) / 4
        found, within = found.reshape(*shape, 6, 3), within.reshape(shape)
        if within.any() and not within.all():  # a place inside a solid takes its neighbour's light
            nearest = distance_transform_edt(within, return_distances=False, return_indices=True)
            found = found[tuple(np.asarray(nearest))]
        return found.astype(np.float32)


@lru_cache(maxsize=4)
def sphere_of_directions(count: int) -> Array:
    """Directions (N, 3) spread evenly over the sphere (a Fibonacci lattice)."""
    turn = np.arange(count) * (np.pi * (3 - np.sqrt(5)))
    z = 1 - (2 * np.arange(count) + 1) / count
    radius = np.sqrt(1 - z**2)
    return np.stack([np.cos(turn) * radius, np.sin(turn) * radius, z], -1).astype(np.float32)


@lru_cache(maxsize=4)
def _tiles(height: int, width: int) -> NDArray[np.int32]:
    """Number 0 to 15 of each pixel (H·W,): every 4 x 4 pixels have all, neighbours far ones."""
    y, x = np.indices((height, width), dtype=np.int32).reshape(2, -1) % 4
    return np.array([0, 10, 2, 8, 5, 15, 7, 13, 1, 11, 3, 9, 4, 14, 6, 12], np.int32)[4 * y + x]


def _smoothed(image: Array, part: NDArray, normal: Array) -> Array:
    """Mean (H, W, 3) over 4 x 4 pixels that lie on the same part and face the same way."""
    facing = normal.reshape(image.shape)
    for axis in (0, 1):
        total, count = image.copy(), np.ones(part.shape, np.float32)
        for step in (-2, -1, 1):
            here, there = [slice(None)] * 2, [slice(None)] * 2
            here[axis] = slice(max(0, -step), part.shape[axis] - max(0, step))
            there[axis] = slice(max(0, step), part.shape[axis] - max(0, -step))
            h, t = tuple(here), tuple(there)
            alike = np.einsum("ijk,ijk->ij", facing[h], facing[t]) > 0.9
            alike &= part[h] == part[t]
            total[h] += image[t] * alike[..., None]
            count[h] += alike
        image = total / count[..., None]
    return image
