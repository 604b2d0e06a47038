"""The whole method: exact without noise, far ahead with it, and the same however it is asked."""

import os
import subprocess
import sys
import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from facet_scenes import CAMERA, SHAPE, WRAP, plane_depth, plane_frame

import cmtof
from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth, wrap_count_from_depth
from cmtof.measurement import Measurement
from cmtof.scenes.frame import Frame
from cmtof.simulation import simulate

IMAGES = ("wrap_count", "depth", "confidence")


def unwrapped(measurement, method="cmtof", **more):
    result = cmtof.unwrap(measurement, method=method, **more)
    return [result[name].to_numpy() for name in IMAGES]


def true_count(measurement):
    return wrap_count_from_depth(measurement.depth.astype(float), FREQUENCIES[0])


def right(measurement, method="cmtof", within=1):
    """Share of scored pixels whose count is off by less than that."""
    count, _, _ = unwrapped(measurement, method)
    scored = measurement.mask
    return np.mean(np.abs(count - true_count(measurement))[scored] < within)


def rebuilt(measurement, correlation=None, psi=None, **more):
    """The same measurement with other images."""
    data = measurement.dataset
    held = {"depth": measurement.depth, "mask": measurement.mask, "camera": measurement.camera}
    low, high = measurement.range
    return Measurement.from_arrays(
        data["correlation"].to_numpy() if correlation is None else correlation,
        data["psi"].to_numpy() if psi is None else psi,
        measurement.frequencies,
        **{**held, "range_min": low, "range_max": high, **more},
    )


@pytest.fixture(scope="module")
def clean(clean_corner):
    return unwrapped(clean_corner)


@pytest.fixture(scope="module")
def noisy_corner(corner):
    return simulate(corner.frame, protocol="full", seed=0)


# --- how right it is ---------------------------------------------------------------------------


def test_the_corner_without_noise_is_exact(corner, clean_corner, clean):
    count, depth, _ = clean
    exact = np.abs(depth - corner.frame.depth) < 1e-4
    # what is left are single pixels along the edges
    assert np.mean((count == true_count(clean_corner)) & exact) >= 0.995


@pytest.mark.parametrize("protocol", ["full", "released"])
@pytest.mark.parametrize("seed", range(4))
def test_the_corner_with_noise_beats_the_field(corner, protocol, seed):
    """A share of 20 480 pixels is known to 0.3 %, and draws of mrf spread by 10 %."""
    m = simulate(corner.frame, protocol=protocol, seed=seed)
    ours = right(m)
    assert ours > 0.85
    assert ours > right(m, "mrf") + 0.2


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.3, -0.2, 1), (-0.1, 0.6, 1)])
@pytest.mark.parametrize("seed", range(3))
def test_a_wide_plane_is_right_in_the_papers_noise(normal, seed):
    """Its pooled phase is known to 1 mrad, so that only pixels at a boundary can be off."""
    m = simulate(plane_frame(normal, 2.5, 0.6), protocol="full", seed=seed)
    assert right(m, within=2) > 0.99


@pytest.mark.parametrize("option", [{"bent": False}, {"shape": False}, {"ties": False},
                                    {"fill": False}])  # fmt: skip
def test_without_noise_every_part_may_be_left_out(clean_corner, option):
    count, _, _ = unwrapped(clean_corner, **option)
    assert np.mean(count == true_count(clean_corner)) > 0.99


def test_confidence_tells_right_from_wrong(corner):
    """On average over draws it is higher where the wrap is right."""
    sure, unsure = [], []
    for seed in range(3):
        m = simulate(corner.frame, protocol="full", seed=seed)
        count, _, confidence = unwrapped(m)
        good = np.abs(count - true_count(m)) < 2
        sure.append(confidence[good])
        unsure.append(confidence[~good])
    assert np.concatenate(sure).mean() > np.concatenate(unsure).mean() + 0.1


# --- what must not matter ----------------------------------------------------------------------


@pytest.mark.parametrize("shift", [0.3, 1.7, -2.2, np.pi])
def test_a_shift_of_all_reference_phases(corner, clean, shift):
    psi = np.arange(4) * np.pi / 2 + shift
    m = simulate(corner.frame, protocol="full", noise_free=True, psi=psi)
    assert np.mean(unwrapped(m)[0] == clean[0]) > 0.999


@pytest.mark.parametrize("roll", [1, 2, 3])
def test_steps_rolled_with_their_labels(clean_corner, clean, roll):
    images, psi = (clean_corner.dataset[n].to_numpy() for n in ("correlation", "psi"))
    m = rebuilt(clean_corner, np.roll(images, roll, axis=1), np.roll(psi, roll, axis=1))
    assert np.mean(unwrapped(m)[0] == clean[0]) > 0.999


def test_steps_in_any_order(clean_corner, clean, rng):
    images, psi = (clean_corner.dataset[n].to_numpy() for n in ("correlation", "psi"))
    order = rng.permutation(4)
    m = rebuilt(clean_corner, images[:, order], psi[:, order])
    assert np.mean(unwrapped(m)[0] == clean[0]) > 0.999


