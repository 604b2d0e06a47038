"""Several processes train as one: their gradients are averaged."""

import os
import subprocess
import sys

import torch
from pytest import mark

from cmtof.network.data import Steps, open_rooms
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
train(read_config("recipe.yml"), Path("both"), quiet=True, **flags)
"""


def test_gradients_of_two_processes_are_those_of_two_halves_in_one(tmp_path):
    path = tmp_path / "recipe.yml"
    path.write_text(RECIPE)
    (tmp_path / "run.py").write_text(SCRIPT)
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    subprocess.run(
        [sys.executable, "run.py"], cwd=tmp_path, env=environment, check=True
    )
    config = read_config(path)
    module = Unwrapping(config, open_rooms(config, None, tmp_path), tmp_path)
    for rank in range(2):  # norms see one half at a time, as in a process
        sample = module.measured(Steps(config, None, rank, 2)[0])
        (loss_of(module.network, sample) / 2).backward()
    found = torch.load(tmp_path / "gradients.pt")
    for name, weight in module.network.named_parameters():
        torch.testing.assert_close(found[name], weight.grad, rtol=1e-4, atol=1e-6)
