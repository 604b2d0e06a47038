"""The network: any size, the same in bands and crops, local, and as large as its table says."""

import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import pytest
import torch
from torch import Tensor, nn
from torch.utils.flop_counter import FlopCounterMode

from cmtof.network.building import build_network
from cmtof.network.configuration import MODELS
from cmtof.network.fast_scnn import Architecture, FastSCNN
from cmtof.network.receptive_field import receptive_field

SMALL = Architecture(
    stem=4, down=(4, 6), bottlenecks=(8, 8, 16), repeats=1, expansion=2, pools=(3, 5), context=8,
    head=6,
)  # fmt: skip
AS_RELEASED = replace(SMALL, stem=0, pools=(), norm="instance")
PLAIN = replace(SMALL, stem=0)


def trained(architecture: Architecture, inputs: int = 5, classes: int = 9) -> FastSCNN:
    """A network ready to use, its norms fitted to noise: otherwise deep layers would fade."""
    torch.manual_seed(0)
    network = FastSCNN(architecture, inputs, classes)
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.momentum = 1.0
            nn.init.uniform_(module.weight, 0.7, 1.5)
            nn.init.normal_(module.bias, std=0.2)
    with torch.no_grad():
        network(image(2, inputs, 64, 64))
    return network.eval()


def image(*shape: int) -> Tensor:
    return torch.randn(shape, generator=torch.Generator().manual_seed(1))


# --- sizes -------------------------------------------------------------------------------------


@pytest.mark.parametrize("norm", ["batch", "instance"])
@pytest.mark.parametrize("stem", [0, 4])
@pytest.mark.parametrize("size", [(8, 8), (9, 8), (8, 31), (17, 23), (33, 64), (1, 40), (48, 50)])
@torch.inference_mode()
def test_any_height_and_width_comes_out_as_it_went_in(norm, stem, size):
    size = (9, 9) if norm == "instance" and size == (8, 8) else size  # one pixel has no spread
    pools = () if norm == "instance" else (3, 5)
    network = trained(replace(SMALL, norm=norm, stem=stem, pools=pools))
    weights = network(image(2, 5, *size))
    assert weights.shape == (2, 9, *size)
    assert torch.isfinite(weights).all()


@pytest.mark.parametrize("name", MODELS)
@torch.inference_mode()
def test_every_model_takes_odd_sizes(name: str):
    network = build_network(name, 21).eval()
    outputs = 21 if MODELS[name].target == "wraps" else 1
    assert network(image(1, network.inputs, 19, 27)).shape == (1, outputs, 19, 27)


@pytest.mark.parametrize("name", MODELS)
def test_every_model_trains_on_a_single_crop(name: str):
    """Norms of one pixel have no spread; no layer may ask for one of a batch of one."""
    network = build_network(name, 5)
    network(image(1, network.inputs, 32, 32)).square().mean().backward()
    missing = [n for n, p in network.named_parameters() if p.grad is None]
    assert not missing
    assert all(torch.isfinite(p.grad).all() for p in network.parameters() if p.grad is not None)


@pytest.mark.parametrize("architecture", [SMALL, PLAIN, AS_RELEASED])
@pytest.mark.parametrize("rows", [1, 2, 7, 16, 29, 64])
@torch.inference_mode()
def test_bands_give_what_the_whole_gives(architecture: Architecture, rows: int):
    network, x = trained(architecture), image(2, 5, 29, 22)
    found = network.in_bands(x, lambda weights: weights, rows)
    torch.testing.assert_close(found, network(x), atol=1e-5, rtol=1e-5)


@torch.inference_mode()
def test_bands_never_hold_the_classes_of_a_whole_frame():
    held: list[tuple[int, ...]] = []

    def likeliest(weights: Tensor) -> Tensor:
        held.append(tuple(weights.shape))
        return weights.argmax(1, keepdim=True)

    network, x = trained(SMALL), image(1, 5, 50, 16)
    found = network.in_bands(x, likeliest, rows=16)
    assert held == [(1, 9, 16, 16)] * 3 + [(1, 9, 2, 16)]
    assert (found[:, 0] == network(x).argmax(1)).all()


# --- crops and frames --------------------------------------------------------------------------


