import numpy as np
import pytest

from cmtof.scenes.rooms import solids
from cmtof.scenes.rooms.assembly import assemble
from cmtof.scenes.rooms.cameras import Lens, close_cameras, looking, room_cameras
from cmtof.scenes.rooms.materials import Material
from cmtof.scenes.rooms.thing import Mesh, Thing, pose
from cmtof.scenes.rooms.tracing import Tracer

pytest.importorskip("embreex")
WHITE = Material((0.8, 0.8, 0.8))
FLOOR = [(0.0, 6.0, 0.0, 5.0)]


@pytest.fixture(scope="module")
def furnished():
    box = solids.box((6, 5, 2.6), (3, 2.5, 1.3))
    placed = [(Thing("walls").add(Mesh(box.vertices, box.faces[:, ::-1].copy()), WHITE), pose())]
    rng = np.random.default_rng(0)
    for k in range(10):
        crate = Thing(f"crate {k}").add(solids.box((0.4, 0.3, 0.5), (0, 0, 0.25)), WHITE)
        placed.append((crate, pose(rng.uniform(0.5, 5.5), rng.uniform(0.5, 4.5))))
    geometry = assemble(placed, rng=rng)
    return geometry, Tracer(geometry.vertices, geometry.faces)


def test_orientation_is_a_rotation_that_looks_at_its_target():
    camera = looking(np.array([1.0, 2.0, 3.0]), np.array([4.0, -1.0, 1.0]), roll=0.3)
    assert camera.orientation.T @ camera.orientation == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(camera.orientation) == pytest.approx(1.0)
    ahead = np.array([3.0, -3.0, -2.0])
    assert -camera.orientation[:, 2] == pytest.approx(ahead / np.linalg.norm(ahead))


def test_the_ray_through_the_middle_goes_ahead_and_the_corner_by_the_lens():
    lens = Lens((4, 6), 5.0)
    rays = lens.rays(np.eye(3))
    assert rays[1:3, 2:4].mean(axis=(0, 1)) == pytest.approx([0, 0, -0.99], abs=0.01)
    corner = np.array([-2.5, 1.5, -5.0])  # centre of the upper left pixel
    assert rays[0, 0] == pytest.approx(corner / np.linalg.norm(corner), abs=1e-6)


def test_people_stand_in_the_air_above_the_floor(furnished):
    geometry, tracer = furnished
    cameras = room_cameras(
        6, floor=FLOOR, height=2.6, tracer=tracer, geometry=geometry,
        lens=Lens((64, 64), 55.0), rng=np.random.default_rng(1),
    )  # fmt: skip
    directions = np.random.default_rng(2).normal(size=(200, 3)).astype(np.float32)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for camera in cameras:
        x, y, z = camera.position
        assert 0 < x < 6 and 0 < y < 5 and 1.0 <= z <= 1.9
        start = np.tile(camera.position.astype(np.float32), (200, 1))
        assert tracer.nearest(start, directions).distance.min() > 0.15
        assert abs(camera.orientation[2, 0]) < 0.2  # nearly level


def test_close_views_look_at_a_thing_from_half_a_metre_to_twelve_tenths(furnished):
    geometry, tracer = furnished
    lens = Lens((64, 64), 55.0)
    cameras = close_cameras(
        6, things=np.arange(2, 12), floor=FLOOR, height=2.6, tracer=tracer, geometry=geometry,
        lens=lens, rng=np.random.default_rng(1),
    )  # fmt: skip
    for camera in cameras:
        rays = lens.rays(camera.orientation).reshape(-1, 3)
        start = np.tile(camera.position.astype(np.float32), (len(rays), 1))
        hits = tracer.nearest(start, rays)
        middle = hits.distance.reshape(64, 64)[28:36, 28:36]
        assert 0.3 < np.median(middle) < 1.4
        seen = geometry.instance[geometry.part[hits.triangle.reshape(64, 64)[28:36, 28:36]]]
        assert (seen > 1).any()


def test_more_views_leave_the_first_as_they_were(furnished):
    geometry, tracer = furnished
    few, many = (
        room_cameras(
            n, floor=FLOOR, height=2.6, tracer=tracer, geometry=geometry,
            lens=Lens((64, 64), 55.0), rng=np.random.default_rng(1),
        )
        for n in (2, 5)
    )  # fmt: skip
    for a, b in zip(few, many, strict=False):
        assert np.array_equal(a.position, b.position)
        assert np.array_equal(a.orientation, b.orientation)
