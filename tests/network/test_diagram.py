"""The picture of a network says what the network is."""

import matplotlib.pyplot as plt
import pytest
import torch

from cmtof.network.building import build_network
from cmtof.network.configuration import MODELS
from cmtof.network.diagram import LABELS, blocks, draw_network


@pytest.mark.parametrize("name", ["fast-scnn", "fast-scnn-released", "fast-scnn-light"])
def test_every_parameter_stands_in_a_block(name: str):
    network = build_network(name, 21)
    found = blocks(network, 64, 96)
    assert sum(b.parameters for b in found) == sum(w.numel() for w in network.parameters())


def test_sizes_are_those_of_the_features():
    network = build_network("fast-scnn", 21).eval()
    found = {b.name: b for b in blocks(network, 64, 96)}
    image = torch.zeros(1, 36, 64, 96)
    with torch.inference_mode():
        down = network.down(network.stem(image))  # type: ignore[misc]
    assert tuple(found["down.2"][2:5]) == tuple(down.shape[1:])
    assert tuple(found["features"][2:5]) == (36, 64, 96)
    assert tuple(found["output"][2:5]) == (21, 64, 96)


def test_alike_blocks_count_as_one():
    found = {b.name: b for b in blocks(build_network("fast-scnn", 5), 64, 64)}
    assert found["extract.0"].repeats == found["extract.3"].repeats == 3
    assert found["classify.0"].repeats == 2
    assert found["down.0"].repeats == 1


@pytest.mark.parametrize("name", ["fast-scnn", "fast-scnn-released"])
def test_the_drawing_shows_the_channels(name: str):
    network = build_network(name, 21)
    figure, ax = plt.subplots()
    drawn = draw_network(ax, network, 64, 64)
    texts = [text.get_text() for text in ax.texts]
    for block in drawn:
        assert any(text.partition("\n")[0] == str(block.channels) for text in texts)
    assert ("skip" in texts) is bool(MODELS[name].architecture.get("stem", 32))
    plt.close(figure)


def test_the_network_is_left_alone():
    network = build_network("fast-scnn-light", 5)
    blocks(network, 32, 32)
    assert network.training
    assert not any(module._forward_hooks for module in network.modules())
    assert {weight.device.type for weight in network.parameters()} == {"cpu"}


def test_every_block_has_a_label():
    parts = {b.name.partition(".")[0] for b in blocks(build_network("fast-scnn", 5), 32, 32)}
    assert parts == LABELS.keys()
