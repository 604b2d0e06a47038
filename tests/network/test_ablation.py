import json

import pytest

from cmtof.book.paper import published_numbers
from cmtof.network.ablation import ROWS, comparable, found_rows, last_gain, reads, trained_for


@pytest.fixture
def folder(tmp_path):
    """Cards without weights: the rows of a table are chosen by their cards alone."""

    def write(name, model, configuration, steps=1000, protocol="released"):
        card = {"model": model, "classes": 21, "first_wrap": 36, "protocol": protocol,
                "sha256": "", "configuration": {"name": configuration, "model": model},
                "steps": steps}  # fmt: skip
        (tmp_path / f"{name}.safetensors").touch()
        (tmp_path / f"{name}.json").write_text(json.dumps(card))

    write("fast-scnn.released", "fast-scnn", "gpu", 12000)
    write("fast-scnn.full", "fast-scnn", "gpu", 12000, protocol="full")
    write("fast-scnn-light.released", "fast-scnn-light", "gpu", 12000)
    write("fast-scnn.released.common", "fast-scnn", "common", 2400)
    write("fast-scnn-ce.released", "fast-scnn-ce", "common", 2400)
    write("fast-scnn-phase.released", "fast-scnn-phase", "cpu")
    return tmp_path


def test_rows_are_found_in_the_order_of_the_table(folder):
    rows = found_rows(folder=folder)
    assert [row.key for row in rows] == ["proposed", "proposed", "ce_only", "phase_only"]
    assert {row.label for row in rows} >= {"fast-scnn.released", "fast-scnn.released.common"}


def test_only_rows_that_were_trained_alike_are_compared(folder):
    table = comparable(found_rows(folder=folder))
    assert {key: row.configuration for key, row in table.items()} == {
        "proposed": "common",
        "ce_only": "common",
    }
    assert not table["proposed"].short


def test_where_no_two_agree_the_longest_training_stands(folder):
    rows = [row for row in found_rows(folder=folder) if row.configuration != "common"]
    assert [row.configuration for row in comparable(rows).values()] == ["gpu"]


def test_without_weights_there_is_no_row(tmp_path):
    assert found_rows(folder=tmp_path / "missing") == []
    assert comparable([]) == {}


def test_every_row_is_in_the_paper():
    numbers = published_numbers()
    assert {key.split(".")[1] for key in numbers if key.startswith("table1.")} == set(ROWS)


def test_rows_differ_by_what_the_paper_took_away():
    assert [reads(model).count(",") for model in ROWS.values()] == [3, 3, 2, 1]
    assert [trained_for(model).startswith("wrap and") for model in ROWS.values()] == [
        True,
        False,
        True,
        True,
    ]


def test_a_gain_is_that_of_the_last_quarter():
    curve = [{"step": 10 * k, "delta_lt_1": 0.01 * k**2} for k in range(1, 9)]
    assert last_gain({"validation": curve}) == pytest.approx(0.64 - 0.36)
    assert last_gain({"validation": curve[:1]}) == 0
    with pytest.raises(ValueError, match="validation curve"):
        last_gain({})
