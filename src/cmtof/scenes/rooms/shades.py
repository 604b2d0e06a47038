"""What makes a lamp: bulbs, shades lit from within, and the light that gets out of them."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from cmtof.scenes.rooms.materials import Colour, Material, hue
from cmtof.scenes.rooms.pliant import across, bars, unit
from cmtof.scenes.rooms.solids import ball, cylinder, revolve, rod
from cmtof.scenes.rooms.thing import Light, Mesh, Thing

Maker = Callable[..., Thing]

WARM: Colour = (1.15, 1.0, 0.78)
"""Light of a bulb; green is 1, the channel that the pictures are made from."""
GLOW = Material((0.92, 0.9, 0.84), emission=4.0, specular=0.0)
"""A bulb that burns."""
LINING = Material((0.86, 0.84, 0.8), emission=0.9, specular=0.02)
"""White inside of a shade, lit from near by."""
BLACK = Material((0.02, 0.02, 0.02), specular=0.05, gloss=20.0)
BRASS = Material((0.62, 0.45, 0.18), specular=0.65, gloss=120.0)


def power(rng: np.random.Generator, low: float, high: float) -> float:
    """Radiant intensity over pi: a white wall 1 m away gets that irradiance."""
    return float(rng.uniform(low, high))


def cloth(rng: np.random.Generator) -> Material:
    """Paper or linen of a shade, lit from within: white to sand, now and then a colour."""
    if rng.uniform() < 0.75:
        white = float(rng.uniform(0.55, 0.85))
        colour = (white, 0.95 * white, float(rng.uniform(0.7, 0.92)) * white)
    else:
        colour = hue(float(rng.uniform()), 0.6, 0.35)
    other = tuple(0.9 * c for c in colour)
    glow = float(rng.uniform(0.5, 1.3))
    return Material(colour, other, "weave", 0.006, specular=0.0, emission=glow)  # type: ignore[arg-type]


def bulb(thing: Thing, x: float, y: float, z: float, radius: float = 0.03, up: int = 1) -> None:
    """A glowing bulb about (x, y, z), m, on its socket; ``up`` is 1 when the socket is below."""
    r = radius
    profile = np.array([(0.45, -1.7), (0.5, -1.3), (0.92, -0.45), (1, 0), (0.75, 0.66), (0, 1)])
    glass = revolve(r * profile, 14)
    socket = cylinder(0.5 * r, 1.6 * r, (0, 0, -2.3 * r), sides=10)
    for mesh, material in ((glass, GLOW), (socket, BLACK)):
        turned = mesh.vertices * np.array([1, up, up], np.float32) + np.array([x, y, z], np.float32)
        thing.add(Mesh(turned, mesh.faces), material)


def shine(
    thing: Thing, centre: tuple[float, float, float], strength: float, half: float = 0.05
) -> None:
    """Light all around from a small level square about ``centre``, m."""
    thing.lights.append(Light(centre, (half, 0, 0), (0, half, 0), strength, colour=WARM))


def glow_around(
    thing: Thing, centre: tuple[float, float, float], radius: float, strength: float
) -> None:
    """Light of a closed glowing body: a square that reaches out of it, as the body is opaque.

    About half of the square is hidden by the body from wherever one looks, hence twice the power.
    """
    shine(thing, centre, 2 * strength, half=1.25 * radius)


def shade(
    thing: Thing,
    profile: ArrayLike,
    outside: Material,
    inside: Material = LINING,
    *,
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0),
    axis: ArrayLike = (0.0, 0.0, 1.0),
    sides: int = 32,
    thickness: float = 0.002,
) -> None:
    """A turned shell, open where its profile (radius, height) begins and ends, m.

    ``axis`` is where the profile's height points.
    """
    p = np.asarray(profile, float)
    along = unit(np.gradient(p, axis=0))
    inner = p - thickness * np.stack([along[:, 1], -along[:, 0]], -1)
    inner[:, 0] = np.maximum(inner[:, 0], 1e-4)
    outer = revolve(p, sides)
    lining = revolve(np.concatenate([p[-1:], inner[::-1], inner[:1], p[:1]]), sides)
    thing.add(_turned(outer, axis, centre), outside)
    thing.add(_turned(lining, axis, centre), inside)


def _turned(mesh: Mesh, axis: ArrayLike, centre: ArrayLike) -> Mesh:
    """A mesh with its z axis along ``axis`` and its origin at ``centre``."""
    one, two = across(axis)
    frame = np.stack([one, two, unit(axis)])
    vertices = mesh.vertices @ frame + np.asarray(centre, float)
    return Mesh(vertices.astype(np.float32), mesh.faces)


def spider(thing: Thing, radius: float, z: float, metal: Material, drop: float = 0.02) -> None:
    """Three wires that hold a shade of that radius to its stem."""
    angle = np.arange(3) * (2 * np.pi / 3) + 0.4
    ends = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(3, z)], -1)
    starts = np.tile([0.0, 0.0, z - drop], (3, 1))
    thing.add(bars(starts, ends, 0.0015), metal)


def drum(
    rng: np.random.Generator,
    thing: Thing,
    z: float,
    radius: float,
    strength: float,
    metal: Material,
) -> None:
    """A cloth shade, drum to cone, whose lower edge is at z, with its bulb and its light."""
    height = radius * float(rng.uniform(0.9, 1.4))
    top = radius * float(rng.choice([0.95, 0.75, 0.55]))
    sides = int(rng.choice([32, 32, 6]))
    rise = np.linspace(0, 1, 5)
    bell = float(rng.choice([0.0, 0.0, 0.25])) * np.sin(np.pi * rise)
    profile = np.column_stack([radius + (top - radius) * (rise + bell), z + height * rise])
    shade(thing, profile, cloth(rng), sides=sides)
    spider(thing, 0.99 * top, z + 0.93 * height, metal)
    bulb(thing, 0, 0, z + 0.45 * height, 0.02 if top < 0.1 else 0.03)
    thing.add(rod((0, 0, z - 0.06), (0, 0, z + 0.94 * height), 0.004), metal)
    shine(thing, (0, 0, z + 0.45 * height), strength, half=min(0.06, 0.6 * top))


def spot(
    thing: Thing, neck: ArrayLike, aim: ArrayLike, radius: float, length: float,
    outside: Material, strength: float,
) -> None:  # fmt: skip
    """A small conical head at ``neck`` that looks along ``aim``, with its bulb and its light."""
    neck, aim = np.asarray(neck, float), unit(aim)
    depth = np.array([0, 0.02, 0.25, 0.6, 1.0]) * length
    width = np.array([0.12, 0.38, 0.45, 0.72, 1.0]) * radius
    # the profile runs from the mouth back to the neck, against the aim
    profile = np.column_stack([width[::-1], length - depth[::-1]])
    mouth = neck + length * aim
    shade(thing, profile, outside, centre=tuple(mouth), axis=-aim, sides=24)
    globe = neck + 0.62 * length * aim
    thing.add(ball(0.38 * radius, globe, 2), GLOW)
    at = mouth - 0.05 * length * aim
    one, two = across(aim)
    half = 0.5 * radius
    thing.lights.append(
        Light(tuple(at), tuple(half * one), tuple(half * two), strength, tuple(aim), WARM)
    )
