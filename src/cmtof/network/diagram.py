"""The network drawn from the network: every number in the picture is read off its layers.

Hooks note what each block makes of an image; nothing about channels or sizes stands in here.
"""

from copy import deepcopy
from itertools import pairwise
from typing import NamedTuple

import torch
from matplotlib.axes import Axes
from matplotlib.patches import FancyBboxPatch, Rectangle
from torch import Tensor, nn

from cmtof.book.plotting import PALETTE
from cmtof.network.fast_scnn import FastSCNN


class Block(NamedTuple):
    """What one block makes of an image."""

    name: str
    """Path of the module, or the first of a group's."""
    repeats: int
    """Alike modules in a row."""
    channels: int
    height: int
    width: int
    parameters: int


LABELS = {
    "features": "features",
    "stem": "conv 3×3",
    "down": "separable",
    "extract": "bottleneck",
    "pyramid": "pyramid",
    "deep": "up, separable",
    "fine": "conv 1×1",
    "classify": "separable",
    "join": "up, separable",
    "output": "conv 1×1",
}
"""What a block does, by the first word of its path."""

_COLOURS = {
    "features": "#5C6770",
    "stem": PALETTE["orange"],
    "down": PALETTE["sky"],
    "extract": PALETTE["blue"],
    "pyramid": PALETTE["purple"],
    "deep": PALETTE["green"],
    "fine": PALETTE["green"],
    "classify": PALETTE["green"],
    "join": PALETTE["orange"],
    "output": PALETTE["vermillion"],
}

_INK = "#49535A"

WIDTH = 0.62
"""Of a block, columns."""

BEHIND = 0.055
"""By how much alike blocks are set off."""


def blocks(network: FastSCNN, height: int, width: int) -> list[Block]:
    """Run an image of no content through the network; tell what comes out of each block.

    Alike blocks in a row count as one. The first is the image itself.

    Examples
    --------
    >>> from cmtof.network.building import build_network
    >>> found = blocks(build_network("fast-scnn", 21), 512, 512)
    >>> [block.name for block in found if block.height == 64]
    ['extract.3', 'extract.6', 'pyramid']
    >>> sum(block.parameters for block in found)
    1167621
    """
    shadow = deepcopy(network).to("meta").eval()
    found = [Block("features", 1, network.inputs, height, width, 0)]
    for name, module in _parts(shadow):
        module.register_forward_hook(_noting(found, name))
    with torch.inference_mode():
        shadow(torch.empty(1, network.inputs, height, width, device="meta"))
    return _grouped(found)


def draw_network(ax: Axes, network: FastSCNN, height: int, width: int) -> list[Block]:
    """Draw the network's blocks from left to right, one level for each resolution.

    A block shows the channels that leave it, and how often it stands in a row; its height grows
    with their number. Returns what is drawn.
    """
    found = blocks(network, height, width)
    levels = sorted({block.height for block in found}, reverse=True)
    row = {size: -1.3 * k for k, size in enumerate(levels)}
    places = _places(found)
    for block, x in zip(found, places, strict=True):
        _draw_block(ax, block, x, row[block.height])
    _draw_levels(ax, found, row, max(places))
    _draw_arrows(ax, found, row, places)
    ax.set(
        xlim=(-1.75, max(places) + 0.6), ylim=(min(row.values()) - 0.7, 0.75), xticks=[], yticks=[]
    )
    ax.axis("off")
    return found


def _parts(network: FastSCNN) -> list[tuple[str, nn.Module]]:
    """Blocks in the order of the drawing: members of a chain one by one, the others whole."""
    found: list[tuple[str, nn.Module]] = []
    for name, child in network.named_children():
        if name in ("down", "extract", "classify"):
            found += [(f"{name}.{k}", part) for k, part in child.named_children()]
        else:
            found.append((name, child))
    return found


def _noting(found: list[Block], name: str):
    def note(module: nn.Module, inputs: tuple[Tensor, ...], output: Tensor) -> None:
        parameters = sum(weight.numel() for weight in module.parameters())
        channels, height, width = output.shape[1:]
        found.append(Block(name, 1, channels, height, width, parameters))

    return note


def _grouped(found: list[Block]) -> list[Block]:
    groups: list[Block] = []
    for block in found:
        last = groups[-1] if groups else None
        alike = last is not None and _kind(last) == _kind(block) and last[2:5] == block[2:5]
        if last is not None and alike:
            total = last.parameters + block.parameters
            groups[-1] = last._replace(repeats=last.repeats + 1, parameters=total)
        else:
            groups.append(block)
    return groups


def _kind(block: Block) -> str:
    return block.name.partition(".")[0]


def _places(found: list[Block]) -> list[float]:
    """Columns: each block right of the one before, `fine` above `pyramid`, beside `deep`."""
    column, places, by_kind = 0.0, [], {}
    for block in found:
        kind = _kind(block)
        if kind == "fine":  # it starts from the end of `down` and runs beside what is deeper
            places.append(by_kind["pyramid"])
            continue
        if kind == "classify":
            column += 0.3  # room for the sum
        places.append(column)
        by_kind[kind] = column
        column += 1.0
    return places


