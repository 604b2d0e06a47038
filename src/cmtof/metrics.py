"""How good an unwrapping is: delta rates by both wrap counts, depth errors."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from cmtof.correlation import consistent_wrap_count, wrap_count_from_depth
from cmtof.measurement import Measurement

LIMITS = (1, 2, 3, 10)


def delta_rates(wrap_count: ArrayLike, true_count: ArrayLike) -> dict[str, float]:
    """Shares of pixels by wrap error ``delta = |n - n_true|``, Tables 1-3.

    Parameters
    ----------
    wrap_count, true_count : array_like of int, shape (...)
        Scored pixels only.

    Returns
    -------
    dict
        ``delta_lt_1``, ``delta_lt_2``, ``delta_lt_3``, ``delta_ge_3``, ``delta_ge_10``.

    Examples
    --------
    >>> delta_rates([5, 6, 8, 25], [5, 5, 5, 5])["delta_lt_2"]
    0.5
    """
    delta = np.abs(np.asarray(wrap_count, np.int64) - np.asarray(true_count, np.int64))
    if delta.size == 0:
        raise ValueError("Expected at least one scored pixel, got none. Check mask and range.")
    below = {limit: float(np.mean(delta < limit)) for limit in LIMITS}
    return {
        "delta_lt_1": below[1],
        "delta_lt_2": below[2],
        "delta_lt_3": below[3],
        "delta_ge_3": 1 - below[3],
        "delta_ge_10": 1 - below[10],
    }


class Scored(dict[str, NDArray]):
    """Per-pixel quantities of the scored pixels of one frame, to be pooled over frames."""


def scored_pixels(result: xr.Dataset, measurement: Measurement) -> Scored:
    """Gather a result and its truth over the valid pixels that have a depth.

    Returns
    -------
    Scored
        ``wrap_count``, ``true_count``, ``consistent``, ``true_consistent`` (int), and
        ``depth_error`` (m), each of shape (P,).

    Raises
    ------
    ValueError
        If the measurement holds no true depth or no valid pixel.
    """
    truth = measurement.depth
    if truth is None:
        raise ValueError("Expected a measurement with its true depth, got none. Simulate one.")
    scored = measurement.mask & np.isfinite(truth)
    if not scored.any():
        raise ValueError("Expected at least one scored pixel, got none. Check mask and range.")
    frequency = measurement.frequencies[0]
    depth, phase = truth[scored].astype(float), measurement.phase[0][scored].astype(float)
    estimate = result["depth"].to_numpy()[scored].astype(float)
    return Scored(
        wrap_count=result["wrap_count"].to_numpy()[scored],
        true_count=wrap_count_from_depth(depth, frequency),
        consistent=consistent_wrap_count(estimate, phase, frequency),
        true_consistent=consistent_wrap_count(depth, phase, frequency),
        depth_error=estimate - depth,
    )


def score(frames: Scored | Sequence[Scored]) -> dict[str, float]:
    """Rates and depth errors over all scored pixels of one or more frames.

    Returns
    -------
    dict
        The rates of `delta_rates` by the paper's count, ``consistent_lt_1`` by the count that
        turns the measured phase into depth, ``depth_rmse_m`` and ``depth_median_error_m``.
    """
    frames = [frames] if isinstance(frames, Mapping) else list(frames)
    pooled = {key: np.concatenate([frame[key] for frame in frames]) for key in frames[0]}
    error = np.abs(pooled["depth_error"])
    return {
        **delta_rates(pooled["wrap_count"], pooled["true_count"]),
        "consistent_lt_1": float(np.mean(pooled["consistent"] == pooled["true_consistent"])),
        "depth_rmse_m": float(np.sqrt(np.mean(error**2))),
        "depth_median_error_m": float(np.median(error)),
    }
