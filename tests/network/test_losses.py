"""Equations 6 and 7: the mean class, and both losses with their gradients."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from cmtof.correlation import TAU
from cmtof.network.losses import IGNORED, Loss, soft_argmax, unwrapping_loss

CLASSES = 7


def sample(seed: int = 0, shape: tuple[int, ...] = (2, 5, 6)) -> tuple[Tensor, Tensor, Tensor]:
    """Labels, phases and turns that agree with each other."""
    generator = torch.Generator().manual_seed(seed)
    label = torch.randint(0, CLASSES, shape, generator=generator)
    phase = TAU * torch.rand(shape, generator=generator)
    return label, phase, label + phase / TAU


def drawn(seed: int = 1, scale: float = 1.0) -> Tensor:
    generator = torch.Generator().manual_seed(seed)
    return scale * torch.randn(2, CLASSES, 5, 6, generator=generator)


# --- Eq. 6 -------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", range(CLASSES))
def test_soft_argmax_of_a_one_hot_is_its_class(n: int):
    weights = torch.zeros(1, CLASSES)
    weights[0, n] = 60.0
    assert soft_argmax(weights).item() == pytest.approx(n, abs=1e-6)


@pytest.mark.parametrize("classes", [1, 2, 21, 358])
@pytest.mark.parametrize("hardness", [0.5, 1.0, 1000.0])
def test_equal_weights_give_the_middle(classes: int, hardness: float):
    middle = soft_argmax(torch.full((1, classes, 2), 3.0), hardness)
    assert middle.shape == (1, 2)
    assert torch.allclose(middle, torch.tensor((classes - 1) / 2), rtol=1e-5)


def test_soft_argmax_is_the_mean_of_the_classes_by_equation_6():
    weights = drawn().double().numpy()
    share = np.exp(2.5 * weights)
    expected = (np.arange(CLASSES)[:, None, None] * share).sum(1) / share.sum(1)
    np.testing.assert_allclose(soft_argmax(drawn(), 2.5).numpy(), expected, rtol=1e-5)


def test_as_printed_equation_6_is_no_mean():
    """Hardness before the exponential: equal weights would not give the middle but far beyond."""
    hardness, weights = 10.0, np.zeros(CLASSES)
    printed = (np.arange(CLASSES) * hardness * np.exp(weights)) / np.exp(hardness * weights).sum()
    assert printed.sum() == pytest.approx(10 * (CLASSES - 1) / 2)
    assert printed.sum() > CLASSES


def test_hardness_leads_from_the_mean_to_the_argmax():
    weights, truth = drawn(), drawn().argmax(1).float()
    distance = [float((soft_argmax(weights, g) - truth).abs().mean()) for g in (0.1, 1, 10, 100)]
    assert distance == sorted(distance, reverse=True)
    top = weights.topk(2, 1).values
    clear = (top[:, 0] - top[:, 1]) > 0.02  # e^-20 beside it at the hardness below
    assert torch.allclose(soft_argmax(weights, 1000)[clear], truth[clear], atol=1e-5)


@given(st.floats(-50, 50), st.integers(0, 99))
def test_soft_argmax_knows_differences_of_weights_alone(shift: float, seed: int):
    weights = drawn(seed)
    assert torch.allclose(soft_argmax(weights + shift), soft_argmax(weights), atol=2e-4)


@given(st.floats(0.1, 100), st.integers(0, 99))
def test_soft_argmax_stays_among_the_classes(hardness: float, seed: int):
    found = soft_argmax(drawn(seed, scale=5), hardness)
    assert found.min() >= 0
    assert found.max() <= CLASSES - 1 + 1e-5


@pytest.mark.parametrize("hardness", [0.5, 1.0, 4.0])
def test_gradient_of_soft_argmax_is_hardness_times_the_distance_from_the_mean(hardness: float):
    """d n' / d phi_k = gamma p_k (k - n'), the covariance of class and weight."""
    weights = drawn().requires_grad_()
    mean = soft_argmax(weights, hardness)
    (gradient,) = torch.autograd.grad(mean.sum(), weights)
    share = torch.softmax(hardness * weights, 1)
    classes = torch.arange(CLASSES).view(1, -1, 1, 1)
    assert torch.allclose(gradient, hardness * share * (classes - mean[:, None]), atol=1e-5)
    assert torch.allclose(gradient.sum(1), torch.zeros(2, 5, 6), atol=1e-5)


def test_gradient_of_soft_argmax_is_its_slope():
    weights, step = drawn(), 1e-2
    moved = torch.zeros_like(weights)
    moved[0, 2, 1, 1] = step
    slope = (soft_argmax(weights + moved) - soft_argmax(weights - moved)).sum() / (2 * step)
    (gradient,) = torch.autograd.grad(soft_argmax(weights.requires_grad_()).sum(), weights)
    assert float(gradient[0, 2, 1, 1]) == pytest.approx(float(slope), abs=2e-3)


def test_half_precision_does_not_round_the_numbers_of_classes():
    """bfloat16 knows no 301: the mean is taken in single precision, under autocast as well."""
    weights = torch.full((1, 358, 1, 1), -60.0)
    weights[0, 301] = 0
    with torch.autocast("cpu", torch.bfloat16):
        assert soft_argmax(weights.bfloat16()).item() == pytest.approx(301, abs=1e-3)


# --- Eq. 7 -------------------------------------------------------------------------------------


def test_cross_entropy_is_minus_the_logarithm_of_the_true_share():
    label, phase, turns = sample()
    weights = drawn().double().numpy()
    share = np.exp(weights) / np.exp(weights).sum(1, keepdims=True)
    true = np.take_along_axis(share, label.numpy()[:, None], 1)
    loss = unwrapping_loss(drawn(), label, phase, turns)
    assert loss.cross_entropy.item() == pytest.approx(float(-np.log(true).mean()), rel=1e-5)


@pytest.mark.parametrize("classes", [2, 21, 358])
def test_knowing_nothing_costs_the_logarithm_of_the_number_of_classes(classes: int):
    zeros = torch.zeros(1, 4, 4)
    loss = unwrapping_loss(torch.zeros(1, classes, 4, 4), zeros.long(), zeros, zeros)
    assert loss.cross_entropy.item() == pytest.approx(math.log(classes), rel=1e-5)


def test_the_right_class_costs_nothing():
    label, phase, turns = sample()
    sure = 80.0 * torch.nn.functional.one_hot(label, CLASSES).movedim(-1, 1).float()
    assert all(float(part) < 1e-6 for part in unwrapping_loss(sure, label, phase, turns))


@pytest.mark.parametrize(("error", "cost"), [(0, 0.0), (1, 0.5), (2, 1.5), (-3, 2.5)])
def test_depth_is_a_smooth_distance_in_wraps(error: int, cost: float):
    label = torch.full((1, 2, 2), 3)
    phase = torch.full((1, 2, 2), 1.0)
    weights = torch.zeros(1, CLASSES, 2, 2)
    weights[:, 3 + error] = 80.0
    loss = unwrapping_loss(weights, label, phase, label + phase / TAU)
    assert loss.depth.item() == pytest.approx(cost, abs=1e-5)


def test_the_measured_phase_carries_its_noise_into_depth():
    """With every wrap right the distance is that of the phase: e^2 / 2 turns^2."""
    label, phase, turns = sample()
    sure = 80.0 * torch.nn.functional.one_hot(label, CLASSES).movedim(-1, 1).float()
    loss = unwrapping_loss(sure, label, phase + 0.3 * TAU, turns)
    assert loss.depth.item() == pytest.approx(0.3**2 / 2, rel=1e-4)


@pytest.mark.parametrize("weight", [0.1, 1.0, 7.5])
def test_the_loss_is_the_sum_of_its_parts(weight: float):
    loss = unwrapping_loss(drawn(), *sample(), depth_weight=weight)
    assert isinstance(loss, Loss)
    assert loss.total.item() == pytest.approx(
        loss.cross_entropy.item() + weight * loss.depth.item(), rel=1e-6
    )
    assert loss.depth > 0


def test_without_weight_there_is_no_loss_on_depth():
    label, phase, turns = sample()
    weights = drawn().requires_grad_()
    loss = unwrapping_loss(weights, label, phase, turns * 1e9, depth_weight=0.0)
    assert loss.depth.item() == 0
    assert loss.total.item() == loss.cross_entropy.item()
    entropy = torch.nn.functional.cross_entropy(weights, label)
    (expected,) = torch.autograd.grad(entropy, weights, retain_graph=True)
    (found,) = torch.autograd.grad(loss.total, weights)
    assert torch.allclose(found, expected, atol=1e-8)


@pytest.mark.parametrize("hardness", [1.0, 3.0])
def test_gradient_of_the_loss_is_that_of_equation_7(hardness: float):
    """p_k - [k = n] from the first part, w s'(d) gamma q_k (k - n') from the second."""
    label, phase, turns = sample()
    turns = turns + 0.4 * torch.randn(turns.shape, generator=torch.Generator().manual_seed(5))
    weights = drawn(scale=2).requires_grad_()
    loss = unwrapping_loss(weights, label, phase, turns, depth_weight=0.1, hardness=hardness)
    (found,) = torch.autograd.grad(loss.total, weights)
    one_hot = torch.nn.functional.one_hot(label, CLASSES).movedim(-1, 1)
    share, hard = (torch.softmax(g * weights.detach(), 1) for g in (1.0, hardness))
    classes = torch.arange(CLASSES).view(1, -1, 1, 1)
    mean = (hard * classes).sum(1)
    pull = (mean + phase / TAU - turns).clamp(-1, 1)
    depth = (pull[:, None] * hardness * hard * (classes - mean[:, None])) * 0.1
    assert torch.allclose(found, (share - one_hot + depth) / label.numel(), atol=1e-6)


def test_gradient_of_the_cross_entropy_is_its_slope():
    label, phase, turns = sample(shape=(1, 2, 2))
    weights = drawn()[:1, :, :2, :2].double().requires_grad_()
    assert torch.autograd.gradcheck(
        lambda w: unwrapping_loss(w, label, phase, turns, depth_weight=0.0).total, (weights,)
    )


# --- masked pixels -----------------------------------------------------------------------------


def masked(mask: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """The sample with nothing known in some pixels: no label, phase and depth not a number."""
    label, phase, turns = sample()
    return (
        torch.where(mask, IGNORED, label),
        torch.where(mask, torch.nan, phase),
        torch.where(mask, torch.nan, turns),
    )


def half() -> Tensor:
    return torch.rand(2, 5, 6, generator=torch.Generator().manual_seed(9)) < 0.5


def test_masked_pixels_have_neither_value_nor_gradient():
    mask, weights = half(), drawn().requires_grad_()
    loss = unwrapping_loss(weights, *masked(mask))
    (gradient,) = torch.autograd.grad(loss.total, weights)
    hidden = mask[:, None].expand_as(gradient)
    assert torch.isfinite(gradient).all()
    assert not gradient[hidden].any()
    assert (gradient[~hidden] != 0).all()
    other = torch.where(hidden, 1e3 * drawn(77), weights.detach())
    assert unwrapping_loss(other, *masked(mask)).total.item() == loss.total.item()


def test_the_loss_is_the_mean_over_what_is_left():
    mask, (label, phase, turns) = half(), sample()
    kept = ~mask
    weights = drawn().movedim(1, -1)[kept].T[None, :, :, None]
    alone = unwrapping_loss(weights, *(one[kept][None, :, None] for one in (label, phase, turns)))
    among = unwrapping_loss(drawn(), *masked(mask))
    for one, other in zip(alone, among, strict=True):
        assert other.item() == pytest.approx(one.item(), rel=1e-5)


@pytest.mark.parametrize("weight", [0.0, 0.1])
def test_where_all_is_masked_nothing_is_learnt(weight: float):
    weights = drawn().requires_grad_()
    loss = unwrapping_loss(weights, *masked(torch.ones(2, 5, 6).bool()), depth_weight=weight)
    assert [float(part.detach()) for part in loss] == [0, 0, 0]
    loss.total.backward()
    assert weights.grad is not None and not weights.grad.any()
