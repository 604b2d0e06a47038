"""The published numbers, the verdicts on ours, the claims, and the scoreboard page."""

import json
import math
import re
from dataclasses import replace

from pytest import approx, mark

from cmtof_book import ROOT, claims, compared, paper, provenance, record, scoreboard
from cmtof_book.verdict import CROPS, Score

NUMBERS = paper.published_numbers()
PLAIN = replace(
    NUMBERS["sec1.wrap_depth_7ghz"], value=10.0, tolerance=0.5, relation="eq"
)
KNOWN = {one.name: one for number in NUMBERS.values() for one in number.depends}


def scores(values, **about):
    """All published numbers, some with ours."""
    return {
        key: Score(one, values.get(key, {}), **about) for key, one in NUMBERS.items()
    }


def claims_by(values, **about):
    """The claims by name, as our numbers lead to them."""
    return {one.name: one for one in claims.claims(scores(values, **about))}


@mark.parametrize(
    ("relation", "ours", "verdict"),
    [
        ("eq", 10.5, "reproduced"),
        ("eq", 9.4, "contradicted"),
        ("lt", 10.4, "reproduced"),
        ("lt", 10.5, "contradicted"),
        ("gt", 9.6, "reproduced"),
        ("gt", 9.5, "contradicted"),
        ("eq", math.nan, "untested"),
        ("eq", (10.1, 9.6, 10.6), "reproduced"),
        ("eq", (10.1, 9.0, 11.2), "open"),  # over four tolerances wide
        ("eq", (10.7, 10.4, 11.0), "open"),  # near it, but not within the tolerance
        ("eq", (13, 12, 14), "contradicted"),
        ("lt", (2, 1, 9), "reproduced"),  # the direction counts, not the distance
        ("lt", (10, 9, 12), "open"),
        ("eq", {"one": 10, "other": 20}, "open"),  # two cases disagree
        ("eq", {"one": 20, "other": 30}, "contradicted"),
    ],
)
def test_value_interval_and_cases_decide(relation, ours, verdict):
    assert Score(replace(PLAIN, relation=relation), ours).verdict == verdict


def test_the_last_bit_of_a_float_decides_nothing():
    edge = replace(PLAIN, value=0.0165, tolerance=0.0005)
    assert Score(edge, 0.017).verdict == "reproduced"


@mark.parametrize(
    ("needs", "about", "verdict"),
    [
        ("scenes", {}, "open"),
        ("training", {"crops": 28_000}, "open"),
        ("training", {"crops": CROPS}, "contradicted"),
        ("sizes", {"profile": "ci"}, "untested"),
        ("sizes", {"profile": "book"}, "contradicted"),
    ],
)
def test_what_is_not_the_papers_leaves_a_number_open(needs, about, verdict):
    score = Score(replace(PLAIN, depends=(KNOWN[needs],)), 20, **about)
    assert score.verdict == verdict
    assert ("It would be decided by: " in score.note) == (verdict == "open")
    assert "28,000" in score.note or about.get("crops") != 28_000


def test_settings_are_compared_too():
    setting = replace(PLAIN, kind="setting", changed="Why.")
    assert Score(setting, 10.2).verdict == "as stated"
    changed = Score(setting, 11)
    assert (changed.verdict, changed.note) == ("changed", "Why.")
    assert Score(replace(PLAIN, untested="other data"), 10).verdict == "untested"


def test_rates_of_the_tables_nest_and_add_up():
    for key, number in NUMBERS.items():
        if key.endswith("delta_lt_3"):
            row = key.removesuffix("lt_3")
            rates = [NUMBERS[f"{row}lt_{k}"].value for k in (1, 2, 3)]
            assert sorted(rates) == rates, key
            assert number.value + NUMBERS[f"{row}ge_3"].value == approx(1, abs=1e-3)


def test_a_claim_says_in_one_line_why():
    wide = claims_by({"fig3.precision_ratio": (100, 20, 180)})
    assert wide["precision"].why == "Our interval is too wide."
    apart = {"at once": 1.0, "later": 0.1}
    far = {"sec8.network_scanned": apart, "sec8.kde_scanned": apart}
    told = "Network: ours agrees at once; ours differs later. KDE: ours differs at once; ours"
    assert claims_by(far)["scanned"].why.startswith(told)
    order = claims_by({"sec8.order": 1.0}, crops=36_000)["order"]
    assert order.why.startswith("It holds although the scenes, the training")
    assert claims_by({})["order"].why == "No chapter computes it."


