"""Networks that unwrap: the paper's (Fig. 5), its variants in Table 1, learned baselines.

Layers follow the articles; sizes are our reading, 1.1 to 1.2 million weights, a tenth if light.
"""

from itertools import pairwise
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from cmtof.constants import FREQUENCY_DOUBLED, FREQUENCY_SINGLE
from cmtof.correlation import TAU
from cmtof.network.features import CLASSES, FEATURE_SETS, channels, padding
from cmtof.network.layers import (
    Bottleneck,
    NormedConv,
    Pyramid,
    Residual,
    conv,
    resize_like,
    scale_and_offset,
    separable,
)
from cmtof.network.public import PublicPyramid

# Change of the beat `phi_2 - 2 phi_1` from one wrap of the lower frequency to the next, rad.
BEAT = TAU * (FREQUENCY_DOUBLED / FREQUENCY_SINGLE - 2)

# Factor of those first filters: norms divide it out, and the optimiser disturbs the sums less.
LARGE = 8.0


class Model(NamedTuple):
    """Class of a network, name of its set of features, and weights of its loss."""

    network: "type[Network]"
    features: str = "proposed"
    depth_weight: float = 0.1  # w of Eq. 7
    smoothness: float = 0.0  # weight of a regressed depth's gradient


class Network(nn.Module):
    """Network from features (B, C, H, W) of any size to weights of classes (B, N, H, W).

    For the target ``"depth"`` to depth (B, 1, H, W), wraps above the first class; ``stride`` that
    of the coarsest features, px, ``reach`` how far a pixel sees, a multiple of the stride. Most end
    with a layer ``output``, which reads the images of `before_output`.
    """

    target = "wraps"
    stride = reach = 1

    def __init__(self, model: Model, classes: int) -> None:
        super().__init__()
        self.model = model
        self.inputs = channels(model.features)
        self.classes = classes
        self.outputs = classes if self.target == "wraps" else 1
        self.build()

    def build(self) -> None: ...

    def body(self, x: Tensor) -> Tensor:
        return self.output(self.before_output(x))  # pyright: ignore[reportCallIssue]

    def before_output(self, x: Tensor) -> Tensor: ...

    def forward(self, x: Tensor) -> Tensor:
        height, width = x.shape[-2:]
        more = [padding(size, self.stride) for size in (height, width)]
        if any(more):
            x = functional.pad(x, (0, more[1], 0, more[0]), mode="replicate")
        found = self.body(x)[..., :height, :width]
        # 358 wraps need more than the 8 bits of bfloat16
        return found if self.target == "wraps" else self.classes * (0.5 + found.float())


