"""RMSE, MAE and what they tell together; the table's driver."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.correlation import centred, depth_from_phase
from cmtof.instrument.settings import TwinSettings
from cmtof.ranging import sweep
from cmtof.ranging.interferometer import Interferometer
from cmtof.ranging.optical import OpticalRanger
from cmtof.ranging.rf import RfRanger
from cmtof.ranging.target import StageTarget


class Pretended:
    """An instrument with a constant offset on each day and Gaussian noise."""

    def __init__(self, offset=0.0, noise=0.0, rows=None):
        self.offset, self.noise, self.rows = offset, noise, rows

    def sweep(self, target, positions, *, repeats, seed):
        rng = np.random.default_rng(seed)
        count = len(positions)
        error = self.offset + self.noise * rng.standard_normal((self.rows or repeats, count))
        return target.distance + positions + error

    def bound(self, target, positions):
        return np.full(len(positions), self.noise)


@given(st.floats(-1e-3, 1e-3), st.floats(-0.1, 0.1), st.floats(0, 1e-4), st.integers(0, 2**32 - 1))
def test_the_parts_add_up(offset, slope, noise, seed):
    rng = np.random.default_rng(seed)
    about = sweep.POSITIONS - sweep.POSITIONS.mean()
    errors = offset + slope * about + noise * rng.standard_normal((4, 21))
    found = sweep.parts(errors, sweep.POSITIONS)
    total = found.offset**2 + found.slope**2 * about.var() + 19 / 21 * found.scatter**2
    np.testing.assert_allclose(total, sweep.rmse(errors) ** 2, rtol=1e-9, atol=1e-20)


def test_parts_of_a_straight_line():
    about = sweep.POSITIONS - sweep.POSITIONS.mean()
    found = sweep.parts(3e-5 - 0.02 * about, sweep.POSITIONS)
    np.testing.assert_allclose(found[:3], (3e-5, -0.02, 0), atol=1e-12)


def test_ratio_of_gaussian_errors_and_of_an_offset():
    """200 000 errors tell the ratio to 0.2 %."""
    errors = np.random.default_rng(0).standard_normal(200_000)
    ratio = sweep.mae(errors) / sweep.rmse(errors)
    assert ratio == pytest.approx(sweep.GAUSSIAN_RATIO, abs=0.004)
    assert ratio == pytest.approx(0.798, abs=0.004)
    constant = np.full(21, -3e-5)
    assert sweep.mae(constant) == pytest.approx(sweep.rmse(constant))


@given(st.floats(0.0, 50.0), st.floats(0.01, 50.0))
def test_offset_and_scatter_are_found_again(offset, scatter):
    rmse = float(np.hypot(offset, scatter))
    mae = float(sweep.expected_mae(offset, scatter))
    found = sweep.offset_and_scatter(rmse, min(mae, rmse))
    # the ratio knows little of a small offset, or of a small scatter
    assert float(sweep.expected_mae(*found)) == pytest.approx(mae, rel=1e-6)
    assert np.hypot(*found) == pytest.approx(rmse)
    if 0.5 < offset / scatter < 20:
        np.testing.assert_allclose(found, (offset, scatter), rtol=1e-3)


def test_expected_mae_is_the_mean_of_many():
    errors = 2.0 + 1.5 * np.random.default_rng(1).standard_normal(10**6)
    assert sweep.mae(errors) == pytest.approx(float(sweep.expected_mae(2.0, 1.5)), rel=3e-3)


def test_limits_of_offset_and_scatter():
    assert sweep.offset_and_scatter(1.0, 0.7) == (0.0, 1.0)
    assert sweep.offset_and_scatter(1.0, 1.0) == (1.0, 0.0)


def test_a_phase_without_signal():
    frequency = 7.15e9
    phase = np.random.default_rng(2).uniform(0, 2 * np.pi, 10**6)
    errors = depth_from_phase(centred(phase), frequency)
    expected = sweep.random_phase_errors(frequency)
    assert sweep.rmse(errors) == pytest.approx(expected[0], rel=3e-3)
    assert sweep.mae(errors) == pytest.approx(expected[1], rel=3e-3)


def test_interval_covers_repeats_and_mean():
    rng = np.random.default_rng(3)
    found = sweep.interval(rng.normal(5.0, 2.0, 4000))
    assert (found.low, found.high) == pytest.approx((5 - 1.96 * 2, 5 + 1.96 * 2), abs=0.3)
    expected = 2 * 1.96 * 2 / np.sqrt(4000)
    assert found.mean_high - found.mean_low == pytest.approx(expected, rel=0.1)
    assert found.mean_low < 5.0 < found.mean_high


def test_the_interval_of_a_positive_mean_is_positive():
    """One far day of a hundred, as fringe counting has them."""
    found = sweep.interval(np.append(np.full(99, 1e-7), 1e-4))
    assert 0 < found.mean_low < found.mean < found.mean_high
    assert found.median == found.high == 1e-7


def test_table_of_pretended_instruments():
    rangers = {"steady": Pretended(offset=2e-5), "noisy": Pretended(noise=1e-5)}
    targets = {"mirror": StageTarget.mirror(), "diffuse": StageTarget()}
    table = sweep.table_4(rangers, targets, repeats=50, seed=0)
    assert list(table) == [(name, what) for name in rangers for what in targets]
    steady, noisy = table["steady", "mirror"], table["noisy", "diffuse"]
    np.testing.assert_allclose(steady.rmse, 2e-5)
    np.testing.assert_allclose(steady.ratio, 1)
    assert noisy.errors.shape == (50, 21)
    assert np.sqrt(np.mean(noisy.rmse**2)) == pytest.approx(1e-5, rel=5 / np.sqrt(2 * 50 * 21))
    np.testing.assert_array_equal(noisy.bound, 1e-5)


def test_table_of_the_three_instruments():
    rangers = {
        "all-optical": OpticalRanger(),
        "RF": RfRanger(),
        "fringes": Interferometer(TwinSettings()),
    }
    targets = {"mirror": StageTarget.mirror(), "diffuse": StageTarget()}
    places = sweep.POSITIONS[:3]
    table = sweep.table_4(rangers, targets, repeats=2, seed=0, positions=places)
    for result in table.values():
        assert result.errors.shape == (2, 3)
        assert np.isfinite(result.errors).all()
        assert (result.bound > 0).all()
    assert table["all-optical", "mirror"].rmse.max() < 1e-4


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (lambda: sweep.parts([1.0], [0.0]), "Expected at least 3 positions"),
        (lambda: sweep.interval([1.0]), "Expected values of at least 2 repeats"),
        (lambda: sweep.offset_and_scatter(1.0, 2.0), "Expected 0 < MAE <= RMSE"),
        (
            lambda: sweep.run_sweep(Pretended(rows=3), StageTarget(), repeats=2, seed=0),
            r"Expected ranges \(2, 21\)",
        ),
    ],
)
def test_bad_input(act, message):
    with pytest.raises(ValueError, match=message):
        act()
