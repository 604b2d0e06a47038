"""Training of a network (Sec. 8.1): a Lightning module, and the run around it.

Whatever is random hangs on the seed and on where the run is, never on how it came there: a run that
was killed and resumed ends with the weights of one that was not.
"""

import ctypes
import logging
import sys
import time
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import torch
from lightning import Callback, LightningModule, Trainer
from lightning.pytorch.loggers import CSVLogger
from safetensors.torch import load_file, save_file
from torch import Tensor

from cmtof import __version__
from cmtof.files import written_whole
from cmtof.network.building import build_network
from cmtof.network.configuration import MODELS, Config, wraps_of
from cmtof.network.data import Data
from cmtof.network.losses import IGNORED, Loss, unwrapping_loss
from cmtof.network.measuring import Batch, Sample, measure
from cmtof.network.weights import save_weights, weights_path

LAST, BEST = "last.ckpt", "best.safetensors"
"""Files of a run: all that it needs to go on, and the weights after its best validation."""

LIMITS = (1, 2, 3, 10)
"""Wrap errors that validation counts, as in Tables 1 to 3."""


class Unwrapping(LightningModule):
    """Network, loss and schedule of one configuration.

    Attributes
    ----------
    curve : list of dict
        What each validation found, with the epoch, the step and the training loss since the last.
    """

    def __init__(self, config: Config) -> None:
        super().__init__()
        self.config, self.model = config, MODELS[config.model]
        self.first, self.classes = wraps_of(config.protocol)
        torch.manual_seed(config.seed)
        self.network = build_network(config.model, self.classes)
        self.curve: list[dict[str, float]] = []
        self._losses: list[Tensor] = []
        self._rates: list[Tensor] = []

    def on_fit_start(self) -> None:
        if self.device.type == "cuda":  # what its half-precision convolutions compute in
            self.network.to(memory_format=torch.channels_last)  # pyright: ignore[reportCallIssue]

    def forward(self, inputs: Tensor) -> Tensor:
        return self.network(inputs)

    def training_step(self, batch: Batch, index: int) -> Tensor:
        seed = _seed(self.config.seed, self.global_step, self.global_rank)
        torch.manual_seed(seed)  # dropout
        generator = torch.Generator(self.device).manual_seed(seed)
        shape = (2, *batch.depth.shape[:1], 2, *batch.depth.shape[1:])
        noise = torch.randn(shape, generator=generator, device=self.device)
        loss = self._loss(self._measured(batch, noise))[0]
        self._losses.append(loss.total.detach())
        self.log("loss", loss.total, prog_bar=True)
        self.log("cross_entropy", loss.cross_entropy)
        self.log("depth", loss.depth)
        return loss.total

    def validation_step(self, batch: tuple[Batch, Tensor], index: int) -> None:
        frames, noise = batch
        sample = self._measured(frames, noise.movedim(1, 0))
        loss, weights = self._loss(sample)
        valid = sample.label != IGNORED
        delta = (weights.argmax(1) - sample.label)[valid].abs()
        below = [(delta < limit).sum() for limit in LIMITS]
        self._rates.append(torch.stack([loss.total * valid.sum(), *below, valid.sum()]))

    def on_validation_epoch_end(self) -> None:
        total = torch.stack(self._rates).double().sum(0) if self._rates else torch.zeros(6).double()
        total = self.trainer.strategy.reduce(total.to(self.device).float(), reduce_op="sum")
        self._rates.clear()
        loss, *below, count = (float(x) for x in total)
        found = {f"delta_lt_{k}": b / max(count, 1) for k, b in zip(LIMITS, below, strict=True)}
        found["validation_loss"] = loss / max(count, 1)
        self.log_dict(found, prog_bar=False, rank_zero_only=False, sync_dist=False)
        self.log("δ<1", found["delta_lt_1"], prog_bar=True, logger=False)
        if self.trainer.sanity_checking:
            return
        trained = torch.stack(self._losses).mean() if self._losses else torch.tensor(float("nan"))
        self._losses.clear()
        where = {"epoch": self.current_epoch + 1, "step": self.global_step}
        self.curve.append(where | {"loss": float(trained)} | found)

    def configure_optimizers(self) -> Any:
        c = self.config
        optimizer = torch.optim.Adam(
            self.network.parameters(), c.learning_rate, weight_decay=c.weight_decay
        )
        schedule = torch.optim.lr_scheduler.OneCycleLR(
            optimizer,
            c.learning_rate,
            total_steps=int(self.trainer.estimated_stepping_batches),
            pct_start=c.warm_up,
            anneal_strategy="linear",
        )
        return {
            "optimizer": optimizer,
            "lr_scheduler": {"scheduler": schedule, "interval": "step"},
        }

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        checkpoint["curve"] = self.curve
        checkpoint["config"] = self.config.as_dict()

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        self.curve = checkpoint["curve"]

    def _measured(self, batch: Batch, noise: Tensor) -> Sample:
        return measure(
            batch, noise, inputs=self.model.features, first=self.first, classes=self.classes
        )

    def _loss(self, sample: Sample) -> tuple[Loss, Tensor]:
        weights = self.network(sample.inputs)
        loss = unwrapping_loss(
            weights,
            sample.label,
            sample.phase,
            sample.turns,
            depth_weight=self.model.depth_weight,
            hardness=self.config.hardness,
        )
        return loss, weights


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
        if not trainer.sanity_checking:
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
        if trainer.is_global_zero and rates and rates[-1] == max(rates):
            with written_whole(self.folder / BEST) as part:
                save_file(pl_module.network.state_dict(), part)

    def on_train_epoch_end(self, trainer: Trainer, pl_module: LightningModule) -> None:
        with written_whole(self.folder / LAST) as part:
            trainer.save_checkpoint(part, weights_only=False)


