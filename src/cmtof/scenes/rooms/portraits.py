"""Heads and shoulders, modelled over a stack of sections; the socles that carry them, m."""

from typing import NamedTuple

import numpy as np

from cmtof.scenes.rooms.joinery import boards
from cmtof.scenes.rooms.materials import Material
from cmtof.scenes.rooms.pliant import Points, ripples
from cmtof.scenes.rooms.shaping import turned
from cmtof.scenes.rooms.solids import joined, sheet
from cmtof.scenes.rooms.thing import Mesh


class Face(NamedTuple):
    """What tells one portrait from another; lengths as shares of the head's height."""

    nose: float
    jaw: float
    brow: float
    hair: float
    """Thickness of the hair; 0 for a bald head."""
    curl: float
    """Depth of its waves."""
    beard: float
    turn: float
    """Of the head against the shoulders, rad."""
    nod: float
    broad: float
    """Half breadth of the shoulders."""
    cut: str
    """How the chest ends: rounded, square (a herm) or at the neck."""


# height, half breadth, front, back, as shares of the head's height; 0 at the chin, 1 at the crown
_HEAD = np.array([(-0.22, 0.285, -0.19, 0.31), (-0.1, 0.26, -0.175, 0.28), (-0.03, 0.25, -0.23,
    0.25), (0.01, 0.235, -0.365, 0.24), (0.08, 0.265, -0.395, 0.26), (0.20, 0.300, -0.400, 0.32),
    (0.34, 0.318, -0.395, 0.39), (0.48, 0.328, -0.390, 0.43), (0.62, 0.335, -0.400, 0.445), (0.76,
    0.320, -0.375, 0.42), (0.88, 0.262, -0.285, 0.345), (0.96, 0.165, -0.16, 0.22), (0.995, 0.06,
    -0.04, 0.10), (1.0, 0.0, 0.03, 0.03)])  # fmt: skip
_CHEST = {"rounded": np.array([(-1.08, 0.10, -0.16, 0.14), (-1.0, 0.40, -0.33, 0.22), (-0.86, 0.80,
    -0.41, 0.28), (-0.7, 1.0, -0.40, 0.32), (-0.56, 0.94, -0.35, 0.34), (-0.46, 0.62, -0.28, 0.34),
    (-0.39, 0.36, -0.22, 0.32)]), "square": np.array([(-1.0, 0.92, -0.40, 0.28), (-0.8, 0.98, -0.41,
    0.31), (-0.62, 1.0, -0.38, 0.33), (-0.52, 0.86, -0.33, 0.34), (-0.44, 0.55, -0.27, 0.33),
    (-0.38, 0.34, -0.22, 0.32)]), "neck": np.array([(-0.5, 0.26, -0.2, 0.28), (-0.44, 0.27, -0.21,
    0.31), (-0.38, 0.27, -0.2, 0.31)])}  # fmt: skip


def _sections(face: Face, rows: int) -> Points:
    chest = _CHEST[face.cut] + [0.13, 0, 0, 0]
    if face.cut != "neck":
        lower = np.clip((-0.24 - chest[:, 0]) / 0.2, 0, 1)
        chest[:, 1] *= 1 + (face.broad - 1) * lower
    stack = np.concatenate([chest, _HEAD])
    step = np.linalg.norm(np.diff(stack, axis=0), axis=1)
    share = np.where(stack[:-1, 0] < -0.1, 0.55, 1.5) * step  # rows go where the face is
    at = np.concatenate([[0], np.cumsum(share)])
    wanted = np.linspace(0, at[-1], rows)
    made = np.stack([np.interp(wanted, at, column) for column in stack.T], -1)
    smooth = made.copy()
    for _ in range(2):
        smooth[1:-1, 1:] = 0.25 * smooth[:-2, 1:] + 0.5 * smooth[1:-1, 1:] + 0.25 * smooth[2:, 1:]
    return smooth


