"""A network from its name."""

from collections.abc import Callable

from cmtof.network import deep_tof, fast_scnn, one_step, rapid, u_net
from cmtof.network.bands import Banded
from cmtof.network.configuration import MODELS, Model
from cmtof.network.features import channels

NETWORKS: dict[str, tuple[type, Callable[..., Banded]]] = {
    "fast-scnn": (fast_scnn.Architecture, fast_scnn.FastSCNN),
    "u-net": (u_net.Architecture, u_net.UNet),
    "one-step": (one_step.Architecture, one_step.OneStep),
    "deep-tof": (deep_tof.Architecture, deep_tof.DeepToF),
    "rapid": (rapid.Architecture, rapid.Rapid),
}
"""Networks by name, each with the class of its sizes."""


def build_network(name: str, classes: int) -> Banded:
    """Network of a model out of `MODELS`, with fresh weights.

    Examples
    --------
    >>> network = build_network("fast-scnn", 21)
    >>> sum(weight.numel() for weight in network.parameters())
    1167621
    """
    return build(MODELS[name], classes)


def build(model: Model, classes: int) -> Banded:
    """Network of any model, with fresh weights."""
    sizes, network = NETWORKS[model.network]
    return network(sizes(**model.architecture), channels(model.features), classes, model.target)
