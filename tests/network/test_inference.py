"""Inference by ONNX Runtime: what torch answers, from the same weights."""

import numpy as np
import torch
from numpy.testing import assert_allclose
from pytest import mark, param
from tests.network.conftest import card, worn

import cmtof
from cmtof.correlation import wrap_count_from_depth
from cmtof.estimate import without_holes
from cmtof.frame import held_out_frames
from cmtof.measurement import Measurement
from cmtof.network import inference, weights
from cmtof.network.features import features
from cmtof.network.models import MODELS, build_network
from cmtof_book.onnx_graphs import graph_of


def in_torch(network, inputs):
    """Answer (C, H, W) of a network of torch."""
    with torch.inference_mode():
        return network(torch.from_numpy(inputs))[0].numpy()


@mark.parametrize("numbers", [[7], param(range(32), marks=mark.slow)])
@mark.parametrize(
    "name", sorted(path.name for path in weights.FOLDER.glob("*.safetensors"))
)
def test_wraps_equal_those_of_torch(name, numbers):
    path = weights.FOLDER / name
    network, card = weights.load_weights(path)
    frames = held_out_frames()
    same = []
    for number in numbers:
        measurement = without_holes(
            cmtof.simulate(frames[number], protocol=card.protocol, frame_number=number)
        )
        kind = network.model.features
        images = inference.network_images(measurement, kind)
        answer = in_torch(network, features(*images[:2], kind, *images[2:])[None])
        wraps = (
            answer.argmax(0)
            if len(answer) > 1
            else answer[0].clip(0, card.classes - 1) // 1
        )
        depth = inference.unwrap_with_network(measurement, weights=path)[0]
        found = wrap_count_from_depth(depth, measurement.frequencies[0])
        same.append(card.first_wrap + wraps == found)
    assert np.mean(same) >= 0.9999


@mark.parametrize("size", [(33, 50), (1, 3)])
@mark.parametrize("name", MODELS)
def test_every_network_answers_as_in_torch(tmp_path, name, size):
    """At sizes that are padded, with norms that have seen something, for all classes."""
    torch.manual_seed(0)
    network = worn(build_network(name, "full"))
    path = weights.weights_path(name, "full", tmp_path)
    weights.save_weights(path, network, card(name, "full"))
    inputs = torch.randn(1, network.inputs, *size).numpy()
    expected = in_torch(weights.load_weights(path).network, inputs)
    ready = inference.load_network(path)
    found = inference.apply_last_layer(ready, inference.run_padded(ready, inputs))
    if network.target == "depth":
        found = network.classes * (0.5 + found)
    # norms that divide by the spread of an image feel the rounding, the more the smaller it is
    close = 3e-3 / min(size) if name == "fast-scnn-public" else 1e-5
    assert_allclose(found, expected, rtol=0, atol=close * abs(expected).max())


@mark.parametrize("name", ["u-net", "rapid"])
def test_networks_read_counts_in_any_unit(measurement, name):
    volts = measurement.dataset["correlation"] / 3000
    scaled = Measurement(measurement.dataset.assign(correlation=volts))
    pair = [cmtof.unwrap(m, method=name).wrap_count for m in (measurement, scaled)]
    assert (pair[0] == pair[1]).mean() > 0.97


@mark.parametrize("name", MODELS)
def test_graphs_are_those_of_the_models(name):
    """Else run python -m cmtof_book.onnx_graphs."""
    assert inference.read_graph(card(name)) == graph_of(build_network(name))
