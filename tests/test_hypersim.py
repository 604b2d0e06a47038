"""Hypersim's tree as its authors describe it, and rooms written in the same layout."""

from itertools import chain

import h5py
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from official_tree import (
    PLAIN,
    PROJECTIONS,
    SHAPE,
    VIEWS,
    wall,
    write_official,
    write_tree,
)
from pytest import approx, fixture, mark
from refusals import refused
from scipy.spatial.transform import Rotation
from vectors import unit

from cmtof.frame import Frames
from cmtof.hypersim import (
    PARTITIONS,
    Hypersim,
    View,
    camera_from_projection,
    read_array,
    split_views,
    write_metadata,
)
from cmtof.pointcloud import points_from_depth
from cmtof.scenes import load_frame
from cmtof_rooms.rendering import view_exists, write_view

FIRST = View("ai_001_001", "cam_00", 0)


@fixture
def tree(tmp_path):
    """Three scenes of three views, as the data set's description has them."""
    return write_tree(tmp_path / "hypersim")


def test_a_tree_holds_its_views_and_official_float16_files_load(tree):
    whole = Hypersim(tree)
    assert whole.views == [
        View(scene, *view) for scene in PROJECTIONS for view in VIEWS
    ]
    assert Hypersim(tree / "ai_001_002").views == whole.views[3:6]
    frame = whole.frame(FIRST)
    assert_array_equal(frame.depth[1:], wall(PLAIN).astype(np.float16)[1:])
    assert np.isnan(frame.depth).sum() == 3  # NaN, infinite and 0
    assert frame.intensity[3, 3] == 0.5  # green, linear, as stored
    # NaN, inf, negative
    assert frame.intensity.diagonal()[5:8].tolist() == [0, 65504, 0]
    assert frame.name == "ai_001_001/cam_00/0000"
    assert frame.note == "float16 depth in steps of up to 2.0 mm"


@mark.parametrize("kind", ["depth", "color"])
def test_files_and_scenes_may_be_links(tree, tmp_path, kind):
    file = FIRST.file(tree, kind)
    file.symlink_to(file.rename(tmp_path / "object"))
    assert load_frame(FIRST.file(tree, "depth")).camera is not None
    scene = tree / FIRST.scene
    store = tmp_path / "room[1]"
    scene.symlink_to(scene.rename(store), target_is_directory=True)
    assert load_frame(scene).name == "ai_001_001/cam_00/0042"
    assert len(Hypersim(store).views) == 3


@mark.parametrize("scene", PROJECTIONS)
def test_depth_is_range_and_its_camera_keeps_a_wall_flat(tree, scene):
    """Points by the frame's camera are the true ones, turned: a plane, 2 m away."""
    view = View(scene, "cam_00", 0)
    write_official(
        view.file(tree, "depth"), wall(PROJECTIONS[scene]).astype(np.float32)
    )
    frame = Hypersim(tree).frame(view)
    points = points_from_depth(frame.depth, frame.camera).reshape(-1, 3)
    normal = np.linalg.lstsq(points, np.ones(len(points)), rcond=None)[0]
    assert 1 / np.linalg.norm(normal) == approx(2.0, abs=1e-5)
    assert_allclose(points @ normal, 1.0, atol=1e-5)


lengths = st.floats(3, 30)
centres = st.floats(-2, 12)


@given(
    lengths,
    lengths,
    centres,
    centres,
    st.floats(-0.02, 0.02),
    st.tuples(*[st.floats(-0.3, 0.3)] * 3),
)
def test_a_turned_pinhole_with_skew_is_found_again(fx, fy, cx, cy, skew, angles):
    turn = Rotation.from_euler("xyz", angles).as_matrix()
    pinhole = np.array([[fx, skew * fx, cx], [0, fy, cy], [0, 0, 1]])
    to_pixel = np.array([[4, 0, 4], [0, -3, 3], [0, 0, 1]])
    projection = np.diag([1.0, -1, -1]) @ turn @ np.linalg.inv(pinhole) @ to_pixel
    camera = camera_from_projection(projection, (6, 8))
    expected = [fx, fy, cx, cy, skew * fx][: len(camera)]
    assert len(camera) == 5 or abs(skew) < 2e-6
    assert_allclose(camera, expected, rtol=1e-7, atol=1e-7)


def cut(path):
    path.write_bytes(path.read_bytes()[:700])


def claims_much(path):
    with h5py.File(path, "w") as file:
        file.create_dataset(
            "dataset", shape=(10**6, 10**6), dtype="f4", chunks=(100, 100)
        )


def holds_nothing(path):
    h5py.File(path, "w").close()


def holds_complex_numbers(path):
    write_official(path, np.ones((2, 2), complex))


def knows_no_depth(path):
    write_official(path, np.full(SHAPE, np.nan))


@mark.parametrize(
    "damage, message",
    [
        (cut, "whole HDF5 file"),
        (claims_much, r"its header claims 4e\+12 bytes"),
        (holds_nothing, "key dataset"),
        (holds_complex_numbers, "numbers on 2 axes"),
        (knows_no_depth, "none above 0"),
    ],
)
def test_a_broken_depth_file_is_named_and_left_out(tree, damage, message):
    damage(FIRST.file(tree, "depth"))
    hypersim = Hypersim(tree)
    with refused(f"(?s){message}") as error:
        hypersim.frame(FIRST)
    assert "ai_001_001" in str(error.value)
    View("ai_001_002", "cam_00", 42).file(tree, "color").unlink()
    frames = Frames(hypersim.sources(hypersim.views))
    assert len(list(frames)) == 7
    assert set(frames.skipped) == {FIRST.name, "ai_001_002/cam_00/0042"}


