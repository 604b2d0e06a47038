"""Graphs, their costs, and the rearranged network: all the same as the network itself."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import nn

from cmtof.network.building import build_network
from cmtof.network.cost import BLOCKS, median_seconds, multiply_adds
from cmtof.network.export import Runner, check_export, export_network
from cmtof.network.fast_scnn import Architecture, FastSCNN
from cmtof.network.phased import Likeliest, Phased

SMALL: dict[str, Any] = {
    "down": (8, 8),
    "bottlenecks": (8, 16),
    "strides": (2, 2),
    "repeats": 1,
    "context": 16,
}


def shaken(network: FastSCNN) -> FastSCNN:
    """Eval mode, the norms as training might have left them."""
    torch.manual_seed(1)
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            nn.init.normal_(module.running_mean, std=0.3)  # type: ignore[arg-type]
            nn.init.uniform_(module.running_var, 0.5, 2)  # type: ignore[arg-type]
            nn.init.uniform_(module.weight, 0.5, 2)
            nn.init.normal_(module.bias, std=0.3)
    return network.eval()


@pytest.fixture
def small() -> FastSCNN:
    return shaken(FastSCNN(Architecture(stem=8, head=8, **SMALL), 6, 5))


@pytest.fixture
def skipless() -> FastSCNN:
    return shaken(FastSCNN(Architecture(stem=0, pools=(), norm="instance", **SMALL), 6, 5))


@pytest.mark.parametrize("shape", [(8, 8), (8, 26), (34, 12), (32, 48)])
def test_the_rearranged_network_gives_the_same_up_to_the_border(small: FastSCNN, shape):
    image = torch.randn(2, 6, *shape)
    with torch.inference_mode():
        expected, found = small(image), Phased(small)(image)
    assert torch.allclose(found, expected, atol=1e-5 * float(expected.abs().max()))


@pytest.mark.parametrize("shape", [(16, 16), (33, 21)])
def test_without_a_skip_any_size_is_rearranged(skipless: FastSCNN, shape):
    image = torch.randn(1, 6, *shape)
    with torch.inference_mode():
        expected, found = skipless(image), Phased(skipless)(image)
    assert torch.allclose(found, expected, atol=1e-5 * float(expected.abs().max()))


@pytest.mark.parametrize("name", ["fast-scnn", "fast-scnn-light"])
def test_the_named_networks_are_rearranged_exactly(name: str):
    network = shaken(build_network(name, 21))
    image = torch.randn(1, network.inputs, 32, 40)
    with torch.inference_mode():
        expected, found = network(image), Phased(network)(image)
    assert torch.allclose(found, expected, atol=1e-5 * float(expected.abs().max()))


def test_odds_are_those_of_the_softmax():
    weights = torch.randn(2, 7, 3, 4) * 5
    odds, likeliest = torch.softmax(weights, 1).max(1)
    found = Likeliest()(weights)
    assert torch.equal(found[:, 0], likeliest.float())
    assert torch.allclose(found[:, 1], odds)


def test_the_graph_of_the_weights_takes_any_size(small: FastSCNN, tmp_path: Path):
    path = export_network(small, tmp_path / "weights.onnx")
    agreement = check_export(path, small, [(24, 32), (17, 35)], tolerance=1e-5)
    assert agreement.error < 1e-5
    assert agreement.same > 0.999
    assert Runner(path)(np.zeros((2, 6, 10, 9), np.float32)).shape == (2, 5, 10, 9)


def test_the_graph_of_the_likeliest_class_agrees(small: FastSCNN, tmp_path: Path):
    path = export_network(small, tmp_path / "likeliest.onnx", likeliest=True)
    assert check_export(path, small, [(24, 32), (10, 70)]).error < 1e-5
    with pytest.raises(ValueError, match=r"multiples of 2, got \(9, 10\)"):
        Runner(path)(np.zeros((1, 6, 9, 10), np.float32))


def test_without_a_skip_the_likeliest_class_takes_any_size(skipless: FastSCNN, tmp_path: Path):
    path = export_network(skipless, tmp_path / "likeliest.onnx", likeliest=True)
    assert check_export(path, skipless, [(24, 32), (19, 33)]).error < 1e-4


def test_a_graph_of_other_weights_is_found_out(small: FastSCNN, tmp_path: Path):
    path = export_network(small, tmp_path / "weights.onnx")
    other = shaken(FastSCNN(small.architecture, 6, 5))
    with torch.no_grad():
        other.output[1].weight.mul_(1.01)  # type: ignore[union-attr,operator]
    with pytest.raises(ValueError, match=r"weights.onnx to agree .* Export it anew"):
        check_export(path, other)


@pytest.mark.parametrize("likeliest", [False, True])
def test_a_network_in_training_is_not_exported(small: FastSCNN, tmp_path: Path, likeliest: bool):
    with pytest.raises(ValueError, match="eval mode"):
        export_network(small.train(), tmp_path / "x.onnx", likeliest=likeliest)
    with pytest.raises(ValueError, match="eval mode"):
        Phased(small)
    assert not list(tmp_path.iterdir())


def test_a_norm_that_is_not_linear_is_not_rearranged():
    network = FastSCNN(Architecture(stem=8, head=8, norm="instance", **SMALL), 6, 5).eval()
    with pytest.raises(ValueError, match="batch norm before the output, got InstanceNorm2d"):
        Phased(network)


def test_a_missing_graph_is_named(tmp_path: Path):
    with pytest.raises(ValueError, match=r"ONNX graph in .*none\.onnx, got none"):
        Runner(tmp_path / "none.onnx")


def test_multiply_adds_are_those_of_the_layers():
    network = build_network("fast-scnn", 21)
    counts = multiply_adds(network, 64, 32)
    assert tuple(counts) == tuple(BLOCKS)
    assert counts["stem"] == 64 * 32 * 36 * 32 * 9
    head = 2 * (9 * 128 + 128 * 128) / 4 + (9 * 160 + 160 * 64) + 64 * 21
    assert counts["head"] == 64 * 32 * head
    assert next(network.parameters()).device.type == "cpu"


def test_no_block_is_forgotten():
    network = build_network("fast-scnn", 21)
    parts = {part for parts in BLOCKS.values() for part in parts}
    assert parts == {name for name, _ in network.named_children()}
    assert multiply_adds(build_network("fast-scnn-released", 21), 16, 16)["stem"] == 0


def test_the_first_calls_are_not_timed():
    calls: list[int] = []
    assert median_seconds(lambda: calls.append(1), runs=3, warm_up=2) >= 0
    assert len(calls) == 5
