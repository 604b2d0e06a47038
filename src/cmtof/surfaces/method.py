"""Unwrapping by surfaces in true geometry, each pooled over all of its pixels.

1. `cmtof.surfaces.field`: the phasors of each pixel, weighted so that likelihoods add up.
2. `cmtof.surfaces.windows`, `growing`: planes begin in windows, take the cells that they explain,
   and bend.
3. `cmtof.surfaces.labels`, `beats`, `offsets`, `ties`: pixels take surfaces; beat, shape and what
   meets give their wraps.
4. Here and in `cmtof.surfaces.votes`: other pixels take the nearest one, the beat about them, or
   the vote of neighbours.
"""

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_edt, median
from scipy.special import ndtr

from cmtof.classical.beat import beat, synthetic_frequency
from cmtof.classical.region import nearest
from cmtof.estimate import Estimate, within_range
from cmtof.measurement import Measurement
from cmtof.surfaces.beats import cells_of_surfaces, cut_where_beats_step, uneven_phase
from cmtof.surfaces.field import CELL, Array, Field, Labels, Mask, field_from_measurement
from cmtof.surfaces.growing import GAIN, Surfaces, fitted, grown_surfaces
from cmtof.surfaces.labels import depth_of_labels, interiors, pixel_labels
from cmtof.surfaces.offsets import Offsets, aligned, offsets, unevenness
from cmtof.surfaces.ties import Borders, Ties, borders, tied
from cmtof.surfaces.votes import DOUBT, doubt_of_beats, voted

REACH = 4  # pixels around a surface that are given to it where nothing explains them

# Confidences, calibrated on views of training rooms, and of votes on scans of things from these.
CALIBRATION = (  # odds of an offset by its Gaussian, and the share that was right
    (0.0, 0.1, 0.25, 0.35, 0.5, 0.6, 0.75, 0.9, 0.99, 1.0),
    (0.08, 0.08, 0.14, 0.16, 0.4, 0.445, 0.67, 0.83, 0.905, 0.955),
)
FITTING = ((0.4, 0.6, 0.8, 0.95), (0.5, 0.69, 0.82, 1.0))  # share of S about a pixel, and a factor
# px off the nearest surface, and a factor; farther off the beat counts, hardly ever right
BESIDE = ((1.0, 2.0, REACH, REACH + 0.1), (0.36, 0.2, 0.1, 0.03))
NARROW = 0.5  # share of the doubt that goes with fewer than 100 wraps to choose from
# share of the winner of a vote, and how often it was right
VOTING = ((0.0, 0.65, 0.95, 0.995, 1.0), (0.05, 0.33, 0.42, 0.55, 0.81))

_EVEN = 0.02  # roughness of a surface, rad^2, that leaks alone give it


class Stages(NamedTuple):
    """Result of each step; images are (H, W), padded to whole cells."""

    field: Field
    owner: Labels  # surface of each cell, -1 for none
    label: Labels  # surface of each pixel, -1 for none
    surfaces: Array  # parameters (N, 6) before any offset is added
    offsets: Offsets
    borders: Borders
    tied: Ties
    depth: Array  # of all pixels, m
    confidence: Array
    component: Labels  # pixels that share one offset, from 1 on; 0 for those of none


class _Shapes(NamedTuple):
    """Surfaces and the pixels (H, W) that lie on them."""

    owner: Labels
    label: Labels
    share: Array  # of the S expected about each pixel
    inner: Labels  # the labels without borders
    surfaces: Surfaces


def surfaces(measurement: Measurement, *, without: Collection[str] = ()) -> Estimate:
    """Depths by surfaces in true geometry, each pooled over all of its pixels.

    Steps named in ``without`` are left out, as in `stages`.
    """
    found = stages(measurement, without)
    inside = tuple(slice(0, n) for n in measurement.shape)
    depth = within_range(found.depth[inside], measurement)
    confidence = np.where(measurement.mask, found.confidence[inside], 0)
    return Estimate(depth, confidence, found.component[inside], _doubts(found))


def _doubts(found: Stages) -> Array:
    """Probability that the offset of each component is wrong: of its surest surface."""
    groups = np.unique(found.tied.group)
    sure = np.interp(_odds(found.tied), *CALIBRATION)
    return 1 - np.array([sure[found.tied.group == one].max() for one in groups])


def stages(measurement: Measurement, without: Collection[str] = ()) -> Stages:
    """Results of all steps, for two frequencies of which none is a multiple of the other.

    Steps that may be left out: ``bent`` surfaces beside planes; ``parts``, cut where the beat
    steps; with a camera, offsets by the ``shape``, one of all beats by it (``closure``), and by the
    ``axes`` of the room; ``ties`` of surfaces that meet; the ``fill`` of far pixels by their beat.
    """
    synthetic_frequency(*measurement.frequencies[:2])  # refuses multiples
    field = field_from_measurement(measurement)
    shapes = _shapes(field, without)
    # without a camera one is assumed, and shapes tell nothing
    assumed = {"shape"} if measurement.camera is None else set()
    alone = _offsets(field, shapes, assumed.union(without))
    touching = borders(field, shapes.label, shapes.surfaces.parameters)
    joined = tied(alone, touching._replace(odds=touching.odds * ("ties" not in without)))
    joined, depth = _placed(field, shapes, joined, measurement)
    explained = shapes.label >= 0
    distance = np.where(explained.any(), distance_transform_edt(~explained), np.inf)
    depth = _filled(depth, (distance > REACH) & ("fill" not in without), measurement)
    elected, votes = voted(field, depth, explained, alone.closure)
    depth = np.where(votes > 0, elected, depth)
    sure = _confidence(field, joined, shapes, distance, votes)
    component = np.where(votes > 0, 0, _components(joined, shapes.label))
    found = shapes.owner, shapes.label, shapes.surfaces.parameters
    return Stages(field, *found, alone, touching, joined, depth, sure, component)


