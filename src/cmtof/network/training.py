"""Training in stages, from dead leaves to rooms, and fine-tuning (Sec. 8.1, 6.4).

Everything random is decided by the seed and by the step, never by how a run came there: one that
was killed and resumed ends with the same weights.
"""

import ctypes
import logging
import sys
import time
import warnings
from collections.abc import Sequence
from contextlib import suppress
from copy import deepcopy
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from lightning import Callback, LightningModule, Trainer
from lightning.fabric.utilities.exceptions import MisconfigurationException
from numpy.typing import NDArray
from scipy.stats import ttest_1samp
from torch import Tensor, nn
from torch.utils.data import DataLoader

from cmtof import __version__
from cmtof.correlation import wrap_length
from cmtof.files import written_whole
from cmtof.measurement import Measurement
from cmtof.network.data import Batch, Block, Pack, Sample, Steps, batch_of, measure, open_rooms
from cmtof.network.losses import IGNORED, regression_loss, unwrapping_loss
from cmtof.network.models import MODELS, Network, build_network, wraps_of
from cmtof.network.recipe import Config, Rooms
from cmtof.network.weights import (
    Card,
    Rates,
    Trained,
    halved,
    load_weights,
    network_inputs,
    save_weights,
    weights_path,
)

LAST = "last.ckpt"
"""File of a run with all that it needs to go on."""

# --- one step ------------------------------------------------------------------------------------


def loss_of(name: str, network: Network, sample: Sample) -> Tensor:
    """Loss of a model (Eq. 7, or that of a regression)."""
    model, found = MODELS[name], network(sample.inputs)
    if network.target == "depth":
        scale = {"classes": network.classes, "smoothness": model.smoothness}
        return regression_loss(found, sample.label, sample.turns, **scale).total
    weight = model.depth_weight
    return unwrapping_loss(
        found, sample.label, sample.phase, sample.turns, depth_weight=weight
    ).total


