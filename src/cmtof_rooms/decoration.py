"""Makers of lamps, vessels, plants, pictures, fabrics, and of what is fixed to a room.

Each fills a box and has options that `presets.yml` names; see `cmtof_rooms.kit`.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from trimesh import Trimesh

from cmtof.types import Array
from cmtof_rooms.boxes import Box, Rectangle
from cmtof_rooms.kit import Kit, Piece, Top
from cmtof_rooms.materials import Material
from cmtof_rooms.presets import presets
from cmtof_rooms.solids import ball, bar, mesh_from, move, revolution, scaled, slab
from cmtof_rooms.things import level_light

THIN = 0.006  # thickness of a fabric, m


def panel(kit: Kit, space: Box) -> Piece:
    """A panel under the ceiling that shines."""
    half = min(space.x1, space.y1)
    yield level_light((0, 0, -0.01), half, half, 1.0)
    yield _glow(kit), space


def _glow(kit: Kit) -> Material:
    """Draw the material of a lamp's shade."""
    return kit.material("shade")._replace(emission=1.0)


def lamp(kit: Kit, space: Box, *, hangs: bool = False) -> Piece:
    """A lamp on a stand, or a pendant on its cord."""
    height = space.z1
    radius = min(space.x1, space.y1)
    glow = _glow(kit)
    tall, narrow = kit.draw("shade")
    tall = min(tall * 2 * radius, 0.45 * height)
    narrow *= radius
    metal = kit.material("metal")
    shade = revolution([(radius, 0), (narrow, tall)])
    if hangs:
        if kit.chance(0.4):
            body = ball((radius, radius, tall / 2))
            shade = move(body, (0, 0, tall / 2))
        yield level_light((0, 0, -0.03), radius, radius, 1.0)
        yield metal, bar([(0, 0, tall), (0, 0, height)], 0.008)
        yield glow, shade
        return
    foot = min(0.7 * radius, 0.16)
    half = 0.5 * narrow
    low = height - tall
    stand = [
        (foot, 0),
        (foot, 0.02),
        (0.012, 0.03),
        (0.012, low),
    ]
    yield level_light((0, 0, height + 0.05), half, half, 1.0, 0.0)
    yield metal, revolution(stand)
    yield glow, move(shade, (0, 0, low))


def vessel(
    kit: Kit,
    space: Box,
    *,
    profile: str = "vase",
    material: str = "ceramic",
) -> Piece:
    """A turned vessel, of another width than depth where the size says so."""
    outline = np.array(presets()["profiles"][profile]) * [0.5, 1]
    yield material, scaled(revolution(outline), space.size)


def blob(
    kit: Kit,
    space: Box,
    *,
    material: str = "fabric",
    noise: float = 0.1,
    squareness: float = 0.0,
) -> Iterator[tuple[str, Trimesh]]:
    """Something soft or grown: cushion, fruit, stone, toy."""
    body = ball(1.0, noise=noise, rng=kit.rng, squareness=squareness, fineness=3)
    whole = scaled(body, space.size / body.extents)
    yield material, move(whole, (0, 0, space.z1 / 2) - whole.bounds.mean(axis=0))


def cloth(kit: Kit, space: Box, *, folds: Sequence[float] = (5, 9)) -> Piece:
    """A fabric that hangs, with so many folds a metre."""
    width, _, height = space.size
    count = kit.between(*folds) * width
    x = np.linspace(-width / 2, width / 2, int(10 * count) + 9)[:, None]
    z = np.linspace(0, height, 7)
    flat = slab(x[:-1], x[1:], 0, THIN, z[:-1], z[1:])
    yield "fabric", mesh_from(_folded(kit, space, count, flat.vertices), flat.faces)


def _folded(kit: Kit, space: Box, count: float, points: Array) -> Array:
    """Points (N, 3) of a flat fabric once it lies in folds, which are deeper below."""
    width, depth, height = space.size
    fall = points[:, 2] / height
    bend = 0.3 * np.sin(3 * fall + kit.between(0, 6))
    turns = count * (points[:, 0] / width + 0.5)
    wave = np.sin(2 * np.pi * turns + kit.between(0, 2 * np.pi) + bend)
    out = (depth / 2 - THIN) * wave * (1 - 0.3 * fall)
    return points + np.outer(out, [0, 1, 0])


def rug(kit: Kit, space: Box) -> Piece:
    """A rug, a fifth of them oval."""
    disc = revolution([(0.5, 0), (0.5, 1)])
    yield "fabric", scaled(disc, space.size) if kit.chance(0.2) else space


