"""Turned ware: walls, rims, handles, what stands in a kitchen."""

import numpy as np
import pytest
from furnishing import assert_made_well, closed_volumes, draw

from cmtof.scenes.rooms import tableware, vessels
from cmtof.scenes.rooms.shaping import (
    hollow,
    inside,
    laid,
    modelled,
    outline_radius,
    pipe,
    resampled,
    turned,
)
from cmtof.scenes.rooms.solids import ball
from cmtof.scenes.rooms.thing import Mesh, Thing

CATALOGUE = {**vessels.CATALOGUE, **tableware.CATALOGUE}
LIMITS = {
    "vase": ((0.04, 0.34), (0.04, 0.34), (0.13, 0.43)),
    "bowl": ((0.12, 0.36), (0.12, 0.36), (0.02, 0.2)),
    "plate": ((0.15, 0.28), (0.15, 0.29), (0.01, 0.06)),
    "cup": ((0.09, 0.18), (0.09, 0.18), (0.04, 0.1)),
    "mug": ((0.09, 0.14), (0.065, 0.11), (0.08, 0.12)),
    "glass": ((0.045, 0.1), (0.045, 0.1), (0.07, 0.24)),
    "wine_bottle": ((0.065, 0.1), (0.065, 0.1), (0.28, 0.36)),
    "bottle": ((0.04, 0.09), (0.04, 0.09), (0.07, 0.33)),
    "jar": ((0.055, 0.14), (0.055, 0.14), (0.08, 0.25)),
    "jug": ((0.07, 0.22), (0.05, 0.15), (0.09, 0.2)),
    "pitcher": ((0.13, 0.33), (0.1, 0.24), (0.19, 0.31)),
    "decanter": ((0.1, 0.23), (0.1, 0.23), (0.24, 0.33)),
    "urn": ((0.18, 0.45), (0.13, 0.35), (0.24, 0.6)),
    "teapot": ((0.22, 0.36), (0.13, 0.2), (0.1, 0.24)),
    "pan": ((0.3, 0.56), (0.15, 0.32), (0.04, 0.19)),
    "pot": ((0.22, 0.4), (0.17, 0.3), (0.08, 0.27)),
    "candle": ((0.05, 0.22), (0.05, 0.22), (0.02, 0.21)),
    "candlestick": ((0.09, 0.38), (0.09, 0.13), (0.2, 0.62)),
    "cutlery_set": ((0.04, 0.14), (0.19, 0.24), (0.005, 0.03)),
    "tray": ((0.36, 0.58), (0.25, 0.4), (0.04, 0.4)),
    "egg_carton": ((0.13, 0.26), (0.1, 0.15), (0.1, 0.15)),
    "tin_cans": ((0.07, 0.23), (0.07, 0.2), (0.07, 0.23)),
    "spray_bottle": ((0.08, 0.12), (0.04, 0.07), (0.19, 0.27)),
}
"""Least and greatest width, depth and height, m."""


def test_every_vessel_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    budget = 8000 if name == "tray" else 5000
    assert_made_well(name, CATALOGUE[name], LIMITS[name], check_thing, budget=budget)


def volume(mesh: Mesh) -> float:
    return closed_volumes(Thing("body").add(mesh, vessels.CORK))[0]


def test_a_hollow_cylinder_has_the_volume_of_its_wall_and_bottom():
    r, h, t = 0.05, 0.1, 0.004
    corners = [(0, 0), (0.999 * r, 0), (r, 0), (r, 0.001), (r, h)]
    wall = np.pi * (r**2 - (r - t) ** 2) * h + np.pi * (r - t) ** 2 * t
    assert volume(hollow(corners, t, sides=96, count=40)) == pytest.approx(wall, rel=0.08)


def test_a_turned_cone_has_a_third_of_its_cylinder():
    cone = turned([(0, 0), (0.03, 0), (0.03, 0), (0, 0.09)], 120, 80)
    assert volume(cone) == pytest.approx(np.pi * 0.03**2 * 0.09 / 3, rel=0.06)


def test_the_inside_never_comes_through_the_wall():
    for shape in vessels._VASES:
        outer = resampled(vessels.outline(shape, 0.08, 0.3), 60)
        inner, _ = inside(outer, 0.004)
        walls = np.interp(inner[:, 1], np.maximum.accumulate(outer[:, 1]), outer[:, 0])
        assert (inner[1:, 0] < walls[1:]).all()


def test_resampling_keeps_the_ends_and_crowds_where_it_bends():
    path = resampled([(0, 0), (0.9, 0), (1, 0.1), (1, 1)], 21)
    assert path[[0, -1]].tolist() == [[0, 0], [1, 1]]
    step = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert step[10] < 0.7 * step[0]


def test_the_inside_told_to_fruit_is_the_inside_that_is_turned():
    corners = vessels.outline(((0.4, 0), (0.45, 0.03), (0.75, 0.22), (1.0, 1.0)), 0.15, 0.08)
    r, z = outline_radius(corners, 0.005)
    assert (np.diff(r) >= -1e-9).all()
    assert z[0] == pytest.approx(0.005)
    assert r[-1] == pytest.approx(0.145, abs=0.003)


def test_a_pipe_is_open_and_looks_outwards():
    tube = pipe([(0, 0, 0), (0, 0, 0.1)], 0.02, 0.004, sides=60)
    r = np.hypot(*tube.vertices[:, :2].T)
    assert sorted({round(float(v), 4) for v in r}) == [0.016, 0.02]
    corners = tube.vertices[tube.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outer = np.isclose(r[tube.faces].min(1), 0.02, atol=1e-4)
    assert ((normal * corners.mean(1))[outer, :2].sum(1) > 0).all()


def test_modelling_without_bumps_leaves_an_ellipsoid():
    mesh = modelled((2, 4, 6))
    assert ((mesh.vertices / [1, 2, 3]) ** 2).sum(1) == pytest.approx(1, abs=1e-5)


def test_a_bump_stands_out_by_its_height():
    mesh = modelled((2, 2, 2), [((0, 0, 1), 0.2, 0.3)])
    assert mesh.vertices[:, 2].max() == pytest.approx(1.3, abs=1e-5)
    assert mesh.vertices[:, 2].min() == pytest.approx(-1.0, abs=1e-5)


@pytest.mark.parametrize(("axis", "way"), [(0, [1, 0, 0]), (1, [0, -1, 0])])
def test_a_laid_body_points_along_its_axis_unmirrored(axis, way):
    body = ball(0.01, (0, 0, 1.0), 1)
    moved = laid(body, axis)
    assert moved.vertices.mean(0) == pytest.approx(way, abs=1e-5)
    assert volume(moved) == pytest.approx(volume(body))


def test_drinks_stay_below_the_rim():
    for seed in range(8):
        for maker in (vessels.cup, vessels.mug):
            thing = draw(maker, seed)
            level = thing.parts[-1].mesh.vertices[:, 2].max()
            assert level <= thing.bounds[1, 2] + 1e-6


def test_eggs_lie_in_their_hollows():
    thing = draw(tableware.egg_carton, 1)
    eggs = [p.mesh.vertices for p in thing.parts if np.ptp(p.mesh.vertices[:, 0]) < 0.046]
    assert eggs
    for egg in eggs:
        assert 0.005 < egg[:, 2].min() < 0.02
