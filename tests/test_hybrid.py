"""The hybrid: offsets of surfaces by the odds of a network and by their own."""

import numpy as np
from pytest import approx, mark

from cmtof.hybrid import LEAST, means_of_surfaces
from cmtof.surfaces.contacts import Borders, offsets_with_contacts
from cmtof.surfaces.placing import Offsets


def test_means_are_those_over_the_pixels_of_each_surface():
    sure = np.array([[5, 5, 9, 4, 0]])  # of these wraps is the network sure, by pixel
    odds = np.where(np.arange(21)[:, None, None] == sure, 0.0, -20.0)
    label = np.array([[0, 0, 1, 1, -1]])
    turns = np.array([[3.5, 3.2, 8.9, 8.0, np.nan]])
    offsets = np.tile(np.arange(-20, 21), (3, 1))
    told = means_of_surfaces(odds, turns, label, offsets)
    assert told[0, 22] == 0  # both pixels lie two wraps behind
    assert told[1, 21] == approx(LEAST / 2)  # one of two says so
    assert told[0, 0] == LEAST  # below the first wrap
    assert not told[2].any()  # it has no pixels


def offset_of_surface(mean, spread, said):
    """Offset of one surface, by itself to a standard deviation, and as a network says."""
    return offsets_with_contacts(
        Offsets(*np.array([[mean], [spread]])),
        Borders(*np.zeros((4, 0), int)),  # it meets no other
        np.array([[-99], [99]]),
        357.5,
        lambda at: np.where(at == said, 0, -2),
    )


@mark.parametrize(
    "mean, spread, moved",
    [(0.0, 0.1, 0), (0.4, 0.5, 1)],  # a sure offset stands, an unsure one follows
)
def test_the_surer_of_beat_and_network_decides(mean, spread, moved):
    assert offset_of_surface(mean, spread, said=1).wraps == moved


def test_doubt_grows_where_beat_and_network_differ():
    agreeing, differing = (offset_of_surface(0.0, 0.4, said).odds for said in (0, 1))
    assert differing < agreeing
