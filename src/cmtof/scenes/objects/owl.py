"""An owl with textured plumage: pale and dark feathers, a face with a dark rim, eyes, a beak."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cmtof.instrument.targets import MeshTarget
from cmtof.scenes.objects.staging import Piece, staged
from cmtof.scenes.rooms.shaping import modelled
from cmtof.scenes.rooms.solids import ball, tube
from cmtof.scenes.rooms.thing import Mesh

Array = NDArray[np.float64]

DARK, PALE = 0.03, 0.8
"""Least and greatest reflectance of its plumage at 532 nm (assumed: black and white feathers)."""
FIELD = 0.34
"""Full angle that frames it, rad."""

_RELIEF = 7e-4  # m: how far a feather stands out at its tip


def owl() -> MeshTarget:
    """Build the owl before its wall, on a branch."""
    eyes = [side * 0.031 for side in (-1, 1)]
    body = modelled((0.16, 0.135, 0.21), [((0, -1, 0.1), 0.5, 0.06), ((0, 0, -1), 0.6, -0.06)],
        (0, 0, 0.125), subdivisions=7)  # fmt: skip
    head = modelled((0.145, 0.118, 0.115), [((0.42, -1, 0.1), 0.22, -0.1),
        ((-0.42, -1, 0.1), 0.22, -0.1), ((0.75, -0.25, 1), 0.15, 0.38),
        ((-0.75, -0.25, 1), 0.15, 0.38), ((0, -1, 0.3), 0.16, 0.05)], (0, -0.004, 0.232),
        subdivisions=6)  # fmt: skip
    pieces = [_plumed(body, _breast, 24), _plumed(head, _face, 24)]
    for side in (-1, 1):
        wing = modelled((0.046, 0.115, 0.17), [((0, 0.5, -1), 0.5, 0.25)],
            (side * 0.07, 0.006, 0.13), subdivisions=6)  # fmt: skip
        pieces.append(_plumed(wing, _wing, 12))
        foot = modelled((0.03, 0.045, 0.02), centre=(side * 0.028, -0.045, 0.022), subdivisions=5)
        pieces.append(Piece(foot, 0.35, 0.02))
    for x in eyes:
        iris = ball(0.0165, (x, -0.043, 0.236), 5)
        pieces.append(Piece(iris, _iris(iris, x), 0.04))
    beak = modelled((0.016, 0.03, 0.03), [((0, -0.6, -1), 0.4, 0.3)], (0, -0.06, 0.214),
        subdivisions=5)  # fmt: skip
    way = np.linspace(-0.5, 0.5, 120)
    branch = tube(np.stack([way, 0.01 * np.sin(9 * way) - 0.02, 0.012 + 0 * way], -1), 0.012, 160)
    pieces += [Piece(beak, 0.06, 0.05), Piece(branch, 0.15)]
    return staged(pieces, middle=0.15, pitch=0.08)


def _plumed(mesh: Mesh, colours: Callable[[Array, Array, Array], Array], columns: int) -> Piece:
    """Feathers on a mesh, so many around it: their relief, and the reflectance of each vertex."""
    p = mesh.vertices.astype(float)
    centre = p.mean(0)
    out = (p - centre) / np.linalg.norm(p - centre, axis=1, keepdims=True)
    tip, place = _feathers(p - [centre[0], centre[1], 0], columns)
    points = p + _RELIEF * tip[:, None] * out
    return Piece(Mesh(points.astype(np.float32), mesh.faces), colours(p, tip, place))


def _feathers(p: Array, columns: int, row: float = 0.0135) -> tuple[Array, Array]:
    """Rows of feathers, staggered: how near a point is to the tip of one, 0 to 1; which feather.

    The second array is a fixed number from 0 to 1 for each feather.
    """
    angle = np.arctan2(p[:, 0], -p[:, 1])
    height = p[:, 2] / row
    level = np.floor(height)
    across = angle * columns / (2 * np.pi) + 0.5 * (level % 2)
    column = np.floor(across)
    s, t = across - column - 0.5, height - level  # t falls from 1 at the root to 0 at the tip
    inside = np.clip(1 - (2 * s) ** 2, 0, 1)
    tip = inside * np.cos(np.pi / 2 * np.clip(t, 0, 1)) ** 1.5 * np.clip(6 * t, 0, 1)
    which = np.mod(np.sin(12.9898 * level + 78.233 * column) * 43758.5453, 1.0)
    return tip, which


def _mix(dark: float, pale: float, share: Array) -> Array:
    return dark + (pale - dark) * np.clip(share, 0, 1)


def _breast(p: Array, tip: Array, which: Array) -> Array:
    """Pale in front with dark tips, brown at the back."""
    front = np.clip(0.5 - p[:, 1] / 0.04, 0, 1)
    spot = np.clip(6 * (tip - 0.5), 0, 1) * (which < 0.75)
    pale = _mix(0.12, PALE, front * (0.8 + 0.4 * tip))
    return pale + (DARK - pale) * spot


def _wing(p: Array, tip: Array, which: Array) -> Array:
    """Dark brown with some white tips."""
    spot = np.clip(6 * (tip - 0.5), 0, 1) * (which < 0.4)
    base = _mix(0.04, 0.16, which)
    return base + (PALE - base) * spot


def _face(p: Array, tip: Array, which: Array) -> Array:
    """Two pale discs with rings and a dark rim; a speckled brown crown; dark ears."""
    x, z = np.abs(p[:, 0]), p[:, 2]
    far = np.hypot(x - 0.03, (z - 0.233) * 1.05)
    disc = _mix(0.45, PALE, 0.5 + 0.5 * np.cos(2 * np.pi * far / 0.0075))
    rim = np.exp(-(((far - 0.036) / 0.0035) ** 2))
    crown = _mix(0.07, 0.3, which)
    crown = crown + (0.7 - crown) * np.clip(6 * (tip - 0.6), 0, 1) * (which < 0.35)
    crown = _mix(0.05, 1.0, crown * np.clip((0.292 - z) / 0.015, 0.15, 1))
    inside = np.clip((0.036 - far) / 0.0015, 0, 1) * (p[:, 1] < 0)
    seen = crown + (disc - crown) * inside
    return np.clip(seen + (DARK - seen) * rim * (p[:, 1] < 0), DARK, PALE)


def _iris(mesh: Mesh, x: float) -> Array:
    """A pupil, a bright iris, a dark rim."""
    off = np.hypot(mesh.vertices[:, 0] - x, mesh.vertices[:, 2] - 0.236)
    return np.where(off < 0.0072, DARK, np.where(off < 0.0145, 0.5, 0.05)).astype(float)