def _size(block: Block) -> float:
    return 0.34 + 0.42 * min(block.channels / 128, 1.0)


def _top(block: Block) -> float:
    """Size of a block with those that stand behind it."""
    return _size(block) + 2 * BEHIND * (block.repeats - 1)


def _draw_block(ax: Axes, block: Block, x: float, y: float) -> None:
    high = _size(block)
    for behind in range(block.repeats - 1, -1, -1):
        offset = BEHIND * behind
        ax.add_patch(
            FancyBboxPatch(
                (x - WIDTH / 2 + offset, y - high / 2 + offset), WIDTH, high,
                boxstyle="round,pad=0,rounding_size=0.06", lw=0.9, ec="white",
                fc=_COLOURS[_kind(block)], zorder=3 - 0.1 * behind,
            )
        )  # fmt: skip
    text = f"{block.channels}" + (f"\n×{block.repeats}" if block.repeats > 1 else "")
    ax.text(x, y, text, color="white", weight="bold", ha="center", va="center", fontsize=10,
            linespacing=0.95, zorder=4)  # fmt: skip
    kind, edge = _kind(block), high / 2 + 0.07
    # an arrow comes from below: the name gives way, up or to its right
    dx, dy = {"join": (0.0, edge), "deep": (0.08, -edge)}.get(kind, (0.0, -edge))
    ax.text(x + dx, y + dy, _label(block), ha="left" if dx else "center",
            va="bottom" if dy > 0 else "top", fontsize=8, zorder=4, linespacing=1.0)  # fmt: skip


def _label(block: Block) -> str:
    if block.name == "down.0":
        return LABELS["stem"]
    return LABELS[_kind(block)].replace(", ", ",\n")


def _draw_levels(ax: Axes, found: list[Block], row: dict[int, float], right: float) -> None:
    full = found[0]
    for block in {b.height: b for b in found}.values():
        y, share = row[block.height], full.height // block.height
        shown = "full" if share == 1 else f"1/{share}"
        ax.add_patch(Rectangle((-0.5, y - 0.2), right + 1, 0.4, fc="#EEF1F3", ec="none", zorder=0))
        ax.text(-1.7, y, f"{shown}\n{block.height}×{block.width}", ha="left", va="center",
                fontsize=8.8, color=_INK)  # fmt: skip


def _draw_arrows(ax: Axes, found: list[Block], row: dict[int, float], places: list[float]) -> None:
    at = {
        _kind(b): (x, row[b.height], _top(b)) for b, x in zip(found, places, strict=True)
    }  # the last of its kind
    total = (at["deep"][0] + 0.65, at["deep"][1], 0.26)
    ax.text(*total[:2], "+", ha="center", va="center_baseline", fontsize=12, zorder=4,
            bbox={"boxstyle": "circle,pad=0.12", "fc": "white", "ec": _INK})  # fmt: skip
    chain = [
        (x, row[b.height], _top(b))
        for b, x in zip(found, places, strict=True)
        if _kind(b) != "fine"
    ]
    after = chain.index(at["deep"]) + 1
    chain.insert(after, total)
    for k, (start, end) in enumerate(pairwise(chain)):
        leaves, enters = (0.28 if j == after else WIDTH for j in (k, k + 1))
        _arrow(ax, start, end, leaves, enters)
    _arrow(ax, at["down"], at["fine"])
    x, y, high = at["fine"]
    _drawn(ax, (x + 0.12, y + high / 2 + 0.02), (total[0], total[1] + 0.17), "arc3,rad=-0.3", _INK)
    if "join" in at:
        _arrow(ax, at["stem"], at["join"], colour=PALETTE["orange"])
        middle = (at["stem"][0] + at["join"][0]) / 2
        ax.text(middle, at["stem"][1] + 0.06, "skip", ha="center", va="bottom", fontsize=9.5,
                color="#8A5F00")  # fmt: skip


def _arrow(
    ax: Axes,
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    wide_start: float = WIDTH,
    wide_end: float = WIDTH,
    colour: str = _INK,
) -> None:
    """Straight along a level; to another one out of the side, into the top or the bottom."""
    (x, y, _), (u, v, high) = start, end
    begin = (x + wide_start / 2 + 0.02, y)
    if y == v:
        _drawn(ax, begin, (u - wide_end / 2 - 0.02, v), "arc3,rad=0", colour)
    else:
        stop = (u, v + (high / 2 + 0.03) * (1 if y > v else -1))
        _drawn(ax, begin, stop, "angle,angleA=0,angleB=90,rad=6", colour)


def _drawn(
    ax: Axes, begin: tuple[float, float], stop: tuple[float, float], way: str, colour: str
) -> None:
    ax.annotate("", stop, begin, zorder=2, arrowprops={
        "arrowstyle": "-|>", "lw": 1.5, "color": colour, "shrinkA": 0, "shrinkB": 0,
        "mutation_scale": 11, "connectionstyle": way,
    })  # fmt: skip
