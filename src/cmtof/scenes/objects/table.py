"""A cluttered table: things of many materials, half hidden by each other."""

import numpy as np
from numpy.typing import NDArray

from cmtof.instrument.targets import MeshTarget
from cmtof.scenes.objects.staging import Piece, lathe, pieces_of, refined, staged
from cmtof.scenes.rooms.books import book_stack
from cmtof.scenes.rooms.materials import Style, style
from cmtof.scenes.rooms.pliant import spline
from cmtof.scenes.rooms.solids import ball, box, sheet, tube
from cmtof.scenes.rooms.table_plants import herb_pot
from cmtof.scenes.rooms.thing import moved, pose

Array = NDArray[np.float64]

FIELD = 0.44
"""Full angle that frames it, rad."""


def table() -> MeshTarget:
    """Build the table before its wall; reflectances at 532 nm are assumed."""
    rng = np.random.default_rng(11)
    home = style(rng)
    pieces = [*_mug(), *_bottle(), *_ball(), *_box(), *_apple(), *_books(rng, home)]
    pieces += pieces_of(
        herb_pot(np.random.default_rng(3), home), pose(0.13, 0.12, 0.0), smooth=(0,)
    )
    return staged(pieces, middle=0.075, pitch=0.38, table=0.35)


def _mug() -> list[Piece]:
    """Glazed stoneware with a dark band, and its handle."""
    r, h, wall = 0.041, 0.095, 0.004
    outside = [(0, 0), (0.8 * r, 0), (0.97 * r, 0.004), (r, 0.02), (r, 0.5 * h), (r, h - 0.003)]
    inside = [(r - wall, h - 0.003), (r - wall, 0.5 * h), (r - wall, 0.02), (0.8 * r, 0.008),
              (0, 0.008)]  # fmt: skip
    body = lathe([*outside, (r - 0.5 * wall, h), *inside], count=400)
    path = [(r - 0.002, 0, 0.8 * h), (r + 0.02, 0, 0.84 * h), (r + 0.031, 0, 0.55 * h),
            (r + 0.02, 0, 0.24 * h), (r - 0.004, 0, 0.2 * h)]  # fmt: skip
    grip = tube(spline(path, 160), 0.0052, 96)
    there = pose(0.0, -0.13, 0.0, -0.5)
    band = np.abs(body.vertices[:, 2] - 0.6 * h) < 0.012
    return [Piece(moved(body, there), np.where(band, 0.08, 0.7), 0.05),
            Piece(moved(grip, there), 0.7, 0.05)]  # fmt: skip


def _bottle() -> list[Piece]:
    """Dark green glass, taken as opaque, with a paper label and a cork."""
    r, h = 0.036, 0.235
    glass = lathe(np.array([(0, 0), (0.9, 0), (0.99, 0.02), (1, 0.06), (1, 0.5), (0.99, 0.58),
        (0.8, 0.69), (0.42, 0.79), (0.36, 0.86), (0.36, 0.97), (0.36, 1.0), (0, 1.0)]) * [r, h],
        count=400)  # fmt: skip
    turn = np.linspace(-1.9, 1.9, 400) - np.pi / 2
    rows = np.linspace(0.16 * h, 0.46 * h, 60)
    grid = np.stack(np.broadcast_arrays((r + 3e-4) * np.cos(turn), (r + 3e-4) * np.sin(turn),
        rows[:, None]), -1)  # fmt: skip
    label = sheet(grid[::-1])
    printed = np.sin(label.vertices[:, 2] / 0.0028) * np.sin(40 * np.arctan2(label.vertices[:, 0],
        -label.vertices[:, 1])) > 0.5  # fmt: skip
    cork = lathe([(0, 0.99 * h), (0.0105, 0.99 * h), (0.0108, h + 0.012), (0, h + 0.013)])
    there = pose(0.055, 0.05, 0.0)
    return [Piece(moved(glass, there), 0.12, 0.4),
            Piece(moved(label, there), np.where(printed, 0.06, 0.75)),
            Piece(moved(cork, there), 0.35)]  # fmt: skip


def _ball() -> list[Piece]:
    """A rubber ball with stripes."""
    mesh = ball(0.034, (0.14, -0.07, 0.034), 7)
    x, y, z = (mesh.vertices - np.array([0.14, -0.07, 0.034], np.float32)).T
    stripe = np.mod(np.floor((0.8 * x + 0.2 * y + 0.56 * z) / 0.0125), 2)
    return [Piece(mesh, _mix(0.1, 0.65, stripe), 0.02)]


def _mix(dark: float, pale: float, share: Array) -> Array:
    return dark + (pale - dark) * np.asarray(share, float)


def _box() -> list[Piece]:
    """A cardboard box with its lid, and a black one upon it."""
    low = moved(box((0.11, 0.09, 0.085), (0, 0, 0.0425), 0.001), pose(-0.14, 0.11, 0, 0.35))
    high = moved(box((0.06, 0.07, 0.03), (0, 0, 0.1), 0.0015), pose(-0.145, 0.105, 0, -0.25))
    return [Piece(low, 0.4), Piece(high, 0.05, 0.1)]


def _apple() -> list[Piece]:
    """An apple with its stalk."""
    a = np.linspace(-np.pi / 2, np.pi / 2, 60)
    grid = np.empty((60, 72, 3))
    turn = np.arange(72) * (2 * np.pi / 72)
    r = 0.034 * np.cos(a) * (1 + 0.1 * np.sin(a)) + 1e-5
    z = 0.031 * np.sin(a) - 0.013 * np.exp(-((r / 0.011) ** 2)) * np.sign(np.sin(a))
    swell = 1 + 0.025 * np.cos(5 * turn) * np.cos(a)[:, None]
    grid[..., 0], grid[..., 1] = (
        r[:, None] * np.cos(turn) * swell,
        r[:, None] * np.sin(turn) * swell,
    )
    grid[..., 2] = z[:, None] + 0.03
    skin = sheet(refined(grid, 5)[:, ::-1], closed=True)
    stalk = tube([(0, 0, 0.045), (0.002, 0, 0.055), (0.006, 0, 0.067)], 0.0013, 24)
    there = pose(0.085, -0.17, 0.0)
    return [Piece(moved(skin, there), 0.22, 0.06), Piece(moved(stalk, there), 0.1)]


def _books(rng: np.random.Generator, home: Style) -> list[Piece]:
    """A pile of books at the left."""
    pile = book_stack(rng, home, count=3)
    return pieces_of(pile, pose(-0.13, -0.05, 0.0, 1.3))
