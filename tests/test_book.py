"""The built book: whole, local, described."""

import json
import re
from functools import cache
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from bs4 import BeautifulSoup

import graph

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "ci"
HTML = BUILD / "html"
NOTEBOOKS = graph.Book(ROOT).notebooks()
PAGES = [p for p in sorted(HTML.rglob("*.html")) if "_static" not in p.parts]

needs_build = pytest.mark.skipif(not HTML.is_dir(), reason="no ci build: make test makes one")
each_page = pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(HTML)))


@cache
def soup(page: Path) -> BeautifulSoup:
    return BeautifulSoup(page.read_text(encoding="utf-8"), "html.parser")


@cache
def anchors(page: Path) -> set[str]:
    return {tag.get(key) for tag in soup(page).find_all() for key in ("id", "name")} - {None}


@needs_build
def test_every_chapter_has_a_page_that_states_how_it_was_made():
    assert "WARNING" not in (BUILD / "book.log").read_text(encoding="utf-8")
    for stem in NOTEBOOKS:
        block = soup(HTML / "notebooks" / f"{stem}.html").select_one(".admonition.provenance")
        rows = {row.td.get_text() for row in block.select("tr") if row.td}
        assert rows >= {"profile", "seed", "cmtof", "run", "libraries"}


@needs_build
def test_no_figure_table_or_equation_of_the_paper_is_missing():
    page = (BUILD / "stage" / "book" / "scoreboard.md").read_text(encoding="utf-8")
    assert "None of them is missing." in page


@needs_build
@each_page
def test_a_page_is_whole(page: Path):
    """Resources lie beside it, links lead somewhere, images have a text."""
    for tag in soup(page).find_all(["script", "img", "iframe", "source", "link", "a"]):
        loads = tag.name != "a" and not (tag.name == "link" and "canonical" in tag.get("rel", []))
        target = urlsplit(tag.get("src") or tag.get("href") or "")
        if target.scheme or target.netloc:
            assert not loads or target.scheme == "data", f"loads {target.geturl()}"
            continue
        path = (page.parent / unquote(target.path)).resolve() if target.path else page
        assert path.exists(), target.geturl()
        # the search page makes its anchors while it runs
        if tag.name == "a" and target.fragment and path in PAGES:
            assert unquote(target.fragment) in anchors(path), target.geturl()
        if tag.name == "img" and "_static" not in target.path:
            assert tag.get("alt", "").strip(), target.geturl()


@needs_build
def test_style_sheets_load_nothing_from_elsewhere():
    for sheet in HTML.rglob("*.css"):
        text = sheet.read_text(encoding="utf-8", errors="ignore")
        assert not re.search(r"(url\(\s*['\"]?|@import\s+['\"])(https?:)?//", text), sheet.name


@needs_build
@pytest.mark.parametrize("stem", NOTEBOOKS)
def test_no_cell_ends_in_an_object_that_nobody_wants_to_read(stem: str):
    """A cell that ends in `ax.set_ylabel(...)` would print what that returns."""
    held = json.loads((BUILD / "stage" / "notebooks" / f"{stem}.ipynb").read_text("utf-8"))
    texts = [
        "".join(output["data"].get("text/plain", ""))
        for cell in held["cells"]
        for output in cell.get("outputs", ())
        if output["output_type"] == "execute_result"
    ]
    unwanted = re.compile(r"Text\(|<matplotlib|\[<|.* object at 0x|\(?array\(")
    assert not [text for text in texts if unwanted.match(text)]


@needs_build
def test_every_figure_is_placed_with_its_caption_and_text():
    placed = set().union(*map(anchors, PAGES))
    texts = {img.get("alt") for page in PAGES for img in soup(page).find_all("img")}
    for file in sorted((BUILD / "results").glob("*/*.json")):
        if file.name == "checks.json":
            continue
        record = json.loads(file.read_text(encoding="utf-8"))
        assert (file.parent / record["figure"]).is_file()
        assert "fig-" + file.stem.replace("_", "-") in placed, f"{file.stem} is on no page"
        assert record["alt"] in texts, f"{file.stem} has no alternative text"


@needs_build
def test_every_erratum_was_computed_by_this_build():
    notebook = json.loads((BUILD / "notebooks" / "22_errata.ipynb").read_text(encoding="utf-8"))
    printed = "".join(
        text
        for cell in notebook["cells"]
        for output in cell.get("outputs", [])
        for text in output.get("text", [])
    )
    verdicts = dict(re.findall(r"^(\d+)\. (\w[\w ]*?):", printed, re.MULTILINE))
    assert {int(number) for number in verdicts} >= set(range(1, 18))
    assert "NOT PROVED" not in verdicts.values()
