import numpy as np
import pytest

import cmtof
from cmtof import tally
from cmtof.metrics import score, scored_pixels


@pytest.mark.parametrize(("label", "method", "options"), [("beat 41", "beat", {"window": 41})])
def test_counts_are_the_rates_of_evaluate(record, taken, label, method, options):
    measured = taken.usual
    expected = score(scored_pixels(cmtof.unwrap(measured, method=method, **options), measured))
    found = tally.rates([record, record], label)
    assert 1 - found.pop("delta_lt_10") == pytest.approx(expected["delta_ge_10"])
    assert found == pytest.approx({name: expected[name] for name in found})


def test_every_stratum_adds_up_to_the_whole(record):
    for label, found in record["methods"].items():
        for name, right in found["strata"].items():
            assert sum(right) == found["below"][0], (label, name)
            assert sum(record["strata"][name]) == record["pixels"]
            assert (np.array(right) <= record["strata"][name]).all()


def test_the_middle_is_right_where_the_scene_is(record):
    held = {36 + k: count for k, count in enumerate(record["strata"]["wrap"])}
    right = record["methods"]["middle"]["strata"]["wrap"]
    assert right[46 - 36] == held[46] == sum(right) > 0


def test_arrays_hold_one_column_a_frame(contest):
    records = list(tally.count_all(contest))
    assert tally.scored(records).shape == (2,)
    assert tally.below(records, "crt").shape == (4, 2)
    right, whole = tally.stratum(records, "edge", "crt")
    assert right.shape == whole.shape == (7, 2)
    # the noise of each frame is its own
    assert records[0]["methods"]["beat 41"] != records[1]["methods"]["beat 41"]
