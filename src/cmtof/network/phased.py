r"""The same network with its last layers computed where there is something to compute.

Eager, the features are brought to full resolution and then convolved, one channel at a time. Both
steps are linear, and twice the resolution is four interleaved images of the lower one (the phases
of a filter bank): each is a convolution of the features as they were, with the kernel

.. math:: K_{ab} = M_a K M_b^T, \quad
          M_0 = \begin{pmatrix} \tfrac34 & \tfrac14 & 0 \\ \tfrac14 & \tfrac34 & \tfrac34 \\
                0 & 0 & \tfrac14 \end{pmatrix}, \quad
          M_1 = \begin{pmatrix} \tfrac14 & 0 & 0 \\ \tfrac34 & \tfrac34 & \tfrac14 \\
                0 & \tfrac14 & \tfrac34 \end{pmatrix}

in which bilinear weights are multiplied into the kernel K. No image of all channels is ever made at
full resolution; the classes alone are interleaved. A network without a skip gains more: its output
is linear too, and 21 classes are resized in place of 128 features. Nothing is approximated.
"""

import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.fusion import fuse_conv_bn_eval

from cmtof.network.fast_scnn import FastSCNN, resized

EDGE = 2
"""Pixels along the border where zeros beyond it count, and the phases' kernels do not hold."""

_PHASES = ((0, 0), (0, 1), (1, 0), (1, 1))
_ROWS = (
    ((0.75, 0.25, 0.0), (0.25, 0.75, 0.75), (0.0, 0.0, 0.25)),
    ((0.25, 0.0, 0.0), (0.75, 0.75, 0.25), (0.0, 0.25, 0.75)),
)


class Phased(nn.Module):
    """A network in eval mode, rearranged; it maps even sizes to what the network does.

    Parameters
    ----------
    network : FastSCNN
        Its weights are shared but for those of the last layers.
    likeliest : bool
        End in the likeliest class and its odds, (B, 2, H, W), in place of the weights of all.

    Raises
    ------
    ValueError
        If the network is in training mode, where norms change from batch to batch, or a norm
        after its skip is not linear.
    """

    def __init__(self, network: FastSCNN, *, likeliest: bool = False) -> None:
        super().__init__()
        if network.training:
            raise ValueError("Expected a network in eval mode, got one in training. Call eval().")
        self.network, self.ends = network, Likeliest() if likeliest else nn.Identity()
        if network.join is None:
            return
        width = network.architecture.context
        # the norm is linear too: it becomes part of the kernels
        across, self.narrow = (_fused(network.join[k], network.join[k + 1]) for k in (0, 3))
        assert across.bias is not None
        # constants of their own: a runtime lays out what it need not slice first
        self.biases = nn.ParameterList(part.detach().clone() for part in across.bias.split(
            [width, network.architecture.stem]))  # fmt: skip
        self.kernels = nn.ParameterList(
            _phase_kernel(across.weight[:width], *phase) for phase in _PHASES
        )
        # two rows and columns at a time, the kernel in one of four corners: no image is shifted
        self.skip_kernels = nn.ParameterList(
            functional.pad(across.weight[width:], (b, 1 - b, a, 1 - a)).detach() for a, b in _PHASES
        )

    def forward(self, x: Tensor) -> Tensor:
        n = self.network
        if n.join is None:
            return self.ends(resized(n.output(n.fused(x)[0]), x))
        context, skip = n.fused(x)
        assert skip is not None
        phases = [self._phase(context, skip, k) for k in range(len(_PHASES))]
        whole = functional.pixel_shuffle(torch.stack(phases, 2).flatten(1, 2), 2)
        return self._bordered(whole, context, skip)

    def _phase(self, context: Tensor, skip: Tensor, k: int) -> Tensor:
        """Every second row and column of the output, from row a and column b on."""
        groups, bias = (context.shape[1], skip.shape[1]), self.biases
        low = functional.conv2d(context, self.kernels[k], bias[0], padding=1, groups=groups[0])
        beside = functional.conv2d(skip, self.skip_kernels[k], bias[1], 2, 1, groups=groups[1])
        joined = torch.cat([functional.relu(low), functional.relu(beside)], 1)
        return self.ends(self.network.output(functional.relu(self.narrow(joined))))

    def _bordered(self, whole: Tensor, context: Tensor, skip: Tensor) -> Tensor:
        """The same with its edge computed as the network does, from the strips that it needs."""
        e = EDGE
        top = self._strip(context[..., :e, :], skip[..., : e + 1, :], 0)[..., :e, :]
        bottom = self._strip(context[..., -e:, :], skip[..., -e - 1 :, :], 1)[..., -e:, :]
        left = self._strip(context[..., :e], skip[..., : e + 1], 0)[..., e:-e, :e]
        right = self._strip(context[..., -e:], skip[..., -e - 1 :], 1)[..., e:-e, -e:]
        middle = torch.cat([left, whole[..., e:-e, e:-e], right], 3)
        return torch.cat([top, middle, bottom], 2)

    def _strip(self, context: Tensor, skip: Tensor, end: int) -> Tensor:
        """What the network makes of a strip; ``end`` tells whether it is the last of the image."""
        doubled = functional.interpolate(context, scale_factor=2, mode="bilinear")
        height, width = skip.shape[-2:]
        doubled = doubled[..., -height:, -width:] if end else doubled[..., :height, :width]
        return self.ends(self.network.head(torch.cat([doubled, skip], 1)))


class Likeliest(nn.Module):
    """Class of the largest weight, and its odds by the softmax of all: (B, N, …) to (B, 2, …)."""

    def forward(self, weights: Tensor) -> Tensor:
        top, likeliest = weights.max(1, keepdim=True)
        odds = 1 / torch.exp(weights - top).sum(1, keepdim=True)
        return torch.cat([likeliest.to(odds.dtype), odds], 1)


def _fused(convolution: nn.Module, norm: nn.Module) -> nn.Conv2d:
    if not (isinstance(convolution, nn.Conv2d) and isinstance(norm, nn.BatchNorm2d)):
        raise ValueError(
            f"Expected a convolution and a batch norm before the output, got {type(norm).__name__}."
            " Export the class weights."
        )
    return fuse_conv_bn_eval(convolution, norm)


def _phase_kernel(kernel: Tensor, a: int, b: int) -> nn.Parameter:
    """Kernels (C, 1, 3, 3) behind a doubling, for the rows from a and columns from b."""
    down, across = (torch.tensor(_ROWS[k], dtype=kernel.dtype) for k in (a, b))
    return nn.Parameter((down @ kernel @ across.T).detach(), requires_grad=False)
