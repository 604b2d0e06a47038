"""Windows in which planes begin: their slopes by spectra, and the likeliest plane of each.

Within a window a plane's phases are ramps, so both spectra peak: at a slope nu, rad/px, and at
``(k_2 / k_1) nu``. Slopes that differ by whole turns per pixel look alike but for the beat.
"""

from collections.abc import Iterator

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.fft import fft, fftfreq, next_fast_len

from cmtof.compiled import inlined, njit
from cmtof.correlation import TAU
from cmtof.surfaces.blocks import SIDE, region_of_boxes
from cmtof.surfaces.field import CELL, Field
from cmtof.surfaces.fitting import climb
from cmtof.surfaces.shapes import BENT, PLANE
from cmtof.types import Array, Flags, Numbers

# Side of a window, distance to the next, side of the core whose spectrum is taken, all px, and how
# many times its bins are refined. Large ones come first: what is large should stay in one piece.
WINDOWS = (
    (64, 32, 32, 3),
    (32, 16, 16, 4),
    (16, 8, 12, 4),
    (12, 4, 8, 5),
)
_AT_ONCE = 32  # windows whose spectra are taken together
_LEAST = 150.0  # information E below which a window starts nothing: its noise would fit as well
FREE = 0.7  # share of the cells of a window that must be without a surface
_ALIASES = 2  # whole turns per pixel tried to each side
_STEEPEST = 1.6  # largest slope, turns/px
_CANDIDATES = 4  # slopes out of all aliases that are fitted


def windows(
    field: Field, owner: Numbers, side: int, stride: int, core: int, finer: int
) -> Iterator[tuple]:
    """Top, left, side (N,) of windows on free cells, the clearest first, and slopes, rad/px.

    They come some at a time, so that no spectrum is taken where the first ones grew.
    """
    height, width = np.array(field.cosine.shape) - side + 1
    corner = np.mgrid[:height:stride, :width:stride].reshape(2, -1)
    corner = corner[:, _are_free(owner, corner, side)]
    totals = _sums(field.information.sum(axis=0, dtype=float), corner, side)
    order = np.argsort(-totals, kind="stable")
    corner = corner[:, order[totals[order] >= _LEAST]]
    for start in range(0, len(corner[0]), _AT_ONCE):
        some = corner[:, start : start + _AT_ONCE]
        # rows in one piece, as Numba compiled for
        some = some.compress(_are_free(owner, some, side), axis=1)
        core_corner = some + (side - core) // 2
        slopes = spectral_slopes(field, *core_corner, core, finer)  # pyright: ignore[reportCallIssue]
        yield *some, np.full_like(some[0], side), *slopes