def _bell(u: Points, v: Points, at: tuple[float, float], size: tuple[float, float]) -> Points:
    return np.exp(-(((u - at[0]) / size[0]) ** 2) - ((v - at[1]) / size[1]) ** 2)


def _features(x: Points, z: Points, face: Face) -> Points:
    """How far the face stands out of the plain head at (x, z), shares of the head's height."""
    a = np.abs(x)
    ridge = np.interp(z, [0.27, 0.31, 0.35, 0.5, 0.56], [0, 1.0, 0.95, 0.35, 0.0])
    out = face.nose * ridge * np.exp(-((a / (0.036 + 0.035 * np.clip(0.5 - z, 0, 0.2) / 0.2)) ** 2))
    out += 0.25 * face.nose * _bell(a, z, (0.055, 0.315), (0.03, 0.028))  # nostrils
    out -= 0.075 * _bell(a, z, (0.14, 0.475), (0.075, 0.05))  # sockets
    out += 0.042 * _bell(a, z, (0.14, 0.47), (0.052, 0.026))  # eyes
    out += face.brow * _bell(a, z, (0.12, 0.565), (0.1, 0.03))
    out += 0.028 * _bell(a, z, (0.2, 0.36), (0.07, 0.06))  # cheek bones
    out += 0.034 * _bell(a, z, (0, 0.205), (0.085, 0.021))  # upper lip
    out += 0.036 * _bell(a, z, (0, 0.155), (0.07, 0.021))
    out -= 0.03 * _bell(a, z, (0, 0.18), (0.1, 0.009))
    out -= 0.018 * _bell(a, z, (0, 0.115), (0.09, 0.02))
    out += face.jaw * _bell(a, z, (0, 0.05), (0.075, 0.045))
    return out + face.beard * _bell(a, z, (0, 0.02), (0.2, 0.16)) * (
        1 - _bell(a, z, (0, 0.18), (0.09, 0.03))
    )


def portrait(
    rng: np.random.Generator, face: Face, height: float, rows: int = 52, columns: int = 48
) -> Mesh:
    """Head, neck and shoulders as one surface, its lowest point at z = 0, looking towards -y.

    Parameters
    ----------
    height : float
        Of the head from chin to crown, m: 0.23 in life.
    """
    s = _sections(face, rows)
    turn = np.linspace(0, 2 * np.pi, columns, endpoint=False)
    angle = turn + 0.42 * np.sin(turn)  # columns crowd towards the back of this, the face
    c, n = np.cos(angle + np.pi / 2), np.sin(angle + np.pi / 2)
    z = np.repeat(s[:, :1], columns, 1)
    x = s[:, 1:2] * np.sign(c) * np.abs(c) ** 0.9
    y = np.where(n > 0, s[:, 3:4] * n, -s[:, 2:3] * n)
    narrow = np.interp(z, [-0.1, 0.03, 0.25, 0.6], [0, 0.33, 0.2, 0.08])
    x = x * (1 - narrow * np.clip(-n, 0, 1) ** 1.5)
    on_head = np.clip((z + 0.06) / 0.08, 0, 1)
    y = y - on_head * _features(x, z, face) * np.clip(-n, 0, 1) ** 0.5 * (z < 0.75)
    side = (np.exp(-(((y - 0.06) / 0.06) ** 2) - ((z - 0.42) / 0.12) ** 2) * np.clip(np.abs(c), 0,
        1) ** 4)  # fmt: skip
    x = x + 0.075 * np.sign(c) * side  # ears
    line = 0.76 + 0.0 * n - 0.5 * np.clip(n + 0.45, 0, 1)
    hair = np.clip((z - line) / 0.05, 0, 1) * (1 - 0.999 * side)
    wave = 1 + face.curl * ripples(rng, 3.2 * angle / np.pi + 0 * z, 3 * z + 0.4 * angle, 10, 0.9)
    wave = 1 + (wave - 1) * np.clip((0.99 - z) / 0.15, 0, 1)  # one height at the crown
    grow = 1 + face.hair * hair * wave / 0.4
    x, y = x * grow, 0.03 + (y - 0.03) * grow
    z = z + face.hair * hair * wave * np.clip((z - 0.8) / 0.2, 0, 1)
    points = _posed(np.stack([x, y, z], -1), face) * height
    points[..., 2] -= points[..., 2].min()
    closed = np.concatenate(
        [np.broadcast_to(points[:1].mean(1, keepdims=True), points[:1].shape), points]
    )
    return sheet(closed[:, ::-1], closed=True)


