"""Where surfaces may begin: windows, the slope that their phases show, and a plane for each.

Within a window a plane's phases are ramps, so both spectra peak: at a slope nu, rad/px, at the
lower frequency, and at ``(k_2 / k_1) nu`` at the higher one. Slopes that differ by whole turns per
pixel look alike at the lower frequency; at the higher one, and in the beat, they do not quite.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cmtof.correlation import TAU
from cmtof.surfaces.field import CELL, Field
from cmtof.surfaces.kernels import BENT, PLANE, refine

WINDOWS = ((64, 32, 32, 3), (32, 16, 16, 4), (16, 8, 12, 4), (12, 4, 8, 5))
"""Side of a window, distance to the next, side of the core whose spectrum is taken, all px, and how
many times its bins are refined: large ones first, for what is large should stay in one piece."""

LEAST = 150.0
"""Information E below which a window starts nothing: its noise would fit as well."""

FREE = 0.7
"""Share of a window's cells that must be without a surface."""

_ALIASES = 2
"""Whole turns per pixel, to each side, that are tried."""

_STEEPEST = 1.6
"""Largest slope, turns per pixel."""

_CANDIDATES = 4
"""Slopes out of all aliases that are fitted."""


class Windows(NamedTuple):
    """Windows to begin in, best first."""

    top: NDArray[np.int64]
    left: NDArray[np.int64]
    side: NDArray[np.int64]
    down: NDArray[np.float64]
    """Slope at the lower frequency towards the next row, rad/px, but for whole turns."""
    right: NDArray[np.float64]
    """The same towards the next column."""


