"""Shaping of small things: turned ware, spouts, modelled clay, and standing them on z = 0."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.rooms.joinery import rounded
from cmtof.scenes.rooms.pliant import spline
from cmtof.scenes.rooms.solids import ball, revolve, sheet, tube
from cmtof.scenes.rooms.thing import Mesh, Thing, pose, transformed

Points = NDArray[np.float64]
Bump = tuple[tuple[float, float, float], float, float]
"""Direction from the middle, angular width, rad, and height as a share of the radius."""


def pick(rng: np.random.Generator, *choices: float) -> float:
    """One of several sizes."""
    return float(choices[int(rng.integers(len(choices)))])


def resampled(path: ArrayLike, count: int) -> Points:
    """A line (N, D) at ``count`` points, closer together where it bends.

    Examples
    --------
    >>> resampled([[0, 0], [1, 0], [2, 0]], 5)[:, 0].tolist()
    [0.0, 0.5, 1.0, 1.5, 2.0]
    """
    path = np.asarray(path, float)
    step = np.diff(path, axis=0)
    length = np.linalg.norm(step, axis=1)
    way = step / (length[:, None] + 1e-12)
    turn = np.arccos(np.clip((way[1:] * way[:-1]).sum(1), -1, 1))
    bend = np.zeros(len(path))
    bend[1:-1] = np.where((length[1:] > 1e-9) & (length[:-1] > 1e-9), turn, 0.0)
    cost = length / length.sum()
    if bend.sum() > 1e-6:
        cost = cost + 0.5 * (bend[1:] + bend[:-1]) / bend.sum()
    at = np.concatenate([[0.0], np.cumsum(cost)])
    wanted = np.linspace(0, at[-1], count)
    return np.stack([np.interp(wanted, at, column) for column in path.T], -1)


def turned(profile: ArrayLike, sides: int = 28, count: int = 20) -> Mesh:
    """A body turned from a few corners (N, 2) of radius and height, m, its corners rounded."""
    return revolve(resampled(rounded(profile), count), sides)


def hollow(
    profile: ArrayLike, wall: float, *, floor: float | None = None, sides: int = 28, count: int = 15
) -> Mesh:
    """A turned vessel with a wall, a rounded rim and an inside.

    Parameters
    ----------
    profile : array_like, shape (N, 2)
        Corners of the outside, radius and height, m, from the middle of the bottom to the rim.
    wall : float
        m.
    floor : float, optional
        Height of the inside's lowest point, m; ``wall`` above the bottom by default.
    """
    outer = resampled(rounded(profile), count)
    inner, rim = inside(outer, wall, floor)
    return revolve(np.concatenate([outer, rim, inner[::-1]]), sides)


def inside(outer: Points, wall: float, floor: float | None = None) -> tuple[Points, Points]:
    """Profile of a vessel's inside, from its bottom up, and the point on top of its rim."""
    way = np.gradient(outer, axis=0)
    way /= np.linalg.norm(way, axis=1, keepdims=True) + 1e-12
    inner = outer + wall * np.stack([-way[:, 1], way[:, 0]], -1)
    bottom = float(outer[:, 1].min()) + wall if floor is None else floor
    inner = inner[(inner[:, 1] > bottom + 0.3 * wall) & (inner[:, 0] > 0.3 * wall)]
    inner = resampled(inner, max(6, 3 * len(inner) // 4))
    walls = np.interp(inner[:, 1], np.maximum.accumulate(outer[:, 1]), outer[:, 0])
    inner[:, 0] = np.minimum(inner[:, 0], walls - 0.5 * wall)
    low = [(0.0, bottom), (0.7 * inner[0, 0], bottom)]
    rim = (outer[-1:] + inner[-1:]) / 2 + 0.4 * wall * way[-1:]
    return np.concatenate([low, inner]), rim


def outline_radius(corners: ArrayLike, wall: float) -> tuple[Points, Points]:
    """Radii and heights along the inside of the vessel that `hollow` turns from corners, m."""
    fine = resampled(rounded(np.asarray(corners, float)), 60)
    inner, _ = inside(fine, wall)
    inner = resampled(inner, 200)
    return inner[:, 0], inner[:, 1]


def handle(points: ArrayLike, radius: ArrayLike, *, count: int = 12, sides: int = 8) -> Mesh:
    """A round bar bent smoothly through points (N, 3), m."""
    path = spline(points, count)
    thick = np.asarray(radius, float)
    if thick.ndim:
        thick = np.interp(np.linspace(0, 1, count), np.linspace(0, 1, len(thick)), thick)
    return tube(path, thick, sides)


def pipe(path: ArrayLike, radius: ArrayLike, wall: float, sides: int = 10) -> Mesh:
    """A tube that one can look into at its far end: spouts, necks, drain pipes."""
    path = np.asarray(path, float)
    radius = np.broadcast_to(np.asarray(radius, float), len(path))
    rings = tube(path, radius, sides, capped=False).vertices.reshape(len(path), sides, 3)
    share = (1 - wall / radius)[:, None, None]
    inner = path[:, None] + share * (rings - path[:, None])
    return sheet(np.concatenate([rings, inner[::-1]]), closed=True)


def modelled(
    size: ArrayLike,
    bumps: Sequence[Bump] = (),
    centre: ArrayLike = (0.0, 0.0, 0.0),
    *,
    subdivisions: int = 3,
) -> Mesh:
    """An ellipsoid as of clay: bumps raised on it and hollows pressed into it.

    The radius along the unit vector u grows by the sum of ``a exp((u·d - 1) / w²)`` over bumps
    with direction d, width w and height a.
    """
    unit = ball(1.0, subdivisions=subdivisions)
    swell = np.ones(len(unit.vertices))
    for direction, width, height in bumps:
        way = np.asarray(direction, float)
        swell += height * np.exp((unit.vertices @ (way / np.linalg.norm(way)) - 1) / width**2)
    points = unit.vertices * swell[:, None] * (np.asarray(size, float) / 2)
    return Mesh((points + np.asarray(centre, float)).astype(np.float32), unit.faces)


def stretched(mesh: Mesh, x: float, y: float, z: float) -> Mesh:
    """A mesh longer or shorter along the axes."""
    return Mesh(mesh.vertices * np.array([x, y, z], np.float32), mesh.faces)


def laid(mesh: Mesh, axis: int = 0) -> Mesh:
    """A turned body whose upright axis becomes x (0), or -y (1): wheels, knobs, lenses."""
    turns = ([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], [[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    return Mesh(mesh.vertices @ np.array(turns[axis], np.float32).T, mesh.faces)


def shifted_by(thing: Thing, shift: Points) -> Thing:
    """A copy of a thing, moved with all that it carries, m."""
    dx, dy, dz = (float(v) for v in shift)
    return replace(thing, parts=[part._replace(mesh=Mesh((part.mesh.vertices +
        shift).astype(np.float32), part.mesh.faces)) for part in thing.parts],
        supports=[s._replace(x0=s.x0 + dx, x1=s.x1 + dx, y0=s.y0 + dy, y1=s.y1 + dy,
        z=s.z + dz) for s in thing.supports], children=[(child,
        pose(dx, dy, dz) @ motion) for child, motion in thing.children])  # fmt: skip


def stood(thing: Thing) -> Thing:
    """A copy with its footprint's middle at the origin and its lowest point at z = 0."""
    low, high = thing.bounds
    return shifted_by(thing, -np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]))


def on_wall(thing: Thing) -> Thing:
    """A copy whose back touches the wall, y = 0, about x = 0 and z = 0."""
    low, high = thing.bounds
    return shifted_by(thing, -np.array([(low[0] + high[0]) / 2, high[1], (low[2] + high[2]) / 2]))


def absorbed(thing: Thing, other: Thing, motion: Points) -> Thing:
    """Take over the parts of another thing as its own, moved by a pose; returns the first."""
    for part in other.parts:
        points = transformed(part.mesh.vertices, motion).astype(np.float32)
        thing.add(Mesh(points, part.mesh.faces), part.material, part.grain)
    return thing
