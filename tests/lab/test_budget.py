"""The error budget: closed forms against Monte Carlo, and the sum against the whole."""

import numpy as np
from pytest import approx, mark

from cmtof_lab.budget import budget_terms, ideal_but_for, simulated_errors
from cmtof_lab.settings import TwinSettings
from cmtof_lab.targets import MIRROR, PLATE

STILL = {"stage_error": 0.0, "air_change": (0.0, 0.0)}


def rms(errors):
    return np.sqrt(np.mean(np.square(errors)))


@mark.parametrize(
    "name, field, mode",
    [
        ("RF phase drift", "phase_drift", "doubled"),
        ("I/Q imbalance", "iq_imbalance", "single"),
        ("phase codes", "phase_step_error", "single"),
    ],
)
def test_closed_forms_meet_the_simulation(name, field, mode):
    """Days tell a root mean square to 1/sqrt(2 days) or so; three of these."""
    whole, floor = (
        rms(simulated_errors(settings, MIRROR, mode, days=days, seed=1, **STILL))
        for settings, days in ((ideal_but_for(field), 80), (TwinSettings.ideal(), 5))
    )
    term = budget_terms(MIRROR, mode, days=1)[name]
    assert np.sqrt(whole**2 - floor**2) == approx(term, rel=3 / np.sqrt(160))


def test_leakage_averages_out_in_the_single_mode_alone():
    single, doubled = (
        budget_terms(PLATE, mode, days=6)["RF leakage"]
        for mode in ("single", "doubled")
    )
    assert doubled > 2 * single


def test_the_sum_of_squares_is_the_whole():
    """The drift's rms over 100 days is known to 10 %."""
    terms = budget_terms(PLATE)
    errors = simulated_errors(TwinSettings(), PLATE, "single", days=100, seed=3)
    assert rms(errors) == approx(rms(list(terms.values())) * len(terms) ** 0.5, rel=0.2)
