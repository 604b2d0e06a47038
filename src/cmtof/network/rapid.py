"""Rapid and robust phase unwrapping (Zhang T., Jiang, Zhao et al., Opt. Express 27(16), 2019).

DeepLabV3+ (Chen et al. 2018) segments a wrapped phase into wrap counts, which are mended
afterwards. The paper cites a "Zhang et al. 2019" and calls it a regression; two articles of that
year fit the name. Built is this one; the other (Zhang J., Tian, Shao et al., Opt. Express 27(10),
2019) joins a SegNet with a denoiser. The published code was not available: backbone, sizes and the
mending are our reading.

Ours: a small residual backbone that ends at 1/16 of the resolution; the pool over the whole image
has a bias in place of a norm, which one pixel of one crop would not bear. Weights of classes are
linear in the decoder's features, and so is the resize to full resolution: the features are resized
and not the classes, to the same end. As shipped it is narrowed to about 1.17 million parameters.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from cmtof.correlation import TAU
from cmtof.network.bands import Target
from cmtof.network.fast_scnn import conv, resized
from cmtof.network.parts import AnySize, Residual


@dataclass(frozen=True)
class Architecture:
    """Sizes of a DeepLabV3+.

    Attributes
    ----------
    backbone : tuple of int
        Channels at 1/2, 1/4, 1/8 and 1/16 of the resolution.
    blocks : int
        Residual blocks at each but the first.
    rates : tuple of int
        Dilations of the pyramid (ASPP), px at 1/16.
    pyramid, skip, decoder : int
        Channels of the pyramid, of the low-level features beside it, and of the decoder.
    """

    backbone: tuple[int, ...] = (32, 48, 80, 112)
    blocks: int = 2
    rates: tuple[int, ...] = (6, 12, 18)
    pyramid: int = 80
    skip: int = 24
    decoder: int = 64


PUBLISHED = Architecture((64, 128, 256, 512), pyramid=256, skip=48, decoder=256)
"""Pyramid and decoder of DeepLabV3+; a backbone as wide as a ResNet-18."""


class AtrousPyramid(nn.Module):
    """Convolutions of several dilations and the mean of the image, side by side, and joined."""

    def __init__(self, inputs: int, width: int, rates: tuple[int, ...]) -> None:
        super().__init__()
        self.near = conv(inputs, width, "batch", kernel=1)
        self.far = nn.ModuleList(_dilated(inputs, width, rate) for rate in rates)
        self.whole = nn.Conv2d(inputs, width, 1)
        self.join = conv((len(rates) + 2) * width, width, "batch", kernel=1)

    def forward(self, x: Tensor) -> Tensor:
        mean = functional.relu(self.whole(x.mean((-2, -1), keepdim=True)))
        local = [self.near(x), *(branch(x) for branch in self.far)]
        return self.join(torch.cat([*local, mean.expand(-1, -1, *x.shape[-2:])], 1))


class Rapid(AnySize):
    """DeepLabV3+ on a residual backbone.

    Parameters
    ----------
    architecture : Architecture
    inputs, classes, target
        As of `cmtof.network.bands.Banded`.
    """

    stride = 16

    def __init__(
        self, architecture: Architecture, inputs: int, classes: int, target: Target = "wraps"
    ) -> None:
        super().__init__(inputs, classes, target)
        self.architecture, a = architecture, architecture
        self.stem = conv(inputs, a.backbone[0], "batch", stride=2)
        self.fine, *coarse = (_stage(i, o, a.blocks) for i, o in pairwise(a.backbone))
        self.coarse = nn.Sequential(*coarse)
        self.pyramid = AtrousPyramid(a.backbone[-1], a.pyramid, a.rates)
        self.skip = conv(a.backbone[1], a.skip, "batch", kernel=1)
        self.decoder = nn.Sequential(
            conv(a.pyramid + a.skip, a.decoder, "batch"), conv(a.decoder, a.decoder, "batch")
        )
        self.output = nn.Conv2d(a.decoder, self.outputs, 1)

    def body(self, x: Tensor) -> Tensor:
        fine = self.fine(self.stem(x))
        context = resized(self.pyramid(self.coarse(fine)), fine)
        return resized(self.decoder(torch.cat([context, self.skip(fine)], 1)), x)


def _stage(inputs: int, outputs: int, blocks: int) -> nn.Sequential:
    """Residual blocks, the first of which halves the resolution."""
    more = (Residual(outputs, outputs) for _ in range(blocks - 1))
    return nn.Sequential(Residual(inputs, outputs, stride=2), *more)


def _dilated(inputs: int, outputs: int, rate: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, 3, padding=rate, dilation=rate, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    )


# --- afterwards --------------------------------------------------------------------------------


def mended(
    wraps: NDArray[np.integer], phase: NDArray[np.floating], side: int = 5
) -> NDArray[np.int64]:
    """Wraps by the vote of their neighbourhood, then made congruent with the measured phase.

    First comes a mode filter, which takes single wrong pixels out, then `congruent`, which puts
    back the wrap lines that noise draws into the measured phase and the filter straightens.

    Parameters
    ----------
    wraps : ndarray of int, shape (H, W)
        Wrap counts.
    phase : ndarray, shape (H, W)
        Measured wrapped phase that they belong to, rad, finite.
    side : int
        Of the neighbourhood, odd, px.
    """
    return congruent(most_frequent(wraps, side), phase, side)


def most_frequent(wraps: NDArray[np.integer], side: int = 5) -> NDArray[np.int64]:
    """Most frequent wrap within a square, its own first among equals, then the lowest.

    Examples
    --------
    >>> most_frequent(np.array([[3, 3, 3, 9, 3, 3]]), 3).tolist()
    [[3, 3, 3, 3, 3, 3]]
    """
    return _voted(np.asarray(wraps), np.zeros(np.shape(wraps)), side)


def congruent(
    wraps: NDArray[np.integer], phase: NDArray[np.floating], side: int = 5
) -> NDArray[np.int64]:
    r"""Most frequent of the wraps that the neighbours hold a pixel to have.

    .. math:: n_p = n_q + \mathrm{round}\frac{\hat\varphi_q - \hat\varphi_p}{2\pi}

    is what the wrap of q says of p, if no more than half a turn lies between the two: on a surface
    whose phase runs on, all neighbours agree on both sides of every wrap line.

    Parameters
    ----------
    wraps, phase, side
        As of `mended`.

    Examples
    --------
    >>> congruent(np.array([[3, 3, 4]]), np.array([[5.9, 6.1, 0.1]]), 3).tolist()
    [[3, 3, 4]]
    """
    return _voted(np.asarray(wraps), np.asarray(phase) / TAU, side)


def _voted(wraps: NDArray, turns: NDArray, side: int) -> NDArray[np.int64]:
    """Mode of ``n_q + round(turns_q - turns_p)`` over the squares' pixels q within the image."""
    if side < 1 or side % 2 == 0:
        raise ValueError(f"Expected an odd side, which has a middle, got {side}. Add a pixel.")
    votes = _votes(wraps.astype(np.int32), turns.astype(np.float32), side // 2)
    outside = np.iinfo(np.int32).min
    best, most = wraps.astype(np.int32), np.zeros(wraps.shape, np.int16)
    middle = len(votes) // 2
    for k in (middle, *range(middle), *range(middle + 1, len(votes))):
        count = np.zeros(wraps.shape, np.int16)
        for other in votes:
            count += other == votes[k]
        inside = votes[k] != outside
        # a later vote wins only by number, or, among others than the pixel's own, by being lower
        tied = (count == most) & (votes[k] < best) & (best != votes[middle])
        better = inside & ((count > most) | tied)
        best, most = np.where(better, votes[k], best), np.where(better, count, most)
    return best.astype(np.int64)


def _votes(wraps: NDArray[np.int32], turns: NDArray[np.float32], reach: int) -> NDArray[np.int32]:
    """What each pixel of a square says of its middle ((2 reach + 1)^2, H, W)."""
    height, width = wraps.shape
    span = 2 * reach + 1
    votes = np.full((span * span, height, width), np.iinfo(np.int32).min, np.int32)
    for k in range(span * span):
        down, right = k // span - reach, k % span - reach
        here = tuple(
            slice(max(-d, 0), max(min(n, n - d), 0)) for d, n in ((down, height), (right, width))
        )
        there = tuple(
            slice(max(d, 0), max(min(n, n + d), 0)) for d, n in ((down, height), (right, width))
        )
        steps = np.rint(turns[there] - turns[here]).astype(np.int32)
        votes[k][here] = wraps[there] + steps
    return votes
