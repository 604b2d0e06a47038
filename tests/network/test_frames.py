"""Frames packed for training: what is read is what was written."""

import json

import numpy as np
import pytest
from tiny_rooms import write_room, write_rooms

from cmtof.network.frames import pack_frames
from cmtof.scenes.hypersim import Hypersim, View

SHAPE = (16, 24)


@pytest.fixture
def tree(tmp_path):
    return write_rooms(tmp_path / "rooms", SHAPE)


@pytest.mark.parametrize(("partition", "count"), [("train", 16), ("val", 2), ("test", 1)])
def test_a_pack_holds_the_frames_of_its_partition(tree, tmp_path, partition: str, count: int):
    told: list[str] = []
    pack = pack_frames(tree, tmp_path / "packed", partition, told.append)
    views = Hypersim(tree).split()[partition]
    assert len(pack) == len(views) == count
    assert pack.names == told == [view.name for view in views]
    assert pack.depth.shape == pack.intensity.shape == (count, *SHAPE)
    assert (pack.depth.dtype, pack.intensity.dtype) == (np.float32, np.float16)
    for number, view in enumerate(views):
        frame = Hypersim(tree).frame(view)
        np.testing.assert_array_equal(pack.depth[number], frame.depth)  # every bit
        clipped = np.clip(frame.intensity, 0, 1)
        np.testing.assert_allclose(pack.intensity[number], clipped, rtol=2.0**-11)
        assert pack.far[number] == pytest.approx(np.nanpercentile(frame.depth, 99.9))
    assert np.isnan(pack.depth[:, 0, 0]).all()


def test_what_was_packed_is_opened_and_not_packed_again(tree, tmp_path):
    folder = tmp_path / "packed"
    once = pack_frames(tree, folder, "val")
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    told: list[str] = []
    again = pack_frames(tree, folder, "val", told.append)
    assert told == []
    assert {path: path.stat().st_mtime_ns for path in folder.iterdir()} == before
    np.testing.assert_array_equal(again.depth, once.depth)
    assert again.names == once.names


def test_a_grown_tree_is_packed_anew(tmp_path):
    folder = tmp_path / "packed"
    assert len(pack_frames(write_rooms(tmp_path / "rooms", SHAPE, 6), folder, "train")) == 12
    assert len(pack_frames(write_rooms(tmp_path / "rooms", SHAPE, 8), folder, "train")) == 16


def test_a_run_that_was_stopped_while_packing_is_packed_anew(tree, tmp_path):
    """The list is written last: arrays without it are no pack."""
    folder = tmp_path / "packed"
    expected = np.array(pack_frames(tree, folder, "val").depth)
    (folder / "val.json").unlink()
    with (folder / "val_depth.npy").open("r+b") as file:
        file.truncate(200)
    np.testing.assert_array_equal(pack_frames(tree, folder, "val").depth, expected)


def test_broken_frames_are_left_out_and_told(tree, tmp_path):
    View("room_000_000", "cam_00", 1).file(tree, "depth").write_bytes(b"no HDF5")
    View("room_000_003", "cam_00", 0).file(tree, "color").unlink()
    pack = pack_frames(tree, tmp_path / "packed", "train")
    assert len(pack) == len(pack.depth) == len(pack.far) == 14
    assert not {"room_000_000/cam_00/0001", "room_000_003/cam_00/0000"} & set(pack.names)
    assert np.isfinite(pack.depth[:, -1]).all()  # no row of zeros stands for one
    held = json.loads((tmp_path / "packed" / "train.json").read_text())
    assert set(held["skipped"]) == {"room_000_000/cam_00/0001", "room_000_003/cam_00/0000"}
    reopened = pack_frames(tree, tmp_path / "packed", "train")
    assert reopened.names == pack.names and reopened.depth.shape == pack.depth.shape


def test_without_a_whole_frame_there_is_no_pack(tree, tmp_path):
    for frame in (0, 1):
        View("room_000_008", "cam_00", frame).file(tree, "depth").write_bytes(b"no HDF5")
    with pytest.raises(ValueError, match=r"frames to train on, got .*Render them anew"):
        pack_frames(tree, tmp_path / "packed", "val")


def test_frames_of_another_size_are_refused(tree, tmp_path):
    write_room(tree, "room_000_002", 1, 5, (20, 24))
    with pytest.raises(ValueError, match=r"\(16, 24\), got \(20, 24\) in room_000_002/cam_00/0001"):
        pack_frames(tree, tmp_path / "packed", "train")
    assert not (tmp_path / "packed" / "train.json").exists()


def test_too_few_scenes_to_validate_on_are_refused(tmp_path):
    tree = write_rooms(tmp_path / "rooms", SHAPE, 4)
    with pytest.raises(ValueError, match=r"the partition val in .*, got none\. Render 10 scenes"):
        pack_frames(tree, tmp_path / "packed", "val")
