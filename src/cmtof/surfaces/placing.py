"""From surfaces to depths: the surface of each pixel, and how many wraps each surface is off.

The beat says it (`cmtof.surfaces.beats`), and so does the shape: a plane moved along the rays is
bent, the more so the wider it is.
"""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter, uniform_filter

from cmtof.compiled import njit
from cmtof.correlation import TAU
from cmtof.surfaces.beats import Beats
from cmtof.surfaces.blocks import pixel_likelihood
from cmtof.surfaces.field import CELL, Field
from cmtof.surfaces.growing import owners_around
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
_PLUMB = 5e-4  # deviation, rad, of what is upright
_UPRIGHT = 5.0  # its least likelihood, 1 / rad
_CLEAR = 1e-2  # uncertainty, rad, of normals that vote,
_SHARP = 1.5e-3  # and of those elected
_FARTHEST = 10.0  # offset, wraps, up to which a plane turns in proportion


class Offsets(NamedTuple):
    """Offset of each surface (N,), wraps to add, and its standard deviation."""

    mean: Array
    spread: Array
    closure: float = 0.0  # common offset of all beats, wraps, that was subtracted


def pixel_labels(
    field: Field, owner: Numbers, surfaces: Array
) -> tuple[Numbers, Array, Numbers]:
    """Likeliest surface of each pixel (H, W), -1 for none, how well it fits, and `interiors`.

    Both follow from a square about the pixel; the fit is the score S over that expected.
    """
    side = 2 * RADIUS + 1
    shape = field.cosine.shape
    label = np.full(shape, -1, np.int32)
    best = np.zeros(shape)
    _label(field, owner, surfaces, label, best)
    rough = np.append(surfaces[:, 6:].sum(axis=1), 0)
    # each frequency loses its own part of S by roughness
    left = np.exp(np.outer((-0.5, -2.0), rough))[:, label]
    known = field.information.astype(float)
    mean = uniform_filter(known, side, mode="constant", axes=(1, 2))
    expected = (side**2 * mean * left).sum(axis=0)
    share = (best / np.maximum(expected, 1e-9)).astype(np.float32)
    label = np.where(share > EXPLAINED, label, -1)
    return label, share, interiors(label, share)


def interiors(label: Numbers, share: Array) -> Numbers:
    """Labels (H, W), with -1 near borders and where unsure; thin surfaces keep all their pixels."""
    side = 2 * _INSIDE + 1
    inner = (minimum_filter(label, side) == maximum_filter(label, side)) & (
        share > _CERTAIN
    )
    number = label + 1  # zero stands for none
    whole = np.bincount(number.ravel())
    thin = np.bincount(number[inner], minlength=whole.size) < whole / 4
    return np.where(inner | thin[number], label, -1)


@njit()
def _label(field, owner, surfaces, label, best):  # pragma: no cover - compiled
    """Write each pixel's likeliest nearby surface to ``label``, its S by a square to ``best``."""
    side = 2 * RADIUS + 1
    for row, column in np.ndindex(owner.shape):
        for n in owners_around(owner, row, column):
            near = _near_cell(field, surfaces[n], row, column)
            for y in range(CELL):
                for x in range(CELL):
                    total = near[y : y + side, x : x + side].sum()
                    at = (row * CELL + y, column * CELL + x)
                    if total > best[at]:
                        best[at] = total
                        label[at] = n


