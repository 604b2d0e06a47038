"""The paper's network: Fast-SCNN with a smaller receptive field and a full-resolution skip.

Poudel et al. 2019 halve the image three times and look at the whole of it in the end; here
(Sec. 5.1) it is halved once before the features that the output is made from, every pool is local,
and the first layer, at full resolution, goes straight to the output. A wrap is local: what is far
away says nothing of it. The paper leaves the layers to a supplement; this table is our reading.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import torch
from torch import Tensor, nn
from torch.nn import functional

from cmtof.network.bands import Banded, Target

Norm = Literal["batch", "instance"]


@dataclass(frozen=True)
class Architecture:
    """Sizes of a network; two networks of the same one can exchange their weights.

    Attributes
    ----------
    stem : int
        Channels of the full-resolution skip; 0: none.
    down : tuple of int
        Channels of the learning to down-sample, at 1/2 of the resolution.
    bottlenecks : tuple of int
        Channels of each stage of the global feature extractor.
    strides : tuple of int
        Of those stages.
    repeats, expansion : int
        Bottlenecks a stage, and how much wider they are inside.
    pools : tuple of int
        Sides of the pyramid's local pools, px of its resolution; empty: bins of the whole image.
    context, head : int
        Channels of the fused features, and of the layer that joins them with the skip.
    norm : {"batch", "instance"}
        ``"batch"`` norms by what training saw, so that a crop and a frame agree.
    dropout : float
    """

    stem: int = 32
    down: tuple[int, ...] = (32, 48, 64)
    bottlenecks: tuple[int, ...] = (64, 96, 128)
    strides: tuple[int, ...] = (2, 2, 1)
    repeats: int = 3
    expansion: int = 6
    pools: tuple[int, ...] = (3, 5, 9, 17)
    context: int = 128
    head: int = 64
    norm: Norm = "batch"
    dropout: float = 0.1


def conv(inputs: int, outputs: int, norm: Norm, kernel: int = 3, stride: int = 1) -> nn.Sequential:
    """Convolution, norm, ReLU."""
    return nn.Sequential(_conv(inputs, outputs, kernel, stride), _norm(norm, outputs), _relu())


def separable(inputs: int, outputs: int, norm: Norm, stride: int = 1) -> nn.Sequential:
    """Depthwise separable convolution, each half with norm and ReLU."""
    return nn.Sequential(
        _conv(inputs, inputs, 3, stride, groups=inputs), _norm(norm, inputs), _relu(),
        _conv(inputs, outputs, 1), _norm(norm, outputs), _relu(),
    )  # fmt: skip


class Bottleneck(nn.Module):
    """Inverted residual of MobileNetV2: widen, convolve each channel, narrow, add."""

    def __init__(self, inputs: int, outputs: int, norm: Norm, stride: int, expansion: int) -> None:
        super().__init__()
        wide = expansion * inputs
        self.body = nn.Sequential(
            _conv(inputs, wide, 1), _norm(norm, wide), _relu(),
            _conv(wide, wide, 3, stride, groups=wide), _norm(norm, wide), _relu(),
            _conv(wide, outputs, 1), _norm(norm, outputs),
        )  # fmt: skip
        self.residual = stride == 1 and inputs == outputs

    def forward(self, x: Tensor) -> Tensor:
        return x + self.body(x) if self.residual else self.body(x)


class PyramidPooling(nn.Module):
    """Means over several neighbourhoods beside the features themselves.

    Local pools leave out what lies beyond the border. Without any the bins are 1, 2, 3 and 6 a side
    of the whole image, as published.
    """

    def __init__(self, width: int, pools: tuple[int, ...], norm: Norm) -> None:
        super().__init__()
        self.pools = pools
        self.branches = nn.ModuleList(
            conv(width, width // 4, norm, kernel=1) for _ in (pools or GLOBAL_BINS)
        )
        if norm == "instance" and not pools:
            self.branches[0][1] = nn.Identity()  # type: ignore[index]  # one pixel has no spread
        count = len(self.branches)
        self.join = conv(width + count * (width // 4), width, norm, kernel=1)

    def forward(self, x: Tensor) -> Tensor:
        return self.join(torch.cat([x, *self._means(x)], 1))

    def _means(self, x: Tensor) -> Iterator[Tensor]:
        for side, branch in zip(self.pools, self.branches, strict=False):
            # narrowed first, pooled then: both are linear but for the ReLU, and this is cheaper
            yield functional.avg_pool2d(
                branch(x), side, stride=1, padding=side // 2, count_include_pad=False
            )
        if not self.pools:
            for bins, branch in zip(GLOBAL_BINS, self.branches, strict=True):
                down, across = (_bins(size, bins).to(x) for size in x.shape[-2:])
                yield resized(branch(down @ x @ across.T), x)


GLOBAL_BINS = (1, 2, 3, 6)


class FastSCNN(Banded):
    """Modified Fast-SCNN (Sec. 5.1, Fig. 5).

    Takes images of any size from 8 px on (9 with instance norms).

    Parameters
    ----------
    architecture : Architecture
    inputs, classes, target
        As of `cmtof.network.bands.Banded`.
    """

    reach = 1

    def __init__(
        self, architecture: Architecture, inputs: int, classes: int, target: Target = "wraps"
    ) -> None:
        super().__init__(inputs, classes, target)
        self.architecture, a, norm = architecture, architecture, architecture.norm
        self.stem = conv(inputs, a.stem, norm) if a.stem else None
        first = conv(a.stem or inputs, a.down[0], norm, stride=2)
        widths = zip(a.down, a.down[1:], strict=False)
        self.down = nn.Sequential(first, *(separable(i, o, norm) for i, o in widths))
        self.extract = nn.Sequential(*_stages(a))
        self.pyramid = PyramidPooling(a.bottlenecks[-1], a.pools, norm)
        self.deep = nn.Sequential(
            _conv(a.bottlenecks[-1], a.bottlenecks[-1], 3, groups=a.bottlenecks[-1]),
            _norm(norm, a.bottlenecks[-1]), _relu(),
            _conv(a.bottlenecks[-1], a.context, 1), _norm(norm, a.context),
        )  # fmt: skip
        self.fine = nn.Sequential(_conv(a.down[-1], a.context, 1), _norm(norm, a.context))
        self.classify = nn.Sequential(*(separable(a.context, a.context, norm) for _ in range(2)))
        self.join = separable(a.context + a.stem, a.head, norm) if a.stem else None
        last = a.head if a.stem else a.context
        self.output = nn.Sequential(nn.Dropout(a.dropout), _conv(last, self.outputs, 1, bias=True))

    def fused(self, x: Tensor) -> tuple[Tensor, Tensor | None]:
        """Context at half of the resolution, and the skip at all of it, if there is one."""
        skip = self.stem(x) if self.stem else None
        down = self.down(x if skip is None else skip)
        deep = self.deep(resized(self.pyramid(self.extract(down)), down))
        return self.classify(functional.relu(deep + self.fine(down))), skip

    def trunk(self, x: Tensor) -> Tensor:
        """What the classes are told from, at full resolution: context, and the skip beside it."""
        context, skip = self.fused(x)
        context = resized(context, x)
        return context if skip is None else torch.cat([context, skip], 1)

    def head(self, trunk: Tensor) -> Tensor:
        """Class weights or turns from any piece of `trunk`'s rows."""
        return super().head(trunk if self.join is None else self.join(trunk))


