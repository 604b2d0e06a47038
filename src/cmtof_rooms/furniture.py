"""Makers of furniture to sit at, to sit on, to lie on, and to keep things in.

Each fills a box and has options that `presets.yml` names; see `cmtof_rooms.kit`.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from trimesh import Trimesh

from cmtof_rooms.boxes import Box
from cmtof_rooms.kit import Kit, Piece
from cmtof_rooms.solids import (
    ball,
    ellipse,
    extrusion,
    move,
    revolution,
)


def posts(space: Box, thickness: float) -> Box:
    """Four upright bars of a thickness, m, in the corners of a space."""
    return space.ends("x", thickness).ends("y", thickness)


def padding(space: Box, **shape: Any) -> Trimesh:
    """A rounded body that fills a space; see `ball` for its shape."""
    return move(ball(space.size / 2, **shape), space.middle)


def table(
    kit: Kit,
    space: Box,
    *,
    legs: str = "four",
    round_top: float = 0.0,
) -> Piece:
    """A top on four legs, two panels, or a pedestal; ``round_top`` is the share of round ones.

    Below the board of a high table with four legs are rails.
    """
    width, depth, height = space.size
    thickness = min(kit.between(0.02, 0.05), height / 4)
    below = space.inset(z1=thickness)
    wood = kit.material("wood")
    reach = 0.9  # of the place for things, as a share of the size
    if kit.chance(round_top):
        yield (
            wood,
            move(extrusion(ellipse((width, depth)), thickness), (0, 0, below.z1)),
        )
        legs = "pedestal"
        reach = 0.63
    else:
        yield wood, space.cut(z0=below.z1)
    if legs == "pedestal":
        foot = 0.3 * min(width, depth)
        column = [(foot, 0), (foot, 0.03), (0.05, 0.06), (0.04, below.z1)]
        yield "metal", revolution(column)
    elif legs == "panel":
        yield wood, below.inset(x=0.04, y=0.025 * depth).ends("x", 0.04)
    else:
        leg = min(kit.between(0.03, 0.07), width / 6, depth / 6)
        yield wood, posts(below.inset(x=leg / 2, y=leg / 2), leg)
        if below.z1 > 0.5:
            rails = below.inset(x=leg, y=leg - 0.01).cut(z0=below.z1 - 0.11)
            yield wood, rails.ends("y", 0.02)
    yield Box.standing((reach * width, reach * depth, 1.2), (0, 0, height))


def chair(kit: Kit, space: Box, *, back: bool = True) -> Piece:
    """A chair or stool: seat, four legs and, at its back, two posts with a board."""
    height = space.z1
    level = min(0.46, 0.55 * height) if back else height
    wood = kit.material(kit.pick(["wood", "metal"]))
    thickness = 0.035
    seat = space.cut(z0=level - 0.04, z1=level)
    yield "fabric", seat
    yield wood, posts(space.cut(z1=seat.z0), thickness)
    if back:
        behind = space.cut(y0=space.y1 - thickness, z0=level)
        low = level + 0.5 * (height - level) if kit.chance(0.5) else level + 0.08
        board = behind.inset(x=thickness / 2, y=thickness / 2 - 0.012).cut(z0=low)
        yield wood, behind.ends("x", thickness), board


def sofa(kit: Kit, space: Box, *, arms: bool = True) -> Piece:
    """A sofa, armchair or bench, upholstered, with a back where it is high enough."""
    height = space.z1
    cover = kit.material("fabric")
    arm = kit.between(0.12, 0.2) if arms else 0.0
    back = kit.between(0.16, 0.24) if height > 0.5 else 0.0
    level = min(0.42, 0.9 * height)
    between = space.inset(x=arm)
    yield cover, space.cut(z0=0.08, z1=level - 0.12)
    yield "wood", posts(space.inset(x=0.03, y=0.03).cut(z1=0.08), 0.06)
    if arms:
        rest = min(kit.between(0.55, 0.65), height)
        yield cover, space.cut(z0=0.08, z1=rest).ends("x", arm)
    seat = between.inset(y1=back).cut(z0=level - 0.14, z1=level + 0.04)
    yield cover, *_cushions(seat, 0.75)
    if back:
        yield cover, between.cut(y0=space.y1 - 0.08, z0=level - 0.12)
        above = between.cut(z0=level).inset(y1=0.03)
        sunk = 0.05 * (height - level)
        above = above.cut(y0=above.y1 - back).inset(z0=-sunk, z1=sunk)
        yield cover, *_cushions(above, 0.7)


def _cushions(space: Box, squareness: float) -> list[Trimesh]:
    """A row of cushions that fill a space."""
    row = space.split("x", max(1, round(space.size[0] / 0.75)))
    return [padding(one, squareness=squareness) for one in row.singles()]


def bed(kit: Kit, space: Box) -> Piece:
    """A frame with headboard, mattress, blanket and pillows; its head at +y."""
    width, depth, height = space.size
    level = min(0.5, 0.6 * height)
    yield (
        "wood",
        space.cut(z0=0.1, z1=0.3),
        space.cut(y0=space.y1 - 0.05),
        space.inset(x=0.1, y0=0.1).cut(z1=0.1),
    )
    mattress = space.inset(x=0.02, y0=0.05, y1=0.07).cut(z0=0.28, z1=level)
    yield "linen", padding(mattress, squareness=0.85, fineness=3)
    blanket = space.cut(y1=0.16 * depth, z0=0.18, z1=level + 0.02)
    wrinkles = kit.between(0.005, 0.03)
    yield (
        "fabric",
        padding(blanket, squareness=0.85, fineness=4, noise=wrinkles, rng=kit.rng),
    )
    count = 2 if width > 1.2 else 1
    half = min(0.32, width / count / 2.1)
    x = width * ((np.arange(count) + 0.5) / count - 0.5)
    head = space.inset(y1=0.12).cut(z0=level - 0.03, z1=level + 0.13)
    row = head.cut(y0=head.y1 - 0.4).bars("x", x, half)
    for pillow in row.singles():
        yield "linen", padding(pillow, squareness=0.5)


def cabinet(
    kit: Kit,
    space: Box,
    *,
    columns: Sequence[int],
    rows: Sequence[int] = (1, 3),
    material: str = "wood",
    top: str = "",
) -> Piece:
    """A carcass with fronts (doors or drawers), handles on most, perhaps a worktop of its own."""
    wood = kit.material(material)
    plinth = min(0.06, space.z1 / 8)
    inset = space.inset(x=0.03)
    body = space.inset(z0=plinth)
    yield (
        wood,
        body.inset(y0=0.02),
        inset.inset(y0=0.06).cut(z1=plinth),
    )
    face = body.inset(z1=0.02).cut(y1=body.y0 + 0.02)
    fronts = face.split("x", kit.count(columns)).split("z", kit.count(rows))
    yield wood, fronts.inset(x=0.006, z=0.006)
    if kit.chance(0.6):
        x = (fronts.x0 + fronts.x1) / 2
        z = 0.2 * fronts.z0 + 0.8 * fronts.z1
        yield (
            "metal",
            Box(x - 0.05, x + 0.05, body.y0 - 0.025, body.y0, z, z + 0.012),
        )
    height = space.z1
    if top:
        height += 0.03
        yield top, space.inset(y0=-0.015).cut(z0=space.z1, z1=height)
    yield inset.inset(y0=0.04, y1=0.03).cut(z0=height, z1=height + 1.0)


def shelf(kit: Kit, space: Box, *, fill: float, bay: float = 0.9) -> Piece:
    """Boards between sides, some of them with rows of books, others free for things."""
    height = space.z1
    wood = kit.material("wood")
    thickness = 0.025
    columns = max(1, round(space.size[0] / bay))
    rows = max(1, round(height / kit.between(0.32, 0.42)))
    x = np.linspace(space.x0, space.x1, columns + 1)
    z = np.linspace(0.05, height - thickness, rows + 1)
    left = np.minimum(x, space.x1 - thickness)
    yield (
        wood,
        space.cut(x0=left, x1=left + thickness),
        space.inset(y0=0.005).cut(z0=z, z1=z + thickness),
    )
    yield wood, space.cut(y0=space.y1 - 0.01, z0=0.05)
    inside = space.inset(y0=0.02, z1=thickness).cut(z0=0.05)
    bays = inside.split("x", columns).split("z", rows)
    for one in bays.inset(x0=thickness, z0=thickness).singles():
        if kit.chance(fill):
            yield from _books(kit, one.inset(y1=0.02))
        else:
            yield one.inset(y1=0.03)
    yield space.cut(z0=height, z1=height + 0.5)


def _books(kit: Kit, space: Box) -> Piece:
    """Books from the left over part or all of a space, in runs of equal height and thickness."""
    width, depth, height = space.size
    x = space.x0
    end = x + kit.between(0.4, 1.0) * width
    while x < end - 0.03:
        run, high, thickness, shift = kit.draw("books")
        run = min(run, end - x)  # one edition: equal heights
        top = space.z0 + height * high
        start = x + thickness * np.arange(max(1, int(run / thickness)))
        yield (
            "paper",
            space.cut(
                x0=start,
                x1=start + thickness - 0.001,
                y0=space.y0 + shift * depth,
                z1=top,
            ),
        )
        x += len(start) * thickness + 0.002
