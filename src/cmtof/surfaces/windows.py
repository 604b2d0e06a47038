"""Planes in windows: where surfaces begin.

Within a window a plane's phases are ramps, so both spectra peak: at a slope nu, rad/px, and at
``(k_2 / k_1) nu``. Slopes that differ by whole turns per pixel look alike but for the beat. All is
counted from the middle of a window, so that a mirrored image has mirrored planes.
"""

from typing import NamedTuple

import numpy as np
from scipy.fft import fft, fftfreq, next_fast_len

from cmtof.compiled import njit
from cmtof.correlation import TAU
from cmtof.surfaces import fitting
from cmtof.surfaces.field import CELL, Array, Field, Labels, Mask


class Kind(NamedTuple):
    """Size of windows, px."""

    side: int
    stride: int  # distance to the next
    core: int  # side of the square whose spectrum is taken
    finer: int  # how many times its bins are refined


# Large ones come first: what is large should stay in one piece.
KINDS = (Kind(64, 32, 32, 3), Kind(32, 16, 16, 4), Kind(16, 8, 12, 4), Kind(12, 4, 8, 5))

FREE = 0.7  # share of the cells of a window that must be without a surface
_LEAST = 150.0  # information E below which a window starts nothing: its noise would fit as well
_ALIASES = 2  # whole turns per pixel tried to each side
_STEEPEST = 1.6  # largest slope, turns/px
_CANDIDATES = 4  # slopes out of all aliases that are fitted
_BLOCK = 4  # side, px, of the blocks of a fit
_BRIGHT = 100.0  # information of the middle of a window from which on it is fitted first
_LOST = 0.4  # share S / E below which a fit is not pursued


