"""Training in stages; resumed after a kill it ends with the same bits (Sec. 8.1)."""

import ctypes
import logging
import platform
import time
import warnings
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from copy import deepcopy
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from lightning import LightningModule, Trainer
from lightning.fabric.utilities.rank_zero import rank_zero_only
from scipy.stats import ttest_1samp
from torch import Tensor, nn
from torch.utils.data import DataLoader

from cmtof import __version__
from cmtof.files import atomic_output, exclusive_lock, reading
from cmtof.network import weights
from cmtof.network.data import (
    Batch,
    Packs,
    Sample,
    batch_at,
    batch_of,
    measure,
    open_rooms,
)
from cmtof.network.features import CLASSES
from cmtof.network.losses import IGNORED, regression_loss, unwrapping_loss
from cmtof.network.models import Network, build_network
from cmtof.network.muon import Muon
from cmtof.network.recipe import Config, Rooms
from cmtof.types import Fields, Numbers, Values


def loss_of(network: Network, sample: Sample) -> Tensor:
    """Loss of a network on a batch (Eq. 7; for a regression the absolute error), a scalar."""
    model = network.model
    found = network(sample.inputs)
    _, label, phase, turns = sample
    if network.target == "wraps":
        return unwrapping_loss(
            found, label, phase, turns, depth_weight=model.depth_weight
        )
    return regression_loss(found, label, turns, network.classes, model.smoothness)


def multiplies_bfloat16() -> bool:
    """Whether the processor has bfloat16 instructions; if not, single precision is faster."""
    return torch.cpu.get_capabilities().get("avx512_bf16", False)


def norms(network: nn.Module) -> list[nn.BatchNorm2d]:
    """Batch norms of a network."""
    return [layer for layer in network.modules() if isinstance(layer, nn.BatchNorm2d)]


def optimizer_of(network: nn.Module, kind: str, rate: float = 1.0) -> Muon:
    """Optimiser "adamw", or "muon" for dense kernels and AdamW for depthwise ones and offsets."""
    groups: list[Any] = [
        {"params": [], "weight_decay": decay} for decay in (1e-3, 1e-3, 0.0)
    ]
    for weight in network.parameters():
        group = 2 if weight.ndim < 2 else int(weight.shape[1] == 1)
        groups[group]["params"].append(weight)
    groups[0]["orthogonal"] = kind == "muon"
    return Muon(groups, lr=rate, betas=(0.9, 0.99))


def average_into(
    average: nn.Module, network: nn.Module, step: int, most: float
) -> None:
    """Move averaged weights towards a network's, in place: a moving average, shorter at first."""
    keep = min(most, step / (step + 9))
    new = network.state_dict()
    for name, old in average.state_dict().items():
        if old.is_floating_point():  # norms count their steps, which nothing reads
            old.lerp_(new[name], 1 - keep)


def keep_pages() -> None:
    """Let glibc keep freed memory: fetching its pages again costs a third of a step."""
    if platform.libc_ver()[0] == "glibc":
        library = ctypes.CDLL("libc.so.6")
        library.mallopt(-4, 0)  # M_MMAP_MAX
        library.mallopt(-1, 2**31 - 1)  # M_TRIM_THRESHOLD


