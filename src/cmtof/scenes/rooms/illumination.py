"""How much light reaches a point: lamps, windows, sun, and what other surfaces scatter.

Light is followed over three bounces. The irradiance of every triangle, from lamps and from one
bounce, is found once a scene and serves all its cameras; a pixel then asks lamps and sun by itself
and gathers the rest from the triangles that it sees.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from cmtof.scenes.rooms import shading
from cmtof.scenes.rooms.assembly import Geometry
from cmtof.scenes.rooms.materials import PATTERNS
from cmtof.scenes.rooms.meshing import face_vectors, spread
from cmtof.scenes.rooms.sunlight import sun_patches
from cmtof.scenes.rooms.tracing import Hits, Tracer
from cmtof.scenes.rooms.visibility import CELL, visibility

Array = NDArray[np.float32]

BRIGHTEST = 12.0
"""Radiance at which scattered light is cut, in means of all surfaces: rare rays make specks."""

SMALL = 2e-3
"""Area below which a triangle is asked for its light once only, m^2."""

# mean share of the second colour in each pattern: what a blurred glance sees
_MEAN_MIX = np.array([0.0 if name == "plain" else 0.35 for name in PATTERNS], np.float32)


@dataclass
class Points:
    """N places that want light, (N, 3) each: position (m), unit normals, and the way of sight."""

    position: Array
    normal: Array
    """Of the true surface, towards the viewer; zero where there is none."""
    shading: Array
    """Smoothed normal."""
    view: Array
    """Unit direction from the viewer."""
    gloss: Array
    """Specular share, exponent, emission."""
    order: NDArray[np.int32]
    """(N,) which samples each point takes."""

    def at(self, index: NDArray[np.integer]) -> "Points":
        """Some of the points."""
        kept = (getattr(self, field.name)[index] for field in fields(self))
        return Points(*kept)


@dataclass
class Illumination:
    """Light of one scene.

    Parameters
    ----------
    geometry : Geometry
    tracer : Tracer
        Of the same triangles.
    """

    geometry: Geometry
    tracer: Tracer

    def __post_init__(self) -> None:
        g, m = self.geometry, self.geometry.materials
        mix = _MEAN_MIX[m["pattern"]][:, None]
        colour = m["colour"] * (1 - mix) + m["second"] * mix
        self.albedo = (colour * (1 - m["specular"][:, None]))[g.part].astype(np.float32)
        glow = (m["colour"] * m["emission"][:, None])[g.part].astype(np.float32)
        centres, area = self._centres()
        outside = self._outside(centres.position)
        # the last entry serves rays that meet nothing: their triangle is -1
        self._outdoors = np.append(outside, False)
        # patches of sun are lamps from here on, so the triangles' own light leaves the sun out
        self.lights = np.concatenate([g.lights, sun_patches(g, self.tracer, self.albedo)])
        within = centres.position[~outside]
        self._seen = visibility(self.tracer, self.lights, within.min(axis=0), within.max(axis=0))
        direct = self._sampled(centres, area, lambda p, n: self.direct(p, n)[0])
        self.radiance = glow + self.albedo * direct
        mean = np.average(self.radiance[~outside].mean(axis=1), weights=area[~outside])
        self._brightest = np.float32(BRIGHTEST * mean)
        scattered = self._sampled(centres, area, self.gathered)
        self.irradiance = direct + scattered
        self.radiance = glow + self.albedo * self.irradiance

    def _centres(self) -> tuple[Points, Array]:
        """Middle of every triangle, and its area (T,), m^2."""
        middle, normal, area = face_vectors(self.geometry.vertices, self.geometry.faces)
        # a slim triangle's middle may touch its neighbour: start a little above it
        middle += np.float32(1e-3) * normal
        order = np.arange(len(middle), dtype=np.int32)
        return Points(middle, normal, normal, normal, np.zeros_like(normal), order), area

    def _sampled(self, points: Points, area: Array, ask: Callable[[Points, int], Array]) -> Array:
        """Irradiance (T, 3): four samples for a large triangle, one for every other small one.

        Each then takes the mean of its neighbours in the mesh, or of its part if none was asked.
        """
        large = area >= SMALL
        every_other = (np.arange(len(area)) * 7919) % 16 < 8  # in no step with the meshes' order
        irradiance, weight = np.zeros_like(points.position), np.zeros_like(area)
        for asked, samples in ((large, 4), (~large & every_other, 1)):
            index = np.flatnonzero(asked)
            irradiance[index], weight[index] = ask(points.at(index), samples), area[index] + 1e-9
        g = self.geometry
        return spread(irradiance, weight, g.faces, g.part, len(g.vertices), len(g.materials))

    def direct(self, points: Points, samples: int) -> tuple[Array, Array]:
        """Irradiance (N, 3) and mirrored radiance (N,) from lamps and windows, ``samples`` rays."""
        n = len(points.position)
        direction, reach = np.zeros((n, 3), np.float32), np.empty(n, np.float32)
        diffuse, shine = np.empty((n, 3), np.float32), np.empty(n, np.float32)
        irradiance, mirrored = np.zeros((n, 3), np.float32), np.zeros(n, np.float32)
        if not len(self.lights):
            return irradiance, mirrored
        for sample in range(samples):
            shading.lamp_rays(
                points.position, points.normal, points.shading, points.view, points.gloss,
                self.lights, self._seen.low, CELL, self._seen.seen, sample, points.order,
                direction, reach, diffuse, shine,
            )  # fmt: skip
            self._add_unblocked(points, direction, reach, diffuse, shine, irradiance, mirrored)
        return irradiance / np.float32(samples), mirrored / np.float32(samples)

    def sunlight(self, points: Points) -> tuple[Array, Array]:
        """Irradiance (N, 3) and mirrored radiance (N,) from the sun."""
        n = len(points.position)
        irradiance, mirrored = np.zeros((n, 3), np.float32), np.zeros(n, np.float32)
        outdoors = self.geometry.outdoors
        if outdoors.sun <= 0:
            return irradiance, mirrored
        towards = np.array(outdoors.towards_sun, np.float32)
        reach, diffuse = np.empty(n, np.float32), np.empty((n, 3), np.float32)
        shine = np.empty(n, np.float32)
        shading.sun_light(
            points.shading, points.normal, points.view, points.gloss, towards,
            np.float32(outdoors.sun), reach, diffuse, shine,
        )  # fmt: skip
        direction = np.broadcast_to(towards, (n, 3))
        self._add_unblocked(points, direction, reach, diffuse, shine, irradiance, mirrored)
        return irradiance, mirrored

    def gathered(self, points: Points, samples: int) -> Array:
        """Irradiance (N, 3) that other surfaces scatter and the open sky sends."""
        direction = np.empty_like(points.position)
        total = np.zeros_like(points.position)
        outside = self._outside(points.position)
        for sample in range(samples):
            shading.scattered_rays(points.normal, sample, points.order, direction)
            hits = self.tracer.nearest(points.position, direction)
            seen = self.met(hits, points.position)
            # windows are lamps already: what lies beyond them must not count twice
            seen[~outside] = np.minimum(seen[~outside], self._brightest)
            seen[self._outdoors[hits.triangle] & ~outside] = 0
            total += seen
        return total / np.float32(samples)

    def met(self, hits: Hits, origin: Array) -> Array:
        """Radiance (N, 3) of what rays from ``origin`` (N, 3) hit."""
        radiance = self.radiance[np.maximum(hits.triangle, 0)]
        sky = np.where(self._outside(origin), np.float32(self.geometry.outdoors.sky), 0)
        return np.where((hits.triangle < 0)[:, None], sky[:, None], radiance).astype(np.float32)

    def _outside(self, position: Array) -> NDArray[np.bool_]:
        """Which points (N, 3) lie out of doors."""
        x0, x1, y0, y1 = self.geometry.outdoors.house
        x, y = position[:, 0], position[:, 1]
        return (x < x0) | (x > x1) | (y < y0) | (y > y1)

    def _add_unblocked(
        self, points: Points, direction: Array, reach: Array, diffuse: Array, shine: Array,
        irradiance: Array, mirrored: Array,
    ) -> None:  # fmt: skip
        asked = np.flatnonzero(reach > 0)
        if not len(asked):
            return
        origin = points.position[asked]
        free = ~self.tracer.blocked(origin, direction[asked], reach[asked])
        lit = asked[free]
        irradiance[lit] += diffuse[lit]
        mirrored[lit] += shine[lit]