def _components(joined: Ties, label: Labels) -> Labels:
    """Number (H, W) of the group to which the surface of each pixel is tied, from 1 on."""
    number = 1 + np.unique(joined.group, return_inverse=True)[1]
    return np.append(number, 0)[label]


def _placed(
    field: Field, shapes: _Shapes, joined: Ties, measurement: Measurement
) -> tuple[Ties, Array]:
    """Ties within the limits, and depth (H, W), m, of every pixel on its nearest surface."""
    everywhere = shapes.label[nearest(shapes.label >= 0)]
    depth = depth_of_labels(field, everywhere, shapes.surfaces.parameters)
    if not joined.wraps.size:
        return joined, depth
    inside = tuple(slice(0, n) for n in measurement.shape)
    masked = np.where(measurement.mask, shapes.label[inside], -1)
    joined = _inside(joined, depth[inside], masked, field)
    # clear pixels that depart from their surface vote instead
    variance = np.where(doubt_of_beats(field) < DOUBT, 0, _variance(shapes))
    departure = uneven_phase(field, depth, variance) / field.wavenumber[0]
    return joined, depth + field.period * joined.wraps[everywhere] + departure


def _filled(depth: Array, far: Mask, measurement: Measurement) -> Array:
    """The depth with that of the beat far off all surfaces, and where there is none."""
    lost = ~np.isfinite(depth) | far
    if not lost.any():
        return depth
    inside = tuple(slice(0, n) for n in measurement.shape)
    out = depth.copy()
    out[inside] = np.where(lost[inside], beat(measurement).depth, depth[inside])
    return out


def _variance(shapes: _Shapes) -> Array:
    """Variance (H, W), rad^2, of each pixel about its surface, beyond that of even ones."""
    return np.append(np.maximum(shapes.surfaces.roughness - _EVEN, 0), 0.0)[shapes.label]


def _shapes(field: Field, without: Collection[str]) -> _Shapes:
    """Surfaces grown, cut where their beat steps, and fitted to the pixels inside of them."""
    gain = np.inf if "bent" in without else GAIN
    owner, grown = grown_surfaces(field, gain=gain)
    label, share = pixel_labels(field, owner, grown)
    inner = interiors(label, share)
    cells = cells_of_surfaces(field, inner, grown)
    main, cut = cut_where_beats_step(field, cells, grown.parameters)
    if "parts" not in without and len(cut) > len(grown.parameters):
        old = owner
        owner = np.where(main < len(grown.parameters), owner, main)
        both = np.isin(owner, [old[owner != old], owner[owner != old]])  # of what was cut
        whole = np.kron(np.where(both, owner, -1), np.ones((CELL, CELL), int))
        grown = fitted(field, whole, cut, gain)
        label, share = pixel_labels(field, owner, grown)
        inner = interiors(label, share)
    final = fitted(field, inner, grown.parameters, gain)
    return _Shapes(owner, label, share, inner, final)


def _offsets(field: Field, shapes: _Shapes, without: Collection[str]) -> Offsets:
    """Offset of each surface by itself."""
    found = shapes.surfaces
    cells = cells_of_surfaces(field, shapes.inner, found)
    uneven = unevenness(field, cells, len(found.offset))
    shape = "shape" not in without
    alone = offsets(field, cells, found, uneven, shape=shape, closed="closure" in without)
    if shape and "axes" not in without and len(found.offset):
        alone = aligned(alone, found, uneven, shapes.label)
    return alone


def _inside(joined: Ties, depth: Array, label: Labels, field: Field) -> Ties:
    """Move groups by whole beats, then by wraps, until their median lies within the limits."""
    known = label >= 0
    if not known.any():  # all surfaces lie outside the mask
        return joined
    group = joined.group[label[known]]
    every = np.arange(joined.wraps.size)
    middle = median(depth[known] / field.period + joined.wraps[label[known]], group, every)
    low, high = np.array(field.limits) / field.period
    middle = np.where(np.isin(every, group), middle, low)
    repeat = 1 / abs(field.excess)  # wraps
    beats = np.ceil((low - middle) / repeat)
    beats = np.where(middle + beats * repeat < high, beats, 0)
    middle = middle + beats * repeat
    lacking = joined.mean + (beats * repeat)[joined.group]
    wraps = np.where(beats[joined.group] != 0, np.rint(lacking), joined.wraps)
    extra = np.ceil(np.maximum(low - middle, 0)) - np.ceil(np.maximum(middle - high, 0))
    return joined._replace(mean=lacking, wraps=wraps + extra[joined.group])


def _odds(joined: Ties) -> Array:
    """Probability (N,) that the offset of a group, a Gaussian, was rounded to the right wrap."""
    off = joined.mean - joined.wraps
    return ndtr((0.5 - off) / joined.spread) - ndtr((-0.5 - off) / joined.spread)


def _confidence(
    field: Field, joined: Ties, shapes: _Shapes, distance: Array, votes: Array
) -> Array:
    """Calibrated probability (H, W) that the wrap of each pixel is right."""
    everywhere = shapes.label[nearest(shapes.label >= 0)]
    odds = np.append(_odds(joined), 0.0)[everywhere]
    beside = np.interp(distance, *BESIDE)
    fits = np.where(distance == 0, np.interp(shapes.share, *FITTING), beside)
    odds = np.interp(odds, *CALIBRATION) * fits
    odds += NARROW * odds * (1 - odds) * (np.ptp(field.limits) < 100 * field.period)
    return np.where(votes > 0, np.interp(votes, *VOTING), odds)
