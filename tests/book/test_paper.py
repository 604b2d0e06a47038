"""The published numbers, the verdicts on ours, and the scoreboard page."""

import json
import math
import re
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

import scoreboard
from cmtof.book import paper, provenance
from cmtof.book.paper import quantity_text, toleranced_text

NUMBERS = paper.published_numbers()
DELTAS = ["delta_lt_1", "delta_lt_2", "delta_lt_3", "delta_ge_3"]
ROWS = {
    "table1": (["proposed", "ce_only", "fourier", "phase_only"], DELTAS),
    "table2": (
        ["phasor", "crt", "kde", "one_step", "u_net", "deep_tof", "rapid", "proposed"],
        [*DELTAS, "delta_ge_10"],
    ),
    "table3": (["conventional", "phase_offset", "ambient"], DELTAS),
    "table4": (
        ["interferometry", "rf", "proposed"],
        ["rmse_mirror", "mae_mirror", "rmse_diffuse", "mae_diffuse"],
    ),
}
RATIO = NUMBERS["fig3.precision_ratio"]
PLAIN = replace(RATIO, value=10.0, tolerance=0.5, relation="eq")
finite = st.floats(-1e9, 1e9)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    target = tmp_path / "03_precision"
    monkeypatch.setenv(provenance.OUTPUT_VARIABLE, str(target))
    provenance.begin(profile="ci", seed=4)
    yield target
    provenance.begin()


@pytest.mark.parametrize("number", NUMBERS.values(), ids=NUMBERS)
def test_every_entry_is_well_formed(number):
    assert re.fullmatch(r"(abstract|sec\d+|fig\d+|table[1-4])(\.[a-z][a-z0-9_]*){1,2}", number.key)
    assert math.isfinite(number.value)
    assert math.isfinite(number.tolerance) and number.tolerance >= 0
    assert number.unit in {"1", "fraction", "m", "s", "Hz", "W", "rad", "bit", "px", "counts"}
    assert number.relation in {"eq", "approx", "lt", "gt"}
    assert number.kind in {"result", "setting", "cited"}
    assert number.erratum is None or 1 <= number.erratum <= 30
    assert number.where and number.what and "|" not in number.what + number.reason
    assert number.comparable or number.reason, "what cannot be compared says why"
    if number.unit == "fraction":
        assert 0 <= number.value <= 1


def test_the_four_tables_are_complete():
    for table, (rows, columns) in ROWS.items():
        wanted = {f"{table}.{row}.{column}" for row in rows for column in columns}
        assert wanted == {key for key in NUMBERS if key.startswith(table)}


def test_rates_of_a_row_add_up():
    """δ < 3 and δ ≥ 3 are the two halves of one whole, and the bands nest."""
    for table in ("table1", "table2", "table3"):
        for row in ROWS[table][0]:
            one, two, three, beyond = (NUMBERS[f"{table}.{row}.{d}"].value for d in DELTAS)
            assert three + beyond == pytest.approx(1.0, abs=1e-3)
            assert one <= two <= three
    for row in ROWS["table4"][0]:
        for target in ("mirror", "diffuse"):
            rmse = NUMBERS[f"table4.{row}.rmse_{target}"].value
            assert NUMBERS[f"table4.{row}.mae_{target}"].value <= rmse


def test_the_proposed_row_is_the_same_in_three_tables():
    for delta in DELTAS:
        keys = (f"table1.proposed.{delta}", f"table2.proposed.{delta}")
        keys = (*keys, f"table3.conventional.{delta}")
        assert len({NUMBERS[key].value for key in keys}) == 1


def test_printed_numbers_follow_from_each_other():
    value = {key: number.value for key, number in NUMBERS.items()}
    duration = value["sec7.samples_per_phase"] * value["sec7.phase_steps"]
    number = NUMBERS["sec7.integration_time"]
    assert paper.verdict(number, duration / value["sec7.sample_rate"]).outcome == "agrees"
    difference = value["abstract.frequency_high"] - value["abstract.frequency_low"]
    assert paper.verdict(NUMBERS["sec6.frequency_difference"], difference).outcome == "agrees"
    error = value["fig14.height_true"] - value["fig14.height"]
    assert paper.verdict(NUMBERS["fig14.height_error"], error).outcome == "paper errs"


@pytest.mark.parametrize(
    ("relation", "value", "outcome"),
    [
        ("eq", 10.5, "agrees"),
        ("eq", 9.5, "agrees"),
        ("eq", 10.5 + 1e-9, "differs"),
        ("approx", 9.5 - 1e-9, "differs"),
        ("lt", 10.5, "differs"),
        ("lt", 10.4, "agrees"),
        ("lt", -1e6, "agrees"),
        ("gt", 9.5, "differs"),
        ("gt", 9.6, "agrees"),
        ("eq", math.nan, "differs"),
        ("lt", -math.inf, "differs"),
    ],
)
def test_verdict_at_the_edges(relation, value, outcome):
    assert paper.verdict(replace(PLAIN, relation=relation), value).outcome == outcome


def test_a_tolerance_printed_in_decimals_includes_its_edge():
    """0.0165 ± 0.0005 holds 0.017, though their floats differ by a last bit."""
    number = replace(PLAIN, value=0.0165, tolerance=0.0005)
    assert paper.verdict(number, 0.017).outcome == "agrees"


def test_reason_and_erratum_excuse_only_what_lies_outside():
    assert paper.verdict(PLAIN, 12.0, reason="other data").outcome == "not comparable"
    assert paper.verdict(PLAIN, 10.0, reason="other data").outcome == "agrees"
    assert paper.verdict(replace(PLAIN, erratum=9), 12.0).outcome == "paper errs"
    assert paper.verdict(replace(PLAIN, erratum=9), 10.0).outcome == "agrees"
    assert paper.verdict(PLAIN, 12.0, tolerance=2.0).outcome == "agrees"


