"""A polished helmet with slits and holes, open at its back, so that they show the wall behind it.

Almost all light is mirrored, away from the instrument; what comes back is a faint diffuse rest.
"""

import numpy as np
from numpy.typing import NDArray

from cmtof.instrument.targets import MeshTarget
from cmtof.scenes.objects.staging import Piece, staged
from cmtof.scenes.rooms.solids import box
from cmtof.scenes.rooms.thing import Mesh

Array = NDArray[np.float64]

STEEL = 0.58
"""Reflectance of polished steel at 532 nm (known: 0.55 to 0.6)."""
MIRRORED = 0.97
"""Weight of its specular law (assumed): the rest scatters as paint of 3 % would."""
FIELD = 0.34
"""Full angle that frames it, rad."""

_HEIGHT, _ROWS, _COLUMNS = 0.28, 440, 600
# share of the height, half breadth, front, back, m
_SECTIONS = np.array([(0.0, 0.104, 0.128, 0.112), (0.05, 0.097, 0.118, 0.105), (0.15, 0.092, 0.113,
    0.1), (0.3, 0.096, 0.118, 0.106), (0.5, 0.101, 0.122, 0.112), (0.62, 0.102, 0.12, 0.113),
    (0.75, 0.094, 0.108, 0.104), (0.87, 0.071, 0.08, 0.08), (0.95, 0.043, 0.05, 0.05),
    (0.99, 0.019, 0.022, 0.022), (1.0, 0.0, 0.0, 0.0)])  # fmt: skip


def helmet() -> MeshTarget:
    """Build the helmet before its wall, on a wooden block."""
    shell = _shell()
    raised = Mesh(shell.vertices + np.array([0, 0, 0.02], np.float32), shell.faces)
    block = box((0.26, 0.3, 0.02), (0, 0, 0.01), 0.002)
    pieces = [Piece(raised, STEEL, MIRRORED), Piece(block, 0.18, 0.03)]
    return staged(pieces, middle=0.155, pitch=0.08)


def _shell() -> Mesh:
    """The shell: a grid about the upright axis, without the faces that slits and holes take."""
    from scipy.interpolate import PchipInterpolator

    # rows closer together towards the crown, where the section closes; columns towards the face
    share = 1 - np.linspace(1, 0, _ROWS) ** 1.4
    side, front, back = PchipInterpolator(_SECTIONS[:, 0], _SECTIONS[:, 1:])(share).T[..., None]
    turn = np.linspace(-np.pi, np.pi, _COLUMNS, endpoint=False)
    turn = turn - 0.6 * np.sin(turn)  # 0 is the front
    x = side * np.sin(turn)
    y = np.where(np.cos(turn) > 0, -front, -back) * np.cos(turn)
    z = np.broadcast_to(share[:, None] * _HEIGHT, x.shape)
    grow = 1 + _relief(x, z, np.cos(turn)) / np.maximum(np.hypot(x, y), 0.02)
    points = np.stack([x * grow, y * grow, z], -1)
    index = np.arange(x.size, dtype=np.int32).reshape(x.shape)
    ring = np.concatenate([index, index[:, :1]], axis=1)
    a, b, c, d = ring[:-1, :-1], ring[:-1, 1:], ring[1:, 1:], ring[1:, :-1]
    middle = points.reshape(-1, 3)[np.stack([a, b, c, d])].mean(0)
    kept = ~_open(middle)
    faces = np.concatenate([np.stack(t, -1)[kept] for t in ((a, b, c), (a, c, d))])
    return Mesh(points.reshape(-1, 3).astype(np.float32), faces)


def _relief(x: Array, z: Array, ahead: Array) -> Array:
    """How far comb, brow, keel and rim stand out of the plain shell, m."""
    face = np.clip(3 * ahead, 0, 1)
    comb = 0.007 * np.exp(-((x / 0.006) ** 2)) * np.clip((z / _HEIGHT - 0.66) / 0.08, 0, 1)
    brow = 0.004 * np.exp(-(((z - 0.193 + 0.9 * x**2) / 0.006) ** 2)) * face
    keel = 0.012 * np.exp(-np.abs(x) / 0.012) * face * np.clip(1 - z / 0.185, 0, 1) ** 0.5
    rim = 0.003 * np.exp(-(((z - 0.006) / 0.004) ** 2))
    return comb + brow + keel + rim


def _slot(u: Array, v: Array, half: tuple[float, float]) -> NDArray[np.bool_]:
    """Inside a slot with round ends, half its breadth and height, m."""
    r = min(half)
    du, dv = np.maximum(np.abs(u) - (half[0] - r), 0), np.maximum(np.abs(v) - (half[1] - r), 0)
    return np.hypot(du, dv) < r


def _open(p: Array) -> NDArray[np.bool_]:
    """Where the shell (..., 3) is open: eyes, breaths, the back."""
    x, y, z = np.abs(p[..., 0]), p[..., 1], p[..., 2]
    ahead = y < -0.01
    eyes = _slot(x - 0.042, z - 0.171 - 0.12 * (x - 0.042), (0.028, 0.0085))
    breaths = np.zeros_like(eyes)
    for k in range(4):
        breaths |= _slot(x - 0.02 - 0.015 * k, z - 0.095 + 0.002 * k, (0.0042, 0.03 - 0.003 * k))
    holes = np.hypot(x - 0.03, z - 0.04) < 0.0055
    holes |= np.hypot(x - 0.05, z - 0.042) < 0.0055
    behind = (y > 0.02) & (z < 0.78 * _HEIGHT)
    return (ahead & (eyes | breaths | holes)) | behind
