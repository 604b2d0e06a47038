"""The whole method: exact without noise, far ahead with it, unmoved by what must not matter."""

import numpy as np
from exact_scenes import (
    CAMERA,
    COLUMNS,
    SHAPE,
    WRAP,
    corner_scene,
    exact_field,
    plane_depth,
    plane_frame,
)
from pytest import approx, fixture, mark
from scores import images, scores
from walls import lit

import cmtof
from cmtof.constants import FREQUENCIES
from cmtof.frame import Frame
from cmtof.measurement import Measurement
from cmtof.simulation import simulate
from cmtof.surfaces import stages, surfaces_mirrored
from cmtof.surfaces.method import STEPS
from cmtof.surfaces.mirrored import mirror_image
from cmtof.surfaces.votes import depth_by_votes, slopes_of_surfaces


def right(measurement, within=1, **options):
    """Share of scored pixels whose count is off by less than that."""
    return scores(measurement, **options)[f"delta_lt_{within}"]


@fixture(scope="module")
def corner():
    return corner_scene()


@fixture(scope="module")
def clean_corner(corner):
    return simulate(corner.frame, protocol="full", noise_free=True)


@fixture(scope="module")
def clean(clean_corner):
    return images(clean_corner)


def test_the_corner_without_noise_is_exact_whatever_is_left_out(
    corner, clean_corner, clean
):
    # what is left are single pixels along the edges
    assert (abs(clean[1] - corner.frame.depth) < 1e-4).mean() >= 0.995
    for option in STEPS:
        assert right(clean_corner, without=[option]) > 0.99


def test_the_corner_with_noise_beats_the_random_field(corner):
    """A share of 20 480 pixels is known to 0.3 %, and draws of mrf spread by 10 %."""
    m = simulate(corner.frame, protocol="full", seed=0)
    ours = right(m)
    assert ours > 0.85
    assert ours > right(m, method="mrf") + 0.2


def test_a_wide_plane_is_right_in_the_papers_noise():
    """Its pooled phase is known to 1 mrad, so that only pixels at a boundary can be off."""
    ahead, steep = (plane_frame(normal, 0.6) for normal in ((0, 0, 1), (-0.1, 0.6, 1)))
    # straight ahead also through a lens other than the one that is assumed
    for frame in (ahead, steep, lit(ahead.depth)):
        assert right(simulate(frame, protocol="full", seed=1), within=2) > 0.99


def test_a_turned_image_has_a_turned_answer(clean_corner, clean):
    """Its camera is turned as well."""
    data = clean_corner.dataset
    turned = data.rename(y="x", x="y").transpose("frequency", "step", "y", "x", ...)
    turned["camera"] = data["camera"][[1, 0, 3, 2]]
    assert (clean[0] == images(Measurement(turned))[0].T).mean() >= 0.98


def test_the_vote_is_the_same_for_a_mirror_image(corner):
    m = simulate(corner.frame)
    found = surfaces_mirrored(mirror_image(m, -1, -1)).depth
    assert np.allclose(found[::-1, ::-1], surfaces_mirrored(m).depth)


def test_components_are_bodies_whose_surfaces_meet(clean_corner):
    """Walls, floor and box meet; two planes with darkness between them do not."""
    room = cmtof.unwrap(clean_corner)
    assert (room.component == 1).mean() > 0.95
    assert room.component_odds.sel(number=1, offset=0) > 0.9
    left, _ = plane_depth((0, 0.5, 1), 2)
    right, _ = plane_depth((0, 0, 1), 3)
    light = abs(COLUMNS - 90) > 10
    apart = lit(np.where(COLUMNS < 90, left, right), light, CAMERA)
    result = cmtof.unwrap(simulate(apart, protocol="full", seed=1))
    assert (result.component[:, :75] == 1).mean() > 0.95
    assert (result.component[:, 105:] == 2).mean() > 0.95


