"""Losses of a training: cross-entropy of the classes and distance in depth (Sec. 5.2)."""

import torch
from torch import Tensor
from torch.nn import functional

from cmtof.correlation import TAU
from cmtof.network.features import WRAP

IGNORED = -100  # label of a masked pixel, which costs nothing

# Depth of one wrap of the lower frequency, mm: the paper's unit of depth (Sec. 5.3).
WRAP_MM = 1e3 * WRAP


def soft_argmax(weights: Tensor, hardness: float = 1.0) -> Tensor:
    r"""Differentiable argmax (B, ...) over the classes of weights (B, N, ...) (Eq. 6).

    .. math:: n' = \sum_n n\, e^{\gamma\bar\varphi_n} / \sum_m e^{\gamma\bar\varphi_m}

    The hardness 1 gives the mean of the classes by their probability, infinity the argmax. As
    printed, it multiplies the numerator's exponential; it belongs into both exponents.
    """
    share = torch.softmax(hardness * weights, 1)
    classes = torch.arange(weights.shape[1], dtype=share.dtype, device=share.device)
    # no matrix product: mixed precision would round the numbers of the classes
    return (share * classes.view(-1, *[1] * (weights.ndim - 2))).sum(1)


def unwrapping_loss(
    weights: Tensor,
    label: Tensor,
    phase: Tensor,
    turns: Tensor,
    *,
    depth_weight: float = 0.1,
) -> Tensor:
    r"""Cross-entropy of the classes and smooth L1 distance in depth (Eq. 7), mean over pixels.

    .. math:: \mathcal L = -\ln p_n + w\,s(z' - z), \quad
              z' = \frac{c}{4\pi f_1} (2\pi n' + \hat\varphi_1)

    with p the softmax of the weights (B, N, H, W) and s Huber's distance of width 1 mm. The true
    class, the wrapped phase (rad), and the true depth (wraps above the first class) are (B, H, W).
    """
    weights = weights.float() if weights.dtype.itemsize < 4 else weights
    valid = label != IGNORED
    count = valid.sum().clamp(min=1)
    entropy = functional.cross_entropy(
        weights, label, ignore_index=IGNORED, reduction="sum"
    )
    if not depth_weight:
        return entropy / count
    # masked before the distance is taken: a NaN there must not reach a gradient
    found = (soft_argmax(weights) + phase / TAU)[valid] * WRAP_MM
    true = turns[valid].to(found.dtype) * WRAP_MM
    distance = functional.smooth_l1_loss(found, true, reduction="sum")
    return entropy / count + depth_weight * (distance / count)


def regression_loss(
    found: Tensor, label: Tensor, turns: Tensor, classes: int, smoothness: float = 0.0
) -> Tensor:
    r"""Absolute error of a regressed depth (B, 1, H, W), plus its scaled gradient (Su et al. 2018).

    Depths are wraps above the first class, and the loss is over the number of classes; the gradient
    is that to the next row and column.
    """
    found = found[:, 0].float()
    valid = label != IGNORED
    total = (found[valid] - turns[valid]).abs().sum() / (
        classes * valid.sum().clamp(min=1)
    )
    for axis in (-1, -2) if smoothness else ():
        last = found.shape[axis] - 1
        pair = valid.narrow(axis, 1, last) & valid.narrow(axis, 0, last)
        rough = found.diff(dim=axis)[pair].abs().sum() / pair.sum().clamp(min=1)
        total = total + smoothness * rough / classes
    return total
