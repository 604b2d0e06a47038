"""Materials of rooms: a reflectance, a pattern of two colours, light of their own."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]
Colour = tuple[float, float, float]


class Material(NamedTuple):
    """How a surface looks; reflectance is linear."""

    colour: Colour = (0.6, 0.6, 0.6)
    second: Colour = (0.6, 0.6, 0.6)
    """The pattern's other colour."""
    pattern: str = "plain"
    """Key of `PATTERNS`."""
    scale: float = 0.1
    """Period of the pattern, m."""
    emission: float = 0.0
    """Radiance of its own light per reflectance; a white wall at irradiance 1 has radiance 1."""


def _hash(i: Array, j: Array) -> Array:
    """Number in [0, 1) for each pair of whole numbers."""
    a = i.astype(np.int64).astype(np.uint32) * np.uint32(374761393)
    a += j.astype(np.int64).astype(np.uint32) * np.uint32(668265263)
    a = (a ^ (a >> np.uint32(13))) * np.uint32(1274126177)
    return ((a ^ (a >> np.uint32(16))) & np.uint32(0xFFFF)).astype(np.float32) / np.float32(65536)


def _noise(s: Array, t: Array) -> Array:
    """Value noise with one cell a unit, 0 to 1."""
    i, j = np.floor(s), np.floor(t)
    x, y = s - i, t - j
    x, y = x * x * (3 - 2 * x), y * y * (3 - 2 * y)
    low = _hash(i, j) * (1 - x) + _hash(i + 1, j) * x
    high = _hash(i, j + 1) * (1 - x) + _hash(i + 1, j + 1) * x
    return low * (1 - y) + high * y


def _joints(s: Array, t: Array) -> Array:
    return np.maximum(s % 1 < 0.05, t % 1 < 0.05).astype(np.float32)


def _planks(s: Array, t: Array) -> Array:
    row = np.floor(t)
    board = np.floor(s / 8 + _hash(row, row))
    tone = _hash(row, board)
    return np.where(t % 1 < 0.04, 1.0, 0.7 * tone + 0.3 * _noise(s / 2, 9 * t))


def _wood(s: Array, t: Array) -> Array:
    return 0.5 + 0.5 * np.sin(2 * np.pi * (t + 0.8 * _noise(s / 6, t / 2)))


PATTERNS: dict[str, Callable[[Array, Array], Array]] = {
    "plain": lambda s, t: np.zeros_like(s),
    "stripes": lambda s, t: (s % 1 < 0.5).astype(np.float32),
    "checks": lambda s, t: ((np.floor(s) + np.floor(t)) % 2).astype(np.float32),
    "tiles": _joints,
    "bricks": lambda s, t: _joints(s / 2 + 0.5 * (np.floor(t) % 2), t),
    "planks": _planks,
    "wood": _wood,
    "noise": lambda s, t: 0.7 * _noise(s, t) + 0.3 * _noise(3 * s, 3 * t),
    "dots": lambda s, t: ((s % 1 - 0.5) ** 2 + (t % 1 - 0.5) ** 2 < 0.09).astype(np.float32),
}
"""Share, 0 to 1, of the second colour at coordinates in periods."""

_ORDER = list(PATTERNS)


class Palette:
    """Materials of many parts as arrays, looked up by number.

    Parameters
    ----------
    materials : sequence of Material
    """

    def __init__(self, materials: Sequence[Material]) -> None:
        self._colour = np.array([m.colour for m in materials], np.float32)
        self._second = np.array([m.second for m in materials], np.float32)
        self._scale = np.array([m.scale for m in materials], np.float32)
        self._pattern = np.array([_ORDER.index(m.pattern) for m in materials])
        self.emission = np.array([m.emission for m in materials], np.float32)
        mean = np.where(self._pattern == 0, 0.0, 0.4)[:, None].astype(np.float32)
        self.mean = self._colour + mean * (self._second - self._colour)
        """Reflectance (M, 3) without its pattern."""

    def albedo(self, number: NDArray, position: Array, normal: Array, footprint: Array) -> Array:
        """Reflectance (N, 3) of points of materials ``number`` (N,).

        Parameters
        ----------
        number : ndarray of int, shape (N,)
        position, normal : ndarray, shape (N, 3)
            In the world, m. The pattern lies in the plane that the normal is nearest to.
        footprint : ndarray, shape (N,)
            Size of a pixel on the surface, m; finer patterns fade to their mean.
        """
        found = self._colour[number]
        pattern = self._pattern[number]
        for code in np.unique(pattern):
            if code == 0:
                continue
            some = np.flatnonzero(pattern == code)
            kind = number[some]
            axis = np.abs(normal[some]).argmax(axis=1)
            x, y, z = (position[some] / self._scale[kind][:, None]).T
            s, t = np.where(axis == 0, y, x), np.where(axis == 2, y, z)
            mix = PATTERNS[_ORDER[code]](s, t)
            faded = np.clip(2.5 * footprint[some] / self._scale[kind] - 0.5, 0, 1)
            mix = (mix + faded * (0.4 - mix)).astype(np.float32)[:, None]
            found[some] += mix * (self._second[kind] - found[some])
        return found
