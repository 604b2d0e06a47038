"""A network from its name."""

from collections.abc import Callable
from typing import Any

from cmtof.network import deep_tof, fast_scnn, one_step, rapid, u_net
from cmtof.network.configuration import MODELS, Model
from cmtof.network.features import channels

BUILDERS: dict[str, Callable[[Model, int, int], Any]] = {
    "fast-scnn": lambda m, inputs, classes: fast_scnn.FastSCNN(
        fast_scnn.Architecture(**m.architecture), inputs, classes
    ),
    "u-net": lambda m, inputs, classes: u_net.UNet(
        u_net.Architecture(**m.architecture), inputs, classes, m.target
    ),
    "one-step": lambda m, inputs, classes: one_step.OneStep(
        one_step.Architecture(**m.architecture), inputs, classes, m.target
    ),
    "deep-tof": lambda m, inputs, classes: deep_tof.DeepToF(
        deep_tof.Architecture(**m.architecture), inputs, classes, m.target
    ),
    "rapid": lambda m, inputs, classes: rapid.Rapid(
        rapid.Architecture(**m.architecture), inputs, classes, m.target
    ),
}
"""Networks by name: from a model, the channels of its features, and the number of classes."""


def build_network(name: str, classes: int) -> Any:
    """Network of a model out of `MODELS`, with fresh weights.

    A `FastSCNN`, or a `cmtof.network.parts.Banded`: both have ``inputs``, ``classes`` and
    ``in_bands``.

    Examples
    --------
    >>> network = build_network("fast-scnn", 21)
    >>> sum(weight.numel() for weight in network.parameters())
    1167621
    """
    model = MODELS[name]
    return BUILDERS[model.network](model, channels(model.features), classes)
