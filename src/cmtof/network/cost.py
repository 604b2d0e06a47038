"""What a frame costs: multiply-adds, counted, and seconds, taken by the clock."""

import time
from collections.abc import Callable
from copy import deepcopy
from statistics import median
from typing import Any

import torch

from cmtof.network.fast_scnn import FastSCNN

BLOCKS = {
    "stem": ("stem",),
    "down": ("down",),
    "extract": ("extract",),
    "pyramid": ("pyramid",),
    "fuse": ("deep", "fine"),
    "head": ("classify", "join", "output"),
}
"""Parts of the network, by the attributes of `FastSCNN` that belong to each."""


def multiply_adds(network: FastSCNN, height: int, width: int) -> dict[str, int]:
    """Multiply-adds of the convolutions of each block, for one image; nothing is computed.

    Examples
    --------
    >>> from cmtof.network.building import build_network
    >>> counts = multiply_adds(build_network("fast-scnn", 21), 256, 256)
    >>> round(sum(counts.values()) / 1e9, 2), round(counts["stem"] / 1e9, 2)
    (4.7, 0.68)
    """
    from torch.utils.flop_counter import FlopCounterMode

    shadow = deepcopy(network).to("meta").eval()
    with FlopCounterMode(display=False) as counter, torch.inference_mode():
        shadow(torch.empty(1, network.inputs, height, width, device="meta"))
    found = {
        name.removeprefix("FastSCNN."): sum(counts.values())
        for name, counts in counter.get_flop_counts().items()
    }
    # two operations, a product and a sum, make one
    return {
        block: sum(found.get(part, 0) for part in parts) // 2 for block, parts in BLOCKS.items()
    }


def median_seconds(call: Callable[[], Any], *, runs: int = 3, warm_up: int = 1) -> float:
    """Median time of a call, s; the first calls, which fetch memory, are left out."""
    for _ in range(warm_up):
        call()
    taken = []
    for _ in range(runs):
        began = time.perf_counter()
        call()
        taken.append(time.perf_counter() - began)
    return median(taken)
