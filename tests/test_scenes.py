"""Frames from files, formulas and captures."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from cmtof.correlation import centred, phase_from_depth
from cmtof.measurement import open_measurement
from cmtof.pointcloud import points_from_depth, write_ply
from cmtof.scenes import analytic, captures, load_frame
from cmtof.scenes.catalogue import still_life
from cmtof.scenes.frame import Frame, embedded_frames, ray_lengths, rays_from_camera

CAMERA = [50.0, 60.0, 8.0, 6.0]


def solid(distance):
    return analytic.Solid(distance, analytic.plain(0.5))


def looking_ahead(solids, shape=(12, 16)):
    return analytic.view(
        solids, eye=(0, 0, 0), target=(0, 0, 1), shape=shape, focal=20.0, lamp=(0, 2, 0)
    )


# --- formulas ------------------------------------------------------------------------------


def test_wall_ahead_has_the_range_of_its_rays():
    frame = looking_ahead([solid(analytic.plane((0, 0, -1), -2.0))])
    expected = 2.0 * ray_lengths((12, 16), frame.camera)
    np.testing.assert_allclose(frame.depth, expected, atol=2e-6)


def test_ball_has_the_range_of_the_quadratic():
    frame = looking_ahead([solid(analytic.sphere((0, 0, 2.0), 0.6))])
    rays = rays_from_camera((12, 16), frame.camera)
    along = 2.0 / np.linalg.norm(rays, axis=-1)
    root = along**2 - (4.0 - 0.36)
    expected = np.where(root > 0, along - np.sqrt(np.maximum(root, 0)), np.nan)
    np.testing.assert_allclose(frame.depth, expected, atol=1e-5)


SHAPES = [
    analytic.plane((0.2, 1, 0.1), 0.3),
    analytic.sphere((0.1, 0.2, 0.3), 0.5),
    analytic.box((0, 0.1, 0), (0.6, 0.4, 0.8), turn=0.7, rounding=0.05),
    analytic.capsule((0, 0, 0), (0.3, 0.5, 0.1), 0.1),
    analytic.revolved((0, 0, 0), [(0.2, 0.0), (0.3, 0.2), (0.1, 0.5)]),
]


@pytest.mark.parametrize("shape", SHAPES)
@given(st.integers(0, 2**32))
def test_no_distance_overstates_how_far_one_may_march(shape, seed):
    """A signed distance changes by no more than the way gone: marching never jumps a surface."""
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-1, 1, (2, 50, 3))
    ways = np.linalg.norm(a - b, axis=-1)
    same_side = np.sign(shape(a)) == np.sign(shape(b))
    change = np.abs(shape(a) - shape(b))
    assert (change <= ways + 1e-9)[same_side].all()


def test_shadow_falls_behind_a_ball():
    floor = solid(analytic.plane((0, 1, 0), -1.0))
    ball = solid(analytic.sphere((0, 0.0, 3.0), 0.5))
    lit = looking_ahead([floor], shape=(40, 40)).intensity
    shaded = looking_ahead([floor, ball], shape=(40, 40)).intensity
    assert (shaded < lit - 1e-3).any()


def test_embedded_still_life_is_what_its_formulas_trace():
    """Traced anew at a quarter of the size, it agrees with the stored frame between the edges."""
    small, stored = still_life((60, 80)), load_frame("still_life")
    np.testing.assert_allclose(stored.camera, 4 * np.asarray(small.camera))
    blocks = stored.depth.reshape(60, 4, 80, 4)
    smooth = np.ptp(blocks, axis=(1, 3)) < 0.02
    centre = blocks[:, 1:3, :, 1:3].mean(axis=(1, 3))
    assert smooth.mean() > 0.6
    # the mean of four pixels misses the centre's range by the curvature of small round things
    assert np.abs(centre - small.depth)[smooth].max() < 5e-3
    assert np.median(np.abs(centre - small.depth)[smooth]) < 1e-5


# --- files ---------------------------------------------------------------------------------


def test_frames_survive_their_file(tmp_path, tilted_wall):
    tilted_wall.save(tmp_path / "wall.npz")
    read = load_frame(tmp_path / "wall.npz")
    np.testing.assert_array_equal(read.depth, tilted_wall.depth)
    np.testing.assert_array_equal(read.intensity, tilted_wall.intensity)
    np.testing.assert_array_equal(read.camera, tilted_wall.camera)


@pytest.mark.parametrize(
    ("depth", "intensity", "message"),
    [
        (np.ones((2, 3)), np.ones((3, 2)), "one shape"),
        (np.ones(3), np.ones(3), "one shape"),
        (np.full((2, 2), np.nan), np.ones((2, 2)), "none above 0"),
        (np.zeros((2, 2)), np.ones((2, 2)), "none above 0"),
        (np.ones((2, 2)), -np.ones((2, 2)), "intensities >= 0"),
        (np.ones((2, 2)), np.full((2, 2), np.nan), "intensities >= 0"),
    ],
)
def test_impossible_frames_are_refused(depth, intensity, message):
    with pytest.raises(ValueError, match=message):
        Frame(depth, intensity)


def test_frame_files_that_are_none(tmp_path):
    np.savez(tmp_path / "half.npz", depth=np.ones((2, 2)))
    (tmp_path / "empty.npz").touch()
    (tmp_path / "a.jpg").touch()
    with pytest.raises(ValueError, match="arrays depth and intensity"):
        load_frame(tmp_path / "half.npz")
    with pytest.raises(ValueError, match=r"whole \.npz"):
        load_frame(tmp_path / "empty.npz")
    with pytest.raises(ValueError, match="or"):
        load_frame(tmp_path / "a.jpg")
    with pytest.raises(FileNotFoundError, match="still_life"):
        load_frame("no_such_frame")
    assert set(embedded_frames()) == {"room", "stairs", "still_life"}


def png_pair(folder, scale=1000, bits=8):
    depth = np.linspace(0, 3.0, 12 * 16).reshape(12, 16)
    Image.fromarray(np.rint(depth * scale).astype(np.uint16)).save(folder / "depth.png")
    colour = np.zeros((12, 16, 3), np.uint8)
    colour[..., 1] = 188  # sRGB of about one half
    Image.fromarray(colour).save(folder / "colour.png")
    return depth


def test_png_pairs_load_with_scale_gamma_and_holes(tmp_path):
    depth = png_pair(tmp_path, scale=5000)
    frame = load_frame(tmp_path / "depth.png", intensity=tmp_path / "colour.png", depth_scale=5000)
    assert np.isnan(frame.depth[0, 0])
    np.testing.assert_allclose(frame.depth[1:], depth[1:], atol=1.1e-4)
    np.testing.assert_allclose(frame.intensity, 0.5, atol=0.005)


def test_planar_png_becomes_range(tmp_path):
    png_pair(tmp_path)
    pair = {"intensity": tmp_path / "colour.png", "camera": CAMERA}
    planar = load_frame(tmp_path / "depth.png", planar=True, **pair)
    ranged = load_frame(tmp_path / "depth.png", **pair)
    np.testing.assert_allclose(
        planar.depth, ranged.depth * ray_lengths((12, 16), CAMERA), rtol=1e-6
    )


def test_png_pairs_that_lack_something(tmp_path):
    png_pair(tmp_path)
    colour = tmp_path / "colour.png"
    with pytest.raises(ValueError, match="intensity image beside"):
        load_frame(tmp_path / "depth.png")
    with pytest.raises(ValueError, match="Expected camera"):
        load_frame(tmp_path / "depth.png", intensity=colour, planar=True)
    with pytest.raises(ValueError, match="depth scale > 0"):
        load_frame(tmp_path / "depth.png", intensity=colour, depth_scale=0)
    (tmp_path / "fake.png").write_bytes(b"no image")
    with pytest.raises(ValueError, match="Expected a PNG image"):
        load_frame(tmp_path / "fake.png", intensity=colour)


# --- points ----------------------------------------------------------------------------------


@given(st.floats(0.1, 10), st.integers(0, 15), st.integers(0, 11))
def test_points_lie_at_their_range_on_their_ray(depth, x, y):
    image = np.full((12, 16), depth)
    point = points_from_depth(image, CAMERA)[y, x]
    assert np.linalg.norm(point) == pytest.approx(depth)
    assert point[0] / point[2] * 50 + 8 == pytest.approx(x + 0.5)
    assert point[1] / point[2] * 60 + 6 == pytest.approx(y + 0.5)


def test_ply_holds_every_finite_pixel(tmp_path, rng):
    depth = rng.uniform(1, 2, (12, 16))
    depth[3, 4] = np.nan
    count = write_ply(
        tmp_path / "c.ply", depth, CAMERA, brightness=np.ones((12, 16)), confidence=depth / 4
    )
    head, body = (tmp_path / "c.ply").read_bytes().split(b"end_header\n", 1)
    assert f"element vertex {count}\n".encode() in head
    assert count == 191
    record = np.dtype([("xyz", "<f4", 3), ("rgb", "u1", 3), ("confidence", "<f4")])
    vertices = np.frombuffer(body, record)
    np.testing.assert_allclose(
        np.linalg.norm(vertices["xyz"], axis=1), depth[np.isfinite(depth)], rtol=1e-6
    )
    np.testing.assert_allclose(vertices["confidence"], depth[np.isfinite(depth)] / 4, rtol=1e-6)
    assert (vertices["rgb"] == 255).all()


# --- captures --------------------------------------------------------------------------------


def test_captures_written_in_the_published_layout_open(tmp_path, rng):
    depth = rng.uniform(0.6, 0.8, (7, 9))
    path = captures.write_capture(phase_from_depth(depth, 7.15e9) % (2 * np.pi), depth, tmp_path)
    m = open_measurement(path)
    np.testing.assert_allclose(m.dataset["reference_depth"], depth)
    assert np.abs(centred(m.phase[0] - phase_from_depth(depth, 7.15e9))).max() < 1e-9
    assert m.frequencies.tolist() == [7.15e9]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "got none"),
        ("1,2\n3\n", "rows of numbers"),
        ("1,2\nx,4\n", "rows of numbers"),
        ("1,nan\n3,4\n", "got NaN or inf"),
        ("1,700\n3,4\n", "Is it a depth map"),
    ],
)
def test_broken_captures_end_in_one_sentence(tmp_path, text, message):
    (tmp_path / "scene_x_phase.csv").write_text(text)
    with pytest.raises(ValueError, match=message):
        open_measurement(tmp_path / "scene_x_phase.csv")


def test_captures_of_another_size_are_refused(tmp_path):
    for kind, text in (("phase", "1,2\n3,4\n"), ("depth", "700,701\n")):
        (tmp_path / kind).mkdir()
        (tmp_path / kind / f"scene_x_{kind}.csv").write_text(text)
    with pytest.raises(ValueError, match="reference depth of shape"):
        open_measurement(tmp_path / "phase" / "scene_x_phase.csv")


def test_a_machine_without_captures_says_so(monkeypatch, tmp_path):
    monkeypatch.setenv("CMTOF_DATA", str(tmp_path))
    assert captures.data_root() is None
    assert captures.published_captures() == {}


def test_published_captures_agree_with_their_reference_on_the_background(shared_data):
    found = captures.published_captures()
    assert "owl" in found
    m = open_measurement(found["owl"])
    assert m.shape == (100, 100)
    reference = m.dataset["reference_depth"].to_numpy()
    turn = np.exp(1j * (phase_from_depth(reference, 7.15e9) - m.phase[0]))
    border = np.ones((100, 100), bool)
    border[20:, 20:80] = False  # the object stands in the middle
    assert abs(turn[border].mean()) > 0.5
