"""The published numbers, the verdicts on ours, and the scoreboard page."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

from cmtof_book import compared, paper, provenance, record, scoreboard

ROOT = Path(__file__).parents[2]
ACCEPTED = ROOT / "figures" / "scoreboard.json"
NUMBERS = paper.published_numbers()
PLAIN = replace(NUMBERS["fig3.precision_ratio"], value=10.0, tolerance=0.5, relation="eq")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    target = tmp_path / "02_precision"
    monkeypatch.setenv(provenance.OUTPUT_VARIABLE, str(target))
    monkeypatch.setitem(provenance.RUN, "profile", "ci")
    return target


def test_every_entry_is_well_formed():
    for number in NUMBERS.values():
        name = r"(abstract|sec\d+|fig\d+|table[1-4])(\.[a-z][a-z0-9_]*){1,2}"
        assert re.fullmatch(name, number.key)
        assert math.isfinite(number.value) and number.tolerance >= 0
        assert number.unit in {"1", "fraction", "m", "s", "Hz", "W", "rad", "bit", "px", "counts"}
        assert number.erratum is None or 1 <= number.erratum <= 30
        assert number.where and number.what
        assert "|" not in number.what + number.untested + number.note
        assert number.unit != "fraction" or 0 <= number.value <= 1


def test_the_four_tables_are_complete_and_add_up():
    """δ < 3 and δ ≥ 3 are the two halves of one whole, and the bands nest."""
    sizes = {"table1": (4, 4), "table2": (8, 5), "table3": (3, 4), "table4": (3, 4)}
    for table, (rows, columns) in sizes.items():
        value = {key: one.value for key, one in NUMBERS.items() if key.startswith(table)}
        names = {key.rpartition(".")[0] for key in value}
        assert len(names) == rows and len(value) == rows * columns
        for row in names:
            if table == "table4":
                assert value[f"{row}.mae_mirror"] <= value[f"{row}.rmse_mirror"]
                assert value[f"{row}.mae_diffuse"] <= value[f"{row}.rmse_diffuse"]
            else:
                below = [value[f"{row}.delta_lt_{limit}"] for limit in (1, 2, 3)]
                assert below == sorted(below)
                assert below[2] + value[f"{row}.delta_ge_3"] == pytest.approx(1, abs=1e-3)


def test_a_result_is_reproduced_inside_its_tolerance_and_contradicted_outside():
    cases = {
        "eq": ([10.5, 9.5], [10.5 + 1e-9, 9.4]),
        "lt": ([10.4, -1e6], [10.5, 11.0]),
        "gt": ([9.6, 1e6], [9.5, -1.0]),
    }
    for relation, (inside, outside) in cases.items():
        number = replace(PLAIN, relation=relation)
        assert {number.outcome(value) for value in inside} == {"reproduced"}
        assert {number.outcome(value) for value in outside} == {"contradicted"}
        assert number.outcome(math.nan) == "untested"
    # 0.0165 ± 0.0005 holds 0.017, though their floats differ by a last bit
    assert replace(PLAIN, value=0.0165, tolerance=0.0005).outcome(0.017) == "reproduced"
    # of a band the nearest value counts
    for band, said in (([1, 9.6], "reproduced"), ([1, 9], "contradicted"), ([1, 99], "reproduced")):
        assert PLAIN.outcome(band) == said
    for value in (10.0, -1e9):
        assert replace(PLAIN, untested="other data").outcome(value) == "untested"
        assert replace(PLAIN, kind="setting").outcome(value) == "input"


def test_each_claim_can_hold_and_can_fail():
    """Ten of them; numbers that hold reproduce a claim, and any one that fails contradicts it."""
    assert len(paper.claims()) == 10
    for claim in paper.claims():
        numbers = [NUMBERS[key] for key in claim.keys]
        side = {"lt": 0.5, "gt": 1.5}
        holds = {one.key: one.value * side.get(one.relation, 1) for one in numbers}
        assert claim.outcome(holds) == "reproduced", claim.text
        assert claim.outcome({}) == "untested"
        for one in numbers:
            fails = {one.key: one.value * (2 - side.get(one.relation, 1.5))}
            assert claim.outcome(holds | fails) == "contradicted"
    assert not [key for key, number in NUMBERS.items() if key[:5] == "table" and number.untested]
    assert sum(bool(number.untested) for number in NUMBERS.values()) <= 25


def test_check_prints_one_line_with_the_ratio_and_records_it(folder, capsys):
    with pytest.raises(ValueError, match=r"Expected .* got 'fig3.precison'. Use 'fig3.precision"):
        paper.check("fig3.precison", 1.0)
    paper.check("fig3.precision_ratio", 50.0)
    paper.check("fig3.precision_ratio", compared.sum_over_draws(99.8, error=3.2))
    paper.check("table2.kde.delta_lt_1", 0.0473, crops=28_000)
    paper.check("table4.rf.rmse_mirror", (2e-4, 3e-4), photon=(2e-6, 9.9e-5))
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith("paper ≈ 100 ± 10, ours 50 (0.5 ×): contradicted")
    assert lines[1].endswith("ours 99.8 (0.998 ×): reproduced")
    assert lines[2].endswith(
        "ours 4.73 % (0.5 ×): contradicted after 28,000 crops of the paper's 500,000"
    )
    beside = "at the photon limit 2 µm to 99 µm (0.0404 to 2 ×): reproduced"
    assert lines[3].endswith(f"ours 200 µm to 300 µm (4.04 to 6.06 ×): contradicted; {beside}")
    (found,) = record.read_all(folder.parent)
    assert found.numbers["table4.rf.rmse_mirror"]["beside"] == beside
    assert found.numbers["fig3.precision_ratio"]["verdict"] == "reproduced"
    assert found.content["provenance"]["profile"] == "ci"
    assert found.compared() == {"fig3.precision_ratio": compared.sum_over_draws(99.8, error=3.2)}


def test_scoreboard_lists_and_counts_every_number_once(folder):
    paper.check("fig3.precision_ratio", 99.8)
    paper.check("fig14.height_error", 1.2e-6)
    paper.check("sec8.gain", 20)
    page = scoreboard.page(list(record.read_all(folder.parent)))
    listed = re.findall(r"<br><code>([a-z0-9_.]+)</code>", page.replace("<wbr>", ""))
    assert sorted(listed) == sorted(key.partition(".")[2] for key in NUMBERS)
    counts = dict(re.findall(r"^\| \**([a-z, ]+?)\** \| \**(\d+)\** \|$", page, re.MULTILINE))
    assert counts["reproduced"] == "1" and counts["contradicted"] == "1"
    assert int(counts["results"]) + int(counts["inputs, apart"]) == len(NUMBERS)
    assert int(counts["results"]) == 2 + int(counts["untested"])
    assert "{doc}`02 <../notebooks/02_precision>` | ci | 0 |" in page


def test_scoreboard_shows_the_worst_of_several_runs(tmp_path, monkeypatch):
    for name, value in (("01_good", 100.0), ("02_bad", 10.0), ("03_good", 100.0)):
        monkeypatch.setenv(provenance.OUTPUT_VARIABLE, str(tmp_path / name))
        paper.check("fig3.precision_ratio", value)
    runs = list(record.read_all(tmp_path))
    (row,) = [r for r in scoreboard.page(runs).splitlines() if "precision_<wbr>ratio" in r]
    assert "contradicted" in row and "(0.1\u00a0×)" in row and "02_bad" in row
    (number,) = scoreboard.accepted(runs)["numbers"].values()
    assert number["ours"] == 10
    assert number["verdict"] == "contradicted"
    assert number["chapter"] == "02_bad"


@pytest.mark.skipif(not ACCEPTED.is_file(), reason="make figures writes it")
def test_the_accepted_verdicts_follow_from_the_accepted_numbers():
    for key, number in json.loads(ACCEPTED.read_text("utf-8"))["numbers"].items():
        ours = math.nan if number["ours"] is None else number["ours"]
        assert paper.published(key).outcome(ours) == number["verdict"], key
        assert paper.published(key).value == pytest.approx(number["paper"], rel=1e-9)


def test_figures_tables_and_equations_are_found_where_they_stand(tmp_path):
    records = [
        record.Record("03_wraps", "fig04_wraps", {"numbers": {}}),
        record.Record("03_wraps", "wraps_odds", {"numbers": {}}),
        record.Record("07_table", record.PAPER, {"numbers": {"table3.a": {}, "fig13.b": {}}}),
    ]
    notebook = tmp_path / "01_light.py"
    notebook.write_text("# :label: eq-12\n# :label: eq-20-profile\n# {eq}`eq-3`\n")
    assert scoreboard.chapters_by_item(records, [notebook]) == {
        "Figure 4": ["03_wraps"],
        "Table 3": ["07_table"],
        "Equation 12": ["01_light"],
    }
    page = scoreboard.coverage_section(records, [notebook])
    assert "| Figure 4 | {doc}`03 <../notebooks/03_wraps>` |" in page
    missing = page.partition("Not yet reached: ")[2].partition(".\n")[0].split(", ")
    assert len(missing) == 40 - 3 and "Equation 20" in missing


def test_every_figure_and_equation_of_the_paper_stands_in_the_book():
    found = scoreboard.chapters_by_item([], sorted((ROOT / "notebooks").glob("*.py")))
    assert {int(item.split()[1]) for item in found} == set(range(1, 21))
    assert all(len(chapters) == 1 for chapters in found.values())
    names = {path.name[:5] for path in (ROOT / "figures").glob("fig*.json")}
    assert names >= {f"fig{number:02d}" for number in range(1, 17)}