class Unwrapping(LightningModule):
    """Network, loss and schedule of one configuration, and the average of its weights."""

    def __init__(self, config: Config, init: Path | None = None) -> None:
        super().__init__()
        self.config = config
        torch.manual_seed(config.seed)
        self.network = build_network(config.model, config.protocol)
        if init is not None:
            self.network.load_state_dict(load_weights(init).network.state_dict())
        for layer in self.network.modules():
            if isinstance(layer, nn.BatchNorm2d):
                layer.momentum = 0.03
        self.average = deepcopy(self.network).requires_grad_(False)
        self.curve: list[dict[str, float]] = []
        self.seconds = 0.0

    def measured(self, batch: Batch) -> Sample:
        """Inputs and labels of a batch."""
        features = MODELS[self.config.model].features
        sample = measure(batch, inputs=features, protocol=self.config.protocol)
        return sample._replace(inputs=sample.inputs.contiguous(memory_format=torch.channels_last))

    def on_fit_start(self) -> None:
        self.network.to(memory_format=torch.channels_last)  # pyright: ignore

    def training_step(self, batch: Batch, index: int) -> Tensor:
        stage, share = self.config.stage_at(self.global_step)
        for layer in self.network.modules():
            if isinstance(layer, nn.BatchNorm2d):
                layer.train(share < stage.freeze)
        loss = loss_of(self.config.model, self.network, self.measured(batch))
        self.log("loss", loss, prog_bar=True)
        return loss

    def on_train_batch_end(self, *_: Any) -> None:
        keep = min(self.config.average, self.global_step / (self.global_step + 9))
        new = self.network.state_dict()
        for name, old in self.average.state_dict().items():
            old.lerp_(new[name], 1 - keep) if old.is_floating_point() else old.copy_(new[name])

    def configure_optimizers(self) -> Any:
        weights = list(self.network.parameters())
        kernels = {"params": [w for w in weights if w.ndim > 1]}
        others = {"params": [w for w in weights if w.ndim < 2], "weight_decay": 0.0}
        decay = self.config.weight_decay
        optimizer = torch.optim.AdamW(
            [kernels, others], lr=1.0, betas=(0.9, 0.99), weight_decay=decay
        )
        schedule = torch.optim.lr_scheduler.LambdaLR(optimizer, self.config.rate_at)
        return [optimizer], [{"scheduler": schedule, "interval": "step"}]

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        held = {"config": self.config.model_dump_json(), "curve": self.curve}
        checkpoint["cmtof"] = held | {"seconds": self.seconds}

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        held = checkpoint["cmtof"]
        self.curve, self.seconds = held["curve"], held["seconds"]

    def validated(self, pack: Pack) -> dict[str, Any]:
        """Fields of a card: rates of the averaged weights and of trivial answers, and the gain.

        Trivial are the middle class, and the one that is most frequent in these views. The gain's
        interval is Student's, over views: pixels of one view are right or wrong together.
        """
        config, network = self.config, self.average.eval()
        chosen = np.unique(np.linspace(0, len(pack.far) - 1, config.validation_views).round())
        answers, labels = [], []
        for view in chosen.astype(int):
            rng, sigma = np.random.default_rng([7, view]), config.stages[-1].noise[1]
            batch = batch_of([(*pack.staged(view, config.protocol), sigma, rng)])
            sample = self.measured(Batch(*(x.to(self.device) for x in batch)))
            with torch.inference_mode():
                found = network(sample.inputs)
            turns = found[:, 0].floor().clamp(0, network.classes - 1)
            wraps = turns.long() if network.target == "depth" else found.argmax(1)
            scored = sample.label != IGNORED
            if scored.any():
                answers.append(wraps[scored].cpu().numpy())
                labels.append(sample.label[scored].cpu().numpy())
        mode = int(np.bincount(np.concatenate(labels)).argmax())
        deltas = {"ours": [abs(a - true) for a, true in zip(answers, labels, strict=True)]}
        for name, constant in (("middle", network.classes // 2), ("mode", mode)):
            deltas[name] = [abs(constant - true) for true in labels]
        rates = {name: _rates(np.concatenate(delta)) for name, delta in deltas.items()}
        ours = rates.pop("ours")
        best = max(rates, key=lambda name: rates[name].delta_lt_1)
        pairs = zip(deltas["ours"], deltas[best], strict=True)
        test = ttest_1samp([np.mean(a < 1) - np.mean(b < 1) for a, b in pairs], 0.0)
        interval = test.confidence_interval(0.95) if len(labels) > 1 else (-1.0, 1.0)
        gain = (float(np.mean(interval)), float(interval[0]), float(interval[1]))
        return {"views": len(labels), "validation": ours, "trivial": rates, "gain": gain}


def _rates(delta: NDArray[np.integer]) -> Rates:
    """Rates of wrap errors."""
    below = {f"delta_lt_{k}": float((delta < k).mean()) for k in (1, 2, 3)}
    return Rates(**below, delta_ge_10=float((delta >= 10).mean()))


# --- runs ----------------------------------------------------------------------------------------


class Keeper(Callback):
    """Checkpoint, validation and the clock, between two blocks of steps."""

    def __init__(self, folder: Path, pack: Pack, minutes: float | None) -> None:
        self.folder, self.pack, self.minutes = folder, pack, minutes

    def on_train_start(self, trainer: Trainer, pl_module: LightningModule) -> None:
        self.began = self.last = time.monotonic()

    def on_train_epoch_end(self, trainer: Trainer, pl_module: Any) -> None:
        now, done = time.monotonic(), trainer.current_epoch + 1
        pl_module.seconds, self.last = pl_module.seconds + now - self.last, now
        if trainer.is_global_zero and done % pl_module.config.validate_every == 0:
            found = pl_module.validated(self.pack)["validation"].model_dump()
            pl_module.curve.append({"step": trainer.global_step} | found)
        if self.minutes is not None and now - self.began > 60 * self.minutes:
            trainer.should_stop = True
        with written_whole(self.folder / LAST) as part:
            trainer.save_checkpoint(part)


def train(
    config: Config,
    folder: Path,
    *,
    tree: Path | None = None,
    init: Path | None = None,
    resume: bool = False,
    minutes: float | None = None,
    workers: int = 0,
    quiet: bool = False,
    **flags: Any,
) -> Path | None:
    """Train, or go on training, and write the averaged weights with their card.

    Parameters
    ----------
    config, folder
        Of the run: its recipe, and where its checkpoint, at last the weights, are kept.
    tree, init
        Frames in Hypersim's layout (by default rooms are rendered), and weights to begin with.
    resume, minutes
        Go on from the folder's checkpoint; end this leg at the first checkpoint after.
    workers, quiet
        Processes that cut crops; no progress bars.
    **flags
        For Lightning's `Trainer`: accelerator, devices, num_nodes, strategy.

    Returns
    -------
    Path or None
        The weights; None while steps are left.

    Raises
    ------
    ValueError
        If the folder holds a run that is not to be resumed, or one of another configuration.
    """
    if tree is not None and not tree.is_dir():
        raise FileNotFoundError(
            f"Expected a folder of frames in Hypersim's layout, got {tree}. Check the path."
        )
    folder.mkdir(parents=True, exist_ok=True)
    last = _checkpoint(folder, config, resume)
    _keep_freed_memory()
    logging.getLogger("lightning.pytorch").setLevel(logging.ERROR)
    warnings.filterwarnings("ignore", module="lightning.*")
    rooms = config.rooms or Rooms()
    name = f"rooms_{rooms.seed}_{rooms.scenes}x{rooms.views}_{rooms.height}x{rooms.width}"
    pack, held_out = open_rooms(config, tree or folder.parent / name)
    module = Unwrapping(config, init)
    try:
        trainer = Trainer(
            max_epochs=-(-config.steps // config.save_every),
            precision=config.precision,  # type: ignore[arg-type]
            gradient_clip_val=2.0,
            callbacks=[Keeper(folder, held_out, minutes)],
            logger=False,
            use_distributed_sampler=False,
            sync_batchnorm=torch.cuda.is_available() and flags.get("accelerator") != "cpu",
            enable_checkpointing=False,
            enable_progress_bar=not quiet,
            enable_model_summary=False,
            **flags,
        )
    except (MisconfigurationException, TypeError) as error:
        raise ValueError(
            f"Expected accelerator, devices and strategy that this machine has, got «{error}». "
            "Choose others."
        ) from error
    steps = Steps(config, pack, trainer.global_rank, trainer.world_size)
    loader = DataLoader(steps, None, sampler=Block(config), num_workers=workers)
    trainer.fit(module, loader, ckpt_path=last, weights_only=True)
    if trainer.global_step < config.steps:
        return None
    path = weights_path(config.model, config.protocol, folder)
    if trainer.is_global_zero:
        half = {
            name: weight.float() for name, weight in halved(module.average.state_dict()).items()
        }
        module.average.load_state_dict(half)  # validated as they are stored
        save_weights(path, module.average, _card(module, held_out))
    return path


def _card(module: Unwrapping, pack: Pack) -> Card:
    """Card of a finished training."""
    config, (first, classes) = module.config, wraps_of(module.config.protocol)
    on = f"; {config.rooms.scenes}x{config.rooms.views} views of rooms" if config.rooms else ""
    gpu = torch.cuda.is_available()
    return Card(
        model=config.model,
        protocol=config.protocol,  # type: ignore[arg-type]
        classes=classes,
        first_wrap=first,
        parameters=sum(weight.numel() for weight in module.average.parameters()),
        configuration=config.model_dump(mode="json"),
        data=f"dead leaves{on}",
        crops=sum(stage.steps * stage.batch for stage in config.stages),
        steps=config.steps,
        minutes=round(module.seconds / 60, 1),
        hardware=torch.cuda.get_device_name() if gpu else f"CPU, {torch.get_num_threads()} threads",
        versions={"cmtof": __version__, "torch": torch.__version__.partition("+")[0]},
        curve=module.curve,
        **module.validated(pack),
    )


def _checkpoint(folder: Path, config: Config, resume: bool) -> Path | None:
    """Checkpoint to go on from, of the same configuration."""
    last = folder / LAST
    if not last.is_file():
        return None
    if not resume:
        raise ValueError(
            f"Expected a new folder, got a run in {folder}. Pass --resume, or choose another."
        )
    held = torch.load(last, map_location="cpu", weights_only=True)["cmtof"]["config"]
    if held != config.model_dump_json():
        raise ValueError(
            f"Expected the configuration that {last} was made with, got another. Choose another "
            "folder."
        )
    return last


def _keep_freed_memory() -> None:
    """Ask glibc to keep what is freed: fetching pages again costs a third of a step on a CPU."""
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):
            library = ctypes.CDLL("libc.so.6")
            library.mallopt(-4, 0)  # M_MMAP_MAX
            library.mallopt(-1, 2**31 - 1)  # M_TRIM_THRESHOLD


# --- fine-tuning ---------------------------------------------------------------------------------


class Labelled(NamedTuple):
    """A measurement and the wraps that are known of it."""

    measurement: Measurement
    wraps: NDArray[np.integer]
    """Wrap count of the lowest frequency (H, W)."""
    mask: NDArray[np.bool_]
    """Pixels (H, W) whose wrap is known."""
    depth: NDArray[np.floating]
    """Best range (H, W), m; finite where the mask is True."""


class FineTuned(NamedTuple):
    """A copy of a network that went on learning, and the loss before each step."""

    trained: Trained
    losses: list[float]


def fine_tune(
    trained: Trained,
    examples: Sequence[Labelled],
    *,
    steps: int = 20,
    learning_rate: float = 1e-4,
    crop: int = 128,
    batch: int = 2,
    seed: int = 0,
) -> FineTuned:
    """Continue the training of a network on labelled measurements of an instrument (Sec. 6.4).

    Running means of the norms stay as they are: a few scans are too few to estimate them. Crops
    are drawn until a twentieth of each is labelled, ten times at most; ``trained`` is left as it
    is.

    Raises
    ------
    ValueError
        If there is no example, shapes disagree, or no label lies among the network's classes.
    """
    if not examples or min(steps, crop, batch) < 1 or not learning_rate > 0:
        raise ValueError(
            f"Expected examples, steps, crop, batch and learning rate above 0, got "
            f"{len(examples)}, {steps}, {crop}, {batch}, {learning_rate}. Correct them."
        )
    prepared = [_prepared(one, trained) for one in examples]
    known = sum(int((sample.label != IGNORED).sum()) for sample in prepared)
    if not known:
        first = trained.card.first_wrap
        raise ValueError(
            f"Expected labels among the wraps {first} to {first + trained.card.classes - 1}, got "
            f"none in {len(prepared)} measurements. Choose other weights, or label more."
        )
    network = deepcopy(trained.network).train()
    for layer in network.modules():
        if isinstance(layer, nn.BatchNorm2d):
            layer.eval()
    rng, losses = np.random.default_rng(seed), []
    optimizer = torch.optim.Adam(network.parameters(), learning_rate)
    for _ in range(steps):
        chosen = [prepared[k] for k in rng.integers(len(prepared), size=batch)]
        drawn = [_cropped(sample, rng, crop) for sample in chosen]
        loss = torch.stack([loss_of(trained.card.model, network, one) for one in drawn]).mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(float(loss.detach()))
    note = {"steps": steps, "learning_rate": learning_rate, "labelled_pixels": known, "seed": seed}
    card = trained.card.model_copy(update={"fine_tuned": note})
    return FineTuned(Trained(network.eval(), card), losses)


def _prepared(example: Labelled, trained: Trained) -> Sample:
    """Inputs and labels (1, ...) of one example; unknown pixels are `IGNORED`."""
    measurement, wraps, mask, depth = example
    shapes = [np.shape(image) for image in (wraps, mask, depth)]
    if shapes != [measurement.shape] * 3:
        raise ValueError(
            f"Expected wraps, mask and depth of the measurement's shape {measurement.shape}, got "
            f"{shapes}. Take them from one scan."
        )
    inputs, phase = network_inputs(measurement, trained.model)
    label = np.asarray(wraps, np.int64) - trained.card.first_wrap
    turns = np.asarray(depth, float) / wrap_length(measurement.frequencies[0])
    known = np.asarray(mask, bool) & np.isfinite(turns) & measurement.mask
    known &= (label >= 0) & (label < trained.card.classes)
    turns = np.where(known, turns - trained.card.first_wrap, 0.0)
    images = (inputs, np.where(known, label, IGNORED), phase, turns)
    return Sample(*(torch.from_numpy(np.ascontiguousarray(image)[None]) for image in images))


def _cropped(sample: Sample, rng: np.random.Generator, crop: int) -> Sample:
    """A square crop, drawn until it holds labels."""
    height, width = sample.label.shape[-2:]
    for _ in range(10):
        y, x = (int(rng.integers(max(size - crop, 0) + 1)) for size in (height, width))
        piece = Sample(*(image[..., y : y + crop, x : x + crop] for image in sample))
        if (piece.label != IGNORED).float().mean() >= 0.05:
            break
    return piece
