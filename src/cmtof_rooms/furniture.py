"""Makers of furniture to sit at, to sit on, to lie on, and to keep things in.

Each fills a box and has options that `presets.yml` names; see `cmtof_rooms.kit`.
"""

from collections.abc import Sequence

import numpy as np

from cmtof.types import Pair, Shape
from cmtof_rooms.boxes import Box, Rectangle, both_sides
from cmtof_rooms.kit import Kit, Piece, Solids, Top
from cmtof_rooms.materials import Material
from cmtof_rooms.solids import (
    ball,
    ellipse,
    extrusion,
    move,
    revolution,
)


def posts(x: float, y: float, thickness: float, z0: float, z1: float) -> Box:
    """Four upright bars about (±x, ±y), m."""
    half = thickness / 2
    row = Box(0, 0, 0, 0, z0, z1).bars("y", both_sides(y), half)
    return row.bars("x", both_sides(x)[:, None], half)


def table(
    kit: Kit,
    space: Box,
    *,
    legs: str = "four",
    round_top: float = 0.0,
) -> Piece:
    """A top on four legs, two panels, or a pedestal; ``round_top`` is the share of round ones."""
    width, depth, height = space.size
    thickness = min(kit.between(0.02, 0.05), height / 4)
    board = space.cut(z0=height - thickness)
    wood = kit.material("wood")
    reach = 0.9  # of the place for things, as a share of the size
    if kit.chance(round_top):
        disc = extrusion(ellipse((width, depth)), thickness)
        yield wood, move(disc, (0, 0, board.z0))
        legs = "pedestal"
        reach = 0.63
    else:
        yield wood, board
    yield from LEGS[legs](kit, wood, board)
    yield Top(Rectangle.about((0.0, 0.0), (reach * width, reach * depth)), height, 1.2)


def _pedestal(kit: Kit, wood: Material, board: Box) -> Piece:
    """A round metal column with a wide foot, below a table's board."""
    foot = 0.3 * min(board.size[:2])
    yield "metal", revolution([(foot, 0), (foot, 0.03), (0.05, 0.06), (0.04, board.z0)])


def _leg_panels(kit: Kit, wood: Material, board: Box) -> Piece:
    """Two upright panels below a table's board."""
    y = 0.95 * board.y1
    below = Box(0, 0, -y, y, 0, board.z0)
    yield wood, below.bars("x", both_sides(board.x1 - 0.06), 0.02)


def _four_legs(kit: Kit, wood: Material, board: Box) -> Piece:
    """Four legs and, below a high table's board, rails between them."""
    thickness = min(kit.between(0.03, 0.07), *board.size[:2] / 6)
    x = board.x1 - thickness
    y = board.y1 - thickness
    yield wood, posts(x, y, thickness, 0, board.z0)
    if board.z1 > 0.5:
        below = Box(-x, x, 0, 0, board.z0 - 0.11, board.z0)
        yield wood, below.bars("y", both_sides(y), 0.01)


# What carries a table, by the name that `presets.yml` uses.
LEGS = {
    "four": _four_legs,
    "panel": _leg_panels,
    "pedestal": _pedestal,
}


def chair(kit: Kit, space: Box, *, back: bool = True) -> Piece:
    """A chair or stool: seat, four legs and, at its back, two posts with a board."""
    height = space.z1
    level = min(0.46, 0.55 * height) if back else height
    wood = kit.material("wood", "metal")
    thickness = 0.035
    half = thickness / 2
    x = space.x1 - half
    y = space.y1 - half
    low = level - 0.04
    yield "fabric", space.cut(z0=low, z1=level)
    yield wood, posts(x, y, thickness, 0, low)
    if back:
        behind = Box(-x, x, y - half, y + half, level, height)
        low = level + 0.5 * (height - level) if kit.chance(0.5) else level + 0.08
        board = behind.cut(y0=y - 0.012, y1=y + 0.012, z0=low)
        yield wood, behind.bars("x", both_sides(x), half), board


def sofa(kit: Kit, space: Box, *, arms: bool = True) -> Piece:
    """A sofa, armchair or bench, upholstered, with a back where it is high enough."""
    width, depth, height = space.size
    cover = kit.material("fabric")
    arm = kit.between(0.12, 0.2) if arms else 0.0
    between = width - 2 * arm
    back = kit.between(0.16, 0.24) if height > 0.5 else 0.0
    level = min(0.42, 0.9 * height)
    yield cover, space.cut(z0=0.08, z1=level - 0.12)
    yield (
        "wood",
        posts(space.x1 - 0.06, space.y1 - 0.06, 0.06, 0, 0.08),
    )
    if arms:
        rests = space.ends("x", arm)
        yield cover, rests.cut(z0=0.08, z1=min(kit.between(0.55, 0.65), height))
    middle = (-back / 2, level - 0.05)
    yield _cushions(cover, (between, depth - back, 0.18), middle, 0.75)
    if back:
        behind = space.inset(x0=arm, x1=arm)
        yield cover, behind.cut(y0=space.y1 - 0.08, z0=level - 0.12)
        above = height - level
        middle = (space.y1 - back / 2 - 0.03, level + 0.45 * above)
        yield _cushions(cover, (between, back, above), middle, 0.7)


def _cushions(
    cover: Material,
    size: Sequence[float],
    middle: Pair,
    squareness: float,
) -> Solids:
    """A row of cushions that has a size, m, as a whole, centred at (y, z) = ``middle``, m."""
    width, depth, height = size
    count = max(1, round(width / 0.75))
    each = width / count
    cushion = ball((each / 2, depth / 2, height / 2), squareness=squareness)
    places = -width / 2 + each * (np.arange(count) + 0.5)
    return cover, *[move(cushion, (x, *middle)) for x in places]


