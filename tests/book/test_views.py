"""Interactive scenes: one whole, small file each, drawn, and on the notebook's page."""

import re

import numpy as np
import pytest

from cmtof.book import views
from cmtof.book.provenance import OUTPUT_VARIABLE
from cmtof.pointcloud import points_from_depth

LOADED = re.compile(r"""(?:src|href)\s*=\s*["']?(?:https?:)?//""", re.IGNORECASE)
# scripts of the viewer name addresses in their comments; these would fetch something
FETCHES = re.compile(r"""(?:fetch|import|setAttribute\("href",)\s*\(?[`"'](?:https?:)?//""")
CAMERA = (100.0, 100.0, 40.0, 30.0)


def ball() -> np.ndarray:
    """Ranges (60, 80), m, of a ball before a wall."""
    y, x = (np.mgrid[:60, :80] + 0.5 - np.array([30, 40])[:, None, None]) / 100
    inside = np.maximum(0.2**2 - x**2 - y**2, 0)
    return np.where(inside > 0, 1.0 - np.sqrt(inside), 1.2)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """Folder with a saved scene, and its still."""
    folder = tmp_path_factory.mktemp("results") / "31"
    depth = ball()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(OUTPUT_VARIABLE, str(folder))
        still = views.save_scene(
            "ball_scene",
            points_from_depth(depth, CAMERA),
            (1.2 - depth[..., None]) * [2.5, 2.0, 1.0],
            title="A ball & a wall",
            longest=0.05,
            eye=(-0.3, -0.3, 0.0),
        )
    return folder, still


def test_one_file_that_loads_nothing(scene):
    folder, _ = scene
    assert [file.name for file in folder.iterdir()] == ["ball_scene.html"]
    text = (folder / "ball_scene.html").read_text(encoding="utf-8")
    assert len(text.encode()) < 3_000_000
    assert not LOADED.search(text) and not FETCHES.search(text)
    assert "favicon" not in text
    assert "<title>A ball &amp; a wall</title>" in text


def test_the_still_shows_the_surface(scene):
    _, still = scene
    if still is None:
        pytest.skip("no OpenGL here (Debian: apt-get install libegl1 libgl1)")
    assert still.shape[2] == 3 and still.min() >= 0 and still.max() <= 1
    drawn = (still < 0.97).any(axis=-1)
    assert drawn.mean() > 0.3
    assert np.ptp(still[drawn], axis=0).min() > 0.2  # shaded, not one colour


def test_without_opengl_only_the_still_is_missing(scene, monkeypatch, tmp_path, capsys):
    folder, _ = scene
    held = (folder / "ball_scene.html").read_text(encoding="utf-8")

    def crashed(*surface, page, **options):
        page.write_text(held, encoding="utf-8")

    monkeypatch.setattr(views, "still", crashed)
    monkeypatch.setenv(OUTPUT_VARIABLE, str(tmp_path))
    surface = points_from_depth(ball(), CAMERA)
    more = {"title": "A ball", "longest": 0.05, "eye": (0, 0, 0)}
    assert views.save_scene("ball_scene", surface, surface, **more) is None
    assert (tmp_path / "ball_scene.html").is_file()
    assert "OpenGL is missing" in capsys.readouterr().err


def test_the_page_names_and_folds_the_scene(monkeypatch):
    shown = []
    monkeypatch.setattr("IPython.display.display", shown.append)
    views.show_scene("ball_scene", title='A "ball"')
    block = shown[0].data
    assert block.startswith("<details")
    assert 'title="A &quot;ball&quot;, interactive"' in block and 'loading="lazy"' in block
    assert block.count("../_static/scenes/ball_scene.html") == 2
