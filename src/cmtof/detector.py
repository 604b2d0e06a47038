"""Detection: photon and electronic noise of counts, and quantisation by an ADC.

All-optical correlation has no charge buckets, so its noise is Poisson-Gaussian (Sec. 5.3); the
multi-bucket pixel of a correlation camera subtracts two Poisson counts and is Skellam-Gaussian.
"""

from typing import Literal, get_args

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike

from cmtof.types import Array

NoiseOrder = Literal["paper", "released"]

# numpy draws Poisson counts as int64; beyond this mean the counts would overflow
_LARGEST_MEAN = 9.2e18


def poisson_gaussian(
    mean: ArrayLike,
    *,
    rng: Generator,
    sigma: float,
    order: NoiseOrder = "paper",
) -> Array:
    """Counts with photon and Gaussian noise from their expectation (Eq. 8, Sec. 5.3).

    ``sigma`` is that of the Gaussian noise, counts; float32 means stay float32. Order
    ``"paper"`` adds it to Poisson counts, as Eq. 8 is written; results may be negative. Order
    ``"released"`` does as the authors' released code: Gaussian noise first, clipped at zero, then
    Poisson counts of that. Raises a ValueError for another order, and for negative or non-finite
    means or sigma.

    >>> rng = np.random.default_rng(0)
    >>> counts = poisson_gaussian(np.full(100_000, 400.0), rng=rng, sigma=15.0)
    >>> round(counts.std())  # sqrt(400 + 15^2)
    25
    """
    if order not in get_args(NoiseOrder):
        raise ValueError(
            f"Expected order 'paper' or 'released', got {order!r}. Choose one."
        )
    mean = np.asarray(mean) + np.float32(0)
    _check_counts(mean, sigma)
    gaussian = rng.standard_normal(mean.shape, dtype=mean.dtype.type)
    gaussian *= float(sigma)
    if order == "released":
        gaussian += mean
        return rng.poisson(np.maximum(gaussian, 0)).astype(mean.dtype)
    gaussian += rng.poisson(mean)
    return gaussian


def _check_counts(mean: Array, sigma: float) -> None:
    low = mean.min(initial=0.0)
    high = mean.max(initial=0.0)
    if not (low >= 0 and high < _LARGEST_MEAN):  # NaN is refused as well
        raise ValueError(
            f"Expected finite counts >= 0, got values from {low:.6g} to {high:.6g}. "
            "Check intensity, gain and exposure."
        )
    if not 0 <= sigma < np.inf:
        raise ValueError(
            f"Expected a finite noise sigma >= 0, got {sigma}. Give it in counts."
        )


def skellam_gaussian(
    bucket_a: ArrayLike, bucket_b: ArrayLike, *, rng: Generator, sigma: float = 0.0
) -> Array:
    """Difference of two charge buckets, Poisson each, plus Gaussian read noise (Sec. 5.3).

    From the expected counts of the two buckets; mean ``a - b``, variance ``a + b + sigma^2``.
    """
    means = np.array(np.broadcast_arrays(bucket_a, bucket_b), float)
    _check_counts(means, sigma)
    a, b = rng.poisson(means)
    return (a - b).astype(float) + sigma * rng.standard_normal(means.shape[1:])


def quantise(signal: ArrayLike, *, bits: int, full_scale: float) -> Array:
    """Signal rounded to the levels of an N-bit ADC, Q of Eq. 20; beyond its scale it saturates.

    ``2^bits`` levels from 0 to ``full_scale``, which has the unit of the signal.

    >>> quantise([-1.0, 0.4, 0.6, 9.0], bits=2, full_scale=3.0).tolist()
    [0.0, 0.0, 1.0, 3.0]
    """
    if not (bits >= 1 and full_scale > 0):
        raise ValueError(
            f"Expected bits >= 1 and full_scale > 0, got {bits} and {full_scale}. "
            "A 14-bit converter has bits=14."
        )
    step = full_scale / (2**bits - 1)
    return np.clip(np.rint(np.divide(signal, step)), 0, 2**bits - 1) * step
