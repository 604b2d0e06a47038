"""A network from its name."""

from cmtof.network.configuration import MODELS
from cmtof.network.fast_scnn import Architecture, FastSCNN
from cmtof.network.features import channels


def build_network(name: str, classes: int) -> FastSCNN:
    """Network of a model out of `MODELS`, with fresh weights.

    Examples
    --------
    >>> network = build_network("fast-scnn", 21)
    >>> sum(weight.numel() for weight in network.parameters())
    1167621
    """
    model = MODELS[name]
    return FastSCNN(Architecture(**model.architecture), channels(model.features), classes)
