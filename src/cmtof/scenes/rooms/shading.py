"""Light on surfaces, compiled: where rays hit, where lamps are asked for, how samples are smoothed.

Irradiance is in units of a white wall 1 m from a light of power 1; a white surface at irradiance 1
has radiance 1. Samples repeat every 8 x 8 pixels, so that a box of that size averages them all.
"""

import math
from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cmtof.scenes.rooms.patterns import pattern, value_noise

TILE = 8
"""Side of the blocks of pixels, of which each has the same set of samples."""


@lru_cache(maxsize=4)
def sample_order(height: int, width: int) -> NDArray[np.int32]:
    """Number (H·W,) of each pixel's samples: scrambled within a tile, other in the next tiles."""
    y, x = np.indices((height, width), dtype=np.int32).reshape(2, -1)
    tile = (x // TILE) % 4 + 4 * ((y // TILE) % 4)
    x, y = x % TILE, y % TILE
    return (29 * x + 37 * y + 8 * (x ^ y)) % 64 + 64 * ((7 * tile) % 16)


_STEPS = np.sqrt([2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53.0])

_OFFSET = 1e-4  # m, by which secondary rays start off their surface


@njit(cache=True, error_model="numpy", nogil=True, fastmath=True)
def surfaces(
    origin, directions, triangle, u, v, vertices, faces, normals, part, materials, pixel,
    distance, position, normal, shading, albedo, gloss,
):  # fmt: skip  # pragma: no cover - compiled
    """Fill, for every ray that hit: exact range, position, normals, reflectance and shine.

    Range is solved again in double precision from the triangle's plane: Embree's own is good to
    some micrometres only. ``pixel`` is the angle a pixel spans, rad: patterns finer than that
    fade to their mean.
    """
    for i in range(triangle.size):
        t = triangle[i]
        if t < 0:
            distance[i] = np.nan
            albedo[i] = 0
            continue
        a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
        ax, ay, az = (
            float(vertices[a, 0]),
            float(vertices[a, 1]),
            float(vertices[a, 2]),
        )
        e1x, e1y, e1z = vertices[b, 0] - ax, vertices[b, 1] - ay, vertices[b, 2] - az
        e2x, e2y, e2z = vertices[c, 0] - ax, vertices[c, 1] - ay, vertices[c, 2] - az
        nx, ny, nz = e1y * e2z - e1z * e2y, e1z * e2x - e1x * e2z, e1x * e2y - e1y * e2x
        size = math.sqrt(nx * nx + ny * ny + nz * nz)
        nx, ny, nz = nx / size, ny / size, nz / size
        dx, dy, dz = float(directions[i, 0]), float(directions[i, 1]), float(directions[i, 2])
        along = nx * dx + ny * dy + nz * dz
        k = i if len(origin) > 1 else 0
        ox, oy, oz = origin[k, 0], origin[k, 1], origin[k, 2]
        r = (nx * (ax - ox) + ny * (ay - oy) + nz * (az - oz)) / along
        distance[i] = r
        px, py, pz = ox + r * dx, oy + r * dy, oz + r * dz
        flip = -1.0 if along > 0 else 1.0
        normal[i, 0], normal[i, 1], normal[i, 2] = flip * nx, flip * ny, flip * nz
        position[i, 0] = px + _OFFSET * flip * nx
        position[i, 1] = py + _OFFSET * flip * ny
        position[i, 2] = pz + _OFFSET * flip * nz

        w = 1 - u[i] - v[i]
        sx = flip * (w * normals[a, 0] + u[i] * normals[b, 0] + v[i] * normals[c, 0])
        sy = flip * (w * normals[a, 1] + u[i] * normals[b, 1] + v[i] * normals[c, 1])
        sz = flip * (w * normals[a, 2] + u[i] * normals[b, 2] + v[i] * normals[c, 2])
        if sx * dx + sy * dy + sz * dz > -1e-3:  # turned away at an outline: take the plane's
            sx, sy, sz = normal[i, 0], normal[i, 1], normal[i, 2]
        m = materials[part[t]]
        f = m.from_world
        x = f[0, 0] * px + f[0, 1] * py + f[0, 2] * pz + f[0, 3]
        y = f[1, 0] * px + f[1, 1] * py + f[1, 2] * pz + f[1, 3]
        z = f[2, 0] * px + f[2, 1] * py + f[2, 2] * pz + f[2, 3]
        if m.bump > 0:
            g = 2.3
            sx += m.bump * (value_noise(g * x, g * y, g * z) - 0.5)
            sy += m.bump * (value_noise(g * x + 9, g * y, g * z) - 0.5)
            sz += m.bump * (value_noise(g * x, g * y + 9, g * z) - 0.5)
        size = math.sqrt(sx * sx + sy * sy + sz * sz)
        shading[i, 0], shading[i, 1], shading[i, 2] = sx / size, sy / size, sz / size
        if m.pattern == 0:
            mix, red, green, blue = 0.0, 1.0, 1.0, 1.0
        else:
            # the face's plane in pattern space: the axis along which its normal is longest is out
            lx = abs(f[0, 0] * nx + f[0, 1] * ny + f[0, 2] * nz)
            ly = abs(f[1, 0] * nx + f[1, 1] * ny + f[1, 2] * nz)
            lz = abs(f[2, 0] * nx + f[2, 1] * ny + f[2, 2] * nz)
            if lz >= lx and lz >= ly:
                mix, red, green, blue = pattern(m.pattern, x, y, z, x, y)
            elif ly >= lx:
                mix, red, green, blue = pattern(m.pattern, x, y, z, x, z)
            else:
                mix, red, green, blue = pattern(m.pattern, x, y, z, y, z)
            fine = min(1.0, max(0.0, 2.5 * r * pixel / (m.scale * max(-flip * along, 0.15)) - 0.5))
            mix += fine * (0.4 - mix)
            red += fine * (1 - red)
            green += fine * (1 - green)
            blue += fine * (1 - blue)
        albedo[i, 0] = min(0.95, (m.colour[0] + mix * (m.second[0] - m.colour[0])) * red)
        albedo[i, 1] = min(0.95, (m.colour[1] + mix * (m.second[1] - m.colour[1])) * green)
        albedo[i, 2] = min(0.95, (m.colour[2] + mix * (m.second[2] - m.colour[2])) * blue)
        gloss[i, 0], gloss[i, 1], gloss[i, 2] = m.specular, m.gloss, m.emission


@njit(cache=True, error_model="numpy", inline="always")
def _sample(index, dimension):  # pragma: no cover - compiled
    """Number in [0, 1): evenly spread in ``index`` and independent between dimensions.

    Multiples of square roots of primes (Kronecker's sequence).
    """
    value = (index + 0.5) * _STEPS[dimension % 16]
    return value - math.floor(value)


@njit(cache=True, error_model="numpy", nogil=True, fastmath=True)
def lamp_rays(
    position, normal, shading, view, gloss, lights, low, cell, seen, sample, order,
    direction, reach, diffuse, shine,
):  # fmt: skip  # pragma: no cover - compiled
    """One ray a point towards one of the lamps, drawn by how much it seems to give.

    ``low``, ``cell`` and ``seen`` are those of `cmtof.scenes.rooms.visibility`.

    Fills unit direction, reach (m), and what the point gets if nothing is in between:
    irradiance in three colours and mirrored radiance. No ray: reach 0.
    """
    count = len(lights)
    share = np.empty(count)
    for i in range(len(position)):
        reach[i] = 0
        diffuse[i] = 0
        shine[i] = 0
        if not normal[i, 0] * normal[i, 0] + normal[i, 1] * normal[i, 1] + normal[i, 2] ** 2 > 0.5:
            continue
        total = 0.0
        cx = min(max(int((position[i, 0] - low[0]) / cell), 0), seen.shape[0] - 1)
        cy = min(max(int((position[i, 1] - low[1]) / cell), 0), seen.shape[1] - 1)
        cz = min(max(int((position[i, 2] - low[2]) / cell), 0), seen.shape[2] - 1)
        for k in range(count):
            share[k] = 0.0
            if seen[cx, cy, cz, k] == 0:
                continue
            light = lights[k]
            x = light.centre[0] - position[i, 0]
            y = light.centre[1] - position[i, 1]
            z = light.centre[2] - position[i, 2]
            square = x * x + y * y + z * z + 0.02
            extent, high_u, high_v = 0.0, 0.0, 0.0
            for q in range(3):
                extent += light.half_u[q] ** 2 + light.half_v[q] ** 2
                high_u += light.half_u[q] * normal[i, q]
                high_v += light.half_v[q] * normal[i, q]
            d = math.sqrt(square)
            # the corner that stands highest above the point's horizon decides
            height = x * normal[i, 0] + y * normal[i, 1] + z * normal[i, 2]
            cosine = (height + abs(high_u) + abs(high_v)) / d
            front = -(x * light.normal[0] + y * light.normal[1] + z * light.normal[2])
            one_sided = light.normal[0] ** 2 + light.normal[1] ** 2 + light.normal[2] ** 2 > 0.5
            if cosine > 0 and (front > 0 or not one_sided):
                share[k] = light.power * min(cosine, 1.0) / (square + extent) * seen[cx, cy, cz, k]
                if one_sided:
                    share[k] *= min(1.0, front / d + 0.1)
            total += share[k]
        if total <= 0:
            continue
        index = order[i]
        pick = total * _sample(index, 3 * sample)
        k = 0
        while k < count - 1 and pick >= share[k]:
            pick -= share[k]
            k += 1
        if share[k] <= 0:
            continue
        light = lights[k]
        a = 2 * _sample(index, 3 * sample + 1) - 1
        b = 2 * _sample(index, 3 * sample + 2) - 1
        x = light.centre[0] + a * light.half_u[0] + b * light.half_v[0] - position[i, 0]
        y = light.centre[1] + a * light.half_u[1] + b * light.half_v[1] - position[i, 1]
        z = light.centre[2] + a * light.half_u[2] + b * light.half_v[2] - position[i, 2]
        d = math.sqrt(x * x + y * y + z * z) + 1e-9
        x, y, z = x / d, y / d, z / d
        cosine = x * shading[i, 0] + y * shading[i, 1] + z * shading[i, 2]
        plane = x * normal[i, 0] + y * normal[i, 1] + z * normal[i, 2]
        emitted = 1.0
        if light.normal[0] ** 2 + light.normal[1] ** 2 + light.normal[2] ** 2 > 0.5:
            emitted = -(x * light.normal[0] + y * light.normal[1] + z * light.normal[2])
        if cosine <= 0 or plane <= 0 or emitted <= 0:
            continue
        # no point gets more than the lamp's own radiance, pi power / area; a sample may exceed it,
        # but one that does by far would only show as a speck
        most = 2 * math.pi * light.power / max(_area(light.half_u, light.half_v), 1e-3)
        strength = min(light.power * emitted / (d * d + 1e-4), most) * total / share[k]
        direction[i, 0], direction[i, 1], direction[i, 2] = x, y, z
        reach[i] = d * 0.999
        for q in range(3):
            diffuse[i, q] = strength * cosine * light.colour[q]
        shine[i] = strength * cosine * _lobe(x, y, z, i, shading, view, gloss)


@njit(cache=True, error_model="numpy", inline="always")
def _area(u, v):  # pragma: no cover - compiled
    x, y, z = u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
    return 4 * math.sqrt(x * x + y * y + z * z)


@njit(cache=True, error_model="numpy", inline="always")
def _lobe(x, y, z, i, shading, view, gloss):  # pragma: no cover - compiled
    """Blinn's mirrored lobe (per white radiance) for light from (x, y, z), times the share."""
    hx, hy, hz = x - view[i, 0], y - view[i, 1], z - view[i, 2]
    size = math.sqrt(hx * hx + hy * hy + hz * hz) + 1e-9
    half = (hx * shading[i, 0] + hy * shading[i, 1] + hz * shading[i, 2]) / size
    exponent = min(gloss[i, 1], 400.0)
    return gloss[i, 0] * (exponent + 8) / 8 * max(half, 0.0) ** exponent


@njit(cache=True, error_model="numpy", nogil=True, fastmath=True)
def sun_light(
    shading, normal, view, gloss, towards, strength, reach, diffuse, shine
):  # fmt: skip  # pragma: no cover - compiled
    """What every point gets from the sun if nothing is in between; reach 0 where it turns away."""
    x, y, z = towards[0], towards[1], towards[2]
    for i in range(len(normal)):
        cosine = x * shading[i, 0] + y * shading[i, 1] + z * shading[i, 2]
        plane = x * normal[i, 0] + y * normal[i, 1] + z * normal[i, 2]
        lit = cosine > 0 and plane > 0
        reach[i] = 1000.0 if lit else 0.0
        diffuse[i] = strength * cosine if lit else 0.0
        shine[i] = strength * cosine * _lobe(x, y, z, i, shading, view, gloss) if lit else 0.0


@njit(cache=True, error_model="numpy", nogil=True, fastmath=True)
def scattered_rays(normal, sample, order, direction):  # pragma: no cover - compiled
    """One direction a point, by the cosine law about its normal."""
    for i in range(len(normal)):
        index = order[i]
        a, b = _sample(index, 2 * sample + 12), _sample(index, 2 * sample + 13)
        nx, ny, nz = normal[i, 0], normal[i, 1], normal[i, 2]
        radius, angle = math.sqrt(a), 2 * math.pi * b
        x, y, z = radius * math.cos(angle), radius * math.sin(angle), math.sqrt(1 - a)
        sign = 1.0 if nz >= 0 else -1.0  # Duff et al., JCGT 6(1), 2017: a basis without branches
        p = -1 / (sign + nz)
        q = nx * ny * p
        direction[i, 0] = x * (1 + sign * nx * nx * p) + y * q + z * nx
        direction[i, 1] = x * sign * q + y * (sign + ny * ny * p) + z * ny
        direction[i, 2] = -x * sign * nx - y * ny + z * nz


@njit(cache=True, error_model="numpy", nogil=True, fastmath=True)
def smoothed(
    image, triangle, part, normal, position, height, width, stride
):  # pragma: no cover - compiled
    """Mean over 8 x 8 pixels of (H·W, 8) along rows, then columns, within one smooth surface.

    ``stride`` is the distance between the pixels that are taken.
    """
    one, two = np.zeros_like(image), np.zeros_like(image)
    total = np.empty(8, np.float32)
    for axis in range(2):
        source, target = (image, one) if axis == 0 else (one, two)
        step = stride if axis == 0 else stride * width
        for y in range(height):
            for x in range(width):
                i = y * width + x
                if triangle[i] < 0:
                    continue
                here, last = (x, width) if axis == 0 else (y, height)
                low = max(axis - 4, -(here // stride))
                high = min(axis + 4, (last - 1 - here) // stride + 1)
                count = np.float32(0)
                total[:] = 0
                for k in range(low, high):
                    j = i + k * step
                    if triangle[j] == triangle[i] or (
                        part[j] == part[i] and _one_surface(i, j, normal, position)
                    ):
                        for q in range(8):
                            total[q] += source[j, q]
                        count += np.float32(1)
                for q in range(8):
                    target[i, q] = total[q] / count
    return two


@njit(cache=True, error_model="numpy", inline="always")
def _one_surface(i, j, normal, position):  # pragma: no cover - compiled
    cosine, off = 0.0, 0.0
    for q in range(3):
        cosine += normal[i, q] * normal[j, q]
        off += normal[i, q] * (position[j, q] - position[i, q])
    return cosine > 0.85 and abs(off) < 0.02
