"""The error budget: closed forms against Monte Carlo, and the sum against the whole."""

import numpy as np
from pytest import approx, mark

from cmtof_lab.budget import budget_terms, drift_spread, only, simulated
from cmtof_lab.instrument import DRIFT_RMS, drift
from cmtof_lab.settings import TwinSettings
from cmtof_lab.targets import MIRROR, PLATE

STILL = {"stage_error": 0.0, "air_change": (0.0, 0.0)}


def rms(errors):
    return np.sqrt(np.mean(np.square(errors)))


@mark.parametrize(
    ("name", "field", "mode"),
    [
        ("RF phase drift", "phase_drift", "doubled"),
        ("I/Q imbalance", "iq_imbalance", "single"),
        ("phase codes", "phase_step_error", "single"),
    ],
)
def test_closed_forms_meet_the_simulation(name, field, mode):
    """Days tell a root mean square to 1/sqrt(2 days) or so; three of these."""
    errors = simulated(only(field), MIRROR, mode, days=80, seed=1, **STILL)
    floor = rms(simulated(TwinSettings.ideal(), MIRROR, mode, days=5, seed=1, **STILL))
    found = np.sqrt(rms(errors) ** 2 - floor**2)
    assert found == approx(
        budget_terms(MIRROR, mode, days=1)[name], rel=3 / np.sqrt(160)
    )


def test_noise_meets_its_part_of_the_bound():
    """Of one reading and of the zero's eight; 20 days of 21 positions."""
    terms = budget_terms(MIRROR, days=1)
    whole = np.sqrt(
        sum(terms[n] ** 2 for n in ("photon noise", "amplifier", "converter"))
    )
    quiet = only("noise", "divergence", "exit_radius", "ambient_radiance")
    errors = simulated(quiet, MIRROR, "single", days=40, seed=2, **STILL)
    assert rms(errors) == approx(whole, rel=0.12)


def test_leakage_averages_out_in_the_single_mode_alone():
    terms = {
        mode: budget_terms(PLATE, mode, days=6)["RF leakage"]
        for mode in ("single", "doubled")
    }
    assert terms["doubled"] > 2 * terms["single"]


def test_the_sum_of_squares_is_the_whole():
    """The drift's rms over 100 days is known to 10 %."""
    terms = budget_terms(PLATE)
    errors = simulated(TwinSettings(), PLATE, "single", days=100, seed=3)
    assert rms(errors) == approx(rms(list(terms.values())) * len(terms) ** 0.5, rel=0.2)


def test_drift_spread_is_that_of_many_days():
    times = np.arange(21.0) + 600
    zero = np.arange(8.0)
    days = [drift(seed, 0, np.append(times, zero)) / DRIFT_RMS for seed in range(3000)]
    found = rms([day[:21] - day[21:].mean() for day in days])
    assert found == approx(drift_spread(times, zero), rel=0.03)
    assert drift_spread([0.0], [0.0]) == 0
