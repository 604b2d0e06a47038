"""Walls, their light, and how deep a wrap is."""

import numpy as np

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import wrap_length
from cmtof.frame import Frame

WRAP = wrap_length(FREQUENCY_SINGLE)  # m


def lit(depth, light=1.0, camera=None):
    """Frame of a depth (H, W), m, in even light."""
    return Frame(depth, np.full(depth.shape, light), camera)


def flat_wall(side, depth, light=1.0):
    """Square wall: its side, px, its depth, m, and its brightness."""
    return lit(np.full((side, side), depth), light)
