"""Spatial unwrapping cut into regions, one pooled beat offset each.

One frequency unwrapped over the image tells the shape of each surface but for whole wraps; pooled
over a region the beat tells those. It fails where regions leak: a depth jump that is small modulo
one wrap leaves no mark in the phase, two surfaces share an offset, and one of them is wrong.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines import Estimate, within_range
from cmtof.baselines.beat import beat_depth, beat_phasor, synthetic_frequency
from cmtof.baselines.beat_guided import guides
from cmtof.baselines.spatial import unwrapped_phase
from cmtof.bounds import wrap_probability
from cmtof.correlation import depth_from_phase, phase_from_depth, wrap_length
from cmtof.measurement import Measurement

STEP = 1.0
"""Step of the unwrapped phase between neighbours that cuts, rad.

The better of 1 and 1.6 with `EDGE` out of 0.1, 0.2 and none, on 8 views of validation rooms.
"""

EDGE = 0.1
"""Step of the smoothed logarithm of amplitude between neighbours that cuts."""

COHERENCE = 0.1
"""Coherence of the local slope below which a pixel belongs to no region."""

SMALLEST = 100
"""Pixels below which a region takes the depth of a larger one beside it."""


class Pooled(NamedTuple):
    """Angles of summed phasors, each array one value a region (..., S)."""

    phase: NDArray[np.floating]
    """Angle of the sum, rad."""
    spread: NDArray[np.floating]
    """Standard deviation of that angle, rad; infinite for a single pixel."""


def region(
    measurement: Measurement,
    *,
    step: float = STEP,
    edge: float = EDGE,
    coherence: float = COHERENCE,
    smallest: int = SMALLEST,
) -> Estimate:
    """Place each region of the spatially unwrapped phase by its pooled beat.

    The low frequency's phase is unwrapped by reliability (Herraez et al. 2002); neighbours belong
    together unless phase or amplitude steps between them. The beat's phasors, demodulated by the
    relative depth, are added up over each region; their angle tells its whole wraps.

    Parameters
    ----------
    measurement : Measurement
        At two frequencies.
    step : float
        Step of the unwrapped phase that cuts, rad.
    edge : float
        Step of the logarithm of amplitude, smoothed over 5 px, that cuts.
    coherence : float
        Least coherence of the local slope, 0 to 1 (see `cmtof.baselines.beat_guided.guides`).
    smallest : int
        Smaller regions, px, take the depth of the nearest pixel of a larger one, if there is any.

    Raises
    ------
    ValueError
        If the frequencies are multiples of each other.
    """
    synthetic = synthetic_frequency(*measurement.frequencies[:2])
    mask, middle = measurement.mask, sum(measurement.range) / 2
    if not mask.any():
        return Estimate(np.full(mask.shape, middle), np.zeros(mask.shape))
    phase = relative_phase(measurement)
    bright, coherent = guides(measurement)[:2]
    inside = mask & (coherent >= coherence)
    number = linked(inside, phase, bright, step=step, edge=edge)
    shape = depth_from_phase(phase, measurement.frequencies[0])
    beat = beat_phasor(measurement) * np.exp(-1j * phase_from_depth(shape, synthetic.frequency))
    pooled = pool(np.where(mask, beat, 0), number)
    offset = whole_wraps(pooled.phase, mean_over(shape, number, mask), measurement)
    low, high = (float(f) for f in measurement.frequencies[:2])
    odds = np.asarray(wrap_probability(0, pooled.spread, frequencies=(low, high)))
    near = nearest(inside & (np.bincount(number.ravel())[number] >= smallest))
    depth, confidence = (shape + offset[number])[near], odds[number][near]
    return Estimate(within_range(depth, measurement), np.where(mask, confidence, 0))


def relative_phase(measurement: Measurement) -> NDArray[np.floating]:
    """Phase (H, W) of the lowest frequency, unwrapped up to 2 pi m, rad; a line as well."""
    if 1 not in measurement.shape:
        return unwrapped_phase(measurement)
    line, phase = measurement.mask.ravel(), np.zeros(measurement.mask.size)
    phase[line] = np.unwrap(measurement.phase[0].ravel()[line].astype(float))
    return phase.reshape(measurement.shape)


def linked(
    inside: NDArray[np.bool_],
    phase: NDArray[np.floating],
    bright: NDArray[np.floating],
    *,
    step: float,
    edge: float,
) -> NDArray[np.intp]:
    """Number of each pixel's region (H, W); pixels outside are regions of their own."""
    links = []
    for axis in (0, 1):
        gentle = (abs(np.diff(phase, axis=axis)) <= step) & (
            abs(np.diff(bright, axis=axis)) <= edge
        )
        first, second = (np.delete(inside, at, axis) for at in (-1, 0))
        links.append(gentle & first & second)
    return components(*links)


