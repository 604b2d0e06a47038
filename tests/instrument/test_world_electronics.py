"""Detector, filters and converter against closed forms and an independent simulation."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from cmtof.hardware.codecs.labjack import NOMINAL
from cmtof.instrument.electronics import (
    ELEMENTARY_CHARGE,
    Conversion,
    chain,
    counts_from_volts,
    volts_from_counts,
)
from cmtof.instrument.settings import Detector

RATE = 24000.0


def test_conversion_from_the_data_sheet():
    """53 A/W at 800 nm and M = 100 is a quantum efficiency of 0.82, and 2.65e9 V/W."""
    peak = Conversion(Detector(gain=100.0, efficiency=0.8214), 800e-9)
    assert peak.responsivity * 100 == pytest.approx(53.0, rel=1e-3)
    assert peak.volts_per_watt == pytest.approx(2.65e9, rel=1e-3)
    # saturation power 1.54 nW at M = 100
    assert float(peak.volts(1.53e-9)) == pytest.approx(1.53e-9 * 2.65e9, rel=2e-3)
    assert float(peak.volts(1.6e-9)) == 4.1
    assert peak.excess_noise == pytest.approx(100**0.3)


def test_noise_density():
    conversion = Conversion(Detector(), 532e-9)
    power = 4e-10
    volts = conversion.volts(power)
    current = power * conversion.responsivity
    shot = 2 * ELEMENTARY_CHARGE * current * 50**0.3 * (50 * 5e7) ** 2
    assert conversion.density(volts) == pytest.approx(shot + (3.5e-15 * 2.65e9) ** 2)
    assert np.sqrt(conversion.density(0.0)) == pytest.approx(9.275e-6)


def test_rc_of_the_paper_damps_the_sweep_47_times():
    """75 Hz through 100 ms, and through 10 kHz and 100 kHz, sampled at 24 kS/s (erratum 12)."""
    filters = chain(replace(Detector(), rc_time=0.1), 1 / RATE)
    count = 320 * 200
    time = np.arange(count) / RATE
    wave = np.cos(2 * np.pi * 75 * time)[None]
    output = filters.run(wave, np.zeros_like(wave), None)[0, -320 * 20 :]
    spectrum = np.abs(np.fft.rfft(output - output.mean())) / output.size * 2
    assert 1 / spectrum.max() == pytest.approx(np.hypot(1, 2 * np.pi * 75 * 0.1), rel=1e-3)
    assert round(1 / spectrum.max()) == 47
    fast = chain(Detector(), 1 / RATE).run(wave, np.zeros_like(wave), None)[0, -320 * 20 :]
    assert np.abs(np.fft.rfft(fast)).max() / fast.size * 2 == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("rc_time", [20e-6, 1 / (2 * np.pi * 1e4), 1e-3, 0.1])
def test_filters_equal_an_independent_simulation(rc_time):
    """scipy.signal.lsim of held light on a fine grid; equal poles included."""
    detector = replace(Detector(), rc_time=rc_time)
    rng = np.random.default_rng(1)
    held = np.concatenate([np.full(5, 1.0), rng.uniform(0, 2, 40)])
    fine = 100
    poles = np.array([-2 * np.pi * 1e5, -2 * np.pi * 1e4, -1 / rc_time])
    matrix = np.diag(poles) - np.diag(poles[1:], -1)
    state = signal.StateSpace(matrix, [[-poles[0]], [0], [0]], [[0, 0, 1]], [[0]])
    grid = np.arange(held.size * fine) / (RATE * fine)
    settled = np.full(3, held[0])
    _, output, _ = signal.lsim(state, np.repeat(held, fine), grid, X0=settled, interp=False)
    found = chain(detector, 1 / RATE).run(held[None], np.zeros((1, held.size)), None)[0]
    np.testing.assert_allclose(found, output[::fine], atol=1e-9)


@pytest.mark.parametrize("rc_time", [20e-6, 1e-3])
def test_noise_bandwidth(rc_time):
    """The integral of |H|^2 over frequency, by quadrature."""
    frequency = np.geomspace(1e-2, 1e9, 400_000)
    gain = np.ones_like(frequency)
    for corner in (1e5, 1e4, 1 / (2 * np.pi * rc_time)):
        gain /= 1 + (frequency / corner) ** 2
    expected = np.trapezoid(gain, frequency)
    found = chain(replace(Detector(), rc_time=rc_time), 1 / RATE).noise_bandwidth
    assert found == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("rc_time", [20e-6, 2e-4])
def test_filtered_noise_has_its_variance_and_correlation(rc_time):
    """2000 runs of 40 samples; 5 sigma of the estimates."""
    filters = chain(replace(Detector(), rc_time=rc_time), 1 / RATE)
    rng = np.random.default_rng(7)
    runs, scans, density = 2000, 40, 3e-10
    light = np.full((runs, scans), 0.5)
    normals = rng.standard_normal((runs, 3 * (scans + 1)))
    noise = filters.run(light, np.full_like(light, density), normals) - 0.5
    variance = density * filters.noise_bandwidth
    # from the first sample on, correlated samples count as at least a quarter as many
    tolerance = 5 * np.sqrt(2 / (runs * scans / 4))
    assert noise.var() == pytest.approx(variance, rel=tolerance)
    assert noise[:, 0].var() == pytest.approx(variance, rel=5 * np.sqrt(2 / runs))
    # autocorrelation at one sample, from the spectrum
    frequency = np.linspace(0, 4e6, 2_000_001)
    power = np.ones_like(frequency)
    for corner in (1e5, 1e4, 1 / (2 * np.pi * rc_time)):
        power /= 1 + (frequency / corner) ** 2
    turned = np.trapezoid(power * np.cos(2 * np.pi * frequency / RATE), frequency)
    correlation = (noise[:, 1:] * noise[:, :-1]).mean() / noise.var()
    assert correlation == pytest.approx(
        turned / filters.noise_bandwidth, abs=5 / np.sqrt(runs * 10)
    )


def test_counts_read_back_by_the_t7_s_nominal_calibration():
    volts = np.array([-10.0, -1.0, 0.0, 0.5, 9.99])
    for number, volts_range in enumerate((10.0, 1.0, 0.1, 0.01)):
        part = volts * volts_range / 10
        counts = counts_from_volts(part, Detector(), volts_range=volts_range)
        half = 0.51 * 3.16e-4 * volts_range / 10
        np.testing.assert_allclose(
            NOMINAL.high_speed[number].volts_from_counts(counts), part, atol=2 * half
        )
        np.testing.assert_allclose(
            volts_from_counts(counts, volts_range=volts_range), part, atol=half
        )


def test_converter_clips_and_rounds():
    counts = counts_from_volts([-99.0, 99.0], Detector(), volts_range=10.0)
    assert counts.tolist() == [0, 65535]
    assert counts.dtype == np.uint16
    coarse = counts_from_volts(np.linspace(-11, 11, 5000), Detector(bits=14), volts_range=10.0)
    assert (coarse % 4 == 0).all()
    assert coarse.max() == 65532
    np.testing.assert_array_equal(
        counts_from_volts(1.0, Detector(), volts_range=0.0),
        counts_from_volts(1.0, Detector(), volts_range=10.0),
    )


@pytest.mark.parametrize("volts_range", [5.0, -10.0, np.nan])
def test_converter_has_four_ranges(volts_range):
    with pytest.raises(ValueError, match=r"Expected a range out of 10, 1, 0.1, 0.01 V"):
        counts_from_volts(0.0, Detector(), volts_range=volts_range)
