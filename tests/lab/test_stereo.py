"""Two cameras beside the scanner: calibration, triangulation, spots, occlusion and wrap labels."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from pytest import approx, fixture, mark
from walls import WRAP, lit

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import TAU, phase_from_depth
from cmtof.frame import ray_lengths
from cmtof.pointcloud import points_from_depth
from cmtof_lab import stereo
from cmtof_lab.spots import photographed_spots

RIG = stereo.simulated_rig()
CAMERA = [60.0, 60.0, 20.0, 15.0]
SHAPE = (30, 40)


def planar(depth):
    """Frame of a planar depth, m."""
    return lit(depth * ray_lengths(SHAPE, CAMERA), 0.5, CAMERA)


def points_of(frame):
    return points_from_depth(frame.depth, frame.camera)


WALL = planar(1.5)
# a post of 10 columns, 0.9 m away, before a wall at 1.8 m
COLUMNS = np.arange(40)
POST = planar(np.where((COLUMNS < 15) | (COLUMNS >= 25), 1.8, 0.9))


@fixture
def spots():
    """Spots of every pixel of the wall where they truly are."""
    pixels = RIG.project(points_of(WALL))
    return stereo.Spots(pixels, np.full(pixels.shape[:-1], 0.05))


@given(st.floats(-0.3, 0.3), st.floats(-0.25, 0.25), st.floats(0.6, 8))
def test_triangulation_inverts_projection(x, y, z):
    point = np.array([x * z, y * z, z])
    assert_allclose(RIG.triangulate(RIG.project(point)), point, atol=1e-6 * z**2)


def test_points_behind_and_missing_spots_are_nan():
    assert np.isnan(RIG.project([0.1, 0.1, -1.0])).all()
    pixels = RIG.project([[0.1, 0.1, 1.0], [0.0, 0.2, 2.0]])
    pixels[1, 0] = np.nan
    assert np.isnan(RIG.triangulate(pixels)).all(-1).tolist() == [True, False]


def test_depth_noise_follows_the_closed_form(rng, z=4.0):
    """sigma_z = sqrt(2) z^2 sigma / (f b): 4000 draws know it to 1.1 %; the margin is 5 %."""
    exact_pixels = RIG.project([0.0, 0.0, z])[:, None]
    found = RIG.triangulate(exact_pixels + 0.1 * rng.standard_normal((2, 4000, 2)))
    focal = RIG.matrices[0, 0, 0]
    baseline = np.linalg.norm(np.diff(RIG.centres, axis=0))
    assert baseline == approx(0.3)
    expected = np.sqrt(2) * z**2 * 0.1 / focal / baseline
    assert found[:, 2].std() == approx(expected, rel=0.05)


def between(rig):
    """Rotation vector and shift from the first camera to the second."""
    return (rig.poses[1] * rig.poses[0].inv()).as_exp_coords()


def test_boards_calibrate_each_camera_of_the_rig(rng):
    """Corners are single precision, 1e-4 px; the two lenses differ."""
    matrices = RIG.matrices.copy()
    matrices[1, :2] *= 1.02
    rig = replace(RIG, matrices=matrices)
    poses = stereo.board_poses(rig, 4, rng=rng)
    seen = np.stack([rig.project(p.apply(stereo.BOARD)) for p in poses], axis=1)
    found, rms = stereo.calibrate(seen, rig.shape)
    assert rms < 1e-3
    assert_allclose(found.matrices, rig.matrices, atol=0.05)
    assert_allclose(found.distortions, rig.distortions, atol=1e-3)
    assert_allclose(between(found), between(rig), atol=1e-4)


def test_spots_locate_the_scanner(rng):
    rig = replace(RIG, poses=tuple(pose * RIG.poses[0].inv() for pose in RIG.poses))
    beams = points_of(planar(1.5 + 0.01 * COLUMNS))
    pixels = RIG.project(beams) + 0.1 * rng.standard_normal((2, *SHAPE, 2))
    pixels[:, ::3] = np.nan
    found = stereo.locate_scanner(rig, pixels, 3.7 * beams)
    assert_allclose(found.centres, RIG.centres, atol=1e-3)


def windows(rng, brightness, sigma, count=1500):
    """Noisy windows (N, S, S), electrons, and where their spots lie."""
    places = stereo.WINDOW / 2 + rng.uniform(-0.5, 0.5, (count, 2))
    look = np.full((2, count), [[brightness], [sigma]])
    return photographed_spots(places, *look, rng, stereo.SENSOR), places


@mark.parametrize(
    "brightness, sigma",
    [
        (1500, 0.9),
        (30_000, 1.5),
    ],
)
def test_spots_are_placed_as_well_as_stated(brightness, sigma, rng):
    """3000 coordinates: their deviation is known to 1.3 %; the margin is 8 %."""
    light, places = windows(rng, brightness, sigma)
    found, stated = stereo.place_spots(light, stereo.Sensor(contrast=0.0))
    assert np.isfinite(stated).mean() > 0.99
    error = (found - places) / stated[:, None]
    assert np.nanstd(error) == approx(1, abs=0.08)
    assert abs(np.nanmean(error, axis=0)).max() < 4 / np.sqrt(1500)
    # the Cramer-Rao bound of a spot without background
    assert np.nanmedian(stated) > sigma / np.sqrt(brightness)


def test_no_spot_and_saturated_spots_are_refused(rng):
    dark, _ = windows(rng, 0.0, 1.1)
    full, _ = windows(rng, 4e5, 1.1, count=20)
    lost_dark, lost_full = (
        np.isnan(stereo.place_spots(light, stereo.SENSOR)[1]) for light in (dark, full)
    )
    assert lost_dark.mean() > 0.998
    assert lost_full.all()


def test_a_post_hides_what_geometry_says():
    """From 0.15 m aside the post's edge at 0.9 m hides 0.15 m of the wall at 1.8 m: 5 px."""
    hidden = np.flatnonzero(~stereo.visible_from(points_of(POST), (0.15, 0, 0))[15])
    assert 4 <= len(hidden) <= 6
    assert len(set(hidden) & set(range(10, 15))) >= 4


