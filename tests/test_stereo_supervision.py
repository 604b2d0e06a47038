"""Pseudo-true wrap maps: right where they speak, silent where they cannot know."""

import numpy as np
import pytest

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import TAU, wrap_length
from cmtof.scenes.frame import Frame, ray_lengths
from cmtof.stereo import (
    Lighting,
    Reason,
    Sensor,
    Spots,
    Status,
    pseudo_truth,
    record,
    simulated_rig,
    truth_from_spots,
    view_scene,
    visible_from,
)

RIG = simulated_rig()
WRAP = float(wrap_length(FREQUENCY_SINGLE))
CAMERA = np.array([60.0, 60.0, 20.0, 15.0])
SHAPE = (30, 40)


def planar(depth) -> np.ndarray:
    """Range along the rays of a planar depth, m."""
    return np.broadcast_to(depth, SHAPE) * ray_lengths(SHAPE, CAMERA)


def wall(depth=1.5, intensity=0.5) -> Frame:
    return Frame(planar(depth), np.full(SHAPE, intensity), CAMERA, "wall")


def stepped() -> Frame:
    """A post of 10 columns, 0.9 m away, before a wall at 1.8 m."""
    depth = np.full(SHAPE, 1.8)
    depth[:, 15:25] = 0.9
    return Frame(planar(depth), np.full(SHAPE, 0.5), CAMERA, "post")


def ideal(frame: Frame, rig=RIG, sigma=0.05) -> tuple[Spots, Spots]:
    """Exact spots of every pixel, with a stated covariance and nothing in the way."""
    scene = view_scene(frame, rig)
    found = []
    for pixels in scene.pixels:
        shape = pixels.shape[:2]
        covariance = np.broadcast_to(sigma**2 * np.eye(2), (*shape, 2, 2))
        found.append(
            Spots(pixels, covariance, np.ones(shape), np.ones(shape), np.zeros(shape, np.int8))
        )
    return found[0], found[1]


def phase_of(depth) -> np.ndarray:
    return np.mod(TAU * depth.astype(float) / WRAP, TAU)


# --- hidden surfaces ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "centre", [(-0.15, 0, 0), (0.15, 0, 0), (0.0, 0.2, 0.1), (0.1, -0.1, -0.1)]
)
@pytest.mark.parametrize("slope", [(0, 0), (0.6, 0), (0.0, -0.7), (-0.5, 0.5)])
def test_no_plane_hides_itself(centre, slope):
    y, x = np.indices(SHAPE)
    inverse = 0.6 + slope[0] * (x - 20) / 60 + slope[1] * (y - 15) / 60
    assert visible_from(planar(1 / inverse), CAMERA, centre).all()


@pytest.mark.parametrize("side", [-1, 1])
def test_a_post_hides_what_geometry_says(side):
    centre = np.array([side * 0.15, 0, 0])
    seen = visible_from(stepped().depth, CAMERA, centre)
    assert seen[:, 15:25].all()
    # from 0.15 m aside the post's far edge at 0.9 m hides 0.15 m of the wall at 1.8 m: 5 px
    hidden = ~seen[15]
    edge = np.arange(10, 15) if side > 0 else np.arange(25, 30)
    assert hidden[edge].sum() >= 4
    assert hidden.sum() <= 6
    assert not hidden[np.arange(25, 40) if side > 0 else np.arange(15)].any()


def test_unknown_depth_hides_nothing_and_is_not_seen():
    depth = planar(1.5).copy()
    depth[10:14, 10:14] = np.nan
    seen = visible_from(depth, CAMERA, (0.15, 0, 0))
    assert not seen[10:14, 10:14].any()
    assert seen.sum() == seen.size - 16


def test_a_camera_within_the_scene_is_refused():
    with pytest.raises(ValueError, match="before the nearest surface"):
        visible_from(planar(1.5), CAMERA, (0, 0, 1.6))


# --- labels ------------------------------------------------------------------------------------


