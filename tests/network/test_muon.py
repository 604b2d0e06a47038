"""Muon: orthogonal steps of kernels, AdamW's for the rest, the same after a checkpoint."""

import torch
from pytest import mark
from torch.nn import Parameter

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
    assert float((found * matrix).sum()) > 0.9 * float(
        torch.linalg.svdvals(matrix).sum()
    )


def test_groups_that_are_not_orthogonal_step_as_with_adamw():
    torch.manual_seed(1)
    kernel, offset, same = (Parameter(torch.randn(6, 4)) for _ in range(3))
    same.data.copy_(offset)
    before = kernel.detach().clone()
    pairs = (kernel, True), (offset, False)
    groups = [{"params": [weight], "orthogonal": turned} for weight, turned in pairs]
    steppers = Muon(groups, lr=0.01), torch.optim.AdamW([same], lr=0.01)
    for _ in range(5):
        for weight in (kernel, offset, same):
            weight.grad = 2 * (weight.detach() - 1)
        for stepper in steppers:
            stepper.step()
    assert torch.equal(offset, same)
    # a fifth of the rate, root mean square
    assert 0.001 < (kernel - before).square().mean().sqrt() / 5 < 0.004
