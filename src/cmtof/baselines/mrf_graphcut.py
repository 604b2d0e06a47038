"""The random field over wraps with a convex prior, its energy lowered by graph cuts.

``E(n) = sum_p U_p(n_p) + jump sum_pq |n_q - n_p - d_pq|`` over the four neighbours. A move lets
every pixel choose between its label and the one ``step`` higher or lower; as the prior is convex,
the best of all these choices is a minimum cut (Kolmogorov and Zabih 2004). Moves by one alone are
those of PUMA (Bioucas-Dias and Valadão 2007), which end in the global minimum where the unary costs
are convex too; larger ones (Bioucas-Dias et al. 2009) leap over the ripples of those that are not.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines.method import Estimate
from cmtof.baselines.mrf import POOLING, RADIUS, Field, semi_global_matching, wrap_field
from cmtof.correlation import TAU
from cmtof.measurement import Measurement

Labels = NDArray[np.integer]

# On the six validation views of `mrf`, released: 37.5, 74.5, 85.3, 1.5 % (delta < 1, 2, 3, >= 10);
# most = 0.2 gave 37.6, 75.7, 85.7, 1.5, but is no longer convex.
JUMP, MOST = 0.03, np.inf
STEPS = (4, -4, 2, -2, 1, -1)
_UNITS = 2.0**36
"""Whole units that the largest cost is counted in: flows are integer."""
_FORBIDDEN = 2**56


class Problem(NamedTuple):
    """An energy over labels (H, W)."""

    unary: Callable[[Labels], NDArray[np.floating]]
    """Cost (H, W) of labels (H, W), all in range."""
    size: int
    """Number of labels N."""
    down: Labels
    """d_pq to the pixel below (H - 1, W)."""
    right: Labels
    """d_pq to the pixel on the right (H, W - 1)."""
    jump: float
    """Cost of a step by one."""
    most: float = np.inf
    """Cost of the largest step; below infinity the prior is no longer convex."""

    def prior(self, step: Labels) -> NDArray[np.floating]:
        """Cost of steps beyond those that the phases tell."""
        return np.minimum(self.jump * np.abs(step), self.most)

    def energy(self, labels: Labels) -> float:
        """E of labels (H, W)."""
        pairs = self.prior(np.diff(labels, axis=0) - self.down).sum()
        pairs += self.prior(np.diff(labels, axis=1) - self.right).sum()
        return float(self.unary(labels).sum(dtype=float) + pairs)


def mrf_graphcut(
    measurement: Measurement,
    *,
    jump: float = JUMP,
    most: float = MOST,
    radius: int = RADIUS,
    pooling: float = POOLING,
    steps: Sequence[int] = STEPS,
    rounds: int = 2,
) -> Estimate:
    """Lower the energy by graph cuts, from where semi-global matching ends.

    Confidence is that of the matching, turned round where the cuts disagree with it.

    Parameters
    ----------
    measurement : Measurement
        At two frequencies.
    jump, most : float
        Cost of a step by one wrap that the phase does not tell, and of the largest step: infinite
        for the convex prior.
    radius, pooling
        See `cmtof.baselines.mrf.wrap_field`.
    steps : sequence of int
        Moves of a round, in wraps.
    rounds : int
        Rounds at most; it ends before if none of the moves helps.

    Raises
    ------
    ValueError
        Unless ``0 < jump <= most``.
    """
    if not 0 < jump <= most or jump == np.inf:
        raise ValueError(
            f"Expected costs 0 < jump <= most, got {jump:g} and {most:g}. Try {JUMP:g} and inf."
        )
    field = wrap_field(measurement, radius=radius, pooling=pooling)
    start, odds = semi_global_matching(field)
    labels = lower(_problem(field, jump, most), start, steps=steps, rounds=rounds)
    changed = np.where(labels == start, odds, np.minimum(odds, 1 - odds))
    return Estimate(field.depth(labels, measurement), changed)


def lower(problem: Problem, labels: Labels, *, steps: Sequence[int], rounds: int) -> Labels:
    """Make moves until none of them lowers the energy, or for so many rounds."""
    energy = problem.energy(labels)
    for _ in range(rounds):
        before = energy
        for step in steps:
            moved = labels + step * best_move(problem, labels, step)
            # costs are rounded to whole units: what gains less than the rounding is not taken
            if (lowered := problem.energy(moved)) < energy:
                labels, energy = moved, lowered
        if energy == before:
            break
    return labels


def best_move(problem: Problem, labels: Labels, step: int) -> NDArray[np.bool_]:
    """Pixels (H, W) whose move by ``step``, all at once, lowers the energy most.

    A pair's costs ``A, B, C, D`` for the choices 00, 01, 10, 11 are ``A + (C - A) x_p + (D - C) x_q
    + (B + C - A - D) (1 - x_p) x_q``. Where a truncated prior makes the last factor negative it is
    raised to zero, which never understates what a move costs.
    """
    from cmtof.baselines.mrf_kernels import minimum_cut

    target = labels + step
    inside = (target >= 0) & (target < problem.size)
    gain = problem.unary(np.where(inside, target, labels)) - problem.unary(labels)
    reach = max(float(np.abs(gain).max()), problem.jump * (1 + abs(step)))
    scale = _UNITS / reach
    excess = np.where(inside, np.rint(gain * scale), _FORBIDDEN).astype(np.int64)
    capacities = []
    for axis, told in ((1, problem.right), (0, problem.down)):
        now = np.diff(labels, axis=axis) - told
        same = _units(problem.prior(now), scale)
        # x_p = 0, x_q = 1 raises the difference, x_p = 1, x_q = 0 lowers it
        ahead = _units(problem.prior(now + step), scale)
        back = _units(problem.prior(now - step), scale)
        back = np.maximum(back, 2 * same - ahead)
        first = (slice(None),) * axis + (slice(None, -1),)
        second = (slice(None),) * axis + (slice(1, None),)
        excess[first] += back - same
        excess[second] += same - back
        capacity = np.zeros((2, *labels.shape), np.int64)
        capacity[(0, *first)] = ahead + back - 2 * same
        capacities.append(capacity)
    return minimum_cut(excess, *capacities)


def _units(cost: NDArray[np.floating], scale: float) -> NDArray[np.int64]:
    return np.rint(cost * scale).astype(np.int64)


def _problem(field: Field, jump: float, most: float) -> Problem:
    cosine, sine = (f(field.angles).astype(np.float32) for f in (np.cos, np.sin))

    def unary(labels: Labels) -> NDArray[np.floating]:
        return -(field.beat[..., 0] * cosine[labels] + field.beat[..., 1] * sine[labels])

    # labels rise where the phase falls by a wrap
    down, right = (-np.rint(np.diff(field.phase, axis=axis) / TAU).astype(int) for axis in (0, 1))
    return Problem(unary, field.angles.size, down, right, jump, most)
