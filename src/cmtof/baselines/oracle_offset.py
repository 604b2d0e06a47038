"""True surfaces, one unknown offset each: what pooling over a whole surface could tell at best.

The shape of every surface is taken from the truth, where it lies is not. It is a reference and no
bound: it gives up boundaries, and small or dark surfaces that their neighbours could place.
"""

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines import Estimate, within_range
from cmtof.baselines.beat import synthetic_frequency
from cmtof.baselines.region import Pooled, components, mean_over, nearest, pool, whole_wraps
from cmtof.bounds import wrap_probability
from cmtof.correlation import depth_from_phase, phase_from_depth
from cmtof.measurement import Measurement

STEP = 4e-3
"""Second difference of depth that ends a surface, m."""


def oracle_offset(
    measurement: Measurement, *, step: float = STEP, extend: bool = False
) -> Estimate:
    """Place every true surface by the beat of its summed phasors.

    Both phasors are demodulated by the true depth, ``a_i exp(i (phi_i - 4 pi f_i z / c))``, and
    added up over each surface. The low frequency's sum tells the offset within a wrap, the beat of
    both sums the whole wraps; the offset is added back to the true shape.

    Pixels of a boundary belong to no surface: each is left with its own beat, which is right once
    in a hundred times, so the rates are those of counting boundaries wrong.

    Parameters
    ----------
    measurement : Measurement
        With its true depth.
    step : float
        A surface ends where the second difference of depth along x or y exceeds this, m.
    extend : bool
        Give the pixels of a boundary the offset of the surface nearest in the image instead.

    Raises
    ------
    ValueError
        If the step is not positive.
    """
    assert measurement.depth is not None  # `Method` has made sure
    truth = measurement.depth.astype(float)
    surface, boundary = surfaces(truth, step)
    if extend:
        surface = surface[nearest(~boundary)]
    return placed(measurement, np.where(np.isfinite(truth), truth, 0), surface)


def oracle_contact(measurement: Measurement, *, step: float = STEP) -> Estimate:
    """Place what hangs together, creases and all, by the beat of its summed phasors.

    As `oracle_offset`, but a wall and the floor it stands on, or a cup and its table, share one
    offset: their true shape is known across the crease. Only jumps of depth come between.

    Parameters
    ----------
    measurement : Measurement
        With its true depth.
    step : float
        What a step of depth must exceed the steps on both of its sides by, m.

    Raises
    ------
    ValueError
        If the step is not positive.
    """
    assert measurement.depth is not None  # `Method` has made sure
    truth = measurement.depth.astype(float)
    return placed(measurement, np.where(np.isfinite(truth), truth, 0), bodies(truth, step))


def bodies(depth: NDArray[np.floating], step: float = STEP) -> NDArray[np.intp]:
    """Number of each pixel's body (H, W): components of pixels without a jump between them.

    Two neighbours hang together if the step from one to the other is within ``step``, m, of none,
    or of the one before or behind it: across a crease it is one of the two, across a jump neither.
    """
    _check(step)
    links = []
    for axis in (0, 1):
        steps = np.diff(depth, axis=axis)
        width = [(0, 0), (0, 0)]
        nearest_step = abs(steps)
        if steps.shape[axis] > 1:
            bend = abs(np.diff(steps, axis=axis))
            for side in ((1, 0), (0, 1)):
                width[axis] = side
                beside = np.pad(bend, width, constant_values=np.inf)
                nearest_step = np.fmin(nearest_step, beside)
        links.append(nearest_step <= step)
    return components(*links)


def placed(
    measurement: Measurement, shape: NDArray[np.floating], surface: NDArray[np.intp]
) -> Estimate:
    """Surfaces, each moved to where its summed phasors say that it lies.

    Parameters
    ----------
    measurement : Measurement
        With its true depth, of which only what is unknown is looked at.
    shape : ndarray, shape (H, W)
        Depth, m, but for one offset a surface.
    surface : ndarray of int, shape (H, W)
        Number of each pixel's surface.
    """
    phasors = demodulated(measurement, shape)
    first, second = (Pooled(*(one[surface] for one in pool(p, surface))) for p in phasors)
    assert measurement.depth is not None
    counted = np.isfinite(measurement.depth) & measurement.mask
    return located(measurement, shape, first, second, mean_over(shape, surface, counted)[surface])


def located(
    measurement: Measurement,
    shape: NDArray[np.floating],
    first: Pooled,
    second: Pooled,
    middle: NDArray[np.floating],
) -> Estimate:
    """Depth of a shape (H, W), m, from what was pooled of both frequencies about each pixel.

    ``middle`` (H, W), m, is the part of the shape that lies in range with its offset.
    """
    assert measurement.depth is not None
    known = np.isfinite(measurement.depth)
    low, high = (float(f) for f in measurement.frequencies[:2])
    synthetic = synthetic_frequency(low, high)
    beat = synthetic.sign * (second.phase - synthetic.multiple * first.phase)
    offset = whole_wraps(beat, middle, measurement, depth_from_phase(first.phase, low))
    odds = np.asarray(wrap_probability(first.spread, second.spread, frequencies=(low, high)))
    depth = np.where(known, shape + offset, sum(measurement.range) / 2)
    return Estimate(within_range(depth, measurement), np.where(known, odds, 0))


def surfaces(
    depth: NDArray[np.floating], step: float = STEP
) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Number of each pixel's surface (H, W), every boundary pixel one of its own, and which are.

    A surface is a connected component (4 neighbours) of pixels whose second differences
    ``|z(x-1) - 2 z(x) + z(x+1)|`` along both axes stay within ``step``, m; next to the image's
    border there is none to exceed it, and unknown depth always does.
    """
    from scipy.ndimage import label

    _check(step)
    smooth = np.isfinite(depth)
    for axis in (0, 1):
        if depth.shape[axis] > 2:
            inner = (slice(None),) * axis + (slice(1, -1),)
            smooth[inner] &= np.abs(np.diff(depth, n=2, axis=axis)) <= step
    numbers = np.zeros(depth.shape, np.intp)
    label(smooth, output=numbers)
    numbers[~smooth] = numbers.max() + 1 + np.arange(np.count_nonzero(~smooth))
    return numbers - 1, ~smooth


def _check(step: float) -> None:
    if not step > 0:
        raise ValueError(f"Expected a step > 0 m, got {step:g}. Try {STEP:g}.")


def demodulated(
    measurement: Measurement, depth: NDArray[np.floating]
) -> NDArray[np.complexfloating]:
    """Phasors (2, H, W) turned back by a depth, counts; zero where not finite."""
    turned = phase_from_depth(depth, measurement.frequencies[:2, None, None])
    with np.errstate(invalid="ignore"):
        phasors = measurement.amplitude[:2] * np.exp(1j * (measurement.phase[:2] - turned))
    return np.where(np.isfinite(phasors), phasors, 0)
