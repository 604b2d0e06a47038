"""Windows in which planes begin: their slopes by spectra, and the likeliest plane of each.

Within a window a plane's phases are ramps, so both spectra peak: at a slope nu, rad/px, and at
``(k_2 / k_1) nu``. Slopes that differ by whole turns per pixel look alike but for the beat.
"""

import numpy as np
from scipy.fft import fft, fftfreq, next_fast_len

from cmtof.compiled import njit
from cmtof.correlation import TAU
from cmtof.surfaces.field import CELL, Field
from cmtof.surfaces.fitting import refine, region_of_boxes
from cmtof.surfaces.shapes import BENT, PLANE
from cmtof.types import Array, Flags, Numbers

# Side of a window, distance to the next, side of the core whose spectrum is taken, all px, and how
# many times its bins are refined. Large ones come first: what is large should stay in one piece.
WINDOWS = ((64, 32, 32, 3), (32, 16, 16, 4), (16, 8, 12, 4), (12, 4, 8, 5))
_LEAST = 150.0  # information E below which a window starts nothing: its noise would fit as well
FREE = 0.7  # share of the cells of a window that must be without a surface
_ALIASES = 2  # whole turns per pixel tried to each side
_STEEPEST = 1.6  # largest slope, turns/px
_CANDIDATES = 4  # slopes out of all aliases that are fitted


