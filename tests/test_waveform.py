"""Fourier coefficients of periodic waveforms: round trips, closed forms, the low pass."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.testing import assert_allclose
from pytest import approx

from cmtof.correlation import TAU
from cmtof.waveform import (
    gate,
    harmonics_from_waveform,
    low_pass_harmonics,
    waveform_from_harmonics,
)

finite = st.floats(-10, 10, allow_subnormal=False)


@given(hnp.arrays(float, st.tuples(st.integers(1, 3), st.just(9)), elements=finite))
def test_an_odd_number_of_samples_comes_back_from_its_harmonics(samples):
    theta = TAU * np.arange(9) / 9
    back = waveform_from_harmonics(harmonics_from_waveform(samples, 4), theta)
    assert_allclose(back, samples, atol=1e-12)


def test_gate_is_the_series_of_the_square_wave():
    wave = waveform_from_harmonics(gate(4001), [0.0, 1.0, 2.5, np.pi, np.pi / 2])
    assert_allclose(wave, [1, 1, 0, 0, 0.5], atol=3e-4)


def test_low_pass_halves_the_power_at_its_cutoff_and_keeps_the_mean():
    passed = low_pass_harmonics([1.0, 1.0, 1.0], frequency=12e9, cutoff=12e9)
    assert_allclose(abs(passed) ** 2, [1, 1 / 2, 1 / 5], rtol=1e-14)
    assert np.angle(passed[1]) == approx(-np.pi / 4)
