"""Losses: closed forms of Eq. 6 and 7, gradients, and nothing from masked pixels."""

import math

import torch
from pytest import approx, fixture, mark
from torch.autograd import gradcheck

from cmtof.correlation import TAU
from cmtof.network.losses import (
    IGNORED,
    WRAP_MM,
    regression_loss,
    soft_argmax,
    unwrapping_loss,
)

N = 7


@fixture
def pixels():
    """Weights, labels, phases and turns; the first row is masked and not a number."""
    generator = torch.Generator().manual_seed(0)
    weights = torch.randn((1, N, 3, 4), generator=generator, dtype=torch.float64)
    label = torch.randint(N, (1, 3, 4), generator=generator)
    phase = TAU * torch.rand((1, 3, 4), generator=generator, dtype=torch.float64)
    turns = label + phase / TAU
    label[0, 0] = IGNORED
    turns[0, 0] = math.nan
    return weights, label, phase, turns


def test_soft_argmax_is_the_mean_class_and_hardens_to_the_argmax():
    weights = torch.tensor([[0.0, math.log(2), math.log(3)]])
    assert soft_argmax(weights)[0] == approx((2 + 2 * 3) / 6)
    assert soft_argmax(weights, 1e3)[0] == approx(2)


def test_gradient_of_the_cross_entropy_is_probability_minus_truth(pixels):
    weights, label, phase, turns = pixels
    weights.requires_grad_()
    unwrapping_loss(weights, label, phase, turns, depth_weight=0).backward()
    kept = label != IGNORED
    truth = torch.nn.functional.one_hot(label.clamp(min=0), N).movedim(-1, 1)
    closed = (torch.softmax(weights, 1) - truth) * kept[:, None] / kept.sum()
    assert torch.allclose(weights.grad, closed)
    assert gradcheck(lambda w: unwrapping_loss(w, label, phase, turns + 0.2), weights)


@mark.parametrize("off", [1, 5])
def test_depth_term_counts_millimetres(off):
    """A sharp answer n wraps off costs w (21 n - 1/2), Huber's distance of width 1 mm."""
    weights = torch.full((1, N, 1, 1), -1e3)
    weights[0, off] = 1e3
    label = torch.zeros(1, 1, 1, dtype=torch.long)
    phase = torch.ones(1, 1, 1)
    given = weights.double(), label, phase, phase / TAU
    depth = unwrapping_loss(*given, depth_weight=0.1) - unwrapping_loss(
        *given, depth_weight=0
    )
    assert depth == approx(0.1 * (WRAP_MM * off - 0.5), rel=1e-5)


def test_regression_counts_wraps_over_classes_and_the_slope(pixels):
    _, label, _, turns = pixels
    found = torch.nan_to_num(turns[:, None]) + 0.5
    loss = regression_loss(found, label, turns, classes=N)
    assert loss == approx(0.5 / N)
    flat = torch.full_like(found, 2.0)
    smooth, plain = (
        regression_loss(flat, label, turns, classes=N, smoothness=s) for s in (1, 0)
    )
    assert torch.equal(smooth, plain)
    assert regression_loss(found, label, turns, classes=N, smoothness=1.0) > loss


def masked_loss(pixels, label):
    """Both losses together, and the gradients of what they were given."""
    weights, _, phase, turns = pixels
    w = weights.clone().requires_grad_()
    found = weights[:, :1].clone().requires_grad_()
    total = unwrapping_loss(w, label, phase, turns)
    total = total + regression_loss(found, label, turns, classes=N, smoothness=1)
    total.backward()
    return total, (w.grad, found.grad)


def test_masked_pixels_have_no_gradient(pixels):
    _, gradients = masked_loss(pixels, pixels[1])
    for gradient in gradients:
        assert torch.isfinite(gradient).all()
        assert not gradient[:, :, 0].any()


def test_an_image_of_masked_pixels_costs_nothing(pixels):
    loss, gradients = masked_loss(pixels, torch.full_like(pixels[1], IGNORED))
    assert loss == 0
    assert not any(gradient.any() for gradient in gradients)
