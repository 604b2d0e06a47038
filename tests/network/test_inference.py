"""Inference by ONNX Runtime: what torch answers, from the same weights."""

import gzip

import numpy as np
import torch
from numpy.testing import assert_allclose
from pytest import mark, param
from tests.network.conftest import card

import cmtof
from cmtof.correlation import wrap_count_from_depth
from cmtof.estimate import without_holes
from cmtof.frame import held_out_frames
from cmtof.network import inference, weights
from cmtof.network.features import CLASSES, features
from cmtof.network.models import MODELS, build_network
from cmtof.network.training import norms
from cmtof_book.onnx_graphs import graph_of


def torch_wraps(trained, measurement):
    """Wraps that the network of torch finds likeliest."""
    kind = trained.network.model.features
    phase, amplitude, *more = inference.network_images(measurement, kind)
    inputs = torch.from_numpy(features(phase, amplitude, kind, *more))[None]
    with torch.inference_mode():
        (found,) = trained.network(inputs)
    if trained.network.target == "depth":
        found = found.floor().clip(0, trained.card.classes - 1)
        return trained.card.first_wrap + found[0].int().numpy()
    return trained.card.first_wrap + found.argmax(0).numpy()


def equal_share(path, numbers):
    """Share of pixels of test frames at which both find the same wrap."""
    trained, frames, same = weights.load_weights(path), held_out_frames(), []
    for number in numbers:
        measurement = without_holes(cmtof.simulate(frames[number], frame_number=number))
        depth, _ = inference.unwrap_with_network(measurement, weights=path)
        found = wrap_count_from_depth(depth, measurement.frequencies[0])
        same.append(torch_wraps(trained, measurement) == found)
    return np.mean(same)


SHIPPED = sorted(path.name for path in weights.FOLDER.glob("*.released.safetensors"))


@mark.parametrize("numbers", [[7], param(range(32), marks=mark.slow)])
@mark.parametrize("name", SHIPPED)
def test_wraps_equal_those_of_torch(name, numbers):
    assert equal_share(weights.FOLDER / name, numbers) >= 0.9999


@mark.parametrize("size", [(33, 50), (1, 3)])
@mark.parametrize("name", MODELS)
def test_every_network_answers_as_in_torch(tmp_path, name, size):
    """At sizes that are padded, with norms that have seen something, for all classes."""
    torch.manual_seed(0)
    network = build_network(name, "full").eval()
    for norm in norms(network):
        norm.running_mean.uniform_(-1, 1)
        norm.running_var.uniform_(0.5, 2)
    path = weights.weights_path(name, "full", tmp_path)
    weights.save_weights(path, network, card(name, "full"))
    ready, trained = inference.load_network(path), weights.load_weights(path)
    inputs = torch.randn(1, network.inputs, *size)
    with torch.inference_mode():
        expected = trained.network(inputs)[0].numpy()
    found = inference.run_padded(ready.network, inputs.numpy())
    if network.target == "depth":
        found = CLASSES["full"][1] * (0.5 + found)
    assert_allclose(found, expected, rtol=0, atol=1e-5 * np.abs(expected).max())


@mark.parametrize("name", MODELS)
def test_graphs_are_those_of_the_models(name):
    """Else run python -m cmtof_book.onnx_graphs."""
    stored = gzip.decompress((weights.FOLDER / f"{name}.released.onnx.gz").read_bytes())
    assert stored == graph_of(build_network(name))
