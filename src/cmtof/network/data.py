"""Training data: dead leaves and crops of rooms, measured on the fly (Sec. 5.3)."""

import warnings
from collections.abc import Callable, Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.random import Generator, default_rng
from torch import Tensor
from torch.utils.data import default_collate

from cmtof.constants import FREQUENCIES, FULL_SIGNAL, SPEED_OF_LIGHT
from cmtof.correlation import TAU
from cmtof.frame import Frames, Source
from cmtof.hypersim import Hypersim
from cmtof.measurement import unambiguous_range
from cmtof.network.features import CLASSES, WRAP, features
from cmtof.network.losses import IGNORED
from cmtof.network.recipe import Config, Rooms
from cmtof.simulation import RELEASED_FAR_DEPTH, released_scale
from cmtof.types import Array, Arrays

# Depth, m (NaN where unknown), and linear intensity, 0 to 1.
Crop = Arrays


class Batch(NamedTuple):
    """Crops of frames, and what their noise is made of."""

    depth: Tensor  # (B, H, W), m, NaN where unknown
    intensity: Tensor  # (B, H, W), linear, 0 to 1
    sigma: Tensor  # (B,), of a correlation image, counts
    noise: Tensor  # (B, 4, 2, H, W), standard normal
    offset: Tensor  # (B, 2), error of calibration of each phase, rad


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
    light = torch.where(torch.isfinite(batch.depth), batch.intensity, 0.0)
    signal = FULL_SIGNAL * light[:, None]
    spread = torch.sqrt(signal / 4 + batch.sigma.view(-1, 1, 1, 1) ** 2 / 2)
    noise = (spread[:, None] * batch.noise).unbind(1)
    angle = _angles(batch)
    size = signal / torch.pi
    x = size * torch.cos(angle) + noise[0]
    y = size * torch.sin(angle) + noise[1]
    mean = signal / 2 + noise[2] / 2**0.5
    alternating = noise[3] / 2**0.5
    even = mean + alternating
    odd = mean - alternating
    correlation = torch.stack([even + x, odd - y, even - x, odd + y], 2)
    return torch.remainder(torch.atan2(y, x), TAU), torch.hypot(x, y), correlation


def _angles(batch: Batch) -> Tensor:
    """Phases (B, 2, H, W), rad, with their errors; those of depth 0 where it is unknown."""
    # turns are reduced in double precision: 700 wraps in float32 would lose a milliradian
    depth = batch.depth.nan_to_num().double()[:, None]
    tones = depth.new_tensor(FREQUENCIES)
    turns = depth * (2 * tones / SPEED_OF_LIGHT).view(-1, 1, 1)
    return (TAU * turns.frac()).float() + batch.offset[..., None, None]


def measure(batch: Batch, *, inputs: str, protocol: str) -> Sample:
    """Inputs of a network, out of `FEATURE_SETS`, channels last, and its target wraps.

    Masked are pixels outside the protocol's wraps and those whose beat repeats a nearer one's.
    """
    first, classes = CLASSES[protocol]
    phase, amplitude, correlation = phasors(batch)
    turns = batch.depth / WRAP - first
    repeated = unambiguous_range(FREQUENCIES) / WRAP - first
    scored = (turns >= 0) & (turns < min(classes, repeated))  # false for NaN
    label = torch.where(scored, turns.floor().long(), IGNORED)
    found = features(phase, amplitude, inputs, correlation)
    return Sample(
        found.contiguous(memory_format=torch.channels_last), label, phase[:, 0], turns
    )


