"""Losses of training: the right class, and a near one rather than a far one (Sec. 5.2)."""

from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn import functional

from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, wrap_length

IGNORED = -100
"""Label of a masked pixel."""

WRAP_MM = 1e3 * float(wrap_length(FREQUENCIES[0]))
"""Depth of one wrap of the lower frequency, mm: the paper's unit of depth (Sec. 5.3)."""


class Loss(NamedTuple):
    """A loss and its two parts."""

    total: Tensor
    cross_entropy: Tensor
    depth: Tensor


def soft_argmax(weights: Tensor, hardness: float = 1.0) -> Tensor:
    r"""Differentiable argmax over classes (Eq. 6).

    .. math:: n' = \sum_{n=0}^{N-1} n\,
              \frac{e^{\gamma\bar\varphi_n}}{\sum_{m=0}^{N-1} e^{\gamma\bar\varphi_m}}

    As printed, the hardness :math:`\gamma` multiplies the numerator's exponential, and the shares
    do not add up to one; it belongs into both exponents.

    Parameters
    ----------
    weights : Tensor, shape (B, N, ...)
        Class weights of any scale.
    hardness : float
        1 gives the mean of the classes by their probability, infinity the argmax.

    Returns
    -------
    Tensor, shape (B, ...)
        Expected class, in [0, N - 1].

    Examples
    --------
    >>> soft_argmax(torch.tensor([[0.0, 0.0, 99.0]])).tolist()
    [2.0]
    """
    share = torch.softmax(hardness * weights, 1)
    classes = torch.arange(weights.shape[1], dtype=share.dtype, device=share.device)
    # no matrix product: mixed precision would round the numbers of the classes
    return (share * classes.view(-1, *[1] * (weights.ndim - 2))).sum(1)


def unwrapping_loss(
    weights: Tensor, label: Tensor, phase: Tensor, turns: Tensor, *, depth_weight: float = 0.1
) -> Loss:
    r"""Cross-entropy of the classes and smooth L1 distance in depth (Eq. 7).

    .. math:: \mathcal L = -\ln p_n + w\,s(z' - z), \quad
              z' = \frac{c}{4\pi f_1} (2\pi n' + \hat\varphi_1)

    with :math:`p` the softmax of the weights, depth in mm as in the paper, and :math:`s` Huber's
    distance of width 1 mm: at w = 0.1 an error of one wrap costs 2.1. Eq. 7 prints the
    cross-entropy with phases in the place of probabilities.

    Parameters
    ----------
    weights : Tensor, shape (B, N, H, W)
        Class weights.
    label : Tensor of int64, shape (B, H, W)
        True class, `IGNORED` where masked.
    phase : Tensor, shape (B, H, W)
        Measured wrapped phase of the lower frequency, rad.
    turns : Tensor, shape (B, H, W)
        True depth, wraps of the lower frequency above the first class.
    depth_weight : float
        w, 1/mm; 0 leaves the cross-entropy alone.

    Returns
    -------
    Loss
        Means over the pixels that are not masked; 0 where none is left.
    """
    weights, valid = (weights.float() if weights.dtype.itemsize < 4 else weights), label != IGNORED
    count = valid.sum().clamp(min=1)
    entropy = functional.cross_entropy(weights, label, ignore_index=IGNORED, reduction="sum")
    entropy = entropy / count
    if not depth_weight:
        return Loss(entropy, entropy, torch.zeros_like(entropy))
    # masked before the distance is taken: a NaN there must not reach a gradient
    found = (soft_argmax(weights) + phase / TAU)[valid] * WRAP_MM
    true = turns[valid].to(found.dtype) * WRAP_MM
    distance = functional.smooth_l1_loss(found, true, reduction="sum") / count
    return Loss(entropy + depth_weight * distance, entropy, distance)


def regression_loss(
    found: Tensor, label: Tensor, turns: Tensor, *, classes: int, smoothness: float = 0.0
) -> Loss:
    r"""Absolute error of a regressed depth, and of its gradient (Su et al. 2018).

    .. math:: \mathcal L = \frac1N \left(\overline{|t' - t|} + \lambda\,
              \overline{|\nabla t'|}\right)

    Parameters
    ----------
    found : Tensor, shape (B, 1, H, W)
        Depth t', wraps of the lower frequency above the first class.
    label, turns : Tensor, shape (B, H, W)
        As of `unwrapping_loss`.
    classes : int
        N.
    smoothness : float
        lambda, of the sum of mean absolute differences to the next row and column.

    Returns
    -------
    Loss
        Without cross-entropy; 0 where no pixel is left.
    """
    found, valid = found[:, 0].float(), label != IGNORED
    distance = (found[valid] - turns[valid]).abs().sum() / (classes * valid.sum().clamp(min=1))
    total = distance
    for axis in (-1, -2) if smoothness else ():
        last = found.shape[axis] - 1
        pair = valid.narrow(axis, 1, last) & valid.narrow(axis, 0, last)
        rough = found.diff(dim=axis)[pair].abs().sum() / pair.sum().clamp(min=1)
        total = total + smoothness * rough / classes
    return Loss(total, torch.zeros_like(total), distance)
