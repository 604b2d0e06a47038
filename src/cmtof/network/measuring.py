"""Measurements made on the device that trains: frames in, features and labels out (Sec. 5.3).

`cmtof.simulation` draws every correlation image. At four quadratures the sum of opposite ones is
the same for any phase, so decoding leaves a phasor with equal, independent noise across and along
it, of variance (G T I / 2 + sigma^2) / 2 each: two normal numbers a pixel instead of four and four
photon counts. Only the photons' skewness is lost, next to sigma = 1200 counts. A test holds the two
against each other.
"""

from typing import NamedTuple

import torch
from torch import Tensor

from cmtof.constants import FREQUENCIES, GAIN, INTEGRATION_TIME, SPEED_OF_LIGHT
from cmtof.correlation import TAU, wrap_length
from cmtof.measurement import unambiguous_range
from cmtof.network.features import features
from cmtof.network.losses import IGNORED

REPEATED = unambiguous_range(FREQUENCIES) / float(wrap_length(FREQUENCIES[0]))
"""Wraps of the lower frequency after which the beat repeats itself: 357.5, no whole number."""


class Batch(NamedTuple):
    """Crops of frames, and how each is to be measured."""

    depth: Tensor
    """Staged by the protocol, (B, H, W), m; NaN where unknown."""
    intensity: Tensor
    """(B, H, W), 0 to 1."""
    sigma: Tensor
    """Gaussian noise (B,), counts."""


class Sample(NamedTuple):
    """What a network is given and asked."""

    inputs: Tensor
    """(B, C, H, W)"""
    label: Tensor
    """Class of the true wrap (B, H, W), `IGNORED` where masked."""
    phase: Tensor
    """Measured wrapped phase of the lower frequency (B, H, W), rad."""
    turns: Tensor
    """True depth (B, H, W), wraps of the lower frequency above the first class."""


def phasors(
    depth: Tensor, intensity: Tensor, sigma: Tensor, noise: Tensor | None = None
) -> tuple[Tensor, Tensor]:
    """Decoded measurements of frames (Eq. 8, four quadratures).

    Parameters
    ----------
    depth, intensity : Tensor, shape (B, H, W)
        m and 0 to 1; unknown depths are NaN, and no light returns from there.
    sigma : Tensor, shape (B,)
        Gaussian noise of a correlation image, counts.
    noise : Tensor, shape (2, B, 2, H, W), optional
        Standard normal numbers, one for each part of each phasor; by default noise-free.

    Returns
    -------
    phase, amplitude : Tensor, shape (B, 2, H, W)
        Wrapped, rad, in [0, 2 pi); counts.
    """
    known = torch.isfinite(depth)
    signal = GAIN * INTEGRATION_TIME * torch.where(known, intensity, 0.0)[:, None]
    tones = torch.tensor(FREQUENCIES, dtype=torch.float64, device=depth.device)
    # turns are reduced in double precision: 700 wraps in float32 would lose a milliradian
    turns = torch.where(known, depth, 0.0).double()[:, None] * (2 * tones / SPEED_OF_LIGHT).view(
        -1, 1, 1
    )
    angle = (TAU * (turns - turns.floor())).float()
    x, y = signal / torch.pi * torch.cos(angle), signal / torch.pi * torch.sin(angle)
    if noise is not None:
        spread = torch.sqrt(signal / 4 + sigma.view(-1, 1, 1, 1) ** 2 / 2)
        x, y = x + spread * noise[0], y + spread * noise[1]
    return torch.remainder(torch.atan2(y, x), TAU), torch.hypot(x, y)


def measure(batch: Batch, noise: Tensor | None, *, inputs: str, first: int, classes: int) -> Sample:
    """Measure a batch: inputs of a network, and the wraps it is asked for.

    Parameters
    ----------
    batch : Batch
    noise : Tensor, shape (2, B, 2, H, W), or None
        As in `phasors`.
    inputs : str
        Set of features, out of `cmtof.network.features.FEATURE_SETS`.
    first, classes : int
        Wrap of the first class, and how many there are; pixels beyond, and those whose beat
        repeats a nearer one's, are masked.
    """
    phase, amplitude = phasors(*batch, noise)
    turns = batch.depth * (2 * FREQUENCIES[0] / SPEED_OF_LIGHT) - first
    label = torch.nan_to_num(turns, nan=-1.0).floor().long()
    scored = (turns >= 0) & (turns < min(classes, REPEATED - first))  # false for NaN
    label = torch.where(scored, label, IGNORED)
    return Sample(features(phase, amplitude, inputs), label, phase[:, 0], turns)
