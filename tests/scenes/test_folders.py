"""Folders of frames in the styles of TUM, NYU and ScanNet, of npz, and trees."""

import numpy as np
import pytest
from PIL import Image

from cmtof.scenes import load_frame
from cmtof.scenes.folders import STYLES, frames_in, read_intrinsics, style_of
from cmtof.scenes.frame import Frame, Frames, ray_lengths

VGA = (480, 640)
SMALL = (24, 32)
CAMERA = (30.0, 30.0, 16.0, 12.0)


def planar_depth(shape):
    return np.linspace(0.5, 4, shape[0] * shape[1]).reshape(shape)


def write_pair(depth, colour, *, scale, shape=SMALL, colour_shape=None, level=188):
    for path in (depth, colour):
        path.parent.mkdir(parents=True, exist_ok=True)
    levels = np.rint(planar_depth(shape) * scale).astype(np.uint16)
    levels[0, 0] = 0
    Image.fromarray(levels).save(depth)
    image = np.zeros((*(colour_shape or shape), 3), np.uint8)
    image[..., 1] = level
    Image.fromarray(image).save(colour)


@pytest.fixture
def tum(tmp_path):
    """Times differ by 4 ms; the last depth image has no partner."""
    folder = tmp_path / "freiburg"
    stamps = [(1.000, 1.004), (1.033, 1.037), (1.066, 2.5)]
    for depth, colour in stamps:
        names = folder / "depth" / f"{depth:.6f}.png", folder / "rgb" / f"{colour:.6f}.png"
        write_pair(*names, scale=5000, shape=VGA)
    for kind, column in (("depth", 0), ("rgb", 1)):
        lines = [f"{s[column]:.6f} {kind}/{s[column]:.6f}.png" for s in stamps]
        (folder / f"{kind}.txt").write_text("\n".join(["# list", *lines]))
    return folder


@pytest.fixture
def scannet(tmp_path):
    folder = tmp_path / "scene0000_00"
    for number in (0, 2, 10):
        names = folder / "depth" / f"{number}.png", folder / "color" / f"{number}.jpg"
        write_pair(*names, scale=1000, colour_shape=(48, 64))
    (folder / "intrinsic").mkdir()
    matrix = np.diag([30.0, 30.0, 1, 1])
    matrix[:2, 2] = 15.5, 11.5
    np.savetxt(folder / "intrinsic" / "intrinsic_depth.txt", matrix)
    return folder


def names_of(sources):
    return [source.name for source in sources]


def test_tum_frames_are_paired_by_time(tum):
    assert names_of(frames_in(tum)) == ["freiburg/1.000000", "freiburg/1.033000"]


def test_tum_frames_have_their_scale_and_become_range(tum):
    frame = frames_in(tum)[0].load()
    expected = planar_depth(VGA) * ray_lengths(VGA, STYLES["tum"].camera)
    assert np.isnan(frame.depth[0, 0])
    np.testing.assert_allclose(frame.depth[1:], expected[1:], atol=1.5e-4)
    assert frame.note == "tum style: 5000 levels per metre, along the axis, camera 525 525 320 240"


@pytest.mark.parametrize("lists", [["rgb"], ["rgb", "depth"]])
def test_tum_names_are_times_where_lists_are_missing(tum, lists):
    for name in lists:
        (tum / f"{name}.txt").unlink()
    assert len(frames_in(tum)) == 2


def test_tum_names_that_are_no_times_need_a_list(tum):
    (tum / "rgb.txt").unlink()
    (tum / "rgb" / "readme.md").touch()
    with pytest.raises(ValueError, match=r"Expected times as names .* Add the list rgb\.txt"):
        frames_in(tum)


def test_a_list_of_pairs_goes_before_times(tum):
    (tum / "associations.txt").write_text("1.066 depth/1.066000.png 2.5 rgb/2.500000.png\n")
    assert names_of(frames_in(tum)) == ["freiburg/1.066000"]


def test_scannet_frames_are_in_order_of_number(scannet):
    assert names_of(frames_in(scannet)) == [f"scene0000_00/{n}" for n in (0, 2, 10)]


