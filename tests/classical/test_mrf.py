"""Random fields: one row is a Viterbi chain, cuts are the least of all, planes are exact."""

from itertools import product

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from pytest import approx, mark
from scipy.special import softmax

import cmtof
from cmtof.classical import mrf
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU


def random_field(rng, height, width, labels):
    return mrf.RandomField(
        rng.uniform(0, TAU, (height, width)).astype(np.float32),
        rng.normal(0, 2 * mrf.JUMP, (height, width, 2))
        .astype(np.float32)
        .view("c8")[..., 0],
        rng.normal(size=(2, labels)).astype(np.float32),
        0,
    )


@mark.parametrize("labels", [1, 2, 5])
@mark.parametrize("shape", [(1, 6), (6, 1)])
def test_one_row_is_the_best_chain(rng, shape, labels):
    """Of all chains, tried one after the other."""
    field = random_field(rng, *shape, labels)
    chains = np.array([*product(range(labels), repeat=6)])
    steps = abs(np.diff(chains) + np.rint(np.diff(field.phase.ravel()) / TAU))
    cost = np.minimum(mrf.JUMP * steps, mrf.MOST).sum(1)
    cost += [field.unary(one.reshape(shape)).sum() for one in chains]
    found, odds = mrf.semi_global_labels(field)
    least = [
        [cost[pixel == label].min() for label in range(labels)] for pixel in chains.T
    ]
    assert found.ravel().tolist() == np.argmin(least, axis=1).tolist()
    share = softmax(np.divide(least, -mrf._TEMPERATURE), axis=1).max(1)
    assert odds.ravel() == approx(share, rel=1e-3)


@mark.parametrize("method", ["mrf", "mrf-graphcut"])
@mark.parametrize("hole", [0, 3])
@mark.parametrize("pair", [FREQUENCIES, (7.16e9, 14.30e9), (7.15e9, 7.16e9)])
def test_planes_without_noise_are_exact_across_holes(
    exact, tilted_wall, pair, hole, method
):
    depth = tilted_wall.depth.copy()
    depth[:, 21 : 21 + hole] = np.nan
    limits = {"range_min": 0.7547, "range_max": 1.195}
    m = exact(depth, pair, mask=np.isfinite(depth), **limits)
    assert_allclose(cmtof.unwrap(m, method=method).depth, depth, rtol=0, atol=1e-6)


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, -1, 2]))
def test_a_move_is_the_best_of_all(seed, step):
    rng = np.random.default_rng(seed)
    field = random_field(rng, 2, 4, 5)
    labels = rng.integers(0, 5, (2, 4))
    moved = labels + step * mrf.best_move(field, labels, step)
    others = labels + step * np.reshape([*product((0, 1), repeat=8)], (-1, 2, 4))
    inside = [x for x in others if set(x.flat) <= set(range(5))]
    least = min(mrf.energy(field, x) for x in inside)
    assert mrf.energy(field, moved) == approx(least, abs=1e-6)
