"""Beside the steps: how long a run took, and what is kept of it."""

import time
from pathlib import Path
from typing import Any

from lightning import Callback, LightningModule, Trainer
from safetensors.torch import save_file

from cmtof.files import written_whole
from cmtof.network.module import Unwrapping

LAST, BEST = "last.ckpt", "best.safetensors"
"""Files of a run: all that it needs to go on, and the weights after its best validation."""


class Clock(Callback):
    """Time that a run took, over all of its legs, and the share that steps waited for data.

    Ends a leg after some minutes, at the end of an epoch, where its checkpoint stands.
    """

    def __init__(self, minutes: float | None = None) -> None:
        self.minutes, self.seconds, self.waited = minutes, 0.0, 0.0

    def on_train_start(self, trainer: Trainer, pl_module: LightningModule) -> None:
        self._began = self._ended = time.perf_counter()
        self._before = self.seconds

    def on_train_batch_start(self, *_: Any, **__: Any) -> None:
        self.waited += time.perf_counter() - self._ended

    def on_train_batch_end(self, *_: Any, **__: Any) -> None:
        self._tick()

    def on_validation_end(self, trainer: Trainer, pl_module: LightningModule) -> None:
        if trainer.state.fn == "fit":  # a resumed run that was over is validated alone
            self._tick()

    def on_train_epoch_end(self, trainer: Trainer, pl_module: LightningModule) -> None:
        self._tick()
        if self.minutes is not None and self._ended - self._began > 60 * self.minutes:
            trainer.should_stop = True

    def _tick(self) -> None:
        self._ended = time.perf_counter()
        self.seconds = self._before + self._ended - self._began

    def state_dict(self) -> dict[str, float]:
        return {"seconds": self.seconds, "waited": self.waited}

    def load_state_dict(self, state_dict: dict[str, float]) -> None:
        self.seconds, self.waited = state_dict["seconds"], state_dict["waited"]


class Keeper(Callback):
    """Checkpoint after every epoch, the weights after the best validation; each whole or not there.

    Lightning's own checkpoints remember where they lay; these may be carried to another machine.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def on_validation_end(self, trainer: Trainer, pl_module: LightningModule) -> None:
        assert isinstance(pl_module, Unwrapping)
        rates = [found["delta_lt_1"] for found in pl_module.curve]
        fitting = trainer.state.fn == "fit"
        if fitting and trainer.is_global_zero and rates and rates[-1] == max(rates):
            with written_whole(self.folder / BEST) as part:
                save_file(pl_module.network.state_dict(), part)

    def on_train_epoch_end(self, trainer: Trainer, pl_module: LightningModule) -> None:
        with written_whole(self.folder / LAST) as part:
            trainer.save_checkpoint(part, weights_only=False)
