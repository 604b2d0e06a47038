"""What a step of training does: measure, unwrap, compare; a Lightning module (Sec. 8.1).

Whatever is random hangs on the seed and on where the run is, never on how it came there: a run that
was killed and resumed ends with the weights of one that was not.
"""

from typing import Any

import numpy as np
import torch
from lightning import LightningModule
from torch import Tensor

from cmtof.network.building import build_network
from cmtof.network.configuration import MODELS, Config, wraps_of
from cmtof.network.losses import IGNORED, Loss, regression_loss, unwrapping_loss
from cmtof.network.measuring import Batch, Sample, measure, normals

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
        # two at a time: further numbers leave the first as they are
        draws = range(normals(self.model.features) // 2)
        noise = torch.cat(
            [torch.randn(shape, generator=generator, device=self.device) for _ in draws]
        )
        loss = self._loss(self._measured(batch, noise))[0]
        self._losses.append(loss.total.detach())
        self.log("loss", loss.total, prog_bar=True)
        self.log("cross_entropy", loss.cross_entropy)
        self.log("depth", loss.depth)
        return loss.total

    def validation_step(self, batch: tuple[Batch, Tensor], index: int) -> None:
        frames, noise = batch
        sample = self._measured(frames, noise.movedim(1, 0))
        loss, found = self._loss(sample)
        valid = sample.label != IGNORED
        delta = (self._wraps(found) - sample.label)[valid].abs()
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
        losses = [loss.to(self.device) for loss in self._losses]  # restored ones are on the CPU
        trained = torch.stack(losses).mean() if losses else torch.tensor(float("nan"))
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
        # those since the last validation, whose mean the next one tells
        checkpoint["losses"] = [float(loss) for loss in self._losses]
        checkpoint["config"] = self.config.as_dict()

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        self.curve = checkpoint["curve"]
        self._losses = [torch.tensor(loss) for loss in checkpoint.get("losses", [])]

    def _measured(self, batch: Batch, noise: Tensor) -> Sample:
        return measure(
            batch, noise, inputs=self.model.features, first=self.first, classes=self.classes
        )

    def _loss(self, sample: Sample) -> tuple[Loss, Tensor]:
        found = self.network(sample.inputs)
        if self.model.target == "depth":
            loss = regression_loss(
                found,
                sample.label,
                sample.turns,
                classes=self.classes,
                smoothness=self.model.smoothness,
            )
            return loss, found
        loss = unwrapping_loss(
            found,
            sample.label,
            sample.phase,
            sample.turns,
            depth_weight=self.model.depth_weight,
            hardness=self.config.hardness,
        )
        return loss, found

    def _wraps(self, found: Tensor) -> Tensor:
        """Class (B, H, W) of what the network says: the likeliest, or where its depth lies."""
        if self.model.target == "depth":
            return found[:, 0].floor().clamp(0, self.classes - 1).long()
        return found.argmax(1)


def _seed(*numbers: int) -> int:
    """One seed out of several numbers."""
    return int(np.random.SeedSequence(numbers).generate_state(1, np.uint64)[0] >> np.uint64(1))
