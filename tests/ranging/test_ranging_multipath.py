"""Radiosity with delays: against a dense solution, closed forms, limits and reciprocity."""

import numpy as np
import pytest

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.ranging.corner import Corner
from cmtof.ranging.multipath import (
    Transport,
    band_limit,
    beat_wraps,
    bounces,
    exchange,
    flood,
    mean_path_error,
    range_error,
    spot_ratio,
    spots,
    total,
    two_path_error,
)

ROOM = Corner(walls=3, cells=7)
GROOVE = Corner(angle=1.2, cells=6, along=9)


def dense(corner, frequency):
    """Transport matrix from centres and normals alone, without the edge's symmetry."""
    points = corner.points.reshape(-1, 3)
    wall = np.repeat(np.arange(corner.walls), corner.shape[1] * corner.shape[2])
    normal = corner.frames[1][wall]
    way = points[None] - points[:, None]
    d = np.linalg.norm(way, axis=-1)
    np.fill_diagonal(d, 1.0)
    here = np.einsum("ijk,ik->ij", way, normal) / d
    there = -np.einsum("ijk,jk->ij", way, normal) / d
    factor = np.maximum(here, 0) * np.maximum(there, 0) / (np.pi * d**2) * corner.cell**2
    factor[wall[:, None] == wall] = 0
    return factor * np.exp(-2j * np.pi * frequency / SPEED_OF_LIGHT * d)


