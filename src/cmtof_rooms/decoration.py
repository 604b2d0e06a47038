"""Makers of lamps, vessels, plants, pictures, fabrics, and of what is fixed to a room.

Each fills a box and has options that `presets.yml` names; see `cmtof_rooms.kit`.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from trimesh import Trimesh

from cmtof_rooms.boxes import Box
from cmtof_rooms.kit import Kit, Piece, Solids
from cmtof_rooms.materials import Material
from cmtof_rooms.presets import presets
from cmtof_rooms.solids import (
    ball,
    ellipse,
    extrusion,
    move,
    revolution,
    sheet,
    slab,
    sweep,
)
from cmtof_rooms.things import level_light


def lamp(kit: Kit, space: Box, *, style: str = "stand") -> Piece:
    """A lamp on a stand, a pendant on its cord, or a panel under the ceiling."""
    height = space.z1
    radius = min(space.x1, space.y1)
    shade = kit.material("shade")._replace(emission=1.0)
    if style == "panel":
        yield level_light((0, 0, -0.01), radius, 1.0)
        yield shade, space
        return
    tall, narrow = kit.draw("shade")
    tall = min(tall * 2 * radius, 0.45 * height)
    narrow *= radius
    metal = kit.material("metal")
    cone = revolution([(radius, 0), (narrow, tall)])
    if style == "stand":
        foot = min(0.7 * radius, 0.16)
        stand = [(foot, 0), (foot, 0.02), (0.012, 0.03), (0.012, height - tall)]
        yield level_light((0, 0, height + 0.05), 0.5 * narrow, 1.0, 0.0)
        yield metal, revolution(stand)
        yield shade, move(cone, (0, 0, height - tall))
    else:
        yield level_light((0, 0, -0.03), radius, 1.0)
        globe = move(ball((radius, radius, tall / 2)), (0, 0, tall / 2))
        yield shade, globe if kit.chance(0.4) else cone
        yield metal, sweep([(0, 0, tall), (0, 0, height)], 0.008, 6)


def vessel(
    kit: Kit,
    space: Box,
    *,
    profile: str = "vase",
    material: str = "ceramic",
) -> Piece:
    """A vessel of revolution, stretched to the width, depth and height of a space."""
    turned = revolution(presets()["profiles"][profile], sections=32)
    turned.vertices = turned.vertices * space.size * [0.5, 0.5, 1]
    yield material, turned


def blob(
    kit: Kit,
    space: Box,
    *,
    material: str = "fabric",
    noise: float,
    squareness: float = 0.0,
) -> Iterator[Solids]:
    """A rounded, uneven body: cushion, fruit, stone, toy."""
    body = ball(
        1.0,
        noise=noise,
        rng=kit.rng,
        squareness=squareness,
        fineness=3,
    )
    centred = body.vertices - body.bounds.mean(axis=0)
    body.vertices = centred * space.size / body.extents + space.middle
    yield material, body


def cloth(
    kit: Kit,
    space: Box,
    *,
    style: str = "curtain",
) -> Piece:
    """A curtain in folds, or a towel that hangs."""
    width, _, height = space.size
    thickness = 0.006
    folds, phase, shift = kit.draw(style)
    if style == "curtain":
        folds *= width
    columns = np.linspace(space.x0, space.x1, max(9, int(10 * folds) + 1))
    x, z = np.meshgrid(columns, np.linspace(0, height, 7), indexing="ij")
    phase = phase + 0.3 * np.sin(3 * z / height + shift)
    wave = np.sin(2 * np.pi * folds * (x / width + 0.5) + phase)
    y = (space.y1 - thickness) * wave * (1 - 0.3 * z / height)
    yield "fabric", sheet(np.stack([x, y, z], -1), thickness)


def rug(kit: Kit, space: Box) -> Piece:
    """A rug on the floor, a fifth of them oval."""
    size = space.size[:2]
    corners = size / [(-2, -2), (2, -2), (2, 2), (-2, 2)]
    outline = ellipse(size, 40) if kit.chance(0.2) else corners
    yield "fabric", extrusion(outline, space.z1)


def plant(kit: Kit, space: Box, *, style: str = "leaves") -> Piece:
    """A plant in a pot: single leaves on stems, or a bush."""
    height = space.z1
    width = 2 * min(space.x1, space.y1)
    pot = min(0.35 * height, 0.6 * width)
    crown = height - pot
    yield from vessel(kit, Box.standing((0.9 * pot, 0.9 * pot, pot)), profile="pot")
    green = kit.material("leaf")
    if style == "bush":
        leaves = Box.standing((width, width, height)).cut(z0=pot + 0.1 * crown)
        bush = kit.part(*next(blob(kit, leaves, material="leaf", noise=0.35)))
        yield green, bush.mesh
        ends = [(0, 0, 0.8 * pot), (0, 0, pot + 0.3 * crown)]
        yield green, sweep(ends, 0.03 * pot + 0.01, 6)
    else:
        yield from _leaves(kit, green, width, pot, crown)


def _leaves(kit: Kit, green: Material, width: float, pot: float, crown: float) -> Piece:
    """Leaves of a plant, and the bent stems that carry them out of its pot."""
    leaf = ball((0.2 * width, 0.085 * width, 0.008), fineness=1)
    leaves = []
    stems = []
    for k in range(kit.count((7, 17))):
        turn, reach, rise = kit.draw("leaf")
        turn += 2.4 * k
        tip = reach * width / 2 * np.array([np.cos(turn), np.sin(turn)])
        top = pot + crown * rise
        stem = [(0, 0, 0.8 * pot), (*0.3 * tip, (pot + top) / 2), (*tip, top)]
        stems.append(sweep(stem, 0.004 + 0.004 * crown, 5))
        leaves.append(move(leaf, stem[-1], turn))
    yield green, *leaves
    yield green, *stems


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
    yield (
        kit.material(material)._replace(emission=emission),
        space.inset(x=half, y0=depth / 3, z=half),
    )
    yield (
        kit.material(kit.pick(["wood", "metal"])),
        space.ends("z", edge),
        space.inset(z=edge).ends("x", edge),
    )


def pipe(
    kit: Kit,
    space: Box,
    *,
    level: bool = False,
) -> Piece:
    """One or two upright pipes as high as a space, or level rails as wide."""
    radius = min(0.4 * space.size[1], 0.03)
    metal = kit.material("metal")
    number = kit.count((1, 2))
    x = space.x1
    if level:
        bend = np.multiply(presets()["rail"], (x, space.y1 - radius))
        first = np.pad(bend, [(0, 0), (0, 1)], constant_values=radius)
        step = np.array([0, 0, space.z1 - 2 * radius])
    else:
        left = x / number - x
        first = np.array([(left, 0, 0), (left, 0, space.z1)])
        step = np.array([2 * x / number, 0, 0])
    for k in range(number):
        yield metal, sweep(first + k * step, radius)


def radiator(kit: Kit, space: Box) -> Piece:
    """Upright fins between two rails, on feet."""
    width, depth, height = space.size
    inside = space.inset(x=0.02, y=depth / 4)
    x = np.linspace(inside.x0, inside.x1, max(3, int(width / 0.07)))
    feet = space.inset(y=depth / 5).cut(z1=0.12 * height)
    yield (
        "paint",
        space.cut(z0=0.11 * height, z1=0.97 * height).bars("x", x, 0.02),
        inside.bars("z", height * np.array([0.16, 0.92]), 0.02),
        feet.bars("x", x[[0, -1]], 0.015),
    )


def stairs(kit: Kit, space: Box, *, rail: bool = True) -> Piece:
    """Steps that rise along x to the height of a space, perhaps with a banister at its front."""
    count = max(2, round(space.z1 / 0.18))
    z = np.linspace(0, space.z1, count + 1)[1:]
    steps = space.split("x", count).cut(z1=z)
    yield "wood", steps
    if rail:
        middles = (steps.x0 + steps.x1) / 2
        feet = np.column_stack([middles, np.full(count, space.y0 + 0.04), z])
        tops = feet + np.array([0, 0, 0.9])
        bars = [sweep(ends, 0.012, 6) for ends in zip(feet, tops, strict=True)]
        yield "metal", *bars
        yield "wood", sweep(tops, 0.025, 8)


def stack(
    kit: Kit,
    space: Box,
    *,
    count: Sequence[int] = (1, 4),
    material: str = "paper",
) -> Piece:
    """Boxes or papers piled up, each turned a little; a single one is not turned."""
    number = kit.count(count)
    shares = kit.rng.uniform(0.15, 1, number - 1).round(2)
    for z0, z1 in pairwise(space.z1 * np.unique([0.0, *shares, 1.0])):
        layer = space.cut(z0=z0, z1=z1 - 1e-3)
        yield material, _case(kit, layer) if number > 1 else layer
    yield Box.standing([*space.size[:2] / 1.5, 0.4], (0, 0, space.z1))


def _case(kit: Kit, space: Box) -> Trimesh:
    """A box turned a little, which does not leave the floor of its space."""
    width, depth, _ = space.size
    turn, share_x, share_y = kit.draw("case")
    longer = max(width / depth, depth / width)
    fit = 0.5 / (np.cos(turn) + longer * abs(np.sin(turn)))
    x = width * fit * share_x
    y = depth * fit * share_y
    return move(slab(-x, x, -y, y, space.z0, space.z1), (0, 0, 0), turn)
