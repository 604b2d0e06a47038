"""U-Net (Ronneberger, Fischer and Brox 2015), as the paper compares with it: segmentation.

Five levels, two convolutions each on the way down and up, max-pools, transposed convolutions and
concatenated skips, as published. Changed, as is usual today: convolutions keep the size of the
image, and each has a batch norm. What the paper calls unmodified reads, by our choice, the bare
wrapped phases and log amplitudes (features ``phase``), and is trained by cross-entropy alone.

As shipped it is narrowed to about as many parameters as the paper's own network has, 1.17 million;
`PUBLISHED` has 31 million. The first level is narrowed least: out of it come up to 358 classes.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional

from cmtof.network.bands import Target
from cmtof.network.fast_scnn import conv
from cmtof.network.parts import AnySize


@dataclass(frozen=True)
class Architecture:
    """Sizes of a U-Net.

    Attributes
    ----------
    widths : tuple of int
        Channels of each level, each at half of the resolution of the one before.
    """

    widths: tuple[int, ...] = (24, 48, 72, 104, 128)


PUBLISHED = Architecture((64, 128, 256, 512, 1024))
"""What the authors built, for biomedical images."""


class UNet(AnySize):
    """U-Net with batch norms.

    Parameters
    ----------
    architecture : Architecture
    inputs, classes, target
        As of `cmtof.network.bands.Banded`.
    """

    def __init__(
        self, architecture: Architecture, inputs: int, classes: int, target: Target = "wraps"
    ) -> None:
        super().__init__(inputs, classes, target)
        self.architecture, widths = architecture, architecture.widths
        self.stride = 2 ** (len(widths) - 1)
        steps = list(pairwise(widths))
        self.down = nn.ModuleList(self.level(i, o) for i, o in pairwise((inputs, *widths)))
        self.rise = nn.ModuleList(nn.ConvTranspose2d(o, i, 2, 2) for i, o in reversed(steps))
        self.up = nn.ModuleList(self.level(2 * i, i) for i, _ in reversed(steps))
        self.output = nn.Conv2d(widths[0], self.outputs, 1)

    @staticmethod
    def level(inputs: int, outputs: int) -> nn.Module:
        """What is done at one resolution, on the way down or up."""
        return nn.Sequential(conv(inputs, outputs, "batch"), conv(outputs, outputs, "batch"))

    def body(self, x: Tensor) -> Tensor:
        *skips, x = self._levels(x)
        for rise, level in zip(self.rise, self.up, strict=True):
            x = level(torch.cat([skips.pop(), rise(x)], 1))
        return x

    def _levels(self, x: Tensor) -> Iterator[Tensor]:
        for k, level in enumerate(self.down):
            x = level(functional.max_pool2d(x, 2) if k else x)
            yield x
