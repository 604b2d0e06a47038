"""Layers of the authors' public code, which differ from the paper's text.

Facts from https://github.com/princeton-computational-imaging/GHz-ToF, ``net/arch.py``.
"""

import torch
from torch import Tensor, nn

from cmtof.network.layers import conv, resize_like


def averaging_matrix(size: int, count: int, like: Tensor) -> Tensor:
    """Matrix (count, size) that averages a row of ``size`` pixels over ``count`` equal parts.

    They are those of adaptive pooling, which ONNX does not have.
    """
    pixel = torch.arange(size, device=like.device)
    part = torch.arange(count, device=like.device)[:, None]
    inside = (pixel >= part * size // count) & (pixel * count < (part + 1) * size)
    shares = inside.to(like.dtype)
    return shares / shares.sum(1, keepdim=True)


class PublicPyramid(nn.Module):
    """Features joined with their means over parts of the image (pyramid pooling).

    The public code has a mean over all of it, too, of which its norm leaves nothing.
    """

    def __init__(self, width: int, counts: tuple[int, ...]) -> None:
        super().__init__()
        self.counts = counts  # parts of a row and of a column
        quarter = width // 4
        self.branches = nn.ModuleList(conv(width, quarter, 1) for _ in counts)
        self.join = conv(width + quarter * len(counts), width, 1)

    def forward(self, x: Tensor) -> Tensor:
        height, width = x.shape[-2:]
        found = [x]
        for branch, count in zip(self.branches, self.counts, strict=True):
            mean = (
                averaging_matrix(height, count, x)
                @ x
                @ averaging_matrix(width, count, x).T
            )
            found.append(resize_like(branch(mean), x, aligned=True))
        return self.join(torch.cat(found, 1))