def windows(field: Field, free: Mask, kind: Kind) -> Array:
    """Windows on free cells, the clearest first: top, left, side and slopes, rad/px (N, 5)."""
    ends = (slice(0, n - kind.side + 1, kind.stride) for n in field.cosine.shape)
    top, left = np.mgrid[tuple(ends)].reshape(2, -1)
    inside = _sums(field.information.sum(axis=0, dtype=float), top, left, kind.side)
    cells = max(kind.side // CELL, 1)  # that lie within a window
    open_cells = _sums(free.astype(float), -(-top // CELL), -(-left // CELL), cells)
    order = np.argsort(-inside, kind="stable")
    order = order[(inside[order] >= _LEAST) & (open_cells[order] >= FREE * cells**2)]
    margin = (kind.side - kind.core) // 2
    corner = top[order] + margin, left[order] + margin
    slopes = spectral_slopes(field, *corner, kind.core, kind.finer)
    return np.stack([top[order], left[order], np.full(order.size, kind.side), *slopes], axis=1)


def _sums(image: Array, top: Labels, left: Labels, side: int) -> Array:
    """Sum (N,) of an image (H, W) over squares."""
    total = np.pad(image.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    bottom = top + side
    right = left + side
    return total[bottom, right] - total[top, right] - total[bottom, left] + total[top, left]


def spectral_slopes(field: Field, top: Labels, left: Labels, side: int, finer: int) -> Array:
    """Slopes (2, N) down and right, rad/px, at the joint peak of both spectra of each square."""
    size = int(next_fast_len(finer * side) or 1)
    whole = np.rint(fftfreq(size) * size)
    higher = np.rint(field.wavenumber[1] / field.wavenumber[0] * whole).astype(int) % size
    phasors = (field.real + 1j * field.imaginary).astype(np.complex64)
    squares = np.lib.stride_tricks.sliding_window_view(phasors, (side, side), axis=(1, 2))
    batch = max(1, 2**19 // size**2)  # spectra that stay in the cache
    peaks = [np.empty((2, 0), int)]
    for start in range(0, top.size, batch):
        some = slice(start, start + batch)
        peaks.append(_joint_peaks(squares[:, top[some], left[some]], size, higher))
    return TAU * whole[np.concatenate(peaks, axis=1)] / size


def _joint_peaks(squares: Array, size: int, higher: Labels) -> Labels:
    """Row and column (2, N) at which both spectra of squares (2, N, side, side) peak together."""
    rows = fft(squares, size)  # before rows of zeros are added
    spectrum = np.asarray(fft(rows, size, axis=-2))
    power = spectrum.real**2 + spectrum.imag**2
    joint = power[0] + power[1][:, higher[:, None], higher]
    return np.array(np.divmod(joint.reshape(len(joint), -1).argmax(axis=1), size))


@njit(cache=True, nogil=True)
def plane_in_window(field, window, limits):  # pragma: no cover - compiled
    """The likeliest plane of a window, out of all aliases of its slope, and its sums."""
    beats, angle = _beats(field, window)
    size = np.abs(beats)
    blocks = _blocks_of_window(window)
    plane = np.zeros(fitting.BENT)
    best = np.zeros(54)
    for _ in range(_CANDIDATES):
        at = np.argmax(size)
        turns = at // size.shape[1], at % size.shape[1]
        size[turns] = -1
        start, steep = _start(field, window, turns, (np.angle(beats[turns]), angle), limits)
        if steep:
            continue
        q, sums = _climbed(field, start, blocks)
        if fitting.likelihood(sums) > fitting.likelihood(best):
            plane = q
            best = sums
    return plane, best


@njit(cache=True, nogil=True)
def _start(field, window, turns, phases, limits):  # pragma: no cover - compiled
    """Plane whose slopes are off by turns per pixel, by its beat and lower phase; if too steep."""
    down = window[3] + 2 * np.pi * (turns[0] - _ALIASES)
    right = window[4] + 2 * np.pi * (turns[1] - _ALIASES)
    # the middle lies between pixels, where a slope of a turn per pixel is half a turn
    middle = phases[1] + np.pi * (turns[0] + turns[1])
    z = _depth_of_beat(field, phases[0], middle, limits)
    steep = max(abs(down), abs(right)) > 2 * np.pi * _STEEPEST
    return _plane(field, window, z, down, right), steep


@njit(cache=True, nogil=True)
def _depth_of_beat(field, beat, angle, limits):  # pragma: no cover - compiled
    """Depth, m, of a phase of the lower frequency that is nearest to that of a beat, in limits."""
    wavenumber = field[3]
    wrap = 2 * np.pi / wavenumber[0]
    synthetic = wavenumber[1] - np.rint(wavenumber[1] / wavenumber[0]) * wavenumber[0]
    period = 2 * np.pi / abs(synthetic)
    z = limits[0] + (beat / synthetic - limits[0]) % period
    if z > limits[1]:
        z = limits[1] if z - limits[1] < limits[0] - (z - period) else limits[0]
    z = angle / wavenumber[0] + wrap * np.rint((z - angle / wavenumber[0]) / wrap)
    return max(z, wrap)


@njit(cache=True, nogil=True)
def _beats(field, window):  # pragma: no cover - compiled
    """Beat summed over the blocks for each alias (A, A), and the lower phase in the middle."""
    side = int(window[2])
    sums = _block_phasors(field, window, 8 if side >= 32 else 4)
    count = sums.shape[1]
    multiple = np.rint(field[3][1] / field[3][0])
    excess = (field[3][1] / field[3][0] - multiple) * 2 * np.pi  # a turn's mark on the higher
    out = np.zeros((2 * _ALIASES + 1, 2 * _ALIASES + 1), np.complex128)
    for i in range(count):
        for j in range(count):
            low = sums[0, i, j]
            beat = sums[1, i, j] * np.conj((low / max(abs(low), 1e-9)) ** multiple)
            y = (i + 0.5 - count / 2) * side / count
            x = (j + 0.5 - count / 2) * side / count
            _add_beat(out, beat, excess * y, excess * x)
    half = count // 2
    return out, np.angle(np.sum(sums[0, half - 1 : half + 1, half - 1 : half + 1]))


@njit(cache=True, nogil=True)
def _add_beat(out, beat, down, right):  # pragma: no cover - compiled
    """Add the beat of a block, turned back by each alias."""
    for a in range(len(out)):
        for b in range(len(out)):
            out[a, b] += beat * np.exp(-1j * ((a - _ALIASES) * down + (b - _ALIASES) * right))


@njit(cache=True, nogil=True)
def _block_phasors(field, window, count):  # pragma: no cover - compiled
    """Sums of both phasors over count x count blocks, turned back by the slopes of a window."""
    top = int(window[0])
    left = int(window[1])
    side = int(window[2])
    steps = np.arange(side) - (side - 1) / 2
    sums = np.zeros((2, count, count), np.complex128)
    for f in range(2):
        ratio = field[3][f] / field[3][0]
        down = np.exp(-1j * ratio * window[3] * steps)
        right = np.exp(-1j * ratio * window[4] * steps)
        for y in range(side):
            for x in range(side):
                p = complex(field[0][f, top + y, left + x], field[1][f, top + y, left + x])
                sums[f, y * count // side, x * count // side] += p * right[x] * down[y]
    return sums


@njit(cache=True, nogil=True)
def _plane(field, window, z, down, right):  # pragma: no cover - compiled
    """The plane through a depth in the middle of a window, slopes, rad/px, of the lower phase."""
    middle = (window[2] - 1) / 2
    pitch_u = field[5][1] - field[5][0]
    pitch_v = field[6][1] - field[6][0]
    u = field[5][int(window[1])] + middle * pitch_u
    v = field[6][int(window[0])] + middle * pitch_v
    secant = np.sqrt(1 + u * u + v * v)
    fall = 1 / (field[3][0] * z * z)  # of 1 / z per radian
    q = np.zeros(fitting.BENT)
    q[0] = u / secant / z - secant * fall * right / pitch_u
    q[1] = v / secant / z - secant * fall * down / pitch_v
    q[2] = secant / z - q[0] * u - q[1] * v
    return q


@njit(cache=True, nogil=True)
def _blocks_of_window(window):  # pragma: no cover - compiled
    """Rectangles (N, 4) of a window, with how many blocks each lies off its middle."""
    count = int(window[2]) // _BLOCK
    blocks = np.empty((count * count, 5), np.int64)
    for i in range(count):
        for j in range(count):
            y = int(window[0]) + i * _BLOCK
            x = int(window[1]) + j * _BLOCK
            off = max(abs(2 * i + 1 - count), abs(2 * j + 1 - count))
            blocks[i * count + j] = np.array([y, y + _BLOCK, x, x + _BLOCK, off])
    return blocks


@njit(cache=True, nogil=True)
def _climbed(field, q, blocks):  # pragma: no cover - compiled
    """Fit a plane to the middle of a window first, then on outwards, for steep phases bend."""
    nothing = np.zeros((1, 1), np.int32)
    rows = fitting.sum_blocks(field, nothing, fitting.EVERY, q, blocks)
    widest = np.max(blocks[:, 4])
    core = 1
    while core < widest:
        inner = rows[blocks[:, 4] <= core]
        if np.sum(inner[:, 6]) > _BRIGHT:
            fit = fitting.climb(field, inner, q, fitting.PLANE, fitting.CLIMBS)
            q = fit[0]
            if fitting.likelihood(fit[1]) < _LOST * fitting.expected(fit[1]):
                return q, np.zeros(54)
        core = 2 * core + 1
    q = fitting.climb(field, rows, q, fitting.PLANE, fitting.CLIMBS)[0]
    rows = fitting.sum_blocks(field, nothing, fitting.EVERY, q, blocks)
    return fitting.climb(field, rows, q, fitting.PLANE, fitting.CLIMBS)
