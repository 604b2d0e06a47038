"""Where rays end: planes, corner cubes, frames, meshes; and the settings' strict keys."""

from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest
from instrument_panels import ahead, psi, ready

from cmtof.correlation import decode
from cmtof.instrument.frame_target import FrameTarget
from cmtof.instrument.optics import directions_from_angles
from cmtof.instrument.scene import MeshTarget, scene_from
from cmtof.instrument.settings import Laser, TwinSettings
from cmtof.instrument.targets import Corner, Plane
from cmtof.instrument.world import World
from cmtof.scenes.frame import Frame, rays_from_camera

CAMERA = np.array([60.0, 70.0, 16.0, 12.0])


def rays(x, y):
    return directions_from_angles(np.arctan(np.stack(np.broadcast_arrays(x, y), axis=-1)))


def test_straight_ahead_is_plus_z():
    np.testing.assert_array_equal(directions_from_angles([0.0, 0.0]), [0, 0, 1])
    right, down = directions_from_angles([[0.1, 0.0], [0.0, 0.1]])
    assert right[0] > 0
    assert down[1] > 0
    np.testing.assert_allclose(right[0] / right[2], np.tan(0.1))


@pytest.mark.parametrize("tilt", [-0.6, 0.0, 0.6])
def test_plane(tilt):
    x, y = np.array([-0.2, 0.0, 0.2]), np.array([0.1, 0.0, -0.1])
    directions = rays(x, y)
    hits = Plane(1.5, tilt_x=tilt).look(directions)
    points = directions * hits.range[:, None]
    np.testing.assert_allclose(points[:, 2], 1.5 + np.tan(tilt) * points[:, 0])
    assert hits.cosine[1] == pytest.approx(np.cos(tilt))
    mirrored = Plane(1.5, tilt_x=-tilt).look(rays(-x, y))
    np.testing.assert_allclose(mirrored.range, hits.range)


def test_plane_that_is_never_met():
    assert np.isnan(Plane(1.0, tilt_x=1.5).look(rays(0.2, 0.0)).range)


def test_corner_cube():
    hits = Corner(2.0, radius=0.01).look(rays(np.array([0.0, 0.004, 0.006]), 0.0))
    assert hits.range[0] == 2.0
    assert hits.range[1] == pytest.approx(2.0 * np.cos(np.arctan(0.004)))
    assert np.isnan(hits.range[2])


def wall(slope):
    """Frame of a plane z = 2 + slope x, as ranges; intensity by column."""
    grid = rays_from_camera((24, 32), CAMERA)
    planar = 2 / (1 - slope * grid[..., 0])
    depth = planar * np.linalg.norm(grid, axis=-1)
    return Frame(depth, np.tile(np.linspace(0, 2, 32), (24, 1)), CAMERA)


@pytest.mark.parametrize("slope", [-0.5, 0.0, 0.5])
def test_frames_of_planes_are_exact_between_pixels(slope):
    target = FrameTarget(wall(slope))
    x = np.linspace(-0.2, 0.2, 37)
    directions = rays(x, 0.03)
    exact = Plane(2.0, tilt_x=np.arctan(slope)).look(directions)
    hits = target.look(directions)
    np.testing.assert_allclose(hits.range, exact.range, rtol=3e-7)
    np.testing.assert_allclose(hits.cosine, exact.cosine, atol=0.01)
    assert hits.reflectance.max() <= 1  # intensity is clipped as the simulator clips it


def test_steps_in_a_frame_stay_sharp():
    depth = np.where(np.arange(32) < 16, 1.0, 2.0) * np.ones((24, 1))
    target = FrameTarget(Frame(depth, np.ones((24, 32)), CAMERA))
    found = target.look(rays(np.linspace(-0.2, 0.2, 400), 0.0)).range
    assert (np.minimum(np.abs(found - 1), np.abs(found - 2)) < 0.05).all()


def test_a_spot_on_a_step_mixes_both_sides():
    """Five quarters of a wrap: three quarters of the spot's weight against one, at right angles."""
    depth = np.where(np.arange(32) < 16, 1.0, 1.0262) * np.ones((24, 1))
    frame = Frame(depth, np.ones((24, 32)), CAMERA)
    settings = TwinSettings.ideal()
    settings = replace(settings, optics=replace(settings.optics, divergence=20e-3))
    world = World(settings, frame)
    centre, left = decode(
        world.image(ready("single"), [[0.0, 0.0], [-0.1, 0.0]]).T, psi()
    ).amplitude
    assert centre / left == pytest.approx(np.hypot(0.75, 0.25), rel=0.05)


@pytest.mark.parametrize("material", ["diffuse", "specular", "retro"])
def test_mesh_equals_the_plane_that_it_is_made_of(material):
    pytest.importorskip("embreex")
    corners = np.array([[-1, -1, 1.7], [1, -1, 1.7], [1, 1, 2.3], [-1, 1, 2.3]], float)
    mesh = MeshTarget(corners, np.array([[0, 1, 2], [0, 2, 3]]), 0.4, material)
    plane = Plane(2.0, tilt_y=np.arctan(0.3), reflectance=0.4, material=material)
    directions = rays(*np.meshgrid(np.linspace(-0.3, 0.3, 5), np.linspace(-0.2, 0.2, 4)))
    found, expected = mesh.look(directions), plane.look(directions)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6)
    assert np.isnan(mesh.look(rays(2.0, 0.0)).range)
    assert mesh.material == material


