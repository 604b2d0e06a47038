"""What every network is: a trunk over the whole frame, and a head over bands of its rows.

The trunk sees the whole frame at once. The head reaches a few rows, so that the classes of a whole
frame, which would take a gigabyte, never exist at once.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Literal

import torch
from torch import Tensor, nn

Target = Literal["wraps", "depth"]

BAND = 64
"""Rows of the image whose classes are held at a time."""


class Banded(nn.Module, ABC):
    """Network that may end in bands of rows.

    Maps features (B, C, H, W) to weights of wrap classes (B, N, H, W), or, for the target
    ``"depth"``, to turns (B, 1, H, W): wraps of the lower frequency above the first class,
    continuous.

    Parameters
    ----------
    inputs : int
        Channels of the features.
    classes : int
        N, wraps that are told apart; a regression takes them for its scale.
    target : {"wraps", "depth"}
    """

    reach: int = 0
    """Rows that the head looks beyond each of its own."""
    output: nn.Module
    """Last layer: maps the head's features to `outputs` channels."""

    def __init__(self, inputs: int, classes: int, target: Target) -> None:
        super().__init__()
        self.inputs, self.classes, self.target = inputs, classes, target

    @property
    def outputs(self) -> int:
        """Channels of the last layer."""
        return self.classes if self.target == "wraps" else 1

    @abstractmethod
    def trunk(self, x: Tensor) -> Tensor:
        """What the output is made from, at full resolution."""

    def head(self, trunk: Tensor) -> Tensor:
        """Class weights or turns from any piece of `trunk`'s rows."""
        if self.target == "wraps":
            return self.output(trunk)
        # half precision has 8 to 11 bits, and 358 wraps need more
        with torch.autocast(trunk.device.type, enabled=False):
            return self.classes * (0.5 + self.output(trunk.float()))

    def forward(self, x: Tensor) -> Tensor:
        return self.head(self.trunk(x))

    def in_bands(self, x: Tensor, reduce: Callable[[Tensor], Tensor], rows: int = BAND) -> Tensor:
        """``reduce(forward(x))`` by bands of rows.

        Parameters
        ----------
        x : Tensor, shape (B, C, H, W)
        reduce : callable
            Maps what `head` gives (B, N, h, W) to (B, D, h, W), pixel by pixel.
        rows : int
            h.

        Returns
        -------
        Tensor, shape (B, D, H, W)
        """
        trunk, height = self.trunk(x), x.shape[-2]
        bands = []
        for start in range(0, height, rows):
            top, bottom = max(start - self.reach, 0), min(start + rows + self.reach, height)
            found = self.head(trunk[..., top:bottom, :])
            bands.append(reduce(found[..., start - top : start - top + rows, :]))
        return torch.cat(bands, -2)