def _stages(a: Architecture) -> Iterator[nn.Module]:
    inputs = a.down[-1]
    for width, stride in zip(a.bottlenecks, a.strides, strict=True):
        for i in range(a.repeats):
            yield Bottleneck(inputs, width, a.norm, stride if i == 0 else 1, a.expansion)
            inputs = width


def _conv(inputs: int, outputs: int, kernel: int, stride: int = 1, **options) -> nn.Conv2d:
    bias = options.pop("bias", False)
    return nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, bias=bias, **options)


def _norm(kind: Norm, width: int) -> nn.Module:
    return {"batch": nn.BatchNorm2d, "instance": nn.InstanceNorm2d}[kind](width)


def _relu() -> nn.Module:
    return nn.ReLU(inplace=True)


def _bins(size: int, bins: int) -> Tensor:
    """Matrix (bins, size) of means over equal shares of an axis; ONNX has no adaptive pooling."""
    pixel, share = torch.arange(size), torch.arange(bins)[:, None]
    # a bin begins at floor(k n / b) and ends before ceil((k + 1) n / b)
    inside = ((pixel + 1) * bins > share * size) & (pixel * bins < (share + 1) * size)
    return inside.float() / inside.float().sum(1, keepdim=True)


def resized(x: Tensor, like: Tensor) -> Tensor:
    """Bring an image to the size of another, bilinearly, pixel centres at +0.5."""
    return functional.interpolate(x, size=like.shape[-2:], mode="bilinear", align_corners=False)
