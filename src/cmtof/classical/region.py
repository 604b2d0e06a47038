"""Spatial unwrapping of one frequency, alone or in regions, each placed by its summed beat.

Unwrapped over the image, one frequency gives the shape of each surface but for whole wraps; pooled
over a region, the beat gives those. It fails where regions leak: a depth jump that is small modulo
one wrap leaves no mark in the phase, two surfaces share an offset, and one of them is wrong.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median, uniform_filter
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cmtof.bounds import wrap_probability
from cmtof.classical.beat import (
    beat_depth,
    beat_phasor,
    estimate_with_beat,
    steps,
    synthetic_frequency,
)
from cmtof.correlation import TAU, depth_from_phase, phase_from_depth, wrap_length
from cmtof.estimate import (
    Estimate,
    guess_probability,
    nearest_pixel,
    quotient,
    within_range,
)
from cmtof.measurement import Measurement
from cmtof.types import Array, Arrays, Complex, Flags, Numbers

# Steps between neighbours that cut, the best of two and three values on eight views of validation
# rooms: of the unwrapped phase, rad, and of the smoothed logarithm of amplitude.
STEP = 1.0
EDGE = 0.1
# Error of an offset over the scatter of its patches and what the middle one leaves of the beat: the
# likeliest on 32 views of other rooms, at none of which the confidence exceeds the rate by 0.15.
# On 64 views of further rooms, both protocols, without noise and at 300, 1200 and 2000 counts, it
# does in 7 of 512 cases, by 0.26 at most, and lies 0.09 below in the mean: offsets of large regions
# are all or nothing, so that a single view strays by 0.07 to 0.19.
SPREADS = 2.0
# Pixels off the region whose depth a pixel takes, and a factor, counted on views of 45 training
# and validation rooms.
BESIDE = ((0.5, 1.5, 4, 10, 30), (1, 0.65, 0.45, 0.28, 0.15))
_COHERENCE = 0.1  # of the local slope, below which a pixel belongs to no region
_SMALLEST = 100  # px, below which a region takes the depth of a larger one beside it


class Pooled(NamedTuple):
    """Phase of summed phasors and its standard deviation, rad; infinite for a single pixel."""

    phase: Array
    spread: Array


def spatial(measurement: Measurement) -> Estimate:
    """Reliability-sorted unwrapping of the lowest frequency's phase.

    One frequency leaves the absolute wrap open: whole wraps move the median of the image next to
    mid-range, and the confidence is that of a guess. Jumps of more than half a wrap are lost.
    """
    frequency = measurement.frequencies[0]
    relative = relative_phase(measurement)
    middle = phase_from_depth(sum(measurement.range) / 2, frequency)
    offset = np.rint((middle - np.median(relative[measurement.mask])) / TAU)
    depth = depth_from_phase(relative + TAU * offset, frequency)
    return Estimate(depth, guess_probability(measurement))


def region(measurement: Measurement) -> Estimate:
    """Depth by regions of the spatially unwrapped phase, each placed by its pooled beat.

    Regions end where the unwrapped phase or the amplitude steps. The angle of the summed phasors of
    the beat, demodulated by the relative depth, gives the whole wraps of each. They are as sure as
    its patches agree, the middle one of which depths that leak in cannot move.
    """
    frequencies = measurement.frequencies
    mask = measurement.mask
    phase = relative_phase(measurement)
    bright, coherent = _brightness(measurement)
    inside = mask & (coherent >= _COHERENCE)
    number = components(*_links(phase, bright, inside))
    shape = depth_from_phase(phase, frequencies[0])
    turned = np.exp(-1j * _beat_phase(shape, frequencies))
    parts = patches(np.where(mask, beat_phasor(measurement) * turned, 0), number)
    pooled = pool(*parts)
    offset = whole_wraps(pooled.phase, mean_over(shape, number, mask), measurement)
    odds = _offset_odds(*parts, pooled.spread, offset, frequencies)
    near = nearest_pixel(inside & (np.bincount(number.ravel())[number] >= _SMALLEST))
    return estimate_with_beat(
        within_range((shape + offset[number])[near], measurement),
        odds[number][near]
        * np.interp(np.hypot(*(near - np.indices(mask.shape))), *BESIDE),
        measurement,
    )


def _beat_phase(depth: Array, frequencies: Array) -> Array:
    """Unwrapped phase of the beat, rad, at depths, m."""
    return phase_from_depth(depth, synthetic_frequency(*frequencies).frequency)


def _offset_odds(
    sums: Complex, region_of: Numbers, spread: Array, offset: Array, frequencies: Array
) -> Array:
    """Probability (S,) that offsets (S,), m, of regions are right, by the phases of their patches.

    Their scatter ``spread``, rad, and the misfit of the median patch count. ``sums`` are of
    `patches`, and ``region_of`` is the region of each.
    """
    rest = sums * np.exp(-1j * _beat_phase(offset, frequencies)[region_of])
    middle = median(np.angle(rest), region_of, np.arange(offset.size))
    spread = SPREADS * np.hypot(spread, middle)
    return wrap_probability(0, spread, frequencies=frequencies)


def _brightness(measurement: Measurement) -> Arrays:
    """Logarithm of smoothed amplitude (H, W), and coherence, which sinks at edges.

    That is the length of ``sum p(x+1) conj p(x)`` over those of its parts, in 11 x 11 px, times the
    same along the other axis; p is the phasor of the lowest frequency.
    """
    amplitude = np.nan_to_num(measurement.amplitude)
    phasor = amplitude[0] * np.exp(1j * measurement.phase[0])
    coherence = np.ones(phasor.shape)
    for axis in (0, 1):
        pairs = steps(phasor, axis)
        length = uniform_filter(abs(pairs), 11)
        coherence *= quotient(abs(uniform_filter(pairs, 11)), length)
    bright = uniform_filter(amplitude.sum(axis=0), 5)
    # a tenth of the mean keeps the logarithm of noise in the dark from making edges
    return np.log(0.1 + np.maximum(bright, 0) / (bright.mean() or 1.0)), coherence


def _links(phase: Array, bright: Array, inside: Flags) -> list[Flags]:
    """True where a pixel is linked to the next row or column: phase and amplitude do not step."""
    known = np.where(inside, phase, np.nan)  # a step to or from NaN is no small one
    return [
        (abs(np.diff(known, axis=axis)) <= STEP)
        & (abs(np.diff(bright, axis=axis)) <= EDGE)
        for axis in (0, 1)
    ]


def relative_phase(measurement: Measurement) -> Array:
    """Spatially unwrapped phase (H, W), rad, of the lowest frequency, but for multiples of 2 pi."""
    from skimage.restoration import unwrap_phase

    mask = measurement.mask
    phase = np.where(mask, measurement.phase[0], 0.0)
    if 1 in mask.shape:  # scikit-image unwraps no lines
        phase[mask] = np.unwrap(phase[mask])
        return phase
    return np.ma.filled(unwrap_phase(np.ma.masked_array(phase, ~mask), rng=0), 0.0)


def components(down: Flags, across: Flags) -> Numbers:
    """Number of each pixel's connected component (H, W), from links to the next row and column."""
    shape = (across.shape[0], down.shape[1])
    index = np.arange(shape[0] * shape[1]).reshape(shape)
    rows = np.concatenate([index[:-1][down], index[:, :-1][across]])
    columns = np.concatenate([index[1:][down], index[:, 1:][across]])
    return groups(rows, columns, index.size).reshape(shape).astype(np.intp)


