"""How far a network looks, measured: which inputs one output pixel depends on, and how much.

What an architecture allows is a square; what its weights use of it falls off from the middle, much
like a bell (Luo et al. 2016). Both are read off the gradient, whatever the network is made of.
"""

from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn


class ReceptiveField(NamedTuple):
    """Share of each input pixel in one output pixel."""

    weight: NDArray[np.float64]
    """(S, S), sums to 1; the output pixel is the middle one of an odd S."""

    @property
    def extent(self) -> int:
        """Side of the smallest centred square outside of which nothing counts at all, px."""
        reach = np.argwhere(self.weight > 0) - len(self.weight) // 2
        return 2 * int(np.abs(reach).max()) + 1

    def side(self, share: float) -> int:
        """Side of the smallest centred square that holds a share of the weight, px.

        Raises
        ------
        ValueError
            If the share does not lie between 0 and 1.
        """
        if not 0 < share <= 1:
            raise ValueError(f"Expected a share in (0, 1], got {share}. Try 0.95.")
        held = self.profile()
        # the slack keeps rounding from asking for a square beyond the image
        return 2 * int(np.argmax(held >= share - 1e-9)) + 1

    def profile(self) -> NDArray[np.float64]:
        """Weight within the centred squares of sides 1, 3, 5, …"""
        middle = len(self.weight) // 2
        ring = np.abs(np.arange(len(self.weight)) - middle)
        rings = np.maximum.outer(ring, ring)
        return np.bincount(rings.ravel(), self.weight.ravel()).astype(float).cumsum()


def receptive_field(
    network: nn.Module, channels: int, *, side: int = 257, samples: int = 4, seed: int = 0
) -> ReceptiveField:
    r"""Measure by gradients what the middle pixel of the output depends on.

    .. math:: w(y, x) \propto \sum_{\rm noise} \sum_{c} \left|
              \frac{\partial \langle r, g(u)_{\rm middle} \rangle}{\partial u_c(y, x)} \right|

    with :math:`g` the network in eval mode on an input u of white noise and :math:`r` a random
    direction among the output's channels, so that no channel stands out.

    Parameters
    ----------
    network : Module
        Maps (B, C, S, S) to (B, N, S, S); left in the mode and with the gradients that it had.
    channels : int
        C.
    side : int
        S, odd, px; a field that reaches the border is larger than S.
    samples : int
        Noise images to average over: a ReLU hides what it cuts.
    seed : int
        Of noise and directions.

    Raises
    ------
    ValueError
        If the side is even, or the output has another size or does not depend on the input.

    Examples
    --------
    >>> field = receptive_field(nn.Conv2d(1, 2, 3, padding=1), 1, side=9)
    >>> field.extent, field.weight.shape
    (3, (9, 9))
    """
    if side < 1 or side % 2 == 0:
        raise ValueError(f"Expected an odd side, which has a middle, got {side}. Add a pixel.")
    generator = torch.Generator().manual_seed(seed)
    total, was_training = torch.zeros(side, side, dtype=torch.float64), network.training
    network.eval()
    try:
        for _ in range(samples):
            total += _gradient(network, channels, side, generator)
    finally:
        network.train(was_training)
    if not total.sum() > 0:
        raise ValueError("Expected an output that depends on the input, got none. Look at it.")
    return ReceptiveField((total / total.sum()).numpy())


def _gradient(
    network: nn.Module, channels: int, side: int, generator: torch.Generator
) -> torch.Tensor:
    noise = torch.randn(1, channels, side, side, generator=generator).requires_grad_()
    output = network(noise)
    if output.shape[-2:] != (side, side):
        raise ValueError(
            f"Expected an output of {side}x{side}, got {tuple(output.shape)}. Resize it."
        )
    pixel = output[0, :, side // 2, side // 2]
    direction = torch.randn(pixel.shape, generator=generator)
    (gradient,) = torch.autograd.grad(pixel @ direction, noise)
    return gradient[0].abs().sum(0).double()
