"""Whole wraps of each surface by itself: by its beat, by its shape, and by the axes of the room.

A plane that is moved along the rays is bent, the more so the wider it is. How far this is trusted
follows from how uneven surfaces are where their phase is known already: a wall that departs from a
plane by hundredths of a wrap over a few pixels is no plane on the whole either.
"""

from typing import NamedTuple

import numpy as np

from cmtof.correlation import TAU
from cmtof.surfaces.beats import Cells, common_phase, pooled_beats
from cmtof.surfaces.field import Array, Field, Labels
from cmtof.surfaces.growing import Surfaces

_OPEN, _CLOSING = 2.5, 20  # deviations above which a common offset of beats counts; iterations
_SMOOTH = 1e-5  # departure from a plane, m (rms), allowed for where none can be seen
_FLOOR = (0.05, 0.15)  # least uncertainty, wraps, of an offset by the shape and by the beat
_BENT = 1.5  # wraps of uncertainty of a beat per share of coherence that its surface lacks

_SCALES = (1, 2, 4, 8)  # sides, cells, of the blocks over which unevenness is looked for
_CLEARLY = 30.0  # information of a block that counts
_BLOCKS = 12  # of a surface for it to show its own unevenness
_BOWED = 1.0  # departure of a whole surface from its shape, per unevenness of its blocks

_PLUMB, _UPRIGHT = 5e-4, 5.0  # deviation, rad, of what is upright; least likelihood, 1 / rad
_ASKEW = 20.0  # deviation from upright per m of unevenness, rad
_CLEAR, _SHARP = 1e-2, 1.5e-3  # uncertainty, rad, of normals that vote, and of those elected
_FARTHEST = 10.0  # offset, wraps, up to which a plane turns in proportion


class Offsets(NamedTuple):
    """Offset of each surface (N,), wraps to add, and its standard deviation."""

    mean: Array
    spread: Array
    closure: float = 0.0  # common offset of all beats, wraps, that was subtracted


class Unevenness(NamedTuple):
    """How far surfaces (N,) depart from their shape between the scales of a cell and their own."""

    inflation: Array  # variance of what is fitted, over that by the noise alone
    scale: Array  # m (rms)


def unevenness(field: Field, cells: Cells, count: int) -> Unevenness:
    """Unevenness of each surface by the residuals of blocks of cells, beyond their noise.

    Surfaces of few blocks have the median unevenness of the others, weighted by their blocks.
    """
    inflation = np.ones(count)
    variance = np.zeros(count)
    blocks = np.zeros(count)
    for scale in _SCALES:
        number, chi, noise = _blocks(cells, field.multiple, scale, count)
        enough = number >= _BLOCKS
        blocks = np.maximum(blocks, number * enough)
        # a third parameter of a plane is known by each block
        ratio = chi / np.maximum(number - 3, 1)
        inflation = np.where(enough, np.maximum(inflation, ratio), inflation)
        excess = np.maximum(ratio - 1 - np.sqrt(2 / np.maximum(number, 1)), 0) * noise
        variance = np.where(enough, np.maximum(variance, excess), variance)
    usual = [_weighted_median(one, blocks) for one in (inflation, variance)]
    inflation = np.where(blocks > 0, inflation, max(usual[0], 1.0))
    variance = np.where(blocks > 0, variance, usual[1])
    return Unevenness(inflation, np.sqrt(variance) / field.wavenumber[0])


def _blocks(cells: Cells, multiple: int, scale: int, count: int) -> tuple[Array, Array, Array]:
    """Number of blocks (N,) of each surface, their summed chi^2, and their mean noise, rad^2."""
    block, of = _number_blocks(cells.owner, scale)
    both = np.array([1, multiple])[:, None, None]
    phasors = _sum_blocks(cells.phasors * np.exp(1j * both * cells.residual), block)
    told = _sum_blocks(cells.information, block).real
    weight = told[0] + multiple**2 * told[1]
    square = weight * common_phase(phasors, multiple) ** 2
    clear = told.sum(axis=0) > _CLEARLY
    whole = np.bincount(of[clear], minlength=count)
    chi = np.bincount(of[clear], square[clear], count)
    return whole, chi, whole / np.maximum(np.bincount(of[clear], weight[clear], count), 1e-9)


def _number_blocks(owner: Labels, scale: int) -> tuple[Labels, Labels]:
    """Number (h, w) of the block of each cell, -1 for none, and the surface (B,) of each block."""
    rows, columns = np.indices(owner.shape) // scale
    key = (owner * (rows.max() + 1) + rows) * (columns.max() + 1) + columns
    known = owner >= 0
    _, first, number = np.unique(key[known], return_index=True, return_inverse=True)
    block = np.full(owner.shape, -1)
    block[known] = number
    return block, owner[known][first]


def _sum_blocks(images: Array, block: Labels) -> Array:
    """Sums (2, B) of images (2, h, w) over blocks."""
    known = block >= 0
    count = int(block.max(initial=-1)) + 1
    out = np.zeros((2, count), complex)
    for one in range(2):
        out[one].real = np.bincount(block[known], images[one][known].real, count)
        out[one].imag = np.bincount(block[known], images[one][known].imag, count)
    return out


def _weighted_median(values: Array, weights: Array) -> float:
    """Smallest value up to which half of the weights lie; zero without any."""
    if not weights.any():
        return 0.0
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, total[-1] / 2)])


