"""Crops to train on: which, where and how is decided by seed, epoch and number alone.

So a run that was killed goes on with the crops that it would have seen, on any number of processes.
"""

from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path

import numpy as np
import torch
from lightning import LightningDataModule
from numpy.typing import NDArray
from torch import Tensor
from torch.utils.data import DataLoader, Dataset, Sampler

from cmtof.console import progress_bar
from cmtof.constants import FREQUENCIES
from cmtof.correlation import wrap_length
from cmtof.network.configuration import MODELS, Config
from cmtof.network.frames import Pack, pack_frames
from cmtof.network.measuring import Batch, normals
from cmtof.scenes.hypersim import is_hypersim
from cmtof.simulation import RELEASED_FAR_DEPTH, RELEASED_WRAPS

LEAST_VALID = 0.2
"""Share of a crop that should lie in the range; of four draws the best is taken."""

TRIES = 4

_TRAIN, _VALIDATE = 0, 1  # streams of random numbers


class Crops(Dataset[Batch]):
    """Random crops of packed frames, staged by the protocol, mirrored and jittered.

    Indexed by ``epoch * crops + number``; an index always gives the same crop.
    """

    def __init__(self, pack: Pack, config: Config) -> None:
        self.pack, self.config = pack, config

    def __getitem__(self, index: int) -> Batch:
        c = self.config
        rng = np.random.default_rng([c.seed, _TRAIN, index])
        depth, intensity = max(
            self._tries(rng), key=lambda crop: min(in_range(crop[0], c.protocol), LEAST_VALID)
        )
        if c.flips and rng.uniform() < 0.5:
            depth, intensity = depth[:, ::-1], intensity[:, ::-1]
        brighter, noisier = 1 + rng.uniform(-1, 1, 2) * (c.brightness_jitter, c.noise_jitter)
        return Batch(
            _tensor(depth),
            _tensor(np.clip(intensity.astype(np.float32) * brighter, 0, 1)),
            torch.tensor(c.noise * np.sqrt(noisier), dtype=torch.float32),
        )

    def _tries(self, rng: np.random.Generator) -> Iterator[tuple[NDArray, NDArray]]:
        for _ in range(TRIES):
            crop = cut(self.pack, int(rng.integers(len(self.pack))), self.config, rng)
            yield crop
            if in_range(crop[0], self.config.protocol) >= LEAST_VALID:
                return


class Views(Dataset[tuple[Batch, Tensor]]):
    """One crop of each frame, at the paper's noise, always the same: to validate on."""

    def __init__(self, pack: Pack, config: Config) -> None:
        count = min(config.validation_views or len(pack), len(pack))
        # spread over the set, so that a few views see many scenes
        self.chosen = np.unique(np.linspace(0, len(pack) - 1, count).round().astype(int))
        self.pack, self.config = pack, config

    def __len__(self) -> int:
        return len(self.chosen)

    def __getitem__(self, index: int) -> tuple[Batch, Tensor]:
        rng = np.random.default_rng([self.config.seed, _VALIDATE, index])
        depth, intensity = cut(self.pack, int(self.chosen[index]), self.config, rng)
        # further numbers come behind: every model sees the same phasors
        count = normals(MODELS[self.config.model].features)
        noise = rng.standard_normal((count, 2, *depth.shape), dtype=np.float32)
        sigma = torch.tensor(self.config.noise, dtype=torch.float32)
        return Batch(_tensor(depth), _tensor(intensity), sigma), torch.from_numpy(noise)


def cut(
    pack: Pack, frame: int, config: Config, rng: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.float16]]:
    """Depth, m, as the protocol stages it, and intensity of a random crop of one frame."""
    height, width = pack.depth.shape[1:]
    y, x = (int(rng.integers(size - config.crop + 1)) for size in (height, width))
    window = (frame, slice(y, y + config.crop), slice(x, x + config.crop))
    scale = 1.0
    if config.protocol == "released":
        scale = float(np.clip(RELEASED_FAR_DEPTH / pack.far[frame], 0.01, 1.0))
    return pack.depth[window] * np.float32(scale), pack.intensity[window]


