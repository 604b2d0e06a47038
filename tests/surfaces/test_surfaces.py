"""The whole method: exact without noise, far ahead with it, unmoved by what must not matter."""

import numpy as np
from exact_scenes import CAMERA, SHAPE, WRAP, corner_scene, plane_depth, plane_frame
from pytest import approx, fixture, mark

import cmtof
from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth, wrap_count_from_depth
from cmtof.frame import Frame
from cmtof.measurement import Measurement
from cmtof.simulation import simulate
from cmtof.surfaces import stages


def unwrapped(measurement, method="surfaces", **options):
    result = cmtof.unwrap(measurement, method=method, **options)
    return [result[name].to_numpy() for name in ("wrap_count", "depth", "confidence")]


def right(measurement, method="surfaces", within=1, **options):
    """Share of scored pixels whose count is off by less than that."""
    count = unwrapped(measurement, method, **options)[0]
    true = wrap_count_from_depth(
        np.nan_to_num(measurement.depth).astype(float), FREQUENCIES[0]
    )
    return np.mean(np.abs(count - true)[measurement.mask] < within)


def rebuilt(measurement, correlation, **more):
    """The same measurement with other images."""
    held = {
        "depth": measurement.depth,
        "mask": measurement.mask,
        "camera": measurement.camera,
    }
    low, high = measurement.range
    held |= {"range_min": low, "range_max": high, **more}
    psi = measurement.dataset["psi"].to_numpy()
    correlation = np.ascontiguousarray(correlation)
    return Measurement.from_arrays(correlation, psi, measurement.frequencies, **held)


@fixture(scope="module")
def corner():
    return corner_scene()


@fixture(scope="module")
def clean_corner(corner):
    return simulate(corner.frame, protocol="full", noise_free=True)


@fixture(scope="module")
def clean(clean_corner):
    return unwrapped(clean_corner)


def test_the_corner_without_noise_is_exact_whatever_is_left_out(
    corner, clean_corner, clean
):
    # what is left are single pixels along the edges
    assert np.mean(np.abs(clean[1] - corner.frame.depth) < 1e-4) >= 0.995
    for option in ("bent", "parts", "shape", "axes", "ties", "fill"):
        assert right(clean_corner, without=[option]) > 0.99


def test_the_corner_with_noise_beats_the_random_field(corner):
    """A share of 20 480 pixels is known to 0.3 %, and draws of mrf spread by 10 %."""
    m = simulate(corner.frame, protocol="full", seed=0)
    ours = right(m)
    assert ours > 0.85
    assert ours > right(m, "mrf") + 0.2


def test_a_wide_plane_is_right_in_the_papers_noise():
    """Its pooled phase is known to 1 mrad, so that only pixels at a boundary can be off."""
    ahead, steep = (plane_frame(normal, 0.6) for normal in ((0, 0, 1), (-0.1, 0.6, 1)))
    # straight ahead also through a lens other than the one that is assumed
    for frame in (ahead, steep, Frame(ahead.depth, np.ones(SHAPE))):
        assert right(simulate(frame, protocol="full", seed=1), within=2) > 0.99


def test_reference_phases_and_units_do_not_matter(corner, clean_corner, clean):
    psi = 2 * np.pi * np.arange(5) / 5 + 1.7
    other = simulate(corner.frame, protocol="full", noise_free=True, psi=psi)
    scaled = rebuilt(clean_corner, 100 * clean_corner.dataset["correlation"].to_numpy())
    for m in (other, scaled):
        assert np.mean(unwrapped(m)[0] == clean[0]) > 0.999


def test_turned_and_mirrored_images_have_turned_answers(clean_corner, clean):
    images = clean_corner.dataset["correlation"].to_numpy()
    about = {"depth": clean_corner.depth.T, "mask": clean_corner.mask.T}
    camera = np.array(CAMERA)[[1, 0, 3, 2]]
    swapped = rebuilt(clean_corner, images.swapaxes(2, 3), camera=camera, **about)
    assert np.mean(clean[0] == unwrapped(swapped)[0].T) >= 0.98
    camera = np.array(CAMERA)
    camera[2] = SHAPE[1] - camera[2]
    depth = np.flip(clean_corner.depth, 1)
    mirrored = rebuilt(clean_corner, np.flip(images, 3), depth=depth, camera=camera)
    assert np.mean(np.flip(unwrapped(mirrored)[0], 1) == clean[0]) >= 0.98


def test_components_are_bodies_whose_surfaces_meet(clean_corner):
    """Walls, floor and box meet; two planes with darkness between them do not."""
    room = cmtof.unwrap(clean_corner)
    assert np.mean(room.component == 1) > 0.95
    assert room.component_odds.sel(number=1, offset=0) > 0.9
    columns = np.arange(SHAPE[1])
    left, right = (
        plane_depth(normal, z)[0] for normal, z in (((0, 0.5, 1), 2), ((0, 0, 1), 3))
    )
    light = np.broadcast_to(np.abs(columns - 90) > 10, SHAPE)
    apart = Frame(
        np.where(columns < 90, left, right), light.astype(float), np.array(CAMERA)
    )
    result = cmtof.unwrap(simulate(apart, protocol="full", seed=1))
    assert np.mean(result.component[:, :75] == 1) > 0.95
    assert np.mean(result.component[:, 105:] == 2) > 0.95


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


def test_phases_alone_and_other_frequencies():
    """Phases do not say how noisy they are; a beat that turns the other way; a near twin."""
    depth, _ = plane_depth((0.2, 0.1, 1), 1.5)
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    cases = [Measurement.from_phase(phase, FREQUENCIES, depth=depth, camera=CAMERA)]
    frame = Frame(depth, np.ones(SHAPE), np.array(CAMERA))
    for pair in ((7.15e9, 14.28e9), (7.15e9, 7.2e9), (5e9, 15.05e9)):
        cases.append(
            simulate(frame, protocol="full", noise_free=True, frequencies=pair)
        )
    for m in cases:
        assert np.mean(np.abs(unwrapped(m)[1] - depth)[m.mask] < 1e-4) > 0.99
    far = Frame(100 * depth, frame.intensity, frame.camera)
    m = simulate(far, protocol="full", noise_free=True, frequencies=(7.15e7, 1.432e8))
    assert np.mean(np.abs(unwrapped(m)[1] / 100 - depth)[m.mask] < 1e-4) > 0.99


def test_clear_pixels_vote_where_no_surface_explains_them():
    """Clutter of 4 px without noise: surfaces, which need 12 px, fail, and neighbours decide."""
    depth = np.repeat(
        np.repeat(np.random.default_rng(4).uniform(0.8, 1.1, (16, 20)), 4, 0), 4, 1
    )
    assert right(simulate(Frame(depth, np.ones(depth.shape)), noise_free=True)) > 0.9


def test_images_whose_surfaces_lie_outside_the_mask_are_unwrapped():
    """A wall that is masked beside dark pixels that are not."""
    mask = np.broadcast_to(np.arange(SHAPE[1]) < 16, SHAPE)
    m = simulate(
        plane_frame((0, 0, 1), np.where(mask, 0.0, 1.0)), protocol="full", seed=0
    )
    count, depth, confidence = unwrapped(
        Measurement(m.dataset.assign(mask=(("y", "x"), mask)))
    )
    assert (count[mask] >= 0).all() and (count[~mask] == -1).all()
    assert np.isfinite(depth[mask]).all() and np.isnan(depth[~mask]).all()
    assert not confidence[~mask].any()
