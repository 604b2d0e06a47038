import json
from dataclasses import replace

import pytest

from cmtof import tally
from cmtof.conditions import Conditions
from cmtof.stored_counts import (
    disagreement,
    joined,
    objection,
    outdated,
    read_counts,
    write_counts,
)
from cmtof.tally import MIDDLE, Entry


def test_what_is_stored_is_read_and_fits(contest, tmp_path):
    records = list(tally.count_all(contest))
    held = write_counts(tmp_path / "t.json", contest, records, command="made by hand")
    assert read_counts(tmp_path / "t.json") == held
    assert objection(held, contest) == ""
    assert disagreement(held, records[:1]) == 0
    assert len((tmp_path / "t.json").read_text().splitlines()) < 12


def test_edited_counts_are_refused(contest, record, tmp_path):
    path = tmp_path / "t.json"
    held = write_counts(path, contest, [record], command="")
    held["frames"][0]["pixels"] += 1
    path.write_text(json.dumps(held))
    with pytest.raises(ValueError, match="edited"):
        read_counts(path)
    path.write_text("[]")
    with pytest.raises(ValueError, match="Make them anew"):
        read_counts(path)


def test_other_weights_or_settings_are_noticed(contest, record, tmp_path):
    old, new = tmp_path / "old", tmp_path / "new"
    old.write_bytes(b"1"), new.write_bytes(b"2")

    def with_net(label, path):
        return replace(contest, entries={label: Entry("fast-scnn", {"weights": str(path)})})

    ours = with_net("net", old)
    counts = record | {"methods": {"net": record["methods"]["crt"]}}
    held = write_counts(tmp_path / "t.json", ours, [counts], command="")
    assert objection(held, ours) == ""
    assert "lack net," in objection(held, with_net("net", new))
    assert "lack net2," in objection(held, with_net("net2", old))
    assert "other settings" in objection(
        held, replace(ours, conditions=Conditions(seed=3, noise=2000))
    )
    # a set may grow
    assert objection(held, replace(ours, rooms=replace(ours.rooms, scenes=40))) == ""


def test_a_method_that_was_never_counted_is_noticed(contest, record, tmp_path):
    held = write_counts(tmp_path / "t.json", contest, [record], command="")
    more = replace(contest, entries={**contest.entries, "crt-ml": Entry("crt-ml")})
    assert outdated(held, contest) == []
    assert outdated(held, more) == ["crt-ml"]
    assert "lack crt-ml" in objection(held, more)
    # one that takes no part any more is no objection, and is dropped
    fewer = replace(contest, entries=MIDDLE)
    assert objection(held, fewer) == ""
    assert list(joined(held, [record], fewer)[0]["methods"]) == ["middle"]


def test_newer_counts_are_joined_in_order(contest, record, tmp_path):
    held = write_counts(tmp_path / "t.json", contest, [record], command="")
    newer = json.loads(json.dumps(record))
    newer["methods"] = {"new": newer["methods"]["crt"], "crt": newer["methods"]["middle"]}
    entries = {"new": Entry("crt"), **contest.entries}
    found = joined(held, [newer], replace(contest, entries=entries))[0]["methods"]
    assert list(found) == ["new", *contest.entries]
    assert found["new"] == record["methods"]["crt"]
    assert found["crt"] == record["methods"]["middle"]
    assert found["beat 41"] == record["methods"]["beat 41"]
    with pytest.raises(ValueError, match="Count all methods anew"):
        joined(held, [newer | {"pixels": 1}], contest)
    with pytest.raises(ValueError, match="shorter"):
        joined(held, [], contest)


def test_other_counts_of_a_frame_are_noticed(record):
    held = {"frames": [record]}
    changed = json.loads(json.dumps(record))
    changed["methods"]["crt"]["below"][1] += 3
    assert disagreement(held, [changed]) == pytest.approx(3 / record["pixels"])
    assert disagreement(held, [record | {"frame": "another"}]) == 1
    assert disagreement(held, [record | {"pixels": 1}]) == 1
