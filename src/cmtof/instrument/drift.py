"""What changes slowly, and random numbers that depend on keys alone, never on history."""

import numpy as np
from numpy.random import Generator, Philox
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
_MASK = (1 << 64) - 1

PURPOSES = {"label": 1, "drift": 5, "codes": 6, "speckle": 7}
"""Streams of random numbers that never meet, by what they are for."""


def keyed_generator(seed: int, purpose: str, key: int = 0) -> Generator:
    """Generator whose numbers depend on the arguments only.

    Philox is counter-based (Salmon et al., SC 2011): the key is (seed, purpose), and ``key``
    starts the counter 2^64 blocks away from its neighbours, so that streams never overlap.
    """
    words = np.array([seed & _MASK, PURPOSES[purpose]], np.uint64)
    return Generator(Philox(key=words, counter=np.array([0, key & _MASK, 0, 0], np.uint64)))


def uniform_from_places(seed: int, places: ArrayLike, count: int) -> Array:
    """Uniform numbers (N, count) in (0, 1) that depend on the seed and on places (N, 2) only.

    Places (integers from -2^31 to 2^31 - 1) and columns are mixed by the finaliser of SplitMix64
    (Steele et al., OOPSLA 2014).
    """
    pair = np.asarray(places).astype(np.int64).view(np.uint64)
    start = _mixed(np.array([seed & _MASK, PURPOSES["speckle"]], np.uint64))
    # arrays of unsigned integers wrap round without a warning
    word = (pair[:, :1] << np.uint64(32)) ^ (pair[:, 1:] & np.uint64(0xFFFFFFFF))
    column = np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    mixed = _mixed(_mixed(word ^ start[:1]) + start[1:] + column)
    return ((mixed >> np.uint64(11)).astype(float) + 0.5) / 2.0**53


def _mixed(word: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Bits of 64-bit words, mixed."""
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return word ^ (word >> np.uint64(31))


class Drift:
    """Sum of sinusoids of equal strength at octaves from 1 mHz to 0.5 Hz: a 1/f spectrum.

    It is a function of time alone, bounded by 1, with the rms `Drift.RMS`. ``seed`` and
    ``channel`` choose the phases.
    """

    COUNT = 10
    RMS = float(1 / np.sqrt(2 * COUNT))

    def __init__(self, seed: int, channel: int) -> None:
        rng = keyed_generator(seed, "drift", channel)
        octaves = 1e-3 * 2.0 ** np.arange(self.COUNT)
        # off the exact octaves, or the sum would be periodic
        self._rate = 2 * np.pi * octaves * rng.uniform(0.9, 1.1, self.COUNT)
        self._phase = rng.uniform(0, 2 * np.pi, self.COUNT)

    def __call__(self, time: ArrayLike) -> Array:
        """Drift in [-1, 1] at times (...), s."""
        angle = np.multiply.outer(np.asarray(time, float), self._rate) + self._phase
        return np.sin(angle).sum(-1) / self.COUNT
