"""`cmtof train` as its users meet it."""

import json
import os
import subprocess
import sys

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


@pytest.mark.slow
def test_two_processes_train_together(recipe, tmp_path):
    """As on two GPUs: Lightning starts the second, and the gradients are averaged."""
    command = [sys.executable, "-m", "cmtof.cli", "train", recipe, "-o", tmp_path / "run"]
    command += ["--accelerator", "cpu", "--devices", 2, "--strategy", "ddp", "--quiet"]
    done = subprocess.run(
        [str(part) for part in command],
        capture_output=True,
        text=True,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
    )
    assert done.returncode == 0, done.stderr
    (card,) = (tmp_path / "run").glob("fast-scnn-light.released.json")
    assert json.loads(card.read_text())["model"] == "fast-scnn-light"
