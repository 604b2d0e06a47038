import json
from dataclasses import replace

import numpy as np
import pytest

import cmtof
from cmtof import tally
from cmtof.conditions import Conditions
from cmtof.metrics import score, scored_pixels
from cmtof.scenes.rooms.rendering import Settings
from cmtof.tally import (
    CLASSICAL,
    MIDDLE,
    Contest,
    Entry,
    count,
    disagreement,
    objection,
    read_tally,
    write_tally,
)

SMALL = Settings(seed=3, scenes=20, height=24, width=32)


@pytest.fixture
def contest(monkeypatch, tilted_wall):
    """Two test frames that are the wall, so that nothing is rendered."""

    def wall(settings, index):
        return replace(tilted_wall, name=f"wall {index}")

    monkeypatch.setattr(tally, "held_out_frame", wall)
    return Contest(CLASSICAL | MIDDLE, SMALL, Conditions(seed=3))


@pytest.fixture
def taken(contest, tilted_wall):
    return contest.measure(tilted_wall, 0)


@pytest.fixture
def record(contest, tilted_wall, taken):
    return count(tilted_wall, taken, contest.answers(taken))


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


def test_what_is_stored_is_read_and_fits(contest, tmp_path):
    records = list(tally.count_all(contest))
    held = write_tally(tmp_path / "t.json", contest, records, command="made by hand")
    assert read_tally(tmp_path / "t.json") == held
    assert objection(held, contest) == ""
    assert disagreement(held, records[:1]) == 0
    assert len((tmp_path / "t.json").read_text().splitlines()) < 12


def test_edited_counts_are_refused(contest, record, tmp_path):
    path = tmp_path / "t.json"
    held = write_tally(path, contest, [record], command="")
    held["frames"][0]["pixels"] += 1
    path.write_text(json.dumps(held))
    with pytest.raises(ValueError, match="edited"):
        read_tally(path)
    path.write_text("[]")
    with pytest.raises(ValueError, match="Make them anew"):
        read_tally(path)


def test_other_weights_or_settings_are_noticed(contest, record, tmp_path):
    old, new = tmp_path / "old", tmp_path / "new"
    old.write_bytes(b"1"), new.write_bytes(b"2")

    def with_net(label, path):
        return replace(contest, entries={label: Entry("fast-scnn", {"weights": str(path)})})

    ours = with_net("net", old)
    held = write_tally(tmp_path / "t.json", ours, [record], command="")
    assert objection(held, ours) == ""
    assert "weights of net" in objection(held, with_net("net", new))
    assert "lack net2" in objection(held, with_net("net2", old))
    assert "other settings" in objection(
        held, replace(ours, conditions=Conditions(seed=3, noise=2000))
    )
    # a set may grow
    assert objection(held, replace(ours, rooms=replace(SMALL, scenes=40))) == ""


def test_other_counts_of_a_frame_are_noticed(record):
    held = {"frames": [record]}
    changed = json.loads(json.dumps(record))
    changed["methods"]["crt"]["below"][1] += 3
    assert disagreement(held, [changed]) == pytest.approx(3 / record["pixels"])
    assert disagreement(held, [record | {"frame": "another"}]) == 1
    assert disagreement(held, [record | {"pixels": 1}]) == 1
