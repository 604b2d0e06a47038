"""The door: what becomes of an estimate."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal
from pytest import fixture, mark
from walls import WRAP

import cmtof
from cmtof.estimate import Estimate
from cmtof.methods import METHODS, Method


@fixture
def answering(monkeypatch):
    """A method that answers with a given depth."""

    def method(depth):
        def run(measurement):
            return Estimate(
                np.broadcast_to(depth, measurement.shape), np.ones(measurement.shape)
            )

        monkeypatch.setitem(METHODS, "given", Method("given", "trivial", "", run))
        return "given"

    return method


def test_depth_is_the_measured_phase_with_the_nearest_wraps(exact, answering, rng):
    """Any estimate within half a wrap gives the depth of the phase itself."""
    depth = rng.uniform(1.0, 7.0, (20, 20))
    estimate = depth + rng.uniform(-0.49, 0.49, depth.shape) * WRAP
    result = cmtof.unwrap(exact(depth), method=answering(estimate))
    assert_allclose(result.depth, depth, atol=1e-6)
    assert_array_equal(result.wrap_count, np.floor(estimate / WRAP))


@mark.parametrize("estimate, end", [(-3.0, 27), (0.0, 27), (99.0, 32)])
def test_estimates_out_of_range_end_at_its_wraps(exact, answering, rng, estimate, end):
    # rounding carries both of these across a boundary of wraps
    ends = (27 * WRAP, 33 * WRAP)
    m = exact(rng.uniform(*ends, (20, 20)))
    result = cmtof.unwrap(m, method=answering(estimate), range=ends)
    assert_allclose(result.depth, np.clip(result.depth, *ends))
    assert (result.wrap_count == end).all()


def test_attributes_state_method_range_and_options(exact):
    result = cmtof.unwrap(
        exact(np.ones((4, 5))), method="beat", window=3, range=(0.5, 2.0)
    )
    assert result.attrs["method"] == "beat"
    assert result.attrs["option_window"] == 3
    assert (result.attrs["range_min"], result.attrs["range_max"]) == (0.5, 2.0)
