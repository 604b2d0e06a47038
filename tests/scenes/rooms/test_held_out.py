import numpy as np
import pytest

from cmtof.scenes.rooms.held_out import TEST_ROOMS, held_out, held_out_frame, held_out_frames
from cmtof.scenes.rooms.rendering import Settings, frame_of, render_view, split_of
from cmtof.scenes.rooms.scene import build

SMALL = Settings(seed=3, scenes=10, height=24, width=32)


@pytest.fixture(scope="module")
def frame():
    return held_out_frame(SMALL, 9)


def test_the_tables_have_as_many_frames_as_the_paper():
    assert len(held_out()) == 46
    assert {split_of(index) for index in held_out()} == {"test"}
    assert (TEST_ROOMS.height, TEST_ROOMS.width) == (512, 512)


def test_nothing_trains_on_their_rooms():
    from cmtof.network.configuration import configurations, read_config

    seeds = {read_config(name).rooms.seed for name in configurations()}
    assert TEST_ROOMS.seed not in seeds


@pytest.mark.slow
def test_a_frame_is_the_first_view_of_its_scene_in_a_set_of_any_size(frame):
    assert frame.name == "room_003_009/cam_00"
    scene, lens = build(3, 9), SMALL.lens(9)
    for views in (2, 5):
        pose = scene.cameras(views, lens)["cam_00"][0]
        same = frame_of(render_view(scene, pose, lens, 0), lens, "")
        assert np.array_equal(frame.depth, same.depth, equal_nan=True)
        assert np.array_equal(frame.intensity, same.intensity)


def test_frames_come_one_by_one_and_only_those_asked_for(monkeypatch):
    built = []
    monkeypatch.setattr(
        "cmtof.scenes.rooms.held_out.held_out_frame", lambda settings, index: built.append(index)
    )
    frames = held_out_frames(Settings(seed=3, scenes=400), count=2)
    assert built == []
    next(frames)
    assert built == [9]
    assert len(list(frames)) == 1
    assert built == [9, 19]


@pytest.mark.slow
def test_another_process_renders_the_same(frame):
    (other,) = held_out_frames(SMALL, workers=2)
    assert other.name == frame.name
    assert np.array_equal(other.depth, frame.depth, equal_nan=True)
    assert np.array_equal(other.intensity, frame.intensity)