def test_stereo_alone_is_in_doubt_near_a_wraps_boundary(spots):
    truth = stereo.truth_from_spots(spots, RIG, sigmas=2.0)
    place = WALL.depth % WRAP
    margin = 2.0 * truth.uncertainty
    near = (place < margin) | (place > WRAP - margin)
    assert (truth.mask == ~near).mean() > 0.999
    assert 0.02 < near.mean() < 0.9
    assert_array_equal(truth.wraps[truth.mask], (WALL.depth // WRAP)[truth.mask])


def test_a_wrong_pair_is_seen_across_the_epipolar_line(spots):
    spots.pixels[1, 3, 4, 1] += 1.0  # 14 of its standard deviations
    truth = stereo.truth_from_spots(spots, RIG, phase=np.zeros(SHAPE))
    assert np.isnan(truth.range[3, 4])
    assert truth.mask.sum() == truth.mask.size - 1


def test_labels_of_a_simulated_scan_are_right_and_silent_where_hidden(rng):
    spots = stereo.scan_spots(POST, RIG, rng=rng)
    phase = phase_from_depth(POST.depth, FREQUENCY_SINGLE) % TAU
    truth = stereo.truth_from_spots(spots, RIG, phase=phase)
    seen = np.all(
        [stereo.visible_from(points_of(POST), c) for c in RIG.centres], axis=0
    )
    assert not truth.mask[~seen].any()
    assert truth.mask.mean() > 0.6
    # k = 3: at most 0.3 % of labels may err
    assert (truth.wraps == POST.depth // WRAP)[truth.mask].mean() > 0.99
    assert np.nanstd((truth.range - POST.depth) / truth.uncertainty) == approx(
        1, abs=0.12
    )
