"""The tool that counts a table counts only what is missing, and goes on where it stopped."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

import tables
from cmtof import stored_counts, tally
from cmtof.conditions import Conditions
from cmtof.tally import Entry


@pytest.fixture
def unwrapped(monkeypatch):
    """Labels in the order in which they are counted."""
    said, plain = [], tally.count

    def counting(frame, measured, answers):
        said.extend(answers)
        return plain(frame, measured, answers)

    monkeypatch.setattr(tally, "count", counting)
    return said


def test_only_what_is_missing_is_counted(contest, unwrapped, tmp_path):
    path = tmp_path / "table2_released_1200.json"
    first = tables.brought_up_to_date(path, contest, [])
    assert unwrapped == 2 * list(contest.entries)
    assert stored_counts.read_counts(path)["frames"] == first
    assert not list(tmp_path.glob("*.part"))

    unwrapped.clear()
    assert tables.brought_up_to_date(path, contest, []) == first and unwrapped == []
    assert tables.brought_up_to_date(path, contest, ["crt"]) == first
    assert unwrapped == ["crt", "crt"]

    unwrapped.clear()
    more = replace(contest, entries={"crt-ml": Entry("crt-ml"), **contest.entries})
    found = tables.brought_up_to_date(path, more, [])
    assert unwrapped == ["crt-ml", "crt-ml"]
    assert [list(one["methods"]) for one in found] == 2 * [list(more.entries)]
    assert stored_counts.objection(stored_counts.read_counts(path), more) == ""


@pytest.mark.parametrize("change", [{"noise": 300.0}, {"seed": 4}, {"protocol": "full"}])
def test_under_other_conditions_all_is_counted(contest, unwrapped, tmp_path, change):
    path = tmp_path / "table2_released_1200.json"
    tables.brought_up_to_date(path, replace(contest, entries=tally.MIDDLE), [])
    unwrapped.clear()
    other = replace(contest, conditions=replace(contest.conditions, **change))
    tables.brought_up_to_date(path, other, [])
    assert unwrapped == 2 * list(contest.entries)


def test_a_run_that_was_stopped_goes_on(contest, unwrapped, tmp_path, monkeypatch):
    path, part = tmp_path / "t.json", tmp_path / "t.json.part"
    whole = tables.brought_up_to_date(path, contest, [])
    path.unlink()
    plain = tally.count_place

    def killed(contest, place):
        if place == 1:
            raise KeyboardInterrupt
        return plain(contest, place)

    monkeypatch.setattr(tally, "count_place", killed)
    with pytest.raises(KeyboardInterrupt):
        tables.brought_up_to_date(path, contest, [])
    assert not path.exists() and len(part.read_text().splitlines()) == 2
    monkeypatch.setattr(tally, "count_place", plain)
    unwrapped.clear()
    assert tables.brought_up_to_date(path, contest, []) == whole
    assert unwrapped == list(contest.entries)  # the second frame alone
    assert not part.exists()


def test_what_others_left_unfinished_is_not_taken(contest, tmp_path):
    part = tmp_path / "t.json.part"
    part.write_text(json.dumps(["other settings"]) + "\n" + json.dumps({"frame": "x"}) + "\n")
    found = tables.brought_up_to_date(tmp_path / "t.json", contest, [])
    assert [record["frame"] for record in found] == ["wall 9", "wall 19"]


def test_who_takes_no_part_cannot_be_counted_again(contest, tmp_path):
    with pytest.raises(ValueError, match=r"Expected methods out of beat 41, .*, got kde\. Choose"):
        tables.brought_up_to_date(tmp_path / "t.json", contest, ["kde"])


def test_the_command_that_is_stored_makes_the_same_contest(contest):
    chosen = replace(contest, conditions=Conditions(protocol="full", noise=300.0))
    said = tables.told(chosen, Path("table2_full_300.json"))
    assert said == "2 --protocol full --noise 300"
    given = tables.parsed(said.split())
    assert (given.table, given.protocol, given.noise) == ("2", "full", 300.0)


def test_the_command_line_counts_every_method(contest, unwrapped, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(tables, "RESULTS", tmp_path)
    monkeypatch.setattr(tally, "TEST_ROOMS", contest.rooms)
    monkeypatch.setattr(
        tally, "Contest", lambda entries, conditions: tally_contest(entries, contest, conditions)
    )
    monkeypatch.setattr(tally, "every_entry", lambda protocol: {"crt": Entry("crt")})
    assert tables.main(["2", "--noise", "300"]) == 0
    held = stored_counts.read_counts(tmp_path / "table2_released_300.json")
    assert held["settings"]["noise"] == 300 and unwrapped == ["crt", "crt"]
    assert "crt {'delta_lt_1':" in capsys.readouterr().out
    assert tables.main(["2", "--noise", "300", "--again", "kde"]) == 1
    assert "Expected methods out of crt, got kde" in capsys.readouterr().err


def tally_contest(entries, like, conditions):
    return replace(like, entries=entries, conditions=conditions)