@pytest.mark.parametrize("steps", [4, 5, 8, 16])
def test_the_number_of_steps(corner, clean, steps):
    psi = 2 * np.pi * np.arange(steps) / steps
    m = simulate(corner.frame, protocol="full", noise_free=True, psi=psi)
    assert np.mean(unwrapped(m)[0] == clean[0]) > 0.999


@pytest.mark.parametrize("gain", [0.01, 100.0])
def test_the_unit_of_the_counts(noisy_corner, gain):
    """Only ratios to the noise count, and that is read off the data."""
    images = noisy_corner.dataset["correlation"].to_numpy() * np.float32(gain)
    count = unwrapped(rebuilt(noisy_corner, images))[0]
    assert np.mean(count == unwrapped(noisy_corner)[0]) > 0.999


def test_rows_for_columns(clean_corner, clean):
    images = clean_corner.dataset["correlation"].to_numpy().swapaxes(2, 3)
    m = rebuilt(
        clean_corner,
        np.ascontiguousarray(images),
        depth=clean_corner.depth.T,
        mask=clean_corner.mask.T,
        camera=np.array(CAMERA)[[1, 0, 3, 2]],
    )
    turned = unwrapped(m)[0].T
    assert np.mean(turned == clean[0]) >= 0.98


@pytest.mark.parametrize("axis", [0, 1])
def test_the_image_in_a_mirror(clean_corner, clean, axis):
    images = np.flip(clean_corner.dataset["correlation"].to_numpy(), axis + 2)
    camera = np.array(CAMERA)
    camera[3 - axis] = SHAPE[axis] - camera[3 - axis]
    m = rebuilt(
        clean_corner,
        np.ascontiguousarray(images),
        depth=np.flip(clean_corner.depth, axis),
        camera=camera,
    )
    assert np.mean(np.flip(unwrapped(m)[0], axis) == clean[0]) >= 0.98


def test_the_seed_does_not_move_the_answer(noisy_corner):
    first, second = unwrapped(noisy_corner), unwrapped(noisy_corner)
    for one, other in zip(first, second, strict=True):
        np.testing.assert_array_equal(one, other)


def test_two_threads_at_once(noisy_corner, clean_corner):
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(unwrapped, [noisy_corner, clean_corner] * 2))
    for m, images in zip([noisy_corner, clean_corner] * 2, found, strict=True):
        for one, other in zip(images, unwrapped(m), strict=True):
            np.testing.assert_array_equal(one, other)


def test_one_thread_only(noisy_corner, tmp_path):
    noisy_corner.save(tmp_path / "corner.nc")
    script = (
        "import sys, numpy, cmtof\n"
        "r = cmtof.unwrap(cmtof.open(sys.argv[1]), method='cmtof')\n"
        "numpy.savez(sys.argv[2], **{n: r[n].to_numpy() for n in sys.argv[3:]})\n"
    )
    paths = os.pathsep.join([*filter(None, sys.path), os.environ.get("PYTHONPATH", "")])
    alone = {"OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    subprocess.run(
        [sys.executable, "-c", script, tmp_path / "corner.nc", tmp_path / "out.npz", *IMAGES],
        env={**os.environ, **alone, "PYTHONPATH": paths},
        check=True,
    )
    here = unwrapped(cmtof.open(tmp_path / "corner.nc"))
    with np.load(tmp_path / "out.npz") as there:
        for name, image in zip(IMAGES, here, strict=True):
            np.testing.assert_array_equal(there[name], image)


# --- holes, edges and extremes -----------------------------------------------------------------


@pytest.fixture(scope="module")
def holes():
    """A mask with a disc, a stripe and scattered pixels missing."""
    y, x = np.indices(SHAPE)
    mask = (np.hypot(y - 30, x - 120) > 9) & (np.abs(x - 40) > 1)
    return mask & (np.random.default_rng(1).random(SHAPE) > 0.02)


@pytest.mark.parametrize("lost", [True, False])
def test_a_mask_with_holes(clean_corner, clean, holes, lost):
    """Masked pixels are not judged, whether or not there is a number in them."""
    images = clean_corner.dataset["correlation"].to_numpy().copy()
    if lost:
        images[..., ~holes] = np.nan
    count, depth, confidence = unwrapped(rebuilt(clean_corner, images, mask=holes))
    assert (count[~holes] == -1).all()
    assert not confidence[~holes].any()
    assert np.isnan(depth[~holes]).all()
    assert np.mean(count[holes] == clean[0][holes]) >= 0.99


def test_a_depth_that_is_unknown_here_and_there(corner, clean):
    """No light returns from there, as from a hole in a depth image."""
    depth = corner.frame.depth.copy()
    depth[60:70, 20:35] = np.nan
    m = simulate(
        Frame(depth, corner.frame.intensity, np.array(CAMERA)), protocol="full", noise_free=True
    )
    count, _, confidence = unwrapped(m)
    assert (count[60:70, 20:35] == -1).all()
    assert not confidence[60:70, 20:35].any()
    assert np.mean(count[m.mask] == clean[0][m.mask]) >= 0.99


