"""Makers of lamps, vessels, plants, pictures, fabrics, and of what is fixed to a room.

Each fills a box and has options that `presets.yml` names; see `cmtof_rooms.kit`.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cmtof_rooms.boxes import Box, Rectangle
from cmtof_rooms.kit import Glow, Kit, Piece, Top
from cmtof_rooms.materials import Material
from cmtof_rooms.solids import ball, box, ellipse, extrusion, move, revolution, sheet, slab, sweep


def lamp(kit: Kit, space: Box, *, style: str = "stand", power: float = 1.0) -> Piece:
    """A lamp on a stand, a pendant on its cord, or a panel under the ceiling."""
    height = space.z1
    radius = min(space.x1, space.y1)
    shade = kit.material("shade")._replace(emission=power)
    if style == "panel":
        yield Glow(-0.01, radius, -1.0, power)
        yield kit.part(shade, space)
        return
    tall = min(kit.between(0.6, 1.2) * 2 * radius, 0.45 * height)
    narrow = radius * kit.between(0.4, 1.0)
    metal = kit.material("metal")
    if style == "stand":
        foot = min(0.7 * radius, 0.16)
        stand = [(foot, 0), (foot, 0.02), (0.012, 0.03), (0.012, height - tall)]
        cone = revolution([(radius, 0), (narrow, tall)])
        yield Glow(height + 0.05, 0.5 * narrow, 0.0, power)
        yield kit.part(metal, revolution(stand))
        yield kit.part(shade, move(cone, (0, 0, height - tall)))
    else:
        yield Glow(-0.03, radius, -1.0, power)
        if kit.chance(0.4):
            body = ball((radius, radius, tall / 2))
        else:
            body = revolution([(radius, -tall / 2), (narrow, tall / 2)])
        yield kit.part(shade, move(body, (0, 0, tall / 2)))
        yield kit.part(metal, sweep([(0, 0, tall), (0, 0, height)], 0.008, 6))


def vessel(kit: Kit, space: Box, *, profile: str = "vase", material: str = "ceramic") -> Piece:
    """A turned vessel, of another width than depth where the size says so."""
    turned = revolution(np.array(kit.profiles[profile]) * [0.5, 1], sections=32)
    turned.vertices = turned.vertices * space.size
    yield kit.part(material, turned)


def blob(
    kit: Kit,
    space: Box,
    *,
    material: str = "fabric",
    noise: float = 0.1,
    squareness: float = 0.0,
) -> Piece:
    """Something soft or grown: cushion, fruit, stone, toy."""
    body = ball(1.0, noise=noise, rng=kit.rng, squareness=squareness, fineness=3)
    low, high = body.bounds
    body.vertices = (body.vertices - (low + high) / 2) * space.size / (high - low)
    yield kit.part(material, move(body, (0, 0, space.z1 / 2)))


def cloth(kit: Kit, space: Box, *, style: str = "curtain", material: str = "fabric") -> Piece:
    """A curtain in folds, a rug on the floor, or a towel that hangs."""
    width, depth, height = space.size
    if style == "rug":
        corners = np.array([(-width, -depth), (width, -depth), (width, depth), (-width, depth)])
        outline = ellipse(width, depth, 40) if kit.chance(0.2) else corners / 2
        yield kit.part(material, extrusion(outline, height))
        return
    thickness = 0.006
    folds = kit.between(5, 9) * width if style == "curtain" else kit.between(0.5, 2)
    columns = np.linspace(-width / 2, width / 2, max(9, int(10 * folds) + 1))
    x, z = np.meshgrid(columns, np.linspace(0, height, 7), indexing="ij")
    phase = kit.between(0, 2 * np.pi) + 0.3 * np.sin(3 * z / height + kit.between(0, 6))
    wave = np.sin(2 * np.pi * folds * (x / width + 0.5) + phase)
    y = (depth / 2 - thickness) * wave * (1 - 0.3 * z / height)
    yield kit.part(material, sheet(np.stack([x, y, z], -1), thickness))


def plant(kit: Kit, space: Box, *, style: str = "leaves") -> Piece:
    """A plant in a pot: single leaves on stems, or a bush."""
    height = space.z1
    width = 2 * min(space.x1, space.y1)
    pot = min(0.35 * height, 0.6 * width)
    crown = height - pot
    yield from vessel(kit, Box.standing((0.9 * pot, 0.9 * pot, pot)), profile="pot")
    green = kit.material("leaf")
    if style == "bush":
        leaves = Box.standing((width, width, 0.9 * crown))
        bush = next(blob(kit, leaves, material="leaf", noise=0.35))
        yield kit.part(green, move(bush.mesh, (0, 0, pot + 0.1 * crown)))
        stem = [(0, 0, 0.8 * pot), (0, 0, pot + 0.3 * crown)]
        yield kit.part(green, sweep(stem, 0.03 * pot + 0.01, 6))
    else:
        yield from _leaves(kit, green, width, pot, crown)


def _leaves(kit: Kit, green: Material, width: float, pot: float, crown: float) -> Piece:
    """Leaves of a plant, each on a bent stem that starts in its pot."""
    leaf = ball((0.2 * width, 0.085 * width, 0.008), fineness=1)
    leaves = []
    stems = []
    for k in range(kit.count((7, 17))):
        turn = 2.4 * k + kit.between(-0.3, 0.3)
        out = kit.between(0.2, 0.6)
        way = np.array([np.cos(turn), np.sin(turn)]) * width / 2
        tip = [*(out * way), pot + crown * kit.between(0.35, 0.88)]
        bend = [*(0.3 * out * way), (pot + tip[2]) / 2]
        stems.append(sweep([(0, 0, 0.8 * pot), bend, tip], 0.004 + 0.004 * crown, 5))
        leaves.append(move(leaf, tip, turn))
    yield kit.part(green, *leaves)
    yield kit.part(green, *stems)


def picture(
    kit: Kit,
    space: Box,
    *,
    frame: float = 0.03,
    material: str = "picture",
    emission: float = 0.0,
) -> Piece:
    """A framed panel: picture, mirror, screen, board; upright, its back at +y."""
    width, depth, _ = space.size
    edge = min(frame, width / 6)
    half = edge / 2
    paint = kit.material(material)._replace(emission=emission)
    yield kit.part(paint, space.inset(x0=half, x1=half, y0=depth / 3, z0=half, z1=half))
    upright = space.inset(z0=edge, z1=edge)
    yield kit.part(
        kit.material("wood", "metal"),
        space.layer("z0", edge),
        space.layer("z1", edge),
        upright.layer("x0", edge),
        upright.layer("x1", edge),
    )


def pipe(kit: Kit, space: Box, *, count: Sequence[int] = (1, 2), level: bool = False) -> Piece:
    """Upright pipes from floor to height, or level rails from side to side."""
    width, depth, height = space.size
    metal = kit.material("metal")
    number = kit.count(count)
    radius = min(0.4 * depth, 0.03)
    y = depth / 2 - radius
    for k in range(number):
        x = width * ((k + 0.5) / number - 0.5)
        z = radius + (height - 2 * radius) * k / max(number - 1, 1)
        corners = [(space.x0, y), (space.x0, -y), (space.x1, -y), (space.x1, y)]
        path = [(*corner, z) for corner in corners] if level else [(x, 0, 0), (x, 0, height)]
        yield kit.part(metal, sweep(_rounded(path), radius, 10))


def _rounded(path: Sequence[Sequence[float]]) -> NDArray[np.float64]:
    """The path with three points close to each inner corner."""
    line = np.array(path, float)
    points = [line[0]]
    for before, corner, after in zip(line[:-2], line[1:-1], line[2:], strict=True):
        a = corner + 0.2 * (before - corner)
        b = corner + 0.2 * (after - corner)
        points += [a, (a + b + 2 * corner) / 4, b]
    return np.array([*points, line[-1]])


def radiator(kit: Kit, space: Box) -> Piece:
    """Upright fins between two rails, on feet."""
    width, depth, height = space.size
    x = np.linspace(-width / 2 + 0.02, width / 2 - 0.02, max(3, int(width / 0.07)))
    places = np.outer(x, [1, 0, 0])
    up = np.array([0, 0, height])
    yield kit.part(
        "paint",
        box((0.04, depth, 0.86 * height), places + 0.54 * up),
        box((width - 0.04, 0.5 * depth, 0.04), np.outer([0.16, 0.92], up)),
        box((0.03, 0.6 * depth, 0.12 * height), places[[0, -1]] + 0.06 * up),
    )


def stairs(kit: Kit, space: Box, *, rail: bool = True) -> Piece:
    """A flight of steps along x that rises to height, with a banister on its free side."""
    count = max(2, round(space.z1 / 0.18))
    x = np.linspace(space.x0, space.x1, count + 1)
    z = np.linspace(0, space.z1, count + 1)[1:]
    yield kit.part("wood", space.cut(x0=x[:-1], x1=x[1:], z1=z))
    if rail:
        feet = np.stack([(x[:-1] + x[1:]) / 2, np.full(count, space.y0 + 0.04), z], 1)
        tops = feet + np.array([0, 0, 0.9])
        bars = [sweep(ends, 0.012, 6) for ends in np.stack([feet, tops], 1)]
        yield kit.part("metal", *bars)
        yield kit.part("wood", sweep(tops, 0.025, 8))


def stack(
    kit: Kit,
    space: Box,
    *,
    count: Sequence[int] = (1, 4),
    material: str = "paper",
) -> Piece:
    """Boxes or books piled up, each turned a little; one of them is a plain case."""
    width, depth, height = space.size
    number = kit.count(count)
    shares = np.sort(kit.rng.uniform(0.15, 1, number - 1))
    levels = height * np.unique([0.0, *shares.round(2), 1.0])
    for low, high in pairwise(levels):
        turn = kit.between(-0.15, 0.15) if number > 1 else 0.0
        longer = max(width / depth, depth / width)
        fit = 0.5 / (np.cos(turn) + longer * abs(np.sin(turn)))
        a = width * fit * _share(kit, number)
        b = depth * fit * _share(kit, number)
        solid = slab(-a, a, -b, b, low, high - 1e-3)
        yield kit.part(material, move(solid, (0, 0, 0), turn))
    yield Top(Rectangle.about(0, 0, 2 * width / 3, 2 * depth / 3), height, 0.4)


def _share(kit: Kit, number: int) -> float:
    """How much of its place one of several piled boxes takes; a single one takes all."""
    return 1.0 if number == 1 else kit.between(0.75, 1.0)
