"""A tiny tree, a tiny training and tiny weights, made once for all tests of a module."""

from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from tiny_rooms import SIDE, VIEWS, write_rooms

from cmtof.network.building import build_network
from cmtof.network.configuration import Config, Rooms, wraps_of
from cmtof.network.weights import save_weights, weights_path


@pytest.fixture(scope="session")
def tiny_tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ten scenes of two views of 64 x 64 px: 16 train, 2 validate, 1 tests."""
    return write_rooms(tmp_path_factory.mktemp("tiny") / "rooms")


@pytest.fixture(scope="session")
def tiny() -> Config:
    """Three epochs of two steps."""
    return Config(
        name="tiny", model="fast-scnn-light", rooms=Rooms(1, 10, len(VIEWS), SIDE, SIDE),
        epochs=3, crops=4, batch=2, crop=32, learning_rate=3e-3,
    )  # fmt: skip


@pytest.fixture
def fresh(tmp_path: Path) -> Callable[..., Path]:
    """Write the weights of a network that was never trained; return their path."""

    def write(model: str = "fast-scnn-light", protocol: str = "released", **changes) -> Path:
        first, classes = wraps_of(protocol)
        torch.manual_seed(0)
        card = {"model": model, "protocol": protocol, "classes": classes, "first_wrap": first}
        card |= changes
        path = weights_path(model, protocol, tmp_path)
        save_weights(path, build_network(model, classes), card)
        return path

    return write
