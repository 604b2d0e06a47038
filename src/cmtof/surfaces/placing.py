"""From surfaces to depths: which one each pixel lies on, and how many whole wraps it is off.

The beat and the shape decide the wraps. The pooled higher phase lags behind the pooled lower one by
``2 pi m (k_2 / k_1 - 2)`` after m wraps; and a plane moved along the rays is no plane any more, so
a fit that is m wraps off is bent, the more so the wider the surface. Surfaces that touch share
their offset: along a border two surfaces either meet, with the same depth there but for their
unknown whole wraps, or one hides the other, and their difference takes any value.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter, uniform_filter

from cmtof.correlation import TAU
from cmtof.surfaces.field import CELL, Field
from cmtof.surfaces.fitting import FARTHEST, pixel_likelihood, select
from cmtof.surfaces.growing import FLAT, GAIN, around, boxes_of_cells, possible

RADIUS = 2
"""Half side, px, of the square over which a pixel compares surfaces."""

EXPLAINED = 0.4
"""Share S / E within that square below which a pixel lies on none of them."""

_INSIDE, _CERTAIN = 4, 0.6  # fits use pixels without another surface this near, and this S / E
_CELLS, _STEPS, _HOPS = 400, 6, 60  # cells, steps and wraps of the last fit
_SMOOTH = 1e-5  # departure from a plane, m (rms), allowed for where none can be seen
_FLOOR = (0.05, 0.15)  # least uncertainty, wraps, of an offset by the shape and by the beat
_BENT = 1.5  # wraps of uncertainty of a beat per share of coherence that its surface lacks
_ENOUGH = 60.0  # information from which on a cell is turned back by its own phasors alone

_LEAST, _LONG = 8, 24  # border, px, below which nothing follows from it; with full odds
# Tolerance of one pixel's difference, wraps, and of it per wrap of slope between the surfaces; of
# the border's median, and of it per wrap of slope: a border is known to a pixel.
_TOLERANCE = (0.25, 1.5, 0.1, 0.3)
# Odds that surfaces meet, by the share of their border that differs by the same whole wraps.
_SUPPORT = ((0.95, 2.0), (0.85, 0.7), (0.6, 0.2), (0.0, 0.02))
_JUMP = 40.0  # wraps over which the depths of surfaces that do not meet are spread
_MEET, _LOOSE = 0.3, 0.05  # odds from which on two surfaces are tied; variance, wraps^2, of a tie


class Offsets(NamedTuple):
    """Offset of each surface (N,), wraps to add, and its standard deviation."""

    mean: NDArray[np.float64]
    spread: NDArray[np.float64]


class Borders(NamedTuple):
    """Pairs of surfaces with a common border, one entry (B,) each.

    ``step`` is the whole wraps by which the first lies behind the second along most of the border,
    ``odds`` that the two meet there, before anything is known of their offsets.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    step: NDArray[np.float64]
    odds: NDArray[np.float64]


class Tied(NamedTuple):
    """Surfaces after the ties, one entry (N,) each.

    ``wraps`` to add, whole; number of the ``group``; its offset ``mean``, wraps, before rounding,
    and the standard deviation ``spread`` of that.
    """

    wraps: NDArray[np.float64]
    group: NDArray[np.int64]
    mean: NDArray[np.float64]
    spread: NDArray[np.float64]


# --- pixels ------------------------------------------------------------------------------------


