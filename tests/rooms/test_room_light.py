"""Light against closed forms, range against geometry."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pytest import approx, mark
from vectors import unit

from cmtof_rooms.bounce import measure_bounce
from cmtof_rooms.cameras import Lens, look_at
from cmtof_rooms.interior import Interior
from cmtof_rooms.materials import Material
from cmtof_rooms.solids import ball, move, slab
from cmtof_rooms.things import Light, Part, Thing, level_light

pytest.importorskip("embreex")
INSIDE = ((-1, -1, 0.1), (1, 1, 1.9))


def floor(albedo=0.5, z=-0.5, **more):
    """A large plate; its middle lies at a height, m."""
    plate = slab(-10, 10, -10, 10, z - 0.5, z + 0.5)
    return Thing("floor", [Part(Material((albedo,) * 3, **more), plate)])


def point_light(power):
    """A light of no size 2 m above the floor."""
    return Light((0, 0, 2), (0, 0, 0), (0, 0, 0), (0, 0, 0), power)


def up(points):
    return np.repeat(np.eye(3, dtype=np.float32)[2:], len(points), axis=0)


def places(radius):
    return np.array([[r, 0, 0] for r in radius], np.float32)


@mark.parametrize(
    ("light", "exponent", "rtol"),
    [
        (point_light(3.0), 1.5, 3e-4),  # Lambert's law; rays start 0.2 mm above
        (
            level_light((0, 0, 2), 0.1, 3.0),
            2,
            0.01,
        ),  # form factor of a small square
    ],
)
def test_light_falls_with_the_distance_by_its_closed_form(light, exponent, rtol):
    radius = np.repeat([0.0, 0.5, 1.0, 3.0], 16)
    interior = Interior([floor()], [light], INSIDE)
    found = interior.direct(places(radius), up(radius), np.tile(np.arange(16), 4))[:, 1]
    away = radius[::16] ** 2 / 4
    expected = 3 / 4 / (1 + away) ** exponent
    assert_allclose(found.reshape(4, 16).mean(1), expected, rtol=rtol)


def test_shadows_are_where_the_light_is_hidden():
    above = Thing("ball", [Part(Material(), move(ball(0.3), (0, 0, 1)))])
    interior = Interior([floor(), above], [point_light(1.0)], INSIDE)
    edge = 2 * np.tan(np.arcsin(0.3))
    beside = places([0.0, edge - 0.03, edge + 0.03])
    found = interior.direct(beside, up(beside))[:, 0]
    assert found[0] == found[1] == 0
    assert found[2] > 0.1


def test_a_furnace_of_equal_radiance_one_gives_irradiance_one_to_all_sides(rng):
    def look(origins, rays):
        return np.ones(origins.shape, np.float32), np.zeros(len(origins), bool)

    bounce = measure_bounce(np.array(INSIDE, np.float32), look)
    normals = unit(rng.normal(size=(50, 3))).astype(np.float32)
    points = np.full_like(normals, [0.3, -0.2, 0.9])
    assert_allclose(bounce.irradiance(points, normals), 1.0, atol=0.03)


@mark.parametrize("albedo", [0.0, 0.4, 0.8])
def test_one_bounce_gives_no_more_than_reflectance_times_the_first_light(albedo, rng):
    light = level_light((0, 0, 1.9), 0.2, 1.0)
    interior = Interior([floor(albedo), floor(albedo, 2.5)], [light], INSIDE)
    points = rng.uniform(-1, 1, (81, 3)).astype(np.float32)
    points[:, 2] = 1.99
    scattered = interior.bounce.irradiance(points, -up(points))
    most = interior.direct(places([0.0]), up([0]))[0, 0]
    assert (scattered >= 0).all()
    assert scattered.max() <= albedo * most + 1e-6
    assert scattered.mean() >= 0.1 * albedo * most


def test_only_what_is_lit_from_its_front_scatters_light():
    interior = Interior([floor()], [level_light((0, 0, 2), 0.1, 3.0)], INSIDE)
    origins = np.zeros((3, 3), np.float32)
    origins[:, 2] = [1, -0.5, 1]
    rays = np.zeros_like(origins)
    rays[:, 2] = [-1, -1, 1]
    radiance, behind = interior.reflected_radiance(origins, rays)
    assert radiance[0, 0] == approx(0.5 * 3 / 4, rel=1e-3)
    assert not radiance[1:].any()
    assert behind.tolist() == [False, True, False]


def test_range_of_a_plane_is_exact_to_single_precision():
    interior = Interior([floor()], [], INSIDE)
    lens = Lens((48, 64), 55.0)
    camera = look_at(np.array([0.1, -0.3, 1.7]), np.array([0.4, 3.0, 1.2]))
    rays = lens.rays(camera.orientation)
    seen = interior.render(camera.position, rays)
    expected = -1.7 / rays[..., 2].astype(float)
    down = rays[..., 2] < 0
    hit = down & (expected < 8)
    assert_allclose(seen.depth[hit], expected[hit], rtol=3e-7)
    assert_allclose(seen.normal[hit], up(expected[hit]), atol=1e-6)
    assert np.isnan(seen.depth[~down]).all()
    assert set(np.unique(seen.instance)) == {-1, 1}


def test_radiance_is_reflectance_times_irradiance_plus_emission():
    interior = Interior([floor(0.3, emission=0.7)], [point_light(3.0)], INSIDE)
    camera = look_at(np.array([0, 0.01, 1.0]), np.zeros(3))
    seen = interior.render(
        camera.position, Lens((9, 9), 900.0).rays(camera.orientation)
    )
    assert seen.color[4, 4, 1] == approx(0.3 * (3 / 4 + 0.7), rel=1e-3)
