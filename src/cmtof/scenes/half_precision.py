"""What float16 does to depth, and a surface without its terraces.

A float16 has ten bits of mantissa. Between 2 and 4 m its steps are 2 mm, between 4 and 8 m 4 mm:
a plane becomes a flight of stairs, and each stair is a jump of phase.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.correlation import phase_from_depth

ROUNDS = 150
"""Steps of the descent; by then the error of a plane is down to a tenth or so."""

_BEND = 3.0  # steps; rounding alone bends a plane by up to 2


def float16_step(depth: ArrayLike) -> NDArray[np.float64]:
    """Distance of neighbouring float16 numbers at a depth, m.

    Examples
    --------
    >>> (1000 * float16_step([1.5, 3.0, 6.0, 12.0])).round(2).tolist()
    [0.98, 1.95, 3.91, 7.81]
    """
    return np.spacing(np.asarray(depth, np.float16)).astype(np.float64)


def float16_phase(depth: ArrayLike, frequency: ArrayLike) -> NDArray[np.floating]:
    """Phase of one float16 step of depth at a modulation frequency, Hz: ``4 pi f step / c``, rad.

    Examples
    --------
    >>> float16_phase([3.0, 6.0], 14.32e9).round(2).tolist()
    [1.17, 2.34]
    """
    return phase_from_depth(float16_step(depth), frequency)


def smoothed_within_step(depth: ArrayLike, rounds: int = ROUNDS) -> NDArray[np.float64]:
    """The least bent surface within half a float16 step of the stored depth at every pixel.

    Minimises the sum of squared second differences along rows and columns by accelerated projected
    gradient descent (Beck and Teboulle 2009), each pixel held between the middles to its neighbours
    among float16 numbers. Where depth bends by more than three steps a surface ends, and nothing
    crosses.

    Parameters
    ----------
    depth : array_like, shape (H, W)
        Range along the ray as float16 holds it, m; NaN, infinite or <= 0 where invalid.
    rounds : int
        Steps of the descent.

    Returns
    -------
    ndarray of float64, shape (H, W)
        Invalid pixels are as they were.
    """
    from cmtof.scenes.half_precision_kernel import descend

    stored = np.asarray(depth, np.float16)
    valid = np.isfinite(stored) & (stored > 0)
    centre = np.where(valid, stored, 0).astype(np.float64)
    below = np.nextafter(stored, np.float16(0)).astype(np.float64)
    above = np.nextafter(stored, np.float16(np.inf)).astype(np.float64)
    low = np.where(valid, (below - centre) / 2, 0)
    high = np.where(valid & np.isfinite(above), (above - centre) / 2, 0)
    limit = _BEND * float16_step(centre)
    along, down = (_bonds(centre, valid, limit, axis) for axis in (1, 0))
    change = descend(centre, low, high, along, down, rounds)
    return np.where(valid, centre + change, np.asarray(depth, np.float64))


def _bonds(
    depth: NDArray[np.float64], valid: NDArray[np.bool_], limit: NDArray[np.float64], axis: int
) -> NDArray[np.bool_]:
    """Pixels whose two neighbours along an axis lie on the same surface."""
    d, v, widest = (np.moveaxis(a, axis, 0) for a in (depth, valid, limit))
    bend = np.abs(d[:-2] - 2 * d[1:-1] + d[2:])
    widest = np.maximum(np.maximum(widest[:-2], widest[1:-1]), widest[2:])
    bonds = np.zeros(depth.shape, bool)
    whole = v.astype(bool)
    np.moveaxis(bonds, axis, 0)[1:-1] = whole[:-2] & whole[1:-1] & whole[2:] & (bend <= widest)
    return bonds