def disagreement(architecture: Architecture) -> float:
    """Greatest difference of a crop's weights to the frame's, beyond the border's reach."""
    # brighter to one side, as scenes are: a crop is not the frame's mean
    network, frame = trained(architecture), image(1, 5, 208, 208) + torch.linspace(-2, 2, 208)
    field = receptive_field(trained(replace(architecture, norm="batch", pools=(3, 5))), 5, side=129)
    assert field.extent < 129
    border = field.extent // 2 + 16  # pixels of one block of 8 look differently far
    low, high = 16, 192  # a multiple of the coarsest pixel, so that the grids agree
    inner = slice(border, high - low - border)
    with torch.inference_mode():
        whole = network(frame)[..., low:high, low:high]
        crop = network(frame[..., low:high, low:high])
    assert whole[..., inner, inner].numel()
    scale = float(whole.abs().max())
    return float((crop - whole)[..., inner, inner].abs().max()) / scale


@pytest.mark.parametrize("architecture", [SMALL, PLAIN])
def test_a_crop_and_its_frame_agree(architecture: Architecture):
    """Norms of what training saw and local pools: train on crops, use on frames of any size."""
    assert disagreement(architecture) < 1e-5


@pytest.mark.parametrize(
    "architecture", [AS_RELEASED, replace(SMALL, pools=()), replace(SMALL, norm="instance")]
)
def test_whole_image_pools_or_norms_break_that(architecture: Architecture):
    assert disagreement(architecture) > 1e-3


# --- reach -------------------------------------------------------------------------------------


def reach(layers: list[tuple[int, int]]) -> int:
    """Side of the square that a chain of (kernel, stride) sees."""
    side, jump = 1, 1
    for kernel, stride in layers:
        side += (kernel - 1) * jump
        jump *= stride
    return side


STAGES = [(3, 2), (3, 1), (3, 1)] * 2 + [(3, 1)] * 3
ORIGINAL = reach([(3, 2)] * 3 + STAGES)


def linear(network: FastSCNN) -> FastSCNN:
    """The same connections, all of them positive and open: nothing cancels, nothing is cut."""
    for module in network.modules():
        if isinstance(module, nn.Sequential):
            for name, child in module.named_children():
                if isinstance(child, nn.ReLU):
                    module[int(name)] = nn.Identity()
    with torch.no_grad():
        for module in network.modules():
            if isinstance(module, nn.Conv2d):
                module.weight.fill_(1 / module.weight[0].numel())
    return network.eval()


def narrow(**options) -> FastSCNN:
    """As deep as the paper's, and as thin as can be."""
    thin = Architecture(1, (1, 1, 1), (4, 4, 4), expansion=1, context=1, head=1)
    return linear(FastSCNN(replace(thin, **options), 1, 2))


def test_features_of_the_extractor_see_121_pixels_where_the_original_saw_447():
    assert ORIGINAL == 447
    network, x = narrow(), torch.ones(1, 1, 257, 257, requires_grad=True)
    assert network.stem is not None
    deep = network.extract(network.down(network.stem(x)))
    (seen,) = torch.autograd.grad(deep[0, :, 16, 16].sum(), x)
    columns = seen[0, 0].any(0).nonzero()
    assert int(columns.max() - columns.min()) + 1 == 121 == reach([(3, 1), (3, 2), (3, 1), (3, 1),
                                                                  *STAGES])  # fmt: skip