def dead_leaves(rng: Generator, side: int, protocol: str) -> Crop:
    """Overlapping slanted plates at random depths: the training data of the first stage.

    Depth, brightness and texture are independent, so that only the phases determine a wrap.
    Some plates lie nearer than the protocol's range; slopes are those of rooms that it has shrunk.
    """
    turns, light = np.zeros((2, side, side))
    pixels = np.indices((side, side))[::-1]
    for number in range(rng.integers(3, 4 + 11 * side // 96)):
        size = 4.0 * side  # of the background
        if number:
            size = side * np.exp(rng.uniform(np.log(0.15), 0))
        away = pixels - rng.uniform(0, side, 2)[:, None, None]
        along, beside = _rotate(away, rng) / size
        beside /= rng.uniform(0.2, 1) if number else 1.0
        far = np.hypot(along, beside)
        if rng.integers(2):  # a rectangle rather than an ellipse
            far = np.maximum(abs(along), abs(beside))
        outside = far > 1
        turns = np.where(outside, turns, _plate_depth(rng, away, size, protocol))
        light = np.where(outside, light, _plate_light(rng, pixels, along))  # pyright: ignore[reportArgumentType]
    grain = 0.15 * rng.standard_normal((side, side))
    grain *= rng.uniform() < 0.5
    light *= np.exp(grain)
    return np.where(turns > 1, turns * WRAP, np.nan), np.minimum(light, 1)


def _rotate(pixels: Array, rng: Generator) -> Array:
    """Coordinates (2, H, W), x and y, along and beside a random direction."""
    angle = rng.uniform(0, TAU)
    cosine = np.cos(angle)
    sine = np.sin(angle)
    return np.tensordot([[cosine, sine], [-sine, cosine]], pixels, 1)


def _plate_depth(rng: Generator, away: Array, size: float, protocol: str) -> Array:
    """Depth (H, W), wraps, of a plate of that size, px, by the distance from its middle."""
    first, classes = CLASSES[protocol]
    level = rng.uniform(-0.5, classes + 0.5)
    if rng.uniform() > 0.85:
        level = rng.uniform(-min(25, first), 0)
    slope = (0.02 if first else 0.1) * np.exp(rng.normal())
    bend = rng.normal(0, 2) * (rng.uniform() < 0.3) / size**2
    return first + level + slope * _rotate(away, rng)[0] + bend * (away**2).sum(0)


def _plate_light(rng: Generator, pixels: Array, along: Array) -> Array:
    """Brightness (H, W) of a plate: stripes, checks or a gradient along it."""
    pitch = np.exp(rng.uniform(np.log(4), np.log(60)))
    stripes, others = np.sin(TAU / pitch * _rotate(pixels, rng))
    checks = np.sign(stripes * others)
    gradient = np.clip(along, -1, 1)
    contrast = rng.uniform(0, 0.8) * (rng.uniform() < 0.6)
    bright = 0.35 * np.exp(rng.normal(0, 1.1))
    kinds = (stripes, checks, gradient)
    return bright * (1 + contrast * kinds[rng.integers(3)])


class Pack(NamedTuple):
    """Frames of one partition in memory: reading a file a crop would cost more than a step."""

    depth: Array  # (V, H, W), m
    intensity: Array
    far: Array  # (V,), m, the 99.9th percentile, by which ``released`` shrinks

    def staged_window(self, view: int, protocol: str, window: Any = ...) -> Crop:
        """Depth, m, scaled as by the protocol, and intensity, of a window of one frame."""
        scale = released_scale(self.far[view]) if protocol == "released" else 1.0
        depth = self.depth[view][window]
        light = self.intensity[view][window]
        return depth.astype(float) * scale, light.astype(float)


Packs = tuple[Pack | None, Pack]  # to train and to validate on


def pack_views(views: Sequence[Source]) -> Pack:
    """Views in memory; one that is broken, empty, or of another size is left out with a warning."""
    frames = Frames(views)
    depths = []
    lights = []
    for frame in frames:
        shape = depths[0].shape if depths else frame.depth.shape
        if frame.depth.shape != shape:
            frames.skipped[frame.name] = (
                f"Expected depths of {shape} px, got {frame.depth.shape}. Look at it."
            )
            continue
        depths.append(frame.depth)
        lights.append(np.clip(frame.intensity, 0, 1).astype(np.float16))
    for name, reason in frames.skipped.items():
        warnings.warn(f"{name} is left out. {reason}", stacklevel=2)
    if not depths:
        raise ValueError(
            "Expected views to train and to validate on, got none. Render 10 scenes or more."
        )
    far = [np.nanpercentile(depth, 99.9) for depth in depths]
    return Pack(np.stack(depths), np.stack(lights), np.array(far))


def open_rooms(
    config: Config, find_tree: Callable[[Rooms], Path] | None = None
) -> Packs:
    """Frames of a tree to train and to validate on; without rooms ``find_tree`` is not called.

    Then there are none to train on, and leaves of a seed of their own to validate on.
    """
    if config.rooms is None:
        return None, _pack_of_leaves(config)
    if find_tree is None:
        raise ValueError("Expected a way to find the rooms, got none. Pass find_tree.")
    scenes = Hypersim(find_tree(config.rooms))
    train, val = (
        pack_views(scenes.sources(scenes.split()[part])) for part in ("train", "val")
    )
    return train, val


def _pack_of_leaves(config: Config) -> Pack:
    """`Pack` of dead leaves to validate on, from seeds of their own."""
    side = config.stages[-1].crop
    crops = [
        dead_leaves(default_rng([99, k]), side, config.protocol)
        for k in range(config.validation_views)
    ]
    depth, light = np.stack(crops, axis=1)
    return Pack(depth, light, np.full(len(crops), RELEASED_FAR_DEPTH))


def room_crop(rng: Generator, pack: Pack, side: int, protocol: str) -> Crop:
    """Random crop, turned, mirrored, and mostly moved in depth: rooms give few wraps a crop.

    Taken is the first of four draws with 30 % of its pixels in range, or the best of them.
    """
    draws = []
    for _ in range(4):
        draw = _draw_window(rng, pack, side, protocol)
        draws.append(draw)
        if draw[0] > 0.3:
            break
    _, *best = max(draws, key=itemgetter(0))
    turn = int(rng.integers(4))
    mirror = 1 - 2 * rng.integers(2)
    depth, light = (np.rot90(image, turn)[:, ::mirror].copy() for image in best)
    return depth, np.clip(light * np.exp(rng.uniform(-0.4, 0.4)), 0, 1)


def _draw_window(
    rng: Generator, pack: Pack, side: int, protocol: str
) -> tuple[float, Array, Array]:
    """Share in range, depth, m, and intensity of a random window; two of three move in depth."""
    first, classes = CLASSES[protocol]
    sizes = np.subtract(pack.depth.shape, (0, side - 1, side - 1))
    view, y, x = rng.integers(sizes)
    depth, light = pack.staged_window(view, protocol, np.s_[y : y + side, x : x + side])
    known = depth[np.isfinite(depth)]
    if known.size and rng.uniform() < 2 / 3:
        depth += (first + rng.uniform(0, classes)) * WRAP - rng.choice(known)
        depth[depth < WRAP] = np.nan
    inside = (depth >= first * WRAP) & (depth < (first + classes) * WRAP)
    return inside.mean(), depth, light


def batch_at(
    step: int, config: Config, pack: Pack | None, rank: int = 0, world: int = 1
) -> Batch:
    """Batch of a step, or the part of it that process ``rank`` out of ``world`` has.

    Crop k of step s is decided by (seed, s, k) alone, also after a kill or among processes.
    """
    stage, share = config.stage_at(step)
    low, high = stage.noise
    sigma = low * (high / low) ** min(share / stage.ramp, 1)
    crops = []
    for k in range(rank, stage.batch, world):
        rng = default_rng([config.seed, step, k])
        if pack is not None and rng.uniform() < stage.rooms:
            crop = room_crop(rng, pack, stage.crop, config.protocol)
        else:
            crop = dead_leaves(rng, stage.crop, config.protocol)
        crops.append((*crop, sigma * np.exp(rng.uniform(-0.2, 0.1)), rng))
    return batch_of(crops, config.offset)


def batch_of(crops: list[tuple], offset: float = 0.0) -> Batch:
    """Batch of crops: depth, intensity, sigma, and a generator of noise and phase offset."""
    drawn = [
        (
            depth,
            light.astype(np.float32),
            np.float32(sigma),
            rng.standard_normal((4, 2, *depth.shape), dtype=np.float32),
            rng.normal(0, offset, 2).astype(np.float32),
        )
        for depth, light, sigma, rng in crops
    ]
    return Batch(*default_collate(drawn))
