"""The book in a browser without a network, as its readers use it: `make test-book`."""

import shutil
from pathlib import Path

import browse
import pytest

BUILD = Path(__file__).resolve().parents[2] / "build"
HTML = next((BUILD / p / "html" for p in ("book", "ci") if (BUILD / p / "html").is_dir()), BUILD)
PAGES = browse.pages(HTML)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not PAGES, reason="no book: make book builds one"),
    pytest.mark.skipif(
        not (shutil.which("chromium") or shutil.which("chromium-browser")),
        reason="no Chromium here (Debian: apt-get install chromium)",
    ),
]


@pytest.fixture(scope="module")
def browser():
    with browse.chromium() as found:
        yield found


@pytest.mark.parametrize("width", browse.WIDTHS.values(), ids=browse.WIDTHS)
def test_nothing_is_wrong_with_any_page(browser, width):
    found = {}
    for page in PAGES:
        with browse.opened(browser, page, width) as (tab, problems):
            problems += browse.faults(tab.evaluate(browse.PROBE), width)
        found |= {page.stem: problems} if problems else {}
    assert not found


@pytest.mark.parametrize("width", [390, 800, 1280])
def test_the_menu_opens_and_closes(browser, width):
    with browse.opened(browser, HTML / "book" / "intro.html", width) as (tab, _):
        bar = tab.locator(".bd-sidebar-primary").first
        before = bar.is_visible()
        tab.locator("button.primary-toggle:visible").click()
        bar.wait_for(state="hidden" if before else "visible")
        if before:
            tab.locator("button.primary-toggle:visible").click()
        else:
            tab.keyboard.press("Escape")
        bar.wait_for(state="visible" if before else "hidden")


@pytest.mark.parametrize("words", ["Cramer-Rao", "SCPI", "frequency doubling"])
def test_search_finds_a_term(browser, words):
    with browse.opened(browser, HTML / "search.html", 1280) as (tab, _):
        tab.goto(f"{(HTML / 'search.html').as_uri()}?q={words}")
        tab.locator("#search-results li").first.wait_for()
