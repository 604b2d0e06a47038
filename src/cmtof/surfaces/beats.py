"""The beat of each surface: its whole wraps, and where these step within it.

The pooled higher phase lags behind the lower one by ``2 pi m (k_2 / k_1 - 2)`` after m wraps. The
unevenness of a surface moves both phases of a pixel alike, and does not count.
"""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter

from cmtof.compiled import njit
from cmtof.correlation import TAU
from cmtof.surfaces.field import CELL, Array, Field, Labels
from cmtof.surfaces.growing import Surfaces
from cmtof.surfaces.labels import depth_of_labels

_ENOUGH = 60.0  # information from which on a cell is turned back by its own phasors alone
_WIDER = (1, 2, 4)  # radii, cells, over which darker ones are turned back
_NEAR = 1.5  # width, px, of the Gaussian that finds the lobe of a pixel's phases
_TURNS = 3  # steps towards the likeliest unevenness of a pixel
_CUT = 20.0  # least gain, as a log-likelihood, of a part
_EDGE = 0.12  # and per cell of its border
_PART = 6  # its least size, cells
_APART = 0.7  # its least distance, wraps
_CUTS = 3  # rounds
_SIDES = 5  # of estimates of which cells lie on which side of a step
_MEDIAN = 0.455  # of chi^2 with one degree of freedom


class Cells(NamedTuple):
    """What the cells (h, w) of an image tell of the surface of most of their pixels."""

    owner: Labels  # -1 for none
    phasors: Array  # (2, h, w), turned back by the surface and by `residual`
    information: Array  # (2, h, w)
    residual: Array  # phase, rad at the lower frequency, by which it departs from the surface


class Beats(NamedTuple):
    """The beat of each surface (N,)."""

    offset: Array  # wraps to add
    noise: Array  # its standard deviation
    coherence: Array  # that it rests on


def pooled_beats(field: Field, cells: Cells, count: int) -> Beats:
    """Beat of each surface, pooled over its cells."""
    multiple = field.multiple
    total = np.zeros((2, count), complex)
    most = np.zeros((2, count))
    for one in range(2):
        total[one].real = sum_over(cells.owner, cells.phasors[one].real, count)[:count]
        total[one].imag = sum_over(cells.owner, cells.phasors[one].imag, count)[:count]
        most[one] = sum_over(cells.owner, cells.information[one], count)[:count]
    most = np.maximum(most, 1e-9)
    length = np.maximum(np.abs(total), 1e-9)
    wrap = TAU * field.excess
    beat = np.angle(total[1] * np.conj(total[0] / length[0]) ** multiple) / wrap
    variance = most / length**2
    noise = np.sqrt(variance[1] + multiple**2 * variance[0]) / abs(wrap)
    return Beats(beat, noise, (length / most).min(axis=0))


