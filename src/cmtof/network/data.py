"""Training data: dead leaves and crops of rooms, measured on the fly (Sec. 5.3)."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor
from torch.utils.data import Dataset

from cmtof.compiled import njit
from cmtof.constants import FREQUENCIES, GAIN, INTEGRATION_TIME, SPEED_OF_LIGHT
from cmtof.correlation import TAU, wrap_length
from cmtof.frame import Source
from cmtof.hypersim import Hypersim
from cmtof.measurement import unambiguous_range
from cmtof.network.features import CLASSES, features
from cmtof.network.losses import IGNORED
from cmtof.network.recipe import Config
from cmtof.simulation import RELEASED_FAR_DEPTH, released_scale
from cmtof.types import Array, Arrays

# Depth of a wrap of the lower frequency, m.
WRAP = float(wrap_length(FREQUENCIES[0]))

# Depth, m (NaN where unknown), and linear intensity, 0 to 1.
Crop = Arrays


class Batch(NamedTuple):
    """Crops of frames, and what their noise is made of."""

    depth: Tensor  # (B, H, W), m, NaN where unknown
    intensity: Tensor  # (B, H, W), linear, 0 to 1
    sigma: Tensor  # (B,), of a correlation image, counts
    noise: Tensor  # (B, 4, 2, H, W), standard normal


class Sample(NamedTuple):
    """Inputs of a network (B, C, H, W) and its answers (B, H, W)."""

    inputs: Tensor
    label: Tensor  # class of the true wrap, `IGNORED` where masked
    phase: Tensor  # measured, of the lower frequency, rad
    turns: Tensor  # true depth, wraps of the lower frequency above the first class


def phasors(batch: Batch) -> tuple[Tensor, Tensor, Tensor]:
    r"""Decoded measurements, and correlations that decode to them (Eq. 8 and 9).

    Phase, rad, amplitude, counts, (B, 2, H, W), and images at 0, 1/2, 1 and 3/2 pi, counts,
    (B, 2, 4, H, W). At four quadratures a phasor's noise is independent along and across it, of
    variance :math:`(GTI/2 + \sigma^2)/2`; the images' mean and alternating part have half of it.
    """
    known = torch.isfinite(batch.depth)
    signal = GAIN * INTEGRATION_TIME * torch.where(known, batch.intensity, 0.0)[:, None]
    tones = torch.tensor(FREQUENCIES, dtype=torch.float64, device=signal.device)
    # turns are reduced in double precision: 700 wraps in float32 would lose a milliradian
    depth = torch.where(known, batch.depth, 0.0).double()[:, None]
    turns = depth * (2 * tones / SPEED_OF_LIGHT).view(-1, 1, 1)
    angle = (TAU * (turns - turns.floor())).float()
    spread = torch.sqrt(signal / 4 + batch.sigma.view(-1, 1, 1, 1) ** 2 / 2)
    x = signal / torch.pi * torch.cos(angle) + spread * batch.noise[:, 0]
    y = signal / torch.pi * torch.sin(angle) + spread * batch.noise[:, 1]
    mean = signal / 2 + spread * batch.noise[:, 2] / 2**0.5
    alternating = spread * batch.noise[:, 3] / 2**0.5
    even = mean + alternating
    odd = mean - alternating
    correlation = torch.stack([even + x, odd - y, even - x, odd + y], 2)
    return torch.remainder(torch.atan2(y, x), TAU), torch.hypot(x, y), correlation


def measure(batch: Batch, *, inputs: str, protocol: str) -> Sample:
    """Inputs of a network, out of `FEATURE_SETS`, and its target wraps.

    Masked are pixels outside the protocol's wraps and those whose beat repeats a nearer one's.
    """
    first, classes = CLASSES[protocol]
    phase, amplitude, correlation = phasors(batch)
    turns = batch.depth / WRAP - first
    repeated = unambiguous_range(FREQUENCIES) / WRAP - first
    scored = (turns >= 0) & (turns < min(classes, repeated))  # false for NaN
    label = torch.where(
        scored, torch.nan_to_num(turns, nan=-1.0).floor().long(), IGNORED
    )
    return Sample(
        features(phase, amplitude, inputs, correlation), label, phase[:, 0], turns
    )


def leaves(rng: np.random.Generator, side: int, protocol: str = "released") -> Crop:
    """Overlapping slanted plates at random depths: the training data of the first stage.

    Depth, brightness and texture are independent, so that only the phases determine a wrap.
    Some plates lie nearer than the protocol's range; slopes are those of rooms that it has shrunk.
    """
    first, classes = CLASSES[protocol]
    uniform = rng.uniform
    count = int(rng.integers(3, 4 + 11 * side // 96))
    size = side * np.exp(uniform(np.log(0.15), 0, count))
    x, y = uniform(0, side, (count, 2)).T
    turn, way, wave = uniform(0, TAU, (3, count))
    extent = np.array([size, size * uniform(0.2, 1, count)])
    extent[:, 0] = 4 * side  # background
    box = rng.integers(0, 2, count) == 0
    near = uniform(-min(25, first), 0, count)
    within = uniform(-0.5, classes + 0.5, count)
    level = first + np.where(uniform(size=count) < 0.85, within, near)
    slope = (0.02 if first else 0.1) * np.exp(rng.normal(0, 1, count))
    bend = rng.normal(0, 2, count) * (uniform(size=count) < 0.3) / size**2
    bright = 0.35 * np.exp(rng.normal(0, 1.1, count))
    contrast = uniform(0, 0.8, count) * (uniform(size=count) < 0.6)
    pitch = np.exp(uniform(np.log(4), np.log(60), count))
    texture = rng.integers(0, 3, count)  # stripes, checks, gradient
    turns, light = np.zeros((2, side, side))
    place = x, y, np.cos(turn), np.sin(turn), *extent, box
    shape = level, slope * np.cos(way), slope * np.sin(way), bend
    look = (
        bright,
        contrast,
        TAU * np.cos(wave) / pitch,
        TAU * np.sin(wave) / pitch,
        texture,
    )
    for plate in zip(*place, *shape, *look, strict=True):
        _paint(turns, light, *plate)
    grain = 0.15 * rng.standard_normal((side, side)) * (uniform() < 0.5)
    return np.where(turns > 1, turns * WRAP, np.nan), np.minimum(
        light * np.exp(grain), 1
    )


@njit()
def _paint(  # pragma: no cover
    turns, light, x, y, cosine, sine, long, wide, box,
    level, right, down, bend, bright, contrast, wave_x, wave_y, texture,
):  # fmt: skip
    """Put a plate in front of turns and brightness."""
    reach = int(1.5 * max(long, wide)) + 1
    side = len(turns)
    for i in range(max(0, int(y) - reach), min(side, int(y) + reach)):
        for j in range(max(0, int(x) - reach), min(side, int(x) + reach)):
            dx = j - x
            dy = i - y
            u = (dx * cosine + dy * sine) / long
            v = (dy * cosine - dx * sine) / wide
            if (max(abs(u), abs(v)) if box else u * u + v * v) > 1:
                continue
            turns[i, j] = level + dx * right + dy * down + bend * (dx * dx + dy * dy)
            wave = np.sin(j * wave_x + i * wave_y)
            if texture == 1:
                wave = np.sign(wave) * np.sign(np.sin(i * wave_x - j * wave_y))
            elif texture == 2:
                wave = min(max(u, -1.0), 1.0)
            light[i, j] = bright * (1 + contrast * wave)


class Pack(NamedTuple):
    """Frames of one partition in memory: reading a file a crop would cost more than a step."""

    depth: Array  # (V, H, W), m
    intensity: Array
    far: Array  # (V,), m, the 99.9th percentile, by which ``released`` shrinks

    def staged(self, view: int, protocol: str, window: Any = ...) -> Crop:
        """Depth as the protocol stages it, and intensity, of a window of one frame."""
        scale = 1.0
        if protocol == "released":
            scale = released_scale(self.far[view])
        depth = self.depth[view][window]
        light = self.intensity[view][window]
        return depth.astype(float) * scale, light.astype(float)


Packs = tuple[Pack | None, Pack]  # to train and to validate on


def pack_views(views: Sequence[Source]) -> Pack:
    """Views in memory; one that is broken, empty, or of another size is left out with a warning."""
    depths = []
    lights = []
    for view in views:
        try:
            depth = (frame := view.load()).depth
            light = frame.intensity
            shape = depths[0].shape if depths else depth.shape
            if depth.shape != shape or not np.isfinite(depth).any():
                raise ValueError(
                    f"Expected depths of {shape} px, got {depth.shape} or none. Look at it."
                )
        except (OSError, ValueError) as error:
            warnings.warn(f"{view.name} is left out. {error}", stacklevel=2)
            continue
        depths.append(depth.astype(np.float32))
        lights.append(np.clip(light, 0, 1).astype(np.float16))
    if not depths:
        raise ValueError(
            "Expected views to train and to validate on, got none. Render 10 scenes or more."
        )
    far = [np.nanpercentile(depth, 99.9) for depth in depths]
    return Pack(np.stack(depths), np.stack(lights), np.array(far))


def open_rooms(config: Config, tree: Path | None, folder: Path) -> Packs:
    """Frames of a tree to train and to validate on, by default of rooms rendered into a folder.

    Without rooms none to train on, and leaves of a seed of their own.
    """
    if config.rooms is None:
        rngs = (np.random.default_rng([99, k]) for k in range(config.validation_views))
        crops = [leaves(rng, config.stages[-1].crop, config.protocol) for rng in rngs]
        depth, light = (np.stack(images) for images in zip(*crops, strict=True))
        return None, Pack(depth, light, np.full(len(crops), RELEASED_FAR_DEPTH))
    if tree is None:
        from cmtof_rooms.rendering import Settings, render_rooms

        rooms = Settings(**config.rooms.model_dump())
        name = f"rooms_{rooms.seed}_{rooms.scenes}x{rooms.views}_{rooms.height}x{rooms.width}"
        render_rooms(tree := folder / name, rooms)
    scenes = Hypersim(tree)
    train, val = (
        pack_views(scenes.sources(scenes.split()[part])) for part in ("train", "val")
    )
    return train, val


def room_crop(rng: np.random.Generator, pack: Pack, side: int, protocol: str) -> Crop:
    """Random crop, turned, mirrored, and mostly moved in depth: rooms give few wraps a crop.

    Taken is the first of four draws with 30 % of its pixels in range, or the best of them.
    """
    first, classes = CLASSES[protocol]
    views, height, width = pack.depth.shape
    share = -1.0
    best: Sequence[Array] = ()
    for _ in range(4):
        view, y, x = (
            rng.integers(n) for n in (views, height - side + 1, width - side + 1)
        )
        found, shade = pack.staged(
            view, protocol, (slice(y, y + side), slice(x, x + side))
        )
        known = found[np.isfinite(found)]
        if known.size and rng.uniform() < 2 / 3:
            found += (first + rng.uniform(0, classes)) * WRAP - rng.choice(known)
            found[found < WRAP] = np.nan
        scored = np.mean((found >= first * WRAP) & (found < (first + classes) * WRAP))
        if scored > share:
            share = scored
            best = (found, shade)
        if share > 0.3:
            break
    turn = rng.integers(4)
    mirror = 1 - 2 * rng.integers(2)
    depth, light = (np.rot90(image, turn)[:, ::mirror] for image in best)
    return depth, np.clip(light * np.exp(rng.uniform(-0.4, 0.4)), 0, 1)


@dataclass(eq=False)
class Steps(Dataset[Batch]):
    """Batches by the number of their step, of process ``rank`` out of ``world``.

    Crop k of step s is decided by (seed, s, k) alone, also after a kill or among processes.
    """

    config: Config
    pack: Pack | None
    rank: int = 0
    world: int = 1

    def __getitem__(self, step: int) -> Batch:
        stage, share = self.config.stage_at(step)
        low, high = stage.noise
        sigma = low * (high / low) ** min(share / stage.ramp, 1)
        crops = []
        for k in range(self.rank, stage.batch, self.world):
            rng = np.random.default_rng([self.config.seed, step, k])
            if self.pack is not None and rng.uniform() < stage.rooms:
                crop = room_crop(rng, self.pack, stage.crop, self.config.protocol)
            else:
                crop = leaves(rng, stage.crop, self.config.protocol)
            crops.append((*crop, sigma * float(np.exp(rng.uniform(-0.2, 0.1))), rng))
        return batch_of(crops)


def batch_of(crops: list[tuple]) -> Batch:
    """Batch of crops (depth, intensity, sigma, generator of their noise)."""
    depth, light, sigma, rngs = zip(*crops, strict=True)
    noise = [
        rng.standard_normal((4, 2, *depth[0].shape), dtype=np.float32) for rng in rngs
    ]
    images = (
        np.stack(depth),
        np.stack(light).astype(np.float32),
        np.float32(sigma),
        np.stack(noise),
    )
    return Batch(*map(torch.from_numpy, images))