@pytest.mark.parametrize("depth", [0.8, 1.5, 2.5])
def test_exact_spots_give_the_exact_wraps(depth):
    frame = wall(depth)
    truth = truth_from_spots(ideal(frame, sigma=1e-6), RIG, FREQUENCY_SINGLE)
    assert np.allclose(truth.range, frame.depth, atol=1e-6)
    assert truth.share > 0.99
    assert (truth.wraps == np.floor(frame.depth / WRAP))[truth.mask].all()
    assert (truth.wraps[~truth.mask] == -1).all() and np.isnan(truth.depth[~truth.mask]).all()


def test_stereo_alone_is_silent_near_the_boundary_of_a_wrap():
    frame = wall(1.5)
    truth = truth_from_spots(ideal(frame), RIG, FREQUENCY_SINGLE, sigmas=2.0)
    place = np.mod(frame.depth, WRAP)
    margin = 2.0 * truth.uncertainty
    near = (place < margin) | (place > WRAP - margin)
    assert (truth.mask == ~near).mean() > 0.999
    assert 0.02 < near.mean() < 0.9
    assert (truth.reason[near] == Reason.UNCERTAIN).all()


def test_with_the_phase_half_a_wrap_is_enough():
    frame = wall(1.5)
    spots = ideal(frame)
    alone = truth_from_spots(spots, RIG, FREQUENCY_SINGLE)
    both = truth_from_spots(spots, RIG, FREQUENCY_SINGLE, phase=phase_of(frame.depth))
    assert both.mask.all() and not alone.mask.all()
    assert (both.wraps == np.floor(frame.depth / WRAP)).all()
    assert np.allclose(both.depth, frame.depth, atol=1e-5)


def test_a_range_that_is_unsure_by_half_a_wrap_is_masked():
    frame = wall(1.5)
    for sigma, labelled in ((0.2, True), (3.0, False)):
        spots = ideal(frame, sigma=sigma)
        truth = truth_from_spots(spots, RIG, FREQUENCY_SINGLE, phase=phase_of(frame.depth))
        assert truth.mask.all() == labelled
        assert (3 * truth.uncertainty < WRAP / 2).all() == labelled


def test_noise_of_the_phase_counts_too():
    frame = wall(1.5)
    noise = np.where(np.arange(SHAPE[1]) < 20, 0.01, 1.2) * np.ones(SHAPE)
    truth = truth_from_spots(
        ideal(frame), RIG, FREQUENCY_SINGLE, phase=phase_of(frame.depth), phase_noise=noise
    )
    assert truth.mask[:, :20].all() and not truth.mask[:, 20:].any()


@pytest.mark.parametrize(
    ("status", "reason"),
    [
        (Status.ABSENT, Reason.HIDDEN),
        (Status.SATURATED, Reason.SATURATED),
        (Status.DOUBLE, Reason.DOUBLE),
        (Status.OUTSIDE, Reason.OUTSIDE),
    ],
)
def test_each_refusal_has_its_reason(status, reason):
    left, right = ideal(wall())
    right.status[3, 4] = status
    right.pixels[3, 4] = np.nan
    truth = truth_from_spots((left, right), RIG, FREQUENCY_SINGLE)
    assert truth.reason[3, 4] == reason and not truth.mask[3, 4]


def test_a_wrong_pair_is_told_by_the_epipolar_line():
    left, right = ideal(wall())
    right.pixels[3, 4] += [0, 1.0]  # 14 of its standard deviations across the line
    truth = truth_from_spots((left, right), RIG, FREQUENCY_SINGLE, phase=phase_of(wall().depth))
    assert truth.reason[3, 4] == Reason.MISMATCHED
    assert truth.mask.sum() == truth.mask.size - 1


