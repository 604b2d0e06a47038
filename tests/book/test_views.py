"""Scenes to turn: a small script of points and colours, a still, and their place on the page."""

import json
from base64 import b64decode
from concurrent.futures.process import BrokenProcessPool
from unittest.mock import MagicMock

import numpy as np
import pytest

from cmtof.pointcloud import points_from_depth
from cmtof_book import views
from cmtof_book.provenance import OUTPUT_VARIABLE

CAMERA = (100.0, 100.0, 40.0, 30.0)


def ball() -> np.ndarray:
    """Ranges (60, 80), m, of a ball before a wall."""
    y, x = (np.mgrid[:60, :80] + 0.5 - np.array([30, 40])[:, None, None]) / 100
    inside = np.maximum(0.2**2 - x**2 - y**2, 0)
    return np.where(inside > 0, 1.0 - np.sqrt(inside), 1.2)


POINTS, COLOURS = points_from_depth(ball(), CAMERA), (1.2 - ball()[..., None]) * [2.5, 2.0, 1.0]
VIEW = {"longest": 0.05, "eye": (-0.3, -0.3, 0.0)}
LAYERS = {"depth": (POINTS, COLOURS), "truth": (POINTS + 0.1, COLOURS)}


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """Folder with a saved scene, and its still."""
    folder = tmp_path_factory.mktemp("results") / "31"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(OUTPUT_VARIABLE, str(folder))
        views.save_scene("ball_scene", LAYERS, **VIEW)
    return folder, views.still(POINTS, COLOURS, **VIEW)


def test_a_script_holds_every_point_and_colour(scene):
    (file,) = scene[0].iterdir()
    call, _, rest = file.read_text(encoding="utf-8").partition(", ")
    assert (file.name, call) == ("ball_scene.js", 'cmtofScene("ball_scene"')
    about = json.loads(rest.rstrip(");\n"))
    assert about["shape"] == [60, 80] and list(about["layers"]) == list(LAYERS)
    for label, (points, colours) in LAYERS.items():
        first, second = map(b64decode, about["layers"][label])
        np.testing.assert_allclose(np.frombuffer(first, "<f4").reshape(60, 80, 3), points, 1e-6)
        levels = np.frombuffer(second, np.uint8).reshape(60, 80, 3) / 255
        np.testing.assert_allclose(levels, np.clip(colours, 0, 1), atol=0.5 / 255 + 1e-9)


def test_the_still_shows_the_surface(scene):
    _, still = scene
    if still is None:
        pytest.skip("no OpenGL here (Debian: apt-get install libegl1 libgl1)")
    assert still.shape[2] == 3 and still.min() >= 0 and still.max() <= 1
    drawn = (still < 0.97).any(axis=-1)
    assert drawn.mean() > 0.3
    assert np.ptp(still[drawn], axis=0).min() > 0.2  # shaded, not one colour


def test_without_opengl_the_still_is_missing(monkeypatch, capsys):
    executor = MagicMock()
    executor.return_value.__enter__.return_value.submit.side_effect = BrokenProcessPool
    monkeypatch.setattr(views, "ProcessPoolExecutor", executor)
    assert views.still(POINTS, COLOURS, longest=0.05, eye=(0, 0, 0)) is None
    assert "OpenGL is missing" in capsys.readouterr().err


def test_the_page_names_and_folds_the_scene(monkeypatch):
    shown = []
    monkeypatch.setattr("IPython.display.display", shown.append)
    views.show_scene("ball_scene", title='A "ball"')
    assert shown[0].data.startswith('<details class="scene" data-scene="ball_scene">')
    assert "A &quot;ball&quot;</summary>" in shown[0].data