def test_the_picture_has_a_line_for_each_result_at_its_ratio():
    text = scoreboard.picture(
        scores(
            {
                "fig3.precision_ratio": (100, 90, 110),
                "table4.proposed.rmse_mirror": {"quiet": 1, "noisy": 1e-9},
            }
        )
    )
    lines = re.findall(r'<li data-verdict="(\w+)" data-same="(\w+)"', text)
    assert lines == [("reproduced", "yes"), ("open", "no")]
    # the paper's number is in the middle
    assert re.findall(r'class="dot" d="M([\d.]+) ', text) == ["50.0", "98.0", "2.0"]


def test_the_accepted_verdicts_follow_from_the_accepted_numbers():
    """What contradicts the paper has a sentence that says why."""
    accepted = (ROOT / "figures" / "scoreboard.json").read_text("utf-8")
    held = json.loads(accepted)["numbers"]
    for key, number in held.items():
        published = NUMBERS[key]
        verdict = number["verdict"]
        score = Score(
            published,
            number["cases"],
            profile=number["profile"],
            crops=number["crops"],
        )
        assert score.verdict == verdict, key
        assert published.note or verdict != "contradicted", key
        assert published.changed or verdict != "changed", key
    for claim in claims_by({}).values():
        chapters = {held[key]["chapter"] for key in claim.about["keys"]}
        assert chapters == {claim.about["chapter"]}  # that of its figure


def test_claims_are_filled_with_numbers_of_the_build():
    law = compared.closed_form([0.5, 0.25]).record()
    records = [record.Record("03_wraps", "wraps_odds", {"numbers": {"law": law}})]
    found = {"sec8.rf_plate": {"quiet": (2e-3, 1e-3, 3e-3), "noisy": 4e-3}}
    numbers = claims.numbers_of(scores(found), records)
    asked = "{p[sec8.rf_plate@0 alone]}, {p[sec8.rf_plate@0]}, {p[sec8.rf_plate@1]}, "
    asked += "{p[sec1.contrast]}, {f[03_wraps/wraps_odds][law][1]:.0%}"
    told = claims.fill_in(asked, numbers).replace("\N{NO-BREAK SPACE}", " ")
    assert told == "2 mm, 2 mm (1–3 mm), 4 mm, (not computed), 25 %"


def test_what_was_checked_is_recorded_shown_and_counted(tmp_path, monkeypatch):
    monkeypatch.setenv(provenance.OUTPUT_VARIABLE, str(tmp_path / "02_precision"))
    monkeypatch.setitem(provenance.RUN, "profile", "book")
    paper.check("fig3.precision_ratio", compared.sum_over_draws(99.8, error=3.2))
    paper.check(
        "table4.rf.rmse_mirror",
        {"quiet": (1e-5, 2e-6, 9.9e-5), "noisy": (2e-4, 1e-4, 3e-4)},
        crops=28_000,
    )
    shown = []
    monkeypatch.setattr(
        paper.notes, "table", lambda head, rows, fold: shown.extend(rows)
    )
    paper.table()
    assert shown[0][1:] == ["≈ 100 ± 10", "99.8 (93.5–106)", "reproduced"]
    assert shown[1][2:] == ["10 µm (2–99 µm) quiet; 200 µm (100–300 µm) noisy", "open"]
    found = scoreboard.scores_in(record.read_all(tmp_path))
    assert found["table4.rf.rmse_mirror"].crops == 28_000
    page = scoreboard.page(found)
    listed = re.findall(r"<br><code>([a-z0-9_.]+)</code>", page.replace("<wbr>", ""))
    assert sorted(listed) == sorted(key.partition(".")[2] for key in NUMBERS)
    row = r'(?m)^\| <span class="verdict .*">(.+)</span> \| (\d+) \|'
    counts = dict(re.findall(row, page))
    assert counts["reproduced"] == counts["open"] == "1"
    assert int(counts["untested"]) == len(NUMBERS) - 2
    assert "<br>{doc}`02 <../notebooks/02_precision>` |" in page
