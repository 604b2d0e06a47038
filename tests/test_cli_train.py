"""`cmtof train` as its users meet it."""

import pytest

TINY = """
model: fast-scnn-light
rooms: null
stages: [{name: leaves, crops: 8, crop: 32, batch: 2, noise: [30, 60], rate: [1.0e-3, 1.0e-4]}]
"""


@pytest.fixture
def recipe(tmp_path):
    path = tmp_path / "tiny.yml"
    path.write_text(TINY)
    return path


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("big",), "Expected a configuration out of"),
        (("miniature", "--model", "v-net"), "a model out of fast-scnn"),
        (("miniature", "--protocol", "half"), "'half'"),
        (("tiny.yml", "--data", "none"), "none"),
    ],
)
def test_bad_input_leaves_nothing(fails, recipe, monkeypatch, arguments, message):
    monkeypatch.chdir(recipe.parent)
    assert message in fails("train", *arguments)
    assert [path.name for path in recipe.parent.iterdir()] == ["tiny.yml"]


def test_a_run_that_is_there_is_not_replaced(run, fails, recipe, tmp_path):
    assert run("train", recipe, "-o", tmp_path / "run", "--quiet")[0] == 0
    assert "--resume" in fails("train", recipe, "-o", tmp_path / "run")
    assert run("train")[0] == 2
    assert run("train", recipe, "--seed", "-1")[0] == 2
