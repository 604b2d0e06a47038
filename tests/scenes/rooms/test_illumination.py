"""Light against closed forms: lamps, the white furnace, shadows, patches of sun, mirrors."""

import numpy as np
import pytest

from cmtof.scenes.rooms import solids
from cmtof.scenes.rooms.assembly import Outdoors, assemble
from cmtof.scenes.rooms.illumination import Illumination, Points
from cmtof.scenes.rooms.materials import Material
from cmtof.scenes.rooms.thing import Light, Mesh, Thing, pose
from cmtof.scenes.rooms.tracing import Tracer
from cmtof.scenes.rooms.view import picture

pytest.importorskip("embreex")


def lit(things, lights=(), **outdoors):
    geometry = assemble(
        [(thing, pose()) for thing in things],
        rng=np.random.default_rng(0),
        lights=list(lights),
        outdoors=Outdoors(**outdoors),
    )
    return Illumination(geometry, Tracer(geometry.vertices, geometry.faces))


def plate(size, z, albedo=0.5, up=True, **material):
    h = size / 2
    corners = [(-h, -h, z), (h, -h, z), (h, h, z), (-h, h, z)]
    mesh = solids.quads([corners if up else corners[::-1]])
    return Thing("plate").add(mesh, Material((albedo,) * 3, **material))


def points(positions, normal=(0.0, 0.0, 1.0)):
    position = np.atleast_2d(np.asarray(positions, np.float32))
    normals = np.tile(np.float32(normal), (len(position), 1))
    order = np.arange(len(position), dtype=np.int32)
    return Points(position, normals, normals, -normals, np.zeros_like(position), order)


def lamp(z=2.0, half=0.01, power=3.0):
    return Light((0, 0, z), (half, 0, 0), (0, half, 0), power, (0.0, 0.0, -1.0))


def test_a_small_panel_obeys_both_cosines_and_the_inverse_square():
    scene = lit([plate(10, 0.0)], [lamp()])
    x = np.array([0.0, 0.5, 1.0, 3.0])
    places = points(np.column_stack([x, np.zeros(4), np.full(4, 1e-3)]))
    irradiance = scene.direct(places, samples=8)[0][:, 0]
    square = x**2 + (2 - 1e-3) ** 2
    assert irradiance == pytest.approx(3.0 * 4 / square**2, rel=0.02)


def test_a_large_panel_has_the_form_factor_of_a_square():
    half, height, power = 1.0, 0.8, 2.0
    scene = lit([plate(10, 0.0)], [lamp(z=height, half=half, power=power)])
    found = scene.direct(points(np.tile([0, 0, 1e-3], (4096, 1))), samples=4)[0][:, 0].mean()
    x = half / height  # Howell, A Catalog of Radiation Heat Transfer: element under a corner, B-4
    factor = 4 * 2 / (2 * np.pi) * x / np.hypot(1, x) * np.arctan(x / np.hypot(1, x))
    assert found == pytest.approx(np.pi * power / (2 * half) ** 2 * factor, rel=0.02)


def test_what_is_in_between_casts_a_shadow():
    scene = lit([plate(10, 0.0), plate(0.5, 1.0)], [lamp()])
    below, beside = points([0, 0, 1e-3]), points([2.0, 0, 1e-3])
    assert scene.direct(below, samples=4)[0].max() == 0
    assert scene.direct(beside, samples=4)[0].min() > 0


def test_the_order_of_lamps_does_not_matter_to_their_sum():
    two = [lamp(), Light((1.0, 1, 1.5), (0.01, 0, 0), (0, 0.01, 0), 0.7)]
    places = points(np.tile([0.3, 0.2, 1e-3], (4096, 1)))
    sums = [
        lit([plate(10, 0.0)], lights).direct(places, samples=4)[0].mean()
        for lights in (two, two[::-1])
    ]
    alone = [lit([plate(10, 0.0)], [one]).direct(places, samples=4)[0].mean() for one in two]
    assert sums == pytest.approx([sum(alone)] * 2, rel=0.02)


@pytest.mark.parametrize("albedo", [0.1, 0.5, 0.8])
def test_a_white_furnace_adds_up_three_bounces(albedo):
    box = solids.box((2, 2, 2))
    inside = Mesh(box.vertices, box.faces[:, ::-1].copy())
    walls = Thing("box").add(inside, Material((albedo,) * 3, specular=0.0, emission=1.0))
    scene = lit([walls])
    glow = albedo  # emission times colour
    direction = np.ones((8, 8, 3), np.float32)
    direction[..., 1:] = np.moveaxis(np.mgrid[-0.3:0.3:8j, -0.3:0.3:8j], 0, -1)
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    seen = picture(scene, np.zeros(3), direction).color
    series = glow * (1 + albedo + albedo**2)
    assert seen == pytest.approx(np.full_like(seen, series), rel=1e-4)