def windows(
    field: Field, free: Flags, side: int, stride: int, core: int, finer: int
) -> tuple:
    """Top, left, side (N,) of windows on free cells, the clearest first, and slopes, rad/px."""
    height, width = np.array(field.cosine.shape) - side + 1
    top, left = np.mgrid[:height:stride, :width:stride].reshape(2, -1)
    inside = _sums(field.information.sum(axis=0, dtype=float), top, left, side)
    open_cells = _sums(free.astype(float), top // CELL, left // CELL, side // CELL)
    order = np.argsort(-inside, kind="stable")
    order = order[
        (inside[order] >= _LEAST) & (open_cells[order] >= FREE * (side // CELL) ** 2)
    ]
    corner = np.array([top[order], left[order]]) + (side - core) // 2
    slopes = spectral_slopes(field, *corner, core, finer)
    return top[order], left[order], np.full(order.size, side), *slopes


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
    slopes = np.empty((2, top.size))
    phasors = (field.real + 1j * field.imaginary).astype(np.complex64)
    squares = np.lib.stride_tricks.sliding_window_view(
        phasors, (side, side), axis=(1, 2)
    )
    batch = max(1, 2**19 // size**2)  # spectra that stay in the cache
    for start in range(0, top.size, batch):
        some = slice(start, start + batch)
        slopes[:, some] = _peaks(squares[:, top[some], left[some]], size, field.ratio)
    return slopes


def _peaks(squares: Array, size: int, ratio: float) -> Array:
    """Slopes (2, N), rad/px, at the joint peaks of spectra of that size of squares (2, N, h, h)."""
    whole = np.rint(fftfreq(size) * size)
    higher = np.rint(ratio * whole).astype(int) % size
    rows = fft(squares, size)  # before rows of zeros are added
    spectrum = np.asarray(fft(rows, size, axis=-2))
    power = spectrum.real**2 + spectrum.imag**2
    joint = power[0] + power[1][:, higher[:, None], higher]
    peak = np.array(np.divmod(joint.reshape(len(joint), -1).argmax(axis=1), size))
    return TAU * whole[peak] / size


@njit()
def plane_in_window(field, window, information):  # pragma: no cover - compiled
    """The likeliest plane of a window, out of all aliases of its slope, and its S."""
    beats, phase = _beats(field, window, information)
    size = np.abs(beats)
    best = -1.0
    plane = np.zeros(BENT)
    for _ in range(_CANDIDATES):
        alias = divmod(np.argmax(size), size.shape[1])
        size[alias] = -1
        slope = (
            window[3] + TAU * (alias[0] - _ALIASES),
            window[4] + TAU * (alias[1] - _ALIASES),
        )
        if max(abs(slope[0]), abs(slope[1])) > TAU * _STEEPEST:
            continue
        z = _depth_of_beat(field, np.angle(beats[alias]), phase)
        fit, there = _climb_outwards(field, _plane(field, window, z, slope), window)
        if there and fit.likelihood > best:
            best = fit.likelihood
            plane = fit.q
    return plane, best


@njit()
def _depth_of_beat(field, beat, phase):  # pragma: no cover - compiled
    """Depth, m, with that phase nearest to that of a beat, both rad, within the limits."""
    k = field.wavenumber
    nearest, farthest = field.limits
    synthetic = k[1] - np.rint(k[1] / k[0]) * k[0]
    repeat = TAU / abs(synthetic)
    z = nearest + (beat / synthetic - nearest) % repeat
    if z > farthest:
        z = farthest if z - farthest < nearest - (z - repeat) else nearest
    here = phase / k[0]
    return max(here + field.period * np.rint((z - here) / field.period), field.period)


@njit()
def _beats(field, window, information):  # pragma: no cover - compiled
    """Beat summed over the blocks for each alias (A, A), and the lower phase at the centre."""
    side = window[2]
    count = 8 if side >= 32 and information > 4 * _LEAST else 4
    sums = _blocks(field, window, count)
    ratio = field.wavenumber[1] / field.wavenumber[0]
    multiple = np.rint(ratio)
    unit = sums[0] / np.maximum(np.abs(sums[0]), 1e-9)
    beats = sums[1] * np.conj(unit**multiple)
    # a whole turn of the lower phase marks the higher one by this
    aliased = _sums_of_aliases(beats, (ratio - multiple) * TAU, side)
    middle = slice(count // 2 - 1, count // 2 + 1)
    return aliased, np.angle(np.sum(sums[0, middle, middle]))


@njit()
def _sums_of_aliases(beats, excess, side):  # pragma: no cover - compiled
    """Sum of the beats of blocks for each alias (A, A): turned back by its whole turns."""
    aliases = np.arange(-_ALIASES, _ALIASES + 1)
    out = np.zeros((aliases.size, aliases.size), np.complex128)
    block = side // len(beats)
    for i, j in np.ndindex(beats.shape):
        y = (i + 0.5) * block - 0.5 - side // 2
        x = (j + 0.5) * block - 0.5 - side // 2
        for a, down in enumerate(aliases):
            for b, right in enumerate(aliases):
                turn = excess * (down * y + right * x)
                out[a, b] += beats[i, j] * np.exp(-1j * turn)
    return out


@njit()
def _blocks(field, window, count):  # pragma: no cover - compiled
    """Sums of both phasors over count x count blocks of a window, turned back by its slope."""
    top, left, side, down, right = window
    sums = np.zeros((2, count, count), np.complex128)
    for f in range(2):
        ratio = field.wavenumber[f] / field.wavenumber[0]
        real = field.real[f, top : top + side, left : left + side]
        imaginary = field.imaginary[f, top : top + side, left : left + side]
        _add_blocks(sums[f], real, imaginary, ratio * down, ratio * right)
    return sums


@njit()
def _add_blocks(sums, real, imaginary, down, right):  # pragma: no cover - compiled
    """Add the phasors of a square to its blocks, turned back by a slope, rad/px."""
    side = len(real)
    block = side // len(sums)
    across = np.exp(-1j * right * (np.arange(side) - side // 2))
    for y in range(side):
        turn = np.exp(-1j * down * (y - side // 2))
        for j in range(len(sums)):
            part = 0j
            for x in range(j * block, j * block + block):
                part += complex(real[y, x], imaginary[y, x]) * across[x]
            sums[y // block, j] += part * turn


@njit()
def _plane(field, window, z, slope):  # pragma: no cover - compiled
    """The plane through a depth in the middle of a window with slopes, rad/px, of its phase."""
    row = window[0] + window[2] // 2
    column = window[1] + window[2] // 2
    u = field.u[column : column + 2]
    v = field.v[row : row + 2]
    cosine = field.cosine[row : row + 2, column : column + 2]
    fall = 1 / (field.wavenumber[0] * z * z)  # of 1 / z per radian
    here = 1 / z / cosine[0, 0]
    below = (1 / z - fall * slope[0]) / cosine[1, 0]
    beside = (1 / z - fall * slope[1]) / cosine[0, 1]
    q = np.zeros(BENT)
    q[0] = (beside - here) / (u[1] - u[0])
    q[1] = (below - here) / (v[1] - v[0])
    q[2] = here - q[0] * u[0] - q[1] * v[0]
    return q


@njit()
def _climb_outwards(field, q, window):  # pragma: no cover - compiled
    """Fit a plane to the middle of a window first, then on outwards, for steep phases bend.

    And whether it got there.
    """
    top, left, side, _, _ = window
    core = 6
    while True:
        core = min(core, side)
        y = top + (side - core) // 2
        x = left + (side - core) // 2
        told = np.sum(field.information[0, y : y + core, x : x + core])
        if core == side or told > 100:
            region = region_of_boxes(np.array([[y, y + core, x, x + core]]))
            steps = 2 if core < side else 3
            fit = refine(field, region, q, PLANE, steps, np.int64(0))
            if core == side or fit.likelihood < 0.4 * fit.most:
                return fit, core == side
            q = fit.q
        core = int(core * 1.5)