@njit()
def _near_cell(field, q, row, column):  # pragma: no cover - compiled
    """Log-likelihood S of a surface at each pixel of a cell and of `RADIUS` px about it."""
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
    """Offset of each surface, from its beat and, as far as it is clearly a plane, its shape.

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
    plane = fit[:, 1] > 0
    known, missed, bend = np.maximum(fit[:, 1:4].T, 1e-12)
    stiff = np.where(plane, known / bend**2, 0)
    # what is too faint for its own unevenness to be seen is as uneven as the others
    order = np.argsort(missed)
    summed = stiff[order].cumsum()
    middle = np.searchsorted(summed, summed[-1:] / 2)
    typical = missed[order][middle]
    unseen = np.minimum(typical, np.sqrt(_FAINT / np.maximum(stiff, 1e-12)))
    uneven = np.maximum(missed, np.maximum(unseen, _SMOOTH))
    variance = 1 / known + (uneven / bend) ** 2 + _FLOOR[0] ** 2
    return np.where(plane, 1 / variance, 0)


def _closure(excess: Array, most: Array) -> float:
    """Mean excess of beats over shapes, wraps, by Student's weights, ``most`` at best.

    It is zero if it is not significant.
    """
    off = 0.0
    total = 0.0
    for _ in range(_CLOSING):
        weight = most / (1 + most * (excess - off) ** 2 / 2)
        total = weight.sum()
        off = float(weight @ excess / (total + _CLOSED))
    return off if abs(off) >= _OPEN / np.sqrt(total + 1e-12) else 0.0


class Planes(NamedTuple):
    """Unit normals of surfaces (N, 3), and how those of planes turn by a wrap, with noise."""

    normal: Array  # (N, 3)
    turn: Array  # (N, 3), its change by a wrap
    noise: Array  # (N, 3, 3), its covariance
    known: Flags  # whether it is a plane


def _planes(surfaces: Array, fit: Array) -> Planes:
    """Normals of surfaces (N, 7), and how a wrap turns those of planes, by fits (N, 16)."""
    q = surfaces[:, :3]
    length = np.linalg.norm(q, axis=1, keepdims=True)
    normal = q / length
    shift = fit[:, 4:7]
    along = (normal * shift).sum(axis=1, keepdims=True)
    turn = (shift - normal * along) / length
    noise = fit[:, 7:].reshape(-1, 3, 3) / length[:, :, None] ** 2
    return Planes(normal, turn, noise, shift.any(axis=1))  # pyright: ignore[reportArgumentType]


def use_axes(found: Offsets, surfaces: Array, fit: Array, label: Numbers) -> Offsets:
    """Offsets, made sharper for planes that stand at right angles to an axis of the room.

    Moved by m wraps, a plane of normal n turns to n + m dn: a right angle to an axis a gives m.
    """
    planes = _planes(surfaces, fit)
    mean = found.mean
    variance = found.spread**2
    now = planes.normal + mean[:, None] * planes.turn
    now /= np.linalg.norm(now, axis=1, keepdims=True)
    trace = np.trace(planes.noise, axis1=1, axis2=2)
    width = np.sqrt(trace + variance * (planes.turn**2).sum(axis=1) + _PLUMB**2)
    size = np.bincount(label[label >= 0], minlength=width.size)
    clear = planes.known & (width < _CLEAR)
    for axis in _axes(now, width, clear, size * clear):
        mean, variance = _use_right_angles(planes, mean, variance, axis)
    return found._replace(mean=mean, spread=np.sqrt(variance))


def _axes(normal: Array, width: Array, clear: Flags, size: Numbers) -> list[Array]:
    """Three axes of a room, or none, from normals, deviations, rad, flags of clear ones, sizes, px.

    The first is the normal to which most are parallel or upright, the second upright to it.
    """
    cosine = abs(normal @ normal.T)
    apart = 3 * np.hypot(width, width[:, None])
    square = cosine < apart
    parallel = 1 - cosine**2 < apart**2
    votes = (square | parallel) @ size - size
    votes = np.where(clear, votes / (1 + (width / _SHARP) ** 2), 0)
    one = votes.argmax()
    upright = votes * square[one]
    other = upright.argmax()
    if not upright[other]:
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
    total = planes.noise @ axis @ axis + _PLUMB**2
    total += slope**2 * variance
    likely = np.exp(-(off**2) / total / 2) / np.sqrt(TAU * total)
    use = planes.known & (likely > _UPRIGHT) & (abs(mean) < _FARTHEST)
    gain = np.where(use, slope * variance / total, 0)
    least = np.minimum(variance, _FLOOR[0] ** 2)
    return mean - gain * off, np.maximum(variance * (1 - gain * slope), least)
