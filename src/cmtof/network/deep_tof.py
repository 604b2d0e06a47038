"""Deep end-to-end time of flight (Su, Heide, Wetzstein and Heidrich, CVPR 2018): raw to depth.

An encoder, residual blocks at a quarter of the resolution, and a decoder that adds the encoder's
features of the same size, from raw correlation images to depth. Not to be taken for the DeepToF of
Marco et al. 2017, which corrects a depth that is already unwrapped.

Ours: eight correlation images, four quadratures at both frequencies, over the pixel's amplitude
(theirs are two at each of two). Loss: absolute error and smoothness, 1e-4 of the absolute gradient;
**the adversarial part is left out**, there is no discriminator. Batch norms, not instance norms,
whose statistics would change from crop to frame. The published code could not be had; the layers
follow the article as others tell of it. As shipped it is narrowed to about 1.17 million parameters.
"""

from dataclasses import dataclass

from torch import Tensor, nn

from cmtof.network.bands import Target
from cmtof.network.fast_scnn import conv
from cmtof.network.parts import AnySize, Residual


@dataclass(frozen=True)
class Architecture:
    """Sizes of the network.

    Attributes
    ----------
    widths : tuple of int
        Channels at each resolution, from the whole one down by halves.
    blocks : int
        Residual blocks at the lowest.
    kernel : int
        Side of the first and the last convolution, px.
    """

    widths: tuple[int, ...] = (16, 32, 80)
    blocks: int = 9
    kernel: int = 7


PUBLISHED = Architecture((64, 128, 256))


class DeepToF(AnySize):
    """Encoder and decoder with symmetric skips.

    Parameters
    ----------
    architecture : Architecture
    inputs, classes, target
        As of `cmtof.network.bands.Banded`.
    """

    def __init__(
        self, architecture: Architecture, inputs: int, classes: int, target: Target = "depth"
    ) -> None:
        super().__init__(inputs, classes, target)
        self.architecture, a = architecture, architecture
        self.stride, self.reach = 2 ** (len(a.widths) - 1), a.kernel // 2
        steps = list(zip(a.widths, a.widths[1:], strict=False))
        self.stem = conv(inputs, a.widths[0], "batch", a.kernel)
        self.down = nn.ModuleList(conv(i, o, "batch", stride=2) for i, o in steps)
        self.middle = nn.Sequential(
            *(Residual(a.widths[-1], a.widths[-1]) for _ in range(a.blocks))
        )
        self.up = nn.ModuleList(_up(o, i) for i, o in reversed(steps))
        self.output = nn.Conv2d(a.widths[0], self.outputs, a.kernel, padding=self.reach)

    def body(self, x: Tensor) -> Tensor:
        x, skips = self.stem(x), []
        for down in self.down:
            skips.append(x)
            x = down(x)
        x = self.middle(x)
        for up in self.up:
            x = up(x) + skips.pop()
        return x


def _up(inputs: int, outputs: int) -> nn.Sequential:
    """Twice the resolution."""
    return nn.Sequential(
        nn.ConvTranspose2d(inputs, outputs, 4, 2, 1, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    )