def test_scattered_rays_follow_the_cosine_law():
    # half of a hemisphere's cosine-weighted rays lie within 45 degrees: a disc of radius h
    disc = Thing("disc").add(
        solids.cylinder(1.0, 0.01, (0, 0, 1.0), sides=128), Material((1, 1, 1), emission=1.0)
    )
    scene = lit([disc])
    places = points(np.tile([0, 0, 0], (20000, 1)))
    assert scene.gathered(places, samples=1).mean() == pytest.approx(0.5, abs=0.01)


def test_the_sky_reaches_the_outdoors_only():
    scene = lit([plate(0.1, -1.0)], sky=5.0, house=(-1.0, 1.0, -1.0, 1.0))
    assert scene.gathered(points([3.0, 0, 0]), samples=4).mean() == pytest.approx(5.0)
    assert scene.gathered(points([0.0, 0, 0]), samples=4).max() == 0


def test_sun_falls_by_the_cosine_and_not_behind_a_roof():
    towards = (0.6, 0.0, 0.8)
    scene = lit([plate(4, 0.0), plate(1.0, 1.0)], towards_sun=towards, sun=7.0)
    open_air, shaded = points([1.5, 1.5, 1e-3]), points([-0.75, 0, 1e-3])
    assert scene.sunlight(open_air)[0][0, 0] == pytest.approx(7.0 * 0.8, rel=1e-5)
    assert scene.sunlight(shaded)[0].max() == 0


def test_a_patch_of_sun_keeps_the_light_that_fell_on_it():
    towards = np.array([-0.6, 0.0, 0.8])
    window = Light((-2.0, 0, 2.0), (0, 0.5, 0), (0, 0, 0.4), 3.0, (1.0, 0, 0))
    scene = lit([plate(20, 0.0, albedo=0.3)], [window], towards_sun=tuple(towards), sun=5.0)
    patch = scene.lights[-1]
    flux = 5.0 * (4 * 0.5 * 0.4) * 0.6  # irradiance, window, its cosine
    assert patch["power"] * np.pi == pytest.approx(0.3 * (1 - 0.03) * flux, rel=0.02)
    assert patch["centre"] == pytest.approx([-2.0 + 2.0 * 0.6 / 0.8, 0, 0.01], abs=0.01)
    assert np.linalg.norm(patch["half_u"]) == pytest.approx(0.5, rel=0.02)
    assert np.linalg.norm(patch["half_v"]) == pytest.approx(0.4 * 0.6 / 0.8, rel=0.02)
    assert patch["normal"] == pytest.approx([0, 0, 1])


def test_a_mirror_shows_what_stands_before_it():
    glass = plate(4, 0.0, albedo=1.0, specular=0.95, gloss=3000.0)
    screen = plate(4, 2.0, albedo=0.9, up=False, emission=1.0)
    scene = lit([glass, screen])
    down = np.float32([[[0.0, 0.0, -1.0]]])
    seen = picture(scene, np.array([0.0, 0.0, 1.0]), down).color[0, 0, 1]
    assert seen == pytest.approx(0.95 * 0.9, rel=0.1)


def test_range_is_exact_to_a_micrometre_along_the_ray():
    scene = lit([plate(60, 0.0)])
    eye = np.array([0.1, -0.2, 3.0])
    direction = np.random.default_rng(0).normal(size=(20, 20, 3))
    direction[..., 2] = -np.abs(direction[..., 2]) - 1.0
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    seen = picture(scene, eye, direction.astype(np.float32))
    exact = eye[2] / -direction[..., 2].astype(np.float32).astype(float)
    assert np.abs(seen.depth - exact).max() < 1e-6
    assert seen.depth.dtype == np.float32
    assert seen.normal.reshape(-1, 3) == pytest.approx(np.tile([0, 0, 1], (400, 1)))


def test_a_ray_that_leaves_has_no_depth_no_instance_and_the_sky():
    scene = lit([plate(1, 0.0)], sky=3.0)
    up = np.float32([[[0.0, 0.0, 1.0]]])
    seen = picture(scene, np.array([0.0, 0, 1]), up)
    assert np.isnan(seen.depth).all()
    assert seen.instance.tolist() == [[-1]]
    assert seen.color.ravel() == pytest.approx(3.0)
    assert not seen.normal.any()


def test_the_same_scene_gives_the_same_bytes():
    def once():
        scene = lit([plate(4, 0.0), plate(1.0, 1.0)], [lamp()], sun=2.0)
        grid = np.mgrid[-1:1:32j, -1:1:32j]
        rays = np.stack([*grid, np.full((32, 32), -1.0)], -1)
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        seen = picture(scene, np.array([0.0, 0, 1.9]), rays.astype(np.float32))
        return b"".join(part.tobytes() for part in seen)

    assert once() == once()


def test_missing_embree_names_the_extra(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "embreex.rtcore_scene", None)
    with pytest.raises(ValueError, match=r"Expected Embree .* pip install cmtof\[rooms\]"):
        Tracer(np.zeros((3, 3), np.float32), np.zeros((1, 3), np.int32))
