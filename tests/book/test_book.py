"""The built book: whole, local, described."""

import json
import re
from functools import cache
from urllib.parse import unquote, urlsplit

from bs4 import BeautifulSoup
from pytest import mark

from cmtof_book import ROOT, graph, scoreboard
from cmtof_book.paper import published_numbers
from cmtof_book.record import read_all

BUILD = ROOT / "build" / "ci"
HTML = BUILD / "html"
NOTEBOOKS = graph.notebooks()
ERRATA = (ROOT / "notebooks" / "22_errata.py").read_text("utf-8")
PAGES = [p for p in sorted(HTML.rglob("*.html")) if "_static" not in p.parts]

pytestmark = mark.skipif(not HTML.is_dir(), reason="no ci build: make test makes one")


@cache
def soup(page):
    return BeautifulSoup(page.read_text("utf-8"), "html.parser")


@cache
def anchors(page):
    return {tag.get(key) for tag in soup(page).find_all() for key in ("id", "name")}


def test_every_chapter_has_a_page_that_states_how_it_was_made():
    assert "WARNING" not in (BUILD / "book.log").read_text("utf-8")
    for stem in NOTEBOOKS:
        page = soup(HTML / "notebooks" / f"{stem}.html")
        assert not page.select(".stderr")  # a warning names a path of this machine
        rows = {cell.get_text() for cell in page.select(".provenance td:first-child")}
        assert rows >= {"profile", "seed", "cmtof", "run", "libraries"}


def test_no_figure_table_or_equation_of_the_paper_is_missing():
    chapters = scoreboard.coverage(
        read_all(BUILD / "results"), ROOT.glob("notebooks/*.py")
    )
    assert len(chapters) == 16 + 4 + 20
    assert all(chapters.values())


LOADED = "script, img, iframe, source, link:not([rel~=canonical])"


def faults(page):
    """Resources from elsewhere, links to nothing, images without a text."""
    for tag in soup(page).select(f"{LOADED}, a"):
        target = urlsplit(tag.get("src") or tag.get("href") or "")
        if target.scheme or target.netloc:
            if tag.name != "a" and target.scheme != "data":
                yield f"loads {target.geturl()}"
            continue
        path = (page.parent / unquote(target.path)).resolve() if target.path else page
        anchor = tag.name == "a" and target.fragment and path in PAGES
        if not path.exists() or (
            anchor and unquote(target.fragment) not in anchors(path)
        ):
            yield f"leads nowhere: {target.geturl()}"
        if (
            tag.name == "img"
            and "_static" not in target.path
            and not tag.get("alt", "").strip()
        ):
            yield f"no text: {target.geturl()}"


def test_pages_are_whole():
    assert PAGES
    assert not [f"{page.name}: {fault}" for page in PAGES for fault in faults(page)]


def test_style_sheets_load_nothing_from_elsewhere():
    for sheet in HTML.rglob("*.css"):
        text = sheet.read_text("utf-8", errors="ignore")
        assert not re.search(r"(url\(\s*['\"]?|@import\s+['\"])(https?:)?//", text), (
            sheet.name
        )


def outputs(stem):
    path = BUILD / "stage" / "notebooks" / f"{stem}.ipynb"
    cells = json.loads(path.read_text("utf-8"))["cells"]
    return [output for cell in cells for output in cell.get("outputs", ())]


def test_no_cell_ends_in_an_object_that_nobody_wants_to_read():
    """A cell that ends in `ax.set_ylabel(...)` would print what that returns."""
    unwanted = re.compile(r"Text\(|<matplotlib|\[<|.* object at 0x|\(?array\(")
    for stem in NOTEBOOKS:
        for out in outputs(stem):
            if out["output_type"] == "execute_result":
                assert not unwanted.match("".join(out["data"].get("text/plain", "")))


def printed_by_errata():
    return "".join(text for out in outputs("22_errata") for text in out.get("text", ()))


REFERENCES = re.compile(  # formulas, quotes, and what points to a place in the paper
    r"\$[^$]*\$|«[^»]*»|`[^`]*`|\[[^]]*\]\([^)]*\)|\(\d[\d.]*\)|[\d/]*π[\d/]*|"
    r"\b(Sections?|Eqs?\.|Figs?\.|Tab\.|Tables?|entr(y|ies)) [\d.]+((,| and| to) [\d.]+)*"
)
# of ten, between a number and per cent or a unit
POWERS = (2, *range(-9, 16, 3))


def written_numbers(text):
    return [
        one.replace(",", "")
        for one in re.findall(r"(?<![\w.^_])\d[\d,]*(?:\.\d+)?", text)
    ]


def is_written(number, word):
    """Whether a number, in some unit, reads so."""
    places = len(word.partition(".")[2])
    return word in {f"{number * 10.0**power:.{places}f}" for power in POWERS}


def test_every_number_of_the_errata_is_printed_by_the_run_or_read_from_the_paper_by_it():
    missing = []
    for part in ERRATA.split("# %% [markdown]"):
        read = [
            one.value for one in published_numbers().values() if f'"{one.key}"' in part
        ]
        document = "\n".join(
            line[2:] for line in part.splitlines() if line.startswith("#")
        )
        entries = re.split(r"(?:^|\n)### (\d+) · ", document.partition("\n%%")[0])
        for entry, body in zip(entries[1::2], entries[2::2], strict=True):
            lines = re.findall(rf"(?m)^{entry}: (.*)$", printed_by_errata())
            known = [*read, *map(float, written_numbers(" ".join(lines)))]
            missing += [
                f"erratum {entry}: {word}"
                for word in written_numbers(REFERENCES.sub(" ", body))
                if not any(is_written(one, word) for one in known)
            ]
    assert not missing


def test_every_erratum_was_computed_by_this_build():
    counted = re.findall(r"(?m)^\w+: (\d+) of (\d+) hold$", printed_by_errata())
    assert sum(int(whole) for _, whole in counted) == 29
    assert all(held == whole for held, whole in counted)
