"""One-step phase unwrapping (Wang, Li, Kemao, Di and Zhao, Opt. Express 27(10), 2019): regression.

A U-Net whose levels hold a residual block between their two convolutions, trained to give the
absolute phase itself; a wrap is read off its answer afterwards. Where two wraps are likely a
regression answers with neither but with what lies between, which is why the paper segments.

Ours: the input is two wrapped phases with log amplitudes in place of one phase; the phase is
counted in wraps of the lower frequency and scaled by the number of classes, for 21 as for 358. The
loss is the mean absolute error, as in the authors' later release; their article may have squared
it. Where in a level the block stands is told by others who built it. As shipped it is narrowed to
about the paper's 1.17 million parameters; `PUBLISHED` is as wide as the U-Net it came from.
"""

from dataclasses import dataclass

from torch import nn

from cmtof.network import u_net
from cmtof.network.bands import Target
from cmtof.network.fast_scnn import conv
from cmtof.network.parts import Residual


@dataclass(frozen=True)
class Architecture(u_net.Architecture):
    """Sizes; as of `cmtof.network.u_net.Architecture`."""

    widths: tuple[int, ...] = (16, 32, 56, 72, 96)


PUBLISHED = Architecture(u_net.PUBLISHED.widths)


class OneStep(u_net.UNet):
    """Residual U-Net; parameters as of `cmtof.network.u_net.UNet`."""

    def __init__(
        self, architecture: Architecture, inputs: int, classes: int, target: Target = "depth"
    ) -> None:
        super().__init__(architecture, inputs, classes, target)

    @staticmethod
    def level(inputs: int, outputs: int) -> nn.Module:
        """Convolution, residual block, convolution."""
        return nn.Sequential(
            conv(inputs, outputs, "batch"),
            Residual(outputs, outputs),
            conv(outputs, outputs, "batch"),
        )