def test_scannet_colour_is_brought_to_the_grid_of_depth(scannet):
    frame = frames_in(scannet)[0].load()
    assert frame.intensity.shape == frame.depth.shape == SMALL
    np.testing.assert_allclose(frame.intensity, 0.503, atol=0.02)  # JPEG


def test_scannet_camera_comes_from_its_file(scannet):
    frame = frames_in(scannet)[0].load()
    np.testing.assert_allclose(frame.camera, CAMERA)
    expected = planar_depth(SMALL) * ray_lengths(SMALL, CAMERA)
    np.testing.assert_allclose(frame.depth[1:], expected[1:], atol=1e-3)


def test_planar_depth_without_a_camera_is_refused(scannet):
    (scannet / "intrinsic" / "intrinsic_depth.txt").unlink()
    with pytest.raises(ValueError, match=r"Expected camera .* planar depth of 0\.png"):
        frames_in(scannet)[0].load()
    assert frames_in(scannet, camera=CAMERA)[0].load().camera is not None


@pytest.mark.parametrize("text", ["", "1 2\n3 4", "1 2 3\n4 5 x\n7 8 9"])
def test_matrices_that_are_none_are_named(tmp_path, text):
    (tmp_path / "intrinsic_depth.txt").write_text(text)
    with pytest.raises(ValueError, match=r"3x3 or 4x4 matrix in .*intrinsic_depth\.txt"):
        read_intrinsics(tmp_path / "intrinsic_depth.txt")


def test_nyu_pairs_have_equal_names(tmp_path):
    for number in (1, 2):
        names = tmp_path / "depth" / f"{number:05}.png", tmp_path / "rgb" / f"{number:05}.jpg"
        write_pair(*names, scale=1000, shape=VGA)
    write_pair(tmp_path / "depth" / "9.png", tmp_path / "other.png", scale=1000)
    assert style_of(tmp_path) == "nyu"
    sources = frames_in(tmp_path)
    assert len(sources) == 2
    frame = sources[0].load()
    expected = planar_depth(VGA) * ray_lengths(VGA, STYLES["nyu"].camera)
    np.testing.assert_allclose(frame.depth[1:], expected[1:], atol=1e-3)


def test_flat_nyu_pairs_stand_side_by_side(tmp_path):
    for name in ("b", "a"):
        names = tmp_path / f"{name}_depth.png", tmp_path / f"{name}_colors.png"
        write_pair(*names, scale=1000)
    write_pair(tmp_path / "c_depth.png", tmp_path / "unrelated.png", scale=1000)
    assert [n.split("/")[1] for n in names_of(frames_in(tmp_path))] == ["a_depth", "b_depth"]


def test_the_camera_of_a_style_holds_for_its_size_only(tmp_path):
    write_pair(tmp_path / "a_depth.png", tmp_path / "a_colors.png", scale=1000)
    with pytest.raises(ValueError, match="Expected camera"):
        frames_in(tmp_path)[0].load()


def test_given_numbers_go_before_those_of_the_style(tum):
    given = {"depth_scale": 1000.0, "planar": False, "camera": CAMERA}
    frame = frames_in(tum, **given)[0].load()
    np.testing.assert_allclose(frame.depth[1:], 5 * planar_depth(VGA)[1:], atol=6e-4)
    np.testing.assert_array_equal(frame.camera, CAMERA)


def test_unknown_styles_are_refused(tum):
    with pytest.raises(ValueError, match="style out of tum, nyu, scannet, got kitti"):
        frames_in(tum, style="kitti")


def test_images_of_another_field_of_view_are_refused(tmp_path):
    names = tmp_path / "a_depth.png", tmp_path / "a_rgb.png"
    write_pair(*names, scale=1000, colour_shape=(24, 48))
    with pytest.raises(ValueError, match=r"sides of the depth image .* Crop or register"):
        frames_in(tmp_path, camera=CAMERA)[0].load()