@given(finite)
def test_what_is_not_comparable_never_agrees(value):
    number = replace(PLAIN, comparable=False, reason="other data")
    assert paper.verdict(number, value).outcome == "not comparable"


@given(value=finite, narrow=st.floats(0, 1e6), more=st.floats(0, 1e6))
def test_a_wider_tolerance_never_takes_agreement_away(value, narrow, more):
    for relation in ("eq", "lt", "gt"):
        number = replace(PLAIN, relation=relation)
        if paper.verdict(number, value, tolerance=narrow).outcome == "agrees":
            assert paper.verdict(number, value, tolerance=narrow + more).outcome == "agrees"


@pytest.mark.parametrize("tolerance", [-1.0, math.nan, math.inf])
def test_a_senseless_tolerance_is_refused(tolerance):
    with pytest.raises(ValueError, match="Expected a tolerance"):
        paper.verdict(PLAIN, 10.0, tolerance=tolerance)


def test_unknown_key_names_the_closest():
    with pytest.raises(ValueError, match=r"Expected .* got 'fig3.precison'. Use 'fig3.precision"):
        paper.published("fig3.precison")


def test_check_prints_one_line_and_records(folder, capsys):
    paper.check("fig3.precision_ratio", 99.8)
    paper.check("fig4.wraps_high", math.nan, reason="nothing seen")
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "fig3.precision_ratio: paper ≈ 100 ± 10, ours 99.8: agrees"
    assert len(lines) == 2 and lines[1].endswith("not finite: differs (nothing seen)")
    records = json.loads((folder / paper.CHECKS).read_text(encoding="utf-8"))
    assert records["fig3.precision_ratio"]["value"] == 99.8
    assert records["fig3.precision_ratio"]["seed"] == 4
    assert records["fig4.wraps_high"]["value"] is None


def test_checking_again_replaces_the_record(folder):
    paper.check("fig3.precision_ratio", 50.0)
    paper.check("fig3.precision_ratio", 100.0)
    records = paper.read_checks(folder / paper.CHECKS)
    assert records["fig3.precision_ratio"]["verdict"] == "agrees"


def _keys(block):
    return re.findall(r"<br><code>([a-z0-9_.]+)</code>", block.replace("<wbr>", ""))


def test_scoreboard_lists_every_key_once(folder):
    paper.check("fig3.precision_ratio", 99.8)
    page = scoreboard.page([folder / paper.CHECKS])
    listed = []
    for block in re.split(r"^## ", page, flags=re.MULTILINE)[1:]:
        name, _, number = block.partition("\n")[0].partition(" ")
        group = {"Table": "table", "Figure": "fig", "Section": "sec"}.get(name, name.lower())
        listed += [f"{group}{number}.{key}" for key in _keys(block)]
    assert sorted(listed) == sorted(NUMBERS)


def test_scoreboard_counts_every_number(folder):
    paper.check("fig3.precision_ratio", 99.8)
    paper.check("fig14.height_error", 1.2e-6)
    paper.check("sec6.effective_wavelength", 0.1)
    paper.check("sec8.gain", 20)
    page = scoreboard.page([folder / paper.CHECKS])
    counts = dict(re.findall(r"^\| ([a-z ]+) \| (\d+ \| \d+) \|$", page, flags=re.MULTILINE))
    assert counts["agrees"] == "1 | 1"
    assert counts["differs"] == "1 | 0"
    assert counts["paper errs"] == "1 | 0"
    sums = [sum(int(pair.split(" | ")[i]) for pair in counts.values()) for i in (0, 1)]
    assert sum(sums) == len(NUMBERS)
    assert f"| **all** | **{sums[0]}** | **{sums[1]}** |" in page
    assert "{doc}`03 <../notebooks/03_precision>` | ci | 4 |" in page


def test_scoreboard_shows_the_worst_of_several_runs(tmp_path, monkeypatch):
    paths = []
    for name, value in (("01_good", 100.0), ("02_bad", 10.0), ("03_good", 100.0)):
        monkeypatch.setenv(provenance.OUTPUT_VARIABLE, str(tmp_path / name))
        paper.check("fig3.precision_ratio", value)
        paths.append(tmp_path / name / paper.CHECKS)
    (row,) = [r for r in scoreboard.page(paths).splitlines() if _keys(r) == ["precision_ratio"]]
    assert "differs" in row and "02_bad" in row


def test_scoreboard_without_runs_reaches_nothing():
    page = scoreboard.page([])
    assert "| agrees | 0 | 0 |" in page and "## Runs" not in page


@pytest.mark.parametrize("content", ["", "[1]", '{"fig3'])
def test_a_broken_record_is_one_clear_line(tmp_path, content):
    path = tmp_path / paper.CHECKS
    path.write_text(content)
    with pytest.raises(ValueError, match=r"Expected .*JSON"):
        scoreboard.page([path])


@given(st.floats(1e-14, 1e11), st.sampled_from(["m", "s", "Hz", "W"]))
def test_prefixed_text_reads_back(value, unit):
    powers = {"G": 9, "M": 6, "k": 3, "": 0, "m": -3, "µ": -6, "n": -9, "p": -12, "f": -15}
    digits, _, label = quantity_text(value, unit).partition(" ")
    assert float(digits) * 10.0 ** powers[label.removesuffix(unit)] == pytest.approx(
        value, rel=1e-3
    )


def test_text_of_numbers_without_prefix():
    assert quantity_text(77400, "1") == "77400"
    assert quantity_text(0.0, "m") == "0 m"
    assert quantity_text(9e-6, "fraction") == "0.0009 %"
    assert toleranced_text(20, 0, "1") == "20"