def extent(network: FastSCNN, side: int) -> int:
    """Side of the square of input pixels that the middle output pixel depends on."""
    x = torch.ones(1, 1, side, side, requires_grad=True)  # light everywhere: no ReLU closes
    pixel = network(x)[0, :, side // 2, side // 2].sum()
    (seen,) = torch.autograd.grad(pixel, x)
    away = (seen[0, 0].nonzero() - side // 2).abs().max()
    return 2 * int(away) + 1


def test_the_networks_reach_is_finite_and_local_pools_are_half_of_it():
    without, local = (extent(narrow(pools=pools), 513) for pools in ((1,), (3, 5, 9, 17)))
    assert 121 < without < 200
    assert local == pytest.approx(without + 16 * 8, abs=8)
    assert local < ORIGINAL  # which had the whole image's bins besides


def test_with_whole_image_bins_the_reach_has_no_end():
    for side in (129, 257):
        assert extent(narrow(pools=()), side) == side


def test_reach_measured_on_noise_is_the_one_counted():
    """Half of all units are cut by their ReLUs, another half in each image."""
    field = receptive_field(trained(PLAIN), 5, side=129, samples=8)
    assert field.extent <= extent(linear(FastSCNN(PLAIN, 1, 2)), 129)
    assert field.extent > 65


def test_the_skip_leads_straight_to_the_output():
    """Cut off from its context, an output pixel still sees the 5 x 5 pixels about it."""
    network = narrow()
    with torch.no_grad():
        for module in network.classify.modules():
            if isinstance(module, nn.Conv2d):
                module.weight.zero_()
    assert extent(network, 33) == 5
    assert narrow(stem=0).join is None


# --- size --------------------------------------------------------------------------------------


def parameters(network: nn.Module) -> int:
    return sum(weight.numel() for weight in network.parameters())


def test_the_papers_network_has_the_parameters_of_its_table():
    """Two weights a norm; layer by layer, from the widths alone."""
    norm, inputs = 2, 36
    separable = lambda i, o: 9 * i + norm * i + i * o + norm * o  # noqa: E731
    bottleneck = lambda i, o: (6 * i) * (i + norm + 9 + norm + o) + norm * o  # noqa: E731
    widths = [64, 64, 64, 64, 96, 96, 96, 128, 128, 128]
    expected = [
        9 * inputs * 32 + norm * 32,
        9 * 32 * 32 + norm * 32 + separable(32, 48) + separable(48, 64),
        sum(bottleneck(i, o) for i, o in pairwise(widths)),
        4 * (128 * 32 + norm * 32) + 256 * 128 + norm * 128,
        9 * 128 + norm * 128 + 128 * 128 + norm * 128 + 64 * 128 + norm * 128,
        2 * separable(128, 128) + separable(160, 64) + 64 * 21 + 21,
    ]
    assert parameters(build_network("fast-scnn", 21)) == sum(expected) == 1_167_621


def test_the_released_variant_has_as_many_as_the_authors_code():
    assert parameters(build_network("fast-scnn-released", 21)) == pytest.approx(1.12e6, rel=3e-3)


def test_the_light_network_is_lighter():
    assert parameters(build_network("fast-scnn-light", 21)) < 1_167_621 / 3


@pytest.mark.parametrize("name", MODELS)
def test_another_number_of_classes_changes_the_last_layer_alone(name: str):
    few, many = (build_network(name, classes).state_dict() for classes in (21, 358))
    assert few.keys() == many.keys()
    changed = {key for key in few if few[key].shape != many[key].shape}
    last = list(few)[-2:]  # of a regression, which ends in one number, nothing changes
    assert changed == (set(last) if MODELS[name].target == "wraps" else set())
    assert all(key.startswith("output.") for key in last)


def floating_point_operations(height: int, width: int) -> int:
    """Counted on the device `meta`, where nothing is computed."""
    network = build_network("fast-scnn", 21).to("meta").eval()
    with FlopCounterMode(display=False) as counter, torch.inference_mode():
        network(torch.empty(1, 36, height, width, device="meta"))
    return counter.get_total_flops()


def test_a_frame_costs_what_the_table_says():
    small = floating_point_operations(256, 256)
    assert 12 * small == floating_point_operations(768, 1024)
    assert 12 * small / 1e9 == pytest.approx(112.8, abs=0.1)


MEMORY = """
import torch
from pathlib import Path
from cmtof.network.building import build_network
from cmtof.network.inference import classify
from cmtof.network.weights import Trained
torch.set_num_threads(1)
inputs = torch.randn(36, 768, 1024).numpy()
network = build_network("fast-scnn", 358).eval()
likeliest, odds = classify(Trained(network, {}), inputs)
assert likeliest.shape == odds.shape == (768, 1024) and likeliest.max() < 358
# the peak of this process; ru_maxrss would begin with that of the one that started it
status = Path("/proc/self/status").read_text()
print(status.partition("VmHWM:")[2].split()[0])
"""


@pytest.mark.slow
def test_358_classes_of_a_full_frame_stay_below_two_gigabytes():
    found = subprocess.run([sys.executable, "-c", MEMORY], capture_output=True, text=True)
    assert found.returncode == 0, found.stderr
    assert 1024 * int(found.stdout) < 2e9
