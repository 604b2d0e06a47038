"""Networks: sizes, how far they see, what their first layer sees."""

import numpy as np
import torch
from pytest import mark

from cmtof.correlation import TAU
from cmtof.network.features import features
from cmtof.network.models import BEAT, MODELS, build_network, conv


@mark.parametrize(("name", "reach"), [("fast-scnn", 256), ("u-net", 192)])
def test_networks_see_no_farther_than_their_reach(name, reach):
    """A change farther away, by a stride of the coarsest features, changes nothing."""
    torch.manual_seed(1)
    network = build_network(name).eval()
    edge = reach + network.stride
    image = torch.randn(1, network.inputs, 16, edge + reach)
    changed = image.clone()
    changed[..., edge:] += 3
    with torch.inference_mode():
        moved = (network(image) - network(changed)).abs().amax((0, 1, 2))
    assert not moved[: network.stride].any()
    assert moved[edge:].any()


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


def test_path_to_the_pyramid_carries_the_beat_from_the_start():
    """A linear reading of the fresh network's pooled features finds the wrap of a flat wall."""
    torch.manual_seed(0)
    network, held = build_network("fast-scnn").train(), []
    network.pyramid.join.register_forward_pre_hook(
        lambda module, given: held.append(given[0])
    )
    wraps = torch.linspace(36, 57, 16)
    low = TAU * torch.rand(16, 64, 64)
    noise = 0.3 * torch.randn(16, 2, 64, 64)
    phase = torch.stack([low, 2 * low + BEAT * wraps[:, None, None]], 1) + noise
    inputs = features(torch.remainder(phase, TAU), torch.full_like(phase, 3000.0))
    with torch.no_grad():
        network(inputs)
    carried = held[0].mean((-2, -1)).double().numpy()
    difference = carried[
        :, 128 + 2
    ]  # first pool, third channel: sum at one beta minus the other
    assert abs(np.corrcoef(difference, wraps)[0, 1]) > 0.95


def test_dilated_kernels_have_their_gradient_in_mixed_precision():
    """Also where memory held large numbers before: the gradient must not read them."""
    torch.manual_seed(3)
    layer = conv(64, 64, 3, relu=False, groups=64, dilation=4).eval()
    image = torch.randn(2, 64, 32, 32).contiguous(memory_format=torch.channels_last)

    def gradient(precise):
        layer.zero_grad()
        with torch.autocast("cpu", torch.bfloat16, enabled=not precise):
            loss = layer(image).square().mean()
        loss.backward()
        return layer[0].weight.grad.clone()

    exact = gradient(True)
    for _ in range(20):
        for size in (576, 1152, 4096, 16384):  # large numbers in memory that is freed
            torch.full((size,), 1e25, dtype=torch.bfloat16)
        assert (gradient(False) - exact).abs().max() < 0.02 * exact.abs().max()