def offsets(
    field: Field,
    cells: Cells,
    surfaces: Surfaces,
    uneven: Unevenness,
    *,
    shape: bool = True,
    closed: bool = False,
) -> Offsets:
    """Offset of each surface, from its shape as far as it keeps it, and from its beat.

    An offset between the frequencies moves all beats and no shape. It is the mean excess of beats
    over shapes of planes, with Student's weights, and zero if ``closed`` or not significant.
    """
    beats = pooled_beats(field, cells, len(surfaces.offset))
    doubt = _FLOOR[1] + _BENT * (1 - np.clip(beats.coherence, 0.05, 1))
    by_beat = 1 / (beats.noise**2 + doubt**2)
    by_shape = _precision_of_shapes(surfaces, uneven) if shape else np.zeros_like(by_beat)
    off = 0.0
    if not closed:
        flat = ~surfaces.parameters[:, 3:].any(axis=1)  # what is bent may have been bent by a wrap
        both = flat * by_beat * by_shape / (by_beat + by_shape)
        off = _closure(beats.offset - surfaces.offset, both)
    mean = surfaces.offset * by_shape + (beats.offset - off) * by_beat
    return Offsets(mean / (by_shape + by_beat), 1 / np.sqrt(by_shape + by_beat), off)


def _precision_of_shapes(surfaces: Surfaces, uneven: Unevenness) -> Array:
    """Inverse variance (N,) of offsets by the shape; zero where nothing was fitted."""
    known = np.maximum(surfaces.known, 1e-12)
    bend = np.maximum(surfaces.bend, 1e-12)
    missed = np.maximum(surfaces.missed, _SMOOTH)
    departure = missed**2 + (_BOWED * uneven.scale) ** 2
    variance = uneven.inflation / known + departure / bend**2 + _FLOOR[0] ** 2
    return np.where(surfaces.known > 0, 1 / variance, 0)


def _closure(excess: Array, precision: Array) -> float:
    """Common offset of all beats, wraps, by their excess over shapes; zero if not significant."""
    off = 0.0
    weight = precision
    for _ in range(_CLOSING):
        weight = precision / (1 + precision * (excess - off) ** 2 / 2)
        off = float(weight @ excess / max(weight.sum(), 1e-12))
    return 0.0 if abs(off) < _OPEN / np.sqrt(weight.sum() + 1e-12) else off


class _Normals(NamedTuple):
    """Unit normals of surfaces as functions of their offset m, wraps: at + m turn."""

    at: Array  # (N, 3)
    turn: Array  # (N, 3)
    noise: Array  # covariance (N, 3, 3)
    plumb: Array  # deviation (N,), rad, of what should be upright
    plane: Array  # which (N,) are planes


def aligned(found: Offsets, surfaces: Surfaces, uneven: Unevenness, label: Labels) -> Offsets:
    """Offsets of planes, made sharper where these stand upright to the axes of a room.

    Moved by m wraps, a plane of normal n turns to n + m dn: a right angle to an axis a gives m.
    """
    normals = _normals(surfaces, uneven)
    mean = found.mean
    variance = found.spread**2
    for axis in _axes(normals, found, label):
        slope = normals.turn @ axis
        off = (normals.at + mean[:, None] * normals.turn) @ axis
        total = normals.noise @ axis @ axis + normals.plumb**2 + slope**2 * variance
        likely = np.exp(-(off**2) / total / 2) / np.sqrt(TAU * total)
        use = normals.plane & (likely > _UPRIGHT) & (np.abs(mean) < _FARTHEST)
        gain = np.where(use, slope * variance / total, 0)
        left = np.maximum(variance * (1 - gain * slope), np.minimum(variance, _FLOOR[0] ** 2))
        mean = mean - gain * off
        variance = left
    return found._replace(mean=mean, spread=np.sqrt(variance))


def _normals(surfaces: Surfaces, uneven: Unevenness) -> _Normals:
    """Unit normals of all surfaces, and how they turn if these are moved by a wrap."""
    length = np.linalg.norm(surfaces.parameters[:, :3], axis=1)[:, None]
    at = surfaces.parameters[:, :3] / length
    turn = (surfaces.turn - at * np.sum(at * surfaces.turn, axis=1, keepdims=True)) / length
    noise = surfaces.covariance * (uneven.inflation[:, None, None] / length[:, :, None] ** 2)
    plumb = np.hypot(_PLUMB, _ASKEW * uneven.scale)
    return _Normals(at, turn, noise, plumb, surfaces.turn.any(axis=1))


def _axes(normals: _Normals, found: Offsets, label: Labels) -> list[Array]:
    """Three axes at right angles, to which most planes are parallel or upright; none if unclear.

    The first is the normal to which most others are, the second upright to it.
    """
    now = normals.at + found.mean[:, None] * normals.turn
    now /= np.linalg.norm(now, axis=1, keepdims=True)
    width = _width_of_normals(normals, found.spread**2)
    size = np.bincount(label[label >= 0], minlength=width.size)
    clear = normals.plane & (width < _CLEAR)
    cosine = np.abs(now @ now.T)
    apart = 3 * np.hypot(width, width[:, None])
    square = cosine < apart
    votes = (square | (1 - cosine**2 < apart**2)) @ np.where(clear, size, 0) - size
    votes = np.where(clear, votes / (1 + (width / _SHARP) ** 2), 0)
    one = int(np.argmax(votes))
    other = int(np.argmax(votes * square[one]))
    if not votes[other] * square[one, other]:
        return []
    second = now[other] - now[one] * (now[other] @ now[one])
    second /= np.linalg.norm(second)
    return [now[one], second, np.cross(now[one], second)]


def _width_of_normals(normals: _Normals, variance: Array) -> Array:
    """Uncertainty (N,) of normals, rad, whose offsets have a variance, wraps^2."""
    trace = np.trace(normals.noise, axis1=1, axis2=2)
    trace = trace + variance * np.sum(normals.turn**2, axis=1)
    return np.sqrt(trace + normals.plumb**2)
