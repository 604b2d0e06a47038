"""Layers that the networks share."""

import torch
from torch import Tensor, nn
from torch.nn import functional


class SingleConv2d(nn.Conv2d):
    """Convolution in single precision, also where the network runs in mixed precision.

    On CPUs PyTorch 2.13's bfloat16 gradient of dilated depthwise kernels reads unset memory.
    """

    def _conv_forward(
        self, input: Tensor, weight: Tensor, bias: Tensor | None
    ) -> Tensor:
        with torch.autocast(input.device.type, enabled=False):
            return super()._conv_forward(input.float(), weight.float(), bias)


class NormedConv(nn.Sequential):
    """Convolution, batch norm, and further layers such as a ReLU.

    A norm that keeps its statistics is a scale and an offset: they go into the kernel and its bias,
    which spares passes over the image.
    """

    def forward(self, input: Tensor) -> Tensor:
        layer, norm, *more = self
        if norm.training or isinstance(norm, nn.InstanceNorm2d):
            return super().forward(input)
        scale, offset = scale_and_offset(norm)
        x = layer._conv_forward(input, layer.weight * scale.view(-1, 1, 1, 1), offset)  # pyright: ignore[reportCallIssue, reportOperatorIssue]
        for function in more:
            x = function(x)
        return x


def scale_and_offset(norm: nn.Module) -> tuple[Tensor, Tensor]:
    """Factor and summand (C,) of each channel, to which a batch norm in evaluation amounts."""
    scale = norm.weight * torch.rsqrt(norm.running_var + norm.eps)  # pyright: ignore[reportOperatorIssue]
    return scale, norm.bias - norm.running_mean * scale  # pyright: ignore[reportOperatorIssue]


def conv(i: int, o: int, kernel=3, *, relu=True, dilation=1, **more) -> NormedConv:
    """Convolution from i to o channels, norm, ReLU; ``more`` are options of `torch.nn.Conv2d`."""
    # one kernel for each channel
    alone = dilation > 1 and more.get("groups", 1) > 1
    kind = SingleConv2d if alone else nn.Conv2d
    more.setdefault("padding", dilation * (kernel // 2))
    layer = kind(i, o, kernel, dilation=dilation, bias=False, **more)
    return NormedConv(
        layer, nn.BatchNorm2d(o), *([nn.ReLU(inplace=True)] if relu else [])
    )


def separable(i: int, o: int, stride: int = 1) -> nn.Sequential:
    """Depthwise separable convolution from i to o channels."""
    alone = conv(i, i, stride=stride, groups=i)
    return nn.Sequential(alone, conv(i, o, 1))


def resize_like(x: Tensor, like: Tensor, aligned: bool = False) -> Tensor:
    """Images (B, C, H, W) resized to those of ``like``, bilinearly.

    Pixel centres lie at +0.5 or, if ``aligned``, those of the corners on each other.
    """
    return functional.interpolate(
        x, size=like.shape[-2:], mode="bilinear", align_corners=aligned
    )


class Bottleneck(nn.Module):
    """Inverted residual of MobileNetV2: widen, convolve each channel, narrow, add."""

    def __init__(self, i: int, o: int, stride: int, expansion=6, dilation=1) -> None:
        super().__init__()
        wide = expansion * i
        self.residual = stride == 1 and i == o
        # the first to draw its weights
        middle = conv(wide, wide, stride=stride, groups=wide, dilation=dilation)
        self.body = nn.Sequential(
            conv(i, wide, 1), middle, conv(wide, o, 1, relu=False)
        )

    def forward(self, x: Tensor) -> Tensor:
        return x + self.body(x) if self.residual else self.body(x)


class Residual(nn.Module):
    """Two convolutions, added to their input (He et al. 2016)."""

    def __init__(self, i: int, o: int, stride: int = 1) -> None:
        super().__init__()
        self.body = nn.Sequential(conv(i, o, stride=stride), conv(o, o, relu=False))
        self.shortcut = (
            nn.Identity() if i == o else conv(i, o, 1, stride=stride, relu=False)
        )

    def forward(self, x: Tensor) -> Tensor:
        return functional.relu(self.body(x) + self.shortcut(x))


def window_mean(side: int) -> nn.Sequential:
    """Layer of means over a square window, px, of the part of it inside the image."""
    columns = nn.AvgPool2d((side, 1), 1, (side // 2, 0), count_include_pad=False)
    rows = nn.AvgPool2d((1, side), 1, (0, side // 2), count_include_pad=False)
    return nn.Sequential(columns, rows)


class Pyramid(nn.Module):
    """Means over several neighbourhoods beside the features themselves (pyramid pooling)."""

    def __init__(self, width: int, sides: tuple[int, ...]) -> None:
        super().__init__()
        self.branches = nn.ModuleList(
            conv(width, width // 4, 1).append(window_mean(side)) for side in sides
        )
        self.join = conv(width + len(sides) * (width // 4), width, 1)

    def forward(self, x: Tensor) -> Tensor:
        return self.join(torch.cat([x, *(branch(x) for branch in self.branches)], 1))
