"""True surfaces, seen through a window: what pooling within a receptive field could tell at best.

`cmtof.baselines.oracle_offset` adds up the phasors of a whole surface. A network sees no further
than its receptive field, a window no further than its side: here each pixel gets the sum over those
pixels of its surface that lie within a square about it.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines import Estimate
from cmtof.baselines.beat import box
from cmtof.baselines.oracle_offset import STEP, demodulated, located, surfaces
from cmtof.baselines.region import Pooled
from cmtof.measurement import Measurement

SIDE = 281
"""Receptive field of the paper's network as we built it, px."""


def oracle_field(measurement: Measurement, *, side: int = SIDE, step: float = STEP) -> Estimate:
    """Place every pixel by the beat of its surface's phasors within a square.

    Parameters
    ----------
    measurement : Measurement
        With its true depth.
    side : int
        Odd side of the square, px.
    step : float
        Second difference of depth that ends a surface, m.

    Raises
    ------
    ValueError
        If the side is not odd or the step not positive.
    """
    if side < 1 or side % 2 == 0:
        raise ValueError(f"Expected an odd side of 1 px or more, got {side}. Try {SIDE}.")
    assert measurement.depth is not None  # `Method` has made sure
    truth = measurement.depth.astype(float)
    surface, _ = surfaces(truth, step)
    shape = np.where(np.isfinite(truth), truth, 0)
    first, second = (
        pool_within(phasor, surface, side) for phasor in demodulated(measurement, shape)
    )
    return located(measurement, shape, first, second, shape)


def pool_within(
    phasors: NDArray[np.complexfloating], surface: NDArray[np.intp], side: int
) -> Pooled:
    """Sum phasors (H, W) over each pixel's surface within a square; angles and spreads (H, W)."""
    phase, spread = np.angle(phasors), np.full(phasors.shape, np.inf)
    for place, inside in pieces(surface):
        ours = np.where(inside, phasors[place], 0)
        share, mean, power = (
            box(image, side, beyond="constant")
            for image in (inside.astype(float), ours, np.abs(ours) ** 2)
        )
        share = np.maximum(share, 0.5 / side**2)
        mean, scatter = mean / share, np.maximum(power / share - np.abs(mean / share) ** 2, 0)
        count = np.maximum(share * side**2, 1)
        length = np.abs(mean)
        known = inside & (count > 1.5) & (length > 0)
        noise = np.sqrt(scatter / (2 * np.maximum(count - 1, 1))) / np.where(known, length, 1)
        phase[place][inside] = np.angle(mean)[inside]
        spread[place][known] = noise[known]
    return Pooled(phase, spread)


def pieces(
    surface: NDArray[np.intp],
) -> Iterator[tuple[tuple[slice, slice], NDArray[np.bool_]]]:
    """Bounding box of each surface of two pixels and more, and which pixels in it are its own."""
    from scipy.ndimage import find_objects

    size = np.bincount(surface.ravel())
    # single pixels, the boundaries, are many; they need no box
    number = np.where(size > 1, np.cumsum(size > 1), 0)[surface]
    for k, place in enumerate(find_objects(number), start=1):
        yield place, number[place] == k
