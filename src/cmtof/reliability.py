"""Whether a confidence means what it says: reliability, calibration error, risk and coverage."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Reliability(NamedTuple):
    """Answers sorted by their confidence into bins of equal width, B of them over [0, 1]."""

    confidence: NDArray[np.float64]
    """Mean confidence (B,); NaN in an empty bin."""
    right: NDArray[np.float64]
    """Share of right answers (B,); NaN in an empty bin."""
    answers: NDArray[np.int64]
    """Answers (B,)."""

    @property
    def calibration_error(self) -> float:
        """Mean of ``|right - confidence|`` over answers (Naeini, Cooper, Hauskrecht, AAAI 2015)."""
        if not self.answers.any():
            return float("nan")
        apart = np.nan_to_num(np.abs(self.right - self.confidence))
        return float(np.average(apart, weights=self.answers))


def reliability(confidence: ArrayLike, right: ArrayLike, *, bins: int = 20) -> Reliability:
    """Sort answers by confidence and count how many of each bin are right.

    Parameters
    ----------
    confidence : array_like
        Probabilities in [0, 1], of any shape.
    right : array_like of bool
        Whether each answer is right, of the same shape.
    bins : int
        B.

    Raises
    ------
    ValueError
        If shapes differ or a confidence is no probability.

    Examples
    --------
    >>> found = reliability([0.9, 0.9, 0.9, 0.1], [True, True, False, False], bins=2)
    >>> found.answers.tolist(), round(found.calibration_error, 3)
    ([1, 3], 0.2)
    """
    said, good = np.ravel(np.asarray(confidence, float)), np.ravel(np.asarray(right, bool))
    if said.shape != good.shape or not ((said >= 0) & (said <= 1)).all():
        raise ValueError(
            f"Expected a probability in [0, 1] for each of {good.size} answers, got {said.size} "
            f"from {np.min(said, initial=np.inf):g} to {np.max(said, initial=-np.inf):g}. "
            "Leave out what was not answered."
        )
    place = np.minimum((said * bins).astype(int), bins - 1)
    count = np.bincount(place, minlength=bins)
    each = np.where(count > 0, count, np.nan)
    return Reliability(
        np.bincount(place, said, bins) / each, np.bincount(place, good, bins) / each, count
    )


def honest_errors(
    confidence: ArrayLike,
    fate: ArrayLike,
    *,
    draws: int = 200,
    bins: int = 20,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Calibration errors (draws,) that confidences would show if every one of them were true.

    Answers that share a fate, such as the pixels of one surface, are right or wrong together: with
    few of them a bin's share of right ones strays from its confidence by luck alone.

    Parameters
    ----------
    confidence : array_like
        Probabilities in [0, 1].
    fate : array_like of int
        Of the same shape: number of the group that each answer belongs to.
    draws, bins : int
        How often the fates are drawn; bins as in `reliability`.
    rng : Generator

    Raises
    ------
    ValueError
        If the shapes differ.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> alone = honest_errors(np.full(1000, 0.5), np.arange(1000), rng=rng)
    >>> together = honest_errors(np.full(1000, 0.5), np.zeros(1000, int), rng=rng)
    >>> round(float(alone.mean()), 2), round(float(together.mean()), 2)
    (0.01, 0.5)
    """
    said, group = np.ravel(np.asarray(confidence, float)), np.ravel(np.asarray(fate))
    if said.shape != group.shape:
        raise ValueError(
            f"Expected a fate for each of {said.size} answers, got {group.size}. Give every answer "
            "the number of its group."
        )
    groups, member = np.unique(group, return_inverse=True)
    # answers of one fate and one hundredth of confidence are one: sums over pixels become few
    grade = np.minimum((said * 100).astype(int), 99)
    cells, cell = np.unique(member.astype(np.int64) * 100 + grade, return_inverse=True)
    count = np.bincount(cell)
    mean = np.bincount(cell, said) / count
    place = np.minimum((mean * bins).astype(int), bins - 1)
    found = np.empty(draws)
    for i in range(draws):
        right = mean > rng.random(groups.size)[cells // 100]
        off = np.bincount(place, count * (right - mean), bins)
        found[i] = np.abs(off).sum() / max(said.size, 1)
    return found


class RiskCoverage(NamedTuple):
    """What is lost by answering only where one is sure."""

    coverage: NDArray[np.float64]
    """Share of pixels answered, surest first (N,)."""
    risk: NDArray[np.float64]
    """Share of wrong ones among them (N,)."""


def risk_coverage(confidence: ArrayLike, right: ArrayLike, *, points: int = 200) -> RiskCoverage:
    """Share of wrong answers among the surest ones, against how many of them are given.

    Equal confidences are answered in an order that knows nothing of the truth: as they come.

    Examples
    --------
    >>> found = risk_coverage([0.9, 0.2, 0.8, 0.1], [True, False, True, False], points=2)
    >>> found.coverage.tolist(), found.risk.tolist()
    ([0.5, 1.0], [0.0, 0.5])
    """
    said, good = np.ravel(np.asarray(confidence, float)), np.ravel(np.asarray(right, bool))
    wrong = np.cumsum(~good[np.argsort(-said, kind="stable")])
    kept = np.unique(np.linspace(0, said.size, points + 1).round().astype(int)[1:])
    kept = kept[kept > 0]
    return RiskCoverage(kept / max(said.size, 1), wrong[kept - 1] / kept)
