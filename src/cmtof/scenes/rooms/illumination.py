"""How much light reaches a point: lamps, windows, sun, and what other surfaces scatter.

Light is followed over three bounces. The irradiance of every triangle, from lamps and from one
bounce, is found once a scene and serves all its cameras; a pixel then asks lamps and sun by itself
and gathers the rest from the triangles that it sees.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cmtof.scenes.rooms import shading
from cmtof.scenes.rooms.assembly import Geometry
from cmtof.scenes.rooms.materials import PATTERNS
from cmtof.scenes.rooms.sunlight import sun_patches
from cmtof.scenes.rooms.tracing import Hits, Tracer

Array = NDArray[np.float32]

BRIGHTEST = np.float32(4.0)
"""Radiance at which scattered light is cut: rare bright rays would show as specks."""

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
    width: int = 0
    """Pixels a row; 0 for points that are no image."""


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
        g = self.geometry
        m = g.materials
        mix = _MEAN_MIX[m["pattern"]][:, None]
        colour = m["colour"] * (1 - mix) + m["second"] * mix
        self.albedo = (colour * (1 - m["specular"][:, None]))[g.part].astype(np.float32)
        self._glow = (m["colour"] * m["emission"][:, None])[g.part].astype(np.float32)
        corners = g.vertices[g.faces]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-20)
        # a slim triangle's centre may touch its neighbour: start a little above it
        centres = Points(
            (corners.mean(axis=1) + 1e-3 * normal).astype(np.float32),
            normal, normal, normal, np.zeros_like(normal),
        )  # fmt: skip
        # patches of sun are lamps from here on, so the triangles' own light leaves the sun out
        patches = sun_patches(g, self.tracer, self.albedo)
        self.lights = np.concatenate([g.lights, patches])
        self.radiance = self._glow.copy()
        direct = self.direct(centres, samples=2)[0]
        self.radiance += self.albedo * direct
        self.radiance = self._glow + self.albedo * (direct + self.gathered(centres, samples=2))

    def direct(self, points: Points, *, samples: int) -> tuple[Array, Array]:
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
                self.lights, sample, points.width, direction, reach, diffuse, shine,
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

    def gathered(self, points: Points, *, samples: int) -> Array:
        """Irradiance (N, 3) that other surfaces scatter and the open sky sends."""
        direction = np.empty_like(points.position)
        total = np.zeros_like(points.position)
        for sample in range(samples):
            shading.scattered_rays(points.normal, sample, points.width, direction)
            total += np.minimum(self.seen(points.position, direction), BRIGHTEST)
        return total / np.float32(samples)

    def seen(self, origin: Array, direction: Array) -> Array:
        """Radiance (N, 3) along rays (N, 3); the sky only for those that start out of doors.

        Within the house the windows are lamps already, and what enters must not count twice.
        """
        return self.met(self.tracer.nearest(origin, direction), origin)

    def met(self, hits: Hits, origin: Array) -> Array:
        """Radiance (N, 3) of what rays from ``origin`` (N, 3) hit."""
        radiance = self.radiance[np.maximum(hits.triangle, 0)]
        x0, x1, y0, y1 = self.geometry.outdoors.house
        x, y = origin[:, 0], origin[:, 1]
        outside = (x < x0) | (x > x1) | (y < y0) | (y > y1)
        sky = np.where(outside, np.float32(self.geometry.outdoors.sky), np.float32(0))
        return np.where((hits.triangle < 0)[:, None], sky[:, None], radiance)

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
