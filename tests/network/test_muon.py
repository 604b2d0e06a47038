"""Muon: orthogonal steps of kernels, AdamW's for the rest, the same after a checkpoint."""

import torch
from pytest import mark

from cmtof.network.muon import Muon, orthogonal


@mark.parametrize("shape", [(16, 40), (40, 16), (12, 12)])
def test_singular_values_come_close_to_one(shape):
    torch.manual_seed(0)
    matrix = torch.randn(shape)
    found = orthogonal(matrix)
    assert found.shape == shape
    values = torch.linalg.svdvals(found)
    assert values.min() > 0.3
    assert values.max() < 1.3
    assert (found * matrix).sum() > 0.9 * torch.linalg.svdvals(matrix).sum()


def parameters():
    torch.manual_seed(1)
    return torch.nn.Parameter(torch.randn(6, 4, 3, 3)), torch.nn.Parameter(
        torch.randn(6)
    )


def muon(kernel, offset):
    return Muon(
        [{"params": [kernel], "orthogonal": True}, {"params": [offset]}], lr=0.01
    )


def stepped(optimizer, kernel, offset, steps):
    for _ in range(steps):
        optimizer.zero_grad()
        ((kernel - 1) ** 2).sum().add(((offset - 1) ** 2).sum()).backward()
        optimizer.step()


def test_groups_that_are_not_orthogonal_step_as_with_adamw():
    kernel, offset = parameters()
    again, same = parameters()
    stepped(muon(kernel, offset), kernel, offset, 5)
    stepped(torch.optim.AdamW([again, same], lr=0.01), again, same, 5)
    assert torch.equal(offset, same)
    assert not torch.equal(kernel, again)


def test_orthogonal_steps_are_as_large_as_adamws_and_lead_to_the_minimum():
    kernel, offset = parameters()
    before = kernel.detach().clone()
    optimizer = muon(kernel, offset)
    stepped(optimizer, kernel, offset, 1)
    assert (
        0.3 * 0.01 < (kernel.detach() - before).square().mean().sqrt() / 0.4 < 3 * 0.01
    )
    optimizer.param_groups[0]["lr"] = 0.05
    stepped(optimizer, kernel, offset, 250)
    assert (kernel.detach() - 1).norm() < 0.4 * (before - 1).norm()
