"""Whole rooms: the same bytes from the same seed, resumed, grown, refused."""

import itertools
import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from cmtof.scenes.hypersim import Hypersim
from cmtof.scenes.rooms import furnish
from cmtof.scenes.rooms.cameras import Lens
from cmtof.scenes.rooms.household import PLACES
from cmtof.scenes.rooms.inventory import CATALOGUE
from cmtof.scenes.rooms.objects import groups
from cmtof.scenes.rooms.rendering import (
    Settings,
    expose,
    frame_of,
    render_rooms,
    render_scene,
    split_of,
)
from cmtof.scenes.rooms.scene import KINDS, build, close_views, stream
from cmtof.scenes.rooms.view import Picture

pytest.importorskip("embreex")
SMALL = Settings(seed=3, scenes=2, views=3, height=48, width=64)


def contents(root: Path) -> dict[str, bytes]:
    files = (path for path in root.rglob("*") if path.is_file())
    return {path.relative_to(root).as_posix(): path.read_bytes() for path in files}


@pytest.fixture(scope="module")
def rendered(tmp_path_factory) -> Path:
    root = tmp_path_factory.mktemp("rooms")
    render_rooms(root, SMALL, workers=1)
    return root


def test_every_name_that_rooms_ask_for_can_be_made():
    names = {name for pair in furnish.EXTRAS.values() for part in pair for name in part}
    names |= {name for group in groups.values() for name, _ in group}
    names |= set(PLACES)
    assert names <= set(CATALOGUE)
    assert set(PLACES.values()) <= set(groups)
    assert set(KINDS) <= set(furnish.ROOMS) & set(furnish.EXTRAS)


def test_the_same_seed_gives_the_same_bytes_also_by_two_processes(rendered, tmp_path):
    render_rooms(tmp_path, SMALL, workers=2)
    assert contents(tmp_path) == contents(rendered)


def test_another_seed_gives_another_room(rendered, tmp_path):
    other = Settings(seed=4, scenes=1, views=1, height=48, width=64)
    render_rooms(tmp_path, other, workers=1)
    depth = "images/scene_cam_00_geometry_hdf5/frame.0000.depth_meters.hdf5"
    assert (
        contents(tmp_path)[f"room_004_000/{depth}"] != contents(rendered)[f"room_003_000/{depth}"]
    )


def test_a_run_that_was_cut_off_goes_on_to_the_same_bytes(rendered, tmp_path):
    render_rooms(tmp_path, SMALL, workers=1)
    images = tmp_path / "room_003_001" / "images"
    lost = sorted(images.rglob("frame.0001.*"))
    assert lost
    for path in lost:
        path.unlink()
    half_written = lost[0].with_name(".frame.part-1.hdf5")
    half_written.write_bytes(b"cut")
    done = render_rooms(tmp_path, SMALL, workers=1)
    assert sum(one.rendered for one in done) == 1
    assert contents(tmp_path) == contents(rendered)


def test_what_is_there_is_not_rendered_again(rendered):
    done = render_scene(rendered, SMALL, 0)
    assert done.rendered == 0
    assert done.build_s == 0


def test_a_set_grows_and_keeps_its_first_rooms_and_views(rendered, tmp_path):
    small = Settings(seed=3, scenes=1, views=2, height=48, width=64)
    render_rooms(tmp_path, small, workers=1)
    render_rooms(tmp_path, SMALL, workers=1)
    grown, whole = contents(tmp_path), contents(rendered)
    pictures = [name for name in whole if "/images/" in name]
    assert all(grown[name] == whole[name] for name in pictures)


def test_a_folder_of_other_settings_is_refused(rendered, tmp_path):
    other = Settings(seed=3, scenes=2, views=3, height=48, width=48)
    with pytest.raises(ValueError, match=r"Expected an empty folder .*rooms.json. Choose another"):
        render_rooms(rendered, other, workers=1)
    (tmp_path / "holiday.jpg").write_bytes(b"")
    with pytest.raises(ValueError, match=r"got other files in .* Choose another folder."):
        render_rooms(tmp_path, SMALL, workers=1)
    (tmp_path / "rooms.json").write_text("{")
    with pytest.raises(ValueError, match=r"Expected settings in .*rooms.json"):
        render_rooms(tmp_path, SMALL, workers=1)


