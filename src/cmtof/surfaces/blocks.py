"""Compiled loops (Numba): phasors turned back by a surface's phase, summed over pixel blocks.

Within a block the depth of all pixels changes nearly alike with each parameter of a surface, so
that its derivatives are taken in the middle. Every step has a loop of its own over the pixels of a
block, so that the processor works on several of them at once.
"""

from typing import NamedTuple

import numpy as np

from cmtof.compiled import inlined, njit
from cmtof.correlation import TAU
from cmtof.surfaces.field import CELL
from cmtof.surfaces.shapes import BENT, FARTHEST, depth_at
from cmtof.types import Numbers

SIDE = 4  # of a block, px, by which sides of rectangles are divisible


class Region(NamedTuple):
    """Pixels that a fit looks at: those of one surface, or all, in some rectangles."""

    boxes: Numbers  # (B, 4): top, bottom, left and right of each
    label: Numbers  # surface of each pixel (H, W)
    only: np.int64  # this one, every pixel counts if it is < 0


@njit()
def region_of_boxes(boxes):  # pragma: no cover - compiled
    """`Region` of all pixels of rectangles (B, 4), whatever their surface."""
    return Region(boxes, np.zeros((1, 1), np.int32), np.int64(-1))


@njit()
def blocks_of_boxes(boxes):  # pragma: no cover - compiled
    """Row and column of the first pixel of each block (N, 2) of rectangles."""
    places = []
    for top, bottom, left, right in boxes:
        for y in range(top, bottom, SIDE):
            for x in range(left, right, SIDE):
                places.append((y, x))
    return np.array(places)


@njit()
def depths_of_blocks(field, q, places):  # pragma: no cover - compiled
    """Depth (N,), m, of a surface mid-block, and functions (N, 6), of which q makes 1 / z there.

    They are the cosine times u, v, 1, u^2, u v, v^2.
    """
    depth = np.empty(len(places))
    functions = np.empty((len(places), BENT))
    for n, (y, x) in enumerate(places):
        v = (field.v[y] + field.v[y + SIDE - 1]) / 2
        u = (field.u[x] + field.u[x + SIDE - 1]) / 2
        slant = np.sqrt(1 + u * u + v * v)
        inverse = 0.0
        for i, term in enumerate((u, v, 1.0, u * u, u * v, v * v)):
            functions[n, i] = term / slant
            inverse += q[i] * functions[n, i]
        depth[n] = 1 / max(inverse, FARTHEST)
    return depth, functions


@njit()
def block_sums(field, region, q, places):  # pragma: no cover - compiled
    """Sums (2, N) over blocks: of phasors turned back by a surface, and of their information E."""
    total = np.zeros((2, len(places)), np.complex128)
    information = np.zeros((2, len(places)))
    depth = np.empty(SIDE**2)
    unit = np.empty(SIDE**2, np.complex128)
    for n, (top, left) in enumerate(places):
        for i in range(SIDE**2):
            depth[i] = depth_at(field, q, top + i // SIDE, left + i % SIDE)
        for f in range(2):
            for i in range(SIDE**2):
                unit[i] = unit_phasor(field.wavenumber[f] / TAU * depth[i])
            for i in range(SIDE**2):
                y = top + i // SIDE
                x = left + i % SIDE
                if region.only < 0 or region.label[y, x] == region.only:
                    total[f, n] += field.phasor[f, y, x] * unit[i]
                    information[f, n] += field.information[f, y, x]
    return total, information


@inlined
def unit_phasor(turns):  # pragma: no cover - compiled
    """exp(-2 pi i turns), to 6e-8: Taylor series on a quarter turn to each side."""
    whole = np.floor(2 * turns + 0.5)
    x = (turns - 0.5 * whole) * TAU
    odd = 1.0 - 2.0 * (whole - 2.0 * np.floor(0.5 * whole))
    y = x * x
    # quotients of literals are factors already when this is compiled
    c = 1 / 40320 - y * (1 / 3628800 - y * (1 / 479001600))
    c = 1 / 24 - y * (1 / 720 - y * c)
    c = 1 - y * (1 / 2 - y * c)
    s = 1 / 5040 - y * (1 / 362880 - y * (1 / 39916800))
    s = 1 / 6 - y * (1 / 120 - y * s)
    s = x * (1 - y * s)
    return complex(odd * c, -odd * s)


@inlined
def pixel_likelihood(field, q, y, x):  # pragma: no cover - compiled
    """Log-likelihood S of a surface at one pixel, up to a constant."""
    z = depth_at(field, q, y, x)
    total = 0.0
    for f in range(2):
        total += (
            field.phasor[f, y, x] * unit_phasor(field.wavenumber[f] / TAU * z)
        ).real
    return total


@njit()
def cell_likelihood(field, q, row, column):  # pragma: no cover - compiled
    """Log-likelihood S of a surface over one cell of `CELL` x `CELL` px, up to a constant."""
    top = row * CELL
    left = column * CELL
    box = np.array(((top, top + CELL, left, left + CELL),))
    sums = frequency_sums(field, q, box)
    return sums[0, 0] + sums[0, 1]


@njit()
def frequency_sums(field, q, boxes):  # pragma: no cover - compiled
    """Log-likelihood S of a surface over rectangles and its expectation E, by frequency (2, 2)."""
    places = blocks_of_boxes(boxes)
    total, information = block_sums(field, region_of_boxes(boxes), q, places)
    out = np.zeros((2, 2))
    for f in range(2):
        out[0, f] = total[f].real.sum()
        out[1, f] = information[f].sum()
    return out
