"""Images of depth and light as others store them: what they mean, and what is said of them."""

from pathlib import Path

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal
from PIL import Image
from pytest import mark
from refusals import refused

from cmtof.frame import Frame, ray_lengths
from cmtof.scenes import frames_in, load_frame
from cmtof_book.provenance import read_json

pytestmark = mark.usefixtures("own_folder")
SHAPE = (12, 16)
CAMERA = [50.0, 60.0, 8.0, 6.0]
DEPTH = np.linspace(1.5, 3.0, 192).reshape(SHAPE)
LIGHT = np.full((*SHAPE, 3), 188, np.uint8)  # sRGB of one half
INFRARED = np.full(SHAPE, 255, np.uint16)


def write(name, pixels):
    Path(name).parent.mkdir(exist_ok=True)
    if name.lower().endswith(".npy"):
        with Path(name).open("wb") as file:
            np.save(file, pixels)
    else:
        Image.fromarray(pixels).save(name)
    return name


def levels(scale):
    return np.rint(DEPTH * scale).astype(np.uint16)


LEVELS = levels(1000)


def read(depth, light=LIGHT, name="d.png", **how):
    """A frame of two images as they are stored."""
    return load_frame(write(name, depth), intensity=write("light.png", light), **how)


@mark.parametrize(
    "depth, how, right, note",
    [
        (levels(5000), {"depth_scale": 5000}, DEPTH, "along the ray"),
        (LEVELS, {}, DEPTH, "1000 levels a metre, for want of a scale"),
        (
            LEVELS * 8,  # as if turned
            {"depth_scale": 8000},
            DEPTH,
            "multiples of 8: if these are SUN RGB-D's",
        ),
        (
            np.where(DEPTH > 2.9, np.uint16(65535), LEVELS),
            {},
            np.where(DEPTH > 2.9, np.nan, DEPTH),
            "at level 65535, taken as unknown",
        ),
        (
            LEVELS.clip(max=2500),
            {},
            DEPTH.clip(max=2.5),
            "at the largest level, 2500",
        ),
    ],
)
def test_levels_are_depths_and_odd_ones_are_named(depth, how, right, note):
    frame = read(depth, **how)
    assert_allclose(frame.depth, right, atol=6e-4)
    assert note in frame.note


@mark.parametrize(
    "light, how, right, note",
    [
        (LIGHT, {}, 0.5, ""),
        (INFRARED, {"linear": True}, 1.0, ""),
        (INFRARED, {}, 0.0003, "is it linear (--linear)?"),
        (np.full((24, 32), 188, np.uint8), {}, 0.5, "resampled from 24x32 to 12x16 px"),
    ],
)
def test_light_is_linear_and_dark_light_is_named(light, how, right, note):
    frame = read(LEVELS, light, **how)
    assert_allclose(frame.intensity, right, atol=0.005)
    assert note in frame.note


def test_planar_depth_becomes_range_along_the_ray():
    frame = read(levels(5000), depth_scale=5000, planar=True, camera=CAMERA)
    assert_allclose(frame.depth, DEPTH * ray_lengths(SHAPE, CAMERA), atol=1.2e-4)


@mark.parametrize(
    "name, depth, within",
    [
        ("d.pgm", LEVELS, 6e-4),
        ("d.npy", LEVELS, 6e-4),
        ("d.NPY", DEPTH, 1e-6),
        ("d.pfm", DEPTH.astype(np.float32), 1e-6),
    ],
)
def test_other_formats_hold_levels_or_metres(name, depth, within):
    assert_allclose(read(depth, name=name).depth, DEPTH, atol=within)


@mark.parametrize(
    "depth, how, message",
    [
        (LIGHT, {}, "one channel of depth"),
        (LEVELS, {"planar": True}, "for planar depth a camera"),
        (LEVELS, {"depth_scale": 0}, "depth scale > 0"),
    ],
)
def test_what_a_pair_lacks_is_asked_for(depth, how, message):
    with refused(message):
        read(depth, **how)


def test_depth_without_light_is_refused():
    depth = write("d.png", LEVELS)
    with refused("intensity image beside"):
        load_frame(depth)
    Path("fake.png").write_bytes(b"no image")
    with refused("Expected a PNG image"):
        load_frame(depth, intensity="fake.png")
    counts = write("light.npy", LIGHT.astype(np.int32))
    with refused("8 or 16 bits or floats, got int32"):
        load_frame(depth, intensity=counts)


@mark.parametrize(
    "content",
    [
        b"P5 16 12 4095 " + LEVELS.byteswap().tobytes(),
        b"P2 16 12 4095 " + b"1500 " * 192,
    ],
)
def test_levels_that_would_be_stretched_are_refused(content):
    Path("d.pgm").write_bytes(content)
    with refused("largest level is neither 255 nor 65535"):
        load_frame("d.pgm", intensity=write("light.png", LIGHT))