@pytest.mark.parametrize("name", ["scenes", "views", "height", "width"])
def test_nothing_to_render_is_refused(name):
    with pytest.raises(ValueError, match=f"Expected {name} of at least 1, got 0. Ask for more."):
        Settings(**{name: 0})


def test_a_negative_seed_is_refused():
    with pytest.raises(ValueError, match=r"Expected a seed >= 0, got -1. Choose another."):
        Settings(seed=-1)


def test_hypersims_reader_reads_the_rooms(rendered):
    tree = Hypersim(rendered)
    views = tree.views
    assert len(views) == SMALL.scenes * SMALL.views
    frame = views[0].frame()
    assert frame.depth.dtype == np.float32
    assert frame.depth.shape == (48, 64)
    assert frame.camera is not None
    assert frame.camera[:2] == pytest.approx(SMALL.lens(0).focal, rel=1e-6)
    assert np.isfinite(frame.depth).mean() > 0.7


def test_range_and_pose_agree_between_two_views_of_one_room(rendered):
    """Points of one view, thrown into space by its pose, lie on the surfaces of the room."""
    scene = build(3, 0)
    view = Hypersim(rendered).views[0]
    position, orientation = view.pose()
    rays = view.rays() @ orientation.T
    points = position + rays * view.depth()[..., None]
    known = np.isfinite(view.depth())
    toward = (points[known] - position).astype(np.float32)
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    start = np.tile(position.astype(np.float32), (len(toward), 1))
    again = scene.light.tracer.nearest(start, toward).distance
    agree = np.abs(again - view.depth()[known]) < 1e-3
    assert agree.mean() > 0.99  # the others graze an edge


def test_settings_are_written_down(rendered):
    found = json.loads((rendered / "rooms.json").read_text())
    assert found["seed"] == 3
    assert found["views"] == 3
    assert "version" in found


def test_the_first_view_stays_when_more_are_asked_for():
    scene = build(3, 1)
    lens = Lens((48, 64), 55.0)
    few, many = scene.cameras(1, lens)["cam_00"], scene.cameras(4, lens)["cam_00"]
    assert np.array_equal(few[0].position, many[0].position)


def test_splits_are_by_scene_eight_to_one_to_one():
    assert Counter(split_of(i) for i in range(50)) == {"train": 40, "val": 5, "test": 5}


def test_one_view_in_ten_is_close_whatever_the_number_of_views():
    for views in (1, 3, 5, 10):
        close = sum(close_views(i, views) for i in range(100))
        assert close == pytest.approx(10 * views, abs=1)


def test_streams_of_random_numbers_are_apart():
    uses = itertools.product((0, 1), repeat=3)
    draws = {tuple(stream(*use).integers(0, 2**62, 2)) for use in uses}
    assert len(draws) == 8


def test_exposure_sets_the_median_and_only_scales():
    color = np.random.default_rng(0).uniform(0.5, 2, (20, 20, 3)).astype(np.float32)
    seen = Picture(color, np.ones((20, 20), np.float32), color, np.ones((20, 20), np.int32))
    middle = expose(seen, 0.6).color
    assert np.ptp(middle / color) == pytest.approx(0, abs=1e-5)
    assert np.median(middle @ [0.3, 0.59, 0.11]) == pytest.approx(0.38, rel=1e-3)
    medians = [np.median(expose(seen, r).color) for r in (0.05, 0.2, 0.6, 0.95)]
    assert medians == sorted(medians)


def test_a_frame_keeps_green_and_the_lens():
    color = np.zeros((4, 6, 3), np.float32)
    color[..., 1] = 0.5
    seen = Picture(color, np.ones((4, 6), np.float32), color, np.ones((4, 6), np.int32))
    frame = frame_of(seen, Lens((4, 6), 5.0), "one")
    assert frame.intensity == pytest.approx(np.full((4, 6), 0.5))
    assert frame.camera == pytest.approx([5, 5, 3, 2])
