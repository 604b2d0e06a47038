"""Boxes by their limits; examples in their docstrings touch and are inset."""

import numpy as np
from pytest import approx

from cmtof_rooms.boxes import Box
from cmtof_rooms.solids import join
from cmtof_rooms.things import meshes_of

CUBE = Box(0.0, 1.0, 0.0, 1.0, 0.0, 1.0)


def test_boxes_that_share_little_meet_from_either_side():
    other = Box(0.9, 2.0, 0.9, 2.0, 0.0, 1.0)
    assert CUBE.meets([other])
    assert other.meets([CUBE])


def test_limits_that_are_arrays_stand_for_several_boxes():
    ends = CUBE.ends("x", 0.25)
    assert ends.singles() == [CUBE.cut(x1=0.25), CUBE.cut(x0=0.75)]
    assert join(meshes_of([ends])).volume == approx(0.5)
    bars = CUBE.bars("z", np.array([0.2, 0.5, 0.9]), 0.01)
    assert [bar.z0 for bar in bars.singles()] == approx([0.19, 0.49, 0.89])
