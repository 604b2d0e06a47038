"""`cmtof train` as its users meet it."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

TINY = """
rooms: {seed: 1, scenes: 10, views: 2, height: 32, width: 32}
model: fast-scnn-light
epochs: 2
crops: 4
batch: 2
crop: 32
"""


@pytest.fixture
def config(tmp_path: Path) -> Path:
    path = tmp_path / "tiny.yml"
    path.write_text(TINY)
    return path


def write_tree(root: Path) -> Path:
    """Scenes of the tests of the network, which lie in another folder."""
    sys.path.insert(0, str(Path(__file__).parent / "network"))
    try:
        from tiny_rooms import write_rooms  # pyright: ignore[reportMissingImports]
    finally:
        sys.path.pop(0)
    return write_rooms(root, (32, 32))


def test_help_names_what_there_is(run):
    code, text, _ = run("train", "--help")
    assert code == 0
    assert "paper, gpu, common, cpu or smoke" in text and "--resume" in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("big",), "a configuration out of common, cpu"),
        (("smoke", "--model", "v-net"), "a model out of fast-scnn"),
        (("smoke", "--protocol", "half"), "protocol 'released' or 'full', got 'half'"),
    ],
)
def test_bad_input_is_one_line(run, tmp_path, monkeypatch, arguments, message: str):
    monkeypatch.chdir(tmp_path)
    code, _, err = run("train", *arguments)
    assert code == 1
    assert err.startswith("cmtof: Expected ") and err.count("\n") == 1
    assert message in err
    assert not list(tmp_path.iterdir())


def test_a_wrong_name_in_a_file_is_one_line(run, config):
    config.write_text(TINY + "crosp: 3\n")
    code, _, err = run("train", config, "-o", config.parent / "run")
    assert code == 1 and err.count("\n") == 1
    assert "got crosp. Correct the name" in err


def test_a_run_that_is_there_is_one_line(run, config, tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "last.ckpt").write_bytes(b"")
    code, _, err = run("train", config, "-o", folder, "--data", tmp_path)
    assert code == 1 and err.count("\n") == 1
    assert "Pass --resume" in err


def test_a_wrong_command_line_ends_with_2(run):
    assert run("train")[0] == 2
    assert run("train", "smoke", "--seed", "-1")[0] == 2


def test_methods_tell_whose_weights_are_there(run):
    listed = {entry["name"]: entry for entry in json.loads(run("methods", "--json")[1])}
    learned = {name for name, entry in listed.items() if entry["kind"] == "learned"}
    assert {"fast-scnn", "fast-scnn-ce", "fast-scnn-fourier", "fast-scnn-phase"} <= learned
    for name, entry in listed.items():
        if name in learned:
            assert set(entry["weights"]) <= {"released", "full"}
        else:
            assert entry["weights"] is None


@pytest.mark.slow
def test_two_processes_train_together(config, tmp_path):
    """As on two GPUs: Lightning starts the second, and the gradients are averaged."""
    tree = write_tree(tmp_path / "rooms")
    command = [
        sys.executable, "-m", "cmtof.cli", "train", config, "-o", tmp_path / "run",
        "--data", tree, "--accelerator", "cpu", "--devices", 2, "--strategy", "ddp", "--quiet",
    ]  # fmt: skip
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, env=environment
    )
    assert done.returncode == 0, done.stderr
    path = tmp_path / "run" / "fast-scnn-light.released.safetensors"
    assert path.is_file()
    assert done.stdout.count(str(path)) >= 1
    card = json.loads(path.with_suffix(".json").read_text())
    assert card["hardware"].startswith("2 x CPU")
    assert card["steps"] == 4  # two a batch, one for each process
    assert [point["epoch"] for point in card["validation"]] == [1, 2]