def _are_free(owner: Numbers, corner: Numbers, side: int) -> Flags:
    """Whether windows (N,), by their top and left (2, N), lie mostly on cells without an owner."""
    cells = side // CELL
    free = _sums((owner < 0).astype(float), corner // CELL, cells)
    return free >= FREE * cells**2


def _sums(image: Array, corner: Numbers, side: int) -> Array:
    """Sum (N,) of an image (H, W) over squares, by their top and left (2, N)."""
    total = image.cumsum(axis=0).cumsum(axis=1)
    total = np.pad(total, (1, 0))
    top, left = corner
    bottom, right = corner + side
    whole = total[bottom, right]
    above = total[top, right]
    beside = total[bottom, left]
    return whole - above - beside + total[top, left]


def spectral_slopes(
    field: Field,
    top: Numbers,
    left: Numbers,
    side: int,
    finer: int,
) -> Array:
    """Slopes (2, N) down and right, rad/px, at the joint peak of both spectra of each square."""
    squares = sliding_window_view(field.phasor, (side, side), axis=(1, 2))
    size: int = next_fast_len(finer * side)  # pyright: ignore[reportAssignmentType]
    whole = np.rint(fftfreq(size) * size)
    higher = np.rint(field.ratio * whole).astype(int)
    higher %= size
    rows = fft(squares[:, top, left], size)  # before rows of zeros are added
    spectrum = fft(rows, size, axis=-2)
    low, high = spectrum.real**2 + spectrum.imag**2  # pyright: ignore[reportAttributeAccessIssue]
    joint = low + high.take(higher, 1).take(higher, 2)
    best = joint.reshape(-1, size**2).argmax(axis=1)
    return TAU * whole[np.array(np.divmod(best, size))] / size


@njit()
def plane_in_window(field, window, information):  # pragma: no cover - compiled
    """Likeliest plane (6,) of a window, by the likeliest aliases of its slope; S, -1 if none."""
    beats, phase = _beats(field, window, information)
    size = np.abs(beats)
    best = -1.0
    plane = np.zeros(BENT)
    for _ in range(_CANDIDATES):
        alias = divmod(np.argmax(size), size.shape[1])
        size[alias] = -1
        down = window[3] + TAU * (alias[0] - _ALIASES)
        right = window[4] + TAU * (alias[1] - _ALIASES)
        if max(abs(down), abs(right)) > TAU * _STEEPEST:
            continue
        z = _depth_of_beat(field, np.angle(beats[alias]), phase)
        fit, there = _climb_outwards(
            field, _plane(field, window, z, down, right), window
        )
        if there and fit.likelihood > best:
            best = fit.likelihood
            plane = fit.q
    return plane, best


@inlined
def _depth_of_beat(field, beat, phase):  # pragma: no cover - compiled
    """Depth, m, by a lower-frequency phase, nearest to that of a beat in range; both in rad."""
    low, high = field.wavenumber
    period = field.period
    nearest, farthest = field.limits
    synthetic = high - np.rint(high / low) * low
    repeat = TAU / abs(synthetic)
    z = nearest + (beat / synthetic - nearest) % repeat
    if z > farthest:
        before = z - repeat
        z = farthest if z - farthest < nearest - before else nearest
    here = phase / low
    whole = np.rint((z - here) / period)
    return max(here + period * whole, period)


@inlined
def _beats(field, window, information):  # pragma: no cover - compiled
    """Beat of a window for each alias (A, A) of its slope, and the phase of the lower tone, rad."""
    side = window[2]
    count = 8 if side >= 32 and information > 4 * _LEAST else 4
    low, beats = _blocks(field, window, count)
    ratio = field.wavenumber[1] / field.wavenumber[0]
    multiple = np.rint(ratio)
    for place in np.ndindex(low.shape):
        unit = low[place] * (1 / max(np.abs(low[place]), 1e-9))
        beats[place] *= np.conj(unit**multiple)
    # a whole turn of the lower phase marks the higher one by this
    excess = (ratio - multiple) * TAU
    middle = slice(count // 2 - 1, count // 2 + 1)
    phase = np.angle(low[middle, middle].sum())
    return _sums_of_aliases(beats, excess, side), phase


@inlined
def _sums_of_aliases(beats, excess, side):  # pragma: no cover - compiled
    """Sums (A, A) of blocks' beats, turned back by the whole turns per pixel of each alias."""
    count = 2 * _ALIASES + 1
    out = np.zeros((count, count), np.complex128)
    width = side // len(beats)
    start = (width - 1) / 2 - side // 2  # middle of the first block
    for a, b in np.ndindex(out.shape):
        for i, j in np.ndindex(beats.shape):
            down = (a - _ALIASES) * (start + i * width)
            right = (b - _ALIASES) * (start + j * width)
            out[a, b] += beats[i, j] * np.exp(-1j * (excess * (down + right)))
    return out


@inlined
def _blocks(field, window, count):  # pragma: no cover - compiled
    """Sums of both phasors over count x count blocks of a window, turned back by its slope."""
    top, left, side = window[:3]
    width = side // count
    sums = np.zeros((2, count, count), np.complex128)
    for f in range(2):
        along = _turns(field, f, side, window[3])
        across = _turns(field, f, side, window[4])
        for y, x in np.ndindex(side, side):
            turned = field.phasor[f, top + y, left + x] * along[y] * across[x]
            sums[f, y // width, x // width] += turned
    return sums


@inlined
def _turns(field, f, side, slope):  # pragma: no cover - compiled
    """Unit phasors (h,) that turn pixels of a window back by a slope, rad/px, in one direction."""
    turns = np.empty(side, np.complex128)
    ratio = field.wavenumber[f] / field.wavenumber[0]
    for i in range(side):
        turns[i] = np.exp(-1j * ratio * slope * (i - side // 2))
    return turns


@inlined
def _plane(field, window, z, down, right):  # pragma: no cover - compiled
    """The plane through a depth in the middle of a window with slopes, rad/px, of its phase."""
    row = window[0] + window[2] // 2
    column = window[1] + window[2] // 2
    u = field.u[column]
    v = field.v[row]
    fall = 1 / (field.wavenumber[0] * z * z)  # of 1 / z per radian
    cosine = field.cosine
    here = 1 / z / cosine[row, column]
    below = (1 / z - fall * down) / cosine[row + 1, column]
    beside = (1 / z - fall * right) / cosine[row, column + 1]
    q = np.zeros(BENT)
    q[0] = (beside - here) / (field.u[column + 1] - u)
    q[1] = (below - here) / (field.v[row + 1] - v)
    q[2] = here - q[0] * u - q[1] * v
    return q


@inlined
def _climb_outwards(field, q, window):  # pragma: no cover - compiled
    """Fit of a plane from a window's middle outwards, and whether it reached the whole window.

    It begins small, for steep phases bend.
    """
    top, left, side, _, _ = window
    core = 2 * SIDE
    while True:
        core = min(core, side)
        there = core == side
        y = top + (side - core) // 2
        x = left + (side - core) // 2
        information = field.information[0, y : y + core, x : x + core].sum()
        if there or information > 100:
            region = region_of_boxes(np.array([[y, y + core, x, x + core]]))
            fit = climb(field, region, q, PLANE, 3 if there else 2)
            if there or fit.likelihood < 0.4 * fit.most:
                return fit, there
            q = fit.q
        core += core // 2 // SIDE * SIDE
