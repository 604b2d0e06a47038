"""Unwrapping by surfaces in true geometry, each pooled over all of its pixels.

1. `cmtof.surfaces.field`: the phasors of each pixel, weighted so that likelihoods add up.
2. `cmtof.surfaces.growing`: planes start in windows, grow over cells that fit, and may curve.
   `cmtof.surfaces.parts`: parts that do not belong together become surfaces of their own.
3. `cmtof.surfaces.placing`: pixels take surfaces, whose beat (`cmtof.surfaces.beats`) and shape
   give their wraps. `cmtof.surfaces.contacts`: surfaces that meet agree on them.
   `cmtof.surfaces.roughness`: how far pixels depart from their surface.
4. Here: other pixels take the nearest one, or the beat about them if there is none.
   `cmtof.surfaces.votes`: clear ones take the vote of their neighbours.
"""

from collections.abc import Callable, Collection
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_edt, median

from cmtof.classical.beat import beat, synthetic_frequency
from cmtof.estimate import Components, Estimate, within_range
from cmtof.measurement import Measurement
from cmtof.surfaces import contacts, placing
from cmtof.surfaces.beats import information_of_beats, pooled_beats
from cmtof.surfaces.field import Field, field_from_measurement, pixels_of_cells
from cmtof.surfaces.fitting import EFFORT, fit_surfaces
from cmtof.surfaces.growing import GAIN, ROUGHEST, grown_surfaces
from cmtof.surfaces.parts import cut_surfaces
from cmtof.surfaces.roughness import Cells, cells_of_surfaces, departure, turn_back
from cmtof.surfaces.shapes import depth_of_labels
from cmtof.surfaces.votes import CLEAR, depth_by_votes, slopes_of_surfaces
from cmtof.types import Array, Numbers

# Steps that may be left out
STEPS = ("bent", "parts", "shape", "closure", "axes", "ties")

# Confidences, calibrated on views of training rooms, and of votes on scans of things from these.
# odds of an offset, and the share right
CALIBRATION = ((0.0, 0.9, 1.0), (0.0, 0.87, 0.965))
# S / E about a pixel, and a factor
FITTING = ((0.4, 0.6, 0.8, 0.95), (0.5, 0.69, 0.82, 1.0))
# px off the nearest surface, and a factor
BESIDE = ((1.0, 2.0, 4.0, 4.1), (0.36, 0.2, 0.1, 0.03))
NARROW = 0.5  # share of the doubt that goes with fewer than 100 wraps to choose from
# share of the winner of a vote, and how often it was right
VOTING = ((0.0, 0.65, 0.95, 0.995, 1.0), (0.05, 0.33, 0.42, 0.55, 0.81))


# Log-odds of offsets, from depth (H, W) and surface (H, W) before any, and offsets (N, M).
OddsOfOffsets = Callable[[Array, Numbers, Numbers], Array]


class Stages(NamedTuple):
    """Result of each step; images are (H, W), padded to whole cells."""

    field: Field
    owner: Numbers  # surface of each cell, -1 for none
    label: Numbers  # surface of each pixel, -1 for none
    surfaces: Array  # parameters and roughness (N, 7) before any offset is added
    offsets: placing.Offsets
    borders: contacts.Borders
    placement: contacts.Placement
    depth: Array  # of all pixels, m
    confidence: Array
    components: Components  # of the image without its padding


def surfaces(
    measurement: Measurement,
    *,
    without: Collection[str] = (),
    prior: OddsOfOffsets | None = None,
) -> Estimate:
    """Depths by surfaces in true geometry, each pooled over all of its pixels.

    Steps named in ``without`` are left out, and ``prior`` says more of offsets, as in `stages`.
    """
    if not set(without) <= set(STEPS):
        raise ValueError(
            f"Expected steps out of {STEPS} to leave out, got {without}. Correct it."
        )
    found = stages(measurement, without, prior)
    height, width = measurement.shape
    depth = within_range(found.depth[:height, :width], measurement)
    sure = np.where(measurement.mask, found.confidence[:height, :width], 0)
    return Estimate(depth, sure, found.components)


def stages(
    measurement: Measurement,
    without: Collection[str] = (),
    prior: OddsOfOffsets | None = None,
) -> Stages:
    """Results of all steps, for two frequencies of which none is a multiple of the other.

    Steps that may be left out: ``bent`` surfaces beside planes; ``parts``, cut where the beat
    steps; with a camera, offsets by the ``shape``, one of all beats by it (``closure``), and by the
    ``axes`` of the room; ``ties`` of surfaces that meet. ``prior`` returns log-odds of offsets
    (N, M), wraps, from the depth (H, W), m, and the surface (H, W) of pixels before any offset.
    """
    synthetic_frequency(*measurement.frequencies)  # refuses multiples
    field = field_from_measurement(measurement)
    if measurement.camera is None:
        without = {"shape", *without}
    grown = _grow_and_cut(field, without, measurement.camera is not None)
    depth = depth_of_labels(field, grown.near, grown.surfaces)
    cells = cells_of_surfaces(field, grown.inner, grown.surfaces, field.side)
    alone = _own_offsets(field, cells, grown, without)
    touching = contacts.borders(field, grown.label, grown.surfaces)
    touching = touching._replace(odds=touching.odds * ("ties" not in without))
    inside = np.s_[: measurement.shape[0], : measurement.shape[1]]
    masked = np.where(measurement.mask, grown.label[inside], -1)
    joined = contacts.offsets_with_contacts(
        alone,
        touching,
        _limits(field, depth[inside], masked, len(grown.surfaces)),
        repeat=1 / abs(field.excess),
        prior=prior and partial(prior, depth[inside], masked),
    ).calibrate(CALIBRATION)
    # where there is no surface, the number -1 stands for the last entry
    depth += field.period * np.append(joined.wraps, 0)[grown.near]
    slopes = slopes_of_surfaces(depth / field.period, grown.near)
    depth = _add_departures(field, depth, np.append(cells.rough, 0)[grown.label])
    lost = ~np.isfinite(depth[inside])
    np.copyto(depth[inside], beat(measurement).depth, where=lost)
    depth, votes = depth_by_votes(field, depth, slopes, grown.label >= 0, alone.closure)
    masked[votes[inside] > 0] = -1
    return Stages(
        field,
        grown.owner,
        grown.label,
        grown.surfaces,
        alone,
        touching,
        joined,
        depth,
        _confidence(field, np.append(joined.odds, 1)[grown.near], grown, votes),
        contacts.components(joined, masked),
    )


