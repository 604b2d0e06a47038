"""The tool that scores options on validation views, and on nothing else."""

import pytest

import tune
from cmtof.conditions import Conditions
from cmtof.evaluation import Evaluation
from cmtof.scenes.hypersim import Hypersim


def test_every_combination_is_tried_in_order():
    found = tune.read_grid(["window=21,41", "step=0.5,1e-3", "kind=box"])
    assert found == [{"window": w, "step": s, "kind": "box"} for w in (21, 41) for s in (0.5, 1e-3)]
    assert tune.read_grid([]) == [{}]


@pytest.mark.parametrize("word", ["window", "window=", "=3", "a b=3"])
def test_a_word_that_is_no_option_is_refused(word):
    with pytest.raises(ValueError, match="Expected OPTION=V1,V2, got"):
        tune.read_grid([word])


def test_views_are_validation_views_spread_evenly(tiny_tree):
    parts = Hypersim(tiny_tree).split()
    assert tune.validation_views(tiny_tree, 99) == parts["val"]
    (one,) = tune.validation_views(tiny_tree, 1)
    assert one in parts["val"] and one not in parts["test"] and one not in parts["train"]


def test_a_tree_without_validation_rooms_is_refused(tmp_path):
    from tiny_rooms import write_rooms

    lonely = write_rooms(tmp_path / "rooms", scenes=1)
    with pytest.raises(ValueError, match=r"Expected validation rooms in .*, got none"):
        tune.validation_views(lonely, 3)


def test_scores_are_those_of_evaluate(tiny_tree, capsys):
    words = ["beat", "window=5,21", "--data", str(tiny_tree), "--views", "2", "--seed", "7"]
    assert tune.main(words) == 0
    head, *rows = capsys.readouterr().out.splitlines()
    assert head.startswith("2 views, released: delta_lt_1")
    frames = [view.frame() for view in Hypersim(tiny_tree).split()["val"]]
    for window, row in zip((5, 21), rows, strict=True):
        options = {"beat": {"window": window}}
        contest = Evaluation(["beat"], seed=7, options=options)
        scores = contest.add_all(frames).report()["methods"]["beat"]
        said = row.split()
        assert said[0] == f"window={window}"
        assert [float(x) for x in said[1:6]] == pytest.approx(
            [100 * scores[name] for name in tune.RATES], abs=0.051
        )
    assert Conditions().seed != 1  # tests have another noise than tuning has


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["beat", "window=4"], "Expected an odd window"),
        (["beat", "width=4"], "options that method beat knows, got width"),
        (["nothing"], "Expected a method out of"),
    ],
)
def test_what_cannot_be_scored_is_said_in_a_line(tiny_tree, capsys, words, complaint):
    assert tune.main([*words, "--data", str(tiny_tree), "--views", "1"]) == 1
    said = capsys.readouterr().err
    assert complaint in said and len(said.splitlines()) == 1
