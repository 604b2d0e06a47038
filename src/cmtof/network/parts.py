"""What the learned baselines share: any image size, frames in bands, a target, a residual block.

A network is a trunk at full resolution and a head that reaches a few rows. The trunk sees the whole
frame at once; the classes of a whole frame, which would take a gigabyte, never exist at once.
"""

from collections.abc import Callable
from typing import Literal

import torch
from torch import Tensor, nn
from torch.nn import functional

from cmtof.network.fast_scnn import BAND, conv

Target = Literal["wraps", "depth"]


class Banded(nn.Module):
    """Network of any image size that may end in bands of rows.

    Maps features (B, C, H, W) to weights of wrap classes (B, N, H, W), or, for the target
    ``"depth"``, to turns (B, 1, H, W): wraps of the lower frequency above the first class,
    continuous.

    Parameters
    ----------
    inputs : int
        Channels of the features.
    classes : int
        N, wraps that are told apart; a regression takes them for its scale.
    target : {"wraps", "depth"}
    """

    stride: int
    """Of the coarsest features, px: images are padded to a multiple."""
    reach: int = 0
    """Rows that the head looks beyond each of its own."""
    output: nn.Module
    """Last layer: maps the trunk to `outputs` channels."""

    def __init__(self, inputs: int, classes: int, target: Target) -> None:
        super().__init__()
        self.inputs, self.classes, self.target = inputs, classes, target

    @property
    def outputs(self) -> int:
        """Channels of the last layer."""
        return self.classes if self.target == "wraps" else 1

    def body(self, x: Tensor) -> Tensor:
        """Features at full resolution of an image whose sides are multiples of the stride."""
        raise NotImplementedError

    def trunk(self, x: Tensor) -> Tensor:
        """What the output is made from, at full resolution, of an image of any size."""
        height, width = x.shape[-2:]
        return self.body(padded(x, self.stride))[..., :height, :width]

    def head(self, trunk: Tensor) -> Tensor:
        """Class weights or turns from any piece of `trunk`'s rows."""
        if self.target == "wraps":
            return self.output(trunk)
        # half precision has 8 to 11 bits, and 358 wraps need more
        with torch.autocast(trunk.device.type, enabled=False):
            return self.classes * (0.5 + self.output(trunk.float()))

    def forward(self, x: Tensor) -> Tensor:
        return self.head(self.trunk(x))

    def in_bands(self, x: Tensor, reduce: Callable[[Tensor], Tensor], rows: int = BAND) -> Tensor:
        """``reduce(forward(x))`` by bands of rows, as `cmtof.network.fast_scnn.FastSCNN` does.

        Parameters
        ----------
        x : Tensor, shape (B, C, H, W)
        reduce : callable
            Maps what `head` gives (B, N, h, W) to (B, D, h, W), pixel by pixel.
        rows : int
            h.

        Returns
        -------
        Tensor, shape (B, D, H, W)
        """
        trunk, height = self.trunk(x), x.shape[-2]
        bands = []
        for start in range(0, height, rows):
            top, bottom = max(start - self.reach, 0), min(start + rows + self.reach, height)
            found = self.head(trunk[..., top:bottom, :])
            bands.append(reduce(found[..., start - top : start - top + rows, :]))
        return torch.cat(bands, -2)


class Residual(nn.Module):
    """Two convolutions with batch norms, added to what went in (He et al. 2016).

    A 1x1 convolution brings the shortcut to another width or stride.
    """

    def __init__(self, inputs: int, outputs: int, stride: int = 1) -> None:
        super().__init__()
        self.body = nn.Sequential(
            conv(inputs, outputs, "batch", stride=stride),
            nn.Conv2d(outputs, outputs, 3, padding=1, bias=False),
            nn.BatchNorm2d(outputs),
        )
        same = stride == 1 and inputs == outputs
        self.shortcut = nn.Identity() if same else nn.Sequential(
            nn.Conv2d(inputs, outputs, 1, stride, bias=False), nn.BatchNorm2d(outputs)
        )  # fmt: skip

    def forward(self, x: Tensor) -> Tensor:
        return functional.relu(self.body(x) + self.shortcut(x))


def padded(x: Tensor, stride: int) -> Tensor:
    """Repeat the last row and column up to a multiple of the stride, two of them at least.

    A batch norm in training asks for more than one pixel, also of a single crop.

    Examples
    --------
    >>> padded(torch.zeros(1, 2, 1, 33), 16).shape
    torch.Size([1, 2, 32, 48])
    """
    height, width = (max(-(-size // stride), 2) * stride for size in x.shape[-2:])
    beyond = (0, width - x.shape[-1], 0, height - x.shape[-2])
    return functional.pad(x, beyond, mode="replicate") if any(beyond) else x
