"""Planes begin in windows and grow from cell to cell; every cell takes the likeliest beside it.

Within a window a plane's phases are ramps, so both spectra peak: at a slope nu, rad/px, and at
``(k_2 / k_1) nu``. Slopes that differ by whole turns per pixel look alike but for the beat.
"""

import numpy as np
from scipy.fft import fft, fftfreq, next_fast_len

from cmtof.compiled import njit
from cmtof.correlation import TAU
from cmtof.surfaces.field import CELL, Field, pixels_of_cells
from cmtof.surfaces.fitting import (
    BENT,
    EVERY,
    PLANE,
    boxes_of_cells,
    cell_likelihood,
    fitted,
    frequency_sums,
    possible,
    refine,
    select,
)
from cmtof.surfaces.roughness import sum_cells
from cmtof.types import Array, Flags, Numbers

# Side of a window, distance to the next, side of the core whose spectrum is taken, all px, and how
# many times its bins are refined. Large ones come first: what is large should stay in one piece.
WINDOWS = ((64, 32, 32, 3), (32, 16, 16, 4), (16, 8, 12, 4), (12, 4, 8, 5))

# Share S / E that a plane must reach
_START = 0.75  # to begin in a window,
_JOIN = 0.6  # to grow into a cell,
_STAY = 0.5  # and to keep it.
GAIN = 15.0  # in S from which on a surface counts as bent
ROUGHEST = 0.9  # variance, rad^2, of the depths about a surface, up to which it is one
_ROUGHER = 0.1  # by which it may grow beyond that of the window in which it began
_SURE = 6.0  # deviations of S from noise for a rough surface to begin
_ALIKE = (
    0.08,
    2.0,
)  # tolerance of its coherence at the higher frequency, and in deviations
_LEAST = 150.0  # information E below which a window starts nothing: its noise would fit as well
_FREE = 0.7  # share of the cells of a window that must be without a surface
_ALIASES = 2  # whole turns per pixel tried to each side
_STEEPEST = 1.6  # largest slope, turns/px
_CANDIDATES = 4  # slopes out of all aliases that are fitted
_STEPS = np.int64(2)  # of a fit
_CELLS = np.int64(100)  # of a surface that it looks at
_BESIDE = ((1, 0), (-1, 0), (0, 1), (0, -1))  # steps down and right
_ROUNDS = 6  # of reassignment
_NEIGHBOURLY = 3.0  # gain in S per neighbour in the same surface


def grown_surfaces(
    field: Field, *, gain: float = GAIN, roughest: float = ROUGHEST
) -> tuple[Numbers, Array]:
    """Owner of each cell, -1 for none, and the surfaces (N, 7) grown from windows.

    Their parameters, and their roughness: the variance of pixels about them, rad^2; those that
    begin rougher than ``roughest`` are none.
    """
    information = sum_cells(field.information.astype(float))
    label = np.zeros((1, 1), np.int32)  # fits look at whole cells
    owner = np.full(information.shape[1:], -1)
    surfaces = np.zeros((0, BENT + 1))
    for kind in WINDOWS:
        start = windows(field, owner < 0, *kind)
        added = _grow(
            field, label, start, information, gain, roughest, owner, len(surfaces)
        )
        surfaces = np.concatenate([surfaces, added])
    for turn in range(_ROUNDS):
        owner = _reassigned(field, owner, surfaces, information)
        if turn % 2:
            label = pixels_of_cells(owner)
            surfaces, _ = fitted(field, label, surfaces, (_STEPS, _CELLS), gain)
    return owner, surfaces


