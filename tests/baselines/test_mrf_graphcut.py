"""Graph cuts: least cuts and least energies against all that there are, on small images."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cmtof
from cmtof.baselines import mrf
from cmtof.baselines.mrf_graphcut import Problem, _problem, best_move, lower
from cmtof.baselines.mrf_kernels import minimum_cut

seeds = st.integers(0, 2**32 - 1)


def random_problem(rng, height, width, labels, *, convex, most=np.inf):
    """Random unary costs, those of a convex function of the label if asked for."""
    n = np.arange(labels)
    if convex:
        turn = rng.uniform(-1, labels, (height, width, 1))
        costs = rng.uniform(0.1, 3, (height, width, 1)) * np.abs(n - turn) ** 1.7
    else:
        costs = rng.uniform(0, 3, (height, width, labels))

    def unary(chosen):
        return np.take_along_axis(costs, chosen[..., None], 2)[..., 0]

    down, right = rng.integers(-1, 2, (height - 1, width)), rng.integers(-1, 2, (height, width - 1))
    return Problem(unary, labels, down, right, rng.uniform(0.1, 2), most)


def cut_cost(x, excess, right, down):
    def between(p, q, ahead, back):
        return (ahead * (1 - p) * q + back * (1 - q) * p).sum()

    return (
        (excess * x).sum()
        + between(x[:, :-1], x[:, 1:], right[0, :, :-1], right[1, :, :-1])
        + between(x[:-1], x[1:], down[0, :-1], down[1, :-1])
    )


@given(seeds)
def test_minimum_cut_is_the_least_of_all(seed):
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(1, 4, 2))
    excess = rng.integers(-9, 10, shape)
    right, down = rng.integers(0, 6, (2, 2, *shape))
    every = [np.reshape(x, shape) for x in product((0, 1), repeat=excess.size)]
    least = min(cut_cost(x, excess, right, down) for x in every)
    found = minimum_cut(excess, right, down).astype(int)
    assert cut_cost(found, excess, right, down) == least
    # of equal minima it has the fewest ones
    fewest = min(x.sum() for x in every if cut_cost(x, excess, right, down) == least)
    assert found.sum() == fewest


@given(seeds, st.sampled_from([1, -1, 2, -2, 4]), st.sampled_from([np.inf, 1.0]))
def test_a_move_never_raises_the_energy(seed, step, most):
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(1, 9, 2))
    problem = random_problem(rng, *shape, 6, convex=False, most=most)
    problem = problem._replace(jump=min(problem.jump, most))
    labels = rng.integers(0, 6, shape)
    moved = labels + step * best_move(problem, labels, step)
    assert moved.min() >= 0
    assert moved.max() < 6
    assert problem.energy(moved) <= problem.energy(labels) + 1e-7


@given(seeds, st.sampled_from([1, -1, 2]))
def test_a_move_is_the_best_of_all(seed, step):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, 2, 4, 5, convex=False)
    labels = rng.integers(0, 5, (2, 4))
    moved = problem.energy(labels + step * best_move(problem, labels, step))
    others = []
    for x in product((0, 1), repeat=8):
        other = labels + step * np.reshape(x, (2, 4))
        if other.min() >= 0 and other.max() < 5:
            others.append(problem.energy(other))
    assert moved == pytest.approx(min(others), abs=1e-7)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_convex_energies_end_in_the_minimum_of_all(seed):
    """Nine pixels, four labels: 262 144 labellings, of which descent finds the best."""
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, 3, 3, 4, convex=True)
    every = np.stack(np.meshgrid(*[np.arange(4)] * 9, indexing="ij"), -1).reshape(-1, 3, 3)
    grid = np.broadcast_to(np.arange(4)[:, None, None], (4, 3, 3))
    table = np.stack([problem.unary(labels) for labels in grid])
    y, x = np.mgrid[:3, :3]
    energies = table[every, y, x].sum(axis=(1, 2))
    energies += problem.prior(np.diff(every, axis=1) - problem.down).sum(axis=(1, 2))
    energies += problem.prior(np.diff(every, axis=2) - problem.right).sum(axis=(1, 2))
    found = lower(problem, np.zeros((3, 3), int), steps=(1, -1), rounds=50)
    assert problem.energy(found) == pytest.approx(energies.min(), abs=1e-7)


@given(seeds)
def test_turning_the_image_keeps_the_convex_minimum(seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, 5, 7, 6, convex=True)
    turned = problem._replace(
        unary=lambda n: problem.unary(n.T).T, down=problem.right.T, right=problem.down.T
    )
    start = rng.integers(0, 6, (5, 7))
    one = problem.energy(lower(problem, start, steps=(1, -1), rounds=50))
    two = turned.energy(lower(turned, start.T, steps=(1, -1), rounds=50))
    assert one == pytest.approx(two, abs=1e-7)


@pytest.mark.parametrize("most", [np.inf, 0.1])
def test_cuts_lower_the_energy_of_a_measurement(measured, most):
    field = mrf.wrap_field(measured)
    problem = _problem(field, 0.03, most)
    start, _ = mrf.semi_global_matching(field)
    energies = [
        problem.energy(lower(problem, start, steps=steps, rounds=2))
        for steps in ((1, -1), (4, -4, 2, -2, 1, -1))
    ]
    assert energies[0] <= problem.energy(start)
    assert energies[1] <= problem.energy(start)


def test_bad_costs_are_refused(measured):
    with pytest.raises(ValueError, match="0 < jump <= most"):
        cmtof.unwrap(measured, method="mrf-graphcut", jump=-1.0)
