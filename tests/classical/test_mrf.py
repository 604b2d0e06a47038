"""Random fields: one row is a Viterbi chain, cuts are the least of all, planes are exact."""

from itertools import product

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from pytest import approx, mark

import cmtof
from cmtof.classical import mrf
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU


def plane(height, width):
    y, x = np.mgrid[:height, :width]
    return 0.8 + 0.2 * x / width + 0.1 * y / height


def random_field(rng, height, width, labels):
    return mrf.Field(
        rng.uniform(0, TAU, (height, width)).astype(np.float32),
        (2 * mrf.JUMP * rng.normal(size=(height, width, 2))).astype(np.float32),
        np.linspace(0, 2.5, labels),
        0,
    )


def viterbi(cost, step):
    """Least cost of a chain through each label at each of its pixels (W, N), pair by pair."""
    n = np.arange(cost.shape[1])
    ends = []
    for order in (1, -1):
        total = [cost[::order][0]]
        signed = step if order == 1 else -step[::-1]
        for own, d in zip(cost[::order][1:], signed, strict=True):
            pair = np.minimum(mrf.JUMP * np.abs(n[None, :] - n[:, None] - d), mrf.MOST)
            total.append(own + (total[-1][:, None] + pair).min(axis=0))
        ends.append(np.array(total)[::order])
    return ends[0] + ends[1] - cost


@mark.parametrize("labels", [1, 2, 7, 21])
@mark.parametrize("shape", [(1, 40), (40, 1)])
def test_one_row_is_the_best_chain(rng, shape, labels):
    field = random_field(rng, *shape, labels)
    phase = field.phase.ravel()
    step = np.rint((phase[:-1] - phase[1:]) / TAU)
    unary = np.stack(
        [field.unary(np.full(shape, one)).ravel() for one in range(labels)], axis=1
    )
    cost = viterbi(unary.astype(float), step)
    least = cost.min(axis=1, keepdims=True)
    found, odds = mrf.semi_global_labels(field)
    assert_allclose(np.take_along_axis(cost, found.reshape(40, 1), 1), least, atol=1e-5)
    share = np.exp(-(cost - least) / mrf._TEMPERATURE).sum(axis=1)
    assert_allclose(odds.ravel(), 1 / share, rtol=1e-3)


@mark.parametrize("method", ["mrf", "mrf-graphcut"])
@mark.parametrize("hole", [0, 3])
@mark.parametrize("pair", [FREQUENCIES, (7.16e9, 14.30e9), (7.15e9, 7.16e9)])
def test_planes_without_noise_are_exact_across_holes(exact, pair, hole, method):
    depth = plane(40, 50)
    known = np.ones(depth.shape, bool)
    known[:, 21 : 21 + hole] = False
    shape = np.where(known, depth, np.nan)
    m = exact(shape, pair, mask=known, truth=depth, range_min=0.7547, range_max=1.195)
    assert (
        np.abs((cmtof.unwrap(m, method=method).depth - depth).to_numpy()[known]).max()
        < 1e-6
    )


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, -1, 2]))
def test_a_move_is_the_best_of_all(seed, step):
    rng = np.random.default_rng(seed)
    field = random_field(rng, 2, 4, 5)
    labels = rng.integers(0, 5, (2, 4))
    moved = labels + step * mrf.best_move(field, labels, step)
    others = [labels + step * np.reshape(x, (2, 4)) for x in product((0, 1), repeat=8)]
    inside = [x for x in others if x.min() >= 0 and x.max() < 5]
    assert mrf.energy(field, moved) == approx(
        min(mrf.energy(field, x) for x in inside), abs=1e-6
    )