def centred(shape):
    return (140.0, 140.0, shape[1] / 2, shape[0] / 2)


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (5, 7), (63, 65), (64, 64), (8, 200)])
@pytest.mark.parametrize("noise_free", [True, False])
def test_any_size(shape, noise_free):
    camera = centred(shape)
    frame = plane_frame((0.05, 0, 1), 2.5, 1.0, shape, camera)
    m = simulate(frame, protocol="full", noise_free=noise_free)
    count, depth, confidence = unwrapped(m)
    assert count.shape == shape
    low, high = m.range
    assert ((depth >= low) & (depth < high)).all()
    assert ((confidence >= 0) & (confidence <= 1)).all()
    if noise_free:
        assert np.mean(np.abs(depth - frame.depth) < 1e-4) > 0.99


@pytest.mark.parametrize("protocol", ["full", "released"])
def test_a_dark_frame(protocol):
    depth, _ = plane_depth((0, 0, 1), 1.1)
    m = simulate(Frame(depth, np.zeros(SHAPE), np.array(CAMERA)), protocol=protocol)
    count, found, confidence = unwrapped(m)
    low, high = m.range
    found, count = found[m.mask], count[m.mask]
    assert ((found >= low) & (found < high)).all()
    assert ((confidence >= 0) & (confidence <= 0.5)).all()
    assert (count >= 0).all()


def test_no_light_and_no_noise_either():
    zeros = np.zeros((2, 4, *SHAPE), np.float32)
    m = Measurement.from_arrays(zeros, np.arange(4) * np.pi / 2, FREQUENCIES, camera=CAMERA)
    _, depth, confidence = unwrapped(m)
    assert np.isfinite(depth).all()
    assert (confidence <= 0.5).all()


@pytest.mark.parametrize("depth", [0.3, 1.0, 2.5, 4.5])
def test_phases_alone(depth):
    """They do not say how noisy they are, but here they are exact."""
    z, _ = plane_depth((0.2, 0.1, 1), depth)
    phase = np.stack([phase_from_depth(z, f) for f in FREQUENCIES])
    m = Measurement.from_phase(phase, FREQUENCIES, depth=z, camera=CAMERA)
    assert np.mean(np.abs(unwrapped(m)[1] - z) < 1e-4) > 0.99


@pytest.mark.parametrize("seed", range(3))
def test_no_camera(seed):
    """A wall straight ahead through a lens other than the one that is assumed."""
    frame = plane_frame((0, 0, 1), 2.5)
    m = simulate(Frame(frame.depth, frame.intensity), protocol="full", seed=seed)
    assert m.camera is None
    assert right(m, within=2) > 0.99


def test_a_frame_far_from_its_range(noisy_corner):
    """Nothing there can be right, and nothing leaves the range."""
    low, high = 6.5, 7.3
    count, depth, confidence = unwrapped(noisy_corner.between(low, high))
    assert (depth >= low - 1e-6).all()
    assert (depth <= high + 1e-6).all()
    assert (np.abs(count * WRAP - 6.9) < 0.45).all()
    assert (confidence <= 1).all()


@pytest.mark.parametrize("protocol", ["full", "released"])
def test_confidence_is_a_probability(corner, protocol):
    m = simulate(corner.frame, protocol=protocol, seed=7)
    _, _, confidence = unwrapped(m)
    assert ((confidence >= 0) & (confidence <= 1)).all()
    assert confidence[m.mask].any()


@pytest.mark.parametrize("frequencies", [(7e9, 14e9), (5e9, 15e9)])
@pytest.mark.parametrize("shape", [(4, 4), (70, 90)])
def test_multiples_are_refused(frequencies, shape):
    m = Measurement.from_phase(np.ones((2, *shape)), frequencies)
    with pytest.raises(ValueError, match="no multiples"):
        cmtof.unwrap(m, method="cmtof")


@pytest.mark.parametrize("frequencies", [(7.15e9, 14.28e9), (7.15e9, 7.2e9), (5e9, 15.05e9)])
def test_other_pairs_of_frequencies(frequencies):
    """A beat that turns the other way, a near twin, and three times the lower one."""
    depth, _ = plane_depth((0.2, 0.1, 1), 1.5)
    frame = Frame(depth, np.ones(SHAPE), np.array(CAMERA))
    m = simulate(frame, protocol="full", noise_free=True, frequencies=frequencies)
    found = unwrapped(m)[1]
    assert np.mean(np.abs(found - depth)[m.mask] < 1e-4) > 0.99


@pytest.mark.slow
def test_four_megapixels():
    side = 2048
    camera = (2240.0, 2240.0, side / 2, side / 2)
    frame = plane_frame((0.2, -0.1, 1), 2.5, 0.8, (side, side), camera)
    m = simulate(frame, protocol="full", seed=1)
    tracemalloc.start()
    try:
        count, _, _ = unwrapped(m)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert np.mean(np.abs(count - true_count(m)) < 2) > 0.99
    assert peak < 2e9