def test_colour_in_place_of_depth_is_refused(tmp_path):
    write_pair(tmp_path / "depth.png", tmp_path / "colour.png", scale=1000)
    with pytest.raises(ValueError, match=r"one channel of depth in .*colour\.png, got 3"):
        load_frame(tmp_path / "colour.png", intensity=tmp_path / "depth.png")


@pytest.mark.parametrize("mode", ["L", "LA", "RGBA", "P", "I;16"])
def test_images_of_every_mode_give_linear_light(tmp_path, mode):
    write_pair(tmp_path / "depth.png", tmp_path / "colour.png", scale=1000)
    levels = np.full(SMALL, 188 * 257 if mode == "I;16" else 188, np.uint16)
    grey = Image.fromarray(levels if mode == "I;16" else levels.astype(np.uint8))
    (grey if mode == "I;16" else grey.convert(mode)).save(tmp_path / "colour.png")
    frame = load_frame(tmp_path / "depth.png", intensity=tmp_path / "colour.png")
    np.testing.assert_allclose(frame.intensity, 0.503, atol=0.002)


def test_averaging_colour_keeps_its_light(tmp_path):
    write_pair(tmp_path / "depth.png", tmp_path / "colour.png", scale=1000)
    checks = np.zeros((48, 64, 3), np.uint8)
    checks[::2, ::2] = checks[1::2, 1::2] = 255
    Image.fromarray(checks).save(tmp_path / "colour.png")
    frame = load_frame(tmp_path / "depth.png", intensity=tmp_path / "colour.png")
    np.testing.assert_allclose(frame.intensity, 0.5, atol=1e-6)  # of light, not of levels


def test_npz_in_a_folder_are_listed_by_name(tmp_path):
    for name in ("b", "a"):
        Frame(np.ones((3, 4)), np.ones((3, 4)), name=name).save(tmp_path / f"{name}.npz")
    assert names_of(frames_in(tmp_path)) == ["a", "b"]
    assert load_frame(tmp_path).name == "a"


def test_a_folder_of_folders_is_gone_through(scannet, tmp_path):
    more = tmp_path / "more"
    more.mkdir()
    Frame(np.ones((3, 4)), np.ones((3, 4))).save(more / "z.npz")
    assert names_of(frames_in(tmp_path)) == ["z", *[f"scene0000_00/{n}" for n in (0, 2, 10)]]


def test_a_file_or_an_embedded_name_is_one_frame(tmp_path):
    assert names_of(frames_in("still_life")) == ["still_life"]
    Frame(np.ones((3, 4)), np.ones((3, 4))).save(tmp_path / "a.npz")
    assert frames_in(tmp_path / "a.npz")[0].load().name == "a"
    with pytest.raises(FileNotFoundError, match="no_such"):
        frames_in("no_such")[0].load()


def test_a_folder_without_frames_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"Expected frames in .* Name the folder"):
        frames_in(tmp_path)


def test_broken_frames_of_a_folder_are_skipped_and_counted(scannet):
    (scannet / "depth" / "2.png").write_bytes(b"no image")
    frames = Frames(frames_in(scannet))
    assert [frame.name for frame in frames] == ["scene0000_00/0", "scene0000_00/10"]
    assert list(frames.skipped) == ["scene0000_00/2"]
    assert "Expected a PNG image" in frames.skipped["scene0000_00/2"]


# --- trees ---------------------------------------------------------------------------------


def test_of_a_tree_the_test_frames_are_listed(tree):
    expected = ["ai_001_001/cam_00/0042", "ai_002_001/cam_00/0042"]
    assert names_of(frames_in(tree)) == names_of(frames_in(tree, partition="test")) == expected
    assert len(frames_in(tree, partition="all")) == 9
    assert len(frames_in(tree, partition="train")) == 3


def test_of_a_tree_without_test_frames_every_view_is_listed(tree):
    assert len(frames_in(tree / "ai_001_002")) == 3


def test_an_empty_partition_is_refused(tree):
    with pytest.raises(ValueError, match="views of the partition val"):
        frames_in(tree, partition="val")


def test_frames_of_a_tree_load_with_smoothing_if_asked_for(tree):
    assert frames_in(tree, smooth=True)[0].load().note.startswith("float16 depth smoothed")
