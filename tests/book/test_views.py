"""Scenes to turn: a small script of points and colours, a still, and their place on the page."""

import json
from base64 import b64decode

import matplotlib.pyplot as plt
import numpy as np
from numpy.testing import assert_allclose
from pytest import skip

from cmtof.pointcloud import points_from_depth
from cmtof_book import views
from cmtof_book.provenance import OUTPUT_VARIABLE

SIDE = np.linspace(-1, 1, 60)
BOWL = 0.8 + 0.2 * (SIDE**2 + SIDE[:, None] ** 2)  # m
LAYER = views.Layer(
    points_from_depth(BOWL, (100, 100, 30, 30)),
    BOWL,
    "viridis",
    (0.8, 1.2),
    "range (m)",
)
VIEW = {"longest": 0.05, "eye": (-0.3, -0.3, 0.0)}
LAYERS = {"depth": LAYER, "truth": LAYER._replace(points=LAYER.points + 0.1)}


def test_a_script_holds_points_and_colours(tmp_path, monkeypatch):
    monkeypatch.setenv(OUTPUT_VARIABLE, str(tmp_path))
    views.save_scene("ball_scene", LAYERS, **VIEW, step=2)
    call, _, rest = (tmp_path / "ball_scene.js").read_text("utf-8").partition(", ")
    about = json.loads(rest.rstrip(");\n"))
    assert [call, about["longest"], *about["layers"]] == [
        'cmtofScene("ball_scene"',
        0.1,
        *LAYERS,
    ]
    held = about["layers"]["truth"]
    points = np.frombuffer(b64decode(held["points"]), "<f4").reshape(*held["shape"], 3)
    assert_allclose(points, LAYERS["truth"].points[::2, ::2], 1e-6)
    levels = np.frombuffer(b64decode(held["colours"]), np.uint8).reshape(points.shape)
    expected = plt.get_cmap("viridis")((BOWL[::2, ::2] - 0.8) / 0.4)[..., :3]
    assert_allclose(levels, 255 * expected, atol=0.51)
    assert_allclose(LAYERS["truth"].colours()[::2, ::2], expected)
    assert (held["ends"], held["scale"][:7]) == (["0.8", "1.2"], "#440154")


def test_the_still_shows_the_surface():
    still = views.still(LAYER, **VIEW)
    if still is None:
        skip("no OpenGL here (Debian: apt-get install libegl1 libgl1)")
    drawn = (still < 0.97).any(-1)
    assert drawn.mean() > 0.3
    assert np.ptp(still[drawn], 0).min() > 0.2  # shaded, not one colour
