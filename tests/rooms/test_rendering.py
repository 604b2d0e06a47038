"""Sets of rooms: the same bytes from the same seed, resumed, grown, refused; their statistics."""

import json
from pathlib import Path

import numpy as np
import pytest

from cmtof.frame import brightness
from cmtof.hardness import hardness
from cmtof_rooms import rendering
from cmtof_rooms.engine import Picture
from cmtof_rooms.rendering import Settings, expose, render_rooms, rendered_views

pytest.importorskip("embreex")
SMALL = Settings(seed=3, scenes=2, views=3, height=48, width=64)
STORED = Path(__file__).with_name("depth.json")


def contents(root):
    files = (path for path in root.rglob("*") if path.is_file())
    return {path.relative_to(root).as_posix(): path.read_bytes() for path in files}


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    root = tmp_path_factory.mktemp("rooms")
    render_rooms(root, SMALL, workers=1)
    return root


def test_the_same_seed_gives_the_same_bytes_by_two_processes(rendered, tmp_path):
    render_rooms(tmp_path, SMALL, workers=2)
    assert contents(tmp_path) == contents(rendered)


def test_a_set_grows_and_keeps_its_first_rooms_and_views(rendered, tmp_path):
    render_rooms(tmp_path, Settings(seed=3, scenes=1, views=2, height=48, width=64), workers=1)
    render_rooms(tmp_path, SMALL, workers=1)
    grown, whole = contents(tmp_path), contents(rendered)
    assert all(grown[name] == whole[name] for name in whole if "/images/" in name)


def test_depth_agrees_with_stored_values_of_another_machine():
    """Range at 35 pixels of four views within 0.1 mm, but for single ones at outlines."""
    stored = json.loads(STORED.read_text())
    views = rendered_views(Settings(41, 2, 2, 48, 64))
    found = [np.nan_to_num(view.frame.depth[::10, ::10]) for view in views]
    off = np.abs(np.array(found) - np.array(stored))
    assert np.mean(off > 1e-4) < 0.02
    assert np.median(off) < 1e-6


def test_views_are_exposed_to_the_median_of_their_rank():
    color = np.random.default_rng(2).uniform(0, 3, (40, 50, 3)).astype(np.float32)
    seen = Picture(color, np.ones((40, 50), np.float32), color, np.ones((40, 50), np.int32))
    ranks = np.linspace(0.21, 0.99, 9)
    medians = [float(np.median(brightness(expose(seen, rank).color))) for rank in ranks]
    assert np.all(np.diff(medians) > 0)
    assert medians[4] == pytest.approx(0.38, rel=0.02)
    assert float(np.median(brightness(expose(seen, 0.1).color))) < 0.05


@pytest.mark.slow
def test_statistics_come_near_to_hypersims():
    views = list(rendered_views(Settings(51, 30, 3, 128, 192, 221.7)))
    depth = np.concatenate([v.frame.depth[np.isfinite(v.frame.depth)] for v in views])
    light = np.concatenate([brightness(v.picture.color).ravel() for v in views])
    for at, published, ratio in (
        (5, 1.27, 1.6),
        (25, 3.0, 1.4),
        (50, 4.8, 1.3),
        (75, 7.8, 1.4),
        (95, 23.0, 1.9),
    ):
        assert 1 / ratio < np.percentile(depth, at) / published < ratio
    for at, published, ratio in ((25, 0.08, 1.6), (50, 0.27, 1.4), (75, 0.7, 1.4), (90, 1.6, 1.5)):
        assert 1 / ratio < np.percentile(light, at) / published < ratio
    slope = np.median(np.concatenate([hardness(v.frame.depth).slope for v in views]))
    assert slope < 0.3  # wraps a pixel, at half the resolution of the book
    assert np.mean([np.isnan(v.frame.depth).mean() for v in views]) < 0.05


def test_impossible_settings_are_refused():
    for change, message in (
        ({"width": 0}, "Expected width of 1 to 4096, got 0. Choose another."),
        ({"seed": -1}, r"Expected a seed of 0 to 2\^63, got -1."),
        ({"focal": float("nan")}, "Expected a focal length of 1 to 1e6 px, got nan"),
    ):
        with pytest.raises(ValueError, match=message):
            Settings(**change)
    with pytest.raises(ValueError, match="Expected a size like 512x512, got big. Try 768x1024."):
        rendering.shape_from_text("big")


def test_a_folder_of_other_things_is_refused(rendered, tmp_path):
    other = Settings(seed=3, scenes=2, views=3, height=48, width=48)
    with pytest.raises(ValueError, match=r"Expected an empty folder .*rooms.json. Choose another"):
        render_rooms(rendered, other, workers=1)
    (tmp_path / "holiday.jpg").write_bytes(b"")
    with pytest.raises(ValueError, match=r"got other files in .* Choose another folder."):
        render_rooms(tmp_path, SMALL, workers=1)
    (tmp_path / "rooms.json").write_text("{")
    with pytest.raises(ValueError, match=r"Expected YAML in .*rooms.json"):
        render_rooms(tmp_path, SMALL, workers=1)