def test_what_is_missing_is_named(tree):
    depth = FIRST.file(tree, "depth")
    FIRST.file(tree, "color").unlink()
    with refused(r"frame\.0000\.color\.hdf5", FileNotFoundError):
        Hypersim(tree).frame(FIRST)
    frame = load_frame(depth)
    assert (frame.intensity == 1).all()
    assert frame.note.endswith("intensity 1 everywhere")
    (tree / "metadata_camera_parameters.csv").unlink()
    assert load_frame(depth).camera is None
    (tree / "metadata_images_split_scene_v1.csv").unlink()
    with refused(r"split_scene_v1\.csv in or beside", FileNotFoundError):
        Hypersim(tree).split()
    with refused("Expected scenes such as"):
        Hypersim(tree / "ai_001_001" / "images")
    with refused("Keep the layout"):
        load_frame(depth.rename(tree / depth.name))


def test_damaged_tables_are_named(tree):
    text = "scene_name,camera_name,frame_id,split_partition_name\na,b,c,d\n"
    (tree / "metadata_images_split_scene_v1.csv").write_text(text)
    with refused(r"columns and numbers, got .*split_scene_v1.csv"):
        Hypersim(tree).split()
    text = "M_cam_from_uv_00\nminus one\n"
    (tree / "metadata_camera_parameters.csv").write_text(text)
    with refused(r"columns and numbers, got .*camera_parameters.csv"):
        _ = Hypersim(tree).projections


@mark.parametrize("place", [".", "../analysis"])
def test_papers_frames_are_tested_and_their_scenes_never_trained_on(tree, place):
    (tree / place).mkdir(exist_ok=True)
    for table in list(tree.glob("*.csv")):
        table.rename(tree / place / table.name)
    split = Hypersim(tree).split()
    names = ["ai_001_001/cam_00/0042", "ai_002_001/cam_00/0042"]
    assert [view.name for view in split["test"]] == names
    assert {view.scene for view in split["train"]} == {"ai_001_002"}
    assert load_frame(tree).name == "ai_001_001/cam_00/0042"


scenes = [f"ai_00{i}_00{j}" for i in range(3) for j in range(1, 4)]
scenes += ["room_0", "room_1"]


@given(
    st.dictionaries(st.sampled_from(scenes), st.sampled_from([*PARTITIONS, ""])),
    st.sets(st.sampled_from([("cam_00", 0), ("cam_00", 42), ("cam_01", 42)])),
)
def test_no_view_stands_in_two_partitions(partitions, views):
    listed = [
        View(scene, *view, p) for scene, p in partitions.items() for view in views
    ]
    parts = split_views(listed)
    found = [*chain(*parts.values())]
    assert len(found) == len(set(found))
    assert set(found) <= {v for v in listed if v.partition}
    together = [{v.scene for v in part} for part in parts.values()]
    assert sum(map(len, together)) == len(set().union(*together))


def test_official_tables_and_the_public_depth_file(shared_data):
    """482 turned pinholes, 31 of them skewed; 46 test frames, 34 of official training scenes."""
    tree = Hypersim(shared_data / "hypersim")
    cameras = [camera_from_projection(m, (12, 16)) for m in tree.projections.values()]
    assert (len(cameras), sum(len(camera) == 5 for camera in cameras)) == (482, 31)
    frame = load_frame(next(tree.root.rglob("frame.0000.depth_meters.hdf5")))
    assert frame.depth.shape == (768, 1024)
    assert abs(frame.camera[2:] - [512, 384]).min() > 50  # shifted
    assert tree.split()["test"] == []  # on disk is none
    test = split_views(tree._listed_views)["test"]
    assert [sum(v.partition == name for v in test) for name in PARTITIONS] == [34, 5, 7]


def picture(seed):
    rng = np.random.default_rng(seed)
    return {
        "color": rng.lognormal(size=(40, 48, 3)),
        "depth": rng.uniform(0.5, 8, (40, 48)).astype(np.float32),
        "normal": unit(rng.normal(size=(40, 48, 3))),
        "instance": rng.integers(-1, 300, (40, 48)),
    }


@fixture
def rooms(tmp_path):
    """A training room and a test room of two equal views each."""
    split = {"room_000_000": "train", "room_000_001": "test"}
    views = [("cam_00", 0), ("cam_00", 1)]
    for number, scene in enumerate(split):
        for view in views:
            write_view(tmp_path, View(scene, *view), **picture(number))
    write_metadata(
        tmp_path, (40, 48), {name: (part, 41.6, views) for name, part in split.items()}
    )
    return Hypersim(tmp_path)


def test_rooms_are_read_by_the_one_reader(rooms):
    expected = picture(0)
    view = rooms.views[1]
    frame = rooms.frame(view)
    assert_array_equal(frame.depth, expected["depth"])  # every bit
    assert_allclose(frame.intensity, expected["color"][..., 1], rtol=2.0**-11)
    for kind in ("normal", "instance"):
        found = read_array(view.file(rooms.root, kind), expected[kind].ndim)
        assert_allclose(found, expected[kind], rtol=0, atol=2.0**-11)
    assert_allclose(frame.camera, [41.6, 41.6, 24, 20])
    assert not frame.note
    assert [v.name for v in rooms.split()["test"]] == ["room_000_001/cam_00/0000"]


def test_a_view_exists_once_all_its_files_do(rooms):
    assert all(view_exists(rooms.root, view) for view in rooms.views)
    view = rooms.views[1]
    view.file(rooms.root, "normal").unlink()
    assert not view_exists(rooms.root, view)
