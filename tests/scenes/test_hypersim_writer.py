"""Rendered scenes in Hypersim's layout: whole, the same bytes, read back by the one reader."""

import csv
import hashlib
import os

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from official_tree import official_rays

from cmtof.scenes.hypersim import (
    FILES,
    MANTISSA,
    Hypersim,
    projection_from_focal,
    rounded,
    view_exists,
    view_file,
    write_metadata,
    write_scene,
    write_view,
)

SHAPE = (40, 48)
FOCAL = {"room_000_000": 41.6, "room_000_001": 60.0, "room_000_002": 41.6}
SPLIT = {"room_000_000": "train", "room_000_001": "test", "room_000_002": "val"}
VIEWS = [("cam_00", 0), ("cam_00", 1), ("cam_01", 0)]


def picture(seed=0, shape=SHAPE):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.5, 8, shape).astype(np.float32)
    depth[0, 0] = np.nan
    normal = rng.normal(size=(*shape, 3)).astype(np.float32)
    return {
        "color": rng.lognormal(size=(*shape, 3)).astype(np.float32),
        "depth": depth,
        "normal": normal / np.linalg.norm(normal, axis=-1, keepdims=True),
        "instance": rng.integers(-1, 300, shape, dtype=np.int32),
    }


def write_rooms(root):
    poses = (np.arange(6.0).reshape(2, 3), np.tile(np.eye(3), (2, 1, 1)))
    for number, scene in enumerate(SPLIT):
        cameras = {"cam_00": poses, "cam_01": (poses[0][:1], poses[1][:1])}
        write_scene(root, scene, cameras=cameras, parameters={"seed": number})
        for camera, frame in VIEWS:
            write_view(root, scene, camera, frame, **picture(number + frame))
    write_metadata(root, SPLIT, shape=SHAPE, focal=FOCAL, views=dict.fromkeys(SPLIT, VIEWS))
    return root


@pytest.fixture
def rooms(tmp_path):
    return write_rooms(tmp_path / "rooms")


def contents(root):
    return {
        path.relative_to(root).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(root.rglob("*"))
        if path.is_file()
    }


def test_equal_input_gives_equal_bytes(rooms, tmp_path):
    """Though written at another time, over files that were there, and elsewhere."""
    once = contents(rooms)
    for path in rooms.rglob("*.hdf5"):
        os.utime(path, (0, 0))
    assert contents(write_rooms(rooms)) == once
    assert contents(write_rooms(tmp_path / "again")) == once
    assert len(once) == 3 * (3 * 4 + 2 * 3 + 2) + 2


def test_the_one_reader_reads_rooms(rooms):
    tree, expected = Hypersim(rooms), picture(1)
    view = tree.view("room_000_000", "cam_00", 1)
    frame = view.frame()
    np.testing.assert_array_equal(frame.depth, expected["depth"])  # every bit
    np.testing.assert_allclose(frame.intensity, expected["color"][..., 1], rtol=2.0**-11)
    np.testing.assert_allclose(view.normal(), expected["normal"], rtol=2.0**-11)
    np.testing.assert_array_equal(view.instance(), expected["instance"])
    np.testing.assert_allclose(frame.camera, [41.6, 41.6, 24, 20])
    position, orientation = view.pose()
    np.testing.assert_array_equal(position, [3, 4, 5])
    np.testing.assert_array_equal(orientation, np.eye(3))
    assert frame.note == ""


def test_rays_of_rooms_are_those_of_their_own_lens(rooms):
    for scene, focal in FOCAL.items():
        view = Hypersim(rooms).view(scene, "cam_01", 0)
        expected = official_rays(projection_from_focal(focal, SHAPE), SHAPE)
        np.testing.assert_allclose(view.rays(), expected, atol=1e-12)


def test_rooms_are_tested_on_the_first_view_of_each_test_scene(rooms):
    split = Hypersim(rooms).split()
    assert [view.name for view in split["test"]] == ["room_000_001/cam_00/0000"]
    assert {view.scene for view in split["train"]} == {"room_000_000"}
    assert {view.scene for view in split["val"]} == {"room_000_002"}
    assert len(split["train"]) == 3


