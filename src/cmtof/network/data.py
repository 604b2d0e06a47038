"""Training data: dead leaves and crops of rooms, measured on the fly (Sec. 5.3).

Crop k of step s is decided by (seed, s, k) alone: a run that was killed, or that is shared among
processes, sees the crops it would have seen.
"""

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numba
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.utils.data import Dataset, Sampler

from cmtof.constants import FREQUENCIES, GAIN, INTEGRATION_TIME, SPEED_OF_LIGHT
from cmtof.correlation import TAU, wrap_length
from cmtof.files import written_whole
from cmtof.measurement import unambiguous_range
from cmtof.network.features import features
from cmtof.network.losses import IGNORED
from cmtof.network.models import wraps_of
from cmtof.network.recipe import Config
from cmtof.simulation import RELEASED_FAR_DEPTH

if TYPE_CHECKING:
    from cmtof.scenes.frame import Source

WRAP = float(wrap_length(FREQUENCIES[0]))
"""Depth of a wrap of the lower frequency, m."""

REPEATED = unambiguous_range(FREQUENCIES) / WRAP
"""Wraps of the lower frequency after which the beat repeats: 357.5."""

Crop = tuple[NDArray[np.floating], NDArray[np.floating]]
"""Depth, m (NaN where unknown), and linear intensity, 0 to 1."""


class Batch(NamedTuple):
    """Crops of frames, and their noise."""

    depth: Tensor
    """(B, H, W), m; NaN where unknown."""
    intensity: Tensor
    """(B, H, W), 0 to 1."""
    sigma: Tensor
    """Gaussian noise of a correlation image (B,), counts."""
    noise: Tensor
    """Standard normal numbers (B, 4, 2, H, W)."""


class Sample(NamedTuple):
    """Inputs of a network and its answers."""

    inputs: Tensor
    """(B, C, H, W)"""
    label: Tensor
    """Class of the true wrap (B, H, W), `IGNORED` where masked."""
    phase: Tensor
    """Measured wrapped phase of the lower frequency (B, H, W), rad."""
    turns: Tensor
    """True depth (B, H, W), wraps of the lower frequency above the first class."""


def phasors(batch: Batch) -> tuple[Tensor, Tensor, Tensor]:
    r"""Decoded measurements, and correlations that decode to them (Eq. 8 and 9).

    At four quadratures decoding leaves a phasor with equal, independent noise of variance
    :math:`(GTI/2 + \sigma^2)/2` along and across it: two normal numbers a pixel stand for four
    photon counts. The images' mean and their alternating part have half that variance.

    Returns
    -------
    phase, amplitude : Tensor, shape (B, 2, H, W)
        rad in [0, 2 pi), and counts.
    correlation : Tensor, shape (B, 2, 4, H, W)
        Counts, at 0, 1/2, 1 and 3/2 pi.
    """
    known = torch.isfinite(batch.depth)
    signal = GAIN * INTEGRATION_TIME * torch.where(known, batch.intensity, 0.0)[:, None]
    tones = torch.tensor(FREQUENCIES, dtype=torch.float64, device=signal.device)
    # turns are reduced in double precision: 700 wraps in float32 would lose a milliradian
    turns = torch.where(known, batch.depth, 0.0).double()[:, None]
    turns = turns * (2 * tones / SPEED_OF_LIGHT).view(-1, 1, 1)
    angle = (TAU * (turns - turns.floor())).float()
    spread = torch.sqrt(signal / 4 + batch.sigma.view(-1, 1, 1, 1) ** 2 / 2)
    x = signal / torch.pi * torch.cos(angle) + spread * batch.noise[:, 0]
    y = signal / torch.pi * torch.sin(angle) + spread * batch.noise[:, 1]
    mean = signal / 2 + spread * batch.noise[:, 2] / 2**0.5
    alternating = spread * batch.noise[:, 3] / 2**0.5
    even, odd = mean + alternating, mean - alternating
    correlation = torch.stack([even + x, odd - y, even - x, odd + y], 2)
    return torch.remainder(torch.atan2(y, x), TAU), torch.hypot(x, y), correlation