def pixel_labels(
    field: Field, owner: NDArray[np.int64], surfaces: NDArray[np.float64]
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Likeliest surface (H, W) of each pixel among those about its cell, and its share S / E.

    Both are compared over a square about the pixel; -1 where no surface explains it.
    """
    side = 2 * RADIUS + 1
    both = field.information.sum(axis=0, dtype=float)
    told = side**2 * uniform_filter(both, side, mode="constant")
    label, best = np.full(both.shape, -1, np.int32), np.full(both.shape, -np.inf)
    _label(field.arrays(), owner, surfaces, label, best)
    share = np.where(label < 0, 0, best / np.maximum(told, 1e-9)).astype(np.float32)
    return np.where(share > EXPLAINED, label, -1).astype(np.int32), share


def interiors(label: NDArray[np.int32], share: NDArray[np.float32]) -> NDArray[np.int32]:
    """The labels without the borders of surfaces, unless little else would be left of one."""
    side = 2 * _INSIDE + 1
    inner = (minimum_filter(label, side) == maximum_filter(label, side)) & (share > _CERTAIN)
    known = label >= 0
    count = int(label.max()) + 1
    whole, left = (np.bincount(label[known & of], minlength=count) for of in (True, inner))
    thin = np.append(left < whole / 4, False)
    return np.where(inner | thin[label], label, -1).astype(np.int32)


def depth_of_labels(
    field: Field, label: NDArray[np.integer], surfaces: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Depth (H, W), m, of each pixel on its surface; NaN without one."""
    out = np.full(label.shape, np.nan)
    known = label >= 0
    if known.any():
        q = surfaces[label[known]].T
        u, v = (np.broadcast_to(x, label.shape)[known] for x in (field.u, field.v[:, None]))
        inverse = q[0] * u + q[1] * v + q[2] + q[3] * u * u + q[4] * u * v + q[5] * v * v
        out[known] = 1 / np.maximum(field.cosine[known] * inverse, FARTHEST)
    return out


@njit(cache=True, nogil=True, fastmath=True)
def _label(field, owner, surfaces, label, best):  # pragma: no cover - compiled
    """Sum S of every surface about a cell over squares about its pixels; keep the largest."""
    height, width = label.shape
    side = 2 * RADIUS + 1
    found, patch = np.empty(9, np.int64), np.zeros((CELL + 2 * RADIUS, CELL + 2 * RADIUS))
    for cell in range(owner.size):
        row, column = cell // owner.shape[1], cell % owner.shape[1]
        top, left = row * CELL - RADIUS, column * CELL - RADIUS
        for i in range(around(owner, row, column, found)):
            patch[:] = 0.0
            for y in range(max(top, 0), min(top + patch.shape[0], height)):
                for x in range(max(left, 0), min(left + patch.shape[1], width)):
                    patch[y - top, x - left] = pixel_likelihood(field, surfaces[found[i]], y, x)
            for y in range(CELL):
                for x in range(CELL):
                    total = 0.0
                    for a in range(side):
                        for b in range(side):
                            total += patch[y + a, x + b]
                    at = (row * CELL + y, column * CELL + x)
                    if total > best[at]:
                        best[at], label[at] = total, found[i]


# --- offsets ---------------------------------------------------------------------------------


def fitted(
    field: Field, inner: NDArray[np.int32], surfaces: NDArray[np.float64], *, bent: bool = True
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit every surface (N, 6) to its interior; its fit (N, 5) as well.

    The fit holds: offset that is lacking, wraps; its inverse variance; functions used; what a plane
    misses, m (rms); by how much a plane is bent by a wrap, m (rms).
    """
    rows, columns = (n // CELL for n in inner.shape)
    # one entry for each cell and surface that share pixels
    cell = (np.arange(inner.shape[0]) // CELL)[:, None] * columns
    cell = cell + np.arange(inner.shape[1]) // CELL
    known = inner >= 0
    pairs = np.unique(inner[known].astype(np.int64) * (rows * columns) + cell[known])
    of, cells = np.divmod(pairs, rows * columns)
    starts = np.searchsorted(of, np.arange(len(surfaces) + 1))
    out, fit = surfaces.copy(), np.zeros((len(surfaces), 5))
    farthest, gain = float(field.limits[1]), GAIN if bent else np.inf
    _fit(field.arrays(), inner, cells, starts, columns, farthest, gain, out, fit)
    return out, fit


@njit(cache=True, nogil=True)
def _fit(field, inner, cells, starts, columns, farthest, gain, surfaces, fit):  # pragma: no cover
    k = field[3]
    for n in range(surfaces.shape[0]):
        own = cells[starts[n] : starts[n + 1]]
        if own.size == 0:
            continue
        boxes = boxes_of_cells(own, columns, _CELLS)
        weight = own.size / boxes.shape[0]
        found = select(field, inner, n, surfaces[n], boxes, _STEPS, _HOPS, gain, FLAT, weight)
        q, _, most, offset, known, size, missed = found
        if not possible(field, q, boxes[0], farthest):
            continue
        surfaces[n] = q
        stiff = max(most * (k[0] ** 2 + k[1] ** 2) / 2, 1e-9)
        bend = np.sqrt(known / stiff)
        fit[n] = np.array([offset, known * weight, float(size), missed, bend])


def offsets(
    field: Field,
    inner: NDArray[np.int32],
    surfaces: NDArray[np.float64],
    fit: NDArray[np.float64],
    *,
    shape: bool = True,
) -> Offsets:
    """Offset of each fitted surface from its shape and from its beat.

    The shape counts as far as a plane is known to miss the surface by less than a wrap bends it.
    """
    beat, noise, coherence = pooled_beats(field, inner, surfaces)
    doubt = _FLOOR[1] + _BENT * (1 - np.clip(coherence, 0.05, 1))
    by_beat = 1 / (noise**2 + doubt**2)
    known, missed, bend = (np.maximum(fit[:, i], 1e-12) for i in (1, 3, 4))
    variance = 1 / known + (np.maximum(missed, _SMOOTH) / bend) ** 2 + _FLOOR[0] ** 2
    by_shape = np.where((fit[:, 1] > 0) & shape, 1 / variance, 0)
    mean = (fit[:, 0] * by_shape + beat * by_beat) / (by_shape + by_beat)
    return Offsets(mean, 1 / np.sqrt(by_shape + by_beat))


def pooled_beats(
    field: Field, inner: NDArray[np.int32], surfaces: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Offset by the beat of each surface (N,), wraps, its noise, and the coherence it rests on.

    A surface is no better than its six functions. So each cell is first turned back by what its
    neighbourhood's phasors say at both frequencies together, and then all are summed.
    """
    count, shape = len(surfaces), tuple(n // CELL for n in inner.shape)
    main = _main_surfaces(inner, count)
    chosen = np.kron(main, np.ones((CELL, CELL), int)) == inner
    depth = np.nan_to_num(depth_of_labels(field, inner, surfaces))
    phasors = (field.real + 1j * field.imaginary) * np.exp(
        -1j * field.wavenumber[:, None, None] * depth
    )
    blocks = (2, shape[0], CELL, shape[1], CELL)
    chosen &= inner >= 0
    sums = np.where(chosen, phasors, 0).reshape(blocks).sum(axis=(2, 4))
    told = np.where(chosen, field.information, 0).astype(float).reshape(blocks).sum(axis=(2, 4))
    near, reached = sums.copy(), told.sum(axis=0)
    for radius in (1, 2, 4):
        weak = reached < _ENOUGH
        wider = _same(np.concatenate([sums, told]), main, radius)
        near = np.where(weak, wider[:2], near)
        reached = np.where(weak, np.real(wider[2:]).sum(axis=0), reached)
    multiple = field.multiple
    low = np.angle(near[0])
    high = np.angle(near[1] * np.exp(-1j * multiple * low))
    size = np.abs(near)
    residual = low + size[1] * multiple * high / (size[0] + multiple**2 * size[1] + 1e-9)
    known = main >= 0
    turns = np.array([1, multiple])[:, None, None]
    turned = sums * np.exp(-1j * turns * residual)

    def summed(image: NDArray) -> NDArray[np.float64]:
        return np.bincount(main[known], image[known], count).astype(float)

    total = np.stack([summed(np.real(one)) + 1j * summed(np.imag(one)) for one in turned])
    most = np.maximum(np.stack([summed(told[f]) for f in (0, 1)]), 1e-9)
    length = np.maximum(np.abs(total), 1e-9)
    wrap = TAU * field.excess
    beat = np.angle(total[1] * np.conj(total[0] / length[0]) ** multiple) / wrap
    variance = most / length**2
    noise = np.sqrt(variance[1] + multiple**2 * variance[0]) / abs(wrap)
    return beat, noise, (length / most).min(axis=0)


def _main_surfaces(inner: NDArray[np.int32], count: int) -> NDArray[np.int64]:
    """Surface of most pixels in each cell (h, w), -1 for none."""
    shape = tuple(n // CELL for n in inner.shape)
    y, x = np.nonzero(inner >= 0)
    cell = y // CELL * shape[1] + x // CELL
    pairs, pixels = np.unique(cell * max(count, 1) + inner[y, x], return_counts=True)
    order = np.argsort(pixels, kind="stable")  # the last one written has most
    main = np.full(shape[0] * shape[1], -1, np.int64)
    cells, owners = np.divmod(pairs[order], max(count, 1))
    main[cells] = owners
    return main.reshape(shape)


def _same(images: NDArray, main: NDArray[np.int64], radius: int) -> NDArray:
    """Sum of images (N, h, w) over the cells of the same surface within a radius."""
    height, width = main.shape
    edge = (radius, radius)
    padded = np.pad(images, ((0, 0), edge, edge))
    owner = np.pad(main, radius, constant_values=-2)
    out = np.zeros_like(images)
    for y in range(2 * radius + 1):
        for x in range(2 * radius + 1):
            place = (slice(y, y + height), slice(x, x + width))
            out += np.where(owner[place] == main, padded[(slice(None), *place)], 0)
    return out


# --- ties ------------------------------------------------------------------------------------


def borders(field: Field, label: NDArray[np.int32], surfaces: NDArray[np.float64]) -> Borders:
    """Compare surfaces across every border between labels (H, W)."""
    count = len(surfaces)
    keys, steps, slopes = [], [], []
    for axis in (0, 1):
        here, ahead = np.delete(label, -1, axis), np.delete(label, 0, axis)
        between = (here != ahead) & (here >= 0) & (ahead >= 0)
        low, high = np.minimum(here, ahead), np.maximum(here, ahead)
        pad = [(0, 0), (0, 0)]
        depths = []  # of both surfaces at both pixels
        for one in (low, high):
            for side in ((0, 1), (1, 0)):
                pad[axis] = side
                at = np.pad(np.where(between, one, -1), pad, constant_values=-1)
                found = depth_of_labels(field, at, surfaces)
                depths.append(np.delete(found, -1 if side == (0, 1) else 0, axis)[between])
        first, second = depths[0] - depths[2], depths[1] - depths[3]
        keys.append(low[between].astype(np.int64) * count + high[between])
        steps.append((first + second) / 2 / field.period)
        slopes.append(np.abs(first - second) / field.period)
    return _judged(np.concatenate(keys), np.concatenate(steps), np.concatenate(slopes), count)


def _judged(
    keys: NDArray[np.int64], steps: NDArray[np.float64], slopes: NDArray[np.float64], count: int
) -> Borders:
    """Odds that the two surfaces of each border meet."""
    order = np.argsort(keys, kind="stable")
    cuts = np.flatnonzero(np.diff(keys[order])) + 1
    found = []
    for part in np.split(order, cuts):
        if part.size < _LEAST:
            continue
        step, slope = steps[part], np.minimum(slopes[part], 1)
        near = _TOLERANCE[0] + _TOLERANCE[1] * slope
        whole = np.unique(np.rint(step))
        support = (np.abs(step[:, None] - whole) < near[:, None]).mean(axis=0)
        best = int(np.argmax(support))
        agreeing = step[np.abs(step - whole[best]) < near.max()]
        rest = np.median(agreeing) - whole[best] if agreeing.size else 0.5
        width = _TOLERANCE[2] + _TOLERANCE[3] * np.median(slope)
        odds = next(value for least, value in _SUPPORT if support[best] >= least)
        odds *= np.exp(-((rest / width) ** 2) / 2) * min(1, part.size / _LONG)
        found.append((*divmod(int(keys[part[0]]), count), whole[best], odds))
    columns = list(zip(*found, strict=True)) if found else [(), (), (), ()]
    kinds = (np.int64, np.int64, float, float)
    return Borders(*(np.array(c, kind) for c, kind in zip(columns, kinds, strict=True)))


def tied(found: Offsets, borders: Borders) -> Tied:
    """Tie surfaces, the surest pair first, as long as the odds are good.

    Each group's offset is a Gaussian. If two meet, their offsets differ by known wraps: the odds
    are those of the border times how much likelier the two Gaussians are to agree than to be
    anywhere within `_JUMP` wraps.
    """
    count = found.mean.size
    group, shift = np.arange(count), np.zeros(count)
    mean, variance = found.mean.copy(), found.spread**2
    first, second, step, odds = borders
    live = odds > 0
    while live.any():
        a, b = group[first], group[second]
        live &= a != b
        # meeting: wraps_first - wraps_second = -step
        apart = -step - shift[first] + shift[second]
        width = variance[a] + variance[b] + _LOOSE
        off = mean[a] - mean[b] - apart
        value = odds * _JUMP * np.exp(-(off**2) / (2 * width)) / np.sqrt(TAU * width)
        value = np.where(live, value, 0)
        n = int(np.argmax(value))
        if value[n] <= _MEET:
            break
        keep, join = a[n], b[n]
        weights = 1 / variance[[keep, join]]
        mean[keep] = (
            mean[keep] * weights[0] + (mean[join] + apart[n]) * weights[1]
        ) / weights.sum()
        variance[keep] = 1 / weights.sum()
        members = group == join
        group[members] = keep
        shift[members] -= apart[n]
    return Tied(np.rint(mean[group]) + shift, group, mean[group] + shift, np.sqrt(variance[group]))
