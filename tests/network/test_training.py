"""Training: a falling loss, the same end however it was interrupted, and a card that tells it all.

The killed run and the one on two processes are other processes, as they are for a user.
"""

import csv
import hashlib
import json
import signal
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path

import pytest
import torch
import yaml
from safetensors.torch import load_file

from cmtof.network.building import build_network
from cmtof.network.configuration import Config
from cmtof.network.training import train
from cmtof.network.weights import load_weights

CPU = {"quiet": True, "accelerator": "cpu", "devices": 1}

pytestmark = pytest.mark.filterwarnings(
    # Lightning of the loaders, which read little and from memory
    "ignore:The '.*_dataloader' does not have many workers",
    "ignore:.*isinstance.treespec, LeafSpec.* is deprecated",
)


@pytest.fixture(scope="module")
def whole(tiny: Config, tiny_tree: Path, tmp_path_factory) -> Path:
    """Weights of a run that nothing interrupted."""
    path = train(tiny, tmp_path_factory.mktemp("whole"), tree=tiny_tree, **CPU)
    assert path is not None
    return path


def card(path: Path) -> dict:
    return json.loads(path.with_suffix(".json").read_text())


def assert_same_end(path: Path, other: Path) -> None:
    """Equal to the last bit: the shipped weights, the best ones in full, the whole curve."""
    assert path.read_bytes() == other.read_bytes()
    best, same = (load_file(p.parent / "best.safetensors") for p in (path, other))
    assert best.keys() == same.keys()
    assert all(torch.equal(best[key], same[key]) for key in best)
    assert card(path)["validation"] == card(other)["validation"]
    assert card(path)["sha256"] == card(other)["sha256"]


# --- a run -------------------------------------------------------------------------------------


def test_a_run_leaves_weights_card_checkpoint_and_logs(whole: Path):
    assert whole.name == "fast-scnn-light.released.safetensors"
    assert {path.name for path in whole.parent.iterdir()} == {
        whole.name, whole.with_suffix(".json").name, "last.ckpt", "best.safetensors", "leg_0",
    }  # fmt: skip
    with (whole.parent / "leg_0" / "metrics.csv").open() as file:
        rows = list(csv.DictReader(file))
    losses = [float(row["loss"]) for row in rows if row["loss"]]
    assert losses and all(0 < loss < 50 for loss in losses)


def test_the_curve_tells_each_validation(whole: Path):
    curve = card(whole)["validation"]
    assert [point["epoch"] for point in curve] == [1, 2, 3]
    assert [point["step"] for point in curve] == [2, 4, 6]
    for point in curve:
        assert 0 < point["loss"] < 50 and 0 < point["validation_loss"] < 50
        rates = [point[f"delta_lt_{k}"] for k in (1, 2, 3, 10)]
        assert rates[0] >= 0 and rates == sorted(rates) and rates[-1] <= 1
    assert curve[0]["loss"] > curve[-1]["loss"]


def test_the_card_says_how_it_was_made(whole: Path, tiny: Config):
    found = card(whole)
    assert found["configuration"] == asdict(tiny)
    assert (found["model"], found["protocol"]) == ("fast-scnn-light", "released")
    assert (found["classes"], found["first_wrap"]) == (21, 36)
    assert (found["training_frames"], found["validation_frames"]) == (16, 2)
    assert found["steps"] == tiny.steps == 6
    best = max(found["validation"], key=lambda point: point["delta_lt_1"])
    assert found["best_step"] == best["step"]
    network = build_network("fast-scnn-light", 21)
    assert found["parameters"] == sum(weight.numel() for weight in network.parameters())
    assert found["hardware"].startswith("1 x CPU, ")
    assert found["command"].startswith("cmtof train tiny --model fast-scnn-light --protocol rel")
    assert found["versions"].keys() == {"cmtof", "torch"}
    assert 0 <= found["share_waiting_for_data"] <= 1 and found["minutes"] >= 0
    assert found["sha256"] == hashlib.sha256(whole.read_bytes()).hexdigest()
    half = found["validation_in_half_precision"]
    assert half["delta_lt_1"] == pytest.approx(best["delta_lt_1"], abs=0.05)


def test_the_weights_are_trained(whole: Path, tiny: Config):
    trained = load_weights(whole)
    torch.manual_seed(tiny.seed)
    fresh = build_network("fast-scnn-light", 21).state_dict()
    moved = [k for k, v in trained.network.state_dict().items() if not torch.equal(v, fresh[k])]
    assert len(moved) == len(fresh)
    assert trained.first == 36


def test_the_same_seed_ends_alike_and_another_does_not(tiny, tiny_tree, tmp_path):
    short = replace(tiny, epochs=1)
    ends = [
        train(replace(short, seed=seed), tmp_path / f"{number}", tree=tiny_tree, **CPU)
        for number, seed in enumerate((0, 0, 1))
    ]
    first, again, other = (path for path in ends if path is not None)
    assert_same_end(first, again)
    assert first.read_bytes() != other.read_bytes()


def test_a_loss_falls(tiny, tiny_tree, tmp_path):
    """On little noise, within a few steps."""
    easy = replace(tiny, epochs=4, crops=8, noise=100.0)
    path = train(easy, tmp_path, tree=tiny_tree, **CPU)
    assert path is not None
    losses = [point["loss"] for point in card(path)["validation"]]
    assert losses[-1] < losses[0] - 0.1


# --- interrupted -------------------------------------------------------------------------------