def measure(batch: Batch, *, inputs: str, protocol: str) -> Sample:
    """Inputs of a network, out of `FEATURE_SETS`, and the wraps it is asked for.

    Masked are pixels outside the protocol's wraps and those whose beat repeats a nearer one's.
    """
    first, classes = wraps_of(protocol)
    phase, amplitude, correlation = phasors(batch)
    turns = batch.depth / WRAP - first
    scored = (turns >= 0) & (turns < min(classes, REPEATED - first))  # false for NaN
    label = torch.where(scored, torch.nan_to_num(turns, nan=-1.0).floor().long(), IGNORED)
    return Sample(features(phase, amplitude, inputs, correlation), label, phase[:, 0], turns)


# --- dead leaves ---------------------------------------------------------------------------------


def leaves(rng: np.random.Generator, side: int, protocol: str = "released") -> Crop:
    """Overlapping slanted plates at random depths: the training data of the first stage.

    Depth, brightness and texture are independent, so that nothing but the phases leads to a wrap.
    Some plates lie nearer than the protocol's range; slopes are those of rooms that the protocol
    has shrunk, in the median 0.02 wraps a pixel (five times that in ``full``).

    Examples
    --------
    >>> depth, intensity = leaves(np.random.default_rng(0), 32)
    >>> depth.shape, bool((intensity <= 1).all())
    ((32, 32), True)
    """
    first, classes = wraps_of(protocol)
    count = int(rng.integers(3, 4 + 11 * side // 96))
    size = side * np.exp(rng.uniform(np.log(0.15), 0, count))
    plate = np.empty((count, 16))
    plate[:, 0:2] = rng.uniform(0, side, (count, 2))  # centre
    turn, way, wave = rng.uniform(0, TAU, (3, count))
    plate[:, 2], plate[:, 3] = np.cos(turn), np.sin(turn)
    plate[:, 4], plate[:, 5] = size, size * rng.uniform(0.2, 1, count)
    plate[0, 4:6] = 4 * side  # background
    plate[:, 6] = rng.integers(0, 2, count)  # box or ellipse
    near = rng.uniform(-min(25, first), 0, count)
    within = rng.uniform(-0.5, classes + 0.5, count)
    plate[:, 7] = first + np.where(rng.uniform(size=count) < 0.85, within, near)
    slope = (0.02 if first else 0.1) * np.exp(rng.normal(0, 1, count))
    plate[:, 8], plate[:, 9] = slope * np.cos(way), slope * np.sin(way)
    plate[:, 10] = rng.normal(0, 2, count) * (rng.uniform(size=count) < 0.3) / size**2  # bend
    plate[:, 11] = 0.35 * np.exp(rng.normal(0, 1.1, count))  # brightness
    plate[:, 12] = rng.uniform(0, 0.8, count) * (rng.uniform(size=count) < 0.6)  # contrast
    pitch = np.exp(rng.uniform(np.log(4), np.log(60), count))
    plate[:, 13], plate[:, 14] = TAU * np.cos(wave) / pitch, TAU * np.sin(wave) / pitch
    plate[:, 15] = rng.integers(0, 3, count)  # stripes, checks, gradient
    turns, light = _painted(plate, side)
    grain = 0.15 * rng.standard_normal((side, side)) * (rng.uniform() < 0.5)
    return np.where(turns > 1, turns * WRAP, np.nan), np.minimum(light * np.exp(grain), 1)


@numba.njit(cache=True)
def _painted(plates, side):  # pragma: no cover
    """Turns and brightness of plates, the last one in front."""
    turns, light = np.zeros((side, side)), np.zeros((side, side))
    for p in plates:
        reach = int(1.5 * max(p[4], p[5])) + 1
        for y in range(max(0, int(p[1]) - reach), min(side, int(p[1]) + reach)):
            for x in range(max(0, int(p[0]) - reach), min(side, int(p[0]) + reach)):
                dx, dy = x - p[0], y - p[1]
                u, v = (dx * p[2] + dy * p[3]) / p[4], (dy * p[2] - dx * p[3]) / p[5]
                if (max(abs(u), abs(v)) if p[6] == 0 else u * u + v * v) > 1:
                    continue
                turns[y, x] = p[7] + dx * p[8] + dy * p[9] + p[10] * (dx * dx + dy * dy)
                wave = np.sin(x * p[13] + y * p[14])
                if p[15] == 1:
                    wave = np.sign(wave) * np.sign(np.sin(y * p[13] - x * p[14]))
                elif p[15] == 2:
                    wave = min(max(u, -1.0), 1.0)
                light[y, x] = p[11] * (1 + p[12] * wave)
    return turns, light


# --- rooms ---------------------------------------------------------------------------------------


class Pack(NamedTuple):
    """Frames of one partition, opened for reading by crops."""

    depth: NDArray[np.floating]
    """Range (V, H, W), m; NaN where unknown."""
    intensity: NDArray[np.floating]
    """(V, H, W), 0 to 1."""
    far: NDArray[np.floating]
    """99.9th percentile of each frame's depth (V,), m: protocol ``released`` shrinks by it."""

    def staged(self, view: int, protocol: str, window: Any = ...) -> Crop:
        """Depth as the protocol stages it, and intensity, of a window of one frame."""
        scale = 1.0
        if protocol == "released":
            scale = float(np.clip(RELEASED_FAR_DEPTH / self.far[view], 0.01, 1.0))
        depth, light = self.depth[view][window], self.intensity[view][window]
        return depth.astype(float) * scale, light.astype(float)


def pack_views(views: Iterable["Source"], folder: Path) -> Pack:
    """Pack views into one array each of depth and intensity, or open what was packed before.

    A Hypersim tree is one compressed file an image; unpacking it for each crop would cost more
    than a step of training.
    """
    views, listing = list(views), folder / "views.json"
    names = [view.name for view in views]
    paths = [folder / f"{kind}.npy" for kind in Pack._fields]
    if not views:
        raise ValueError(
            f"Expected views for {folder.name}, got none. Render 10 scenes or more: of ten, one "
            "validates and one tests."
        )
    if not listing.is_file() or json.loads(listing.read_text(encoding="utf-8")) != names:
        folder.mkdir(parents=True, exist_ok=True)
        shape, far = (len(views), *views[0].load().depth.shape), []
        kinds = (np.float32, np.float16)
        arrays = [
            np.lib.format.open_memmap(path, "w+", kind, shape)
            for path, kind in zip(paths, kinds, strict=False)
        ]
        for k, frame in enumerate(view.load() for view in views):
            if frame.depth.shape != shape[1:]:
                raise ValueError(
                    f"Expected frames of {shape[1:]}, got {frame.depth.shape} in {frame.name}. "
                    "Train on one size."
                )
            arrays[0][k], arrays[1][k] = frame.depth, np.clip(frame.intensity, 0, 1)
            far.append(np.nanpercentile(frame.depth, 99.9))
        np.save(paths[2], far)
        with written_whole(listing) as part:
            part.write_text(json.dumps(names) + "\n", encoding="utf-8")
    return Pack(*(np.load(path, mmap_mode="r") for path in paths))


def open_rooms(config: Config, tree: Path) -> tuple[Pack | None, Pack]:
    """Frames to train and to validate on, rendered if they are not there, packed.

    Without rooms none, and leaves of a seed of their own.
    """
    if config.rooms is None:
        rngs = (np.random.default_rng([99, k]) for k in range(config.validation_views))
        crops = [leaves(rng, config.stages[-1].crop, config.protocol) for rng in rngs]
        depth, light = (np.stack(images) for images in zip(*crops, strict=True))
        return None, Pack(depth, light, np.full(len(crops), RELEASED_FAR_DEPTH))
    from cmtof.scenes.hypersim import Hypersim
    from cmtof.scenes.rooms.rendering import SETTINGS, Settings, render_rooms

    if not tree.is_dir() or (tree / SETTINGS).is_file():
        render_rooms(tree, Settings(**config.rooms.model_dump()))
    scenes, packed = Hypersim(tree), tree.with_name(f"{tree.name}.packed")
    train, val = (scenes.sources(scenes.split()[part]) for part in ("train", "val"))
    return pack_views(train, packed / "train"), pack_views(val, packed / "val")


def room_crop(rng: np.random.Generator, pack: Pack, side: int, protocol: str) -> Crop:
    """Random crop of a random view, turned, mirrored, and in two of three cases moved in depth.

    The move puts a random pixel into a random class: rooms alone give one or two wraps a crop. Of
    four draws the one with most pixels in range is taken.
    """
    first, classes = wraps_of(protocol)
    views, height, width = pack.depth.shape
    share, depth, light = -1.0, np.empty(0), np.empty(0)
    for _ in range(4):
        view, y, x = (int(rng.integers(n)) for n in (views, height - side + 1, width - side + 1))
        found, shade = pack.staged(view, protocol, (slice(y, y + side), slice(x, x + side)))
        known = found[np.isfinite(found)]
        if known.size and rng.uniform() < 2 / 3:
            found += (first + rng.uniform(0, classes)) * WRAP - rng.choice(known)
            found[found < WRAP] = np.nan
        scored = float(np.mean((found >= first * WRAP) & (found < (first + classes) * WRAP)))
        if scored > share:
            share, depth, light = scored, found, shade
        if share > 0.3:
            break
    turn, mirror = int(rng.integers(4)), 1 - 2 * int(rng.integers(2))
    depth, light = (np.rot90(image, turn)[:, ::mirror] for image in (depth, light))
    return depth, np.clip(light * np.exp(rng.uniform(-0.4, 0.4)), 0, 1)


class Steps(Dataset[Batch]):
    """Batches by the number of their step, through all stages of a configuration.

    ``pack`` holds the views to train on; ``rank`` is the number of this process out of ``world``.
    """

    def __init__(self, config: Config, pack: Pack | None, rank: int = 0, world: int = 1) -> None:
        self.config, self.pack, self.rank, self.world = config, pack, rank, world

    def __len__(self) -> int:
        return self.config.steps

    def __getitem__(self, step: int) -> Batch:
        stage, share = self.config.stage_at(step)
        low, high = stage.noise
        sigma, crops = low * (high / low) ** min(share / stage.ramp, 1), []
        for k in range(self.rank, stage.batch, self.world):
            rng = np.random.default_rng([self.config.seed, step, k])
            if self.pack is not None and rng.uniform() < stage.rooms:
                crop = room_crop(rng, self.pack, stage.crop, self.config.protocol)
            else:
                crop = leaves(rng, stage.crop, self.config.protocol)
            crops.append((*crop, sigma * float(np.exp(rng.uniform(-0.2, 0.1))), rng))
        return batch_of(crops)


class Block(Sampler[int]):
    """Numbers of an epoch's steps: an epoch is what lies between two checkpoints."""

    def __init__(self, config: Config) -> None:
        self.config, self.epoch = config, 0

    def set_epoch(self, epoch: int) -> None:
        """Lightning sets the epoch, also after a resumption."""
        self.epoch = epoch

    def __iter__(self) -> Iterator[int]:
        start = self.epoch * self.config.save_every
        yield from range(start, min(start + self.config.save_every, self.config.steps))

    def __len__(self) -> int:
        return len(list(iter(self)))


def batch_of(crops: list[tuple]) -> Batch:
    """Batch of crops (depth, intensity, sigma, generator of their noise)."""
    depth, light, sigma, rngs = zip(*crops, strict=True)
    shape = (4, 2, *depth[0].shape)
    noise = np.stack([rng.standard_normal(shape, dtype=np.float32) for rng in rngs])
    images = (np.stack(depth), np.stack(light).astype(np.float32), np.float32(sigma), noise)
    return Batch(*(torch.from_numpy(image) for image in images))
