"""The book in a browser without a network, as its readers use it: `make test-book`."""

import contextlib
import re
from functools import partial
from unittest.mock import MagicMock

import browse
import numpy as np
from pytest import fixture, mark

from cmtof_book import ROOT, live, views
from cmtof_book.provenance import OUTPUT_VARIABLE

BUILD = ROOT / "build"
HTML = next(
    (BUILD / p / "html" for p in ("book", "ci") if (BUILD / p / "html").is_dir()), BUILD
)
PAGES = browse.pages(HTML)

pytestmark = [
    mark.slow,
    mark.skipif(not PAGES, reason="no book: make book builds one"),
    mark.skipif(
        not browse.CHROMIUM,
        reason="no Chromium here (Debian: apt-get install chromium)",
    ),
]


@fixture(scope="module")
def browser():
    with browse.chromium() as found:
        yield found


@fixture
def visit(browser):
    """Open a page of the book, which has nothing to complain about."""
    problems = []
    with contextlib.ExitStack() as stack:

        def opened(page, width=1280):
            tab, found = stack.enter_context(browse.opened(browser, HTML / page, width))
            problems.append(found)
            return tab

        yield opened
    assert not any(problems)


@mark.parametrize("width", browse.WIDTHS.values())
def test_nothing_is_wrong_with_any_page(browser, width):
    found = {}
    for page in PAGES:
        with browse.opened(browser, page, width) as (tab, problems):
            problems += browse.faults(tab.evaluate(browse.PROBE), width)
        found |= {page.stem: problems} if problems else {}
    assert not found


PLACES = {
    "Cramer-Rao": "html",
    "cite": "intro.html#index-",
    "33.5": "scoreboard.html#index-",
    "Fig. 13": "17_precision_sweep.html#index-",
    "Eq. 17": "04_modulator.html#index-",
}


@mark.parametrize("words", PLACES)
def test_search_finds_a_place_first_and_quotes_its_page(visit, words):
    tab = visit("search.html")
    tab.goto(f"{tab.url}?q={words}")
    found = tab.locator("#search-results li").first
    found.locator("p.context").wait_for()
    assert PLACES[words] in found.locator("a").first.get_attribute("href")
    assert not re.search(r"\\\w|import ", found.inner_text())


@mark.parametrize("chapter", ["03_wraps", "04_modulator", "18_error_budget"])
def test_every_slider_changes_the_curve(visit, chapter):
    tab = visit(f"notebooks/{chapter}.html")
    curve = tab.locator("[data-play] .curve")
    seen = set()
    sliders = tab.locator("[data-play] input").all()
    for slider in sliders:
        slider.focus()
        for key in ("Home", "End"):
            tab.keyboard.press(key)
            assert "NaN" not in curve.get_attribute("d")
            seen.add(curve.get_attribute("d"))
    assert len(seen) > len(sliders)


def pinch(tab, canvas):
    """Move two fingers apart on a scene."""
    box = canvas.bounding_box()
    touch = tab.context.new_cdp_session(tab)
    for kind, apart in (("touchStart", 30), ("touchMove", 60), ("touchEnd", 0)):
        ends = [
            {"x": box["x"] + 100 + x, "y": box["y"] + 100}
            for x in (-apart, apart)
            if apart
        ]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": ends})


@mark.parametrize(
    "page", ["book/intro", "notebooks/21_scanned_scenes", "notebooks/11_surfaces"]
)
def test_a_scene_turns_changes_and_is_reset(visit, page):
    tab = visit(f"{page}.html")
    scene = tab.locator(".scene").first
    scene.click()
    canvas = scene.locator("canvas")
    canvas.click()
    acts = [partial(tab.keyboard.press, key) for key in ("ArrowLeft", "ArrowUp")]
    acts += [partial(tab.mouse.wheel, 0, -200), partial(pinch, tab, canvas)]
    for name in ("wraps off", "truth", "nearer", "reset"):
        acts.append(scene.get_by_role("button", name=name).click)
    pictures = []
    for act in [lambda: None, *acts]:
        act()
        tab.wait_for_timeout(300)
        pictures.append(canvas.evaluate("canvas => canvas.toDataURL()"))
    assert pictures[0] == pictures[-1]
    assert len(set(pictures)) == len(pictures) - 1


def test_a_notebook_has_what_moves_on_pages(browser, tmp_path, monkeypatch):
    shown = MagicMock()
    monkeypatch.setattr("IPython.display.display", shown)
    monkeypatch.setenv(OUTPUT_VARIABLE, str(HTML.parent / "results" / "11_surfaces"))
    live.show('<div data-play="odds"></div>')
    views.show_scene("scene_room", title='the "room"')
    page = tmp_path / "outputs.html"
    page.write_text("".join(call.args[0]["text/html"] for call in shown.mock_calls))
    with browse.opened(browser, page, 1280) as (tab, problems):
        tab.frame_locator("iframe >> nth=1").get_by_text('Turn it: the "room"').click()
        for number, part in enumerate(("input >> nth=0", "canvas")):
            moved = tab.frame_locator(f"iframe >> nth={number}").locator(part)
            moved.press("ArrowLeft")
            before = tab.screenshot()
            moved.press("ArrowLeft")
            tab.wait_for_timeout(300)
            assert tab.screenshot() != before
        assert not problems


