"""Slopes from spectra, and planes in windows though their phase turns more than once a pixel."""

import numpy as np
import pytest
from facet_scenes import NOTHING, SHAPE, WRAP, exact_field, plane_depth

from cmtof.correlation import TAU
from cmtof.surfaces.field import CELL
from cmtof.surfaces.labels import depth_of_labels
from cmtof.surfaces.seeds import WINDOWS, plane_in_window, spectral_slopes, windows

CELLS = (SHAPE[0] // CELL, SHAPE[1] // CELL)

FULL_LIGHT = 56.0
"""Information of a pixel of intensity 1: one over 0.134 rad squared."""


def ramp(down, right, shape=(64, 64), **more):
    """Field of a depth whose lower phase rises by so many rad/px."""
    y, x = np.indices(shape)
    return exact_field(2.0 + (down * y + right * x) * WRAP / TAU, **more)


def turned(difference):
    """Smallest of slopes that differ by whole turns per pixel."""
    return (difference + np.pi) % TAU - np.pi


@pytest.mark.parametrize(("side", "finer"), [(core, finer) for _, _, core, finer in WINDOWS])
@pytest.mark.parametrize(
    "slopes",
    [(0, 0), (0.31, -0.82), (-1.3, 0.004), (2.9, 2.2), (0, -3.0), (4.0, -0.5), (-7.0, 1.0)],
)
def test_slopes_are_those_of_the_ramp(slopes, side, finer):
    field = ramp(*slopes)
    top, left = np.array([0, 11, 20]), np.array([3, 0, 17])
    found = spectral_slopes(field, top, left, side, finer)
    for got, true in zip(found, slopes, strict=True):
        assert np.abs(turned(got - true)).max() <= 1.01 * TAU / (finer * side)


@pytest.mark.parametrize("seed", range(5))
def test_slopes_are_found_in_noise(seed):
    """In a square of 32 px an information of 0.5 a pixel sums to 1024: far above any other bin."""
    rng = np.random.default_rng(seed)
    slopes = rng.uniform(-3, 3, 2)
    field = ramp(*slopes, information=0.5, noise_of=rng)
    found = spectral_slopes(field, np.array([5]), np.array([9]), 32, 3)
    for got, true in zip(found, slopes, strict=True):
        assert abs(turned(got[0] - true)) <= 1.01 * TAU / 96


@pytest.mark.parametrize("kind", WINDOWS)
def test_windows_lie_within_and_tell_something(kind, rng):
    depth, _ = plane_depth((0.2, 0.1, 1), 2.5)
    information = np.broadcast_to(np.linspace(9, 3, SHAPE[1]) * (np.arange(SHAPE[1]) < 80), SHAPE)
    field = exact_field(depth, information=information, noise_of=rng)
    found = windows(field, np.ones(CELLS, bool), *kind)
    assert found.top.size
    assert (found.side == kind[0]).all()
    assert (found.top >= 0).all()
    assert (found.top + found.side <= SHAPE[0]).all()
    assert (found.left < 80).all()
    assert np.isfinite(found.down).all()
    assert np.isfinite(found.right).all()
    told = [information[0, x : x + kind[0]].sum() for x in found.left]
    assert (np.diff(told) < 1e-3).all()  # what knows most comes first


@pytest.mark.parametrize("kind", WINDOWS)
def test_windows_keep_off_what_is_taken(kind):
    depth, _ = plane_depth((0.2, 0.1, 1), 2.5)
    free = np.ones(CELLS, bool)
    free[:, : CELLS[1] // 2] = False
    found = windows(exact_field(depth), free, *kind)
    assert found.top.size
    # as far as a part of a window may be taken
    assert (found.left + found.side > SHAPE[1] // 2 + found.side / 2).all()


@pytest.mark.parametrize("kind", WINDOWS)
def test_nothing_begins_in_the_dark_or_where_all_is_taken(kind):
    depth, _ = plane_depth((0, 0, 1), 2.5)
    assert windows(exact_field(depth, information=0.0), np.ones(CELLS, bool), *kind).top.size == 0
    assert windows(exact_field(depth), np.zeros(CELLS, bool), *kind).top.size == 0


def fit(field, top, left, side):
    """Plane of a window by its own slopes: S / E, and its depth (H, W)."""
    core = {w[0]: w for w in WINDOWS}[side]
    margin = (side - core[2]) // 2
    at = np.array([top + margin]), np.array([left + margin])
    down, right = spectral_slopes(field, *at, core[2], core[3])
    told = float(field.information[:, top : top + side, left : left + side].sum())
    window = (top, left, side, down[0], right[0])
    q, likely = plane_in_window(field.arrays(), NOTHING, window, field.limits, told)
    return likely / told, depth_of_labels(field, np.zeros(SHAPE, int), q[None])


def steep(turns, way):
    """Normal of a plane at 2.5 m whose phase rises by so many turns a pixel, across or down."""
    tangent = turns * WRAP * 140 / 2.5
    return (-tangent * np.cos(way), -tangent * np.sin(way), 1)


@pytest.mark.parametrize("side", [32, 16, 12])
@pytest.mark.parametrize("normal", [(0, 0, 1), (0.2, 0.1, 1), (-0.3, 0.2, 1), (0.1, -0.5, 1)])
def test_planes_are_found_without_noise(normal, side):
    depth, _ = plane_depth(normal, 2.5)
    share, found = fit(exact_field(depth), 32, 48, side)
    middle = (32 + side // 2, 48 + side // 2)
    assert share > 0.99
    # the beat's blocks say the wrap but for a few; the shape of larger surfaces will
    assert abs(found[middle] - depth[middle]) < 3.5 * WRAP


@pytest.mark.parametrize(
    ("side", "turns"),
    [(16, 0.55), (16, -0.6), (16, 0.7), (12, 0.6), (12, 0.7), (12, -0.8), (12, 1.0)],
)
@pytest.mark.parametrize("way", np.deg2rad([0, 30, 90]))
def test_phases_that_turn_more_than_half_a_turn_a_pixel(side, turns, way):
    """Their slope is an alias at the lower frequency; at full light the beat tells which."""
    rng, right = np.random.default_rng(3), 0
    depth, _ = plane_depth(steep(turns, way), 2.5)
    places = [(y, x) for y in (54, 62, 70) for x in (73, 81, 89)]
    for y, x in places:
        field = exact_field(depth, information=FULL_LIGHT, noise_of=rng)
        share, found = fit(field, y - side // 2, x - side // 2, side)
        slopes = [(d[y + 1, x] - d[y, x], d[y, x + 1] - d[y, x]) for d in (found, depth)]
        right += share > 0.9 and np.abs(np.subtract(*slopes)).max() < 0.02 * WRAP
    assert right >= 6  # of nine; by chance one of 25 aliases is
