"""Sets of rooms: the same bytes from the same seed, resumed, grown, refused; their statistics."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_less
from pytest import approx, fixture, mark
from refusals import WRONG, refused

from cmtof.frame import brightness
from cmtof.hardness import hardness
from cmtof_rooms.interior import Picture
from cmtof_rooms.rendering import (
    Settings,
    expose,
    render_rooms,
    render_views,
)

pytest.importorskip("embreex")
SMALL = Settings(seed=3, scenes=2, views=3, height=48, width=64)


def contents(root):
    files = (path for path in root.rglob("*") if path.is_file())
    return {path.relative_to(root).as_posix(): path.read_bytes() for path in files}


@fixture(scope="module")
def rendered(tmp_path_factory):
    root = tmp_path_factory.mktemp("rooms")
    render_rooms(root, SMALL, workers=1)
    return root


def test_the_same_seed_gives_the_same_bytes_by_two_processes(rendered, tmp_path):
    render_rooms(tmp_path, SMALL, workers=2)
    assert contents(tmp_path) == contents(rendered)


def test_a_set_grows_and_keeps_its_first_rooms_and_views(rendered, tmp_path):
    render_rooms(tmp_path, replace(SMALL, scenes=1, views=2), workers=1)
    render_rooms(tmp_path, SMALL, workers=1)
    grown = contents(tmp_path)
    whole = contents(rendered)
    assert all(grown[name] == whole[name] for name in whole if "/images/" in name)


def test_depth_agrees_with_stored_values_of_another_machine():
    """Range at 35 pixels of four views within 0.1 mm, but for single ones at outlines."""
    stored = json.loads(Path(__file__).with_name("depth.json").read_text())
    views = render_views(Settings(41, 2, 2, 48, 64))
    found = [np.nan_to_num(view.frame.depth[::10, ::10]) for view in views]
    off = abs(np.subtract(found, stored))
    assert (off > 1e-4).mean() < 0.02
    assert np.median(off) < 1e-6


def test_views_are_exposed_to_the_median_of_their_rank(rng):
    color = rng.uniform(0, 3, (40, 50, 3)).astype(np.float32)
    one = np.ones((40, 50), np.float32)
    seen = Picture(color, one, color, one)
    ranks = np.linspace(0.21, 0.99, 9)
    medians = [np.median(brightness(expose(seen, rank).color)) for rank in ranks]
    assert (np.diff(medians) > 0).all()
    assert medians[4] == approx(0.38, rel=0.02)
    assert np.median(brightness(expose(seen, 0.1).color)) < 0.05


@fixture(scope="module")
def views():
    return list(render_views(Settings(51, 30, 3, 128, 192, 221.7)))


@mark.slow
def test_depth_and_brightness_are_spread_nearly_as_hypersims(views):
    """Percentiles over the published ones, and by how much each may differ from them."""
    depth = np.nanpercentile([view.frame.depth for view in views], [5, 25, 50, 75, 95])
    apart = depth / [1.27, 3.0, 4.8, 7.8, 23.0]
    assert_array_less(abs(np.log(apart)), np.log([1.6, 1.4, 1.3, 1.4, 1.9]))
    light = np.percentile(
        [brightness(view.picture.color) for view in views], [25, 50, 75, 90]
    )
    apart = light / [0.08, 0.27, 0.7, 1.6]
    assert_array_less(abs(np.log(apart)), np.log([1.6, 1.4, 1.4, 1.5]))


@mark.slow
def test_views_are_mostly_smooth_and_whole(views):
    slope = np.median(
        np.concatenate([hardness(view.frame.depth).slope for view in views])
    )
    assert slope < 0.3  # wraps a pixel, at half the resolution of the book
    assert np.mean([np.isnan(view.frame.depth).mean() for view in views]) < 0.05


@mark.parametrize("focal", [0.0, -1.0, 1e6, float("nan"), float("inf")])
def test_an_impossible_focal_length_is_refused_before_anything_is_written(
    focal, tmp_path
):
    root = tmp_path / "set"
    with refused(r"Expected a focal length of 1 to 1e6 px, got .* Try"):
        render_rooms(root, Settings(scenes=1, focal=focal), workers=1)
    assert not root.exists()


def test_a_set_of_other_settings_is_refused(rendered):
    with refused(r"Expected an empty folder .*rooms.json. Choose another"):
        render_rooms(rendered, replace(SMALL, width=48), workers=1)


@mark.parametrize("name, message", WRONG["sets"])
def test_a_folder_of_other_or_broken_files_is_refused(tmp_path, name, message):
    (tmp_path / name).write_text("{")
    with refused(message):
        render_rooms(tmp_path, SMALL, workers=1)