def test_legs_end_as_one_run_does(tiny, tiny_tree, tmp_path):
    """Between two validations: the loss since the last one is carried over."""
    config = replace(tiny, validate_every=3)
    legs = tmp_path / "legs"
    for leg in range(2):
        ended = train(config, legs, tree=tiny_tree, minutes=0.0, resume=leg > 0, **CPU)
        assert ended is None
        assert not list(legs.glob("fast-scnn*"))
    path = train(config, legs, tree=tiny_tree, resume=True, **CPU)
    straight = train(config, tmp_path / "straight", tree=tiny_tree, **CPU)
    assert path is not None and straight is not None
    assert_same_end(straight, path)
    assert sorted(p.name for p in legs.glob("leg_*")) == ["leg_0", "leg_1", "leg_2"]


KILLED = """
import os, signal, sys
from pathlib import Path
from cmtof.network.configuration import read_config
from cmtof.network.module import Unwrapping
from cmtof.network.training import train
step = Unwrapping.training_step

def deadly(self, batch, index):
    if self.global_step == 3:  # the second of the second epoch
        os.kill(os.getpid(), signal.SIGKILL)
    return step(self, batch, index)

Unwrapping.training_step = deadly
train(read_config(sys.argv[1]), Path(sys.argv[2]), tree=Path(sys.argv[3]), quiet=True,
      accelerator="cpu", devices=1)
"""


@pytest.fixture
def tiny_file(tiny: Config, tmp_path: Path) -> Path:
    path = tmp_path / "tiny.yml"
    path.write_text(yaml.safe_dump(tiny.as_dict()))
    return path


@pytest.mark.slow
def test_a_killed_run_goes_on_to_the_same_end(whole, tiny, tiny_tree, tiny_file, tmp_path):
    folder = tmp_path / "killed"
    arguments = [str(one) for one in (tiny_file, folder, tiny_tree)]
    killed = subprocess.run([sys.executable, "-c", KILLED, *arguments], capture_output=True)
    assert killed.returncode == -signal.SIGKILL, killed.stderr.decode()
    assert (folder / "last.ckpt").is_file()
    assert not list(folder.glob("fast-scnn*"))
    path = train(tiny, folder, tree=tiny_tree, resume=True, **CPU)
    assert path is not None
    assert_same_end(whole, path)


def test_parts_of_a_checkpoint_are_no_checkpoint(tiny, tiny_tree, tmp_path):
    """Killed while it wrote its first one, a run starts anew."""
    (tmp_path / ".last.part-1.ckpt").write_bytes(b"half")
    config = replace(tiny, epochs=1, crops=2)
    assert train(config, tmp_path, tree=tiny_tree, resume=True, **CPU) is not None


def test_a_finished_run_may_be_resumed_and_stays(whole, tiny, tiny_tree, tmp_path):
    folder = tmp_path / "copy"
    folder.mkdir()
    for name in ("last.ckpt", "best.safetensors"):
        (folder / name).write_bytes((whole.parent / name).read_bytes())
    path = train(tiny, folder, tree=tiny_tree, resume=True, **CPU)
    assert path is not None
    assert path.read_bytes() == whole.read_bytes()
    assert card(path)["validation"] == card(whole)["validation"]


def test_a_run_is_not_written_over(whole, tiny, tiny_tree):
    before = whole.read_bytes()
    with pytest.raises(ValueError, match=r"a new folder, got a run in .*Pass --resume, or choose"):
        train(tiny, whole.parent, tree=tiny_tree, **CPU)
    assert whole.read_bytes() == before


def test_another_configuration_does_not_go_on(whole, tiny, tiny_tree):
    other = replace(tiny, seed=5, learning_rate=1e-3)
    with pytest.raises(ValueError, match=r"got another learning_rate, seed\. Choose another"):
        train(other, whole.parent, tree=tiny_tree, resume=True, **CPU)


# --- otherwise ---------------------------------------------------------------------------------


def test_mixed_precision_trains(tiny, tiny_tree, tmp_path):
    config = replace(tiny, epochs=1, precision="bf16-mixed")
    path = train(config, tmp_path, tree=tiny_tree, **CPU)
    assert path is not None
    trained = load_weights(path)
    assert all(torch.isfinite(weight).all() for weight in trained.network.parameters())
    assert all(0 < point["loss"] < 50 for point in trained.card["validation"])


def test_the_full_protocol_tells_358_wraps_apart(tiny, tiny_tree, tmp_path):
    config = replace(tiny, epochs=1, protocol="full")
    path = train(config, tmp_path, tree=tiny_tree, **CPU)
    assert path is not None and path.name == "fast-scnn-light.full.safetensors"
    trained = load_weights(path)
    assert (trained.card["classes"], trained.first) == (358, 0)
    assert trained.network.classes == 358


@pytest.mark.parametrize("model", ["fast-scnn-ce", "fast-scnn-phase", "fast-scnn-released"])
def test_every_kind_of_model_trains(tiny, tiny_tree, tmp_path, model: str):
    config = replace(tiny, epochs=1, crops=2, model=model)
    path = train(config, tmp_path, tree=tiny_tree, **CPU)
    assert path is not None
    assert load_weights(path).card["model"] == model


@pytest.mark.parametrize(
    ("flags", "got"),
    [({"accelerator": "gpu"}, "gpu"), ({"devices": 0}, "devices"), ({"devices": "x"}, "devices")],
)
def test_machines_that_are_not_there_are_refused(tiny, tiny_tree, tmp_path, flags, got: str):
    if flags == {"accelerator": "gpu"} and torch.cuda.is_available():
        pytest.skip("there is one")
    with pytest.raises(ValueError, match=f"accelerator, devices and strategy .*{got}.*Choose oth"):
        train(tiny, tmp_path, tree=tiny_tree, **(CPU | flags))
