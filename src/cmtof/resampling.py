"""How sure a rate is: intervals from drawing scenes again, with replacement (the bootstrap).

Pixels of one frame are right or wrong together, so a million of them do not make a million trials.
What varies from one test set to the next are its scenes, and those are drawn again here.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

LEVEL = 0.95
"""Share of the redrawn sets that an interval holds."""


class Interval(NamedTuple):
    """A value, and the ends of its interval; floats or arrays of one shape."""

    value: Array
    low: Array
    high: Array

    @property
    def excludes_zero(self) -> NDArray[np.bool_]:
        """Whether all of the interval lies on one side of 0."""
        return np.asarray((self.low > 0) | (self.high < 0))


def draws_of(frames: int, *, draws: int = 2000, rng: np.random.Generator) -> NDArray[np.int64]:
    """Draw sets of frames with replacement.

    Parameters
    ----------
    frames, draws : int
        How many frames there are, and how many sets to draw.

    Returns
    -------
    ndarray of int, shape (draws, frames)
        How often each frame stands in each set. Rates that are compared share one such array.

    Raises
    ------
    ValueError
        If there is no frame or no draw.

    Examples
    --------
    >>> draws_of(4, draws=3, rng=np.random.default_rng(0)).sum(axis=1).tolist()
    [4, 4, 4]
    """
    if frames < 1 or draws < 1:
        raise ValueError(
            f"Expected at least one frame and one draw, got {frames} and {draws}. Ask for more."
        )
    return rng.multinomial(frames, np.full(frames, 1 / frames), size=draws)


def ratio_interval(
    part: ArrayLike, whole: ArrayLike, drawn: ArrayLike, *, level: float = LEVEL
) -> Interval:
    """Interval of a ratio of sums over frames, by percentiles over the drawn sets.

    With few frames (under ten or so) such intervals are too narrow.

    Parameters
    ----------
    part, whole : array_like, shape (..., F)
        Numerator and denominator of each frame, such as pixels right and pixels scored.
    drawn : array_like, shape (D, F)
        From `draws_of`.
    level : float
        Share of the drawn sets inside.

    Returns
    -------
    Interval
        Each of shape (...); NaN where no frame has anything in the denominator.

    Raises
    ------
    ValueError
        If the numbers of frames differ.

    Examples
    --------
    >>> drawn = draws_of(100, rng=np.random.default_rng(0))
    >>> found = ratio_interval(np.arange(100) % 2, np.ones(100), drawn)
    >>> float(found.value), round(float(found.low), 1), round(float(found.high), 1)
    (0.5, 0.4, 0.6)
    """
    part, whole = (np.asarray(x, float) for x in np.broadcast_arrays(part, whole))
    return _interval(_ratio(part.sum(-1), whole.sum(-1)), _redrawn(part, whole, drawn), level)


def difference_interval(
    part: ArrayLike,
    other: ArrayLike,
    whole: ArrayLike,
    drawn: ArrayLike,
    *,
    level: float = LEVEL,
) -> Interval:
    """Interval of ``part / whole - other / whole``, both on the same drawn frames.

    Frames that are hard for one method are hard for the other; drawn together they cancel, so a
    difference is known better than its two rates.

    Parameters
    ----------
    part, other, whole : array_like, shape (..., F)
    drawn, level
        As in `ratio_interval`.
    """
    arrays = np.broadcast_arrays(part, other, whole)
    part, other, whole = (np.asarray(x, float) for x in arrays)
    value = _ratio(part.sum(-1) - other.sum(-1), whole.sum(-1))
    return _interval(value, _redrawn(part - other, whole, drawn), level)


def _redrawn(part: Array, whole: Array, drawn: ArrayLike) -> Array:
    """Ratio in each drawn set (..., D)."""
    times = np.asarray(drawn, float)
    if times.ndim != 2 or times.shape[1] != part.shape[-1]:
        raise ValueError(
            f"Expected draws of {part.shape[-1]} frames, got an array of shape {times.shape}. "
            "Draw from as many frames as were counted."
        )
    return _ratio(part @ times.T, whole @ times.T)


def _ratio(part: Array, whole: Array) -> Array:
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(whole > 0, part / whole, np.nan)[()]


def _interval(value: Array, redrawn: Array, level: float) -> Interval:
    if not 0 < level < 1:
        raise ValueError(f"Expected a level between 0 and 1, got {level}. Try {LEVEL}.")
    # a stratum that no frame has is empty in every draw; one that few have, in some
    known = np.asarray(np.isfinite(redrawn).any(-1))
    filled = np.where(known[..., None], redrawn, 0.0)
    ends = np.nanpercentile(filled, [50 * (1 - level), 50 * (1 + level)], axis=-1)
    low, high = np.where(known, ends, np.nan)
    return Interval(value, low, high)