@njit()
def _grow(
    field, label, start, information, gain, roughest, owner, count
):  # pragma: no cover
    """Grow surfaces from windows, numbered from ``count`` on; return their parameters."""
    rows, columns = owner.shape
    stamp = np.zeros((rows, columns), np.int64)
    surfaces = np.zeros((start[0].size, BENT + 1))
    new = 0
    for n, window in enumerate(zip(*start)):  # noqa: B905 - unknown to Numba
        side = window[2] // CELL
        y0 = window[0] // CELL
        x0 = window[1] // CELL
        told = information[:, y0 : y0 + side, x0 : x0 + side].sum()
        free = (owner[y0 : y0 + side, x0 : x0 + side] < 0).sum()
        if free < _FREE * side * side:
            continue
        q, likelihood = plane_in_window(field, label, window, told)
        rough = 0.0
        if likelihood < _START * told:
            rough = _roughness(field, q, window, roughest) if likelihood > 0 else 0.0
            if rough == 0:
                continue
        most = min(rough + _ROUGHER, roughest)
        region = np.empty(rows * columns, np.int64)
        size = 0
        for y in range(y0, y0 + side):
            for x in range(x0, x0 + side):
                if owner[y, x] < 0 and _explains(field, q, rough, information, y, x):
                    region[size] = y * columns + x
                    stamp[y, x] = n + 1
                    size += 1
        if size < 0.6 * free:
            continue
        before = 0
        while size > before:
            before = size
            boxes, weight = boxes_of_cells(region[:size], columns, _CELLS)
            fit = select(field, label, EVERY, q, boxes, _STEPS, gain, weight)
            if possible(field, fit[0], boxes):
                q = fit[0]
            if rough > 0:
                rough = min(_scatter(frequency_sums(field, q, boxes)), most)
            size = _spread(
                field, q, rough, owner, stamp, n + 1, region, size, information
            )
        if size >= 0.6 * side * side:
            owner.ravel()[region[:size]] = count + new
            surfaces[new, :BENT] = q
            surfaces[new, BENT] = rough
            new += 1
    return surfaces[:new]


@njit(inline="always")
def _explains(field, q, rough, information, y, x):  # pragma: no cover - compiled
    """Whether a surface may grow into a cell."""
    return cell_likelihood(field, q, y, x) > _JOIN * _expected(rough, information, y, x)


@njit(inline="always")
def _expected(rough, information, y, x):  # pragma: no cover - compiled
    """S that a surface of this roughness has in a cell on average."""
    return (
        np.exp(-rough / 2) * information[0, y, x]
        + np.exp(-2 * rough) * information[1, y, x]
    )


@njit()
def _scatter(sums):  # pragma: no cover - compiled
    """Variance, rad^2, of depths about a surface by its coherence at the lower frequency."""
    return -2 * np.log(min(max(sums[0, 0] / max(sums[1, 0], 1e-9), 0.05), 1.0))


@njit()
def _roughness(field, q, window, roughest):  # pragma: no cover - compiled
    """Roughness of a window if both frequencies agree on it, else zero.

    A Gaussian of variance r costs one frequency exp(-r / 2), twice that frequency exp(-2 r).
    """
    top, left, side, _, _ = window
    sums = frequency_sums(field, q, np.array([[top, top + side, left, left + side]]))
    rough = _scatter(sums)
    most = max(sums[1, 1], 1e-9)
    off = sums[0, 1] / most - np.exp(-2 * rough)
    tolerance = _ALIKE[0] + _ALIKE[1] / np.sqrt(most)
    sure = sums[0].sum() > _SURE * np.sqrt(sums[1].sum()) and abs(off) < tolerance
    return rough if sure and rough < roughest else 0.0


@njit()
def _spread(
    field, q, rough, owner, stamp, mark, region, size, information
):  # pragma: no cover
    """Add free cells beside the region that the surface explains, until it has doubled."""
    rows, columns = owner.shape
    goal = max(2 * size, size + 8)
    i = 0
    while i < size and size < goal:
        for dy, dx in _BESIDE:
            y = region[i] // columns + dy
            x = region[i] % columns + dx
            inside = 0 <= y < rows and 0 <= x < columns
            if not inside or owner[y, x] >= 0 or stamp[y, x] == mark:
                continue
            if _explains(field, q, rough, information, y, x):
                stamp[y, x] = mark
                region[size] = y * columns + x
                size += 1
        i += 1
    return size