def components(down: NDArray[np.bool_], across: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Number of each pixel's component (H, W) from links to the next row and the next column.

    Examples
    --------
    >>> components(np.ones((1, 3), bool), np.array([[True, False], [True, False]]))
    array([[0, 0, 1],
           [0, 0, 1]])
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    shape = (across.shape[0], down.shape[1])
    index = np.arange(shape[0] * shape[1]).reshape(shape)
    rows = np.concatenate([index[:-1][down], index[:, :-1][across]])
    columns = np.concatenate([index[1:][down], index[:, 1:][across]])
    graph = coo_array((np.ones(rows.size, bool), (rows, columns)), shape=(index.size, index.size))
    return connected_components(graph, directed=False)[1].reshape(shape).astype(np.intp)


def pool(phasors: NDArray[np.complexfloating], number: NDArray[np.intp]) -> Pooled:
    """Sum demodulated phasors (H, W) over each region; their noise is what lies across the sum."""
    size = np.bincount(number.ravel())
    total = sum_over(phasors.real, number) + 1j * sum_over(phasors.imag, number)
    phase, length = np.angle(total), np.abs(total)
    across = np.imag(phasors * np.exp(-1j * phase[number]))
    known = (size > 1) & (length > 0)
    # one direction was fitted, so a pixel less tells of the noise
    power = sum_over(across**2, number) * size / np.maximum(size - 1, 1)
    return Pooled(phase, np.where(known, np.sqrt(power) / np.where(known, length, 1), np.inf))


def whole_wraps(
    beat: NDArray[np.floating],
    middle: NDArray[np.floating],
    measurement: Measurement,
    fraction: NDArray[np.floating] | float = 0.0,
) -> NDArray[np.floating]:
    """Offset of each region, m: whole wraps and a fraction, nearest to what the beat says.

    Parameters
    ----------
    beat : ndarray, shape (S,)
        Phase of the demodulated beat, rad.
    middle : ndarray, shape (S,)
        Mean relative depth of the region, m; with its offset it lies in the measurement's range.
    measurement : Measurement
    fraction : ndarray, shape (S,)
        Part of the offset that is known, m, modulo one wrap.
    """
    low, high = measurement.frequencies[:2]
    turned = phase_from_depth(middle, synthetic_frequency(low, high).frequency)
    coarse = beat_depth(beat + turned, measurement) - middle
    length = wrap_length(low)
    return fraction + length * np.rint((coarse - fraction) / length)


def sum_over(values: NDArray, number: NDArray[np.intp]) -> NDArray:
    """Sum of real values (H, W) over each region (S,)."""
    return np.bincount(number.ravel(), values.ravel())


def mean_over(
    values: NDArray, number: NDArray[np.intp], counted: NDArray[np.bool_]
) -> NDArray[np.floating]:
    """Mean of the counted values (H, W) over each region (S,); zero where none counts."""
    size = sum_over(counted.astype(float), number)
    return sum_over(np.where(counted, values, 0), number) / np.maximum(size, 1)


def nearest(wanted: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Row and column (H, W) of the wanted pixel nearest to each; its own if none is wanted."""
    from scipy.ndimage import distance_transform_edt

    if not wanted.any():
        own = np.indices(wanted.shape)
        return own[0], own[1]
    found = np.empty((2, *wanted.shape), np.int32)
    distance_transform_edt(~wanted, return_distances=False, return_indices=True, indices=found)
    return found[0].astype(np.intp), found[1].astype(np.intp)