def in_range(depth: NDArray[np.floating], protocol: str) -> float:
    """Share of pixels that a protocol scores, as far as its near end goes."""
    near = RELEASED_WRAPS[0] * float(wrap_length(FREQUENCIES[0])) if protocol == "released" else 0.0
    return float(np.mean(depth >= near))  # false for NaN


class EpochSampler(Sampler[int]):
    """Numbers of an epoch's crops, every ``world``-th for each process."""

    def __init__(self, count: int, rank: int = 0, world: int = 1) -> None:
        self.count, self.rank, self.world, self.epoch = count, rank, world, 0

    def set_epoch(self, epoch: int) -> None:
        """Lightning tells the epoch, after a resumption too."""
        self.epoch = epoch

    def __len__(self) -> int:
        return self.count // self.world

    def __iter__(self) -> Iterator[int]:
        start = self.epoch * self.count
        yield from range(start + self.rank, start + len(self) * self.world, self.world)


class Data(LightningDataModule):
    """Training and validation frames: rendered if they are not there, packed, cut into crops.

    Parameters
    ----------
    tree : Path
        Hypersim's layout: the data set itself, or a set of rooms, which is rendered or completed.
    config : Config
    workers : int
        Processes that cut crops.
    quiet : bool
        No progress bar.
    """

    def __init__(self, tree: Path, config: Config, *, workers: int = 0, quiet: bool = False):
        super().__init__()
        self.tree, self.config, self.workers, self.quiet = tree, config, workers, quiet
        self.packed = tree.with_name(f"{tree.name}.packed")

    def prepare_data(self) -> None:
        """Render and pack; Lightning asks one process a node for it."""
        from cmtof.scenes.rooms.rendering import SETTINGS, Settings, render_rooms

        if (self.tree / SETTINGS).is_file() or not is_hypersim(self.tree):
            settings = Settings(**asdict(self.config.rooms))
            with progress_bar(self.quiet) as bar:
                task = bar.add_task("rooms", total=settings.scenes)
                render_rooms(self.tree, settings, progress=lambda _: bar.update(task, advance=1))
        with progress_bar(self.quiet) as bar:
            task = bar.add_task("packing", total=None)
            for partition in ("train", "val"):
                self._pack(partition, lambda name: bar.update(task, advance=1, description=name))

    def setup(self, stage: str) -> None:
        """Open what is packed."""
        self.train, self.validate = self._pack("train"), self._pack("val")

    def train_dataloader(self) -> DataLoader[Batch]:
        """Crops of an epoch; the batch is shared out among the processes."""
        rank, world = self._place()
        sampler = EpochSampler(self.config.crops, rank, world)
        size = max(self.config.batch // world, 1)
        return self._loader(Crops(self.train, self.config), size, sampler=sampler)

    def val_dataloader(self) -> DataLoader[tuple[Batch, Tensor]]:
        """The same crops every time; each process takes its share."""
        views, (rank, world) = Views(self.validate, self.config), self._place()
        return self._loader(views, 1, sampler=range(rank, len(views), world))

    def _pack(self, partition: str, progress: Callable[[str], None] = lambda name: None) -> Pack:
        return pack_frames(self.tree, self.packed, partition, progress)

    def _place(self) -> tuple[int, int]:
        """Number of this process, and how many there are."""
        return (self.trainer.global_rank, self.trainer.world_size) if self.trainer else (0, 1)

    def _loader(self, crops: Dataset, size: int, **options) -> DataLoader:
        return DataLoader(
            crops,
            batch_size=size,
            num_workers=self.workers,
            pin_memory=torch.cuda.is_available(),
            persistent_workers=self.workers > 0,
            **options,
        )


def _tensor(array: NDArray) -> Tensor:
    return torch.from_numpy(np.ascontiguousarray(array, np.float32))
