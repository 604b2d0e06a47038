"""Measurements made on the device that trains: frames in, features and labels out (Sec. 5.3).

`cmtof.simulation` draws every correlation image. At four quadratures the sum of opposite ones is
the same for any phase, so decoding leaves a phasor with equal, independent noise across and along
it, of variance (G T I / 2 + sigma^2) / 2 each: two normal numbers a pixel instead of four and four
photon counts. Only the photons' skewness is lost, next to sigma = 1200 counts. A test holds the two
against each other.

What the images hold beside the phasor is their mean and what alternates from image to image; both
have noise of half that variance, from two more numbers, and `quadratures` puts the images together.
"""

from typing import NamedTuple

import torch
from torch import Tensor

from cmtof.constants import FREQUENCIES, GAIN, INTEGRATION_TIME, SPEED_OF_LIGHT
from cmtof.correlation import TAU, wrap_length
from cmtof.measurement import unambiguous_range
from cmtof.network.features import features, needs_correlation
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
    signal = _signal(depth, intensity)
    known = torch.isfinite(depth)
    tones = torch.tensor(FREQUENCIES, dtype=torch.float64, device=depth.device)
    # turns are reduced in double precision: 700 wraps in float32 would lose a milliradian
    turns = torch.where(known, depth, 0.0).double()[:, None] * (2 * tones / SPEED_OF_LIGHT).view(
        -1, 1, 1
    )
    angle = (TAU * (turns - turns.floor())).float()
    x, y = signal / torch.pi * torch.cos(angle), signal / torch.pi * torch.sin(angle)
    if noise is not None:
        spread = _spread(signal, sigma)
        x, y = x + spread * noise[0], y + spread * noise[1]
    return torch.remainder(torch.atan2(y, x), TAU), torch.hypot(x, y)


def quadratures(
    batch: Batch, phase: Tensor, amplitude: Tensor, noise: Tensor | None = None
) -> Tensor:
    r"""Correlation images that decode to the given phasors (Eq. 8 and 9, four quadratures).

    .. math:: C_k = d + a \cos(\hat\varphi + k\pi/2) + (-1)^k q, \quad
              d = \tfrac14 \sum_k C_k, \quad q = \tfrac14 \sum_k (-1)^k C_k

    Each image has the variance :math:`v_k = GTI(1/2 + \cos(\varphi + k\pi/2)/\pi) + \sigma^2`,
    and :math:`v_0 + v_2 = v_1 + v_3`. So d and q, of mean GTI/2 and 0, both have the variance
    :math:`\sum_k v_k / 16 = (GTI/2 + \sigma^2)/4`, half of the phasor's, and no covariance. With
    the phasor theirs is at most :math:`a/4`, from photons: 0.3 % of the spreads' product at
    sigma = 1200 counts, and left out.

    Parameters
    ----------
    batch : Batch
    phase, amplitude : Tensor, shape (B, 2, H, W)
        As measured, from `phasors`: rad and counts.
    noise : Tensor, shape (2, B, 2, H, W), optional
        Standard normal numbers for d and q, independent of those of `phasors`.

    Returns
    -------
    Tensor, shape (B, 2, 4, H, W)
        Counts, at 0, 1/2, 1 and 3/2 pi.
    """
    x, y = amplitude * torch.cos(phase), amplitude * torch.sin(phase)
    signal = _signal(batch.depth, batch.intensity)
    offset, alternating = (signal / 2).expand_as(x), torch.zeros_like(x)
    if noise is not None:
        spread = _spread(signal, batch.sigma) / 2**0.5
        offset, alternating = offset + spread * noise[0], spread * noise[1]
    even, odd = offset + alternating, offset - alternating
    return torch.stack([even + x, odd - y, even - x, odd + y], 2)


def normals(inputs: str) -> int:
    """Standard normal numbers that a pixel's measurement takes at each frequency.

    Examples
    --------
    >>> normals("proposed"), normals("correlation")
    (2, 4)
    """
    return 4 if needs_correlation(inputs) else 2


def _signal(depth: Tensor, intensity: Tensor) -> Tensor:
    """G T I (B, 1, H, W), counts; no light returns from where no depth is known."""
    return GAIN * INTEGRATION_TIME * torch.where(torch.isfinite(depth), intensity, 0.0)[:, None]


def _spread(signal: Tensor, sigma: Tensor) -> Tensor:
    """Standard deviation of each part of a phasor, counts."""
    return torch.sqrt(signal / 4 + sigma.view(-1, 1, 1, 1) ** 2 / 2)


def measure(batch: Batch, noise: Tensor | None, *, inputs: str, first: int, classes: int) -> Sample:
    """Measure a batch: inputs of a network, and the wraps it is asked for.

    Parameters
    ----------
    batch : Batch
    noise : Tensor, shape (K, B, 2, H, W), or None
        Standard normal, K of `normals`: two as in `phasors`, then two as in `quadratures`.
    inputs : str
        Set of features, out of `cmtof.network.features.FEATURE_SETS`.
    first, classes : int
        Wrap of the first class, and how many there are; pixels beyond, and those whose beat
        repeats a nearer one's, are masked.
    """
    phase, amplitude = phasors(*batch, None if noise is None else noise[:2])
    images = None
    if needs_correlation(inputs):
        images = quadratures(batch, phase, amplitude, None if noise is None else noise[2:])
    turns = batch.depth * (2 * FREQUENCIES[0] / SPEED_OF_LIGHT) - first
    label = torch.nan_to_num(turns, nan=-1.0).floor().long()
    scored = (turns >= 0) & (turns < min(classes, REPEATED - first))  # false for NaN
    label = torch.where(scored, label, IGNORED)
    return Sample(features(phase, amplitude, inputs, images), label, phase[:, 0], turns)
