"""Detector, filters and converter against closed forms and Monte Carlo."""

from dataclasses import replace

import numpy as np
import pytest

from cmtof.instrument.electronics import (
    Conversion,
    chain,
    counts_from_volts,
    volts_from_counts,
)
from cmtof.instrument.settings import Detector

STEP = 1 / 24000


def test_conversion_follows_the_data_sheet():
    sheet = Conversion(Detector(gain=100.0, efficiency=0.8215), 800e-9)
    assert sheet.volts_per_watt == pytest.approx(2.65e9, rel=2e-3)
    assert sheet.volts([1e-10, 1.0]).tolist() == pytest.approx([0.265, 4.1], rel=2e-3)


def test_shot_noise_grows_with_the_output():
    detector = Detector()
    conversion = Conversion(detector, 532e-9)
    excess = detector.gain**detector.excess_index
    slope = 2 * 1.602176634e-19 * detector.gain * excess * detector.transimpedance
    assert conversion.density(0.0) == pytest.approx(detector.noise_density**2)
    rise = conversion.density(2.0) - conversion.density(1.0)
    assert rise == pytest.approx(slope)


@pytest.mark.parametrize("rc_time", [20e-6, 2e-3])
def test_step_response_is_that_of_three_poles(rc_time):
    detector = Detector(rc_time=rc_time)
    light = np.r_[0.0, np.ones(199)][None]
    found = chain(detector, STEP).run(light, np.ones_like(light), None)[0, 1:]
    times = np.array([1 / (2 * np.pi * 1e5), 1 / (2 * np.pi * 1e4), rc_time])
    t = STEP * np.arange(199)[:, None]
    others = [np.delete(times, i) for i in range(3)]
    weights = np.array([a**2 / np.prod(a - b) for a, b in zip(times, others, strict=True)])
    np.testing.assert_allclose(found, 1 - (weights * np.exp(-t / times)).sum(1), atol=1e-9)


def test_filtered_noise_has_its_variance_and_correlation():
    filters = chain(Detector(rc_time=1e-4), STEP)
    normals = np.random.default_rng(1).standard_normal((20000, 13, 3))
    still = np.zeros((20000, 12))
    seen = filters.run(still, np.ones_like(still), normals)
    settled = filters.settled @ filters.settled.T
    lagged = (filters.transition @ settled)[-1, -1]
    for found, wanted in (
        (np.mean(seen**2), settled[-1, -1]),
        (np.mean(seen[:, 1:] * seen[:, :-1]), lagged),
    ):
        assert found == pytest.approx(wanted, rel=4 * np.sqrt(3 / 20000))
    assert filters.noise_bandwidth == pytest.approx(settled[-1, -1])


def test_noise_bandwidth_of_one_slow_pole():
    slow = Detector(rc_time=1e-2, bandwidth=1e8, low_pass=1e8)
    assert chain(slow, STEP).noise_bandwidth == pytest.approx(25.0, rel=1e-3)


@pytest.mark.parametrize("volts_range", [10.0, 1.0, 0.1, 0.01])
def test_counts_and_volts_invert_each_other(volts_range):
    volts = np.linspace(-1, 0.99, 101) * volts_range
    counts = counts_from_volts(volts, Detector(), volts_range=volts_range)
    back = volts_from_counts(counts, volts_range=volts_range)
    assert np.abs(back - volts).max() <= 0.51 * 3.15805780e-5 * volts_range
    ends = counts_from_volts([-99, 99], Detector(), volts_range=volts_range)
    assert ends.tolist() == [0, 65535]


def test_converter_of_fewer_bits():
    counts = counts_from_volts(np.linspace(0, 1, 500), replace(Detector(), bits=14))
    assert not (counts % 4).any()


def test_unknown_range_is_refused():
    with pytest.raises(ValueError, match="Expected a range out of"):
        counts_from_volts(0.0, Detector(), volts_range=5.0)