def groups(first: Numbers, second: Numbers, count: int) -> Numbers:
    """Number of the group (count,) of each of so many nodes, from links (L,) between two."""
    links = coo_array((np.ones(first.size, bool), (first, second)), (count, count))
    return connected_components(links, directed=False)[1]


def patches(phasors: Complex, number: Numbers) -> tuple[Complex, Numbers]:
    """Sums (P,) of phasors (H, W) in each grid square's part of a region, and that region (P,).

    A square is a twelfth of the image's longer side wide: what leaks into a region fills whole
    ones, and the scatter of these sums tells of it as well as of the noise.
    """
    row, column = np.indices(number.shape) // max(1, max(number.shape) // 12)
    place = number * number.size + row * number.shape[1] + column
    part, patch_of = np.unique(place, return_inverse=True)
    return sum_over(phasors, patch_of), part // number.size


def pool(phasors: Complex, number: Numbers) -> Pooled:
    """Phase of the summed phasors of each region, and its spread, from the parts across the sum."""
    size = np.bincount(number.ravel())
    total = sum_over(phasors, number)
    phase = np.angle(total)
    length = np.where(size > 1, abs(total), 0)  # one pixel has no spread
    across = np.imag(phasors * np.exp(-1j * phase[number]))
    # one direction was fitted, so that one degree of freedom is lost
    power = sum_over(across**2, number) * size / np.maximum(size - 1, 1)
    return Pooled(phase, quotient(np.sqrt(power), length, np.inf))


def whole_wraps(
    beat: Array, middle: Array, measurement: Measurement, fraction: Array | float = 0.0
) -> Array:
    """Offset (S,), m, of each region: the whole wraps plus ``fraction``, m, nearest to its beat.

    ``beat`` is the phase that is left after the shape, rad; ``middle`` is the mean depth of the
    shape, m, which comes into the range with the offset.
    """
    turned = _beat_phase(middle, measurement.frequencies)
    coarse = beat_depth(beat + turned, measurement) - middle
    length = wrap_length(measurement.frequencies[0])
    return fraction + length * np.rint((coarse - fraction) / length)


def sum_over(values: NDArray, number: Numbers) -> NDArray:
    """Sums (S,) of values (H, W) over each region of the map ``number`` (H, W)."""
    total = np.zeros(number.max() + 1, values.dtype)
    np.add.at(total, number, values)
    return total


def mean_over(values: NDArray, number: Numbers, counted: Flags) -> Array:
    """Means (S,) of the values (H, W) that are ``counted`` over each region; zero where none is."""
    size = sum_over(counted.astype(float), number)
    return sum_over(np.where(counted, values, 0), number) / np.maximum(size, 1)