def test_files_keep_the_official_names_keys_and_kinds(rooms):
    kinds = {"color": np.float32, "depth": np.float32, "normal": np.float32, "instance": np.int16}
    for kind in FILES:
        with h5py.File(view_file(rooms, "room_000_000", "cam_00", 0, kind)) as file:
            assert list(file) == ["dataset"]
            assert file["dataset"].dtype == kinds[kind]  # type: ignore[union-attr]


def test_instances_beyond_int16_are_int32(tmp_path):
    many = picture() | {"instance": np.full(SHAPE, 40000)}
    write_view(tmp_path, "room", "cam_00", 0, **many)
    with h5py.File(view_file(tmp_path, "room", "cam_00", 0, "instance")) as file:
        assert file["dataset"].dtype == np.int32  # type: ignore[union-attr]


def test_tables_have_the_official_columns(rooms):
    with (rooms / "metadata_images_split_scene_v1.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert rows[0] == {
        "scene_name": "room_000_000", "camera_name": "cam_00", "frame_id": "0",
        "included_in_public_release": "True", "exclude_reason": "",
        "split_partition_name": "train",
    }  # fmt: skip
    with (rooms / "room_000_002" / "_detail" / "metadata_scene.csv").open(newline="") as file:
        assert dict(csv.reader(file))["seed"] == "2"


def test_columns_of_written_tables_stand_in_the_official_ones(rooms, official_tables):
    for name in ("metadata_camera_parameters.csv", "metadata_images_split_scene_v1.csv"):
        with (rooms / name).open() as ours, (official_tables / name).open() as theirs:
            assert set(next(csv.reader(ours))) <= set(next(csv.reader(theirs)))


@pytest.mark.parametrize("kind", FILES)
def test_a_view_exists_when_all_its_files_do(rooms, kind):
    assert view_exists(rooms, "room_000_000", "cam_00", 0)
    view_file(rooms, "room_000_000", "cam_00", 0, kind).unlink()
    assert not view_exists(rooms, "room_000_000", "cam_00", 0)


def test_parts_of_a_killed_run_are_not_seen_and_go(rooms):
    before = contents(rooms)
    geometry = view_file(rooms, "room_000_000", "cam_00", 0, "depth").parent
    (geometry / ".frame.0007.depth_meters.part-1234.hdf5").write_bytes(b"half")
    (rooms / ".metadata_camera_parameters.part-1234.csv").write_bytes(b"half")
    assert not view_exists(rooms, "room_000_000", "cam_00", 7)
    assert len(Hypersim(rooms).views) == 9
    assert contents(write_rooms(rooms)) == before


@pytest.mark.parametrize(
    ("kind", "array"),
    [
        ("color", np.ones(SHAPE)),
        ("normal", np.ones((2, 2, 3))),
        ("depth", np.ones((2, 2))),
        ("instance", np.ones(4)),
    ],
)
def test_shapes_that_do_not_fit_are_refused_before_anything_is_written(tmp_path, kind, array):
    with pytest.raises(ValueError, match=r"room cam_00 frame 3\. Render"):
        write_view(tmp_path, "room", "cam_00", 3, **(picture() | {kind: array}))
    assert list(tmp_path.iterdir()) == []


def test_poses_that_do_not_fit_are_refused(tmp_path):
    with pytest.raises(ValueError, match="Stack one of each a view"):
        write_scene(tmp_path, "room", cameras={"cam_00": (np.ones((2, 3)), np.ones((3, 3, 3)))})


def test_other_partitions_are_refused(tmp_path):
    with pytest.raises(ValueError, match="train, val and test, got dev"):
        write_metadata(tmp_path, {"room": "dev"}, shape=SHAPE, focal=50.0, views={})


floats = arrays(np.float32, 20, elements=st.floats(-(2.0**99), 2.0**99, width=32))


@given(floats, st.integers(1, 22))
def test_rounding_is_within_half_a_place_and_is_done_once(values, bits):
    once = rounded(values, bits)
    normal = np.abs(values) > 1e-30
    error = np.abs(once.astype(float) - values.astype(float))
    assert (error <= 2.0 ** -(bits + 1) * np.abs(values.astype(float)))[normal].all()
    np.testing.assert_array_equal(rounded(once, bits), once)


def test_rounding_keeps_what_float16_holds_and_what_is_no_number():
    held = np.array([0, -0.0, 1, 1.5, -3.1416, 1000, np.nan, np.inf, -np.inf], np.float16)
    np.testing.assert_array_equal(rounded(held.astype(np.float32), MANTISSA), held)