class FastSCNN(Network):
    """Modified Fast-SCNN (Sec. 5.1, Fig. 5; Poudel et al. 2019).

    The stem goes to the output as well (the paper's skip); pools are local, not over the image.
    """

    stride = 8
    reach = 256
    stem_width = 32  # at full resolution
    head_width = 64
    down_widths = 48, 64  # at 1/2 and 1/4
    widths = 64, 64, 64, 96, 96, 96, 128, 128, 128  # of bottlenecks at 1/8
    expansion = 6  # within them
    # so that they see farther, as theirs do at 1/32
    dilations = 1, 1, 1, 1, 1, 1, 1, 2, 4
    pools = 3, 5, 9, 17, 33  # sides of windows at 1/8
    context = 128  # fused features, at 1/4

    def build(self) -> None:
        half, quarter = self.down_widths
        self.stem = conv(self.inputs, self.stem_width)
        self.down = nn.Sequential(
            conv(self.stem_width, half, stride=2), separable(half, quarter, 2)
        )
        pairs = enumerate(pairwise((quarter, *self.widths)))
        self.extract = nn.Sequential(
            *(
                Bottleneck(i, o, 1 if k else 2, self.expansion, self.dilations[k])
                for k, (i, o) in pairs
            )
        )
        deep = self.widths[-1]
        self.pyramid = Pyramid(deep, self.pools)
        self.deep = conv(deep, self.context, 1, relu=False)
        self.fine = conv(quarter, self.context, 1, relu=False)
        self.classify = nn.Sequential(
            separable(self.context, self.context),
            separable(self.context, self.context),
            nn.Conv2d(self.context, self.head_width, 1, bias=False),
        )
        self.skip = nn.Conv2d(
            self.stem_width, self.head_width, 3, padding=1, bias=False
        )
        self.norm = nn.BatchNorm2d(self.head_width)
        self.output = nn.Conv2d(self.head_width, self.outputs, 1)

    def before_output(self, x: Tensor) -> Tensor:
        skip = self.stem(x)  # (B, 32, H, W)
        down = self.down(skip)  # (B, 64, H/4, W/4)
        deep = self.deep(self.pyramid(self.extract(down)))  # (B, 128, H/8, W/8)
        context = self.classify(
            functional.relu(resize_like(deep, down) + self.fine(down))
        )
        if self.norm.training:
            return functional.relu(
                self.norm(resize_like(context, skip) + self.skip(skip))
            )
        # the norm goes into both summands
        scale, offset = (x.view(-1, 1, 1, 1) for x in scale_and_offset(self.norm))
        context = (context * scale[..., 0] + offset[..., 0]).to(context.dtype)
        fine = self.skip._conv_forward(skip, self.skip.weight * scale, None)
        return functional.relu_(fine.add_(resize_like(context, skip)))

    @torch.no_grad()
    def see_the_beat(self, first: int) -> None:
        r"""Set half of the stem, and a path to the pyramid, so that they compute the beat.

        Means of :math:`|\cos(\varphi_2 + \alpha) - \cos(2\varphi_1 + \alpha + \beta)|` over alpha
        depend on the beat alone. beta lies a quarter turn below and above the middle of the range,
        or at four places where the range is a whole turn.
        """
        quarters = (1, -1) if self.classes * BEAT < TAU / 2 else (0, 1, 2, 3)
        middle = BEAT * (first + self.classes / 2)
        self._set_beat_filters([middle + TAU / 4 * quarter for quarter in quarters])
        self._pass_beat_on(len(quarters))
        if len(quarters) > 2:
            self._set_smooth_output()

    def _set_beat_filters(self, betas: list[float]) -> None:
        """Set half of the stem's filters: for each beta, rad, as many angles alpha."""
        angles = self.stem_width // 2 // len(betas)
        alpha = TAU / angles * torch.arange(angles)
        moved = torch.cat([alpha + beta for beta in betas])
        alpha = alpha.repeat(len(betas))
        filters = torch.stack([alpha.cos(), -alpha.sin(), -moved.cos(), moved.sin()], 1)
        weight = self.stem.get_parameter("0.weight")
        weight[: len(filters)] = 0
        # octaves, after two phases
        weight[: len(filters), [14, 15, 4, 5], 1, 1] = LARGE * filters

    def _pass_beat_on(self, places: int) -> None:
        """Pass the sums over alpha and their differences through eight channels to the pyramid."""
        angles = self.stem_width // 2 // places
        sums = torch.eye(places).repeat_interleave(angles, 1) * (LARGE / (2 * angles))
        sums = torch.cat([sums, sums - sums.roll(1, 0)]).repeat(4 // places, 1)
        weight = self.down.get_parameter("0.0.weight")
        weight[:8] = 0
        weight[:8, : sums.shape[1]] = sums[..., None, None]
        self.down.get_parameter("0.1.bias")[:8] = 2.0
        # from there on each goes alone, averaged, two spreads above the ReLU's corner
        path = [*self.down[1], *self.pyramid.branches]  # pyright: ignore[reportGeneralTypeIssues]
        for block in self.extract:
            if block.residual:
                block.get_parameter("body.2.1.weight").zero_()
            else:
                path += block.body  # pyright: ignore[reportOperatorIssue]
        for kernel, norm, *relu in path:
            kernel.weight[:8] = 0
            size = kernel.kernel_size[0]
            for k in range(8):
                kernel.weight[k, 0 if kernel.groups > 1 else k] = LARGE / size
            norm.bias[:8] = 2.0 if relu else 0.0

    def _set_smooth_output(self) -> None:
        """Set the output's weights to smooth random functions of the class."""
        cycle = torch.arange(1, 65)
        place = torch.arange(self.classes) + 0.5
        codes = torch.randn(64, self.head_width) / (1 + (cycle[:, None] / 6) ** 2)
        waves = torch.cos(torch.outer(place, cycle) * (TAU / 2 / self.classes))
        self.output.weight[..., 0, 0] = 0.12 * waves @ codes


class LightFastSCNN(FastSCNN):
    """Fast-SCNN with a tenth of the weights."""

    stem_width = 16
    head_width = 32
    context = 64
    down_widths = 24, 32
    widths = 48, 48, 64, 64
    expansion = 3
    pools = 3, 5, 9, 17


class PublicFastSCNN(Network):
    """Fast-SCNN of the authors' public code: phases alone, no skip at full resolution."""

    stride = 8
    reach = 256
    widths = 64, 64, 64, 64, 96, 96, 96, 128, 128, 128
    halved = 0, 3  # bottlenecks of stride 2

    def build(self) -> None:
        self.down = nn.Sequential(
            conv(self.inputs, 32, stride=2, padding=0),
            separable(32, 48),
            separable(48, 64),
        )
        blocks = (
            Bottleneck(i, o, 2 if k in self.halved else 1)
            for k, (i, o) in enumerate(pairwise(self.widths))
        )
        self.extract = nn.Sequential(*blocks, PublicPyramid(128, (2, 3, 6)))
        self.deep = nn.Sequential(
            conv(128, 128, groups=128),
            conv(128, 128, 1, relu=False),
        )
        self.fine = conv(64, 128, 1, relu=False)
        self.classify = nn.Sequential(
            separable(128, 128),
            separable(128, 128),
            nn.Dropout(0.1),
            nn.Conv2d(128, self.outputs, 1),
        )
        for layer in self.modules():
            if isinstance(layer, NormedConv):
                layer[1] = nn.InstanceNorm2d(layer[1].num_features)  # pyright: ignore[reportArgumentType]

    def body(self, x: Tensor) -> Tensor:
        fine = self.down(x)  # (B, 64, H/2, W/2)
        deep = self.deep(resize_like(self.extract(fine), fine, aligned=True))
        mixed = functional.relu(deep + self.fine(fine))
        return resize_like(self.classify(mixed), x, aligned=True)


class UNet(Network):
    """U-Net (Ronneberger, Fischer and Brox 2015; 64 to 1024 wide there), with batch norms."""

    stride = 16
    reach = 192
    widths = 24, 48, 72, 104, 128

    def build(self) -> None:
        down = pairwise((self.inputs, *self.widths))
        up = list(pairwise(self.widths[::-1]))
        self.down = nn.ModuleList(self.level(i, o) for i, o in down)
        self.rise = nn.ModuleList(nn.ConvTranspose2d(i, o, 2, 2) for i, o in up)
        self.up = nn.ModuleList(self.level(2 * o, o) for _, o in up)
        self.output = nn.Conv2d(self.widths[0], self.outputs, 1)

    def level(self, i: int, o: int) -> nn.Module:
        return nn.Sequential(conv(i, o), conv(o, o))

    def before_output(self, x: Tensor) -> Tensor:
        skips: list[Tensor] = []
        for level in self.down:
            x = level(functional.max_pool2d(x, 2) if skips else x)
            skips.append(x)
        x = skips.pop()
        for rise, level in zip(self.rise, self.up, strict=True):
            x = level(torch.cat([skips.pop(), rise(x)], 1))
        return x


class OneStep(UNet):
    """One-step unwrapping (Wang, Li, Kemao, Di and Zhao 2019): a residual U-Net that regresses."""

    target = "depth"
    reach = 256
    widths = 16, 32, 56, 72, 96

    def level(self, i: int, o: int) -> nn.Module:
        return nn.Sequential(conv(i, o), Residual(o, o), conv(o, o))


class DeepToF(Network):
    """Deep end-to-end time of flight (Su, Heide, Wetzstein and Heidrich 2018): raw to depth.

    Theirs reads two correlations a frequency, ours four; its adversarial loss is left out.
    """

    target = "depth"
    stride = 4
    reach = 96

    def build(self) -> None:
        self.stem = conv(self.inputs, 16, 7)
        self.down = nn.ModuleList(conv(i, o, stride=2) for i, o in ((16, 32), (32, 80)))
        self.middle = nn.Sequential(*(Residual(80, 80) for _ in range(9)))
        self.up = nn.ModuleList(
            nn.Sequential(
                nn.ConvTranspose2d(i, o, 4, 2, 1), nn.BatchNorm2d(o), nn.ReLU()
            )
            for i, o in ((80, 32), (32, 16))
        )
        self.output = nn.Conv2d(16, self.outputs, 7, padding=3)

    def before_output(self, x: Tensor) -> Tensor:
        full = self.stem(x)
        half = self.down[0](full)
        half = half + self.up[0](self.middle(self.down[1](half)))
        return full + self.up[1](half)


class Rapid(Network):
    """Rapid and robust unwrapping (Zhang, Jiang, Zhao et al. 2019): DeepLabV3+ on a ResNet.

    The paper calls its "Zhang et al. 2019" a regression; of two articles that fit, this segments.
    Its correction of the segments afterwards is left out.
    """

    stride = 16
    reach = 448

    def build(self) -> None:
        self.stem = conv(self.inputs, 32, stride=2)
        pairs = pairwise((32, 48, 80, 112))
        self.fine, *deeper = (
            nn.Sequential(Residual(i, o, 2), Residual(o, o)) for i, o in pairs
        )
        self.coarse = nn.Sequential(*deeper)
        self.near = conv(112, 80, 1)
        self.far = nn.ModuleList(conv(112, 80, dilation=rate) for rate in (6, 12, 18))
        self.whole = nn.Conv2d(112, 80, 1)  # no norm: one crop has one pixel here
        self.join = conv(5 * 80, 80, 1)
        self.skip = conv(48, 24, 1)
        self.decoder = nn.Sequential(conv(80 + 24, 64), conv(64, 64))
        self.output = nn.Conv2d(64, self.outputs, 1)

    def before_output(self, x: Tensor) -> Tensor:
        fine = self.fine(self.stem(x))
        deep = self.coarse(fine)
        mean = functional.relu(self.whole(deep.mean((-2, -1), keepdim=True)))
        near = self.near(deep)
        far = (far(deep) for far in self.far)
        atrous = self.join(torch.cat([near, *far, mean.expand_as(near)], 1))
        decoded = self.decoder(
            torch.cat([resize_like(atrous, fine), self.skip(fine)], 1)
        )
        return resize_like(decoded, x)


# The rows of Table 1, one that costs less, and the baselines: all read raw correlations.
MODELS = {
    "fast-scnn": Model(FastSCNN),
    "fast-scnn-ce": Model(FastSCNN, depth_weight=0.0),
    "fast-scnn-fourier": Model(FastSCNN, "fourier"),
    "fast-scnn-phase": Model(FastSCNN, "phase"),
    "fast-scnn-public": Model(PublicFastSCNN, "octaves"),
    "fast-scnn-light": Model(LightFastSCNN, "beat"),
    "u-net": Model(UNet, "correlation", 0.0),
    "one-step": Model(OneStep, "correlation"),
    "deep-tof": Model(DeepToF, "correlation", smoothness=1e-4),
    "rapid": Model(Rapid, "correlation", 0.0),
}


def build_network(name: str, protocol: str = "released") -> Network:
    """Network of a model and protocol with initial weights, random but for `see_the_beat`."""
    model = MODELS[name]
    first, classes = CLASSES[protocol]
    network = model.network(model, classes)
    if isinstance(network, FastSCNN) and "fourier" in FEATURE_SETS[model.features]:
        network.see_the_beat(first)
    return network
