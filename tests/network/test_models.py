"""Networks: sizes, how far they see, what their first layer sees."""

from functools import partial

import numpy as np
import torch
from numpy.testing import assert_allclose
from pytest import mark
from tests.network.conftest import worn

from cmtof.correlation import TAU
from cmtof.network.features import CLASSES, features
from cmtof.network.models import BEAT, MODELS, build_network, conv
from cmtof.network.training import norms


# but for rapid, whose mean is over the whole image
@mark.parametrize("name", ["fast-scnn", "u-net", "one-step", "deep-tof"])
def test_networks_see_no_farther_than_their_reach(name):
    torch.manual_seed(1)
    network = build_network(name).eval()
    image = torch.randn(1, network.inputs, 16, 2 * network.reach + 3 * network.stride)
    changed = image.clone()
    beyond = network.reach + network.stride
    with torch.inference_mode():
        changed[..., beyond:] += 3
        difference = (network(image) - network(changed)).abs()
    assert not difference[..., : network.stride].any()
    assert difference[..., beyond:].any()


def test_compared_networks_have_about_as_many_weights():
    counts = {
        name: sum(w.numel() for w in build_network(name).parameters())
        for name in MODELS
    }
    assert counts["fast-scnn"] == 1_191_749
    light = counts.pop("fast-scnn-light")
    assert max(counts.values()) < 1.1 * min(counts.values())
    assert light < 0.11 * counts["fast-scnn"]


def test_regression_spans_the_range_in_single_precision():
    network = build_network("one-step", "full").eval()
    with torch.no_grad(), torch.autocast("cpu", torch.bfloat16):
        for layer in (network.output.weight, network.output.bias):
            layer.zero_()
        found = network(torch.randn(1, network.inputs, 32, 32))
    assert found.dtype == torch.float32 and (found == 179).all()


@mark.parametrize("protocol, quarters", [("released", (1, -1)), ("full", (0, 1, 2, 3))])
def test_fresh_stem_sees_the_beat(protocol, quarters, rng):
    """Means of the rectified filters follow |sin((b - beta)/2)|, whatever the phase."""
    first, classes = CLASSES[protocol]
    kernels = (
        build_network("fast-scnn", protocol).stem[0].weight.detach()[:16, :, 1:2, 1:2]
    )
    beat = BEAT * np.linspace(first, first + classes, 7)[:, None]
    low = rng.uniform(0, TAU, (7, 4000))
    phase = torch.from_numpy(np.stack([low, (2 * low + beat) % TAU])).float()
    inputs = features(phase, torch.full_like(phase, 3000.0))
    seen = torch.relu(torch.nn.functional.conv2d(inputs, kernels))
    means = seen.unflatten(0, (len(quarters), -1)).mean((1, 3))
    beta = BEAT * (first + classes / 2) + TAU / 4 * np.array(quarters)
    expected = 8 * 2 * abs(np.sin((beat - beta) / 2)).T / np.pi
    assert_allclose(means, expected, rtol=0, atol=0.25)


def test_path_to_the_pyramid_carries_the_beat_from_the_start():
    """A linear reading of the fresh network's pooled features finds the wrap of a flat wall."""
    torch.manual_seed(0)
    network = build_network("fast-scnn").train()
    held = []
    network.pyramid.join.register_forward_pre_hook(lambda _, given: held.extend(given))
    wraps = torch.linspace(36, 57, 16)
    low = TAU * torch.rand(16, 64, 64)
    noise = 0.3 * torch.randn(16, 2, 64, 64)
    phase = torch.stack([low, 2 * low + BEAT * wraps[:, None, None]], 1) + noise
    inputs = features(torch.remainder(phase, TAU), torch.full_like(phase, 3000.0))
    with torch.no_grad():
        network(inputs)
    # first pool, third channel: sum at one beta minus the other
    assert abs(np.corrcoef(held[0].mean((-2, -1))[:, 128 + 2], wraps)[0, 1]) > 0.95


@mark.parametrize("precision", [torch.float32, torch.bfloat16])
def test_frozen_norms_go_into_the_kernels_and_change_nothing(precision):
    """The same answers as of norms that are applied after their convolution."""
    torch.manual_seed(2)
    network = worn(build_network("fast-scnn"))
    image = torch.randn(1, network.inputs, 32, 40)
    with (
        torch.no_grad(),
        torch.autocast("cpu", precision, enabled=precision != torch.float32),
    ):
        folded = network(image).float()
        for layer in norms(network):  # with running statistics, though in training mode
            layer.train()
            layer.forward = partial(
                torch.nn.functional.batch_norm,
                running_mean=layer.running_mean,
                running_var=layer.running_var,
                weight=layer.weight,
                bias=layer.bias,
                eps=layer.eps,
            )
        apart = network(image).float()
    tolerance = 1e-4 if precision == torch.float32 else 0.1
    assert (folded - apart).abs().max() < tolerance * apart.abs().max()


def test_dilated_kernels_have_their_gradient_in_mixed_precision():
    """Also where memory held large numbers before: the gradient must not read them."""
    torch.manual_seed(3)
    layer = conv(64, 64, relu=False, groups=64, dilation=4).eval()
    image = torch.randn(2, 64, 32, 32).contiguous(memory_format=torch.channels_last)
    layer(image).square().mean().backward()
    exact = layer[0].weight.grad.clone()
    for _ in range(20):
        for size in (576, 1152, 4096, 16384):  # large numbers in memory that is freed
            torch.full((size,), 1e25, dtype=torch.bfloat16)
        layer.zero_grad()
        with torch.autocast("cpu", torch.bfloat16):
            loss = layer(image).square().mean()
        loss.backward()
        assert (layer[0].weight.grad - exact).abs().max() < 0.02 * exact.abs().max()
