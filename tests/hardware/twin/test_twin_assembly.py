"""Scenes of several materials: nearest part, reflectance across triangles, shares of both laws."""

import numpy as np
import pytest
from instrument_panels import psi, ready

from cmtof.correlation import centred, decode, phase_from_depth
from cmtof.instrument.optics import (
    SPECULAR_DIFFUSE,
    directions_from_angles,
    returned_fraction,
    trace,
)
from cmtof.instrument.scene import MeshTarget, assembled, scene_from
from cmtof.instrument.settings import Optics, TwinSettings
from cmtof.instrument.targets import Hits
from cmtof.instrument.world import World

pytest.importorskip("embreex")

SQUARE = np.array([[0, 1, 2], [0, 2, 3]])


def card(z, half=1.0, centre=0.0, **stuff):
    """A square across the axis at z, m."""
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    return MeshTarget(np.array([(centre + x, y, z) for x, y in corners], float), SQUARE, **stuff)


def grid(n=9, half=0.2):
    angles = np.linspace(-half, half, n) + 1e-4  # not on the diagonal that two triangles share
    return np.stack(np.meshgrid(angles, angles), -1).reshape(-1, 2)


def test_the_nearest_part_is_met():
    near = card(0.9, 0.05, reflectance=0.2)
    both = assembled([card(1.4, reflectance=0.7), near])
    hits = both.look(directions_from_angles(grid()))
    inside = np.isfinite(near.look(directions_from_angles(grid())).range)
    assert 0 < inside.sum() < inside.size
    np.testing.assert_allclose(hits.reflectance, np.where(inside, 0.2, 0.7))
    points = directions_from_angles(grid()) * hits.range[:, None]
    np.testing.assert_allclose(points[:, 2], np.where(inside, 0.9, 1.4))


@pytest.mark.parametrize("material", ["diffuse", "specular"])
def test_an_assembly_of_one_equals_its_part(material):
    part = card(1.1, reflectance=0.3, material=material)
    angles = grid(5, 0.002)
    one, other = (trace(t, angles, TwinSettings(), 3) for t in (part, assembled([part])))
    np.testing.assert_array_equal(one.range, other.range)
    np.testing.assert_allclose(one.fraction, other.fraction, rtol=3e-7)  # Embree has float32


def test_reflectance_is_interpolated_across_triangles():
    corners = np.array([[0, 0, 1], [0.2, 0, 1], [0, 0.2, 1]], float)
    target = MeshTarget(corners, np.array([[0, 1, 2]]), np.array([0.1, 0.5, 0.9]))
    x, y = np.array([0.05, 0.1, 0.02]), np.array([0.05, 0.02, 0.15])
    rays = directions_from_angles(np.arctan(np.stack([x, y], -1)))
    expected = 0.1 + 0.4 * x / 0.2 + 0.8 * y / 0.2
    np.testing.assert_allclose(target.look(rays).reflectance, expected, rtol=1e-5)


@pytest.mark.parametrize("weight", [0.0, 0.25, 1.0])
def test_both_laws_add_up_with_their_weights(weight):
    optics = Optics()
    hits = Hits(np.array([1.0, 1.2]), np.array([1.0, 0.999]), np.full(2, 0.6), np.full(2, weight))
    diffuse, specular, mixed = (
        returned_fraction(optics, material, hits) for material in ("diffuse", "specular", "mixed")
    )
    np.testing.assert_allclose(mixed, (1 - weight) * diffuse + weight * specular, rtol=1e-12)


def test_what_a_tilted_polished_surface_returns_is_its_diffuse_rest():
    hits = Hits(np.array(1.0), np.array(np.cos(0.1)), np.array(0.6), np.array(0.9))
    diffuse = returned_fraction(Optics(), "diffuse", hits)
    mixed = returned_fraction(Optics(), "mixed", hits)
    np.testing.assert_allclose(mixed / diffuse, 0.1 + 0.9 * SPECULAR_DIFFUSE)


def test_only_the_rough_share_speckles():
    angles = grid(40, 0.01)
    settings = TwinSettings()
    contrast = {}
    for weight in (0.0, 0.5):
        target = card(1.0, reflectance=0.5, material="mixed", mirrored=weight)
        light = trace(target, angles, settings, 0).fraction.sum(1)
        calm = trace(target, angles, TwinSettings(optics=Optics(speckle=False)), 0).fraction.sum(1)
        rough = (1 - weight) * returned_fraction(
            settings.optics, "diffuse", target.look(directions_from_angles(angles))
        )
        contrast[weight] = np.std((light - calm) / rough)
    # 1600 directions: the standard deviation of a contrast is 1/sqrt(3200), 1.8 %
    assert contrast[0.5] == pytest.approx(contrast[0.0], rel=0.05)


def test_the_whole_instrument_ranges_two_parts():
    target = assembled([card(1.2, reflectance=0.5), card(1.0, 0.1, 0.1, reflectance=0.2)])
    world = World(TwinSettings.ideal(), target)
    angles = np.array([[-0.05, 0.01], [0.08, 0.01]])
    panel = ready("single")
    assert world.ranges(angles)[0] > 1.2 > world.ranges(angles)[1]
    counts = world.image(panel, angles)
    found = decode(counts.T, psi())
    expected = phase_from_depth(world.ranges(angles), 7.15e9)
    difference = centred(np.diff(found.phase) - np.diff(expected))
    np.testing.assert_allclose(difference, 0, atol=2e-3)
    assert found.amplitude[0] > 1.5 * found.amplitude[1]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: card(1.0, mirrored=0.5), "Expected mirrored for the material mixed alone"),
        (lambda: card(1.0, material="mixed"), "Expected mirrored for the material mixed alone"),
        (lambda: card(1.0, reflectance=np.ones(3)), "Expected reflectance of all or of each of 4"),
        (
            lambda: card(1.0, material="mixed", mirrored=np.ones((4, 1))),
            "Expected mirrored of all or of each of 4",
        ),
        (lambda: assembled([card(1.0, material="retro")]), "Expected parts that are diffuse"),
        (lambda: scene_from({"kind": "object"}), "Expected name and other keys"),
        (lambda: scene_from({"kind": "object", "name": "cat"}), "Expected an object out of bust"),
    ],
)
def test_what_cannot_be_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
