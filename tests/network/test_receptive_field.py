"""How far a network looks."""

import numpy as np
import pytest
import torch
from torch import nn

from cmtof.network.building import build_network
from cmtof.network.receptive_field import receptive_field


def stack(count: int) -> nn.Module:
    return nn.Sequential(*(nn.Conv2d(3, 3, 3, padding=1) for _ in range(count)))


@pytest.mark.parametrize(("count", "extent"), [(1, 3), (2, 5), (5, 11)])
def test_stacked_convolutions_see_two_pixels_more_each(count: int, extent: int):
    field = receptive_field(stack(count), 3, side=21)
    assert field.extent == extent
    assert field.side(1.0) == extent
    assert field.weight.sum() == pytest.approx(1)


def test_a_mean_weighs_all_its_pixels_alike():
    field = receptive_field(nn.AvgPool2d(9, stride=1, padding=4), 2, side=31)
    assert field.extent == 9
    assert field.weight[15, 15] == pytest.approx(1 / 81)
    assert field.side(0.5) == 7  # 49 of 81
    assert field.profile()[:5] == pytest.approx(np.arange(1, 10, 2) ** 2 / 81)


def test_a_pixelwise_network_sees_one_pixel():
    assert receptive_field(nn.Conv2d(4, 5, 1), 4, side=9).extent == 1


def test_the_same_seed_gives_the_same_field():
    network = stack(2)
    first, second = (receptive_field(network, 3, side=9).weight for _ in range(2))
    assert np.array_equal(first, second)


@pytest.mark.parametrize("training", [True, False])
def test_the_network_is_left_as_it_was(training: bool):
    network = nn.Sequential(nn.Conv2d(2, 2, 3, padding=1), nn.BatchNorm2d(2), nn.Dropout(0.5))
    network.train(training)
    before = {name: value.clone() for name, value in network.state_dict().items()}
    receptive_field(network, 2, side=9)
    assert network.training is training
    assert all(parameter.grad is None for parameter in network.parameters())
    assert all(torch.equal(before[k], v) for k, v in network.state_dict().items())


def test_the_networks_middle_counts_most():
    torch.manual_seed(0)
    network = build_network("fast-scnn-light", 5)
    with torch.no_grad():
        for _ in range(20):  # fresh norms let deep layers fade
            network(torch.randn(2, 38, 32, 32))
    field = receptive_field(network, 38, side=65, samples=2)
    assert field.side(0.5) < field.side(0.95) <= field.extent
    assert field.weight[31:34, 31:34].sum() > 9 / 65**2


@pytest.mark.parametrize(
    ("network", "side", "match"),
    [
        (nn.Conv2d(1, 1, 3, padding=1), 8, "odd side, which has a middle, got 8"),
        (nn.Conv2d(1, 1, 3), 9, "output of 9x9"),
        (nn.Threshold(1e9, 0.0), 9, "depends on the input"),
    ],
)
def test_what_cannot_be_measured_is_refused(network: nn.Module, side: int, match: str):
    with pytest.raises(ValueError, match=match):
        receptive_field(network, 1, side=side)


@pytest.mark.parametrize("share", [0.0, 1.1])
def test_a_share_lies_between_0_and_1(share: float):
    with pytest.raises(ValueError, match="share in"):
        receptive_field(nn.Conv2d(1, 1, 1), 1, side=3).side(share)