def cells_of_surfaces(field: Field, inner: Labels, surfaces: Surfaces) -> Cells:
    """Sums over the pixels of each cell, turned back by what both frequencies share."""
    shape = tuple(n // CELL for n in inner.shape)
    owner = _commonest(inner, np.empty(shape, np.int64))
    chosen = (np.kron(owner, np.ones((CELL, CELL), int)) == inner) & (inner >= 0)
    phasors = _turned_back(field, np.where(chosen, inner, -1), surfaces)
    sums = _sum_cells(np.where(chosen, phasors, 0))
    told = _sum_cells(np.where(chosen, field.information, 0).astype(float))
    near = _neighbourhoods(owner, sums, told)
    residual = common_phase(near, field.multiple)
    both = np.array([1, field.multiple])[:, None, None]
    return Cells(owner, sums * np.exp(-1j * both * residual), told, residual)


def _neighbourhoods(owner: Labels, sums: Array, told: Array) -> Array:
    """Phasors (2, h, w) of cells, of darker ones with those about them."""
    near = sums.copy()
    reached = told.sum(axis=0)
    for radius in _WIDER:
        weak = reached < _ENOUGH
        wider = _same(np.concatenate([sums, told]), owner, radius)
        near = np.where(weak, wider[:2], near)
        reached = np.where(weak, np.real(wider[2:]).sum(axis=0), reached)
    return near


def common_phase(phasors: Array, multiple: int) -> Array:
    """Likeliest r of phasors (2, ...) that are turned by r and by ``multiple`` r, rad."""
    low = np.angle(phasors[0])
    high = np.angle(phasors[1] * np.exp(-1j * multiple * low))
    size = np.abs(phasors)
    return low + size[1] * multiple * high / (size[0] + multiple**2 * size[1] + 1e-9)


def _turned_back(field: Field, label: Labels, surfaces: Surfaces) -> Array:
    """Phasors (2, H, W), turned back by surfaces and the likeliest unevenness of each pixel."""
    depth = np.nan_to_num(depth_of_labels(field, label, surfaces.parameters))
    uneven = uneven_phase(field, depth, np.append(surfaces.roughness, 0.0)[label])
    both = np.array([1, field.multiple])[:, None, None]
    return turned_phasors(field, depth) * np.exp(-1j * both * uneven)


def turned_phasors(field: Field, depth: Array) -> Array:
    """Phasors (2, H, W), turned back by a depth (H, W), m."""
    phasors = field.real + 1j * field.imaginary
    return phasors * np.exp(-1j * field.wavenumber[:, None, None] * depth)


def uneven_phase(field: Field, depth: Array, variance: Array) -> Array:
    """Likeliest phase (H, W), rad at the lower frequency, by which pixels depart from a depth.

    It is a Gaussian of this ``variance`` (H, W), rad^2, and moves both frequencies alike.
    """
    phasors = turned_phasors(field, depth)
    multiple = field.multiple
    stiff = field.information[0] + multiple**2 * field.information[1]
    near = [gaussian_filter(part, _NEAR) for part in (phasors[0].real, phasors[0].imag)]
    reach = variance * stiff / (1 + variance * stiff)
    uneven = reach * np.arctan2(near[1], near[0])
    for _ in range(_TURNS):
        low = (phasors[0] * np.exp(-1j * uneven)).imag
        high = (phasors[1] * np.exp(-1j * multiple * uneven)).imag
        uneven += (variance * (low + multiple * high) - uneven) / (1 + variance * stiff)
    return np.clip(uneven, -np.pi, np.pi)


def _sum_cells(images: Array) -> Array:
    """Sum of images (2, H, W) over cells."""
    _, height, width = images.shape
    return images.reshape(2, height // CELL, CELL, width // CELL, CELL).sum(axis=(2, 4))


@njit(cache=True, nogil=True)
def _commonest(label, out):  # pragma: no cover - compiled
    """The commonest label >= 0 of each cell (h, w), the smaller one of two; -1 for none."""
    for row in range(out.shape[0]):
        for column in range(out.shape[1]):
            cell = label[row * CELL : row * CELL + CELL, column * CELL : column * CELL + CELL]
            most = 0
            out[row, column] = -1
            for number in np.unique(cell):
                count = np.sum(cell == number)
                if number >= 0 and count > most:
                    most = count
                    out[row, column] = number
    return out


def sum_over(owner: Labels, image: Array, count: int) -> Array:
    """Sum (N + 1,) of an image over the cells of each surface, and over those of none."""
    return np.bincount(np.where(owner < 0, count, owner).ravel(), image.ravel(), count + 1)


def _same(images: Array, owner: Labels, radius: int) -> Array:
    """Sum of images (N, h, w) over the cells of the same surface within a radius."""
    height, width = owner.shape
    edge = (radius, radius)
    padded = np.pad(images, ((0, 0), edge, edge))
    around = np.pad(owner, radius, constant_values=-2)
    out = np.zeros_like(images)
    for y in range(2 * radius + 1):
        for x in range(2 * radius + 1):
            place = (slice(y, y + height), slice(x, x + width))
            out += np.where(around[place] == owner, padded[(slice(None), *place)], 0)
    return out


def cut_where_beats_step(field: Field, cells: Cells, parameters: Array) -> tuple[Labels, Array]:
    """Surface of each cell, and parameters (N, 6), those of surfaces whose beat steps cut in two.

    Two planes at whole wraps of distance have the same phases and grow as one. They are cut if that
    gains more log-likelihood than `_CUT`, and than `_EDGE` for each cell along the border.
    """
    owner = cells.owner
    lag, weight = _beats_of_cells(field, cells)
    for _ in range(_CUTS):
        count = len(parameters)
        upper, good = _two_sides(owner, lag, weight, count)
        new = count + np.cumsum(good) - 1
        index = np.where(owner < 0, count, owner)
        owner = np.where(upper & good[index], new[index], owner)
        parameters = np.concatenate([parameters, parameters[np.flatnonzero(good)]])
    return owner, parameters


def _beats_of_cells(field: Field, cells: Cells) -> tuple[Array, Array]:
    """Beat (h, w) of each cell, wraps, and its inverse variance by what neighbours differ."""
    wrap = TAU * field.excess
    multiple = field.multiple
    told = cells.information
    low, high = cells.phasors.imag / np.maximum(told, 1e-6)
    lag = (high - multiple * low) / wrap
    weight = wrap**2 * told[0] * told[1] / np.maximum(told[0] + multiple**2 * told[1], 1e-9)
    scatter = _scatter_of_neighbours(cells.owner, lag, weight)
    return lag, weight / scatter[np.where(cells.owner < 0, -1, cells.owner)]


def _scatter_of_neighbours(owner: Labels, lag: Array, weight: Array) -> Array:
    """Median chi^2 (N + 1,) of differences of neighbours within each surface, one at least."""
    squares = []
    of = []
    for axis in (0, 1):
        first, second = (np.delete(weight, end, axis) for end in (0, -1))
        same = np.diff(owner, axis=axis) == 0
        same &= (np.delete(owner, 0, axis) >= 0) & (np.minimum(first, second) > 0)
        both = first * second / np.maximum(first + second, 1e-12)
        squares.append((np.diff(lag, axis=axis) ** 2 * both)[same])
        of.append(np.delete(owner, 0, axis)[same])
    out = np.ones(int(owner.max(initial=-1)) + 2)
    number = np.concatenate(of)
    square = np.concatenate(squares)
    for one in np.unique(number):
        out[one] = max(np.median(square[number == one]) / _MEDIAN, 1.0)
    return out


def _two_sides(owner: Labels, lag: Array, weight: Array, count: int) -> tuple[Array, Array]:
    """Which cells lie on the upper side of a step, and which surfaces (N + 1,) are to be cut."""
    index = np.where(owner < 0, count, owner)
    middle = _side(owner, lag, weight, count).mean[index]
    apart = np.ones(owner.shape)
    radius = 1
    for _ in range(_SIDES):
        pull = _same((weight * (lag - middle) * apart)[None], owner, radius)[0]
        radius = 2
        upper = pull > 0
        low = _side(owner, lag, weight * ~upper, count)
        high = _side(owner, lag, weight * upper, count)
        middle = ((low.mean + high.mean) / 2)[index]
        apart = (high.mean - low.mean)[index]
    good = _worth(low, high, _border(index, upper, count))
    for side in (upper, ~upper):
        good &= sum_over(owner, side, count) >= _PART
    return upper, good & (np.arange(count + 1) < count)


class _Side(NamedTuple):
    """One side of each surface, one entry (N + 1,) each."""

    mean: Array  # beat, wraps
    known: Array  # inverse variance of that


def _side(owner: Labels, lag: Array, weight: Array, count: int) -> _Side:
    """Mean beat of one side of each surface, the last entry for cells of none."""
    known = np.maximum(sum_over(owner, weight, count), 1e-9)
    return _Side(sum_over(owner, weight * lag, count) / known, known)


def _worth(low: _Side, high: _Side, border: Array) -> Array:
    """Which surfaces gain enough by a cut along a border of that many cells (N + 1,)."""
    step = high.mean - low.mean
    gain = step**2 / (1 / low.known + 1 / high.known) / 2
    return (gain > np.maximum(_CUT, _EDGE * border)) & (np.abs(step) > _APART)


def _border(index: Labels, upper: Array, count: int) -> Array:
    """Length (N + 1,), cells, of the border between both sides of each surface."""
    out = np.zeros(count + 1)
    for axis in (0, 1):
        first = np.delete(index, 0, axis)
        crossed = (first == np.delete(index, -1, axis)) & np.diff(upper, axis=axis)
        out += np.bincount(first.ravel(), crossed.ravel(), count + 1)
    return out
