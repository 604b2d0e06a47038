"""Measurements under stated conditions: what is stored of them, and what each method is given."""

import numpy as np
import pytest

from cmtof.conditions import Conditions, Measured
from cmtof.constants import FREQUENCIES
from cmtof.correlation import centred
from cmtof.simulation import simulate, true_phase


def test_settings_are_plain_and_name_only_what_is_unusual():
    assert Conditions().settings() == {"protocol": "released", "noise": 1200.0, "seed": 0}
    found = Conditions(protocol="full", phase_offset=(0.0, 0.01)).settings()
    assert found == {
        "protocol": "full",
        "noise": 1200.0,
        "seed": 0,
        "phase_offset": [0.0, 0.01],
    }


def test_the_same_conditions_give_the_same_counts(tilted_wall):
    ours = Conditions(seed=4).measure(tilted_wall, 2).dataset["correlation"]
    theirs = simulate(tilted_wall, seed=4, frame_number=2).dataset["correlation"]
    assert np.array_equal(ours, theirs)


@pytest.mark.parametrize("offset", [(0.01, 0.0), (0.0, -0.01), (0.3, 0.2)])
def test_a_phase_offset_moves_every_phase_by_itself(tilted_wall, offset):
    measured = Conditions(noise_free=True, phase_offset=offset).measure(tilted_wall)
    moved = centred(measured.phase - np.stack([true_phase(measured, k) for k in range(2)]))
    assert np.abs(moved - np.array(offset)[:, None, None]).max() < 1e-4


def test_methods_share_a_measurement_unless_they_need_other_frequencies(tilted_wall):
    taken = Measured(Conditions(protocol="full"), tilted_wall)
    assert taken.by("crt") is taken.by("beat") is taken.usual
    close = taken.by("phasor")
    assert close is taken.by("phasor")
    assert close.frequencies.tolist() == [7.15e9, 7.16e9]
    assert taken.usual.frequencies.tolist() == list(FREQUENCIES)
    assert np.array_equal(close.mask, taken.usual.mask)
    assert close.range[1] == pytest.approx(2 * taken.usual.range[1])