def train(
    config: Config,
    folder: Path,
    *,
    tree: Path,
    resume: bool = False,
    minutes: float | None = None,
    workers: int = 0,
    quiet: bool = False,
    **flags: Any,
) -> Path | None:
    """Train, or go on training, and write the best weights with their card.

    Parameters
    ----------
    config : Config
    folder : Path
        Of the run: checkpoint, logs, at last the weights.
    tree : Path
        Frames in Hypersim's layout; a set of rooms is rendered where it is missing.
    resume : bool
        Go on from the folder's checkpoint.
    minutes : float, optional
        End this leg after the epoch in which they are over.
    workers : int
        Processes that cut crops.
    quiet : bool
        No progress bars.
    **flags
        For Lightning's `Trainer`: accelerator, devices, num_nodes, strategy.

    Returns
    -------
    Path or None
        The weights; None while epochs are left, and in all processes but the first.

    Raises
    ------
    ValueError
        If the folder holds a run that is not to be resumed, or one of another configuration.
    """
    folder.mkdir(parents=True, exist_ok=True)
    last = _resumed(folder, config, resume)
    _keep_freed_memory()
    # its greetings and hints; warnings of other kinds still come through
    logging.getLogger("lightning.pytorch").setLevel(logging.WARNING)
    warnings.filterwarnings("ignore", message=".*isinstance.treespec, LeafSpec.* is deprecated")
    module, clock = Unwrapping(config), Clock(minutes)
    trainer = Trainer(
        max_epochs=config.epochs,
        precision=config.precision,  # type: ignore[arg-type]
        check_val_every_n_epoch=config.validate_every,
        callbacks=[clock, Keeper(folder)],
        logger=CSVLogger(folder, name="", version=f"leg_{len(list(folder.glob('leg_*')))}"),
        use_distributed_sampler=False,
        num_sanity_val_steps=0,
        log_every_n_steps=min(10, config.steps // config.epochs),
        enable_checkpointing=False,
        enable_progress_bar=not quiet,
        enable_model_summary=False,
        benchmark=True,
        **flags,
    )
    data = Data(tree, config, workers=workers, quiet=quiet)
    trainer.fit(module, data, ckpt_path=last, weights_only=True)
    if trainer.current_epoch < config.epochs or not trainer.is_global_zero:
        return None
    module.network.load_state_dict(load_file(folder / BEST))
    path = weights_path(config.model, config.protocol, folder)
    save_weights(path, module.network, _card(module, clock, data))
    return path


def _card(module: Unwrapping, clock: Clock, data: Data) -> dict[str, Any]:
    """Where weights come from."""
    config = module.config
    best = max(module.curve, key=lambda found: found["delta_lt_1"])
    return {
        "model": config.model,
        "protocol": config.protocol,
        "classes": module.classes,
        "first_wrap": module.first,
        "parameters": sum(weight.numel() for weight in module.network.parameters()),
        "command": f"cmtof train {config.name} --model {config.model} "
        f"--protocol {config.protocol} -o runs/{config.name}-{config.model}-{config.protocol}",
        "configuration": config.as_dict(),
        "training_frames": len(data.train),
        "validation_frames": len(data.validate),
        "steps": module.global_step,
        "best_step": best["step"],
        "minutes": round(clock.seconds / 60, 1),
        "share_waiting_for_data": round(clock.waited / max(clock.seconds, 1e-9), 4),
        "hardware": _hardware(module.trainer),
        "versions": {"cmtof": __version__, "torch": torch.__version__.partition("+")[0]},
        "validation": module.curve,
    }


def _hardware(trainer: Trainer) -> str:
    if torch.cuda.is_available() and trainer.strategy.root_device.type == "cuda":
        name = torch.cuda.get_device_name()
    else:
        name = f"CPU, {torch.get_num_threads()} threads"
    return f"{trainer.world_size} x {name}"


def _resumed(folder: Path, config: Config, resume: bool) -> Path | None:
    """Checkpoint to go on from, made sure to be of the same configuration."""
    last = folder / LAST
    if not last.is_file():
        return None
    if not resume:
        raise ValueError(
            f"Expected a new folder, got a run in {folder}. Pass --resume, or choose another."
        )
    held = torch.load(last, map_location="cpu", weights_only=True)["config"]
    changed = [key for key, value in config.as_dict().items() if held.get(key) != value]
    if changed:
        raise ValueError(
            f"Expected the configuration that {last} was made with, got another "
            f"{', '.join(changed)}. Choose another folder."
        )
    return last


def _seed(*numbers: int) -> int:
    """One seed out of several numbers."""
    return int(np.random.SeedSequence(numbers).generate_state(1, np.uint64)[0] >> np.uint64(1))


def _keep_freed_memory() -> None:
    """Ask glibc to keep what is freed: fetching pages anew costs a third of a step on a CPU."""
    if sys.platform != "linux":
        return
    with suppress(OSError, AttributeError):
        library = ctypes.CDLL("libc.so.6")
        library.mallopt(-4, 0)  # M_MMAP_MAX
        library.mallopt(-1, 2**31 - 1)  # M_TRIM_THRESHOLD