class GrownSurfaces(NamedTuple):
    """Surfaces before any offset is added, and the pixels that lie on them."""

    owner: Numbers  # surface of each cell, -1 for none
    label: Numbers  # surface of each pixel (H, W), -1 for none
    share: Array  # S / E about each pixel (H, W)
    inner: Numbers  # labels without the borders of surfaces
    surfaces: Array  # parameters and roughness (N, 7)
    fit: Array  # as `fit_surfaces` has it (N, 16)
    distance: Array  # of each pixel from the nearest that lies on a surface (H, W), px
    near: Numbers  # surface of that pixel


def _grow_and_cut(field: Field, without: Collection[str], known: bool) -> GrownSurfaces:
    """Surfaces grown and cut into parts; none is rough unless the camera is ``known``."""
    gain = np.inf if "bent" in without else GAIN
    # without a camera what a shape lacks would look like roughness
    owner, surfaces = grown_surfaces(field, gain=gain, roughest=ROUGHEST * known)
    label, share, inner = placing.pixel_labels(field, owner, surfaces)
    if "parts" not in without:
        parts, cut = cut_surfaces(field, inner, surfaces, gain)
        if len(cut) > len(surfaces):
            owner, surfaces = _fit_again(field, owner, parts, cut, gain)
            label, share, inner = placing.pixel_labels(field, owner, surfaces)
    surfaces, fit = fit_surfaces(field, inner, surfaces, EFFORT, gain)
    off = label < 0
    distance, near = distance_transform_edt(off, return_indices=True)  # pyright: ignore[reportGeneralTypeIssues]
    distance = np.where(off.all(), np.inf, distance)
    near = label[tuple(near)]
    return GrownSurfaces(owner, label, share, inner, surfaces, fit, distance, near)


def _fit_again(
    field: Field, owner: Numbers, parts: Numbers, surfaces: Array, gain: float
) -> tuple[Numbers, Array]:
    """Owner of each cell after cuts, and surfaces (N, 7), those of each cut fitted again."""
    parts = np.where(parts <= owner.max(), owner, parts)
    changed = parts != owner
    both = np.isin(parts, [owner[changed], parts[changed]])
    cells = pixels_of_cells(np.where(both, parts, -1))
    surfaces, _ = fit_surfaces(field, cells, surfaces, EFFORT, gain)
    return parts, surfaces


def _own_offsets(
    field: Field, cells: Cells, grown: GrownSurfaces, without: Collection[str]
) -> placing.Offsets:
    """Offsets of surfaces by their own beat and shape, and by the axes of a room."""
    shape = "shape" not in without
    found = placing.offsets(
        pooled_beats(field, cells),
        grown.surfaces,
        grown.fit,
        shape=shape,
        closed="closure" in without,
    )
    if shape and "axes" not in without and len(grown.surfaces):
        found = placing.use_axes(found, grown.surfaces, grown.fit, grown.label)
    return found


def _confidence(field: Field, odds: Array, grown: GrownSurfaces, votes: Array) -> Array:
    """Confidence of all pixels, by the odds of their surface or by the vote they won."""
    near = np.interp(grown.distance, *BESIDE)
    odds *= np.where(grown.label >= 0, np.interp(grown.share, *FITTING), near)
    narrow = np.ptp(field.limits) < 100 * field.period
    odds += NARROW * odds * (1 - odds) * narrow
    return np.where(votes > 0, np.interp(votes, *VOTING), odds)


def _add_departures(field: Field, depth: Array, rough: Array) -> Array:
    """Depth (H, W), m, plus departures of pixels from rough surfaces, except of clear pixels."""
    clear = information_of_beats(field, field.information) > CLEAR
    variance = np.where(clear, 0, rough)
    if not variance.any():
        return depth
    phase = departure(field, turn_back(field, depth), variance)
    return depth + phase / field.wavenumber[0]


def _limits(field: Field, depth: Array, label: Numbers, count: int) -> Array:
    """Least and largest offset (2, N), wraps, that keep each surface's median depth in range."""
    known = label >= 0
    limits = np.full((2, count), np.inf) * [[-1], [1]]
    there = np.unique(label[known])
    if there.size:
        middle = median(depth[known], label[known], there)
        limits[:, there] = (np.array(field.limits)[:, None] - middle) / field.period
    return limits
