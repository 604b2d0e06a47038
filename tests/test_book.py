"""The built book: whole, local, described, and clean in a browser without a network."""

import json
import re
import shutil
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import browse
import graph
import pairs

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "ci"
HTML = BUILD / "html"
NOTEBOOKS = graph.Book(ROOT).notebooks()

needs_build = pytest.mark.skipif(not HTML.is_dir(), reason="no ci build: make test makes one")


class Page(HTMLParser):
    """The tags and anchors of a page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.path = path
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, {key: value or "" for key, value in attrs}))

    @property
    def anchors(self) -> set[str]:
        return {about[key] for _, about in self.tags for key in ("id", "name") if key in about}

    def resources(self) -> Iterator[str]:
        """Yield what a browser loads on its own, links to follow left out."""
        for tag, about in self.tags:
            if tag in {"script", "img", "iframe", "source", "video", "audio", "embed"}:
                yield about.get("src", "")
            if tag == "link" and {"stylesheet", "icon", "preload"} & set(about["rel"].split()):
                yield about.get("href", "")


@cache
def pages() -> tuple[Page, ...]:
    return tuple(Page(path) for path in browse.pages(HTML)) if HTML.is_dir() else ()


each_page = pytest.mark.parametrize(
    "page", pages(), ids=lambda page: str(page.path.relative_to(HTML))
)


def test_notebook_pairs_agree():
    scripts = sorted((ROOT / "notebooks").glob("[0-9]*.py"))
    stale = [s.stem for s in scripts if not pairs.same(s, s.with_suffix(".ipynb"))]
    assert not stale, "run make pairs"


@needs_build
def test_sphinx_gave_no_warning():
    assert "WARNING" not in (BUILD / "book.log").read_text(encoding="utf-8")


@needs_build
def test_every_chapter_has_a_page():
    assert {HTML / "notebooks" / f"{stem}.html" for stem in NOTEBOOKS} <= {p.path for p in pages()}


@needs_build
@each_page
def test_resources_lie_beside_the_page(page: Page):
    for url in filter(None, page.resources()):
        assert not urlsplit(url).netloc, f"loads {url} from elsewhere"
        if not url.startswith("data:"):
            assert (page.path.parent / unquote(urlsplit(url).path)).is_file(), url


@needs_build
def test_style_sheets_load_nothing_from_elsewhere():
    for sheet in HTML.rglob("*.css"):
        text = sheet.read_text(encoding="utf-8", errors="ignore")
        assert not re.search(r"(url\(\s*['\"]?|@import\s+['\"])(https?:)?//", text), sheet.name


@needs_build
@each_page
def test_links_within_the_book_lead_somewhere(page: Page):
    known = {other.path: other.anchors for other in pages()}
    for tag, about in page.tags:
        target = urlsplit(about.get("href", ""))
        if tag != "a" or target.scheme or target.netloc:
            continue
        path = (page.path.parent / unquote(target.path)).resolve() if target.path else page.path
        assert path.exists(), about["href"]
        # the search page makes its anchors while it runs
        if target.fragment and path in known:
            assert unquote(target.fragment) in known[path], about["href"]


@needs_build
@each_page
def test_every_image_has_a_text(page: Page):
    for tag, about in page.tags:
        if tag == "img" and "_static" not in about.get("src", ""):
            assert about.get("alt", "").strip(), about


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
@pytest.mark.parametrize("stem", NOTEBOOKS)
def test_executed_pages_tell_how_they_were_made(stem: str):
    text = (HTML / "notebooks" / f"{stem}.html").read_text(encoding="utf-8")
    assert "How this page was made" in text
    for row in ("profile", "seed", "cmtof", "run", "numpy"):
        assert row in text.split("How this page was made")[1]


@needs_build
def test_every_figure_is_placed_with_its_caption_and_text():
    anchors = set().union(*(page.anchors for page in pages()))
    images = {about.get("alt") for page in pages() for tag, about in page.tags if tag == "img"}
    for file in sorted((BUILD / "results").glob("*/*.json")):
        if file.name == "checks.json":
            continue
        record = json.loads(file.read_text(encoding="utf-8"))
        assert (file.parent / record["figure"]).is_file()
        assert "fig-" + file.stem.replace("_", "-") in anchors, f"{file.stem} is on no page"
        assert record["alt"] in images, f"{file.stem} has no alternative text"


@needs_build
def test_every_erratum_was_proved_by_this_build():
    notebook = json.loads((BUILD / "notebooks" / "22_errata.ipynb").read_text(encoding="utf-8"))
    printed = "".join(
        text
        for cell in notebook["cells"]
        for output in cell.get("outputs", [])
        for text in output.get("text", [])
    )
    verdicts = dict(re.findall(r"^(\d+)\. (proved|NOT PROVED):", printed, re.MULTILINE))
    assert {int(number) for number in verdicts} >= set(range(1, 18))
    assert [number for number, verdict in verdicts.items() if verdict != "proved"] == []


@pytest.mark.slow
@needs_build
@pytest.mark.skipif(
    not (shutil.which("chromium") or shutil.which("chromium-browser")),
    reason="no Chromium here (Debian: apt-get install chromium)",
)
def test_a_browser_without_a_network_finds_nothing_wrong():
    with browse.chromium() as tab:
        visits = [
            tab.visit(page, width)
            for page in browse.pages(HTML)
            for width in browse.WIDTHS.values()
        ]
    assert not {(v.page, v.width): v.problems for v in visits if v.problems}