def bed(kit: Kit, space: Box) -> Piece:
    """A frame with headboard, mattress, blanket and pillows; its head at +y."""
    width, depth, height = space.size
    level = min(0.5, 0.6 * height)
    yield (
        "wood",
        space.cut(z0=0.1, z1=0.3),
        space.cut(y0=space.y1 - 0.05),
        space.inset(x0=0.1, x1=0.1, y0=0.1).cut(z1=0.1),
    )

    axes = (width / 2 - 0.02, depth / 2 - 0.06, (level - 0.28) / 2)
    mattress = ball(axes, squareness=0.85, fineness=3)
    yield "linen", move(mattress, (0, -0.01, (level + 0.28) / 2))

    axes = (width / 2, depth * 0.33, (level - 0.2) / 2 + 0.02)
    wrinkles = kit.between(0.005, 0.03)
    blanket = ball(axes, squareness=0.85, fineness=4, noise=wrinkles, rng=kit.rng)
    yield (
        "fabric",
        move(blanket, (0, -depth * 0.17, (level + 0.2) / 2)),
    )
    yield from _pillows(kit, width, (depth / 2 - 0.32, level + 0.05))


def _pillows(kit: Kit, width: float, middle: Pair) -> Piece:
    """One pillow or, on a wide bed, two, centred at (y, z) = ``middle``, m."""
    count = 2 if width > 1.2 else 1
    half = min(0.32, width / count / 2.1)
    pillow = ball((half, 0.2, 0.08), squareness=0.5)
    for k in range(count):
        x = (k - (count - 1) / 2) * width / count
        yield "linen", move(pillow, (x, *middle))


def cabinet(
    kit: Kit,
    space: Box,
    *,
    columns: Sequence[int] = (1, 3),
    rows: Sequence[int] = (1, 3),
    material: str = "wood",
    top: str = "",
) -> Piece:
    """A carcass with fronts (doors or drawers) and handles, perhaps a worktop of its own."""
    wood = kit.material(material)
    plinth = min(0.06, space.z1 / 8)
    inset = space.inset(x0=0.03, x1=0.03)
    body = space.inset(z0=plinth)
    yield (
        wood,
        body.inset(y0=0.02),
        inset.inset(y0=0.06).cut(z1=plinth),
    )
    yield from _doors(kit, wood, body, (kit.count(columns), kit.count(rows)))
    height = space.z1
    if top:
        height += 0.03
        yield top, space.inset(y0=-0.015).cut(z0=space.z1, z1=height)
    yield Top(inset.inset(y0=0.04, y1=0.03).floor, height)


def _doors(kit: Kit, wood: Material, body: Box, shape: Shape) -> Piece:
    """Fronts of a cabinet in columns and rows and, on most cabinets, a handle on each front."""
    columns, rows = shape
    gap = 0.006
    y = body.y0
    x = np.linspace(body.x0, body.x1, columns + 1)[:, None]
    z = np.linspace(body.z0, body.z1 - 0.02, rows + 1)
    cells = Box(x[:-1], x[1:], y, y + 0.02, z[:-1], z[1:])
    yield wood, cells.inset(x0=gap, x1=gap, z0=gap, z1=gap)
    if kit.chance(0.6):
        x = (x[:-1] + x[1:]) / 2
        z = 0.2 * z[:-1] + 0.8 * z[1:]
        yield "metal", Box(x - 0.05, x + 0.05, y - 0.025, y, z, z + 0.012)


def shelf(kit: Kit, space: Box, *, fill: float = 0.5, bay: float = 0.9) -> Piece:
    """Boards between sides, some of them with rows of books, others free for things."""
    height = space.z1
    wood = kit.material("wood")
    thickness = 0.025
    columns = max(1, round(space.size[0] / bay))
    rows = max(1, round(height / kit.between(0.32, 0.42)))
    x = np.linspace(space.x0, space.x1, columns + 1)
    z = np.linspace(0.05, height - thickness, rows + 1)
    left = np.minimum(x, space.x1 - thickness)
    boards = space.inset(y0=0.005).cut(z0=z, z1=z + thickness)
    yield wood, space.cut(x0=left, x1=left + thickness), boards
    yield wood, space.cut(y0=space.y1 - 0.01, z0=0.05)
    bays = space.inset(y0=0.02).cut(x0=x[:-1, None] + thickness, x1=x[1:, None])
    yield from _fill(kit, bays.cut(z0=z[:-1] + thickness, z1=z[1:]), fill)
    yield Top(space.floor, height, 0.5)


def _fill(kit: Kit, compartments: Box, share: float) -> Piece:
    """Books in a share of a shelf's compartments, places for other things in the others."""
    for space in compartments.singles():
        if kit.chance(share):
            yield from _books(kit, space.inset(y1=0.02))
        else:
            yield Top(
                space.inset(y1=0.03).floor,
                space.z0,
                space.z1 - space.z0,
            )


def _books(kit: Kit, space: Box) -> Piece:
    """Books from the left over part or all of a space, in runs of equal height and thickness."""
    width, depth, height = space.size
    x = space.x0
    end = x + kit.between(0.4, 1.0) * width
    while x < end - 0.03:
        run, high, thickness, shift = kit.draw("books")
        run = min(run, end - x)  # one edition: equal heights
        top = space.z0 + height * high
        front = space.y0 + shift * depth
        start = x + thickness * np.arange(max(1, int(run / thickness)))
        books = space.cut(x0=start, x1=start + thickness - 0.001, y0=front, z1=top)
        yield "paper", books
        x += len(start) * thickness + 0.002
