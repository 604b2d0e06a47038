"""The ladder from beat to fringe: odds of each rung, averages, synthetic wavelengths."""

import numpy as np
import pytest

from cmtof.bounds import wrap_probability
from cmtof.constants import FREQUENCIES
from cmtof.correlation import wrap_length
from cmtof.ranging.fringe_order import (
    Ladder,
    averages_needed,
    order_odds,
    plan_colours,
    required_spread,
    second_colour,
    synthetic_wavelength,
)

WAVELENGTH = 532e-9
COLOURS = [WAVELENGTH, *second_colour(WAVELENGTH, [435e-6, 20e-6])]
NOISE = np.array([1e-4, 1e-4, 0.03, 0.03, 0.03])


def test_odds_are_the_share_of_errors_within_half_a_wrap():
    rng = np.random.default_rng(0)
    errors = rng.normal(0, 90e-9, 200_000)
    share = np.mean(np.abs(errors) < WAVELENGTH / 4)
    assert order_odds(90e-9, WAVELENGTH / 2) == pytest.approx(share, abs=4 * 0.5 / np.sqrt(2e5))
    assert order_odds(90e-9, WAVELENGTH / 2) == pytest.approx(
        float(order_odds(1.0, WAVELENGTH / 2 / 90e-9))
    )


@pytest.mark.parametrize("odds", [0.5, 0.95, 0.999])
def test_the_required_spread_is_the_inverse(odds):
    spread = required_spread(odds, WAVELENGTH / 2)
    assert order_odds(spread, WAVELENGTH / 2) == pytest.approx(odds)


def test_averages_stop_at_the_floor():
    settings = {"odds": 0.95, "wrap": WAVELENGTH / 2}
    few = averages_needed(5e-6, 30e-9, **settings)
    assert order_odds(np.hypot(5e-6 / np.sqrt(few), 30e-9), WAVELENGTH / 2) >= 0.95
    assert order_odds(np.hypot(5e-6 / np.sqrt(few - 2), 30e-9), WAVELENGTH / 2) < 0.95
    limit = float(required_spread(0.95, WAVELENGTH / 2))
    assert averages_needed(5e-6, 1.0001 * limit, **settings) == np.inf


def test_colours_and_their_beat_are_inverse():
    length = np.array([1e-3, 20e-6, 2e-6])
    found = synthetic_wavelength(WAVELENGTH, second_colour(WAVELENGTH, length))
    np.testing.assert_allclose(found, length)
    close = synthetic_wavelength(WAVELENGTH, WAVELENGTH + 1e-12)
    assert close == pytest.approx(WAVELENGTH**2 / 1e-12, rel=1e-4)


def test_rungs_wrap_where_they_should():
    ladder = Ladder.of(FREQUENCIES, COLOURS)
    expected = [wrap_length(20e6), *wrap_length(FREQUENCIES), 217.5e-6, 10e-6, WAVELENGTH / 2]
    np.testing.assert_allclose(ladder.wraps, expected)
    in_air = Ladder.of(FREQUENCIES, COLOURS, group=1.0003, index=1.0002)
    np.testing.assert_allclose(in_air.wraps[:3] * 1.0003, expected[:3])
    np.testing.assert_allclose(in_air.wraps[3:] * 1.0002, expected[3:])
    assert Ladder.of(FREQUENCIES).names == ("beat", "7.15 GHz", "14.32 GHz")
    longer = Ladder.of(FREQUENCIES, [WAVELENGTH, WAVELENGTH**2 / (WAVELENGTH - 1e-9)])
    assert (longer.wraps > 0).all()


@pytest.mark.parametrize("noise", [0.001, 0.01, 0.1])
def test_the_beat_has_the_known_odds(noise):
    ladder = Ladder.of(FREQUENCIES)
    known = wrap_probability(noise, 0.7 * noise, frequencies=FREQUENCIES)
    assert ladder.odds([noise, 0.7 * noise])[0] == pytest.approx(float(known))


def test_without_noise_the_ladder_climbs_to_the_fringe():
    ladder = Ladder.of(FREQUENCIES, COLOURS)
    z = np.random.default_rng(1).uniform(0.3, 5, 300)
    found = ladder.resolve(ladder.phases(z))
    assert found.shape == (300, 6)
    np.testing.assert_allclose(found[:, -1], z, atol=1e-11)


def test_odds_and_spreads_hold_in_simulation():
    """100 000 ranges: each rung right as often as foretold, given that those above were right."""
    ladder, draws = Ladder.of(FREQUENCIES, COLOURS), 100_000
    noise = np.array([6e-3, 6e-3, 0.03, 0.03, 0.03])
    rng = np.random.default_rng(2)
    z = rng.uniform(0.5, 0.7, draws)
    found = ladder.resolve(ladder.phases(z) + noise * rng.standard_normal((draws, 5)))
    error = found - z[:, None]
    own = np.abs(error) < ladder.wraps / 2
    # the beat is never a wrap off; from then on the first rung that errs is to blame
    right = np.ones(draws, bool)
    for k, odds in enumerate(ladder.odds(noise), start=1):
        step = np.abs(error[:, k - 1] - error[:, k]) < 1e-9 + ladder.wraps[k] / 2
        assert step.all()
        # a slip leaves an error of at least half a wrap more than its own noise
        kept = np.abs(error[:, k]) < 0.5 * ladder.wraps[k]
        share = np.mean(kept[right])
        assert share == pytest.approx(odds, abs=0.006)
        right &= kept
    assert own[:, 0].all()


def test_the_last_rung_has_the_fringe_s_own_spread():
    ladder, noise = Ladder.of(FREQUENCIES, COLOURS), NOISE / 5
    rng = np.random.default_rng(3)
    z = rng.uniform(0.5, 0.7, 20_000)
    error = ladder.resolve(ladder.phases(z) + noise * rng.standard_normal((20_000, 5))) - z[:, None]
    np.testing.assert_allclose(error.std(0), ladder.spreads(noise), rtol=0.03)


def test_a_planned_ladder_keeps_its_odds():
    colours = plan_colours(WAVELENGTH, 30e-6, phase_noise=0.02, odds=0.999)
    assert all(np.diff(colours) < 0)
    ladder = Ladder.of(FREQUENCIES, [WAVELENGTH, *second_colour(WAVELENGTH, colours)])
    # 30 um of range are this much of the doubled mode's phase
    ghz = 30e-6 / ladder.gains()[2, 1]
    odds = ladder.odds([ghz, ghz, *[0.02] * (1 + len(colours))])
    assert (odds[2:] > 0.9975).all()
    assert plan_colours(WAVELENGTH, 10e-9, phase_noise=0.02, odds=0.999) == []


def test_phases_too_noisy_for_a_ladder():
    with pytest.raises(ValueError, match="Expected phases good enough that a rung narrows"):
        plan_colours(WAVELENGTH, 30e-6, phase_noise=1.0, odds=0.999)
