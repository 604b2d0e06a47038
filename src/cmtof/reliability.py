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