@njit()
def _reassigned(field, owner, surfaces, information):  # pragma: no cover - compiled
    """Give each cell the likeliest of the surfaces about it, or none."""
    rows, columns = owner.shape
    out = owner.copy()
    for y in range(rows):
        for x in range(columns):
            found = around(owner, y, x)
            if found.size == 0 or (found.size == 1 and owner[y, x] == found[0]):
                continue
            best = -np.inf
            at = -1
            for n in found:
                value = cell_likelihood(field, surfaces[n], y, x)
                for dy, dx in _BESIDE:
                    a = y + dy
                    b = x + dx
                    if 0 <= a < rows and 0 <= b < columns and owner[a, b] == n:
                        value += _NEIGHBOURLY
                if value > best:
                    best = value
                    at = n
            told = _expected(surfaces[at, 6], information, y, x)
            out[y, x] = at if best >= _STAY * told - np.sqrt(told) else -1
    return out


@njit()
def around(owner, y, x):  # pragma: no cover - compiled
    """The different owners of a cell and its eight neighbours."""
    near = np.unique(owner[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2])
    return near[near >= 0]


def windows(
    field: Field, free: Flags, side: int, stride: int, core: int, finer: int
) -> tuple:
    """Top, left, side (N,) of windows on free cells, the clearest first, and slopes, rad/px."""
    ends = (slice(0, n - side + 1, stride) for n in field.cosine.shape)
    top, left = np.mgrid[tuple(ends)].reshape(2, -1)
    inside = _sums(field.information.sum(axis=0, dtype=float), top, left, side)
    cells = side // CELL
    open_cells = _sums(free.astype(float), top // CELL, left // CELL, cells)
    order = np.argsort(-inside, kind="stable")
    order = order[(inside[order] >= _LEAST) & (open_cells[order] >= _FREE * cells**2)]
    top = top[order]
    left = left[order]
    margin = (side - core) // 2
    slopes = spectral_slopes(field, top + margin, left + margin, core, finer)
    return top, left, np.full(top.size, side), *slopes


def _sums(image: Array, top: Numbers, left: Numbers, side: int) -> Array:
    """Sum (N,) of an image (H, W) over squares."""
    total = np.pad(image.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    bottom = top + side
    edge = left + side
    return (
        total[bottom, edge] - total[top, edge] - total[bottom, left] + total[top, left]
    )


def spectral_slopes(
    field: Field, top: Numbers, left: Numbers, side: int, finer: int
) -> Array:
    """Slopes (2, N) down and right, rad/px, at the joint peak of both spectra of each square."""
    size = int(next_fast_len(finer * side) or 1)
    whole = np.rint(fftfreq(size) * size)
    higher = np.rint(field.ratio * whole).astype(int) % size
    slopes = np.empty((2, top.size))
    phasors = (field.real + 1j * field.imaginary).astype(np.complex64)
    squares = np.lib.stride_tricks.sliding_window_view(
        phasors, (side, side), axis=(1, 2)
    )
    batch = max(1, 2**19 // size**2)  # spectra that stay in the cache
    for start in range(0, top.size, batch):
        some = slice(start, start + batch)
        rows = fft(
            squares[:, top[some], left[some]], size
        )  # before rows of zeros are added
        spectrum = np.asarray(fft(rows, size, axis=-2))
        power = spectrum.real**2 + spectrum.imag**2
        joint = power[0] + power[1][:, higher[:, None], higher]
        peak = np.array(np.divmod(joint.reshape(len(joint), -1).argmax(axis=1), size))
        slopes[:, some] = TAU * whole[peak] / size
    return slopes


@njit()
def plane_in_window(field, label, window, information):  # pragma: no cover - compiled
    """The likeliest plane of a window, out of all aliases of its slope, and its S."""
    top, left, side, down, right = window
    k = field.wavenumber
    nearest, farthest = field.limits
    beats, angle = _beats(field, window, information)
    size = np.abs(beats)
    best = -1.0
    plane = np.zeros(BENT)
    synthetic = k[1] - np.rint(k[1] / k[0]) * k[0]
    repeat = TAU / abs(synthetic)
    here = angle / k[0]
    for _ in range(_CANDIDATES):
        a, b = divmod(np.argmax(size), size.shape[1])
        size[a, b] = -1
        fall = down + TAU * (a - _ALIASES)
        lean = right + TAU * (b - _ALIASES)
        if max(abs(fall), abs(lean)) > TAU * _STEEPEST:
            continue
        z = nearest + (np.angle(beats[a, b]) / synthetic - nearest) % repeat
        if z > farthest:
            z = farthest if z - farthest < nearest - (z - repeat) else nearest
        z = max(here + field.period * np.rint((z - here) / field.period), field.period)
        q = _plane(field, top + side // 2, left + side // 2, z, fall, lean)
        q, likelihood, whole = _climbed(field, label, q, top, left, side)
        if whole and likelihood > best:
            best = likelihood
            plane = q
    return plane, best


@njit()
def _beats(field, window, information):  # pragma: no cover - compiled
    """Beat summed over the blocks for each alias (A, A), and the lower phase at the centre."""
    side = window[2]
    count = 8 if side >= 32 and information > 4 * _LEAST else 4
    sums = _blocks(field, window, count)
    ratio = field.wavenumber[1] / field.wavenumber[0]
    multiple = np.rint(ratio)
    excess = (ratio - multiple) * TAU  # a turn's mark on the higher
    aliases = np.arange(-_ALIASES, _ALIASES + 1)
    out = np.zeros((aliases.size, aliases.size), np.complex128)
    block = side // count
    for i in range(count):
        for j in range(count):
            low = sums[0, i, j]
            unit = low / max(abs(low), 1e-9)
            beat = sums[1, i, j] * np.conj(unit**multiple)
            y = (i + 0.5) * block - 0.5 - side // 2
            x = (j + 0.5) * block - 0.5 - side // 2
            for a, down in enumerate(aliases):
                for b, right in enumerate(aliases):
                    out[a, b] += beat * np.exp(-1j * (excess * (down * y + right * x)))
    middle = slice(count // 2 - 1, count // 2 + 1)
    return out, np.angle(np.sum(sums[0, middle, middle]))


@njit()
def _blocks(field, window, count):  # pragma: no cover - compiled
    """Sums of both phasors over count x count blocks of a window, turned back by its slope."""
    top, left, side, down, right = window
    block = side // count
    sums = np.zeros((2, count, count), np.complex128)
    for f in range(2):
        real = field.real[f, top:, left:]
        imaginary = field.imaginary[f, top:, left:]
        ratio = field.wavenumber[f] / field.wavenumber[0]
        across = np.exp(-1j * ratio * right * (np.arange(side) - side // 2))
        for y in range(side):
            turn = np.exp(-1j * ratio * down * (y - side // 2))
            for j in range(count):
                part = 0j
                for x in range(j * block, j * block + block):
                    part += complex(real[y, x], imaginary[y, x]) * across[x]
                sums[f, y // block, j] += part * turn
    return sums


@njit()
def _plane(field, row, column, z, down, right):  # pragma: no cover - compiled
    """The plane through a depth at a pixel with slopes, rad/px, of the lower phase."""
    u = field.u[column : column + 2]
    v = field.v[row : row + 2]
    cosine = field.cosine[row : row + 2, column : column + 2]
    fall = 1 / (field.wavenumber[0] * z * z)  # of 1 / z per radian
    here = 1 / z / cosine[0, 0]
    below = (1 / z - fall * down) / cosine[1, 0]
    beside = (1 / z - fall * right) / cosine[0, 1]
    q = np.zeros(BENT)
    q[0] = (beside - here) / (u[1] - u[0])
    q[1] = (below - here) / (v[1] - v[0])
    q[2] = here - q[0] * u[0] - q[1] * v[0]
    return q


@njit()
def _climbed(field, label, q, top, left, side):  # pragma: no cover - compiled
    """Fit a plane to the middle of a window first, then on outwards, for steep phases bend."""
    core = 6
    while True:
        core = min(core, side)
        margin = (side - core) // 2
        y = top + margin
        x = left + margin
        box = np.array([[y, y + core, x, x + core]])
        if (
            core == side
            or np.sum(field.information[0, y : y + core, x : x + core]) > 100
        ):
            fit = refine(
                field, label, EVERY, q, box, PLANE, 2 if core < side else 3, np.int64(0)
            )
            q = fit[0]
            if core == side or fit[1] < 0.4 * fit[2]:
                return q, fit[1], core == side
        core = int(core * 1.5)
