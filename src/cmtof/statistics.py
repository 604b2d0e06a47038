"""Intervals of rates, and calibration of confidences.

Pixels of one frame are right or wrong together, so what varies from one test set to the next are
its scenes: intervals come from redrawing scenes (the bootstrap of `scipy.stats`).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cmtof.estimate import quotient
from cmtof.types import Array, Numbers


class Interval(NamedTuple):
    """A value and both ends of its confidence interval; floats or arrays of one shape."""

    value: Array
    low: Array
    high: Array


def ratio_interval(
    part: ArrayLike,
    whole: ArrayLike,
    *,
    draws: int = 2000,
    seed: int = 0,
) -> Interval:
    """95 % interval of a ratio of sums over frames, by percentiles over redrawn sets of frames.

    ``part`` and ``whole`` (..., F) are numerator and denominator of each frame, such as pixels
    right and scored. With under ten frames or so intervals are too narrow; with one they are NaN.
    A difference of two rates is
    ``ratio_interval(part - other, whole)``; it is known better than its two rates, as frames are
    hard for both.

    >>> found = ratio_interval(np.arange(100) % 2, np.ones(100))
    >>> float(found.value), round(float(found.low), 1), round(float(found.high), 1)
    (0.5, 0.4, 0.6)
    """
    from scipy.stats import bootstrap

    part, whole = (np.asarray(x, float) for x in np.broadcast_arrays(part, whole))

    def ratio(above: Array, below: Array, axis: int = -1) -> Array:
        return quotient(above.sum(axis), below.sum(axis))

    known = whole.sum(-1) > 0
    value = np.where(known, ratio(part, whole), np.nan)
    if part.shape[-1] < 2:
        return Interval(value[()], np.nan * value, np.nan * value)
    ends = bootstrap(
        (part, whole),
        ratio,
        axis=-1,
        paired=True,
        vectorized=True,
        method="percentile",
        n_resamples=draws,
        batch=200,
        rng=np.random.default_rng(seed),
    ).confidence_interval
    return Interval(value[()], *(np.where(known, end, np.nan)[()] for end in ends))


def conformal_quantile(scores: Sequence[Array], level: float) -> float:
    """Score below which, on average, at least a share ``level`` of a new group's scores lies.

    ``scores`` holds an array of each of n groups, such as the pixels of a room; groups are alike
    and independent, scores within one are not. A new group's risk, the share of its scores above q,
    is at most ``1 - level`` in the mean if ``(n R(q) + 1) / (n + 1)`` is, with R the mean risk of
    the n groups (conformal risk control: Angelopoulos, Bates, Fisch, Lei, Schuster, ICLR 2024).
    Infinite if n groups are too few to tell.

    >>> conformal_quantile(np.arange(1, 9).reshape(4, 2), 0.5)
    5.0
    """
    share = level * (1 + 1 / len(scores)) - 1e-12  # rounding must not pass a score
    if share > 1:
        return np.inf
    weights = np.concatenate([np.full(len(one), 1 / len(one)) for one in scores])
    quantile = np.quantile(
        np.concatenate(scores), share, weights=weights, method="inverted_cdf"
    )
    return float(quantile)


class Reliability(NamedTuple):
    """Bins of confidence (B,): mean confidence, share of right answers, number of answers."""

    confidence: Array
    right: Array
    answers: Numbers

    @property
    def calibration_error(self) -> float:
        """Mean of ``|right - confidence|`` over answers (Naeini, Cooper, Hauskrecht, AAAI 2015)."""
        if not self.answers.any():
            return float("nan")
        apart = np.nan_to_num(abs(self.right - self.confidence))
        return float(np.average(apart, weights=self.answers))


def reliability(
    confidence: ArrayLike, right: ArrayLike, *, bins: int = 20
) -> Reliability:
    """Share of right answers in each of ``bins`` bins of confidence, NaN where a bin is empty.

    ``confidence`` are probabilities in [0, 1], ``right`` whether each answer is right, of the same
    shape. ValueError if shapes differ or a confidence is no probability.

    >>> found = reliability([0.9, 0.9, 0.9, 0.1], [True, True, False, False], bins=2)
    >>> found.answers.tolist(), round(found.calibration_error, 3)
    ([1, 3], 0.2)
    """
    from scipy.stats import binned_statistic

    confidences = np.ravel(np.asarray(confidence, float))
    is_right = np.ravel(np.asarray(right, bool))
    if (
        confidences.shape != is_right.shape
        or not ((confidences >= 0) & (confidences <= 1)).all()
    ):
        raise ValueError(
            f"Expected a probability in [0, 1] for each of {is_right.size} answers, "
            f"got {confidences}. Leave out what was not answered."
        )
    (mean, share), _, number = binned_statistic(
        confidences * bins, [confidences, is_right], "mean", bins, (0, bins)
    )
    return Reliability(mean, share, np.bincount(number - 1, minlength=bins))