def windows(
    field: Field, free: NDArray[np.bool_], side: int, stride: int, core: int, finer: int
) -> Windows:
    """Windows of one kind that are still free and know enough, by what they know.

    Parameters
    ----------
    field : Field
    free : ndarray of bool, shape (h, w)
        Cells without a surface.
    side, stride, core, finer : int
        See `WINDOWS`.
    """
    top, left = (
        places.ravel()
        for places in np.meshgrid(
            *(np.arange(0, n - side + 1, stride) for n in field.cosine.shape), indexing="ij"
        )
    )
    inside = _sums(field.information.sum(axis=0, dtype=float), top, left, side)
    cells = max(side // CELL, 1)
    open_cells = _sums(free.astype(float), top // CELL, left // CELL, cells)
    order = np.argsort(-inside, kind="stable")
    order = order[(inside[order] >= LEAST) & (open_cells[order] >= FREE * cells**2)]
    top, left = top[order], left[order]
    margin = (side - core) // 2
    down, right = spectral_slopes(field, top + margin, left + margin, core, finer)
    return Windows(top, left, np.full(top.size, side), down, right)


def _sums(
    image: NDArray[np.float64], top: NDArray[np.int64], left: NDArray[np.int64], side: int
) -> NDArray[np.float64]:
    """Sum (N,) of an image (H, W) over squares."""
    total = np.zeros((image.shape[0] + 1, image.shape[1] + 1))
    total[1:, 1:] = image.cumsum(axis=0).cumsum(axis=1)
    bottom, edge = top + side, left + side
    return total[bottom, edge] - total[top, edge] - total[bottom, left] + total[top, left]


def spectral_slopes(
    field: Field, top: NDArray[np.int64], left: NDArray[np.int64], side: int, finer: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Slopes (N,) down and right, rad/px, at the joint peak of both spectra of each square."""
    from scipy.fft import fft2, fftfreq, next_fast_len

    size = int(next_fast_len(finer * side) or 1)
    whole = np.rint(fftfreq(size) * size)
    higher = np.rint(field.wavenumber[1] / field.wavenumber[0] * whole).astype(int) % size
    down, right = np.empty(top.size), np.empty(top.size)
    phasors = (field.real + 1j * field.imaginary).astype(np.complex64)
    squares = np.lib.stride_tricks.sliding_window_view(phasors, (side, side), axis=(1, 2))
    batch = max(1, 2**19 // size**2)  # spectra that stay in the cache
    for start in range(0, top.size, batch):
        some = slice(start, start + batch)
        power = [
            np.abs(np.asarray(fft2(one[top[some], left[some]], (size, size)))) ** 2
            for one in squares
        ]
        joint = power[0] + power[1][:, higher[:, None], higher]
        row, column = np.divmod(joint.reshape(len(joint), -1).argmax(axis=1), size)
        down[some], right[some] = TAU * whole[row] / size, TAU * whole[column] / size
    return down, right


@njit(cache=True, nogil=True, fastmath=True)
def _blocks(field, top, left, side, count, down, right):  # pragma: no cover - compiled
    """Sums of both phasors over count x count blocks, turned back by a slope."""
    real, imaginary, _, wavenumber = field[:4]
    block = side // count
    sums = np.zeros((2, count, count), np.complex128)
    for f in range(2):
        ratio = wavenumber[f] / wavenumber[0]
        across = np.exp(-1j * ratio * right * (np.arange(side) - side // 2))
        for i in range(count):
            for y in range(i * block, i * block + block):
                turn = np.exp(-1j * ratio * down * (y - side // 2))
                for j in range(count):
                    part = 0j
                    for x in range(j * block, j * block + block):
                        phasor = complex(
                            real[f, top + y, left + x], imaginary[f, top + y, left + x]
                        )
                        part += phasor * across[x]
                    sums[f, i, j] += part * turn
    return sums


@njit(cache=True, nogil=True)
def _beats(field, top, left, side, down, right, information):  # pragma: no cover - compiled
    """Beat summed over the blocks for each alias (A, A), and the lower phase at the centre."""
    count = 8 if side >= 32 and information > 4 * LEAST else 4
    sums = _blocks(field, top, left, side, count, down, right)
    wavenumber = field[3]
    multiple = np.rint(wavenumber[1] / wavenumber[0])
    excess = (wavenumber[1] / wavenumber[0] - multiple) * 2 * np.pi  # a turn's mark on the higher
    aliases = 2 * _ALIASES + 1
    out = np.zeros((aliases, aliases), np.complex128)
    block = side // count
    for i in range(count):
        for j in range(count):
            low = sums[0, i, j]
            unit = low / max(abs(low), 1e-9)
            beat = sums[1, i, j] * np.conj(unit**multiple)
            y = (i + 0.5) * block - 0.5 - side // 2
            x = (j + 0.5) * block - 0.5 - side // 2
            for a in range(aliases):
                for b in range(aliases):
                    turn = excess * ((a - _ALIASES) * y + (b - _ALIASES) * x)
                    out[a, b] += beat * np.exp(-1j * turn)
    half = count // 2
    return out, np.angle(np.sum(sums[0, half - 1 : half + 1, half - 1 : half + 1]))


@njit(cache=True, nogil=True)
def _plane(field, row, column, z, down, right):  # pragma: no cover - compiled
    """The plane through a depth at a pixel with slopes, rad/px, of the lower phase."""
    wavenumber, u, v, cosine = field[3], field[5], field[6], field[7]
    matrix, wanted = np.empty((3, 3)), np.empty(3)
    ys, xs = (row, row + 1, row), (column, column, column + 1)
    slopes = (0.0, down, right)
    for i in range(3):
        y, x = ys[i], xs[i]
        matrix[i, 0] = cosine[y, x] * u[x]
        matrix[i, 1] = cosine[y, x] * v[y]
        matrix[i, 2] = cosine[y, x]
        wanted[i] = -slopes[i] / (wavenumber[0] * z * z)
    matrix[1:] -= matrix[0]
    wanted[0] = 1 / z
    q = np.zeros(BENT)
    q[:3] = np.linalg.solve(matrix, wanted)
    return q


@njit(cache=True, nogil=True)
def _climbed(field, label, q, top, left, side):  # pragma: no cover - compiled
    """Fit a plane to the middle of a window first, then to more and more of it.

    Away from the middle the phases of a steep plane bend, too much for slopes known to a bin.
    """
    box = np.empty((1, 4), np.int64)
    core = 6
    while True:
        core = min(core, side)
        margin = (side - core) // 2
        box[0] = (top + margin, top + margin + core, left + margin, left + margin + core)
        area = field[2][0, box[0, 0] : box[0, 1], box[0, 2] : box[0, 3]]
        if core == side or np.sum(area) > 100:
            fit = refine(field, label, -1, q, box, PLANE, 2 if core < side else 3, 0)
            q = fit[0]
            if core == side or fit[1] < 0.4 * fit[2]:
                return q, fit[1], core == side
        core = int(core * 1.5)


@njit(cache=True, nogil=True)
def plane_in_window(field, label, window, limits, information):  # pragma: no cover - compiled
    """The likeliest plane of a window, out of all aliases of its slope, and its S."""
    top, left, side, down, right = window
    wavenumber = field[3]
    wrap = 2 * np.pi / wavenumber[0]
    beats, angle = _beats(field, top, left, side, down, right, information)
    size = np.abs(beats)
    best, plane = -1.0, np.zeros(BENT)
    synthetic = wavenumber[1] - np.rint(wavenumber[1] / wavenumber[0]) * wavenumber[0]
    for _ in range(_CANDIDATES):
        at = np.argmax(size)
        a, b = at // size.shape[1], at % size.shape[1]
        size[a, b] = -1
        slopes = (down + 2 * np.pi * (a - _ALIASES), right + 2 * np.pi * (b - _ALIASES))
        if max(abs(slopes[0]), abs(slopes[1])) > 2 * np.pi * _STEEPEST:
            continue
        z = _nearest_depth(np.angle(beats[a, b]) / synthetic, 2 * np.pi / abs(synthetic), limits)
        z = angle / wavenumber[0] + wrap * np.rint((z - angle / wavenumber[0]) / wrap)
        z = max(z, wrap)
        q = _plane(field, top + side // 2, left + side // 2, z, slopes[0], slopes[1])
        q, likelihood, whole = _climbed(field, label, q, top, left, side)
        if whole and likelihood > best:
            best, plane = likelihood, q
    return plane, best


@njit(cache=True, nogil=True)
def _nearest_depth(z, period, limits):  # pragma: no cover - compiled
    """A depth known but for whole periods, in the limits or as near to them as it can be."""
    z = limits[0] + (z - limits[0]) % period
    if z > limits[1]:
        above, below = z - limits[1], limits[0] - (z - period)
        z = limits[1] if above < below else limits[0]
    return z
