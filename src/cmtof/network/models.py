"""Networks that unwrap: the paper's (Fig. 5), the rows of Table 1, and the learned baselines.

Layers follow the published articles. Sizes are our reading (the paper's stand in a supplement that
could not be obtained); the baselines are narrowed to about the 1.2 million weights of the paper's
own network.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU
from cmtof.network.features import CHANNELS, CLASSES, FEATURE_SETS, channels

BEAT = TAU * (FREQUENCIES[1] / FREQUENCIES[0] - 2)
"""Change of the beat ``phi_2 - 2 phi_1`` from one wrap of the lower frequency to the next, rad."""

# --- blocks --------------------------------------------------------------------------------------


def conv(i: int, o: int, kernel: int = 3, stride: int = 1, relu: bool = True, **more: int):
    """Convolution, batch norm, ReLU."""
    padding = more.get("dilation", 1) * (kernel // 2)
    layer = nn.Conv2d(i, o, kernel, stride, padding, bias=False, **more)
    return nn.Sequential(layer, nn.BatchNorm2d(o), *([nn.ReLU(inplace=True)] if relu else []))


def separable(i: int, o: int, stride: int = 1) -> nn.Sequential:
    """Depthwise separable convolution."""
    return nn.Sequential(conv(i, i, 3, stride, groups=i), conv(i, o, 1))


def resized(x: Tensor, like: Tensor) -> Tensor:
    """Image at the size of another, bilinear, pixel centres at +0.5."""
    return functional.interpolate(x, size=like.shape[-2:], mode="bilinear", align_corners=False)


class Bottleneck(nn.Module):
    """Inverted residual of MobileNetV2: widen, convolve each channel, narrow, add."""

    def __init__(self, i: int, o: int, stride: int, expansion: int) -> None:
        super().__init__()
        wide = expansion * i
        middle = conv(wide, wide, 3, stride, groups=wide)
        self.body = nn.Sequential(conv(i, wide, 1), middle, conv(wide, o, 1, relu=False))
        self.residual = stride == 1 and i == o

    def forward(self, x: Tensor) -> Tensor:
        return x + self.body(x) if self.residual else self.body(x)


class Residual(nn.Module):
    """Two convolutions, added to their input (He et al. 2016)."""

    def __init__(self, i: int, o: int, stride: int = 1) -> None:
        super().__init__()
        self.body = nn.Sequential(conv(i, o, stride=stride), conv(o, o, relu=False))
        same = stride == 1 and i == o
        self.shortcut = nn.Identity() if same else conv(i, o, 1, stride, relu=False)

    def forward(self, x: Tensor) -> Tensor:
        return functional.relu(self.body(x) + self.shortcut(x))


class Pyramid(nn.Module):
    """Means over several neighbourhoods beside the features themselves (pyramid pooling)."""

    def __init__(self, width: int, pools: tuple[int, ...]) -> None:
        super().__init__()
        self.pools = pools
        self.branches = nn.ModuleList(conv(width, width // 4, 1) for _ in pools)
        self.join = conv(width + len(pools) * (width // 4), width, 1)

    def forward(self, x: Tensor) -> Tensor:
        means = (
            functional.avg_pool2d(branch(x), side, 1, side // 2, count_include_pad=False)
            for side, branch in zip(self.pools, self.branches, strict=True)
        )
        return self.join(torch.cat([x, *means], 1))


# --- networks ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Model:
    """A network by name: its inputs, out of `FEATURE_SETS`, and the weights of its loss.

    ``depth_weight`` is w of Eq. 7; ``smoothness`` weighs the gradient of a regressed depth;
    `cmtof.network.weights.mended` follows where ``mend`` is set.
    """

    network: "type[Network]"
    features: str = "proposed"
    depth_weight: float = 0.1
    smoothness: float = 0.0
    mend: bool = False


class Network(nn.Module):
    """Network from features (B, C, H, W) of any size to weights of classes (B, N, H, W).

    For the target ``"depth"`` it gives turns (B, 1, H, W) instead: depth in wraps of the lower
    frequency above the first class. ``stride`` is that of the coarsest features, px, ``reach`` how
    far an output pixel sees, a multiple of the stride.
    """

    target = "wraps"
    stride = reach = 1

    def __init__(self, model: Model, classes: int) -> None:
        super().__init__()
        self.model, self.inputs, self.classes = model, channels(model.features), classes
        self.outputs = classes if self.target == "wraps" else 1
        self.build()

    def build(self) -> None:
        """Make the layers."""

    def body(self, x: Tensor) -> Tensor:
        """Output for sides that are multiples of the stride."""
        raise NotImplementedError

    def forward(self, x: Tensor) -> Tensor:
        height, width = x.shape[-2:]
        # two pixels at least: in training a batch norm needs more than one value
        more = [max(-(-size // self.stride), 2) * self.stride - size for size in (height, width)]
        if any(more):
            x = functional.pad(x, (0, more[1], 0, more[0]), mode="replicate")
        found = self.body(x)[..., :height, :width]
        # 358 wraps need more than the 8 bits of bfloat16
        return found if self.target == "wraps" else self.classes * (0.5 + found.float())


class FastSCNN(Network):
    """Modified Fast-SCNN (Sec. 5.1, Fig. 5; Poudel et al. 2019).

    The stem at full resolution goes to the output as well (the paper's skip); pools are local, so
    that the receptive field is narrower than the original's, which pools over the whole image.
    """

    stride, reach = 8, 160
    stem_width, head_width = 32, 64  # at full resolution
    down_widths = 48, 64  # at 1/2 and 1/4
    widths, repeats, expansion = (64, 96, 128), 3, 6  # bottlenecks at 1/8
    pools = 3, 5, 9, 17  # sides, px at 1/8
    context = 128  # fused features, at 1/4

    def build(self) -> None:
        half, quarter = self.down_widths
        self.stem = conv(self.inputs, self.stem_width)
        self.down = nn.Sequential(conv(self.stem_width, half, 3, 2), separable(half, quarter, 2))
        stages, i = [], quarter
        for o in np.repeat(self.widths, self.repeats).tolist():
            stages.append(Bottleneck(i, o, 1 if stages else 2, self.expansion))
            i = o
        self.extract = nn.Sequential(*stages)
        self.pyramid = Pyramid(i, self.pools)
        self.deep = conv(i, self.context, 1, relu=False)
        self.fine = conv(quarter, self.context, 1, relu=False)
        fused = [separable(self.context, self.context) for _ in range(2)]
        narrow = nn.Conv2d(self.context, self.head_width, 1, bias=False)
        self.classify = nn.Sequential(*fused, narrow)
        self.skip = nn.Conv2d(self.stem_width, self.head_width, 3, padding=1, bias=False)
        self.norm = nn.BatchNorm2d(self.head_width)
        self.output = nn.Conv2d(self.head_width, self.outputs, 1)

    def body(self, x: Tensor) -> Tensor:
        skip = self.stem(x)  # (B, 32, H, W)
        down = self.down(skip)  # (B, 64, H/4, W/4)
        deep = self.deep(self.pyramid(self.extract(down)))  # (B, 128, H/8, W/8)
        context = self.classify(functional.relu(resized(deep, down) + self.fine(down)))
        return self.output(functional.relu(self.norm(resized(context, skip) + self.skip(skip))))

    @torch.no_grad()
    def see_the_beat(self, first: int) -> None:
        r"""Initialise half of the stem, and a path to the pyramid, so that the beat is seen.

        .. math:: |\cos(\varphi_2 + \alpha) - \cos(2\varphi_1 + \alpha + \beta)|
                  = 2\,|\sin\tfrac{b - \beta}{2}|\;|\sin(\ldots)|, \quad
                  b = \varphi_2 - 2\varphi_1

        Both cosines are octaves of Eq. 5, and the mean of the rectified differences over angles
        alpha depends on the beat b alone. beta lies a quarter turn below and above the middle of
        the range, or at four places where the range is a whole turn.
        """
        quarters = (1, -1) if self.classes * BEAT < TAU / 2 else (0, 1, 2, 3)
        angles = self.stem_width // 2 // len(quarters)
        # large: norms divide it out again, and steps of the optimiser, as long for every weight,
        # disturb the sums less
        count, large, kinds = angles * len(quarters), 8.0, FEATURE_SETS[self.model.features]
        alpha = TAU / angles * torch.arange(angles)
        middle = BEAT * (first + self.classes / 2)
        moved = torch.cat([alpha + (middle + TAU / 4 * quarter) for quarter in quarters])
        alpha = alpha.repeat(len(quarters))
        low = 2 * sum(CHANNELS[kind] for kind in kinds[: kinds.index("fourier")])
        octaves = [low + CHANNELS["fourier"], low + CHANNELS["fourier"] + 1, low + 2, low + 3]
        filters = torch.stack([alpha.cos(), -alpha.sin(), -moved.cos(), moved.sin()], 1)
        self.stem[0].weight[:count] = 0
        self.stem[0].weight[:count, octaves, 1, 1] = large * filters
        # eight channels for the sums over alpha and their differences
        sums = torch.eye(len(quarters)).repeat_interleave(angles, 1) * (large / (2 * angles))
        sums = torch.cat([sums, sums - sums.roll(1, 0)]).repeat(4 // len(quarters), 1)
        (enter, norm, _), *path = self.down[0], *self.down[1], *self.pyramid.branches
        enter.weight[:8] = 0
        enter.weight[:8, :count], norm.bias[:8] = sums[..., None, None], 2.0
        # from there on each goes alone, averaged, two spreads above the ReLU's corner
        for block in self.extract:
            if block.residual:
                block.body[-1][1].weight.zero_()
            else:
                path += block.body
        for kernel, norm, *relu in path:
            kernel.weight[:8] = 0
            for k in range(8):
                kernel.weight[k, 0 if kernel.groups > 1 else k] = large / kernel.kernel_size[0]
            norm.bias[:8] = 2.0 if relu else 0.0


class LightFastSCNN(FastSCNN):
    """A tenth of the weights."""

    stem_width, head_width, context = 16, 32, 64
    down_widths = 24, 32
    widths, repeats, expansion = (48, 64), 2, 3


class UNet(Network):
    """U-Net (Ronneberger, Fischer and Brox 2015; 64 to 1024 wide there), with batch norms."""

    stride, reach = 16, 192
    widths = 24, 48, 72, 104, 128

    def build(self) -> None:
        steps = list(pairwise(self.widths))
        levels = pairwise((self.inputs, *self.widths))
        self.down = nn.ModuleList(self.level(i, o) for i, o in levels)
        self.rise = nn.ModuleList(nn.ConvTranspose2d(o, i, 2, 2) for i, o in reversed(steps))
        self.up = nn.ModuleList(self.level(2 * i, i) for i, _ in reversed(steps))
        self.output = nn.Conv2d(self.widths[0], self.outputs, 1)

    def level(self, i: int, o: int) -> nn.Module:
        """Layers at one resolution, on the way down or up."""
        return nn.Sequential(conv(i, o), conv(o, o))

    def body(self, x: Tensor) -> Tensor:
        skips: list[Tensor] = []
        for level in self.down:
            x = level(functional.max_pool2d(x, 2) if skips else x)
            skips.append(x)
        x = skips.pop()
        for rise, level in zip(self.rise, self.up, strict=True):
            x = level(torch.cat([skips.pop(), rise(x)], 1))
        return self.output(x)


class OneStep(UNet):
    """One-step unwrapping (Wang, Li, Kemao, Di and Zhao 2019): a residual U-Net that regresses.

    A regression answers with neither of two likely wraps but with what lies between them.
    """

    target, reach = "depth", 256
    widths = 16, 32, 56, 72, 96

    def level(self, i: int, o: int) -> nn.Module:
        return nn.Sequential(conv(i, o), Residual(o, o), conv(o, o))


class DeepToF(Network):
    """Deep end-to-end time of flight (Su, Heide, Wetzstein and Heidrich 2018): raw to depth.

    Encoder, residual blocks at a quarter of the resolution, decoder with added skips. Theirs reads
    two correlations at each of two frequencies, ours four; its adversarial loss is left out.
    """

    target, stride, reach = "depth", 4, 96
    widths, blocks, kernel = (16, 32, 80), 9, 7

    def build(self) -> None:
        steps, last = list(pairwise(self.widths)), self.widths[-1]
        self.stem = conv(self.inputs, self.widths[0], self.kernel)
        self.down = nn.ModuleList(conv(i, o, stride=2) for i, o in steps)
        self.middle = nn.Sequential(*(Residual(last, last) for _ in range(self.blocks)))
        self.up = nn.ModuleList(
            nn.Sequential(nn.ConvTranspose2d(o, i, 4, 2, 1), nn.BatchNorm2d(i), nn.ReLU())
            for i, o in reversed(steps)
        )
        self.output = nn.Conv2d(self.widths[0], 1, self.kernel, padding=self.kernel // 2)

    def body(self, x: Tensor) -> Tensor:
        x, skips = self.stem(x), []
        for down in self.down:
            skips.append(x)
            x = down(x)
        x = self.middle(x)
        for up in self.up:
            x = up(x) + skips.pop()
        return self.output(x)


class Rapid(Network):
    """Rapid and robust unwrapping (Zhang, Jiang, Zhao et al. 2019): DeepLabV3+ on a ResNet.

    The paper calls its "Zhang et al. 2019" a regression; two articles of that year fit the name,
    and this one segments. Its published code was not available. The mean over the image is one over
    each band where a large image is unwrapped in bands.
    """

    stride, reach = 16, 448
    backbone, pyramid, skip_width, decoder_width = (32, 48, 80, 112), 80, 24, 64

    def build(self) -> None:
        wide, last, width = self.pyramid, self.backbone[-1], self.decoder_width
        self.stem = conv(self.inputs, self.backbone[0], stride=2)
        stages = [
            nn.Sequential(Residual(i, o, stride=2), Residual(o, o))
            for i, o in pairwise(self.backbone)
        ]
        self.fine, self.coarse = stages[0], nn.Sequential(*stages[1:])
        self.near = conv(last, wide, 1)
        self.far = nn.ModuleList(conv(last, wide, dilation=rate) for rate in (6, 12, 18))
        self.whole = nn.Conv2d(last, wide, 1)  # one pixel of one crop bears no norm
        self.join = conv(5 * wide, wide, 1)
        self.skip = conv(self.backbone[1], self.skip_width, 1)
        self.decoder = nn.Sequential(conv(wide + self.skip_width, width), conv(width, width))
        self.output = nn.Conv2d(width, self.outputs, 1)

    def body(self, x: Tensor) -> Tensor:
        fine = self.fine(self.stem(x))
        deep = self.coarse(fine)
        mean = functional.relu(self.whole(deep.mean((-2, -1), keepdim=True)))
        branches = [self.near(deep), *(far(deep) for far in self.far)]
        atrous = self.join(torch.cat([*branches, mean.expand_as(branches[0])], 1))
        decoded = self.decoder(torch.cat([resized(atrous, fine), self.skip(fine)], 1))
        return self.output(resized(decoded, x))


MODELS = {
    "fast-scnn": Model(FastSCNN),
    "fast-scnn-ce": Model(FastSCNN, depth_weight=0.0),
    "fast-scnn-fourier": Model(FastSCNN, "fourier"),
    "fast-scnn-phase": Model(FastSCNN, "phase"),
    "fast-scnn-light": Model(LightFastSCNN, "beat"),
    "u-net": Model(UNet, "phase", 0.0),
    "one-step": Model(OneStep, "phase"),
    "deep-tof": Model(DeepToF, "correlation", smoothness=1e-4),
    "rapid": Model(Rapid, "phase", 0.0, mend=True),
}
"""The rows of Table 1, one that costs less, and the paper's learned baselines."""


def build_network(name: str, protocol: str = "released") -> Network:
    """Network of a model with fresh weights; a stem that reads Fourier features sees the beat.

    Examples
    --------
    >>> sum(weight.numel() for weight in build_network("fast-scnn").parameters())
    1183493
    """
    model, (first, classes) = MODELS[name], CLASSES[protocol]
    network = model.network(model, classes)
    if isinstance(network, FastSCNN) and "fourier" in FEATURE_SETS[model.features]:
        network.see_the_beat(first)
    return network
