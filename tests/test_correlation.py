"""Correlation: closed forms, round trips, symmetries."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from pytest import approx, mark

from cmtof import correlation as co
from cmtof.correlation import TAU
from cmtof.hardware.reduction import nominal_psi
from cmtof.modulator import SINGLE
from cmtof.simulation import QUADRATURES
from cmtof.waveform import gate, waveform_from_harmonics

angles = st.floats(0, TAU, exclude_max=True)


@given(angles, angles)
def test_harmonic_sum_equals_the_time_integral_of_any_waveforms(phase, psi):
    """Brute force: the mean of p(t - tau) r(t) over one period."""
    p = SINGLE.harmonics(12)
    r = gate(12)
    theta = TAU * np.arange(4096) / 4096
    product = waveform_from_harmonics(p, theta - phase)
    product *= waveform_from_harmonics(r, theta + psi)
    fast = co.correlation_from_harmonics(p, r, phase=phase, psi=psi)
    assert fast == approx(product.mean(), abs=1e-12)


@given(
    st.lists(st.integers(0, 62), min_size=3, max_size=9, unique=True),
    angles,
    st.floats(0.1, 1e4),
    st.floats(-1e4, 1e4),
)
def test_decoding_undoes_encoding_for_any_distinct_psi(steps, phase, amplitude, offset):
    psi = 0.1 * np.array(steps)
    c = co.correlation_from_phase([phase], psi, amplitude=amplitude, offset=offset)
    decoded = co.decode(c, psi)
    # neighbouring steps 0.1 rad apart make the fit up to 1e3 times less certain
    assert abs(co.centred(decoded.phase - phase)) < 1e-6 * (1 + abs(offset) / amplitude)
    assert decoded.amplitude == approx(amplitude, rel=1e-6, abs=1e-6 * abs(offset))


@mark.parametrize("steps", [3, 4, 16])
def test_decoding_in_single_precision_errs_by_less_than_5_microradians(rng, steps):
    psi = rng.permutation(nominal_psi(steps))
    phase = rng.uniform(0, TAU, (40, 101))
    phase[0, :6] = [0, np.pi / 4, np.pi / 2, np.pi, 3 * np.pi / 2, TAU - 1e-7]  # seams
    amplitude = rng.uniform(10, 6366, phase.shape)
    # float32 counts carry half an ulp each: compare with float64 arithmetic on the same counts
    c = co.correlation_from_phase(
        phase, psi, amplitude=amplitude, offset=amplitude * 1.6
    )
    c = c.astype(np.float32)
    fast = co.decode(c, psi)
    exact = co.decode(c.astype(float), psi)
    assert fast.phase.dtype == np.float32
    assert abs(co.centred(fast.phase - exact.phase)).max() < 5e-6
    assert_allclose(fast.amplitude, exact.amplitude, rtol=1e-5, atol=1e-2)
    assert_allclose(fast.offset, exact.offset, rtol=1e-5)
    assert fast.phase.min() >= 0
    assert fast.phase.max() < TAU


def test_types_of_phase_and_depth_cost_no_precision():
    whole = co.correlation_from_phase([0, 1], [0.5])
    assert_allclose(whole, np.cos([[0.5, 1.5]]))
    single = np.float32(7.3)
    found = co.phase_from_depth(single, 14.32e9)
    assert found == approx(co.phase_from_depth(float(single), 14.32e9), rel=1e-12)


def test_darkness_decodes_to_a_finite_phase():
    decoded = co.decode(np.zeros((4, 5), np.float32), QUADRATURES)
    assert not decoded.phase.any()
    assert not decoded.amplitude.any()


def test_residual_noise_finds_the_noise_of_the_samples(rng):
    psi = nominal_psi(6)
    signal = co.correlation_from_phase(
        rng.uniform(0, 6, 50_000), psi, amplitude=100.0, offset=200.0
    )
    noise = co.residual_noise(signal + 7.0 * rng.normal(size=signal.shape), psi)
    assert noise == approx(7.0, rel=0.02)


@given(st.floats(0, 20), st.sampled_from([0.1e9, 7.15e9, 14.32e9]))
def test_depth_comes_back_from_its_phase_and_from_its_wraps(depth, frequency):
    unwrapped = co.phase_from_depth(depth, frequency)
    assert co.depth_from_phase(unwrapped, frequency) == approx(depth, abs=1e-12)
    phase = co.wrapped(unwrapped)
    wraps = co.consistent_wrap_count(depth, phase, frequency)
    assert co.depth_from_wraps(phase, wraps, frequency) == approx(depth, abs=1e-9)
    assert abs(int(wraps) - int(co.wrap_count_from_depth(depth, frequency))) <= 1


@given(st.floats(-1e6, 1e6))
def test_wrapping_keeps_the_angle_and_stays_in_range(phase):
    angles = np.array([co.wrapped(phase), co.centred(phase)])
    assert 0 <= angles[0] < TAU
    assert -np.pi <= angles[1] < np.pi
    assert_allclose(np.exp(1j * angles), np.exp(1j * phase), atol=1e-9)


def test_wrapping_never_rounds_up_to_two_pi():
    assert co.wrapped(-1e-20) == 0.0
    assert co.wrapped(np.float32(-1e-9)) < TAU
