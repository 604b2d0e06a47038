"""Which figure, table and equation of the paper stands where."""

from pathlib import Path

import pytest

import scoreboard as coverage
from scoreboard import Item

ROOT = Path(__file__).parents[2]


@pytest.fixture
def chapters(tmp_path):
    (tmp_path / "03_wraps").mkdir()
    (tmp_path / "07_table").mkdir()
    (tmp_path / "03_wraps" / "fig04_wraps.json").write_text("{}")
    (tmp_path / "03_wraps" / "wraps_odds.json").write_text("{}")
    (tmp_path / "07_table" / "table1_rates.json").write_text("{}")
    (tmp_path / "07_table" / "checks.json").write_text('{"table3.a": 1, "fig13.b": 2}')
    notebook = tmp_path / "01_light.py"
    notebook.write_text("# :label: eq-12\n# :label: eq-20-profile\n# {eq}`eq-3`\n")
    return [tmp_path / "03_wraps", tmp_path / "07_table"], [notebook]


def test_items_are_found_where_they_stand(chapters):
    assert coverage.chapters_by_item(*chapters) == {
        Item("Figure", 4): ["03_wraps"],
        Item("Table", 1): ["07_table"],
        Item("Table", 3): ["07_table"],
        Item("Equation", 12): ["01_light"],
    }


def test_section_links_what_stands_and_names_what_is_missing(chapters):
    page = coverage.coverage_section(*chapters)
    assert "| Figure 4 | {doc}`03 <../notebooks/03_wraps>` |" in page
    missing = page.partition("Not yet reached: ")[2].partition(".\n")[0].split(", ")
    assert len(missing) == 16 + 4 + 20 - 4
    assert "Equation 20" in missing and "Figure 4" not in missing


def test_every_equation_of_the_paper_stands_in_one_chapter():
    found = coverage.chapters_by_item([], sorted((ROOT / "notebooks").glob("*.py")))
    assert {item.number for item in found} == set(range(1, 21))
    assert all(len(chapters) == 1 for chapters in found.values())


def test_every_figure_is_drawn():
    names = {path.name[:5] for path in (ROOT / "figures").glob("fig*.json")}
    assert names >= {f"fig{number:02d}" for number in range(1, 17)}
