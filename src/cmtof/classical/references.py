"""References that are given a part of the true depth: what accuracy that allows.

`reference_depth` reads the true depth against the measured phase. The others know the shape of
every true surface but not its place: phasors demodulated by the true depth, ``a_i exp(i (phi_i -
4 pi f_i z / c))``, are summed over it; the lower sum gives the offset within a wrap, the beat of
both the whole wraps. They are no bounds: neighbours could place small and dark surfaces.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.ndimage import find_objects, uniform_filter

from cmtof.bounds import wrap_probability
from cmtof.classical.beat import noise_of_mean, synthetic_frequency
from cmtof.classical.region import Pooled, components, mean_over, pool, whole_wraps
from cmtof.correlation import (
    consistent_wrap_count,
    depth_from_phase,
    depth_from_wraps,
    phase_from_depth,
)
from cmtof.estimate import Estimate
from cmtof.hardness import BEND, bends
from cmtof.measurement import Measurement
from cmtof.types import Array, Complex, Numbers

SIDE = 281  # receptive field of the paper's network as built here, px

# Mean of an image, zero outside, over a square of odd side, px, at each pixel.
_square_mean = partial(uniform_filter, mode="constant")


def reference_depth(measurement: Measurement) -> Estimate:
    """The measured phase with the wraps that bring it nearest to the true depth.

    By the paper's count 9 % of them are wrong: noise carries phases across the boundary of a wrap.
    """
    frequency = measurement.frequencies[0]
    phase = measurement.phase[0]
    truth = _truth(measurement)
    known = np.isfinite(truth)
    wraps = consistent_wrap_count(np.where(known, truth, 0), phase, frequency)
    depth = np.where(
        known, depth_from_wraps(phase, wraps, frequency), sum(measurement.range) / 2
    )
    return Estimate(depth, known.astype(float))


def reference_offset(measurement: Measurement) -> Estimate:
    """True surfaces, one unknown offset each, found by the beat of the summed phasors."""
    return _estimate_from_shapes(measurement, surfaces)


def reference_contact(measurement: Measurement) -> Estimate:
    """True bodies, joined across creases, one unknown offset each, by the beat of their phasors."""
    return _estimate_from_shapes(measurement, bodies)


def reference_field(measurement: Measurement, *, side: int = SIDE) -> Estimate:
    """True surfaces, their phasors summed in a square of odd ``side``, px, about each pixel."""
    return _estimate_from_shapes(measurement, surfaces, side)


def surfaces(depth: Array) -> Numbers:
    """Number of each pixel's surface (H, W), connected between `bends`; those stand alone."""
    inside = ~bends(depth)
    return components(inside[1:] & inside[:-1], inside[:, 1:] & inside[:, :-1])


def bodies(depth: Array) -> Numbers:
    """Number of each pixel's body (H, W): connected by steps of depth that are no jumps.

    A step is no jump if it is below 4 mm, or differs by less from the step before or after it, as
    at a crease.
    """
    links = []
    for image in (depth, depth.T):
        steps = np.diff(image, axis=0)
        least = abs(steps)
        bend = abs(np.diff(steps, axis=0))
        for side in (np.s_[1:], np.s_[:-1]):
            least[side] = np.fmin(least[side], bend)
        links.append(least <= BEND)
    down, across = links
    return components(down, across.T)


def _truth(measurement: Measurement) -> Array:
    """True depth (H, W), m, NaN where unknown."""
    assert measurement.depth is not None  # `Method` has made sure
    return measurement.depth.astype(float)


def _estimate_from_shapes(
    measurement: Measurement, shapes: Callable[[Array], Numbers], side: int = 0
) -> Estimate:
    """Estimate of true shapes, at offsets from the phasors summed over each.

    With an odd ``side``, px, phasors are summed only over a square about each pixel.
    """
    truth = _truth(measurement)
    surface = shapes(truth)
    known = np.isfinite(truth)
    shape = np.nan_to_num(truth)
    # turned back by the true depth; zero where it is unknown
    true_phase = phase_from_depth(shape, measurement.frequencies[:, None, None])
    amplitude = np.nan_to_num(measurement.amplitude)
    phasors = amplitude * np.exp(1j * (measurement.phase - true_phase))
    if side:
        sums = [_pool_within(one, surface, side) for one in phasors]
        middle = shape
    else:
        # of each surface, then of each pixel
        sums = [Pooled(*np.array(pool(one, surface))[:, surface]) for one in phasors]
        middle = mean_over(shape, surface, known & measurement.mask)[surface]
    depth = shape + _offset(sums, middle, measurement)
    odds = wrap_probability(
        sums[0].spread, sums[1].spread, frequencies=measurement.frequencies
    )
    depth = np.where(known, depth, sum(measurement.range) / 2)
    return Estimate(depth, np.where(known, odds, 0))


def _offset(sums: list[Pooled], middle: Array, measurement: Measurement) -> Array:
    """Offset (H, W), m, to add to a shape of mean depth ``middle``, m, from both summed phasors."""
    low, high = measurement.frequencies
    synthetic = synthetic_frequency(low, high)
    beat = synthetic.sign * (sums[1].phase - synthetic.multiple * sums[0].phase)
    return whole_wraps(beat, middle, measurement, depth_from_phase(sums[0].phase, low))


def _pool_within(phasors: Complex, surface: Numbers, side: int) -> Pooled:
    """Phase and spread (H, W), rad, of phasors summed over each pixel's surface in a square."""
    phase = np.angle(phasors)
    spread = np.full(phasors.shape, np.inf)
    size = np.bincount(surface.ravel())
    for number, place in enumerate(find_objects(surface + 1)):
        if size[number] < 2:
            continue
        inside = surface[place] == number
        own_phasors = np.where(inside, phasors[place], 0)
        share = np.maximum(_square_mean(inside.astype(float), side), 0.5 / side**2)
        mean = _square_mean(own_phasors, side) / share
        power = _square_mean(abs(own_phasors) ** 2, side) / share
        noise = noise_of_mean(mean, power, np.maximum(share * side**2, 1))
        known = inside & np.isfinite(noise)
        phase[place][inside] = np.angle(mean)[inside]
        spread[place][known] = noise[known]
    return Pooled(phase, spread)