@mark.parametrize("kind", ["waves", "rough"])
def test_uneven_walls_keep_their_wraps(kind, rng):
    """Waves of 0.1 wraps over 24 px, or 0.12 wraps (rms) a pixel; unevenness is followed too."""
    wall = plane_frame((-0.1, 0.6, 1), 0.6)
    rows, columns = np.indices(SHAPE)
    waves = 0.1 * np.sin(2 * np.pi / 24 * (columns + 0.5 * rows))
    uneven = waves if kind == "waves" else 0.12 * rng.normal(size=SHAPE)
    frame = Frame(wall.depth + WRAP * uneven, wall.intensity, wall.camera)
    m = simulate(frame, protocol="full", seed=1)
    assert right(m, within=2) > 0.97
    assert right(m) > 0.85


def test_one_frame_shows_the_offset_between_its_frequencies():
    """By what beats exceed shapes, within 4 deviations: they were 0.08 wraps in 24 draws."""
    room = corner_scene((256, 320), tuple(2 * np.array(CAMERA))).frame
    for number, offset in enumerate((0.0, 0.01, -0.03)):
        m = simulate(room, phase_offset=(0, offset), seed=number)
        wraps = offset / (2 * np.pi * (FREQUENCIES[1] / FREQUENCIES[0] - 2))
        assert stages(m).offsets.closure == approx(wraps, abs=0.32)
    assert stages(m, ["closure"]).offsets.closure == 0


NEAR, _ = plane_depth((0.2, 0.1, 1), 1.5)


def exact_share(m, depth):
    """Share of the valid pixels whose depth is right to a ten-thousandth of a metre."""
    return (abs(images(m)[1] - depth)[m.mask] < 1e-4).mean()


def test_phases_alone_do_not_say_how_noisy_they_are(exact):
    assert exact_share(exact(NEAR, camera=CAMERA), NEAR) > 0.99


@mark.parametrize(
    "frequencies, scale",
    [
        ((7.15e9, 14.28e9), 1),  # the beat turns the other way
        ((7.15e9, 7.2e9), 1),  # a near twin
        ((5e9, 15.05e9), 1),
        ((7.15e7, 1.432e8), 100),
    ],
)
def test_other_frequencies(frequencies, scale):
    frame = lit(scale * NEAR, camera=CAMERA)
    m = simulate(frame, protocol="full", noise_free=True, frequencies=frequencies)
    assert exact_share(m, frame.depth) > 0.99


def test_clear_pixels_vote_where_no_surface_explains_them(rng):
    """Clutter of 4 px without noise: surfaces, which need 12 px, fail, and neighbours decide."""
    depth = np.kron(rng.uniform(0.8, 1.1, (16, 20)), np.ones((4, 4)))
    assert right(simulate(lit(depth), noise_free=True)) > 0.9


def test_neighbours_vote_along_the_slope_of_their_surface():
    """A plane that falls by 0.6 wraps a pixel, beside pixels that no surface explains."""
    depth, _ = plane_depth((-0.7, 0, 1))
    field = exact_field(depth, information=5000.0)
    assert np.median(np.diff(depth)) == approx(0.6 * WRAP, rel=0.1)
    explained = np.broadcast_to(COLUMNS % 8 < 4, SHAPE)
    astray = np.where(explained, depth, depth - WRAP)
    slopes = slopes_of_surfaces(depth / WRAP, np.zeros(SHAPE, int))
    found, share = depth_by_votes(field, astray, slopes, explained, 0.0)
    assert share[~explained].all()
    assert (abs(found - depth)[~explained] < WRAP / 2).all()


def test_images_whose_surfaces_lie_outside_the_mask_are_unwrapped():
    """A wall that is masked beside dark pixels that are not."""
    mask = np.broadcast_to(COLUMNS < 16, SHAPE)
    m = simulate(
        plane_frame((0, 0, 1), np.where(mask, 0.0, 1.0)), protocol="full", seed=0
    )
    count, depth, _ = images(Measurement(m.dataset.assign(mask=(("y", "x"), mask))))
    assert (count[mask] >= 0).all()
    assert np.isfinite(depth[mask]).all()