def test_bad_input_is_refused():
    spots = ideal(wall())
    with pytest.raises(ValueError, match="Expected phase of the left spots' shape"):
        truth_from_spots(spots, RIG, FREQUENCY_SINGLE, phase=np.zeros((3, 3)))
    with pytest.raises(ValueError, match="frequency and a number of sigmas above 0"):
        truth_from_spots(spots, RIG, FREQUENCY_SINGLE, sigmas=0.0)
    with pytest.raises(ValueError, match="Expected a frame with a camera"):
        view_scene(Frame(planar(1.5), np.ones(SHAPE)), RIG)


# --- the whole simulation ----------------------------------------------------------------------


@pytest.fixture(scope="module")
def post():
    frame = stepped()
    scene = view_scene(frame, RIG)
    return frame, scene, record(scene, rng=np.random.default_rng(3))


def test_spots_are_found_where_they_can_be_seen(post):
    _, scene, spots = post
    for camera, found in enumerate(spots):
        there = scene.inside[camera] & scene.visible[camera]
        assert (found.status[there] == Status.FOUND).mean() > 0.97
        assert not (
            found.status[scene.inside[camera] & ~scene.visible[camera]] == Status.FOUND
        ).any()
        assert (found.status[~scene.inside[camera]] == Status.OUTSIDE).all()
        good = found.status == Status.FOUND
        error = (found.pixels - scene.pixels[camera])[good]
        told = np.sqrt(found.covariance[good][:, 0, 0])
        assert (error / told[:, None]).std() == pytest.approx(1, abs=0.08)


def test_labels_of_a_simulated_scan_are_right(post):
    frame, scene, spots = post
    truth = truth_from_spots(
        spots, RIG, FREQUENCY_SINGLE, phase=phase_of(frame.depth), lit=scene.lit
    )
    right = truth.wraps == np.floor(frame.depth / WRAP)
    # k = 3: at most 0.3 % of labels may err; 1200 pixels
    assert right[truth.mask].mean() > 0.99
    seen = (scene.inside & scene.visible).all(axis=0)
    assert truth.mask[seen].mean() > 0.95 and not truth.mask[~seen].any()
    error = (truth.range - frame.depth)[truth.mask] / truth.uncertainty[truth.mask]
    assert error.std() == pytest.approx(1, abs=0.12)


def test_without_noise_spots_lie_where_they_are():
    scene = view_scene(wall(), RIG)
    for camera, found in enumerate(record(scene, rng=np.random.default_rng(0), noise_free=True)):
        good = found.status == Status.FOUND
        assert good.mean() > 0.99
        assert np.abs((found.pixels - scene.pixels[camera])[good]).max() < 1e-3


def test_the_same_seed_gives_the_same_labels():
    one, two, other = (
        pseudo_truth(wall(), RIG, rng=np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    assert np.array_equal(one.range, two.range, equal_nan=True)
    assert not np.array_equal(one.range, other.range, equal_nan=True)


def test_a_wrong_calibration_shows_in_the_range():
    # 1 px of the right camera's centre is 1 px of disparity: z^2 / (f b) metres
    wrong = RIG.moved(right_cx=1.0)
    rng = np.random.default_rng(0)
    truth = pseudo_truth(wall(1.5), RIG, rng=rng, calibrated=wrong)
    middle = truth.range[15, 20] - 1.5
    foretold = 1.5**2 / (RIG.left.intrinsics[0] * RIG.baseline)
    assert abs(middle) == pytest.approx(foretold, rel=0.35)


def test_light_and_lens_decide_what_can_be_labelled():
    dim = pseudo_truth(
        wall(2.0, 0.02), RIG, rng=np.random.default_rng(0), lighting=Lighting(exposure=1e-7)
    )
    assert dim.share == 0 and (dim.reason == Reason.HIDDEN).mean() > 0.9
    stopped, open_ = (
        np.nanmedian(
            pseudo_truth(
                wall(2.0), RIG, rng=np.random.default_rng(0), sensor=Sensor(f_number=n)
            ).uncertainty
        )
        for n in (8.0, 2.0)
    )
    assert stopped > 2 * open_  # speckle: a wider lens sees more of the wave