@mark.parametrize("chapter", ["10_methods", "21_scanned_scenes"])
def test_a_divider_shows_one_method_or_the_other(visit, chapter):
    figure = visit(f"notebooks/{chapter}.html").locator("figure.swipe")
    slider = figure.locator("[type=range]")
    acts = [partial(slider.press, key) for key in ("Home", "End")]
    acts += [
        figure.get_by_label("errors").check,
        partial(slider.hover, position={"x": 9, "y": 9}),
    ]
    acts += 2 * [partial(slider.press, "Shift+ArrowDown")]
    shown = []
    for act in acts:
        act()
        shown.append(figure.screenshot())
    assert len(set(shown)) == len(shown)
    assert re.match(
        r"Pixel \(\d+,\d+\): (not scored|truth: \d+ wraps, \d+ mm; .*odds)",
        figure.locator("output").inner_text(),
    )


def test_the_scoreboard_shows_what_is_chosen(visit):
    figure = visit("book/scoreboard.html").locator("figure.ratios")
    lines = figure.locator("li").count()
    for box in figure.locator("input").all():
        value = box.get_attribute("value")
        chosen = figure.locator(
            f"[data-verdict='{value}'], [data-same='{value}']"
        ).count()
        box.uncheck()
        assert lines > figure.locator("li:visible").count() == lines - chosen
        box.check()


@mark.parametrize("kind", ["#equation-", "bibliography.html#"])
def test_a_link_shows_what_it_leads_to(visit, kind):
    tab = visit("notebooks/08_network.html")
    tab.locator(f".bd-article a.reference.internal[href*='{kind}']").first.hover()
    box = tab.locator("div.preview")
    box.wait_for()
    assert box.inner_text()
    tab.mouse.move(0, 0)
    box.wait_for(state="detached")


def test_a_phone_offers_to_enlarge_a_picture(visit):
    tab = visit("notebooks/01_correlation.html", 390)
    assert "tap" in tab.locator("figcaption").first.evaluate(
        "caption => getComputedStyle(caption, '::before').content"
    )
    tab.locator("figure img").first.click()
    assert tab.locator("dialog.zoom img").bounding_box()["width"] >= 900
    tab.keyboard.press("Escape")
    tab.locator("dialog.zoom").wait_for(state="detached")


def test_the_book_is_light():
    sizes = {file: file.stat().st_size for file in HTML.rglob("*") if file.is_file()}
    assert sum(sizes.values()) < 45e6
    for page in PAGES:
        images = {
            (page.parent / source).resolve()
            for source in re.findall(r'<img[^>]* src="([^"]+)"', page.read_text())
            if "data:" not in source
        }
        assert sizes[page] + sum(image.stat().st_size for image in images) < 3e6, (
            page.stem
        )


def right_share(tab, method):
    """Share of right wraps that the laboratory shows, once nothing is left to compute."""
    done = "document.querySelector('#laboratory').dataset.milliseconds"
    tab.wait_for_timeout(100)
    tab.wait_for_function(done)
    caption = tab.locator("#laboratory figcaption", has_text=f"errors of the {method}")
    return float(re.search(r"([\d.]+) % right", caption.inner_text())[1])


@mark.parametrize("width", browse.WIDTHS.values())
@mark.parametrize("colours", ["light", "dark"])
def test_the_laboratory_measures_and_unwraps(browser, width, colours, tmp_path):
    with browse.opened(browser, HTML / "book" / "laboratory.html", width) as (
        tab,
        problems,
    ):
        tab.emulate_media(color_scheme=colours)
        tab.locator("#laboratory[data-ready]").wait_for(timeout=120_000)
        noisy = {method: right_share(tab, method) for method in ("beat", "network")}
        tab.locator("[name=sigma]").focus()
        tab.keyboard.press("Home")
        assert all(right_share(tab, method) > noisy[method] for method in noisy)
        tab.locator("[name=offset]").focus()
        tab.keyboard.press("End")
        assert all(right_share(tab, method) < noisy[method] for method in noisy)
        read_a_pixel(tab)
        take_own_scenes(tab, tmp_path)
        assert not problems


def read_a_pixel(tab):
    """Move the pixel by mouse, by touch and by keyboard."""
    canvas = tab.locator("#laboratory canvas").first
    pixel = tab.locator("#laboratory .spot p")
    box = canvas.bounding_box()
    touch = {"pointerType": "touch", "clientX": box["x"] + 50, "clientY": box["y"] + 60}
    acts = [
        partial(canvas.dispatch_event, "pointerdown", touch),
        partial(canvas.press, "ArrowUp"),
    ]
    seen = {pixel.inner_text()}
    for act in (partial(canvas.hover, position={"x": 30, "y": 40}), *acts):
        act()
        seen.add(pixel.inner_text())
    assert len(seen) == 4


def take_own_scenes(tab, folder):
    """Take a frame of the reader's and the phases of the example, and refuse what is neither."""
    image = np.full((70, 90), 0.9)
    np.savez(folder / "own.npz", depth=image, intensity=image)
    with tab.expect_download() as example:
        tab.get_by_role("link", name="an example").click()
    example.value.save_as(folder / "own.csv")
    taken = tab.locator("#laboratory input[type=file]")
    for kind, width in (("npz", "88"), ("csv", "128")):
        (folder / f"other.{kind}").write_bytes(b"no data")
        taken.set_input_files(folder / f"other.{kind}")
        tab.locator("#laboratory .said", has_text="Expected").wait_for()
        taken.set_input_files(folder / f"own.{kind}")
        tab.locator("#laboratory option", has_text=f"own.{kind}").wait_for(
            state="attached"
        )
        assert tab.locator("#laboratory canvas").first.get_attribute("width") == width
        assert tab.locator("[name=sigma]").is_disabled() == (kind == "csv")
