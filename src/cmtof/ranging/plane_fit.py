r"""Planes through measured points: parallel ones at a step's two sides, and what R^2 says of one.

With the points of group g on :math:`z = a x + b y + c_g`, two parallel planes are

.. math:: h = \frac{c_0 - c_1}{\sqrt{1 + a^2 + b^2}}

apart. The share of the depth's variance that one plane explains, in its expected values, is

.. math:: R^2 = 1 - \frac{\sigma^2}{\mathrm{var}(z)} = 1 - \frac{\sigma^2}{s^2 + \sigma^2},
          \qquad s^2 = \frac{(a L_x)^2 + (b L_y)^2}{12},

for noise sigma on a plane scanned over a rectangle L_x by L_y: tilt and extent, not the noise
alone.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class PlaneFit(NamedTuple):
    """Parallel planes z = a x + b y + c_g through points, by least squares in z."""

    slopes: Array
    """(2,), dz/dx and dz/dy."""
    offsets: Array
    """(G,), m: z of each group's plane on the axis."""
    covariance: Array
    """(2 + G, 2 + G) of slopes and offsets, from the residuals' own scatter."""
    residual: Array
    """(N,), m."""
    r_squared: float
    """Share of the variance of z, about its mean, that the planes explain."""


def fit_planes(points: ArrayLike, group: ArrayLike | None = None) -> PlaneFit:
    """Fit one plane, or parallel planes through groups of points.

    Parameters
    ----------
    points : array_like, shape (N, 3)
        x, y, z, m, all finite.
    group : array_like, shape (N,), or None
        Number of each point's plane, from 0.

    Raises
    ------
    ValueError
        For points that are not finite, or too few to fit planes to.

    Examples
    --------
    >>> x, y = np.mgrid[:3, :4].reshape(2, -1) / 100
    >>> fit = fit_planes(np.column_stack([x, y, 1 + 0.5 * x - 0.001 * (y > 0.01)]), y > 0.01)
    >>> height, _ = step_height(fit)
    >>> f"{1e3 * height * np.sqrt(1.25):.3f} mm"
    '1.000 mm'
    """
    points = np.asarray(points, float)
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise ValueError(
            f"Expected finite points (N, 3), got shape {points.shape}. Leave out what is missing."
        )
    which = np.zeros(len(points), int) if group is None else np.asarray(group).astype(int)
    member = which[:, None] == np.arange(which.max(initial=0) + 1)
    design = np.column_stack([points[:, :2], member])
    unknowns = design.shape[1]
    if len(points) <= unknowns or np.linalg.matrix_rank(design) < unknowns:
        raise ValueError(
            f"Expected more than {unknowns} points that span each plane, got {len(points)} of "
            f"rank {np.linalg.matrix_rank(design)}. Take more points."
        )
    z = points[:, 2]
    found = np.linalg.lstsq(design, z, rcond=None)[0]
    residual = z - design @ found
    variance = residual @ residual / (len(z) - unknowns)
    covariance = variance * np.linalg.inv(design.T @ design)
    explained = 1 - residual @ residual / ((z - z.mean()) ** 2).sum()
    return PlaneFit(found[:2], found[2:], covariance, residual, float(explained))


def step_height(fit: PlaneFit) -> tuple[float, float]:
    """Distance from plane 1 to plane 0 along their normal, and its standard error, m.

    The error counts independent noise alone: not what all points share, or a block's points share.
    """
    if len(fit.offsets) != 2:
        raise ValueError(f"Expected two planes, got {len(fit.offsets)}. Number the points 0 and 1.")
    cosine = 1 / np.sqrt(1 + fit.slopes @ fit.slopes)
    way = np.array([1.0, -1.0])
    spread = np.sqrt(way @ fit.covariance[2:, 2:] @ way)
    return float(way @ fit.offsets * cosine), float(spread * cosine)


# --- R^2 <-> noise -----------------------------------------------------------------------------


def depth_spread(slopes: ArrayLike, extents: ArrayLike) -> Array:
    """Standard deviation of depth, m, over a plane (..., 2) scanned over a rectangle (..., 2), m.

    Examples
    --------
    >>> f"{1e3 * depth_spread([0.5, 0.0], [0.2, 0.2]):.1f} mm"
    '28.9 mm'
    """
    return np.sqrt((np.square(np.multiply(slopes, extents))).sum(axis=-1) / 12)


def r_squared_from_noise(noise: ArrayLike, spread: ArrayLike) -> Array:
    """R^2 that noise (...), m, leaves to a plane of this spread of depth (...), m.

    Examples
    --------
    >>> float(r_squared_from_noise(1.0, 3.0))
    0.9
    """
    square = np.square(np.asarray(noise, float))
    return 1 - square / (square + np.square(np.asarray(spread, float)))


def noise_from_r_squared(r_squared: ArrayLike, spread: ArrayLike) -> Array:
    """Noise (...), m, with which a plane of this spread (...), m, has such an R^2, 0 to 1.

    Raises
    ------
    ValueError
        For an R^2 outside of (0, 1].

    Examples
    --------
    >>> float(noise_from_r_squared(0.9, 3.0).round(12))
    1.0
    """
    share = np.asarray(r_squared, float)
    if not ((share > 0) & (share <= 1)).all():
        raise ValueError(f"Expected R^2 above 0, at most 1, got {r_squared}. Fit again.")
    return np.asarray(spread, float) * np.sqrt((1 - share) / share)
