"""Boxes by their limits."""

import numpy as np
from pytest import approx, mark

from cmtof_rooms.boxes import Box
from cmtof_rooms.solids import join
from cmtof_rooms.things import meshes_of

CUBE = Box(0.0, 1.0, 0.0, 1.0, 0.0, 1.0)


@mark.parametrize(
    ("other", "meets"),
    [
        (Box(0.2, 0.8, 0.2, 0.8, 0.0, 1.0), True),
        (Box(0.9, 2.0, 0.9, 2.0, 0.0, 1.0), True),
        (Box(1.0, 2.0, 0.0, 1.0, 0.0, 1.0), False),
        (Box(0.0, 1.0, 1.5, 2.0, 0.0, 1.0), False),
    ],
)
def test_boxes_meet_only_where_they_share_more_than_a_side(other, meets):
    assert CUBE.meets([other]) == meets
    assert other.meets([CUBE]) == meets


@mark.parametrize("axis", ["x", "y", "z"])
def test_an_inset_lies_inside_at_its_side_and_that_of_an_axis_at_both(axis):
    low, high = axis + "0", axis + "1"
    assert CUBE.inset(**{low: 0.25}) == CUBE.cut(**{low: 0.25})
    assert CUBE.inset(**{high: 0.25}) == CUBE.cut(**{high: 0.75})
    assert CUBE.inset(**{axis: 0.25}) == CUBE.cut(**{low: 0.25, high: 0.75})


def test_limits_that_are_arrays_stand_for_several_boxes():
    ends = CUBE.ends("x", 0.25)
    assert ends.singles() == [CUBE.cut(x1=0.25), CUBE.cut(x0=0.75)]
    assert join(meshes_of([ends])).volume == approx(0.5)
    bars = CUBE.bars("z", np.array([0.2, 0.5, 0.9]), 0.01)
    assert [bar.z0 for bar in bars.singles()] == approx([0.19, 0.49, 0.89])