class Unwrapping(LightningModule):
    """Network, loss and schedule of a configuration, and the average of its weights.

    An epoch lies between two writings of the checkpoint ``last``, all that a run needs to go on.
    """

    def __init__(
        self, config: Config, packs: Packs, last: Path, init: Path | None = None
    ) -> None:
        super().__init__()
        self.config = config
        self.checkpoint = last
        self.seen, self.held_out = packs
        torch.manual_seed(config.seed)
        self.network = build_network(config.model, config.protocol)
        if config.depth_weight is not None:
            self.network.model = self.network.model._replace(
                depth_weight=config.depth_weight
            )
        if init:
            given = weights.load_weights(init).network.state_dict()
            expected = f"weights of {config.model} for {config.protocol}"
            with reading(expected, init, "Choose others."):
                self.network.load_state_dict(given)
        for layer in norms(self.network):
            layer.momentum = 0.03
        self.average = deepcopy(self.network).requires_grad_(False)
        self.network.to(memory_format=torch.channels_last)  # pyright: ignore
        self.curve: list[Values] = []
        self.began = time.monotonic()
        self.end = np.inf

    def train_dataloader(self) -> DataLoader:
        start = self.current_epoch * self.config.save_every
        block = range(start, min(start + self.config.save_every, self.config.steps))
        make = partial(
            batch_at,
            config=self.config,
            pack=self.seen,
            rank=self.global_rank,
            world=self.trainer.world_size,
        )
        workers = 8 * torch.cuda.is_available()
        return DataLoader(block, None, collate_fn=make, num_workers=workers)  # pyright: ignore[reportArgumentType]

    def sample_from_batch(self, batch: Batch) -> Sample:
        """Network inputs and labels of a batch: its crops, measured by simulation."""
        return measure(
            batch, inputs=self.average.model.features, protocol=self.config.protocol
        )

    def training_step(self, batch: Batch, index: int) -> Tensor:
        stage, share = self.config.stage_at(self.global_step)
        for layer in norms(self.network):
            layer.train(share < stage.freeze)
        # what is dropped out follows from the step, also in a resumed run
        torch.manual_seed(self.config.seed + self.global_step)
        loss = loss_of(self.network, self.sample_from_batch(batch))
        self.log("loss", loss, prog_bar=True)
        return loss

    def on_train_batch_end(self, *_: Any) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        average_into(self.average, self.network, self.global_step, self.config.average)

    def on_train_epoch_end(self) -> None:
        due = (self.current_epoch + 1) % self.config.validate_every == 0
        if due and self.trainer.is_global_zero:
            found = self.validate_average()["validation"].model_dump()
            self.curve.append({"step": self.global_step} | found)
        self.trainer.should_stop = time.monotonic() > self.end
        # other processes take part, and write nothing
        whole = atomic_output if self.trainer.is_global_zero else nullcontext
        with whole(self.checkpoint) as part:
            self.trainer.save_checkpoint(part)

    def configure_optimizers(self) -> Any:
        optimizer = optimizer_of(self.network, self.config.optimizer)
        schedule = torch.optim.lr_scheduler.LambdaLR(optimizer, self.config.rate_at)
        return [optimizer], [{"scheduler": schedule, "interval": "step"}]

    def on_save_checkpoint(self, checkpoint: Fields) -> None:
        checkpoint["cmtof"] = {
            "config": self.config.model_dump_json(),
            "curve": self.curve,
            "seconds": time.monotonic() - self.began,
        }

    def on_load_checkpoint(self, checkpoint: Fields) -> None:
        self.curve = checkpoint["cmtof"]["curve"]
        self.began -= checkpoint["cmtof"]["seconds"]

    def errors(self) -> Iterator[tuple[Numbers, Numbers]]:
        """Wrap errors (P,) of the averaged weights and true classes (P,) of each held-out view."""
        network = self.average.eval()
        pack = self.held_out
        places = np.linspace(0, len(pack.far) - 1, self.config.validation_views)
        sigma = self.config.stages[-1].noise[1]
        for view in np.unique(places.round()).astype(int):
            crop = pack.staged_window(view, self.config.protocol)
            held = batch_of([(*crop, sigma, np.random.default_rng([7, view]))])
            sample = self.sample_from_batch(
                self.transfer_batch_to_device(held, self.device, 0)
            )
            with torch.inference_mode():
                found = network(sample.inputs)
            turns = found[:, 0].floor().clamp(0, network.classes - 1)
            wraps = turns.long() if network.target == "depth" else found.argmax(1)
            scored = sample.label != IGNORED
            if scored.any():
                label = sample.label[scored].cpu().numpy()
                yield abs(wraps[scored].cpu().numpy() - label), label

    def validate_average(self) -> Fields:
        """Fields of a `Card`: rates of averaged weights and of trivial answers, and the gain."""
        ours, labels = zip(*self.errors(), strict=True)
        mode = int(np.bincount(np.concatenate(labels)).argmax())
        others = {
            "middle": [abs(self.average.classes // 2 - true) for true in labels],
            "mode": [abs(mode - true) for true in labels],
        }
        trivial = {name: _rates(deltas) for name, deltas in others.items()}
        best = max(trivial, key=lambda name: trivial[name].delta_lt_1)
        return {
            "views": len(ours),
            "validation": _rates(ours),
            "trivial": trivial,
            "gain": _gain(ours, others[best]),
        }


def _gain(ours: Sequence[Numbers], others: Sequence[Numbers]) -> tuple[float, ...]:
    """Gain of ``ours`` over ``others`` in the share of right wraps, and its 95 % interval.

    Both are wrap errors by view. The interval is Student's over views, as the pixels of a view are
    right or wrong together.
    """
    gains = [(a < 1).mean() - (b < 1).mean() for a, b in zip(ours, others, strict=True)]
    interval = (-1.0, 1.0)
    if len(gains) > 1:
        interval = ttest_1samp(gains, 0.0).confidence_interval()
    return float(np.mean(interval)), *interval


def _rates(deltas: Sequence[Numbers]) -> weights.Rates:
    """Rates of wrap errors, given by view, over the pixels of all views."""
    delta = np.concatenate(deltas)
    below = {f"delta_lt_{k}": float((delta < k).mean()) for k in (1, 2, 3)}
    return weights.Rates(**below, delta_ge_10=float((delta >= 10).mean()))


def train(
    config: Config,
    folder: Path,
    *,
    find_tree: Callable[[Rooms], Path] | None = None,
    init: Path | None = None,
    resume: bool = False,
    minutes: float | None = None,
    quiet: bool = False,
    **flags: Any,
) -> Path | None:
    """Train, or go on training, and write the averaged weights with their card into a folder.

    ``find_tree`` returns the folder of a configuration's rooms in Hypersim's layout, and may render
    them first; it is called after ``folder`` is made. ``init`` are weights to begin with,
    ``resume`` goes on from the folder's checkpoint, and a call ends at the first checkpoint after
    some ``minutes``; the ``flags`` are Lightning's: accelerator, devices, num_nodes, strategy.
    Returned is the file of weights, or None while steps are left. Raises ValueError if another
    process trains there.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (
        exclusive_lock(folder)
        if getattr(rank_zero_only, "rank", 0) == 0
        else nullcontext()
    ):
        last = folder / "last.ckpt"
        begun = last.is_file()
        if begun:
            _check_checkpoint(last, config, resume)
        keep_pages()
        logging.getLogger("lightning.pytorch").setLevel(logging.ERROR)
        warnings.filterwarnings("ignore", module="lightning.*")
        module = Unwrapping(config, open_rooms(config, find_tree), last, init)
        if minutes is not None:
            module.end = module.began + 60 * minutes
        flags |= {"precision": config.precision, "enable_progress_bar": not quiet}
        trainer = _trainer(config, **flags)
        try:
            trainer.fit(module, ckpt_path=last if begun else None, weights_only=True)
        except SystemExit as stop:
            # Lightning makes an exit of Ctrl-C
            if isinstance(stop.__context__, KeyboardInterrupt):
                raise KeyboardInterrupt from stop
            raise
        if trainer.global_step < config.steps:
            return None
        path = weights.weights_path(config.model, config.protocol, folder)
        if trainer.is_global_zero:
            # validated as they are stored
            module.average.load_state_dict(
                weights.half_precision_weights(module.average)
            )
            weights.save_weights(path, module.average, _card(module))
        return path


def _check_checkpoint(last: Path, config: Config, resume: bool) -> None:
    """Raise a ValueError unless ``resume``, and the checkpoint is whole and of ``config``."""
    if not resume:
        raise ValueError(
            f"Expected a new folder, got a run in {last.parent}. "
            "Pass --resume, or choose another."
        )
    with reading("a whole checkpoint", last):
        if spoilt := zipfile.ZipFile(last).testzip():
            raise ValueError(f"{spoilt} is damaged")
        checkpoint = torch.load(last, map_location="cpu", weights_only=True)["cmtof"]
        stored = checkpoint["config"]
    if stored != config.model_dump_json():
        raise ValueError(
            f"Expected the configuration of {last}, got another. Choose another folder."
        )


def _trainer(config: Config, **flags: Any) -> Trainer:
    """Lightning's trainer; a ValueError if this machine lacks what the flags name."""
    on_gpu = torch.cuda.is_available() and flags.get("accelerator") != "cpu"
    if not on_gpu and not multiplies_bfloat16():
        flags["precision"] = flags["precision"].replace("bf16-mixed", "32-true")
    with reading(
        "accelerator, devices, strategy and precision that this machine has",
        flags,
        "Choose others.",
    ):
        return Trainer(
            max_epochs=-(-config.steps // config.save_every),
            gradient_clip_val=2.0,
            reload_dataloaders_every_n_epochs=1,
            use_distributed_sampler=False,
            sync_batchnorm=on_gpu,
            logger=False,
            enable_checkpointing=False,
            enable_model_summary=False,
            **flags,
        )


def _card(module: Unwrapping) -> weights.Card:
    """Card of the weights of a finished training."""
    config = module.config
    first, classes = CLASSES[config.protocol]
    data = "dead leaves"
    if module.seen:
        data += f"; {len(module.seen.far)} views"
    hardware = f"CPU, {torch.get_num_threads()} threads"
    if torch.cuda.is_available():
        hardware = torch.cuda.get_device_name()
    return weights.Card(
        model=config.model,
        protocol=config.protocol,
        classes=classes,
        first_wrap=first,
        parameters=sum(weight.numel() for weight in module.average.parameters()),
        configuration=config.model_dump(mode="json"),
        data=data,
        crops=sum(stage.steps * stage.batch for stage in config.stages),
        steps=config.steps,
        minutes=round((time.monotonic() - module.began) / 60, 1),
        hardware=hardware,
        versions={"cmtof": __version__, "torch": torch.__version__.partition("+")[0]},
        curve=module.curve,
        **module.validate_average(),
    )
