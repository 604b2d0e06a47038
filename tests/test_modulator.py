"""The two-pass modulator against its equations and its Bessel series."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from pytest import approx, mark
from scipy.special import jv

from cmtof import jones
from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU
from cmtof.modulator import (
    DOUBLED,
    SINGLE,
    TwoPassModulator,
    doubled_mode_harmonics,
    single_mode_harmonics,
)

THETA = np.linspace(0, TAU, 101)
small = st.floats(-0.3, 0.3, allow_subnormal=False)
voltages = st.floats(-3, 3)


@given(voltages)
def test_fields_are_those_of_equations_14_and_17(voltage):
    """Both up to the global phase -1."""
    single = 1j * (np.cos(voltage) - np.sin(voltage)) / np.sqrt(2)
    assert_allclose(SINGLE.states(voltage)["PBS out"], [-single, 0], atol=1e-14)
    assert_allclose(
        DOUBLED.states(voltage)["PBS out"], [1j * np.sin(voltage), 0], atol=1e-14
    )


@given(voltages, voltages, voltages)
def test_half_wave_plate_sets_the_bias_and_cancels_static_birefringence(
    voltage, angle, static
):
    modulator = replace(SINGLE, half_wave_angle=angle, static_retardance=static)
    expected = (1 + np.cos(8 * angle + 2 * voltage + 2 * static)) / 2
    assert modulator.transmission(voltage) == approx(expected, abs=1e-13)


@mark.parametrize("eta", [0.26, 1.527])
@mark.parametrize(
    "mode, series",
    [(SINGLE, single_mode_harmonics), (DOUBLED, doubled_mode_harmonics)],
)
def test_harmonics_equal_bessel_values(mode, series, eta):
    assert_allclose(
        replace(mode, eta=eta).harmonics(24), series(eta, 24), rtol=0, atol=1e-12
    )


erroneous = st.builds(
    TwoPassModulator,
    half_wave_angle=st.floats(0, np.pi),
    quarter_wave_angle=st.floats(0, np.pi),
    eta=st.floats(0, 3),
    mirror_distance=st.one_of(st.none(), st.floats(0, 0.1)),
    input_axis=st.sampled_from(["vertical", "horizontal"]),
    half_wave_retardance_error=small,
    half_wave_angle_error=small,
    quarter_wave_retardance_error=small,
    quarter_wave_angle_error=small,
    transmitted_extinction=st.floats(2, 1e5),
    reflected_extinction=st.floats(2, 1e5),
    eom_angle_error=small,
    static_retardance=small,
    mirror_reflectance=st.floats(0, 1),
)


@settings(max_examples=40, deadline=None)
@given(erroneous)
def test_the_two_ports_share_what_the_mirror_returns(modulator):
    other = replace(modulator, output="returned")
    wave = modulator.waveform(THETA)
    assert wave.min() >= 0
    assert wave.max() <= 1 + 1e-12
    total = wave + other.waveform(THETA)
    entered = jones.intensity(modulator.states(0.0)["PBS in"])
    assert_allclose(total, modulator.mirror_reflectance * entered, atol=1e-12)


@mark.parametrize("mode", [SINGLE, DOUBLED])
def test_horizontal_input_of_section_7_gives_the_light_of_vertical_input(mode):
    """The off-diagonal elements of a unitary matrix are equal in magnitude."""
    horizontal = replace(mode, input_axis="horizontal")
    assert_allclose(horizontal.waveform(THETA), mode.waveform(THETA), atol=1e-14)


@mark.parametrize("eta", [0.26, np.pi / 4])
def test_modes_have_their_depth_and_throughput(eta):
    bright = replace(DOUBLED, output="returned", eta=eta)
    assert bright.throughput() == approx((1 + jv(0, 2 * eta)) / 2, abs=1e-14)
    modulator = replace(SINGLE, eta=eta)
    assert modulator.modulation_depth() == approx(2 * jv(1, 2 * eta), abs=1e-14)
    assert modulator.throughput() == approx(0.5, abs=1e-14)


def test_doubled_drive_on_the_single_modes_spacing_is_late_by_9_mrad():
    mode = replace(DOUBLED, mirror_distance=SPEED_OF_LIGHT / (2 * SINGLE.frequency))
    assert mode.pass_delay == approx(8.8e-3, abs=5e-5)
    assert mode.effective_eta == approx(DOUBLED.eta * (1 - mode.pass_delay**2 / 8))


@given(st.floats(0, 0.2), st.sampled_from([SINGLE, DOUBLED]))
def test_delay_scales_the_drive_and_shifts_the_waveform(distance, mode):
    delayed = replace(mode, mirror_distance=distance)
    shifted = replace(mode, eta=delayed.effective_eta).waveform(
        THETA + delayed.pass_delay / 2
    )
    assert_allclose(delayed.waveform(THETA), shifted, atol=1e-12)
