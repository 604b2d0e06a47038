"""Light against closed forms, range against geometry."""

import numpy as np
import pytest

from cmtof_rooms.cameras import Lens, looking
from cmtof_rooms.engine import Light, Part, Thing, World
from cmtof_rooms.materials import Material
from cmtof_rooms.solids import ball, box

pytest.importorskip("embreex")
INSIDE = ((-1, -1, 0.1), (1, 1, 1.9))
POINT = {"half_u": (0, 0, 0), "half_v": (0, 0, 0), "normal": (0, 0, 0)}


def floor(albedo=0.5, **more):
    return Thing("floor", [Part(box((20, 20, 1), (0, 0, -0.5)), Material((albedo,) * 3, **more))])


def up(points):
    return np.tile(np.array([0, 0, 1], np.float32), (len(points), 1))


def places(radius):
    return np.array([[r, 0, 0] for r in radius], np.float32)


def test_a_point_light_follows_lamberts_law():
    world = World([floor()], [Light((0, 0, 2), power=3.0, **POINT)], INSIDE, bounce=False)
    radius = np.array([0.0, 0.5, 1.0, 3.0])
    found = world.direct(places(radius), up(radius))
    expected = 3 * 2 / (radius**2 + 4) ** 1.5
    np.testing.assert_allclose(found[:, 1], expected, rtol=3e-4)  # rays start 0.2 mm above


def test_a_small_square_light_gives_its_form_factor():
    side, height = 0.2, 2.0
    light = Light((0, 0, height), (side / 2, 0, 0), (0, side / 2, 0), (0, 0, -1), 1.0)
    world = World([floor()], [light], INSIDE, bounce=False)
    radius = np.repeat([0.0, 1.0, 2.0], 16)
    found = world.direct(places(radius), up(radius), np.tile(np.arange(16), 3))[:, 0]
    expected = height**2 / (np.array([0.0, 1.0, 2.0]) ** 2 + height**2) ** 2
    np.testing.assert_allclose(found.reshape(3, 16).mean(axis=1), expected, rtol=0.01)


def test_shadows_are_where_the_light_is_hidden():
    ball_above = Thing("ball", [Part(ball(0.3), Material())])
    ball_above.parts[0].mesh.apply_translation((0, 0, 1))
    world = World(
        [floor(), ball_above], [Light((0, 0, 2), power=1.0, **POINT)], INSIDE, bounce=False
    )
    edge = 2 * np.tan(np.arcsin(0.3))
    found = world.direct(places([0.0, edge - 0.03, edge + 0.03]), up(range(3)))[:, 0]
    assert found[0] == found[1] == 0
    assert found[2] > 0.1


def test_a_furnace_of_equal_light_gives_back_its_reflectance():
    """Walls of radiance one seen all around: irradiance one, whatever the direction."""
    room = [
        Thing("wall", [Part(box(size, centre), Material((0.5,) * 3))])
        for size, centre in (
            ((4, 4, 1), (0, 0, -0.5)),
            ((4, 4, 1), (0, 0, 2.5)),
            ((1, 4, 4), (-2, 0, 1)),
            ((1, 4, 4), (2, 0, 1)),
            ((4, 1, 4), (0, -2, 1)),
            ((4, 1, 4), (0, 2, 1)),
        )
    ]
    world = World(room, [], INSIDE)
    world.direct = lambda position, normal, sample=None: np.full(position.shape, 2.0, np.float32)
    world._probes = world._probed()
    points = np.zeros((50, 3), np.float32) + np.float32([0.3, -0.2, 0.9])
    normals = np.random.default_rng(1).normal(size=(50, 3))
    normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)
    np.testing.assert_allclose(world.bounced(points, normals), 1.0, atol=0.03)


def test_one_bounce_gives_no_more_than_reflectance_times_the_first_light():
    for albedo in (0.0, 0.4, 0.8):
        room = [
            floor(albedo),
            Thing("roof", [Part(box((20, 20, 1), (0, 0, 2.5)), Material((albedo,) * 3))]),
        ]
        light = Light((0, 0, 1.9), (0.2, 0, 0), (0, 0.2, 0), (0, 0, -1), 1.0)
        world = World(room, [light], INSIDE)
        x, y = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9))
        points = np.stack([x.ravel(), y.ravel(), np.full(81, 1.99)], 1).astype(np.float32)
        scattered = world.bounced(points, -up(points))
        most = world.direct(places([0.0]), up([0]))[0, 0]
        assert (scattered >= 0).all()
        assert scattered.max() <= albedo * most + 1e-6
        assert (scattered.mean() > 0.1 * albedo * most) or albedo == 0


def test_range_of_a_plane_is_exact_to_single_precision():
    world = World([floor()], [], INSIDE, bounce=False)
    lens = Lens((48, 64), 55.0)
    camera = looking(np.array([0.1, -0.3, 1.7]), np.array([0.4, 3.0, 1.2]))
    rays = lens.rays(camera.orientation)
    seen = world.picture(camera.position, rays)
    expected = -1.7 / rays[..., 2].astype(float)
    hit = (rays[..., 2] < 0) & (expected < 8)
    np.testing.assert_allclose(seen.depth[hit], expected[hit], rtol=3e-7)
    np.testing.assert_allclose(seen.normal[hit], np.tile([0, 0, 1.0], (hit.sum(), 1)), atol=1e-6)
    assert np.isnan(seen.depth[rays[..., 2] >= 0]).all()
    assert set(np.unique(seen.instance)) == {-1, 1}


def test_radiance_is_reflectance_times_irradiance_plus_emission():
    light = Light((0, 0, 2), power=3.0, **POINT)
    world = World([floor(0.3, emission=0.7)], [light], INSIDE, bounce=False)
    camera = looking(np.array([0, 0.01, 1.0]), np.array([0.0, 0.0, 0.0]))
    seen = world.picture(camera.position, Lens((9, 9), 900.0).rays(camera.orientation))
    assert seen.color[4, 4, 1] == pytest.approx(0.3 * (3 / 4 + 0.7), rel=1e-3)
