"""Parts of a surface that become surfaces of their own."""

import numpy as np
from exact_scenes import COLUMNS, SHAPE, WRAP, exact_field, plane_depth
from pytest import mark

from cmtof.surfaces.field import CELL
from cmtof.surfaces.parts import cut_surfaces

RIGHT = COLUMNS >= 112
ALL = np.zeros(SHAPE, np.int32)
PIECES = ALL - ((COLUMNS >= 80) & ~RIGHT)


@mark.parametrize(
    "inner, wraps, count",
    [
        (ALL, 5, 2),  # where the beat steps
        (PIECES, 0.2, 2),  # a piece apart that is fitted much better alone
        (PIECES, 0, 1),  # one that gains by noise alone
    ],
)
def test_surfaces_are_cut_where_that_explains_more(rng, inner, wraps, count):
    depth, q = plane_depth()
    field = exact_field(depth + wraps * WRAP * RIGHT, information=200.0, noise_of=rng)
    main, surfaces = cut_surfaces(field, inner, q[None], gain=15.0)
    assert len(surfaces) == count
    same = ((main > 0) == RIGHT[::CELL]).mean()
    assert (max(same, 1 - same) > 0.97) == (count > 1)