def plant(kit: Kit, space: Box, *, bush: bool = False) -> Piece:
    """A plant in a pot: single leaves on stems, or a bush."""
    height = space.z1
    width = 2 * min(space.x1, space.y1)
    pot = min(0.35 * height, 0.6 * width)
    crown = height - pot
    yield from vessel(kit, Box.standing((0.9 * pot, 0.9 * pot, pot)), profile="pot")
    green = kit.material("leaf")
    if not bush:
        yield from _leaves(kit, green, width, pot, crown)
        return
    top = Box.standing((width, width, 0.9 * crown))
    for material, leaves in blob(kit, top, material="leaf", noise=0.35):
        yield material, move(leaves, (0, 0, pot + 0.1 * crown))
    stem = [(0, 0, 0.8 * pot), (0, 0, pot + 0.3 * crown)]
    yield green, bar(stem, 0.03 * pot + 0.01)


def _leaves(kit: Kit, green: Material, width: float, pot: float, crown: float) -> Piece:
    """Leaves of a plant, each on a bent stem that starts in its pot."""
    leaf = ball((0.2 * width, 0.085 * width, 0.008), fineness=1)
    for k in range(kit.count((7, 17))):
        shift, reach, rise = kit.draw("leaf")
        turn = 2.4 * k + shift
        x, y = np.array([np.cos(turn), np.sin(turn)]) * reach * width / 2
        top = pot + crown * rise
        stem = [
            (0, 0, 0.8 * pot),
            (0.3 * x, 0.3 * y, (pot + top) / 2),
            (x, y, top),
        ]
        yield (
            green,
            bar(stem, 0.004 + 0.004 * crown),
            move(leaf, stem[-1], turn),
        )


def picture(
    kit: Kit,
    space: Box,
    *,
    frame: float = 0.03,
    material: str = "picture",
    emission: float = 0.0,
) -> Piece:
    """A framed panel: picture, mirror, screen, board; upright, its back at +y."""
    depth = space.size[1]
    half = frame / 2
    paint = kit.material(material)._replace(emission=emission)
    yield paint, space.inset(x0=half, x1=half, y0=depth / 3, z0=half, z1=half)
    upright = space.inset(z0=frame, z1=frame)
    yield (
        kit.material("wood", "metal"),
        space.ends("z", frame),
        upright.ends("x", frame),
    )


def pipe(kit: Kit, space: Box, *, level: bool = False) -> Piece:
    """Upright pipes from floor to height, or level rails from side to side."""
    radius = min(0.4 * space.size[1], 0.03)
    metal = kit.material("metal")
    number = kit.count((1, 2))
    x = space.x1
    y = space.y1 - radius
    for k in range(number):
        z = radius + space.z1 * k / number
        path = [
            (-x, y, z),
            (-x, -y, z),
            (x, -y, z),
            (x, y, z),
        ]
        if not level:
            across = ((2 * k + 1) / number - 1) * x
            path = [(across, 0, 0), (across, 0, space.z1)]
        yield metal, bar(path, radius)


def radiator(kit: Kit, space: Box) -> Piece:
    """Upright fins along two rails."""
    x = np.linspace(space.x0 + 0.02, space.x1 - 0.02, max(3, int(space.size[0] / 0.07)))
    _, depth, height = space.size
    rails = space.inset(x0=0.02, x1=0.02, y0=depth / 4, y1=depth / 4)
    heights = np.array([0.16, 0.92]) * height
    yield (
        "paint",
        space.bars("x", x, 0.02),
        rails.bars("z", heights, 0.02),
    )


def stairs(kit: Kit, space: Box, *, rail: bool = True) -> Piece:
    """A flight of steps along x that rises to height, with a banister on its free side."""
    count = max(2, round(space.z1 / 0.18))
    x = np.linspace(space.x0, space.x1, count + 1)
    z = np.linspace(0, space.z1, count + 1)[1:]
    yield "wood", space.cut(x0=x[:-1], x1=x[1:], z1=z)
    if rail:
        x = (x[:-1] + x[1:]) / 2
        y = space.y0 + 0.04
        yield "metal", Box(x - 0.01, x + 0.01, y - 0.01, y + 0.01, z, z + 0.9)
        yield "wood", bar([(x[k], y, z[k] + 0.9) for k in (0, -1)], 0.025)


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
    for z0, z1 in pairwise(levels):
        layer = space.cut(z0=z0, z1=z1 - 1e-3)
        yield material, _case(kit, layer) if number > 1 else layer
    top = Rectangle.about((0, 0), (2 * width / 3, 2 * depth / 3))
    yield Top(top, height, 0.4)


def _case(kit: Kit, space: Box) -> Trimesh:
    """A box turned a little, which does not leave the floor of its space."""
    width, depth, _ = space.size
    turn, share_x, share_y = kit.draw("case")
    x = 0.4 * width * share_x
    y = 0.4 * depth * share_y
    return move(slab(-x, x, -y, y, space.z0, space.z1), (0, 0, 0), turn)
