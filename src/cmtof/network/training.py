"""A run of training: started, resumed, and ended with weights and their card (Sec. 8.1)."""

import ctypes
import logging
import sys
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any

import torch
from lightning import Trainer
from lightning.fabric.utilities.exceptions import MisconfigurationException
from lightning.pytorch.loggers import CSVLogger
from safetensors.torch import load_file

from cmtof import __version__
from cmtof.network.callbacks import BEST, LAST, Clock, Keeper
from cmtof.network.configuration import Config
from cmtof.network.data import Data
from cmtof.network.module import Unwrapping
from cmtof.network.weights import halved, save_weights, weights_path


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
        The weights; None while epochs are left.

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
    trainer = _trainer(
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
    if trainer.current_epoch < config.epochs:
        return None
    # validated as they are shipped, to show what half precision costs
    module.network.load_state_dict(halved(load_file(folder / BEST)))
    trainer.validate(module, data, verbose=False)
    path = weights_path(config.model, config.protocol, folder)
    if trainer.is_global_zero:
        save_weights(path, module.network, _card(module, clock, data))
    return path


def _trainer(**options: Any) -> Trainer:
    """Lightning's, whose complaints of a machine that lacks what is asked for are bad input."""
    try:
        return Trainer(**options)
    except (MisconfigurationException, TypeError) as error:
        raise ValueError(
            f"Expected accelerator, devices and strategy that this machine has, got «{error}». "
            "Choose others."
        ) from error


def _card(module: Unwrapping, clock: Clock, data: Data) -> dict[str, Any]:
    """Where weights come from; the last validation is that of the halved weights."""
    config, rates = module.config, module.curve.pop()
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
        "validation_in_half_precision": {k: rates[k] for k in rates if k.startswith("delta")},
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


def _keep_freed_memory() -> None:
    """Ask glibc to keep what is freed: fetching pages anew costs a third of a step on a CPU."""
    if sys.platform != "linux":
        return
    with suppress(OSError, AttributeError):
        library = ctypes.CDLL("libc.so.6")
        library.mallopt(-4, 0)  # M_MMAP_MAX
        library.mallopt(-1, 2**31 - 1)  # M_TRIM_THRESHOLD
