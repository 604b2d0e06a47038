"""Rates of methods side by side."""

import numpy as np
import pytest

from cmtof.rates import COLUMNS, markdown_table, rates_of_counts, rates_of_report


def record(pixels, **below):
    methods = {name: {"below": list(counts)} for name, counts in below.items()}
    return {"frame": "f", "pixels": pixels, "methods": methods}


COUNTS = [
    record(100, cmtof=(80, 85, 90, 97), beat=(10, 20, 30, 60)),
    record(300, cmtof=(150, 200, 240, 291), beat=(30, 60, 90, 180)),
]


def test_rates_are_shares_of_all_pixels_not_means_over_frames():
    found = rates_of_counts(COUNTS, ["cmtof", "beat"], draws=50, seed=0)
    np.testing.assert_allclose(found["cmtof"].value, [230 / 400, 330 / 400, 12 / 400])
    np.testing.assert_allclose(found["beat"].value, [0.1, 0.3, 0.4])
    assert (found["cmtof"].low <= found["cmtof"].value).all()
    assert (found["cmtof"].high >= found["cmtof"].value).all()
    assert found["cmtof"].low[0] < found["cmtof"].high[0]


def test_methods_share_the_redrawn_scenes():
    """A method alone gets the same interval as beside others."""
    both = rates_of_counts(COUNTS, ["beat", "cmtof"], draws=50, seed=3)
    alone = rates_of_counts(COUNTS, ["cmtof"], draws=50, seed=3)
    np.testing.assert_array_equal(both["cmtof"].low, alone["cmtof"].low)


def test_what_was_not_counted_is_left_out():
    assert rates_of_counts(COUNTS, ["crt"], draws=5, seed=0) == {}
    assert rates_of_counts([], ["crt"], draws=5, seed=0) == {}
    assert rates_of_report({"methods": {}}, ["crt"]) == {}


@pytest.mark.parametrize("protocol", ["released", "full"])
def test_table_has_a_cell_for_each_rate(protocol):
    report = {"methods": {"beat": dict(zip(COLUMNS, (0.25, 0.5, 0.125), strict=True))}}
    rates = {protocol: rates_of_report(report, ["beat"])}
    lines = markdown_table(["beat", "cmtof"], rates, ("the goal", (1, 2, 3))).splitlines()
    assert lines[0] == f"| | {protocol}: δ < 1 | δ < 3 | δ ≥ 10 |"
    assert lines[2] == "| `beat` | 25.0 | 50.0 | 12.5 |"
    assert lines[3] == "| **`cmtof`** |  |  |  |"
    assert lines[4] == "| the goal | 1 | 2 | 3 |"
    assert {line.count("|") for line in lines} == {5}


def test_an_interval_follows_the_first_rate():
    rates = {"full": rates_of_counts(COUNTS, ["cmtof"], draws=50, seed=0)}
    line = markdown_table(["cmtof"], rates).splitlines()[2]
    assert line.count("<br>(") == 1
    assert line.startswith("| **`cmtof`** | 57.5<br>(")
