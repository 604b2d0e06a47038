"""What the learned baselines share: images of any size, a residual block."""

from abc import abstractmethod

from torch import Tensor, nn
from torch.nn import functional

from cmtof.network.bands import Banded
from cmtof.network.fast_scnn import conv


class AnySize(Banded):
    """Network that halves the image several times, and still takes one of any size.

    Parameters
    ----------
    inputs, classes, target
        As of `cmtof.network.bands.Banded`.
    """

    stride: int
    """Of the coarsest features, px: images are padded to a multiple."""

    @abstractmethod
    def body(self, x: Tensor) -> Tensor:
        """Features at full resolution of an image whose sides are multiples of the stride."""

    def trunk(self, x: Tensor) -> Tensor:
        height, width = x.shape[-2:]
        return self.body(padded(x, self.stride))[..., :height, :width]


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
    >>> import torch
    >>> padded(torch.zeros(1, 2, 1, 33), 16).shape
    torch.Size([1, 2, 32, 48])
    """
    height, width = (max(-(-size // stride), 2) * stride for size in x.shape[-2:])
    beyond = (0, width - x.shape[-1], 0, height - x.shape[-2])
    return functional.pad(x, beyond, mode="replicate") if any(beyond) else x
