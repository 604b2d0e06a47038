"""Detector, filters and converter against closed forms and Monte Carlo."""

import numpy as np
from numpy.testing import assert_allclose
from pytest import approx, mark
from scipy import signal

from cmtof.correlation import TAU
from cmtof_lab.electronics import (
    Chain,
    counts_from_volts,
    volts_from_counts,
)
from cmtof_lab.settings import TwinSettings

STEP = 1 / 24000


@mark.parametrize("rc_time", [20e-6, 2e-3])
def test_step_response_is_that_of_three_poles(rc_time):
    light = np.r_[0.0, np.ones(199)][None]
    chain = Chain(TwinSettings(rc_time=rc_time), STEP)
    found = chain.run(light, light, np.zeros((1, 201, 3)))[0, 1:]
    poles = -np.array([TAU * 1e5, TAU * 1e4, 1 / rc_time])
    _, expected = signal.step(([], poles, -poles.prod()), T=STEP * np.arange(199))
    assert_allclose(found, expected, atol=1e-9)


def test_filtered_noise_has_its_memory(rng):
    filters = Chain(TwinSettings(rc_time=1e-4), STEP)
    normals = rng.standard_normal((20000, 13, 3))
    still = np.zeros((20000, 12))
    seen = filters.run(still, np.ones_like(still), normals)
    found = [(seen[:, lag:] * seen[:, : 12 - lag]).mean() for lag in range(3)]
    assert_allclose(found, filters.memory(3), rtol=4 * np.sqrt(3 / 20000))
    # one slow pole: density over 4 RC
    slow = TwinSettings(rc_time=1e-2, bandwidth=1e8, low_pass=1e8)
    assert Chain(slow, STEP).memory(1)[0] == approx(25.0, rel=1e-3)


def test_counts_and_volts_invert_each_other():
    volts = np.linspace(-10, 9.9, 101)
    back = volts_from_counts(counts_from_volts(volts))
    assert_allclose(back, volts, rtol=0, atol=0.51 * 3.15805780e-4)
    assert counts_from_volts([-99, 99]).tolist() == [0, 65535]