@pytest.mark.parametrize("corner", [ROOM, GROOVE])
def test_convolution_along_the_edges_is_the_dense_transport(corner, monkeypatch):
    monkeypatch.setattr("cmtof.ranging.multipath._NEAR", 0)
    rng = np.random.default_rng(1)
    light = rng.normal(size=(2, *corner.shape)) + 1j * rng.normal(size=(2, *corner.shape))
    found = Transport(corner, 3e9).bounce(light)
    expected = light.reshape(2, -1) @ dense(corner, 3e9).T
    assert np.allclose(found.reshape(2, -1), expected, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("corner", [ROOM, GROOVE])
def test_neumann_series_solves_the_radiosity_equation(corner, monkeypatch):
    monkeypatch.setattr("cmtof.ranging.multipath._NEAR", 0)
    e = flood(corner, 2e9)
    matrix = np.eye(e.size) - 0.7 * dense(corner, 2e9)
    exact = np.linalg.solve(matrix, e.ravel())
    series = total(bounces(Transport(corner, 2e9), e, 60), 0.7)
    assert np.allclose(series.ravel(), exact, rtol=1e-9)


@pytest.mark.parametrize("angle", [0.6, 1.0, np.pi / 2, 2.4])
def test_form_factor_of_an_endless_groove(angle):
    # Hottel's crossed strings: F_12 = 1 - sin(alpha / 2), the furnace's 1 as the groove closes
    corner = Corner(angle=angle, cells=24, along=720)
    one = np.zeros(corner.shape)
    one[1] = 1
    seen = Transport(corner, 0.0).bounce(one)[0, :, 360].real
    assert seen.mean() == pytest.approx(1 - np.sin(angle / 2), rel=0.01)
    u = (np.arange(24) + 0.5) / 24
    strip = 0.5 * (1 + (np.cos(angle) - u) / np.sqrt(1 + u**2 - 2 * u * np.cos(angle)))
    assert np.allclose(seen[6:], strip[6:], rtol=0.01)


def test_walls_of_a_closed_cube_share_all_their_light():
    # two unit squares, parallel 1 apart, in closed form (Howell, Siegel, Menguc, App. C)
    opposite = (2 / np.pi) * (
        np.log(np.sqrt(4 / 3))
        + 2 * np.sqrt(2) * np.arctan(1 / np.sqrt(2))
        - 2 * np.arctan(1.0)
    )  # fmt: skip
    corner = Corner(walls=3, cells=40, side=1.0)
    one = np.zeros(corner.shape)
    one[1] = 1
    beside = Transport(corner, 0.0).bounce(one)[0].real.mean()
    assert 4 * beside + opposite == pytest.approx(1, abs=2e-3)


def test_no_cell_gets_more_than_a_furnace_gives():
    for corner in (Corner(walls=3, cells=20), Corner(angle=0.6, cells=20, along=100)):
        seen = Transport(corner, 0.0).bounce(np.ones(corner.shape)).real
        assert seen.min() > 0
        assert seen.max() < 1.02


def test_reciprocity():
    # equal cells: light from i to j is that from j to i, delays and bounces included
    transport = Transport(ROOM, 4e9)
    cells = [(0, 1, 2), (2, 4, 5)]
    light = np.zeros((2, *ROOM.shape))
    for k, cell in enumerate(cells):
        light[(k, *cell)] = 1
    response = total(bounces(transport, light, 20), 0.8)
    assert response[(0, *cells[1])] == pytest.approx(response[(1, *cells[0])], rel=1e-10)


def test_limit_of_low_frequency_is_half_the_mean_detour():
    for corner in (ROOM, GROOVE):
        f = 1e3
        light = total(bounces(Transport(corner, f), flood(corner, f), 30), 0.6)
        found = range_error(light / flood(corner, f), f)
        assert np.allclose(found, mean_path_error(corner, 0.6), rtol=1e-6)


def test_one_detour_in_closed_form():
    # two far-apart small plates make one two-bounce path each
    corner = Corner(cells=1, along=1, side=1e-3, distance=0.3)
    f = np.array([1e8, 7.15e9])
    for one in f:
        terms = bounces(Transport(corner, one), flood(corner, one), 1)
        strength = 0.9 * abs(exchange(corner, 0.0)[0, 0, 0])
        error = range_error(total(terms, 0.9) / terms[0], one)[0, 0, 0]
        path = -np.angle(exchange(corner, one)[0, 0, 0]) * SPEED_OF_LIGHT / (2 * np.pi * one)
        detour = np.asarray(two_path_error(strength, path, one))
        assert error == pytest.approx(detour, rel=0.01)
    assert two_path_error(0.2, 1.0, 1.0) == pytest.approx(0.5 * 0.2 / 1.2, rel=1e-6)
    half = SPEED_OF_LIGHT / 2e9
    assert two_path_error(0.5, half, 1e9) == pytest.approx(0, abs=1e-12)


def test_error_depends_on_size_over_wavelength_only():
    small, large = Corner(cells=9), Corner(cells=9, side=5.0, distance=10.0)
    ratio = [
        total(bounces(Transport(c, f), flood(c, f), 6), 0.5) / flood(c, f)
        for c, f in ((small, 3e9), (large, 3e8))
    ]
    assert np.allclose(ratio[0], ratio[1], rtol=1e-9)


def test_finer_cells_change_little():
    errors = []
    for cells in (41, 81):
        corner = Corner(cells=cells)
        ratio = total(bounces(Transport(corner, 7.15e9), flood(corner, 7.15e9), 10), 0.5)
        ratio = ratio / flood(corner, 7.15e9)
        errors.append(range_error(ratio, 7.15e9)[0, cells // 2, cells // 2])
    assert errors[0] == pytest.approx(errors[1], rel=0.02)


def test_a_scanned_spot_sees_three_reflections_only():
    corner, f = Corner(cells=41), 1e8
    cells = [(0, 20, 20)]
    terms = bounces(Transport(corner, f), spots(corner, f, cells), 8)
    flooded = total(bounces(Transport(corner, f), flood(corner, f), 8), 0.5) / flood(corner, f)
    ratio = spot_ratio(corner, terms, 0.5, f, cells, 0.0246)
    assert abs(ratio[0] - 1) < 0.05 * abs(flooded[0, 20, 20] - 1)
    assert spot_ratio(corner, terms[:2], 0.5, f, cells, 0.0246)[0] == pytest.approx(1)
    # an open field of view sees what flood light of all spots would send back to one camera
    wide = spot_ratio(corner, terms, 0.5, f, cells, np.pi)
    assert abs(wide[0] - 1) > 10 * abs(ratio[0] - 1)


def test_rays_meet_the_cells_they_are_sent_to():
    for corner in (ROOM, GROOVE, Corner(walls=2, angle=2.0, cells=5)):
        distance, cosine = corner.seen
        ray = (corner.points - corner.instrument) / distance[..., None]
        reach, facing, cell = corner.look(ray)
        assert np.allclose(reach, distance) and np.allclose(facing, cosine)
        assert (cell == np.moveaxis(np.indices(corner.shape), 0, -1)).all()
    assert np.isnan(ROOM.look([0.0, 0.0, 1.0])[0])


def test_band_limit_and_beat():
    f = np.geomspace(1e6, 1e10, 81)
    # strength 1 / (1 + (f / f0)^2)^(1/2) is a tenth at f0 sqrt(99)
    assert band_limit(f, 1 / np.hypot(1, f / 1e8)) == pytest.approx(1e8 * np.sqrt(99), rel=0.01)
    with pytest.raises(ValueError, match="fall below"):
        band_limit(f, np.ones(81))
    # 17.6 mrad of beat are one wrap
    low, high = 7.15e9, 14.32e9
    turn = np.exp(-1j * 2 * np.pi * 20e6 / low)
    assert beat_wraps(1.0, turn, frequencies=(low, high)) == pytest.approx(1)


def test_bad_input():
    with pytest.raises(ValueError, match="three walls at a right angle"):
        Corner(walls=3, angle=1.0)
    with pytest.raises(ValueError, match="square walls"):
        Corner(walls=3, cells=5, along=7)
    with pytest.raises(ValueError, match=r"corner\.side from"):
        Corner(side=-1.0)
    with pytest.raises(ValueError, match="light of shape"):
        Transport(ROOM, 1e9).bounce(np.ones((2, 2)))
