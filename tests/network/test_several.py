"""Several processes train as one: their gradients are averaged, and a run survives one of them."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import torch
from pytest import fixture, mark

from cmtof.network.data import batch_at, open_rooms
from cmtof.network.recipe import read_config
from cmtof.network.training import Unwrapping, loss_of

pytestmark = mark.slow

RECIPE = """
model: fast-scnn-light
precision: 32-true
rooms: null
save_every: 5
validate_every: 100
validation_views: 2
stages: [{name: leaves, crops: 240, crop: 64, batch: 4, noise: [30, 60], rate: [1.0e-3, 1.0e-4]}]
"""
SCRIPT = """
import sys
from pathlib import Path
import torch
from lightning import Callback
from cmtof.network.recipe import read_config
from cmtof.network.training import train

class Keep(Callback):
    def on_before_optimizer_step(self, trainer, module, optimizer):
        if trainer.is_global_zero and trainer.global_step == 0:
            found = {name: w.grad for name, w in module.network.named_parameters()}
            torch.save(found, "gradients.pt")

flags = {"accelerator": "cpu", "devices": 2, "strategy": "ddp", "callbacks": [Keep()]}
resume = Path(sys.argv[2]).is_dir()
train(read_config(sys.argv[1]), Path(sys.argv[2]), quiet=True, resume=resume, **flags)
"""


@fixture
def start(own_folder):
    """Start a run of two processes in a folder."""
    Path("recipe.yml").write_text(RECIPE)
    Path("run.py").write_text(SCRIPT)

    def starter(folder):
        command = [sys.executable, "run.py", "recipe.yml", folder]
        return subprocess.Popen(command, env=os.environ | {"OMP_NUM_THREADS": "1"})

    return starter


def test_gradients_of_two_processes_are_those_of_two_halves_in_one(start):
    assert start("both").wait(600) == 0
    config = read_config("recipe.yml")
    module = Unwrapping(config, open_rooms(config), Path("last.ckpt"))
    for rank in range(2):  # norms see one half at a time, as in a process
        half = module.sample_from_batch(batch_at(0, config, None, rank, 2))
        (loss_of(module.network, half) / 2).backward()
    found = {name: one.grad for name, one in module.network.named_parameters()}
    torch.testing.assert_close(torch.load("gradients.pt"), found, rtol=1e-4, atol=1e-6)


def test_a_run_goes_on_after_one_of_its_processes_was_killed(start):
    assert start("whole").wait(600) == 0
    run = start("killed")
    while not Path("killed/last.ckpt").is_file():
        assert run.poll() is None
        time.sleep(0.05)
    children = Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text().split()
    os.kill(int(children[0]), signal.SIGKILL)
    assert run.wait(600) != 0
    assert not list(Path("killed").glob("*.safetensors"))
    assert start("killed").wait(600) == 0
    (whole,), (killed,) = (Path(n).glob("*.safetensors") for n in ("whole", "killed"))
    assert whole.read_bytes() == killed.read_bytes()
