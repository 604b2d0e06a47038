"""Methods side by side: what a scene counts, and that a figure holds it."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest

import cmtof
from cmtof.comparison import Scene, comparison_figure
from cmtof.conditions import Conditions, Measured
from cmtof.metrics import score, scored_pixels


@pytest.fixture(scope="module")
def scene(tilted_wall):
    taken = Measured(Conditions(seed=3), tilted_wall)
    answers = {m: cmtof.unwrap(taken.by(m), method=m) for m in ("beat", "oracle-depth", "middle")}
    return Scene(tilted_wall, taken.usual, answers)


def test_what_is_right_is_what_evaluate_counts(scene):
    for label, answer in scene.answers.items():
        expected = score(scored_pixels(answer, scene.measurement))["delta_lt_1"]
        assert scene.right(label) == pytest.approx(expected)
    # some phases carry their pixel across a boundary, all of them to the next wrap
    assert np.nanmax(scene.error("oracle-depth")) <= 1


def test_pixels_out_of_range_are_blank(scene, tilted_wall):
    mask = np.zeros(tilted_wall.depth.shape, bool)
    mask[3, 4] = True
    measurement = cmtof.Measurement(scene.measurement.dataset.assign(mask=(("y", "x"), mask)))
    one = scene._replace(measurement=measurement)
    for image in (one.true_count, one.found_count("beat"), one.error("beat")):
        assert np.isfinite(image).sum() == 1


def test_the_figure_has_two_rows_a_scene_and_a_column_a_method(scene):
    other = scene._replace(frame=replace(scene.frame, name="another"))
    figure = comparison_figure([scene, other], {"beat": "averages", "middle": "nothing"})
    titles = [ax.get_title() for ax in figure.axes if ax.get_title()]
    assert titles.count("averages") == titles.count("nothing") == 2
    assert f"{100 * scene.right('beat'):.0f} % right" in titles
    assert {"wall", "another"} <= set(titles)
    plt.close(figure)


def test_no_scene_no_figure():
    with pytest.raises(ValueError, match="Expected at least one scene and method, got 0 and 0"):
        comparison_figure([], {})
