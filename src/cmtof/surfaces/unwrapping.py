"""Our method: surfaces in true geometry, grown, pooled and tied to each other.

1. `cmtof.surfaces.field`: each pixel's phasors, weighted so that likelihoods add up.
2. `cmtof.surfaces.seeds`: planes in windows, out of the joint peak of both spectra.
3. `cmtof.surfaces.growing`: each plane takes the cells that it explains, is fitted again, bends if
   it must, and moves by whole wraps if that is likelier.
4. `cmtof.surfaces.labels`: every pixel takes the likeliest surface beside it.
5. `cmtof.surfaces.offsets`: the whole wraps of each surface, by its beat and by its shape.
6. `cmtof.surfaces.ties`: surfaces that meet share what they know.
7. Here: what no surface explains takes the nearest one or its neighbourhood's beat.
8. `cmtof.surfaces.votes`: where single pixels are clear enough to tell, they vote instead.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines import Estimate, within_range
from cmtof.baselines.beat import beat_depth, box, synthetic_frequency
from cmtof.baselines.region import nearest
from cmtof.measurement import Measurement
from cmtof.surfaces.field import Field, field_from_measurement
from cmtof.surfaces.growing import grown_surfaces
from cmtof.surfaces.labels import depth_of_labels, interiors, pixel_labels
from cmtof.surfaces.offsets import Offsets, fitted, offsets
from cmtof.surfaces.ties import Borders, Tied, borders, tied
from cmtof.surfaces.votes import Votes, voted

REACH = 4
"""Pixels around a surface that are given to it where nothing explains them."""

WINDOW = 41
"""Side, px, of the square over which the beat is averaged further away."""

# What follows was counted once, on a view of each of 90 training rooms in both protocols.
CALIBRATION = (
    (0.0, 0.1, 0.25, 0.35, 0.5, 0.6, 0.75, 0.9, 0.99, 1.0),
    (0.08, 0.08, 0.14, 0.16, 0.4, 0.445, 0.67, 0.83, 0.905, 0.955),
)
"""Odds of an offset that the sums foretell, and the share that was right."""

FITTING = ((0.4, 0.6, 0.8, 0.95), (0.5, 0.69, 0.82, 1.0))
"""Share S / E about a pixel on a surface, and the factor on its odds."""

BESIDE = ((1.0, 2.0, REACH), (0.36, 0.2, 0.1))
"""Distance, px, of a pixel that no surface explains from one that it explains, and the factor."""

FAR = 0.02
"""Share of pixels far from any surface that was right."""


VOTING = ((0.0, 0.65, 0.95, 0.995, 1.0), (0.05, 0.33, 0.42, 0.55, 0.81))
"""Share that the winner of a vote has, and how often it was right: on twelve simulated scans of
things from the training rooms."""


class Stages(NamedTuple):
    """What each step found; images are (H, W), padded to whole cells."""

    field: Field
    owner: NDArray[np.int64]
    """Surface of each cell, -1 for none."""
    label: NDArray[np.int32]
    """Surface of each pixel, -1 for none."""
    share: NDArray[np.float32]
    """Share S / E that the likeliest surface about a pixel reaches around it."""
    surfaces: NDArray[np.float64]
    """Parameters (N, 6), before any offset is added."""
    offsets: Offsets
    borders: Borders
    tied: Tied
    votes: Votes
    depth: NDArray[np.float64]
    """Depth of all pixels, m."""
    odds: NDArray[np.float64]
    """That the wrap is right, before it is calibrated."""
    distance: NDArray[np.float64]
    """To the nearest pixel that a surface explains, px."""


def surfaces(
    measurement: Measurement, *, bent: bool = True, shape: bool = True, ties: bool = True,
    fill: bool = True,
) -> Estimate:  # fmt: skip
    """Unwrap by surfaces, each pooled over all of its pixels.

    Parameters
    ----------
    measurement : Measurement
        At two frequencies. With a camera a surface's shape tells its distance as well.
    bent : bool
        Let surfaces bend; otherwise all are planes.
    shape : bool
        Use what a surface's shape tells of its offset; otherwise only the beat does.
    ties : bool
        Tie surfaces that meet.
    fill : bool
        Give pixels far from any surface their neighbourhood's beat; otherwise the nearest surface.

    Raises
    ------
    ValueError
        If the frequencies are multiples of each other.
    """
    found = stages(measurement, bent=bent, shape=shape, ties=ties, fill=fill)
    height, width = measurement.shape
    odds = np.interp(found.odds, *CALIBRATION) * np.where(
        found.distance > 0,
        np.interp(found.distance, *BESIDE),
        np.interp(found.share, *FITTING),
    )
    odds = np.where(found.distance > REACH, FAR, odds)
    share = found.votes.share
    odds = np.where(share > 0, np.interp(share, *VOTING), odds)
    depth = within_range(found.depth[:height, :width], measurement)
    return Estimate(depth, np.where(measurement.mask, odds[:height, :width], 0))


def stages(
    measurement: Measurement, *, bent: bool = True, shape: bool = True, ties: bool = True,
    fill: bool = True,
) -> Stages:  # fmt: skip
    """Run the method and keep what each step found; see `surfaces`."""
    from scipy.ndimage import distance_transform_edt

    synthetic_frequency(*measurement.frequencies[:2])  # refuses multiples
    field = field_from_measurement(measurement)
    owner, surfaces = grown_surfaces(field, bent=bent)
    label, share = pixel_labels(field, owner, surfaces)
    inner = interiors(label, share)
    surfaces, fit = fitted(field, inner, surfaces, bent=bent)
    alone = offsets(
        field, inner, surfaces, fit, shape=shape and measurement.camera is not None
    )  # without a camera the shape is assumed
    touching = borders(field, label, surfaces)
    joined = tied(alone, touching if ties else touching.none())
    explained = label >= 0
    everywhere = label[nearest(explained)]
    depth = depth_of_labels(field, everywhere, surfaces)
    if len(surfaces):
        scored = np.zeros(label.shape, bool)
        scored[: measurement.shape[0], : measurement.shape[1]] = measurement.mask
        joined = _inside(joined, depth, np.where(scored, label, -1), field)
        depth = depth + field.period * joined.wraps[everywhere]
    odds = _odds(joined)[everywhere] if len(surfaces) else np.zeros(label.shape)
    distance = np.full(label.shape, np.inf)
    if explained.any():
        distance = np.asarray(distance_transform_edt(~explained))
    lost = ~np.isfinite(depth) | ((distance > REACH) & fill)
    if lost.any():
        depth = np.where(lost, beat_depth(_beat_phase(field, ~explained), measurement), depth)
    votes = voted(field, depth, explained)
    depth = np.where(votes.share > 0, votes.depth, depth)
    return Stages(
        field, owner, label, share, surfaces, alone, touching, joined, votes, depth, odds, distance
    )


def _inside(
    joined: Tied, depth: NDArray[np.float64], label: NDArray[np.integer], field: Field
) -> Tied:
    """Move groups by whole wraps until their scored pixels lie within the limits on average.

    First by the wraps after which the beat repeats, which it cannot tell apart.
    """
    known = label >= 0
    count = joined.wraps.size
    group = joined.group[label[known]]
    size = np.bincount(group, minlength=count)
    placed = depth[known] + field.period * joined.wraps[label[known]]
    mean = np.bincount(group, placed, count) / np.maximum(size, 1)
    low, high = field.limits
    repeat = 1 / abs(field.excess)  # wraps
    beats = np.ceil((low - mean) / (repeat * field.period)) * (size > 0)
    beats = np.where(mean + beats * repeat * field.period < high, beats, 0)
    mean = mean + beats * repeat * field.period
    lacking = joined.mean + (beats * repeat)[joined.group]
    again = np.where(beats[joined.group] != 0, np.rint(lacking), joined.wraps)
    joined = joined._replace(mean=lacking, wraps=again)
    up = np.ceil(np.maximum(low - mean, 0) / field.period)
    down = np.ceil(np.maximum(mean - high, 0) / field.period)
    extra = np.where(size > 0, up - down, 0)[joined.group]
    return joined._replace(wraps=joined.wraps + extra)


def _odds(joined: Tied) -> NDArray[np.float64]:
    """Probability (N,) that each group's offset, a Gaussian, was rounded to the right wrap."""
    from scipy.special import ndtr

    off = joined.mean - joined.wraps
    return ndtr((0.5 - off) / joined.spread) - ndtr((-0.5 - off) / joined.spread)


def _beat_phase(field: Field, among: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Phase (H, W), rad, of the beat averaged over a window, among those pixels only."""
    low = field.real[0] + 1j * field.imaginary[0]
    high = field.real[1] + 1j * field.imaginary[1]
    unit = low / np.maximum(np.abs(low), np.finfo(np.float32).tiny)
    mean = box(np.where(among, high * np.conj(unit) ** field.multiple, 0), WINDOW)
    return np.sign(field.excess) * np.angle(mean)
