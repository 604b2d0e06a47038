"""How rough surfaces are, and by how much each pixel departs from its own.

What departs from a surface moves both phases of a pixel alike. So the beat does not lose by it
where pixels are turned back by their own departure, and a pixel has the wrap of its own depth.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects, gaussian_filter

from cmtof.compiled import njit
from cmtof.correlation import TAU
from cmtof.surfaces.blocks import unit_phasor
from cmtof.surfaces.field import CELL, Field, pixels_of_cells
from cmtof.surfaces.shapes import depth_of_labels
from cmtof.types import Array, Arrays, Numbers

_EVEN = 0.02  # roughness, rad^2, that an even surface shows as well
_ALIKE = 0.2  # largest excess of coherence at the higher frequency over that of uneven surfaces
_NEAR = 1.5  # width, px, of the Gaussian that finds the lobe of a pixel's phases
_REACH = 6  # px, four times that width, where SciPy ends it
_TURNS = 3  # steps towards the likeliest departure of a pixel


class Cells(NamedTuple):
    """Phasors turned back by the phase of their surface, of pixels and summed over cells."""

    main: Numbers  # surface in the middle of each cell (h, w)
    label: Numbers  # (H, W), of the pixels of this surface, -1 for others
    turned: Array  # phasors (2, H, W) of these, zero for others
    sums: Array  # of these (2, h, w)
    information: Array  # and their E
    rough: Array  # variance (N,), rad^2, of the pixels of each surface about it

    @property
    def side(self) -> int:
        """Side of a cell, px."""
        return len(self.label) // len(self.main)


def cells_of_surfaces(
    field: Field, inner: Numbers, surfaces: Array, side: int = CELL
) -> Cells:
    """Phasors turned back by the depth of their surface (N, 7), and how rough these are."""
    middle = slice((side - 1) // 2, side // 2 + 1)
    # the largest of the middle four pixels, so that mirrors agree
    main = _blocks(inner, side)[:, middle, :, middle].max(axis=(1, 3))
    whole = pixels_of_cells(main, side)
    label = np.where(whole == inner, inner, -1)
    chosen = label >= 0
    depth = depth_of_labels(field, inner, surfaces)
    turned = np.where(chosen, turn_back(field, depth), 0)
    weights = np.where(chosen, field.information, 0)
    information = sum_cells(weights.astype(float), side)
    sums = sum_cells(turned, side)
    rough = roughness(main, sums, information, len(surfaces))
    return Cells(main, label, turned, sums, information, rough)


def _blocks(images: NDArray, side: int) -> NDArray:
    """Images (..., H, W) as the pixels of their cells (..., h, side, w, side)."""
    *others, height, width = images.shape
    return images.reshape(*others, height // side, side, width // side, side)


@njit()
def turn_back(field, depth):  # pragma: no cover - compiled
    """Phasors (2, H, W) turned back by the phase of a depth z (H, W), m: ``P exp(-i k z)``."""
    out = np.empty(field.phasor.shape, np.complex128)
    for f in range(2):
        turns = field.wavenumber[f] / TAU
        for y, x in np.ndindex(depth.shape):
            out[f, y, x] = field.phasor[f, y, x] * unit_phasor(turns * depth[y, x])
    return out


def sum_cells(images: Array, side: int = CELL) -> Array:
    """Sums of images (2, H, W) over cells."""
    return _blocks(images, side).sum(axis=(2, 4))


def roughness(owner: Numbers, sums: Array, information: Array, count: int) -> Array:
    """Variance (N,), rad^2, of pixels about their surface, by the coherence of each frequency.

    Unevenness s of a Gaussian costs one frequency exp(-s^2 / 2) and twice that frequency the fourth
    power of this. Pixels of other surfaces cost both alike: then there is none.
    """
    total, most = pooled_phasors(owner, sums, information, count)
    coherence = np.hypot(total.real, total.imag) / most
    low, high = np.clip(coherence, 0.05, 1)
    by_low = -2 * np.log(low)
    by_high = -np.log(high) / 2
    found = np.minimum(by_low, by_high)
    alike = high - low**4 > _ALIKE
    return np.where(alike | (found < _EVEN), 0, found)


def pooled_phasors(
    main: Numbers, phasors: Array, information: Array, count: int
) -> Arrays:
    """Sums (2, N) over the cells of each surface, of phasors and of their information E."""
    both = np.array([phasors, information])
    total, most = sum_surfaces(main, both, count)[..., :count]
    return total, np.maximum(most.real, 1e-9)


def sum_surfaces(main: Numbers, images: NDArray, count: int) -> Array:
    """Sums (..., N + 1) of cell images (..., h, w) by surface; the last of cells without one."""
    out = np.zeros((*images.shape[:-2], count + 1), np.result_type(images, float))
    np.add.at(out, (..., main), images)  # pyright: ignore[reportArgumentType]
    return out


def departure(field: Field, turned: Array, variance: Array) -> Array:
    """Likeliest phase (H, W), rad at the lower frequency, by which pixels depart from a surface.

    From phasors (2, H, W) turned back by it; a Gaussian of this ``variance`` (H, W), rad^2, that
    moves both frequencies alike.
    """
    out = np.zeros(variance.shape)
    rough = variance > 0
    phasors = turned[:, rough]
    variance = variance[rough]
    low, high = field.information[:, rough]
    known = variance * (low + field.multiple**2 * high)
    # these pixels and all that the Gaussian adds to them
    (box,) = find_objects(rough.astype(int))
    box = tuple(slice(max(0, s.start - _REACH), s.stop + _REACH) for s in box)
    near = gaussian_filter(turned[0][box], _NEAR)[rough[box]]
    found = known / (1 + known) * np.angle(near)
    for _ in range(_TURNS):
        low, high = turn_both_back(field, phasors, found).imag
        found += (variance * (low + field.multiple * high) - found) / (1 + known)
    out[rough] = np.clip(found, -np.pi, np.pi)
    return out


def turn_both_back(field: Field, phasors: Array, departure: Array) -> Array:
    """Phasors (2, ...) turned back by a phase (...), rad, the higher by the multiple of it."""
    low = np.exp(-1j * departure)
    return phasors * [low, low**field.multiple]