@mark.parametrize("place", [".", "a.npz"])
@mark.parametrize(
    "options", [{"planar": True}, {"depth_scale": 5.0}, {"intensity": "a"}]
)
def test_options_of_images_are_refused_beside_archives(place, options):
    np.savez("a.npz", depth=DEPTH, intensity=DEPTH / 9)
    with refused("Leave these out"):
        load_frame(place, **options)


def test_pairs_of_a_folder_are_read_in_the_order_of_their_numbers(tmp_path):
    depth = LEVELS.copy()
    depth[0, 0] = 0
    for name in ("2.png", "10.png"):
        write(f"depth/{name}", depth)
        write(f"rgb/{name}", LIGHT)
    listed = frames_in(tmp_path)
    assert [one.name for one in listed] == [f"{tmp_path.name}/{n}" for n in (2, 10)]
    assert np.argwhere(np.isnan(listed[0].load().depth)).tolist() == [[0, 0]]


def test_scannet_tells_its_camera():
    write("depth/0.png", LEVELS)
    write("color/0.png", LIGHT)
    matrix = Path("intrinsic/intrinsic_depth.txt")
    matrix.parent.mkdir()
    matrix.write_text("9 0 7 0\n0 8 6 0\n0 0 1 0\n0 0 0 1\n")
    found = load_frame(".")
    told = load_frame(".", planar=True, camera=[9.0, 8.0, 7.5, 6.5])
    assert_array_equal(found.camera, told.camera)
    assert_array_equal(found.depth, told.depth)
    matrix.write_text("9 0 7 0")
    with refused("a matrix of the camera"):
        load_frame(".")


def test_what_cannot_be_read_is_told_how_to_convert():
    Path("d.exr").write_bytes(b"v/1\x01")
    with refused(r"got d\.exr\. Convert it: numpy\.save"):
        load_frame("d.exr", intensity="light.png")


@mark.parametrize(
    "level, kind, right, note",
    [
        (51, np.uint8, 0.2, "255 is 1"),
        (13107, np.uint16, 0.2, "65535 is 1"),
        (1, np.uint8, 1.0, "at 1 or above, and counts as white"),
        (900, float, 900.0, "at 1 or above, and counts as white"),
        (0.3, float, 0.3, ""),
    ],
)
def test_light_of_an_archive_is_what_its_type_says(level, kind, right, note):
    light = np.full(SHAPE, level, kind)
    np.savez("a.npz", depth=DEPTH, intensity=light)
    frame = load_frame("a.npz")
    assert_allclose(frame.intensity, right, rtol=1e-6)
    assert note in frame.note
    assert bool(note) == bool(frame.note)
    assert_array_equal(Frame(DEPTH, light).intensity, frame.intensity)


TUM_DEPTH = """\
# timestamp filename
1.0100 depth/1.01.png
9.0000 depth/9.0.png
1.0400 depth/1.04.png
"""
TUM_RGB = """\
# timestamp filename
1.0000 rgb/1.0.png
1.0500 rgb/1.05.png
"""


def test_a_tum_sequence_is_read_as_downloaded():
    """The second depth has no colour near it in time."""
    for time in ("1.01", "9.0", "1.04"):
        write(f"depth/{time}.png", levels(5000))
    write("rgb/1.0.png", LIGHT)
    write("rgb/1.05.png", np.full_like(LIGHT, 255))
    Path("depth.txt").write_text(TUM_DEPTH)
    Path("rgb.txt").write_text(TUM_RGB)
    frames = [source.load() for source in frames_in(".")]
    assert [frame.name for frame in frames] == ["1.01", "1.04"]
    assert_allclose(frames[0].depth, DEPTH, atol=2e-4)
    assert [round(float(frame.intensity[0, 0]), 1) for frame in frames] == [0.5, 1.0]
    wide = frames_in(".", camera=[8.0, 8.0, 8.0, 6.0])[0].load()
    assert (wide.depth > frames[0].depth).all()
    with refused("for planar depth a camera"):
        load_frame(".", planar=True)


def test_evaluate_reads_images_as_told_and_stores_what_is_odd(succeeds):
    write("depth/1.png", levels(5000))
    write("color/1.png", LIGHT)
    command = "evaluate . --method middle --json scores.json"
    note = "depth taken along the ray"
    assert f"1: {note}" in succeeds(command, "--depth-scale 5000")
    assert read_json(Path("scores.json"))["notes"]["1"] == note
    assert "1000 levels a metre" in succeeds(command)
