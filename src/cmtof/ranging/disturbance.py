"""What moves fringes besides the target: vibration, speckle, slow drift, as random processes."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import lfilter
from scipy.sparse import csr_array

Array = NDArray[np.float64]
Phasor = NDArray[np.complex128]


def vibration(
    rng: np.random.Generator,
    count: int,
    interval: float,
    *,
    rms: float,
    frequency: float,
    quality: float,
) -> Array:
    """Displacement of a resonance under white forcing (count,), m, sampled exactly.

    Real part of a circular Gaussian process with the covariance ``rms^2 exp((i w - w / 2 Q) |t|)``.

    Parameters
    ----------
    rng : numpy.random.Generator
    count : int
    interval : float
        Between samples, s.
    rms, frequency, quality : float
        m, Hz, quality factor Q.
    """
    if rms == 0:
        return np.zeros(count)
    keep = np.exp((1j - 1 / (2 * quality)) * 2 * np.pi * frequency * interval)
    return rms * np.real(_carried(_circular(rng, count), keep))


def vibration_spread(interval: ArrayLike, *, rms: float, frequency: float, quality: float) -> Array:
    """Standard deviation, m, of `vibration`'s change over an interval, s.

    ``sqrt(2 (1 - exp(-w t / 2 Q) cos w t))`` times the rms.
    """
    angle = 2 * np.pi * frequency * np.asarray(interval, float)
    return rms * np.sqrt(2 * (1 - np.exp(-angle / (2 * quality)) * np.cos(angle)))


def drift(
    rng: np.random.Generator, count: int, interval: float, *, rms: float, time: float
) -> Array:
    """Slow drift (count,) about where it began: 0 first, then Ornstein-Uhlenbeck, unit of rms."""
    if rms == 0:
        return np.zeros(count)
    keep = np.exp(-interval / time)
    walk = _carried(rng.standard_normal(count), keep)
    return rms * (walk - walk[0])


def _carried(normals: NDArray[Any], keep: complex) -> NDArray[Any]:
    """Stationary first-order process of unit variance: ``x_k = keep x_(k-1) + rest``."""
    fresh = np.sqrt(1 - abs(keep) ** 2) * normals
    fresh[:1] = normals[:1]
    return np.asarray(lfilter([1.0], [1.0, -keep], fresh))


def _circular(rng: np.random.Generator, count: int) -> Phasor:
    """Circular complex normals whose real and imaginary parts have unit variance each."""
    return rng.standard_normal((count, 2)).view(complex)[:, 0]


class Speckle:
    """Field of a rough plate in the reference mode along its travel: circular complex Gaussian.

    Mean square 1, correlation ``exp(-(d / length)^2)`` over a travel d. Its intensity follows an
    exponential law: it drops below a small share q of its mean with the odds q.

    Parameters
    ----------
    places : array_like, shape (N,)
        Travel, m.
    length : float
        m, above 0.
    """

    def __init__(self, places: ArrayLike, length: float) -> None:
        # white noise on a grid, smoothed by exp(-2 d^2 / L^2); a grid of L/3 leaves no ripple
        x = 3 * np.asarray(places, float) / length
        x = x - x.min()
        near = np.arange(-7, 8)
        column = np.rint(x).astype(int)[:, None] + near
        weight = np.exp(-2 / 9 * (x[:, None] - column) ** 2)
        weight /= np.sqrt(np.sum(np.exp(-4 / 9 * np.arange(-30, 31) ** 2)))
        rows = np.arange(0, x.size * near.size + 1, near.size)
        self._nodes = int(column.max()) + 8
        self._smooth = csr_array(
            (weight.ravel(), column.ravel() + 7, rows), shape=(x.size, self._nodes)
        )

    def draw(self, rng: np.random.Generator) -> Phasor:
        """One plate (N,)."""
        return self._smooth @ (_circular(rng, self._nodes) / np.sqrt(2))
