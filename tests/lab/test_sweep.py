"""Parts of the errors of a sweep, and the table of three instruments."""

from functools import partial

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from pytest import mark

from cmtof_lab.interferometer import Interferometer
from cmtof_lab.optical_ranging import OpticalRanger
from cmtof_lab.rf_ranging import RfRanger
from cmtof_lab.sweep import POSITIONS, parts
from cmtof_lab.targets import MIRROR


@given(
    st.floats(-1e-3, 1e-3),
    st.floats(-0.1, 0.1),
    st.floats(0, 1e-4),
    st.integers(0, 2**32 - 1),
)
def test_the_parts_add_up(offset, slope, noise, seed):
    about = POSITIONS - POSITIONS.mean()
    found = parts(
        np.random.default_rng(seed).normal(offset + slope * about, noise, (4, 21))
    )
    total = found.offset**2 + found.slope**2 * about.var() + 19 / 21 * found.scatter**2
    assert_allclose(total, found.rmse**2, rtol=1e-9, atol=1e-20)


@mark.parametrize(
    "ranger",
    [OpticalRanger(), RfRanger(), Interferometer()],
    ids=lambda one: type(one).__name__,
)
def test_repeats_are_days_of_their_own(ranger):
    places = POSITIONS[:3]
    sweep = partial(ranger.sweep, MIRROR, places)
    three = sweep(repeats=3, seed=9)
    assert_array_equal(sweep(repeats=1, seed=9)[0], three[0])
    assert len({row.tobytes() for row in three}) == 3
    assert not np.array_equal(sweep(repeats=1, seed=8)[0], three[0])
    assert abs(three - 0.6 - places).max() < 5e-5
    assert ranger.bound(MIRROR, places).shape == (3,)
