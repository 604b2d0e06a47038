"""Materials of rooms: a reflectance, a pattern of two colours, light of their own."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cmtof.types import Array, Arrays, Flags, Numbers
from cmtof_rooms.boxes import Triple

Colour = Triple

MEAN_SHARE = 0.4  # share of the second colour where a pattern is too fine to be seen


class Material(NamedTuple):
    """How a surface looks; reflectance is linear."""

    colour: Colour = (0.6, 0.6, 0.6)
    second: Colour = (0.6, 0.6, 0.6)  # the pattern's other colour
    pattern: str = "plain"  # or a key of `PATTERNS`
    scale: float = 0.1  # period of the pattern, m
    # Radiance of its own light per reflectance; a white wall at irradiance 1 has radiance 1.
    emission: float = 0.0


def _hash(i: Array, j: Array) -> Array:
    """Number in [0, 1), which looks random, for each pair of whole numbers."""
    mixed = i.astype(np.int64) * 374761393 + j.astype(np.int64) * 668265263
    bits = mixed.astype(np.uint32)
    bits ^= bits >> 13
    bits *= 1274126177
    bits ^= bits >> 16
    return (bits & 0xFFFF).astype(np.float32) / 65536


def _noise(s: Array, t: Array) -> Array:
    """Smooth noise, 0 to 1, with one random value at each pair of whole numbers (value noise)."""
    i = np.floor(s)
    j = np.floor(t)
    x = _smooth_step(s - i)
    y = _smooth_step(t - j)
    low, high = [_mix(_hash(i, row), _hash(i + 1, row), x) for row in (j, j + 1)]
    return _mix(low, high, y)


def _mix(first: Array, second: Array, share: Array) -> Array:
    """Mean of two values, with the share of the second."""
    return first * (1 - share) + second * share


def _smooth_step(share: Array) -> Array:
    """Share, 0 to 1, bent so that its slope is 0 at both ends (smoothstep)."""
    return share * share * (3 - 2 * share)


def _stripes(s: Array, t: Array) -> Flags:
    """Stripes along t."""
    return s % 1 < 0.5


def _checks(s: Array, t: Array) -> Array:
    """Chequered squares of two colours."""
    return (np.floor(s) + np.floor(t)) % 2


def _tiles(s: Array, t: Array) -> Flags:
    """Joints of square tiles."""
    return (s % 1 < 0.05) | (t % 1 < 0.05)


def _bricks(s: Array, t: Array) -> Flags:
    """Joints of bricks, each second row shifted by half a brick."""
    return _tiles(s / 2 + 0.5 * (np.floor(t) % 2), t)


def _planks(s: Array, t: Array) -> Array:
    """Boards of different tones with grain, and the gaps between their rows."""
    row = np.floor(t)
    board = np.floor(s / 8 + _hash(row, row))
    tone = 0.7 * _hash(row, board) + 0.3 * _noise(s / 2, 9 * t)
    return np.where(t % 1 < 0.04, 1.0, tone)


def _wood(s: Array, t: Array) -> Array:
    """Wood: share of the second colour, 0 to 1, as growth rings that are cut along s."""
    ring = t + 0.8 * _noise(s / 6, t / 2)
    return 0.5 + 0.5 * np.sin(2 * np.pi * ring)


def _cloudy(s: Array, t: Array) -> Array:
    """Noise with finer noise in it."""
    return 0.7 * _noise(s, t) + 0.3 * _noise(3 * s, 3 * t)


def _dots(s: Array, t: Array) -> Flags:
    """Round dots in rows."""
    off_centre = (s % 1 - 0.5) ** 2 + (t % 1 - 0.5) ** 2
    return off_centre < 0.09


# Share, 0 to 1, of the second colour at coordinates in periods; a plain material has no pattern.
PATTERNS = {
    "stripes": _stripes,
    "checks": _checks,
    "tiles": _tiles,
    "bricks": _bricks,
    "planks": _planks,
    "wood": _wood,
    "noise": _cloudy,
    "dots": _dots,
}


# The fields of a `Material` as types of arrays.
_LOOK = [
    ("colour", "3f4"),
    ("second", "3f4"),
    ("pattern", "U16"),
    ("scale", "f4"),
    ("emission", "f4"),
]


class Palette:
    """Materials of many parts as arrays, looked up by number.

    Parameters
    ----------
    materials : sequence of Material

    Attributes
    ----------
    looks : structured ndarray, shape (M,)
        Materials with the fields that `Material` has, in single precision.
    mean : ndarray of float32, shape (M, 3)
        Reflectance of a typical pattern's mean: its second colour has the share `MEAN_SHARE`.
    """

    def __init__(self, materials: Sequence[Material]) -> None:
        self.looks = np.array(materials, _LOOK)
        first = self.looks["colour"]
        share = np.float32(MEAN_SHARE) * (self.looks["pattern"] != "plain")[:, None]
        self.mean = first + share * (self.looks["second"] - first)

    def albedo(
        self,
        number: Numbers,
        position: Array,
        normal: Array,
        footprint: Array,
    ) -> Array:
        """Reflectance (..., 3) of points whose materials have the numbers ``number`` (...).

        Parameters
        ----------
        number : ndarray of int, shape (...)
        position, normal : ndarray, shape (..., 3)
            In the room, m. The pattern lies in the two axes that the normal is farthest from.
        footprint : ndarray, shape (...)
            Size of a pixel on the surface, m; finer patterns fade to their mean.
        """
        looks = self.looks[number]
        found = looks["colour"]
        for name, pattern in PATTERNS.items():
            some = looks["pattern"] == name
            scale = looks["scale"][some]
            s, t = _coordinates(position[some] / scale[:, None], normal[some])
            share = pattern(s, t).astype(np.float32)
            fade = np.clip(2.5 * footprint[some] / scale - 0.5, 0, 1)
            share = (share + fade * (MEAN_SHARE - share)).astype(np.float32)[:, None]
            found[some] += share * (looks["second"][some] - found[some])
        return found


def _coordinates(position: Array, normal: Array) -> Arrays:
    """Coordinates (N,) in the two axes that the normal (N, 3) is farthest from."""
    axis = np.abs(normal).argmax(axis=1)
    x, y, z = position.T
    return np.where(axis == 0, y, x), np.where(axis == 2, y, z)
