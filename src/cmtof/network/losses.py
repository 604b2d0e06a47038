"""What the network is trained for: the right class, and a wrong one that is near (Sec. 5.2)."""

from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn import functional

from cmtof.correlation import TAU

IGNORED = -100
"""Label of a masked pixel."""


def soft_argmax(weights: Tensor, hardness: float = 1.0) -> Tensor:
    r"""Differentiable argmax over classes (Eq. 6).

    .. math:: n' = \sum_{n=0}^{N-1} n\,
              \frac{e^{\gamma\bar\varphi_n}}{\sum_{m=0}^{N-1} e^{\gamma\bar\varphi_m}}

    As printed, the hardness :math:`\gamma` multiplies the numerator's exponential and the sum is no
    mean; it belongs into the exponent, as it stands in the denominator.

    Parameters
    ----------
    weights : Tensor, shape (B, N, ...)
        Class weights of any scale.
    hardness : float
        1 gives the mean of the classes by their probability; towards infinity the argmax.

    Returns
    -------
    Tensor, shape (B, ...)
        Expected class, in [0, N - 1].

    Examples
    --------
    >>> soft_argmax(torch.tensor([[0.0, 0.0, 99.0]])).tolist()
    [2.0]
    """
    share = torch.softmax(hardness * weights.float(), 1)
    classes = torch.arange(weights.shape[1], dtype=share.dtype, device=share.device)
    # no matrix product: mixed precision would round the numbers of the classes
    return (share * classes.view(-1, *[1] * (weights.ndim - 2))).sum(1)


class Loss(NamedTuple):
    """A loss and its two parts."""

    total: Tensor
    cross_entropy: Tensor
    depth: Tensor


def unwrapping_loss(
    weights: Tensor,
    label: Tensor,
    phase: Tensor,
    turns: Tensor,
    *,
    depth_weight: float = 0.1,
    hardness: float = 1.0,
) -> Loss:
    r"""Cross-entropy of the classes and smooth distance in depth (Eq. 7).

    .. math:: \mathcal L = \mathcal L_{CE} + w\,\mathcal L_{L1}, \quad
              \mathcal L_{CE} = -\ln p_n, \quad \mathcal L_{L1} = s(z' - z), \quad
              z' = \frac{c}{4\pi f_1} (2\pi n' + \hat\varphi_1)

    with :math:`p` the softmax of the weights and :math:`s` the smooth L1 distance (Huber's, of
    width 1). Eq. 7 prints the cross-entropy with phases in the place of probabilities. Depth is
    measured in wraps of the lower frequency, so that neither part hangs on a unit of length.

    Parameters
    ----------
    weights : Tensor, shape (B, N, H, W)
        Class weights.
    label : Tensor of int64, shape (B, H, W)
        True class, `IGNORED` where masked: there nothing counts.
    phase : Tensor, shape (B, H, W)
        Measured wrapped phase of the lower frequency, rad.
    turns : Tensor, shape (B, H, W)
        True depth, wraps of the lower frequency above the first class.
    depth_weight : float
        w; 0 leaves the cross-entropy alone.
    hardness : float
        gamma of Eq. 6.

    Returns
    -------
    Loss
        Means over the pixels that are not masked; 0 where none is left.
    """
    valid = label != IGNORED
    count = valid.sum().clamp(min=1)
    entropy = functional.cross_entropy(weights, label, ignore_index=IGNORED, reduction="sum")
    entropy = entropy / count
    if not depth_weight:
        return Loss(entropy, entropy, torch.zeros_like(entropy))
    # masked before the distance is taken: what is not a number there must not reach a gradient
    found = (soft_argmax(weights, hardness) + phase / TAU)[valid]
    distance = functional.smooth_l1_loss(found, turns[valid], reduction="sum") / count
    return Loss(entropy + depth_weight * distance, entropy, distance)


def regression_loss(
    found: Tensor, label: Tensor, turns: Tensor, *, classes: int, smoothness: float = 0.0
) -> Loss:
    r"""Absolute error of a regressed depth, and of its gradient (Su et al. 2018).

    .. math:: \mathcal L = \frac1N \left(\overline{|t' - t|} + \lambda\,
              \overline{|\nabla t'|}\right)

    in wraps t over the number of classes N: the range of a protocol has the length 1.

    Parameters
    ----------
    found : Tensor, shape (B, 1, H, W)
        Depth, wraps of the lower frequency above the first class.
    label : Tensor of int64, shape (B, H, W)
        `IGNORED` where masked: there nothing counts.
    turns : Tensor, shape (B, H, W)
        True depth, in the same unit.
    classes : int
        N.
    smoothness : float
        lambda, of the sum of mean absolute differences to the next row and column.

    Returns
    -------
    Loss
        Means over the pixels, and pairs of them, that are not masked; 0 where none is left. There
        is no cross-entropy.
    """
    found, valid = found[:, 0].float(), label != IGNORED
    # masked before the distance is taken, as above
    distance = (found[valid] - turns[valid]).abs().sum() / (classes * valid.sum().clamp(min=1))
    total = distance
    if smoothness:
        rough = _roughness(found, valid, -1) + _roughness(found, valid, -2)
        total = distance + smoothness * rough / classes
    return Loss(total, torch.zeros_like(total), distance)


def _roughness(found: Tensor, valid: Tensor, axis: int) -> Tensor:
    """Mean absolute difference of neighbours that are both valid."""
    last = found.shape[axis] - 1
    pair = valid.narrow(axis, 1, last) & valid.narrow(axis, 0, last)
    return found.diff(dim=axis)[pair].abs().sum() / pair.sum().clamp(min=1)
