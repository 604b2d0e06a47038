"""Frames: cameras, light, files, folders, captures; what is refused, in one line."""

import zipfile
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from pytest import mark
from refusals import WRONG, refused

import cmtof
from cmtof import captures
from cmtof.correlation import TAU, centred, phase_from_depth
from cmtof.frame import Frame, brightness, rays_from_camera
from cmtof.scenes import load_frame

pytestmark = mark.usefixtures("own_folder")
ONES = np.ones((6, 8))


@given(
    st.floats(3, 30),
    st.floats(3, 30),
    st.floats(0, 8),
    st.floats(0, 6),
    st.floats(-1, 1),
)
def test_rays_of_a_skewed_camera_land_on_their_pixels(fx, fy, cx, cy, skew):
    rays = rays_from_camera((6, 8), [fx, fy, cx, cy, skew])
    pinhole = np.array([[fx, skew, cx], [0, fy, cy], [0, 0, 1]])
    v, u = np.indices((6, 8)) + 0.5
    assert_allclose(rays @ pinhole.T, np.stack([u, v, ONES], axis=-1), atol=1e-9)


@mark.parametrize("camera", [None, [9.0, 9, 4, 3, 0.1]])
def test_frames_survive_their_file(rng, camera):
    frame = Frame(*rng.uniform(0.1, 2, (2, 6, 8)), camera, note="float16")
    frame.save("a.npz")
    read = load_frame("a.npz")
    for name in ("depth", "intensity", "camera"):
        assert_array_equal(getattr(read, name), getattr(frame, name))
    assert (read.note, read.name) == ("float16", "a")


def test_a_frame_that_is_stored_twice_has_the_notes_of_once():
    Frame(ONES, ONES / 100).save("a.npz")
    once = load_frame("a.npz")
    once.save("b.npz")
    assert load_frame("b.npz").note == once.note != ""
    with refused(r"named \*.npz"):
        once.save("b")


def test_brightness_of_bytes_is_that_of_their_values():
    assert_allclose(brightness(np.uint8([[10, 20, 30]])), 18.1, rtol=1e-6)


@mark.filterwarnings("error")
@mark.parametrize(
    "arrays, message",
    [
        ({"intensity": ONES.astype([("a", float)])}, "numbers as intensity"),
        *WRONG["frames"],
    ],
)
def test_impossible_frames_are_refused_alike_from_arrays_and_files(arrays, message):
    arrays = {"depth": ONES, "intensity": ONES} | arrays
    with refused(message):
        Frame(**arrays)
    np.savez("a.npz", **arrays)
    with refused(message):
        load_frame("a.npz")


def test_an_archive_that_claims_more_than_it_holds_is_refused_before_it_is_read():
    path = Path("a.npz")
    Frame(ONES, ONES).save(path)
    with zipfile.ZipFile(path) as archive:
        size = archive.getinfo("depth.npy").file_size.to_bytes(4, "little")
    path.write_bytes(path.read_bytes().replace(size, (2**31).to_bytes(4, "little")))
    with refused(r"whole \.npz file, got .*its header claims 4\.29e\+09"):
        load_frame(path)


@mark.parametrize("name, message", WRONG["files"])
def test_what_holds_no_frame_is_refused(name, message):
    np.savez("half.npz", depth=ONES)
    Path("empty.npz").touch()
    Path("a.jpg").touch()
    Path("void").mkdir()
    with refused(message, (ValueError, OSError)):
        load_frame(name)


CAPTURE = Path("phase/scene_x_phase.csv")


def write_capture(phase, depth):
    for kind, table in (("phase", phase), ("depth", depth)):
        Path(kind).mkdir()
        np.savetxt(f"{kind}/scene_x_{kind}.csv", table, delimiter=",")


@mark.parametrize("folder", [".", "phase"])
def test_a_capture_opens_from_everywhere(rng, monkeypatch, folder):
    """In its own folder as well, where its path has no parents."""
    depth = rng.uniform(0.6, 0.8, (7, 9))
    phase = phase_from_depth(depth, 7.15e9)
    write_capture(phase % TAU, 1000 * depth)
    monkeypatch.chdir(folder)
    measurement = cmtof.open(CAPTURE.relative_to(folder))
    assert_allclose(measurement.dataset["reference_depth"], depth)
    assert_allclose(centred(measurement.phase[0] - phase), 0, atol=1e-5)
    assert measurement.frequencies.tolist() == [7.15e9]


@mark.parametrize("text, message", WRONG["captures"])
def test_broken_captures_end_in_one_sentence(text, message):
    write_capture(ONES, 700 * ONES)
    CAPTURE.write_text(text)
    with refused(message):
        captures.read_capture(CAPTURE)