def test_mesh_from_a_file(tmp_path):
    pytest.importorskip("embreex")
    pytest.importorskip("trimesh")
    path = tmp_path / "wall.obj"
    path.write_text("v -1000 -1000 900\nv 1000 -1000 900\nv 0 2000 900\nf 1 2 3\n")
    target = made({"kind": "mesh", "file": str(path), "scale": 1e-3, "reflectance": 0.7})
    hits = target.look(rays(0.0, 0.0))
    assert float(hits.range) == pytest.approx(0.9)
    assert float(hits.reflectance) == 0.7


def test_scenes_by_setting(tmp_path):
    assert scene_from(None) is None
    plane = Plane(1.0)
    assert scene_from(plane) is plane
    assert made("room").material == "diffuse"
    assert made({"kind": "frame", "file": "room", "material": "retro"}).material == "retro"
    mirror = made({"kind": "mirror", "distance": 0.6, "tilt_x": 0.01})
    assert mirror == Plane(0.6, tilt_x=0.01, material="specular")
    assert made({"kind": "corner", "distance": 2.0}) == Corner(2.0)
    wall(0.1).save(tmp_path / "wall.npz")
    assert made(tmp_path / "wall.npz").look(rays(0.0, 0.0)).range == pytest.approx(2.0)


def made(source):
    target = scene_from(source)
    assert target is not None
    return target


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (7, "Expected twin.scene to be a name or a mapping, got 7"),
        ({"kind": "sphere"}, "Expected twin.scene.kind out of plane, mirror, corner, frame, mesh"),
        ({"distance": 1.0}, "got None"),
        ({"kind": "plane"}, "Expected distance and other keys"),
        ({"kind": "plane", "distance": 1.0, "colour": 3}, "got colour, distance"),
        ({"kind": "plane", "distance": 1.0, "material": "wood"}, "Expected twin.scene.material"),
        ({"kind": "mesh"}, "Expected file and other keys"),
    ],
)
def test_bad_scenes(scene, message):
    with pytest.raises(ValueError, match=message):
        scene_from(scene)


def test_frames_need_a_camera():
    with pytest.raises(ValueError, match="Expected a frame with a camera"):
        scene_from(Frame(np.ones((2, 2)), np.ones((2, 2))))


# --- settings ----------------------------------------------------------------------------------


def test_settings_from_a_mapping():
    found = TwinSettings.from_mapping(
        {
            "laser": {"power": 1},
            "detector": {"bits": 14, "rc_time": 0.1},
            "emission": {"half_wave_angle_error": -0.01},
            "optics": {"speckle": False},
            "reference": {"material": "specular", "reflectance": 1e-6},
            "noise": False,
            "scene": "room",
            "faults": [{"device": "daq", "kind": "silence"}],
        }
    )
    assert found.laser.power == 1.0
    assert found.detector.bits == 14
    assert found.detection.half_wave_angle_error == 0.0
    assert found.scene == "room"
    assert found.faults == [{"device": "daq", "kind": "silence"}]
    assert TwinSettings.from_mapping(None) == TwinSettings()
    assert World(found).scene is not None


@pytest.mark.parametrize(
    ("raw", "message"),
    [
        ([], "Expected twin to be a mapping"),
        ({"lasr": {}}, "Expected keys of twin out of laser, .*got 'lasr'"),
        ({"laser": {"pwr": 1}}, "Expected keys of twin.laser out of power, .*got 'pwr'"),
        ({"laser": 3}, "Expected twin.laser to be a mapping, got 3"),
        ({"laser": {"power": "1"}}, "Expected twin.laser.power to be a number, got '1'"),
        ({"laser": {"power": True}}, "Expected twin.laser.power to be a number, got True"),
        ({"drive": {"resonance": "7e9"}}, "an exponent needs its sign"),
        ({"laser": {"power": -1}}, "Expected twin.laser.power from 0 to 10, got -1"),
        ({"laser": {"power": float("nan")}}, "got nan"),
        ({"emission": {"plate_zero": 90}}, "Expected twin.emission.plate_zero from -7 to 7"),
        ({"detector": {"bits": 14.5}}, "Expected twin.detector.bits to be a whole number"),
        ({"detector": {"bits": 14.0}}, "Expected twin.detector.bits to be a whole number"),
        ({"detector": {"bits": 24}}, "Expected twin.detector.bits from 4 to 16, got 24"),
        ({"optics": {"speckle": 1}}, "Expected twin.optics.speckle to be true or false, got 1"),
        ({"noise": "no"}, "Expected twin.noise to be true or false"),
        ({"reference": {"material": "wood"}}, "Expected twin.reference.material out of diffuse"),
        ({"laser": {"fibre_low": 0.4}}, "Expected twin.laser.fibre_high from 0.4 on"),
    ],
)
def test_bad_settings(raw, message):
    with pytest.raises(ValueError, match=message):
        TwinSettings.from_mapping(raw)


def test_bad_settings_from_python():
    with pytest.raises(ValueError, match=r"Expected twin's Laser.power from 0 to 10, got -3"):
        Laser(power=-3)


def test_every_number_has_limits_that_its_default_keeps():
    for section in fields(TwinSettings):
        default = getattr(TwinSettings(), section.name)
        if is_dataclass(default):
            for entry in fields(default):
                if isinstance(entry.default, float):
                    assert entry.metadata["low"] <= entry.default <= entry.metadata["high"]


def test_ideal_settings_are_silent():
    world = World(TwinSettings.ideal(), Plane(1.0))
    counts = world.image(ready("single"), ahead(2), labels=[1, 900])
    np.testing.assert_array_equal(counts[0], counts[1])
