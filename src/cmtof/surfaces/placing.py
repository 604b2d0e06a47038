"""From surfaces to depths: which one each pixel lies on, and how many whole wraps it is off.

The pooled higher phase lags behind the lower one by ``2 pi m (k_2 / k_1 - 2)`` after m wraps: the
beat. A plane moved along the rays is bent, the more so the wider it is: the shape.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter, uniform_filter

from cmtof.compiled import njit
from cmtof.correlation import TAU
from cmtof.surfaces.field import CELL, ENOUGH, Field
from cmtof.surfaces.fitting import pixel_likelihood
from cmtof.surfaces.growing import around
from cmtof.surfaces.roughness import (
    Cells,
    cells_of_surfaces,
    departure,
    pooled_phasors,
    sum_cells,
    sum_nearby,
    sum_surfaces,
    turned_alike,
)
from cmtof.surfaces.shapes import FARTHEST
from cmtof.types import Array, Arrays, Flags, Numbers

RADIUS = 2  # half side, px, of the square over which a pixel compares surfaces
# share S / E within that square below which a pixel lies on none of them
EXPLAINED = 0.4
_INSIDE = 4  # fits use pixels without another surface this near, px,
_CERTAIN = 0.6  # and with this S / E
_OPEN = 2.5  # deviations above which a common offset of beats counts
# inverse variance of such an offset, 1 / wraps^2, before anything is known
_CLOSED = 0.4
_CLOSING = 20  # iterations towards it
_SMOOTH = 1e-5  # departure from a plane, m (rms), allowed for where none can be seen
_FAINT = 8.0  # loss of S, times the stiffness, from which on it is seen
_FLOOR = (
    0.05,
    0.15,
)  # least uncertainty, wraps, of an offset by the shape and by the beat
# wraps of uncertainty of a beat per share of coherence that its surface lacks
_BENT = 1.5
_AGAIN = 2  # times that beats of rough surfaces are pooled again
_CUT = 20.0  # least gain, as a log-likelihood, of a part,
_EDGE = 0.12  # also per cell of its border
_PART = 6  # least size, cells, of a part
_APART = 0.7  # and its least distance, wraps
_CUTS = 3  # rounds of cutting
_PLUMB = 5e-4  # deviation, rad, of what is upright
_UPRIGHT = 5.0  # its least likelihood, 1 / rad
_CLEAR = 1e-2  # uncertainty, rad, of normals that vote,
_SHARP = 1.5e-3  # and of those elected
_FARTHEST = 10.0  # offset, wraps, up to which a plane turns in proportion


Beats = tuple[Array, Array, Array]
"""Offset by the beat of each surface (N,), wraps, its noise, and the coherence it rests on."""


class Offsets(NamedTuple):
    """Offset of each surface (N,), wraps to add, and its standard deviation."""

    mean: Array
    spread: Array
    closure: float = 0.0  # common offset of all beats, wraps, that was subtracted


def pixel_labels(
    field: Field, owner: Numbers, surfaces: Array
) -> tuple[Numbers, Array]:
    """Likeliest surface (H, W), -1 for none, of a square about each pixel, and its share S / E."""
    side = 2 * RADIUS + 1
    shape = field.cosine.shape
    label = np.full(shape, -1, np.int32)
    best = np.full(shape, -np.inf)
    _label(field, owner, surfaces, label, best)
    told = np.zeros(shape)
    for frequency, loss in enumerate((0.5, 2.0)):  # of S by roughness
        information = field.information[frequency].astype(float)
        left = np.append(np.exp(-loss * surfaces[:, 6:].sum(axis=1)), 1.0)
        told += (
            side**2 * uniform_filter(information, side, mode="constant") * left[label]
        )
    share = np.where(label < 0, 0, best / np.maximum(told, 1e-9)).astype(np.float32)
    return np.where(share > EXPLAINED, label, -1).astype(np.int32), share


def interiors(label: Numbers, share: Array) -> Numbers:
    """The labels without the borders of surfaces, unless little else would be left of one."""
    side = 2 * _INSIDE + 1
    inner = (minimum_filter(label, side) == maximum_filter(label, side)) & (
        share > _CERTAIN
    )
    known = label >= 0
    count = int(label.max()) + 1
    whole, left = (
        np.bincount(label[known & of], minlength=count) for of in (True, inner)
    )
    thin = np.append(left < whole / 4, False)
    return np.where(inner | thin[label], label, -1).astype(np.int32)


def depth_of_labels(field: Field, label: Numbers, surfaces: Array) -> Array:
    """Depth (H, W), m, of each pixel on its surface; NaN without one."""
    out = np.full(label.shape, np.nan)
    y, x = np.nonzero(label >= 0)
    out[y, x] = depth_of_pixels(field, surfaces, label[y, x], y, x)
    return out


def depth_of_pixels(
    field: Field, surfaces: Array, which: Numbers, y: Numbers, x: Numbers
) -> Array:
    """Depth (P,), m, of surfaces by their number (P,) at pixels (P,)."""
    q = surfaces[which].T
    u = field.u[x]
    v = field.v[y]
    inverse = q[0] * u + q[1] * v + q[2] + q[3] * u * u + q[4] * u * v + q[5] * v * v
    return 1 / np.maximum(field.cosine[y, x] * inverse, FARTHEST)


@njit()
def _label(field, owner, surfaces, label, best):  # pragma: no cover - compiled
    """Sum S of every surface about a cell over squares about its pixels; keep the largest."""
    side = 2 * RADIUS + 1
    for row, column in np.ndindex(owner.shape):
        for n in around(owner, row, column):
            near = _near_cell(field, surfaces[n], row, column)
            for y in range(CELL):
                for x in range(CELL):
                    total = np.sum(near[y : y + side, x : x + side])
                    at = (row * CELL + y, column * CELL + x)
                    if total > best[at]:
                        best[at] = total
                        label[at] = n


@njit()
def _near_cell(field, q, row, column):  # pragma: no cover - compiled
    """S of a surface at each pixel of a cell and of a margin about it."""
    height, width = field.cosine.shape
    side = CELL + 2 * RADIUS
    top = row * CELL - RADIUS
    left = column * CELL - RADIUS
    out = np.zeros((side, side))
    for y in range(max(top, 0), min(top + side, height)):
        for x in range(max(left, 0), min(left + side, width)):
            out[y - top, x - left] = pixel_likelihood(field, q, y, x)
    return out


def offsets(
    beats: Beats, surfaces: Array, fit: Array, *, shape=True, closed=False
) -> Offsets:
    """Offset of each surface, from its shape as far as a plane misses it little, and its beat.

    An offset between the frequencies moves all beats and no shape. It is the mean excess of beats
    over shapes of planes, with Student's weights, and zero if ``closed`` or not significant.
    """
    beat, noise, coherence = beats
    doubt = _FLOOR[1] + _BENT * (1 - np.clip(coherence, 0.05, 1))
    by_beat = 1 / (noise**2 + doubt**2)
    by_shape = _information_of_shapes(fit) * shape
    total = by_beat + by_shape
    flat = ~surfaces[:, 3:6].any(axis=1)  # what is bent may have been bent by a wrap
    off = 0.0
    if not closed:
        off = _closure(beat - fit[:, 0], flat * by_beat * by_shape / total)
    mean = (fit[:, 0] * by_shape + (beat - off) * by_beat) / total
    return Offsets(mean, 1 / np.sqrt(total), off)


def _information_of_shapes(fit: Array) -> Array:
    """Inverse variance (N,), 1 / wraps^2, of offsets by the shapes of planes."""
    known, missed, bend = np.maximum(fit[:, 1:4].T, 1e-12)
    stiff = np.where(fit[:, 1] > 0, known / bend**2, 0)
    # what is too faint for its own unevenness to be seen is as uneven as the others
    order = np.argsort(missed)
    told = stiff[order].cumsum()
    typical = missed
    if len(told):
        typical = missed[order][np.searchsorted(told, told[-1:] / 2)]
    unseen = np.minimum(typical, np.sqrt(_FAINT / np.maximum(stiff, 1e-12)))
    uneven = np.maximum(missed, np.maximum(unseen, _SMOOTH))
    variance = 1 / known + (uneven / bend) ** 2 + _FLOOR[0] ** 2
    return np.where(fit[:, 1] > 0, 1 / variance, 0)


def _closure(excess: Array, most: Array) -> float:
    """Mean excess of beats over shapes, wraps, by Student's weights, ``most`` at best.

    It is zero if it is not significant.
    """
    weight = most
    off = 0.0
    for _ in range(_CLOSING):
        weight = most / (1 + most * (excess - off) ** 2 / 2)
        off = float(weight @ excess / (weight.sum() + _CLOSED))
    return 0.0 if abs(off) < _OPEN / np.sqrt(weight.sum() + 1e-12) else off


class Planes(NamedTuple):
    """Normals of planes, one entry (N,) each, zeros for what is bent."""

    normal: Array  # (N, 3)
    turn: Array  # (N, 3), its change by a wrap
    noise: Array  # (N, 3, 3), its covariance
    known: Flags  # whether it is a plane


def _planes(surfaces: Array, fit: Array) -> Planes:
    """Normals of surfaces (N, 7) by their fit (N, 16)."""
    length = np.linalg.norm(surfaces[:, :3], axis=1, keepdims=True)
    normal = surfaces[:, :3] / length
    shift = fit[:, 4:7]
    turn = (shift - normal * np.sum(normal * shift, axis=1, keepdims=True)) / length
    noise = fit[:, 7:].reshape(-1, 3, 3) / length[:, :, None] ** 2
    return Planes(normal, turn, noise, shift.any(axis=1))


def aligned(found: Offsets, surfaces: Array, fit: Array, label: Numbers) -> Offsets:
    """Offsets of planes, made sharper where these stand upright to the axes of a room.

    Moved by m wraps, a plane of normal n turns to n + m dn: a right angle to an axis a gives m.
    """
    planes = _planes(surfaces, fit)
    mean = found.mean
    variance = found.spread**2
    now = planes.normal + mean[:, None] * planes.turn
    now /= np.linalg.norm(now, axis=1, keepdims=True)
    trace = np.trace(planes.noise, axis1=1, axis2=2)
    width = np.sqrt(trace + variance * np.sum(planes.turn**2, axis=1) + _PLUMB**2)
    size = np.bincount(label[label >= 0], minlength=width.size)
    for axis in _axes(now, width, np.where(planes.known & (width < _CLEAR), size, -1)):
        mean, variance = _use_right_angles(planes, mean, variance, axis)
    return found._replace(mean=mean, spread=np.sqrt(variance))


def _axes(normal: Array, width: Array, size: Numbers) -> list[Array]:
    """Axes of a room from normals, their deviations, rad, and sizes, px, -1 of those not clear.

    The first is the normal to which most are parallel or upright, the second upright to it.
    """
    clear = size >= 0
    size = np.maximum(size, 0)
    cosine = np.abs(normal @ normal.T)
    apart = 3 * np.hypot(width, width[:, None])
    square = cosine < apart
    votes = (square | (1 - cosine**2 < apart**2)) @ size - size
    votes = np.where(clear, votes / (1 + (width / _SHARP) ** 2), 0)
    one = int(np.argmax(votes))
    other = int(np.argmax(votes * square[one]))
    if not votes[other] * square[one, other]:
        return []
    first = normal[one]
    second = normal[other] - first * (normal[other] @ first)
    second /= np.linalg.norm(second)
    return [first, second, np.cross(first, second)]


def _use_right_angles(
    planes: Planes, mean: Array, variance: Array, axis: Array
) -> Arrays:
    """Mean and variance (N,) of offsets by the right angles of planes to an axis."""
    slope = planes.turn @ axis
    off = (planes.normal + mean[:, None] * planes.turn) @ axis
    total = planes.noise @ axis @ axis + _PLUMB**2 + slope**2 * variance
    likely = np.exp(-(off**2) / total / 2) / np.sqrt(TAU * total)
    use = planes.known & (likely > _UPRIGHT) & (np.abs(mean) < _FARTHEST)
    gain = np.where(use, slope * variance / total, 0)
    least = np.minimum(variance, _FLOOR[0] ** 2)
    return mean - gain * off, np.maximum(variance * (1 - gain * slope), least)


def pooled_beats(field: Field, cells: Cells) -> Beats:
    """Offset by the beat of each surface (N,), wraps, its noise, and the coherence it rests on.

    Pixels of rough surfaces are turned back by their own departure, which takes a part of the
    offset along: it is pooled again without the offset that was found.
    """
    turn = -1j * TAU * field.excess
    found = _beats(field, cells)
    for _ in range(_AGAIN if cells.rough.any() else 0):
        turned = cells.turned.copy()
        turned[1] *= np.exp(turn * np.append(found[0], 0)[cells.label])
        sums = sum_cells(turned, cells.side)
        again = _beats(field, cells._replace(turned=turned, sums=sums))
        found = (found[0] + again[0], *again[1:])
    return found


def _beats(field: Field, cells: Cells) -> Beats:
    """One pass of `pooled_beats`."""
    multiple = field.multiple
    turned = _cell_phasors(field, cells)
    total, most = pooled_phasors(cells.main, turned, cells.told, cells.rough.size)
    length = np.maximum(np.abs(total), 1e-9)
    wrap = TAU * field.excess
    beat = np.angle(total[1] * np.conj(total[0] / length[0]) ** multiple) / wrap
    variance = most / length**2
    noise = np.sqrt(variance[1] + multiple**2 * variance[0]) / abs(wrap)
    return beat, noise, (length / most).min(axis=0)


def _cell_phasors(field: Field, cells: Cells) -> Array:
    """Phasors (2, h, w) of cells without what moves both alike."""
    sums = cells.sums
    multiple = field.multiple
    if cells.rough.any():  # pixels are turned back by their own departure first
        off = departure(field, cells.turned, np.append(cells.rough, 0)[cells.label])
        sums = sum_cells(turned_alike(field, cells.turned, off), cells.side)
    near = sums
    reached = cells.told.sum(axis=0)  # six functions miss what these turn back
    for radius in (1, 2, 4) if cells.side > 1 else ():
        weak = reached < ENOUGH
        wider = sum_nearby(np.concatenate([sums, cells.told]), cells.main, radius)
        near = np.where(weak, wider[:2], near)
        reached = np.where(weak, wider[2:].real.sum(axis=0), reached)
    low = np.angle(near[0])
    high = np.angle(turned_alike(field, near, low)[1])
    size = np.abs(near)
    pull = size[1] * multiple * high / (size[0] + multiple**2 * size[1] + 1e-9)
    return turned_alike(field, sums, low + pull)


def parted(field: Field, inner: Numbers, surfaces: Array) -> tuple[Numbers, Array]:
    """Surface of most pixels in each cell, and surfaces (N, 7), those cut whose beat steps.

    Two planes at whole wraps of distance have the same phases and grow as one. They are parted if
    that gains more log-likelihood than `_CUT`, and than `_EDGE` for each cell along the border.
    """
    depth = depth_of_labels(field, inner, surfaces)
    cells = cells_of_surfaces(field, inner, depth, len(surfaces))
    lags = _lags(field, cells)
    main = cells.main
    for _ in range(_CUTS):
        count = len(surfaces)
        ahead, apart, known = _halves(main, *lags, count)
        gain = apart**2 / np.sum(1 / known, axis=0) / 2
        good = gain > np.maximum(_CUT, _EDGE * _borders_of_halves(main, ahead, count))
        good &= (
            sum_surfaces(main, np.array([~ahead, ahead]), count).min(axis=0) >= _PART
        )
        good &= np.abs(apart) > _APART
        good[count] = False  # of cells without a surface
        new = count + np.cumsum(good) - 1
        main = np.where(ahead & good[main], new[main], main)
        surfaces = np.concatenate([surfaces, surfaces[good[:count]]])
    return main, surfaces


def _lags(field: Field, cells: Cells) -> tuple[Array, Array]:
    """Lag of the beat of each cell (h, w), wraps, and its inverse variance."""
    told = cells.told
    wrap = TAU * field.excess
    ratio = field.multiple
    low, high = _cell_phasors(field, cells).imag / np.maximum(told, 1e-6)
    both = np.maximum(told[0] + ratio**2 * told[1], 1e-9)
    return (high - ratio * low) / wrap, wrap**2 * told[0] * told[1] / both


def _halves(
    main: Numbers, lag: Array, weight: Array, count: int
) -> tuple[Flags, Array, Array]:
    """Cells (h, w) of each surface that lie ahead, by how much (N + 1,), and weights (2, N + 1)."""
    summed = partial(sum_surfaces, main, count=count)
    middle = (summed(weight * lag) / np.maximum(summed(weight), 1e-9))[main]
    turn = 1.0
    for radius in (1, 2, 2, 2, 2):
        ahead = sum_nearby(weight * (lag - middle) * turn, main, radius) > 0
        sides = np.array([~ahead, ahead])
        known = np.maximum(summed(weight * sides), 1e-9)
        rest, part = summed(weight * lag * sides) / known
        middle = ((part + rest) / 2)[main]
        turn = (part - rest)[main]
    return ahead, part - rest, known


def _borders_of_halves(main: Numbers, ahead: Flags, count: int) -> Array:
    """Length (N + 1,), cells, of the border of what lies ahead within each surface."""
    border = np.zeros(count + 1)
    for axis in (0, 1):
        here = np.delete(main, 0, axis)
        inside = here == np.delete(main, -1, axis)
        border += sum_surfaces(here, inside & np.diff(ahead, axis=axis), count)
    return border
