"""The hybrid: offsets of surfaces by the odds of a network and by their own."""

import numpy as np
from pytest import approx, mark
from scipy.stats import norm

from cmtof.hybrid import LEAST, MOVES, elected, means_of_groups
from cmtof.surfaces.contacts import Tied


def surface_off_by(mean, spread):
    """One surface, whose offset is known to a standard deviation, wraps."""
    share = norm.pdf(np.arange(-20, 21), mean, spread)
    return Tied(np.zeros(1), np.zeros(1, int), share[None] / share.sum())


def test_means_are_those_over_the_pixels_of_each_group():
    sure = np.array([5, 5, 9, 4])  # of these wraps is the network sure, by pixel
    odds = np.where(np.arange(21)[:, None] == sure, 0.0, -20.0)
    wraps = np.array([3, 3, 8, 8])
    told = means_of_groups(odds, np.arange(4), wraps, wraps // 8, 3)
    assert told[0, MOVES == 2] == 0  # both pixels lie two wraps behind
    assert told[1, MOVES == 1] == approx(LEAST / 2)  # one of two says so
    assert not told[2].any()  # it has no pixels


@mark.parametrize(
    ("mean", "spread", "moved"),
    [(0.0, 0.1, 0), (0.4, 0.5, 1)],  # a sure offset stands, an unsure one follows
)
def test_the_surer_of_beat_and_network_decides(mean, spread, moved):
    told = np.where(MOVES == 1, 0.0, -1.0)[None]
    assert elected(surface_off_by(mean, spread), told).wraps == moved


def test_doubt_grows_where_beat_and_network_differ():
    before = surface_off_by(0.0, 0.4)
    told = [np.where(move == MOVES, 0.0, -2.0)[None] for move in (0, 1)]
    agreeing, differing = (elected(before, one).odds for one in told)
    assert differing < agreeing
