"""Scans as the methods of chapter 21 read them, and counts that are computed once."""

from pytest import approx

from cmtof.correlation import centred
from cmtof.simulation import simulate
from cmtof_book import scanned
from cmtof_book.counts import Counts


def test_four_phases_hold_the_phase_of_the_scan(measured):
    four = scanned.four_phases(measured)
    assert four.dataset.sizes["step"] == 4
    assert abs(centred(four.phase - measured.phase)).max() < 1e-5
    assert four.range == measured.range


def test_a_close_pair_has_the_lower_frequency_of_both(measured, tilted_wall):
    other = simulate(tilted_wall, frequencies=(7.16e9, 14.32e9))
    pair = scanned.close_pair(measured, other)
    assert pair.frequencies.tolist() == [7.15e9, 7.16e9]
    assert pair.phase[1] == approx(other.phase[0])


def test_a_count_is_computed_once_and_survives_the_process(tmp_path):
    path = tmp_path / "counts.json"
    first = Counts(path).keep(("counts", "kde"), lambda: [3, 1])
    assert Counts(path).keep(("counts", "kde"), lambda: 1 / 0) == first


def test_nothing_that_is_shown_is_learnt():
    assert not set(scanned.SHOWN) & {*scanned.LEARNT, *scanned.HELD_OUT}
    assert len(scanned.LEARNT) >= 10