def _posed(points: Points, face: Face) -> Points:
    """The head turned and nodded upon its neck."""
    x, y, z = np.moveaxis(points, -1, 0)
    share = np.clip((z + 0.25) / 0.3, 0, 1)
    share = share**2 * (3 - 2 * share)
    c, s = np.cos(face.turn * share), np.sin(face.turn * share)
    x, y = c * x - s * y, s * x + c * y
    p, q = np.cos(face.nod * share), np.sin(face.nod * share)
    return np.stack([x, p * y - q * (z + 0.2) * 1.0, q * y + p * (z + 0.2) - 0.2], -1)


def draw_face(rng: np.random.Generator, cut: str) -> Face:
    """Somebody."""
    return Face(nose=float(rng.uniform(0.1, 0.15)), jaw=float(rng.uniform(0.01, 0.045)),
        brow=float(rng.uniform(0.02, 0.045)), hair=float(rng.choice([0.0, 0.03, 0.05, 0.08])),
        curl=float(rng.uniform(0.3, 0.9)), beard=float(rng.choice([0.0, 0.0, 0.06, 0.1])),
        turn=float(rng.normal(0, 0.25)), nod=float(rng.uniform(-0.05, 0.12)),
        broad=float(rng.uniform(0.85, 1.05)), cut=cut)  # fmt: skip


def socle(width: float, height: float, square: bool) -> Mesh:
    """What a bust stands on: a turned waist on a square base, or a block, m."""
    w, h = width, height
    if square:
        return joined([boards([(-w / 2, w / 2, -w / 2, w / 2, 0, 0.2 * h)], 0.003),
            boards([(-0.42 * w, 0.42 * w, -0.42 * w, 0.42 * w, 0.19 * h, h)], 0.003)])  # fmt: skip
    profile = np.array([(0, 0.15), (0.46, 0.15), (0.46, 0.3), (0.3, 0.42), (0.24, 0.6), (0.3, 0.82),
        (0.42, 0.9), (0.42, 1.0), (0, 1.0)]) * [w, h]  # fmt: skip
    return joined(
        [turned(profile, 24, 18), boards([(-w / 2, w / 2, -w / 2, w / 2, 0, 0.2 * h)], 0.003)]
    )


STATUARY: tuple[Material, ...] = (Material((0.78, 0.76, 0.72), (0.5, 0.5, 0.5), "marble", 0.12,
    specular=0.06, gloss=60.0), Material((0.8, 0.79, 0.77), specular=0.01), Material((0.16, 0.1,
    0.045), (0.07, 0.09, 0.06), "noise", 0.05, specular=0.25, gloss=40.0), Material((0.45, 0.2,
    0.1), (0.38, 0.16, 0.08), "noise", 0.03, specular=0.01), Material((0.04, 0.04, 0.042),
    specular=0.08, gloss=40.0), Material((0.62, 0.45, 0.18), specular=0.5, gloss=80.0),
    Material((0.4, 0.39, 0.36), (0.3, 0.29, 0.27), "noise", 0.015, specular=0.0,
    bump=0.3))  # fmt: skip
"""Marble, plaster, bronze, terracotta, basalt, gilt, sandstone."""


def statuary(rng: np.random.Generator) -> Material:
    """What statues are made of."""
    return STATUARY[int(rng.integers(len(STATUARY)))]
