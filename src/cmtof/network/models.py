"""Networks that unwrap: the paper's (Fig. 5), the rows of Table 1, and the learned baselines.

Layers follow the published articles; sizes are our reading where none are published (the paper's
stand in a supplement that could not be obtained), and the baselines are narrowed to about the 1.2
million weights of the paper's own network.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, wrap_length
from cmtof.measurement import unambiguous_range
from cmtof.network.features import FEATURE_SETS, channels
from cmtof.simulation import RELEASED_WRAPS

BEAT = TAU * (FREQUENCIES[1] / FREQUENCIES[0] - 2)
"""Change of the beat ``phi_2 - 2 phi_1`` from one wrap of the lower frequency to the next, rad."""


def wraps_of(protocol: str) -> tuple[int, int]:
    """First wrap that a protocol distinguishes, and how many: its classes.

    Raises
    ------
    ValueError
        For an unknown protocol.

    Examples
    --------
    >>> wraps_of("released"), wraps_of("full")
    ((36, 21), (0, 358))
    """
    if protocol == "released":
        return RELEASED_WRAPS[0], RELEASED_WRAPS[1] - RELEASED_WRAPS[0]
    if protocol == "full":
        return 0, int(np.ceil(unambiguous_range(FREQUENCIES) / wrap_length(FREQUENCIES[0])))
    raise ValueError(f"Expected protocol 'released' or 'full', got {protocol!r}. Choose one.")


# --- blocks --------------------------------------------------------------------------------------


def conv(
    i: int, o: int, kernel: int = 3, stride: int = 1, *, groups: int = 1, dilation: int = 1,
    relu: bool = True,
) -> nn.Sequential:  # fmt: skip
    """Convolution, batch norm, ReLU."""
    padding = dilation * (kernel // 2)
    layer = nn.Conv2d(i, o, kernel, stride, padding, dilation, groups=groups, bias=False)
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
        self.body = nn.Sequential(
            conv(i, wide, 1), conv(wide, wide, 3, stride, groups=wide), conv(wide, o, 1, relu=False)
        )
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


class Network(nn.Module):
    """Network from features (B, C, H, W) of any size to weights of classes (B, N, H, W).

    For the target ``"depth"`` it gives turns (B, 1, H, W) instead: depth in wraps of the lower
    frequency above the first class.

    Attributes
    ----------
    stride : int
        Of the coarsest features, px; images are padded to a multiple by repeating their border.
    reach : int
        Distance that an output pixel sees, px, a multiple of the stride.
    """

    stride = 1
    reach = 0

    def __init__(self, inputs: int, classes: int, target: str) -> None:
        super().__init__()
        self.inputs, self.classes, self.target = inputs, classes, target
        self.outputs = classes if target == "wraps" else 1

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

    Parameters
    ----------
    stem : int
        Channels at full resolution.
    down : (int, int)
        Channels of the learning to down-sample, at 1/2 and 1/4.
    widths, repeats, expansion
        Bottlenecks of the global feature extractor at 1/8: channels, blocks each, widening.
    pools : tuple of int
        Sides of the pyramid's pools, px at 1/8.
    context, head : int
        Channels of the fused features at 1/4, and of the last layer.
    """

    stride, reach = 8, 160

    def __init__(
        self, inputs: int, classes: int, target: str = "wraps", *, stem: int = 32,
        down: tuple[int, int] = (48, 64), widths: tuple[int, ...] = (64, 96, 128), repeats: int = 3,
        expansion: int = 6, pools: tuple[int, ...] = (3, 5, 9, 17), context: int = 128,
        head: int = 64,
    ) -> None:  # fmt: skip
        super().__init__(inputs, classes, target)
        self.stem = conv(inputs, stem)
        self.down = nn.Sequential(conv(stem, down[0], 3, 2), separable(down[0], down[1], 2))
        stages, i = [], down[1]
        for stage, width in enumerate(widths):
            for block in range(repeats):
                stages.append(Bottleneck(i, width, 2 if stage == block == 0 else 1, expansion))
                i = width
        self.extract = nn.Sequential(*stages)
        self.pyramid = Pyramid(i, pools)
        self.deep = conv(i, context, 1, relu=False)
        self.fine = conv(down[1], context, 1, relu=False)
        narrow = nn.Conv2d(context, head, 1, bias=False)
        self.classify = nn.Sequential(
            separable(context, context), separable(context, context), narrow
        )
        self.skip = nn.Conv2d(stem, head, 3, padding=1, bias=False)
        self.norm = nn.BatchNorm2d(head)
        self.output = nn.Conv2d(head, self.outputs, 1)

    def body(self, x: Tensor) -> Tensor:
        skip = self.stem(x)  # (B, 32, H, W)
        down = self.down(skip)  # (B, 64, H/4, W/4)
        deep = self.deep(self.pyramid(self.extract(down)))  # (B, 128, H/8, W/8)
        context = self.classify(functional.relu(resized(deep, down) + self.fine(down)))
        return self.output(functional.relu(self.norm(resized(context, skip) + self.skip(skip))))

    @torch.no_grad()
    def see_the_beat(self, features: str, first: int) -> None:
        r"""Initialise half of the stem's filters so that the beat can be read after the ReLU.

        .. math:: |\cos(\varphi_2 + \alpha) - \cos(2\varphi_1 + \alpha + \beta)|
                  = 2\,|\sin\tfrac{b - \beta}{2}|\;|\sin(\ldots)|, \quad
                  b = \varphi_2 - 2\varphi_1

        Both cosines are linear in the octaves of Eq. 5. Over eight angles alpha the mean of the
        rectified differences depends on the beat b alone: at two beta a quarter turn below and
        above the middle of the range, at four all round where the range is a whole turn.
        """
        weight = self.stem[0].weight
        half, span = weight.shape[0] // 2, self.classes * BEAT
        low = channels(features, before="fourier")  # cos, sin of phi_1, 2 phi_1, 4 phi_1, ...
        high = low + (channels("fourier") - channels("phase")) // 2
        quarters = (1, -1) if span < TAU / 2 else (0, 1, 2, 3)
        kernel = torch.tensor([1.0, 2.0, 1.0]).outer(torch.tensor([1.0, 2.0, 1.0])) * 3**0.5 / 16
        weight[:half] = 0
        for k in range(half):
            angles = half // len(quarters)
            alpha = TAU * (k % angles) / angles
            beta = BEAT * (first + self.classes / 2) + TAU / 4 * quarters[k // angles]
            weight[k, high] = float(np.cos(alpha)) * kernel
            weight[k, high + 1] = -float(np.sin(alpha)) * kernel
            weight[k, low + 2] = -float(np.cos(alpha + beta)) * kernel
            weight[k, low + 3] = float(np.sin(alpha + beta)) * kernel


class UNet(Network):
    """U-Net (Ronneberger, Fischer and Brox 2015) with same-size convolutions and batch norms.

    Published widths: 64 to 1024.
    """

    stride, reach = 16, 192

    def __init__(
        self, inputs: int, classes: int, target: str = "wraps", *,
        widths: tuple[int, ...] = (24, 48, 72, 104, 128),
    ) -> None:  # fmt: skip
        super().__init__(inputs, classes, target)
        steps = list(pairwise(widths))
        self.down = nn.ModuleList(self.level(i, o) for i, o in pairwise((inputs, *widths)))
        self.rise = nn.ModuleList(nn.ConvTranspose2d(o, i, 2, 2) for i, o in reversed(steps))
        self.up = nn.ModuleList(self.level(2 * i, i) for i, _ in reversed(steps))
        self.output = nn.Conv2d(widths[0], self.outputs, 1)

    @staticmethod
    def level(i: int, o: int) -> nn.Module:
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

    reach = 256

    def __init__(
        self, inputs: int, classes: int, target: str = "depth", *,
        widths: tuple[int, ...] = (16, 32, 56, 72, 96),
    ) -> None:  # fmt: skip
        super().__init__(inputs, classes, target, widths=widths)

    @staticmethod
    def level(i: int, o: int) -> nn.Module:
        """Convolution, residual block, convolution."""
        return nn.Sequential(conv(i, o), Residual(o, o), conv(o, o))


class DeepToF(Network):
    """Deep end-to-end time of flight (Su, Heide, Wetzstein and Heidrich 2018): raw to depth.

    Encoder, residual blocks at a quarter of the resolution, decoder with added skips. Theirs reads
    two correlations at each of two frequencies, ours four; its adversarial loss is left out.
    """

    stride, reach = 4, 96

    def __init__(
        self, inputs: int, classes: int, target: str = "depth", *,
        widths: tuple[int, ...] = (16, 32, 80), blocks: int = 9, kernel: int = 7,
    ) -> None:  # fmt: skip
        super().__init__(inputs, classes, target)
        steps = list(pairwise(widths))
        self.stem = conv(inputs, widths[0], kernel)
        self.down = nn.ModuleList(conv(i, o, stride=2) for i, o in steps)
        self.middle = nn.Sequential(*(Residual(widths[-1], widths[-1]) for _ in range(blocks)))
        self.up = nn.ModuleList(
            nn.Sequential(
                nn.ConvTranspose2d(o, i, 4, 2, 1, bias=False), nn.BatchNorm2d(i), nn.ReLU()
            )
            for i, o in reversed(steps)
        )
        self.output = nn.Conv2d(widths[0], self.outputs, kernel, padding=kernel // 2)

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
    and this one segments. Its published code was not available. `mended` is its last step. The mean
    over the image is one over each band where a large image is unwrapped in bands.
    """

    stride, reach = 16, 448

    def __init__(
        self, inputs: int, classes: int, target: str = "wraps", *,
        backbone: tuple[int, ...] = (32, 48, 80, 112), blocks: int = 2,
        rates: tuple[int, ...] = (6, 12, 18), pyramid: int = 80, skip: int = 24, decoder: int = 64,
    ) -> None:  # fmt: skip
        super().__init__(inputs, classes, target)

        def stage(i: int, o: int) -> nn.Sequential:
            more = (Residual(o, o) for _ in range(blocks - 1))
            return nn.Sequential(Residual(i, o, stride=2), *more)

        self.stem = conv(inputs, backbone[0], stride=2)
        self.fine, *coarse = (stage(i, o) for i, o in pairwise(backbone))
        self.coarse = nn.Sequential(*coarse)
        self.near = conv(backbone[-1], pyramid, 1)
        self.far = nn.ModuleList(conv(backbone[-1], pyramid, dilation=rate) for rate in rates)
        self.whole = nn.Conv2d(backbone[-1], pyramid, 1)
        self.join = conv((len(rates) + 2) * pyramid, pyramid, 1)
        self.skip = conv(backbone[1], skip, 1)
        self.decoder = nn.Sequential(conv(pyramid + skip, decoder), conv(decoder, decoder))
        self.output = nn.Conv2d(decoder, self.outputs, 1)

    def body(self, x: Tensor) -> Tensor:
        fine = self.fine(self.stem(x))
        deep = self.coarse(fine)
        mean = functional.relu(self.whole(deep.mean((-2, -1), keepdim=True)))
        branches = [self.near(deep), *(far(deep) for far in self.far)]
        atrous = self.join(torch.cat([*branches, mean.expand_as(branches[0])], 1))
        decoded = self.decoder(torch.cat([resized(atrous, fine), self.skip(fine)], 1))
        return self.output(resized(decoded, x))


def mended(
    wraps: NDArray[np.integer], phase: NDArray[np.floating], side: int = 5
) -> NDArray[np.int64]:
    r"""Wraps by the vote of their neighbourhood, consistent with the wrapped phase.

    Each neighbour q votes for :math:`n_q + \mathrm{round}((\hat\varphi_q - \hat\varphi_p)/2\pi)`:
    on a surface whose phase is continuous all votes agree, on both sides of a wrap line. Among
    equals the lowest wins.

    Parameters
    ----------
    wraps, phase : ndarray, shape (H, W)
        Wrap counts, and the measured wrapped phase they belong to, rad, finite.
    side : int
        Of the neighbourhood, odd, px.

    Examples
    --------
    >>> mended(np.array([[3, 9, 4]]), np.array([[5.9, 6.1, 0.1]]), 5).tolist()
    [[3, 3, 4]]
    """
    turns, pad = np.asarray(phase) / TAU, side // 2
    around = [np.pad(np.asarray(a, float), pad, constant_values=np.nan) for a in (wraps, turns)]
    height, width = turns.shape
    votes = np.stack([
        n[y : y + height, x : x + width] + np.rint(t[y : y + height, x : x + width] - turns)
        for n, t in [around] for y in range(side) for x in range(side)
    ])  # fmt: skip
    count = np.stack([(votes == vote).sum(0) for vote in votes])
    leading = count == count.max(0)
    return np.where(leading, votes, np.inf).min(0).astype(np.int64)


# --- models --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Model:
    """A network by name: its inputs, its sizes and what it is trained for.

    Attributes
    ----------
    summary : str
    network : type
    features : str
        Out of `cmtof.network.features.FEATURE_SETS`.
    sizes : dict
        Differences from the network's default sizes.
    target : {"wraps", "depth"}
        Classes of wraps, or a regression of depth.
    depth_weight : float
        w of Eq. 7, for wraps.
    smoothness : float
        Weight of the depth's gradient, for depth.
    mended : bool
        Whether `mended` follows.
    """

    summary: str
    network: Callable[..., Network] = FastSCNN
    features: str = "proposed"
    sizes: Mapping[str, Any] = field(default_factory=dict)
    target: Literal["wraps", "depth"] = "wraps"
    depth_weight: float = 0.1
    smoothness: float = 0.0
    mended: bool = False


LIGHT = {"stem": 16, "down": (24, 32), "widths": (48, 64), "repeats": 2, "expansion": 3}

MODELS = {
    "fast-scnn": Model("the paper's network: Fourier features, edges, both losses"),
    "fast-scnn-ce": Model("the paper's network without the loss on depth", depth_weight=0.0),
    "fast-scnn-fourier": Model("the paper's network without phase edges", features="fourier"),
    "fast-scnn-phase": Model("the paper's network on phases and amplitudes", features="phase"),
    "fast-scnn-light": Model(
        "a lighter network that is given the beat of the two phases",
        features="beat",
        sizes=LIGHT | {"context": 64, "head": 32},
    ),
    "u-net": Model("U-Net on phases and amplitudes", UNet, "phase", depth_weight=0.0),
    "one-step": Model("residual U-Net that regresses depth", OneStep, "phase", target="depth"),
    "deep-tof": Model(
        "encoder and decoder from raw correlations to depth",
        DeepToF, "correlation", target="depth", smoothness=1e-4,
    ),
    "rapid": Model(
        "DeepLabV3+ on phases and amplitudes, wraps mended afterwards",
        Rapid, "phase", depth_weight=0.0, mended=True,
    ),
}  # fmt: skip
"""The rows of Table 1, one that costs less, and the paper's learned baselines."""


def build_network(name: str, classes: int, first: int | None = None) -> Network:
    """Network of a model out of `MODELS`, with fresh weights.

    With the wrap of the first class, a stem that reads Fourier features is initialised by
    `FastSCNN.see_the_beat`.

    Examples
    --------
    >>> sum(weight.numel() for weight in build_network("fast-scnn", 21).parameters())
    1183493
    """
    model = MODELS[name]
    network = model.network(channels(model.features), classes, model.target, **model.sizes)
    if first is not None and "fourier" in FEATURE_SETS[model.features]:
        network.see_the_beat(model.features, first)
    return network
